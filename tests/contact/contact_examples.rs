//! The contact examples, each with its number.

use crate::stepper;

use crate::polylines;

#[test]
fn chains_bounce_and_momentum_is_kept() {
    let summary = stepper::run().unwrap();
    assert!(summary.deepest < 0.0 && summary.deepest > -0.5, "{summary:?}");
    assert!(summary.velocity[1] > summary.velocity[0] && summary.momentum_error < 1e-12, "{summary:?}");
}

#[test]
fn strands_of_the_file_touch_once() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/polylines.csv");
    let contacts = polylines::run(path, 1.0).unwrap();
    assert_eq!(contacts.sites.iter().filter(|s| s.gap < 0.0).count(), 1);
    assert_eq!((contacts.sites.len(), contacts.zones.len()), (3, 4));
}
