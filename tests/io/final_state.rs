//! What is written of a final state: stress resultants, plots along the rods, a surface for printers.

use std::path::Path;

use supercoil::io::view::{MAX_NODES, of_run};
use supercoil::math::{Quat, Vec3};

use crate::program::{folder, number, run, supercoil, table};

const CANTILEVERS: &str = r#"
units = { length = "mm", force = "N" }
[[rods]]
name = "a"
shape = { kind = "line", start = [0.0, 0.0, 0.0], direction = [1.0, 2.0, 0.5], length = 2.0 }
section = { bending = [1.0, 3.0], twisting = 0.8, stretching = 1e4, shearing = 1e4, contact_radius = 0.05 }
elements = 12
[[rods]]
name = "b"
shape = { kind = "line", start = [5.0, 0.0, 0.0], direction = [0.0, 0.0, 1.0], length = 1.0 }
section = { bending = 1.0, twisting = 0.8, stretching = 1e4, shearing = 1e4, contact_radius = 0.05 }
elements = 6
[[supports]]
rod = "a"
at = "start"
position = true
rotation = true
[[supports]]
rod = "b"
at = "start"
position = true
rotation = true
[[loads]]
rod = "a"
at = "end"
force = [0.3, -0.4, 0.7]
[[stages]]
ramp = { load = 1.0 }
steps = 2
[output]
view = true
"#;

fn text(out: &std::process::Output) -> String {
    String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr)
}

/// Tension and shear turned into space are the load at its end, at every node; moments are the lever times the load. A
/// rod without load has none.
#[test]
fn resultants_balance_the_load() {
    let dir = folder("resultants");
    let (code, _, error) = run(&dir, CANTILEVERS);
    assert_eq!(code, 0, "{error}");
    let out = dir.join("out");
    let (_, state) = table(&out.join("final_state.csv"));
    let (_, rows) = table(&out.join("resultants.csv"));
    assert_eq!(rows.len(), state.len());
    let place = |row: usize| Vec3::new(number(&state[row], "x"), number(&state[row], "y"), number(&state[row], "z"));
    let (load, tip) = (Vec3::new(0.3, -0.4, 0.7), place(36));
    for (k, (row, at)) in rows.iter().zip(&state).enumerate() {
        assert_eq!(number(row, "arc_length"), number(at, "arc_length"));
        let frame = Quat::new_normalize(nalgebra::Quaternion::new(
            number(at, "qw"),
            number(at, "qx"),
            number(at, "qy"),
            number(at, "qz"),
        ));
        let in_space = |names: [&str; 3]| frame * Vec3::from(names.map(|name| number(row, name)));
        let force = in_space(["shear_1", "shear_2", "tension"]);
        let moment = in_space(["moment_1", "moment_2", "torque"]);
        let is_loaded = row["rod"] == "a";
        let (n, m) = if is_loaded { (load, (tip - place(k)).cross(&load)) } else { (Vec3::zeros(), Vec3::zeros()) };
        assert!((force - n).norm() < 1e-3 && (moment - m).norm() < 1e-3, "node {k}: {force:?} {n:?}, {moment:?} {m:?}");
    }
    plots_and_surface(&out);
    page_of_open_rods(&out);
    std::fs::remove_dir_all(&dir).unwrap();
}

fn plots_and_surface(out: &Path) {
    let place = out.to_str().unwrap();
    let plot =
        |words: &[&str]| supercoil(&[&["plot", place, "--of", "resultants", "--x", "arc_length"], words].concat());
    let drawn = plot(&["--rod", "a", "--y", "moment_1,moment_2,torque"]);
    assert!(drawn.status.success(), "{}", text(&drawn));
    let svg = std::fs::read_to_string(out.join("moment_1_moment_2_torque.svg")).unwrap();
    assert!(svg.contains("arc_length, mm") && svg.contains("torque"));
    let refused = plot(&["--rod", "c", "--y", "torque"]);
    assert!(refused.status.code() == Some(2) && text(&refused).contains("one of a, b"), "{}", text(&refused));
    let missing = supercoil(&["plot", place, "--of", "lines", "--x", "arc_a", "--y", "gap"]);
    assert!(missing.status.code() == Some(2) && text(&missing).contains("lines.csv"), "{}", text(&missing));

    let file = out.join("rods.stl");
    let written = supercoil(&["view", place, "--stl", file.to_str().unwrap()]);
    assert!(written.status.success(), "{}", text(&written));
    let bytes = std::fs::read(&file).unwrap();
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    assert_eq!(bytes.len(), 84 + 50 * count);
    assert!(bytes.starts_with(b"supercoil") && String::from_utf8_lossy(&bytes[..80]).contains("1 unit = 1 mm"));
    let corner = |at: usize| -> Vec3 {
        Vec3::from([0, 4, 8].map(|k| f64::from(f32::from_le_bytes(bytes[at + k..at + k + 4].try_into().unwrap()))))
    };
    let volume = |triangle: usize| {
        let [a, b, c] = [12, 24, 36].map(|k| corner(84 + 50 * triangle + k));
        a.dot(&b.cross(&c)) / 6.0
    };
    // two capsules of radius 0.05, 2 mm and 1 mm long
    let exact = std::f64::consts::PI * (0.0025 * 3.0 + 2.0 * 4.0 / 3.0 * 0.000_125);
    let volume: f64 = (0..count).map(volume).sum();
    assert!((volume / exact - 1.0).abs() < 0.03, "{volume} {exact}");
}

/// The page has the numbers of the table that change, and plots them against what the stages ramp.
fn page_of_open_rods(out: &Path) {
    let film = of_run(out, MAX_NODES).unwrap();
    let names: Vec<&str> = film.table.columns.iter().map(|(name, _)| name.as_str()).collect();
    let (columns, rows) = table(&out.join("table.csv"));
    for (k, name) in names.iter().enumerate() {
        let values: Vec<f64> = rows.iter().map(|row| row[*name].parse().unwrap_or(f64::NAN)).collect();
        let shown: Vec<f64> = film.table.rows.iter().map(|row| row[k]).collect();
        assert_eq!(format!("{values:?}"), format!("{shown:?}"), "{name}");
        assert!(*name == "step" || values.windows(2).any(|pair| pair[0] != pair[1]), "{name} never changes");
    }
    assert!(names.contains(&"a_extension") && !names.contains(&"b_extension"), "{names:?} of {columns:?}");
    let plotted: Vec<Vec<&str>> = film.plots.iter().map(|plot| plot.y.iter().map(|&y| names[y]).collect()).collect();
    assert!(film.plots.iter().all(|plot| names[plot.x] == "load"), "{names:?}");
    assert!(plotted.contains(&vec!["a_extension"]), "{plotted:?}");
}

/// Completions and manual know the commands.
#[test]
fn shells_and_man_know_the_commands() {
    let bash = supercoil(&["completions", "bash"]);
    assert!(bash.status.success() && text(&bash).contains("resume"), "{}", text(&bash));
    let dir = folder("manual");
    let made = supercoil(&["man", dir.to_str().unwrap()]);
    assert!(made.status.success(), "{}", text(&made));
    let page = std::fs::read_to_string(dir.join("supercoil-plot.1")).unwrap();
    assert!(page.contains("resultants"), "{page}");
    std::fs::remove_dir_all(&dir).unwrap();
}
