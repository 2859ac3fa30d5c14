//! What a run of a hundred thousand nodes leaves behind: complete, and bounded in size per node.

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a test stops where it cannot go on

use crate::plectoneme;

use std::path::{Path, PathBuf};
use std::time::Instant;

use plectoneme::plectoneme;
use supercoil::internals::record::{MAX_SITES, Record, RodSnapshot};
use supercoil::io::csv::read_state;
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::file::OutputChoice;
use supercoil::scene::{Model, Scene};
use supercoil::solve::{Options, Progress, Solver, Status, StepReport};

/// A plectoneme as it was laid, not in equilibrium: touching here and there along its whole length.
fn scene(nodes: usize) -> Scene {
    let section = Section::isotropic(100.0, 150.0, 1e4, 1e4, 1.0);
    let shape = Shape::Points(plectoneme(nodes, 1.0, 0.02));
    let rod = Rod::new("dna", &shape, RodMesh::closed(nodes / 3, 3), section, Natural::Straight).unwrap();
    Scene { title: "long".to_owned(), model: Model { rods: vec![rod], ..Model::default() }, ..Scene::default() }
}

fn report() -> StepReport {
    StepReport {
        status: Status::Converged,
        iterations: 0,
        iterations_on_other_meshes: 0,
        augmentations: 0,
        escapes: 0,
        energy_released: 0.0,
        num_unstable: 0,
        penetration: 0.0,
        complementarity: 0.0,
        stiffness_reduction: 1.0,
        start: None,
        attempts: Vec::new(),
        branch_ends: false,
        error: None,
        history: Vec::new(),
    }
}

/// The start state seen and snapped as a run would.
fn state(scene: &Scene) -> (Observation, Vec<RodSnapshot>) {
    let mut solver = Solver::new(scene.model.clone(), Options::default()).unwrap();
    // brings contact up to date
    let _ = solver.num_unstable().unwrap();
    let (report, engine) = (report(), solver.engine());
    let started = Instant::now();
    let progress = Progress { given: None, engine, stage: 0, step: 0, fraction: 0.0, report: &report, seconds: 0.0 };
    let observation = observe(&progress);
    println!("{} nodes: observation {:.2?}", engine.num_nodes(), started.elapsed());
    let fields = engine.all_nodal_fields().remove(0);
    let smoothed_contact_force = fields.contact_force.clone();
    let (positions, frames) = (engine.positions(0).to_vec(), engine.frames(0).to_vec());
    let snapshot = RodSnapshot { positions, frames, fields, smoothed_contact_force };
    (observation, vec![snapshot])
}

/// Writes the record of two like states into an empty folder.
fn record(scene: &Scene, output: OutputChoice, observation: &Observation, rods: &[RodSnapshot], name: &str) -> PathBuf {
    let dir = std::env::temp_dir().join(format!("supercoil_long_{}_{name}", std::process::id()));
    std::fs::remove_dir_all(&dir).ok();
    let mut record = Record::new(&Scene { output, ..scene.clone() }, &dir).unwrap();
    for step in 0..2 {
        record.push(Observation { step, ..observation.clone() }, rods.to_vec()).unwrap();
    }
    let started = Instant::now();
    record.finish(true, "converged", 1.0).unwrap();
    println!("{name}: finishing {:.2?}", started.elapsed());
    dir
}

/// Bytes of the appended array `name` of a `.vtp` file, found by its offset as VTK does.
fn array(path: &Path, name: &str) -> Vec<f64> {
    let file = std::fs::read(path).unwrap();
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let start = file.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
    let head = std::str::from_utf8(&file[..start]).unwrap();
    let tag = head.lines().find(|line| line.contains(&format!("Name=\"{name}\""))).unwrap();
    let offset = tag.split("offset=\"").nth(1).unwrap().split('"').next().unwrap();
    let at = start + offset.parse::<usize>().unwrap();
    let count = u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
    file[at + 8..at + 8 + count].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
}

fn points(path: &Path) -> Vec<Vec3> {
    array(path, "Points").chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2])).collect()
}

fn bytes(path: PathBuf) -> f64 {
    std::fs::metadata(path).unwrap().len() as f64
}

