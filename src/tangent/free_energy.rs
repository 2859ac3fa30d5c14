//! The harmonic free energy of an equilibrium, and fluctuations about it.
//!
//! ```text
//! F = Π − kT ln ∫ exp(−½ δᵀKδ/kT) dδ        ⟨δa δb⟩ = kT ∇aᵀ K⁻¹ ∇b
//! ```
//!
//! Zero-energy modes are taken out of the integral, and their volumes put in by name. With T their generators (unit
//! displacements, rotations and spins by a radian, sliding by a unit of length), z of N unknowns, and S the springs
//! that hold them,
//!
//! ```text
//! ∫ = V √(det TᵀST / det(K + S)) (2πkT)^((N − z)/2)
//! ```
//!
//! V is 8π² of rotations (2π in the plane), 2π of spin, the length of sliding, 1 of displacements. It does not matter
//! where the springs are. Mesh and measure are in F: only differences between states of the same rods on the same
//! mesh mean anything.
//!
//! Contact is one-sided. Of a contact with the force f and the stiffness k of its gap the integral is that of
//! exp(−(fg + ½kg²)/kT) over g ≥ 0. Free contacts have it over all g and without f, locked ones kT/f, the width in
//! which the force holds the gap. Both are too large, so that F lies above either; for one contact above the larger one
//! by at most 0.98 kT, where both are equal (½ exp(t²) erfc(t) at t = f/√(2k kT) = 1/2√π), and less where they differ.

use std::f64::consts::{PI, TAU};

use nalgebra::DMatrix;

use super::{ContactResponse, EquilibriumTangent, Observable, contact};
use crate::error::InputError;
use crate::solve::problem::linearised::dot;
use crate::solve::problem::zero_energy::Generator;
use crate::solve::{Engine, RunError, Solver};

/// Cosine of a gradient and a motion that costs nothing, where the gradient is, up to which one does not change the
/// other, because sliding of a mesh changes twist and writhe by its ripples.
const NEUTRAL: f64 = 1e-3;

/// Unknowns of a node.
const END: usize = 6;

/// The parts of the harmonic free energy of a state.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Harmonic {
    /// Π \[F·L\].
    pub potential: f64,
    /// ln(det(K + S)/det TᵀST).
    pub log_determinant: f64,
    /// Zero-energy modes by name, with the volumes of their orbits.
    pub zero_modes: Vec<ZeroMode>,
    /// Zero-energy modes without a name (of held rods, of several rods): they cancel between states of one kind only.
    pub num_unnamed: usize,
    /// Unknowns.
    pub num_unknowns: usize,
    /// How contact responds.
    pub contacts: ContactResponse,
    /// Negative eigenvalues: the integral has no meaning if there are any.
    pub num_unstable: usize,
    /// Of locked contacts, force and stiffness of the lock; `None` if one is a line, whose width is not known.
    locks: Option<Vec<(f64, f64)>>,
}

/// A kind of motion that costs nothing, with the volume of its orbit.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ZeroMode {
    /// `displacement`, `rotation`, `spin` or `sliding`.
    pub name: String,
    /// Dimension of its orbit.
    pub dimension: usize,
    /// Volume of its orbit: 1 of displacements, 8π² of rotations, 2π of a spin, the length \[L\] of sliding.
    pub volume: f64,
}

impl Harmonic {
    /// F at a thermal energy kT \[F·L\], up to a number that is the same for all states of the same rods on the same
    /// mesh.
    ///
    /// # Errors
    /// An unstable state; lines of contact that are locked.
    pub fn free_energy(&self, thermal_energy: f64) -> Result<f64, InputError> {
        InputError::positive("thermal_energy", thermal_energy)?;
        let refuse = |reason: &str| Err(InputError::inconsistent("state", reason));
        if self.num_unstable > 0 {
            return refuse(match self.contacts {
                ContactResponse::Free => {
                    "is unstable where its contacts are free: it has no bound of the free energy with these"
                }
                ContactResponse::ByLaw | ContactResponse::Locked => "is unstable: it has no harmonic free energy",
            });
        }
        let Some(locks) = &self.locks else {
            return refuse("touches along lines, whose widths are not known: only its bound with free contacts is");
        };
        let zero: usize = self.num_unnamed + self.zero_modes.iter().map(|mode| mode.dimension).sum::<usize>();
        let volume: f64 = self.zero_modes.iter().map(|mode| mode.volume.ln()).sum();
        let gaussian = |stiffness: f64| 0.5 * (TAU * thermal_energy / stiffness).ln();
        let locked: f64 =
            locks.iter().map(|(force, stiffness)| (thermal_energy / force).ln() - gaussian(*stiffness)).sum();
        let integral = volume - 0.5 * self.log_determinant + (self.num_unknowns - zero) as f64 * gaussian(1.0) + locked;
        Ok(self.potential - thermal_energy * integral)
    }

