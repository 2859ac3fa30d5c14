//! Contact sites and zones against sampling, and the stated answers of special cases.

use std::f64::consts::PI;

use supercoil::contact::Cubic;
use supercoil::contact::{Contacts, Curve, DetectorOptions, Neighbours, Site, SiteLocation, detect};
use supercoil::math::Vec3;

use crate::random;
use random::Random;

use crate::smooth_curves;
use smooth_curves::{harmonics, helix};

fn options(range: f64, neighbours: Neighbours) -> DetectorOptions {
    DetectorOptions { range, neighbours, ..DetectorOptions::default() }
}

/// The sampled distance of two polylines: local minima over a fine grid of both, with their places.
fn sampled_minima(a: &[Vec3], b: &[Vec3], per_segment: usize, max: f64) -> Vec<(f64, f64, f64)> {
    let at = |p: &[Vec3], k: usize| {
        let (s, t) = (k / per_segment, (k % per_segment) as f64 / per_segment as f64);
        if s + 1 == p.len() { p[s] } else { p[s] + (p[s + 1] - p[s]) * t }
    };
    let (n, m) = ((a.len() - 1) * per_segment, (b.len() - 1) * per_segment);
    let d: Vec<Vec<f64>> = (0..=n).map(|i| (0..=m).map(|j| (at(a, i) - at(b, j)).norm()).collect()).collect();
    let mut found = Vec::new();
    for i in 0..=n {
        for j in 0..=m {
            let around = |di: i64, dj: i64| {
                let (x, y) = (i as i64 + di, j as i64 + dj);
                (x >= 0 && y >= 0 && x <= n as i64 && y <= m as i64).then(|| d[x as usize][y as usize])
            };
            let lowest = (-1..=1).all(|x| (-1..=1).all(|y| around(x, y).is_none_or(|v| v >= d[i][j])));
            if lowest && d[i][j] < max {
                found.push((i as f64 / per_segment as f64, j as f64 / per_segment as f64, d[i][j]));
            }
        }
    }
    found
}

/// Every sampled minimum of two random polylines has a site near it that is at least as deep, and every site is a
/// minimum among its surroundings.
#[test]
fn sites_of_polylines_match_sampling() {
    let mut rng = Random(3);
    let mut total = 0;
    for case in 0..100 {
        let mut walk = || {
            let mut p = vec![rng.vector()];
            for _ in 0..6 {
                let next = p[p.len() - 1] + rng.vector();
                p.push(next);
            }
            p
        };
        let (a, b) = (walk(), walk());
        let range = 1.0;
        let found =
            detect(&[Curve::polyline(&a, 0.1), Curve::polyline(&b, 0.1)], options(range, Neighbours::Turning)).unwrap();
        let sites: Vec<&Site> = found.sites.iter().filter(|s| s.curve_a != s.curve_b).collect();
        for (s, t, d) in sampled_minima(&a, &b, 40, range) {
            total += 1;
            // A descent from the sampled minimum can only lead to a site; nearly flat valleys let it wander.
            let near = |x: &&&Site| {
                let (u, v) = (x.segment_a as f64 + x.u_a, x.segment_b as f64 + x.u_b);
                (u - s).abs().max((v - t).abs()) < 1.5 && x.gap + 0.2 <= d + 1e-12
            };
            assert!(sites.iter().any(|x| near(&x)), "case {case}: no site for the minimum at {s} {t}: {d}");
        }
        let at = |p: &[Vec3], x: f64| {
            let s = (x.max(0.0) as usize).min(p.len() - 2);
            p[s] + (p[s + 1] - p[s]) * (x.min(p.len() as f64 - 1.0).max(0.0) - s as f64)
        };
        for x in &sites {
            let (u, v) = (x.segment_a as f64 + x.u_a, x.segment_b as f64 + x.u_b);
            for k in 0..16 {
                let (sin, cos) = (PI / 8.0 * f64::from(k)).sin_cos();
                let d = (at(&a, u + 1e-4 * cos) - at(&b, v + 1e-4 * sin)).norm();
                assert!(d >= x.gap + 0.2 - 1e-12, "case {case}: {x:?} is no minimum");
            }
        }
    }
    assert!(total > 150, "{total}");
}

