//! Contact geometry against brute force: Bernstein roots, projection, capsules, broad phase, exclusion, clearance; and
//! the refusal of bad input.

use std::f64::consts::PI;

use proptest::prelude::*;
use supercoil::InputError;
use supercoil::contact::Cubic;
use supercoil::internals::bernstein::{Roots, SignChange, eval, roots};
use supercoil::internals::broad_phase::{BroadPhase, brute_force_candidates};
use supercoil::internals::capsule::{distance_lower_bound, segment_distance, segment_distance_sq};
use supercoil::internals::clearance::smallest_clearance;
use supercoil::internals::curve::{CurveInput, CurveSet, angle};
use supercoil::internals::exclusion::Exclusion;
use supercoil::internals::projection::{Feet, feet_on_segment, local_minima, stationarity};
use supercoil::math::Vec3;

use crate::random;
use random::Random;

fn exclusion(set: &CurveSet) -> Exclusion {
    let mut e = Exclusion::new();
    e.update(set).expect("the test's curves are fine enough");
    e
}

/// Smooth random curve (sum of three harmonics plus a drift for open ones), in units of `unit` about `centre`.
fn wiggle(rng: &mut Random, n: usize, closed: bool, radius: f64, (unit, centre): (f64, Vec3)) -> CurveInput {
    let waves: Vec<(Vec3, Vec3)> =
        (0..3).map(|k| (rng.vector() / f64::from(k + 1), rng.vector() / f64::from(k + 1))).collect();
    let drift = if closed { Vec3::zeros() } else { rng.vector() * 0.3 };
    let f = |t: f64| {
        let (mut p, mut m) = (drift * t, drift);
        for (k, (a, b)) in waves.iter().enumerate() {
            let w = (k + 1) as f64;
            let (s, c) = (w * t).sin_cos();
            p += a * c + b * s;
            m += (b * c - a * s) * w;
        }
        (p, m)
    };
    let h = 2.0 * PI / n as f64;
    let at = |i: usize| f(h * if closed { i % n } else { i } as f64);
    let place = |c: Cubic| Cubic { b: c.b.map(|p| p * unit + centre) };
    let mut segments: Vec<Cubic> =
        (0..n).map(|i| place(Cubic::from_hermite(at(i).0, at(i).1 * h, at(i + 1).0, at(i + 1).1 * h))).collect();
    for i in 1..n {
        segments[i].b[0] = segments[i - 1].b[3];
    }
    CurveInput { segments, lengths: vec![h * unit; n], closed, radius: radius * unit }
}

// ---- Bernstein roots
// ------------------------------------------------------------------------------------------------------------

