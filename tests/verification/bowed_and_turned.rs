//! A rod between coaxial clamps, bowed, brought together and turned, against shooting: `tests/common/clamped_loop.rs`,
//! which shares nothing with the engine.
//!
//! ```text
//!              _____
//!            /       \
//!            \       /
//!             \     /              L = B = C = 1, D = .01, clamps .4 apart, one of them turned
//!  ▌───────────╲───╱───────────▐ ⤸
//! ```
//!
//! The rod loops out; at 1.15 turns the open branch turns back and it snaps into contact with itself at one point,
//! which carries 164 B/L² at 2.25 turns. The scene is `tests/scenes/bowed_and_turned.toml`, with EA = GA = 1e8 (which
//! leaves 1e-6 of the force) and the default contact law. Without contact the force converges with the mesh's order 2p
//! = 6 until the stretch is seen; in contact the law spreads a point force over some nodes.

use std::ops::ControlFlow;
use std::path::Path;

use crate::common::clamped_loop::{ClampedLoop, Found};
use crate::common::{fitted_order, verify};

use supercoil::io::run::options;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::scene::{Ramp, Scene, Stage};
use supercoil::solve::{Status, run};

const REFERENCE: ClampedLoop = ClampedLoop { twisting: 1.0, diameter: 0.01, distance: 0.4 };
const OPEN: [f64; 3] = [0.0, 0.5, 1.0];
const TOUCHING: [f64; 5] = [1.25, 1.5, 1.75, 2.0, 2.25];

/// States at rest at the turns, on a mesh.
fn states(elements: usize, turns: &[f64]) -> Vec<Observation> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/bowed_and_turned.toml");
    let mut scene = Scene::read_with(&path, &[format!("rods.0.elements={elements}")]).unwrap();
    let Ramp::Rotation { node, axis, .. } = scene.stages[2].ramps[0] else { panic!("the scene's third stage turns") };
    scene.stages.truncate(2);
    let turned = |from: f64, to: f64| {
        let steps = ((to - from) / 0.0833).ceil() as usize;
        Stage::new(vec![Ramp::Rotation { node, axis, to }], steps)
    };
    let from = |k: usize| if k == 0 { 0.0 } else { turns[k - 1] };
    let stages = turns.iter().enumerate().filter(|(_, to)| **to > 0.0).map(|(k, &to)| turned(from(k), to));
    scene.stages.extend(stages);
    let mut ends = Vec::new();
    let solution = run(scene.model.clone(), &scene.stages, &options(&scene), &mut |progress| {
        if progress.fraction == 1.0 && progress.stage > 0 {
            ends.push(observe(progress));
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure.map(|failure| failure.to_string()));
    ends
}

/// Force and moment on the turned clamp, contact force, elastic energy.
fn numbers(state: &Observation) -> [f64; 4] {
    let [force, moment] = [state.reactions[1].force[0], state.reactions[1].moment[0]];
    [force, moment, state.total_contact_force, state.energies.total - state.energies.contact]
}

fn compare(found: &Found, state: &Observation, tolerances: [f64; 4]) {
    let exact = [found.force, found.moment, found.contact, found.energy];
    let names = ["force T L²/B", "moment M L/B", "contact force P L²/B", "elastic energy E L/B"];
    let case = format!("bowed and turned by {} turns", found.turns);
    for (k, measured) in numbers(state).into_iter().enumerate().filter(|(k, _)| *k != 2 || found.contact > 0.0) {
        verify(&case, names[k], measured, exact[k], tolerances[k]);
    }
}

#[test]
fn shooting_is_an_equilibrium_and_its_moment_the_slope_of_its_energy() {
    for found in REFERENCE.open(&OPEN).iter().chain(&REFERENCE.touching(&TOUCHING)) {
        assert!(found.residual < 1e-12, "{found:?}");
    }
    let turns = |middle: f64| [middle - 1e-3, middle, middle + 1e-3];
    for found in [REFERENCE.open(&turns(0.7)), REFERENCE.touching(&turns(1.7))] {
        let slope = (found[2].energy - found[0].energy) / (2e-3 * std::f64::consts::TAU);
        verify("clamped loop by shooting", "dE/dΦ over M", slope / found[1].moment, 1.0, 1e-5);
    }
}

#[test]
fn a_bowed_rod_turned_between_clamps() {
    let turns: Vec<f64> = OPEN.into_iter().chain(TOUCHING).collect();
    let seen = states(96, &turns);
    for (found, state) in REFERENCE.open(&OPEN).iter().zip(&seen) {
        assert!(state.sites.is_empty());
        compare(found, state, [5e-5, 5e-6, 0.0, 3e-5]);
    }
    for (found, state) in REFERENCE.touching(&TOUCHING).iter().zip(&seen[OPEN.len()..]) {
        assert_eq!(state.num_sites, 1, "{:?}", state.sites);
        let shares = [4e-4, 5e-4, 7e-4, 1e-6];
        let of = [found.force, found.moment, found.contact, found.energy];
        compare(found, state, std::array::from_fn(|k| shares[k] * of[k]));
    }
}

#[test]
fn without_contact_it_converges_with_the_order_of_the_elements() {
    let exact = REFERENCE.open(&[1.0])[0];
    let meshes = [12.0, 16.0, 24.0];
    let errors = meshes.map(|elements| {
        let seen = states(elements as usize, &[1.0]);
        (numbers(&seen[seen.len() - 1])[0] - exact.force).abs()
    });
    let order = -fitted_order(&meshes, &errors);
    verify("bowed and turned by 1 turn", "order of the force in the mesh", order, 6.0, 0.7);
}
