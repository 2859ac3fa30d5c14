//! Orders of convergence in a spatial case, for elements of order 1, 2, 3 at slenderness 1e1 to 1e6.
//!
//! Set-up: a stress-free circular arc of 90° and length 1 in the x-y plane, clamped at the origin, under a dead tip
//! force (0.8, −1.1, 2.5) B/L²: bending about both axes and twist. Solid disc of slenderness L/ε with E = 2G: EA =
//! 4B/ε², GA = 2B/ε². Reference: the same rod on 96 cubic elements; its internal moment by equilibrium, m(s) = (r(L) −
//! r(s)) × F. Required: with p the order of the elements, the tip's position and rotation and the energy converge with
//! order 2p, the largest error of position over all nodes with 2, 4, 4, the internal moment at the integration points
//! with p + 1, the internal force there is exact but for rounding, and neither errors nor orders depend on the
//! slenderness (no locking), in any of six decades.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use common::{cantilever, elastic_energy, fitted_order, history, sci, slender_disc, strains_of, verify};
use std::f64::consts::FRAC_PI_2;
use supercoil::internals::quadrature::gauss;
use supercoil::internals::shape_functions::lagrange;
use supercoil::math::{Quat, Vec3};
use supercoil::rod::{Natural, Rod, RodMesh, Shape};
use supercoil::scene::Ramp;
use supercoil::solve::{Options, Solver, Status};

const FINE: usize = 96;

fn force() -> Vec3 {
    Vec3::new(0.8, -1.1, 2.5)
}

/// The curvature of the arc, exactly.
fn uniform() -> Natural {
    Natural::Uniform { kappa: [FRAC_PI_2, 0.0, 0.0] }
}

fn bent(order: usize, elements: usize, natural: Natural, slenderness: f64) -> Solver {
    bent_along(order, elements, natural, slenderness, &[1.0])
}

/// As [`bent`], over the load factors of `way`.
fn bent_along(order: usize, elements: usize, natural: Natural, slenderness: f64, way: &[f64]) -> Solver {
    push(arc(order, elements, natural, slenderness), way)
}

fn arc(order: usize, elements: usize, natural: Natural, slenderness: f64) -> Rod {
    let shape = Shape::Arc {
        start: Vec3::zeros(),
        tangent: Vec3::x(),
        towards: Vec3::y(),
        radius: 1.0 / FRAC_PI_2,
        angle: FRAC_PI_2,
    };
    Rod::new("arc", &shape, RodMesh::open(elements, order), slender_disc(slenderness), natural).unwrap()
}

fn push(rod: Rod, way: &[f64]) -> Solver {
    let mut solver = Solver::new(cantilever(rod, force(), Vec3::zeros()), Options::default()).unwrap();
    for &to in way {
        let report = solver.step_to(&[Ramp::Load { to }]).unwrap();
        assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", history(&report));
    }
    solver
}

/// Position and frame of a solution at a fraction of its length, inside its elements.
fn at(solver: &Solver, fraction: f64) -> (Vec3, Quat) {
    let rod = &solver.engine().model().rods[0];
    let x = fraction * rod.num_elements as f64;
    let element = (x as usize).min(rod.num_elements - 1);
    let n = lagrange(rod.order, x - element as f64).0;
    let node = |a: usize| element * rod.order + a;
    let position = (0..=rod.order).map(|a| solver.engine().positions(0)[node(a)] * n[a]).sum();
    let frames = solver.engine().frames(0);
    let sign = |a: usize| frames[node(0)].coords.dot(&frames[node(a)].coords).signum();
    let sum: nalgebra::Vector4<f64> = (0..=rod.order).map(|a| frames[node(a)].coords * (sign(a) * n[a])).sum();
    (position, Quat::new_normalize(nalgebra::Quaternion::from_vector(sum)))
}

/// Errors of: tip position, tip rotation, energy, position anywhere, moment anywhere.
fn errors(solver: &Solver, fine: &Solver) -> [f64; 5] {
    let rod = &solver.engine().model().rods[0];
    let (order, elements) = (rod.order, rod.num_elements);
    let (end, exact_end) = (at(solver, 1.0), at(fine, 1.0));
    let turn = (exact_end.1.inverse() * end.1).imag().norm() * 2.0;
    let energy = (elastic_energy(solver) - elastic_energy(fine)).abs();
    let positions = solver.engine().positions(0);
    let last = (positions.len() - 1) as f64;
    let offset = |(i, r): (usize, &Vec3)| (r - at(fine, i as f64 / last).0).norm();
    let anywhere = positions.iter().enumerate().map(offset).fold(0.0, f64::max);
    let points = gauss(order).points;
    let moment_error = |(i, strain): (usize, &[f64; 6])| {
        let fraction = ((i / order) as f64 + points[i % order]) / elements as f64;
        // isotropic, bending and twisting stiffness 1: the strains are the moments in the rod's own frame
        let material = Vec3::new(strain[3], strain[4], strain[5]);
        let (position, frame) = at(fine, fraction);
        (frame * material - (exact_end.0 - position).cross(&force())).norm()
    };
    let moment = strains_of(solver).iter().enumerate().map(moment_error).fold(0.0, f64::max);
    [(end.0 - exact_end.0).norm(), turn, energy, anywhere, moment]
}

/// Errors on three meshes, each twice as fine as the last, and the orders fitted to them.
fn study(order: usize, slenderness: f64) -> ([[f64; 5]; 3], [f64; 5]) {
    study_of(order, slenderness, |elements| bent(order, elements, uniform(), slenderness))
}

