//! A rod clamped at one end and turned at the other, which may slide along the axis, without pull: where it buckles,
//! and what holds of it wound up in a plectoneme.
//!
//! * Loss of stability of the straight rod: Greenhill's ML/B = 8.986818916 for two clamps, so Φ = 8.986818916 B/C. Here
//!   C/B = 1/(1 + ν) = 4/3. The difference goes with the square of the thickness: by shear and by the rod's own
//!   shortening, which Greenhill's thin rod does not have.
//! * With the thin rod in contact with itself, whatever its shape: forces and moments of the two ends balance, for
//!   contact is internal; and M = dE/dΦ, E the elastic energy, by differences of two
//!   hundredths of a turn, the work of the turned end being the only one. A contact force with a part along its own
//!   strand, or a moment that is not the energy's slope, would be seen.
//!
//! Scenes: `tests/scenes/turned_thin_rod_plectoneme.toml` (L/D = 50) and `turned_rod_plectoneme.toml` (L/D = 20).

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;

use crate::common::{to_branch_point, verify};

use supercoil::io::run::options;
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::scene::{Ramp, Scene, Stage};
use supercoil::solve::{Solver, Status, run};

const GREENHILL: f64 = 8.986818916;
const TWIST_OVER_BEND: f64 = 4.0 / 3.0;

fn scene(name: &str) -> Scene {
    Scene::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes").join(name).with_extension("toml")).unwrap()
}

/// Turns at which the straight rod of a scene loses its stability, over Greenhill's.
fn onset(name: &str) -> f64 {
    let scene = scene(name);
    let options = options(&scene);
    let mut solver = Solver::new(scene.model, options).unwrap();
    assert_eq!(solver.find_equilibrium().status, Status::Converged);
    let Ramp::Rotation { node, axis, .. } = scene.stages[0].ramps[0] else { panic!("it turns") };
    to_branch_point(&mut solver, &Ramp::Rotation { node, axis, to: 1.5 }) * TWIST_OVER_BEND * TAU / GREENHILL
}

#[test]
fn it_buckles_where_greenhill_says() {
    let [thin, thick] = ["turned_thin_rod_plectoneme", "turned_rod_plectoneme"].map(onset);
    let turns = "turns at loss of stability over Greenhill's";
    verify("turned rod, L/D = 50", turns, thin, 1.0, 3e-4);
    verify("turned rod, L/D = 20", turns, thick, 1.0, 2e-3);
    let order = ((1.0 - thick) / (1.0 - thin)).ln() / 2.5f64.ln();
    verify("turned rod", "order of the difference in the thickness", order, 2.0, 0.05);
}

#[test]
#[ignore = "slow: a quarter of a minute"]
fn wound_up_it_balances_and_its_moment_is_the_slope_of_its_energy() {
    let mut scene = scene("turned_thin_rod_plectoneme");
    let Ramp::Rotation { node, axis, .. } = scene.stages[0].ramps[0] else { panic!("it turns") };
    let stage = |to: f64, steps: usize| Stage::new(vec![Ramp::Rotation { node, axis, to }], steps);
    let turns = [2.98, 3.0, 3.02];
    scene.stages = vec![stage(turns[0], 12), stage(turns[1], 1), stage(turns[2], 1)];
    let mut seen = Vec::new();
    let solution = run(scene.model.clone(), &scene.stages, &options(&scene), &mut |progress| {
        if progress.fraction == 1.0 {
            let ends = [0, node.node].map(|k| progress.engine.positions(0)[k]);
            seen.push((observe(progress), ends));
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure.map(|failure| failure.to_string()));
    let states = &seen[seen.len() - 3..];
    let case = "thin turned rod, 3 turns";
    let moment = states[1].0.reactions[1].moment[1];
    for (state, [start, end]) in states {
        assert!(state.num_sites > 0, "not in contact");
        let vector = |v: [f64; 3]| Vec3::from(v);
        let [one, two] = [&state.reactions[0], &state.reactions[1]];
        let force = vector(one.force) + vector(two.force);
        let turning =
            vector(one.moment) + vector(two.moment) + start.cross(&vector(one.force)) + end.cross(&vector(two.force));
        verify(case, "sum of the ends' forces, over M/L", force.norm() / moment, 0.0, 1e-9);
        verify(case, "sum of the ends' moments, over M", turning.norm() / moment, 0.0, 1e-9);
    }
    let energy = |k: usize| states[k].0.energies.total - states[k].0.energies.contact;
    let slope = (energy(2) - energy(0)) / (TAU * (turns[2] - turns[0]));
    verify(case, "dE/dΦ over M", slope / moment, 1.0, 1e-3);
}
