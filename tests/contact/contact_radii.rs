//! A radius per segment: candidates, sites, zones, clearance and forces against brute force and against equal radii.

use supercoil::contact::Cubic;
use supercoil::contact::Want;
use supercoil::contact::{Curve, Detector, DetectorOptions, Neighbours, Radius, detect};
use supercoil::internals::capsule::segment_distance;
use supercoil::math::Vec3;

use crate::random;
use random::Random;

const RANGE: f64 = 0.05;

fn options() -> DetectorOptions {
    DetectorOptions { range: RANGE, neighbours: Neighbours::Segments(1), ..DetectorOptions::default() }
}

struct Line {
    points: Vec<Vec3>,
    radii: Vec<f64>,
    closed: bool,
}

/// Random walks in a small box, radii over two decades.
fn lines(rng: &mut Random, count: usize, n: usize) -> Vec<Line> {
    (0..count)
        .map(|c| {
            let closed = c % 2 == 1;
            let mut points = vec![rng.vector() * 2.0];
            while points.len() < n {
                let next = (points[points.len() - 1] + rng.vector() * 0.7).map(|x| x.clamp(-2.0, 2.0));
                points.push(next);
            }
            let segments = if closed { n } else { n - 1 };
            let radii = (0..segments).map(|_| 10f64.powf(rng.between(-2.5, -0.5))).collect();
            Line { points, radii, closed }
        })
        .collect()
}

impl Line {
    fn curve(&self) -> Curve<'_> {
        Curve { closed: self.closed, ..Curve::polyline(&self.points, &self.radii) }
    }
    fn ends(&self, k: usize) -> (Vec3, Vec3) {
        (self.points[k], self.points[(k + 1) % self.points.len()])
    }
    /// Radius at a parameter, the larger at joints.
    fn at(&self, k: usize, u: f64) -> f64 {
        let n = self.radii.len();
        let before = if k > 0 { Some(k - 1) } else { self.closed.then_some(n - 1) };
        let after = if k + 1 < n { Some(k + 1) } else { self.closed.then_some(0) };
        let other = if u == 0.0 {
            before
        } else if u == 1.0 {
            after
        } else {
            None
        };
        other.map_or(self.radii[k], |o| self.radii[k].max(self.radii[o]))
    }
}

/// (line, segment) of every segment in the common numbering.
fn places(set: &[Line]) -> Vec<(usize, usize)> {
    set.iter().enumerate().flat_map(|(c, l)| (0..l.radii.len()).map(move |k| (c, k))).collect()
}

fn distance(set: &[Line], a: (usize, usize), b: (usize, usize)) -> f64 {
    let ((p0, p1), (q0, q1)) = (set[a.0].ends(a.1), set[b.0].ends(b.1));
    segment_distance(&p0, &p1, &q0, &q1)
}

#[test]
fn candidates_match_brute_force() {
    let mut rng = Random(3);
    let (mut tried, mut near) = (0, 0);
    for case in 0..6 {
        let set = lines(&mut rng, 2 + case, 40);
        let curves: Vec<Curve> = set.iter().map(Line::curve).collect();
        let mut detector = Detector::new(options());
        detector.detect(&curves).unwrap();
        let places = places(&set);
        for i in 0..places.len() {
            for j in i + 1..places.len() {
                let (a, b) = (places[i], places[j]);
                let round = if set[a.0].closed { set[a.0].radii.len() } else { usize::MAX };
                let neighbours = a.0 == b.0 && (b.1 - a.1 <= 1 || round - (b.1 - a.1) <= 1);
                let d = distance(&set, a, b);
                let listed = detector.candidates().binary_search(&[i as u32, j as u32]).is_ok();
                let least = set[a.0].radii[a.1] + set[b.0].radii[b.1] + RANGE;
                let thickest = |p: (usize, usize)| set[p.0].at(p.1, 0.0).max(set[p.0].at(p.1, 1.0));
                let most = thickest(a) + thickest(b) + RANGE;
                assert!(neighbours || listed || d > least * (1.0 - 1e-12), "{case}: {a:?} {b:?} missed at {d}");
                assert!(!listed || (!neighbours && d <= most * (1.0 + 1e-3)), "{case}: {a:?} {b:?} invented at {d}");
                tried += 1;
                near += usize::from(d <= least && !neighbours);
            }
        }
    }
    assert!(tried > 50_000 && near > 300, "{tried} {near}");
}