/// Crossing smooth curves: the sites of cubics are those of brute-force minimisation.
#[test]
fn sites_of_cubics_match_sampling() {
    let mut rng = Random(4);
    let mut total = 0;
    for case in 0..40 {
        let (a, b) = (harmonics(&mut rng, 48, 0.8), harmonics(&mut rng, 48, 0.8));
        let range = 0.6;
        let Ok(found) = detect(&[Curve::cubics(&a, 0.1), Curve::cubics(&b, 0.1)], options(range, Neighbours::Turning))
        else {
            continue;
        };
        let sites: Vec<&Site> = found.sites.iter().filter(|s| s.curve_a != s.curve_b).collect();
        // The same, whichever curve comes first and whichever way they run.
        let back: Vec<Cubic> = a.iter().rev().map(|c| Cubic { b: [c.b[3], c.b[2], c.b[1], c.b[0]] }).collect();
        for (x, y) in [(&b, &a), (&back, &b)] {
            let set = [Curve::cubics(x, 0.1), Curve::cubics(y, 0.1)];
            let other = detect(&set, options(range, Neighbours::Turning)).unwrap();
            let gaps = |c: &Contacts| {
                let mut g: Vec<f64> = c.sites.iter().filter(|s| s.curve_a != s.curve_b).map(|s| s.gap).collect();
                g.sort_by(f64::total_cmp);
                g
            };
            let (p, q) = (gaps(&found), gaps(&other));
            assert!(
                p.len() == q.len() && p.iter().zip(&q).all(|(p, q)| (p - q).abs() < 1e-12),
                "case {case}: {p:?} {q:?}"
            );
        }
        let m = 6;
        let point =
            |c: &[Cubic], k: usize| c[(k / m).min(47)].point(if k == 48 * m { 1.0 } else { (k % m) as f64 / m as f64 });
        let dense = |c: &[Cubic]| (0..=48 * m).map(|k| point(c, k)).collect::<Vec<_>>();
        let minima = sampled_minima(&dense(&a), &dense(&b), 1, 0.6);
        for (s, t, d) in minima {
            total += 1;
            let near = |x: &&&Site| {
                let (u, v) = ((x.segment_a as f64 + x.u_a) * m as f64, (x.segment_b as f64 + x.u_b) * m as f64);
                (u - s).abs().max((v - t).abs()) < 12.0 && x.gap + 0.2 <= d + 1e-12
            };
            assert!(
                sites.iter().any(|x| near(&x)),
                "case {case}: no site for the minimum at {} {}: {d}",
                s / m as f64,
                t / m as f64
            );
        }
        for x in &sites {
            let at = |c: &[Cubic], y: f64| {
                let s = (y.max(0.0) as usize).min(47);
                c[s].point((y.clamp(0.0, 48.0)) - s as f64)
            };
            let (u, v) = (x.segment_a as f64 + x.u_a, x.segment_b as f64 + x.u_b);
            for k in 0..16 {
                let (sin, cos) = (PI / 8.0 * f64::from(k)).sin_cos();
                let d = (at(&a, u + 1e-4 * cos) - at(&b, v + 1e-4 * sin)).norm();
                assert!(d >= x.gap + 0.2 - 1e-11, "case {case}: {x:?} is no minimum");
            }
            let twins = sites.iter().filter(|y| (x.arc_a - y.arc_a).abs() + (x.arc_b - y.arc_b).abs() < 1e-7).count();
            assert_eq!(twins, 1, "case {case}: {x:?} twice");
        }
    }
    assert!(total > 50, "{total}");
}

