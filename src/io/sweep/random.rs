//! Random draws that depend on a seed, a key and an index only: further draws or keys do not change earlier ones.

use twox_hash::XxHash3_128;

use crate::dna::sequence::SplitMix;

/// A stream of numbers, the same on every machine and in every version.
#[derive(Debug, Clone)]
pub(super) struct DrawStream(SplitMix);

impl DrawStream {
    /// The stream of draw `index` of a key.
    pub fn of(seed: u64, key: &str, index: usize) -> Self {
        Self(SplitMix(XxHash3_128::oneshot(format!("{seed} {key} {index}").as_bytes()) as u64))
    }

    fn bits(&mut self) -> u64 {
        self.0.bits()
    }

    /// Uniform in [0, 1), with 53 bits.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform among 0 … count − 1; `count` > 0. Off uniform by less than count / 2⁶⁴.
    pub fn below(&mut self, count: u64) -> u64 {
        ((u128::from(self.bits()) * u128::from(count)) >> 64) as u64
    }

    /// Of mean 0 and standard deviation 1 (Box & Muller 1958).
    pub fn normal(&mut self) -> f64 {
        // 1 − x avoids the logarithm of 0
        let (radius, angle) = ((-2.0 * (1.0 - self.unit()).ln()).sqrt(), std::f64::consts::TAU * self.unit());
        radius * angle.cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_uniform_and_normal_and_independent() {
        let count = 20_000;
        let draws: Vec<DrawStream> = (0..count).map(|index| DrawStream::of(7, "a.b", index)).collect();
        let mean = |of: &dyn Fn(DrawStream) -> f64| draws.iter().cloned().map(of).sum::<f64>() / count as f64;
        // four standard errors
        assert!((mean(&|mut r| r.unit()) - 0.5).abs() < 4.0 * 0.289 / (count as f64).sqrt());
        assert!(mean(&|mut r| r.normal()).abs() < 4.0 / (count as f64).sqrt());
        assert!((mean(&|mut r| r.normal().powi(2)) - 1.0).abs() < 4.0 * 1.42 / (count as f64).sqrt());
        assert!((mean(&|mut r| r.below(4) as f64) - 1.5).abs() < 4.0 * 1.12 / (count as f64).sqrt());
        let next = |index: usize| draws[(index + 1) % count].clone().normal();
        let paired = (0..count).map(|k| draws[k].clone().normal() * next(k)).sum::<f64>() / count as f64;
        assert!(paired.abs() < 4.0 / (count as f64).sqrt(), "{paired}");
        assert_ne!(DrawStream::of(7, "a.b", 0).bits(), DrawStream::of(8, "a.b", 0).bits());
        assert_ne!(DrawStream::of(7, "a.b", 0).bits(), DrawStream::of(7, "a.c", 0).bits());
    }

    /// Draws do not change between versions.
    #[test]
    fn draws_are_those_of_every_version() {
        let mut random = DrawStream::of(1, "rods.dna.sequence.letters", 3);
        let drawn = [random.below(1_000_000), random.below(1_000_000)];
        assert_eq!(drawn, [976571, 18332]);
    }
}