/// The minima of the distance do not depend on radii: with one thick radius for all they are the same points, of which
/// those within both local radii + range must be told.
#[test]
fn sites_are_the_minima_within_their_own_radii() {
    let mut rng = Random(11);
    let (mut found, mut dropped, mut stepped) = (0, 0, 0);
    for case in 0..10 {
        let set = lines(&mut rng, 2 + case % 4, 40);
        let thick = 0.4;
        let uniform: Vec<Curve> = set.iter().map(|l| Curve { radius: Radius::Constant(thick), ..l.curve() }).collect();
        let all = detect(&uniform, options()).unwrap().sites;
        let expected: Vec<_> = all
            .iter()
            .map(|s| {
                let radii = [(s.curve_a, s.segment_a, s.u_a), (s.curve_b, s.segment_b, s.u_b)];
                let sum: f64 = radii.iter().map(|&(c, k, u)| set[c].at(k, u)).sum();
                let own: f64 = radii.iter().map(|&(c, k, _)| set[c].radii[k]).sum();
                stepped += usize::from(own < sum && s.gap + 2.0 * thick - sum <= RANGE);
                (s, s.gap + 2.0 * thick - sum)
            })
            .filter(|(_, gap)| *gap <= RANGE)
            .collect();
        let curves: Vec<Curve> = set.iter().map(Line::curve).collect();
        let sites = detect(&curves, options()).unwrap().sites;
        assert_eq!(sites.len(), expected.len(), "{case}");
        for (s, (t, gap)) in sites.iter().zip(&expected) {
            let place = |s: &supercoil::contact::Site| (s.curve_a, s.segment_a, s.u_a, s.curve_b, s.segment_b, s.u_b);
            assert_eq!(place(s), place(t));
            assert!((s.gap - gap).abs() < 1e-14);
        }
        found += sites.len();
        dropped += all.len() - sites.len();
    }
    assert!(found > 100 && dropped > 100 && stepped > 5, "{found} {dropped} {stepped}");
}

/// A point of one curve is in a zone exactly if some pair of segments brings it within both radii + range.
#[test]
fn zones_match_sampling() {
    let mut rng = Random(5);
    let (mut inside, mut outside) = (0, 0);
    for _ in 0..8 {
        let set = lines(&mut rng, 2, 30);
        let curves: Vec<Curve> = set.iter().map(Line::curve).collect();
        let zones = detect(&curves, options()).unwrap().zones;
        let mut arc = 0.0;
        for k in 0..set[0].radii.len() {
            let (p0, p1) = set[0].ends(k);
            for step in 0..50 {
                let u = (f64::from(step) + 0.37) / 50.0;
                let x = p0 + (p1 - p0) * u;
                let excess = (0..set[1].radii.len())
                    .map(|m| {
                        let (q0, q1) = set[1].ends(m);
                        segment_distance(&x, &x, &q0, &q1) - (set[0].radii[k] + set[1].radii[m] + RANGE)
                    })
                    .fold(f64::INFINITY, f64::min);
                let at = arc + u * (p1 - p0).norm();
                let told = zones.iter().any(|z| z.curve == 0 && z.partner == 1 && z.arc[0] <= at && at <= z.arc[1]);
                if excess.abs() > 1e-9 {
                    assert!(!told || excess < 0.0, "invented: {excess}");
                    inside += usize::from(told);
                    outside += usize::from(!told);
                    assert!(told || excess > 0.0, "missed: segment {k} u {u} excess {excess}");
                }
            }
            arc += (p1 - p0).norm();
        }
    }
    assert!(inside > 200 && outside > 1000, "{inside} {outside}");
}

#[test]
fn smallest_clearance_matches_brute_force() {
    let mut rng = Random(8);
    for _ in 0..12 {
        let mut set = lines(&mut rng, 2, 12);
        for p in &mut set[1].points {
            p.x += 4.5;
        }
        let curves: Vec<Curve> = set.iter().map(Line::curve).collect();
        let mut least = f64::INFINITY;
        for k in 0..set[0].radii.len() {
            for m in 0..set[1].radii.len() {
                least = least.min(distance(&set, (0, k), (1, m)) - set[0].radii[k] - set[1].radii[m]);
            }
        }
        let found = Detector::new(DetectorOptions { neighbours: Neighbours::Segments(100), ..options() })
            .smallest_clearance(&curves, 10.0, 1e-9)
            .unwrap()
            .unwrap();
        assert!(found.lower <= least + 1e-12 && least <= found.upper + 1e-12, "{found:?} {least}");
        assert!(found.upper - found.lower <= 1e-8);
    }
}

