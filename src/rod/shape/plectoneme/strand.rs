//! One strand of a plectoneme from apex to apex, in cylindrical coordinates about its axis, in closed form.

/// Parameters of the planar end loop: the least ∫κ² for a given length in the family of loops that are even and odd
/// polynomials about the apex with zero curvature at the helix.
const HEIGHT: [f64; 2] = [0.625, 0.36];
const FULLNESS: f64 = 0.84;

/// Largest distance of the loop from the axis, beyond the strands' own, relative to the loop's size.
pub(super) const LOOP_WIDTH: f64 = 0.2695;
/// Height of the loop relative to its size.
pub(super) const LOOP_HEIGHT: f64 = 1.25 * HEIGHT[0] + HEIGHT[1];

/// A point of the strand: distance x from the axis, height z, angle φ about the axis, with first and second derivatives
/// by the parameter.
#[derive(Debug, Clone, Copy)]
pub(super) struct StrandPoint {
    pub x: [f64; 3],
    pub z: [f64; 3],
    pub phi: [f64; 3],
}

/// A half loop of size `size` above a double helix of radius `radius` that rotates by `rate` per height.
///
/// In its own plane the loop is x = R A(w) + S b(w), z = S c(w), w = 1 at the helix and 0 at the apex, A = (15w −
/// 10w³ + 3w⁵)/8, b = w(1 + e w²) y³, c = γ1(y + y²/4) + γ3 y³, y = 1 − w². The plane rotates about the axis, at the
/// rate of the helix at w = 1; the rate decays to 0 at the apex as (5w³ − 3w⁵)/2. Position, tangent and curvature are
/// continuous where helix and loop meet; at the apex the curve is smooth.
#[derive(Debug, Clone, Copy)]
pub(super) struct HalfLoop {
    pub radius: f64,
    pub size: f64,
    pub rate: f64,
}

impl HalfLoop {
    /// The point at the parameter v = 1 − w, 0 at the helix, 1 at the apex; z and φ from the end of the helix.
    pub(super) fn at(&self, v: f64) -> StrandPoint {
        let w = 1.0 - v;
        let (w2, y, y1) = (w * w, v * (2.0 - v), -2.0 * w); // y by differences: exact near the helix
        let a = [w * (15.0 + w2 * (3.0 * w2 - 10.0)) / 8.0, 15.0 * y * y / 8.0, -7.5 * w * y];
        let (h, h1, h2) = (w * (1.0 + FULLNESS * w2), 1.0 + 3.0 * FULLNESS * w2, 6.0 * FULLNESS * w);
        let (q, q1, q2) = (y * y * y, 3.0 * y * y * y1, 24.0 * y * w2 - 6.0 * y * y);
        let b = [h * q, h1 * q + h * q1, h2 * q + 2.0 * h1 * q1 + h * q2];
        let [g1, g3] = HEIGHT;
        let (slope, bend) = (g1 * (1.0 + 0.5 * y) + 3.0 * g3 * y * y, 0.5 * g1 + 6.0 * g3 * y);
        let c = [y * (g1 * (1.0 + 0.25 * y) + g3 * y * y), slope * y1, bend * y1 * y1 - 2.0 * slope];
        let rate = self.rate * self.size * 2.0 * g1; // per v, from that per height
        let winding =
            [rate * (3.0 - w2 * w2 * (5.0 - 2.0 * w2)) / 8.0, rate * w * w2 * (2.5 - 1.5 * w2), -7.5 * rate * w2 * y];
        let (r, s) = (self.radius, self.size);
        // d/dv = −d/dw
        StrandPoint {
            x: [r * a[0] + s * b[0], -r * a[1] - s * b[1], r * a[2] + s * b[2]],
            z: [s * c[0], -s * c[1], s * c[2]],
            phi: winding,
        }
    }
}

impl StrandPoint {
    /// First and second derivative in cylindrical axes: radial, azimuthal, along the (straight) axis.
    fn derivatives(&self) -> [[f64; 3]; 2] {
        let ([x, x1, x2], [_, z1, z2], [_, p1, p2]) = (self.x, self.z, self.phi);
        [[x1, x * p1, z1], [x2 - x * p1 * p1, 2.0 * x1 * p1 + x * p2, z2]]
    }

