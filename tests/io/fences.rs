//! What could hurt the machine, the terminal or other results: each was found by trying, each is refused in words.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use supercoil::InputError;
use supercoil::io::checkpoint::FILE_NAME;
use supercoil::io::run::{SceneRun, run_scene};
use supercoil::scene::{Scene, read_points};
use supercoil::solve::Status;

use crate::program::{self, folder};

const BEAM: &str = r#"
title = "beam"
units = { length = "m", force = "N" }
[[rods]]
name = "beam"
shape = { kind = "line", length = 1.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e3, shearing = 1e3, contact_radius = 0.01 }
elements = 2
[[supports]]
at = "start"
position = true
rotation = true
[[supports]]
at = "end"
rotation = true
[[stages]]
ramp = { rotation = { at = "end", axis = [1, 0, 0], turns = 0.1 } }
steps = 2
[output]
picture = false
"#;

fn scene_file(dir: &Path, text: &str) -> PathBuf {
    let file = dir.join("beam.toml");
    std::fs::write(&file, text).unwrap();
    file
}

/// The message with which a scene is refused after `from`, which must be there, was replaced by `to`.
fn refusal(from: &str, to: &str) -> String {
    assert!(BEAM.contains(from), "{from}");
    let read = Scene::from_toml(&BEAM.replacen(from, to, 1), Path::new(""));
    read.map_or_else(|error| error.to_string(), |_| format!("accepted: {to}"))
}

/// The program with words and paths.
fn supercoil(arguments: &[&dyn AsRef<std::ffi::OsStr>]) -> Output {
    program::supercoil(arguments)
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn go_on(_: &supercoil::observe::report::Observation) -> std::ops::ControlFlow<()> {
    std::ops::ControlFlow::Continue(())
}

/// Symptom: the program was ended without a word, by `check` too.
#[test]
fn more_elements_than_memory_are_refused_with_the_number() {
    let message = refusal("elements = 2", "elements = 1000000000");
    assert!(message.starts_with("rods.beam.elements: 1000000000 elements are too many"), "{message}");
    assert!(message.contains("3000000000 nodes take at least 19557.8 GiB, and"), "{message}");
}

/// A limit of the shell counts as well as the machine's memory.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_on_memory_is_heeded() {
    let dir = folder("memory");
    let check = |elements: &str, limit: &str| {
        let file = scene_file(&dir, &BEAM.replace("elements = 2", &format!("elements = {elements}")));
        let program = format!("ulimit -v {limit}; exec {} check {}", env!("CARGO_BIN_EXE_supercoil"), file.display());
        Command::new("sh").args(["-c", &program]).output().unwrap()
    };
    for (elements, limit, reason) in [
        ("100000", "1500000", "300000 nodes take at least 2.0 GiB, and 1.4 GiB are available"),
        ("1000000", "8388608", "3000000 nodes take at least 19.6 GiB, and "),
    ] {
        let output = check(elements, limit);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(reason), "{}", said(&output));
    }
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Symptom: wires 5000 nodes a diameter fine took 22 GB in `check`, until the system ended it. Mechanism: each element
/// is kept in a pair with each that lies beside it within a diameter.
#[cfg(target_os = "linux")]
#[test]
fn pairs_of_elements_are_counted() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes/cable.toml");
    let cable = std::fs::read_to_string(path).unwrap();
    let read = |elements: &str| {
        let text =
            cable.replace("elements = 21", &format!("elements = {elements}")).replace("length = 40.0", "length = 1.0");
        Scene::from_toml(&text, Path::new(""))
    };
    assert!(read("100").is_ok());
    let message = read("30000").unwrap_err().to_string();
    assert!(message.starts_with("rods.a.elements: 30000 elements are too many: 59400 lie on a contact"), "{message}");
}