/// Bernstein coefficients of c Π (t − r_k).
fn from_roots(r: &[f64], c: f64) -> Vec<f64> {
    let mut b = vec![c];
    for &root in r {
        let n = b.len();
        b = (0..=n)
            .map(|i| {
                let left = if i > 0 { b[i - 1] * i as f64 / n as f64 } else { 0.0 };
                let same = if i < n { b[i] * (n - i) as f64 / n as f64 } else { 0.0 };
                (1.0 - root) * left - root * same
            })
            .collect();
    }
    b
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Every sign change of a dense sampling is bracketed by exactly an odd number of crossing roots; every root is one
    /// of p.
    #[test]
    fn roots_match_dense_sampling(coeffs in prop::collection::vec(-1.0..1.0f64, 1..=8), exponent in -150i32..150) {
        let coeffs: Vec<f64> = coeffs.iter().map(|c| c * 10f64.powi(exponent)).collect();
        let size = coeffs.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        let mut found = Roots::new();
        roots(&coeffs, &mut found);
        let list: Vec<_> = found.iter().collect();
        prop_assert!(list.windows(2).all(|w| w[0].t < w[1].t));
        for r in &list {
            prop_assert!((0.0..=1.0).contains(&r.t));
            prop_assert!(eval(&coeffs, r.t).abs() <= 1e-12 * size, "{r:?}");
        }
        let n = 500;
        for k in 0..n {
            let (a, b) = (f64::from(k) / f64::from(n), f64::from(k + 1) / f64::from(n));
            let (pa, pb) = (eval(&coeffs, a), eval(&coeffs, b));
            if pa.abs().min(pb.abs()) < 1e-13 * size {
                continue;
            }
            let within = list.iter().filter(|r| r.t > a && r.t <= b);
            let inside: Vec<_> = within.filter(|r| r.crossing != SignChange::Touching).collect();
            prop_assert_eq!(inside.len() % 2 == 1, (pa < 0.0) != (pb < 0.0), "{} {} {:?}", a, b, list);
            if let [one] = inside[..] {
                prop_assert_eq!(one.crossing == SignChange::Rising, pa < 0.0);
            }
        }
    }

    /// Well separated known roots come back, whatever the scale; signs of crossings alternate.
    #[test]
    fn known_roots_come_back(gaps in prop::collection::vec(0.05..1.0f64, 2..=8), exponent in -250i32..250) {
        let total: f64 = gaps.iter().sum();
        let mut sum = 0.0;
        let r: Vec<f64> = gaps[..gaps.len() - 1].iter().map(|g| { sum += g / total; sum }).collect();
        prop_assume!(r.windows(2).all(|w| w[1] - w[0] > 0.02));
        let mut found = Roots::new();
        roots(&from_roots(&r, 10f64.powi(exponent)), &mut found);
        prop_assert_eq!(found.as_slice().len(), r.len());
        for (a, b) in found.as_slice().iter().zip(&r) {
            prop_assert!((a - b).abs() < 1e-8, "{} {}", a, b);
        }
        let crossings: Vec<_> = found.iter().map(|r| r.crossing).collect();
        prop_assert!(crossings.windows(2).all(|w| w[0] != w[1]));
    }

    /// A double root plus others: at most one root reported at the double one, none lost among the simple ones.
    #[test]
    fn double_roots_and_ends(double in 0.1..0.9f64, simple in 0.0..1.0f64, gap in 0.0..1e-7f64) {
        prop_assume!((double - simple).abs() > 0.05);
        let mut found = Roots::new();
        roots(&from_roots(&[0.0, double, double + gap, simple, 1.0], -3.0), &mut found);
        let list: Vec<_> = found.iter().collect();
        prop_assert!(list.first().is_some_and(|r| r.t == 0.0) && list.last().is_some_and(|r| r.t == 1.0));
        prop_assert!(list.iter().any(|r| (r.t - simple).abs() < 1e-9), "{:?}", list);
        let near: Vec<_> = list.iter().filter(|r| (r.t - double).abs() < 1e-3).collect();
        prop_assert!(near.len() <= 2 && near.len() + 3 == list.len(), "{:?}", list);
    }
}

// ---- Projection
// -----------------------------------------------------------------------------------------------------------------

fn random_cubic(rng: &mut Random) -> Cubic {
    let mut b = [rng.vector(), rng.vector(), rng.vector(), rng.vector()];
    match rng.below(8) {
        0 => b[1] = b[0],
        1 => b[2] = b[1],
        2 => b[3] = b[0],
        3 => {
            // Back and forth along one line.
            let d = rng.vector();
            b = [d * 0.0, d * 1.5, d * -0.5, d];
        }
        4 => return Cubic::straight(b[0], b[3]),
        5 => b = b.map(|p| Vec3::new(p.x, p.y, 0.0)),
        _ => {}
    }
    Cubic { b }
}

