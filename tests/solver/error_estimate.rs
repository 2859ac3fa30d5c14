//! The estimate of a state's own error against errors that are known.
//!
//! Promise of [`estimate_error`]: where one of its parts, mesh or contact law, makes the error, error and estimate are
//! within a factor of two of each other; where both do, the error is not above one and a half times their sum (Bathe
//! bend and twisted ring, references as in `bathe_bolourchi` and `twisted_ring`). On twisted rings in general the error
//! is not above [`COVERS`] times their sum.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::ops::ControlFlow;
use std::path::Path;

use common::cases::{BATHE_TIP_AT_600, bathe_bend};
use common::observed;
use supercoil::io::run::run_scene;
use supercoil::math::Vec3;
use supercoil::observe::{COVERS, ErrorEstimate, estimate_error};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, Ramp, Scene};
use supercoil::solve::{Options, Solver, Status};

/// The 45° bend under a tip load of 600, kGA = 5/6·5e6.
fn bend(elements: usize, order: usize) -> (Solver, f64) {
    let mut solver = Solver::new(bathe_bend(elements, order, 600.0, 5e6 * 5.0 / 6.0), Options::default()).unwrap();
    assert_eq!(solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap().status, Status::Converged);
    let error = (solver.engine().positions(0).last().unwrap() - Vec3::from(BATHE_TIP_AT_600)).norm();
    (solver, error)
}

#[test]
fn bathe_bend_on_coarse_meshes() {
    for (elements, order) in [(8, 1), (16, 1), (4, 2), (8, 2), (2, 3), (4, 3), (8, 3)] {
        let (solver, error) = bend(elements, order);
        let before = solver.engine().state().clone();
        let estimate = estimate_error(&solver).unwrap();
        assert_eq!(solver.engine().state(), &before, "the solver stays as it is");
        let position = estimate.total(|d| d.position).unwrap();
        println!("{elements} elements of order {order}: error {error:.2e}, estimate {position:.2e}");
        assert!(estimate.contact_law.is_none() && estimate.penetration.is_none());
        // the reference has ten digits
        assert!(error < 1e-8 || (0.5 * position < error && error < 2.0 * position), "{elements}, order {order}");
        assert!(estimate.residual < 1e-6, "{:e}", estimate.residual);
    }
}

/// The twisted ring with D/L = .02, EA = GA = 1e8 B/L²; errors of contact force, writhe and energy at rest.
fn ring(elements: usize, kappa: f64, excess_link: f64) -> Solver {
    let section = Section::isotropic(1.0, 1.5, 1e8, 1e8, 0.01);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(elements, 3), section, Natural::Straight).unwrap();
    let law = ContactLaw::AugmentedLagrangian { stiffness: kappa * 1e-8, tol_penetration: 1e-8 };
    let model = Model { rods: vec![rod], contact: Contact { law }, ..Model::default() };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    for to in [0.5, 1.1, 1.2, 1.4, excess_link] {
        let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to }]).unwrap();
        assert_eq!(report.status, Status::Converged, "{elements} elements, {to}");
    }
    solver
}

fn force(solver: &mut Solver) -> f64 {
    let report = solver.step_to(&[]).unwrap();
    observed(solver, &report).total_contact_force
}

#[test]
fn contact_force_of_the_ring() {
    let mut dominated = 0;
    for (elements, kappa) in [(12, 1e11), (16, 1e11), (24, 1e9), (32, 1e9), (24, 1e10)] {
        let mut solver = ring(elements, kappa, 1.6);
        let error = (force(&mut solver) - 169.920755).abs();
        let estimate: ErrorEstimate = estimate_error(&solver).unwrap();
        let part = |c: &supercoil::observe::Comparison| c.error.unwrap().contact_force.unwrap();
        let (mesh, law) = (part(&estimate.mesh), part(estimate.contact_law.as_ref().unwrap()));
        println!("{elements} elements, κ = {kappa:.0e}: error {error:.2e}, mesh {mesh:.2e}, law {law:.2e}\n{estimate}");
        let total = estimate.total(|d| d.contact_force).unwrap();
        assert!(error < 1.5 * total, "{elements} elements, κ = {kappa:e}: {error:e} {total:e}");
        // where the parts may cancel the estimate is a bound only
        let one_dominates = mesh.max(law) > 4.0 * mesh.min(law);
        assert!(!one_dominates || error > 0.5 * total, "{elements} elements, κ = {kappa:e}: {error:e} {total:e}");
        dominated += usize::from(one_dominates);
    }
    assert!(dominated >= 3, "{dominated}");
}

