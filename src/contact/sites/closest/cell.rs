//! A parallelogram of parameters, and bounds of D(u, v) = ½|a(u) − b(v)|² over it.
//!
//! In the coordinates u and t, v = v₀ + s (u − u₀) + t, the difference w = a − b of the curves is a bicubic polynomial
//! in Bernstein form, and with it
//!
//! ```text
//!     D_t = −w·b′,      D_u = w·(a′ − s b′)        (t held)
//! ```
//!
//! are of degree (5, 5). Their coefficients bound them, the differences of neighbouring coefficients bound the second
//! derivatives. The slope s lets a cell lie along a valley of D, where D_u changes slowly: cells along a contact line
//! may be long and thin, instead of as small as the valley is level.

use crate::contact::curves::curve::Cubic;
use crate::contact::measures::SUM_ROUNDING;
use crate::math::Vec3;

/// β, as a segment's parameter: cells overlap by twice this, because rounding could lose a minimum on a border.
pub(super) const BORDER: f64 = 1e-9;
/// Binomial coefficients, because products of Bernstein polynomials are sums of products of coefficients weighted with
/// them.
const C2: [f64; 3] = [1.0, 2.0, 1.0];
const C3: [f64; 4] = [1.0, 3.0, 3.0, 1.0];
const C5: [f64; 6] = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];

/// {(u, v): u in `u`, v − v₀ − s (u − u₀) in `t`}, u₀ the middle of `u`.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellParallelogram {
    /// The curves are exchanged: u is the parameter of the second.
    pub(super) flipped: bool,
    pub(super) u: [f64; 2],
    pub(super) v0: f64,
    pub(super) slope: f64,
    pub(super) t: [f64; 2],
}

impl CellParallelogram {
    pub(super) const WHOLE: Self = Self { flipped: false, u: [0.0, 1.0], v0: 0.5, slope: 0.0, t: [-0.5, 0.5] };

    pub(super) fn middle(&self) -> f64 {
        0.5 * (self.u[0] + self.u[1])
    }

    pub(super) fn v(&self, u: f64, t: f64) -> f64 {
        self.v0 + self.slope * (u - self.middle()) + t
    }

    /// Smallest interval of v.
    pub(super) fn v_range(&self) -> [f64; 2] {
        let half = 0.5 * (self.slope * (self.u[1] - self.u[0])).abs();
        [self.v0 + self.t[0] - half, self.v0 + self.t[1] + half]
    }

    pub(super) fn width(&self) -> [f64; 2] {
        [self.u[1] - self.u[0], self.t[1] - self.t[0]]
    }

    pub(super) fn enlarged(&self) -> Self {
        let wide = |r: [f64; 2], by: f64| [r[0] - by, r[1] + by];
        Self { u: wide(self.u, BORDER), t: wide(self.t, 2.0 * BORDER), ..*self }
    }

    /// The part with u in the given interval.
    pub(super) fn with_u(&self, u: [f64; 2]) -> Self {
        Self { u, v0: self.v(0.5 * (u[0] + u[1]), 0.0), ..*self }
    }

    pub(super) fn with_t(&self, t: [f64; 2]) -> Self {
        Self { t, ..*self }
    }

    /// A cell of another slope that contains this one.
    pub(super) fn sheared(&self, slope: f64) -> Self {
        let more = 0.5 * ((slope - self.slope) * (self.u[1] - self.u[0])).abs();
        Self { slope, t: [self.t[0] - more, self.t[1] + more], ..*self }
    }

    /// A cell of slope 0 with the curves exchanged.
    pub(super) fn exchanged(&self) -> Self {
        let u0 = self.middle();
        Self {
            flipped: !self.flipped,
            u: [self.v0 + self.t[0], self.v0 + self.t[1]],
            v0: u0,
            slope: 0.0,
            t: self.u.map(|u| u - u0),
        }
    }
}