/// 24 000 (curve, point) pairs, ordinary and adversarial, in three units and two offsets.
#[test]
fn projection_misses_and_invents_nothing() {
    let mut rng = Random(1);
    let (mut total, mut feet) = (0, Feet::new());
    let n = 1000;
    for case in 0..24_000 {
        let base = random_cubic(&mut rng);
        let (c, d, dd) = base.derivatives(0.5 + 0.5 * rng.unit());
        let point = match case % 6 {
            0 => c,
            // Near or at the centre of curvature, where minima split.
            1 if d.norm() > 1e-3 => {
                let normal = dd - d * (dd.dot(&d) / d.norm_squared());
                c + normal * (d.norm_squared() / normal.norm_squared().max(1e-9)) * (1.0 + 1e-3 * rng.unit())
            }
            2 => base.b[0] + rng.vector() * 1e-6,
            3 => c + rng.vector() * 1e-3,
            _ => rng.vector() * 2.0,
        };
        let unit = [1.0, 1e-12, 1e12, 1e-140][rng.below(4) as usize];
        let offset = rng.vector() * if rng.below(4) == 0 { 1e6 * unit } else { 0.0 };
        let curve = Cubic { b: base.b.map(|p| p * unit + offset) };
        let x = point * unit + offset;
        local_minima(&curve, &x, f64::INFINITY, &mut feet);
        // The oracle samples the squared distance of the same control points.
        let relative = Cubic { b: curve.b.map(|p| (p - x) / unit) };
        let at = |u: f64| relative.point(u).norm_squared();
        let size = relative.b.iter().map(Vec3::norm_squared).fold(0.0, f64::max);
        let noise = 1e-13 * size;
        let samples: Vec<f64> = (0..=n).map(|k| at(k as f64 / n as f64)).collect();
        for k in 2..n - 1 {
            if samples[k] + noise < samples[k - 1].min(samples[k - 2])
                && samples[k] + noise < samples[k + 1].min(samples[k + 2])
            {
                total += 1;
                let u = k as f64 / n as f64;
                let near = feet.as_slice().iter().filter(|f| (f.u - u).abs() < 2.5 / n as f64).count();
                assert!(near >= 1, "case {case}: missed the minimum at {u}: {feet:?}");
            }
        }
        // None invented: the slope rises through zero there, as far as rounding lets one see; and where the minimum is
        // pronounced the distance grows at once on both sides.
        let slope = stationarity(&relative, &Vec3::zeros());
        let slope_noise = 1e-13 * slope.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        for foot in feet.as_slice() {
            assert!((foot.distance / unit - at(foot.u).sqrt()).abs() <= 1e-14 * size.sqrt());
            let (before, after) = (eval(&slope, (foot.u - 1e-7).max(0.0)), eval(&slope, (foot.u + 1e-7).min(1.0)));
            assert!(
                before <= slope_noise && after >= -slope_noise,
                "case {case}: no minimum at {foot:?}: {before} {after}"
            );
            let (_, d, dd) = relative.derivatives(foot.u);
            let pronounced = d.norm_squared() + relative.point(foot.u).dot(&dd) > 1e-2 * size;
            for u in [foot.u - 1e-4, foot.u + 1e-4] {
                assert!(!pronounced || !(0.0..=1.0).contains(&u) || at(u) > at(foot.u), "case {case}: {foot:?}");
            }
        }
        assert!(feet.as_slice().windows(2).all(|w| w[0].u < w[1].u));
    }
    assert!(total > 15_000, "the oracle saw only {total} minima");
}

