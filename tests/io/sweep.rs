//! Sweeps: plans, runs that are stopped, killed, doubled or damaged, and the one table that comes of all of them.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use supercoil::io::run::run_scene;
use supercoil::io::sweep::{
    Collected, ColumnValues, Plan, Shard, SweepRun, SweepTable, collect, from_bytes, merge, status, to_bytes,
    write_part,
};

/// A cantilever bent by a force: a few milliseconds a case.
const SCENE: &str = r#"
title = "cantilever"
[[rods]]
name = "rod"
shape = { kind = "line", length = 1.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.0 }
elements = 4
[[supports]]
at = "start"
position = true
rotation = true
[[loads]]
at = "end"
force = [0.0, 1.0, 0.0]
moment = [0.0, 0.0, 0.0]
[[stages]]
ramp = { load = 1.0 }
steps = 2
"#;

/// Twelve cases, of which a third are refused and a third do not converge.
const AXES: &str = r#"
scene = "scene.toml"
[axes]
"stages.0.ramp.load" = { from = 1.0, to = 2.5, count = 4 }
[[linked]]
"rods.rod.elements" = [4, 0, 4]
"loads.0.moment" = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 60.0]]
"#;

/// A folder with a scene and a sweep file, planned into its subfolder `sweep`.
fn planned(name: &str, axes: &str) -> (PathBuf, PathBuf) {
    let dir = std::env::temp_dir().join(format!("supercoil_sweep_{}_{name}", std::process::id()));
    std::fs::remove_dir_all(&dir).ok();
    std::fs::create_dir_all(&dir).unwrap();
    std::fs::write(dir.join("scene.toml"), SCENE).unwrap();
    let sweep = plan(&dir, axes);
    (dir, sweep)
}

fn plan(dir: &Path, axes: &str) -> PathBuf {
    std::fs::write(dir.join("sweep.toml"), axes).unwrap();
    Plan::of_file(&dir.join("sweep.toml")).unwrap().write(&dir.join("sweep")).unwrap();
    dir.join("sweep")
}

fn run(sweep: &Path, choices: &SweepRun) -> supercoil::io::sweep::Tally {
    choices.go(sweep, &mut |_| ()).unwrap()
}

fn serial() -> SweepRun {
    SweepRun { jobs: 1, ..SweepRun::default() }
}

/// The program, without a terminal.
fn program(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_supercoil"));
    command.arg("sweep").args(arguments).stdin(Stdio::null());
    command
}

fn output(arguments: &[&str]) -> (i32, String) {
    let Output { status, stdout, stderr } = program(arguments).output().unwrap();
    (status.code().unwrap(), String::from_utf8([stdout, stderr].concat()).unwrap())
}

fn words(table: &SweepTable, name: &str) -> Vec<String> {
    (0..table.num_rows()).map(|row| table.column(name).unwrap().text(row).unwrap_or_default()).collect()
}

fn parts(sweep: &Path, ending: &str) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(sweep.join("parts")) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|found| found == ending));
    paths.sort();
    paths
}

fn assert_same(a: &Collected, b: &Collected) {
    assert_eq!((&a.missing, &b.missing), (&vec![], &vec![]));
    let (rows, others) = (0..a.table.num_rows(), 0..b.table.num_rows());
    assert_eq!(a.table.difference(rows, &b.table, others, &["seconds"]), None);
}

