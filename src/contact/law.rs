//! Contact laws: pressure per reference length as a function of gap.
//!
//! Both laws are p = κ⟨c − gap⟩ with energy ½κ⟨c − gap⟩² per length: the penalty law has offset c = 0; the augmented
//! Lagrangian raises the offset field c until the gap is non-negative to a tolerance, after which p is the
//! multiplier. The law is C¹ in the energy's gradient; p vanishes where contact ends.

/// Value, pressure and stiffness of the law at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Energy per length \[F\].
    pub energy: f64,
    /// Pressure p per length \[F/L\] = −d energy / d gap.
    pub pressure: f64,
    /// −d pressure / d gap \[F/L²\].
    pub stiffness: f64,
}

/// Response at overlap e = c − gap \[L\]; zero for e ≤ 0.
#[inline]
pub fn response(stiffness: f64, overlap: f64) -> Response {
    if overlap <= 0.0 {
        return Response { energy: 0.0, pressure: 0.0, stiffness: 0.0 };
    }
    let pressure = stiffness * overlap;
    Response { energy: 0.5 * pressure * overlap, pressure, stiffness }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressure_is_minus_the_slope_of_the_energy() {
        let h = 1e-6;
        for overlap in [-0.3, 0.0, 0.2, 1.7] {
            let slope = (response(5.0, overlap + h).energy - response(5.0, overlap - h).energy) / (2.0 * h);
            assert!((slope - response(5.0, overlap).pressure).abs() < 1e-5);
        }
    }
}
