//! Rods whose supports hold less than all of their neutral motions: they converge like rods that are free or fully
//! held.
//!
//! ```text
//!      _  _             ___
//!     / \/ \         > (   ) <
//!     \_/\_/▒        >  ) (  < ▒
//! ```
//!
//! * A twisted closed ring, L = 1, B = 1, C = 1.5, D/L = .02, 144 cubic elements, held at one node: clamped it may
//!   travel along its own shape through the clamp, and swing about the tangent there; on a ball joint it may turn and
//!   spin besides.
//! * A ring under pressure in the plane (see `planar_touch`), clamped at one node: it may travel.
//! * A heavy ring, clamped at one node: it may swing there if its tangent is vertical.
//!
//! None of these motions costs energy. Reference: the same rings, free. Contact that lies elsewhere between nodes
//! differs by the elements' compliance inside themselves, up to 2e-5 of its force (6e-5 on 96 elements); the support
//! carries the ripple that sliding has in the discrete energy, up to 1e-4 of it. Searches must end quadratically, as
//! they do without supports: before the motions were known they went on with increments of 1e-5 for ever, and 60
//! iterations became 500.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;

use common::cases::oval_ring;
use common::{history, observed, verify};
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, NodeRef, Ramp, Scene, Support};
use supercoil::solve::{self, Options, Solver, Status, StepReport};

fn seen(solver: &Solver, report: &StepReport) -> Observation {
    assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", history(report));
    observed(solver, report)
}

/// The last search of a step ended with increments that fell at least a thousandfold at once, or below 1e-9 in one
/// step.
fn assert_at_rest(report: &StepReport) {
    let last = report.history.last().unwrap();
    let sizes: Vec<f64> = last.iter().map(|i| i.increment).collect();
    let end = sizes[sizes.len() - 1];
    assert!(end < 1e-7, "{sizes:?}");
    assert!(sizes.len() < 2 || end < 1e-3 * sizes[sizes.len() - 2] || end < 1e-9, "{sizes:?}");
}

/// Steps a model and the same with a support; compares energy, contact force and what the support carries.
fn compare(name: &str, model: &Model, support: Support, ramps: &[Ramp]) {
    let held = Model { supports: vec![support], ..model.clone() };
    let [mut free, mut held] = [model.clone(), held].map(|model| Solver::new(model, Options::default()).unwrap());
    for ramp in ramps {
        let reports = [&mut free, &mut held].map(|solver| solver.step_to(std::slice::from_ref(ramp)).unwrap());
        println!("{name}, {ramp:?}: {} and {} iterations", reports[0].iterations, reports[1].iterations);
        assert_at_rest(&reports[1]);
        let [free, held] = [seen(&free, &reports[0]), seen(&held, &reports[1])];
        let name = format!("{name}, {ramp:?}");
        let energy = free.energies.total;
        verify(&name, "energy", held.energies.total, energy, 1e-5 * energy.abs());
        let force = free.total_contact_force;
        // where on its mesh a point lies makes 5e-5 of its force
        verify(&name, "contact force", held.total_contact_force, force, 1e-4 * force);
        for reaction in &held.reactions {
            verify(&name, "reaction", Vec3::from(reaction.force).norm(), 0.0, 2e-4 * force.max(1e-3));
        }
    }
}

#[test]
fn twisted_ring_held_at_one_node() {
    let node = NodeRef { rod: 0, node: 0 };
    for (law, support) in [
        (ContactLaw::None, Support::clamp(node)),
        (Contact::default().law, Support::clamp(node)),
        (Contact::default().law, Support::pin(node)),
    ] {
        let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, 0.01);
        let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
        let rod = Rod::new("ring", &shape, RodMesh::closed(144, 3), section, Natural::Straight).unwrap();
        let model = Model { rods: vec![rod], contact: Contact { law }, ..Model::default() };
        let links: &[f64] = if law.is_on() { &[0.5, 1.1, 1.2, 1.5, 2.1] } else { &[0.5, 1.1] };
        let ramps: Vec<_> = links.iter().map(|&to| Ramp::ExcessLink { rod: 0, to }).collect();
        let name = if support.rotation[0] { "twisted ring, one clamp" } else { "twisted ring, one ball joint" };
        compare(name, &model, support, &ramps);
    }
}

