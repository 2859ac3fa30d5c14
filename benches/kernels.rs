//! Kernels by module: rod element (residual and tangent), contact terms of a supercoiled strand pair, one equilibrium search.
//! Each checks its answer before it is timed. The element is also measured against its operations: microseconds (least and median of 400 goes of 250
//! elements: other work on the machine disturbs the least hardly), operations (see [`flops`]) and the rate that they make; the aim is 3 µs for residual and
//! tangent of a cubic element in space.
//!
//! `cargo bench --bench kernels`, of the element only with `-- element`
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Instant;

use supercoil::contact::curve::{Cubic, CurveInput, CurveSet};
use supercoil::contact::detect::{Want, evaluate};
use supercoil::contact::law::Law;
use supercoil::math::quaternion::to_array;
use supercoil::math::shape_functions::Table;
use supercoil::math::{Quat, Vec3};
use supercoil::rod::element::{self, Body, ElementNodes, ElementOutput, Plane};
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, Model, Ramp};
use supercoil::solve::{Options, Solver, Status};

/// A straight element under pure stretch has the energy ½ EA ε² ℓ, in space and in the plane.
fn rod_element(c: &mut Criterion) {
    let along_x = Quat::rotation_between(&Vec3::z(), &Vec3::x()).map_or([1.0, 0.0, 0.0, 0.0], |q| to_array(&q));
    let plane = Plane::new(&along_x);
    for (order, plane) in (1..=3).flat_map(|order| [(order, None), (order, Some(&plane))]) {
        let table = Table::new(order);
        let mut nodes = ElementNodes::default();
        for a in 0..=order {
            nodes.r[a] = [1.01 * a as f64 / order as f64, 0.0, 0.0];
            nodes.q[a] = along_x;
        }
        let material = [1e3, 1e3, 1e4, 1.0, 1.0, 1.5];
        let reference = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]; 3];
        let body = Body { table: &table, length: 1.0, material: &material, plane };
        let (mut out, mut tangent) = (ElementOutput::default(), [[0.0; element::MAX_DOF]; element::MAX_DOF]);
        let mut run = |wanted: bool| {
            let tangent = wanted.then_some(&mut tangent);
            element::evaluate(&body, black_box(&nodes), &reference, None, tangent, &mut out);
            out.energy[0]
        };
        assert!((run(true) - 0.5e4 * 1e-4).abs() < 1e-10);
        let place = if plane.is_some() { "in a plane" } else { "in space" };
        for (wanted, what) in [(false, "residual"), (true, "tangent")] {
            report(&format!("{place}, order {order}, {what}"), flops(plane.is_none(), order, wanted), || run(wanted));
            c.bench_function(&format!("element {place}, order {order}, {what}"), |b| b.iter(|| run(wanted)));
        }
    }
}

fn report(name: &str, flops: usize, mut run: impl FnMut() -> f64) {
    const ELEMENTS: u32 = 250;
    let mut micros: Vec<f64> = (0..400)
        .map(|_| {
            let start = Instant::now();
            for _ in 0..ELEMENTS {
                black_box(run());
            }
            start.elapsed().as_secs_f64() * 1e6 / f64::from(ELEMENTS)
        })
        .collect();
    micros.sort_by(f64::total_cmp);
    let (least, median) = (micros[0], micros[micros.len() / 2]);
    let rate = 1e-3 * flops as f64 / least;
    println!("element {name:<30} {least:>7.3} µs least {median:>7.3} µs median {flops:>6} flops {rate:>5.1} GF/s");
}

/// Additions, subtractions, multiplications and divisions of the element kernel as it is written, by hand; signs and choices not counted. (What a compiler makes
/// of it, counted instruction by instruction in a cubic element in space, is 3 % less: it leaves out sums that start from zero.)
fn flops(in_space: bool, order: usize, tangent: bool) -> usize {
    // components of r' and z, rotations of a node; forms' slopes and curvatures
    let (r, z, slopes, curvature) = if in_space { (3, 4, 87, 55) } else { (2, 2, 17, 17) };
    let (t, nodes) = (z - 1, order + 1);
    let strains = r + t;
    let dot = |n: usize| 2 * n - 1;
    let gradient = 2 * (r * r + r * z + 2 * t * z);
    let point = 2 * nodes * (r + 2 * z) + dot(z) + 4;
    let strain = 1 + slopes + r * dot(r) + t * dot(z) + strains + r * r + r * (1 + 3 * z) + t * z + t * (1 + 3 * z);
    let stress = 1 + 6 * strains + gradient + nodes * (2 * r + 4 * z);
    let mut sum = 1 + order * (point + strain + stress) + nodes * (z + t * dot(z));
    if tangent {
        let geometric = curvature + 2 * strains + 2 + 2 * z + 6 * z * z + 2 * r * z;
        let material = r * (r * (1 + 2 * r + 2 * z) + z * (1 + 2 * z)) + t * z * (2 + 6 * z);
        let at_point = gradient + nodes * 4 * z + strains + geometric + material;
        let sums = order * (4 + 2 * r * r + 4 * r * z + 8 * z * z);
        let turns = 2 * r * t * dot(z) + 2 * t * z * z + t * t * dot(z);
        sum += order * at_point + nodes * (nodes + 1) / 2 * (sums + turns) + nodes * (2 * z + t);
    }
    sum
}

/// Two strands of a double helix that overlap a little: every facing pair is in contact and the forces on the strands balance.
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
    let pressed: f64 = run(Want::Gradient).iter().flat_map(|t| &t.zones).map(|z| z.half_force).sum();
    assert!(pressed > 1.0 && total.norm() < 1e-9 * pressed);
    c.bench_function("contact terms of 1000 segments, gradient", |b| b.iter(|| run(Want::Gradient)));
    c.bench_function("contact terms of 1000 segments, Hessian", |b| b.iter(|| run(Want::Hessian)));
}

/// A twisted flat ring of 96 cubic elements brought to rest after a tenth of a turn.
fn search(c: &mut Criterion) {
    let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, 0.005);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, true, section, 96, 3, Natural::Straight).unwrap();
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
