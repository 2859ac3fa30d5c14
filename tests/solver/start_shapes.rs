//! Closed rods that start at a given link: the link is met exactly, twist is even, nothing overlaps.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::f64::consts::TAU;

use supercoil::contact::Clearance;
use supercoil::contact::Cubic;
use supercoil::internals::clearance::smallest_clearance;
use supercoil::internals::curve::{CurveInput, CurveSet};
use supercoil::internals::exclusion::Exclusion;
use supercoil::math::Vec3;
use supercoil::math::link::{link_numbers, linking_number, writhe};
use supercoil::rod::superhelix_angle;
use supercoil::rod::{Axis, Natural, Placement, Plectoneme, Rod, RodMesh, Section, Shape, TorusKnot};
use supercoil::scene::Model;
use supercoil::solve::Engine;

fn rod(shape: &Shape, radius: f64, elements: usize) -> Rod {
    let section = Section::isotropic(1.0, 1.5, 1e4, 1e4, radius);
    Rod::new("rod", shape, RodMesh::closed(elements, 3), section, Natural::Straight).unwrap()
}

fn engine(rod: Rod) -> Engine {
    Engine::new(Model { rods: vec![rod], ..Model::default() }, None).unwrap()
}

/// A closed space curve without symmetry, through points.
fn tangle() -> Shape {
    let point = |t: f64| {
        Vec3::new(t.cos() + 0.7 * (2.0 * t).cos(), 1.1 * t.sin() - 0.7 * (2.0 * t).sin(), 0.8 * (3.0 * t + 0.3).sin())
    };
    Shape::Points((0..50).map(|i| point(TAU * f64::from(i) / 50.0)).collect())
}

/// Shapes with a radius that leaves them clear of themselves, and elements enough for it.
fn shapes() -> Vec<(&'static str, Shape, f64, usize)> {
    let circle = Shape::Circle { length: 10.0, center: Vec3::zeros(), normal: Vec3::new(1.0, 2.0, 3.0) };
    let minicircle = Plectoneme::of_link(114.24, 5.0, 205.7, 308.6, -3.0).unwrap();
    let long = Plectoneme::of_turns(900.0, 5.0, -15.3).unwrap();
    let coil = Shape::Helix { center: Vec3::zeros(), axis: Vec3::z(), radius: 60.0, pitch: 25.0, turns: 2.0 };
    let coiled = Plectoneme::of_angle(900.0, 5.0, 0.4).unwrap().about(Axis::Along(Box::new(coil)));
    vec![
        ("circle", circle, 0.3, 20),
        ("tangle", tangle(), 0.05, 60),
        ("trefoil", TorusKnot::new(30.0, [2, 3]).into(), 0.4, 60),
        ("left trefoil", TorusKnot::new(30.0, [2, -3]).into(), 0.4, 60),
        ("cinquefoil", TorusKnot::new(30.0, [2, 5]).into(), 0.3, 80),
        ("(3, 4) torus knot", TorusKnot::new(30.0, [3, 4]).into(), 0.2, 90),
        ("minicircle", Shape::Plectoneme(minicircle), 2.5, 48),
        ("long plectoneme", Shape::Plectoneme(long), 2.5, 240),
        ("coiled plectoneme", Shape::Plectoneme(coiled), 2.5, 240),
    ]
}

/// The link is measured as by an observer, on a fine polygon of the contact centreline with the elements' own frames;
/// the twist is the difference to the writhe and lies evenly along the rod.
#[test]
fn link_is_what_was_asked_for() {
    for (name, shape, radius, elements) in shapes() {
        let plain = rod(&shape, radius, elements);
        let own = plain.start_excess_link;
        for turns in [0.0, own, -3.0, 2.5, own + 1.0 / 3.0, own - 7.123456789] {
            let engine = engine(plain.clone().with_excess_link(turns).unwrap());
            let (points, d1) = engine.centerline(0, 4);
            let prescribed = engine.state().seams()[0] / TAU;
            let found = link_numbers(&points, &d1, prescribed);
            assert!((found.link - turns).abs() < 1e-9, "{name}: {found:?}, asked for {turns}");
            assert!((prescribed - turns).abs() < 1e-12, "{name}");
            let (twist, _) = engine.twist(0);
            assert!(
                (twist - (turns - found.writhe)).abs() < 1e-3 * (1.0 + found.writhe.abs()),
                "{name}: {twist} {found:?} {turns}"
            );
            let k3 = engine.nodal_fields(0).twist_rate;
            let even = TAU * twist / plain.length;
            let uneven = k3.iter().map(|k| (k - even).abs()).fold(0.0, f64::max) * plain.length / TAU;
            // strains at nodes are extrapolated on elements that also bend and wind
            assert!(
                uneven < 0.02 * (1.0 + twist.abs() + 0.2 * found.writhe.abs()),
                "{name}: twist {twist} uneven by {uneven} turns"
            );
        }
    }
}

