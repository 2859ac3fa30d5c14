//! Rods that are sheared: contact lies along their centrelines, whatever their sections do.
//!
//! Symptom: a rod whose ends are moved sideways until it is sheared by 25° ended "bent as tightly as it is thick", and
//! two of them pressed together at half the way. Mechanism: the contact centreline had the directors for its tangents, and
//! at 17° it turned by a right angle from node to node.

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::scene::Scene;
use supercoil::solve::{Options, Status, run};

/// The states of all steps.
fn states_of(text: &str) -> Vec<Observation> {
    let scene = Scene::from_toml(text, Path::new("")).unwrap();
    let mut states = Vec::new();
    let solution = run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
        states.push(observe(progress));
        ControlFlow::Continue(())
    });
    let solution = solution.unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure.map(|failure| failure.to_string()));
    states
}

/// A post of length 1 between clamps, which shears as easily as rubber ten times softer than it should be.
fn post(name: &str, shape: &str, radius: &str, elements: usize) -> String {
    let ends = ["start", "end"]
        .map(|at| format!("[[supports]]\nrod = \"{name}\"\nat = \"{at}\"\nposition = true\nrotation = true\n"));
    format!(
        "[[rods]]\nname = \"{name}\"\nshape = {{ kind = \"line\", {shape}, length = 1.0 }}\n\
         section = {{ bending = 1.0, twisting = 1.0, stretching = 40.0, shearing = 10.0, contact_radius = {radius} }}\n\
         elements = {elements}\n{}",
        ends.concat()
    )
}

/// Apart from others contact is not felt.
#[test]
fn a_sheared_rod_does_not_touch_itself() {
    let energy_and_shear = |radius: &str| {
        let stage = "[[stages]]\nramp = { displacement = [{ at = \"end\", to = [0.0, 0.6, 0.0] }] }\nsteps = 6\n";
        let rod = post("post", "start = [0.0, 0.0, 0.0], direction = [1.0, 0.0, 0.0]", radius, 16);
        let states = states_of(&format!("{rod}{stage}"));
        let energies = states[states.len() - 1].energies;
        assert!(energies.shearing > 0.5 * energies.total, "{energies:?}");
        energies.total
    };
    let [thick, thin] = ["0.1", "0.0"].map(energy_and_shear);
    assert!((thick / thin - 1.0).abs() < 1e-9, "{thick} {thin}");
}

/// A post is pushed across another: both are sheared to 27° where they touch.
#[test]
fn sheared_rods_press_each_other() {
    let energy = |elements: usize| {
        let radius = "0.1";
        let post_on = post("post", "start = [0.0, 0.0, 0.0], direction = [1.0, 0.0, 0.0]", radius, elements);
        let bar = post("bar", "start = [0.5, 0.25, -0.5], direction = [0.0, 0.0, 1.0]", radius, elements);
        let stage = "[[stages]]\nramp = { displacement = [{ rod = \"post\", at = \"start\", to = [0.0, 0.4, 0.0] }, \
                     { rod = \"post\", at = \"end\", to = [0.0, 0.8, 0.0] }] }\nsteps = 8\n";
        let states = states_of(&format!("{post_on}{bar}{stage}"));
        let last = &states[states.len() - 1];
        assert!(!last.sites.is_empty() && last.sites.iter().all(|site| site.gap >= -1e-9), "{:?}", last.sites);
        last.energies.total
    };
    let [coarse, fine] = [12, 16].map(energy);
    println!("energies on 12 and 16 elements {coarse} {fine}");
    assert!((coarse / fine - 1.0).abs() < 2e-4, "{coarse} {fine}");
}

/// A ring that is sheared beside its point of contact is in balance: what contact seems to do on the spin of its sections
/// does not count.
#[test]
fn a_sheared_ring_is_in_balance() {
    let text = "[[rods]]\nclosed = true\nshape = { kind = \"circle\", length = 1.0 }\n\
        section = { bending = 1.0, twisting = 1.5, stretching = 1e6, shearing = 300, contact_radius = 0.01 }\n\
        elements = 32\n[[stages]]\nramp = { excess_link = { to = 1.6 } }\nsteps = 8\n";
    let scene = Scene::from_toml(text, Path::new("")).unwrap();
    let solution = run(scene.model, &scene.stages, &Options::default(), &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(solution.status, Status::Converged);
    let residual = solution.solver.engine().relative_residual();
    println!("relative residual {residual:e}");
    assert!(residual < 1e-8, "{residual:e}");
}
