//! Kernels by module: rod element (residual and tangent), contact terms of a supercoiled strand pair, one equilibrium
//! search. Each checks its answer before it is timed. The tangent of a cubic element in space is also measured against
//! its operations; the aim is 3 µs.
//!
//! `cargo bench --bench kernels`, of the element only with `-- element`
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Instant;

use supercoil::contact::Cubic;
use supercoil::contact::Law;
use supercoil::contact::Want;
use supercoil::internals::curve::{CurveInput, CurveSet};
use supercoil::internals::element::{self, ElementNodes, ElementProperties, RodPlane};
use supercoil::internals::potential::evaluate;
use supercoil::internals::quaternion::to_array;
use supercoil::internals::shape_functions::ShapeTable;
use supercoil::math::{Quat, Vec3};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, Ramp};
use supercoil::solve::{Options, Solver, Status};

/// Additions, multiplications and divisions for residual and tangent of a cubic element in space: 19 200 counted
/// instruction by instruction when whole matrices were multiplied, less 864 for blocks that are no longer formed.
const FLOPS: f64 = 18.3e3;

/// Least and median of 400 goes of 250 elements (other work on the machine hardly disturbs the least), and the rate of
/// operations that the least makes.
fn against_operations(mut tangent: impl FnMut() -> f64) {
    const ELEMENTS: u32 = 250;
    let mut micros: Vec<f64> = (0..400)
        .map(|_| {
            let start = Instant::now();
            (0..ELEMENTS).for_each(|_| {
                black_box(tangent());
            });
            start.elapsed().as_secs_f64() * 1e6 / f64::from(ELEMENTS)
        })
        .collect();
    micros.sort_by(f64::total_cmp);
    let (least, median) = (micros[0], micros[micros.len() / 2]);
    println!(
        "cubic element in space, tangent: {least:.2} µs least, {median:.2} µs median, {FLOPS:.0} operations, {:.1} \
         GF/s",
        1e-3 * FLOPS / least
    );
}

/// A straight element under pure stretch has the energy ½ EA ε² ℓ, in space and in the plane.
fn rod_element(c: &mut Criterion) {
    let along_x = Quat::rotation_between(&Vec3::z(), &Vec3::x()).map_or([1.0, 0.0, 0.0, 0.0], |q| to_array(&q));
    let plane = RodPlane::new(&along_x);
    for (order, plane) in (1..=3).flat_map(|order| [(order, None), (order, Some(&plane))]) {
        let table = ShapeTable::new(order);
        let mut nodes = ElementNodes::default();
        for a in 0..=order {
            nodes.r[a] = [1.01 * a as f64 / order as f64, 0.0, 0.0];
            nodes.q[a] = along_x;
        }
        let material = [1e3, 1e3, 1e4, 1.0, 1.0, 1.5];
        let reference = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]; 3];
        let body =
            ElementProperties { table: &table, length: 1.0, material: element::Material::Diagonal(&material), plane };
        let mut tangent = [[0.0; element::MAX_DOF]; element::MAX_DOF];
        let mut run = |wanted: bool| {
            let tangent = wanted.then_some(&mut tangent);
            element::evaluate(&body, black_box(&nodes), &reference, None, tangent).energy.stretching
        };
        assert!((run(true) - 0.5e4 * 1e-4).abs() < 1e-10);
        if order == 3 && plane.is_none() {
            against_operations(|| run(true));
        }
        let place = if plane.is_some() { "in a plane" } else { "in space" };
        c.bench_function(&format!("element {place}, order {order}, residual"), |b| b.iter(|| run(false)));
        c.bench_function(&format!("element {place}, order {order}, tangent"), |b| b.iter(|| run(true)));
    }
}

/// Two strands of a double helix that overlap a little: every facing pair is in contact and the forces on the strands
/// balance.
fn contact_terms(c: &mut Criterion) {
    let strand = |phase: f64| {
        let at = |k: usize| {
            let t = 0.2 * k as f64;
            let (s, c) = (t + phase).sin_cos();
            (Vec3::new(c, s, 1.2 * t), Vec3::new(-s, c, 1.2) * 0.2)
        };
        let segments: Vec<Cubic> = (0..500)
            .map(|k| {
                let ((p, dp), (q, dq)) = (at(k), at(k + 1));
                Cubic::from_hermite(p, dp, q, dq)
            })
            .collect();
        CurveInput { lengths: vec![0.312; segments.len()], segments, closed: false, radius: 1.02 }
    };
    let set = CurveSet::new(vec![strand(0.0), strand(std::f64::consts::PI)]).unwrap();
    let pairs: Vec<[u32; 2]> =
        (0..500u32).flat_map(|i| (i.saturating_sub(2)..(i + 3).min(500)).map(move |j| [i, 500 + j])).collect();
    let law = Law::Linear { stiffness: 100.0 };
    let run = |want| evaluate(&set, black_box(&pairs), law, &|_, _| [0.0; 2], want);
    let total: Vec3 = run(Want::Gradient).iter().flat_map(|t| t.gradient).sum();
    let pressed: f64 = run(Want::Gradient).iter().flat_map(|t| &t.zones).map(|z| z.force).sum();
    assert!(pressed > 1.0 && total.norm() < 1e-9 * pressed);
    c.bench_function("contact terms of 1000 segments, gradient", |b| b.iter(|| run(Want::Gradient)));
    c.bench_function("contact terms of 1000 segments, Hessian", |b| b.iter(|| run(Want::Hessian)));
}

/// A twisted flat ring of 96 cubic elements brought to rest after a tenth of a turn.
fn search(c: &mut Criterion) {
    let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, 0.005);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(96, 3), section, Natural::Straight).unwrap();
    let model = Model { rods: vec![rod], contact: Contact::NONE, ..Model::default() };
    let run = || {
        let mut solver = Solver::new(model.clone(), Options::default()).unwrap();
        solver.step_to(&[Ramp::ExcessLink { rod: 0, to: 0.1 }]).unwrap()
    };
    assert_eq!(run().status, Status::Converged);
    c.bench_function("set up and settle a ring of 96 elements", |b| b.iter(run));
}

criterion_group!(kernels, rod_element, contact_terms, search);
criterion_main!(kernels);
