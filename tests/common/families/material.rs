//! Stiffnesses and thickness of rods, within what real ones have.

use super::Random;
use super::draft::short;

/// C/B: .5 is a tube's, .77 a steel wire's, 1.5 to 2 DNA's.
const TWISTING: [f64; 2] = [0.5, 2.0];
/// EA ε²/B: 4 is a round wire's, 33 that of DNA with its coat of ions.
const STRETCHING: [f64; 2] = [4.0, 33.0];
/// GA/EA: .35 is a wire's.
const SHEARING: [f64; 2] = [0.35, 1.0];

/// A section, B = 1 where it is isotropic.
#[derive(Debug, Clone, Copy)]
pub struct Material {
    pub bending: [f64; 2],
    pub twisting: f64,
    pub stretching: f64,
    pub shearing: f64,
    pub radius: f64,
}

impl Material {
    pub fn isotropic(random: &mut Random, radius: f64) -> Self {
        let stretching = random.log_between(STRETCHING[0], STRETCHING[1]) / (radius * radius);
        Self {
            bending: [1.0; 2],
            twisting: random.between(TWISTING[0], TWISTING[1]),
            stretching,
            shearing: stretching * random.between(SHEARING[0], SHEARING[1]),
            radius,
        }
    }

    /// One bending stiffness is up to three times the other.
    pub fn anisotropic(random: &mut Random, radius: f64) -> Self {
        let mut bending = [1.0, random.log_between(1.05, 3.0)];
        if random.chance(0.5) {
            bending.reverse();
        }
        Self { bending, ..Self::isotropic(random, radius) }
    }

    /// Naked DNA in salt water, nm and pN.
    pub fn dna(random: &mut Random) -> Self {
        Self {
            bending: [205.7; 2],
            twisting: 205.7 * random.between(1.4, 2.1),
            stretching: 1100.0,
            shearing: 1100.0,
            radius: random.between(1.25, 3.0),
        }
    }

    pub fn diameter(&self) -> f64 {
        2.0 * self.radius
    }

    /// The section as TOML.
    pub fn text(&self) -> String {
        let [b1, b2] = self.bending.map(short);
        let bending = if b1 == b2 { format!("{b1:?}") } else { format!("[{b1:?}, {b2:?}]") };
        let [twisting, stretching, shearing, radius] =
            [self.twisting, self.stretching, self.shearing, self.radius].map(short);
        format!(
            "{{ bending = {bending}, twisting = {twisting:?}, stretching = {stretching:?}, shearing = {shearing:?}, \
             contact_radius = {radius:?} }}"
        )
    }
}
