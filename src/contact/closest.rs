//! All bilateral local minima of the distance between two cubics.
//!
//! With D(u, v) = ½|a(u) − b(v)|² the square \[0, 1\]² of parameters is halved again and again. A box is dropped if its curves are provably
//! out of range or if ∂D/∂u or ∂D/∂v keeps its sign there: the Bernstein coefficients of ∂D/∂u over the box are those of the
//! point–curve quintics from each control point of b, so the test is exact up to rounding. What is neither dropped nor decided at the
//! chosen resolution is a valley as flat as contact lines have them: the boxes that hang together give one minimum, marked `flat`, at the nearest
//! level point found among them.
//!
//! **What is proved.** Boxes are looked at enlarged by β = 1e-9 on all sides ([`BORDER`]). On a box where the same coefficients show that every Hessian has its least
//! eigenvalue above some m > 0, ∇D is strongly monotone: for a stationary point q and any p of the box (∇D(p))·(p − q) ≥ m |p − q|². So
//! (i) there is at most one stationary point, and it is a minimum; (ii) it is within |∇D(p)|/m of any p; (iii) if p rests against the enlarged border
//! with the slope there rising inward, only the components of ∇D(p) along the border count in (ii). The search ends in such a box only with
//! a p for which that radius, the rounding of ∇D included, is below β/2: then the minimum is at p to that radius (told as such), or, in case (iii), lies
//! outside the box proper. Otherwise the box is halved. Hence: *all minima outside the undecided valleys are told, each once, to 1e-9 of a segment's parameter, and nothing
//! else*. (A minimum within β of the end of a segment is told at that end.) In an undecided valley the descents are ordinary numerics: one minimum is told for each,
//! the deepest found, and that it is the only one is not claimed; a valley without a level point tells none.

use super::capsule::distance_lower_bound;
use super::curve::Cubic;
use super::projection::stationarity;
use crate::math::Vec3;
use crate::math::bernstein::derivative;

/// A box is undecided at the latest when this many have been looked at.
const MAX_BOXES: usize = 4096;
/// β: boxes overlap by twice this (in their segment's parameter), so that rounding cannot lose a minimum on a border.
const BORDER: f64 = 1e-9;
/// Slope (cosine of the angle between tangent and connection) below which a valley counts as level.
const LEVEL: f64 = 1e-7;

/// A local minimum at parameters u, v.
#[derive(Clone, Copy, Debug)]
struct Closest {
    u: f64,
    v: f64,
    flat: bool,
}

#[derive(Clone, Copy)]
struct Cell {
    u: [f64; 2],
    v: [f64; 2],
}

impl Cell {
    fn enlarged(&self) -> Self {
        let wide = |r: [f64; 2]| [r[0] - BORDER, r[1] + BORDER];
        Self { u: wide(self.u), v: wide(self.v) }
    }
}

/// All local minima with distance ≤ `max_distance` \[L\] at which both curves are stationary (ends and kinks are not looked at), each handed to `push(u, v, flat)`.
/// `resolution` is the size of parameter boxes, in (0, 1\], below which valleys are not resolved further.
pub(crate) fn minima(a: &Cubic, b: &Cubic, max_distance: f64, resolution: f64, mut push: impl FnMut(f64, f64, bool)) {
    let origin = b.b[0];
    let (a, b) = (a.b.map(|p| p - origin), b.b.map(|p| p - origin));
    let scale = a.iter().chain(&b).map(Vec3::amax).fold(0.0, f64::max);
    let usable = scale > 0.0 && scale.is_finite();
    if !usable {
        return;
    }
    let (a, b) = (Cubic { b: a.map(|p| p / scale) }, Cubic { b: b.map(|p| p / scale) });
    let reach = max_distance / scale * (1.0 + 1e-14);
    let out = &mut Vec::new();
    let mut stack = vec![Cell { u: [0.0, 1.0], v: [0.0, 1.0] }];
    let mut undecided = Vec::new();
    let mut looked_at = 0;
    while let Some(cell) = stack.pop() {
        looked_at += 1;
        let wide = cell.enlarged();
        let (pa, pb) = (a.restrict(wide.u[0], wide.u[1]), b.restrict(wide.v[0], wide.v[1]));
        if distance_lower_bound(&pa, &pb) > reach {
            continue;
        }
        let (along_u, along_v) = (Slopes::new(&pa, &pb), Slopes::new(&pb, &pa));
        if along_u.one_sign() || along_v.one_sign() {
            continue;
        }
        let convexity = convexity(&pa, &pb, &along_u, &along_v, &wide);
        if convexity > 0.0 {
            match newton(&a, &b, &wide, convexity) {
                Newton::At(u, v) => {
                    if (a.point(u) - b.point(v)).norm() <= reach {
                        out.push(Closest { u, v, flat: false });
                    }
                    continue;
                }
                Newton::Outside => continue,
                Newton::Unsure => {}
            }
        }
        let size = (cell.u[1] - cell.u[0]).max(cell.v[1] - cell.v[0]);
        if size <= resolution || looked_at > MAX_BOXES {
            undecided.push(cell);
        } else {
            split(&cell, &pa, &pb, &mut stack);
        }
    }
    valleys(&a, &b, reach, &undecided, out);
    // Two boxes that share a border may both have found the minimum on it.
    for (k, c) in out.iter().enumerate() {
        if !out[..k].iter().any(|t| (t.u - c.u).abs() + (t.v - c.v).abs() < 4.0 * BORDER) {
            push(c.u, c.v, c.flat);
        }
    }
}