/// Radius, place and ramp of an obstacle are axes as any number of a scene is.
#[test]
fn sweeps_change_obstacles() {
    let dir = std::env::temp_dir().join(format!("supercoil_sweep_{}_obstacles", std::process::id()));
    std::fs::remove_dir_all(&dir).ok();
    std::fs::create_dir_all(&dir).unwrap();
    let scene = "planar = true\n[[rods]]\nname = \"ring\"\nclosed = true\nshape = { kind = \"circle\", radius = 1.0 }\n\
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.05 }\n\
        elements = 16\n\
        [[obstacles]]\nname = \"tube\"\nshape = \"cylinder\"\naxis = [0, 0, 1]\nside = \"inside\"\nradius = 1.1\n\
        [[stages]]\nramp = { obstacle = { radius = 1.045 } }\n";
    std::fs::write(dir.join("scene.toml"), scene).unwrap();
    let axes = "scene = \"scene.toml\"\n[axes]\n\"obstacles.tube.radius\" = [1.1, 0.9]\n\
        \"stages.0.ramp.obstacle.radius\" = [1.045, 1.042]\n";
    let sweep = plan(&dir, axes);
    run(&sweep, &serial());
    let table = collect(&sweep).unwrap().table;
    // the start and a step of each case that runs; no ring fits in the smaller tube
    assert_eq!(words(&table, "status"), ["converged", "converged", "converged", "converged", "refused", "refused"]);
    let forces: Vec<f64> = words(&table, "tube_force").iter().filter_map(|text| text.parse().ok()).collect();
    // a ring that is compressed evenly: 2π EA (1 − λ)
    for (force, compressed) in [(forces[1], 0.005), (forces[3], 0.008)] {
        let even = std::f64::consts::TAU * 1e4 * compressed;
        assert!((force / even - 1.0).abs() < 1e-2, "{force} {even}");
    }
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn a_sweep_runs_resumes_and_keeps_its_failures_as_rows() {
    let (dir, sweep) = planned("runs", AXES);
    // no time for any case
    let stopped = run(&sweep, &SweepRun { max_seconds: Some(0.0), ..serial() });
    assert_eq!(status(&sweep).unwrap().missing.len(), 12 - stopped.done);
    let first = run(&sweep, &SweepRun { shard: Shard { index: 0, count: 2 }, ..serial() });
    assert_eq!((first.cases, first.before + first.done), (6, 6));
    let now = status(&sweep).unwrap();
    assert!(now.missing.iter().all(|case| case % 2 == 1) && now.missing_shards(2) == [1], "{now:?}");
    let rest = run(&sweep, &SweepRun::default());
    assert_eq!((rest.cases, rest.before + rest.done, rest.missing()), (12, 12, 0));
    assert_eq!(run(&sweep, &serial()).done, 0);

    let now = status(&sweep).unwrap();
    let count = |status: &str| now.by_status.get(status).copied();
    assert_eq!((count("converged"), count("refused"), now.failures.len()), (Some(4), Some(4), 8), "{now}");
    let Collected { table, missing } = collect(&sweep).unwrap();
    assert!(missing.is_empty());
    let plan = Plan::read(&sweep).unwrap();
    let mut ids = words(&table, "case");
    ids.dedup();
    assert_eq!(ids, plan.cases().iter().map(|case| case.id.clone()).collect::<Vec<_>>());
    for (row, state) in words(&table, "status").iter().enumerate() {
        let message = &words(&table, "message")[row];
        match state.as_str() {
            "converged" => assert!(message.is_empty(), "{message}"),
            "refused" => assert!(message.contains("elements = 0"), "{message}"),
            _ => assert!(message.contains("use more elements"), "{state}: {message}"),
        }
    }
    let read = from_bytes(std::fs::read(sweep.join("table.parquet")).unwrap(), &|_| true).unwrap();
    assert_eq!(read.num_rows(), table.num_rows());
    std::fs::remove_dir_all(dir).unwrap();
}

/// A run that ends with a status of its own without a failed step, here tubes inside each other, says why in its row.
#[test]
fn rows_of_overlaps_say_why() {
    let axes = "scene = \"scene.toml\"\n[axes]\n\"stages.0.ramp.load\" = [1.0, 60.0]\n";
    let (dir, sweep) = planned("overlap", axes);
    std::fs::write(dir.join("scene.toml"), SCENE.replace("contact_radius = 0.0", "contact_radius = 0.2")).unwrap();
    std::fs::remove_dir_all(&sweep).unwrap();
    let sweep = plan(&dir, axes);
    run(&sweep, &serial());
    let table = collect(&sweep).unwrap().table;
    let last = table.num_rows() - 1;
    assert_eq!((words(&table, "status")[0].as_str(), words(&table, "message")[0].as_str()), ("converged", ""));
    assert_eq!(words(&table, "status")[last], "overlap");
    assert!(words(&table, "message")[last].contains("as tightly as its contact radius allows"));
    std::fs::remove_dir_all(dir).unwrap();
}

/// A case is the run of its scene, to the bit: a row each accepted step.
#[test]
fn a_case_is_the_run_of_its_scene() {
    let (dir, sweep) = planned("case", AXES);
    let plan = Plan::read(&sweep).unwrap();
    let case = &plan.cases()[0];
    let rows = plan.run(case, &Default::default()).unwrap();
    let outcome = run_scene(plan.scene(case).unwrap(), &dir.join("run"), &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(rows.num_rows() == outcome.steps.len() && rows.num_rows() == 3);
    for (row, step) in outcome.steps.iter().enumerate() {
        let number = |name: &str| rows.column(name).unwrap().number(row).unwrap();
        assert_eq!(number("total_energy").to_bits(), step.energies.total.to_bits());
        assert_eq!((number("step"), number("iterations")), (step.step as f64, step.iterations as f64));
    }
    assert_eq!(rows.column("rods.rod.elements").unwrap().number(0), Some(4.0));
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn ids_change_with_whatever_changes_numbers_and_with_nothing_else() {
    let (dir, sweep) = planned("ids", AXES);
    let ids = || Plan::read(&sweep).unwrap().cases().iter().map(|case| case.id.clone()).collect::<Vec<_>>();
    let first = ids();
    std::fs::write(dir.join("scene.toml"), SCENE.replace("cantilever", "beam").replace("elements = 4", "elements=4 #"))
        .unwrap();
    plan(&dir, AXES);
    assert_eq!(ids(), first);
    // rows of an earlier plan stay good when values are added
    run(&sweep, &serial());
    plan(&dir, &AXES.replace("to = 2.5, count = 4", "to = 3.0, count = 5"));
    assert!(first.iter().all(|id| ids().contains(id)) && ids().len() == 15);
    assert_eq!(status(&sweep).unwrap().missing, [12, 13, 14]);
    plan(&dir, &AXES.replace("[axes]", "rows = \"last\"\n[axes]"));
    assert!(first.iter().all(|id| !ids().contains(id)));
    // a file that scenes name
    let points = "[set]\n\"rods.rod.shape\" = { kind = \"points\", file = \"line.csv\" }\n";
    std::fs::write(dir.join("line.csv"), "x,y,z\n0,0,0\n0.5,0,0\n1,0,0\n").unwrap();
    plan(&dir, &format!("{AXES}{points}"));
    let with_points = ids();
    plan(&dir, &format!("{AXES}{points}"));
    assert_eq!(ids(), with_points);
    std::fs::write(dir.join("line.csv"), "x,y,z\n0,0,0\n0.5,0,0\n1.0,0,0\n").unwrap();
    plan(&dir, &format!("{AXES}{points}"));
    assert!(ids().iter().all(|id| !with_points.contains(id)));
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn a_damaged_part_is_refused_and_redone() {
    let (dir, sweep) = planned("damaged", AXES);
    run(&sweep, &SweepRun { part_seconds: 0.0, ..serial() });
    let whole = collect(&sweep).unwrap();
    let all = parts(&sweep, "parquet");
    assert!(all.len() > 3, "{all:?}");
    for (part, damage) in all.iter().zip([0, 1, 100]) {
        let bytes = std::fs::read(part).unwrap();
        // cut short, empty, a bit turned
        let mut damaged = bytes[..bytes.len() - damage].to_vec();
        damaged[50] ^= u8::from(damage == 0);
        std::fs::write(part, damaged).unwrap();
    }
    let now = status(&sweep).unwrap();
    assert!(now.damaged.len() == 3 && now.missing.len() >= 3, "{now}");
    assert!(now.to_string().contains("is damaged or cut short"), "{now}");
    let redone = run(&sweep, &serial());
    assert_eq!(redone.done, now.missing.len());
    assert_same(&whole, &collect(&sweep).unwrap());
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn collect_refuses_rows_that_differ_for_one_case() {
    let (dir, sweep) = planned("unequal", AXES);
    let plan = Plan::read(&sweep).unwrap();
    let case = &plan.cases()[0];
    let rows = plan.run(case, &Default::default()).unwrap();
    let mut columns = rows.columns().to_vec();
    let energy = columns.iter_mut().find(|column| column.name == "total_energy").unwrap();
    let ColumnValues::Number(values) = &mut energy.values else { panic!("{energy:?}") };
    values[1] = values[1].map(|x| x * (1.0 + f64::EPSILON));
    let other = SweepTable::new(columns.clone());
    assert_eq!(merge(&plan, &[rows.clone(), rows.clone()]).unwrap().table.num_rows(), rows.num_rows());
    write_part(&sweep, &rows).unwrap();
    write_part(&sweep, &other).unwrap();
    let error = collect(&sweep).unwrap_err().to_string();
    assert!(error.starts_with("case 0 (") && error.contains("first difference: total"), "{error}");
    // wall times do differ
    let seconds = columns.iter_mut().find(|column| column.name == "seconds").unwrap();
    seconds.values = ColumnValues::Number(vec![Some(1.0); rows.num_rows()]);
    columns.iter_mut().find(|column| column.name == "total_energy").unwrap().values =
        rows.column("total_energy").unwrap().clone();
    assert!(merge(&plan, &[rows, SweepTable::new(columns)]).is_ok());
    std::fs::remove_dir_all(dir).unwrap();
}

/// Both do all cases, or one passes over those of the other: the table is that of one run.
#[test]
fn the_same_shard_twice_at_once_does_no_harm() {
    let (dir, sweep) = planned("twice", AXES);
    let text = sweep.to_str().unwrap().to_owned();
    let start = || program(&["run", &text, "--part-seconds", "0", "--jobs", "1", "--quiet"]).spawn().unwrap();
    let both = [start(), start()];
    both.into_iter().for_each(|mut child| assert!(child.wait().unwrap().success()));
    let (other_dir, other) = planned("once", AXES);
    run(&other, &serial());
    // the plans are in other folders, but their scenes are the same
    assert_same(&collect(&sweep).unwrap(), &collect(&other).unwrap());
    [dir, other_dir].iter().for_each(|dir| std::fs::remove_dir_all(dir).unwrap());
}

/// Killed at the moment when a file is being written, again and again, then left to end.
#[test]
fn a_writer_killed_in_the_middle_of_a_file_loses_nothing_else() {
    let many = AXES.replace("count = 4", "count = 40");
    let (dir, sweep) = planned("killed", &many);
    let text = sweep.to_str().unwrap().to_owned();
    let begun = Instant::now();
    let mut leftovers = 0;
    while leftovers < 3 {
        assert!(begun.elapsed() < Duration::from_secs(120), "no writer was caught at work");
        let mut child = program(&["run", &text, "--part-seconds", "0", "--jobs", "1", "--quiet"]).spawn().unwrap();
        while parts(&sweep, "tmp").len() == leftovers && child.try_wait().unwrap().is_none() {}
        child.kill().unwrap();
        child.wait().unwrap();
        leftovers = parts(&sweep, "tmp").len();
        if status(&sweep).unwrap().missing.is_empty() && leftovers < 3 {
            // all done before enough were caught: once more
            std::fs::remove_dir_all(sweep.join("parts")).unwrap();
            leftovers = 0;
        }
    }
    // whatever else is there is whole
    assert!(status(&sweep).unwrap().damaged.is_empty());
    let (code, said) = output(&["run", &text]);
    assert_eq!(code, 0, "{said}");
    let survived = collect(&sweep).unwrap();
    assert!(parts(&sweep, "tmp").is_empty(), "leftovers are swept");
    let (other_dir, other) = planned("unkilled", &many);
    run(&other, &serial());
    assert_same(&survived, &collect(&other).unwrap());
    [dir, other_dir].iter().for_each(|dir| std::fs::remove_dir_all(dir).unwrap());
}

#[test]
fn the_command_line_says_how_it_went() {
    let (dir, sweep) = planned("commands", AXES);
    let (file, sweep) = (dir.join("sweep.toml"), sweep.to_str().unwrap().to_owned());
    let file = file.to_str().unwrap();
    assert_eq!(output(&["plan", file, "--out", &sweep]).0, 0);
    assert_eq!(output(&["run", &sweep, "--max-seconds", "0", "--jobs", "1"]).0, 130);
    assert_eq!(output(&["status", &sweep]).0, 1);
    let (code, said) = output(&["run", &sweep, "--shard", "1/4"]);
    assert!(code == 0 && said.contains(" did not converge"), "{said}");
    let (_, missing) = output(&["status", &sweep, "--missing-of", "4"]);
    assert!(missing == "0,2-3\n" || missing == "2-3\n", "{missing}");
    let (code, said) = output(&["run", &sweep]);
    assert_eq!(code, 0, "{said}");
    let (code, said) = output(&["status", &sweep]);
    assert!(code == 0 && said.starts_with("12 cases, ") && said.contains("to look at it: supercoil run "), "{said}");
    let csv = dir.join("table.csv");
    assert_eq!(output(&["collect", &sweep, "--csv", csv.to_str().unwrap()]).0, 0);
    let head = "case,stages.0.ramp.load,loads.0.moment,rods.rod.elements,";
    assert!(std::fs::read_to_string(&csv).unwrap().starts_with(head));
    let plot = ["plot", &sweep, "-x", "stages.0.ramp.load", "-y", "bending_energy", "--by"];
    assert_eq!(output(&[&plot[..], &["rods.rod.elements"]].concat()).0, 0);
    assert!(std::fs::read_to_string(Path::new(&sweep).join("bending_energy.svg")).unwrap().contains("elements = 4"));
    for (wrong, reason) in [
        (output(&[&plot[..], &["nothing"]].concat()), "by = \"nothing\": must be case, "),
        (
            output(&["plot", &sweep, "-x", "status", "-y", "bending_energy"]),
            "x = \"status\": must be a column of numbers",
        ),
        (output(&["run", &sweep, "--shard", "4/4"]), "must be i/n"),
        (output(&["run", dir.to_str().unwrap()]), "plan.jsonl: is not there: supercoil sweep plan makes it"),
    ] {
        assert!(wrong.0 == 2 && wrong.1.contains(reason), "{wrong:?}");
    }
    std::fs::write(file, AXES.replace("rods.rod.elements", "rods.rod.element")).unwrap();
    let (code, said) = output(&["plan", file, "--out", &sweep]);
    assert!(code == 2 && said.contains("unknown field `element`"), "{said}");
    std::fs::remove_dir_all(dir).unwrap();
}

/// What the help shows can be planned: 3 salts, 7 densities, 2 linked values, 100 draws.
#[test]
fn the_sweep_file_of_the_help_is_one() {
    let dir = crate::program::folder("sweep_help");
    let help = Command::new(env!("CARGO_BIN_EXE_supercoil")).args(["help", "sweep"]).output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let lines = help.split("A sweep file:\n").nth(1).unwrap().lines();
    let file: String = lines.map(|line| line.trim().to_owned() + "\n").collect();
    std::fs::write(dir.join("sweep.toml"), file).unwrap();
    let minicircle = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes/minicircle.toml");
    std::fs::copy(minicircle, dir.join("minicircle.toml")).unwrap();
    assert_eq!(Plan::of_file(&dir.join("sweep.toml")).unwrap().cases().len(), 4200);
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn the_example_is_ten_thousand_cases() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/sweeps/minicircles.toml");
    let plan = Plan::of_file(&file).unwrap();
    assert_eq!(plan.cases().len(), 10_000);
    let shapes = [0, 9_999].map(|case| plan.scene(&plan.cases()[case]).unwrap().model.rods[0].section.contact_radius);
    assert!(shapes[0] > shapes[1], "{shapes:?}"); // at 20 and 500 mmol/l
}

/// Equal tables are equal files, so that a part's name says what is in it.
#[test]
fn equal_rows_are_equal_bytes() {
    let (dir, sweep) = planned("bytes", AXES);
    let plan = Plan::read(&sweep).unwrap();
    let refused = plan.cases().iter().find(|case| case.set.iter().any(|set| set.ends_with("elements=0"))).unwrap();
    let bytes = || to_bytes(&plan.run(refused, &Default::default()).unwrap()).unwrap();
    assert_eq!(bytes(), bytes());
    std::fs::remove_dir_all(dir).unwrap();
}
