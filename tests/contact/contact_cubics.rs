//! Contact of cubics: the same sites and zones after motions, changes of unit, far from the origin, reversed and
//! exchanged; and hard cases for the certified search: wild cubics with many minima a pair, contact lines whose depth
//! varies by 1e-7, parallel and coincident curves.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::f64::consts::PI;

use supercoil::contact::Cubic;
use supercoil::contact::{Contacts, Curve, DetectorOptions, Neighbours, Site, SiteLocation, detect};
use supercoil::math::{Quat, Vec3};

use crate::random;
use random::Random;

use crate::smooth_curves;
use smooth_curves::harmonics;

const RADIUS: f64 = 0.1;
const RANGE: f64 = 0.3;

fn find(a: &[Cubic], b: &[Cubic], unit: f64) -> Contacts {
    let set = [Curve::cubics(a, RADIUS * unit).closed(), Curve::cubics(b, RADIUS * unit).closed()];
    // Neighbours by count: the turning of a piece is a bound, which rounding may move across the limit.
    let options =
        DetectorOptions { range: RANGE * unit, neighbours: Neighbours::Segments(12), ..DetectorOptions::default() };
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
        let (a, b) = (harmonics(&mut rng, 64, 1.0), harmonics(&mut rng, 64, 1.0));
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

fn between_two(a: &[Cubic], b: &[Cubic], range: f64) -> Vec<Site> {
    let options = DetectorOptions {
        range,
        neighbours: Neighbours::Segments(usize::MAX),
        zones: false,
        ..DetectorOptions::default()
    };
    detect(&[Curve::cubics(a, RADIUS), Curve::cubics(b, RADIUS)], options).unwrap().sites
}

/// Wild cubics (random control points): wherever a descent of the distance ends inside both, there is a site; each site
/// is told once, is a minimum, and none is left undecided.
#[test]
fn all_minima_of_wild_cubics() {
    let mut rng = Random(5);
    let (mut several, mut total, mut ends) = (0, 0, 0);
    for case in 0..400 {
        let mut cubic = || Cubic { b: std::array::from_fn(|_| rng.vector()) };
        let (a, b) = (cubic(), cubic());
        let sites = between_two(std::slice::from_ref(&a), std::slice::from_ref(&b), 4.0);
        assert!(sites.iter().all(|s| !s.flat), "case {case}: {sites:?}");
        let inside = |u: f64| u > 1e-6 && u < 1.0 - 1e-6;
        let inner: Vec<&Site> = sites.iter().filter(|s| inside(s.u_a) && inside(s.u_b)).collect();
        for k in 0..225 {
            let (u, v) = descend(&a, &b, f64::from(k / 15) / 14.0, f64::from(k % 15) / 14.0);
            let ((pa, da, _), (pb, db, _)) = (a.derivatives(u), b.derivatives(v));
            let w = pa - pb;
            // Some descents stop short where steps no longer pay.
            let level = w.dot(&da).abs() < 1e-9 * da.norm() && w.dot(&db).abs() < 1e-9 * db.norm();
            if inside(u) && inside(v) && level {
                ends += 1;
                let near = |s: &&&Site| (s.u_a - u).abs() < 1e-4 && (s.u_b - v).abs() < 1e-4;
                assert_eq!(inner.iter().filter(near).count(), 1, "case {case}: ({u}, {v}) of {a:?} {b:?}: {inner:?}");
            }
        }
        for s in &inner {
            let ((pa, da, dda), (pb, db, ddb)) = (a.derivatives(s.u_a), b.derivatives(s.u_b));
            let w = pa - pb;
            assert!(w.dot(&da).abs() < 1e-13 * da.norm() && w.dot(&db).abs() < 1e-13 * db.norm(), "{s:?}");
            let (uu, vv, uv) = (da.dot(&da) + w.dot(&dda), db.dot(&db) - w.dot(&ddb), -da.dot(&db));
            assert!(uu > 0.0 && uu * vv - uv * uv > 0.0, "{s:?} is no minimum");
        }
        several += usize::from(inner.len() > 1);
        total += inner.len();
    }
    assert!(several > 50 && total > 300 && ends > 20_000, "{several} {total} {ends}");
}

fn helix(n: usize, phase: f64, shift: f64) -> Vec<Cubic> {
    let h = 2.0 * PI / 20.0;
    let at = |k: usize| {
        let t = h * (k as f64 + shift);
        let (s, c) = (t + phase).sin_cos();
        (Vec3::new(c, s, 0.4 * t), Vec3::new(-s, c, 0.4) * h)
    };
    (0..n).map(|k| Cubic::from_hermite(at(k).0, at(k).1, at(k + 1).0, at(k + 1).1)).collect()
}

/// Two coaxial helices touch along two lines. As strings of cubics their distance varies along a line by 1e-7 of it,
/// several times a segment: the minima are those of the distance sampled along the line, all of them and no others.
#[test]
fn all_minima_along_contact_lines() {
    const N: usize = 40;
    const FINE: usize = 2000;
    for shift in [0.0, 0.37, 0.9] {
        let (a, b) = (helix(N, 0.0, 0.0), helix(N, PI, shift));
        let sites = between_two(&a, &b, 1.85);
        let place = |x: f64| ((x as usize).min(N - 1), x - (x as usize).min(N - 1) as f64);
        let derivatives = |c: &[Cubic], x: f64| c[place(x).0].derivatives(place(x).1);
        let mut expected = Vec::new();
        // sin δ = .16 δ: where the distance across stops falling.
        for delta in [-2.7, 2.7] {
            let mut y = 10.0 - shift + delta / (2.0 * PI / 20.0);
            let y0 = y;
            let mut depth = |k: usize| {
                let x = 10.0 + k as f64 / FINE as f64;
                y = y0 + x - 10.0;
                for _ in 0..20 {
                    let (p, (q, dq, ddq)) = (derivatives(&a, x).0, derivatives(&b, y));
                    y += (p - q).dot(&dq) / (dq.norm_squared() - (p - q).dot(&ddq));
                }
                (x, y, (derivatives(&a, x).0 - derivatives(&b, y).0).norm())
            };
            let line: Vec<_> = (0..=20 * FINE).map(&mut depth).collect();
            // Over five samples, so that rounding shows no minima of its own.
            expected.extend((5..line.len() - 5).filter_map(|k| {
                let lower = |m: usize| line[k].2 < line[m].2;
                (lower(k - 5)
                    && lower(k + 5)
                    && (1..5).all(|d| line[k].2 <= line[k - d].2 && line[k].2 <= line[k + d].2))
                .then_some(line[k])
            }));
        }
        expected.dedup_by(|p, q| (p.0 - q.0).abs() < 3.0 / FINE as f64);
        let told: Vec<(f64, f64)> =
            sites.iter().map(|s| (s.segment_a as f64 + s.u_a, s.segment_b as f64 + s.u_b)).collect();
        let within = |x: f64| x > 10.01 && x < 29.99;
        for (x, y, _) in expected.iter().filter(|e| within(e.0)) {
            let near = |p: &&(f64, f64)| (p.0 - x).abs() < 5e-3 && (p.1 - y).abs() < 5e-3;
            assert_eq!(told.iter().filter(near).count(), 1, "shift {shift}: {x} {y}");
        }
        let (found, sampled) =
            (told.iter().filter(|p| within(p.0)).count(), expected.iter().filter(|e| within(e.0)).count());
        assert!(found == sampled && found >= 38, "shift {shift}: {found} sites, {sampled} sampled");
    }
}

/// Parallel and coincident strings of straight cubics: for each pair that runs side by side one flat site in the middle
/// of the common part, and nothing where pairs only meet at a joint.
#[test]
fn parallel_cubics_have_a_flat_site_each() {
    let d = Vec3::new(0.3, 0.5, 0.7).normalize();
    let aside = d.cross(&Vec3::x()).normalize() * 0.3;
    let line = |shift: f64, from: Vec3| -> Vec<Cubic> {
        let at = |k: usize| from + d * (k as f64 + shift);
        (0..10).map(|k| Cubic::straight(at(k), at(k + 1))).collect()
    };
    for (shift, from) in [(0.0, aside), (0.25, aside), (0.0, Vec3::zeros()), (0.25, Vec3::zeros())] {
        let sites = between_two(&line(0.0, Vec3::zeros()), &line(shift, from), 0.2);
        let (flat, others): (Vec<Site>, Vec<Site>) = sites.iter().partition(|s| s.flat);
        // Open ends are sites of their own.
        assert!(others.iter().all(|s| s.kind == supercoil::contact::SiteLocation::End), "{others:?}");
        for s in &flat {
            let (x, y) = (s.segment_a as f64 + s.u_a, s.segment_b as f64 + s.u_b + shift);
            assert!((x - y).abs() < 1e-9 && (s.gap - (from.norm() - 2.0 * RADIUS)).abs() < 1e-12, "{s:?}");
            let middle = if s.segment_a == s.segment_b { 0.5 * (1.0 + shift) } else { 0.5 * shift };
            assert!((s.u_a - middle).abs() < 1e-6, "{s:?}");
        }
        assert_eq!(flat.len(), if shift == 0.0 { 10 } else { 19 });
    }
}

/// However far apart two crossing cubics are, straight or bulging towards each other, their soft minimum is isolated:
/// up to 1e11 of their length, where the distance along them changes by no more than its rounding.
#[test]
fn soft_minima_of_far_cubics_are_isolated() {
    let v = Vec3::new;
    for (distance, bulge) in (0..=11).flat_map(|k| [0.0, 0.05].map(|bulge| (10f64.powi(k), bulge))) {
        for t in (0..20).map(|k| 0.03 * f64::from(k)) {
            let a = [Cubic {
                b: [v(-1.0, 0.1 * t, -bulge), v(-0.33, 0.01, bulge), v(0.34, 0.0, bulge), v(1.0, 0.05, -bulge)],
            }];
            let (low, high) = (distance - bulge, distance + bulge);
            let b = [Cubic {
                b: [v(0.1 + 0.3 * t, -1.0, high), v(0.05, -0.3, low), v(0.05, 0.4, low), v(-0.1, 1.0 + t, high)],
            }];
            let options = DetectorOptions { range: 2.0 * distance, zones: false, ..DetectorOptions::default() };
            let found = detect(&[Curve::cubics(&a, 0.1), Curve::cubics(&b, 0.1)], options).unwrap().sites;
            assert!(
                found.len() == 1 && !found[0].flat && found[0].kind == SiteLocation::Interior,
                "{distance:e} {found:?}"
            );
            let ((p, dp, _), (q, dq, _)) = (a[0].derivatives(found[0].u_a), b[0].derivatives(found[0].u_b));
            let w = (q - p).normalize();
            assert!(w.dot(&dp).abs() < 1e-14 * dp.norm() && w.dot(&dq).abs() < 1e-14 * dq.norm(), "{distance:e}");
        }
    }
}
