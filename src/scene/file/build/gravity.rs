//! Masses of rods, and their weight by one line for all: gravity times the mass of each.

use std::f64::consts::PI;

use crate::error::InputError;
use crate::math::Vec3;
use crate::scene::file::syntax::{RampText, RodText, SceneText};

const ONE_WAY: &str = "density, mass and weight say one thing: give one of them";

/// Weight of a rod of that length as a force per length \[F/L\], if it has one.
pub(super) fn weight(scene: &SceneText, rod: &RodText, length: f64) -> Result<Option<Vec3>, InputError> {
    let Some(mass) = line_density(scene, rod, length)? else { return Ok(None) };
    Ok(scene.gravity.map(|gravity| Vec3::from(gravity) * mass))
}

/// Mass per length of a rod of that length, if it has one \[mass/L\].
pub(super) fn line_density(scene: &SceneText, rod: &RodText, length: f64) -> Result<Option<f64>, InputError> {
    let path = format!("rods.{}", rod.name);
    let given = [("density", rod.density), ("mass", rod.mass), ("weight", rod.weight)];
    let mut given = given.iter().filter_map(|(key, value)| value.map(|value| (*key, value)));
    let Some((key, value)) = given.next() else { return Ok(None) };
    if given.next().is_some() {
        return Err(InputError::inconsistent(path, ONE_WAY));
    }
    InputError::positive(&format!("{path}.{key}"), value)?;
    let gravity = scene.gravity.map(|gravity| Vec3::from(gravity).norm());
    let vibrates = scene.output.modes > 0 && key != "weight";
    if gravity.is_none() && !vibrates {
        let reason = "has no meaning without gravity: give the scene gravity = [x, y, z]";
        return Err(InputError::inconsistent(format!("{path}.{key}"), reason));
    }
    Ok(Some(match key {
        "mass" => value / length,
        "weight" => value / gravity.unwrap_or(1.0),
        _ => value * area(&path, rod)?,
    }))
}

/// Area of a section that is given by its sides \[L²\].
fn area(path: &str, rod: &RodText) -> Result<f64, InputError> {
    let section = rod.section.as_ref();
    match section.map(|section| (section.circle, section.rectangle)) {
        Some((Some(radius), None)) => Ok(PI * radius * radius),
        Some((None, Some(sides))) => Ok(sides.0[0] * sides.0[1]),
        _ => {
            let reason = "needs a section with circle or rectangle, which give its area: give mass or weight instead";
            Err(InputError::inconsistent(format!("{path}.density"), reason))
        }
    }
}

/// Refuses a gravity that is none, or that pulls at nothing.
pub(super) fn check(scene: &SceneText) -> Result<(), InputError> {
    let Some(gravity) = scene.gravity.map(Vec3::from) else { return Ok(()) };
    let ok = gravity.iter().all(|x| x.is_finite()) && gravity != Vec3::zeros() && !(scene.planar && gravity.z != 0.0);
    if !ok {
        let allowed =
            if scene.planar { "in the x-y plane of a planar scene, and not zero" } else { "finite and not zero" };
        return Err(InputError::Vector { field: "gravity".to_owned(), value: gravity.into(), allowed });
    }
    let is_heavy = |rod: &RodText| rod.density.or(rod.mass).or(rod.weight).is_some();
    if scene.rods.iter().any(is_heavy) {
        return Ok(());
    }
    Err(InputError::inconsistent("gravity", "pulls at nothing: give rods a density, a mass or a weight"))
}

/// Load factor at the start: loads that no stage ramps act from the start.
pub(super) fn start_factor(scene: &SceneText) -> f64 {
    let mut ramps = scene.stages.iter().map(|stage| &stage.ramp);
    let ramped = ramps.any(|ramp: &RampText| ramp.load.is_some());
    scene.load.unwrap_or(if ramped { 0.0 } else { 1.0 })
}