    /// ds/dv, κ² ds/dv, and the twist rate (rad per v) about the curve of the direction "around".
    ///
    /// Let a be that direction, of derivative −φ′ outwards, t the tangent: the part of a normal to t turns about t at
    /// the rate (t·(a × a′) − (a·t) t·(a × t′))/(1 − (a·t)²).
    pub(super) fn rates(&self) -> [f64; 3] {
        let [r1, r2] = self.derivatives();
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let speed_sq = dot(r1, r1);
        let speed = speed_sq.sqrt();
        let bent = cross(r1, r2);
        let along = r1[1] / speed;
        let turned = r1[2] / speed * self.phi[1]; // t·(a × a′), a × a′ = φ′ along the axis
        let swept = dot(r1, cross([0.0, 1.0, 0.0], r2)) / speed_sq;
        let twist = (turned - along * swept) / (1.0 - along * along);
        [speed, dot(bent, bent) / (speed_sq * speed_sq * speed), twist]
    }
}

/// Length, ∫κ² ds and twist of the direction "around" (rad) of a half loop.
pub(super) fn integrals(half: &HalfLoop) -> [f64; 3] {
    const PANELS: usize = 12;
    let mut sums = [0.0; 3];
    for k in 0..3 {
        let rate = |v: f64| half.at(v).rates()[k];
        sums[k] = (0..PANELS)
            .map(|i| super::super::spline::gauss(&rate, i as f64 / PANELS as f64, (i + 1) as f64 / PANELS as f64))
            .sum();
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: HalfLoop = HalfLoop { radius: 0.7, size: 5.0, rate: 0.9 };

    #[test]
    fn derivatives_are_those_of_the_curve() {
        let h = 1e-5;
        for v in [0.1, 0.35, 0.6, 0.9] {
            let [before, here, after] = [v - h, v, v + h].map(|v| HALF.at(v));
            for pick in [|p: &StrandPoint| p.x, |p: &StrandPoint| p.z, |p: &StrandPoint| p.phi] {
                for k in 0..2 {
                    let slope = (pick(&after)[k] - pick(&before)[k]) / (2.0 * h);
                    assert!((slope - pick(&here)[k + 1]).abs() < 1e-7 * (1.0 + slope.abs()), "{v} {k}");
                }
            }
        }
    }

    #[test]
    fn it_continues_the_helix_and_ends_on_the_axis() {
        let start = HALF.at(0.0);
        assert!((start.x[0] - 0.7).abs() < 1e-15 && start.x[1].abs() < 1e-15 && start.x[2].abs() < 1e-15);
        assert!(start.z[0] == 0.0 && start.z[2].abs() < 1e-14 && start.phi[0].abs() < 1e-15 && start.phi[2] == 0.0);
        assert!((start.phi[1] - 0.9 * start.z[1]).abs() < 1e-15, "the helix's rate of turning");
        let apex = HALF.at(1.0);
        assert!(apex.x[0] == 0.0 && apex.z[1] == 0.0 && apex.phi[1] == 0.0, "{apex:?}");
        assert!((apex.z[0] - LOOP_HEIGHT * 5.0).abs() < 1e-14);
        let widest =
            (0..1000).map(|i| HalfLoop { radius: 0.0, ..HALF }.at(f64::from(i) / 1000.0).x[0]).fold(0.0, f64::max);
        assert!((widest / 5.0 - LOOP_WIDTH).abs() < 1e-4, "{widest}");
    }

    /// The planar loop has ∫κ² ds times its length of 9.3412; no neighbour in the family has less.
    #[test]
    fn the_loop_is_the_least_bent_of_its_family() {
        let flat = HalfLoop { radius: 0.0, size: 1.0, rate: 0.0 };
        let [length, bend, twist] = integrals(&flat);
        assert!((length * bend - 9.3412).abs() < 2e-4 && twist == 0.0, "{length} {bend} {twist}");
    }
}
