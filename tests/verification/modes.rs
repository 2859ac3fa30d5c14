//! Softest modes against closed forms.
//!
//! Columns: length 1, B = 1 about both axes, C = 1.3, stretch and shear stiffness 1e8 B/L², a dead compression P;
//! pinned (turning freely across the axis) or clamped, the far end free to move along the axis. λ = (nπ)⁴ − P (nπ)²
//! for n half waves of a pinned one (Euler), λ = β⁴ with cos β cosh β = 1 of a clamped one without load; each twice.
//! 32 cubic elements. A rope that hangs from a pin in the plane under its weight w, B = 1e-7 wL³: λ = w j²/4L for the
//! zeros j of the Bessel function J₀ (D. Bernoulli). A ring of C/B = 1.5 with the excess link ΔLk: the product of the
//! four eigenvalues of n waves, over that of the ring without link, is (1 − x²/(n² − 1))², x = C ΔLk/B, whatever the
//! masses; the softest is zero at Michell's √3.

use crate::common;

use std::f64::consts::PI;

use common::{any_equilibrium, end_of, verify};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Joint, LineLoad, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{Solver, Status};
use supercoil::tangent::{ContactResponse, EquilibriumTangent};

const RIGID: f64 = 1e8;

fn line(bending: f64, stiff: f64, elements: usize) -> Rod {
    let section = Section::isotropic(bending, 1.3 * bending, stiff, stiff, 0.0);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    Rod::new("rod", &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap()
}

/// At rest under the loads of a model.
fn at_rest(model: Model) -> Solver {
    let mut options = any_equilibrium();
    options.newton.tol_increment = 1e-12;
    let mut solver = Solver::new(model, options).unwrap();
    let report = solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap();
    assert_eq!(report.status, Status::Converged);
    solver
}

fn column(compression: f64, rotation: [bool; 3]) -> Solver {
    let rod = line(1.0, RIGID, 32);
    let end = end_of(&rod);
    let supports = vec![
        Support { node: NodeRef { rod: 0, node: 0 }, position: [true; 3], rotation },
        Support { node: end, position: [false, true, true], rotation },
    ];
    let loads = vec![NodeLoad { node: end, force: Vec3::x() * -compression, moment: Vec3::zeros() }];
    at_rest(Model { rods: vec![rod], supports, loads, contact: Contact::NONE, ..Model::default() })
}

fn eigenvalues(solver: &mut Solver, count: usize) -> Vec<f64> {
    EquilibriumTangent::at(solver, ContactResponse::ByLaw).unwrap().modes(count).unwrap().eigenvalues().collect()
}

#[test]
fn pinned_column() {
    for compression in [0.0, 5.0, 12.0] {
        let mut solver = column(compression, [true, false, false]);
        let found = eigenvalues(&mut solver, 6);
        for (k, found) in found.iter().enumerate() {
            let q = (k / 2 + 1) as f64 * std::f64::consts::PI;
            let exact = q.powi(4) - compression * q * q;
            verify(&format!("pinned column, P = {compression}"), &format!("mode {k}"), *found, exact, 2e-5 * q.powi(4));
        }
        let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap();
        assert_eq!(tangent.num_unstable(), if compression > 10.0 { 2 } else { 0 });
        let modes = tangent.modes(1).unwrap();
        assert!(modes.modes.iter().all(|mode| mode.participation.bend > 0.9999));
    }
}

#[test]
fn clamped_column() {
    let found = eigenvalues(&mut column(0.0, [true; 3]), 4);
    for (k, beta) in [4.730_040_744_863_f64, 7.853_204_624_096].into_iter().enumerate() {
        for found in &found[2 * k..2 * k + 2] {
            verify("clamped column", &format!("mode {}", k + 1), *found, beta.powi(4), 2e-5 * beta.powi(4));
        }
    }
}

#[test]
fn hanging_rope() {
    let bending = 1e-7;
    // so stiff that its stretch is a millionth, and so soft that this is known to some digits
    let mut rod = line(bending, 1e6, 40);
    let turn = supercoil::math::Quat::from_scaled_axis(Vec3::z() * -std::f64::consts::FRAC_PI_2);
    rod.positions.iter_mut().for_each(|r| *r = turn * *r);
    rod.frames.iter_mut().for_each(|q| *q = turn * *q);
    let supports =
        vec![Support { node: NodeRef { rod: 0, node: 0 }, position: [true; 3], rotation: [true, true, false] }];
    let line_loads = vec![LineLoad { rod: 0, force: -Vec3::y(), moment: Vec3::zeros() }];
    let model =
        Model { rods: vec![rod], supports, line_loads, planar: true, contact: Contact::NONE, ..Model::default() };
    let mut solver = at_rest(model);
    let found = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap().vibrations(3, &[2.0]).unwrap();
    for (mode, j) in found.modes.iter().zip([2.404_825_557_7, 5.520_078_110_3, 8.653_727_912_9]) {
        let exact = j * j / 4.0 / 2.0;
        verify("hanging rope of density 2", "ω²", mode.eigenvalue, exact, 2e-4 * exact);
    }
}

fn ring(excess_link: f64) -> Solver {
    let section = Section::isotropic(1.0, 1.5, RIGID, RIGID, 0.0);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(24, 3), section, Natural::Straight).unwrap();
    let model = Model { rods: vec![rod], contact: Contact::NONE, ..Model::default() };
    let mut solver = Solver::new(model, any_equilibrium()).unwrap();
    let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to: excess_link }]).unwrap();
    assert_eq!(report.status, Status::Converged);
    solver
}

