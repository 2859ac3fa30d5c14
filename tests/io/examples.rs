//! Every example's one number, and that each is short. (Those of contact alone: `tests/contact/contact_examples.rs`;
//! those that are scenes: `gallery.rs`, `poses.rs`.)

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on
#![allow(dead_code)] // the examples' own main functions

use supercoil::solve::Status;

use crate::crossed_beams;
use crate::dna_minicircle;
use crate::elastica;
use crate::lee_frame;
use crate::ring_pressure;

/// Linear theory of two clamped beams pushed together, deflections of a four-hundredth of the span.
#[test]
fn crossed_beams_press_as_linear_theory_says() {
    let summary = crossed_beams::run(0.005).unwrap();
    assert_eq!(summary.status, Status::Converged);
    assert!((summary.force / summary.exact - 1.0).abs() < 1e-3, "{} {}", summary.force, summary.exact);
}

/// The frame's first limit load, and that it snaps back through zero.
#[test]
fn lees_frame_has_two_limit_points() {
    let summary = lee_frame::run(30.0).unwrap();
    assert_eq!(summary.end, supercoil::solve::PathEnd::Target);
    let loads: Vec<f64> = summary.limits.iter().map(|limit| limit.1).collect();
    assert!(loads.len() == 2 && (loads[0] / 18.546_558_74 - 1.0).abs() < 1e-7 && loads[1] < 0.0, "{loads:?}");
}

/// The neck closes at one point, symmetric about the middle of the wire.
#[test]
fn the_elastica_touches_itself() {
    let summary = elastica::run(20).unwrap();
    assert_eq!(summary.status, Status::Converged);
    let state = summary.last.unwrap();
    assert_eq!(state.sites.len(), 1, "{:?}", state.sites);
    let site = &state.sites[0];
    let centers = [site.arc_a, site.arc_b].map(|arc| 0.5 * (arc[0] + arc[1]));
    assert!((centers[0] + centers[1] - 1.0).abs() < 1e-6 && site.gap.abs() < 1e-9, "{site:?}");
    // the clamps carry equal and opposite forces
    let [a, b] = [state.reactions[0].force, state.reactions[1].force];
    assert!((0..3).all(|k| (a[k] + b[k]).abs() < 1e-6 * a[0].abs()), "{:?}", state.reactions);
}

/// Above the buckling pressure of the circle, 3 B/R³, the ring collapses until its long sides touch in the middle, at
/// quarter and three quarters of its length.
#[test]
fn the_ring_collapses() {
    let summary = ring_pressure::run(6.0, 30).unwrap();
    assert_eq!(summary.status, Status::Converged);
    let first_touch = summary.first_touch.unwrap();
    assert!(first_touch > 3.0 && first_touch < 6.0, "{first_touch}");
    let state = summary.last.unwrap();
    assert_eq!(state.sites.len(), 1, "{:?}", state.sites);
    let site = &state.sites[0];
    let centers = [site.arc_a, site.arc_b].map(|arc| 0.5 * (arc[0] + arc[1]));
    assert!((centers[0] - 1.571).abs() < 1e-2 && (centers[1] - 4.712).abs() < 1e-2, "{centers:?}");
    assert!(site.angle < 1e-6 && state.contact_gap.unwrap().lower > -1e-9, "{state:?}");
}

/// A coarse minicircle taken to the figure-eight: its writhe, −.83087 on 48 elements.
#[test]
fn the_minicircle_writhes() {
    let out = std::env::temp_dir().join(format!("supercoil_example_{}", std::process::id()));
    let outcome = dna_minicircle::run(-1.2, 16, &out, &indicatif::ProgressBar::hidden()).unwrap();
    std::fs::remove_dir_all(&out).unwrap();
    assert_eq!(outcome.status, Status::Converged);
    let writhe = outcome.steps.last().unwrap().links[0].writhe;
    assert!((writhe + 0.83087).abs() < 2e-3, "{writhe}");
}

/// Sixty lines fit on a screen.
#[test]
fn examples_are_short() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let sources = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let lines = |path: &std::path::Path| std::fs::read_to_string(path).unwrap().lines().count();
    let code =
        sources.filter(|path| path.extension().is_some_and(|extension| extension == "rs" || extension == "toml"));
    let long: Vec<_> = code.map(|path| (lines(&path), path)).filter(|(lines, _)| *lines > 60).collect();
    assert!(long.is_empty(), "{long:?}");
}
