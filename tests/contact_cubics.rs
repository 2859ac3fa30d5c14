//! Contact of smooth cubics: the same sites and zones after motions, changes of unit, far from the origin, reversed and exchanged; and with a hard case
//! for the certified search, many minima in one pair of segments' neighbourhood.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::f64::consts::PI;

use supercoil::contact::curve::Cubic;
use supercoil::contact::{Contacts, Curve, Neighbours, Options, Site, detect};
use supercoil::math::{Quat, Vec3};

#[path = "common/random.rs"]
mod random;
use random::Random;

const RADIUS: f64 = 0.1;
const RANGE: f64 = 0.3;

/// Closed curve of three random harmonics, n pieces.
fn smooth(rng: &mut Random, n: usize) -> Vec<Cubic> {
    let waves: Vec<(Vec3, Vec3)> = (1..4).map(|k| (rng.vector() / f64::from(k), rng.vector() / f64::from(k))).collect();
    let at = |i: usize| {
        let t = 2.0 * PI * (i % n) as f64 / n as f64;
        let (mut p, mut m) = (Vec3::zeros(), Vec3::zeros());
        for (k, (a, b)) in waves.iter().enumerate() {
            let w = (k + 1) as f64;
            let (s, c) = (w * t).sin_cos();
            p += a * c + b * s;
            m += (b * c - a * s) * w;
        }
        (p, m * (2.0 * PI / n as f64))
    };
    (0..n).map(|k| Cubic::from_hermite(at(k).0, at(k).1, at(k + 1).0, at(k + 1).1)).collect()
}

fn find(a: &[Cubic], b: &[Cubic], unit: f64) -> Contacts {
    let set = [Curve::cubics(a, RADIUS * unit).closed(), Curve::cubics(b, RADIUS * unit).closed()];
    // Neighbours by count: the turning of a piece is a bound, which rounding may move across the limit.
    let options = Options { range: RANGE * unit, neighbours: Neighbours::Segments(12), ..Options::default() };
    detect(&set, options).unwrap()
}

fn mapped(curve: &[Cubic], f: impl Fn(&Vec3) -> Vec3) -> Vec<Cubic> {
    curve.iter().map(|c| Cubic { b: c.b.map(|p| f(&p)) }).collect()
}

fn reversed(curve: &[Cubic]) -> Vec<Cubic> {
    curve.iter().rev().map(|c| Cubic { b: [c.b[3], c.b[2], c.b[1], c.b[0]] }).collect()
}

/// Sites between the two curves as (gap, arcs on the first and second curve, angle), sorted by gap.
fn between(c: &Contacts, unit: f64, swapped: bool) -> Vec<[f64; 4]> {
    let tell = |s: &Site| {
        let (a, b) = if swapped { (s.arc_b, s.arc_a) } else { (s.arc_a, s.arc_b) };
        [s.gap / unit, a / unit, b / unit, s.angle]
    };
    let mut list: Vec<_> = c.sites.iter().filter(|s| s.curve_a != s.curve_b && !s.flat).map(tell).collect();
    list.sort_by(|x, y| x[0].total_cmp(&y[0]));
    list
}

fn assert_same(x: &[[f64; 4]], y: &[[f64; 4]], tol: f64, lengths: [f64; 2], what: &str) {
    assert_eq!(x.len(), y.len(), "{what}");
    for (p, q) in x.iter().zip(y) {
        assert!((p[0] - q[0]).abs() < tol, "{what}: {p:?} {q:?}");
        // The place is known to the square root of the gap's accuracy at worst; round the closing joint.
        for k in 1..3 {
            let apart = (p[k] - q[k]).abs();
            assert!(apart.min((lengths[k - 1] - apart).abs()) < 1e3 * tol + 1e-8, "{what}: {p:?} {q:?}");
        }
        assert!((p[3] - q[3]).abs() < 1e4 * tol + 1e-7, "{what}: {p:?} {q:?}");
    }
}

#[test]
fn same_sites_under_motion_unit_offset_reversal_and_swap() {
    let mut rng = Random(77);
    let (mut total, mut zones) = (0, 0);
    for case in 0..12 {
        let (a, b) = (smooth(&mut rng, 64), smooth(&mut rng, 64));
        let base = find(&a, &b, 1.0);
        let expected = between(&base, 1.0, false);
        total += expected.len();
        zones += base.zones.len();
        let length = |c: &[Cubic]| {
            c.iter()
                .map(|c| (0..1024).map(|k| c.derivatives((f64::from(k) + 0.5) / 1024.0).1.norm() / 1024.0).sum::<f64>())
                .sum()
        };
        let lengths: [f64; 2] = [length(&a), length(&b)];
        let turn = Quat::from_euler_angles(0.3, -1.1, 2.0);
        let units = (-12..=12).step_by(4).map(|k| (10f64.powi(k), Vec3::zeros(), 1e-12));
        let moves = [(1.0, Vec3::new(3.0, -7.0, 11.0), 1e-12), (1.0, Vec3::repeat(1e6 * RADIUS), 1e-9)];
        for (unit, shift, tol) in units.chain(moves) {
            let f = |p: &Vec3| turn * p * unit + shift;
            let moved = find(&mapped(&a, f), &mapped(&b, f), unit);
            let what = format!("case {case} unit {unit:e} shift {}", shift.x);
            assert_same(&expected, &between(&moved, unit, false), tol, lengths, &what);
            assert_eq!(base.zones.len(), moved.zones.len(), "{what}");
            for (y, z) in base.zones.iter().zip(&moved.zones) {
                assert_eq!((y.curve, y.partner), (z.curve, z.partner), "{what}");
                let close = |p: f64, q: f64| (p - q / unit).abs() < 1e6 * tol;
                assert!(
                    close(y.arc[0], z.arc[0]) && close(y.arc[1], z.arc[1]) && close(y.gap, z.gap),
                    "{what}: {y:?} {z:?}"
                );
            }
        }
        assert_same(&expected, &between(&find(&b, &a, 1.0), 1.0, true), 1e-12, lengths, "swap");
        let mut back = between(&find(&reversed(&a), &b, 1.0), 1.0, false);
        back.iter_mut().for_each(|s| s[1] = lengths[0] - s[1]);
        assert_same(&expected, &back, 1e-12, lengths, "reversal");
    }
    assert!(total > 60 && zones > 60, "{total} {zones}");
}

