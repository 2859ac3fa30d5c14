//! The contact stiffness that a model has if none is given, `ContactLaw::ByMesh`: nodes two layers (B/κ)^¼ apart,
//! between a least stiffness and 10⁴.
//!
//! What it is for is held by `ring_thickness`: rings from thin to thick show their points and lines of contact as hard
//! contact does, on coarse and fine meshes.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model};
use supercoil::solve::{Options, Solver};

/// A straight rod of cubic elements.
fn rod(name: &str, elements: usize, [length, bending, radius]: [f64; 3]) -> Rod {
    let per_area = bending / (length * length);
    let section = Section::isotropic(bending, 0.8 * bending, 1e6 * per_area, 1e6 * per_area, radius);
    let start = Vec3::z() * name.len() as f64 * length;
    let shape = Shape::Line { start, direction: Vec3::x(), length };
    Rod::new(name, &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap()
}

fn by_mesh(rods: &[Rod]) -> f64 {
    ContactLaw::stiffness_by_mesh(rods, 10.0)
}

#[test]
fn nodes_are_two_layers_apart() {
    for (elements, radius) in [(20, 0.02), (40, 0.012), (100, 0.006), (100, 0.012)] {
        let stiffness = by_mesh(&[rod("a", elements, [1.0, 3.0, radius])]);
        let layer = radius * stiffness.powf(-0.25);
        let apart = 1.0 / (3.0 * elements as f64) / layer;
        assert!((apart - 2.0).abs() < 1e-12, "{elements}, {radius}: {apart} layers, κ' {stiffness}");
    }
}

/// Of rods with more than 30 000 nodes a single layer, though the same mesh on a shorter rod has two.
#[test]
fn nodes_of_long_rods_are_one_layer_apart() {
    let of = |elements: usize| by_mesh(&[rod("a", elements, [elements as f64, 1.0, 0.6])]);
    let [short, long] = [9_999, 10_000].map(of);
    assert!((short / long - 16.0).abs() < 1e-9, "{short} {long}");
}

#[test]
fn between_a_least_and_a_largest() {
    assert_eq!(by_mesh(&[rod("a", 5, [1.0, 1.0, 0.01])]), 10.0);
    assert_eq!(ContactLaw::stiffness_by_mesh(&[rod("a", 5, [1.0, 1.0, 0.01])], 1e3), 1e3);
    assert_eq!(by_mesh(&[rod("a", 500, [1.0, 1.0, 0.01])]), 1e4);
    assert_eq!(ContactLaw::stiffness_by_mesh(&[rod("a", 500, [1.0, 1.0, 0.01])], 1e5), 1e5);
    assert_eq!(by_mesh(&[rod("a", 500, [1.0, 1.0, 0.0])]), 10.0);
}

/// In any unit, and for the rod of several that carries least; rods without a contact radius do not count.
#[test]
fn as_the_coarsest_rod_asks() {
    let fine = || rod("a", 60, [1.0, 1.0, 0.01]);
    let coarse = rod("bb", 40, [1.0, 1.0, 0.01]);
    let alone = by_mesh(std::slice::from_ref(&coarse));
    assert!(alone < 0.3 * by_mesh(&[fine()]));
    assert_eq!(by_mesh(&[fine(), coarse]), alone);
    assert_eq!(by_mesh(&[fine(), rod("ccc", 4, [1.0, 1.0, 0.0])]), by_mesh(&[fine()]));
    // sixteen times as stiff in bending: carries the same layer with nodes twice as far apart
    let stiff = rod("bb", 30, [1.0, 16.0, 0.01]);
    assert!((by_mesh(&[fine(), stiff]) / by_mesh(&[fine()]) - 1.0).abs() < 1e-12);
    for unit in [1e-80, 1e-9, 1e9, 1e80] {
        let scaled = by_mesh(&[rod("a", 60, [unit, 1e3 / unit, 0.01 * unit])]);
        assert!((scaled / by_mesh(&[fine()]) - 1.0).abs() < 1e-12, "{unit:e}: {scaled}");
    }
}

#[test]
fn a_solver_states_the_number_and_keeps_it_on_a_finer_mesh() {
    let model = Model { rods: vec![rod("a", 40, [1.0, 1.0, 0.01])], ..Model::default() };
    assert_eq!(model.contact, Contact::default());
    let law = model.contact.law.on_mesh(&model.rods);
    let ContactLaw::AugmentedLagrangian { stiffness, tol_penetration } = law else { panic!("{law:?}") };
    assert_eq!((stiffness, tol_penetration), (by_mesh(&model.rods), 1e-8));
    let solver = Solver::new(model, Options::default()).unwrap();
    assert_eq!(solver.engine().model().contact.law, law);
    assert_eq!(solver.refined(2).unwrap().engine().model().contact.law, law);
}
