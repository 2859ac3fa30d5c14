//! Contact forces inside somebody else's explicit time stepper: two elastic chains thrown at each other bounce, and
//! momentum is kept.
//!
//! Unit mass per bead, unit rest length, radius 0.3; springs along each chain; symplectic Euler. The detector keeps its
//! lists between steps.

#![allow(clippy::print_stdout)]

use supercoil::InputError;
use supercoil::contact::{Curve, Detector, Options};
use supercoil::math::Vec3;

const BEADS: usize = 21;
const RADIUS: f64 = 0.3;

/// What the run is about.
#[derive(Debug)]
pub struct Summary {
    /// Smallest gap seen, in radii.
    pub deepest: f64,
    /// Vertical velocity of the upper chain before and after.
    pub velocity: [f64; 2],
    /// Change of the total momentum.
    pub momentum_error: f64,
}

/// Springs between successive beads of one chain: the caller's own physics.
fn springs(x: &[Vec3], force: &mut [Vec3]) {
    for k in 1..x.len() {
        let d = x[k] - x[k - 1];
        let pull = d * (200.0 * (d.norm() - 1.0) / d.norm());
        force[k - 1] += pull;
        force[k] -= pull;
    }
}

/// Two crossed chains, the upper one falling on the lower one.
pub fn run() -> Result<Summary, InputError> {
    let at = |k: usize| k as f64 - (BEADS - 1) as f64 / 2.0;
    let mut x: Vec<Vec3> = (0..BEADS).map(|k| Vec3::new(at(k), 0.0, 0.0)).collect();
    x.extend((0..BEADS).map(|k| Vec3::new(0.1, at(k) + 0.2, 0.8)));
    let mut v = vec![Vec3::zeros(); 2 * BEADS];
    v[BEADS..].fill(-Vec3::z());
    let (before, dt) = (v.iter().sum::<Vec3>(), 0.005);
    let mut detector = Detector::new(Options { range: 0.0, margin: 0.2, zones: false, ..Options::default() });
    let mut deepest = f64::INFINITY;
    for _ in 0..600 {
        let mut force = vec![Vec3::zeros(); 2 * BEADS];
        let (lower, upper) = x.split_at(BEADS);
        springs(lower, &mut force[..BEADS]);
        springs(upper, &mut force[BEADS..]);
        let curves = [Curve::polyline(lower, RADIUS), Curve::polyline(upper, RADIUS)];
        let contact = detector.forces(&curves, 400.0)?;
        for (force, push) in force.iter_mut().zip(contact.forces.iter().flatten()) {
            *force += push;
        }
        deepest = deepest.min(contact.min_gap / RADIUS);
        for k in 0..x.len() {
            v[k] += force[k] * dt;
            x[k] += v[k] * dt;
        }
    }
    let after = v[BEADS..].iter().map(|v| v.z).sum::<f64>() / BEADS as f64;
    let momentum_error = (v.iter().sum::<Vec3>() - before).norm();
    Ok(Summary { deepest, velocity: [-1.0, after], momentum_error })
}

fn main() -> Result<(), InputError> {
    let s = run()?;
    println!(
        "deepest overlap {:.3} radii; velocity {:.3} -> {:.3}; momentum error {:.1e}",
        -s.deepest, s.velocity[0], s.velocity[1], s.momentum_error
    );
    Ok(())
}
