//! Scenes that must agree with each other: scenes of all pairs of features, and relations that need no reference.
//!
//! `axes` names the features and the combinations that are refused, `covering` chooses scenes in which every other pair
//! occurs, `draft` writes them as files. `relation` changes each and compares; `motion` has the changes, `measure` the
//! comparison, `file` any problem as a file, `work` the energy balance. `known` lists what fails for now, `tally`
//! counts.

#![allow(dead_code)] // the bench and the test use their parts
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of tests

pub mod axes;
pub mod covering;
pub mod draft;
pub mod file;
pub mod known;
pub mod measure;
pub mod motion;
pub mod relation;
pub mod tally;
pub mod work;

use draft::Draft;

/// Number of scenes: two covering arrays and more of a third.
pub const NUM_SCENES: usize = 150;

/// All scenes, always the same.
pub fn scenes() -> Vec<Draft> {
    let features = (1..=3).flat_map(covering::covering).take(NUM_SCENES);
    features.enumerate().map(|(index, features)| Draft::new(index, features)).collect()
}
