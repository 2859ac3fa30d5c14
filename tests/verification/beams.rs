//! Clamped beams in contact, against small-displacement closed forms.
//!
//! * Two beams crossing at right angles at mid-span, the ends of one lowered by δ after first touch: F = 96 B δ/L³.
//! * Two parallel beams a gap g apart, both pushed together by a line load q: they touch at mid-span at q₁ = 192 B g/L⁴
//!   (each bends by g/2), contact stays a point until 3 q₁, then a line grows.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::ops::ControlFlow;

use common::curvature::{PointForce, interpolate_to_zero, tangent_and_curvature};
use common::{any_equilibrium, observed, root, runge_kutta, verify};
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Along, Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, LineLoad, Model, NodeRef, Ramp, Support};
use supercoil::solve::{FollowOptions, NewtonOptions, Options, PathEnd, Solver, Status};

const RADIUS: f64 = 0.01;

fn beam(name: &str, start: Vec3, direction: Vec3, elements: usize) -> Rod {
    let section = Section::isotropic(1.0, 1.0, 1e7, 1e7, RADIUS);
    let shape = Shape::Line { start, direction, length: 1.0 };
    Rod::new(name, &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap()
}

fn clamped(rods: Vec<Rod>) -> Model {
    let supports = rods
        .iter()
        .enumerate()
        .flat_map(|(rod, r)| [0, r.num_nodes() - 1].map(|node| Support::clamp(NodeRef { rod, node })))
        .collect();
    Model { rods, supports, ..Model::default() }
}

fn to(solver: &mut Solver, ramps: &[Ramp]) -> Observation {
    let report = solver.step_to(ramps).unwrap();
    assert_eq!(report.status, Status::Converged, "{ramps:?}: {}", common::history(&report));
    observed(solver, &report)
}

#[test]
fn a_tapered_beam_is_touched_where_its_radius_says() {
    let radii = Along::points(vec![0.0, 1.0], vec![0.005, 0.02]).unwrap();
    let lower = beam("lower", Vec3::new(-0.5, 0.0, 0.0), Vec3::x(), 10).with_contact_radii(radii).unwrap();
    assert_eq!(lower.section.contact_radius, lower.contact_radius_of(29));
    // in the middle of a segment, whose radius is that there
    let (place, height) = (0.35, 0.025);
    let upper = beam("upper", Vec3::new(place - 0.5, -0.5, height), Vec3::y(), 10);
    let last = upper.num_nodes() - 1;
    let law = ContactLaw::AugmentedLagrangian { stiffness: 100.0, tol_penetration: 1e-8 };
    let model = Model { contact: Contact { law }, ..clamped(vec![lower, upper]) };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    let lowered = |by: f64| -> Vec<Ramp> {
        [0, last].map(|node| Ramp::Displacement { node: NodeRef { rod: 1, node }, to: Vec3::z() * -by }).to_vec()
    };
    let touch = height - (0.005 + 0.015 * place) - RADIUS;
    let case = "beam across a tapered one";
    let before = to(&mut solver, &lowered(touch - 1e-4));
    assert_eq!(before.num_sites, 0);
    verify(case, "gap before they touch", before.contact_gap.unwrap().lower, 1e-4, 1e-6);
    let beyond = 1e-5;
    let found = to(&mut solver, &lowered(touch + beyond)).total_contact_force;
    let compliance = (place * (1.0 - place)).powi(3) / 3.0 + 1.0 / 192.0;
    verify(case, "contact force", found, beyond / compliance, 1e-3 * beyond / compliance);
}

#[test]
fn crossed_beams_press_with_the_exact_force() {
    for elements in [8, 9] {
        // with an odd number of elements the crossing lies inside a segment, not on a node
        let lower = beam("lower", Vec3::new(-0.5, 0.0, 0.0), Vec3::x(), elements);
        let upper = beam("upper", Vec3::new(0.0, -0.5, 2.5 * RADIUS), Vec3::y(), elements);
        let last = upper.num_nodes() - 1;
        // by the mesh κ' would be 10: normals turn by w/2ε over the point's zone, 2w long, which leaves 1.1e-6 between
        // the sum of the forces and their resultant
        let law = ContactLaw::AugmentedLagrangian { stiffness: 100.0, tol_penetration: 1e-8 };
        let model = Model { contact: Contact { law }, ..clamped(vec![lower, upper]) };
        let mut solver = Solver::new(model, Options::default()).unwrap();
        let lowered = |by: f64| -> Vec<Ramp> {
            [0, last].map(|node| Ramp::Displacement { node: NodeRef { rod: 1, node }, to: Vec3::z() * -by }).to_vec()
        };
        let touch = 0.5 * RADIUS;
        for deflection in [1e-4, 2e-4, 5e-4] {
            let seen = to(&mut solver, &lowered(touch + deflection));
            let exact = 96.0 * deflection;
            println!("δ {deflection}: force {} exact {exact}", seen.total_contact_force);
            assert_eq!(seen.sites.len(), 1);
            assert_eq!(seen.sites[0].kind, "point");
            assert!((seen.sites[0].angle - 90.0).abs() < 0.1);
            // stretching stiffens by (δ/2)²·EA/B-ish, shear softens by 1e-5: both below 1e-3 here for the first two
            let stretch = 1e7 * deflection * deflection / 40.0;
            let tolerance = 2e-3 + stretch;
            assert!((seen.total_contact_force / exact - 1.0).abs() < tolerance, "force {}", seen.total_contact_force);
            // the reactions of the upper beam balance the contact force, as far as a search tells the deflection
            let up: f64 = seen.reactions.iter().filter(|r| r.rod == 1).map(|r| r.force[2]).sum();
            let known = 1e-6 + NewtonOptions::default().tol_increment / last as f64 / deflection;
            assert!((up + seen.total_contact_force).abs() < known * seen.total_contact_force, "reaction {up}");
        }
    }
}

/// A first light touch in one step, searched for without asking for stability. Symptom: 510 iterations and no rest,
/// back and forth between forces of .36 and 6.2, where .081 balances. Mechanism: under a new law the first step starts
/// from the pressures of the one before; plain Newton went on starting from them in all its steps, which makes the
/// slope of another curve of it.
#[test]
fn a_light_touch_is_found_without_asking_for_stability() {
    let gap = 1e-3;
    for crossed in [true, false] {
        let forces = [Options::default(), any_equilibrium()].map(|options| {
            let direction = if crossed { Vec3::z() } else { Vec3::x() };
            let start = Vec3::new(0.5, 2.0 * RADIUS + gap, 0.0) - direction * 0.5;
            let mut model =
                clamped(vec![beam("lower", Vec3::zeros(), Vec3::x(), 16), beam("upper", start, direction, 16)]);
            model.line_loads = vec![LineLoad::of_force(0, Vec3::y()), LineLoad::of_force(1, -Vec3::y())];
            let mut solver = Solver::new(model, options).unwrap();
            let report = solver.step_to(&[Ramp::Load { to: 384.0 * gap }]).unwrap();
            assert_eq!(report.status, Status::Converged, "{}", common::history(&report));
            println!("crossed {crossed}: {} iterations", report.iterations);
            assert!(report.iterations < 100, "{}", common::history(&report));
            observed(&solver, &report).total_contact_force
        });
        assert!((forces[0] / forces[1] - 1.0).abs() < 1e-6 && forces[0] > 0.05, "{forces:?}");
    }
}

/// Beams that are soft along (EA = 100 B/L²), pressed together by δ = 1e-3 L: 96 B δ/L³ between clamps, 24 B δ/L³
/// simply supported.
#[test]
fn crossed_beams_press_as_in_the_textbook() {
    let deflection = 1e-3;
    for (name, clamped, factor) in [("clamped", true, 96.0), ("simply supported", false, 24.0)] {
        let section = Section::isotropic(1.0, 1.0, 1e2, 1e9, RADIUS);
        let beam = |name: &str, start: Vec3, direction: Vec3| {
            let shape = Shape::Line { start, direction, length: 1.0 };
            Rod::new(name, &shape, RodMesh::open(16, 3), section, Natural::Straight).unwrap()
        };
        let rods = vec![
            beam("lower", Vec3::x() * -0.5, Vec3::x()),
            beam("upper", Vec3::new(0.0, -0.5, 2.5 * RADIUS), Vec3::y()),
        ];
        let last = rods[0].num_nodes() - 1;
        // simply supported ends turn about the horizontal normal of their beam
        let support = |rod: usize, node: usize| Support {
            node: NodeRef { rod, node },
            position: [true; 3],
            rotation: if clamped { [true; 3] } else { [rod == 0, rod == 1, true] },
        };
        let supports = [(0, 0), (0, last), (1, 0), (1, last)].map(|(rod, node)| support(rod, node)).to_vec();
        let law = ContactLaw::AugmentedLagrangian { stiffness: 1e12 * RADIUS.powi(4), tol_penetration: 1e-8 };
        let model = Model { rods, supports, contact: Contact { law }, ..Model::default() };
        let mut solver = Solver::new(model, Options::default()).unwrap();
        let to_depth = Vec3::z() * -(0.5 * RADIUS + deflection);
        let ramps = [0, last].map(|node| Ramp::Displacement { node: NodeRef { rod: 1, node }, to: to_depth });
        let seen = to(&mut solver, &ramps);
        let exact = factor * deflection;
        let name = format!("crossed beams, {name}, δ/L = {deflection}");
        verify(&name, "contact force", seen.total_contact_force, exact, 3e-5 * exact);
        let up: f64 = seen.reactions.iter().filter(|r| r.rod == 1).map(|r| r.force[2]).sum();
        verify(&name, "reactions of the upper beam", -up, exact, 3e-5 * exact);
    }
}

/// The force of two crossing beams does not depend on the crossing angle, from nearly parallel to perpendicular.
#[test]
fn any_crossing_angle_gives_the_same_force() {
    let deflection = 1e-4;
    for degrees in [3.0f64, 10.0, 30.0, 60.0, 90.0] {
        let direction = Vec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
        let lower = beam("lower", Vec3::new(-0.5, 0.0, 0.0), Vec3::x(), 24);
        let upper = beam("upper", Vec3::z() * (2.5 * RADIUS) - direction * 0.5, direction, 24);
        let last = upper.num_nodes() - 1;
        let mut solver = Solver::new(clamped(vec![lower, upper]), Options::default()).unwrap();
        let ramps = [0, last].map(|node| Ramp::Displacement {
            node: NodeRef { rod: 1, node },
            to: Vec3::z() * -(0.5 * RADIUS + deflection),
        });
        let seen = to(&mut solver, &ramps);
        let exact = 96.0 * deflection;
        println!("{degrees}°: force {} exact {exact}, {} site(s)", seen.total_contact_force, seen.sites.len());
        assert!((seen.total_contact_force / exact - 1.0).abs() < 5e-3, "force {}", seen.total_contact_force);
        assert!((seen.sites[0].angle - degrees).abs() < 0.1, "angle {}", seen.sites[0].angle);
    }
}

#[test]
fn parallel_beams_touch_in_a_point_then_along_a_line() {
    let gap = 1e-4;
    let lower = beam("lower", Vec3::zeros(), Vec3::x(), 24);
    let upper = beam("upper", Vec3::new(0.0, 2.0 * RADIUS + gap, 0.0), Vec3::x(), 24);
    let first = 192.0 * gap;
    let mut model = clamped(vec![lower, upper]);
    model.planar = true;
    model.line_loads = vec![LineLoad::of_force(0, Vec3::y()), LineLoad::of_force(1, -Vec3::y())];
    let mut solver = Solver::new(model, Options::default()).unwrap();
    let mut at = |factor: f64| to(&mut solver, &[Ramp::Load { to: factor * first }]);
    let seen = at(0.98);
    assert!(seen.sites.is_empty(), "{:?}", seen.sites);
    for factor in [1.5, 2.0, 2.9] {
        let seen = at(factor);
        assert_eq!(seen.sites.len(), 1);
        // a clamped beam under q with a central force F deflects (q/384 − F/192) L⁴/B at mid-span = g/2
        let exact = 0.5 * factor * first - 96.0 * gap;
        println!("{factor} q1: force {} exact {exact}, zone {:?}", seen.total_contact_force, seen.sites[0].arc_a);
        assert!((seen.total_contact_force / exact - 1.0).abs() < 5e-3);
    }
    for factor in [6.0, 12.0, 24.0] {
        let seen = at(factor);
        let q = factor * first;
        // lift-off length ℓ at each end: the line spans L − 2ℓ and carries q plus end reactions qℓ/3... in all q(L −
        // 2ℓ) + 2 qℓ/3
        let lift_off = (36.0 * gap / q).powf(0.25);
        let exact = q * (1.0 - 2.0 * lift_off) + 2.0 * q * lift_off / 3.0;
        let from = seen.sites.iter().map(|s| s.arc_a[0]).fold(f64::INFINITY, f64::min);
        let until = seen.sites.iter().map(|s| s.arc_a[1]).fold(0.0, f64::max);
        println!(
            "{factor} q1: force {} exact {exact}, line {from:.4}..{until:.4}, ℓ {lift_off:.4}",
            seen.total_contact_force
        );
        assert!((seen.total_contact_force / exact - 1.0).abs() < 1e-2);
        assert!((from - lift_off).abs() < 0.02 && (1.0 - until - lift_off).abs() < 0.02);
    }
}

/// A quarter of a beam that is guided at both ends and loaded in the middle by F: a cantilever of length L/4 with the
/// dead end load P = F/2, B θ'' = −P cos θ, θ(0) = 0, θ'(L/4) = 0. Returns end deflection ∫sin θ, shortening ∫(1 − cos
/// θ) and θ'(0).
fn elastica_quarter(force: f64) -> [f64; 3] {
    let (length, load) = (0.25, 0.5 * force);
    let rate = |y: &[f64; 4]| [y[1], -load * y[0].cos(), y[0].sin(), 1.0 - y[0].cos()];
    let shoot = |start: f64| runge_kutta::along(rate, [0.0, start, 0.0, 0.0], length, 4000);
    let start = root(0.0, load * length, |start| shoot(start)[1]);
    let end = shoot(start);
    [end[2], end[3], start]
}

/// Two beams that cross at right angles, their ends guided (free to slide along the beam, not to turn), pressed into
/// each other by 60 % of their length. Each is a planar elastica under a force in the middle: four cantilevers of a
/// quarter of its length.
///
/// ```text
///      ──╮               ╭──   ends of the upper beam lowered by δ beyond touch
///         ╲             ╱
///          ╰────(o)────╯
///               ╱ ╲            (o): the lower beam, seen end on, itself bent down by the same amount
/// ```
///
/// Reference: shooting in this test, Runge–Kutta of fourth order, 4000 steps.
#[test]
fn crossed_beams_at_large_displacement_are_elasticas() {
    let section = Section::isotropic(1.0, 1.0, 1e8, 1e8, RADIUS);
    let guided = |name: &str, direction: Vec3, z: f64| {
        let shape = Shape::Line { start: Vec3::z() * z - direction * 0.5, direction, length: 1.0 };
        Rod::new(name, &shape, RodMesh::open(16, 3), section, Natural::Straight).unwrap()
    };
    let rods = vec![guided("lower", Vec3::x(), 0.0), guided("upper", Vec3::y(), 2.5 * RADIUS)];
    let last = rods[0].num_nodes() - 1;
    let mut supports = Vec::new();
    for rod in 0..2 {
        let along: [bool; 3] = std::array::from_fn(|k| k == rod);
        for node in [0, last] {
            let node = NodeRef { rod, node };
            supports.push(Support { node, position: along.map(|x| !x), rotation: [true; 3] });
        }
        // by symmetry the middle does not slide; nothing else would hold it
        let node = NodeRef { rod, node: last / 2 };
        supports.push(Support { node, position: along, rotation: [false; 3] });
    }
    let penalty = |kappa: f64| ContactLaw::Penalty { stiffness: kappa * RADIUS.powi(4) };
    let model = Model { rods, supports, contact: Contact { law: penalty(1e7) }, ..Model::default() };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    // a step that moves the ends by five diameters at once does not converge
    let mut lowered = 0.0;
    for depth in [0.01, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6] {
        solver.set_contact_law(penalty(1e7)).unwrap();
        let parts = f64::ceil((depth - lowered) / 0.02);
        for part in 1..=parts as u32 {
            let by = lowered + (depth - lowered) * f64::from(part) / parts;
            let ramps = [0, last].map(|node| Ramp::Displacement {
                node: NodeRef { rod: 1, node },
                to: Vec3::z() * -(0.5 * RADIUS + by),
            });
            to(&mut solver, &ramps);
        }
        lowered = depth;
        for decade in 8..=13 {
            solver.set_contact_law(penalty(10f64.powi(decade))).unwrap();
            assert_eq!(solver.find_equilibrium().status, Status::Converged);
        }
        let seen = to(&mut solver, &[]);
        // secant on the force
        let (mut force, mut step) = (96.0 * depth, 9.6 * depth);
        let miss = |force: f64| 4.0 * elastica_quarter(force)[0] - depth;
        let mut last_miss = miss(force - step);
        for _ in 0..20 {
            let now = miss(force);
            step *= -now / (now - last_miss);
            last_miss = now;
            force += step;
            if step.abs() < 1e-12 * force {
                break;
            }
        }
        let [_, shortening, curvature] = elastica_quarter(force);
        let name = "crossed beams, guided ends";
        // what the supports carry: the site's ∫p adds up magnitudes, whose directions differ by the width of the zone
        // over D
        let [below, above] =
            [0, 1].map(|rod| -> f64 { seen.reactions.iter().filter(|r| r.rod == rod).map(|r| r.force[2]).sum() });
        verify(name, &format!("force at δ/L = {depth}"), -above, force, 3e-6 * force);
        verify(name, &format!("vertical balance at δ/L = {depth}"), below, -above, 1e-7 * force);
        let end = solver.engine().positions(0)[last].x;
        verify(name, &format!("end of the beam at δ/L = {depth}"), end, 0.5 - 2.0 * shortening, 1e-6);
        let clamp = seen.reactions.iter().find(|r| r.rod == 0 && r.node == 0).unwrap();
        verify(
            name,
            &format!("moment at the guide, δ/L = {depth}"),
            clamp.moment[1].abs(),
            curvature,
            3e-6 * curvature,
        );
    }
}

/// Parallel beams, the load at which the point opens into a line, and what the supports carry beyond.
///
/// ```text
///  ↓ ↓ ↓ ↓ ↓ ↓ ↓ ↓ ↓ ↓ ↓ q
///  ▌‾‾\_____________/‾‾▐      a line L − 2ℓ with pressure q, forces qℓ/3 at its ends; a clamp carries qℓ − qℓ/3
///  ▌__/‾‾‾‾‾‾‾‾‾‾‾‾‾\__▐
///  ↑ ↑ ↑ ↑ ↑ ↑ ↑ ↑ ↑ ↑ ↑ q
/// ```
///
/// Exact for small displacements: point → line at 3 q₁ (the curvature in the middle vanishes), lift-off length ℓ = (36
/// B g/q)^¼. The beams are soft along (EA = 100 B/L²), so that the gap of 1e-4 L costs no tension, and stiff in shear.
#[test]
fn parallel_beams_open_into_a_line_at_three_times_the_touching_load() {
    let gap = 1e-4;
    let first = 192.0 * gap;
    let section = Section::isotropic(1.0, 1.0, 1e2, 1e9, RADIUS);
    let beam = |name: &str, y: f64, elements: usize| {
        let shape = Shape::Line { start: Vec3::y() * y, direction: Vec3::x(), length: 1.0 };
        Rod::new(name, &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap()
    };
    let penalty = |kappa: f64| ContactLaw::Penalty { stiffness: kappa * RADIUS.powi(4) };
    let pair = |elements: usize| {
        let mut model = clamped(vec![beam("lower", 0.0, elements), beam("upper", 2.0 * RADIUS + gap, elements)]);
        model.planar = true;
        model.contact = Contact { law: penalty(1e6) };
        model.line_loads = vec![LineLoad::of_force(0, Vec3::y()), LineLoad::of_force(1, -Vec3::y())];
        Solver::new(model, Options::default()).unwrap()
    };
    let at = |solver: &mut Solver, factor: f64, top: i32| {
        solver.set_contact_law(penalty(1e6)).unwrap();
        to(solver, &[Ramp::Load { to: factor * first }]);
        for decade in 7..=top {
            solver.set_contact_law(penalty(10f64.powi(decade))).unwrap();
            to(solver, &[]);
        }
        to(solver, &[])
    };
    let mut solver = pair(16);
    // uniform load alone brings the middles together in proportion
    let seen = at(&mut solver, 0.99, 6);
    verify(
        "parallel beams",
        "gap left at 0.99 q₁, over that at first",
        seen.contact_gap.unwrap().upper / gap,
        0.01,
        2e-6,
    );
    let (mut bent, mut factors) = (Vec::new(), Vec::new());
    for factor in [2.2, 2.6, 2.9] {
        // the force spreads over (B/κ)^¼, so that its effect on the gap errs by the square of that, κ^−½; at a tenfold
        // stiffness the error of the force were as much by rounding of the gap
        let [softer, harder] = [11, 12].map(|top| at(&mut solver, factor, top).total_contact_force);
        let force = harder + (harder - softer) / (10f64.sqrt() - 1.0);
        solver.set_contact_law(penalty(1e13)).unwrap();
        let seen = to(&mut solver, &[]);
        assert_eq!(seen.sites.len(), 1);
        let site = &seen.sites[0];
        let point = PointForce { force: -Vec3::y() * site.force, spread: site.spread[0] };
        bent.push(tangent_and_curvature(&solver, 0, site.center[0], point).1.y);
        factors.push(factor);
        verify(
            "parallel beams",
            &format!("force at the point, {factor} q₁"),
            force,
            0.5 * factor * first - 96.0 * gap,
            1e-6 * first,
        );
    }
    verify("parallel beams", "q/q₁, point → line", interpolate_to_zero(&bent, &factors), 3.0, 1e-5);
    let mut solver = pair(96);
    for factor in [6.0, 12.0, 24.0] {
        let seen = at(&mut solver, factor, 9);
        let q = factor * first;
        let lift_off = (36.0 * gap / q).powf(0.25);
        let exact = q * (1.0 - 2.0 * lift_off) + 2.0 * q * lift_off / 3.0;
        verify(
            "parallel beams",
            &format!("resultant along the line, {factor} q₁"),
            seen.total_contact_force,
            exact,
            1e-5 * exact,
        );
        let from = seen.sites.iter().map(|s| s.arc_a[0]).fold(f64::INFINITY, f64::min);
        // the line begins earlier by about the layer (2B/κ)^¼ of the law
        verify("parallel beams", &format!("lift-off length, {factor} q₁"), from, lift_off, 1.5 * 2e-9f64.powf(0.25));
        let clamp = seen.reactions.iter().find(|r| r.rod == 0 && r.node == 0).unwrap().force[1].abs();
        let end_force = q * lift_off - clamp;
        verify(
            "parallel beams",
            &format!("end force qℓ/3, {factor} q₁"),
            end_force,
            q * lift_off / 3.0,
            1e-4 * q * lift_off,
        );
    }
}

/// The load as the parameter of a path, through first contact at q₁ = 192 B g/L⁴ and back: a corner so mild that steps
/// go past it.
#[test]
fn a_path_goes_through_first_contact_and_back() {
    let gap = 1e-4;
    let first = 192.0 * gap;
    let section = Section::isotropic(1.0, 1.0, 1e2, 1e9, RADIUS);
    let beam = |name: &str, y: f64| {
        let shape = Shape::Line { start: Vec3::y() * y, direction: Vec3::x(), length: 1.0 };
        Rod::new(name, &shape, RodMesh::open(16, 3), section, Natural::Straight).unwrap()
    };
    let mut model = clamped(vec![beam("lower", 0.0), beam("upper", 2.0 * RADIUS + gap)]);
    model.planar = true;
    model.line_loads = vec![LineLoad::of_force(0, Vec3::y()), LineLoad::of_force(1, -Vec3::y())];
    let mut solver = Solver::new(model, Options::default()).unwrap();
    for (name, to) in [("up", 2.5 * first), ("down", 0.2 * first)] {
        let mut force = 0.0;
        let report = solver.follow(&Ramp::Load { to }, &FollowOptions::default(), &mut |point| {
            force = observe(&point.progress).total_contact_force;
            ControlFlow::Continue(())
        });
        let report = report.unwrap();
        assert_eq!(report.end, PathEnd::Target);
        let exact = (0.5 * to - 96.0 * gap).max(0.0);
        verify(
            "parallel beams, path",
            &format!("force at its end, {name}, over q₁ L"),
            force / first,
            exact / first,
            1e-4,
        );
    }
}
