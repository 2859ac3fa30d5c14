//! A closed plectoneme of any length.

#![allow(dead_code)] // not every test needs all of it

use std::f64::consts::{FRAC_PI_2, TAU};
use supercoil::math::Vec3;

/// Axial length of one turn of the superhelix.
const PITCH: f64 = 9.0;
/// Axial length of the round ends, and how much wider than the superhelix the end loops are, over which length.
const CAP: f64 = 4.0;
const LOOP: [f64; 2] = [3.0, 6.0];

/// `n` points about half a radius apart, of two strands of radius 1 wound about the x axis and joined by round end
/// loops whose curvature stays below 0.7. The superhelix radius swings about `radius` by `swing` over every third turn:
/// with radius 1 and a small swing the strands touch at many places.
pub fn plectoneme(n: usize, radius: f64, swing: f64) -> Vec<Vec3> {
    let turns = (n / 44).max(3) as f64;
    let half = 0.5 * turns * PITCH;
    // along a strand from the middle to a tip; in the caps by the angle, so that points do not thin out where the
    // strand turns round
    let quarter = half - CAP + CAP * FRAC_PI_2;
    let at = |i: usize| {
        let s = 4.0 * i as f64 / n as f64;
        let (side, along) = if s < 2.0 { (1.0, s - 1.0) } else { (-1.0, 3.0 - s) };
        let from_tip = quarter * (1.0 - along.abs());
        let (to_tip, share) = match from_tip < CAP * FRAC_PI_2 {
            true => (CAP * (1.0 - (from_tip / CAP).cos()), (from_tip / CAP).sin()),
            false => (from_tip - CAP * FRAC_PI_2 + CAP, 1.0),
        };
        let x = along.signum() * (half - to_tip);
        let rho =
            share * (radius + swing * (TAU * x / (3.0 * PITCH)).cos() + LOOP[0] * (-(to_tip / LOOP[1]).powi(2)).exp());
        let angle = TAU * x / PITCH;
        Vec3::new(x, side * rho * angle.cos(), side * rho * angle.sin())
    };
    (0..n).map(at).collect()
}