/// Symptom: a converged run whose error could not be estimated left neither summary nor tables. Mechanism: the refusal
/// went up before the record was finished. Here nodes are known to 0.7 thousandths of their spacing (far from the
/// origin), and those of the finer mesh would be to 1.4, above the 1 that is allowed.
#[test]
fn a_run_without_an_estimate_leaves_its_record() {
    let text = r#"
        [[rods]]
        shape = { kind = "line", length = 1.0, start = [2.6e11, 0.0, 0.0] }
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.0 }
        elements = 4
        [[supports]]
        at = "start"
        position = true
        rotation = true
        [output]
        vtk = false
        picture = false
        error_estimate = true
    "#;
    let scene = Scene::from_toml(text, Path::new("")).unwrap();
    let dir = std::env::temp_dir().join(format!("supercoil_no_estimate_{}", std::process::id()));
    let error = run_scene(scene, &dir, &mut |_| ControlFlow::Continue(())).unwrap_err().to_string();
    assert!(error.contains("from the origin"), "{error}");
    let summary = std::fs::read_to_string(dir.join("summary.json")).unwrap();
    std::fs::remove_dir_all(&dir).unwrap();
    assert!(summary.contains("converged") && !summary.contains("error_estimate"), "{summary}");
}

/// A scene that asks for it has the estimate in its outcome and its summary; one that does not has none.
#[test]
fn scenes_tell_their_error_on_request() {
    let text = r#"
        [[rods]]
        name = "beam"
        shape = { kind = "line", length = 1.0, start = [0.0, 0.0, 0.0], direction = [1.0, 0.0, 0.0] }
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.0 }
        elements = 4
        [[supports]]
        at = "start"
        position = true
        rotation = true
        [[loads]]
        at = "end"
        force = [0.0, 4.0, 0.0]
        [[stages]]
        ramp = { load = 1.0 }
        steps = 2
        [output]
        vtk = false
        picture = false
    "#;
    for asked in [true, false] {
        let text = if asked { format!("{text}\nerror_estimate = true") } else { text.to_owned() };
        let scene = Scene::from_toml(&text, Path::new("")).unwrap();
        let dir = std::env::temp_dir().join(format!("supercoil_estimate_{}_{asked}", std::process::id()));
        let outcome = run_scene(scene, &dir, &mut |_| ControlFlow::Continue(())).unwrap();
        let summary = std::fs::read_to_string(dir.join("summary.json")).unwrap();
        std::fs::remove_dir_all(&dir).unwrap();
        assert_eq!(outcome.error_estimate.is_some(), asked);
        assert_eq!(summary.contains("error_estimate"), asked);
        let Some(estimate) = outcome.error_estimate else { continue };
        let energy = estimate.total(|d| Some(d.energy)).unwrap();
        assert!(energy > 0.0 && energy < 1e-3, "{energy}");
        assert!(estimate.to_string().contains("reaction moments"));
    }
}

/// How the estimate covers the errors of twisted rings: thin and thick, one and two points of contact and a line, on
/// meshes that a user would choose.
#[test]
#[ignore = "slow: 40 states, each on three meshes, two minutes"]
fn estimates_of_twisted_rings_cover_their_errors() {
    let law = ContactLaw::ByMesh { least: 10.0, tol_penetration: 1e-6 };
    let ring = |radius: f64, elements: usize, law: ContactLaw| {
        let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, radius);
        let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
        let rod = Rod::new("ring", &shape, RodMesh::closed(elements, 3), section, Natural::Straight).unwrap();
        Solver::new(Model { rods: vec![rod], contact: Contact { law }, ..Model::default() }, Options::default())
            .unwrap()
    };
    let links = [1.4, 1.8, 2.2, 2.6, 3.0];
    let numbers = |solver: &mut Solver, to: f64| {
        let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to }]).unwrap();
        assert_eq!(report.status, Status::Converged);
        let seen = observed(solver, &report);
        let link = &seen.links[0];
        [seen.energies.total, link.writhe, link.seam_moment, seen.total_contact_force]
    };
    let mut worst = [0.0f64; 4];
    let mut beyond = [0; 4];
    let mut count = 0;
    for radius in [0.01, 0.0041] {
        let mut fine = ring(radius, 224, ContactLaw::ByMesh { least: 1e4, tol_penetration: 1e-8 });
        let exact: Vec<[f64; 4]> = links.iter().map(|to| numbers(&mut fine, *to)).collect();
        for elements in [32, 40, 48, 72] {
            let mut solver = ring(radius, elements, law);
            for (to, exact) in links.iter().zip(&exact) {
                let found = numbers(&mut solver, *to);
                let estimate = estimate_error(&solver).unwrap();
                let stated = [
                    estimate.total(|d| Some(d.energy)),
                    estimate.total(|d| d.writhe),
                    estimate.total(|d| d.twisting_moment),
                    estimate.total(|d| d.contact_force),
                ];
                let ratio: [f64; 4] = std::array::from_fn(|k| (found[k] - exact[k]).abs() / stated[k].unwrap());
                println!("radius {radius}, {elements} elements, link {to}: {ratio:.2?} of {stated:?}");
                count += 1;
                (0..4).for_each(|k| worst[k] = worst[k].max(ratio[k]));
                (0..4).for_each(|k| beyond[k] += usize::from(ratio[k] > 1.0));
            }
        }
    }
    println!(
        "{count} states: energy, writhe, moment, force off by at most {worst:.2?} times the estimate; beyond it: \
         {beyond:?}"
    );
    assert!(worst.iter().all(|ratio| *ratio < COVERS), "{worst:?}");
}