/// Damped Newton down the distance from (u, v) inside the square.
fn descend(a: &Cubic, b: &Cubic, mut u: f64, mut v: f64) -> (f64, f64) {
    let value = |u: f64, v: f64| (a.point(u) - b.point(v)).norm_squared();
    for _ in 0..500 {
        let ((pa, da, dda), (pb, db, ddb)) = (a.derivatives(u), b.derivatives(v));
        let w = pa - pb;
        let (gu, gv) = (w.dot(&da), -w.dot(&db));
        let (uu, vv, uv) = (da.dot(&da) + w.dot(&dda), db.dot(&db) - w.dot(&ddb), -da.dot(&db));
        let lower = (-12..6).map(|k| 10f64.powi(k)).find_map(|shift| {
            let (x, y) = (uu + shift, vv + shift);
            let det = x * y - uv * uv;
            let next = ((u - (y * gu - uv * gv) / det).clamp(0.0, 1.0), (v - (x * gv - uv * gu) / det).clamp(0.0, 1.0));
            (x > 0.0 && det > 0.0 && value(next.0, next.1) < value(u, v)).then_some(next)
        });
        match lower {
            Some(next) => (u, v) = next,
            None => break,
        }
    }
    (u, v)
}

/// One pair of pieces with several minima: two S-shaped arcs across each other. All that a fine grid shows are told, and each told one is a minimum.
#[test]
fn many_minima_in_one_pair() {
    let mut rng = Random(5);
    let (mut pairs, mut several, mut total, mut undecided) = (0, 0, 0, 0);
    for _ in 0..400 {
        let mut cubic = || Cubic { b: std::array::from_fn(|_| rng.vector()) };
        let (a, b) = (cubic(), cubic());
        let set = [Curve::cubics(std::slice::from_ref(&a), 0.1), Curve::cubics(std::slice::from_ref(&b), 0.1)];
        let options = Options {
            range: 3.0,
            neighbours: Neighbours::Segments(1),
            zones: false,
            sampling: 256,
            ..Options::default()
        };
        let sites = detect(&set, options).unwrap().sites;
        let inner: Vec<&Site> =
            sites.iter().filter(|s| s.u_a > 0.0 && s.u_a < 1.0 && s.u_b > 0.0 && s.u_b < 1.0).collect();
        const N: usize = 120;
        let at = |c: &Cubic| -> Vec<Vec3> { (0..=N).map(|k| c.point(k as f64 / N as f64)).collect() };
        let (p, q) = (at(&a), at(&b));
        let d = |i: usize, j: usize| (p[i] - q[j]).norm();
        let mut sampled = 0;
        for i in 2..N - 1 {
            for j in 2..N - 1 {
                let here = d(i, j);
                if (0..9).all(|k| k == 4 || d(i + k / 3 - 1, j + k % 3 - 1) > here) {
                    sampled += 1;
                    let (u, v) = (i as f64 / N as f64, j as f64 / N as f64);
                    let told = inner
                        .iter()
                        .any(|s| (s.u_a - u).abs() < 0.1 && (s.u_b - v).abs() < 0.1 && s.gap + 0.2 <= here + 1e-12);
                    // In a slanting narrow valley the grid shows minima of its own; a descent must then lead to a told one.
                    if told {
                        continue;
                    }
                    let end = descend(&a, &b, u, v);
                    if !sites.iter().any(|s| (s.u_a - end.0).abs() < 1e-3 && (s.u_b - end.1).abs() < 1e-3) {
                        // Only in a valley that was left undecided, and says so.
                        assert!(inner.iter().any(|s| s.flat), "{end:?} of {a:?} {b:?}: {inner:?}");
                        undecided += 1;
                    }
                }
            }
        }
        for s in &inner {
            let ((pa, da, dda), (pb, db, ddb)) = (a.derivatives(s.u_a), b.derivatives(s.u_b));
            let w = pa - pb;
            assert!(w.dot(&da).abs() < 1e-8 * da.norm() && w.dot(&db).abs() < 1e-8 * db.norm(), "{s:?}");
            let (uu, vv, uv) = (da.dot(&da) + w.dot(&dda), db.dot(&db) - w.dot(&ddb), -da.dot(&db));
            assert!(s.flat || (uu > 0.0 && uu * vv - uv * uv > 0.0), "{s:?} is no minimum");
        }
        pairs += usize::from(sampled > 0);
        several += usize::from(sampled > 1);
        total += sampled;
    }
    assert!(pairs > 100 && several > 10 && undecided * 100 < total, "{pairs} {several} {total} {undecided}");
}
