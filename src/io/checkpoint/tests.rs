use std::ops::ControlFlow;

use super::*;
use crate::solve::run_from;
use crate::text::state_in_checkpoint;

const SCENE: &str = r#"
    [[rods]]
    name = "beam"
    shape = { kind = "line", length = 1.0 }
    section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }
    elements = 2
    [[supports]]
    at = "start"
    position = true
    rotation = true
    [[stages]]
    ramp = { load = 1.0 }
    steps = 2
    [[loads]]
    at = "end"
    force = [0.0, 0.1, 0.0]
"#;

/// A checkpoint of a small run.
fn checkpoint() -> Checkpoint {
    let scene = Scene::from_toml(SCENE, Path::new("")).unwrap();
    let fingerprint = Fingerprint::of(&scene);
    let mut restart = None;
    let _ = run_from(scene.model, &scene.stages, &Default::default(), None, &mut |_, waypoint| {
        restart = waypoint.restart();
        ControlFlow::Continue(())
    })
    .unwrap();
    let program = "0".to_owned();
    let scene = Some("/nowhere/scene.toml".into());
    Checkpoint {
        nodes: "rod,node\n0,0\n".repeat(20),
        program,
        scene,
        set: vec![],
        fingerprint,
        seconds: 0.1,
        restart: restart.unwrap(),
        record: RecordState::default(),
    }
}

#[test]
fn what_is_written_comes_back() {
    let path = std::env::temp_dir().join(format!("supercoil_checkpoint_{}", std::process::id()));
    let written = checkpoint();
    written.write(&path).unwrap();
    assert_eq!(Checkpoint::read(&path).unwrap(), written);
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(state_in_checkpoint(&bytes), Some(written.nodes.as_bytes()));
    assert_eq!(state_in_checkpoint(&bytes[..HEADER + 100]), None);
    assert!(!path.with_extension("new").exists());
    let size = std::fs::metadata(&path).unwrap().len();
    // the state and up to three before it, for predictions, and the nodes as text
    assert!(size < 4 * 7 * 88 + 500 + written.nodes.len() as u64, "{size} bytes for 7 nodes");
    std::fs::remove_file(&path).unwrap();
    let error = Checkpoint::read(&path).unwrap_err().to_string();
    assert!(error.ends_with("(a run that came to its end leaves none)"), "{error}");
    assert!(written.write(Path::new("/nowhere/x")).is_err());
}

/// Cut off anywhere, with a byte too many, or with any bit turned, it is refused; with a reason.
#[test]
fn damage_is_seen() {
    let bytes = checkpoint().to_bytes().unwrap();
    for length in 0..bytes.len() {
        let error = Checkpoint::from_bytes(&bytes[..length]).unwrap_err();
        let reason = if length < 8 { "is no checkpoint" } else { "is cut short" };
        assert!(error.starts_with(reason), "{length}: {error}");
    }
    let longer: Vec<u8> = bytes.iter().copied().chain([0]).collect();
    assert_eq!(Checkpoint::from_bytes(&longer).unwrap_err(), "has 1 bytes too many");
    for bit in 0..8 * bytes.len() {
        let mut turned = bytes.clone();
        turned[bit / 8] ^= 1 << (bit % 8);
        let error = Checkpoint::from_bytes(&turned).unwrap_err();
        let reason = match bit / 8 {
            0..8 => "is no checkpoint of this program",
            8..12 => "was written by a",
            12..HEADER => "is damaged: its head",
            _ => "is damaged: its content",
        };
        assert!(error.starts_with(reason), "bit {bit}: {error}");
    }
}

#[test]
fn other_versions_are_named() {
    let bytes = checkpoint().to_bytes().unwrap();
    for (version, age) in [(FORMAT + 1, "a newer"), (FORMAT - 1, "an older")] {
        let mut other = bytes.clone();
        other[8..12].copy_from_slice(&version.to_le_bytes());
        let error = Checkpoint::from_bytes(&other).unwrap_err();
        assert!(error.starts_with(&format!("was written by {age} version (format {version};")), "{error}");
    }
}

/// An illegal body with a correct checksum is refused, whatever the lengths of its lists.
#[test]
fn nonsense_is_not_understood() {
    for body in [vec![], vec![0xff; 400], vec![0; 3], b"no checkpoint, but as long as need be".to_vec()] {
        let mut bytes = checkpoint().to_bytes().unwrap();
        bytes.truncate(HEADER);
        bytes[12..20].copy_from_slice(&(body.len() as u64).to_le_bytes());
        bytes[20..24].copy_from_slice(&crc32fast::hash(&body).to_le_bytes());
        let check = crc32fast::hash(&bytes[..24]);
        bytes[24..HEADER].copy_from_slice(&check.to_le_bytes());
        bytes.extend(body);
        let error = Checkpoint::from_bytes(&bytes).unwrap_err();
        assert!(error.starts_with("cannot be understood"), "{error}");
    }
}

/// The solver refuses a checkpoint of another model, which only a caller that bypasses the fingerprint can pass.
#[test]
fn another_models_state_is_refused() {
    let scene = Scene::from_toml(&SCENE.replace("elements = 2", "elements = 3"), Path::new("")).unwrap();
    let go = |restart: Restart| {
        run_from(scene.model.clone(), &scene.stages, &Default::default(), Some(restart), &mut |_, _| {
            ControlFlow::Continue(())
        })
        .map(|_| ())
    };
    let restart = checkpoint().restart;
    let error = go(restart.clone()).unwrap_err().to_string();
    assert!(error.contains("another number of nodes"), "{error}");
    let mut lost = restart.clone();
    lost.place.stage = 1;
    assert!(go(lost).unwrap_err().to_string().contains("no place on this path"));
    let mut broken = restart;
    broken.state.nodes_mut().0[0].x = f64::NAN;
    assert!(go(broken).unwrap_err().to_string().contains("not finite"));
}