/// Without a link asked for, a shape's link is its writhe.
#[test]
fn untwisted_rods_have_the_link_of_their_writhe() {
    for (name, shape, radius, elements) in shapes() {
        let found = rod(&shape, radius, elements).start_excess_link;
        let fine = shape.place(true, 12_000).unwrap();
        let expected = writhe(&fine.positions, true);
        assert!((found - expected).abs() < 2e-3, "{name}: {found} {expected}");
    }
    let reference = 3.51823923104; // of the (2, 3) torus knot
    for (windings, sign) in [([2, 3], 1.0), ([2, -3], -1.0)] {
        let found = rod(&TorusKnot::new(30.0, windings).into(), 0.4, 200).start_excess_link;
        assert!((found - sign * reference).abs() < 1e-7, "{found}");
    }
}

#[test]
fn nodes_lie_at_equal_arc_lengths_and_frames_do_not_twist() {
    for (name, shape, _, _) in shapes() {
        let [coarse, fine] = [150, 4800].map(|num| shape.place(true, num).unwrap());
        let worst = (0..150)
            .map(|i| {
                assert!(coarse.frames[i].angle_to(&fine.frames[32 * i]) < 1e-6, "{name} {i}");
                let arc: f64 =
                    (32 * i..32 * (i + 1)).map(|k| (fine.positions[(k + 1) % 4800] - fine.positions[k]).norm()).sum();
                assert!((coarse.positions[i] - fine.positions[32 * i]).norm() < 1e-10 * fine.length);
                (arc * 150.0 / fine.length - 1.0).abs()
            })
            .fold(0.0, f64::max);
        assert!(worst < 2e-3, "{name}: {worst}");
        let h = fine.length / 4800.0;
        for i in 1..4799 {
            let derivative = (fine.positions[i + 1] - fine.positions[i - 1]) / (2.0 * h);
            assert!((derivative - fine.frames[i] * Vec3::z()).norm() < 1e-2, "{name} {i}");
        }
    }
}

fn clearance_of(shapes: &[Shape], num: usize, radius: f64, max_gap: f64) -> Option<Clearance> {
    let curve = |shape: &Shape| {
        let nodes = shape.place(true, num).unwrap();
        let (x, h) = (&nodes.positions, nodes.length / num as f64);
        let slope = |i: usize| nodes.frames[i % num] * Vec3::z() * h;
        let segments = (0..num).map(|i| Cubic::from_hermite(x[i], slope(i), x[(i + 1) % num], slope(i + 1)));
        CurveInput { segments: segments.collect(), lengths: vec![h; num], closed: true, radius }
    };
    let set = CurveSet::new(shapes.iter().map(curve).collect()).unwrap();
    let mut exclusion = Exclusion::new();
    exclusion.update(&set).unwrap();
    smallest_clearance(&set, &exclusion, max_gap, 1e-9 * radius)
}

/// Strands of a plectoneme just touch, nowhere closer: with a certified bound, over angles and loop sizes.
#[test]
fn plectonemes_do_not_penetrate() {
    for degrees in [2.0_f64, 15.0, 45.0] {
        for loop_size in [4.0, 9.0] {
            let p = Plectoneme { loop_size, ..Plectoneme::of_angle(160.0, 2.0, degrees.to_radians()).unwrap() };
            let overlap = |num: usize| {
                let found = clearance_of(&[Shape::Plectoneme(p.clone())], num, 1.0, 0.5).unwrap();
                assert!(found.upper - found.lower < 1e-8 && found.upper < 1e-8, "{found:?}");
                -found.lower
            };
            // the cubics between nodes are off by the cube of their spacing where helix and loop meet: third
            // derivatives jump there, by 3 at most with these loops
            for num in [200_u32, 800] {
                let bound = 0.05 * (160.0 / f64::from(num)).powi(3) + 1e-8;
                let found = overlap(num as usize);
                assert!(found < bound, "{degrees}° loops {loop_size}, {num} nodes: {found:e}");
            }
        }
    }
    for (name, shape, radius, _) in shapes() {
        let found = clearance_of(&[shape], 1200, radius, 8.0 * radius);
        assert!(found.is_none_or(|gap| gap.lower > -1e-3 * radius), "{name}: {found:?}");
    }
}

#[test]
fn torus_links_are_linked_and_clear() {
    for ([p, q], number) in [([2, 2], 1.0), ([2, -2], -1.0), ([2, 4], 2.0), ([3, 3], 1.0), ([4, 6], 6.0)] {
        let knots = TorusKnot::link(20.0, [p, q]).unwrap();
        let shapes: Vec<Shape> = knots.into_iter().map(Shape::from).collect();
        let points: Vec<Vec<Vec3>> = shapes.iter().map(|s| s.place(true, 300).unwrap().positions).collect();
        for i in 0..points.len() {
            for j in 0..i {
                let found = linking_number(&points[i], &points[j]);
                assert!((found - number).abs() < 1e-9, "({p}, {q}): {found}");
            }
        }
        assert!(clearance_of(&shapes, 300, 0.1, 10.0).unwrap().lower > 0.3, "({p}, {q})");
    }
}

