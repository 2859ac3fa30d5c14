//! All bilateral local minima of the distance between two cubics.
//!
//! With D(u, v) = ½|a(u) − b(v)|² the square \[0, 1\]² of parameters is cut into [cells](cell) until each is decided:
//!
//! * *dropped* if the curves are out of range there, if D_u or D_t keeps its sign, or if D is concave along u or t all
//!   over it;
//! * *convex* if every Hessian has its least eigenvalue above some m > 0: then Newton's method ends in its only minimum
//!   or at its border;
//! * *narrowed* to the part where D_u and D_t can vanish (the hull of their Bernstein coefficients against the axis, as
//!   in Bézier clipping: Sederberg & Nishita 1990), which converges quadratically;
//! * *sheared* along the valley of D that crosses it, so that it may be narrowed to a thin strip;
//! * else halved.
//!
//! **Proof.** Cells are enlarged by β = 1e-9 on all sides, and every bound includes its rounding. On a convex cell the
//! mean H̄ of the Hessians between a point p and a stationary point q obeys the cell's bounds, and ∇D(p) = H̄ (p − q).
//! So (i) there is at most one stationary point, and it is a minimum; (ii) from the slopes at p, rounding included,
//! follow bounds of its distances from p along u and t; (iii) if p is farther than these from the border, there is one;
//! (iv) if p rests against the border with the slope there rising inward, that slope bounds how far inside q can be,
//! often not at all. The search ends in a convex cell only by (iii), or by (iv) with less than β/4, when the minimum
//! lies outside the cell proper. Otherwise the cell is cut on. Hence *all minima outside undecided cells are found,
//! each once, and nothing else*. (A minimum within β of the end of a segment is reported at that end.)
//!
//! **Undecided cells.** First, a cell along which D_u is zero to the rounding of the coordinates as given (parallel or
//! coincident curves): it is *level*: every point of it is a minimum within the accuracy of f64. Second, the cells that
//! remain after [`CELLS`] × sampling cells: parallel curves of different speed, minima that merge with saddles to
//! within rounding. A connected group of undecided cells gives one minimum, marked `flat`, at its nearest level point;
//! a group without a level point gives none.

mod cell;
mod valley;

use cell::{BORDER, Bounds, CellParallelogram};

use crate::contact::curves::curve::Cubic;
use crate::contact::measures::{MAX_STEPS, SUM_ROUNDING};
use crate::math::Vec3;

/// Cells examined for one pair, times the sampling, because parallel curves of different speed have cells without end;
/// the rest is undecided.
const CELLS: usize = 64;
/// Smallest width of a cell that is cut, because the borders of smaller ones are a large part of them.
const SMALLEST: f64 = 1e-8;
/// Fraction at which cells are cut, not the middle, because minima of symmetric cases would lie on borders.
const CUT: f64 = 0.4837;
/// Fraction to which a cell must be clipped, or sheared, to be examined again before it is cut, because with less gain
/// a cut does better.
const WORTH: f64 = 0.7;
/// Smallest fraction that a cell is clipped to at once, because bounds of second derivatives over very narrow cells are
/// lost in rounding.
const LEAST: f64 = 0.05;

/// A local minimum at parameters u, v, known to `radius`.
#[derive(Clone, Copy, Debug)]
struct Closest {
    u: f64,
    v: f64,
    radius: f64,
    flat: bool,
}

