//! The 45° bend of Bathe & Bolourchi (1979): a curved cantilever loaded out of its plane, in ONE load step.
//!
//! Set-up: a circular arc of radius 100 and 45° in the x-y plane, stress-free, clamped at the origin with its tangent
//! along +x and turning towards +y; a dead force along z at the tip. Square section 1 × 1, E = 1e7, ν = 0: EA = 1e7, EI
//! = E/12, GJ = 5e6/6, shear stiffness 5/6 · 5e6 (and 5e6 as a variant). 16 cubic elements. Reference: tip position of
//! the continuous rod, solved as a boundary value problem to all printed digits. (The often quoted (47.23, 15.79,
//! 53.37) at 600 of Simo & Vu-Quoc 1986 comes from coarse meshes.) Tolerance: 1e-7 absolute.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use common::cases::{BATHE_TIP_AT_600, bathe_bend};
use common::{history, tip, verify_point};
use supercoil::scene::Ramp;
use supercoil::solve::{Options, Solver, Status};

const TOLERANCE: f64 = 1e-7;

fn bend(force: f64, shearing: f64) -> Solver {
    let mut solver = Solver::new(bathe_bend(16, 3, force, shearing), Options::default()).unwrap();
    let report = solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap();
    println!("force {force}: {}", history(&report));
    assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", history(&report));
    assert!(report.iterations <= 30, "{}", history(&report));
    solver
}

#[test]
fn tip_at_three_loads() {
    for (force, reference) in [
        (300.0, [58.778_897_330_0, 22.244_679_426_7, 40.192_392_332_3]),
        (450.0, [52.238_261_846_7, 18.508_064_875_6, 48.503_491_531_8]),
        (600.0, BATHE_TIP_AT_600),
    ] {
        let solver = bend(force, 5.0 / 6.0 * 5e6);
        verify_point(&format!("Bathe-Bolourchi, {force}"), &tip(&solver), reference, TOLERANCE);
    }
}

#[test]
fn tip_with_full_shear_stiffness() {
    let reference = [47.150_438_573_6, 15.684_800_534_0, 53.474_858_791_8];
    verify_point("Bathe-Bolourchi, 600, kGA = 5e6", &tip(&bend(600.0, 5e6)), reference, TOLERANCE);
}
