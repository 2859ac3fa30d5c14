//! How does a ring collapse under outside pressure? A slight oval of mean radius 1 m and bending stiffness 1 N m², free
//! of stress as it is, bends to a dog bone and closes in the middle. (A perfect circle buckles at 3 B/R³, Lévy 1884.)
//! Units: m, N.
//!
//! `cargo run --release --example ring_pressure`
#![allow(clippy::print_stdout)] // an example talks to its reader

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use supercoil::math::Vec3;
use supercoil::observe::{observe, report::Observation};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Model, Ramp, Stage};
use supercoil::solve::{self, Options, RunError, Status};

/// What the example finds.
pub struct Summary {
    /// How the run ended.
    pub status: Status,
    /// Pressure at which the ring first touches itself, N/m; between two load steps.
    pub first_touch: Option<f64>,
    /// The last state reached.
    pub last: Option<Observation>,
}

/// Raises the pressure to `pressure` in `steps` load steps.
pub fn run(pressure: f64, steps: usize) -> Result<Summary, RunError> {
    let angle = |k: i32| TAU * f64::from(k) / 24.0;
    let oval = (0..24).map(|k| Vec3::new(1.02 * angle(k).cos(), 0.98 * angle(k).sin(), 0.0)).collect();
    let section = Section::isotropic(1.0, 1.0, 1e5, 1e5, 0.05);
    let ring = Rod::new("ring", &Shape::Points(oval), RodMesh::closed(32, 3), section, Natural::AsShaped)?;
    let model = Model { rods: vec![ring], planar: true, ..Model::default() };
    let stage = Stage::new(vec![Ramp::Pressure { rod: 0, to: pressure }], steps);
    let (mut first_touch, mut last) = (None, None);
    let solution = solve::run(model, &[stage], &Options::default(), &mut |progress| {
        let state = observe(progress);
        if !state.sites.is_empty() && first_touch.is_none() {
            first_touch = Some(pressure * state.fraction);
        }
        last = Some(state);
        ControlFlow::Continue(())
    })?;
    Ok(Summary { status: solution.status, first_touch, last })
}

fn main() -> Result<(), RunError> {
    let summary = run(6.0, 30)?;
    println!("{}; first touch at a pressure of {:?} N/m", summary.status, summary.first_touch);
    summary.last.iter().flat_map(|state| &state.sites).for_each(|site| println!("{site:?}"));
    Ok(())
}