/// Walking a curve finds each minimum once: compare with the sampled whole curve, points in joints' normal planes
/// included.
#[test]
fn feet_over_a_curve_match_sampling() {
    let mut rng = Random(2);
    let mut feet = Feet::new();
    for case in 0..200 {
        let closed = case % 2 == 0;
        let set = CurveSet::new(vec![wiggle(&mut rng, 24, closed, 0.1, (1.0, Vec3::zeros()))]).unwrap();
        let x = if case % 4 < 2 {
            rng.vector() * 2.0
        } else {
            let joint = &set.segments[5];
            joint.b[0] + joint.start_tangent().cross(&rng.vector())
        };
        let found: usize = (0..set.len())
            .map(|s| {
                feet_on_segment(&set, s, &x, f64::INFINITY, &mut feet);
                feet.as_slice().len()
            })
            .sum();
        let m = 400;
        let count = 24 * m + usize::from(!closed);
        let d: Vec<f64> = (0..count)
            .map(|k| {
                (set.segments[(k / m).min(23)].point(if k / m == 24 { 1.0 } else { (k % m) as f64 / m as f64 }) - x)
                    .norm()
            })
            .collect();
        let get = |k: i64| {
            if closed {
                Some(d[k.rem_euclid(count as i64) as usize])
            } else {
                usize::try_from(k).ok().and_then(|k| d.get(k).copied())
            }
        };
        let minima = (0..count as i64)
            .filter(|&k| get(k - 1).is_none_or(|v| v > d[k as usize]) && get(k + 1).is_none_or(|v| v >= d[k as usize]))
            .count();
        assert_eq!(found, minima, "case {case}");
    }
}

// ---- Capsules
// -------------------------------------------------------------------------------------------------------------------

#[test]
fn capsule_bound_is_below_the_sampled_distance() {
    let mut rng = Random(3);
    for case in 0..3000 {
        let unit = [1.0, 1e-12, 1e12, 1e-150, 1e150][rng.below(5) as usize];
        let shift = rng.vector() * if case % 2 == 0 { 0.2 } else { 3.0 };
        let a = random_cubic(&mut rng);
        let mut b = random_cubic(&mut rng);
        b.b = b.b.map(|p| p * 0.7 + shift);
        let scaled = |c: &Cubic| Cubic { b: c.b.map(|p| p * unit) };
        let bound = distance_lower_bound(&scaled(&a), &scaled(&b)) / unit;
        let mut least = f64::INFINITY;
        for i in 0..=40 {
            for j in 0..=40 {
                least = least.min((a.point(f64::from(i) / 40.0) - b.point(f64::from(j) / 40.0)).norm());
            }
        }
        assert!(bound <= least * (1.0 + 1e-14), "{bound} {least}");
        let chord = segment_distance(&a.b[0], &a.b[3], &b.b[0], &b.b[3]);
        assert!(
            bound <= chord && (segment_distance_sq(&a.b[0], &a.b[3], &b.b[0], &b.b[3]).sqrt() - chord).abs() < 1e-15
        );
    }
}

