//! Harmonic free energies and sensitivities against closed forms and whole runs.
//!
//! * A ring of C/B = 1.5 with the excess link ΔLk, x = C ΔLk/B: F(ΔLk) − F(0) = 2π²C ΔLk²/L + kT ln P(x), P = Π_{n≥2}
//!   (1 − x²/(n² − 1)) = −2 sin(π√(1 + x²))/(πx²√(1 + x²)). Each n has its mode twice, and each Gaussian gives half a
//!   logarithm.
//! * A clamped straight rod under the moment M or the tension T: the ratio of its determinant to that without is the
//!   square (two planes) of D(M)/D(0) of solutions that start from the clamp (Gelfand & Yaglom 1960, Forman 1987).
//!   With m = ML/B: D = |½g′ − g| at 1, g = (e^{ims} − 1 − ims + m²s²/2)/(im)³; with k² = TL²/B: D = (2 − 2 cosh k +
//!   k sinh k)/k⁴; both 1/12 at 0. The zero of the first is Greenhill's moment. For large k the slope is that of
//!   Marko & Siggia (1995): 1 − z/L = ½ kT/√(BT).
//!
//!   On a mesh the short waves of its spacing do not feel what couples their planes, so that logarithms of ratios
//!   converge as the node spacing: they are extrapolated from two meshes.
//! * J-factors: of a held straight rod by its compliance, of DNA with a protein by the stiffness of its end, of rings
//!   by the formula at the test.
//! * Derivatives: of energies by link 2π × the moment at the seam, by a radius the contact force; central differences
//!   of whole runs; reciprocity of reactions.

use crate::common;

use common::{any_equilibrium, end_of, verify};
use std::f64::consts::{PI, TAU};
use std::path::Path;
use supercoil::math::{Quat, Vec3};
use supercoil::nalgebra::{Complex, Matrix6};
use supercoil::rod::{Natural, Rod, RodMesh, RodNumber, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, NodeLoad, NodeRef, Obstacle, Ramp, Scene, Support};
use supercoil::solve::{Options, Solver, Status};
use supercoil::tangent::{ContactResponse, EquilibriumTangent, Harmonic, Observable, PrescribedNumber};

const RIGID: f64 = 1e8;

fn reach(solver: &mut Solver, ramps: &[Ramp]) {
    let report = solver.step_to(ramps).unwrap();
    assert_eq!(report.status, Status::Converged, "{ramps:?}: {}", common::history(&report));
}

/// The limit of what converges as the node spacing, from a mesh and one twice as fine.
fn limit(of: impl Fn(usize) -> f64) -> f64 {
    2.0 * of(64) - of(32)
}

fn harmonic(solver: &mut Solver, contacts: ContactResponse) -> Harmonic {
    EquilibriumTangent::at(solver, contacts).unwrap().harmonic()
}

fn ring(excess_link: f64, elements: usize, stiff: f64) -> Solver {
    let section = Section::isotropic(1.0, 1.5, stiff, stiff, 0.0);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(elements, 3), section, Natural::Straight).unwrap();
    let model = Model { rods: vec![rod], contact: Contact::NONE, ..Model::default() };
    let mut solver = Solver::new(model, any_equilibrium()).unwrap();
    reach(&mut solver, &[Ramp::ExcessLink { rod: 0, to: excess_link }]);
    solver
}

#[test]
fn twisted_ring() {
    const KT: f64 = 0.02;
    let flat = [32, 64].map(|elements| harmonic(&mut ring(0.0, elements, RIGID), ContactResponse::ByLaw));
    let names: Vec<(&str, usize)> =
        flat[0].zero_modes.iter().map(|mode| (mode.name.as_str(), mode.dimension)).collect();
    assert_eq!(names, [("displacement", 3), ("rotation", 3), ("spin", 1)]);
    for (x, in_table) in [(0.25, 0.953_952), (0.5, 0.825_360), (1.0, 0.433_909), (1.5_f64, 0.091_141_1)] {
        let root = (1.0 + x * x).sqrt();
        let exact = -2.0 * (PI * root).sin() / (PI * x * x * root);
        verify("ring", &format!("P({x}) in print"), exact, in_table, 1e-6);
        let elastic = 2.0 * PI * PI * 1.5 * (x / 1.5_f64).powi(2);
        let found = limit(|elements| {
            let twisted = harmonic(&mut ring(x / 1.5, elements, RIGID), ContactResponse::ByLaw);
            twisted.relative_to(&flat[usize::from(elements == 64)], KT).unwrap() - elastic
        });
        verify("ring", &format!("ln P({x})"), found / KT, exact.ln(), 1e-3 * x * x);
    }
}

