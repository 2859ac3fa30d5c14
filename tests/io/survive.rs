//! Runs that are stopped, killed or damaged: what goes on from a checkpoint ends with the same bits as what never
//! stopped.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use supercoil::io::checkpoint::{Checkpoint, FILE_NAME};
use supercoil::io::run::{Outcome, SceneRun, resume, run_scene};
use supercoil::scene::Scene;
use supercoil::solve::Status;

use crate::program::folder;

/// A minicircle through its snap into the figure-eight: contact, softened laws, steps that fail and are halved.
const RING: &str = r#"
    title = "ring"
    [[rods]]
    name = "dna"
    closed = true
    shape = { kind = "circle", length = 114.24 }
    section = { bending = 205.7, twisting = 308.6, stretching = 1100.0, shearing = 1100.0, contact_radius = 2.5 }
    elements = 16
    order = 3
    [[stages]]
    ramp = { excess_link = { to = -1.1 } }
    steps = 3
    [[stages]]
    ramp = { excess_link = { to = -1.3 } }
    steps = 4
    [output]
    checkpoint_steps = 1
"#;

/// The ring's scene as a file, so that a run can be resumed by its folder alone.
fn ring_file(dir: &Path) -> PathBuf {
    let file = dir.join("ring.toml");
    std::fs::write(&file, RING).unwrap();
    file
}

