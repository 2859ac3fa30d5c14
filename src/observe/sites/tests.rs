use super::*;
use crate::contact::curve::{Cubic, CurveInput};
use crate::contact::law::Law;
use crate::contact::potential::{PairTerm, Want, evaluate};
use crate::math::Vec3;
use crate::math::random::Random;

/// Two straight rods of radius 0.5 in segments of length 1, `b` at height `height`, turned by `degrees` about z.
fn straight(degrees: f64, height: f64) -> CurveSet {
    let along = |direction: Vec3, z: f64| -> Vec<Vec3> {
        (0..=6).map(|k| direction * (f64::from(k) - 3.2) + Vec3::z() * z).collect()
    };
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (a, b) = (along(Vec3::x(), 0.0), along(Vec3::new(cos, sin, 0.0), height));
    CurveSet::from_polylines(&[(&a, 0.5, false), (&b, 0.5, false)]).unwrap()
}

/// Curves of bending stiffness 1, with elements shorter than the layer.
fn layer(curves: usize, stiffness: f64) -> Layer {
    Layer { stiffness, bending: vec![1.0; curves], elements: vec![0.0; curves] }
}

fn all_pairs(set: &CurveSet) -> Vec<[u32; 2]> {
    let n = set.len() as u32;
    (0..n)
        .flat_map(|i| (i + 1..n).map(move |j| [i, j]))
        .filter(|p| set.curve_of(p[0] as usize) != set.curve_of(p[1] as usize))
        .collect()
}

fn contact_pairs(terms: Vec<PairTerm>) -> Vec<ContactPair> {
    terms.into_iter().map(ContactPair::from).collect()
}

fn found(set: &CurveSet, stiffness: f64) -> Vec<SiteReport> {
    let terms = evaluate(set, &all_pairs(set), Law::Linear { stiffness }, &|_, _| [0.0; 2], Want::Gradient);
    sites(set, &contact_pairs(terms), &[3, 7], &layer(2, stiffness))
}

/// Rods crossing at right angles at height 1 − δ: gap(s) = √(h² + s²) − 1 from either strand, so the zone is
/// |s| < √(1 − h²) and the force 2 · ½ κ ∫ (1 − √(h² + s²)) ds.
#[test]
fn crossing_rods_touch_at_one_point() {
    let (h, stiffness): (f64, f64) = (0.99, 100.0);
    let sites = found(&straight(90.0, h), stiffness);
    assert_eq!(sites.len(), 1, "{sites:?}");
    let site = &sites[0];
    assert_eq!((site.rod_a, site.rod_b, site.kind.as_str()), (3, 7, "point"));
    let w = (1.0 - h * h).sqrt();
    for arc in [site.arc_a, site.arc_b] {
        assert!((arc[0] - (3.2 - w)).abs() < 1e-12 && (arc[1] - (3.2 + w)).abs() < 1e-12, "{arc:?}");
    }
    assert!((site.gap - (h - 1.0)).abs() < 1e-14 && (site.angle - 90.0).abs() < 1e-12);
    let area = w - h * h * (w / h).asinh(); // ∫₋w..w (1 − √(h² + s²)) ds with √(h² + w²) = 1
    assert!((site.force / (stiffness * area) - 1.0).abs() < 1e-7, "{} {}", site.force, stiffness * area);
}

/// Antiparallel rods over the length 6, cut into many pieces: one line; force κ δ · 6, the gap is −δ throughout.
#[test]
fn parallel_rods_touch_along_one_line() {
    for degrees in [0.0, 180.0] {
        let set = straight(degrees, 0.99);
        let sites = found(&set, 100.0);
        assert_eq!(sites.len(), 1, "{degrees}: {sites:?}");
        let site = &sites[0];
        assert_eq!(site.kind, "line");
        let overlap: f64 = if degrees == 0.0 { 6.0 } else { 5.6 };
        // beyond the end of the other rod its end cap is felt: up to √(1 − 0.99²) = 0.141 further
        for arc in [site.arc_a, site.arc_b] {
            assert!((arc[1] - arc[0] - overlap).abs() < 0.2, "{degrees}: {arc:?}");
        }
        assert!((site.force - overlap).abs() < 0.15, "{degrees}: {}", site.force);
        assert!((site.gap + 0.01).abs() < 1e-14 && site.angle < 1e-9);
    }
}

