//! Final states of two runs, compared: free energies, J-factors.

use super::final_state::FinalState;
use crate::solve::RunError;
use crate::tangent::{ContactResponse, EquilibriumTangent, Harmonic, VOID};

/// Modes whose energy is compared with the quadratic one.
const COMPARED: usize = 4;

/// Final states of two runs, compared at a thermal energy.
#[derive(Debug, Clone, PartialEq)]
pub struct StateComparison {
    /// kT \[F·L\].
    pub thermal_energy: f64,
    /// Difference of the potentials \[F·L\].
    pub potential: f64,
    /// What is compared, contacts free.
    pub free: f64,
    /// The same with contacts locked; `None` where they are lines.
    pub locked: Option<f64>,
    /// Largest deviation of the energy along the softest modes from the quadratic one, see
    /// [`EquilibriumTangent::anharmonicity`].
    pub anharmonicity: f64,
    /// Free energies \[F·L\], or J-factors \[1/L³\].
    kind: Compared,
    /// Name of the unit of length.
    length: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Compared {
    FreeEnergy,
    JFactor,
}

/// A state for a comparison.
struct Weighed {
    harmonic: [Harmonic; 2],
    anharmonicity: f64,
}

fn weighed(state: &mut FinalState, thermal_energy: f64) -> Result<Weighed, RunError> {
    let harmonic = EquilibriumTangent::both_bounds(&mut state.solver)?;
    let mut tangent = EquilibriumTangent::at(&mut state.solver, ContactResponse::ByLaw)?;
    let along = tangent.anharmonicity(COMPARED, thermal_energy)?;
    Ok(Weighed { harmonic, anharmonicity: along.into_iter().fold(0.0, f64::max) })
}

impl StateComparison {
    fn new(
        [mut state, mut other]: [FinalState; 2],
        thermal_energy: Option<f64>,
        kind: Compared,
    ) -> Result<Self, RunError> {
        let thermal_energy = state.thermal_energy(thermal_energy)?;
        let [own, reference] = [weighed(&mut state, thermal_energy)?, weighed(&mut other, thermal_energy)?];
        let ([free, locked], [free_there, locked_there]) = (&own.harmonic, &reference.harmonic);
        let compare = |a: &Harmonic, b: &Harmonic| match kind {
            Compared::FreeEnergy => a.relative_to(b, thermal_energy),
            Compared::JFactor => a.j_factor(b, thermal_energy),
        };
        Ok(Self {
            thermal_energy,
            potential: free.potential - free_there.potential,
            free: compare(free, free_there)?,
            locked: compare(locked, locked_there).ok(),
            anharmonicity: own.anharmonicity.max(reference.anharmonicity),
            kind,
            length: state.scene.units.length.clone(),
        })
    }

    /// The free energy of a state less that of a reference, at kT \[F·L\] (that of the first scene's temperature unless
    /// given).
    ///
    /// # Errors
    /// Units without a temperature and no kT; states that cannot be compared ([`Harmonic::relative_to`]).
    pub fn of_free_energies(states: [FinalState; 2], thermal_energy: Option<f64>) -> Result<Self, RunError> {
        Self::new(states, thermal_energy, Compared::FreeEnergy)
    }

    /// The J-factor of a ring or a loop, by the state of the same rod with a free end, at kT \[F·L\].
    ///
    /// # Errors
    /// As [`StateComparison::of_free_energies`]; [`Harmonic::j_factor`].
    pub fn of_ends(states: [FinalState; 2], thermal_energy: Option<f64>) -> Result<Self, RunError> {
        Self::new(states, thermal_energy, Compared::JFactor)
    }
}

/// Molecules per litre in a cubic nanometre.
const MOLAR: f64 = 1.660_539_067;

impl std::fmt::Display for StateComparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kt = self.thermal_energy;
        write!(f, "in kT = {kt:.6e}: potential {:.4}, ", self.potential / kt)?;
        let apart = match self.kind {
            Compared::FreeEnergy => {
                write!(f, "free energy {:.4} with free contacts", self.free / kt)?;
                let other = self.locked.filter(|locked| *locked != self.free);
                other.map_or(Ok(()), |locked| write!(f, ", {:.4} with locked ones", locked / kt))?;
                self.locked.map_or(0.0, |locked| (locked - self.free).abs() / kt)
            }
            Compared::JFactor => {
                let unit = &self.length;
                write!(f, "J = {:.6e} /{unit}³", self.free)?;
                if unit == "nm" {
                    write!(f, " = {:.6e} M", MOLAR * self.free)?;
                }
                let other = self.locked.filter(|locked| *locked != self.free);
                other.map_or(Ok(()), |locked| write!(f, " with free contacts, {locked:.6e} with locked ones"))?;
                self.locked.map_or(0.0, |locked| (locked / self.free).ln().abs())
            }
        };
        if self.locked.is_none() {
            write!(f, "\ncontact along lines: it is not known with locked contacts")?;
        }
        if apart > 1.0 {
            write!(f, "\nthe two differ by more than 1 kT: contact matters")?;
        }
        if self.anharmonicity > VOID {
            write!(
                f,
                "\nvoid: at its thermal amplitude the energy along a soft mode is off the quadratic one by {:.0} %: the next \
                 contact or saddle is as near",
                100.0 * self.anharmonicity
            )?;
        }
        Ok(())
    }
}
