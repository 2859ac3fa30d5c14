//! Electrostatics of the duplex in solutions of a monovalent salt: Debye length and effective line charge, for
//! [`Electrostatics`](crate::scene::Electrostatics). Water at 298 K.

use super::{BARE_DIAMETER, THERMAL_ENERGY, contact_diameter_nm};
use crate::error::InputError;

/// Bjerrum length of water at 298 K, nm (e²/4πε₀ε kT with ε = 78.5).
pub const BJERRUM_LENGTH: f64 = 0.714;
/// Particles per nm³ at 1 mol/l.
const PER_MOLAR: f64 = 0.602_214_076;
/// Euler's constant.
const EULER: f64 = 0.577_215_664_901_532_9;

/// Debye length λ = (8π ℓ_B c)^(−½), nm, of a monovalent salt of concentration c in mol/l: 0.304 nm at 1 mol/l.
///
/// # Errors
/// A concentration that is not positive.
pub fn debye_length_nm(salt: f64) -> Result<f64, InputError> {
    InputError::positive("salt", salt)?;
    Ok((8.0 * std::f64::consts::PI * BJERRUM_LENGTH * PER_MOLAR * salt).sqrt().recip())
}

/// Model of the effective line charge. It exceeds the net charge of the duplex, because the charge of the duplex lies
/// on a surface and the line must give the same potential outside.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "scenes", derive(schemars::JsonSchema))]
pub enum Charge {
    /// Crossing lines have the second virial coefficient of hard rods of the effective diameter of
    /// [`SALT_TABLE`](super::SALT_TABLE), d = λ (ln w + γ + ln 2 − ½), w = 2πν²ℓ_B λ (Stigter 1977, Biopolymers
    /// 16:1435). The diameters are those of the non-linear theory, confirmed by knots.
    #[default]
    Diameter,
    /// Counterions condense until one charge is left per Bjerrum length (Manning 1978, Q. Rev. Biophys. 11:179); it
    /// sits on a cylinder of radius a = 1 nm: ν = 1/(ℓ_B x K₁(x)), x = a/λ. The effective diameters that follow are 15
    /// to 35 % below the measured ones.
    Manning,
}

impl Charge {
    /// Charges per length of the line, 1/nm, at a concentration in mol/l.
    ///
    /// # Errors
    /// Concentrations outside 0.01 to 1 mol/l.
    pub fn per_nm(self, salt: f64) -> Result<f64, InputError> {
        let diameter = contact_diameter_nm(salt)?;
        let debye = debye_length_nm(salt)?;
        Ok(match self {
            Self::Diameter => {
                let contact_energy = (diameter / debye - EULER - 2f64.ln() + 0.5).exp();
                (contact_energy / (std::f64::consts::TAU * BJERRUM_LENGTH * debye)).sqrt()
            }
            Self::Manning => {
                let x = 0.5 * BARE_DIAMETER / debye;
                1.0 / (BJERRUM_LENGTH * x * bessel_k1(x))
            }
        })
    }

    /// kT ℓ_B ν², pN: the strength A of screened repulsion.
    ///
    /// # Errors
    /// As [`Charge::per_nm`].
    pub fn strength(self, salt: f64) -> Result<f64, InputError> {
        Ok(THERMAL_ENERGY * BJERRUM_LENGTH * self.per_nm(salt)?.powi(2))
    }
}

/// The modified Bessel function K₁(x) = ∫ exp(−x cosh t) cosh t dt from 0: the trapezoidal rule is exact to rounding
/// for x of 0.01 to 100.
fn bessel_k1(x: f64) -> f64 {
    const STEP: f64 = 0.05;
    let at = |k: usize| (STEP * k as f64).cosh();
    let sum: f64 = (1..200).map(|k| (-x * at(k)).exp() * at(k)).sum();
    STEP * (0.5 * (-x).exp() + sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bessel_has_the_tabulated_values() {
        for (x, printed) in
            [(0.1, 9.853_844_780_870_606), (1.0, 0.601_907_230_197_234_6), (3.0, 0.040_156_431_128_194_18)]
        {
            assert!((bessel_k1(x) / printed - 1.0).abs() < 1e-12, "{x} {}", bessel_k1(x));
        }
    }

    #[test]
    fn debye_length_is_the_textbook_one() {
        assert!((debye_length_nm(1.0).unwrap() - 0.304).abs() < 5e-4);
        assert!((debye_length_nm(0.01).unwrap() - 3.04).abs() < 5e-3);
        assert!(debye_length_nm(0.0).is_err());
    }

    /// Manning's charge is one per Bjerrum length where the cylinder is thin against the Debye length, and less than
    /// the one by diameters, which is known to be 15 to 35 % in diameter.
    #[test]
    fn charges_grow_with_salt_and_differ_as_said() {
        let mut last = [1.0 / BJERRUM_LENGTH; 2];
        for salt in [0.01, 0.05, 0.1, 0.2, 1.0] {
            let now = [Charge::Manning, Charge::Diameter].map(|charge| charge.per_nm(salt).unwrap());
            assert!(now[0] > last[0] && now[1] > last[1] && now[1] > now[0], "{now:?}");
            let debye = debye_length_nm(salt).unwrap();
            let less = 2.0 * debye * (now[1] / now[0]).ln() / contact_diameter_nm(salt).unwrap();
            assert!((0.13..0.37).contains(&less), "{salt} {less}");
            last = now;
        }
        assert!(Charge::Manning.per_nm(0.001).is_err());
    }
}
