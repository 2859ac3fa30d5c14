//! A run's base pairs, from its folder.

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::dna::base_pairs::{BasePairs, Nodes};
use supercoil::io::export::base_pairs;
use supercoil::io::run::run_scene;
use supercoil::math::link::linking_number;
use supercoil::scene::{Import, Scene, read_points_with};
use supercoil::solve::Status;

const RING: &str = r#"
title = "minicircle of 336 base pairs"
units = { length = "nm", force = "pN" }
[[rods]]
closed = true
shape = { kind = "circle", length = 114.24 }
section = { bending = 205.7, twisting = 308.6, stretching = 1100, shearing = 1100.0, contact_radius = 2.5 }
elements = 24
[[stages]]
ramp = { excess_link = { to = -1.0 } }
steps = 1
[output]
vtk = false
picture = false
"#;

#[test]
fn a_run_is_exported_with_its_link() {
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join("export");
    std::fs::remove_dir_all(&dir).ok();
    let run = |text: &str, dir: &Path| {
        let scene = Scene::from_toml(text, Path::new("")).unwrap();
        let outcome = run_scene(scene, dir, &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(outcome.status, Status::Converged);
    };
    run(RING, &dir);
    let pairs = base_pairs(&dir, None, None).unwrap();
    assert_eq!((pairs.positions.len(), pairs.closed), (336, true));
    // 32 turns at rest
    let [a, b] = pairs.strands();
    assert_eq!(linking_number(&a, &b).round(), 31.0);
    let back = BasePairs::from_oxdna(&pairs.oxdna_configuration(), true).unwrap().strands();
    assert_eq!(linking_number(&back[0], &back[1]).round(), 31.0);
    let refused = base_pairs(&dir, Some("plasmid"), None).unwrap_err().to_string();
    assert_eq!(refused, "rod = \"plasmid\": must be one of \"rod\"");
    let other = dir.join("other_unit");
    run(&RING.replace("\"nm\"", "\"m\""), &other);
    let refused = base_pairs(&other, None, None).unwrap_err().to_string();
    assert!(refused.contains("units.length of the scene = \"m\": must be \"nm\""), "{refused}");
}

/// Files that are written are read as starts: with frames and link, and as points.
#[test]
fn what_is_exported_starts_another_run() {
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join("export_and_back");
    std::fs::create_dir_all(&dir).unwrap();
    let twisted = RING.replace("elements = 24", "elements = 24\nexcess_link = -2");
    let rod = &Scene::from_toml(&twisted, Path::new("")).unwrap().model.rods[0];
    let nodes =
        Nodes { positions: &rod.positions, frames: &rod.frames, order: 3, closed: Some(-2.0), turns_left_out: 0.0 };
    let pairs = BasePairs::along(&nodes, 336).unwrap();
    BasePairs::write(&dir.join("ring.dat"), pairs.oxdna_configuration()).unwrap();
    BasePairs::write(&dir.join("ring.npy"), pairs.npy()).unwrap();
    BasePairs::write(&dir.join("ref_frames.dat"), pairs.ref_frames()).unwrap();
    BasePairs::write(&dir.join("bp_step.par"), pairs.par()).unwrap();
    let start = |shape: &str, more: &str| {
        let circle = "shape = { kind = \"circle\", length = 114.24 }";
        let elements = if more.is_empty() { "elements = 24" } else { "elements = 112" };
        let scene = RING.replace(circle, &format!("shape = {{ {shape} }}\n{more}")).replace("elements = 24", elements);
        Scene::from_toml(&scene, &dir).unwrap().model.rods[0].clone()
    };
    for file in ["ring.dat", "ring.npy", "ref_frames.dat", "bp_step.par"] {
        // the axis alone, on elements of its own
        let back = start(&format!("kind = \"frames\", file = \"{file}\""), "");
        assert_eq!((back.num_elements, back.closed), (24, true));
        assert!((back.start_excess_link + 2.0).abs() < 1e-9, "{file}: {}", back.start_excess_link);
        let apart = (back.positions[36] - back.positions[0]).norm();
        assert!((apart - 114.24 / std::f64::consts::PI).abs() < 1e-3, "{file}: {apart}");
        // the double helix, a node a base pair
        let helix =
            start(&format!("kind = \"frames\", file = \"{file}\""), "natural = { curvature = [0, 0], twist = 1.76 }");
        assert!((helix.start_excess_link + helix.natural_link() - 30.0).abs() < 1e-9, "{file}");
    }
    BasePairs::write(&dir.join("ring.vect"), pairs.vect()).unwrap();
    BasePairs::write(&dir.join("ring.pdb"), pairs.pdb().unwrap()).unwrap();
    BasePairs::write(&dir.join("ring.xyz"), pairs.xyz()).unwrap();
    for (file, scale, places) in [
        ("ring.vect", 1.0, 1e-12),
        ("ring.xyz", 1.0, 1e-12),
        ("ring.pdb", 0.1, 1e-4),
        ("ring.npy", 1.0, 1e-12),
        ("ring.dat", 1.0, 1e-12),
    ] {
        let import = Import { scale, ..Import::default() };
        let points = read_points_with(&dir.join(file), &import).unwrap();
        assert_eq!(points.len(), 336);
        let off = points.iter().zip(&pairs.positions).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(off < places, "{file}: {off:e}");
    }
    std::fs::write(dir.join("bad.npy"), "no array").unwrap();
    let bad = RING.replace("kind = \"circle\", length = 114.24", "kind = \"frames\", file = \"bad.npy\"");
    let refused = Scene::from_toml(&bad, &dir).unwrap_err().to_string();
    assert!(refused.contains("bad.npy") && refused.contains("0 lines of three numbers"), "{refused}");
}