/// Bernstein coefficients over a cell: first index along u, second along t.
pub(super) struct Bounds {
    w: [[Vec3; 4]; 4],
    /// −D_t.
    q: [[f64; 6]; 6],
    /// D_u.
    g: [[f64; 6]; 6],
    width: [f64; 2],
    /// Bound of the roundings of `q` and `g`.
    rounding: f64,
    /// Bound of |b′|.
    speed: f64,
}

/// Least and largest of some numbers.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |r, x| [r[0].min(x), r[1].max(x)])
}

impl Bounds {
    /// `a` and `b` already in the order of the cell.
    pub(super) fn new(a: &Cubic, b: &Cubic, cell: &CellParallelogram) -> Self {
        let [du, dt] = cell.width();
        let pa = a.restrict(cell.u[0], cell.u[1]);
        let (first, along) = (cell.v(cell.u[0], cell.t[0]), cell.slope * du);
        // b and b′ as polynomials in y = v − first.
        let (k0, k1, second) = b.derivatives(first);
        let [e0, e1, e2] = b.edges();
        let (k2, k3) = (second * 0.5, e2 - e1 * 2.0 + e0);
        let zero = Vec3::zeros();
        let (s1, s2, s3) = (along, along * along, along * along * along);
        let (t1, t2, t3) = (dt, dt * dt, dt * dt * dt);
        let monomials = [
            [k0, k1 * t1, k2 * t2, k3 * t3],
            [k1 * s1, k2 * (2.0 * s1 * t1), k3 * (3.0 * s1 * t2), zero],
            [k2 * s2, k3 * (3.0 * s2 * t1), zero, zero],
            [k3 * s3, zero, zero, zero],
        ];
        let mut w = bernstein3(&monomials);
        for i in 0..4 {
            for j in 0..4 {
                w[i][j] = pa.b[i] - w[i][j];
            }
        }
        let (l0, l1, l2) = (k1, k2 * 2.0, k3 * 3.0);
        let d = bernstein2(&[[l0, l1 * t1, l2 * t2], [l1 * s1, l2 * (2.0 * s1 * t1), zero], [l2 * s2, zero, zero]]);
        let edges = hodograph(a, cell.u);
        let (q, p) = products(&w, &d, &edges);
        let mut g = p;
        for k in 0..6 {
            for l in 0..6 {
                g[k][l] -= cell.slope * q[k][l];
            }
        }
        let fastest = |v: &mut dyn Iterator<Item = &Vec3>| v.map(Vec3::norm_squared).fold(0.0, f64::max).sqrt();
        let speed = fastest(&mut d.iter().flatten()).max(fastest(&mut edges.iter()));
        // The error of w times the speed, and ulps of the speed times w.
        let far = fastest(&mut w.iter().flatten());
        let rounding = SUM_ROUNDING * (1.0 + far) * speed * (1.0 + cell.slope.abs());
        Self { w, q, g, width: [du, dt], rounding, speed }
    }

    /// The curves are farther apart than `reach` all over the cell: w has more than that along its direction in the
    /// middle.
    pub(super) fn beyond(&self, reach: f64) -> bool {
        let middle = self.w[1][1] + self.w[1][2] + self.w[2][1] + self.w[2][2];
        let limit = (reach + 4.0 * SUM_ROUNDING) * middle.norm() * (1.0 + SUM_ROUNDING);
        self.w.iter().flatten().all(|w| w.dot(&middle) > limit)
    }

    /// D_t keeps its sign, D_u keeps its sign.
    pub(super) fn slopes(&self) -> [bool; 2] {
        let one_sign = |c: &[[f64; 6]; 6]| {
            let up = c[0][0] > 0.0;
            c.iter().flatten().all(|&x| if up { x > self.rounding } else { x < -self.rounding })
        };
        [one_sign(&self.q), one_sign(&self.g)]
    }

    /// Whether |D_u| is everywhere within the error of coordinates that are uncertain by `noise`.
    pub(super) fn level(&self, noise: f64) -> bool {
        let limit = self.rounding + noise * self.speed;
        self.g.iter().flatten().all(|x| x.abs() <= limit)
    }

