//! Torus knots and links.

use std::f64::consts::TAU;

use crate::error::InputError;
use crate::math::Vec3;

use super::sampler::{Measured, Parametrised};
use super::{Placement, Shape, finite, normal_to, unit};

/// Panels per winding before they are refined.
const PANELS: usize = 8;

/// A closed curve on a torus that winds `windings[0]` = p times about the torus' axis while it winds `windings[1]` = q
/// times around its tube: ((1 + a cos β) cos pt, (1 + a cos β) sin pt, −a sin β)·R with β = qt + phase, scaled to the
/// length.
///
/// (2, 3) is the trefoil, (2, 5) the cinquefoil, (1, q) and (p, 1) are unknotted; −q is the mirror image of q. The
/// crossings of (p, q > 0) are right-handed, so its writhe is positive.
#[derive(Debug, Clone, PartialEq)]
pub struct TorusKnot {
    /// Length of the curve \[L\].
    pub length: f64,
    /// Windings p ≥ 1 about the axis and q ≠ 0 around the tube, without a common divisor.
    pub windings: [i32; 2],
    /// Radius of the tube over radius of the torus, between 0 and 1. ½ keeps the strands of a trefoil well apart.
    pub aspect: f64,
    /// Angle around the tube at the start, rad.
    pub phase: f64,
    /// Centre \[L\].
    pub center: Vec3,
    /// Axis of the torus (need not be unit).
    pub normal: Vec3,
}

impl TorusKnot {
    /// The knot of aspect ½ about the origin and the z axis.
    pub fn new(length: f64, windings: [i32; 2]) -> Self {
        Self { length, windings, aspect: 0.5, phase: 0.0, center: Vec3::zeros(), normal: Vec3::z() }
    }

    /// The components of the torus link (p, q), each of length `length`: gcd(p, q) of them, equally spaced on one
    /// torus. Any two of them have the linking number pq/d² (d that divisor), so (2, 2) is the Hopf link of number 1,
    /// and (2, −2) that of −1.
    ///
    /// # Errors
    /// p < 1 or q = 0.
    pub fn link(length: f64, windings: [i32; 2]) -> Result<Vec<Self>, InputError> {
        let [p, q] = windings;
        check_windings(windings)?;
        let count = divisor(windings);
        let one = Self::new(length, [p / count, q / count]);
        Ok((0..count).map(|k| Self { phase: TAU * f64::from(k) / f64::from(p), ..one.clone() }).collect())
    }

    pub(super) fn place(&self, num_segments: usize) -> Result<Placement, InputError> {
        InputError::positive("shape.length", self.length)?;
        check_windings(self.windings)?;
        let common = divisor(self.windings);
        if common != 1 {
            let [p, q] = self.windings;
            let reason =
                format!("({p}, {q}) is a link of {common} curves: windings of one curve have no common divisor");
            return Err(InputError::Inconsistent { field: "shape.windings".into(), reason });
        }
        let ok = self.aspect > 0.0 && self.aspect < 1.0;
        InputError::check("shape.aspect", self.aspect, ok, "between 0 and 1")?;
        InputError::check("shape.phase", self.phase, true, "a finite number")?;
        finite("shape.center", &self.center)?;
        let d3 = unit("shape.normal", &self.normal)?;
        let side = normal_to(&d3, &Vec3::x(), &Vec3::y());
        let axes = [side, d3.cross(&side), d3];
        let curve = OnTorus { knot: self, axes };
        let count = PANELS * self.windings.iter().map(|w| w.unsigned_abs() as usize).sum::<usize>();
        let breaks: Vec<f64> = (0..=count).map(|i| i as f64 / count as f64).collect();
        let measured = Measured::new(&curve, &breaks);
        let scale = self.length / measured.length();
        let mut placement = measured.place(true, num_segments, self.length);
        placement.positions.iter_mut().for_each(|x| *x = self.center + *x * scale);
        Ok(placement)
    }
}

impl From<TorusKnot> for Shape {
    fn from(knot: TorusKnot) -> Self {
        Self::TorusKnot(knot)
    }
}

/// The knot about the origin, radius of the torus 1, parameter 0..1.
struct OnTorus<'a> {
    knot: &'a TorusKnot,
    axes: [Vec3; 3],
}

impl Parametrised for OnTorus<'_> {
    fn at(&self, u: f64) -> [Vec3; 2] {
        let [p, q] = self.knot.windings.map(|w| TAU * f64::from(w));
        let ((sin_a, cos_a), (sin_b, cos_b)) = ((p * u).sin_cos(), (q * u + self.knot.phase).sin_cos());
        let aspect = self.knot.aspect;
        let (rho, slope) = (1.0 + aspect * cos_b, -aspect * q * sin_b);
        let [x, y, z] = self.axes;
        [
            x * (rho * cos_a) + y * (rho * sin_a) - z * (aspect * sin_b),
            x * (slope * cos_a - rho * p * sin_a) + y * (slope * sin_a + rho * p * cos_a) - z * (aspect * q * cos_b),
        ]
    }
}

fn check_windings([p, q]: [i32; 2]) -> Result<(), InputError> {
    for (i, value, ok, allowed) in [
        (0, p, (1..=1000).contains(&p), "1 to 1000"),
        (1, q, q != 0 && q.abs() <= 1000, "1 to 1000, or the negative of that"),
    ] {
        InputError::check(&format!("shape.windings[{i}]"), f64::from(value), ok, allowed)?;
    }
    Ok(())
}

/// Greatest common divisor.
fn divisor([p, q]: [i32; 2]) -> i32 {
    let (mut a, mut b) = (p, q.abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}