/// GJ of [`clamped`].
const TWISTING: f64 = 1.3;

/// A straight rod between clamps, the far one free along the axis, under tension and turned until it bears a moment.
fn clamped(tension: f64, moment: f64, elements: usize) -> Solver {
    let section = Section::isotropic(1.0, TWISTING, RIGID, RIGID, 0.0);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod = Rod::new("rod", &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap();
    let end = end_of(&rod);
    let model = Model {
        supports: vec![
            Support::clamp(NodeRef { rod: 0, node: 0 }),
            Support { node: end, position: [false, true, true], rotation: [true; 3] },
        ],
        loads: vec![NodeLoad { node: end, force: Vec3::x() * tension, moment: Vec3::zeros() }],
        load: 1.0,
        contact: Contact::NONE,
        rods: vec![rod],
        ..Model::default()
    };
    let mut solver = Solver::new(model, any_equilibrium()).unwrap();
    let state = solver.engine().state();
    let (start, last) = (state.frames()[0], state.frames().len() - 1);
    let along = (0..=last).map(|i| i as f64 / last as f64);
    let positions = along.clone().map(|s| Vec3::x() * (s * (1.0 + tension / RIGID))).collect();
    let frames = along.map(|s| Quat::from_scaled_axis(Vec3::x() * (s * moment / TWISTING)) * start).collect();
    let state = state.with_nodes(positions, frames);
    solver.set_state(state).unwrap();
    solver
}

#[test]
fn greenhill() {
    let of = |m: f64, elements: usize| harmonic(&mut clamped(0.0, m, elements), ContactResponse::ByLaw).log_determinant;
    for m in [2.0, 5.0, 8.0_f64] {
        // real and imaginary parts of (im)³ g = −i m³ g and of its slope at 1
        let (sin, cos) = m.sin_cos();
        let (g, slope) = ([cos - 1.0 + m * m / 2.0, sin - m], [-m * sin + m * m, m * cos - m]);
        let exact = 12.0 * (0.5 * slope[0] - g[0]).hypot(0.5 * slope[1] - g[1]) / m.powi(3);
        let found = limit(|elements| of(m, elements) - of(0.0, elements));
        verify("Greenhill", &format!("½ ln det, M = {m}"), 0.5 * found, exact.ln(), 1e-4 * m * m);
    }
}

#[test]
fn strong_stretching() {
    let of = |tension: f64, elements: usize| {
        0.5 * harmonic(&mut clamped(tension, 0.0, elements), ContactResponse::ByLaw).log_determinant
    };
    let exact = |k: f64| (12.0 * (2.0 - 2.0 * k.cosh() + k * k.sinh()) / k.powi(4)).ln();
    for tension in [10.0, 100.0, 900.0_f64] {
        let found = limit(|elements| of(tension, elements) - of(0.0, elements));
        verify("clamped rod", &format!("½ ln det, T = {tension}"), found, exact(tension.sqrt()), 2e-5 * tension);
    }
    // 1 − z/L over kT = ∂F/∂T/kT, of a rod without ends but for a part in 3/k
    let slope = limit(|elements| (of(925.0, elements) - of(875.0, elements)) / 50.0);
    let exact = 0.5 / 900.0_f64.sqrt();
    verify("strong stretching, TL²/B = 900", "1 − z/L over kT", slope, exact, 0.12 * exact);
}

/// A molecule between clamps, as in tweezers: its extension and its torque at kT are −∂F/∂T and ∂F/∂(turns)/2π. Under
/// the tension T and the moment M the determinant's ratio is |g′² − g g″|² of g that starts from the clamp with g‴ = 1:
/// exponents a, b = ½iM ± √(T − ¼M²) and 0 twice, g = (e^{as}/a² − e^{bs}/b²)/(a − b) + s/ab + (a + b)/(ab)². For long
/// rods, √(T − ¼M²) of it, that is the shortening of Marko & Siggia (1995) and the softening of Moroz & Nelson (1997),
/// 1/C + kT/(4B√(BT)).
#[test]
fn extension_and_torque_at_a_temperature() {
    const KT: f64 = 0.004;
    let log_ratio = |tension: f64, moment: f64| {
        let root = Complex::new(tension - 0.25 * moment * moment, 0.0).sqrt();
        let (a, b) = (Complex::new(0.0, 0.5 * moment) + root, Complex::new(0.0, 0.5 * moment) - root);
        let term = |k: i32| (a.exp() * a.powi(k - 2) - b.exp() * b.powi(k - 2)) / (a - b);
        let g = term(0) + (a * b).inv() + (a + b) / (a * b).powi(2);
        let (slope, second) = (term(1) + (a * b).inv(), term(2));
        (slope * slope - g * second).norm().ln()
    };
    let difference = |f: &dyn Fn(f64) -> f64, at: f64, step: f64| (f(at + step) - f(at - step)) / (2.0 * step);
    for (tension, moment) in [(100.0, 0.0), (100.0, 4.0)] {
        let turned = |elements: usize| PrescribedNumber::Rotation {
            node: NodeRef { rod: 0, node: 3 * elements },
            axis: Vec3::x(),
        };
        let slope = |elements: usize, to: &PrescribedNumber| {
            let mut solver = clamped(tension, moment, elements);
            EquilibriumTangent::thermal_slope(&mut solver, to, (ContactResponse::ByLaw, KT)).unwrap()
        };
        let case = format!("tweezers, TL²/B = {tension}, ML/B = {moment}");
        let of_load = slope(32, &PrescribedNumber::Load);
        let length = 1.0 + tension / RIGID;
        verify(&case, "extension without heat", -of_load.of_potential / tension, length, 1e-5);
        let shorter = limit(|elements| slope(elements, &PrescribedNumber::Load).by_heat / (tension * KT));
        let exact = difference(&|tension| log_ratio(tension, moment), tension, 1e-3 * tension);
        verify(&case, "shortening over kT", shorter, exact, 2e-3 * exact);
        let torque = slope(32, &turned(32)).of_potential / TAU;
        verify(&case, "torque without heat", torque, moment, 1e-5);
        let softer = limit(|elements| slope(elements, &turned(elements)).by_heat / (TAU * KT));
        let exact = TWISTING * difference(&|moment| log_ratio(tension, moment), moment, 1e-3);
        verify(&case, "change of the torque over kT", softer, exact, 2e-3 * exact.abs() + 1e-6);
        if moment > 0.0 {
            // a rod without ends
            let print = -TWISTING * moment / (4.0 * tension.sqrt());
            verify(&case, "softening of Moroz & Nelson", exact, print, 4.0 / tension.sqrt() * print.abs());
        }
    }
}

#[test]
fn link_and_stiffness_of_a_ring() {
    let link = 0.4;
    let mut solver = ring(link, 24, RIGID);
    let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap();
    let to = [PrescribedNumber::Link { rod: 0 }, PrescribedNumber::parse(&Model::default(), "twisting").unwrap()];
    let energy = tangent.gradient(&Observable::Energy, &to).unwrap();
    let seam = TAU * tangent.value(&Observable::SeamMoment { rod: 0 }).unwrap();
    verify("ring", "dE/dLk = 2πM", energy[0], seam, 1e-6 * seam);
    verify("ring", "dE/dLk", energy[0], 4.0 * PI * PI * 1.5 * link, 2e-6 * seam);
    // stretch takes 1e-6 of it
    verify("ring", "dE/dC", energy[1], 2.0 * PI * PI * link * link, 2e-6 * energy[1]);
    let moment = tangent.gradient(&Observable::SeamMoment { rod: 0 }, &to).unwrap();
    verify("ring", "dM/dLk", moment[0], TAU * 1.5, 2e-6 * moment[0]);
    verify("ring", "dM/dC", moment[1], TAU * link, 2e-6 * moment[1]);
    let twist = tangent.gradient(&Observable::Twist { rod: 0 }, &to).unwrap();
    verify("ring", "dTw/dLk", twist[0], 1.0, 2e-6);
}

/// A curved cantilever under a dead load.
fn cantilever() -> Solver {
    let section = Section { bending: [1.0, 1.4], ..Section::isotropic(1.0, 0.8, 1e4, 1e4, 0.0) };
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let natural = Natural::Uniform { kappa: [0.3, 0.8, 0.5] };
    let rod = Rod::new("rod", &shape, RodMesh::open(12, 3), section, natural).unwrap();
    let mut options = Options::default();
    options.newton.tol_increment = 1e-10;
    let mut solver = Solver::new(common::cantilever(rod, Vec3::new(1.0, -2.0, 0.7), Vec3::zeros()), options).unwrap();
    [0.0, 0.5, 1.0].into_iter().for_each(|to| reach(&mut solver, &[Ramp::Load { to }]));
    solver
}

/// Every kind of number against whole runs.
#[test]
fn cantilever_against_whole_runs() {
    use RodNumber::{Bending1, Bending2, Curvature1, Length, Shearing1, Stretching, Twist, Twisting};
    let mut solver = cantilever();
    let end = end_of(&solver.engine().model().rods[0]);
    let start = NodeRef { rod: 0, node: 0 };
    let numbers = [Bending1, Bending2, Curvature1, Length, Shearing1, Stretching, Twist, Twisting];
    let mut to: Vec<PrescribedNumber> =
        numbers.map(|which| PrescribedNumber::Number { rod: 0, which: vec![which] }).to_vec();
    to.push(PrescribedNumber::Load);
    to.push(PrescribedNumber::Displacement { node: start, direction: Vec3::y() });
    to.push(PrescribedNumber::Rotation { node: start, axis: Vec3::z() });
    let of = [
        Observable::Energy,
        Observable::Twist { rod: 0 },
        Observable::Extension { rod: 0 },
        Observable::Position { node: end, axis: 1 },
        Observable::Reaction { node: start, component: 5 },
    ];
    let mut found = Vec::new();
    let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap();
    of.iter().for_each(|of| found.push(tangent.gradient(of, &to).unwrap()));
    let value = |solver: &mut Solver| -> Vec<f64> {
        let mut tangent = EquilibriumTangent::at(solver, ContactResponse::ByLaw).unwrap();
        of.iter().map(|of| tangent.value(of).unwrap()).collect()
    };
    for (k, parameter) in to.iter().enumerate() {
        let (ramp, step): (Box<dyn Fn(f64) -> Ramp>, f64) = match parameter {
            PrescribedNumber::Number { rod, which } => {
                let (rod, which) = (*rod, which[0]);
                let here = solver.engine().model().rods[rod].number(which);
                (Box::new(move |by| Ramp::Number { rod, which, to: here + by }), 1e-3 * here)
            }
            PrescribedNumber::Load => (Box::new(|by| Ramp::Load { to: 1.0 + by }), 1e-3),
            PrescribedNumber::Displacement { node, direction } => {
                let (node, direction) = (*node, *direction);
                (Box::new(move |by| Ramp::Displacement { node, to: direction * by }), 1e-3)
            }
            PrescribedNumber::Rotation { node, axis } => {
                let (node, axis) = (*node, *axis);
                (Box::new(move |by| Ramp::Rotation { node, axis, to: by }), 2e-4)
            }
            _ => unreachable!(),
        };
        let mut at = |by: f64| {
            reach(&mut solver, &[ramp(by * step)]);
            value(&mut solver)
        };
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(&mut at);
        at(0.0);
        for (i, of) in of.iter().enumerate() {
            let exact = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step);
            verify(
                "cantilever",
                &format!("d {of:?} / d {parameter:?}"),
                found[i][k],
                exact,
                1e-6 * exact.abs().max(1e-2),
            );
        }
    }
}