#[test]
fn twisted_ring() {
    let product = |values: &[f64]| values.iter().product::<f64>();
    let flat = eigenvalues(&mut ring(0.0), 8);
    for x in [0.25, 0.5, 1.0, 1.5_f64] {
        let found = eigenvalues(&mut ring(x / 1.5), 8);
        for (n, modes) in [(2, 0..4), (3, 4..8_usize)] {
            let ratio = product(&found[modes.clone()]) / product(&flat[modes]);
            let exact = (1.0 - x * x / f64::from(n * n - 1)).powi(2);
            verify(&format!("twisted ring, x = {x}"), &format!("{n} waves"), ratio, exact, 1e-4);
        }
    }
    let softest = |x: f64| eigenvalues(&mut ring(x / 1.5), 1)[0];
    let [below, above] = [1.73, 1.734].map(softest);
    let zero = 1.73 + 0.004 * below / (below - above);
    verify("twisted ring", "x of the softest mode's zero", zero, 3.0_f64.sqrt(), 1e-4);
}

/// Symptom: of the two swings of a chain of pinned rods, and of a single one along y, one had a frequency 4 % too high.
/// Mechanism: the spin of a line moves no mass but by rounding; scaled to a unit of mass it was taken for a motion, and
/// what had a part along it was taken out of the modes.
///
/// Two rigid rods of length l on a chain: ω² = 3 (1 ± 2/√7) g/l, in each of two planes.
#[test]
fn a_chain_swings_the_same_way_in_all_planes() {
    for down in [-Vec3::z(), Vec3::y(), Vec3::x(), Vec3::new(0.48, -0.6, 0.64)] {
        let section = Section::isotropic(1e6, 1e6, RIGID, RIGID, 0.0);
        let rod = |name: &str, start: Vec3| {
            let shape = Shape::Line { start, direction: down, length: 1.0 };
            Rod::new(name, &shape, RodMesh::open(4, 3), section, Natural::Straight).unwrap()
        };
        let [top, foot, next] = [(0, 0), (0, 12), (1, 0)].map(|(rod, node)| NodeRef { rod, node });
        let model = Model {
            rods: vec![rod("upper", Vec3::zeros()), rod("lower", down)],
            supports: vec![Support { node: top, position: [true; 3], rotation: [false; 3] }],
            joints: vec![Joint::pin(foot, next)],
            line_loads: vec![LineLoad::of_force(0, down), LineLoad::of_force(1, down)],
            contact: Contact::NONE,
            ..Model::default()
        };
        let mut solver = at_rest(model);
        let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap();
        let found = tangent.vibrations(4, &[1.0; 2]).unwrap();
        assert_eq!(found.num_zero_energy, 2);
        for (k, mode) in found.modes.iter().enumerate() {
            let sign = if k < 2 { -1.0 } else { 1.0 };
            let exact = 3.0 * (1.0 + sign * 2.0 / 7.0_f64.sqrt());
            verify("chain of two pinned rods", &format!("ω² of swing {}", k + 1), mode.eigenvalue, exact, 1e-6 * exact);
        }
    }
}

/// A ring that is clamped at a node is an arc of a whole turn between two clamps. Symptom: its second mode was missing:
/// sliding along itself less a turn about the axis was taken for a motion that costs nothing, and is none of a circle.
/// Isotropic or not, curved by nature or not.
#[test]
fn a_clamped_ring_is_an_arc_between_clamps() {
    for natural in [Natural::Straight, Natural::AsShaped] {
        for bending in [[1.3, 2.1], [1.3, 1.3]] {
            let section = Section { bending, ..Section::isotropic(1.0, 0.8, 50.0, 1e4, 0.0) };
            let radius = 0.5 / PI;
            let circle = Shape::Circle { length: 1.0, center: Vec3::y() * radius, normal: Vec3::z() };
            let start = match Rod::new("ring", &circle, RodMesh::closed(24, 3), section, natural.clone()) {
                Ok(rod) => (rod.positions[0], rod.frames[0] * Vec3::z()),
                Err(error) => panic!("{error}"),
            };
            let towards = (Vec3::y() * radius - start.0).normalize();
            let arc = Shape::Arc { start: start.0, tangent: start.1, towards, radius, angle: 2.0 * PI };
            let found = [(circle, RodMesh::closed(24, 3)), (arc, RodMesh::open(24, 3))].map(|(shape, mesh)| {
                let rod = Rod::new("rod", &shape, mesh, section, natural.clone()).unwrap();
                let nodes = if rod.closed { vec![0] } else { vec![0, rod.num_nodes() - 1] };
                let supports = nodes.into_iter().map(|node| Support::clamp(NodeRef { rod: 0, node })).collect();
                let model = Model { rods: vec![rod], supports, contact: Contact::NONE, ..Model::default() };
                let mut solver = Solver::new(model, any_equilibrium()).unwrap();
                assert_eq!(solver.step_to(&[]).unwrap().status, Status::Converged);
                eigenvalues(&mut solver, 5)
            });
            let [ring, arc] = &found;
            let differs = ring.iter().zip(arc).any(|(a, b)| (a / b - 1.0).abs() > 1e-6);
            assert!(ring.len() == 5 && arc.len() == 5 && !differs, "{natural:?} {bending:?}: {ring:?} {arc:?}");
        }
    }
}
