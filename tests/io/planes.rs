//! Planes in scene files: what is refused, and what a run writes about them.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::io::run::run_scene;
use supercoil::scene::Scene;
use supercoil::solve::Status;

use crate::program::{folder, number, table};

const RING: &str = r#"
planar = true
[[rods]]
name = "ring"
closed = true
shape = { kind = "circle", radius = 1.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.05 }
elements = 16
[[planes]]
name = "lower"
point = [0.0, -1.05, 0.0]
normal = [0.0, 1.0, 0.0]
[[planes]]
name = "upper"
point = [3.0, 1.05, 0.0]
normal = [0.0, -1.0, 0.0]
[[stages]]
ramp = { plane = { name = "upper", to = 0.2 } }
steps = 2
"#;

#[test]
fn planes_without_sense_are_refused() {
    Scene::from_toml(RING, Path::new("")).unwrap();
    for (from, to, reasons) in [
        ("normal = [0.0, 1.0, 0.0]", "normal = [0.0, 0.0, 0.0]", &["planes[0].normal", "(0, 0, 0)", "unit vector"][..]),
        ("normal = [0.0, 1.0, 0.0]", "normal = [0.0, 2.0, 0.0]", &["planes[0].normal", "(0, 2, 0)", "unit vector"]),
        ("normal = [0.0, 1.0, 0.0]", "normal = [0.0, 0.0, 1.0]", &["planes[0].normal", "(0, 0, 1)", "x-y plane"]),
        ("point = [0.0, -1.05, 0.0]", "point = [0.0, nan, 0.0]", &["planes[0].point", "finite"]),
        (
            "point = [0.0, -1.05, 0.0]",
            "point = [0.0, -0.95, 0.0]",
            &["planes[0]", "\"ring\" starts beyond it", "deep at arc "],
        ),
        ("name = \"lower\"\n", "", &["planes[0].name", "missing"]),
        ("name = \"lower\"", "name = \"upper\"", &["planes[1].name", "no other plane or obstacle has"]),
        (
            "{ name = \"upper\", to",
            "{ name = \"uper\", to",
            &["stages[0].ramp.plane.name", "uper", "\"lower\", \"upper\""],
        ),
        ("to = 0.2 }", "to = inf }", &["stages[0].ramp.plane.to", "finite"]),
        ("contact_radius = 0.05", "contact_radius = 0.0", &["planes[0]", "contact_radius"]),
        ("planar = true", "planar = true\ncontact = { law = \"none\" }", &["planes[0]", "leave contact on"]),
        ("steps = 2", "steps = 2\nfollow = {}", &["stages[0].follow", "planes"]),
    ] {
        assert!(RING.contains(from), "{from}");
        let message = match Scene::from_toml(&RING.replacen(from, to, 1), Path::new("")) {
            Ok(_) => "accepted".to_owned(),
            Err(error) => error.to_string(),
        };
        for reason in reasons {
            assert!(message.contains(reason), "{to}: {message}");
        }
    }
}

/// Symptom: each picture of a film strip was centred by itself, so that a plane that is held seemed to move.
#[test]
fn a_film_strip_has_one_camera() {
    let dir = folder("strip");
    let scene = Scene::from_toml(&format!("{RING}[output]\nvtk = false\n"), Path::new("")).unwrap();
    let outcome = run_scene(scene, &dir, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(outcome.status, Status::Converged);
    let strip = image::open(dir.join("filmstrip.png")).unwrap().to_luma8();
    let width = strip.width() / 3;
    // planes are seen edge on: as lines across
    let lines = |frame: u32| -> Vec<u32> {
        let columns = || frame * width..(frame + 1) * width;
        let inked = |row: u32| columns().filter(|&x| strip.get_pixel(x, row)[0] < 255).count();
        (0..strip.height()).filter(|&row| 10 * inked(row) > 9 * width as usize).collect()
    };
    let [first, last] = [lines(0), lines(2)];
    assert_eq!(first.last(), last.last(), "the lower plane stands: {first:?} {last:?}");
    assert!(first[0] + 5 < last[0], "the upper one comes down: {first:?} {last:?}");
    std::fs::remove_dir_all(&dir).unwrap();
}

/// ParaView shows obstacles beside rods, where they are in each step; a run that writes anew leaves none of before.
#[test]
fn collections_have_obstacles_as_their_second_part() {
    let dir = folder("parts");
    std::fs::create_dir_all(&dir).unwrap();
    std::fs::write(dir.join("obstacles_0007.vtp"), "of a longer run").unwrap();
    let scene = Scene::from_toml(RING, Path::new("")).unwrap();
    let outcome = run_scene(scene, &dir, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(outcome.status, Status::Converged);
    let collection = std::fs::read_to_string(dir.join("run.pvd")).unwrap();
    let steps = collection.matches("part=\"0\" file=\"step_").count();
    assert!(steps > 1 && !dir.join("obstacles_0007.vtp").exists());
    for step in 0..steps {
        let file = format!("obstacles_{step:04}.vtp");
        assert!(collection.contains(&format!("part=\"1\" file=\"{file}\"")), "{collection}");
        let bytes = std::fs::read(dir.join(file)).unwrap();
        assert!(String::from_utf8_lossy(&bytes).contains("Name=\"obstacle\""));
    }
    let of = |step: usize| std::fs::read(dir.join(format!("obstacles_{step:04}.vtp"))).unwrap();
    assert_ne!(of(0), of(steps - 1), "the upper plane has moved");
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn tables_tell_planes_forces_and_sites() {
    let dir = folder("planes");
    let scene = Scene::from_toml(RING, Path::new("")).unwrap();
    let outcome = run_scene(scene, &dir, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(outcome.status, Status::Converged);
    let (_, steps) = table(&dir.join("table.csv"));
    let last = &steps[steps.len() - 1];
    let [lower, upper] = ["lower_force", "upper_force"].map(|name| number(last, name));
    assert!(lower > 0.5 && (lower - upper).abs() < 1e-6, "{lower} {upper}");
    assert_eq!((number(last, "upper_displaced"), last["num_sites"].as_str()), (0.2, "2"));
    assert!((number(last, "contact_force") - lower - upper).abs() < 1e-12);
    assert!(number(last, "penetration") <= 5.1e-10);
    let sites = table(&dir.join("sites.csv")).1;
    assert_eq!(sites.iter().map(|site| site["rod_b"].as_str()).collect::<Vec<_>>(), ["lower", "upper"]);
    for (site, sign) in sites.iter().zip([1.0, -1.0]) {
        assert_eq!((site["rod_a"].as_str(), site["kind"].as_str(), site["from_b"].as_str()), ("ring", "point", ""));
        assert!((number(site, "force_on_a_y") - sign * lower).abs() < 1e-6, "{site:?}");
    }
    // pages and pictures show them
    let page = std::fs::read_to_string(dir.join("view.html")).unwrap();
    assert!(
        page.contains("\"lines\":[{\"obstacle\":")
            && page.contains("\"ends\":[[")
            && page.contains("\"images\":[[[1.0,0.0,0.0,0.0]")
    );
    std::fs::remove_dir_all(&dir).unwrap();
}