/// A closed rod drawn out to a narrow loop: its two long sides, 0.99 apart, are both strands of one line.
#[test]
fn a_rod_along_itself_is_one_line() {
    let side = |y: f64, back: bool| (0..=8).map(move |k| Vec3::new(f64::from(if back { 8 - k } else { k }), y, 0.0));
    let points: Vec<Vec3> = side(0.0, false).chain(side(0.99, true)).collect();
    let set = CurveSet::from_polylines(&[(&points, 0.5, true)]).unwrap();
    let facing: Vec<[u32; 2]> = (1..7).flat_map(|i| (10..16).map(move |j| [i, j])).collect();
    let terms = evaluate(&set, &facing, Law::Linear { stiffness: 100.0 }, &|_, _| [0.0; 2], Want::Gradient);
    let sites = sites(&set, &contact_pairs(terms), &[0], &layer(1, 100.0));
    assert_eq!(sites.len(), 1, "{sites:?}");
    let site = &sites[0];
    let expected = [[1.0, 7.0], [9.99, 15.99]];
    for (arc, expected) in [site.arc_a, site.arc_b].into_iter().zip(expected) {
        assert!((arc[0] - expected[0]).abs() < 1e-12 && (arc[1] - expected[1]).abs() < 1e-12, "{arc:?}");
    }
    assert_eq!((site.rod_a, site.rod_b, site.kind.as_str()), (0, 0, "line"));
    assert!((site.force - 6.0).abs() < 1e-10 && (site.gap + 0.01).abs() < 1e-14 && site.angle < 1e-9, "{site:?}");
}

/// Two rings side by side touch all round.
#[test]
fn pieces_join_over_the_seam_and_all_round() {
    let ring = |radius: f64, z: f64, start: f64| -> Vec<Vec3> {
        (0..16)
            .map(|k| std::f64::consts::TAU * (f64::from(k) + start) / 16.0)
            .map(|t| Vec3::new(radius * t.cos(), radius * t.sin(), z))
            .collect()
    };
    let (a, b) = (ring(5.0, 0.0, 0.0), ring(5.0, 0.99, 8.0));
    let set = CurveSet::from_polylines(&[(&a, 0.5, true), (&b, 0.5, true)]).unwrap();
    let sites = found(&set, 100.0);
    assert_eq!(sites.len(), 1, "{sites:?}");
    let total = set.length_of(0);
    assert_eq!((sites[0].arc_a, sites[0].kind.as_str()), ([0.0, total], "line"));
    assert!((sites[0].force / total - 1.0).abs() < 1e-9);

    // a straight rod across the first node of the ring: the site runs over the seam
    let bar: Vec<Vec3> =
        (0..4).map(|k| Vec3::new(5.0, 0.0, 0.99) + Vec3::new(1.0, 0.1, 0.0) * (f64::from(k) - 1.4)).collect();
    let set = CurveSet::from_polylines(&[(&a, 0.5, true), (&bar, 0.5, false)]).unwrap();
    let sites = found(&set, 100.0);
    assert_eq!(sites.len(), 1, "{sites:?}");
    assert!(sites[0].arc_a[0] > 30.0 && sites[0].arc_a[1] < 1.0 && sites[0].kind == "point", "{sites:?}");
}

#[test]
fn a_hull_over_the_seam() {
    assert_eq!(hull([[9.0, 10.5], [0.2, 0.8]].into_iter(), Some(10.0)), [9.0, 0.8000000000000007]);
}

/// Zones strewn at random over two closed curves and an open one, long ones and ones over the seam among them: the same
/// counterparts as by trying all.
#[test]
fn counterparts_are_those_of_brute_force() {
    let ring = |z: f64| -> Vec<Vec3> {
        (0..40).map(|i| 0.157 * f64::from(i)).map(|t| Vec3::new(5.0 * t.cos(), 5.0 * t.sin(), z)).collect()
    };
    let line: Vec<Vec3> = (0..30).map(|i| Vec3::x() * f64::from(i)).collect();
    let (a, b) = (ring(0.0), ring(3.0));
    let set = CurveSet::from_polylines(&[(&a, 0.5, true), (&b, 0.5, true), (&line, 0.4, false)]).unwrap();
    let mut numbers = Random(5);
    let mut random = || 0.5 * (numbers.unit() + 1.0);
    for count in [1, 2, 7, 300] {
        let mut zones: Vec<SiteZone> = (0..count)
            .map(|_| {
                let curve_a = (3.0 * random()) as usize;
                let curve_b = (3.0 * random()) as usize;
                let mut arc = |curve: usize| {
                    let start = (random() * 1.2 - 0.1) * set.length_of(curve);
                    let width = if random() < 0.03 { 30.0 } else { 0.4 * random() };
                    if set.period(curve).is_some() {
                        [start, start + width]
                    } else {
                        [start.max(0.0), start.max(0.0) + width]
                    }
                };
                let (arc_a, ends) = (arc(curve_a), arc(curve_b));
                let arc_b = if random() < 0.5 { ends } else { [ends[1], ends[0]] };
                SiteZone {
                    curve_a,
                    arc_a,
                    curve_b,
                    arc_b,
                    load: Load::default(),
                    gap: 0.0,
                    angle: 0.0,
                    push: Vec3::zeros(),
                    torque: Vec3::zeros(),
                    at: Vec3::zeros(),
                    feet: [Vec3::zeros(); 2],
                }
            })
            .collect();
        zones.sort_by(order);
        let places = ByPlace::new(&set, &zones);
        let mut total = 0;
        for (index, zone) in zones.iter().enumerate() {
            let all = class(&zones, zone.curve_b, zone.curve_a);
            let wanted: Vec<usize> =
                all.filter(|&k| k != index && sees(&set, zone, &zones[k], pad(&set, zone))).collect();
            assert_eq!(counterparts(&set, &zones, &places, index), wanted, "{count}: zone {index}");
            total += wanted.len();
        }
        assert!(count < 300 || total > 20, "{total}");
    }
}

