//! Contact that carries next to nothing comes to rest: what is pushed only as far as it gets out of the way.
//!
//! Symptom: load steps cut until they were too small, each try spending 500 iterations on steps that changed nothing.
//! Mechanism: strands that touch without a load may roll or slide off at no cost, so the tangent's smallest eigenvalue
//! is zero but for rounding, and the search goes with a shift. Under one no search that prepares the next took itself
//! for at rest unless its increments were below the tolerance, which what rounding makes of such a motion never is
//! (forces in balance to 5e-15, increments of 1e-7 node spacings), nor is a drift along a valley that has no slope to
//! speak of (decreases of the potential of 7e-13, its rounding 3e-10).

#![allow(clippy::unwrap_used)] // helpers of tests

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::scene::Scene;
use supercoil::solve::{self, Options, Status};

/// The last state of a scene, which must come to its end within so many steps.
fn end_of(text: &str, steps: usize) -> Observation {
    let scene = Scene::from_toml(text, Path::new("")).unwrap();
    let mut last = None;
    let solution = solve::run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
        last = Some(observe(progress));
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure.map(|failure| failure.to_string()));
    assert!(solution.num_steps <= steps, "{} steps", solution.num_steps);
    last.unwrap()
}

/// A free loop is drawn through a stiff ring by one node, which it swings about: it meets the ring and turns away.
/// (Before: stuck at 21 % after 35 s, load step too small.)
#[test]
fn a_free_loop_drawn_through_a_ring() {
    let end = end_of(
        r#"
        [[rods]]
        name = "ring"
        closed = true
        shape = { kind = "circle", radius = 0.15, normal = [1, 0, 0], center = [0.3, 0, 0] }
        section = { bending = 100.0, twisting = 100.0, stretching = 1e5, shearing = 1e5, contact_radius = 0.03 }
        elements = 24
        [[rods]]
        name = "loop"
        closed = true
        shape = { kind = "circle", radius = 0.3, normal = [0, 0, 1], center = [-0.05, 0, 0] }
        section = { bending = 0.1, twisting = 0.1, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }
        elements = 48
        [[supports]]
        rod = "ring"
        at = "start"
        position = true
        rotation = true
        [[supports]]
        rod = "loop"
        at = "start"
        position = true
        [[stages]]
        ramp = { displacement = { rod = "loop", at = "start", to = [0.4, 0, 0] } }
        steps = 16
        "#,
        16,
    );
    // nothing resists: both are the circles that they were
    let tau = std::f64::consts::TAU;
    let circles = 0.5 * (100.0 * tau / 0.15 + 0.1 * tau / 0.3);
    assert!((end.energies.bending / circles - 1.0).abs() < 1e-6, "{} {circles}", end.energies.bending);
    assert!(end.total_contact_force < 1e-6 && end.contact_gap.is_none_or(|gap| gap.upper > -1e-8), "{end:?}");
}

/// A ring buckles under pressure and closes on another one inside: it touches on one side, then on both, the inner ring
/// hardly pressed yet, and turns about it at next to no cost. (Before: load step too small at p = 3.32 B/R³.)
#[test]
fn a_buckled_ring_closes_on_an_inner_one() {
    let end = end_of(
        r#"
        planar = true
        [[rods]]
        name = "outer"
        closed = true
        shape = { kind = "circle", radius = 1.0 }
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.05 }
        elements = 32
        [[rods]]
        name = "inner"
        closed = true
        shape = { kind = "circle", radius = 0.5 }
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.05 }
        elements = 24
        [[supports]]
        rod = "inner"
        at = "start"
        position = true
        rotation = true
        [[stages]]
        ramp = { pressure = { rod = "outer", to = 3.33 } }
        steps = 10
        "#,
        10,
    );
    assert_eq!((end.sites.len(), end.num_unstable), (2, 0), "{end:?}");
    // the inner ring is held at one node, which carries nothing: what presses on one side presses on the other
    let [a, b] = [&end.sites[0], &end.sites[1]].map(|site| site.force);
    assert!(a > 1e-3 && (a / b - 1.0).abs() < 1e-4, "{a} {b}");
}