#[test]
fn stated_answers_of_special_cases() {
    let v = Vec3::new;
    let opts = options(0.3, Neighbours::Turning);
    let two = |a: &[Vec3], b: &[Vec3]| detect(&[Curve::polyline(a, 0.1), Curve::polyline(b, 0.1)], opts).unwrap();
    // Parallel: one flat site in the middle of the overlap, the zones tell its length (and the caps).
    let c = two(&[v(0., 0., 0.), v(4., 0., 0.)], &[v(1., 0.4, 0.), v(7., 0.4, 0.)]);
    assert_eq!(c.sites.len(), 1);
    let s = &c.sites[0];
    assert!(s.flat && (s.arc_a - 2.5).abs() < 1e-14 && (s.arc_b - 1.5).abs() < 1e-14 && (s.gap - 0.2).abs() < 1e-14);
    assert!((s.normal - Vec3::y()).norm() < 1e-15 && s.angle == 0.0 && s.kind == SiteLocation::Interior);
    assert_eq!(c.zones.len(), 2);
    assert!((c.zones[0].arc[0] - 0.7).abs() < 1e-12 && (c.zones[0].arc[1] - 4.0).abs() < 1e-12, "{:?}", c.zones);
    assert!(c.zones[0].partner_arc[0].abs() < 1e-12 && (c.zones[0].partner_arc[1] - 3.0).abs() < 1e-12);
    // Coincident: overlap by the whole diameter, no normal.
    let line = [v(0., 0., 0.), v(1., 0., 0.)];
    let c = two(&line, &line);
    assert!(c.sites.len() == 1 && c.sites[0].flat && c.sites[0].gap == -0.2 && c.sites[0].normal == Vec3::zeros());
    // Crossing centrelines: not flat, no normal, right angle.
    let c = two(&line, &[v(0.5, -1., 0.), v(0.5, 1., 0.)]);
    assert!(c.sites.len() == 1 && !c.sites[0].flat && c.sites[0].normal == Vec3::zeros());
    assert!((c.sites[0].angle - PI / 2.0).abs() < 1e-15);
    // End to end, and end against the inside.
    let c = two(&line, &[v(1.3, 0., 0.), v(2., 0., 0.)]);
    assert!(c.sites.len() == 1 && c.sites[0].kind == SiteLocation::End && (c.sites[0].gap - 0.1).abs() < 1e-15);
    let c = two(&line, &[v(0.5, 0.4, 0.), v(0.5, 2., 0.)]);
    assert!(
        c.sites.len() == 1 && c.sites[0].kind == SiteLocation::End && c.sites[0].u_a == 0.5 && c.sites[0].u_b == 0.0
    );
    // A kink that points at a line; one that points away has none of its own.
    let c = two(&[v(-2., 0., 0.), v(2., 0., 0.)], &[v(-1., 1.3, 0.), v(0., 0.3, 0.), v(1., 1.3, 0.)]);
    assert!(
        c.sites.len() == 1
            && c.sites[0].kind == SiteLocation::Interior
            && c.sites[0].u_b == 0.0
            && c.sites[0].segment_b == 1
    );
    // Nearly closed ring: its ends are a site; closed, it has none.
    let ring = |n: usize, span: f64| {
        (0..=n)
            .map(|k| {
                let (s, c) = (span * k as f64 / n as f64).sin_cos();
                v(c, s, 0.)
            })
            .collect::<Vec<_>>()
    };
    let open = ring(60, 2.0 * PI - 0.05);
    let c = detect(&[Curve::polyline(&open, 0.01)], options(0.1, Neighbours::Turning)).unwrap();
    assert!(
        c.sites.len() == 1 && c.sites[0].kind == SiteLocation::End && c.sites[0].u_a == 0.0 && c.sites[0].u_b == 1.0,
        "{:?}",
        c.sites
    );
    let closed = ring(60, 2.0 * PI);
    let c = detect(&[Curve::polyline(&closed[..60], 0.01).closed()], options(0.1, Neighbours::Turning)).unwrap();
    assert!(c.sites.is_empty() && c.zones.is_empty());
    // Tangent circles touch once; repeated control points are legal.
    let circle = |centre: Vec3, n: usize| -> Vec<Cubic> {
        let h = 2.0 * PI / n as f64;
        let at = |k: usize| {
            let (s, c) = (h * k as f64 + 0.1).sin_cos();
            (centre + v(c, s, 0.), v(-s, c, 0.) * h)
        };
        (0..n).map(|k| Cubic::from_hermite(at(k).0, at(k).1, at((k + 1) % n).0, at((k + 1) % n).1)).collect()
    };
    let (x, y) = (circle(Vec3::zeros(), 16), circle(v(2.25, 0., 0.), 16));
    let set = [Curve::cubics(&x, 0.1).closed(), Curve::cubics(&y, 0.1).closed()];
    let c = detect(&set, options(0.1, Neighbours::Turning)).unwrap();
    assert!(c.sites.len() == 1 && (c.sites[0].gap - 0.05).abs() < 1e-4, "{:?}", c.sites);
    let repeated = [Cubic { b: [v(0., 0., 0.), v(0., 0., 0.), v(1., 0., 0.), v(1., 0., 0.)] }];
    let across = [v(0.3, -1., 0.2), v(0.3, 1., 0.2)];
    let c = detect(&[Curve::cubics(&repeated, 0.1), Curve::polyline(&across, 0.1)], opts).unwrap();
    assert!(c.sites.len() == 1 && c.sites[0].gap.abs() < 1e-14, "{:?}", c.sites);
    // Nothing at all.
    assert_eq!(detect(&[], opts).unwrap(), Contacts::default());
}

/// Coaxial helices opposite each other: one long zone seen from each side, flat or shallow sites along it.
#[test]
fn a_contact_line_is_one_zone() {
    let (a, b) = (helix(80, 4.0, 0.0, 1.0), helix(80, 4.0, PI, 1.0));
    let c = detect(&[Curve::cubics(&a, 0.7), Curve::cubics(&b, 0.7)], options(0.0, Neighbours::Turning)).unwrap();
    let across: Vec<_> = c.zones.iter().filter(|z| z.curve != z.partner).collect();
    assert!(!across.is_empty() && !c.sites.is_empty(), "{} zones, {} sites", across.len(), c.sites.len());
    let whole = across.iter().map(|z| z.arc[1] - z.arc[0]).fold(0.0, f64::max);
    assert!(whole > 20.0, "{across:?}");
}
