//! How much can Lee's frame carry, and what does it do then? Two rods of length 120, joined rigidly at a right angle,
//! hinged at their far ends, are loaded near the corner. Units: L = 120, loads in EI/L². The path goes to
//! `out/lee_frame.svg`. `cargo run --release --example lee_frame`
#![allow(clippy::print_stdout)] // an example talks to its reader

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::InputError;
use supercoil::io::picture::{PlotSpec, Series, SeriesStyle, plot_lines};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Joint, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{FollowOptions, Options, PathEnd, PointKind, Solver};

/// Points are (sinking of the loaded point / L, load L²/EI).
pub struct Summary {
    /// How the path ended.
    pub end: PathEnd,
    /// Every point of it.
    pub path: Vec<(f64, f64)>,
    /// The load's maximum and minimum.
    pub limits: Vec<(f64, f64)>,
}

/// Follows the load up to `to`, through its limit points.
pub fn run(to: f64) -> Result<Summary, InputError> {
    let section = Section::isotropic(2.0, 2.0, 6.0, 6.0 / 2.6, 0.1); // I = 2, A = 6, ν = 0.3 with E = 1
    let rod = |name: &str, start: Vec3, direction: Vec3| {
        let shape = Shape::Line { start, direction, length: 120.0 };
        Rod::new(name, &shape, RodMesh::open(20, 3), section, Natural::Straight)
    };
    let rods = vec![rod("column", Vec3::zeros(), Vec3::y())?, rod("beam", Vec3::y() * 120.0, Vec3::x())?];
    let node = |rod, node| NodeRef { rod, node };
    let (last, loaded) = (60, 12); // 24 from the corner
    let supports = vec![Support::pin(node(0, 0)), Support::pin(node(1, last))];
    let joints = vec![Joint::rigid(node(0, last), node(1, 0))];
    let force = -Vec3::y() * (2.0 / 120f64.powi(2));
    let loads = vec![NodeLoad { node: node(1, loaded), force, moment: Vec3::zeros() }];
    let model = Model { rods, supports, joints, loads, contact: Contact::NONE, planar: true, ..Model::default() };
    let (mut path, mut limits) = (Vec::new(), Vec::new());
    let mut solver = Solver::new(model, Options::default())?;
    let report = solver.follow(&Ramp::Load { to }, &FollowOptions::default(), &mut |point| {
        let here = (1.0 - point.engine().positions(1)[loaded].y / 120.0, point.value);
        path.push(here);
        limits.extend((point.kind == PointKind::Limit).then_some(here));
        ControlFlow::Continue(())
    })?;
    Ok(Summary { end: report.end, path, limits })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Summary { end, path, limits } = run(30.0)?;
    println!("path: {end:?} after {} points; (sinking/L, P L²/EI) at its limit points: {limits:.6?}", path.len());
    let series = vec![Series { name: "path of equilibria".to_owned(), points: path, style: SeriesStyle::LinePoints }];
    let [title, x_label, y_label] = ["Lee's frame", "sinking of the loaded point / L", "P L²/EI"].map(str::to_owned);
    std::fs::create_dir_all("out")?;
    plot_lines(Path::new("out/lee_frame.svg"), &PlotSpec { title, x_label, y_label, series, ..PlotSpec::default() })?;
    Ok(())
}
