//! Random numbers and random walks for tests, the same on every machine.

#![allow(dead_code)] // every test file uses its part

use nalgebra::Vector3;

/// Linear congruential generator (Knuth's MMIX constants).
pub struct Random(pub u64);

impl Random {
    /// The stream of one case of many. Streams of neighbouring numbers have nothing in common (splitmix64).
    pub fn of(family: u64, index: u64) -> Self {
        let mut z = (family << 32 ^ index).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        Self(z ^ (z >> 31))
    }

    /// Uniform in [−1, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * 0.5 * (self.unit() + 1.0)
    }

    /// Uniform among 0..n.
    pub fn below(&mut self, n: u64) -> u64 {
        (((self.unit() + 1.0) * 0.5 * n as f64) as u64).min(n - 1)
    }

    /// Each coordinate uniform in [−1, 1).
    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.unit(), self.unit(), self.unit())
    }

    /// In [low, high), with a uniform logarithm.
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.between(0.0, 1.0))
    }

    /// −1 or 1.
    pub fn sign(&mut self) -> f64 {
        self.unit().signum()
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    /// A unit vector, uniform over the sphere.
    pub fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = self.vector();
            let size = v.norm();
            if (0.1..1.0).contains(&size) {
                return v / size;
            }
        }
    }
}