    /// F less that of another state \[F·L\], both at a thermal energy kT \[F·L\].
    ///
    /// # Errors
    /// As [`Harmonic::free_energy`]; states of other numbers of unknowns; other zero-energy modes without a name.
    pub fn relative_to(&self, other: &Self, thermal_energy: f64) -> Result<f64, InputError> {
        if self.num_unknowns != other.num_unknowns || self.num_unnamed != other.num_unnamed {
            let reason = "has other unknowns, or other zero-energy modes without a name: free energies are compared \
                          on the same mesh under the same supports";
            return Err(InputError::inconsistent("state", reason));
        }
        Ok(self.free_energy(thermal_energy)? - other.free_energy(thermal_energy)?)
    }

    /// The J-factor \[1/L³\]: this state has the ends of a rod where they are (a ring, a loop between clamps), the
    /// other one is the same rod with a free end. J is the concentration of free ends that would be found there as
    /// often, at any orientation that is as probable:
    ///
    /// ```text
    /// J = 8π² Z(closed)/Z(open)        Z = exp(−F/kT)
    /// ```
    ///
    /// Of a ring it is that of one topoisomer; the sum over the links that matter is the ring's. Both are on the same
    /// mesh.
    ///
    /// # Errors
    /// As [`Harmonic::free_energy`]; states that do not differ by the six unknowns of an end.
    pub fn j_factor(&self, open: &Self, thermal_energy: f64) -> Result<f64, InputError> {
        if self.num_unknowns + END != open.num_unknowns || self.num_unnamed + open.num_unnamed > 0 {
            let reason = format!(
                "has {} unknowns, the open one {}: it is to have six fewer, those of the end that is held, and no \
                 zero-energy modes without a name",
                self.num_unknowns, open.num_unknowns
            );
            return Err(InputError::inconsistent("closed", reason));
        }
        let ratio = (open.free_energy(thermal_energy)? - self.free_energy(thermal_energy)?) / thermal_energy;
        Ok(8.0 * PI * PI * ratio.exp())
    }
}