#[test]
fn segment_distance_against_sampling_and_swaps() {
    let mut rng = Random(4);
    for case in 0..5000 {
        let [a, b, mut c, mut d] = [rng.vector(), rng.vector(), rng.vector(), rng.vector()];
        match case % 5 {
            0 => (c, d) = (a + Vec3::z() * 0.2, b + Vec3::z() * 0.2),
            1 => (c, d) = (a + (b - a) * 0.3, a + (b - a) * 0.3 + rng.vector() * 1e-9),
            2 => d = c + (b - a) * 1.3 + rng.vector() * 1e-8,
            _ => {}
        }
        let exact = segment_distance(&a, &b, &c, &d);
        for swapped in
            [segment_distance(&b, &a, &c, &d), segment_distance(&c, &d, &a, &b), segment_distance(&a, &b, &d, &c)]
        {
            assert!((swapped - exact).abs() < 1e-14);
        }
        for i in 0..=30 {
            // The best t for each s by projection.
            let p = a + (b - a) * (f64::from(i) / 30.0);
            let e = d - c;
            let t = if e.norm_squared() > 0.0 { ((p - c).dot(&e) / e.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
            assert!(exact <= (p - c - e * t).norm() + 1e-14);
        }
    }
}

// ---- Broad phase
// ----------------------------------------------------------------------------------------------------------------

fn some_curves(rng: &mut Random, unit: f64, centre: Vec3) -> CurveSet {
    let count = 1 + rng.below(4) as usize;
    let curves = (0..count)
        .map(|_| {
            let (n, closed, radius) = (60 + rng.below(60) as usize, rng.below(2) == 0, 0.02 + 0.05 * rng.unit().abs());
            wiggle(rng, n, closed, radius, (unit, centre))
        })
        .collect();
    CurveSet::new(curves).expect("legal curves")
}

#[test]
fn candidates_contain_brute_force_in_any_unit_and_place() {
    let mut rng = Random(5);
    let mut listed = 0;
    for unit in [1e-12, 1.0, 1e12, 1e-120, 1e120] {
        for offset in [0.0, 1e6 * 0.05] {
            for _ in 0..6 {
                let centre = rng.vector() * offset * unit;
                let set = some_curves(&mut rng, unit, centre);
                let mut exclusion = Exclusion::new();
                if exclusion.update(&set).is_err() {
                    continue;
                }
                let (range, margin) = (0.05 * unit, 0.04 * unit);
                let mut broad = BroadPhase::new();
                let found = broad.candidates(&set, &exclusion, range, margin).unwrap();
                assert!(found.windows(2).all(|w| w[0] < w[1]) && found.iter().all(|p| p[0] < p[1]));
                let oracle = brute_force_candidates(&set, &exclusion, range);
                for pair in &oracle {
                    assert!(found.binary_search(pair).is_ok(), "unit {unit:e} offset {offset:e}: {pair:?} is missing");
                }
                listed += oracle.len();
            }
        }
    }
    assert!(listed > 1000, "{listed}");
}

/// A list kept while curves deform stays a superset, exclusion included; it is not rebuilt at every step, and not kept
/// too long.
#[test]
fn kept_lists_stay_supersets_while_curves_move() {
    let mut rng = Random(6);
    let mut rebuilt = 0;
    for _ in 0..20 {
        let mut set = some_curves(&mut rng, 1.0, Vec3::zeros());
        let mut exclusion = Exclusion::new();
        if exclusion.update(&set).is_err() {
            continue;
        }
        let (range, margin) = (0.02, 0.06);
        let mut broad = BroadPhase::new();
        broad.candidates(&set, &exclusion, range, margin).unwrap();
        let (axis, speed) = (rng.vector(), rng.vector() * 0.02);
        for _ in 0..20 {
            // A swirl: moves every joint consistently.
            for segment in set.segments_mut() {
                segment.b = segment.b.map(|p| p + axis.cross(&p) * 0.01 * p.x + speed * p.y);
            }
            if exclusion.update(&set).is_err() {
                break;
            }
            let before = broad.generation();
            let list = broad.candidates(&set, &exclusion, range, margin).unwrap().to_vec();
            for pair in brute_force_candidates(&set, &exclusion, range) {
                assert!(list.binary_search(&pair).is_ok(), "{pair:?}");
            }
            rebuilt += broad.generation() - before;
            let same = broad.generation();
            broad.candidates(&set, &exclusion, range, margin).unwrap();
            assert_eq!(broad.generation(), same);
        }
    }
    assert!((1..300).contains(&rebuilt), "{rebuilt} rebuilds");
}

/// Two lines that close in by 1.2 margins (.6 each) bring a pair into range that the first list did not hold.
#[test]
fn a_list_is_dropped_when_curves_have_closed_in() {
    let line = |z: f64| -> Vec<Vec3> { (0..40).map(|i| Vec3::new(f64::from(i), 0.0, z)).collect() };
    let (range, margin) = (0.1, 0.5);
    let mut set =
        CurveSet::from_polylines(&[(&line(0.0), 0.1, false), (&line(0.2 + range + 1.05 * margin), 0.1, false)])
            .unwrap();
    let e = exclusion(&set);
    let mut broad = BroadPhase::new();
    assert!(broad.candidates(&set, &e, range, margin).unwrap().is_empty());
    for step in 1..=12 {
        for (i, segment) in set.segments_mut().iter_mut().enumerate() {
            let lift = 0.05 * margin * if i < 39 { 1.0 } else { -1.0 };
            segment.b = segment.b.map(|p| p + Vec3::z() * lift);
        }
        let list = broad.candidates(&set, &e, range, margin).unwrap();
        // Kept while no point has moved half the margin.
        assert!(list.is_empty() == (step <= 10) || step == 10, "step {step}");
        let oracle = brute_force_candidates(&set, &e, range);
        assert_eq!(oracle.is_empty(), step <= 10);
        assert!(oracle.iter().all(|p| list.binary_search(p).is_ok()));
    }
}

/// A straight rod crumples into short waves moving less than half the margin: distances alone would keep the list, but
/// neighbours have ceased to be neighbours.
#[test]
fn a_list_is_dropped_when_neighbours_cease_to_be() {
    let n = 100;
    let points = |amplitude: f64| -> Vec<Vec3> {
        (0..n).map(|i| Vec3::new(0.05 * f64::from(i), amplitude * (0.8 * f64::from(i)).sin(), 0.0)).collect()
    };
    let set = |amplitude: f64| CurveSet::from_polylines(&[(&points(amplitude), 0.1, false)]).unwrap();
    let mut broad = BroadPhase::new();
    let straight = set(0.0);
    assert!(broad.candidates(&straight, &exclusion(&straight), 0.1, 0.5).unwrap().is_empty());
    let waves = set(0.1);
    let e = exclusion(&waves);
    let oracle = brute_force_candidates(&waves, &e, 0.1);
    assert!(oracle.len() > 100);
    let list = broad.candidates(&waves, &e, 0.1, 0.5).unwrap();
    assert!(oracle.iter().all(|p| list.binary_search(p).is_ok()));
}

#[test]
fn tiny_sets_and_thread_counts() {
    let mut broad = BroadPhase::new();
    let empty = CurveSet::new(vec![]).unwrap();
    assert!(broad.candidates(&empty, &exclusion(&empty), 1.0, 0.1).unwrap().is_empty());
    assert!(smallest_clearance(&empty, &exclusion(&empty), 1.0, 0.1).is_none());
    let (a, b) = ([Vec3::zeros(), Vec3::x()], [Vec3::new(0.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 0.0)]);
    let one = CurveSet::from_polylines(&[(&a, 0.1, false)]).unwrap();
    assert!(broad.candidates(&one, &exclusion(&one), 1.0, 0.1).unwrap().is_empty());
    let two = CurveSet::from_polylines(&[(&a, 0.1, false), (&b, 0.1, false)]).unwrap();
    assert_eq!(broad.candidates(&two, &exclusion(&two), 0.81, 0.0).unwrap(), [[0, 1]]);
    assert!(broad.candidates(&two, &exclusion(&two), 0.79, 0.0).unwrap().is_empty());
    let mut rng = Random(7);
    let set = loop {
        let set = some_curves(&mut rng, 1.0, Vec3::zeros());
        if Exclusion::new().update(&set).is_ok() {
            break set;
        }
    };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| BroadPhase::new().candidates(&set, &exclusion(&set), 0.1, 0.1).unwrap().to_vec())
    };
    assert_eq!(with(1), with(4));
}