fn check(nodes: usize) {
    let scene = scene(nodes);
    let (observation, rods) = state(&scene);
    let count = rods[0].positions.len();
    assert!(count.abs_diff(nodes) < 3 && observation.num_sites == observation.sites.len());
    assert!(observation.num_sites > nodes / 300, "{} sites", observation.num_sites);
    let link = observation.links[0];
    assert!((link.link - link.excess_link).abs() < 1e-9 && link.link < -(count as f64) / 50.0, "{link:?}");

    let dir = record(&scene, OutputChoice::default(), &observation, &rods, "full");
    let per_node = |name: &str| bytes(dir.join(name)) / count as f64;
    assert!(points(&dir.join("step_0001.vtp")) == rods[0].positions);
    assert!(array(&dir.join("step_0000.vtp"), "curvature") == rods[0].fields.curvature);
    assert!(per_node("step_0000.vtp") < 240.0, "{} bytes a node", per_node("step_0000.vtp"));
    let read = read_state(&dir.join("final_state.csv")).unwrap();
    assert!(read[0].positions == rods[0].positions && read[0].frames == rods[0].frames);
    assert!(per_node("final_state.csv") < 200.0, "{} bytes a node", per_node("final_state.csv"));

    // sites: counted and the strongest listed in the summary, all in their own file
    let text = std::fs::read_to_string(dir.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    // a hundred sites of 1.2 kilobytes, forces and moments on both strands, in each of three lists
    assert!(text.len() < 380_000, "{} bytes whatever the number of nodes", text.len());
    assert_eq!(summary["final"]["num_sites"], observation.num_sites);
    let listed = summary["final"]["sites"].as_array().unwrap();
    assert_eq!(listed.len(), MAX_SITES);
    let weakest = listed.iter().map(|site| site["force"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
    assert_eq!(observation.sites.iter().filter(|site| site.force > weakest).count(), MAX_SITES - 1);
    let sites = std::fs::read_to_string(dir.join("sites.csv")).unwrap();
    assert_eq!(sites.lines().count(), observation.num_sites + 1);
    for name in ["picture.png", "filmstrip.png"] {
        let picture = image::open(dir.join(name)).unwrap().to_rgb8();
        let drawn = picture.pixels().filter(|pixel| pixel.0[0] < 200).count();
        assert!(drawn > 300, "{name}: a rod far longer than thick is still seen: {drawn} pixels");
        assert!(bytes(dir.join(name)) < 4e6);
    }
    // two steps of at most 300 000 nodes, 48 bytes each as text, and the page itself
    assert!(bytes(dir.join("view.html")) < 96.0 * (count as f64).min(300_000.0) + 150e3);
    std::fs::remove_dir_all(&dir).unwrap();

    // level of detail
    let choice = OutputChoice { node_every: 10, picture: false, ..OutputChoice::default() };
    let dir = record(&scene, choice, &observation, &rods, "stride");
    let kept: Vec<Vec3> = rods[0].positions.iter().step_by(10).copied().collect();
    assert!(points(&dir.join("step_0000.vtp")) == kept);
    std::fs::remove_dir_all(&dir).unwrap();
    let choice = OutputChoice { node_tolerance: Some(0.1), node_every: 50, picture: false, ..OutputChoice::default() };
    let dir = record(&scene, choice, &observation, &rods, "tolerance");
    let kept = points(&dir.join("step_0000.vtp")).len();
    assert!(kept < count / 2 && kept > count / 50, "{kept} of {count}");
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn a_hundred_thousand_nodes() {
    check(99_999);
}

/// Prints how long the parts take; run with `--ignored --nocapture`.
#[test]
#[ignore = "slow: a million nodes, measures time"]
fn a_million_nodes() {
    for nodes in [9_999, 99_999, 999_999] {
        check(nodes);
    }
}

/// The run itself keeps a record that another can take up.
#[test]
fn the_record_of_a_long_rod_stays_small() {
    let scene = scene(30_000);
    let (observation, rods) = state(&scene);
    let dir = std::env::temp_dir().join(format!("supercoil_long_{}_state", std::process::id()));
    let output = OutputChoice { vtk: false, ..OutputChoice::default() };
    let mut record = Record::new(&Scene { output, ..scene }, &dir).unwrap();
    let count = 40;
    for step in 0..count {
        record.push(Observation { step, ..observation.clone() }, rods.clone()).unwrap();
    }
    let size = serde_json::to_vec(&record.state()).unwrap().len();
    assert!(size < count * 1_000_000, "{size} bytes for {count} steps: sites and film are bounded");
    std::fs::remove_dir_all(&dir).unwrap();
}
