//! Scenes of `tests/scenes` come to rest, step by step, and where an exact result is known, at that.
//!
//! * `stage_boundary`: two contacts down to an excess link of 2.4646, across stages, one below.
//! * `snap_of_an_oval_ring`: the same state in any number of steps.
//!
//! The slower ones are in `random_scenes` and `cargo bench --bench families -- --families scenes`.

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::io::run::options;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::scene::{Scene, Stage};
use supercoil::solve::{Status, run};

/// The scene's last state; its load steps changed by `change`.
fn end_of(name: &str, change: impl Fn(&mut Stage)) -> Observation {
    states_of(name, change).pop().unwrap()
}

/// The states of all steps of a scene.
fn states_of(name: &str, change: impl Fn(&mut Stage)) -> Vec<Observation> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes").join(name).with_extension("toml");
    let mut scene = Scene::read(&path).unwrap();
    scene.stages.iter_mut().for_each(change);
    let mut states = Vec::new();
    let solution = run(scene.model.clone(), &scene.stages, &options(&scene), &mut |progress| {
        states.push(observe(progress));
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(solution.status, Status::Converged, "{name}: {:?}", solution.failure.map(|failure| failure.to_string()));
    assert!(states.iter().all(|state| state.num_unstable == 0), "{name}");
    states
}

/// Near the end of the branch the two points lie in one zone.
#[test]
fn stage_boundary() {
    let states = states_of("stage_boundary", |_| ());
    let unwound = states.iter().skip_while(|state| state.links[0].excess_link < 2.6 - 1e-9);
    let sites: Vec<(f64, usize)> = unwound.map(|state| (state.links[0].excess_link, state.num_sites)).collect();
    let on_branch = sites.iter().filter(|(link, _)| *link > 2.4646 + 5e-3);
    assert!(on_branch.clone().count() >= 26 && on_branch.clone().all(|(_, count)| *count == 2), "{sites:?}");
    assert_eq!(sites.last().unwrap().1, 1);
}

/// In 12 steps, in 5, at once.
#[test]
fn snap_of_an_oval_ring() {
    let energies = [None, Some(5), Some(1)]
        .map(|steps| end_of("snap_of_an_oval_ring", |stage| stage.steps = steps.unwrap_or(stage.steps)).energies.total);
    for energy in energies {
        assert!((energy / energies[0] - 1.0).abs() < 1e-5, "{energies:?}");
    }
}

/// In steps of any size, at about the same price: 15 to 45 steps take 240 to 860 iterations. The beam slides softly
/// along the ring; with a shift for stiffer motions 20 steps take 9369 iterations, 36 steps 13 653.
#[test]
fn contact_beside_a_clamp() {
    for steps in [18, 20, 36] {
        let states = states_of("contact_beside_a_clamp", |stage| stage.steps = steps);
        let iterations: usize = states.iter().map(|state| state.iterations).sum();
        assert!(iterations < 1000, "{steps} steps: {iterations}");
    }
}

#[test]
fn curl_from_straight() {
    end_of("curl_from_straight", |_| ());
}

#[test]
fn open_knot() {
    end_of("open_knot", |_| ());
}

/// Before two beams of steel touch, their reactions of 1e-8 N are rounding: their work is no energy set free.
#[test]
fn rounding_of_reactions_sets_nothing_free() {
    let scene = Scene::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/crossed_beams.toml")).unwrap();
    let solution = run(scene.model.clone(), &scene.stages, &options(&scene), &mut |progress| {
        let state = observe(progress);
        assert_eq!(state.energy_released, 0.0, "step {}", state.step);
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(solution.status, Status::Converged);
}