// ---- Exclusion
// ------------------------------------------------------------------------------------------------------------------

/// A thick straight rod then a tight loop: many segments within a diameter of each other on the straight part are
/// neighbours, while in the loop parts a short arc apart touch. No one arc length separates the two.
#[test]
fn exclusion_is_by_turning_not_arc_length() {
    let radius = 0.5;
    let (h, loop_radius) = (0.05, 0.55);
    // Straight from x = −5 to 0, then one helical turn, then straight on.
    let f = |s: f64| {
        let turn = 2.0 * PI * loop_radius;
        let t = s.clamp(0.0, turn) / loop_radius;
        let extra = s - s.clamp(0.0, turn);
        let lift = 1.05 * (t - t.sin()) / (2.0 * PI);
        (
            Vec3::new(loop_radius * t.sin() + extra, loop_radius * (1.0 - t.cos()), lift),
            Vec3::new(
                if extra == 0.0 { t.cos() } else { 1.0 },
                t.sin(),
                1.05 * (1.0 - t.cos()) / (2.0 * PI * loop_radius),
            ),
        )
    };
    let n = 270;
    let at = |i: usize| f(-5.0 + h * i as f64);
    let segments = (0..n).map(|i| Cubic::from_hermite(at(i).0, at(i).1 * h, at(i + 1).0, at(i + 1).1 * h)).collect();
    let set = CurveSet::new(vec![CurveInput { segments, lengths: vec![h; n], closed: false, radius }]).unwrap();
    let e = exclusion(&set);
    // Straight part: 80 segments = 4 diameters apart, still neighbours.
    assert!(e.excluded(0, 80) && e.excluded_bilateral(0, 80));
    // In the loop: 2.5 diameters of arc apart, across from each other: not neighbours.
    let (p, q) = (110, 134);
    assert!(!e.excluded(p, q));
    // The crossing is found, at a place arc length 2π·0.55 = 3.5 < 4 apart.
    let c = smallest_clearance(&set, &e, 1.0, 1e-9).unwrap();
    assert!((c.arc_b - c.arc_a).abs() < 4.0 && c.upper < 0.1, "{c:?}");
}