/// Bernstein coefficients of a third of ∂D/∂u over a box, for each control point of the other curve.
struct Slopes([[f64; 6]; 4]);

impl Slopes {
    fn new(own: &Cubic, other: &Cubic) -> Self {
        Self(other.b.map(|x| stationarity(own, &x)))
    }

    /// Coordinates are of order one: differences below a few ulp are not trusted.
    fn one_sign(&self) -> bool {
        const ROUNDING: f64 = 1e-15;
        let all = || self.0.iter().flatten();
        all().all(|&q| q > ROUNDING) || all().all(|&q| q < -ROUNDING)
    }

    /// Lower bound of a third of ∂²D/∂u² (box parameters).
    fn curvature(&self) -> f64 {
        self.0.iter().flat_map(|q| derivative(q)[..5].to_vec()).fold(f64::INFINITY, f64::min)
    }
}

/// Lower bound of the least eigenvalue of D's Hessian over a box, with respect to the parameters u, v of the whole segments; not positive if
/// that cannot be shown.
fn convexity(a: &Cubic, b: &Cubic, along_u: &Slopes, along_v: &Slopes, cell: &Cell) -> f64 {
    let (du, dv) = (cell.u[1] - cell.u[0], cell.v[1] - cell.v[0]);
    // Slopes are thirds, in the box's own parameters.
    let (uu, vv) = (3.0 * along_u.curvature() / (du * du), 3.0 * along_v.curvature() / (dv * dv));
    if uu <= 0.0 || vv <= 0.0 {
        return 0.0;
    }
    let (e, f) = (a.edges(), b.edges());
    let mixed = 9.0 * e.iter().flat_map(|x| f.iter().map(move |y| x.dot(y).abs())).fold(0.0, f64::max) / (du * dv);
    let det = uu * vv - mixed * mixed * (1.0 + 1e-10);
    let trace = uu + vv;
    2.0 * det / (trace + ((uu - vv) * (uu - vv) + 4.0 * mixed * mixed).sqrt())
}

enum Newton {
    At(f64, f64),
    Outside,
    Unsure,
}

