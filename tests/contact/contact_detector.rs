//! The detector against brute force, independent counts, threads, motions, special cases and bad input.

use std::f64::consts::PI;

use supercoil::InputError;
use supercoil::contact::Cubic;
use supercoil::contact::Want;
use supercoil::contact::{Contacts, Curve, Detector, DetectorOptions, Neighbours, detect};
use supercoil::internals::capsule::segment_distance;
use supercoil::internals::steps::DetectorStep;
use supercoil::math::{Mat3, Quat, Vec3};

use crate::inputs;
use inputs::Kind;

use crate::random;
use random::Random;

use crate::smooth_curves;
use smooth_curves::helix;

fn options(range: f64, neighbours: Neighbours) -> DetectorOptions {
    DetectorOptions { range, neighbours, ..DetectorOptions::default() }
}

/// Random walks, some closed, some flat, some on a lattice (exactly parallel and coincident segments).
fn walks(rng: &mut Random, count: usize, n: usize) -> Vec<(Vec<Vec3>, bool)> {
    (0..count)
        .map(|c| {
            let mut p = rng.vector() * 2.0;
            if c % 4 == 3 {
                p = p.map(f64::round);
            }
            let mut points = vec![p];
            while points.len() < n {
                let mut step = rng.vector();
                match c % 4 {
                    1 => step.z = 0.0,
                    3 => {
                        let axis = (rng.unit() * 3.0 + 3.0) as usize % 3;
                        let sign = rng.unit().signum();
                        step = Vec3::zeros();
                        step[axis] = sign;
                    }
                    _ => {}
                }
                let last = points[points.len() - 1];
                let next = (last + step).map(|x| x.clamp(-3.0, 3.0));
                if next != last && next != points[0] {
                    points.push(next);
                }
            }
            (points, c % 2 == 0)
        })
        .collect()
}

fn curves(walks: &[(Vec<Vec3>, bool)], radius: f64) -> Vec<Curve<'_>> {
    walks.iter().map(|(p, closed)| Curve { closed: *closed, ..Curve::polyline(p, radius) }).collect()
}

/// Brute force over all pairs of segments: candidates must hold all pairs in range and none beyond; returns how many
/// pairs were tried.
fn candidates_are_exact(seed: u64, cases: usize) -> usize {
    let mut rng = Random(seed);
    let mut tried = 0;
    let mut near = 0;
    for case in 0..cases {
        let unit = [1.0, 1e-12, 1e12][case % 3];
        let offset = rng.vector() * if case % 2 == 0 { 0.0 } else { 1e6 * 0.05 * unit };
        let mut list = walks(&mut rng, 2 + case % 14, 40);
        for (points, _) in &mut list {
            points.iter_mut().for_each(|p| *p = *p * unit + offset);
        }
        let (radius, range) = (0.05 * unit, 0.1 * unit);
        let set = curves(&list, radius);
        let mut detector = Detector::new(options(range, Neighbours::Segments(1)));
        if detector.detect(&set).is_err() {
            // The offset may have merged two lattice points; refused by name.
            continue;
        }
        let segments: Vec<(usize, usize, Vec3, Vec3)> = list
            .iter()
            .enumerate()
            .flat_map(|(c, (p, closed))| {
                let n = if *closed { p.len() } else { p.len() - 1 };
                (0..n).map(move |k| (c, k, p[k], p[(k + 1) % p.len()]))
            })
            .collect();
        for i in 0..segments.len() {
            for j in i + 1..segments.len() {
                tried += 1;
                let (a, b) = (&segments[i], &segments[j]);
                let count = if list[a.0].1 { 40 } else { usize::MAX };
                let neighbours = a.0 == b.0 && (b.1 - a.1 <= 1 || count - (b.1 - a.1) <= 1);
                let d = segment_distance(&a.2, &a.3, &b.2, &b.3);
                let listed = detector.candidates().binary_search(&[i as u32, j as u32]).is_ok();
                let limit = 2.0 * radius + range;
                near += usize::from(d <= limit && !neighbours);
                assert!(!(neighbours && listed), "case {case}: neighbours {i} {j}");
                assert!(neighbours || listed || d > limit * (1.0 - 1e-12), "case {case}: {i} {j} missed at {d:e}");
                assert!(!listed || d <= limit * (1.0 + 1e-3), "case {case}: {i} {j} invented at {d:e}");
            }
        }
    }
    assert!(near > tried / 200, "{near} of {tried} pairs near");
    tried
}

