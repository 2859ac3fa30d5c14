//! Library inputs with anything in them: rods from any nodes, curves through any points, models with any supports,
//! loads, laws and ramps.
//!
//! Promise: refused with an `InputError`, or taken; what is taken ends in bounded work, with finite numbers where it
//! says it converged, sites within the range asked for, link conserved. Never a panic.
//! `SUPERCOIL_FUZZ_SEED=7 cargo test --release --test properties fuzz_library -- --ignored` takes other inputs than the
//! usual ones.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use common::fuzz;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use supercoil::contact::{self, Curve, Detector, Neighbours};
use supercoil::math::{Quat, Vec3};
use supercoil::nalgebra::Quaternion;
use supercoil::observe::observe;
use supercoil::rod::{Natural, Placement, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, LineLoad, Model, NodeLoad, NodeRef, Ramp, Stage, Support};
use supercoil::solve::{Options, Status, run};

fn runner(cases: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, max_shrink_iters: 300, ..Config::default() };
    TestRunner::new_with_rng(config, fuzz::rng())
}

/// A number: mostly of ordinary size, sometimes a repeated one, rarely anything.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        80 => -2.0..2.0f64,
        20 => prop::sample::select(vec![0.0, 1.0, -1.0, 0.5, 0.25]),
        3 => (-12..12i32).prop_map(|decade| 10f64.powi(decade)),
        2 => prop::sample::select(
            vec![f64::NAN, f64::INFINITY, -f64::INFINITY, 5e-324, -1e-310, 1e154, -1e300, f64::MAX],
        ),
    ]
}

/// A number that is nearly always positive and of ordinary size.
fn size() -> impl Strategy<Value = f64> {
    prop_oneof![100 => 0.1..10.0f64, 6 => (-8..8i32).prop_map(|decade| 10f64.powi(decade)), 1 => number()]
}

fn vector() -> impl Strategy<Value = Vec3> {
    (number(), number(), number()).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

/// Points on a grid coarse enough for coincidences, or anywhere.
fn points(most: usize) -> impl Strategy<Value = Vec<Vec3>> {
    let grid = (-2..3i32, -2..3i32, -1..2i32).prop_map(|(x, y, z)| Vec3::new(x.into(), y.into(), z.into()) * 0.25);
    let plain = (-2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    prop_oneof![
        4 => prop::collection::vec(grid, 0..most),
        4 => prop::collection::vec(plain, 0..most),
        1 => prop::collection::vec(vector(), 0..most),
    ]
}

fn detect(cases: u32) -> BTreeMap<&'static str, usize> {
    let tally = std::cell::RefCell::new(BTreeMap::new());
    let radius = prop_oneof![8 => 0.0..0.4f64, 1 => number()];
    let curves = prop::collection::vec((points(14), radius, any::<bool>()), 0..4);
    let neighbours = prop_oneof![Just(Neighbours::Turning), (0..40usize).prop_map(Neighbours::Segments)];
    let options = (number(), prop_oneof![3 => Just(0.0), 1 => number()], neighbours, 0..1100usize, any::<bool>());
    runner(cases)
        .run(&(curves, options), |(curves, (range, margin, neighbours, sampling, zones))| {
            let options = contact::DetectorOptions { range, margin, neighbours, sampling, zones };
            let mut lent: Vec<Curve> = Vec::new();
            for (points, radius, closed) in &curves {
                let curve = Curve::polyline(points, *radius);
                lent.push(if *closed { curve.closed() } else { curve });
            }
            let mut detector = Detector::new(options);
            let end = match detector.detect(&lent) {
                Err(error) => {
                    prop_assert!(error.to_string().len() > 5);
                    "refused"
                }
                Ok(contacts) => {
                    for site in &contacts.sites {
                        prop_assert!(site.gap <= range && site.gap.is_finite(), "gap {} beyond {range}", site.gap);
                        let norm = site.normal.norm();
                        prop_assert!(norm == 0.0 || (norm - 1.0).abs() < 1e-9, "normal of length {norm}");
                    }
                    let mut another = Detector::new(options);
                    prop_assert!(another.detect(&lent).unwrap() == contacts, "not the same twice");
                    if contacts.sites.is_empty() { "nothing" } else { "sites" }
                }
            };
            *tally.borrow_mut().entry(end).or_insert(0) += 1;
            Ok(())
        })
        .unwrap();
    tally.into_inner()
}

fn section() -> impl Strategy<Value = Section> {
    let radius = prop_oneof![6 => 0.01..0.1f64, 2 => Just(0.0), 1 => number()];
    (size(), size(), size(), size(), size(), size(), radius).prop_map(|(b1, b2, c, ea, g1, g2, contact_radius)| {
        Section { bending: [b1, b2], twisting: c, stretching: 1e3 * ea, shearing: [1e3 * g1, 1e3 * g2], contact_radius }
    })
}

fn natural() -> impl Strategy<Value = Natural> {
    let kappa = (number(), number(), number()).prop_map(|(a, b, c)| Natural::Uniform { kappa: [a, b, c] });
    prop_oneof![4 => Just(Natural::Straight), 2 => Just(Natural::AsShaped), 2 => kappa]
}

/// Rods from the user's own nodes and frames.
fn rods(cases: u32) -> BTreeMap<&'static str, usize> {
    let tally = std::cell::RefCell::new(BTreeMap::new());
    let frame = prop_oneof![
        3 => Just(Quat::identity()),
        3 => vector().prop_map(Quat::from_scaled_axis),
        1 => (number(), number(), number(), number())
            .prop_map(|(w, x, y, z)| Quat::new_unchecked(Quaternion::new(w, x, y, z))),
    ];
    let nodes = (points(12), prop::collection::vec(frame, 0..12));
    runner(cases)
        .run(
            &(nodes, size(), any::<bool>(), section(), 0..5usize, natural()),
            |(nodes, length, closed, section, order, natural)| {
                let ((positions, mut frames), count) = (nodes.clone(), nodes.0.len());
                // mostly as many frames as positions
                if count > 0 && frames.len() > 2 {
                    frames.resize(count, Quat::identity());
                }
                let nodes = Placement { length, positions, frames, closed };
                let rod = Rod::from_nodes("r", nodes, section, order, natural);
                let end = match rod {
                    Err(_) => "refused",
                    Ok(rod) => {
                        prop_assert!(rod.start_excess_link.is_finite());
                        prop_assert_eq!(rod.check(), Ok(()));
                        if let Ok(fine) = rod.refined(2) {
                            prop_assert_eq!(fine.num_elements, 2 * rod.num_elements);
                        }
                        "taken"
                    }
                };
                *tally.borrow_mut().entry(end).or_insert(0) += 1;
                Ok(())
            },
        )
        .unwrap();
    tally.into_inner()
}

