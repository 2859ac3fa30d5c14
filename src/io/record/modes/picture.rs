//! `modes.png`: each mode at the end of a swing, before the state at rest.

use std::path::PathBuf;

use crate::error::InputError;
use crate::io::picture::{Tube, TubePicture, film_strip};
use crate::io::record::files;
use crate::io::record::pictures::camera::{axes, of_strip, region_of};
use crate::io::record::pictures::still::{Still, StillRod};
use crate::io::record::rods::RodHead;
use crate::io::record::run::RecordedRun;
use crate::math::Vec3;

const SWUNG: [u8; 3] = [62, 112, 178];
const AT_REST: [u8; 3] = [200, 200, 200];

/// Writes a picture of each mode: the nodes of the rods at rest, grey, and at the end of a swing, with its caption.
pub(super) fn write(
    run: &RecordedRun,
    rest: &[Vec<Vec3>],
    ends: &[(Vec<Vec<Vec3>>, String)],
) -> Result<PathBuf, InputError> {
    let still = |rods: &[Vec<Vec3>]| {
        let rod = |points: &Vec<Vec3>| {
            let (radii, directions, values) = (Vec::new(), Vec::new(), Vec::new());
            StillRod { points: points.clone(), radii, directions, values }
        };
        Still { step: 0, rods: rods.iter().map(rod).collect(), spots: Vec::new() }
    };
    let all: Vec<Still> = ends.iter().map(|(rods, _)| still(rods)).chain([still(rest)]).collect();
    let axes = axes(run, &all.iter().collect::<Vec<_>>());
    let radius = run.rods.iter().map(RodHead::radius).fold(0.0, f64::max);
    let points = all.iter().flat_map(|still| &still.rods).flat_map(|rod| &rod.points);
    let empty = of_strip(region_of(points, radius, &axes), &axes);
    let tubes = |rods: &[Vec<Vec3>], color: [u8; 3]| -> Vec<Tube> {
        let tube = |(points, head): (&Vec<Vec3>, &RodHead)| {
            let (points, radii, closed) = (points.clone(), vec![head.radius()], head.closed);
            Tube { points, radii, closed, colors: vec![color], stripe: None }
        };
        rods.iter().zip(&run.rods).map(tube).collect()
    };
    let mut stills = Vec::new();
    for (rods, caption) in ends {
        let tubes = [tubes(rest, AT_REST), tubes(rods, SWUNG)].concat();
        stills.push((TubePicture { tubes, ..empty.clone() }.render()?, caption.clone()));
    }
    let path = run.dir.join(files::MODES_PICTURE);
    film_strip(&stills, 3, [255; 3])?.save_png(&path)?;
    Ok(path)
}