/// Two rods that cross, clamped at their ends; those of the upper one are lowered until it presses on the lower one.
fn crossed(law: ContactLaw) -> Solver {
    let rod = |name: &str, start: Vec3, direction: Vec3, radius: f64| {
        let section = Section::isotropic(50.0 * radius, 0.8, 1e5, 1e5, radius);
        let shape = Shape::Line { start, direction, length: 1.0 };
        Rod::new(name, &shape, RodMesh::open(15, 3), section, Natural::Straight).unwrap()
    };
    let low = rod("low", Vec3::new(-0.5, 0.0, 0.0), Vec3::x(), 0.02);
    let high = rod("high", Vec3::new(0.03, -0.45, 0.05), Vec3::y(), 0.03);
    let last = low.num_nodes() - 1;
    let ends = [(0, 0), (0, last), (1, 0), (1, last)].map(|(rod, node)| NodeRef { rod, node });
    let supports = ends.map(Support::clamp).to_vec();
    let mut options = Options::default();
    options.newton.tol_increment = 1e-9;
    let model = Model { rods: vec![low, high], supports, contact: Contact { law }, ..Model::default() };
    let mut solver = Solver::new(model, options).unwrap();
    let lower = |node: NodeRef, by: f64| Ramp::Displacement { node, to: Vec3::z() * -by };
    reach(&mut solver, &[lower(ends[2], 0.05), lower(ends[3], 0.06)]);
    solver
}