/// All local minima with distance ≤ `max_distance` \[L\] at which both curves are stationary (ends and kinks excluded),
/// each passed to `push(u, v, flat)`. `sampling` bounds the work, see the module's header.
pub(crate) fn minima(a: &Cubic, b: &Cubic, max_distance: f64, sampling: usize, mut push: impl FnMut(f64, f64, bool)) {
    let origin = b.b[0];
    let far = a.b.iter().chain(&b.b).map(Vec3::amax).fold(0.0, f64::max);
    let (a, b) = (a.b.map(|p| p - origin), b.b.map(|p| p - origin));
    let scale = a.iter().chain(&b).map(Vec3::amax).fold(0.0, f64::max);
    let usable = scale > 0.0 && scale.is_finite();
    if !usable {
        return;
    }
    let (a, b) = (Cubic { b: a.map(|p| p / scale) }, Cubic { b: b.map(|p| p / scale) });
    let search = MinimumSearch {
        a,
        b,
        reach: max_distance / scale * (1.0 + SUM_ROUNDING),
        noise: 16.0 * f64::EPSILON * (far / scale),
    };
    let mut found = search.run(CELLS * sampling);
    // The same minimum may have been found in two cells.
    found.sort_by_key(|x| x.flat);
    for (k, c) in found.iter().enumerate() {
        let same = |t: &Closest| (t.u - c.u).abs().max((t.v - c.v).abs()) <= 4.0 * BORDER + 2.0 * (t.radius + c.radius);
        if !found[..k].iter().any(same) {
            push(c.u, c.v, c.flat);
        }
    }
}

/// Two cubics with coordinates of order one.
struct MinimumSearch {
    a: Cubic,
    b: Cubic,
    reach: f64,
    /// Error of slopes from the rounding of the coordinates as they were given.
    noise: f64,
}

enum CellVerdict {
    Dropped,
    Minimum(Closest),
    /// D is constant along the cell up to rounding.
    Level,
    Undecided,
    /// Cell to be examined instead.
    One(CellParallelogram),
    Two([CellParallelogram; 2]),
}

/// A cell with the bounds of D's derivatives over it, enlarged.
struct BoundedCell<'a> {
    cell: &'a CellParallelogram,
    wide: &'a CellParallelogram,
    bounds: &'a Bounds,
    /// Ranges of D_tt, D_ut, D_uu.
    curvatures: &'a [[f64; 2]; 3],
}

impl MinimumSearch {
    fn run(&self, max_cells: usize) -> Vec<Closest> {
        let mut found = Vec::new();
        let mut undecided = Vec::new();
        let mut stack = vec![CellParallelogram::WHOLE];
        let mut looked_at = 0;
        while let Some(cell) = stack.pop() {
            looked_at += 1;
            if looked_at > max_cells {
                undecided.push((cell, false));
                continue;
            }
            match self.examine(&cell) {
                CellVerdict::Dropped => {}
                CellVerdict::Minimum(closest) => found.push(closest),
                CellVerdict::Level => undecided.push((cell, true)),
                CellVerdict::Undecided => undecided.push((cell, false)),
                CellVerdict::One(cell) => stack.push(cell),
                CellVerdict::Two(cells) => stack.extend(cells),
            }
        }
        if !undecided.is_empty() {
            self.valleys(&undecided, &mut found);
        }
        found
    }

    /// The curves in the order of a cell.
    fn curves(&self, cell: &CellParallelogram) -> (&Cubic, &Cubic) {
        if cell.flipped { (&self.b, &self.a) } else { (&self.a, &self.b) }
    }

    fn examine(&self, cell: &CellParallelogram) -> CellVerdict {
        let (a, b) = self.curves(cell);
        let [low, high] = cell.v_range();
        if low > 1.0 + BORDER || high < -BORDER {
            return CellVerdict::Dropped;
        }
        let wide = cell.enlarged();
        let bounds = Bounds::new(a, b, &wide);
        // A level cell is neither dropped nor shortened, because its slopes are rounding.
        let level = bounds.level(self.noise);
        let [along_t, along_u] = bounds.slopes();
        if bounds.beyond(self.reach) || along_t || (along_u && !level) {
            return CellVerdict::Dropped;
        }
        let curvatures = bounds.curvatures();
        let bounded = BoundedCell { cell, wide: &wide, bounds: &bounds, curvatures: &curvatures };
        let [tt, _, uu] = curvatures;
        if level && tt[0] > 0.0 {
            return self.cut(&bounded, true);
        }
        // At a corner of the square D may fall into another pair of segments.
        let corner = (cell.u[0] <= 0.0 || cell.u[1] >= 1.0) && (low <= 0.0 || high >= 1.0);
        if tt[1] < 0.0 || (uu[1] < 0.0 && !corner) {
            return CellVerdict::Dropped;
        }
        let convexity = convexity(&curvatures);
        if convexity > 0.0 {
            match self.newton(&wide, convexity, &curvatures) {
                Newton::At(found) => return CellVerdict::Minimum(found),
                Newton::Outside => return CellVerdict::Dropped,
                Newton::Unsure => {}
            }
        }
        self.cut(&bounded, false)
    }

