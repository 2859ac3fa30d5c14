//! The Princeton beam (Dowell & Traybar 1975): a flat cantilever with a tip weight, its section turned about its axis.
//!
//! Set-up: length 0.508 m along x; the chord (stiff direction) along y, the flap (soft direction) along z; a dead tip
//! force P = 8.896 N at the angle θ from the chord. EI 2.42873444 (flap), 36.27936354 (chord), GJ = 3.10333828 N m²,
//! shear stiffness 9.039150e5, EA = 2.841909e6 N. Reference: |flap| and |chord| displacement of the continuous rod,
//! solved as a boundary value problem to all printed digits (8 decimals of a metre). Tolerance: half of the last
//! printed digit.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use common::{cantilever, history, tip, verify};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::Ramp;
use supercoil::solve::{Options, Solver, Status};

#[test]
fn tip_displacements_at_four_angles() {
    for (degrees, flap, chord) in [
        (30.0f64, 0.079_456_08, 0.010_147_24),
        (45.0, 0.109_041_57, 0.008_888_86),
        (60.0, 0.129_923_51, 0.006_654_36),
        (90.0, 0.146_259_98, 0.0),
    ] {
        // d1 is along z, d2 along −y: bending about d1 moves the rod along y
        let section = Section {
            bending: [36.279_363_54, 2.428_734_44],
            twisting: 3.103_338_28,
            shearing: [9.039_150e5; 2],
            stretching: 2.841_909e6,
            contact_radius: 1e-3,
        };
        let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 0.508 };
        let rod = Rod::new("beam", &shape, RodMesh::open(16, 3), section, Natural::Straight).unwrap();
        let (sin, cos) = degrees.to_radians().sin_cos();
        let weight = Vec3::new(0.0, cos, sin) * 8.896;
        let mut solver = Solver::new(cantilever(rod, weight, Vec3::zeros()), Options::default()).unwrap();
        let report = solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap();
        println!("{degrees}°: {}", history(&report));
        assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", history(&report));
        let (case, end) = (format!("Princeton beam, {degrees}°"), tip(&solver));
        verify(&case, "flap", end.z.abs(), flap, 5.1e-9);
        verify(&case, "chord", end.y.abs(), chord, 5.1e-9);
    }
}
