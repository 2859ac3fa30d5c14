//! Rings linked into a chain and pulled, as scene files: rods that only other rods hold.
//!
//! ```text
//!      ___      ___      ___
//!   |-/ a \----/---\----/ c \-> d     a and c in the plane z = 0, held at their outermost nodes; b across them, free
//!     \___/-b--\---/----\___/
//! ```
//!
//! B = C = 1, EA = GA = 1e6, contact radius ε = .05, rings of radius 1, centres 1.7 apart. Where the outermost nodes
//! are ℓ apart, each ring has been stretched to the width W = (ℓ + 4ε)/3 by forces at two opposite points, whose size
//! is that of the closed inextensible elastica: a quarter of it, length π/2, has θ″ = −(F/2) sin θ between θ = π/2 at
//! the force and π where it crosses its other axis. It is integrated here. (Tolerance: stretch and the zone over which
//! points of contact are spread.)
//!
//! Before, the swing of a ring about the tangent where it is held, with the spin that takes it back, was left to
//! rounding in models of several rods, and a ring just touched by one that drags it counted as unstable.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;

use common::{root, runge_kutta, verify};
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::scene::Scene;
use supercoil::solve::{self, Options, Status};

/// Angle and distance along the force at the end of a quarter of the elastica, from θ = π/2 with curvature `k`.
fn quarter(force: f64, k: f64) -> [f64; 2] {
    let rate = |y: &[f64; 3]| [y[1], -0.5 * force * y[0].sin(), y[0].cos()];
    let y = runge_kutta::along(rate, [0.5 * PI, k, 0.0], 0.5 * PI, 400);
    [y[0], y[2]]
}

/// The force that stretches a ring of radius 1 to a width.
fn force_at(width: f64) -> f64 {
    root(0.01, 6.0, |force| {
        let k = root(1.0, 4.0, |k| quarter(force, k)[0] - PI);
        -2.0 * quarter(force, k)[1] - width
    })
}

fn ring(name: &str, x: f64, normal: &str) -> String {
    format!(
        "[[rods]]\nname = \"{name}\"\nclosed = true\n\
         shape = {{ kind = \"circle\", radius = 1.0, center = [{x}, 0.0, 0.0], normal = {normal} }}\n\
         section = {{ bending = 1.0, twisting = 1.0, stretching = 1e6, shearing = 1e6, contact_radius = 0.05 }}\n\
         elements = 24\n"
    )
}

fn clamp(rod: &str, at: &str) -> String {
    format!("[[supports]]\nrod = \"{rod}\"\nat = {at}\nposition = true\nrotation = true\n")
}

/// The last state of a scene, which must come to rest at every step.
fn rest(text: &str) -> Observation {
    let scene = Scene::from_toml(text, Path::new("")).unwrap();
    let mut last = None;
    let solution = solve::run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
        last = Some(observe(progress));
        ControlFlow::Continue(())
    });
    assert_eq!(solution.unwrap().status, Status::Converged);
    let last = last.unwrap();
    assert_eq!(last.num_unstable, 0);
    last
}

#[test]
fn three_rings_pulled() {
    let pull =
        "[[stages]]\nramp = { displacement = { rod = \"c\", at = \"start\", to = [1.6, 0.0, 0.0] } }\nsteps = 6\n";
    let rings = ring("a", 0.0, "[0, 0, 1]") + &ring("b", 1.7, "[0, 1, 0]") + &ring("c", 3.4, "[0, 0, 1]");
    // a contact's force is the sum of sizes over its zone, about which normals turn: a harder law than this mesh is
    // given by itself, and a smaller zone
    let law = "[contact]\nstiffness = 100.0\n";
    let state = rest(&(rings + law + &clamp("a", &format!("{{ arc = {PI} }}")) + &clamp("c", "\"start\"") + pull));
    let force = force_at((5.4 + 1.6 + 4.0 * 0.05) / 3.0);
    for (name, reaction, sign) in [("a", &state.reactions[0], -1.0), ("c", &state.reactions[1], 1.0)] {
        verify(
            "chain of three rings",
            &format!("force on {name}, R²/B"),
            sign * reaction.force[0],
            force,
            4e-5 * force,
        );
        let across = reaction.force[1].hypot(reaction.force[2]) + reaction.moment.iter().map(|m| m.abs()).sum::<f64>();
        assert!(across < 1e-6, "{across:e}");
    }
    assert_eq!(state.num_sites, 2);
    for site in &state.sites {
        verify("chain of three rings", "force of a contact, R²/B", site.force, force, 4e-4 * force);
    }
}

/// A ring that another one drags along goes with it at no cost; the first distance has them just touch at a step's end.
#[test]
fn a_ring_dragged_along() {
    for law in ["augmented-lagrangian", "penalty"] {
        for distance in [0.5, 0.52] {
            let drag = format!(
                "[[stages]]\nramp = {{ displacement = {{ rod = \"c\", at = \"start\", to = [{distance}, 0.0, 0.0] }} \
                 }}\nsteps = 5\n\
                 [contact]\nlaw = \"{law}\"\n"
            );
            let rings = ring("b", 1.7, "[0, 1, 0]") + &ring("c", 3.4, "[0, 0, 1]");
            let state = rest(&(rings + &clamp("c", "\"start\"") + &drag));
            let (energy, free) = (state.energies.total, 2.0 * PI);
            assert!((energy / free - 1.0).abs() < 1e-8, "{law}, {distance}: {energy} {free}");
            assert!(state.total_contact_force < 1e-6, "{law}, {distance}: {:e}", state.total_contact_force);
        }
    }
}

/// Rings beside each other, each held at one node: it swings about its tangent there and spins back at no cost.
#[test]
fn rings_held_beside_each_other() {
    for law in ["augmented-lagrangian", "none"] {
        let rings = ring("a", 0.0, "[0, 0, 1]") + &ring("b", 5.0, "[0, 1, 2]") + &ring("c", 9.0, "[0, 0, 1]");
        let held = clamp("a", "7") + &clamp("c", "\"start\"") + &format!("[contact]\nlaw = \"{law}\"\n");
        let energy = rest(&(rings + &held)).energies.total;
        assert!((energy / (3.0 * PI) - 1.0).abs() < 1e-8, "{energy}");
    }
}
