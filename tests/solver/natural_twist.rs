//! Rods with a natural twist start relaxed, closed or open; link and turns of ends count from there.

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;

use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::scene::Scene;
use supercoil::solve::{self, Options, Status};

const LENGTH: f64 = 114.24;
const TWISTING: f64 = 308.6;

/// All states of a scene of one rod.
fn states(text: &str) -> Vec<Observation> {
    let scene = Scene::from_toml(text, Path::new("")).expect("sound scene");
    let mut seen = Vec::new();
    let solution = solve::run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
        seen.push(observe(progress));
        ControlFlow::Continue(())
    });
    assert_eq!(solution.expect("sound scene").status, Status::Converged);
    seen
}

fn ring(keys: &str, ramp: &str) -> Vec<Observation> {
    states(&format!(
        "[[rods]]\nclosed = true\nshape = {{ kind = \"circle\", length = {LENGTH} }}\nelements = 240\n{keys}\n\
         section = {{ bending = 205.7, twisting = {TWISTING}, stretching = 1e4, shearing = 1e4, contact_radius = 0.0 \
         }}\n\
         [[stages]]\nramp = {{ {ramp} }}\nsteps = 2"
    ))
}

/// Before, the link of a ring with 32 turns of natural twist was counted from no twist at all: excess link 0 was 32
/// turns from rest.
#[test]
fn excess_link_is_counted_from_nature() {
    let natural = format!("natural = {{ twist = {} }}", 31.99 * TAU / LENGTH);
    let straight = ring("", "excess_link = { to = -0.5 }");
    for (keys, ramp) in [
        (natural.clone(), "excess_link = { to = -0.5 }"),
        (format!("{natural}\nexcess_link = 0.0"), "excess_link = { to = -0.5 }"),
        (format!("{natural}\nlink = 31.99"), "link = { to = 31.49 }"),
    ] {
        let twisted = ring(&keys, ramp);
        let (first, last) = (twisted[0].links[0], twisted[2].links[0]);
        assert!(first.excess_link.abs() < 1e-12 && (first.link - 31.99).abs() < 1e-9, "{keys}: {first:?}");
        assert!((last.excess_link + 0.5).abs() < 1e-12 && (last.link - 31.49).abs() < 1e-9, "{keys}: {last:?}");
        for (ours, theirs) in twisted.iter().zip(&straight) {
            // isotropic: what is natural twist shows nowhere else
            let (a, b) = (ours.energies.total, theirs.energies.total);
            assert!((a / b - 1.0).abs() < 1e-5, "{keys}: {a} {b}");
        }
    }
}

/// A trefoil that is free of stress as it is has no excess link; three turns put in are three turns.
#[test]
fn what_is_as_shaped_has_no_excess() {
    let text = |link: &str| {
        format!(
            "[contact]\nlaw = \"none\"\n[[rods]]\nclosed = true\n\
             shape = {{ kind = \"torus_knot\", windings = [2, 3], length = 30.0 }}\n\
             elements = 60\nnatural = \"as-shaped\"\n{link}\n\
             section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.1 }}"
        )
    };
    for link in ["", "excess_link = 0.0"] {
        let rest = &states(&text(link))[0];
        assert!(rest.energies.total < 1e-16 && rest.links[0].excess_link == 0.0, "{:?}", rest.links);
        assert!(rest.links[0].link > 3.0, "{:?}", rest.links);
    }
    let twisted = &states(&text("excess_link = 0.25"))[0];
    assert!((twisted.links[0].excess_link - 0.25).abs() < 1e-12 && twisted.energies.total > 1e-3);
}

fn rod(keys: &str, ramp: &str) -> Vec<Observation> {
    states(&format!(
        "[contact]\nlaw = \"none\"\n[[rods]]\nshape = {{ kind = \"line\", length = {LENGTH} }}\nelements = 120\n\
         {keys}\n\
         section = {{ bending = 205.7, twisting = {TWISTING}, stretching = 1e4, shearing = 1e4 }}\n\
         [[supports]]\nat = \"start\"\nposition = true\nrotation = true\n\
         [[supports]]\nat = \"end\"\nposition = true\nrotation = true\n\
         [[stages]]\nramp = {{ {ramp} }}\nsteps = 1"
    ))
}

/// Before, a clamped rod with fifteen turns of natural twist started fifteen turns off.
#[test]
fn clamped_rods_start_relaxed_and_turn_from_there() {
    let natural = format!("natural = {{ twist = {} }}", 15.0 * TAU / LENGTH);
    let of_twist = |turns: f64| 0.5 * TWISTING * (TAU * turns).powi(2) / LENGTH;
    let turn = "rotation = { at = \"end\", axis = [1, 0, 0], turns = 0.3 }";
    for (keys, start, end) in [
        (natural.clone(), 0.0, 0.3),
        (format!("{natural}\ntwist = 0.2"), 0.2, 0.5),
        ("twist = -0.5".to_owned(), -0.5, -0.2),
    ] {
        let seen = rod(&keys, turn);
        for (state, turns) in seen.iter().zip([start, end]) {
            let (found, exact) = (state.energies.total, of_twist(turns));
            assert!((found - exact).abs() < 1e-5 * of_twist(0.5), "{keys}: {found} {exact}");
        }
    }
}
