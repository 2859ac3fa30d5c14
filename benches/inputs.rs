//! Deterministic polylines for contact benchmarks: plectoneme, plectoneme on a coil, worm-like chain, crowded sphere.
//! Rod radius 1 and edge length 1 (about); N segments, N + 1 points. Transcendental functions may differ in the last
//! bit from one machine to the next, which the random walks amplify: compare counts, not bits.

use supercoil::math::{Mat3, Vec3};

/// Which polyline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Straight plectonemic hairpin: two strands of superhelix radius 0.99 (2 % overlap), opening angle 55°, end loop.
    Plecto,
    /// The same double strand wound about a worm-like chain (persistence length 100).
    Plectocoil,
    /// Worm-like chain, persistence length 50, crossing itself freely.
    Wlc,
    /// The same, reflected inside a sphere at 10 % volume fraction.
    Packed,
}

impl Kind {
    /// All four.
    pub const ALL: [Self; 4] = [Self::Plecto, Self::Plectocoil, Self::Wlc, Self::Packed];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Plecto => "plecto",
            Self::Plectocoil => "plectocoil",
            Self::Wlc => "wlc",
            Self::Packed => "packed",
        }
    }

    /// Name for a reader.
    #[allow(dead_code, reason = "not every user draws")]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Plecto => "plectoneme",
            Self::Plectocoil => "plectoneme on a coil",
            Self::Wlc => "worm-like chain",
            Self::Packed => "crowded sphere",
        }
    }

    /// The N + 1 points.
    pub fn points(self, n: usize) -> Vec<Vec3> {
        match self {
            Self::Plecto => plecto(n, false),
            Self::Plectocoil => plecto(n, true),
            Self::Wlc => chain(n, 1.0, 50.0, 12345, None),
            Self::Packed => chain(n, 1.0, 50.0, 777, Some((3.0 * n as f64 / (4.0 * 0.10)).cbrt())),
        }
    }

    /// Counts found by an independent program: pairs i + 2 ≤ j with overlapping boxes inflated by the radius; of these,
    /// chords closer than 2; of these, j − i above ⌈π r/h⌉ with h the mean edge.
    pub const fn reference(self, n: usize) -> Option<[usize; 3]> {
        match (self, n) {
            (Self::Plecto, 10_000) => Some([54_476, 34_957, 14_974]),
            (Self::Plectocoil, 10_000) => Some([54_328, 32_036, 15_462]),
            (Self::Wlc, 10_000) => Some([20_589, 19_995, 0]),
            (Self::Packed, 10_000) => Some([39_901, 29_919, 9_787]),
            (Self::Plecto, 100_000) => Some([545_344, 349_957, 149_974]),
            (Self::Plectocoil, 100_000) => Some([544_103, 320_783, 155_095]),
            (Self::Wlc, 100_000) => Some([205_900, 200_186, 191]),
            (Self::Packed, 100_000) => Some([401_725, 298_160, 97_552]),
            _ => None,
        }
    }
}

/// Number of following segments that count as neighbours, ⌈π r / mean edge⌉.
pub fn neighbours(points: &[Vec3]) -> usize {
    let length: f64 = points.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    (std::f64::consts::PI * (points.len() - 1) as f64 / length).ceil() as usize
}

