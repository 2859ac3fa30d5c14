//! What VTK files tell of a step. VTK itself reads such files in `python/tests/test_paraview.py`.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use supercoil::io::vtk::{VtkData, read_vtp};
use supercoil::math::Vec3;

use crate::program::{folder, number, run, table};

const CANTILEVER: &str = r#"
units = { length = "m", force = "N" }
[[rods]]
name = "beam"
shape = { kind = "line", length = 1.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }
elements = 8
[[supports]]
at = "start"
position = true
rotation = true
[[loads]]
at = "end"
force = [0.0, -1.0, 0.0]
[[stages]]
ramp = { load = 1.0, section = { contact_radius = 0.03 } }
steps = 2
[output]
picture = false
"#;

/// Names of the arrays of a file, as VTK would find them; text is its own.
fn names(file: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(file);
    let tags = text.lines().filter(|line| line.starts_with("<DataArray ") || line.starts_with("<Array "));
    tags.map(|tag| tag.split("Name=\"").nth(1).unwrap().split('"').next().unwrap().to_owned()).collect()
}

fn sum(vectors: &[Vec3]) -> Vec3 {
    vectors.iter().sum()
}

#[test]
fn files_tell_radius_arc_and_what_the_rod_bears() {
    let dir = folder("paraview");
    let (code, _, error) = run(&dir, CANTILEVER);
    assert_eq!(code, 0, "{error}");
    let out = dir.join("out");
    let (_, rows) = table(&out.join("table.csv"));
    for (step, radius) in [0.01, 0.02, 0.03].into_iter().enumerate() {
        let path = out.join(format!("step_{step:04}.vtp"));
        let file = std::fs::read(&path).unwrap();
        let [rod]: [VtkData; 1] = read_vtp(&path).unwrap().try_into().unwrap();
        assert!(rod.scalars["radius"].iter().all(|r| (r - radius).abs() < 1e-15), "{step}");
        let arcs = &rod.scalars["arc_length"];
        assert!(arcs[0] == 0.0 && (arcs[24] - 1.0).abs() < 1e-15 && (arcs[1] - 1.0 / 24.0).abs() < 1e-15);
        // the load, all along; its moment about the node, EI κ
        let load = 0.5 * step as f64;
        let (force, moment) = (&rod.vectors["internal_force"], &rod.vectors["internal_moment"]);
        for i in 0..25 {
            assert!((force[i] + load * Vec3::y()).norm() < 1e-4, "{i} {:?}", force[i]);
            let expected = (rod.points[24] - rod.points[i]).cross(&(-load * Vec3::y()));
            assert!((moment[i] - expected).norm() < 1e-4, "{i} {:?} {expected:?}", moment[i]);
            assert!((moment[i].norm() - rod.scalars["curvature"][i]).abs() < 1e-4);
        }
        // what the support does to the rod is opposite to what the rod does there
        let reaction = number(&rows[step], "start_force_y");
        assert!(
            (reaction + force[0].y).abs() < 1e-4 && (number(&rows[step], "start_moment_z") + moment[0].z).abs() < 1e-4
        );
        let mut names = names(&file);
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count, "a name twice: {names:?}");
        for name in ["TimeValue", "load", "total_energy", "units", "smoothed_contact_force_per_length", "twist_rate"] {
            assert!(names.iter().any(|found| found == name), "{name} of {names:?}");
        }
        let text = String::from_utf8_lossy(&file);
        for unit in ["TimeValue: load", "arc_length: m", "internal_moment: N m", "total_energy: N m", "radius: m"] {
            assert!(text.contains(&format!("{unit}\0")), "{unit}");
        }
    }
    // and each step is drawn with its own radius
    let page = std::fs::read_to_string(out.join("view.html")).unwrap();
    let radii = page.split("\"radii\":[[").skip(1).map(|rest| rest.split(']').next().unwrap().parse().unwrap());
    let radii: Vec<f64> = radii.collect();
    assert!(radii.len() == 3 && radii.iter().zip([0.01, 0.02, 0.03]).all(|(a, b)| (a - b).abs() < 1e-15), "{radii:?}");
    std::fs::remove_dir_all(&dir).unwrap();
}

const CROSSED: &str = r#"
[[rods]]
name = "below"
shape = { kind = "line", start = [-1.0, 0.0, 0.0], length = 2.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.05 }
elements = 8
[[rods]]
name = "above"
shape = { kind = "line", start = [0.0, -1.0, 0.12], direction = [0, 1, 0], length = 2.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.05 }
elements = 8
[[supports]]
rod = ["below", "above"]
at = "start"
position = true
rotation = true
[[supports]]
rod = ["below", "above"]
at = "end"
position = true
rotation = true
[[stages]]
ramp = { displacement = [
    { rod = "above", at = "start", to = [0, 0, -0.1] },
    { rod = "above", at = "end", to = [0, 0, -0.1] },
] }
steps = 2
[output]
picture = false
"#;

/// Forces on nodes add up to the contact force; time is the first quantity that is ramped.
#[test]
fn contact_forces_add_up() {
    let dir = folder("paraview_contact");
    let (code, _, error) = run(&dir, CROSSED);
    assert_eq!(code, 0, "{error}");
    let (_, rows) = table(&dir.join("out/table.csv"));
    let rods = read_vtp(&dir.join("out/step_0002.vtp")).unwrap();
    let told = number(&rows[2], "contact_resultants");
    let on = rods.iter().map(|rod| sum(&rod.vectors["contact_force_on_node"])).collect::<Vec<_>>();
    assert!(told > 1.0 && (on[0] + told * Vec3::z()).norm() < 1e-6 * told, "{told} {on:?}");
    assert!((on[0] + on[1]).norm() < 1e-9 * told);
    let per_length = &rods[0].vectors["smoothed_contact_force_per_length"];
    assert!((sum(per_length) * (2.0 / 24.0) - on[0]).norm() < 1e-9 * told, "no force at the ends");
    let text = String::from_utf8_lossy(&std::fs::read(dir.join("out/step_0002.vtp")).unwrap()).into_owned();
    assert!(text.contains("TimeValue: above_start_displaced_z\0"));
    std::fs::remove_dir_all(&dir).unwrap();
}
