//! The tasks of users of five kinds, each done as they would: a scene file, the command line, the files of the run.
//! What single features do is tested elsewhere; here, that they can be had from a scene.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::Path;

use supercoil::io::run::run_scene;
use supercoil::scene::Scene;

use crate::program::{folder, number, run, supercoil, table};

type Rows = Vec<std::collections::BTreeMap<String, String>>;

/// Runs a scene that must converge; the rows of its table.
fn rows(dir: &Path, scene: &str) -> Rows {
    let (code, printed, error) = run(dir, scene);
    assert_eq!(code, 0, "{printed}{error}");
    table(&dir.join("out/table.csv")).1
}

/// The like, in a folder of its own that goes again.
fn rows_of(name: &str, scene: &str) -> Rows {
    let dir = folder(name);
    let rows = rows(&dir, scene);
    std::fs::remove_dir_all(&dir).unwrap();
    rows
}

/// A rod of length 1 clamped at both ends, `more` among its keys, then `stages`.
fn clamped(more: &str, stages: &str) -> String {
    format!(
        "[[rods]]\nshape = {{ kind = \"line\", length = 1.0 }}\n\
         section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.005 }}\n\
         {more}\n\
         [[supports]]\nat = \"start\"\nposition = true\nrotation = true\n\
         [[supports]]\nat = \"end\"\nposition = true\nrotation = true\n{stages}\n\
         [output]\nvtk = false\npicture = false\n"
    )
}

/// Single molecules: a rod with 15 turns by nature between clamps starts at rest, and is turned from there.
#[test]
fn a_rod_twisted_by_nature_is_turned_from_relaxed() {
    let natural = "natural = { curvature = [0.0, 0.0], twist = 94.24777960769379 }\nelements = 90";
    let turn = "[[stages]]\nramp = { rotation = { at = \"end\", axis = [1, 0, 0], turns = 1.0 } }\nsteps = 4";
    let rows = rows_of("natural", &clamped(natural, turn));
    assert!(number(&rows[0], "total_energy") < 1e-9 && number(&rows[0], "excess_twist").abs() < 1e-5, "{:?}", rows[0]);
    assert!((number(&rows[0], "twist") - 15.0).abs() < 1e-5 && number(&rows[0], "end_torque").abs() < 1e-4);
    for row in &rows {
        let turned = number(row, "end_turned");
        assert!((number(row, "excess_twist") - turned).abs() < 1e-5, "straight as long as it is stable");
        assert!((number(row, "link") - 15.0 - turned).abs() < 1e-9 && number(row, "writhe").abs() < 1e-5);
        assert!((number(row, "end_torque") - TAU * turned).abs() < 1e-4);
    }
    assert_eq!(rows.iter().map(|row| number(row, "end_turned")).collect::<Vec<_>>(), [0.0, 0.25, 0.5, 0.75, 1.0]);
}

/// An open rod begins with the twist it is given; buckled out of its plane its link goes over into writhe.
#[test]
fn an_open_rod_has_link_twist_and_writhe() {
    let pushed = "[[stages]]\nramp = { displacement = { at = \"end\", to = [-0.3, 0, 0] } }\nsteps = 6";
    let rows = rows_of("open", &clamped("twist = 1.3\nelements = 16", pushed));
    assert!((number(&rows[0], "twist") - 1.3).abs() < 1e-7 && number(&rows[0], "writhe").abs() < 1e-7);
    let told = |name: &str| rows.iter().map(|row| row[name].as_str()).collect::<Vec<_>>();
    assert_eq!(told("end_displaced_x"), ["0.0", "-0.05", "-0.1", "-0.15", "-0.2", "-0.25", "-0.3"], "a grid");
    let last = rows.last().unwrap();
    assert!((number(last, "extension") - 0.7).abs() < 1e-9);
    assert!((number(last, "link") - 1.3).abs() < 1e-3, "{last:?}");
    assert!((number(last, "link") - number(last, "twist") - number(last, "writhe")).abs() < 1e-9);
    assert!(number(last, "writhe") > 0.1, "{last:?}");
}

