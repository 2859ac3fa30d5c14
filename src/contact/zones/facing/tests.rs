//! The method for facing pairs against the general one.

use super::super::FootKind;
use super::*;
use crate::math::random::Random;

/// Two strands side by side or across each other, bent and skewed by `wild`, closer or farther than the reach.
fn strands(random: &mut Random, wild: f64, away: f64) -> (Cubic, Cubic) {
    let turn = nalgebra::Rotation3::new(Vec3::z() * 3.0 * random.unit());
    let along = turn * Vec3::x();
    let offset = Vec3::z() * away + (Vec3::x() * random.unit() + Vec3::y() * random.unit()) * 0.8;
    let mut bent = |start: Vec3, way: Vec3| {
        let tangent = |random: &mut Random| way + random.vector() * wild;
        let (first, last) = (tangent(random), tangent(random));
        Cubic::from_hermite(start, first, start + way, last)
    };
    let master = bent(Vec3::zeros(), Vec3::x());
    (bent(offset + along * -0.5 + Vec3::x() * 0.5, along), master)
}

/// Pieces, nearest points and feet are those of the general method, whatever the bounds show; and they show nearly
/// always.
#[test]
fn what_faces_plainly_is_found_as_in_general() {
    let mut random = Random(31);
    let (mut plain, mut counts, mut undecided) = (0, [0; 3], 0);
    for case in 0..20_000 {
        let wild = [0.02, 0.1, 0.3, 1.0][case % 4];
        let away = 0.5 + [0.001, 0.01, 0.1, 0.3][case / 4 % 4] * random.unit();
        let (slave, master) = strands(&mut random, wild, away);
        let Some(facing) = Facing::new(&slave, &master) else { continue };
        let reach = [0.5, 0.5 + 0.01 * random.unit()];
        let pair = SegmentPair {
            slave: &slave,
            master: &master,
            open_start: false,
            open_end: false,
            reach,
            joints: [None; 2],
            kinks: [None; 2],
        };
        let (mut general, mut ours, mut nearest) = (Vec::new(), Vec::new(), Vec::new());
        pair.pieces(&mut general);
        if facing.misses() != [false; 2] {
            assert!(general.is_empty(), "case {case}");
            counts[2] += 1;
            continue;
        }
        if !facing.pieces(&pair, false, &mut ours) {
            undecided += 1;
            continue;
        }
        assert!(facing.pieces(&pair, true, &mut nearest), "case {case}");
        plain += 1;
        counts[usize::from(!general.is_empty())] += 1;
        assert_eq!((ours.len(), nearest.len()), (general.len(), general.len()), "case {case}: {ours:?} {general:?}");
        for ((p, q), n) in ours.iter().zip(&general).zip(&nearest) {
            // a grazing zone's ends are known to the square root of rounding
            let tol = 1e-13 / (q.u[1] - q.u[0]).min(1.0) + 1e-12;
            for k in 0..2 {
                assert!(
                    (p.u[k] - q.u[k]).abs() < tol && (p.v[k] - q.v[k]).abs() < 10.0 * tol,
                    "case {case}: {p:?} {q:?}"
                );
                assert!(
                    (n.u[k] - q.u[k]).abs() < tol && (n.v[k] - q.v[k]).abs() < 10.0 * tol,
                    "case {case}: {n:?} {q:?}"
                );
            }
            assert_eq!((p.branch.kind, p.branch.sign), (FootKind::Orthogonal, 1.0));
            assert!((n.nearest.distance - q.nearest.distance).abs() < 1e-14, "case {case}: {n:?} {q:?}");
            for share in [0.1, 0.5, 0.8] {
                let at = |ends: [f64; 2]| ends[0] + share * (ends[1] - ends[0]);
                let (a, b) = (facing.project(&pair, at(q.u), at(q.v)), pair.project(at(q.u), at(q.v), &q.branch).0);
                assert!((a.v - b.v).abs() < 1e-14 / CONVEX, "case {case}: {a:?} {b:?}");
                assert!((a.distance - b.distance).abs() < 1e-14 && (a.normal - b.normal).norm() < 1e-12);
                assert!((a.tangent - b.tangent).norm() < 1e-12 && (a.curvature - b.curvature).norm() < 1e-12);
            }
        }
    }
    assert!(
        plain > 5000 && counts.iter().all(|&n| n > 500) && undecided < plain / 100,
        "{plain} {counts:?} {undecided}"
    );
}

/// On a line of contact the bounds alone decide.
#[test]
fn a_line_of_contact_is_decided_by_bounds() {
    let arc = |phase: f64, from: f64| {
        let at = |t: f64| {
            let (s, c) = (phase + t).sin_cos();
            (Vec3::new(c, s, 2.5 * t), Vec3::new(-s, c, 2.5))
        };
        let h = 0.25;
        Cubic::from_hermite(at(from).0, at(from).1 * h, at(from + h).0, at(from + h).1 * h)
    };
    let slave = arc(0.0, 1.0);
    let mut covered = [0.0; 2];
    for k in 0..40 {
        let master = arc(std::f64::consts::PI, 0.01 + 0.25 * f64::from(k) - 4.0);
        for (covered, reach) in covered.iter_mut().zip([2.0005, 1.9995]) {
            let pair = SegmentPair {
                slave: &slave,
                master: &master,
                open_start: false,
                open_end: false,
                reach: [reach; 2],
                joints: [None; 2],
                kinks: [None; 2],
            };
            let Some(facing) = Facing::new(&slave, &master) else { continue };
            let Some([start, end]) = between(&pair.sides()) else { panic!("{k}") };
            if end - start <= NARROW {
                continue;
            }
            let at = |u: f64| facing.sample(&pair, u, 0.5).unwrap();
            let (first, last) = (at(start), at(end));
            assert_eq!(facing.in_reach(&pair, &first, &last), Some(reach > 2.0), "{k} {reach}");
            *covered += end - start;
        }
    }
    assert!(covered.iter().all(|c| (c - 1.0).abs() < 1e-12), "{covered:?}");
}