/// Symptom: three wires 100 nodes a diameter fine were ended by the system after half a minute, without a word.
/// Mechanism: the matrices couple each segment with all beside it, and so did the search for the smallest gap keep
/// them.
#[cfg(target_os = "linux")]
#[test]
fn pairs_of_segments_are_counted_before_the_matrices_are_made() {
    let dir = folder("pairs");
    let wire = |name: &str, y: f64| {
        let shape = format!("shape = {{ kind = \"line\", start = [0, {y}, 0], length = 120.0 }}");
        let section = "section = { young = 1e3, poisson = 0.3, circle = 0.5 }";
        format!("[[rods]]\nname = \"{name}\"\nelements = 4000\n{shape}\n{section}\n")
    };
    let held = "[[supports]]\nrod = [\"a\", \"b\"]\nat = \"start\"\nposition = true\nrotation = true\n";
    let load = "[[loads]]\nrod = \"a\"\nat = \"end\"\nforce = [0, 0, 1e-4]\n[[stages]]\nramp = { load = 1.0 }\n";
    let file = scene_file(&dir, &(wire("a", 0.0) + &wire("b", 1.05) + held + load));
    for (command, code) in [("check", 2), ("run", 1)] {
        let out = dir.join("out");
        let out = if command == "run" { format!("--out {}", out.display()) } else { String::new() };
        let program = env!("CARGO_BIN_EXE_supercoil");
        let program = format!("ulimit -v 700000; exec {program} {command} {} {out}", file.display());
        let output = Command::new("sh").args(["-c", &program]).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{command}: {}", said(&output));
        assert!(said(&output).contains("pairs of segments may touch"), "{command}: {}", said(&output));
        assert!(said(&output).contains("and 0.7 GiB are available"), "{command}: {}", said(&output));
    }
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Symptom: 20000 threads were being started for ever.
#[test]
fn threads_are_bounded() {
    let message = refusal("[output]", "[solver]\nthreads = 20000\n[output]");
    assert_eq!(message, "solver.threads = 20000: must be between 1 and 1024");
    let dir = folder("threads");
    let output = supercoil(&[&"run", &scene_file(&dir, BEAM), &"--threads", &"20000"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("20000 is not in 1..=1024"), "{}", said(&output));
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Symptom: a pipe that nobody writes to was waited for, and a device without end read, for ever.
#[cfg(unix)]
#[test]
fn scenes_and_points_come_from_regular_files_of_sensible_size() {
    let dir = folder("points");
    let pipe = dir.join("pipe.csv");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for path in [pipe.as_path(), Path::new("/dev/zero"), &dir] {
        let error = read_points(path).unwrap_err().to_string();
        assert!(error.ends_with("is no regular file: only those are read"), "{error}");
    }
    let huge = dir.join("huge.csv");
    std::fs::File::create(&huge).unwrap().set_len((256 << 20) + 1).unwrap();
    assert!(read_points(&huge).unwrap_err().to_string().ends_with("holds more than 256 MiB"));
    std::fs::remove_file(&huge).unwrap();
    for path in [pipe.as_path(), Path::new("/dev/zero")] {
        let error = Scene::read(path).unwrap_err().to_string();
        assert!(error.ends_with("is no regular file: only those are read"), "{error}");
    }
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Symptom: the line in which an error was found was echoed whole, its control characters obeyed by the terminal.
#[test]
fn what_is_echoed_is_cut_and_cannot_command_the_terminal() {
    let dir = folder("echo");
    let path = dir.join("points.csv");
    std::fs::write(&path, format!("1,2,3\n1,\u{1b}[2J{},3\n", "7".repeat(50_000_000))).unwrap();
    let message = read_points(&path).unwrap_err().to_string();
    assert!(message.contains("line 2: a finite number expected, found \"\\u{1b}[2J777"), "{message:.200}");
    assert!(message.len() < 2000 && message.ends_with('…'), "{}", message.len());
    let message = refusal("steps = 2", &format!("steps = {}", "2".repeat(1_000_000)));
    assert!(message.contains("line 18") && message.len() < 5000, "{message:.200}, {}", message.len());
    std::fs::remove_dir_all(&dir).unwrap();
}

/// What goes into tables and onto the terminal as it is.
#[test]
fn titles_names_and_units_are_without_control_characters() {
    for (from, to, field) in [
        ("title = \"beam\"", "title = \"a\\u001b[31mb\"", "title"),
        ("name = \"beam\"", "name = \"a\\nb\"", "rods[0].name"),
        ("length = \"m\"", "length = \"\\u0007\"", "units.length"),
        ("force = \"N\"", "force = \"\\r\"", "units.force"),
    ] {
        let message = refusal(from, to);
        assert!(message.starts_with(&format!("{field} = ")), "{message:?}");
        assert!(message.ends_with("must be one line without control characters"), "{message:?}");
        assert!(!message.chars().any(|c| c.is_control() && c != '\n'), "{message:?}");
    }
}

/// Symptom: lists were taken for tables, their values in the order of the keys; `units = []` was accepted.
#[test]
fn tables_are_not_written_as_lists() {
    for (from, to) in [
        ("units = { length = \"m\", force = \"N\" }", "units = []"),
        ("[output]\npicture = false", "[[output]]"),
        ("[output]", "[[solver]]\n[output]"),
        ("[output]", "[[contact]]\n[output]"),
        ("shape = { kind = \"line\", length = 1.0 }", "shape = [\"line\"]"),
        ("ramp = { rotation = { at = \"end\", axis = [1, 0, 0], turns = 0.1 } }", "ramp = []"),
    ] {
        let message = refusal(from, to);
        assert!(message.contains("invalid type: sequence, expected a table"), "{message}");
    }
    let message = refusal("rotation = { at = \"end\", axis = [1, 0, 0], turns = 0.1 }", "load = 1.0, pressure = [[]]");
    assert!(message.contains("invalid type: sequence, expected a table"), "{message}");
}

/// Symptom: points 2e308 apart "coincide". Mechanism: their distance overflows.
#[test]
fn points_too_far_apart_are_told_so() {
    let dir = folder("far");
    std::fs::write(dir.join("far.csv"), "-1e308,0,0\n0,0,0\n1e308,0,0\n").unwrap();
    let text = BEAM.replace("{ kind = \"line\", length = 1.0 }", "{ kind = \"points\", file = \"far.csv\" }");
    let message = Scene::from_toml(&text, &dir).unwrap_err().to_string();
    let closed = text.replace("elements = 2", "closed = true\nelements = 3");
    let closed = Scene::from_toml(&closed, &dir).unwrap_err().to_string();
    for message in [message, closed] {
        assert!(message.starts_with("rods.beam.shape.points: points lie inf apart: more than 1e150"), "{message}");
    }
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Symptom: two runs in one folder mixed their files, and both ended well.
#[test]
fn one_run_at_a_time_in_a_folder() {
    let dir = folder("lock");
    let (file, out) = (scene_file(&dir, BEAM), dir.join("out"));
    let mut outputs = Vec::new();
    let outcome = run_scene(Scene::read(&file).unwrap(), &out, &mut |step| {
        if step.step == 1 {
            outputs = vec![supercoil(&[&"run", &file, &"--out", &out])];
        }
        go_on(step)
    });
    assert_eq!(outcome.unwrap().status, Status::Converged);
    assert_eq!(outputs[0].status.code(), Some(3), "{}", said(&outputs[0]));
    assert!(said(&outputs[0]).contains("another run is writing to this folder"), "{}", said(&outputs[0]));
    assert!(supercoil(&[&"run", &file, &"--out", &out]).status.success(), "free again");
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Symptom: what a planted link pointed to was overwritten.
#[cfg(unix)]
#[test]
fn a_new_checkpoint_follows_no_link() {
    let dir = folder("link");
    let (out, precious) = (dir.join("out"), dir.join("precious"));
    std::fs::create_dir(&out).unwrap();
    std::fs::write(&precious, "mine").unwrap();
    std::os::unix::fs::symlink(&precious, out.join(format!("{FILE_NAME}.new"))).unwrap();
    let mut scene = Scene::from_toml(BEAM, &dir).unwrap();
    scene.output.checkpoint_steps = Some(1);
    let outcome = run_scene(scene, &out, &mut |_| std::ops::ControlFlow::Break(())).unwrap();
    assert!(outcome.checkpoint.is_some_and(|path| path.symlink_metadata().unwrap().is_file()));
    assert_eq!(std::fs::read_to_string(&precious).unwrap(), "mine");
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Symptom: "bad input" for a disk that is full or read-only.
#[test]
fn what_cannot_be_written_has_an_exit_code_of_its_own() {
    let dir = folder("written");
    let file = scene_file(&dir, BEAM);
    let in_the_way = supercoil(&[&"run", &file, &"--out", &file]);
    assert_eq!(in_the_way.status.code(), Some(3), "{}", said(&in_the_way));
    // found at the end only
    let out = dir.join("out");
    std::fs::create_dir_all(out.join("table.csv")).unwrap();
    let output = supercoil(&[&"run", &file, &"--out", &out]);
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    assert!(said(&output).contains("table.csv"), "{}", said(&output));
    // nobody may write there, be it the superuser
    #[cfg(target_os = "linux")]
    assert_eq!(supercoil(&[&"run", &file, &"--out", &"/proc/out"]).status.code(), Some(3));
    // no byte fits on the disk: what a limit on the size of files leaves
    #[cfg(unix)]
    {
        let program = "trap '' XFSZ; ulimit -f 0; exec \"$0\" run \"$1\" --out \"$2\"";
        let arguments = [Path::new(env!("CARGO_BIN_EXE_supercoil")), &file, &dir.join("full")];
        let output = Command::new("sh").args(["-c", program]).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(3), "{}", said(&output));
        assert!(said(&output).contains("full"), "{}", said(&output));
    }
    let missing = supercoil(&[&"run", &dir.join("nowhere.toml")]);
    assert_eq!(missing.status.code(), Some(2), "what cannot be read is bad input");
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn the_key_that_was_meant_is_named() {
    for (from, to, meant) in [
        ("bending", "bendig", "bending"),
        ("twisting", "twistin", "twisting"),
        ("elements", "elemnts", "elements"),
        ("kind = \"line\"", "kind = \"lien\"", "line"),
        ("steps", "step", "steps"),
    ] {
        let message = refusal(from, to);
        assert!(message.ends_with(&format!("did you mean `{meant}`?")), "{message}");
    }
    let message = refusal("title", "zzz");
    assert!(message.contains("unknown field `zzz`") && !message.contains("did you mean"), "{message}");
}

/// Symptoms: "expected variant identifier", "map", 300 digits of 1e300, and a missing file without its key.
#[test]
fn types_and_files_are_told_in_a_users_words() {
    for (from, to, parts) in [
        ("kind = \"line\"", "kind = 5", &["line 6", "expected text in quotes"][..]),
        ("[[stages]]", "[stages]", &["invalid type: table, expected a list of tables", "double brackets"]),
        ("rotation = { at = \"end\", axis = [1, 0, 0], turns = 0.1 }", "rotation = 0.1", &["such as { to = … }"]),
        ("[output]", "[output]\ndir = \"\"", &["output.dir = \"\": must be the name of a folder"]),
        ("elements = 2", "elements = 1e300", &["`1000", "000…`", "a whole number"]),
        (
            "{ kind = \"line\", length = 1.0 }",
            "{ kind = \"points\", file = \"no.csv\" }",
            &["rods.beam.shape: no.csv: "],
        ),
    ] {
        let message = refusal(from, to);
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
        assert!(message.lines().all(|line| line.chars().count() < 400), "{message}");
    }
}

/// Commands on folders and files that are not what they need: exit code, place and remedy.
#[test]
fn commands_tell_what_they_need() {
    let dir = folder("commands");
    let file = scene_file(&dir, BEAM);
    let refused = |arguments: &[&dyn AsRef<std::ffi::OsStr>], code: i32, parts: &[&str]| {
        let output = supercoil(arguments);
        let all = output.status.code() == Some(code) && parts.iter().all(|part| said(&output).contains(part));
        assert!(all, "{:?}: {}", output.status, said(&output));
    };
    refused(&[&"run", &file, &"--out", &file], 3, &["beam.toml: is a file", "--out"]);
    refused(&[&"run", &file, &"--time-limit", &"-1"], 2, &["--time-limit", "must be at least 0"]);
    refused(&[&"export", &dir], 2, &["--oxdna", "--xyz"]);
    for command in [&["view"][..], &["plot", "--x", "step", "--y", "a"], &["export", "--xyz", "a.xyz"]] {
        let mut arguments: Vec<&dyn AsRef<std::ffi::OsStr>> = vec![&command[0], &dir];
        arguments.extend(command[1..].iter().map(|word| word as &dyn AsRef<std::ffi::OsStr>));
        refused(&arguments, 2, &["is no folder of a finished run", "summary.json"]);
    }
    std::fs::write(dir.join("summary.json"), "{}").unwrap();
    std::fs::write(dir.join("table.csv"), "step,writhe,energy\n0,0.5,1\n1,0.75,2\n").unwrap();
    std::fs::write(dir.join("table_columns.csv"), "column,unit,meaning\nwrithe,turns,\nenergy,pN nm,\n").unwrap();
    let plot =
        |y: &str, name: &str| supercoil(&[&"plot", &dir, &"--x", &"step", &"--y", &y, &"--out", &dir.join(name)]);
    for (y, name, parts) in [
        ("writh", "a.svg", &["column = \"writh\"", "did you mean writhe?"][..]),
        ("writhe,energy", "a.svg", &["cannot share an axis", "turns and pN nm"]),
        ("writhe", "a.png", &["a.png: is neither .svg nor .pdf"]),
    ] {
        let output = plot(y, name);
        assert!(
            output.status.code() == Some(2) && parts.iter().all(|p| said(&output).contains(p)),
            "{}",
            said(&output)
        );
    }
    assert!(plot("writhe", "a.pdf").status.success());
    assert!(std::fs::read(dir.join("a.pdf")).unwrap().starts_with(b"%PDF"));
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Stopped by itself as Ctrl-C would, and taken up again.
#[test]
fn a_time_limit_ends_a_run_cleanly() {
    let dir = folder("limit");
    let file = scene_file(&dir, &BEAM.replace("steps = 2", "steps = 1000000"));
    let out = dir.join("out");
    let output = supercoil(&[&"run", &file, &"--out", &out, &"--time-limit", &"0.5"]);
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    assert!(said(&output).contains("time limit reached") && said(&output).contains("to go on: supercoil resume"));
    assert!(out.join("summary.json").exists() && out.join(FILE_NAME).exists());
    let again = supercoil(&[&"resume", &out, &"--time-limit", &"0.2"]);
    assert_eq!(again.status.code(), Some(130), "{}", said(&again));
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn values_of_a_scene_can_be_replaced() {
    let dir = folder("set");
    let file = scene_file(&dir, BEAM);
    let read = |set: &[&str]| Scene::read_with(&file, &set.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>());
    let scene = read(&["rods.beam.elements=5", "stages.0.steps = 7", "solver.threads=3", "title=other words"]).unwrap();
    assert_eq!((scene.model.rods[0].num_elements, scene.stages[0].steps), (5, 7));
    assert_eq!((scene.solver.threads, scene.title.as_str()), (Some(3), "other words"));
    let scene = read(&["rods.0.shape={ kind = \"line\", length = 3.0 }"]).unwrap();
    assert_eq!(scene.model.rods[0].length, 3.0);
    for (set, reason) in [
        ("rods.beam.elements", "set rods.beam.elements: must be KEY=VALUE"),
        ("rods.bean.elements=3", "there is no entry \"bean\": give its name or its index from 0"),
        ("rods.7.elements=3", "there is no entry \"7\""),
        ("title.x=3", "what \"x\" is to be in is no table"),
        ("rods.beam.elemnts=3", "did you mean `elements`?"),
        ("rods.beam.elements=many", "expected a whole number"),
    ] {
        let error = read(&[set]).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
    std::fs::remove_dir_all(&dir).unwrap();
}

/// A run that was cut goes on with the values that were replaced.
#[test]
fn replaced_values_survive_a_resume() {
    let dir = folder("set_resume");
    let (file, out) = (scene_file(&dir, BEAM), dir.join("out"));
    let set = vec!["rods.beam.elements=3".to_owned(), "stages.0.steps=4".to_owned()];
    let scene = Scene::read_with(&file, &set).unwrap();
    let _ = run_scene(scene, &out, &mut |_| std::ops::ControlFlow::Break(())).unwrap();
    let output = supercoil(&[&"resume", &out]);
    assert!(output.status.success(), "{}", said(&output));
    let summary: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    assert_eq!(
        (summary["rods"][0]["elements"].as_u64(), summary["steps"].as_array().map(Vec::len)),
        (Some(3), Some(5))
    );
    assert_eq!(summary["program"].as_str(), Some(env!("CARGO_PKG_VERSION")));
    std::fs::remove_dir_all(&dir).unwrap();
}

/// A folder says which scene it is of; results of another are not replaced unasked. What counts is the problem, not the
/// file: an edited file is another scene, the same problem in another file is not.
#[test]
fn results_of_another_scene_are_kept() {
    let dir = folder("another");
    let (file, out) = (scene_file(&dir, BEAM), dir.join("out"));
    let run = |more: &[&str]| {
        let mut arguments: Vec<&dyn AsRef<std::ffi::OsStr>> = vec![&"run", &file, &"--out", &out];
        more.iter().for_each(|argument| arguments.push(argument));
        supercoil(&arguments)
    };
    assert!(run(&[]).status.success());
    let copy = || std::fs::read_to_string(out.join("scene_as_run.toml")).unwrap();
    let summary = || -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).unwrap()).unwrap()
    };
    let hash = summary()["model_hash"].as_str().unwrap().to_owned();
    let head = format!("# supercoil {} has run\n# model hash {hash}\n# {file:?}\n\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(copy(), format!("{head}{BEAM}"));
    let rod = &summary()["rods"][0]["stiffness"];
    assert_eq!((rod["bending"][0].as_f64(), rod["stretching"].as_f64()), (Some(1.0), Some(1000.0)));
    assert!(summary()["threads"].as_u64().unwrap() >= 1);
    // the same problem: with another title, other outputs, threads
    let titled = BEAM.replace("\"beam\"\nunits", "\"a beam\"\nunits").replace("[output]", "[output]\nvtk = false");
    std::fs::write(&file, titled).unwrap();
    assert!(run(&["--threads", "1"]).status.success());
    assert_eq!((summary()["model_hash"].as_str(), summary()["threads"].as_u64()), (Some(hash.as_str()), Some(1)));
    assert!(copy().contains("vtk = false"));
    // the same file, edited
    std::fs::write(&file, BEAM.replace("turns = 0.1", "turns = 0.2")).unwrap();
    let output = run(&[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("holds the results of another scene"), "{}", said(&output));
    assert!(said(&output).contains("beam.toml") && said(&output).contains("--force"), "{}", said(&output));
    assert!(copy().contains("vtk = false") && summary()["model_hash"].as_str() == Some(&hash), "nothing was touched");
    // a variant of it
    std::fs::write(&file, BEAM).unwrap();
    assert_eq!(run(&["--set", "rods.beam.elements=4"]).status.code(), Some(2));
    assert!(run(&["--set", "rods.beam.elements=4", "--force"]).status.success());
    assert!(copy().contains("# --set \"rods.beam.elements=4\"\n"), "{}", copy());
    assert_ne!(summary()["model_hash"].as_str(), Some(hash.as_str()));
    // a scene from no file is one, too
    let scene = Scene::from_toml(BEAM, &dir).unwrap();
    let error = run_scene(scene.clone(), &out, &mut go_on).unwrap_err().to_string();
    assert!(error.contains("holds the results of another scene"), "{error}");
    assert!(SceneRun { force: true, ..SceneRun::new(scene.clone(), &out) }.start(&mut go_on).is_ok());
    assert!(run_scene(scene, &out, &mut go_on).is_ok(), "the same again");
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Symptom: a preset picked a mesh that was refused before the first iteration. Natural twist, link, turns and shapes
/// that twist quickly take as many elements as they need.
#[test]
fn presets_pick_meshes_that_are_taken() {
    let ring = |keys: &str| {
        format!(
            "[[rods]]\nclosed = true\nshape = {{ kind = \"circle\", length = 100.0 }}\n\
             section = {{ bending = 200.0, twisting = 300.0, stretching = 1e3, shearing = 1e3, contact_radius = 1.0 \
             }}\n{keys}\n"
        )
    };
    let preset = |word: &str, text: &str| format!("fidelity = \"{word}\"\n{text}");
    let natural = ring("natural = { curvature = [0.0, 0.0], twist = 2.5 }");
    let linked = ring("excess_link = -30.0");
    let knot = ring("").replace("kind = \"circle\"", "kind = \"torus_knot\", windings = [2, 11]");
    let turned = BEAM.replace("elements = 2\n", "").replace("turns = 0.1", "turns = 40.0");
    let loaded = BEAM.replace("elements = 2\n", "").replace(
        "[[stages]]",
        "[[loads]]\nat = \"end\"\nmoment = [0.0, 0.0, 300.0]\n[[stages]]\nramp = { load = 1.0 }\n[[stages]]",
    );
    for word in ["draft", "balanced", "reference"] {
        for text in [&natural, &linked, &knot, &turned, &loaded] {
            let scene = Scene::from_toml(&preset(word, text), Path::new("")).unwrap();
            let steps = scene.model.rods[0].num_elements;
            let solver = supercoil::solve::Solver::new(scene.model, supercoil::solve::Options::default());
            assert!(solver.is_ok(), "{word}, {steps} elements: {text}\n{:?}", solver.err());
        }
    }
    // what takes more than there is is refused with the number, and says that the preset has chosen it
    let slender = preset("reference", &ring("")).replace("contact_radius = 1.0", "contact_radius = 1e-7");
    let message = Scene::from_toml(&slender, Path::new("")).unwrap_err().to_string();
    assert!(message.contains("elements are too many") && message.contains("reference"), "{message}");
}

/// Advice that fits: a load beyond what a rod bears is to be a displacement, too few elements are to be more.
#[test]
fn advice_fits_the_cause() {
    let dir = folder("advice");
    let fails = |text: &str| {
        let output = supercoil(&[&"run", &scene_file(&dir, text), &"--out", &dir.join("out"), &"--force"]);
        assert_eq!(output.status.code(), Some(1), "{}", said(&output));
        said(&output)
    };
    // one iteration does not bring a rod round
    let rotation = "{ rotation = { at = \"end\", axis = [1, 0, 0], turns = 0.1 } }";
    let held = BEAM.replace("at = \"end\"\nrotation", "at = \"end\"\nposition = true\nrotation");
    let held =
        held.replace("elements = 2", "elements = 24").replace("[output]", "[solver]\nmax_iterations = 1\n[output]");
    let moved = held.replace(rotation, "{ displacement = { at = \"end\", to = [-0.6, 0.2, 0.0] } }");
    let message = fails(&moved);
    assert!(message.contains("more solver.max_iterations") && !message.contains("limit load"), "{message}");
    let loaded = moved.replace("[[stages]]", "[[loads]]\nat = 30\nforce = [0.0, 3.0, 0.0]\n[[stages]]");
    let message = fails(&loaded.replace("{ displacement", "{ load = 1.0, displacement"));
    assert!(message.contains("beyond a limit load"), "{message}");
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Reading and writing fail as different things.
#[test]
fn a_table_that_cannot_be_written_is_no_bad_file() {
    let error = supercoil::io::csv::write_table(Path::new("/nowhere/a.csv"), &["a"], [[1.0]]).unwrap_err();
    assert!(matches!(error, InputError::Write { .. }), "{error}");
}