fn run(scene: Scene, dir: &Path) -> Outcome {
    run_scene(scene, dir, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// A CSV table without its wall times.
fn table(path: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let timed = reader.headers().unwrap().iter().position(|name| name == "seconds").unwrap();
    let row = |record: csv::StringRecord| -> Vec<String> {
        record.iter().enumerate().filter(|(i, _)| *i != timed).map(|(_, cell)| cell.to_owned()).collect()
    };
    reader.records().map(|record| row(record.unwrap())).collect()
}

fn without_times(mut value: serde_json::Value) -> serde_json::Value {
    match &mut value {
        serde_json::Value::Object(map) => {
            map.remove("seconds");
            // part of how it was run, as time is
            map.remove("threads");
            map.values_mut().for_each(|inner| *inner = without_times(inner.take()));
        }
        serde_json::Value::Array(list) => list.iter_mut().for_each(|inner| *inner = without_times(inner.take())),
        _ => {}
    }
    value
}

fn summary(dir: &Path) -> serde_json::Value {
    without_times(serde_json::from_str(&std::fs::read_to_string(dir.join("summary.json")).unwrap()).unwrap())
}

/// Both runs ended alike: bits of the state, tables, sites, list of VTK files, pictures.
fn assert_same(a: &Path, b: &Path) {
    for name in ["final_state.csv", "sites.csv", "run.pvd", "filmstrip.png", "picture.png"] {
        let (x, y) = (std::fs::read(a.join(name)).unwrap(), std::fs::read(b.join(name)).unwrap());
        assert!(x == y, "{name} differs between {} and {}", a.display(), b.display());
    }
    assert_eq!(table(&a.join("table.csv")), table(&b.join("table.csv")));
    assert!(summary(a) == summary(b), "summaries of {} and {} differ", a.display(), b.display());
    let last = |dir: &Path| std::fs::read_to_string(dir.join("run.pvd")).unwrap().matches(".vtp").count();
    assert!(last(a) > 1 && b.join(format!("step_{:04}.vtp", last(b) - 1)).exists());
}

/// Checkpoints are put aside while the run goes on: each is what a kill during the step after would leave.
#[test]
fn from_any_step_the_same_end() {
    let dir = folder("every");
    let file = ring_file(&dir);
    let whole = dir.join("whole");
    let mut kept = Vec::new();
    let mut watch = |step: &supercoil::observe::report::Observation| {
        // before and after the change of stage, in the soft phase, at the end
        if [1, 4, 5, 6, 7].contains(&step.step) {
            let aside = dir.join(format!("cut_{}", step.step - 1));
            std::fs::create_dir_all(&aside).unwrap();
            std::fs::copy(whole.join(FILE_NAME), aside.join(FILE_NAME)).unwrap();
            kept.push((step.step - 1, aside));
        }
        ControlFlow::Continue(())
    };
    let outcome = run_scene(Scene::read(&file).unwrap(), &whole, &mut watch).unwrap();
    assert_eq!((outcome.status, outcome.checkpoint), (Status::Converged, None));
    assert!(!whole.join(FILE_NAME).exists(), "a finished run leaves no checkpoint");
    assert_eq!(kept.len(), 5);
    for (cut, aside) in kept.iter().map(|(cut, aside)| (*cut, aside)) {
        let mut seen = Vec::new();
        let mut scene = Scene::read(&file).unwrap();
        scene.solver.threads = Some(1 + cut % 3);
        let resumed = SceneRun::new(scene, aside).resume(&mut |step| {
            seen.push(step.step);
            ControlFlow::Continue(())
        });
        assert_eq!(resumed.unwrap().status, Status::Converged);
        assert_eq!(seen, (cut + 1..=7).collect::<Vec<_>>(), "only the steps that were missing");
        assert_same(&whole, aside);
    }
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Moved supports, loads, planar scenes: what was turned and displaced before the cut counts after it.
#[test]
fn examples_go_on_as_they_began() {
    for (name, cut) in [("crossed_beams", 3), ("elastica", 9), ("ring_pressure", 7), ("loop_between_poses", 25)] {
        let dir = folder(name);
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("examples/{name}.toml"));
        let (whole, parts) = (dir.join("whole"), dir.join("parts"));
        assert_eq!(run(Scene::read(&file).unwrap(), &whole).status, Status::Converged, "{name}");
        let stop_at = |limit: usize| {
            move |step: &supercoil::observe::report::Observation| match step.step >= limit {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        };
        let outcome = run_scene(Scene::read(&file).unwrap(), &parts, &mut stop_at(cut)).unwrap();
        assert_eq!((outcome.status, outcome.steps.len()), (Status::Stopped, cut + 1), "{name}");
        assert_eq!(outcome.checkpoint, Some(parts.join(FILE_NAME)));
        let outcome = resume(&parts, &mut stop_at(cut + 1)).unwrap();
        assert_eq!((outcome.status, outcome.steps.len()), (Status::Stopped, cut + 2), "{name}");
        assert_eq!(resume(&parts, &mut stop_at(usize::MAX)).unwrap().status, Status::Converged, "{name}");
        assert_same(&whole, &parts);
        std::fs::remove_dir_all(&dir).unwrap();
    }
}

/// A flag raised between two steps cuts the next one in its first iteration; nothing of it is left.
#[test]
fn an_interrupt_falls_back_to_the_last_accepted_step() {
    let dir = folder("interrupt");
    let file = ring_file(&dir);
    let run = SceneRun::new(Scene::read(&file).unwrap(), &dir.join("parts"));
    let interrupt = run.interrupt.clone();
    let outcome = run.clone().start(&mut |step| {
        if step.step == 5 {
            interrupt.raise();
        }
        ControlFlow::Continue(())
    });
    let outcome = outcome.unwrap();
    assert_eq!((outcome.status, outcome.steps.len()), (Status::Stopped, 6));
    assert!(run.dir.join("final_state.csv").exists() && run.dir.join("picture.png").exists());
    let checkpoint = Checkpoint::read(&outcome.checkpoint.unwrap()).unwrap();
    assert_eq!(checkpoint.restart.place.num_steps, 5);

    // the flag is still up: no step is accepted, and the checkpoint stays what it is
    let again = run.clone().resume(&mut |_| panic!("nothing was to be accepted")).unwrap();
    assert_eq!((again.status, again.steps.len()), (Status::Stopped, 6));
    run.interrupt.lower();
    assert_eq!(run.clone().resume(&mut |_| ControlFlow::Continue(())).unwrap().status, Status::Converged);
    let whole = dir.join("whole");
    assert_eq!(
        run_scene(Scene::read(&file).unwrap(), &whole, &mut |_| ControlFlow::Continue(())).unwrap().steps.len(),
        8
    );
    assert_same(&whole, &run.dir);
    // this folder has kept the files of all steps, from which the page is made
    let page = |dir: &Path| std::fs::read(dir.join("view.html")).unwrap();
    assert!(page(&whole) == page(&run.dir));

    // before the start has come to rest there is nothing to go on from, but the files are in order
    run.interrupt.raise();
    let early = SceneRun { dir: dir.join("early"), ..run.clone() }.start(&mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!((early.status, early.checkpoint), (Status::Stopped, None));
    assert!(dir.join("early/summary.json").exists());
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn another_scene_is_refused() {
    let dir = folder("scene");
    let parts = dir.join("parts");
    let scene = |text: &str| Scene::from_toml(text, &dir).unwrap();
    let stop = &mut |_: &_| ControlFlow::Break(());
    let _ = run_scene(scene(RING), &parts, stop).unwrap();
    let go_on = |text: &str| SceneRun::new(scene(text), &parts).resume(&mut |_| ControlFlow::Break(()));
    let error = resume(&parts, stop).unwrap_err().to_string();
    assert!(error.contains("its scene came from no file"), "{error}");
    for (from, to, part) in [
        ("bending = 205.7", "bending = 205.70000000000002", "its rods, supports, loads or contact:"),
        ("closed = true", "closed = true\n    roll = 0.25", "its rods, supports, loads or contact:"),
        ("to = -1.3", "to = -1.4", "its stages:"),
        (
            "steps = 4",
            "steps = 4\n    [contact]\n    stiffness = 10.0\n    [solver]\n    max_iterations = 7",
            "contact and its solver",
        ),
    ] {
        let error = go_on(&RING.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.starts_with("scene: differs from the one the checkpoint was written for"), "{error}");
        assert!(error.contains(part), "{error}");
    }
    let harmless = RING
        .replace("title = \"ring\"", "title = \"other\" # a remark")
        .replace("[output]", "[solver]\nthreads = 2\n[output]\npicture = false");
    assert_eq!(go_on(&harmless).unwrap().steps.len(), 2);
    std::fs::remove_dir_all(&dir).unwrap();
}

/// A new checkpoint that cannot be written leaves the old one as it is; a new run sets it aside.
#[test]
fn the_old_checkpoint_is_kept() {
    let dir = folder("kept");
    let file = ring_file(&dir);
    let parts = dir.join("parts");
    let stop = |limit: usize| {
        move |step: &supercoil::observe::report::Observation| {
            if step.step < limit { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        }
    };
    let _ = run_scene(Scene::read(&file).unwrap(), &parts, &mut stop(2)).unwrap();
    let before = std::fs::read(parts.join(FILE_NAME)).unwrap();
    // where the new one is written before it takes the old one's name
    let obstacle = parts.join(format!("{FILE_NAME}.new"));
    std::fs::create_dir(&obstacle).unwrap();
    let error = resume(&parts, &mut stop(3)).unwrap_err().to_string();
    assert!(error.contains(FILE_NAME), "{error}");
    assert!(std::fs::read(parts.join(FILE_NAME)).unwrap() == before);
    std::fs::remove_dir(&obstacle).unwrap();
    let _ = run_scene(Scene::read(&file).unwrap(), &parts, &mut stop(1)).unwrap();
    assert!(std::fs::read(parts.join(format!("{FILE_NAME}.old"))).unwrap() == before);
    std::fs::remove_dir_all(&dir).unwrap();
}

fn program(arguments: &[&std::ffi::OsStr]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_supercoil"));
    command.args(arguments).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn start(file: &Path, dir: &Path) -> Child {
    program(&[
        "run".as_ref(),
        file.as_ref(),
        "--out".as_ref(),
        dir.as_ref(),
        "--checkpoint-every".as_ref(),
        "1".as_ref(),
    ])
    .spawn()
    .unwrap()
}

/// Waits until the child has written `file`, or has ended.
fn wait_for(file: &Path, child: &mut Child) {
    let started = Instant::now();
    while !file.exists() && child.try_wait().unwrap().is_none() {
        assert!(started.elapsed() < Duration::from_secs(300), "{} never came", file.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Killed where it happens to be (at the end of the wait it has been in a step for a while that differs from one
/// machine and one moment to the next), resumed and killed again, three times; then left to end. The mesh is fine
/// enough for the steps after the last kill to take far longer than the wait.
#[test]
fn a_killed_program_goes_on() {
    let dir = folder("killed");
    let file = ring_file(&dir);
    let fine = RING.replace("elements = 16", "elements = 64");
    assert_ne!(fine, RING);
    std::fs::write(&file, fine).unwrap();
    let (whole, parts) = (dir.join("whole"), dir.join("parts"));
    assert!(start(&file, &whole).wait().unwrap().success());
    let mut child = start(&file, &parts);
    for step in [1, 4, 5] {
        wait_for(&parts.join(format!("step_{step:04}.vtp")), &mut child);
        let odd = Instant::now().elapsed().subsec_nanos() + std::process::id();
        std::thread::sleep(Duration::from_micros(u64::from(odd % 97) * 400));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!parts.join("summary.json").exists(), "killed before the end");
        child = program(&["resume".as_ref(), parts.as_ref()]).spawn().unwrap();
    }
    let end = child.wait_with_output().unwrap();
    assert!(end.status.success(), "{}", String::from_utf8_lossy(&end.stderr));
    assert_same(&whole, &parts);
    std::fs::remove_dir_all(&dir).unwrap();
}

/// Exit code 130, a word on how to go on, and files in order; afterwards it goes on.
#[cfg(unix)]
#[test]
fn ctrl_c_ends_cleanly() {
    let dir = folder("ctrl_c");
    let file = ring_file(&dir);
    let (whole, parts) = (dir.join("whole"), dir.join("parts"));
    let signal =
        |child: &Child| Command::new("sh").arg("-c").arg(format!("kill -INT {}", child.id())).status().unwrap();
    assert!(start(&file, &whole).wait().unwrap().success());
    let mut child = start(&file, &parts);
    wait_for(&parts.join("step_0003.vtp"), &mut child);
    assert!(signal(&child).success());
    let end = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&end.stderr).into_owned();
    assert_eq!(end.status.code(), Some(130), "{said}");
    assert!(said.contains(&format!("to go on: supercoil resume {}", parts.display())), "{said}");
    for name in ["summary.json", "table.csv", "final_state.csv", "picture.png", FILE_NAME] {
        assert!(parts.join(name).exists(), "{name}");
    }
    assert!(program(&["resume".as_ref(), parts.as_ref()]).status().unwrap().success());
    assert_same(&whole, &parts);
    let end = program(&["resume".as_ref(), parts.as_ref()]).output().unwrap();
    assert_eq!(end.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&end.stderr).contains("there is no checkpoint to go on from"));
    std::fs::remove_dir_all(&dir).unwrap();
}
