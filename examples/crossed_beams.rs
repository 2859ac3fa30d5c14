//! How hard do two crossed beams press on each other? Each is clamped at both ends, one end free to slide along the
//! beam; the upper one is lowered by δ beyond first touch. Linear theory: F = δ / (2 (ℓ³/192B + ℓ/4GA)). Units: any
//! consistent ones.
//!
//! `cargo run --release --example crossed_beams`
#![allow(clippy::print_stdout)] // an example talks to its reader

use std::ops::ControlFlow;

use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Model, NodeRef, Ramp, Stage, Support};
use supercoil::solve::{self, Options, RunError, Status};

const LENGTH: f64 = 2.0;
const SECTION: (f64, f64, f64, f64) = (1.0, 1.0, 1e5, 0.01); // B, C, EA = GA, radius

/// What the example finds.
pub struct Summary {
    /// How the run ended.
    pub status: Status,
    /// Contact force found.
    pub force: f64,
    /// Contact force of linear theory.
    pub exact: f64,
}

fn beam(name: &str, rod: usize, direction: Vec3, height: f64) -> Result<(Rod, [Support; 2]), RunError> {
    let (bending, twisting, stretching, radius) = SECTION;
    let section = Section::isotropic(bending, twisting, stretching, stretching, radius);
    let line = Shape::Line { start: Vec3::z() * height - direction * (0.5 * LENGTH), direction, length: LENGTH };
    let rod_data = Rod::new(name, &line, RodMesh::open(16, 3), section, Natural::Straight)?;
    let [start, end] = [0, rod_data.num_nodes() - 1].map(|node| NodeRef { rod, node });
    let slide = direction.map(|x| x == 0.0).into();
    Ok((rod_data, [Support::clamp(start), Support { position: slide, ..Support::clamp(end) }]))
}

/// Lowers the ends of the upper beam to first touch and by `depth` more.
pub fn run(depth: f64) -> Result<Summary, RunError> {
    let (bending, _, shearing, radius) = SECTION;
    let height = 2.5 * radius;
    let ((lower, [a, b]), (upper, [c, d])) = (beam("lower", 0, Vec3::x(), 0.0)?, beam("upper", 1, Vec3::y(), height)?);
    let down =
        |support: Support| Ramp::Displacement { node: support.node, to: Vec3::z() * (2.0 * radius - height - depth) };
    let stage = Stage::new(vec![down(c), down(d)], 10);
    let model = Model { rods: vec![lower, upper], supports: vec![a, b, c, d], ..Model::default() };
    let mut force = 0.0;
    let solution = solve::run(model, &[stage], &Options::default(), &mut |progress| {
        force = supercoil::observe::observe(progress).total_contact_force;
        ControlFlow::Continue(())
    })?;
    let compliance = LENGTH.powi(3) / (192.0 * bending) + LENGTH / (4.0 * shearing);
    Ok(Summary { status: solution.status, force, exact: depth / (2.0 * compliance) })
}

fn main() -> Result<(), RunError> {
    let summary = run(0.005)?;
    println!("{}: force {:.6}, linear theory {:.6}", summary.status, summary.force, summary.exact);
    Ok(())
}