#[test]
fn candidates_match_brute_force() {
    let tried = candidates_are_exact(1, 6);
    assert!(tried >= 100_000, "{tried}");
}

#[test]
#[ignore = "slow: a million pairs and more"]
fn candidates_match_brute_force_at_length() {
    let tried = candidates_are_exact(2, 60);
    assert!(tried >= 1_000_000, "{tried}");
}

/// Counts of an independent program, 1e4 segments: overlapping boxes, close chords, close chords that are not
/// neighbours.
#[test]
fn reference_counts() {
    for kind in Kind::ALL {
        let points = kind.points(10_000);
        let curve = [Curve::polyline(&points, 1.0)];
        let mut detector = Detector::new(options(0.0, Neighbours::Segments(1)));
        for stage in [DetectorStep::Prepare, DetectorStep::Refit, DetectorStep::Boxes] {
            detector.run_stage(&curve, stage).unwrap();
        }
        let bounds = |i: usize| {
            let (a, b) = (&points[i], &points[i + 1]);
            (a.inf(b) - Vec3::repeat(1.0), a.sup(b) + Vec3::repeat(1.0))
        };
        let mut counts = [0; 3];
        let mut wanted = Vec::new();
        for &[i, j] in detector.candidates() {
            let (a, b) = (bounds(i as usize), bounds(j as usize));
            if (0..3).all(|k| a.0[k] <= b.1[k] && b.0[k] <= a.1[k]) {
                counts[0] += 1;
                let (i, j) = (i as usize, j as usize);
                if segment_distance(&points[i], &points[i + 1], &points[j], &points[j + 1]) < 2.0 {
                    counts[1] += 1;
                    if j - i > inputs::neighbours(&points) {
                        counts[2] += 1;
                        wanted.push([i as u32, j as u32]);
                    }
                }
            }
        }
        assert_eq!(Some(counts), kind.reference(10_000), "{}", kind.name());
        // The list after the capsule test holds these and hardly more.
        let neighbours = Neighbours::Segments(inputs::neighbours(&points));
        let mut detector = Detector::new(options(0.0, neighbours));
        detector.detect(&curve).unwrap();
        let list = detector.candidates();
        assert!(wanted.iter().all(|p| list.binary_search(p).is_ok()));
        assert!(list.len() <= wanted.len() + wanted.len() / 1000 + 1);
    }
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let packed = Kind::Packed.points(10_000);
    let plecto = Kind::Plectocoil.points(10_000);
    let helices = [helix(200, 10.0, 0.0, 2.0), helix(200, 10.0, PI, 2.0)];
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let set = [
                Curve::polyline(&packed, 1.0),
                Curve::polyline(&plecto, 1.0),
                Curve::cubics(&helices[0], 0.9),
                Curve::cubics(&helices[1], 0.9),
            ];
            let mut detector = Detector::new(options(0.1, Neighbours::Turning));
            let forces = detector.forces(&set, 1.0).unwrap().clone();
            (detector.detect(&set).unwrap().clone(), forces)
        })
    };
    let one = run(1);
    assert!(one.0.sites.len() > 10_000 && one.0.zones.len() > 1000 && one.1.energy > 100.0, "{}", one.1.energy);
    assert!(one == run(2) && one == run(4));
}