// ---- Clearance
// ------------------------------------------------------------------------------------------------------------------

/// Smallest sampled gap over pairs certainly in the domain (turning of sampled tangents ≥ π both ways on one curve).
fn sampled_gap(set: &CurveSet, m: usize) -> f64 {
    let mut points = Vec::new();
    for s in 0..set.len() {
        for k in 0..m {
            let (p, d, _) = set.segments[s].derivatives(k as f64 / m as f64);
            points.push((s, p, d));
        }
    }
    let mut turned = vec![0.0; points.len() + 1];
    for k in 1..points.len() {
        let same = set.curve_of(points[k].0) == set.curve_of(points[k - 1].0);
        turned[k] = turned[k - 1] + if same { angle(&points[k].2, &points[k - 1].2) } else { 0.0 };
    }
    let ends: Vec<(f64, f64)> =
        set.curves.iter().map(|c| (turned[c.first * m], turned[(c.first + c.count) * m - 1])).collect();
    let mut least = f64::INFINITY;
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            let (a, b) = (set.curve_of(points[i].0), set.curve_of(points[j].0));
            let around = turned[j] - turned[i];
            let other = ends[a].1 - ends[a].0 - around;
            if a == b && (around < PI || (set.curves[a].closed && other < PI)) {
                continue;
            }
            let radii = set.curves[a].radius + set.curves[b].radius;
            least = least.min((points[i].1 - points[j].1).norm() - radii);
        }
    }
    least
}

#[test]
fn clearance_brackets_dense_sampling() {
    let mut rng = Random(8);
    let (mut checked, mut tight) = (0, 0);
    for case in 0..40 {
        let unit = [1.0, 1e-12, 1e12, 1e-60][case % 4];
        let curves =
            (0..1 + case % 3).map(|k| wiggle(&mut rng, 40, (case + k) % 2 == 0, 0.02, (unit, Vec3::zeros()))).collect();
        let set = CurveSet::new(curves).unwrap();
        let mut e = Exclusion::new();
        if e.update(&set).is_err() {
            continue;
        }
        let tol = 1e-10 * unit;
        let sampled = sampled_gap(&set, 12);
        let Some(c) = smallest_clearance(&set, &e, 2.0 * unit, tol) else {
            assert!(sampled > 1.9 * unit);
            continue;
        };
        assert!(c.lower <= c.upper && c.lower <= sampled, "case {case}: {c:?} {sampled}");
        // Where points are sampled 12 to a segment the true minimum is not far below.
        assert!(c.upper <= sampled + tol, "case {case}: {c:?} sampled {sampled}");
        let d = (set.segments[c.segment_a].point(c.u_a) - set.segments[c.segment_b].point(c.u_b)).norm();
        assert!((d - set.radius_of(c.segment_a) - set.radius_of(c.segment_b) - c.upper).abs() < 1e-12 * unit);
        assert_eq!(c.arc_a, set.arc_length(c.segment_a, c.u_a));
        tight += usize::from(c.upper - c.lower <= 1.001 * tol);
        checked += 1;
    }
    assert!(checked >= 20 && tight == checked, "{tight} of {checked}");
}

