//! The detector's steps one by one, for benchmarks and white-box tests.

use crate::contact::curves::input::Curve;
use crate::contact::detector::Detector;
use crate::contact::tree::exclusion::bytes;
use crate::error::InputError;

/// One step of a detection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DetectorStep {
    /// Input check and exclusion of neighbours.
    Prepare,
    /// Boxes and tree.
    Refit,
    /// Pairs of overlapping boxes, neighbours left out; the list then holds these.
    Boxes,
    /// The same and the capsule test; the list then holds the candidates.
    Candidates,
    /// Arc lengths, minima of all candidates.
    Sites,
    /// Arc lengths, zones of all candidates.
    Zones,
}

impl Detector {
    /// Memory of the detector between calls, bytes, spare capacity included: without the results, and that of the sites
    /// and zones.
    #[doc(hidden)]
    #[must_use]
    pub fn memory(&self) -> (usize, usize) {
        let found = bytes(&self.contacts.sites) + bytes(&self.contacts.zones);
        (self.exclusion.memory() + self.broad.memory() + self.own_memory(), found)
    }

    /// Runs one step on the results of the steps before it; returns the number of segments, pairs, sites or zones
    /// found.
    ///
    /// # Errors
    /// As [`Detector::detect`].
    #[doc(hidden)]
    pub fn run_stage(&mut self, curves: &[Curve], stage: DetectorStep) -> Result<usize, InputError> {
        if stage == DetectorStep::Prepare {
            return Ok(self.prepare(curves)?.len());
        }
        let strands = crate::contact::curves::input::Strands::view(curves);
        let range = self.options.range;
        Ok(match stage {
            DetectorStep::Prepare | DetectorStep::Refit => {
                self.broad.refit(&strands, 0.5 * range);
                strands.len()
            }
            DetectorStep::Boxes | DetectorStep::Candidates => {
                let reach = (stage == DetectorStep::Candidates).then_some(range);
                self.broad.search(&strands, &self.exclusion, reach);
                self.broad.pairs().len()
            }
            DetectorStep::Sites => {
                self.measure(&strands);
                let mut sites = std::mem::take(&mut self.contacts.sites);
                self.find_sites(&strands, &mut sites);
                self.contacts.sites = sites;
                self.contacts.sites.len()
            }
            DetectorStep::Zones => {
                self.measure(&strands);
                self.find_zones(&strands).len()
            }
        })
    }
}
