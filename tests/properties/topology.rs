//! Link, twist and writhe: published values, invariance under deformation, scale, offset and number of threads.

use crate::random;

use std::f64::consts::TAU;

use random::Random;
use supercoil::math::Vec3;
use supercoil::math::link::{link_numbers, linking_number, ribbon_twist, writhe};

fn torus_knot(n: usize) -> Vec<Vec3> {
    let at = |t: f64| {
        let rho = 2.0 + (3.0 * t).cos();
        Vec3::new(rho * (2.0 * t).cos(), rho * (2.0 * t).sin(), (3.0 * t).sin())
    };
    (0..n).map(|i| at(TAU * i as f64 / n as f64)).collect()
}

/// Directions normal to the local chord that turn `turns` times relative to the z axis.
fn ribbon(points: &[Vec3], turns: f64) -> Vec<Vec3> {
    let n = points.len();
    let direction = |i: usize| {
        let tangent = (points[(i + 1) % n] - points[(i + n - 1) % n]).normalize();
        let u = (Vec3::z() - tangent * tangent.z).normalize();
        let angle = TAU * turns * i as f64 / n as f64;
        u * angle.cos() + tangent.cross(&u) * angle.sin()
    };
    (0..n).map(direction).collect()
}

/// Reference value of the smooth knot; the inscribed polygon converges to it with order 2.
#[test]
fn writhe_of_the_polygon_converges_to_the_torus_knot() {
    let error = |n: usize| (writhe(&torus_knot(n), true).abs() - 3.51823923104).abs();
    let (coarse, fine) = (error(200), error(1600));
    let order = (coarse / fine).log2() / 3.0;
    assert!(fine < 1e-4 && (order - 2.0).abs() < 0.05, "{coarse:e} {fine:e} order {order}");
}

#[test]
fn writhe_ignores_scale_offset_and_direction_and_flips_in_a_mirror() {
    let points = torus_knot(300);
    let reference = writhe(&points, true);
    for scale in [1e-12, 1e-6, 3.0, 1e6, 1e100] {
        let moved: Vec<Vec3> = points.iter().map(|p| p * scale).collect();
        assert!((writhe(&moved, true) - reference).abs() < 1e-12, "{scale}");
    }
    let far: Vec<Vec3> = points.iter().map(|p| p + Vec3::new(1e4, -2e4, 5e3)).collect();
    assert!((writhe(&far, true) - reference).abs() < 1e-9, "only the rounding of the coordinates themselves");
    let reversed: Vec<Vec3> = points.iter().rev().copied().collect();
    assert!((writhe(&reversed, true) - reference).abs() < 1e-12);
    let mirrored: Vec<Vec3> = points.iter().map(|p| Vec3::new(p.x, p.y, -p.z)).collect();
    assert!((writhe(&mirrored, true) + reference).abs() < 1e-12);
    let doubled: Vec<Vec3> = points.iter().flat_map(|p| [*p, *p]).collect();
    assert_eq!(writhe(&doubled, true), reference, "zero-length edges");
}

/// A helix of pitch angle α (to the axis) and n turns has writhe about n(1 − cos α) when long.
#[test]
fn open_helix() {
    let (radius, pitch, turns, per_turn) = (1.0, 8.0, 60, 60);
    let at = |i: usize| {
        let t = TAU * i as f64 / per_turn as f64;
        Vec3::new(radius * t.cos(), radius * t.sin(), pitch * t / TAU)
    };
    let points: Vec<Vec3> = (0..=turns * per_turn).map(at).collect();
    let cosine = pitch / (TAU * radius).hypot(pitch);
    let expected = turns as f64 * (1.0 - cosine);
    assert!((writhe(&points, false) / expected - 1.0).abs() < 0.02);
}

/// Deform a ribbon at random, as long as nothing passes through anything: link stays put to rounding.
#[test]
fn link_survives_random_deformation() {
    let mut random = Random(7);
    for (n, turns, seam) in [(120, 4.0, 0.0), (300, -6.7, 0.3), (900, 12.5, 0.5)] {
        let base = torus_knot(n);
        let reference = link_numbers(&base, &ribbon(&base, turns), seam).link;
        assert!((reference - seam - (reference - seam).round()).abs() < 1e-12);
        for _ in 0..20 {
            let waves: Vec<(f64, Vec3)> = (1..6).map(|k| (k as f64, random.vector() * 0.04)).collect();
            let push = |p: &Vec3| waves.iter().fold(*p, |q, (k, a)| q + a * (k * (p.x + 0.7 * p.y - 0.4 * p.z)).sin());
            let points: Vec<Vec3> = base.iter().map(push).collect();
            let mut d1 = ribbon(&points, turns);
            d1.iter_mut().for_each(|d| *d += random.vector() * 0.05);
            let found = link_numbers(&points, &d1, seam);
            assert!((found.link - reference).abs() < 1e-12, "{n}: {found:?} {reference}");
        }
    }
}

/// Twist of a straight ribbon is the turn of its frames; the polygon needs no refinement for it.
#[test]
fn twist_of_a_straight_ribbon() {
    let points: Vec<Vec3> = (0..=50).map(|i| Vec3::z() * i as f64).collect();
    let d1: Vec<Vec3> = (0..=50).map(|i| Vec3::new((0.3 * i as f64).cos(), (0.3 * i as f64).sin(), 0.0)).collect();
    assert!((ribbon_twist(&points, &d1, false) - 15.0 / TAU).abs() < 1e-14);
}