#[test]
fn clearance_of_overlapping_and_identical_curves() {
    let (a, b) = ([Vec3::zeros(), Vec3::x()], [Vec3::new(0.5, -1.0, 0.0), Vec3::new(0.5, 1.0, 0.0)]);
    for other in [&a, &b] {
        let set = CurveSet::from_polylines(&[(&a, 0.1, false), (other, 0.2, false)]).unwrap();
        let c = smallest_clearance(&set, &exclusion(&set), 1.0, 1e-9).unwrap();
        assert!((c.upper + 0.3).abs() < 1e-6 && c.lower <= c.upper && c.lower >= -0.3 - 1e-15, "{c:?}");
    }
}

// ---- Refusals
// -------------------------------------------------------------------------------------------------------------------

fn message(result: Result<CurveSet, InputError>) -> String {
    result.expect_err("must be refused").to_string()
}

#[test]
fn bad_input_is_refused_by_curve_and_index() {
    let good = CurveInput {
        segments: vec![Cubic::straight(Vec3::zeros(), Vec3::x())],
        lengths: vec![1.0],
        closed: false,
        radius: 0.1,
    };
    let with = |change: &dyn Fn(&mut CurveInput)| {
        let mut bad = good.clone();
        change(&mut bad);
        message(CurveSet::new(vec![good.clone(), bad]))
    };
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(with(&|c| c.radius = value).contains("curves[1].radius"));
        assert!(with(&|c| c.lengths[0] = value).contains("curves[1].lengths[0]"));
    }
    assert!(with(&|c| c.segments[0].b[2].y = f64::NAN).contains("curves[1].segments[0].b[2]"));
    assert!(with(&|c| c.segments.clear()).contains("curves[1].segments"));
    assert!(with(&|c| c.lengths.push(1.0)).contains("curves[1].lengths"));
    assert!(with(&|c| c.closed = true).contains("curves[1].segments[0]"), "a closed curve that does not close");
    let p = [Vec3::zeros(), Vec3::x(), Vec3::x()];
    assert!(message(CurveSet::from_polylines(&[(&p, 0.1, false)])).contains("curves[0].lengths[1]"));
    assert!(message(CurveSet::from_polylines(&[(&p[..1], 0.1, false)])).contains("curves[0].points"));
    assert!(
        message(CurveSet::from_polylines(&[(&[Vec3::zeros(), Vec3::x() * f64::NAN], 0.1, false)]))
            .contains("points[1]")
    );
}

#[test]
fn geometry_that_turns_bad_later_is_refused_too() {
    let mut set = CurveSet::from_polylines(&[(&[Vec3::zeros(), Vec3::x(), Vec3::x() * 2.0], 0.1, false)]).unwrap();
    let e = exclusion(&set);
    for bad in [f64::NAN, f64::INFINITY] {
        set.segments_mut()[1].b[3].z = bad;
        assert!(set.validate_geometry().unwrap_err().to_string().contains("curves[0].segments[1].b[3]"));
        assert!(BroadPhase::new().candidates(&set, &e, 0.1, 0.1).is_err());
        assert!(smallest_clearance(&set, &e, 0.1, 0.1).is_none());
    }
    set.segments_mut()[1].b[3].z = 0.0;
    for (range, margin) in [(f64::NAN, 0.0), (0.0, f64::NAN), (0.0, -1.0)] {
        assert!(BroadPhase::new().candidates(&set, &e, range, margin).is_err());
    }
}
