//! Random scenes of all families, and the scenes of `tests/scenes`: they can be read, are sound and reproducible; and
//! nearly all of them come to rest.

// a test stops where it cannot go on; a table for whoever asks with --nocapture
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::families;
use crate::knots;
use crate::play;
use crate::tally;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use families::{CASES, FAMILIES};
use knots::{closed_far_away, determinant};
use play::{Clock, Limit, Row, play};
use supercoil::error::SolveError;
use supercoil::io::run::options;
use supercoil::observe::start_overlaps;
use supercoil::rod::Rod;
use supercoil::scene::Scene;
use supercoil::solve::{Options, Solver, run};

/// Time for a case on a quiet core.
const LIMIT: Limit = Limit { seconds: 100.0, clock: Clock::Wall };
/// Share of the cases of all families that must come to rest.
const SHARE: f64 = 0.99;

fn folder() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR"))
}

fn scenes() -> Vec<PathBuf> {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes");
    let mut found: Vec<PathBuf> = std::fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    found.sort();
    assert!(!found.is_empty());
    found
}

/// What is wrong with a scene before its first step: what a run refuses, and strands that start inside each other.
fn objection(scene: &Scene) -> Option<String> {
    if let Err(error) = Solver::new(scene.model.clone(), Options::default()) {
        return Some(error.to_string());
    }
    let overlap = match start_overlaps(&scene.model) {
        Err(error) => Some(error.to_string()),
        Ok(overlaps) => overlaps.first().map(ToString::to_string),
    };
    let knotted = |rod: &&Rod| is_straight(rod) && determinant(&closed_far_away(&rod.positions)) != 1.0;
    overlap.or_else(|| {
        let rod = scene.model.rods.iter().find(knotted)?;
        Some(format!("rod {} is straight, and counts as a knot", rod.name))
    })
}

fn is_straight(rod: &Rod) -> bool {
    !rod.closed
        && ((rod.positions[0] - rod.positions[rod.num_nodes() - 1]).norm() - rod.length).abs() < 1e-9 * rod.length
}

/// All cases can be read back, are sound, and the same whenever they are made.
#[test]
fn cases_are_sound() {
    let mut found = Vec::new();
    for family in &FAMILIES {
        for index in 0..CASES {
            let case = family.case(index);
            assert_eq!(case, family.case(index), "{} is not reproducible", case.name);
            let objection = match case.scene(folder()) {
                Ok(scene) => objection(&scene),
                Err(error) => Some(error.to_string()),
            };
            found.extend(objection.map(|objection| format!("{}: {objection}", case.name)));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn scenes_can_be_run() {
    for path in scenes() {
        let scene = Scene::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let solver = Solver::new(scene.model, Options::default());
        assert!(solver.is_ok(), "{}: {}", path.display(), solver.unwrap_err());
    }
}

#[test]
#[ignore = "slow: 800 runs, hours"]
fn families_come_to_rest() {
    let run = |family: &'static families::Family, index: u64| -> Row {
        let scene = family.case(index).scene(folder()).unwrap();
        play(family.name, &index.to_string(), scene, LIMIT).row
    };
    let rows: Vec<Row> = FAMILIES.iter().flat_map(|family| (0..CASES).map(move |index| run(family, index))).collect();
    tally::print(&rows);
    let passed = rows.iter().filter(|row| row.passed).count();
    assert!(passed as f64 >= SHARE * rows.len() as f64, "{passed} of {} came to rest", rows.len());
}

#[test]
#[ignore = "slow: a quarter of an hour"]
fn scenes_come_to_rest() {
    let run = |path: &PathBuf| {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        play("scenes", &name, Scene::read(path).unwrap(), LIMIT).row
    };
    let rows: Vec<Row> = scenes().iter().map(run).collect();
    tally::print(&rows);
    assert!(rows.iter().all(|row| row.passed), "not all scenes came to rest");
}

/// A ring with two bending stiffnesses that rolls and slides along itself for next to nothing. With corrections of
/// least energy each step leaves an error that the next one mends: 4142 iterations without rest, where 1611 suffice.
#[test]
fn a_ring_that_rolls_comes_to_rest() {
    let family = families::Family::named("anisotropic_rings").unwrap();
    let row = play(family.name, "1003", family.case(1003).scene(folder()).unwrap(), LIMIT).row;
    assert!(row.passed && row.iterations < 2500, "{row:?}");
}

/// A plectoneme whose loop turns by more than a right angle within a segment of its draft mesh: the failure says so.
#[test]
fn a_mesh_too_coarse_is_named() {
    let scene = families::Family::named("clamped").unwrap().case(5028).scene(folder()).unwrap();
    let solution =
        run(scene.model.clone(), &scene.stages, &options(&scene), &mut |_| ControlFlow::Continue(())).unwrap();
    let failure = solution.failure.unwrap();
    assert!(matches!(failure.error, Some(SolveError::TooCoarse { .. })), "{failure}");
    assert!(failure.to_string().ends_with("What may help: more elements"), "{failure}");
}
