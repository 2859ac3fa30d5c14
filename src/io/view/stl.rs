//! The last frame of a film as STL, for printers and mesh programs.

use std::path::Path;

use super::mesh::solid;
use super::{Film, FrameRod};
use crate::error::InputError;
use crate::math::Vec3;

/// Sides of a tube: 15° each, an outline within 1 % of the radius.
const SIDES: usize = 24;
/// Bytes of the free text before the number of triangles.
const HEADER: usize = 80;

impl Film {
    /// The tubes of the last frame as binary STL: one closed surface per rod, in the film's own length unit and
    /// position. Tubes in contact are not merged; planes are not among them.
    ///
    /// # Errors
    /// [`InputError`] naming the field if the film has no frame, a count, radius or number cannot be used, or there are
    /// more triangles than the format can count.
    pub fn stl(&self) -> Result<Vec<u8>, InputError> {
        self.check()?;
        let Some(frame) = self.frames.last() else {
            return Err(InputError::inconsistent("frames", "there is none: nothing to write as STL"));
        };
        let drawn = frame.rods.iter().enumerate().filter(|(_, rod)| rod.points.len() > 1);
        let triangles: Vec<[Vec3; 3]> = drawn
            .flat_map(|(index, rod)| {
                solid(&rod.nodes(self.rods[index].closed, |_| Vec3::zeros()), &self.style(index, rod))
            })
            .collect();
        let count = u32::try_from(triangles.len()).map_err(|_| {
            let reason = format!("{} triangles: STL counts at most {}", triangles.len(), u32::MAX);
            InputError::Inconsistent { field: "stl".to_owned(), reason }
        })?;
        let mut header =
            format!("supercoil {}, 1 unit = 1 {}", env!("CARGO_PKG_VERSION"), self.units.length).into_bytes();
        header.resize(HEADER, b' ');
        let mut bytes = header;
        bytes.extend(count.to_le_bytes());
        triangles.iter().for_each(|corners| bytes.extend(record(corners)));
        Ok(bytes)
    }

    /// Writes [`Film::stl`] to a file, replacing what is there.
    ///
    /// # Errors
    /// As there; [`InputError::Write`] if the file cannot be written.
    pub fn save_stl(&self, path: &Path) -> Result<(), InputError> {
        let refuse = |e: std::io::Error| InputError::Write { path: path.to_owned(), reason: e.to_string() };
        std::fs::write(path, self.stl()?).map_err(refuse)
    }

    fn style(&self, index: usize, rod: &FrameRod) -> super::mesh::MeshStyle {
        let (closed, stripe) = (self.rods[index].closed, Vec3::zeros());
        super::mesh::MeshStyle { closed, seam_turns: rod.seam_turns, sides: SIDES, stripe }
    }
}

/// A triangle: its unit normal, its corners, two unused bytes.
fn record(corners: &[Vec3; 3]) -> Vec<u8> {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a)).normalize();
    let numbers = [normal, *a, *b, *c];
    let mut bytes: Vec<u8> =
        numbers.iter().flat_map(|v| [v.x, v.y, v.z]).flat_map(|x| (x as f32).to_le_bytes()).collect();
    bytes.extend([0, 0]);
    bytes
}
