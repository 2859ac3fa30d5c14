//! Random numbers and random walks for tests, the same on every machine.

#![allow(dead_code)] // every test file uses its part

use nalgebra::Vector3;

/// Linear congruential generator (Knuth's MMIX constants).
pub struct Random(pub u64);

impl Random {
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
}