/// The i-th number (from 0) of a splitmix64 stream, in (0, 1).
fn uniform(seed: u64, i: u64) -> f64 {
    let mut z = seed.wrapping_add((i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    ((z >> 11) as f64 + 0.5) / 9_007_199_254_740_992.0
}

/// n normal numbers by Box and Muller.
fn normal(seed: u64, n: usize) -> Vec<f64> {
    let pair = |k: usize| {
        let (u, v) = (uniform(seed, 2 * k as u64), uniform(seed, 2 * k as u64 + 1));
        let (r, t) = ((-2.0 * u.ln()).sqrt(), 2.0 * std::f64::consts::PI * v);
        [r * t.cos(), r * t.sin()]
    };
    (0..n.div_ceil(2)).flat_map(pair).take(n).collect()
}

/// Worm-like chain of edge h and persistence length lp; kept inside a sphere by reflecting its direction.
fn chain(n: usize, h: f64, lp: f64, seed: u64, sphere: Option<f64>) -> Vec<Vec3> {
    let g = normal(seed, 3 * n);
    let kick = (h / lp).sqrt();
    let (mut p, mut d) = (Vec3::zeros(), Vec3::z());
    let mut points = Vec::with_capacity(n + 1);
    points.push(p);
    for k in 0..n {
        let g = Vec3::new(g[3 * k] * kick, g[3 * k + 1] * kick, g[3 * k + 2] * kick);
        let dot = g.x * d.x + g.y * d.y + g.z * d.z;
        d += Vec3::new(g.x - dot * d.x, g.y - dot * d.y, g.z - dot * d.z);
        d *= 1.0 / (d.x * d.x + d.y * d.y + d.z * d.z).sqrt();
        let mut next = p + d * h;
        if sphere.is_some_and(|r| next.norm_squared() > r * r) {
            let size = p.norm();
            let u = p / if size == 0.0 { 1.0 } else { size };
            let outward = d.dot(&u);
            if outward > 0.0 {
                d -= u * (2.0 * outward);
            }
            next = p + d * h;
        }
        p = next;
        points.push(p);
    }
    points
}

/// Interior points of a smooth end loop from p0 (leaving along t0) to p1 (arriving along t1), about h apart.
fn end_loop((p0, t0): (Vec3, Vec3), (p1, t1): (Vec3, Vec3), c: f64, h: f64) -> Vec<Vec3> {
    let fine = 4000;
    let (a, b) = (p0 + t0 * c, p1 - t1 * c);
    let curve: Vec<Vec3> = (0..fine)
        .map(|k| {
            let s = k as f64 / (fine - 1) as f64;
            let q = 1.0 - s;
            p0 * q.powi(3) + a * (3.0 * q * q * s) + b * (3.0 * q * s * s) + p1 * s.powi(3)
        })
        .collect();
    let mut length = vec![0.0; fine];
    for k in 1..fine {
        length[k] = length[k - 1] + (curve[k] - curve[k - 1]).norm();
    }
    let total = length[fine - 1];
    let m = ((total / h).round() as usize).max(3);
    (1..m)
        .map(|k| {
            let at = total * k as f64 / m as f64;
            let i = length.partition_point(|&l| l <= at).clamp(1, fine - 1);
            let t = (at - length[i - 1]) / (length[i] - length[i - 1]);
            curve[i - 1] + (curve[i] - curve[i - 1]) * t
        })
        .collect()
}

fn plecto(n: usize, coil: bool) -> Vec<Vec3> {
    let (h, radius, alpha) = (1.0, 0.99, 55f64.to_radians());
    let (turn, rise) = (h * alpha.cos() / radius, h * alpha.sin());
    let m = n / 2 + 2;
    let axis: Vec<Vec3> = if coil {
        chain(m - 1, rise, 100.0, 7, None)
    } else {
        (0..m).map(|k| Vec3::new(0.0, 0.0, k as f64 * rise)).collect()
    };
    let tangent = |k: usize| {
        let k = k.min(m - 2);
        (axis[k + 1] - axis[k]).normalize()
    };
    let mut e1 = Vec3::x();
    if coil {
        e1 = (e1 - tangent(0) * e1.dot(&tangent(0))).normalize();
    }
    let (mut a, mut b) = (Vec::with_capacity(n + 40), Vec::with_capacity(m));
    for (k, point) in axis.iter().enumerate() {
        let t = tangent(k);
        if coil {
            e1 = (e1 - t * t.dot(&e1)).normalize();
        }
        let (sin, cos) = (k as f64 * turn).sin_cos();
        let off = (e1 * cos + t.cross(&e1) * sin) * radius;
        a.push(point + off);
        b.push(point - off);
    }
    let (t0, t1) = ((a[m - 1] - a[m - 2]).normalize(), (b[m - 2] - b[m - 1]).normalize());
    let bend = end_loop((a[m - 1], t0), (b[m - 1], t1), 12.0, h);
    a.extend(bend);
    a.extend(b.into_iter().rev());
    // Trim the free ends symmetrically to N edges, then turn out of the axes' directions.
    let excess = a.len() - (n + 1);
    let first = excess / 2;
    let turned = rotation();
    a[first..first + n + 1].iter().map(|p| turned * p).collect()
}

fn rotation() -> Mat3 {
    let q = [0.5, 0.3, -0.7, 0.4];
    let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [w, x, y, z] = q.map(|c| c / size);
    Mat3::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - z * w),
        2.0 * (x * z + y * w),
        2.0 * (x * y + z * w),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - x * w),
        2.0 * (x * z - y * w),
        2.0 * (y * z + x * w),
        1.0 - 2.0 * (x * x + y * y),
    )
}
