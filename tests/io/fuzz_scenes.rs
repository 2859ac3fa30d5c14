//! Scenes with anything in them: the examples, with elements given and with a preset, with numbers replaced by extreme
//! ones, keys dropped, doubled or misspelt, types swapped.
//!
//! Promise: a scene is refused with an [`InputError`](supercoil::InputError), or accepted; an accepted one runs a
//! bounded search that ends with a status (or an error) and, if it says it converged, in finite numbers. Never a panic.
//! `SUPERCOIL_FUZZ_SEED` as in `fuzz_library`.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::path::Path;

use common::observed;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use supercoil::scene::Scene;
use supercoil::solve::{Options, Solver, Status};

/// Two rods joined at a right angle and carried round at their far ends.
const CORNER: &str = r#"
[[rods]]
name = "column"
shape = { kind = "line", direction = [0, 1, 0], length = 1.0 }
section = { young = 100.0, poisson = 0.3, circle = 0.05, contact_radius = 0.0 }
elements = 3
[[rods]]
name = "beam"
shape = { kind = "line", start = [0, 1, 0], length = 1.0 }
section = { young = 100.0, poisson = 0.3, circle = 0.05 }
elements = 3
[[supports]]
rod = "column"
at = 0
position = true
rotation = true
[[supports]]
rod = ["beam"]
at = "end"
position = true
rotation = true
[[joints]]
a = { rod = "column", at = { arc = 1.0 } }
b = { rod = "beam", at = 0 }
[[loads]]
rod = "beam"
at = 3
force = [0, -0.01, 0]
[[stages]]
ramp = { load = 1.0, rotation = { rod = "beam", at = "end", axis = [0, 1, 0], through = [0, 0.5, 0.1], turns = 0.05 } }
steps = 2
"#;

const SCENES: [&str; 5] = [
    CORNER,
    include_str!("../../examples/minicircle.toml"),
    include_str!("../../examples/elastica.toml"),
    include_str!("../../examples/ring_pressure.toml"),
    include_str!("../../examples/crossed_beams.toml"),
];

const VALUES: [&str; 32] = [
    "nan",
    "inf",
    "-inf",
    "0",
    "0.0",
    "-0.0",
    "-1",
    "1",
    "5e-324",
    "1e-308",
    "1e-300",
    "1e-160",
    "1e-30",
    "1e-9",
    "0.5",
    "3",
    "1e3",
    "1e9",
    "1e30",
    "1e155",
    "1e300",
    "1.7e308",
    "-1e300",
    "9223372036854775807",
    "true",
    "\"x\"",
    "[]",
    "{}",
    "[1e300, 1e-300]",
    "[nan, 0.0, 0.0]",
    "\"start\"",
    "2",
];

/// The scenes as they are, and with a preset in place of numbers of elements.
fn scenes() -> Vec<String> {
    let preset = |text: &&str| {
        let open: Vec<&str> = text.lines().filter(|line| !line.starts_with("elements")).collect();
        format!("fidelity = \"draft\"\n{}", open.join("\n"))
    };
    SCENES.iter().map(|text| (*text).to_owned()).chain(SCENES.iter().map(preset)).collect()
}

/// Where the numbers of a text are, comments left out.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let (bytes, mut found, mut i, mut quoted) = (text.as_bytes(), Vec::new(), 0, false);
    while i < bytes.len() {
        let c = bytes[i];
        if c == b'"' {
            quoted = !quoted;
        } else if c == b'#' && !quoted {
            while i < bytes.len() && bytes[i] != b'\n' {
                i += 1;
            }
            continue;
        } else if !quoted && (c.is_ascii_digit() || c == b'-') && i > 0 && b" [,=".contains(&bytes[i - 1]) {
            let start = i;
            while i < bytes.len() && (bytes[i].is_ascii_alphanumeric() || b".+-_".contains(&bytes[i])) {
                i += 1;
            }
            found.push((start, i));
            continue;
        }
        i += 1;
    }
    found
}