fn against_runs(name: &str, law: ContactLaw, contacts: ContactResponse, steps: [f64; 3], tolerance: f64) {
    let mut solver = crossed(law);
    let last = solver.engine().model().rods[0].num_nodes() - 1;
    let (node, other) = (NodeRef { rod: 1, node: 0 }, NodeRef { rod: 0, node: last });
    let radius = PrescribedNumber::Number { rod: 0, which: vec![RodNumber::ContactRadius] };
    let bending = PrescribedNumber::Number { rod: 1, which: vec![RodNumber::Bending2] };
    let to = [radius, bending, PrescribedNumber::Displacement { node, direction: Vec3::z() }];
    let of = [
        Observable::Energy,
        Observable::ContactForce,
        Observable::Reaction { node: other, component: 2 },
        Observable::Position { node: NodeRef { rod: 0, node: last / 2 }, axis: 2 },
    ];
    let mut tangent = EquilibriumTangent::at(&mut solver, contacts).unwrap();
    let found: Vec<Vec<f64>> = of.iter().map(|of| tangent.gradient(of, &to).unwrap()).collect();
    let force = tangent.value(&Observable::ContactForce).unwrap();
    if contacts == ContactResponse::Locked {
        verify(name, "dE/dε = force", found[0][0], force, 1e-4 * force);
    }
    let value = |solver: &mut Solver| -> Vec<f64> {
        let mut tangent = EquilibriumTangent::at(solver, contacts).unwrap();
        of.iter().map(|of| tangent.value(of).unwrap()).collect()
    };
    let ramp = |k: usize, by: f64| match k {
        0 => Ramp::Number { rod: 0, which: RodNumber::ContactRadius, to: 0.02 + by },
        1 => Ramp::Number { rod: 1, which: RodNumber::Bending2, to: 1.5 + by },
        _ => Ramp::Displacement { node, to: Vec3::z() * (-0.05 + by) },
    };
    for (k, step) in steps.into_iter().enumerate() {
        let mut at = |by: f64| {
            reach(&mut solver, &[ramp(k, by * step)]);
            value(&mut solver)
        };
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(&mut at);
        at(0.0);
        for (i, of) in of.iter().enumerate() {
            let exact = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step);
            verify(name, &format!("d {of:?} / d {:?}", to[k]), found[i][k], exact, tolerance * exact.abs().max(1e-2));
        }
    }
}