    /// Intervals of D_tt, D_ut, D_uu.
    pub(super) fn curvatures(&self) -> [[f64; 2]; 3] {
        let [du, dt] = self.width;
        let pairs = || (0..5).flat_map(|k| (0..6).map(move |l| (k, l)));
        let scaled = |r: [f64; 2], width: f64| {
            [5.0 * (r[0] - 2.0 * self.rounding) / width, 5.0 * (r[1] + 2.0 * self.rounding) / width]
        };
        let tt = range(pairs().map(|(l, k)| self.q[k][l] - self.q[k][l + 1]));
        let ut = range(pairs().map(|(k, l)| self.q[k][l] - self.q[k + 1][l]));
        let uu = range(pairs().map(|(k, l)| self.g[k + 1][l] - self.g[k][l]));
        [scaled(tt, dt), scaled(ut, du), scaled(uu, du)]
    }

    /// The parts of the cell's intervals of u and t (in 0..1) outside of which D_u or D_t has no zero: the hull of the
    /// coefficients against the axis.
    pub(super) fn clipped(&self) -> [Option<[f64; 2]>; 2] {
        let rows = |c: &[[f64; 6]; 6], k: usize| range(c[k].iter().copied());
        let columns = |c: &[[f64; 6]; 6], l: usize| range(c.iter().map(|row| row[l]));
        let wide = |r: [f64; 2]| [r[0] - self.rounding, r[1] + self.rounding];
        [
            clip(&std::array::from_fn(|k| wide(rows(&self.g, k)))),
            clip(&std::array::from_fn(|l| wide(columns(&self.q, l)))),
        ]
    }
}

/// Where the convex hull of the points (k/5, low), (k/5, high) meets the axis.
fn clip(bounds: &[[f64; 2]; 6]) -> Option<[f64; 2]> {
    let points = || bounds.iter().enumerate().flat_map(|(k, b)| b.map(|y| (0.2 * k as f64, y)));
    let mut found = [f64::INFINITY, f64::NEG_INFINITY];
    for (x0, below) in points().filter(|p| p.1 <= 0.0) {
        for (x1, above) in points().filter(|p| p.1 >= 0.0) {
            let rise = above - below;
            let at = if rise > 0.0 { x0 + (x1 - x0) * (-below / rise) } else { x0 };
            found = [found[0].min(at), found[1].max(at)];
        }
    }
    (found[0] <= found[1]).then(|| [found[0].max(0.0), found[1].min(1.0)])
}

/// Control points of c′ on an interval.
fn hodograph(c: &Cubic, [u0, u1]: [f64; 2]) -> [Vec3; 3] {
    let [e0, e1, e2] = c.edges();
    let mix = |x: Vec3, y: Vec3, t: f64| x * (1.0 - t) + y * t;
    let blossom = |s: f64, t: f64| mix(mix(e0, e1, s), mix(e1, e2, s), t) * 3.0;
    [blossom(u0, u0), blossom(u0, u1), blossom(u1, u1)]
}

/// Bernstein coefficients of Σ m_ij uⁱ tʲ, degree (3, 3).
fn bernstein3(m: &[[Vec3; 4]; 4]) -> [[Vec3; 4]; 4] {
    let line = |c: [Vec3; 4]| {
        let (third1, third2) = (c[1] / 3.0, c[2] / 3.0);
        [c[0], c[0] + third1, c[0] + third1 * 2.0 + third2, c[0] + c[1] + c[2] + c[3]]
    };
    let rows = m.map(line);
    let columns: [[Vec3; 4]; 4] = std::array::from_fn(|j| line(std::array::from_fn(|i| rows[i][j])));
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]))
}

/// The same, degree (2, 2).
fn bernstein2(m: &[[Vec3; 3]; 3]) -> [[Vec3; 3]; 3] {
    let line = |c: [Vec3; 3]| [c[0], c[0] + c[1] / 2.0, c[0] + c[1] + c[2]];
    let rows = m.map(line);
    let columns: [[Vec3; 3]; 3] = std::array::from_fn(|j| line(std::array::from_fn(|i| rows[i][j])));
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]))
}