/// The minimum of D over an (enlarged) box on which the least eigenvalue of D's Hessian is above `convexity`; see the module's head for what
/// each answer proves.
fn newton(a: &Cubic, b: &Cubic, cell: &Cell, convexity: f64) -> Newton {
    let clamp = |x: f64, range: [f64; 2]| x.clamp(range[0], range[1]);
    // Resting against the border: D rises inward.
    let rests = |x: f64, range: [f64; 2], slope: f64| (x == range[0] && slope > 0.0) || (x == range[1] && slope < 0.0);
    let (mut u, mut v) = (0.5 * (cell.u[0] + cell.u[1]), 0.5 * (cell.v[0] + cell.v[1]));
    for _ in 0..60 {
        let h = Derivatives::new(a, b, u, v);
        let (gu, gv) = h.slope();
        let held = (rests(u, cell.u, gu), rests(v, cell.v, gv));
        let free = match held {
            (false, false) => gu.hypot(gv),
            (true, false) => gv.abs(),
            (false, true) => gu.abs(),
            (true, true) => 0.0,
        };
        // Coordinates are of order one: points carry a few ulp of it.
        let rounding = 16.0 * f64::EPSILON * (1.0 + h.w.norm()) * (h.da.norm() + h.db.norm());
        let (du, dv) = match held {
            (false, false) => (-(h.vv * gu - h.uv * gv) / h.det(), -(h.uu * gv - h.uv * gu) / h.det()),
            (true, false) => (0.0, -gv / h.vv),
            (false, true) => (-gu / h.uu, 0.0),
            (true, true) => (0.0, 0.0),
        };
        let (nu, nv) = (clamp(u + du, cell.u), clamp(v + dv, cell.v));
        let moved = (nu - u).abs().max((nv - v).abs());
        if moved.is_nan() {
            return Newton::Unsure;
        }
        if moved <= 4.0 * f64::EPSILON {
            let radius = (free + rounding) / convexity;
            return if radius.is_nan() || radius > 0.5 * BORDER {
                Newton::Unsure
            } else if held.0 || held.1 {
                Newton::Outside
            } else {
                Newton::At(u.clamp(0.0, 1.0), v.clamp(0.0, 1.0))
            };
        }
        (u, v) = (nu, nv);
    }
    Newton::Unsure
}

/// Difference of the points, and D's derivatives, at (u, v).
struct Derivatives {
    w: Vec3,
    da: Vec3,
    db: Vec3,
    uu: f64,
    vv: f64,
    uv: f64,
}

impl Derivatives {
    fn new(a: &Cubic, b: &Cubic, u: f64, v: f64) -> Self {
        let ((pa, da, dda), (pb, db, ddb)) = (a.derivatives(u), b.derivatives(v));
        let w = pa - pb;
        Self { w, da, db, uu: da.dot(&da) + w.dot(&dda), vv: db.dot(&db) - w.dot(&ddb), uv: -da.dot(&db) }
    }

    fn det(&self) -> f64 {
        self.uu * self.vv - self.uv * self.uv
    }

    fn slope(&self) -> (f64, f64) {
        (self.w.dot(&self.da), -self.w.dot(&self.db))
    }
}

/// Newton step of D at (u, v); NaN if the second derivative is singular.
fn step(a: &Cubic, b: &Cubic, u: f64, v: f64) -> (f64, f64) {
    let h = Derivatives::new(a, b, u, v);
    let ((gu, gv), det) = (h.slope(), h.det());
    (-(h.vv * gu - h.uv * gv) / det, -(h.uu * gv - h.uv * gu) / det)
}

/// Downhill inside a box of parameters: Newton where D is convex, else each parameter by itself; only steps that lower D are taken.
fn descend(a: &Cubic, b: &Cubic, start: (f64, f64), hu: [f64; 2], hv: [f64; 2]) -> (f64, f64) {
    let value = |u: f64, v: f64| (a.point(u) - b.point(v)).norm_squared();
    let (mut u, mut v) = start;
    let mut here = value(u, v);
    for _ in 0..60 {
        let h = Derivatives::new(a, b, u, v);
        let (gu, gv) = h.slope();
        let convex = h.uu > 0.0 && h.vv > 0.0 && h.det() > 1e-12 * h.uu * h.vv;
        let single = (-gu / (h.uu.abs() + h.uv.abs()), -gv / (h.vv.abs() + h.uv.abs()));
        let full = if convex { step(a, b, u, v) } else { single };
        let mut moved = false;
        for (du, dv) in [full, single] {
            let mut part = 1.0;
            while part > 1e-3 && !moved {
                let (nu, nv) = ((u + part * du).clamp(hu[0], hu[1]), (v + part * dv).clamp(hv[0], hv[1]));
                let there = value(nu, nv);
                if there < here {
                    (u, v, here, moved) = (nu, nv, there, true);
                }
                part *= 0.25;
            }
        }
        if !moved {
            break;
        }
    }
    (u, v)
}

