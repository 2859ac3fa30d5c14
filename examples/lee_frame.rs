//! How much can Lee's frame carry, and what does it do then? Two rods of length 120, joined rigidly at a right angle,
//! hinged at their far ends, are loaded near the corner. Units: L = 120, loads in EI/L². The path through its limit
//! points goes to `out/lee_frame/path.svg`.
//!
//! `cargo run --release --example lee_frame`
#![allow(clippy::print_stdout)] // an example talks to its reader

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::InputError;
use supercoil::io::picture::{PlotSpec, Series, SeriesStyle, plot_lines};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, Joint, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{FollowOptions, Options, PathEnd, PointKind, Solver};

/// What the example finds: (sinking of the loaded point / L, load L²/EI) along the path and at its limit points.
pub struct Summary {
    /// How the path ended.
    pub end: PathEnd,
    /// Every point.
    pub path: Vec<(f64, f64)>,
    /// The load's maximum and minimum.
    pub limits: Vec<(f64, f64)>,
}

/// Follows the load up to `to`, through its limit points.
pub fn run(to: f64) -> Result<Summary, InputError> {
    let section = Section::isotropic(2.0, 2.0, 6.0, 6.0 / 2.6, 0.1); // I = 2, A = 6, ν = 0.3 with E = 1
    let rod = |name: &str, start: Vec3, direction: Vec3| {
        Rod::new(name, &Shape::Line { start, direction, length: 120.0 }, false, section, 20, 3, Natural::Straight)
    };
    let rods = vec![rod("column", Vec3::zeros(), Vec3::y())?, rod("beam", Vec3::y() * 120.0, Vec3::x())?];
    let node = |rod, node| NodeRef { rod, node };
    let (last, loaded) = (60, 12); // 24 from the corner
    let supports = vec![Support::pin(node(0, 0)), Support::pin(node(1, last))];
    let joints = vec![Joint { a: node(0, last), b: node(1, 0) }];
    let force = -Vec3::y() * (2.0 / 120f64.powi(2));
    let loads = vec![NodeLoad { node: node(1, loaded), force, moment: Vec3::zeros() }];
    let model = Model { rods, supports, joints, loads, contact: Contact::NONE, planar: true, ..Model::default() };
    let (mut path, mut limits) = (Vec::new(), Vec::new());
    let mut solver = Solver::new(model, Options::default())?;
    let report = solver.follow(&Ramp::Load { to }, &FollowOptions::default(), &mut |point| {
        let here = (1.0 - point.engine().positions(1)[loaded].y / 120.0, point.value);
        path.push(here);
        if point.kind == PointKind::Limit {
            limits.push(here);
        }
        ControlFlow::Continue(())
    })?;
    Ok(Summary { end: report.end, path, limits })
}

fn main() -> Result<(), InputError> {
    let Summary { end, path, limits } = run(30.0)?;
    println!("path: {end:?} after {} points; (sinking/L, P L²/EI) at its limit points: {limits:.6?}", path.len());
    let series = |name: &str, points, style| Series { name: name.to_owned(), points, style };
    let series = vec![
        series("path of equilibria", path, SeriesStyle::LinePoints),
        series("limit points", limits, SeriesStyle::Points),
    ];
    let label = |text: &str| text.to_owned();
    let (title, x_label) = (label("Lee's frame"), label("sinking of the loaded point / L"));
    let plot = PlotSpec { title, x_label, y_label: label("P L²/EI"), series, ..PlotSpec::default() };
    let folder = Path::new("out/lee_frame");
    std::fs::create_dir_all(folder)
        .and_then(|()| plot_lines(&folder.join("path.svg"), &plot).map_err(std::io::Error::other))
        .map_err(|e| InputError::File { path: folder.to_owned(), reason: e.to_string() })
}
