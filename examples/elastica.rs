//! When do the legs of a planar elastica touch, and how hard do they press? A straight wire of length 1 m and bending
//! stiffness 1 N m² is bent to a semicircle; its clamped ends are brought together, so that it bulges like a drop, and
//! then turned inwards until the neck closes. Units: m, N.
//!
//! `cargo run --release --example elastica`
#![allow(clippy::print_stdout)] // an example talks to its reader

use std::f64::consts::PI;
use std::ops::ControlFlow;

use supercoil::math::Vec3;
use supercoil::observe::{observe, report::Observation};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Model, NodeRef, Ramp, Stage, Support};
use supercoil::solve::{self, Options, RunError, Status};

/// What the example finds.
pub struct Summary {
    /// How the run ended.
    pub status: Status,
    /// Turn of each end at which the legs first touch, turns; between two load steps.
    pub first_touch: Option<f64>,
    /// The last state reached.
    pub last: Option<Observation>,
}

/// Runs both stages, `steps` load steps each.
pub fn run(steps: usize) -> Result<Summary, RunError> {
    let section = Section::isotropic(1.0, 1.0, 1e5, 1e5, 0.01);
    let (start, tangent, towards) = (Vec3::x() / PI, Vec3::y(), -Vec3::x());
    let semicircle = Shape::Arc { start, tangent, towards, radius: 1.0 / PI, angle: PI };
    let wire = Rod::new("wire", &semicircle, RodMesh::open(32, 3), section, Natural::Straight)?;
    let [a, b] = [0, wire.num_nodes() - 1].map(|node| NodeRef { rod: 0, node });
    let supports = vec![Support::clamp(a), Support::clamp(b)];
    let model = Model { rods: vec![wire], supports, planar: true, ..Model::default() };
    let inwards = |node, x: f64| Ramp::Displacement { node, to: Vec3::x() * x };
    let turn = |node, to| Ramp::Rotation { node, axis: Vec3::z(), to };
    let stages = [
        Stage::new(vec![inwards(a, -0.29), inwards(b, 0.29)], steps),
        Stage::new(vec![turn(a, 0.125), turn(b, -0.125)], steps),
    ];
    let (mut first_touch, mut last) = (None, None);
    let solution = solve::run(model, &stages, &Options::default(), &mut |progress| {
        let state = observe(progress);
        if !state.sites.is_empty() && first_touch.is_none() {
            first_touch = Some(0.125 * state.fraction);
        }
        last = Some(state);
        ControlFlow::Continue(())
    })?;
    Ok(Summary { status: solution.status, first_touch, last })
}

fn main() -> Result<(), RunError> {
    let summary = run(20)?;
    println!("{}; first touch at end turns of {:?}", summary.status, summary.first_touch);
    summary.last.iter().flat_map(|state| &state.sites).for_each(|site| println!("{site:?}"));
    Ok(())
}