    /// The cell clipped, sheared along a valley, or cut in two; a level cell is only cut across.
    fn cut(&self, bounded: &BoundedCell, level: bool) -> CellVerdict {
        let BoundedCell { cell, wide, bounds, curvatures } = *bounded;
        let [part_u, part_t] = bounds.clipped();
        let part_u = if level { Some([0.0, 1.0]) } else { part_u };
        let (Some(part_u), Some(part_t)) = (part_u, part_t) else { return CellVerdict::Dropped };
        let narrowed = |range: [f64; 2], wide: [f64; 2], part: [f64; 2]| {
            let at = |x: f64| wide[0] + x * (wide[1] - wide[0]);
            let [from, to] = if part[1] - part[0] < LEAST {
                let middle = 0.5 * (part[0] + part[1]);
                [middle - 0.5 * LEAST, middle + 0.5 * LEAST]
            } else {
                part
            };
            [range[0].max(at(from)), range[1].min(at(to))]
        };
        let (u, t) = (narrowed(cell.u, wide.u, part_u), narrowed(cell.t, wide.t, part_t));
        if u[0] > u[1] || t[0] > t[1] {
            return CellVerdict::Dropped;
        }
        let [du, dt] = cell.width();
        let narrow = cell.with_t(t).with_u(u);
        let [new_du, new_dt] = narrow.width();
        // Strips thinner than the borders are not worth it.
        let gains = |new: f64, old: f64| new < WORTH * old && old > BORDER;
        if gains(new_du, du) || gains(new_dt, dt) {
            return CellVerdict::One(narrow);
        }
        if level {
            return CellVerdict::Level;
        }
        if let Some(sheared) = self.along_valley(&narrow, curvatures) {
            return CellVerdict::One(sheared);
        }
        if du.max(dt) <= SMALLEST {
            return CellVerdict::Undecided;
        }
        CellVerdict::Two(self.halves(&narrow))
    }

    /// The cell sheared along the valley that crosses it, if there provably is one and the valley crosses much of the
    /// cell's width.
    fn along_valley(&self, cell: &CellParallelogram, [tt, _, uu]: &[[f64; 2]; 3]) -> Option<CellParallelogram> {
        let (a, b) = self.curves(cell);
        let h = DistanceDerivatives::new(a, b, cell.middle(), cell.v(cell.middle(), 0.5 * (cell.t[0] + cell.t[1])));
        let steeper = cell.slope == 0.0 && h.uu > h.vv;
        let (cell, slope, valley) =
            if steeper { (cell.exchanged(), -h.uv / h.uu, uu[0] > 0.0) } else { (*cell, -h.uv / h.vv, tt[0] > 0.0) };
        let [du, dt] = cell.width();
        let across = (slope - cell.slope).abs() * du;
        (valley && across > (1.0 - WORTH) * dt && across > BORDER).then(|| cell.sheared(slope))
    }

