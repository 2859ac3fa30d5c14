//! Ends with handles that turn and stretch against the control points that they move.

use super::super::*;
use crate::contact::curves::curve::{Cubic, CurveInput};
use crate::math::handles::control_points;
use crate::math::quaternion::exp;

fn crossing() -> CurveSet {
    let v = Vec3::new;
    let between = |start: Vec3, tangents: [Vec3; 2], end: Vec3| cubic([start, end], tangents.map(|t| t.normalize()));
    let one = between(v(-0.9, 0.1, 0.2), [v(0.6, -0.1, 0.06), v(0.7, -0.05, 0.06)], v(1.0, 0.0, 0.3));
    let two = between(v(-0.8, -0.5, 0.0), [v(0.6, 0.2, 0.05), v(0.4, 0.5, 0.02)], v(0.6, 0.7, 0.0));
    let input = |cubic: Cubic| CurveInput { segments: vec![cubic], lengths: vec![1.3], closed: false, radius: 0.15 };
    CurveSet::new(vec![input(one), input(two)]).unwrap()
}

fn cubic(ends: [Vec3; 2], tangents: [Vec3; 2]) -> Cubic {
    Cubic { b: control_points(ends, tangents) }
}

/// Control points of both cubics when their ends are displaced and turned.
fn moved(cubics: &[Cubic; 2], step: &[f64; 24]) -> [Vec3; 8] {
    let part = |k: usize| Vec3::new(step[k], step[k + 1], step[k + 2]);
    let of_cubic = |k: usize| {
        let ([after, _, before], first) = (cubics[k].edges(), 12 * k);
        let ends = [cubics[k].b[0] + part(first), cubics[k].b[3] + part(first + 6)];
        let tangents = [exp(&part(first + 3)) * after.normalize(), exp(&part(first + 9)) * before.normalize()];
        cubic(ends, tangents).b
    };
    let [one, two] = [0, 1].map(of_cubic);
    std::array::from_fn(|m| if m < 4 { one[m] } else { two[m - 4] })
}

/// The second-order expansion of the potential in the control points, as a function of the ends, has the gradient and
/// tangent of the end coordinates.
#[test]
fn terms_of_ends_are_those_of_the_control_points_that_they_move() {
    let set = crossing();
    let (law, offset) = (Law::Linear { stiffness: 1e3 }, |_: usize, _: usize| [0.01, -0.01]);
    let (geometry, pressures) = (ContactGeometry::by_ends(&set), Pressures::of(law, &offset));
    let points = evaluate_within(&geometry, &[[0, 1]], &pressures, Want::Hessian);
    let mut pair = [CandidateTerms::NONE];
    evaluate_tangents(&geometry, &[[0, 1]], &pressures, &mut pair);
    let tangent = pair[0].second_derivative().unwrap();
    let ends: Vec<&EndTerm> = pair[0].terms.iter().flatten().collect();
    assert_eq!((points.len(), ends.len()), (2, 2));
    let cubics = [0, 1].map(|k| set.segments[k]);
    let start = moved(&cubics, &[0.0; 24]);
    // the first segment's control points, then the second's, whichever is the slave
    let at = |term: &PairTerm, m: usize| (m + 4 * term.slave) % 8;
    let potential_of = |term: &PairTerm, step: &[f64; 24]| {
        let hessian = term.hessian.as_deref().unwrap();
        let full = |m: usize, n: usize| if m <= n { hessian[m][n] } else { hessian[n][m].transpose() };
        let x = moved(&cubics, step);
        let way: [Vec3; 8] = std::array::from_fn(|m| x[at(term, m)] - start[at(term, m)]);
        let slope = |m: usize| term.gradient[m] + (0..8).map(|n| full(m, n) * way[n]).sum::<Vec3>() * 0.5;
        (0..8).map(|m| slope(m).dot(&way[m])).sum::<f64>()
    };
    let scale = tangent.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs()));
    let two = |i: usize, a: f64, j: usize, b: f64| {
        let mut step = [0.0; 24];
        step[i] += a;
        step[j] += b;
        step
    };
    for (by_points, by_ends) in points.iter().zip(&ends) {
        assert_eq!((by_points.slave, by_points.master), (by_ends.pair.slave, by_ends.pair.master));
        assert!(by_points.energy > 0.1 && (by_points.energy - by_ends.energy).abs() < 1e-14);
        for i in 0..24 {
            let h = 1e-5;
            let [rise, fall] = [h, -h].map(|h| potential_of(by_points, &two(i, h, i, 0.0)));
            let (slope, ours) = ((rise - fall) / (2.0 * h), by_ends.gradient[(i + 12 * by_points.slave) % 24]);
            assert!((slope - ours).abs() < 1e-7 * scale, "{i}: {slope} {ours}");
        }
    }
    let potential = |step: &[f64; 24]| points.iter().map(|term| potential_of(term, step)).sum::<f64>();
    let along = |i: usize, a: f64, j: usize, b: f64| potential(&two(i, a, j, b));
    for i in 0..24 {
        for j in i / 6 * 6..24 {
            let second = |h: f64| {
                (along(i, h, j, h) - along(i, h, j, -h) - along(i, -h, j, h) + along(i, -h, j, -h)) / (4.0 * h * h)
            };
            let difference = (4.0 * second(1e-3) - second(2e-3)) / 3.0;
            assert!((difference - tangent[i][j]).abs() < 1e-7 * scale, "({i},{j}): {difference} {}", tangent[i][j]);
        }
    }
}
