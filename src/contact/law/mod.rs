//! Contact laws: pressure per reference length as a function of overlap e = c − gap.
//!
//! The linear law p = κ⟨e⟩ with offset c = 0 is the penalty; the augmented Lagrangian raises the offset field c until
//! the gap is non-negative to a tolerance, after which p is the multiplier. The core law p = p₀ x²/(1 − x), x =
//! ⟨e⟩/depth, begins with slope 0 and keeps every overlap below its depth. Its stiffness grows with the pressure, so
//! that one pair of numbers serves pressures of many decades. Searches begin with it. In both laws p is continuous and
//! vanishes where contact ends.

pub mod potential;

/// How pressure depends on overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Law {
    /// p = κ⟨e⟩.
    Linear {
        /// κ \[F/L²\].
        stiffness: f64,
    },
    /// p = p₀ x²/(1 − x), x = ⟨e⟩/depth; infinite energy from depth on.
    Core {
        /// p₀ \[F/L\]: the pressure at x = 0.618.
        pressure: f64,
        /// Depth over the contact distance (sum of both radii).
        depth: f64,
    },
}

/// Value, pressure and stiffness of a law at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Energy per length \[F\].
    pub energy: f64,
    /// Pressure p per length \[F/L\] = −d energy / d gap.
    pub pressure: f64,
    /// −d pressure / d gap \[F/L²\].
    pub stiffness: f64,
}

impl Law {
    /// Response at an overlap \[L\] of strands with this contact distance \[L\]; zero for overlap ≤ 0.
    #[inline]
    pub fn response(&self, overlap: f64, contact_distance: f64) -> Response {
        if overlap <= 0.0 {
            return Response { energy: 0.0, pressure: 0.0, stiffness: 0.0 };
        }
        match *self {
            Self::Linear { stiffness } => {
                let pressure = stiffness * overlap;
                Response { energy: 0.5 * pressure * overlap, pressure, stiffness }
            }
            Self::Core { pressure, depth } => {
                let depth = depth * contact_distance;
                let x = overlap / depth;
                let left = 1.0 - x;
                if left <= 0.0 {
                    let infinite = f64::INFINITY;
                    return Response { energy: infinite, pressure: infinite, stiffness: infinite };
                }
                Response {
                    energy: pressure * depth * -((-x).ln_1p() + x + 0.5 * x * x),
                    pressure: pressure * x * x / left,
                    stiffness: pressure / depth * x * (2.0 - x) / (left * left),
                }
            }
        }
    }

    /// The overlap \[L\] at which the law has this pressure \[F/L\].
    #[inline]
    pub fn overlap(&self, pressure: f64, contact_distance: f64) -> f64 {
        match *self {
            Self::Linear { stiffness } => pressure / stiffness,
            Self::Core { pressure: scale, depth } => {
                let y = pressure / scale;
                // x = (√(y² + 4y) − y)/2, without cancellation
                2.0 * y / ((y * y + 4.0 * y).sqrt() + y).max(f64::MIN_POSITIVE) * depth * contact_distance
            }
        }
    }
}

/// Length of the shortest line over that of the longest point contact, because crossings of strands that wind about
/// each other were up to 1.2 times as long under soft laws (κε⁴/B of 50), and lines exceed 1.5 at once. A factor of 1
/// would be exact for strands that bend in one plane under an even law.
const LINE_OVER_POINT: f64 = 1.5;
/// The root βa of the equation in [`shortest_line`].
const HALF_ZONE_AT_OPENING: f64 = 1.095_543_932_565_708;

/// Length \[L\] from which a contact is a line: 1.5 times the zone of a point contact at the load at which it opens
/// into a line (or into two points), for a contact stiffness κ \[F/L²\] and the smaller bending stiffness B of either
/// strand \[F·L²\].
///
/// The gap w = w_a − w_b of two strands pressed together obeys w⁗ = −4β⁴w with β⁴ = ¼κ(1/B_a + 1/B_b) where w < 0, w⁗ =
/// 0 elsewhere. A contact is a point as long as the strands bend away from it on both sides: w″ = k + c|s|, k > 0. At k
/// = 0 it opens. The even solution that is zero at the end a of its zone then has w″(a) = a w‴(a), which is at βa =
/// 1.0955. With κ the zone of a point shortens as κ^(−1/3), this bound as κ^(−1/4), and a line keeps its length: a
/// stiffer law separates points from lines.
pub(crate) fn shortest_line(stiffness: f64, bending: [f64; 2]) -> f64 {
    let compliance = 1.0 / bending[0] + 1.0 / bending[1];
    LINE_OVER_POINT * 2.0 * HALF_ZONE_AT_OPENING / (0.25 * stiffness * compliance).powf(0.25)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAWS: [Law; 2] = [Law::Linear { stiffness: 5.0 }, Law::Core { pressure: 0.3, depth: 0.4 }];

    #[test]
    fn pressure_is_the_slope_of_the_energy_and_stiffness_that_of_the_pressure() {
        let h = 1e-5;
        for law in LAWS {
            for overlap in [-0.3, 0.0, 0.1, 0.5, 0.75] {
                let at = |e: f64| law.response(e, 2.0);
                let slope = (at(overlap + h).energy - at(overlap - h).energy) / (2.0 * h);
                let here = at(overlap);
                assert!((slope - here.pressure).abs() < 1e-4 * (1.0 + here.pressure), "{law:?} {overlap}");
                if overlap != 0.0 {
                    let slope = (at(overlap + h).pressure - at(overlap - h).pressure) / (2.0 * h);
                    assert!((slope - here.stiffness).abs() < 1e-4 * (1.0 + here.stiffness), "{law:?} {overlap}");
                }
            }
        }
    }

    #[test]
    fn overlap_is_the_inverse_of_pressure() {
        for law in LAWS {
            for pressure in [1e-12, 1e-3, 0.3, 40.0, 1e9] {
                let back = law.response(law.overlap(pressure, 2.0), 2.0).pressure;
                // near the depth rounding of the overlap limits the accuracy of the pressure
                assert!((back / pressure - 1.0).abs() < 1e-12 * (1.0 + pressure), "{law:?} {pressure} {back}");
            }
            assert_eq!(law.overlap(0.0, 2.0), 0.0);
        }
    }

    #[test]
    fn a_core_holds_at_its_depth() {
        assert_eq!(LAWS[1].response(0.8, 2.0).energy, f64::INFINITY);
        assert!(LAWS[1].response(0.8 * (1.0 - 1e-9), 2.0).pressure > 1e8);
    }
}