#[test]
fn crossed_rods_under_a_penalty_against_whole_runs() {
    against_runs(
        "crossed rods, penalty",
        ContactLaw::Penalty { stiffness: 0.05 },
        ContactResponse::ByLaw,
        [2e-5, 2e-3, 1e-4],
        1e-5,
    );
}

#[test]
fn crossed_rods_in_hard_contact_against_whole_runs() {
    let law = ContactLaw::AugmentedLagrangian { stiffness: 1e3, tol_penetration: 1e-12 };
    against_runs("crossed rods, hard contact", law, ContactResponse::Locked, [2e-4, 1e-2, 1e-3], 1e-4);
}

/// J-factors. Of a straight rod whose free end is where it is without stress, J = 8π²/√det(2πkT S), S the compliance of
/// the end: in each plane L³/3B + L/GA, L²/2B, L/B, along the axis L/EA and L/C. Of a ring with the excess link ΔLk
///
/// ```text
/// J L³ = 4(2π)^(7/2) b³ √c exp(−2π²(b + c ΔLk²))/P(x)        b = B/LkT, c = C/LkT
/// ```
///
/// Over all links at P = 1 that is 32π³ b³ exp(−2π²b)/L³, with l = L kT/2B 4π³ l⁻⁶ exp(−π²/l) a cubic Kuhn length, as
/// Shimada & Yamakawa (1984) have it to leading order. A chain of 12 to 24 rigid segments with a torque spring at each
/// joint, by its Hessian on the null space of the six conditions of closure, has 7.82 ± 0.01 for the constant's
/// logarithm 7.819.
#[test]
fn j_factors() {
    const KT: f64 = 0.2;
    let straight = |held: bool, elements: usize, stiff: f64| {
        let section = Section::isotropic(1.0, 1.5, stiff, stiff, 0.0);
        let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
        let rod = Rod::new("rod", &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap();
        let ends = [NodeRef { rod: 0, node: 0 }, end_of(&rod)].map(Support::clamp);
        let supports = ends[..if held { 2 } else { 1 }].to_vec();
        let mut solver = Solver::new(
            Model { rods: vec![rod], supports, contact: Contact::NONE, ..Model::default() },
            any_equilibrium(),
        )
        .unwrap();
        reach(&mut solver, &[]);
        harmonic(&mut solver, ContactResponse::ByLaw)
    };
    let found = straight(true, 6, 50.0).j_factor(&straight(false, 6, 50.0), KT).unwrap();
    let plane: f64 = (1.0 / 3.0 + 1.0 / 50.0) - 0.25;
    let compliance = plane * plane / 50.0 / 1.5;
    let exact = 8.0 * PI * PI / (TAU * KT).powi(3) / compliance.sqrt();
    verify("straight rod, ends held", "J L³", found, exact, 1e-8 * exact);
    let free = |elements: usize| {
        let section = Section::isotropic(1.0, 1.5, RIGID, RIGID, 0.0);
        let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
        let rod = Rod::new("rod", &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap();
        let model = Model { rods: vec![rod], contact: Contact::NONE, ..Model::default() };
        let mut solver = Solver::new(model, any_equilibrium()).unwrap();
        reach(&mut solver, &[]);
        harmonic(&mut solver, ContactResponse::ByLaw)
    };
    let open = [32, 64].map(free);
    let (b, c) = (1.0 / KT, 1.5 / KT);
    for x in [0.0, 0.5, 1.0_f64] {
        let root = (1.0 + x * x).sqrt();
        let p = if x > 0.0 { -2.0 * (PI * root).sin() / (PI * x * x * root) } else { 1.0 };
        let energy = 2.0 * PI * PI * (b + c * (x / 1.5).powi(2));
        let found = limit(|elements| {
            let closed = harmonic(&mut ring(x / 1.5, elements, RIGID), ContactResponse::ByLaw);
            closed.j_factor(&open[usize::from(elements == 64)], KT).unwrap().ln()
        });
        let exact = 4.0_f64.ln() + 3.5 * TAU.ln() + 3.0 * b.ln() + 0.5 * c.ln() - energy - p.ln();
        verify(&format!("ring, x = {x}"), "ln J L³", found, exact, 2e-2);
    }
}

/// Slopes of a free energy do not depend on what was asked before. (The number that a slope was taken by kept the value
/// of the last difference.)
#[test]
fn slopes_do_not_depend_on_each_other() {
    const KT: f64 = 0.01;
    let mut solver = cantilever();
    let names = ["bending", "load", "twisting", "length"];
    let to = names.map(|name| PrescribedNumber::parse(solver.engine().model(), name).unwrap());
    let mut slopes = |to: &PrescribedNumber| {
        EquilibriumTangent::thermal_slope(&mut solver, to, (ContactResponse::ByLaw, KT)).unwrap().total()
    };
    let alone: Vec<f64> = to.iter().rev().map(&mut slopes).collect();
    let again: Vec<f64> = to.iter().map(&mut slopes).collect();
    for ((name, again), alone) in names.iter().zip(&again).zip(alone.iter().rev()) {
        verify("cantilever", &format!("slope by {name}"), *again, *alone, 1e-7 * alone.abs().max(KT));
    }
}

/// A straight rod without loads bends harmonically, however far: only its stretch is of higher order along the parabola
/// that a mode is followed on.
#[test]
fn a_soft_straight_rod_is_harmonic() {
    // DNA of 200 and 400 base pairs, nm and pN; it was void by a hundred
    for (length, elements) in [(68.0, 12), (136.0, 24)] {
        let section = Section::isotropic(205.7, 308.6, 1100.0, 1100.0, 1.0);
        let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length };
        let rod = Rod::new("rod", &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap();
        let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 })];
        let model = Model { rods: vec![rod], supports, ..Model::default() };
        let mut solver = Solver::new(model, any_equilibrium()).unwrap();
        reach(&mut solver, &[]);
        let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::Free).unwrap();
        let worst = tangent.anharmonicity(4, 4.11).unwrap().into_iter().fold(0.0, f64::max);
        assert!(worst < 0.25, "{length}: {worst}");
    }
}

