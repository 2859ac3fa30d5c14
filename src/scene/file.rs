//! Scene files: a problem, its stages and its outputs as TOML text. See [`Scene`] for the format.
//!
//! In three rooms: `syntax` is what a file may say, `build` makes the problem of it, `help` speaks to its author.

mod build;
mod help;
mod syntax;

use std::path::{Path, PathBuf};

use crate::dna;
use crate::dna::base_pairs::AtRest;
use crate::error::InputError;

use super::model::{Model, Stage};
use super::{Fidelity, Units};
use crate::text::read_regular;

use help::advice;
use help::words::in_a_users_words;
use syntax::{SceneText, StagesText, set};

#[cfg(feature = "runs")]
pub(crate) use help::reference::schema_for_editors;
pub use help::{Key, TEMPLATES, Template, help, keys, reference};
#[cfg(feature = "sweeps")]
pub(crate) use syntax::canonical::Canonical;
pub use syntax::choices::{
    ColorBy, FollowChoice, FollowStart, MOST_THREADS, OutputChoice, PictureChoice, SolverChoice,
};
#[cfg(feature = "sweeps")]
pub(crate) use syntax::set::value_of;

/// A scene: problem, stages, outputs.
///
/// ```toml
/// title = "336 bp minicircle, excess link to -3"
/// units = { length = "nm", force = "pN" }
///
/// [[rods]]
/// name = "dna"
/// closed = true
/// shape = { kind = "circle", length = 114.24 }
/// section = { bending = 205.7, twisting = 308.6, stretching = 1100.0, shearing = 1100.0, contact_radius = 2.5 }
/// elements = 48
///
/// [[stages]]
/// ramp = { excess_link = { rod = "dna", to = -3.0 } }
/// steps = 30
/// ```
///
/// [`TEMPLATES`] are scenes to begin with (`supercoil new`); [`help`] gives the entry of a single key (`supercoil help
/// scene KEY`).
///
#[doc = include_str!("reference.md")]
///
/// An unknown key is refused with its line, the keys that are allowed there and the most similar one; an illegal value
/// with its key, the value and the legal range; a mesh that needs more memory than available (on Linux). All angles are
/// in turns. Scenes are checked when they are read. Scenes and what they name come from regular
/// files of at most 256 MiB: `resume` reads them again.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Title, for reports; may be empty.
    pub title: String,
    /// Names of the units, for reports.
    pub units: Units,
    /// Temperature for energies in kT, K; `None` if the file has none.
    pub temperature: Option<f64>,
    /// Mass per length of each rod that has one \[mass/L\].
    pub line_densities: Vec<Option<f64>>,
    /// Link of the relaxed molecule, turns, for each rod that is DNA.
    pub relaxed_links: Vec<Option<f64>>,
    /// Base pairs of each rod that is DNA.
    pub num_base_pairs: Vec<Option<usize>>,
    /// Base pairs at rest, for each rod that has a sequence.
    pub base_pairs: Vec<Option<AtRest>>,
    /// Preset for settings that the file does not give.
    pub fidelity: Option<Fidelity>,
    /// The problem.
    pub model: Model,
    /// The stages.
    pub stages: Vec<Stage>,
    /// Path following of the last stage, if it is followed.
    pub follow: Option<FollowChoice>,
    /// Solver settings that differ from the defaults.
    pub solver: SolverChoice,
    /// Outputs.
    pub output: OutputChoice,
    /// Settings of pictures.
    pub picture: PictureChoice,
    /// Absolute path of the scene file; `None` for a scene from text.
    pub path: Option<PathBuf>,
    /// Text of the scene before values were replaced; empty if there was none.
    pub text: String,
    /// Values that were replaced, as `KEY=VALUE`, see [`Scene::read_with`].
    pub set: Vec<String>,
    /// Choices that the file leaves open and whose outcome a user may not expect, in words.
    pub notices: Vec<String>,
}

impl Scene {
    /// Base pairs of a rod that is DNA, and how many of them the relaxed molecule has a turn.
    #[must_use]
    pub fn double_helix(&self, rod: usize) -> Option<(usize, f64)> {
        let count = self.num_base_pairs.get(rod).copied().flatten()?;
        let relaxed = self.relaxed_links.get(rod).copied().flatten()?;
        Some((count, count as f64 / relaxed))
    }