/// A flat ring whose d1 turns once more than its tangent: link 1, and ±q flips of the frame play no part.
#[test]
fn flat_ring() {
    let points: Vec<Vec3> = (0..40).map(|i| TAU * i as f64 / 40.0).map(|t| Vec3::new(t.cos(), t.sin(), 0.0)).collect();
    for turns in [-3.0, 0.0, 1.0, 8.0] {
        let found = link_numbers(&points, &ribbon(&points, turns), 0.0);
        assert_eq!(found.writhe, 0.0);
        assert!((found.link - turns).abs() < 1e-13, "{found:?}");
    }
}

#[test]
fn hopf_link_and_its_mirror() {
    for n in [3, 24, 1000] {
        let angle = |i: usize| TAU * (i as f64 + 0.1) / n as f64;
        let a: Vec<Vec3> = (0..n).map(|i| Vec3::new(angle(i).cos(), angle(i).sin(), 0.0)).collect();
        let b: Vec<Vec3> = (0..n).map(|i| Vec3::new(1.0 + angle(i).cos(), 0.0, angle(i).sin())).collect();
        let link = linking_number(&a, &b);
        assert!((link.abs() - 1.0).abs() < 1e-12, "{n}: {link}");
        assert!((linking_number(&b, &a) - link).abs() < 1e-12);
        let reversed: Vec<Vec3> = b.iter().rev().copied().collect();
        assert!((linking_number(&a, &reversed) + link).abs() < 1e-12);
        let away: Vec<Vec3> = b.iter().map(|p| p + Vec3::x() * 5.0).collect();
        assert!(linking_number(&a, &away).abs() < 1e-12);
    }
}

/// A right-handed crossing counts positive: the strands of a right-handed double helix link positively.
#[test]
fn right_handed_is_positive() {
    let a: Vec<Vec3> =
        (0..200).map(|i| TAU * i as f64 / 200.0).map(|t| Vec3::new(t.cos(), t.sin(), 0.0) * 3.0).collect();
    // A curve that runs along `a` and turns about it seven times, right-handed.
    let around = |i: usize| {
        let t = TAU * i as f64 / 2000.0;
        let out = Vec3::new(t.cos(), t.sin(), 0.0);
        let tangent = Vec3::new(-t.sin(), t.cos(), 0.0);
        out * 3.0 + (out * (7.0 * t).cos() + tangent.cross(&out) * (7.0 * t).sin()) * 0.5
    };
    let b: Vec<Vec3> = (0..2000).map(around).collect();
    assert!((linking_number(&a, &b) - 7.0).abs() < 1e-12);
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let (short, long) = (torus_knot(350), torus_knot(5000));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| [writhe(&short, true), writhe(&short, false), writhe(&long, true)].map(f64::to_bits))
    };
    assert_eq!(run(1), run(2));
    assert_eq!(run(1), run(5));
}

/// A tangled closed polygon of random corners: the two ways to the writhe agree, and the open sum approaches the
/// closed.
#[test]
fn random_polygon_has_integer_link() {
    let mut random = Random(3);
    for n in [5, 30, 390, 600] {
        let points: Vec<Vec3> = (0..n).map(|_| random.vector()).collect();
        let d1: Vec<Vec3> = (0..n).map(|_| random.vector()).collect();
        let link = link_numbers(&points, &d1, 0.0).link;
        assert!((link - link.round()).abs() < 1e-10, "{n}: {link}");
    }
}

/// One edge as long as the whole curve must not blow up the grid that finds crossings.
#[test]
fn one_long_edge() {
    let mut points: Vec<Vec3> = (0..40_000)
        .map(|i| f64::from(i) * 1e-4)
        .map(|t| Vec3::new((9.0 * t).cos() * 0.1, (9.0 * t).sin() * 0.1, t))
        .collect();
    points.push(Vec3::new(3.0, 2.0, 2.0));
    let link = link_numbers(&points, &ribbon(&points, 2.0), 0.0).link;
    assert!((link - link.round()).abs() < 1e-10, "{link}");
}

/// The link of plectonemes of up to a million nodes is a whole number; run with `--ignored --nocapture` to see times.
#[test]
#[ignore = "slow: measures time"]
fn million_nodes() {
    for n in [2000, 10_000, 100_000, 1_000_000] {
        let turns = n as f64 / 50.0;
        let half = n / 2;
        let strand = |i: usize, phase: f64| {
            let t = TAU * turns * i as f64 / half as f64;
            Vec3::new((t + phase).cos(), (t + phase).sin(), t)
        };
        let points: Vec<Vec3> =
            (0..half).map(|i| strand(i, 0.0)).chain((0..half).rev().map(|i| strand(i, TAU / 2.0))).collect();
        let d1 = ribbon(&points, 0.0);
        let start = std::time::Instant::now();
        let found = link_numbers(&points, &d1, 0.0);
        println!("{n}: {found:?} {:?}", start.elapsed());
        assert!((found.link - found.link.round()).abs() < 1e-10, "{n}: {found:?}");
    }
}