#[test]
fn pressed_ring_clamped_at_one_node() {
    let model = oval_ring(48, 0.02, 1e5, Contact::default().law);
    let ramps: Vec<_> = [3.3, 4.0, 5.0, 6.0].map(|to| Ramp::Pressure { rod: 0, to }).to_vec();
    for node in [0, 7] {
        compare("ring under pressure, one clamp", &model, Support::clamp(NodeRef { rod: 0, node }), &ramps);
    }
}

/// A heavy ring clamped where its tangent is vertical swings about it at no cost, whatever it weighs; the same ring in
/// the plane cannot. Before, it ended as unstable before any weight was on it, and so did one in a tilted plane, which
/// weight turns. Standing upright on a horizontal tangent it falls: the motion that costs nothing without weight is
/// found to be unstable with it, and left.
#[test]
fn heavy_ring_clamped_at_one_node() {
    let hung = |normal: [f64; 3], weight: [f64; 3], planar: bool| {
        let text = format!(
            "planar = {planar}\n[[rods]]\nname = \"ring\"\nclosed = true\n\
             shape = {{ kind = \"circle\", radius = 1.0, normal = {normal:?} }}\n\
             section = {{ bending = 1.0, twisting = 1.5, stretching = 1e6, shearing = 1e6, contact_radius = 0.02 }}\n\
             elements = 32\n\
             [[supports]]\nat = 0\nposition = true\nrotation = true\n[[line_loads]]\nforce = {weight:?}\n[[stages]]\n\
             ramp = {{ load = 1.0 }}\nsteps = 5\n"
        );
        let scene = Scene::from_toml(&text, Path::new("")).unwrap();
        let (mut last, mut escapes) = (None, 0);
        let solution = solve::run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
            last = Some(observe(progress));
            escapes += progress.report.escapes;
            ControlFlow::Continue(())
        });
        assert_eq!(solution.unwrap().status, Status::Converged, "{normal:?}");
        let last = last.unwrap();
        let error = Vec3::from(last.reactions[0].force) + 2.0 * PI * Vec3::from(weight);
        verify("heavy ring clamped at one node", "force of the clamp on its weight", error.norm(), 0.0, 1e-7);
        (last.energies.total, escapes)
    };
    let (in_plane, _) = hung([0.0, 0.0, 1.0], [0.0, -3.0, 0.0], true);
    for (normal, weight) in
        [([0.0, 1.0, 0.0], [0.0, 0.0, -3.0]), ([1.0, 0.0, 0.0], [0.0, 0.0, -3.0]), ([0.0, 0.0, 1.0], [0.0, -3.0, 0.0])]
    {
        let (energy, _) = hung(normal, weight, false);
        verify("heavy ring clamped at one node", "energy, B/R", energy, in_plane, 1e-8 * in_plane);
    }
    let [(hanging, still), (fallen, left)] = [-3.0, 3.0].map(|y| hung([1.0, 0.0, 0.0], [0.0, y, 0.0], false));
    verify("heavy ring that stood upright", "energy, B/R", fallen, hanging, 1e-8 * hanging);
    assert_eq!((still, left), (0, 1), "unstable equilibria that were left, hanging and upright");
    hung([1.0, 1.0, 1.0], [0.0, 0.0, -3.0], false);
}

/// A clamped rod whose end moves to coordinates of six digits, so that its ends are coaxial but for 1e-6, and is turned
/// there: it turns about the line between the ends as freely as one whose ends are coaxial to rounding. No step is
/// halved. Before that counted as free, searches neither found the valley that the last digits make nor left it alone.
#[test]
fn ends_are_coaxial_to_six_digits() {
    let scene = Scene::from_toml(
        "[[rods]]\nname = \"rod\"\nelements = 24
shape = { kind = \"line\", direction = [-0.808007, 0.586477, -0.0562989], length = 1.0 }
section = { bending = 1.0, twisting = 1.7, stretching = 5.8e4, shearing = 4.9e4, contact_radius = 0.015 }
[[supports]]\nat = \"start\"\nposition = true\nrotation = true
[[supports]]\nat = \"end\"\nposition = true\nrotation = true
[[stages]]\nramp = { displacement = { at = \"end\", to = [0.468157, -0.339803, 0.0326194] } }\nsteps = 18
[[stages]]\nramp = { rotation = { at = \"end\", axis = [-0.808007, 0.586477, -0.0562989], turns = 1.467 } }\n\
steps = 6\n",
        Path::new("."),
    )
    .unwrap();
    let mut steps = 0;
    let solution = solve::run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
        steps += usize::from(progress.step > 0);
        ControlFlow::Continue(())
    });
    let solution = solution.unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure);
    assert_eq!(steps, 24);
}