fn shape() -> impl Strategy<Value = (Shape, bool)> {
    prop_oneof![
        4 => (vector(), vector(), size())
            .prop_map(|(start, direction, length)| (Shape::Line { start, direction, length }, false)),
        4 => (vector(), vector(), size())
            .prop_map(|(center, normal, length)| (Shape::Circle { center, normal, length }, true)),
        1 => (vector(), vector(), size(), number(), size())
            .prop_map(|(center, axis, radius, pitch, turns)| {
                (Shape::Helix { center, axis, radius, pitch, turns }, false)
            }),
        1 => (points(8), any::<bool>()).prop_map(|(points, closed)| (Shape::Points(points), closed)),
    ]
}

fn law() -> impl Strategy<Value = ContactLaw> {
    prop_oneof![
        2 => Just(ContactLaw::None),
        2 => size().prop_map(|stiffness| ContactLaw::Penalty { stiffness }),
        3 => (size(), number()).prop_map(|(stiffness, tol)| {
            ContactLaw::AugmentedLagrangian { stiffness, tol_penetration: 1e-3 * tol.abs() }
        }),
    ]
}

/// Three in four, by whatever digits the section has.
fn clamped(section: &Section) -> bool {
    !section.twisting.to_bits().is_multiple_of(4)
}

fn models(cases: u32) -> BTreeMap<String, usize> {
    let tally = std::cell::RefCell::new(BTreeMap::new());
    let rod = (shape(), section(), 1..7usize, 1..4usize, natural());
    let node = (prop_oneof![5 => Just(0usize), 1 => 0..2usize], prop_oneof![3 => 0..4usize, 1 => 0..14usize])
        .prop_map(|(rod, node)| NodeRef { rod, node });
    let flags = prop_oneof![3 => Just([true; 3]), 1 => any::<[bool; 3]>()];
    let support = (node.clone(), flags.clone(), flags).prop_map(|(node, position, rotation)| Support {
        node,
        position,
        rotation,
    });
    let load = (node.clone(), vector(), vector()).prop_map(|(node, force, moment)| NodeLoad { node, force, moment });
    let ramp = prop_oneof![
        3 => number().prop_map(|to| Ramp::Load { to }),
        2 => (node.clone(), vector(), number()).prop_map(|(node, axis, to)| Ramp::Rotation { node, axis, to }),
        1 => (node.clone(), vector(), vector(), number())
            .prop_map(|(node, axis, through, to)| Ramp::RotationAbout { node, axis, through, to }),
        2 => (node.clone(), vector()).prop_map(|(node, to)| Ramp::Displacement { node, to: to * 0.1 }),
        4 => (prop_oneof![5 => Just(0usize), 1 => 0..2usize], number())
            .prop_map(|(rod, to)| Ramp::ExcessLink { rod, to }),
        1 => (0..2usize, number()).prop_map(|(rod, to)| Ramp::Pressure { rod, to }),
    ];
    let problem = (
        prop::collection::vec(rod, 1..3),
        prop::collection::vec(support, 0..4),
        prop::collection::vec(load, 0..2),
        prop::collection::vec((Just(0usize), vector()), 0..2),
        law(),
        prop::bool::weighted(0.15),
        prop::collection::vec(ramp, 0..2),
        prop_oneof![12 => 1..4usize, 1 => Just(0usize)],
    );
    runner(cases)
        .run(&problem, |(rods, mut supports, loads, line_loads, law, planar, ramps, steps)| {
            // mostly held at the start of the first rod
            if clamped(&rods[0].1) {
                supports.push(Support::clamp(NodeRef { rod: 0, node: 0 }));
            }
            let place = |((shape, closed), section, elements, order, natural): &(_, Section, usize, usize, Natural)| {
                Rod::new(
                    "r",
                    shape,
                    RodMesh { closed: *closed, num_elements: *elements, order: *order },
                    *section,
                    natural.clone(),
                )
            };
            let placed: Result<Vec<Rod>, _> = rods.iter().map(place).collect();
            let count = |end: String| *tally.borrow_mut().entry(end).or_insert(0) += 1;
            let Ok(rods) = placed else {
                count("rod refused".to_owned());
                return Ok(());
            };
            let line_loads = line_loads.into_iter().map(|(rod, force)| LineLoad::of_force(rod, force)).collect();
            let model =
                Model { rods, supports, loads, line_loads, contact: Contact { law }, planar, ..Model::default() };
            let mut options = Options { max_augmentations: 3, max_escapes: 1, min_step: 0.5, ..Options::default() };
            options.newton.max_iterations = 15;
            let stages = if ramps.is_empty() { Vec::new() } else { vec![Stage::new(ramps, steps)] };
            let mut bad = None;
            let result = run(model, &stages, &options, &mut |progress| {
                let seen = observe(progress);
                if progress.report.status == Status::Converged {
                    if !seen.energies.total.is_finite() {
                        bad = Some(format!("energies {:?}", seen.energies));
                    }
                    // without contact a rod may pass through itself, which changes its link by two
                    let guarded = progress.engine.model().contact.law.is_on();
                    let slips = |link: &&supercoil::observe::report::RodLink| {
                        // where shear may turn d1 into the tangent, the line along d1 has no link
                        let rod = &progress.engine.model().rods[link.rod];
                        let soft = rod.section.shearing[0].min(rod.section.shearing[1]).min(rod.section.stretching);
                        let stiff = rod.section.bending[0].max(rod.section.bending[1]).max(rod.section.twisting);
                        if soft * rod.length.powi(2) < 1e3 * stiff {
                            return false;
                        }
                        let passes = (link.link - rod.natural_link() - link.excess_link) / 2.0;
                        let touches = guarded && rod.section.contact_radius > 0.0;
                        let slip = if touches { passes } else { passes - passes.round() };
                        slip.is_nan() || slip.abs() > 1e-6
                    };
                    if let Some(link) = seen.links.iter().find(slips) {
                        bad = Some(format!("link {link:?}"));
                    }
                }
                ControlFlow::Continue(())
            });
            prop_assert!(bad.is_none(), "converged to {bad:?}");
            count(match result {
                Ok(solution) => solution.status.to_string(),
                Err(supercoil::solve::RunError::Input(_)) => "refused".to_owned(),
                Err(supercoil::solve::RunError::Solve(_)) => "broke down".to_owned(),
            });
            Ok(())
        })
        .unwrap();
    tally.into_inner()
}

#[test]
fn any_curves() {
    let tally = detect(400);
    println!("{tally:?}");
    assert!(tally["sites"] > 20 && tally["nothing"] > 20 && tally["refused"] > 20, "{tally:?}");
}

#[test]
fn any_rods() {
    let tally = rods(1000);
    println!("{tally:?}");
    assert!(tally["taken"] > 20 && tally["refused"] > 100, "{tally:?}");
}

#[test]
fn any_models() {
    let tally = models(600);
    println!("{tally:?}");
    assert!(tally["converged"] > 30 && tally["refused"] > 50, "{tally:?}");
}

#[test]
#[ignore = "slow: the large budget, minutes"]
fn the_large_budget() {
    println!("{:?}", detect(20_000));
    println!("{:?}", rods(50_000));
    println!("{:?}", models(20_000));
}