/// A straight rod and one that touches it `crests` times, once in each length 2, at z = 0 and 1 − 5e-5. `turned` has
/// the second run backwards.
fn rippled(crests: usize, turned: bool, swapped: bool) -> CurveSet {
    let length = 2 * crests;
    let a: Vec<Vec3> = (0..=length).map(|k| Vec3::x() * (k as f64 - 0.3)).collect();
    let mut b: Vec<Vec3> = (0..=10 * length)
        .map(|k| 0.1 * k as f64)
        .map(|x| Vec3::new(x, 0.0, 1.01 - 5e-5 + 0.01 * (std::f64::consts::PI * x).cos()))
        .collect();
    if turned {
        b.reverse();
    }
    let curves: [(&[Vec3], f64, bool); 2] = [(&a, 0.5, false), (&b, 0.5, false)];
    CurveSet::from_polylines(&if swapped { [curves[1], curves[0]] } else { curves }).unwrap()
}

/// Sites where the elements have this length; a layer of width 0.01.
fn sites_of_elements(set: &CurveSet, length: f64) -> (Vec<SiteReport>, Vec<crate::observe::report::LineSample>) {
    let law = Law::Linear { stiffness: 1e8 };
    let terms = contact_pairs(evaluate(set, &all_pairs(set), law, &|_, _| [0.0; 2], Want::Gradient));
    let layer = Layer { elements: vec![length; 2], ..layer(2, 1e8) };
    (sites(set, &terms, &[3, 7], &layer), lines(set, &terms, &[3, 7], &layer))
}

/// A ripple between a point and a line is part of the point, which is stronger, and does not join the two; on a mesh of
/// short elements it is a contact of its own.
#[test]
fn a_ripple_beside_a_point_is_part_of_it() {
    // heights above contact along b; in between straight
    let heights = [(0.0, 1e-2), (0.9, 1e-2), (1.0, -1e-2), (1.1, 1e-2), (1.5, 1e-4), (1.55, -1e-4), (1.6, 1e-4)];
    let line = [(2.0, 1e-4), (2.1, -2e-4), (5.0, -2e-4), (5.1, 1e-2), (6.0, 1e-2)];
    let b: Vec<Vec3> = heights.iter().chain(&line).map(|&(x, above)| Vec3::new(x, 0.0, 1.0 + above)).collect();
    let a: Vec<Vec3> = (0..=6).map(|k| Vec3::x() * f64::from(k)).collect();
    let set = CurveSet::from_polylines(&[(&a, 0.5, false), (&b, 0.5, false)]).unwrap();
    let [fine, coarse] = [0.1, 1.0].map(|length| sites_of_elements(&set, length).0);
    assert_eq!((fine.len(), coarse.len()), (3, 2), "{coarse:?}");
    assert_eq!(coarse[1], fine[2]);
    assert!(
        (coarse[0].force / (fine[0].force + fine[1].force) - 1.0).abs() < 1e-12 && coarse[0].force > coarse[1].force
    );
}