fn split(cell: &Cell, a: &Cubic, b: &Cubic, stack: &mut Vec<Cell>) {
    let extent = |c: &Cubic| c.edges().iter().map(Vec3::norm).sum::<f64>();
    let halves = |r: [f64; 2]| {
        let middle = 0.5 * (r[0] + r[1]);
        [[middle, r[1]], [r[0], middle]]
    };
    if extent(a) >= extent(b) {
        stack.extend(halves(cell.u).map(|u| Cell { u, v: cell.v }));
    } else {
        stack.extend(halves(cell.v).map(|v| Cell { u: cell.u, v }));
    }
}

/// One minimum for each group of undecided boxes that hang together.
fn valleys(a: &Cubic, b: &Cubic, reach: f64, cells: &[Cell], out: &mut Vec<Closest>) {
    let touch = |x: [f64; 2], y: [f64; 2]| x[0] <= y[1] && y[0] <= x[1];
    let mut done = vec![false; cells.len()];
    for k in 0..cells.len() {
        if done[k] {
            continue;
        }
        done[k] = true;
        let mut group = vec![k];
        let mut next = 0;
        while next < group.len() {
            let c = cells[group[next]];
            next += 1;
            for (m, other) in cells.iter().enumerate() {
                if !done[m] && touch(c.u, other.u) && touch(c.v, other.v) {
                    done[m] = true;
                    group.push(m);
                }
            }
        }
        out.extend(deepest(a, b, reach, cells, &group));
    }
}

/// The nearest level point of a group of boxes; of equally near ones the one nearest to the group's middle.
fn deepest(a: &Cubic, b: &Cubic, reach: f64, cells: &[Cell], group: &[usize]) -> Option<Closest> {
    let hull = |get: fn(&Cell) -> [f64; 2]| {
        group.iter().map(|&k| get(&cells[k])).fold([1.0, 0.0], |h: [f64; 2], r| [h[0].min(r[0]), h[1].max(r[1])])
    };
    let (hu, hv) = (hull(|c| c.u), hull(|c| c.v));
    let middle = (0.5 * (hu[0] + hu[1]), 0.5 * (hv[0] + hv[1]));
    let mut points: Vec<(f64, f64, f64)> = Vec::with_capacity(group.len() + 1);
    let starts = group.iter().map(|&k| (0.5 * (cells[k].u[0] + cells[k].u[1]), 0.5 * (cells[k].v[0] + cells[k].v[1])));
    let mut offer = |(u, v): (f64, f64)| -> bool {
        let at = Derivatives::new(a, b, u, v);
        let level = |d: &Vec3| at.w.dot(d).abs() <= LEVEL * at.w.norm() * d.norm() + 4.0 * f64::EPSILON * d.norm();
        let stationary = level(&at.da) && level(&at.db);
        let saddle = at.det() < -1e-9 * (at.uu * at.vv).abs() || at.uu < 0.0 || at.vv < 0.0;
        if stationary && !saddle && at.w.norm() <= reach {
            points.push((at.w.norm(), u, v));
        }
        stationary && saddle
    };
    for start in starts.chain([middle]) {
        let end = descend(a, b, start, hu, hv);
        if offer(end) {
            // Down from the saddle, both ways along the direction it falls in.
            let h = Derivatives::new(a, b, end.0, end.1);
            let angle = 0.5 * (2.0 * h.uv).atan2(h.uu - h.vv) + std::f64::consts::FRAC_PI_2;
            let (dv, du) = (angle.sin_cos().0 * 0.02, angle.sin_cos().1 * 0.02);
            for sign in [-1.0, 1.0] {
                let from = ((end.0 + sign * du).clamp(hu[0], hu[1]), (end.1 + sign * dv).clamp(hv[0], hv[1]));
                offer(descend(a, b, from, hu, hv));
            }
        }
    }
    let least = points.iter().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let off = |p: &(f64, f64, f64)| (p.1 - middle.0).abs() + (p.2 - middle.1).abs();
    let nearest = points.iter().filter(|p| p.0 <= least * (1.0 + 1e-12) + 4.0 * f64::EPSILON);
    nearest.min_by(|x, y| off(x).total_cmp(&off(y))).map(|&(_, u, v)| Closest { u, v, flat: true })
}
