//! Rods that are sheared: contact lies along their centrelines, whatever their sections do.
//!
//! Symptom: a rod whose ends are moved sideways until it is sheared by 25° ended "bent as tightly as it is thick", and
//! two of them pressed together at half the way. Mechanism: the contact centreline had the directors for its tangents,
//! and at 17° it turned by a right angle from node to node.

use std::f64::consts::FRAC_PI_2;
use std::ops::ControlFlow;
use std::path::Path;

use supercoil::math::Vec3;
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

/// A ring that is sheared beside its point of contact is in balance: what contact seems to do on the spin of its
/// sections does not count.
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

/// A rod across another at a place and an angle (rad), both clamped and as easily sheared as `shearing` says, and
/// pressed into it by `by`.
fn crossing(shearing: f64, radius: f64, elements: usize, [place, angle, by]: [f64; 3]) -> String {
    let (sin, cos) = angle.sin_cos();
    let section = format!(
        "section = {{ bending = 1.0, twisting = 0.8, stretching = 200.0, shearing = {shearing}, contact_radius = \
         {radius} }}\n\
         elements = {elements}\n"
    );
    let rod = |name: &str, start: [f64; 3], direction: [f64; 3]| {
        format!(
            "[[rods]]\nname = \"{name}\"\nshape = {{ kind = \"line\", start = {start:?}, direction = {direction:?}, \
             length = 1.0 }}\n{section}"
        )
    };
    let ends = ["start", "end"]
        .map(|at| format!("[[supports]]\nrod = [\"a\", \"b\"]\nat = \"{at}\"\nposition = true\nrotation = true\n"));
    let to = ["start", "end"].map(|at| format!("{{ rod = \"b\", at = \"{at}\", to = [0.0, 0.0, {}] }}", -by));
    format!(
        "{}{}{}[[stages]]\nramp = {{ displacement = [{}] }}\nsteps = 2\n",
        rod("a", [-0.5 - place, 0.0, 0.0], [1.0, 0.0, 0.0]),
        rod("b", [-0.5 * cos, -0.5 * sin, 2.0 * radius], [cos, sin, 0.0]),
        ends.concat(),
        to.join(", ")
    )
}

/// Symptom: a contact force of 15.586 between two rods whose supports carry 7.948. Mechanism: a point force kinks a
/// sheared rod by F/GA; a bend tighter than within the contact distance has two nearest points and a farthest one,
/// which the report counted as two contacts. Reference 7.947: shooting of the Simo–Reissner rods.
#[test]
fn contact_of_sheared_rods_is_what_their_supports_carry() {
    let last = |text: &str| states_of(text).pop().unwrap();
    let seen = last(&crossing(30.0, 0.01, 32, [0.0, FRAC_PI_2, 0.2]));
    println!("contact force {}, resultant {}", seen.total_contact_force, seen.contact_resultants);
    assert!((seen.contact_resultants / 7.947 - 1.0).abs() < 5e-4, "{}", seen.contact_resultants);
    // the integral is more than the resultant, because the direction of the pressure varies along the bend
    assert!((seen.total_contact_force / 7.947 - 1.0).abs() < 2e-3, "{}", seen.total_contact_force);
    for (shearing, radius, elements, at) in [
        (12.8, 0.01794, 24, [0.0, FRAC_PI_2, 0.1282]),
        (95.3, 0.009285, 40, [0.0, FRAC_PI_2, 0.21374]),
        (74.2, 0.0161, 24, [0.0, FRAC_PI_2, 0.1803]),
        (40.0, 0.01, 24, [0.13, 1.3, 0.2]),
    ] {
        let seen = last(&crossing(shearing, radius, elements, at));
        let of_supports: Vec3 = seen.reactions.iter().filter(|r| r.rod == 0).map(|r| Vec3::from(r.force)).sum();
        let of_sites: Vec3 = seen.sites.iter().map(|site| Vec3::from(site.force_on_a)).sum();
        println!("{shearing} {at:?}: supports {of_supports:?}, sites {of_sites:?}, {}", seen.total_contact_force);
        assert!(
            (of_supports + of_sites).norm() < 1e-6 * of_sites.norm(),
            "{shearing} {at:?}: {of_supports:?} {of_sites:?}"
        );
        assert!(seen.total_contact_force < 1.02 * of_sites.norm(), "{shearing} {at:?}: {}", seen.total_contact_force);
    }
}
