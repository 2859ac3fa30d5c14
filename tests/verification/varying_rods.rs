//! Stiffness and natural strains that vary along the rod and couple its strains: a cantilever, and a ring of DNA with
//! twist–bend coupling.
//!
//! References solve the equations of the continuous rod, r′ = R Γ, R′ = R K×, M′ = −r′ × F, with (Γ, K) = ε0(s) +
//! C(s)⁻¹ (Rᵀ F, Rᵀ M), by the Runge–Kutta method of order four:
//!  * cantilever of length 1: all 21 entries of C and all six natural strains vary with s, the natural curvature turns
//!    in the section. Force and moment at the clamp are chosen, so that one integration gives the end and the moment
//!    that is to be applied there; nothing is searched for;
//!  * ring of 104 base pairs of the isotropic model "IdealDNA" (bending .0427, twist .0597 kT/deg², translations 20
//!    kT/Å², 34.2857° and 3.4 Å a step), Lk = 10, with a coupling of 25 nm kT between bending about d2 and twist put
//!    in. Shooting for force and moment at one point. The ring may slide along itself, which leaves the phase of its
//!    twist wave open: compared are energy and the amplitude of the wave, 2 |∮ K3 exp(2πi Lk s/L) ds|/L.

use crate::common;

use common::{any_equilibrium, cantilever, fitted_order, history, runge_kutta, sci, tip, verify, verify_point};
use std::f64::consts::TAU;
use supercoil::internals::quadrature::gauss;
use supercoil::math::{Quat, Vec3};
use supercoil::nalgebra::{SMatrix, SVector, Vector6};
use supercoil::observe::strains;
use supercoil::rod::{Along, Natural, NaturalStrains, Rod, RodMesh, Section, Shape, Stiffness};
use supercoil::scene::{Contact, Model, Ramp};
use supercoil::solve::{Options, Solver, Status};

/// Stiffness and natural strains along a rod.
#[derive(Clone, Copy)]
struct Law {
    stiffness: fn(f64) -> Stiffness,
    natural: fn(f64) -> NaturalStrains,
}

/// s, r, q, M, energy, and real and imaginary part of ∫ K3 exp(iωs) ds.
type State = [f64; 14];

fn rate(law: Law, force: Vec3, omega: f64) -> impl Fn(&State) -> State {
    move |y| {
        let s = y[0];
        let q = Quat::new_unchecked(nalgebra::Quaternion::new(y[4], y[5], y[6], y[7]));
        let moment = Vec3::new(y[8], y[9], y[10]);
        let (n, m) = (q.inverse() * force, q.inverse() * moment);
        let stress = Vector6::new(n.x, n.y, n.z, m.x, m.y, m.z);
        let stiffness = (law.stiffness)(s);
        let change = stiffness.cholesky().unwrap().solve(&stress);
        let strain = (law.natural)(s) + change;
        let r = q * Vec3::new(strain[0], strain[1], strain[2]);
        let turn = q.into_inner() * nalgebra::Quaternion::new(0.0, strain[3], strain[4], strain[5]) * 0.5;
        let moment = -r.cross(&force);
        let (sin, cos) = (omega * s).sin_cos();
        [
            1.0,
            r.x,
            r.y,
            r.z,
            turn.w,
            turn.i,
            turn.j,
            turn.k,
            moment.x,
            moment.y,
            moment.z,
            0.5 * change.dot(&stress),
            strain[5] * cos,
            strain[5] * sin,
        ]
    }
}

/// The state at the end of a rod that starts at the origin with the given frame.
fn end(law: Law, (length, steps): (f64, usize), start: Quat, [force, moment]: [Vec3; 2], omega: f64) -> State {
    let mut y = [0.0; 14];
    [y[4], y[5], y[6], y[7]] = [start.w, start.i, start.j, start.k];
    y[8..11].copy_from_slice(moment.as_slice());
    runge_kutta::along(rate(law, force, omega), y, length, steps)
}