fn study_of(order: usize, slenderness: f64, bent_on: impl Fn(usize) -> Solver) -> ([[f64; 5]; 3], [f64; 5]) {
    let fine = bent(3, FINE, uniform(), slenderness);
    let coarse = [16, 4, 3][order - 1];
    let meshes = [coarse, 2 * coarse, 4 * coarse];
    let found = meshes.map(|n| errors(&bent_on(n), &fine));
    let sizes = meshes.map(|n| 1.0 / n as f64);
    let orders = std::array::from_fn(|k| fitted_order(&sizes, &found.map(|e| e[k])));
    for (n, e) in meshes.iter().zip(&found) {
        println!("order {order}, {n} elements, L/ε {slenderness:e}: {}", sci(e));
    }
    println!("orders {orders:.2?}");
    (found, orders)
}

#[test]
fn orders_do_not_depend_on_the_slenderness() {
    for order in 1..=3 {
        let p = order as f64;
        let mut reference = None;
        for slenderness in [1e2, 1e1, 1e3, 1e4, 1e5, 1e6] {
            let (found, orders) = study(order, slenderness);
            let case = format!("convergence, p = {order}, L/ε = {slenderness:e}");
            for (k, name) in ["tip position", "tip rotation", "energy"].into_iter().enumerate() {
                verify(&case, &format!("order in the {name}"), orders[k], 2.0 * p, 0.15);
            }
            verify(&case, "order in the position anywhere", orders[3], [2.0, 4.0, 4.0][order - 1], 0.2);
            verify(&case, "order in the moment anywhere", orders[4], p + 1.0, 0.2);
            let reference = reference.get_or_insert(found);
            let names = ["tip position", "tip rotation", "energy", "position anywhere", "moment anywhere"];
            for (k, name) in names.into_iter().enumerate().filter(|_| slenderness != 1e2) {
                let ratio = found[1][k] / reference[1][k];
                verify(&case, &format!("{name}, error on the middle mesh over that at L/ε = 1e2"), ratio, 1.0, 0.1);
            }
        }
    }
}

/// Floors of double precision. The load put on in one step, with a rest on the way, and from beyond: what differs in
/// the end is rounding, and what the search leaves when it stops (1e-12). With u = 2⁻⁵² and lengths, forces and moments
/// in L, B/L², B/L:
///
/// | what | floor | at L/ε = 1e6 |
/// |---|---|---|
/// | position and rotation of the tip, energy | 1e-12 + 1e-6 (L/ε)² u | 2e-10 |
/// | internal force at the integration points: EA times a rounding of the stretch, over the element's length | 8 EA u n | 7e-3 n |
///
/// n is the number of elements. The internal force has no error of discretisation: p equations an element hold its p
/// values. Its rounding balances from point to point, which is why the first row is so much smaller.
#[test]
fn floors_of_double_precision() {
    for (order, elements) in [(1, 96), (2, 48), (3, 12), (3, FINE)] {
        for slenderness in [1e1, 1e2, 1e3, 1e4, 1e5, 1e6] {
            let case = format!("floor, p = {order}, {elements} elements, L/ε = {slenderness:e}");
            let section = slender_disc(slenderness);
            let one = bent(order, elements, uniform(), slenderness);
            let (mut tip, mut turn, mut energy) = (0.0f64, 0.0f64, 0.0f64);
            for way in [[0.5, 1.0], [2.0, 1.0], [-0.3, 1.0]] {
                let other = bent_along(order, elements, uniform(), slenderness, &way);
                let (a, b) = (at(&one, 1.0), at(&other, 1.0));
                tip = tip.max((a.0 - b.0).norm());
                turn = turn.max((a.1.inverse() * b.1).imag().norm() * 2.0);
                energy = energy.max((elastic_energy(&one) - elastic_energy(&other)).abs());
            }
            let floor = 1e-12 + 1e-6 * slenderness * slenderness * f64::EPSILON;
            verify(&case, "tip position, difference between ways to the load", tip, 0.0, floor);
            verify(&case, "tip rotation, difference between ways to the load", turn, 0.0, floor);
            verify(&case, "energy, difference between ways to the load", energy, 0.0, floor);
            let points = gauss(order).points;
            let off = |(i, strain): (usize, &[f64; 6])| {
                let fraction = ((i / order) as f64 + points[i % order]) / elements as f64;
                let shear = section.shearing;
                let material = Vec3::new(shear[0] * strain[0], shear[1] * strain[1], section.stretching * strain[2]);
                (at(&one, fraction).1 * material - force()).norm()
            };
            let error = strains_of(&one).iter().enumerate().map(off).fold(0.0, f64::max);
            let floor = 1e-11 + 8.0 * section.stretching * f64::EPSILON * elements as f64;
            verify(&case, "error of the internal force anywhere", error, 0.0, floor);
        }
    }
}

/// On an arc, "as shaped" is the curvature itself, and has its orders.
#[test]
fn an_arc_stress_free_as_shaped() {
    for order in 1..=3 {
        let as_shaped = bent(order, 4, Natural::AsShaped, 1e2);
        assert_eq!(at(&as_shaped, 1.0), at(&bent(order, 4, uniform(), 1e2), 1.0));
    }
}

/// Natural strains measured on interpolated nodes are themselves in error by order p + 1, which then bounds the order
/// of everything: cubic elements lose two orders against natural strains given exactly.
#[test]
fn nodes_stress_free_as_they_are() {
    for order in 1..=3 {
        let (_, orders) = study_of(order, 1e2, |elements| {
            let rod = arc(order, elements, uniform(), 1e2);
            push(Rod { natural: Natural::AsShaped, ..rod }, &[1.0])
        });
        let expected = [2.0, 4.0, 4.0][order - 1];
        verify(
            &format!("convergence, p = {order}, nodes as they are"),
            "order in the tip position",
            orders[0],
            expected,
            0.3,
        );
    }
}
