//! Knots tied into open rods, their ends pinned or clamped, pulled apart; some are turned at one end then. Ends are
//! points, or grips that no loop slips over.

use std::f64::consts::{PI, TAU};

use supercoil::math::Vec3;

use super::Random;
use super::curve::{room, scaled};
use super::draft::{Draft, Mesh, list, short};
use super::material::Material;

const ONLY: &str = "\"rod\"";

/// 0 to 1 over t in 0..1, with level ends.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A tail along x, a loop of radius 1 and a tail; where both tails pass, they wind about each other by `crossings` half
/// turns at a distance of 2`h`: 3 make a trefoil, 5 a cinquefoil.
fn tied(h: f64, crossings: f64, tail: f64) -> Vec<Vec3> {
    let half = (0.5 * crossings + 0.25) * (2.0 * h).sqrt();
    let offset = |x: f64| {
        let angle = crossings * PI * smooth(0.5 + 0.5 * x / half);
        let fade = 1.0 - smooth((x.abs() - half) / (2.0 * half));
        Vec3::new(0.0, -angle.cos(), -angle.sin()) * (h * fade)
    };
    let step = 0.05 * half;
    let count = |length: f64| (length / step).ceil() as usize;
    let (ends, turn) = (count(tail + half), count(TAU));
    let fraction = |i: usize, n: usize| i as f64 / n as f64;
    let first = (0..ends).map(|i| -tail + (tail + half) * fraction(i, ends)).map(|x| Vec3::x() * x + offset(x));
    let around = (0..turn).map(|i| TAU * fraction(i, turn)).map(|a| {
        let base = Vec3::new(a.sin() + half * (0.5 * a).cos(), 1.0 - a.cos(), 0.0);
        base + if a < PI { offset(half + a) } else { -offset(a - TAU - half) }
    });
    let last = (0..=ends).map(|i| (tail + half) * fraction(i, ends) - half).map(|x| Vec3::x() * x - offset(x));
    first.chain(around).chain(last).collect()
}

/// Length that a knot of 3 or 5 crossings takes out of a rod when tight, over the diameter, and some more.
fn tight(crossings: f64) -> f64 {
    if crossings == 3.0 { 18.0 } else { 26.0 }
}

pub fn open_knots(draft: &mut Draft, random: &mut Random) {
    knots(draft, random, "");
}

pub fn gripped_knots(draft: &mut Draft, random: &mut Random) {
    knots(draft, random, "grip = \"endless\"");
}

fn knots(draft: &mut Draft, random: &mut Random, grip: &str) {
    let crossings = if random.chance(0.75) { 3.0 } else { 5.0 };
    // on shorter tails the loop grows until it slips over an end
    let mut points = scaled(&tied(random.between(0.06, 0.12), crossings, random.between(9.0, 14.0)), false, 1.0);
    if random.chance(0.5) {
        points.iter_mut().for_each(|p| p.z = -p.z);
    }
    let between = points[points.len() - 1] - points[0];
    let most = (0.9 * room(&points, false)).min(0.02);
    let radius = 0.5 * random.log_between(0.4 * most, most);
    let material =
        if random.chance(0.3) { Material::anisotropic(random, radius) } else { Material::isotropic(random, radius) };
    // nodes as far apart as the preset for a first look puts them do not resolve the tied curve
    let mesh = match Mesh::random(random) {
        Mesh::Fidelity(_) => Mesh::Fidelity("balanced"),
        spacing => spacing,
    };
    draft.mesh(mesh);
    let shape = draft.shape_through(&points);
    draft.rod("rod", (&shape, 1.0), &material, &[]);
    // turning about the line of the ends is held at least at one of them
    let (start, end) = match random.below(4) {
        0 => ("[\"x\"]", "[\"x\"]"),
        1 => ("true", "true"),
        2 => ("true", "[\"x\"]"),
        _ => ("[\"x\"]", "false"),
    };
    draft.support(ONLY, "\"start\"", "true", start);
    draft.line(grip);
    draft.support(ONLY, "\"end\"", "true", end);
    draft.line(grip);
    let slack = 1.0 - between.norm() - tight(crossings) * material.diameter();
    let by = between.normalize() * (slack.max(0.0) * random.between(0.2, 0.95));
    draft.stage(&format!("displacement = {{ at = \"end\", to = {} }}", list(&by)), 4 + random.below(20) as usize);
    if end == "true" {
        let turns = short(random.between(-2.0, 2.0));
        let ramp = format!("rotation = {{ at = \"end\", axis = [1, 0, 0], turns = {turns:?} }}");
        draft.stage(&ramp, 4 + random.below(12) as usize);
    }
}