/// Coefficients of w·d and w·e, degree (5, 5); e depends on u only.
fn products(w: &[[Vec3; 4]; 4], d: &[[Vec3; 3]; 3], e: &[Vec3; 3]) -> ([[f64; 6]; 6], [[f64; 6]; 6]) {
    let d: [[Vec3; 3]; 3] = std::array::from_fn(|p| std::array::from_fn(|r| d[p][r] * (C2[p] * C2[r])));
    let e: [Vec3; 3] = std::array::from_fn(|p| e[p] * C2[p]);
    let (mut q, mut low) = ([[0.0; 6]; 6], [[0.0; 4]; 6]);
    for i in 0..4 {
        for j in 0..4 {
            let x = w[i][j] * (C3[i] * C3[j]);
            for p in 0..3 {
                low[i + p][j] += x.dot(&e[p]);
                for r in 0..3 {
                    q[i + p][j + r] += x.dot(&d[p][r]);
                }
            }
        }
    }
    let mut p = [[0.0; 6]; 6];
    for k in 0..6 {
        for j in 0..4 {
            for r in 0..3 {
                p[k][j + r] += low[k][j] * C2[r];
            }
        }
        for l in 0..6 {
            let scale = 1.0 / (C5[k] * C5[l]);
            q[k][l] *= scale;
            p[k][l] *= scale;
        }
    }
    (q, p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    /// Coefficients against the functions, bounds against samples, on cells of all kinds.
    #[test]
    fn coefficients_and_bounds() {
        let mut numbers = Random(3);
        let mut random = || numbers.unit();
        for _ in 0..300 {
            let mut cubic = || Cubic { b: std::array::from_fn(|_| Vec3::new(random(), random(), random())) };
            let (a, b) = (cubic(), cubic());
            let u = 0.5 * random();
            let cell = CellParallelogram {
                u: [u, u + 0.01 + 0.5 * random().abs()],
                v0: 0.5 + 0.3 * random(),
                slope: random(),
                t: [-0.2 * random().abs() - 1e-3, 0.1],
                flipped: false,
            };
            let bounds = Bounds::new(&a, &b, &cell);
            let [tt, ut, uu] = bounds.curvatures();
            let [clip_u, clip_t] = bounds.clipped();
            let value = |c: &[[f64; 6]; 6], x: f64, y: f64| {
                let rows: Vec<f64> = c.iter().map(|row| crate::math::bernstein::eval(row, y)).collect();
                crate::math::bernstein::eval(&rows, x)
            };
            let mut last: Option<(f64, f64)> = None;
            for k in 0..400 {
                let (x, y) = (f64::from(k % 20) / 19.0, f64::from(k / 20) / 19.0);
                let (u, t) = (cell.u[0] + x * cell.width()[0], cell.t[0] + y * cell.width()[1]);
                let ((pa, da, dda), (pb, db, ddb)) = (a.derivatives(u), b.derivatives(cell.v(u, t)));
                let w = pa - pb;
                let along = da - db * cell.slope;
                let (dt, du) = (-w.dot(&db), w.dot(&along));
                assert!((value(&bounds.q, x, y) + dt).abs() < bounds.rounding, "{dt}");
                assert!((value(&bounds.g, x, y) - du).abs() < bounds.rounding, "{du}");
                let inside = |r: [f64; 2], z: f64| z >= r[0] && z <= r[1];
                assert!(inside(tt, db.dot(&db) - w.dot(&ddb)));
                assert!(inside(ut, -along.dot(&db) - w.dot(&ddb) * cell.slope));
                assert!(inside(uu, along.dot(&along) + w.dot(&(dda - ddb * (cell.slope * cell.slope)))));
                if let (Some((dt0, _)), true) = (last, k % 20 > 0) {
                    // A zero of D_t between two samples of the same t lies within the clip.
                    assert!(
                        dt0.signum() == dt.signum() || clip_t.is_some_and(|c| inside([c[0] - 1e-12, c[1] + 1e-12], y))
                    );
                }
                assert!(du.abs() > 1e-3 || du.abs() > bounds.rounding || clip_u.is_some_and(|c| inside(c, x)));
                last = Some((dt, du));
            }
        }
    }
}
