//! A DNA minicircle of 336 base pairs supercoils: from the flat circle through the figure-eight into the supercoil.
//! Units: nm, pN. Optional arguments: excess link in turns (-3), number of elements (48).
//!
//! `cargo run --release --example dna_minicircle`
#![allow(clippy::print_stdout)] // an example talks to its reader

use std::ops::ControlFlow;
use std::path::Path;

use indicatif::ProgressBar;
use supercoil::dna;
use supercoil::io::{
    run::{Outcome, run_scene},
    table::StepTable,
};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Model, Ramp, Scene, Stage, Units};
use supercoil::solve::RunError;

const OUT: &str = "out/dna_minicircle";

fn units() -> Units {
    Units { length: "nm".into(), force: "pN".into() }
}

/// The molecule with its ends joined after `excess_link` extra turns, at rest.
pub fn run(excess_link: f64, elements: usize, out: &Path, bar: &ProgressBar) -> Result<Outcome, RunError> {
    let radius = 0.5 * dna::contact_diameter_nm(0.15)?; // 150 mM salt: strands keep 5 nm apart
    let (bending, twisting, stretching) = (dna::BENDING_STIFFNESS, dna::TWIST_STIFFNESS, dna::STRETCH_MODULUS);
    let section = Section::isotropic(bending, twisting, stretching, stretching, radius);
    let length = dna::MINICIRCLE.contour_length();
    let circle = Shape::Circle { length, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("dna", &circle, RodMesh::closed(elements, 3), section, Natural::Straight)?;
    let scene = Scene {
        title: format!("336 bp minicircle, excess link to {excess_link}"),
        units: units(),
        model: Model { rods: vec![rod], ..Model::default() },
        stages: vec![Stage::new(vec![Ramp::ExcessLink { rod: 0, to: excess_link }], 30)],
        ..Scene::default()
    };
    run_scene(scene, out, &mut |step| {
        bar.set_position((1000.0 * step.fraction) as u64);
        ControlFlow::Continue(())
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let excess_link = arguments.next().map_or(Ok(-3.0), |text| text.parse())?;
    let elements = arguments.next().map_or(Ok(48), |text| text.parse())?;
    let bar = ProgressBar::new(1000);
    let outcome = run(excess_link, elements, Path::new(OUT), &bar)?;
    bar.finish_and_clear();
    print!("{}", StepTable { units: &units(), steps: &outcome.steps });
    println!("{} after {:.1} s. Look at {OUT}/picture.png and {OUT}/writhe.svg;", outcome.status, outcome.seconds);
    println!("open {OUT}/run.pvd in ParaView; all numbers are in {OUT}/summary.json and {OUT}/table.csv.");
    Ok(())
}