/// A detector that is used again, with a margin or without, finds what a new one finds.
#[test]
fn kept_buffers_change_nothing() {
    let mut points = Kind::Packed.points(2000);
    let mut kept = Detector::new(options(0.1, Neighbours::Turning));
    let mut lazy = Detector::new(DetectorOptions { margin: 0.5, ..options(0.1, Neighbours::Turning) });
    for _ in 0..6 {
        let curve = [Curve::polyline(&points, 1.0)];
        let fresh = detect(&curve, options(0.1, Neighbours::Turning)).unwrap();
        assert_eq!(*kept.detect(&curve).unwrap(), fresh);
        assert_eq!(*lazy.detect(&curve).unwrap(), fresh);
        for p in &mut points {
            *p += Vec3::new((0.1 * p.y).sin(), (0.1 * p.z).sin(), (0.1 * p.x).sin()) * 0.1;
        }
    }
}

fn assert_same(a: &Contacts, b: &Contacts, unit: f64, what: &str) {
    let isolated = |c: &Contacts| c.sites.iter().filter(|s| !s.flat).copied().collect::<Vec<_>>();
    let (a, b) = (isolated(a), isolated(b));
    assert_eq!(a.len(), b.len(), "{what}");
    for (x, y) in a.iter().zip(&b) {
        assert_eq!((x.curve_a, x.curve_b, x.kind), (y.curve_a, y.curve_b, y.kind), "{what}");
        assert!((x.gap - y.gap / unit).abs() < 1e-8 && (x.arc_a - y.arc_a / unit).abs() < 1e-5, "{what}: {x:?} {y:?}");
        assert!((x.angle - y.angle).abs() < 1e-6, "{what}");
    }
}

#[test]
fn same_sites_under_motion_unit_reversal_and_swap() {
    let a = Kind::Packed.points(1500);
    let b: Vec<Vec3> = Kind::Wlc.points(1500).iter().map(|p| p * 0.2).collect();
    let opts = options(0.2, Neighbours::Segments(4));
    let find = |a: &[Vec3], b: &[Vec3], unit: f64| {
        let set = [Curve::polyline(a, unit), Curve::polyline(b, unit)];
        detect(&set, DetectorOptions { range: 0.2 * unit, ..opts }).unwrap()
    };
    let base = find(&a, &b, 1.0);
    assert!(base.sites.len() > 100, "{}", base.sites.len());
    let rotation = *Quat::from_euler_angles(0.3, -1.1, 2.0).to_rotation_matrix().matrix();
    let moved =
        |p: &[Vec3], m: Mat3, unit: f64, shift: Vec3| p.iter().map(|x| m * x * unit + shift).collect::<Vec<_>>();
    for (what, unit, shift) in [
        ("motion", 1.0, Vec3::new(3.0, -7.0, 11.0)),
        ("tiny", 1e-12, Vec3::zeros()),
        ("huge", 1e12, Vec3::zeros()),
        ("far", 1.0, Vec3::repeat(1e6)),
    ] {
        let (x, y) = (moved(&a, rotation, unit, shift), moved(&b, rotation, unit, shift));
        assert_same(&base, &find(&x, &y, unit), unit, what);
    }
    // Swap and reversal: the same set of gaps, normals turned round where a and b change places.
    let gaps = |c: &Contacts| {
        let mut g: Vec<f64> = c.sites.iter().map(|s| s.gap).collect();
        g.sort_by(f64::total_cmp);
        g
    };
    let same = |x: &[f64], y: &[f64]| x.len() == y.len() && x.iter().zip(y).all(|(p, q)| (p - q).abs() < 1e-9);
    assert!(same(&gaps(&base), &gaps(&find(&b, &a, 1.0))));
    let reversed: Vec<Vec3> = a.iter().rev().copied().collect();
    assert!(same(&gaps(&base), &gaps(&find(&reversed, &b, 1.0))));
}

