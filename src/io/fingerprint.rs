//! Fingerprint of all input that decides the numbers of a run: equal for equal problems, another one for any changed
//! number.

use std::fmt::Debug;

use serde::{Deserialize, Serialize};
use twox_hash::XxHash3_128;

use crate::scene::Scene;
use crate::scene::file::SolverChoice;

/// Hashes of the parts of a scene. Title, units, outputs, pictures and threads may change: they decide no number of the
/// solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fingerprint {
    model: u128,
    stages: u128,
    solver: u128,
}

impl Fingerprint {
    /// Of a scene.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let solver = SolverChoice { threads: None, ..scene.solver };
        Self { model: hash(&scene.model), stages: hash(&(&scene.stages, scene.follow)), solver: hash(&solver) }
    }

    /// All of it in one word of 32 hexadecimal digits: the model hash of `summary.json`.
    #[must_use]
    pub fn model_hash(&self) -> String {
        format!("{:032x}", hash(self))
    }

    /// Parts in which another one differs, in words.
    #[must_use]
    pub fn differences(&self, other: &Self) -> Vec<&'static str> {
        let parts = [
            ("its rods, supports, loads or contact", self.model, other.model),
            ("its stages", self.stages, other.stages),
            ("its solver settings", self.solver, other.solver),
        ];
        parts.iter().filter(|(_, a, b)| a != b).map(|(name, ..)| *name).collect()
    }
}

/// Hash of a value's debug form, which has every field (those yet to come too) and every bit of every number.
fn hash(value: &impl Debug) -> u128 {
    struct HashSink(XxHash3_128);
    impl std::fmt::Write for HashSink {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            self.0.write(text.as_bytes());
            Ok(())
        }
    }
    let mut sink = HashSink(XxHash3_128::new());
    // the sink takes everything
    let _ = std::fmt::write(&mut sink, format_args!("{value:?}"));
    sink.0.finish_128()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const SCENE: &str = r#"
        title = "one"
        [[rods]]
        name = "beam"
        shape = { kind = "line", length = 1.0 }
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }
        elements = 2
        [[supports]]
        at = "start"
        position = true
        rotation = true
        [[stages]]
        ramp = { load = 1.0 }
        steps = 2
        follow = { step = 0.05 }
        [[loads]]
        at = "end"
        force = [0.0, 0.1, 0.0]
        [solver]
        threads = 1
    "#;

    fn of(from: &str, to: &str) -> Fingerprint {
        assert!(SCENE.contains(from), "{from}");
        Fingerprint::of(&Scene::from_toml(&SCENE.replacen(from, to, 1), Path::new("")).unwrap())
    }

    #[test]
    fn every_number_of_the_problem_counts_and_nothing_else() {
        let plain = of("", "");
        for (from, to) in [
            ("bending = 1.0", "bending = 1.0000000000000002"),
            ("shearing = 1e4", "shearing = [1e4, 2e4]"),
            ("contact_radius = 0.01", "contact_radius = 0.02"),
            ("length = 1.0", "length = 1.5"),
            ("elements = 2", "elements = 3"),
            ("at = \"start\"", "at = 1"),
            ("load = 1.0", "load = 2.0"),
            ("steps = 2", "steps = 3"),
            ("step = 0.05", "step = 0.1"),
            ("0.1, 0.0]", "0.1, 1e-300]"),
            ("threads = 1", "tol_increment = 1e-7"),
        ] {
            let changed = of(from, to);
            assert_eq!(plain.differences(&changed).len(), 1, "{to}");
            assert_ne!(plain.model_hash(), changed.model_hash(), "{to}");
        }
        for (from, to) in
            [("one", "other"), ("threads = 1", "threads = 2"), ("[solver]", "[output]\nvtk = false\n[solver]")]
        {
            assert_eq!(plain.model_hash(), of(from, to).model_hash(), "{to}");
        }
        assert_eq!(plain.model_hash().len(), 32);
    }

    /// Symptom: a changed number in a table of natural strains or stiffnesses went unnoticed: they were compared by
    /// their count.
    #[test]
    fn numbers_along_a_rod_count() {
        use crate::rod::Along;
        let along = |value: f64| Along::points(vec![0.0, 1.0], vec![value, 2.0]).unwrap();
        assert_eq!(hash(&along(1.0)), hash(&along(1.0)));
        assert_ne!(hash(&along(1.0)), hash(&along(1.5)));
        assert_ne!(hash(&Along::constant(1.0)), hash(&Along::constant(2.0)));
    }
}
