//! The numbers of `docs/GALLERY.md`, to the digits printed there.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use supercoil::io::run::options;
use supercoil::observe::observe;
use supercoil::scene::Scene;
use supercoil::solve::{self, Status};

/// Scenes that take seconds.
const SLOW: [&str; 9] = [
    "pbr322",
    "lambda_phage",
    "cable",
    "tweezers",
    "tweezers_on_glass",
    "tight_knot",
    "strand",
    "ball_of_string",
    "overhand",
];

/// Scene, quantity and value of each row.
fn rows() -> Vec<[String; 3]> {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/GALLERY.md")).unwrap();
    let rows = text.lines().filter_map(|line| line.strip_prefix("| `"));
    let cells = |row: &str| {
        let mut cells = row.split('|').map(|cell| cell.trim().trim_matches('`').to_owned());
        std::array::from_fn(|_| cells.next().unwrap())
    };
    rows.map(cells).collect()
}

/// A scene of `examples/`, or one that `supercoil new` writes.
fn file_of(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let example = root.join(format!("examples/{name}.toml"));
    if example.exists() { example } else { root.join(format!("assets/scenes/{name}.toml")) }
}

fn check(scenes: impl Fn(&str) -> bool) {
    let mut differs = Vec::new();
    for [name, quantity, printed] in rows().into_iter().filter(|[name, ..]| scenes(name)) {
        let scene = Scene::read(&file_of(&name)).unwrap();
        let choices = options(&scene);
        let mut last = None;
        let solution = solve::run(scene.model, &scene.stages, &choices, &mut |progress| {
            last = Some(observe(progress));
            ControlFlow::Continue(())
        });
        assert_eq!(solution.unwrap().status, Status::Converged, "{name}");
        let state = last.unwrap();
        let value = match quantity.as_str() {
            "writhe" => state.links.first().map_or_else(|| state.ends[0].writhe.unwrap(), |link| link.writhe),
            "energy" => state.energies.total,
            _ => state.total_contact_force,
        };
        let decimals = printed.split('.').nth(1).map_or(0, str::len);
        if format!("{value:.decimals$}") != printed {
            differs.push(format!("{name}: {quantity} {value}, printed {printed}"));
        }
    }
    assert!(differs.is_empty(), "{differs:#?}");
}

#[test]
fn gallery_of_quick_scenes() {
    assert_eq!(rows().len(), 23);
    check(|name| !SLOW.contains(&name));
}

#[test]
#[ignore = "slow: some minutes"]
fn gallery_of_slow_scenes() {
    check(|name| SLOW.contains(&name));
}