/// Protein loops: an end goes to a pose, absolute or relative, straight or on a screw, with whole turns on top.
#[test]
fn an_end_goes_to_a_pose() {
    let stage = |pose: &str| {
        clamped("elements = 12", &format!("[[stages]]\nramp = {{ pose = {{ at = \"end\", {pose} }} }}\nsteps = 8"))
    };
    let last = |name: &str, pose: &str| rows_of(name, &stage(pose)).pop().unwrap();
    let place =
        |row: &std::collections::BTreeMap<String, String>| ["end_x", "end_y", "end_z"].map(|name| number(row, name));
    let there = |row: &std::collections::BTreeMap<String, String>| {
        assert!(place(row).iter().zip([0.6, 0.3, 0.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{row:?}");
        number(row, "total_energy")
    };
    let absolute = there(&last("pose", "position = [0.6, 0.3, 0.0]"));
    let relative = there(&last("pose_relative", "relative = true, position = [-0.4, 0.3, 0.0]"));
    assert!((absolute / relative - 1.0).abs() < 1e-9, "one place, one equilibrium: {absolute} {relative}");
    // the tangent, d3, along y
    let turn = "matrix = [[0, -1, 0], [0, 0, 1], [-1, 0, 0]]";
    there(&last("pose_screw", &format!("position = [0.6, 0.3, 0.0], {turn}, path = \"screw\"")));
    there(&last("pose_axis", "relative = true, position = [-0.4, 0.3, 0.0], axis_angle = [0, 0, 1, 0.25]"));
    let turned = last("pose_turned", "extra_turns = 1");
    assert!((number(&turned, "link") - 1.0).abs() < 1e-9 && (number(&turned, "excess_twist") - 1.0).abs() < 1e-6);
    assert_eq!(turned["end_extra_turns"], "1.0");
}

/// Supports let go and hold again between stages.
#[test]
fn supports_change_between_stages() {
    let stages = "[[stages]]\nramp = { displacement = { at = \"end\", to = [-0.05, 0.2, 0] } }\nsteps = 2\n\
                  [[stages]]\nrelease = [{ at = \"end\", position = true, rotation = true }]\nsteps = 1\n\
                  [[stages]]\nhold = [{ at = \"end\", position = true }]\n\
                  ramp = { displacement = { at = \"end\", to = [-0.05, 0.3, 0] } }\nsteps = 1";
    let rows = rows_of("release", &clamped("elements = 8", stages));
    assert!(
        number(&rows[2], "total_energy") > 0.1 && number(&rows[3], "total_energy") < 1e-9,
        "let go, it is straight"
    );
    assert!(number(&rows[4], "end_force_y") > 0.1 && number(&rows[4], "total_energy") > 0.01, "{:?}", rows[4]);
}

/// DNA in its own words, and its energies in kT.
#[test]
fn dna_is_given_by_base_pairs_salt_and_sigma() {
    let scene = "temperature = 310.0\n[[rods]]\nclosed = true\nshape = { kind = \"circle\" }\n\
                 dna = { base_pairs = 336, salt_mM = 150, helical_repeat = 10.5 }\nelements = 24\n\
                 [[stages]]\nramp = { sigma = { to = -0.03 } }\nsteps = 2\n[output]\nvtk = false\npicture = false\n";
    let rows = rows_of("dna", scene);
    let last = rows.last().unwrap();
    assert!((number(last, "sigma") + 0.03).abs() < 1e-12 && (number(last, "excess_link") + 0.96).abs() < 1e-12);
    let ratio = number(last, "total_energy") / number(last, "total_energy_kT");
    assert!((ratio - 310.0 * 0.0138065).abs() < 1e-4, "{ratio}");
}

/// `excess_link` counts beyond nature, `link` in all.
#[test]
fn link_is_counted_beyond_nature_or_in_all() {
    let ring = |ramp: &str| {
        format!(
            "[[rods]]\nclosed = true\nshape = {{ kind = \"circle\", length = 1.0 }}\n\
             section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }}\n\
             natural = {{ curvature = [0.0, 0.0], twist = 50.26548245743669 }}\nelements = 48\n\
             [[stages]]\nramp = {{ {ramp} }}\nsteps = 2\n[output]\nvtk = false\npicture = false\n"
        )
    };
    let energies = ["excess_link = { to = -0.5 }", "link = { to = 7.5 }"].map(|ramp| {
        let last = rows_of("link", &ring(ramp)).pop().unwrap();
        assert!((number(&last, "excess_link") + 0.5).abs() < 1e-12 && (number(&last, "link") - 7.5).abs() < 1e-9);
        number(&last, "total_energy")
    });
    let exact = 0.5 * TAU * TAU * (1.0 + 0.25);
    assert!(energies[0] == energies[1] && (energies[0] / exact - 1.0).abs() < 1e-3, "{energies:?} {exact}");
}

/// Numbers of the section, length and natural curvature are ramped together and apart.
#[test]
fn quantities_are_ramped() {
    let scene = "[[rods]]\nclosed = true\nshape = { kind = \"circle\", length = 1.0 }\n\
                 section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 \
                 }\nelements = 24\n\
                 [[stages]]\nramp = { length = { to = 2.0 }, section = { contact_radius = 0.02, bending = 2.0 } }\n\
                 steps = 2\n\
                 [[stages]]\nramp = { natural = { curvature = [3.141592653589793, 0.0] } }\nsteps = 1\n\
                 [output]\nvtk = false\npicture = false\n";
    let rows = rows_of("ramps", scene);
    let middle = &rows[1];
    assert_eq!(
        [number(middle, "length"), number(middle, "contact_radius"), number(middle, "bending_1")],
        [1.5, 0.015, 1.5]
    );
    // ½ EI (2π/L)² L
    assert!((number(&rows[2], "bending_energy") / (0.5 * 2.0 * TAU * TAU / 2.0) - 1.0).abs() < 1e-3);
    assert!(number(&rows[3], "total_energy") < 1e-3, "a ring by nature: {:?}", rows[3]);
}

/// Knots: points of any number of columns, closed by a repeated point or not; noise is smoothed, and what link the rod
/// begins with is said.
#[test]
fn measured_points_are_imported_smoothed_and_their_link_told() {
    let dir = folder("import");
    let trefoil = |i: usize| {
        let t = TAU * i as f64 / 300.0;
        [t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos(), -(3.0 * t).sin()]
    };
    let mut text = String::from("index,px,py,pz,charge\n");
    for i in 0..=300 {
        // fine noise that repeats, the first point again at the end
        let noise = 0.02 * ((7919 * (i % 300)) % 13) as f64 / 13.0;
        let [x, y, z] = trefoil(i);
        writeln!(text, "{i},{},{},{},0", 10.0 * (x + noise), 10.0 * (y - noise), 10.0 * (z + noise)).unwrap();
    }
    std::fs::write(dir.join("knot.csv"), text).unwrap();
    let scene = |shape: &str, rod: &str| {
        format!(
            "[[rods]]\nname = \"knot\"\nclosed = true\nelements = 60\n\
             shape = {{ kind = \"points\", file = \"knot.csv\", columns = [\"px\", \"py\", \"pz\"], scale = \
             0.1{shape} }}\n\
             section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.1 }}\n\
             {rod}\n\
             [output]\nvtk = false\npicture = false\n"
        )
    };
    let file = dir.join("knot.toml");
    let check = |text: &str| {
        std::fs::write(&file, text).unwrap();
        let out = supercoil(&["check", file.to_str().unwrap()]);
        (
            out.status.success(),
            String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr),
        )
    };
    let length = |text: &str| -> f64 {
        let (ok, printed) = check(text);
        assert!(ok, "{printed}");
        printed.split("closed, length ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()
    };
    let exact: f64 = (0..300)
        .map(|i| {
            let (a, b) = (trefoil(i), trefoil(i + 1));
            (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
        })
        .sum();
    let (rough, smooth) = (length(&scene("", "")), length(&scene(", smooth = 0.25", "")));
    assert!(rough > 1.005 * exact && (smooth / exact - 1.0).abs() < 2e-3, "{rough} {smooth} {exact}");
    let (_, told) = check(&scene(", smooth = 0.25", ""));
    assert!(
        told.contains("note: rod \"knot\" begins with an excess link of ") && told.contains("excess_link = 0"),
        "{told}"
    );
    let (_, told) = check(&scene(", smooth = 0.25", "excess_link = 0.0"));
    assert!(!told.contains("note:"), "{told}");
    let (ok, told) = check(&scene(", smooth = 1e3", ""));
    assert!(!ok && told.contains("at most 100 mean distances"), "{told}");
    let rows = rows(&dir, &scene(", smooth = 0.25", "excess_link = 0.0"));
    assert_eq!((rows[0]["knot"].as_str(), number(&rows[0], "excess_link")), ("3_1*", 0.0));
    std::fs::remove_dir_all(&dir).unwrap();
}

/// A run starts from what another has ended with, on the same elements or others.
#[test]
fn a_run_starts_from_the_end_of_another() {
    let dir = folder("start_from");
    let bent = clamped(
        "elements = 12",
        "[[stages]]\nramp = { displacement = { at = \"end\", to = [-0.2, 0.1, 0] } }\nsteps = 4",
    );
    let before = rows(&dir, &bent).pop().unwrap();
    std::fs::rename(dir.join("out"), dir.join("first")).unwrap();
    for elements in ["", "elements = 20"] {
        let again = clamped(elements, "").replace(
            "shape = { kind = \"line\", length = 1.0 }",
            "shape = { kind = \"state\", file = \"first/final_state.csv\" }",
        );
        let after = rows(&dir, &again).pop().unwrap();
        let ratio = number(&after, "total_energy") / number(&before, "total_energy");
        assert!((ratio - 1.0).abs() < 1e-4, "{elements}: {ratio}");
        std::fs::remove_dir_all(dir.join("out")).unwrap();
    }
    // or from the checkpoint of one that was stopped
    let _ = run_scene(Scene::from_toml(&bent, &dir).unwrap(), &dir.join("stopped"), &mut |step| match step.step {
        2 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    })
    .unwrap();
    let from = |file: &str| {
        let shape = format!("shape = {{ kind = \"state\", file = \"stopped/{file}\" }}");
        let scene = clamped("elements = 20", "").replace("shape = { kind = \"line\", length = 1.0 }", &shape);
        let rows = rows(&dir, &scene);
        std::fs::remove_dir_all(dir.join("out")).unwrap();
        number(&rows[0], "total_energy")
    };
    let energy = from("checkpoint.bin");
    assert_eq!(energy, from("final_state.csv"));
    assert!(energy > 0.1 * number(&before, "total_energy"), "{energy}");
    let whole = std::fs::read(dir.join("stopped/checkpoint.bin")).unwrap();
    std::fs::write(dir.join("stopped/checkpoint.bin"), &whole[..200]).unwrap();
    let shape = "shape = { kind = \"state\", file = \"stopped/checkpoint.bin\" }";
    let (code, _, error) = run(&dir, &clamped("", "").replace("shape = { kind = \"line\", length = 1.0 }", shape));
    assert!(code == 2 && error.contains("is a checkpoint that is cut short"), "{error}");
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Values that were asked for are met after steps were halved: the grid stays a grid.
#[test]
fn the_grid_is_met_after_a_step_was_halved() {
    let turn = "[[stages]]\nramp = { rotation = { at = \"end\", axis = [1, 0, 0], turns = 3.0 } }\nsteps = 3\n\
        [solver]\nmax_iterations = 4";
    let dir = folder("grid");
    let (_, printed, error) = run(&dir, &clamped("elements = 24", turn));
    let (_, rows) = table(&dir.join("out/table.csv"));
    let turned: Vec<f64> = rows.iter().map(|row| number(row, "end_turned")).collect();
    assert!(turned.len() > 4, "no step was halved: {turned:?} {printed}{error}");
    for wanted in [1.0, 2.0, 3.0] {
        assert!(turned.contains(&wanted) || wanted > *turned.last().unwrap(), "{wanted} of {turned:?}");
    }
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Sweepers: values from the command line, folders that say what they are, columns of one name in table, print and
/// page.
#[test]
fn a_quantity_has_one_name() {
    let dir = folder("names");
    let scene = clamped(
        "elements = 8",
        "[[stages]]\nramp = { displacement = { at = \"end\", to = [-0.05, 0.1, 0] } }\nsteps = 2",
    );
    let (code, printed, error) = run(&dir, &scene.replace("vtk = false\n", ""));
    assert_eq!(code, 0, "{error}");
    let head: Vec<&str> =
        printed.lines().filter(|line| line.contains("step") || line.contains("bending_")).take(2).collect();
    // names over two lines, each ending where its column does
    let [first, second] = head[..] else { panic!("{printed}") };
    let mut names = Vec::new();
    for end in (1..=second.len()).filter(|&end| end == second.len() || second.as_bytes()[end] == b' ') {
        let last_word = |line: &str| line[..end.min(line.len())].rsplit(' ').next().unwrap_or_default().to_owned();
        let name = last_word(first) + &last_word(second);
        if !name.is_empty() && second.as_bytes()[end - 1] != b' ' {
            names.push(name);
        }
    }
    let known = [
        "step",
        "link",
        "writhe",
        "twist",
        "bending_energy",
        "twisting_energy",
        "stretching_energy",
        "shearing_energy",
    ];
    assert_eq!(names[..8], known, "{printed}");
    assert_eq!(names[8..], ["min_gap", "num_sites", "contact_force", "num_unstable", "iterations"], "{printed}");
    let (columns, _) = table(&dir.join("out/table.csv"));
    assert!(names.iter().all(|name| columns.contains(name)), "{columns:?}");
    let page = std::fs::read_to_string(dir.join("out/view.html")).unwrap();
    for name in ["bending_energy", "stretching_energy", "total_energy", "iterations"] {
        assert!(page.contains(&format!("\"name\":\"{name}\"")) && columns.iter().any(|it| it == name), "{name}");
    }
    let summary = std::fs::read_to_string(dir.join("out/summary.json")).unwrap();
    assert!(summary.contains("\"bending\":") && summary.contains("\"stretching\":") && !summary.contains("\"bend\":"));
    std::fs::remove_dir_all(&dir).unwrap();
}

/// What cannot be seen beside the rest is printed as zero.
#[test]
fn zero_is_printed_as_zero() {
    let dir = folder("zero");
    let scene = clamped(
        "elements = 8",
        "[[stages]]\nramp = { rotation = { at = \"end\", axis = [1, 0, 0], turns = 0.5 } }\nsteps = 1",
    );
    let (code, printed, error) = run(&dir, &scene);
    assert_eq!(code, 0, "{error}");
    let cells = |step: &str| -> Vec<&str> {
        printed.lines().find(|line| line.trim_start().starts_with(step)).unwrap().split_whitespace().collect()
    };
    assert_eq!(cells("0 ")[4..8], ["0.0000"; 4], "{printed}");
    let last = cells("1 ");
    assert_eq!([last[4], last[6], last[7]], ["0.0000"; 3], "{printed}");
    assert!(!printed.contains("see notes"));
    std::fs::remove_dir_all(&dir).unwrap();
}

/// A terminal of 40 columns: the table in blocks that fit, each with the numbers of the steps.
#[test]
fn narrow_terminals_are_not_overrun() {
    let dir = folder("narrow");
    let file = dir.join("scene.toml");
    let stage = "[[stages]]\nramp = { displacement = { at = \"end\", to = [-0.05, 0.1, 0] } }\nsteps = 2";
    std::fs::write(&file, clamped("elements = 8", stage)).unwrap();
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_supercoil"))
        .args(["run", "scene.toml", "--out", "out"])
        .current_dir(&dir)
        .env("COLUMNS", "40")
        .output()
        .unwrap();
    let printed = String::from_utf8(run.stdout).unwrap();
    assert!(run.status.success(), "{printed}");
    let (table, _) = printed.split_once("\n\nall ").unwrap();
    // notes below the table are as long as they are
    let is_note = |line: &&str| line.starts_with("* ");
    let lines = || table.lines().skip_while(|line| !line.contains("step")).take_while(|line| !is_note(line));
    assert!(lines().all(|line| line.chars().count() <= 40), "{printed}");
    for name in ["writhe", "bending_", "iterations"] {
        assert!(table.contains(name), "{printed}");
    }
    assert!(lines().filter(|line| line.trim_start().starts_with("2 ")).count() >= 4, "{printed}");
    std::fs::remove_dir_all(&dir).unwrap();
}

/// The minicircle with the finest preset, at every step, whatever their size: apart, a point, which is long for a
/// moment as it opens into two; three points, of which the middle one becomes a line.
#[test]
fn a_supercoiled_ring_touches_along_a_line_between_two_points() {
    const ORDER: [&[&str]; 6] =
        [&[], &["point"], &["line"], &["point", "point"], &["point", "point", "point"], &["point", "line", "point"]];
    for steps in [27, 30, 36] {
        let scene = format!(
            "fidelity = \"reference\"\n[[rods]]\nclosed = true\nshape = {{ kind = \"circle\", length = 114.24 }}\n\
             section = {{ bending = 205.7, twisting = 308.6, stretching = 1100.0, shearing = 1100.0, contact_radius = \
             2.5 }}\n\
             [[stages]]\nramp = {{ excess_link = {{ to = -3.0 }} }}\nsteps = {steps}\n[output]\nvtk = false\n\
             picture = false\n"
        );
        let dir = folder("ring");
        rows(&dir, &scene);
        let summary: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(dir.join("out/summary.json")).unwrap()).unwrap();
        let kinds = |step: &serde_json::Value| -> Vec<String> {
            let mut sites: Vec<_> = step["sites"].as_array().unwrap().iter().collect();
            let start = |site: &serde_json::Value| site["arc_a"][0].as_f64().unwrap();
            sites.sort_by(|x, y| start(x).total_cmp(&start(y)));
            sites.iter().map(|site| site["kind"].as_str().unwrap().to_owned()).collect()
        };
        let steps: Vec<_> = summary["steps"].as_array().unwrap().iter().map(kinds).collect();
        let stage = |kinds: &Vec<String>| ORDER.iter().position(|order| *order == kinds.as_slice());
        let stages: Vec<_> = steps.iter().map(stage).collect();
        assert!(stages.iter().all(Option::is_some) && stages.is_sorted(), "{steps:?}");
        assert!(stages.iter().filter(|stage| **stage == Some(ORDER.len() - 1)).count() >= 7, "{steps:?}");
        assert!(stages.iter().filter(|stage| **stage == Some(2)).count() <= 1, "{steps:?}");
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