/// The other hand is the mirror image, with the opposite link.
#[test]
fn hands_are_symmetric() {
    let [left, right] = [3.0, -3.0].map(|link| {
        let shape = Shape::Plectoneme(Plectoneme::of_link(114.24, 5.0, 205.7, 308.6, link).unwrap());
        rod(&shape, 2.5, 48).with_excess_link(link).unwrap()
    });
    let energies = [&left, &right].map(|rod| {
        let engine = engine(rod.clone());
        let (twist, _) = engine.twist(0);
        let bent: f64 = engine.nodal_fields(0).curvature.iter().map(|k| k * k).sum();
        (twist, bent)
    });
    assert!(
        (energies[0].0 + energies[1].0).abs() < 1e-6 && (energies[0].1 / energies[1].1 - 1.0).abs() < 1e-6,
        "{energies:?}"
    );
}

#[test]
fn what_cannot_be_is_refused() {
    let text = |rod: Result<Rod, supercoil::InputError>| rod.unwrap_err().to_string();
    let circle = Shape::Circle { length: 10.0, center: Vec3::zeros(), normal: Vec3::z() };
    let ring = rod(&circle, 0.1, 10);
    assert!(text(ring.clone().with_excess_link(f64::NAN)).starts_with("rods.rod.excess_link = NaN"));
    assert!(text(ring.clone().with_excess_link(13.0)).contains("use more elements"));
    assert!(ring.with_excess_link(11.0).is_ok());
    let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.0);
    let beam = Rod::new("beam", &line, RodMesh::open(4, 2), section, Natural::Straight).unwrap();
    assert!(text(beam.with_excess_link(1.0)).contains("beam.excess_link: the rod is open"));
    let knot = |windings: [i32; 2]| Shape::from(TorusKnot::new(1.0, windings)).place(true, 30).unwrap_err().to_string();
    assert!(knot([2, 4]).contains("(2, 4) is a link of 2 curves"));
    assert!(knot([0, 3]).starts_with("shape.windings[0] = 0") && knot([2, 0]).starts_with("shape.windings[1] = 0"));
    let wide = TorusKnot { aspect: 1.0, ..TorusKnot::new(1.0, [2, 3]) };
    assert!(Shape::from(wide).place(true, 30).unwrap_err().to_string().starts_with("shape.aspect = 1"));
    assert!(
        Shape::from(TorusKnot::new(1.0, [2, 3])).place(false, 30).unwrap_err().to_string().contains("closed = true")
    );
    assert!(TorusKnot::link(1.0, [0, 2]).is_err());
}

/// A supercoiled genome of a hundred thousand nodes: nodes, frames, link, twist spread; as of a minicircle.
#[test]
fn long_rods() {
    long_rod(1.65e5, 100_000);
}

/// E. coli's chromosome: run with `--ignored --nocapture` to see times.
#[test]
#[ignore = "slow: a million nodes"]
fn million_nodes() {
    long_rod(1.5776e6, 1_000_000);
}

#[allow(clippy::print_stdout)]
fn long_rod(length: f64, nodes: usize) {
    let turns = -(0.0168 * length).round();
    let started = std::time::Instant::now();
    let plectoneme = Plectoneme::of_link(length, 5.0, 205.7, 308.6, turns).unwrap();
    println!("{plectoneme:?} {} turns {:?}", plectoneme.turns(), started.elapsed());
    let expected = superhelix_angle(5.0, 308.6 / 205.7, turns / length).unwrap();
    assert!((plectoneme.angle - expected).abs() < 1e-3, "{} {expected}", plectoneme.angle);
    let section = Section::isotropic(205.7, 308.6, 1100.0, 1100.0, 2.5);
    let placement = Shape::Plectoneme(plectoneme.clone()).place(true, nodes / 3 * 3).unwrap();
    println!("placed {:?}", started.elapsed());
    let rod = Rod::from_nodes("dna", Placement { length, ..placement }, section, 3, Natural::Straight).unwrap();
    println!("measured {:?}", started.elapsed());
    assert!(
        (rod.start_excess_link - plectoneme.writhe()).abs() < 1e-6 * turns.abs(),
        "{} {}",
        rod.start_excess_link,
        plectoneme.writhe()
    );
    let rod = rod.with_excess_link(turns).unwrap();
    println!("twisted {:?}", started.elapsed());
    let d1: Vec<Vec3> = rod.frames.iter().map(|q| q * Vec3::x()).collect();
    let found = link_numbers(&rod.positions, &d1, turns);
    println!("{found:?} {:?}", started.elapsed());
    assert!((found.link - turns).abs() < 1e-7, "{found:?}");
}
