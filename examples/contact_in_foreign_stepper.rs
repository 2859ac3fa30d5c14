//! Contact forces inside somebody else's explicit time stepper: two elastic chains thrown at each other bounce, and
//! momentum is kept. Unit mass per bead, unit rest length; springs along each chain; symplectic Euler.
#![allow(clippy::print_stdout)] // an example talks to its reader

use supercoil::InputError;
use supercoil::contact::{Curve, Detector, DetectorOptions};
use supercoil::math::Vec3;

const BEADS: usize = 21;
const RADIUS: f64 = 0.3;

/// Numbers of the run.
#[derive(Debug)]
pub struct Summary {
    /// Smallest gap seen, in radii.
    pub deepest: f64,
    /// Vertical velocity of the upper chain, before and after.
    pub velocity: [f64; 2],
    /// Change of the total momentum.
    pub momentum_error: f64,
}

/// Forces of the springs between successive beads of a chain: the caller's own physics.
fn springs(x: &[Vec3]) -> Vec<Vec3> {
    let pull = |a: Vec3, b: Vec3| (b - a) * (200.0 * ((b - a).norm() - 1.0) / (b - a).norm());
    let next = |k: usize| x.get(k + 1).map_or_else(Vec3::zeros, |b| pull(x[k], *b));
    (0..x.len()).map(|k| next(k) - if k > 0 { next(k - 1) } else { Vec3::zeros() }).collect()
}

/// Two crossed chains, the upper one falling on the lower one.
pub fn run() -> Result<Summary, InputError> {
    let at = |k: usize| k as f64 - (BEADS - 1) as f64 / 2.0;
    let mut x: Vec<Vec3> = (0..BEADS).map(|k| Vec3::new(at(k), 0.0, 0.0)).collect();
    x.extend((0..BEADS).map(|k| Vec3::new(0.1, at(k) + 0.2, 0.8)));
    let mut v = vec![Vec3::zeros(); 2 * BEADS];
    v[BEADS..].fill(-Vec3::z());
    let (before, dt, mut deepest) = (v.iter().sum::<Vec3>(), 0.005, f64::INFINITY);
    // keeps its lists between steps
    let mut detector =
        Detector::new(DetectorOptions { range: 0.0, margin: 0.2, zones: false, ..DetectorOptions::default() });
    for _ in 0..600 {
        let (lower, upper) = x.split_at(BEADS);
        let contact = detector.forces(&[Curve::polyline(lower, RADIUS), Curve::polyline(upper, RADIUS)], 400.0)?;
        let pull = [springs(lower), springs(upper)].concat();
        deepest = deepest.min(contact.min_gap / RADIUS);
        for (k, push) in contact.forces.iter().flatten().enumerate() {
            v[k] += (pull[k] + push) * dt;
            x[k] += v[k] * dt;
        }
    }
    let after = v[BEADS..].iter().map(|v| v.z).sum::<f64>() / BEADS as f64;
    let momentum_error = (v.iter().sum::<Vec3>() - before).norm();
    Ok(Summary { deepest, velocity: [-1.0, after], momentum_error })
}

fn main() -> Result<(), InputError> {
    let Summary { deepest, velocity: [before, after], momentum_error } = run()?;
    println!("deepest gap {deepest:.3} radii; velocity {before:.3} -> {after:.3}; momentum error {momentum_error:.1e}");
    Ok(())
}
