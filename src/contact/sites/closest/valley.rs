//! Undecided valleys: one minimum for each, by descent.

use super::cell::{BORDER, CellParallelogram};
use super::{Closest, DistanceDerivatives, MinimumSearch};
use crate::contact::curves::curve::Cubic;
use crate::contact::measures::SUM_ROUNDING;
use crate::math::Vec3;

/// Step off a saddle, as parameters, because the slope at the saddle itself is rounding.
const OFF_SADDLE: f64 = 0.02;
/// Fractions of a step of a descent that are tried, because a step that has to be shorter is nearly none.
const SHORTER: [f64; 5] = [1.0, 0.25, 0.0625, 0.015625, 0.00390625];
/// Slope (cosine of the angle between tangent and connection) below which a valley counts as level, because a descent
/// ends where the distance changes by rounding, and slopes there are the root of it.
const LEVEL: f64 = 1e-7;
/// Determinant of second derivatives over the product of the diagonal, below which a point is a saddle, because that of
/// a level valley is rounding about zero.
const SADDLE: f64 = -1e-9;

/// The part of the square of parameters that a cell covers.
struct Rectangle {
    u: [f64; 2],
    v: [f64; 2],
    level: bool,
}

impl Rectangle {
    fn of(&(cell, level): &(CellParallelogram, bool)) -> Self {
        let on_segment = |r: [f64; 2]| [r[0].clamp(0.0, 1.0), r[1].clamp(0.0, 1.0)];
        // Where a slanting strip lies within v in [0, 1].
        let at = |v: f64| cell.middle() + (v - cell.v0) / cell.slope;
        let (x, y) = (at(-cell.t[1]), at(1.0 - cell.t[0]));
        let strip = if cell.slope == 0.0 { cell.u } else { [cell.u[0].max(x.min(y)), cell.u[1].min(x.max(y))] };
        let cell = if strip[0] <= strip[1] { cell.with_u(strip) } else { cell };
        let (u, v) = (on_segment(cell.u), on_segment(cell.v_range()));
        if cell.flipped { Self { u: v, v: u, level } } else { Self { u, v, level } }
    }
}

impl MinimumSearch {
    /// One minimum for each connected group of cells; each cell comes with whether it is level.
    pub(super) fn valleys(&self, cells: &[(CellParallelogram, bool)], out: &mut Vec<Closest>) {
        let cells: Vec<Rectangle> = cells.iter().map(Rectangle::of).collect();
        let project = |x: [f64; 2], y: [f64; 2]| x[0] <= y[1] + BORDER && y[0] <= x[1] + BORDER;
        let mut done = vec![false; cells.len()];
        for k in 0..cells.len() {
            if done[k] {
                continue;
            }
            done[k] = true;
            let mut group = vec![k];
            let mut next = 0;
            while next < group.len() {
                let c = &cells[group[next]];
                next += 1;
                for (m, other) in cells.iter().enumerate() {
                    if !done[m] && project(c.u, other.u) && project(c.v, other.v) {
                        done[m] = true;
                        group.push(m);
                    }
                }
            }
            let group: Vec<&Rectangle> = group.iter().map(|&k| &cells[k]).collect();
            if !ends_here(&group) {
                out.extend(deepest(self, &group));
            }
        }
    }
}

fn hull(group: &[&Rectangle], get: fn(&Rectangle) -> [f64; 2]) -> [f64; 2] {
    group.iter().map(|&c| get(c)).fold([1.0, 0.0], |h: [f64; 2], r| [h[0].min(r[0]), h[1].max(r[1])])
}

/// Whether a level valley only touches the square's border with its end. It then belongs to another pair, or to the end
/// of a curve, which is treated separately.
fn ends_here(group: &[&Rectangle]) -> bool {
    let (u, v) = (hull(group, |c| c.u), hull(group, |c| c.v));
    let small = u[1] - u[0] < 16.0 * BORDER && v[1] - v[0] < 16.0 * BORDER;
    let ends = u[0] == 0.0 || u[1] == 1.0 || v[0] == 0.0 || v[1] == 1.0;
    small && ends && group.iter().all(|c| c.level)
}

