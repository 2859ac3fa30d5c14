//! `base_pairs.csv`: of rods with a sequence.

use crate::dna::base_pairs::{AtRest, BasePairs};
use crate::error::InputError;
use crate::scene::Scene;

use super::run::RecordedRun;
use super::{Writer, files};

#[derive(Debug)]
pub(super) struct BasePairsWriter {
    /// Those of each rod, where it has a sequence.
    of_rods: Vec<Option<AtRest>>,
}

impl BasePairsWriter {
    pub fn new(scene: &Scene) -> Self {
        Self { of_rods: scene.base_pairs.clone() }
    }
}

impl Writer for BasePairsWriter {
    fn end(&mut self, run: &RecordedRun) -> Result<(), InputError> {
        let rods = self.of_rods.iter().enumerate();
        let rods: Vec<_> = rods.filter_map(|(rod, pairs)| Some((rod, pairs.as_ref()?))).collect();
        if rods.is_empty() {
            return Ok(());
        }
        BasePairs::write(&run.dir.join(files::BASE_PAIRS), AtRest::table(rods.into_iter()))
    }
}