/// Rings of a sequence whose steps are all alike spin about themselves like uniform ones. (That had an eigenvalue of
/// rounding, of either sign, which decided whether there was a free energy.)
#[test]
fn rings_of_a_sequence_of_equal_steps_spin() {
    for (base_pairs, link) in [(105, 10), (126, 12), (150, 14)] {
        let text = format!(
            "[[rods]]\nclosed = true\nshape = {{ kind = \"circle\", length = {} }}\nlink = {link}\n\
             sequence = {{ letters = \"random:{base_pairs}:3\", steps = \"ideal\" }}\n\
             section = {{ contact_radius = 1.0 }}\n",
            0.34 * f64::from(base_pairs)
        );
        let scene = Scene::from_toml(&text, Path::new("")).unwrap();
        let mut solver = Solver::new(scene.model, Options::default()).unwrap();
        reach(&mut solver, &[]);
        let tangent = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap();
        // six of a rigid body and the spin; sliding is one of these along a circle
        assert_eq!((tangent.num_zero_energy(), tangent.num_unstable()), (7, 0), "{base_pairs}");
        assert!(tangent.harmonic().free_energy(4.11).is_ok());
    }
}

/// What a motion that costs nothing changes has no standard deviation; a distance has.
#[test]
fn free_ends_have_no_deviation() {
    let section = Section::isotropic(1.0, 1.5, RIGID, RIGID, 0.0);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod = Rod::new("rod", &shape, RodMesh::open(8, 3), section, Natural::Straight).unwrap();
    let model = Model { rods: vec![rod], contact: Contact::NONE, ..Model::default() };
    let mut solver = Solver::new(model, any_equilibrium()).unwrap();
    reach(&mut solver, &[]);
    let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap();
    let position = Observable::Position { node: NodeRef { rod: 0, node: 24 }, axis: 1 };
    assert!(tangent.covariance(&[position], 0.1).is_err());
    assert!(tangent.covariance(&[Observable::Extension { rod: 0 }], 0.1).is_ok());
}

