//! Closed rods: rings and torus knots that are supercoiled.

use std::f64::consts::TAU;

use supercoil::math::Vec3;
use supercoil::math::link::writhe;

use super::Random;
use super::curve::{room, scaled};
use super::draft::{Draft, Mesh, short};
use super::material::Material;

/// Excess link × D/L at most: DNA at the supercoiling density .1, D = 5 nm, 3.57 nm a turn.
const MOST_LINK: f64 = 0.1 * 5.0 / 3.57;

fn excess_link(to: f64) -> String {
    format!("excess_link = {{ to = {:?} }}", short(to))
}

/// A circle, or a closed curve that wanders out of its plane.
fn ring_shape(draft: &mut Draft, random: &mut Random) -> String {
    if random.chance(0.6) {
        return "kind = \"circle\", length = 1.0".to_owned();
    }
    let waves: Vec<[f64; 5]> = (2..5)
        .map(|k| {
            let mut some = |most: f64| random.between(0.0, most / f64::from(k));
            [f64::from(k), some(0.02), some(0.1), some(TAU), some(TAU)]
        })
        .collect();
    let point = |i: i32| {
        let t = TAU * f64::from(i) / 120.0;
        let out = waves.iter().map(|w| w[1] * (w[0] * t + w[3] * w[0]).sin()).sum::<f64>();
        let up = waves.iter().map(|w| w[2] * (w[0] * t + w[4] * w[0]).sin()).sum::<f64>();
        Vec3::new((0.16 + out) * t.cos(), (0.16 + out) * t.sin(), up)
    };
    let points: Vec<Vec3> = (0..120).map(point).collect();
    draft.shape_through(&scaled(&points, true, 1.0))
}

fn ring(draft: &mut Draft, random: &mut Random, steps: usize) {
    let radius = 0.5 * random.log_between(0.008, 0.04);
    let material = Material::isotropic(random, radius);
    draft.mesh(Mesh::random(random));
    let shape = ring_shape(draft, random);
    draft.rod("ring", (&shape, 1.0), &material, &["closed = true", "excess_link = 0.0"]);
    let link = random.between(-1.0, 1.0) * MOST_LINK / material.diameter();
    draft.stage(&excess_link(link), steps);
}

/// All of its link at once.
pub fn rings_at_once(draft: &mut Draft, random: &mut Random) {
    ring(draft, random, 1);
}

/// Its link in forty steps.
pub fn rings_in_steps(draft: &mut Draft, random: &mut Random) {
    ring(draft, random, 40);
}

/// Rings with unlike bending stiffnesses: straight by nature, curved by nature, or with a helix in their section.
pub fn anisotropic(draft: &mut Draft, random: &mut Random) {
    let radius = 0.5 * random.log_between(0.008, 0.04);
    let material = Material::anisotropic(random, radius);
    let mesh = Mesh::random(random);
    let link = random.between(-0.5, 0.5) * MOST_LINK / material.diameter();
    let steps = 1 + random.below(30) as usize;
    let roll = format!("roll = {:?}", short(random.between(0.0, 0.5)));
    let shape = "kind = \"circle\", length = 1.0";
    match random.below(4) {
        0 => {
            // whole turns of the section about the ring, ten nodes each
            let turns = 2.0 + random.below(20) as f64;
            let natural = format!("natural = {{ twist = {:?} }}", TAU * turns);
            let elements = format!("elements = {}", (3.4 * turns).ceil().max(48.0));
            draft.mesh(Mesh::Spacing(0.5));
            let from = "excess_link = 0.0";
            draft.rod("ring", (shape, 1.0), &material, &["closed = true", &natural, from, &elements]);
            draft.stage(&excess_link(link.clamp(-0.2 * turns, 0.2 * turns)), steps);
        }
        1 => {
            draft.mesh(mesh);
            draft.rod("ring", (shape, 1.0), &material, &["closed = true", "natural = \"as-shaped\"", &roll]);
            draft.stage(&excess_link(link), steps);
        }
        _ => {
            draft.mesh(mesh);
            draft.rod("ring", (shape, 1.0), &material, &["closed = true", &roll]);
            draft.stage(&excess_link(link), steps);
        }
    }
}

/// Windings of the torus knots tried, and length over diameter of the tightest one.
const KNOTS: [([i32; 2], f64); 5] = [([2, 3], 16.4), ([2, 5], 23.6), ([2, 7], 30.7), ([3, 4], 30.5), ([3, 5], 35.7)];

/// Torus knots and their mirror images of any thickness that fits, with link put in or taken out.
pub fn torus_knots(draft: &mut Draft, random: &mut Random) {
    let ([p, q], tightest) = KNOTS[random.below(KNOTS.len() as u64) as usize];
    let mirror = random.sign();
    let aspect = short(random.between(0.35, 0.6));
    let points: Vec<Vec3> = (0..400)
        .map(|i| {
            let t = TAU * f64::from(i) / 400.0;
            let beta = f64::from(q) * mirror * t;
            let out = 1.0 + aspect * beta.cos();
            let turn = f64::from(p) * t;
            Vec3::new(out * turn.cos(), out * turn.sin(), -aspect * beta.sin())
        })
        .collect();
    let points = scaled(&points, true, 1.0);
    let most = (0.9 * room(&points, true)).min(0.8 / tightest);
    let radius = 0.5 * random.log_between(0.008, most);
    let material = Material::isotropic(random, radius);
    let link = random.between(-0.3, 0.3) * MOST_LINK / material.diameter();
    draft.mesh(Mesh::random(random));
    let shape = format!(
        "kind = \"torus_knot\", length = 1.0, windings = [{p}, {}], aspect = {aspect:?}",
        f64::from(q) * mirror
    );
    draft.rod("knot", (&shape, 1.0), &material, &["closed = true"]);
    let steps = 1 + random.below(20) as usize;
    // without a link of its own a rod starts without twist
    draft.stage(&excess_link(writhe(&points, true) + link), steps);
}