    fn halves(&self, cell: &CellParallelogram) -> [CellParallelogram; 2] {
        let (a, b) = self.curves(cell);
        let [du, dt] = cell.width();
        let extent = |c: &Cubic| c.edges().iter().map(Vec3::norm).sum::<f64>();
        let at = |r: [f64; 2]| r[0] + CUT * (r[1] - r[0]);
        if du * extent(a) >= dt * extent(b) {
            let middle = at(cell.u);
            [cell.with_u([middle, cell.u[1]]), cell.with_u([cell.u[0], middle])]
        } else {
            let middle = at(cell.t);
            [cell.with_t([middle, cell.t[1]]), cell.with_t([cell.t[0], middle])]
        }
    }

    /// The minimum of D over an (enlarged) cell on which the least eigenvalue of D's Hessian with respect to u and t is
    /// above `convexity`; the module's header states what each answer proves.
    fn newton(&self, cell: &CellParallelogram, convexity: f64, curvatures: &[[f64; 2]; 3]) -> Newton {
        let (a, b) = self.curves(cell);
        let clamp = |x: f64, range: [f64; 2]| x.clamp(range[0], range[1]);
        // At the border with D rising inward.
        let rests =
            |x: f64, range: [f64; 2], slope: f64| (x == range[0] && slope > 0.0) || (x == range[1] && slope < 0.0);
        let (mut u, mut t) = (cell.middle(), 0.5 * (cell.t[0] + cell.t[1]));
        for _ in 0..MAX_STEPS {
            let h = DistanceDerivatives::new(a, b, u, cell.v(u, t)).sheared(cell.slope);
            let (gu, gt) = (h.gu, h.gv);
            let held = (rests(u, cell.u, gu), rests(t, cell.t, gt));
            let (du, dt) = match held {
                (false, false) => (-(h.vv * gu - h.uv * gt) / h.det(), -(h.uu * gt - h.uv * gu) / h.det()),
                (true, false) => (0.0, -gt / h.vv),
                (false, true) => (-gu / h.uu, 0.0),
                (true, true) => (0.0, 0.0),
            };
            let (nu, nt) = (clamp(u + du, cell.u), clamp(t + dt, cell.t));
            let moved = (nu - u).abs().max((nt - t).abs());
            if moved.is_nan() {
                return Newton::Unsure;
            }
            if moved <= 4.0 * f64::EPSILON {
                let nearness = Nearness::new(curvatures, convexity, [gu.abs(), gt.abs()], h.rounding);
                if held.0 || held.1 {
                    return if nearness.beyond(held) { Newton::Outside } else { Newton::Unsure };
                }
                let inside = |x: f64, r: [f64; 2], radius: f64| x - r[0] > radius && r[1] - x > radius;
                let [ru, rt] = nearness.radii();
                let is_inside = inside(u, cell.u, ru) && inside(t, cell.t, rt);
                return if is_inside { self.minimum_at(cell, u, t, ru.max(rt)) } else { Newton::Unsure };
            }
            (u, t) = (nu, nt);
        }
        Newton::Unsure
    }

    /// The minimum at (u, t), if it lies on both segments and in range.
    fn minimum_at(&self, cell: &CellParallelogram, u: f64, t: f64, radius: f64) -> Newton {
        let v = cell.v(u, t);
        let on = |x: f64| (-BORDER..=1.0 + BORDER).contains(&x);
        let (u, v) = if cell.flipped { (v, u) } else { (u, v) };
        if !on(u) || !on(v) {
            return Newton::Outside;
        }
        let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
        if (self.a.point(u) - self.b.point(v)).norm() > self.reach {
            return Newton::Outside;
        }
        Newton::At(Closest { u, v, radius: radius * (1.0 + cell.slope.abs()), flat: false })
    }
}

/// Where a stationary point q of a convex cell can lie, seen from a point p of it with the slopes `slope` (magnitudes,
/// known to `rounding`): from ∇D(p) = H̄ (p − q), H̄ a mean of Hessians, one line at a time.
struct Nearness {
    uu: f64,
    tt: f64,
    /// Largest |D_ut|.
    mixed: f64,
    convexity: f64,
    slope: [f64; 2],
    rounding: f64,
}