/// The J-factor of a piece of DNA with a protein on it whose end is where it is without stress: 8π²√det(K)/(2πkT)³, K
/// the reactions of the held end by its six motions. Two determinants of all unknowns beside one of six, found by
/// derivatives.
#[test]
fn j_factor_of_a_sequence_with_a_protein() {
    const KT: f64 = 4.1;
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("j_factor_protein");
    std::fs::create_dir_all(&folder).unwrap();
    let table =
        "hold,from,to,tilt,roll,twist,shift,slide,rise\nsteps,8,12,0,9,31,0,0.2,3.3\nfrozen,14,16,0,0,0,0,0,0\n";
    std::fs::write(folder.join("protein.csv"), table).unwrap();
    let text = r#"
        [[rods]]
        shape = { kind = "line", length = 6.8 }
        sequence = { letters = "ATCGATATATATGGATATATA", steps = "ideal", proteins = "protein.csv" }
        section = { contact_radius = 0.0 }
        [[supports]]
        at = "start"
        position = true
        rotation = true
    "#;
    let model = Scene::from_toml(text, &folder).unwrap().model;
    let end = end_of(&model.rods[0]);
    let mut open = Solver::new(model.clone(), Options::default()).unwrap();
    reach(&mut open, &[]);
    let mut held = model;
    held.supports.push(Support::clamp(end));
    let mut closed = Solver::new(held, Options::default()).unwrap();
    closed.set_state(open.engine().state().clone()).unwrap();
    reach(&mut closed, &[]);
    let mut tangent = EquilibriumTangent::at(&mut closed, ContactResponse::ByLaw).unwrap();
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let moved = axes.map(|direction| PrescribedNumber::Displacement { node: end, direction });
    let turned = axes.map(|axis| PrescribedNumber::Rotation { node: end, axis });
    let motions = [moved, turned].concat();
    let mut row =
        |component: usize| tangent.gradient(&Observable::Reaction { node: end, component }, &motions).unwrap();
    let rows: Vec<Vec<f64>> = (0..6).map(&mut row).collect();
    let stiffness = Matrix6::from_fn(|i, k| if k < 3 { rows[i][k] } else { rows[i][k] / TAU });
    let exact = 8.0 * PI * PI * stiffness.determinant().sqrt() / (TAU * KT).powi(3);
    let found = tangent.harmonic().j_factor(&harmonic(&mut open, ContactResponse::ByLaw), KT).unwrap();
    verify("21 base pairs with a protein", "J", found, exact, 1e-7 * exact);
}

/// Reactions by displacements are a symmetric matrix (Maxwell & Betti), with contact. Locked points keep their smallest
/// gap by a pressure over their zone, which is off by κ'^(−2/3), 1.1e-7 at κ' = 1e3 and 2.4e-8 at 1e4; beyond, rounding
/// in the stiffness of contact counts, 7e-7 at 1e6.
#[test]
fn reciprocity() {
    let mut solver = crossed(ContactLaw::AugmentedLagrangian { stiffness: 1e4, tol_penetration: 1e-12 });
    let last = solver.engine().model().rods[0].num_nodes() - 1;
    let (low, high) = (NodeRef { rod: 0, node: 0 }, NodeRef { rod: 1, node: last });
    for contacts in [ContactResponse::ByLaw, ContactResponse::Locked, ContactResponse::Free] {
        let mut tangent = EquilibriumTangent::at(&mut solver, contacts).unwrap();
        let mut of = |node: NodeRef, moved: NodeRef| {
            let to = PrescribedNumber::Displacement { node: moved, direction: Vec3::z() };
            tangent.gradient(&Observable::Reaction { node, component: 2 }, &[to]).unwrap()[0]
        };
        let [there, back] = [of(low, high), of(high, low)];
        verify("crossed rods", &format!("reciprocity, {contacts:?}"), there, back, 1e-7 * back.abs() + 1e-9);
        assert!(contacts == ContactResponse::Free || back.abs() > 1.0, "{back}");
    }
}