/// Contacts in a row, one an element, are one line; two are points, and so are rows wider than the elements. Whatever
/// the sites, their forces add up to the same, also if a strand runs the other way or the strands are swapped; the
/// pressure along the line is even and adds up to its force.
#[test]
fn a_row_of_contacts_is_a_line() {
    for (turned, swapped) in [(false, false), (true, false), (false, true), (true, true)] {
        for crests in [2, 3, 9] {
            let set = rippled(crests, turned, swapped);
            let ((points, none), (row, samples)) = (sites_of_elements(&set, 1.0), sites_of_elements(&set, 2.0));
            assert!(points.len() == crests && points.iter().all(|site| site.kind == "point") && none.is_empty());
            let total = |sites: &[SiteReport]| -> (f64, Vec3) {
                (sites.iter().map(|site| site.force).sum(), sites.iter().map(|site| Vec3::from(site.force_on_a)).sum())
            };
            let ((force, vector), (of_row, vector_of_row)) = (total(&points), total(&row));
            assert!((force / of_row - 1.0).abs() < 1e-12 && (vector - vector_of_row).norm() < 1e-12 * force);
            if crests < 3 {
                assert_eq!(row, points);
                continue;
            }
            assert_eq!((row.len(), row[0].kind.as_str()), (1, "line"), "{row:?}");
            // crests at 1, 3, 5 …, the last at 2 crests - 1
            let [from, to] = if swapped { row[0].arc_b } else { row[0].arc_a };
            assert!((from - 1.3).abs() < 0.2 && (to - 2.0 * crests as f64 + 0.7).abs() < 0.2, "{from} {to}");
            let length = row[0].arc_a[1] - row[0].arc_a[0];
            let spacing = length / samples.len() as f64;
            let sum: f64 = samples.iter().map(|sample| sample.pressure * spacing).sum();
            assert!((sum / of_row - 1.0).abs() < 1e-12, "{sum} {of_row}");
            let inner = &samples[samples.len() / 3..samples.len() - samples.len() / 3];
            let mean = inner.iter().map(|sample| sample.pressure).sum::<f64>() / inner.len() as f64;
            let even = |sample: &crate::observe::report::LineSample| (sample.pressure / mean - 1.0).abs() < 0.03;
            assert!(crests < 9 || inner.iter().all(even), "{inner:?}");
        }
    }
}

/// A straight rod in the bend of another one, bent more tightly than within the contact distance: its points see two
/// nearest ones of the bend and a farthest one between them. Symptom: the force of the site was twice that on the rods.
/// Mechanism: farthest points, which the potential subtracts, were left out of the sites.
#[test]
fn sites_carry_the_force_of_the_rods_in_tight_bends() {
    let mut folded = 0;
    for (angle, lift) in [(90.0, 0.0), (90.0, 0.004), (50.0, 0.002), (90.0, -0.001)] {
        let (stiffness, radius) = (100.0, 0.5);
        let (sin, cos) = f64::to_radians(angle).sin_cos();
        let straight: Vec<Vec3> =
            (0..=6).map(|k| Vec3::new(cos, sin, 0.0) * (f64::from(k) - 3.2) - Vec3::z() * (0.99 - lift)).collect();
        let b = |k: f64| Vec3::new(k, 0.0, 0.0);
        // horizontal at x = 0, from there downwards on both sides: radius of curvature .8
        let half = Cubic { b: [b(0.0), b(0.4), Vec3::new(0.75, 0.0, 0.3), Vec3::new(1.0, 0.0, 0.7)] };
        let mirrored = Cubic { b: std::array::from_fn(|k| Vec3::new(-half.b[3 - k].x, 0.0, -half.b[3 - k].z)) };
        let down = Cubic { b: half.b.map(|p| Vec3::new(p.x, 0.0, -p.z)) };
        let line = |w: &[Vec3]| Cubic { b: std::array::from_fn(|k| w[0].lerp(&w[1], k as f64 / 3.0)) };
        let curve =
            |segments: Vec<Cubic>| CurveInput { lengths: vec![1.0; segments.len()], segments, closed: false, radius };
        let set =
            CurveSet::new(vec![curve(straight.windows(2).map(line).collect()), curve(vec![mirrored, down])]).unwrap();
        let terms = evaluate(&set, &all_pairs(&set), Law::Linear { stiffness }, &|_, _| [0.0; 2], Want::Gradient);
        let on_a: Vec3 = terms
            .iter()
            .map(|term| -term.gradient[if set.curve_of(term.slave) == 0 { 0..4 } else { 4..8 }].iter().sum::<Vec3>())
            .sum();
        let is_folded = terms.iter().flat_map(|term| &term.zones).any(|zone| zone.piece.branch.is_subtracted());
        let sites = sites(&set, &contact_pairs(terms), &[0, 1], &layer(2, stiffness));
        let told: Vec3 = sites.iter().map(|site| Vec3::from(site.force_on_a)).sum();
        folded += usize::from(is_folded);
        assert!((told - on_a).norm() < 1e-12 * on_a.norm(), "{angle} {lift}: {told:?} {on_a:?}");
        assert_eq!(sites.len(), 1, "{angle} {lift}: {sites:?}");
    }
    assert!(folded >= 2, "{folded}");
}
