//! A straight cantilever bent into a helix by an end moment and an end force (Ibrahimbegović 1997).
//!
//! Set-up: a straight rod of length 10 along x, clamped at the origin; EA = GA = 1e4, EI = GJ = 100; at the tip a dead
//! moment λ·200π about the fixed axis z (ten full circles at λ = 1) and a dead force λ·50 along z. And the same rod
//! under moment 2.5π and force 1/16. Reference: tip of the continuous rod, solved as a boundary value problem to all
//! printed digits. Tolerance: 1e-6 with 120 cubic elements (twelve to a circle), 1e-9 with 16 (an eighth of a circle).
//!
//! A fixed-axis moment has no potential in space: the inertia of the symmetrised tangent does not decide stability
//! here, so the search takes the equilibrium it finds.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use common::{any_equilibrium, cantilever, verify_point};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Ramp, Stage};
use supercoil::solve::{Solution, Status, run};

/// Tips at the ends of the stages, each ramping the load to the given factor in so many steps.
fn tips(elements: usize, force: f64, moment: f64, stages: &[(f64, usize)]) -> Vec<Vec3> {
    let section = Section::isotropic(100.0, 100.0, 1e4, 1e4, 0.1);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 10.0 };
    let rod = Rod::new("rod", &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap();
    let model = cantilever(rod, Vec3::z() * force, Vec3::z() * moment);
    let stages: Vec<Stage> = stages.iter().map(|&(to, steps)| Stage::new(vec![Ramp::Load { to }], steps)).collect();
    let mut out = vec![Vec3::zeros(); stages.len()];
    let solution = run(model, &stages, &any_equilibrium(), &mut |progress| {
        out[progress.stage] = *progress.engine.positions(0).last().unwrap();
        ControlFlow::Continue(())
    })
    .expect("a sound model");
    let Solution { status, num_steps, iterations, .. } = solution;
    println!("{status:?}, {num_steps} steps, {iterations} iterations");
    assert_eq!(status, Status::Converged);
    assert!(iterations <= 10 * (num_steps + 1), "{iterations} iterations in {num_steps} steps");
    out
}

#[test]
fn ten_circles_drawn_out_into_a_helix() {
    let found = tips(120, 50.0, 200.0 * PI, &[(0.5, 25), (1.0, 25)]);
    verify_point("helix, λ = 0.5", &found[0], [0.019_106_995, 0.000_573_980, -0.226_637_440_7], 1e-6);
    verify_point("helix, λ = 1", &found[1], [4.803_249_66e-3, 7.249_684_7e-5, -7.644_174_173_2e-2], 1e-6);
}

#[test]
fn an_eighth_of_a_circle() {
    let found = tips(16, 1.0 / 16.0, 2.5 * PI, &[(1.0, 1)]);
    let displacement = found[0] - Vec3::new(10.0, 0.0, 0.0);
    let reference = [-0.998_508_359_8, 3.727_561_074_7, 0.195_751_361_6];
    verify_point("helix, small moment", &displacement, reference, 1e-9);
}