fn coupled(s: f64) -> Stiffness {
    let diagonal = Vector6::new(300.0, 350.0, 400.0, 1.0 + 0.5 * s, 2.0, 1.3 - 0.4 * s);
    let entry = |i: usize, j: usize| {
        let (i, j) = (i.min(j), i.max(j));
        if i == j { 1.0 } else { 0.25 * ((1 + i + 2 * j) as f64 + 3.0 * s).sin() }
    };
    Stiffness::from_fn(|i, j| entry(i, j) * (diagonal[i] * diagonal[j]).sqrt())
}

fn helical(s: f64) -> NaturalStrains {
    let (sin, cos) = (8.0 * s).sin_cos();
    [0.02 * s, 0.01 * cos, 1.03 - 0.02 * sin, 1.5 * cos, 1.5 * sin, 2.0 + s * s].into()
}

const CANTILEVER: Law = Law { stiffness: coupled, natural: helical };

fn bent(elements: usize, order: usize, force: Vec3, moment: Vec3) -> Solver {
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let section = Section::of_diagonal(&coupled(0.5), 0.0);
    let natural = Natural::Varying(Along::function(helical));
    let rod = Rod::new("rod", &shape, RodMesh::open(elements, order), section, natural).unwrap();
    let rod = rod.with_stiffness(Along::function(coupled)).unwrap();
    let mut solver = Solver::new(cantilever(rod, force, moment), Options::default()).unwrap();
    // first to the natural shape, then up with the dead moment, which has no potential
    for k in 0..=4 {
        let report = solver.step_to(&[Ramp::Load { to: 0.25 * f64::from(k) }]).unwrap();
        assert_eq!(report.status, Status::Converged, "{k}: {}", history(&report));
        *solver.options_mut() = any_equilibrium();
    }
    solver
}

#[test]
fn cantilever_with_everything_varying() {
    let (force, clamp) = (Vec3::new(0.5, -0.7, 1.0), Vec3::new(0.6, 0.4, -0.5));
    let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let start = line.place(false, 1).unwrap().frames[0];
    let exact = end(CANTILEVER, (1.0, 4000), start, [force, clamp], 0.0);
    let moment = Vec3::new(exact[8], exact[9], exact[10]);
    let exact_tip = [exact[1], exact[2], exact[3]];
    verify_point("varying cantilever, end", &tip(&bent(24, 3, force, moment)), exact_tip, 5e-9);
    for order in 1..=3 {
        let meshes = [1, 2, 4].map(|n| [24, 6, 6][order - 1] * n);
        let errors = meshes.map(|n| (tip(&bent(n, order, force, moment)) - Vec3::from(exact_tip)).norm());
        println!("order {order}: errors {}", sci(&errors));
        let fitted = fitted_order(&meshes.map(|n| 1.0 / n as f64), &errors);
        verify("varying cantilever", &format!("order of the end, p = {order}"), fitted, 2.0 * order as f64, 0.3);
    }
}

const BASE_PAIRS: f64 = 104.0;
const LINK: f64 = 10.0;
const LENGTH: f64 = BASE_PAIRS * 0.34;

fn ideal_dna(_: f64) -> Stiffness {
    let (per_degree, h) = (360.0 / TAU, 0.34);
    let [bending, twisting] = [0.0427, 0.0597].map(|f| f * per_degree * per_degree * h);
    let mut matrix = Section::isotropic(bending, twisting, 680.0, 680.0, 0.0).stiffness();
    (matrix[(4, 5)], matrix[(5, 4)]) = (25.0, 25.0);
    matrix
}

fn double_helix(_: f64) -> NaturalStrains {
    [0.0, 0.0, 1.0, 0.0, 0.0, 34.2857 / 360.0 * TAU / 0.34].into()
}

const DNA: Law = Law { stiffness: ideal_dna, natural: double_helix };

