//! The softest modes of an equilibrium: K v = λ M v.

use super::EquilibriumTangent;
use super::krylov::{Pencil, softest};
use super::masses::Masses;
use crate::error::{InputError, SolveError};
use crate::math::Vec3;
use crate::rod::element::Strain;
use crate::rod::{Deformation, ElasticEnergies};
use crate::solve::problem::linearised::{Linearised, dot};
use crate::solve::{Engine, RunError};

/// Step of the strains' central difference along a mode, over the shape's largest rotation (rad) and displacement
/// (over a node spacing), because strains are quadratic in it and 1e-4 leaves eight digits.
const STEP: f64 = 1e-4;

/// Shares of a mode's elastic energy ½ΔεᵀCΔε, which add up to 1. The energy of the stresses (of the geometric
/// stiffness) and of contact is not in it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Participation {
    /// Of stretch.
    pub stretch: f64,
    /// Of shear.
    pub shear: f64,
    /// Of bending.
    pub bend: f64,
    /// Of twist.
    pub twist: f64,
}

/// A mode.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mode {
    /// λ: negative where the equilibrium is unstable \[F/L²\]; of [`EquilibriumTangent::vibrations`] the square of the
    /// angular frequency \[1/T²\].
    pub eigenvalue: f64,
    /// Where its energy is.
    pub participation: Participation,
    /// Displacements of all nodes, rod after rod \[L\].
    pub displacements: Vec<Vec3>,
    /// Rotation vectors of all nodes \[rad\].
    pub rotations: Vec<Vec3>,
}

/// The softest modes, ascending. A shape has the root mean square 1 \[L\]: vᵀMv is the mass of the rods.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Modes {
    /// B/L⁴ of the smallest bending stiffness and the longest rod \[F/L²\]: eigenvalues of lines of unit density are
    /// numbers times this.
    pub unit: f64,
    /// Unstable directions of the equilibrium.
    pub num_unstable: usize,
    /// Motions that cost nothing, which are left out.
    pub num_zero_energy: usize,
    /// Whether rods have masses: eigenvalues are ω² \[1/T²\].
    pub has_masses: bool,
    /// The modes.
    pub modes: Vec<Mode>,
}

impl Modes {
    /// Frequencies \[1/T\], of rods with masses; NaN of unstable modes.
    #[must_use]
    pub fn frequencies(&self) -> Option<Vec<f64>> {
        self.has_masses.then(|| self.modes.iter().map(Mode::frequency).collect())
    }

    /// Eigenvalues over B/L⁴, of rods with masses ω² over B/L⁴ of unit density.
    pub fn eigenvalues(&self) -> impl Iterator<Item = f64> + '_ {
        self.modes.iter().map(|mode| mode.eigenvalue / self.unit)
    }
}

impl std::fmt::Display for Modes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { num_zero_energy, unit, .. } = self;
        let numbers: Vec<f64> = self.frequencies().unwrap_or_else(|| self.eigenvalues().collect());
        let kind = if self.has_masses { "frequency" } else { "eigenvalue" };
        match self.has_masses {
            true => write!(f, "softest modes, frequencies")?,
            false => write!(f, "softest modes, over B/L⁴ = {unit:.4e}")?,
        }
        write!(f, " ({num_zero_energy} motions that cost nothing left out)")?;
        write!(f, "\n     {kind:>10}   stretch   shear    bend   twist")?;
        for (k, (mode, eigenvalue)) in self.modes.iter().zip(numbers).enumerate() {
            let Participation { stretch, shear, bend, twist } = mode.participation;
            write!(f, "\n{:3} {eigenvalue:11.4e}   {stretch:7.4} {shear:7.4} {bend:7.4} {twist:7.4}", k + 1)?;
        }
        Ok(())
    }
}

impl Mode {
    /// Frequency \[1/T\] of a mode of [`EquilibriumTangent::vibrations`]; NaN of an unstable one.
    #[must_use]
    pub fn frequency(&self) -> f64 {
        self.eigenvalue.sqrt() / std::f64::consts::TAU
    }
}

impl EquilibriumTangent<'_> {
    /// The `count` softest modes of rods of line density 1 (all unstable ones if these are more; fewer if there are
    /// fewer). Rotations have the inertia of a solid cylinder of the contact radius, those of rods without one none.
    ///
    /// # Errors
    /// `SolveError::Eigenvalues` if they do not converge.
    pub fn modes(&mut self, count: usize) -> Result<Modes, SolveError> {
        self.softest(count, (&vec![1.0; self.engine.model().rods.len()], false))
    }

    /// The `count` lowest vibrations without damping of rods of these masses per length \[F·T²/L²\], one a rod:
    /// eigenvalues are ω² \[1/T²\].
    ///
    /// # Errors
    /// Densities that are not positive, or of another number of rods; as [`EquilibriumTangent::modes`].
    pub fn vibrations(&mut self, count: usize, densities: &[f64]) -> Result<Modes, RunError> {
        let rods = self.engine.model().rods.len();
        if densities.len() != rods {
            let reason = format!("{} numbers for {rods} rods", densities.len());
            return Err(InputError::inconsistent("densities", reason).into());
        }
        for (rod, density) in densities.iter().enumerate() {
            InputError::positive(&format!("densities.{rod}"), *density)?;
        }
        Ok(self.softest(count, (densities, true))?)
    }

    fn softest(&mut self, count: usize, (densities, has_masses): (&[f64], bool)) -> Result<Modes, SolveError> {
        let (engine, num_unstable): (&Engine, _) = (&*self.engine, self.num_unstable());
        let masses = Masses::of(engine, densities);
        let held = held_motions(engine, &masses, &self.linearised.zero_energy);
        let mut pencil = Shapes { engine, linearised: &mut self.linearised, masses, held };
        let pairs = softest(&mut pencil, count, num_unstable)?;
        let rods = &engine.model().rods;
        let total: f64 = rods.iter().zip(densities).map(|(rod, density)| rod.length * density).sum();
        let mode = |pair: super::krylov::Eigenpair| {
            let (eigenvalue, size) = (pair.eigenvalue, total.sqrt());
            let shape: Vec<f64> = pair.vector.iter().map(|x| x * size).collect();
            let part = |first: usize| {
                shape.chunks_exact(6).map(|node| Vec3::from_column_slice(&node[first..first + 3])).collect()
            };
            let participation = participation(engine, &shape);
            Mode { eigenvalue, participation, displacements: part(0), rotations: part(3) }
        };
        Ok(Modes {
            unit: engine.scales.bending / engine.scales.length.powi(4),
            num_unstable,
            num_zero_energy: self.linearised.zero_energy.len(),
            has_masses,
            modes: pairs.into_iter().map(mode).collect(),
        })
    }
}

