//! Curves of cubic pieces for tests of contact alone.

#![allow(dead_code)] // every test file uses its part

use std::f64::consts::PI;

use supercoil::contact::Cubic;
use supercoil::math::Vec3;

use super::random::Random;

/// A helix of pitch angle atan .4 in n pieces.
pub fn helix(n: usize, turns: f64, phase: f64, radius: f64) -> Vec<Cubic> {
    let h = turns * 2.0 * PI / n as f64;
    let at = |k: usize| {
        let t = h * k as f64;
        let (s, c) = (t + phase).sin_cos();
        (Vec3::new(c, s, 0.4 * t) * radius, Vec3::new(-s, c, 0.4) * (radius * h))
    };
    (0..n).map(|k| Cubic::from_hermite(at(k).0, at(k).1, at(k + 1).0, at(k + 1).1)).collect()
}

/// A `part` of a closed curve of three random harmonics in n pieces; closed if it is the whole.
pub fn harmonics(random: &mut Random, n: usize, part: f64) -> Vec<Cubic> {
    let mut wave = |k: u32| (random.vector() / f64::from(k), random.vector() / f64::from(k));
    let waves: Vec<(Vec3, Vec3)> = (1..4).map(&mut wave).collect();
    let at = |i: usize| {
        let i = if part == 1.0 { i % n } else { i };
        let t = 2.0 * PI * part * i as f64 / n as f64;
        let (mut p, mut m) = (Vec3::zeros(), Vec3::zeros());
        for (k, (a, b)) in waves.iter().enumerate() {
            let w = (k + 1) as f64;
            let (s, c) = (w * t).sin_cos();
            p += a * c + b * s;
            m += (b * c - a * s) * w;
        }
        (p, m * (2.0 * PI * part / n as f64))
    };
    (0..n).map(|k| Cubic::from_hermite(at(k).0, at(k).1, at(k + 1).0, at(k + 1).1)).collect()
}