impl Nearness {
    fn new([tt, ut, uu]: &[[f64; 2]; 3], convexity: f64, slope: [f64; 2], rounding: f64) -> Self {
        Self { uu: uu[0], tt: tt[0], mixed: ut[0].abs().max(ut[1].abs()), convexity, slope, rounding }
    }

    /// Bounds of |p − q| along u and t.
    fn radii(&self) -> [f64; 2] {
        let [gu, gt] = self.slope.map(|g| g + self.rounding);
        let ru = (gu + self.mixed * gt / self.tt) / (self.uu - self.mixed * self.mixed / self.tt);
        [ru, (gt + self.mixed * ru) / self.tt]
    }

    /// p rests against the border in the directions `held`: no q lies in the cell by more than β/4.
    fn beyond(&self, held: (bool, bool)) -> bool {
        let ([gu, gt], r, c) = (self.slope, self.rounding, self.mixed);
        // Slope missing at the border to exclude q, and the distance that q can then lie inside.
        let one = |held: f64, free: f64, stiff_held: f64, stiff_free: f64| {
            let lacks = c * (free + r) / stiff_free + r - held;
            lacks <= 0.0 || lacks / (stiff_held - c * c / stiff_free) < 0.25 * BORDER
        };
        match held {
            (true, true) => gu.min(gt) > r || 2.0 * r / self.convexity < 0.25 * BORDER,
            (true, false) => one(gu, gt, self.uu, self.tt),
            _ => one(gt, gu, self.tt, self.uu),
        }
    }
}

enum Newton {
    At(Closest),
    /// No minimum on this cell's part of the segments, or out of range.
    Outside,
    Unsure,
}

/// Lower bound of the least eigenvalue of D's Hessian from the intervals of D_tt, D_ut, D_uu; not positive if that
/// cannot be shown.
fn convexity([tt, ut, uu]: &[[f64; 2]; 3]) -> f64 {
    let (uu, tt, mixed) = (uu[0], tt[0], ut[0].abs().max(ut[1].abs()));
    if !(uu > 0.0 && tt > 0.0) {
        return 0.0;
    }
    let det = uu * tt - mixed * mixed * (1.0 + SUM_ROUNDING);
    2.0 * det / (uu + tt + ((uu - tt) * (uu - tt) + 4.0 * mixed * mixed).sqrt())
}

/// Difference of the points, and D's derivatives, at (u, v).
struct DistanceDerivatives {
    w: Vec3,
    da: Vec3,
    db: Vec3,
    gu: f64,
    gv: f64,
    uu: f64,
    vv: f64,
    uv: f64,
    /// Bound of the roundings of the slopes: coordinates are of order one, points carry a few ulp of it.
    rounding: f64,
}

impl DistanceDerivatives {
    fn new(a: &Cubic, b: &Cubic, u: f64, v: f64) -> Self {
        let ((pa, da, dda), (pb, db, ddb)) = (a.derivatives(u), b.derivatives(v));
        let w = pa - pb;
        Self {
            gu: w.dot(&da),
            gv: -w.dot(&db),
            uu: da.dot(&da) + w.dot(&dda),
            vv: db.dot(&db) - w.dot(&ddb),
            uv: -da.dot(&db),
            rounding: 16.0 * f64::EPSILON * (1.0 + w.norm()) * (da.norm() + db.norm()),
            w,
            da,
            db,
        }
    }

    /// With respect to u along v = … + slope u, and v.
    fn sheared(self, slope: f64) -> Self {
        Self {
            gu: self.gu + slope * self.gv,
            uu: self.uu + slope * (2.0 * self.uv + slope * self.vv),
            uv: self.uv + slope * self.vv,
            rounding: self.rounding * (1.0 + slope.abs()),
            ..self
        }
    }

    fn det(&self) -> f64 {
        self.uu * self.vv - self.uv * self.uv
    }
}