/// A zero-energy mode with M times it, M-orthonormal.
type HeldMotions = Vec<(Vec<f64>, Vec<f64>)>;

/// Zero-energy modes that move mass, by more than rounding of what moves it as far. Others (spin of a line) have no
/// part in M-orthogonality.
fn held_motions(engine: &Engine, masses: &Masses, motions: &[Vec<f64>]) -> HeldMotions {
    let mut held: HeldMotions = Vec::new();
    for motion in motions {
        let mut motion = motion.clone();
        let size = |motion: &[f64]| dot(motion, &masses.multiply(engine, motion)).max(0.0).sqrt();
        let largest = farthest(engine, &motion) * masses.total().sqrt();
        for _ in 0..2 {
            remove(&held, &mut motion);
        }
        let left = size(&motion);
        if left > f64::EPSILON.sqrt() * largest {
            motion.iter_mut().for_each(|x| *x /= left);
            let mass = masses.multiply(engine, &motion);
            held.push((motion, mass));
        }
    }
    held
}

/// The largest displacement of a node along a motion, or rotation times a node spacing \[L\].
fn farthest(engine: &Engine, motion: &[f64]) -> f64 {
    let way = |(i, x): (usize, &f64)| if i % 6 < 3 { x.abs() } else { x.abs() * engine.scales.lever };
    motion.iter().enumerate().map(way).fold(0.0, f64::max)
}

fn remove(held: &HeldMotions, vector: &mut [f64]) {
    for (motion, mass) in held {
        let part = dot(mass, vector);
        vector.iter_mut().zip(motion).for_each(|(x, v)| *x -= part * v);
    }
}

/// EquilibriumTangent and masses of rods.
struct Shapes<'a> {
    engine: &'a Engine,
    linearised: &'a mut Linearised,
    masses: Masses,
    held: HeldMotions,
}

impl Pencil for Shapes<'_> {
    fn len(&self) -> usize {
        6 * self.engine.num_nodes()
    }

    fn solve(&mut self, forces: &[f64]) -> Vec<f64> {
        // forces that do work on zero-energy modes would stretch the springs that hold these
        let mut forces = forces.to_vec();
        for (motion, mass) in &self.held {
            let work = dot(motion, &forces);
            forces.iter_mut().zip(mass).for_each(|(f, m)| *f -= work * m);
        }
        let mut motion = self.linearised.solve(self.engine, &forces);
        remove(&self.held, &mut motion);
        motion
    }

    fn multiply(&self, vector: &[f64]) -> Vec<f64> {
        self.masses.multiply(self.engine, vector)
    }
}

/// Rates of the strains of all elements along a motion, by central differences.
pub(super) fn strains_along(engine: &Engine, motion: &[f64]) -> Vec<[Strain; 3]> {
    let step = STEP * engine.scales.lever / farthest(engine, motion).max(f64::MIN_POSITIVE);
    let [after, before] = [step, -step].map(|t| engine.retract(engine.state(), motion, t));
    let of_element = |e: usize| {
        let [after, before] = [&after, &before].map(|state| engine.element_strain(e, state));
        std::array::from_fn(|g| std::array::from_fn(|i| (after[g][i] - before[g][i]) / (2.0 * step)))
    };
    (0..engine.elements.len()).map(of_element).collect()
}

/// Shares of the elastic energy along a shape.
fn participation(engine: &Engine, shape: &[f64]) -> Participation {
    let mut energy = ElasticEnergies::default();
    for (e, rates) in strains_along(engine, shape).iter().enumerate() {
        add_energies(engine, e, rates, &mut energy);
    }
    let sum = energy.total().max(f64::MIN_POSITIVE);
    Participation {
        stretch: energy.stretching / sum,
        shear: energy.shearing / sum,
        bend: energy.bending / sum,
        twist: energy.twisting / sum,
    }
}

/// Adds Δε·CΔε of an element by kinds.
fn add_energies(engine: &Engine, e: usize, rates: &[Strain; 3], energy: &mut ElasticEnergies) {
    let body = engine.body(e);
    for (g, weight) in body.table.rule.weights.iter().enumerate() {
        let change = &rates[g];
        let stress = body.material.stress(g, change);
        for (i, kind) in Deformation::OF_STRAINS.into_iter().enumerate() {
            energy.add(kind, weight * body.length * stress[i] * change[i]);
        }
    }
}