    /// Mass per length of each rod \[mass/L\]; `None` unless all have one.
    pub fn masses(&self) -> Option<Vec<f64>> {
        self.line_densities.iter().copied().collect::<Option<Vec<f64>>>().filter(|all| !all.is_empty())
    }

    /// Temperature, K, and its thermal energy kT, pN·nm: that of the constants of DNA ([`dna::TEMPERATURE`]) unless the
    /// scene has another; `None` if units are not nm and pN.
    ///
    /// [`dna::TEMPERATURE`]: crate::dna::TEMPERATURE
    pub fn thermal(&self) -> Option<(f64, f64)> {
        let of_constants = (dna::TEMPERATURE, dna::THERMAL_ENERGY);
        let other = self.temperature.filter(|kelvin| *kelvin != dna::TEMPERATURE);
        let thermal = other.map_or(of_constants, |kelvin| (kelvin, kelvin * dna::BOLTZMANN));
        self.units.are_molecular().then_some(thermal)
    }

    /// Reads a scene file; files named in it are found relative to it.
    ///
    /// # Errors
    /// A file that cannot be read, and all of [`Scene::from_toml`].
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::read_with(path, &[])
    }

    /// Reads a scene file and replaces some of its values, each given as `KEY=VALUE`: `solver.threads=2`,
    /// `rods.dna.elements=96` (by name) or `stages.0.steps=10` (by index from 0). Values are TOML; anything else counts
    /// as a string. Missing keys are added.
    ///
    /// # Errors
    /// As [`Scene::read`]; [`InputError::Inconsistent`] for a key that does not exist.
    pub fn read_with(path: &Path, set: &[String]) -> Result<Self, InputError> {
        let text = read_regular(path)?;
        let scene = Self::parse(&text, set, &path.display().to_string(), path.parent().unwrap_or(Path::new("")))?;
        Ok(Self { path: std::path::absolute(path).ok(), text, set: set.to_vec(), ..scene })
    }

    /// Reads a scene from text; files named in it are found relative to `base_dir`.
    ///
    /// # Errors
    /// [`InputError::Parse`] with line and column for text that is not TOML, unknown or missing keys, values of the
    /// wrong type; all errors of [`Model::check`] and [`Model::check_stages`].
    pub fn from_toml(text: &str, base_dir: &Path) -> Result<Self, InputError> {
        Self::from_toml_with(text, &[], base_dir)
    }

    /// Reads a scene from text and replaces some of its values as [`Scene::read_with`] does.
    ///
    /// # Errors
    /// As [`Scene::from_toml`] and [`Scene::read_with`].
    pub fn from_toml_with(text: &str, set: &[String], base_dir: &Path) -> Result<Self, InputError> {
        let scene = Self::parse(text, set, "scene", base_dir)?;
        Ok(Self { text: text.to_owned(), set: set.to_vec(), ..scene })
    }

    /// Reads further stages for this scene's model from text: `[[stages]]` as in a scene file, nothing else.
    ///
    /// # Errors
    /// As [`Scene::from_toml`].
    pub fn stages_from_toml(&self, text: &str) -> Result<Vec<Stage>, InputError> {
        let refuse =
            |e: toml::de::Error| InputError::Parse { file: "stages".to_owned(), reason: in_a_users_words(&e, text) };
        let text: StagesText = toml::from_str(text).map_err(refuse)?;
        build::stages::stages(&text.stages, &self.model, &self.relaxed_links)
    }

    fn parse(text: &str, set: &[String], file: &str, base_dir: &Path) -> Result<Self, InputError> {
        let refuse =
            |e: toml::de::Error| InputError::Parse { file: file.to_owned(), reason: in_a_users_words(&e, text) };
        // parsed also if values are replaced, because only here do errors have lines
        let mut read: SceneText = toml::from_str(text).map_err(refuse)?;
        if !set.is_empty() {
            let mut table: toml::Table = toml::from_str(text).map_err(refuse)?;
            set.iter().try_for_each(|assignment| set::apply(&mut table, assignment))?;
            read = table.try_into().map_err(refuse)?;
        }
        let text = read.checked()?;
        let scene = build::scene(&text, base_dir)?;
        Ok(Self { notices: advice::notices(&text, &scene), ..scene })
    }
}
