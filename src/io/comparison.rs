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
    /// What is compared, contacts free; `None` where only contact keeps a state stable.
    pub free: Option<f64>,
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
        [state, other]: [&mut FinalState; 2],
        thermal_energy: Option<f64>,
        kind: Compared,
    ) -> Result<Self, RunError> {
        let thermal_energy = state.thermal_energy(thermal_energy)?;
        let [own, reference] = [weighed(state, thermal_energy)?, weighed(other, thermal_energy)?];
        let ([free, locked], [free_there, locked_there]) = (&own.harmonic, &reference.harmonic);
        let compare = |a: &Harmonic, b: &Harmonic| match kind {
            Compared::FreeEnergy => a.relative_to(b, thermal_energy),
            Compared::JFactor => a.j_factor(b, thermal_energy),
        };
        let [free_ones, locked_ones] = [compare(free, free_there), compare(locked, locked_there)];
        if let (Err(_), Err(error)) = (&free_ones, &locked_ones) {
            return Err(error.clone().into());
        }
        Ok(Self {
            thermal_energy,
            potential: free.potential - free_there.potential,
            free: free_ones.ok(),
            locked: locked_ones.ok(),
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
    pub fn of_free_energies(states: [&mut FinalState; 2], thermal_energy: Option<f64>) -> Result<Self, RunError> {
        Self::new(states, thermal_energy, Compared::FreeEnergy)
    }

    /// The J-factor of a ring or a loop, by the state of the same rod with a free end, at kT \[F·L\].
    ///
    /// # Errors
    /// As [`StateComparison::of_free_energies`]; [`Harmonic::j_factor`].
    pub fn of_ends(states: [&mut FinalState; 2], thermal_energy: Option<f64>) -> Result<Self, RunError> {
        Self::new(states, thermal_energy, Compared::JFactor)
    }
}

/// What is known with free contacts and with locked ones, in words; once where it is the same.
pub(super) fn bounds(free: Option<String>, locked: Option<String>) -> String {
    match (free, locked) {
        (Some(free), Some(locked)) if free == locked => free,
        (Some(free), Some(locked)) => format!("{free} with free contacts, {locked} with locked ones"),
        (Some(free), None) => format!("{free} with free contacts"),
        (None, Some(locked)) => format!("{locked} with locked contacts"),
        (None, None) => "unknown".to_owned(),
    }
}

/// Molecules per litre in a cubic nanometre.
const MOLAR: f64 = 1.660_539_067;

impl std::fmt::Display for StateComparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kt = self.thermal_energy;
        write!(f, "in kT = {kt:.6e}: potential {:.4}, ", self.potential / kt)?;
        let unit = match self.kind {
            Compared::FreeEnergy => String::new(),
            Compared::JFactor => format!(" /{}³", self.length),
        };
        let shown = |value: f64| match self.kind {
            Compared::FreeEnergy => format!("{:.4}", value / kt),
            Compared::JFactor if self.length == "nm" => format!("{value:.6e}{unit} = {:.6e} M", MOLAR * value),
            Compared::JFactor => format!("{value:.6e}{unit}"),
        };
        write!(f, "{}", if self.kind == Compared::JFactor { "J = " } else { "free energy " })?;
        f.write_str(&bounds(self.free.map(shown), self.locked.map(shown)))?;
        let apart = match (self.kind, self.free, self.locked) {
            (Compared::FreeEnergy, Some(free), Some(locked)) => (locked - free).abs() / kt,
            (Compared::JFactor, Some(free), Some(locked)) => (locked / free).ln().abs(),
            _ => 0.0,
        };
        if self.free.is_none() {
            write!(f, "\nstable by contact only: it is not known with free contacts")?;
        }
        if self.locked.is_none() {
            write!(f, "\ncontact along lines: it is not known with locked contacts")?;
        }
        if apart > 1.0 {
            write!(f, "\nthe two differ by more than 1 kT: contact matters")?;
        }
        if self.anharmonicity > VOID {
            write!(
                f,
                "\nvoid: at its thermal amplitude the energy along a soft mode is off the quadratic one by {:.0} %: \
                 the next contact or saddle is as near",
                100.0 * self.anharmonicity
            )?;
        }
        Ok(())
    }
}