#[test]
fn bad_input_is_an_error_by_name() {
    let v = Vec3::new;
    let good = [v(0., 0., 0.), v(1., 0., 0.), v(2., 0., 0.)];
    let refused = |bad: Curve, words: &str| {
        let error = detect(&[Curve::polyline(&good, 1.0), bad], DetectorOptions::default()).unwrap_err().to_string();
        assert!(error.contains("curves[1]") && error.contains(words), "{error}");
    };
    refused(Curve::polyline(&[], 1.0), "points");
    refused(Curve::polyline(&good[..1], 1.0), "points");
    refused(Curve::polyline(&good[..2], 1.0).closed(), "points");
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut points = good;
        points[1].y = bad;
        refused(Curve::polyline(&points, 1.0), "points[1]");
        refused(Curve::polyline(&good, bad), "radius");
        let mut cubic = Cubic::straight(good[0], good[1]);
        cubic.b[2].z = bad;
        refused(Curve::cubics(&[cubic], 1.0), "pieces[0].b[2]");
    }
    refused(Curve::polyline(&good, 0.0), "radius");
    refused(Curve::polyline(&[good[0], good[0], good[1]], 1.0), "points[1]");
    refused(Curve::cubics(&[], 1.0), "pieces");
    refused(Curve::cubics(&[Cubic::straight(good[0], good[0])], 1.0), "pieces[0]");
    refused(Curve::cubics(&[Cubic::straight(good[0], good[1]), Cubic::straight(good[0], good[2])], 1.0), "pieces[0]");
    let hairpin = Cubic { b: [v(0., 0., 0.), v(1., 0., 0.), v(1., 1., 0.), v(0., 1., 0.)] };
    refused(Curve::cubics(&[hairpin], 1.0), "pieces[0]");
    for options in [
        DetectorOptions { range: f64::NAN, ..DetectorOptions::default() },
        DetectorOptions { margin: -1.0, ..DetectorOptions::default() },
        DetectorOptions { sampling: 0, ..DetectorOptions::default() },
    ] {
        let error: InputError = detect(&[Curve::polyline(&good, 1.0)], options).unwrap_err();
        assert!(["range", "margin", "sampling"].iter().any(|n| error.to_string().contains(n)));
    }
}

/// Forces of the stepper's terms: the energy's slope by finite differences, and no net force or moment.
#[test]
fn terms_are_the_slope_of_the_energy() {
    let a: Vec<Vec3> = (0..6).map(|k| Vec3::new(f64::from(k) - 2.5, 0.02 * f64::from(k * k), 0.0)).collect();
    let b: Vec<Vec3> = (0..6).map(|k| Vec3::new(0.1, f64::from(k) - 2.6, 0.3 + 0.01 * f64::from(k))).collect();
    let mut detector = Detector::new(DetectorOptions::default());
    let mut energy = |a: &[Vec3], b: &[Vec3]| -> (f64, Vec<Vec3>) {
        let terms = detector.terms(&[Curve::polyline(a, 0.2), Curve::polyline(b, 0.2)], 50.0, Want::Gradient).unwrap();
        let mut force = vec![Vec3::zeros(); 12];
        for t in &terms {
            let node = |s: usize| if s < 5 { s } else { s + 1 };
            let g = t.point_gradient();
            for (k, n) in [node(t.slave), node(t.slave) + 1, node(t.master), node(t.master) + 1].into_iter().enumerate()
            {
                force[n] -= g[k];
            }
        }
        (terms.iter().map(|t| t.energy).sum(), force)
    };
    let (u, force) = energy(&a, &b);
    assert!(u > 0.0);
    assert!(force.iter().sum::<Vec3>().norm() < 1e-12);
    let moment: Vec3 = a.iter().chain(&b).zip(&force).map(|(x, f)| x.cross(f)).sum();
    assert!(moment.norm() < 1e-12);
    for k in 0..6 {
        for axis in 0..3 {
            let mut at = |h: f64| {
                let mut a = a.clone();
                a[k][axis] += h;
                energy(&a, &b).0
            };
            let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
            // Reference lengths follow the polyline's edges: a small term besides the gap's.
            assert!(
                (slope + force[k][axis]).abs() < 0.05 * (1.0 + force[k].norm()),
                "{k} {axis}: {slope} {}",
                force[k][axis]
            );
        }
    }
}

