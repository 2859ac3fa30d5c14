//! The random numbers that fuzzed inputs are made from.

use proptest::test_runner::{RngAlgorithm, TestRng};

/// The same for every run, unless `SUPERCOIL_FUZZ_SEED` is a whole number: then those of that seed.
pub fn rng() -> TestRng {
    let seed = std::env::var("SUPERCOIL_FUZZ_SEED").ok().and_then(|text| text.parse::<u64>().ok());
    let Some(seed) = seed else { return TestRng::deterministic_rng(RngAlgorithm::ChaCha) };
    let bytes: [u8; 32] = std::array::from_fn(|k| seed.to_le_bytes()[k % 8]);
    TestRng::from_seed(RngAlgorithm::ChaCha, &bytes)
}