/// A list of equal radii is the same as one radius, bit for bit, for polylines and cubics, forces too; and the list is
/// kept only while radii stay.
#[test]
fn equal_radii_are_one_radius() {
    let mut rng = Random(21);
    let set = lines(&mut rng, 4, 60);
    let (radius, list) = (0.2, vec![0.2; 60]);
    let bend = |k: usize| {
        let at = |t: f64| (Vec3::new(t.cos(), t.sin(), 0.3 * t) * 1.5, Vec3::new(-t.sin(), t.cos(), 0.3) * 0.3);
        let (a, b) = (at(0.2 * k as f64), at(0.2 * (k + 1) as f64));
        Cubic::from_hermite(a.0, a.1, b.0, b.1)
    };
    let pieces: Vec<Cubic> = (0..40).map(bend).collect();
    let mut one: Vec<Curve> = set.iter().map(|l| Curve { radius: radius.into(), ..l.curve() }).collect();
    one.push(Curve::cubics(&pieces, radius));
    let mut many: Vec<Curve> =
        set.iter().map(|l| Curve { radius: list[..l.radii.len()].into(), ..l.curve() }).collect();
    many.push(Curve::cubics(&pieces, &list[..40]));
    let (a, b) = (detect(&one, options()).unwrap(), detect(&many, options()).unwrap());
    assert!(a.sites.len() > 50 && a.zones.len() > 50);
    assert_eq!(a, b);
    let energy = |curves: &[Curve]| -> Vec<f64> {
        let terms = Detector::new(options()).terms(curves, 10.0, Want::Gradient).unwrap();
        terms.iter().flat_map(|t| [t.energy, t.gradient[0].x, t.gradient[7].z]).collect()
    };
    assert!(!energy(&one).is_empty());
    assert_eq!(energy(&one), energy(&many));
    // Only the sum of two radii counts.
    let (thin, thick) = (vec![0.1; 60], vec![0.3; 60]);
    let beside: Vec<Vec3> = set[0].points.iter().map(|p| p + Vec3::new(0.1, 0.2, 0.25)).collect();
    let total = |a: &[f64], b: &[f64]| {
        let opts = DetectorOptions { neighbours: Neighbours::Segments(100), ..options() };
        let pair = [Curve::polyline(&set[0].points, &a[..59]), Curve::polyline(&beside, &b[..59])];
        let terms = Detector::new(opts).terms(&pair, 10.0, Want::Gradient).unwrap();
        terms.iter().map(|t| t.energy).sum::<f64>()
    };
    let (equal, unequal) = (total(&list, &list), total(&thin, &thick));
    assert!(equal > 0.0 && (equal / unequal - 1.0).abs() < 1e-12, "{equal} {unequal}");
    // A kept list must not outlive its radii.
    let mut detector = Detector::new(DetectorOptions { margin: 0.5, ..options() });
    let mut radii = vec![0.01; set[0].radii.len()];
    let mut count = |radii: &[f64]| {
        let curves =
            [Curve { radius: radii.into(), ..set[0].curve() }, Curve { radius: 0.01.into(), ..set[1].curve() }];
        let fresh = detect(&curves, options()).unwrap();
        assert_eq!(*detector.detect(&curves).unwrap(), fresh);
        fresh.sites.len()
    };
    let thin = count(&radii);
    radii.fill(0.5);
    assert!(count(&radii) > thin);
}

/// Two parallel lines 1 apart, one with a thick stretch: the zone is that stretch, the sites lie on it.
#[test]
fn a_thick_stretch_is_the_zone() {
    let line = |y: f64| (0..=10).map(|k| Vec3::new(f64::from(k), y, 0.0)).collect::<Vec<_>>();
    let (a, b) = (line(0.0), line(1.0));
    let mut radii = [0.3; 10];
    radii[4..6].fill(0.8);
    let c = detect(&[Curve::polyline(&a, &radii), Curve::polyline(&b, 0.3)], DetectorOptions::default()).unwrap();
    assert_eq!(c.zones.len(), 2);
    assert_eq!((c.zones[0].curve, c.zones[0].arc), (0, [4.0, 6.0]));
    assert!((c.zones[0].gap + 0.1).abs() < 1e-15);
    assert!(!c.sites.is_empty() && c.sites.iter().all(|s| s.arc_a >= 4.0 && s.arc_a <= 6.0 && s.flat));
}

#[test]
fn bad_radii_are_refused_by_name() {
    let points = [Vec3::zeros(), Vec3::x(), Vec3::x() * 2.0];
    for (radii, words) in [
        (vec![1.0], "radius = 1"),
        (vec![1.0; 3], "radius = 3"),
        (vec![1.0, 0.0], "radius[1]"),
        (vec![f64::NAN, 1.0], "radius[0]"),
        (vec![1.0, f64::INFINITY], "radius[1]"),
    ] {
        let error = detect(&[Curve::polyline(&points, &radii)], DetectorOptions::default()).unwrap_err().to_string();
        assert!(error.contains("curves[0]") && error.contains(words), "{error}");
    }
}