/// Forces are the sums of the terms: polylines, closed too, cubics and radii per segment, all among each other; in
/// equilibrium with themselves; the same from a detector in use and whatever its range.
#[test]
fn forces_are_the_sums_of_terms() {
    let line = |k: usize, turns: f64| {
        let t = k as f64 / 60.0;
        let (s, c) = (turns * t).sin_cos();
        Vec3::new(c * 2.2, s * 2.2, 4.0 * t - 2.0)
    };
    let ring: Vec<Vec3> =
        (0..30).map(|k| f64::from(k) * PI / 15.0).map(|t| Vec3::new(t.cos(), 0.1, t.sin()) * 2.0).collect();
    let strand: Vec<Vec3> = (0..=60).map(|k| line(k, 7.0)).collect();
    let other: Vec<Vec3> = (0..=60).map(|k| line(k, 7.2)).collect();
    let pieces = helix(40, 2.0, 0.3, 1.0);
    let radii: Vec<f64> = (0..60).map(|k| 0.3 + 0.002 * f64::from(k)).collect();
    let curves = [
        Curve::polyline(&ring, 0.35).closed(),
        Curve::polyline(&strand, &radii),
        Curve::polyline(&other, 0.3),
        Curve::cubics(&pieces, 0.3),
    ];
    let first = [0, 30, 90, 150];
    let mut detector = Detector::new(options(0.0, Neighbours::Turning));
    let terms = detector.terms(&curves, 5.0, Want::Gradient).unwrap();
    let mut expected =
        vec![vec![Vec3::zeros(); 30], vec![Vec3::zeros(); 61], vec![Vec3::zeros(); 61], vec![Vec3::zeros(); 160]];
    let (mut energy, mut kinds) = (0.0, std::collections::BTreeSet::new());
    for term in &terms {
        energy += term.energy;
        let place = |segment: usize| {
            let curve = (0..4).rev().find(|&c| first[c] <= segment).unwrap();
            (curve, segment - first[curve])
        };
        let points = term.point_gradient();
        for (side, segment) in [term.slave, term.master].into_iter().enumerate() {
            let (curve, k) = place(segment);
            let sums = &mut expected[curve];
            if curve == 3 {
                (0..4).for_each(|m| sums[4 * k + m] -= term.gradient[4 * side + m]);
            } else {
                let next = (k + 1) % sums.len();
                sums[k] -= points[2 * side];
                sums[next] -= points[2 * side + 1];
            }
        }
        kinds.insert([place(term.slave).0, place(term.master).0]);
    }
    assert!(kinds.len() >= 8, "{kinds:?}");
    let scale = expected.iter().flatten().map(Vec3::norm).fold(0.0, f64::max);
    for range in [0.0, 0.0, 0.3, -0.2] {
        detector.options_mut().range = range;
        let found = detector.forces(&curves, 5.0).unwrap();
        assert!((found.energy - energy).abs() < 1e-12 * energy, "{} {energy}", found.energy);
        for (ours, sums) in found.forces.iter().zip(&expected) {
            assert_eq!(ours.len(), sums.len());
            assert!(ours.iter().zip(sums).all(|(f, g)| (f - g).norm() < 1e-12 * scale));
        }
        let net: Vec3 = found.forces.iter().flatten().sum();
        assert!(net.norm() < 1e-11 * scale, "{net}");
        let deepest = terms.iter().flat_map(|t| &t.zones).map(|z| z.min_gap).fold(f64::INFINITY, f64::min);
        assert!((found.min_gap - deepest).abs() < 1e-14);
    }
    let apart = [Curve::polyline(&ring, 1e-3).closed()];
    let none = detector.forces(&apart, 5.0).unwrap();
    assert_eq!((none.energy, none.min_gap, none.forces.len()), (0.0, f64::INFINITY, 1));
    assert!(none.forces[0].len() == 30 && none.forces[0].iter().all(|f| *f == Vec3::zeros()));
}