impl EquilibriumTangent<'_> {
    /// The parts of the harmonic free energy at a solver's state, with contacts free and locked.
    ///
    /// # Errors
    /// As [`EquilibriumTangent::at`].
    pub fn both_bounds(solver: &mut Solver) -> Result<[Harmonic; 2], RunError> {
        let mut harmonic = |contacts| Ok::<_, RunError>(EquilibriumTangent::at(solver, contacts)?.harmonic());
        Ok([harmonic(ContactResponse::Free)?, harmonic(ContactResponse::Locked)?])
    }

    /// The parts of the harmonic free energy, from the pivots of the factor.
    #[must_use]
    pub fn harmonic(&self) -> Harmonic {
        let engine: &Engine = self.engine;
        let unnamed = &self.linearised.zero_energy;
        let named = named(engine, unnamed.len());
        let motions: Vec<&Vec<f64>> = match &named {
            Some(list) => list.iter().map(|(_, motion)| motion).collect(),
            None => unnamed.iter().collect(),
        };
        let springs: Vec<Vec<f64>> = motions.iter().map(|motion| self.linearised.holding(motion)).collect();
        let gram = DMatrix::from_fn(motions.len(), motions.len(), |i, j| dot(motions[i], &springs[j]));
        let locks = match self.choice {
            ContactResponse::Locked => contact::locks(&self.contacts, &self.rates),
            ContactResponse::ByLaw | ContactResponse::Free => Some(Vec::new()),
        };
        Harmonic {
            potential: self.linearised.residual.potential.total(),
            log_determinant: self.linearised.log_determinant() - log_determinant(gram),
            num_unnamed: if named.is_some() { 0 } else { unnamed.len() },
            zero_modes: named.map_or_else(Vec::new, |list| zero_modes(engine, &list)),
            num_unknowns: self.linearised.num_unknowns(),
            contacts: self.choice,
            num_unstable: self.num_unstable(),
            locks,
        }
    }

    /// Covariances ⟨δa δb⟩ of observables at a thermal energy kT \[F·L\], to leading order in it: the square roots of
    /// the diagonal are standard deviations.
    ///
    /// # Errors
    /// Observables that the model does not have; an unstable state.
    pub fn covariance(&mut self, of: &[Observable], thermal_energy: f64) -> Result<DMatrix<f64>, RunError> {
        InputError::positive("thermal_energy", thermal_energy)?;
        if self.num_unstable() > 0 {
            return Err(InputError::inconsistent("state", "is unstable: nothing fluctuates about it").into());
        }
        let mut gradients = Vec::new();
        for observable in of {
            self.check_contact_force(observable)?;
            if *observable == Observable::ContactForce && self.choice == ContactResponse::Locked {
                let reason = "fluctuates as stiffly as its contacts are locked, which says nothing of the rods: it has \
                              no standard deviation";
                return Err(InputError::inconsistent(observable.label(), reason).into());
            }
            let gradient = self.gradient_of(observable)?;
            self.check_neutral(observable, &gradient)?;
            gradients.push(gradient);
        }
        let responses: Vec<Vec<f64>> =
            gradients.iter().map(|gradient| self.linearised.solve(self.engine, gradient)).collect();
        Ok(DMatrix::from_fn(of.len(), of.len(), |i, j| thermal_energy * dot(&gradients[i], &responses[j])))
    }

    /// Refuses observables that motions which cost nothing change: with these they are anything.
    fn check_neutral(&self, of: &Observable, gradient: &[f64]) -> Result<(), InputError> {
        let changes = |motion: &Vec<f64>| {
            let there = gradient.iter().zip(motion).filter(|(slope, _)| **slope != 0.0);
            let size: f64 = there.map(|(_, way)| way * way).sum();
            dot(gradient, motion).abs() > NEUTRAL * (dot(gradient, gradient) * size).sqrt()
        };
        let reason = "is changed by a motion that costs nothing: hold what moves, or ask for a number that it leaves \
                      alone, such as a distance";
        let is_moved = self.linearised.zero_energy.iter().any(changes);
        if is_moved { Err(InputError::inconsistent(of.label(), reason)) } else { Ok(()) }
    }
}

/// ln |det| of a small matrix whose entries may have any size.
fn log_determinant(matrix: DMatrix<f64>) -> f64 {
    if matrix.is_empty() {
        return 0.0;
    }
    matrix.lu().u().diagonal().iter().map(|pivot| pivot.abs().ln()).sum()
}

/// Generators of the zero-energy modes, if these have names. Of a flat ring without twist or with an even one,
/// sliding is rotation and spin.
fn named(engine: &Engine, count: usize) -> Option<Vec<(Generator, Vec<f64>)>> {
    let mut all = crate::solve::problem::zero_energy::generators(engine, engine.state());
    if all.len() == count + 1 {
        all.retain(|(generator, _)| *generator != Generator::Sliding);
    }
    (all.len() == count).then_some(all)
}

fn zero_modes(engine: &Engine, generators: &[(Generator, Vec<f64>)]) -> Vec<ZeroMode> {
    let planar = engine.model().planar;
    let length: f64 = engine.model().rods.iter().map(|rod| rod.length).sum();
    let of = |kind: Generator, name: &str, volume: f64| {
        let dimension = generators.iter().filter(|(generator, _)| *generator == kind).count();
        (dimension > 0).then(|| ZeroMode { name: name.to_owned(), dimension, volume })
    };
    let rotations = if planar { TAU } else { 8.0 * PI * PI };
    let kinds = [
        of(Generator::Displacement, "displacement", 1.0),
        of(Generator::Rotation, "rotation", rotations),
        of(Generator::Spin, "spin", TAU),
        of(Generator::Sliding, "sliding", length),
    ];
    kinds.into_iter().flatten().collect()
}