/// One change of a text: (kind, where, with what).
fn mutate(text: &str, (kind, place, value): (u8, usize, usize)) -> String {
    let places = numbers(text);
    match kind {
        0..=5 if !places.is_empty() => {
            let (a, b) = places[place % places.len()];
            format!("{}{}{}", &text[..a], VALUES[value % VALUES.len()], &text[b..])
        }
        // a text may have been cut to nothing
        6 | 7 if !text.is_empty() => {
            let mut lines: Vec<&str> = text.lines().collect();
            let at = place % lines.len();
            if kind == 6 {
                lines.remove(at);
            } else {
                lines.insert(at, lines[at]);
            }
            lines.join("\n")
        }
        8 => {
            let keys: Vec<(usize, &str)> = text.match_indices(" = ").collect();
            if keys.is_empty() {
                return text.to_owned();
            }
            let at = keys[place % keys.len()].0;
            format!("{}x{}", &text[..at], &text[at..])
        }
        _ => {
            let cut = (0..=place % (text.len() + 1)).rev().find(|&i| text.is_char_boundary(i)).unwrap();
            text[..cut].to_owned()
        }
    }
}

/// Reads a scene and, if it is accepted and small, goes a bounded way.
fn survive(text: &str) -> &'static str {
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let Ok(scene) = Scene::from_toml(text, &base) else { return "refused" };
    let nodes: usize = scene.model.rods.iter().map(|rod| rod.num_nodes()).sum();
    if nodes > 400 {
        return "large";
    }
    let mut options = Options { max_augmentations: 2, max_escapes: 1, ..Options::default() };
    options.newton.max_iterations = 4;
    let Ok(mut solver) = Solver::new(scene.model, options) else { return "refused by the solver" };
    let Some(stage) = scene.stages.first() else { return "no stage" };
    let Ok(report) = solver.step_through(stage) else { return "refused ramp" };
    let seen = observed(&solver, &report);
    if report.status == Status::Converged {
        assert!(seen.energies.total.is_finite(), "converged to an energy of {:?}:\n{text}", seen.energies);
        return "converged";
    }
    "not converged"
}

fn fuzz(cases: u32) {
    let mut runner = TestRunner::new_with_rng(
        Config { cases, failure_persistence: None, max_shrink_iters: 200, ..Config::default() },
        common::fuzz::rng(),
    );
    let change = (0u8..10, any::<usize>(), any::<usize>());
    let tally = std::cell::RefCell::new(std::collections::BTreeMap::<&str, usize>::new());
    let scenes = scenes();
    runner
        .run(&(0..scenes.len(), prop::collection::vec(change, 1..4)), |(scene, changes)| {
            let text = changes.into_iter().fold(scenes[scene].clone(), |text, change| mutate(&text, change));
            *tally.borrow_mut().entry(survive(&text)).or_default() += 1;
            Ok(())
        })
        .unwrap();
    println!("{:?}", tally.borrow());
}

#[test]
fn mutated_scenes_are_refused_or_survive() {
    fuzz(400);
}

#[test]
#[ignore = "the large budget: minutes"]
fn many_mutated_scenes_are_refused_or_survive() {
    fuzz(20_000);
}

/// Every number of every scene, one after the other, replaced by every extreme one.
#[test]
fn every_number_replaced() {
    let mut tally = std::collections::BTreeMap::<&str, usize>::new();
    for text in scenes() {
        for (a, b) in numbers(&text) {
            for value in ["nan", "inf", "-inf", "5e-324", "1e300", "-1e300"] {
                let ends = survive(&format!("{}{value}{}", &text[..a], &text[b..]));
                assert!(!(value.ends_with("nan") && ends != "refused"), "nan {ends} at {}", &text[..a]);
                *tally.entry(ends).or_default() += 1;
            }
        }
    }
    println!("{tally:?}");
}