/// Where centrelines coincide there is energy, but no direction: forces and Hessians stay finite and in balance, for
/// lines and for cubics.
#[test]
fn crossing_centrelines_have_finite_forces() {
    let line = |d: Vec3| [-d, d];
    let (a, crossing, along) = (line(Vec3::x()), line(Vec3::y()), [Vec3::x() * -0.3, Vec3::x() * 1.3]);
    for other in [crossing, along] {
        let cubics = [a, other].map(|p| [Cubic::straight(p[0], p[1])]);
        let lines = [Curve::polyline(&a, 0.2), Curve::polyline(&other, 0.2)];
        for curves in [lines, [Curve::cubics(&cubics[0], 0.2), Curve::cubics(&cubics[1], 0.2)]] {
            let mut detector = Detector::new(options(0.0, Neighbours::Turning));
            let found = detector.forces(&curves, 1.0).unwrap();
            assert!(found.energy > 0.0 && found.energy.is_finite() && (found.min_gap + 0.4).abs() < 1e-12, "{found:?}");
            assert!(found.forces.iter().flatten().sum::<Vec3>().norm() < 1e-12, "{found:?}");
            for term in detector.terms(&curves, 1.0, Want::Hessian).unwrap() {
                let hessian = term.hessian.unwrap();
                assert!((0..8).all(|m| (m..8).all(|n| hessian[m][n].iter().all(|x| x.is_finite()))));
            }
        }
    }
}

/// Far from the origin terms and zones are those at the origin, if the shift itself rounds nothing: pairs are looked at
/// in coordinates of their own. (In global ones the ends of zones drowned in rounding, and were looked for until the
/// iterations ran out.)
#[test]
fn terms_and_zones_do_not_know_the_origin() {
    let exact = |c: &[Cubic]| -> Vec<Cubic> {
        c.iter().map(|c| Cubic { b: c.b.map(|p| p.map(|x| (x * 1048576.0).round() / 1048576.0)) }).collect()
    };
    let (a, b) = (exact(&helix(40, 2.0, 0.0, 2.0)), exact(&helix(40, 2.0, 2.9, 2.0)));
    let far = |c: &[Cubic]| -> Vec<Cubic> {
        c.iter().map(|c| Cubic { b: c.b.map(|p| p + Vec3::new(131072.0, -262144.0, 65536.0)) }).collect()
    };
    let find = |a: &[Cubic], b: &[Cubic]| {
        let curves = [Curve::cubics(a, 1.2), Curve::cubics(b, 1.2)];
        let mut detector = Detector::new(options(0.0, Neighbours::Turning));
        let terms = detector.terms(&curves, 1.0, Want::Gradient).unwrap();
        (terms, detector.detect(&curves).unwrap().zones.clone())
    };
    let ((near, near_zones), (moved, moved_zones)) = (find(&a, &b), find(&far(&a), &far(&b)));
    assert!(near.len() == moved.len() && near.len() > 50, "{} {}", near.len(), moved.len());
    for (x, y) in near.iter().zip(&moved) {
        assert_eq!((x.slave, x.master), (y.slave, y.master));
        assert!((x.energy - y.energy).abs() <= 1e-13 * x.energy.abs(), "{} {}", x.energy, y.energy);
        assert!(x.gradient.iter().zip(&y.gradient).all(|(p, q)| (p - q).norm() <= 1e-13), "{x:?} {y:?}");
    }
    assert!(near_zones.len() == moved_zones.len() && !near_zones.is_empty());
    for (x, y) in near_zones.iter().zip(&moved_zones) {
        assert!((x.arc[0] - y.arc[0]).abs() + (x.arc[1] - y.arc[1]).abs() < 1e-12, "{x:?} {y:?}");
    }
}

/// The memory that the documents state: 130 bytes a segment, 8 a pair of the list and 32 to look for its site, in lists
/// that have grown by a half at most.
#[test]
fn memory_is_what_is_stated() {
    for kind in Kind::ALL {
        let points = kind.points(100_000);
        let mut detector = Detector::new(DetectorOptions { zones: false, ..DetectorOptions::default() });
        let sites = detector.detect(&[Curve::polyline(&points, 1.0)]).unwrap().sites.len();
        let (held, found) = detector.memory();
        let pairs = detector.candidates().len();
        println!("{}: {held} bytes, {pairs} pairs; {found} bytes, {sites} sites", kind.name());
        assert!(held < 130 * 100_000 + 60 * pairs, "{}: {held}", kind.name());
        assert!(found <= 112 * (sites + sites / 2), "{}: {found}", kind.name());
    }
}
