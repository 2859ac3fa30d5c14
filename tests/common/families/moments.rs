//! Rods under dead moments and forces, in a plane, where moments have a potential.

use std::f64::consts::TAU;

use supercoil::math::Vec3;

use super::Random;
use super::draft::{Draft, Mesh, list, short};
use super::material::Material;

const ROD: &str = "\"rod\"";

/// A cantilever that a moment at its tip, with or without a force, rolls up onto itself or bends onto a beam beside it;
/// or one whose tip is held in its place, under a moment anywhere.
pub fn moments(draft: &mut Draft, random: &mut Random) {
    let radius = random.log_between(0.003, 0.02);
    let material = Material::isotropic(random, radius);
    draft.line("planar = true");
    draft.mesh(Mesh::random(random));
    let line = |start: &Vec3, length: f64| {
        format!("kind = \"line\", start = {}, direction = [1.0, 0.0, 0.0], length = {length:?}", list(start))
    };
    draft.rod("rod", (&line(&Vec3::zeros(), 1.0), 1.0), &material, &[]);
    let has_beam = random.chance(0.4);
    if has_beam {
        let away = random.sign() * random.between(0.05, 0.3);
        let start = Vec3::new(short(random.between(0.1, 0.6)), short(away), 0.0);
        let beam = Material { bending: [random.log_between(0.3, 3.0); 2], ..material };
        draft.rod("beam", (&line(&start, 0.8), 0.8), &beam, &[]);
        draft.clamp("\"beam\"", "\"start\"");
        draft.clamp("\"beam\"", "\"end\"");
    }
    draft.clamp(ROD, "\"start\"");
    let is_held = random.chance(0.25);
    let at = if is_held {
        draft.support(ROD, "\"end\"", "true", "false");
        format!("{{ arc = {:?} }}", short(random.between(0.2, 1.0)))
    } else {
        "\"end\"".to_owned()
    };
    // a moment of 2π rolls a cantilever up to a circle
    let moment = random.sign() * TAU * random.between(0.6, 2.5);
    let force = if random.chance(0.5) { random.direction() * random.between(0.0, 6.0) } else { Vec3::zeros() };
    let force = Vec3::new(force.x, force.y, 0.0);
    draft.load(ROD, &at, &force);
    draft.line(&format!("moment = [0.0, 0.0, {:?}]", short(moment)));
    draft.stage("load = 1.0", 2 + random.below(20) as usize);
}