/// Energy and amplitude of the twist wave of the continuous ring.
fn shot_ring() -> (f64, f64) {
    let omega = TAU * LINK / LENGTH;
    let shoot = |x: &Vector6<f64>| {
        let (force, moment) = (Vec3::new(x[0], x[1], x[2]), Vec3::new(x[3], x[4], x[5]));
        end(DNA, (LENGTH, 8000), Quat::identity(), [force, moment], omega)
    };
    // closed if the end is the start: position, and the vector part of the rotation
    let missed = |x: &Vector6<f64>| -> SVector<f64, 6> {
        let y = shoot(x);
        [y[1], y[2], y[3], y[5], y[6], y[7]].into()
    };
    // compliances averaged over the turns of the helix
    let compliance = ideal_dna(0.0).try_inverse().unwrap();
    let bending = 2.0 / (compliance[(3, 3)] + compliance[(4, 4)]);
    let twist = (omega - double_helix(0.0)[5]) / compliance[(5, 5)];
    let binormal = TAU / LENGTH * Vec3::x();
    let force = twist * binormal;
    let mut x = Vector6::new(force.x, 0.0, 0.0, bending * binormal.x, 0.0, twist);
    for _ in 0..6 {
        let gap = missed(&x);
        assert!(gap.norm() < 10.0, "{x}");
        let mut jacobian = SMatrix::<f64, 6, 6>::zeros();
        for k in 0..6 {
            let mut step = Vector6::zeros();
            step[k] = 1e-5;
            jacobian.set_column(k, &((missed(&(x + step)) - missed(&(x - step))) / 2e-5));
        }
        // sliding leaves one direction free
        let least = jacobian.svd(true, true).solve(&gap, 1e-6).unwrap();
        x -= least;
    }
    let gap = missed(&x);
    assert!(gap.norm() < 1e-9, "{gap}");
    let y = shoot(&x);
    // the sign of the quaternion tells even links from odd ones
    assert!(y[4] < 0.0, "{}", y[4]);
    (y[11], 2.0 * y[12].hypot(y[13]) / LENGTH)
}

#[test]
fn twist_wave_of_a_ring() {
    let (energy, amplitude) = shot_ring();
    let circle = Shape::Circle { length: LENGTH, center: Vec3::zeros(), normal: Vec3::z() };
    let section = Section::of_diagonal(&ideal_dna(0.0), 0.0);
    let natural = Natural::Varying(Along::constant(double_helix(0.0)));
    let rod = Rod::new("ring", &circle, RodMesh::closed(104, 3), section, natural).unwrap();
    let excess = LINK - rod.natural_link();
    let rod = rod.with_stiffness(Along::constant(ideal_dna(0.0))).unwrap().with_excess_link(excess).unwrap();
    let model = Model { rods: vec![rod], contact: Contact::NONE, ..Model::default() };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    let report = solver.find_equilibrium();
    println!("{}", history(&report));
    assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", history(&report));
    let (mut sum, mut found, points, h) = ([0.0; 2], 0.0, gauss(3), LENGTH / 104.0);
    let fields = strains(solver.engine(), 0);
    for (k, (strain, stress)) in fields.strains.iter().zip(&fields.stresses).enumerate() {
        let (s, weight) = ((k / 3) as f64 * h + points.points[k % 3] * h, points.weights[k % 3] * h);
        let (sin, cos) = (TAU * LINK * s / LENGTH).sin_cos();
        found += 0.5 * weight * (Vector6::from(*strain) - double_helix(s)).dot(&Vector6::from(*stress));
        sum[0] += weight * strain[5] * cos;
        sum[1] += weight * strain[5] * sin;
    }
    let wave = 2.0 * sum[0].hypot(sum[1]) / LENGTH;
    let case = "ring of 104 bp, Lk 10, coupling 25 nm kT";
    verify(case, "elastic energy, kT", found, energy, 1e-6 * energy);
    verify(case, "amplitude of the twist wave, rad/nm", wave, amplitude, 1e-6 * amplitude);
    assert!(amplitude > 0.01, "{amplitude}");
}
