//! Zones of pairs against closed forms and dense sampling.

use super::*;
use crate::contact::projection::{Feet, local_minima};
use crate::math::random::Random;

fn line(from: [f64; 3], to: [f64; 3]) -> Cubic {
    Cubic::straight(Vec3::from(from), Vec3::from(to))
}

fn pair<'a>(slave: &'a Cubic, master: &'a Cubic, reach: f64) -> SegmentPair<'a> {
    SegmentPair {
        slave,
        master,
        open_start: false,
        open_end: false,
        reach: [reach; 2],
        joints: [None; 2],
        kinks: [None; 2],
    }
}

/// Perpendicular straight strands at height h: the zone is |x| < √(reach² − h²), exactly.
#[test]
fn perpendicular_lines_have_the_chord_of_a_circle_as_zone() {
    let (a, b) = (line([-1.0, 0.0, 0.3], [1.0, 0.0, 0.3]), line([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]));
    let mut pieces = Vec::new();
    pair(&a, &b, 0.5).pieces(&mut pieces);
    assert_eq!(pieces.len(), 1);
    let half = 0.5 * 0.4;
    assert!((pieces[0].u[0] - (0.5 - half)).abs() < 1e-15);
    assert!((pieces[0].u[1] - (0.5 + half)).abs() < 1e-15);
    assert!((pieces[0].nearest.u - 0.5).abs() < 1e-15 && (pieces[0].nearest.distance - 0.3).abs() < 1e-15);
}

#[test]
fn parallel_lines_are_cut_where_the_foot_leaves_the_master() {
    let (a, b) = (line([0.0, 0.2, 0.0], [4.0, 0.2, 0.0]), line([1.0, 0.0, 0.0], [2.0, 0.0, 0.0]));
    let mut pieces = Vec::new();
    pair(&a, &b, 0.3).pieces(&mut pieces);
    assert_eq!(pieces.len(), 1);
    assert!((pieces[0].u[0] - 0.25).abs() < 1e-15 && (pieces[0].u[1] - 0.5).abs() < 1e-15);
    let open = SegmentPair { open_start: true, open_end: true, ..pair(&a, &b, 0.3) };
    pieces.clear();
    open.pieces(&mut pieces);
    pieces.sort_by(|p, q| p.u[0].total_cmp(&q.u[0]));
    assert_eq!(pieces.len(), 3);
    let cap = (0.09f64 - 0.04).sqrt();
    assert_eq!(pieces[0].branch.kind, FootKind::Start);
    assert!((pieces[0].u[0] - (1.0 - cap) / 4.0).abs() < 1e-15);
    assert_eq!(pieces[2].branch.kind, FootKind::End);
    assert!((pieces[2].u[1] - (2.0 + cap) / 4.0).abs() < 1e-15);
}

/// A dip between two samples must not be missed.
#[test]
fn a_shallow_dip_between_samples_is_found() {
    let (a, b) = (line([-1.0, 0.0, 0.3], [1.1, 0.0, 0.3]), line([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]));
    let mut pieces = Vec::new();
    pair(&a, &b, 0.3 * (1.0 + 1e-9)).pieces(&mut pieces);
    assert_eq!(pieces.len(), 1);
    assert!((pieces[0].nearest.u - 1.0 / 2.1).abs() < 1e-14);
}

/// A slave that crosses right above a joint of the master, in any attitude and to rounding on either side of it:
/// together the two segments cover the zone once.
#[test]
fn a_zone_whose_foot_rests_on_a_joint_is_covered_once() {
    let mut numbers = Random(99);
    let mut random = || 0.5 * numbers.unit();
    let exact = 2.0 * (0.25f64 - 0.09).sqrt();
    for trial in 0..3000 {
        let axis = Vec3::new(random(), random(), random());
        let turn = nalgebra::Rotation3::new(axis * 6.0);
        let [t, n, m] = [Vec3::x(), Vec3::y(), Vec3::z()].map(|e| turn * e);
        let joint = Vec3::new(random(), random(), random()) * 5.0;
        let bend = n * 0.3 + m * 0.1;
        let before = Cubic::from_hermite(joint - t + bend, t, joint, t);
        let after = Cubic::from_hermite(joint, t * 0.7, joint + t + bend, t);
        let off = t * [0.0, 1e-16, -1e-16, 1e-15, -1e-15, 1e-12, -1e-9][trial % 7];
        let slave = Cubic::straight(joint + off + m * 0.3 - n, joint + off + m * 0.3 + n);
        let shared = Some(SmoothJoint { tangent: before.b[3] - before.b[2] });
        let mut pieces = Vec::new();
        SegmentPair { joints: [None, shared], ..pair(&slave, &before, 0.5) }.pieces(&mut pieces);
        SegmentPair { joints: [shared, None], ..pair(&slave, &after, 0.5) }.pieces(&mut pieces);
        let covered: f64 = pieces.iter().map(|p| 2.0 * p.branch.sign * (p.u[1] - p.u[0])).sum();
        assert!((covered - exact).abs() < 0.02, "trial {trial}: {covered} {exact} {pieces:?}");
    }
}

/// Against brute force: curved strands, the excess is negative exactly inside the pieces.
#[test]
fn curved_pairs_agree_with_dense_sampling() {
    let mut numbers = Random(12345);
    let mut random = || 0.5 * numbers.unit();
    let mut num_pieces = 0;
    for _ in 0..300 {
        let mut point = |x: f64, y: f64, z: f64| Vec3::new(x + 0.3 * random(), y + 0.3 * random(), z + 0.2 * random());
        let a = Cubic { b: [point(-1.0, 0.0, 0.2), point(-0.3, 0.0, 0.2), point(0.3, 0.0, 0.2), point(1.0, 0.0, 0.2)] };
        let b =
            Cubic { b: [point(-0.7, -0.7, 0.0), point(-0.2, -0.2, 0.0), point(0.2, 0.2, 0.0), point(0.7, 0.7, 0.0)] };
        let p = SegmentPair { open_end: true, reach: [0.25, 0.35], ..pair(&a, &b, 0.0) };
        let mut pieces = Vec::new();
        p.pieces(&mut pieces);
        num_pieces += pieces.len();
        for k in 0..=400 {
            let u = (k as f64 + 0.123) / 401.0;
            let x = a.point(u);
            let mut feet = Feet::new();
            local_minima(&b, &x, f64::INFINITY, &mut feet);
            let mut expected =
                feet.as_slice().iter().filter(|f| f.u > 0.0 && f.u < 1.0 && f.distance < p.reach_at(u)).count();
            let end = x - b.b[3];
            expected += usize::from(end.dot(&(b.b[3] - b.b[2])) > 0.0 && end.norm() < p.reach_at(u));
            let found = pieces.iter().filter(|piece| piece.u[0] < u && u < piece.u[1]).count();
            assert_eq!(found, expected, "u = {u}");
        }
    }
    assert!(num_pieces > 100, "the case must have contact: {num_pieces}");
}