/// The nearest level point of a group of boxes; among equally near points the one nearest to the group's middle.
fn deepest(search: &MinimumSearch, group: &[&Rectangle]) -> Option<Closest> {
    let MinimumSearch { a, b, reach, noise } = search;
    let (hu, hv) = (hull(group, |c| c.u), hull(group, |c| c.v));
    let middle = (0.5 * (hu[0] + hu[1]), 0.5 * (hv[0] + hv[1]));
    let mut points: Vec<(f64, f64, f64)> = Vec::with_capacity(group.len() + 1);
    let starts = group.iter().map(|c| (0.5 * (c.u[0] + c.u[1]), 0.5 * (c.v[0] + c.v[1])));
    let mut offer = |(u, v): (f64, f64)| -> bool {
        let at = DistanceDerivatives::new(a, b, u, v);
        let level = |d: &Vec3| at.w.dot(d).abs() <= LEVEL * at.w.norm() * d.norm() + 4.0 * f64::EPSILON * d.norm();
        let stationary = level(&at.da) && level(&at.db);
        let saddle = at.det() < SADDLE * (at.uu * at.vv).abs() || at.uu < 0.0 || at.vv < 0.0;
        if stationary && !saddle && at.w.norm() <= *reach {
            points.push((at.w.norm(), u, v));
        }
        stationary && saddle
    };
    for start in starts.chain([middle]) {
        let end = descend(a, b, start, hu, hv);
        if offer(end) {
            // Descent from the saddle, both ways along its direction of negative curvature.
            let h = DistanceDerivatives::new(a, b, end.0, end.1);
            let angle = 0.5 * (2.0 * h.uv).atan2(h.uu - h.vv) + std::f64::consts::FRAC_PI_2;
            let (sin, cos) = angle.sin_cos();
            let (du, dv) = (OFF_SADDLE * cos, OFF_SADDLE * sin);
            for sign in [-1.0, 1.0] {
                let from = ((end.0 + sign * du).clamp(hu[0], hu[1]), (end.1 + sign * dv).clamp(hv[0], hv[1]));
                offer(descend(a, b, from, hu, hv));
            }
        }
    }
    let least = points.iter().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let off = |p: &(f64, f64, f64)| (p.1 - middle.0).abs() + (p.2 - middle.1).abs();
    let nearest = points.iter().filter(|p| p.0 <= least * (1.0 + SUM_ROUNDING) + 4.0 * (f64::EPSILON + noise));
    nearest.min_by(|x, y| off(x).total_cmp(&off(y))).map(|&(_, u, v)| Closest { u, v, radius: 0.0, flat: true })
}

/// Newton step of D at (u, v); NaN if the second derivative is singular.
fn step(a: &Cubic, b: &Cubic, u: f64, v: f64) -> (f64, f64) {
    let h = DistanceDerivatives::new(a, b, u, v);
    let (gu, gv, det) = (h.gu, h.gv, h.det());
    (-(h.vv * gu - h.uv * gv) / det, -(h.uu * gv - h.uv * gu) / det)
}

/// Descent inside a box of parameters: Newton's method where D is convex, else one parameter at a time; only steps that
/// lower D are taken.
fn descend(a: &Cubic, b: &Cubic, start: (f64, f64), hu: [f64; 2], hv: [f64; 2]) -> (f64, f64) {
    let value = |u: f64, v: f64| (a.point(u) - b.point(v)).norm_squared();
    let (mut u, mut v) = start;
    let mut here = value(u, v);
    // as many steps as bisections
    for _ in 0..f64::MANTISSA_DIGITS {
        let h = DistanceDerivatives::new(a, b, u, v);
        let (gu, gv) = (h.gu, h.gv);
        let convex = h.uu > 0.0 && h.vv > 0.0 && h.det() > SUM_ROUNDING * h.uu * h.vv;
        let single = (-gu / (h.uu.abs() + h.uv.abs()), -gv / (h.vv.abs() + h.uv.abs()));
        let full = if convex { step(a, b, u, v) } else { single };
        let shorter = |part: f64, (du, dv): (f64, f64)| {
            let (u, v) = ((u + part * du).clamp(hu[0], hu[1]), (v + part * dv).clamp(hv[0], hv[1]));
            (u, v, value(u, v))
        };
        let tries = [full, single].into_iter().flat_map(|step| SHORTER.map(|part| (part, step)));
        let lower = tries.map(|(part, step)| shorter(part, step)).find(|(.., there)| *there < here);
        let Some(lower) = lower else { break };
        (u, v, here) = lower;
    }
    (u, v)
}