/// A cantilever above a table, its end pressed down on it, in the plane, at thermal energies where the end leaves the
/// table now and then: the variance of its middle lies between those with contact locked and free. The independent
/// one is that of a Metropolis chain of 60 segments with a hard table; it turns all that follows a hinge.
#[test]
fn a_chain_on_a_table_fluctuates_between_the_bounds() {
    const KT: f64 = 0.003;
    let (height, load, radius) = (0.1, 0.6, 0.01);
    let section = Section::isotropic(1.0, 1.0, 1e5, 1e5, radius);
    let shape = Shape::Line { start: Vec3::y() * (height + radius), direction: Vec3::x(), length: 1.0 };
    let rod = Rod::new("rod", &shape, RodMesh::open(20, 3), section, Natural::Straight).unwrap();
    let end = end_of(&rod);
    let table = Obstacle::plane("table", Vec3::zeros(), Vec3::y());
    let model = Model {
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        loads: vec![NodeLoad { node: end, force: Vec3::y() * -load, moment: Vec3::zeros() }],
        contact: Contact { law: ContactLaw::AugmentedLagrangian { stiffness: 1.0, tol_penetration: 1e-8 } },
        obstacles: vec![table],
        planar: true,
        rods: vec![rod],
        ..Model::default()
    };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    reach(&mut solver, &[Ramp::Load { to: 1.0 }]);
    let middle = Observable::Position { node: NodeRef { rod: 0, node: 30 }, axis: 1 };
    let variance = |solver: &mut Solver, contacts: ContactResponse| {
        EquilibriumTangent::at(solver, contacts).unwrap().covariance(std::slice::from_ref(&middle), KT).unwrap()[(0, 0)]
    };
    let [locked, free] =
        [ContactResponse::Locked, ContactResponse::Free].map(|contacts| variance(&mut solver, contacts));
    // of a cantilever, and of a propped one, under a force in the middle
    verify("cantilever on a table", "free over kT L³/24B", free / (KT / 24.0), 1.0, 0.02);
    verify("cantilever on a table", "locked over kT 7L³/768B", locked / (KT * 7.0 / 768.0), 1.0, 0.02);
    let [mean, error] = chain_variance(KT, height, load);
    println!("chain: {mean:.4e} ± {error:.1e}, locked {locked:.4e}, free {free:.4e}");
    assert!(mean - 3.0 * error > locked && mean + 3.0 * error < free, "{locked} {mean} ± {error} {free}");
    assert!(error < 0.05 * mean);
}

/// Variance of the middle of a chain of 60 segments, and its error from ten parts.
fn chain_variance(kt: f64, height: f64, load: f64) -> [f64; 2] {
    const COUNT: usize = 60;
    let mut random = crate::random::Random::of(7, 0);
    let size = 1.0 / COUNT as f64;
    let mut points: Vec<[f64; 2]> = (0..=COUNT).map(|k| [k as f64 * size, height]).collect();
    let mut hinges = [0.0; COUNT];
    // the clamp is half a segment from the first hinge's neighbour
    let stiffness = |k: usize| if k == 0 { 2.0 / size } else { 1.0 / size };
    let mut parts = Vec::new();
    for part in 0..=10 {
        let (mut sum, mut squares, moves) = (0.0, 0.0, 200_000);
        for _ in 0..moves {
            let k = random.below(COUNT as u64) as usize;
            let angle = 0.25 * random.unit() * kt.sqrt() * 2.0;
            let (sin, cos) = angle.sin_cos();
            let pivot = points[k];
            let turned = |p: &[f64; 2]| {
                let [x, y] = [p[0] - pivot[0], p[1] - pivot[1]];
                [pivot[0] + cos * x - sin * y, pivot[1] + sin * x + cos * y]
            };
            let after = hinges[k] + angle;
            let bending = 0.5 * stiffness(k) * (after * after - hinges[k] * hinges[k]);
            let fall = turned(&points[COUNT])[1] - points[COUNT][1];
            let accepts = random.between(0.0, 1.0) < (-(bending + load * fall) / kt).exp();
            if accepts && points[k + 1..].iter().all(|p| turned(p)[1] >= 0.0) {
                points[k + 1..].iter_mut().for_each(|p| *p = turned(p));
                hinges[k] = after;
            }
            let y = points[COUNT / 2][1];
            sum += y;
            squares += y * y;
        }
        // the first part is forgotten
        if part > 0 {
            let mean = sum / moves as f64;
            parts.push(squares / moves as f64 - mean * mean);
        }
    }
    let mean = parts.iter().sum::<f64>() / parts.len() as f64;
    let spread = parts.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (parts.len() - 1) as f64;
    [mean, (spread / parts.len() as f64).sqrt()]
}
