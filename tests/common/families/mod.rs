//! Families of random scenes: what people do with rods, with random numbers in it.
//!
//! A case is the text of a scene file, with a file of points where its rod starts as a curve. It depends on its family
//! and its index only, so that a case that fails can be written down and run by itself:
//!
//! ```text
//! cargo bench --bench families -- --write tweezers 7
//! ```
//!
//! Every case is possible: strands start apart, thickness and stiffnesses are those of real rods, ends are never
//! farther apart than a rod is long, and no more turns are asked for than a rod of its thickness has room for. Nothing
//! else is held against a case: not that it snaps, nor that it is far from its start.

#![allow(dead_code)] // the bench and the test use their parts
#![allow(clippy::unwrap_used, clippy::expect_used)] // helpers of tests

mod closed;
mod confined;
mod curve;
mod draft;
mod falling;
mod hanging;
mod joined;
mod material;
mod moments;
mod open;
mod open_knots;
mod several;

use std::path::{Path, PathBuf};

use super::random::Random;
use draft::Draft;
use supercoil::InputError;
use supercoil::scene::Scene;

/// Cases in a family.
pub const CASES: u64 = 50;

/// A kind of scene.
pub struct Family {
    /// Its name on the command line and in tables.
    pub name: &'static str,
    /// Writes a random scene of this kind.
    make: fn(&mut Draft, &mut Random),
}

/// All families.
pub const FAMILIES: [Family; 21] = [
    Family { name: "clamped", make: open::clamped },
    Family { name: "paths", make: open::paths },
    Family { name: "tweezers", make: open::tweezers },
    Family { name: "sliding", make: open::sliding },
    Family { name: "anisotropic_open", make: open::anisotropic },
    Family { name: "curls", make: open::curls },
    Family { name: "open_knots", make: open_knots::open_knots },
    Family { name: "rings_at_once", make: closed::rings_at_once },
    Family { name: "rings_in_steps", make: closed::rings_in_steps },
    Family { name: "anisotropic_rings", make: closed::anisotropic },
    Family { name: "torus_knots", make: closed::torus_knots },
    Family { name: "linked_rings", make: several::linked_rings },
    Family { name: "cables", make: several::cables },
    Family { name: "beams", make: several::beams },
    Family { name: "moments", make: moments::moments },
    Family { name: "falling", make: falling::falling },
    Family { name: "hanging", make: hanging::hanging },
    Family { name: "along_axes", make: hanging::along_axes },
    Family { name: "obstacles", make: confined::obstacles },
    Family { name: "gripped_knots", make: open_knots::gripped_knots },
    Family { name: "joined", make: joined::joined },
];

/// One scene of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Name of the family and index in it, as in `tweezers_007`.
    pub name: String,
    /// The scene file.
    pub text: String,
    /// Files of points that it names, each with its text.
    pub points: Vec<(String, String)>,
}

impl Family {
    /// The family of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        FAMILIES.iter().find(|family| family.name == name)
    }

    /// The case of this index, always the same.
    pub fn case(&self, index: u64) -> Case {
        let family = FAMILIES.iter().position(|other| other.name == self.name).expect("a family of the list");
        let name = format!("{}_{index:03}", self.name);
        let mut draft = Draft::new(&name);
        (self.make)(&mut draft, &mut Random::of(family as u64, index));
        let (text, points) = draft.finish();
        Case { name, text, points }
    }
}

impl Case {
    /// Writes the scene file and its points to a folder; the path of the scene file.
    pub fn write(&self, dir: &Path) -> std::io::Result<PathBuf> {
        std::fs::create_dir_all(dir)?;
        for (file, text) in &self.points {
            std::fs::write(dir.join(file), text)?;
        }
        let path = dir.join(format!("{}.toml", self.name));
        std::fs::write(&path, &self.text)?;
        Ok(path)
    }

    /// The scene, read back from the files that [`Case::write`] leaves in a folder.
    pub fn scene(&self, dir: &Path) -> Result<Scene, InputError> {
        let refuse = |e: std::io::Error| InputError::File { path: dir.to_owned(), reason: e.to_string() };
        Scene::read(&self.write(dir).map_err(refuse)?)
    }
}
