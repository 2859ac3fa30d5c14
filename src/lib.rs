//! Equilibria of elastic rods that touch themselves and each other: DNA loops, plectonemes, knots, plies, cables.
//!
//! # The problem
//!
//! A rod is a curve r(s) that carries a frame d1 d2 d3, s its reference arc length. Its strains cost the energy
//!
//! ```text
//! W = ½ ∫ GA1 Γ1² + GA2 Γ2² + EA Γ3² + EI1 K1² + EI2 K2² + GJ K3² ds      Γ, K measured from their natural values
//! ```
//!
//! (or any other quadratic one, varying along the rod: [`Rod::with_stiffness`](rod::Rod::with_stiffness))
//!
//! and no two strands, each a tube of radius ε about its curve, may penetrate: gap = distance − ε_a − ε_b ≥ 0 wherever
//! one point is an orthogonal projection of the other. Sought are the (stable) equilibria of frictionless rods under
//! dead loads, moved supports, pressure in the plane, and link put into closed rods, followed in load steps.
//!
//! # A first example
//!
//! Half a turn put into a clamped rod at its far end is taken up evenly: K3 = π/L throughout, moment GJ·π/L.
//!
//! ```
//! use std::ops::ControlFlow;
//! use supercoil::math::Vec3;
//! use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
//! use supercoil::scene::{Model, NodeRef, Ramp, Stage, Support};
//! use supercoil::solve::{self, Options, Status};
//!
//! let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 2.0 };
//! let section = Section::isotropic(1.0, 1.5, 100.0, 100.0, 0.05); // EI, GJ, EA, GA, contact radius
//! let rod = Rod::new("shaft", &line, RodMesh::open(8, 3), section, Natural::Straight)?;
//! let end = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
//! let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 }), Support::clamp(end)];
//! let model = Model { rods: vec![rod], supports, ..Model::default() };
//! let turn = Stage::new(vec![Ramp::Rotation { node: end, axis: Vec3::x(), to: 0.5 }], 4);
//!
//! let mut moment = 0.0;
//! let solution = solve::run(model, &[turn], &Options::default(), &mut |progress| {
//!     moment = supercoil::observe::observe(progress).reactions[1].moment[0];
//!     ControlFlow::Continue(())
//! })?;
//! assert_eq!(solution.status, Status::Converged);
//! let exact = 1.5 * std::f64::consts::PI / 2.0;
//! assert!((moment / exact - 1.0).abs() < 1e-6, "{moment} {exact}");
//! # Ok::<(), solve::RunError>(())
//! ```
//!
//! Scenes can also be written down as TOML, see [`scene::Scene`], and run as a whole with [`io::run::run_scene`].
//!
//! # Units
//!
//! Any consistent ones: the library converts nothing and has no absolute tolerance. Docs give dimensions, \[L\] a
//! length, \[F\] a force. Angles are in radians inside the library; link, twist, writhe and everything a user ramps are
//! in turns. [`dna`] is in nm and pN.
//!
//! # Notation
//!
//! | symbol | in the code | meaning | unit |
//! |---|---|---|---|
//! | r | `positions`, `centerline` | centreline | L |
//! | d1 d2 d3 | `frames` | material frame, d3 along the rod; q·e1, q·e2, q·e3 of a unit quaternion q | – |
//! | s, L | `arc`, `length` | reference arc length, of the whole rod | L |
//! | Γ1 Γ2, Γ3 | `gamma`; first three of `Strain` | shear; extension, 1 at rest | – |
//! | K1 K2, K3 | `kappa`; last three of `Strain` | bending; twist | 1/L |
//! | GA1 GA2, EA | `shearing`, `stretching` | stiffnesses against Γ | F |
//! | EI1 EI2 (B), GJ (C) | `bending`, `twisting` | stiffnesses against K | F·L² |
//! | ε | `contact_radius` | radius of the tube that contact sees | L |
//! | g | `gap` | distance of centrelines − ε_a − ε_b; negative = penetration | L |
//! | n | `normal` | unit normal of contact | – |
//! | κ | `stiffness` | contact stiffness: pressure per penetration | F/L² |
//! | c | `offset` | augmented Lagrangian: pressure is κ⟨c − g⟩ | L |
//! | p | `pressure` | contact force per length; also load pressure | F/L |
//! | Lk, Tw, Wr | `link`, `twist`, `writhe` | Lk = Tw + Wr | turns |
//! | ΔLk | `excess_link` | link of a closed rod's material line with its centreline, seam included, beyond that of the relaxed rod (`natural_link`) | turns |
//! | θ | rotation part of an increment | q ← exp(θ/2) q | rad |
//! | ∂Π/∂x | `gradient`, `residual` | of the potential; at supports the reaction | F, F·L |
//! | ∂²Π/∂x² | `tangent` | | |
//!
//! # Modules
//!
//! Lower layers know nothing of higher ones (`tests/architecture/architecture.rs` sees to it):
//!
//! ```text
//! math ──┬── contact ───────────────────┐
//!        ├── rod ───── dna ───── scene ─┼── solve ─┬─ certificate ── observe ─┬─ io ── the command line
//!        └── sparse ────────────────────┘          └─ tangent ────────────────┘
//! error  open to all
//! ```
//!
//! * [`math`]: vectors and rotations, topology of closed curves
//! * [`contact`]: contact of curves with radii; usable without rods
//! * [`rod`]: sections, shapes, elements
//! * `sparse` (private): sparse LDLᵀ with inertia
//! * [`scene`]: a problem as plain data; scene files
//! * [`solve`]: load stepping, paths through limit and branch points, Newton, stability
//! * [`tangent`]: softest modes of an equilibrium, harmonic free energy, sensitivities
//! * [`certificate`]: what holds of a state, checked without the solver
//! * [`observe`]: numbers of a state
//! * [`io`]: VTK, CSV, pictures, interactive pages, glTF, the record of a run, sweeps
//! * [`dna`]: constants and molecules; natural strains and stiffness of a sequence
//!
//! # Features
//!
//! The default is `parallel` and `cli`. Each feature adds the crates that it needs.
//!
//! | feature | contains |
//! |---|---|
//! | none | contact of curves, rods and scenes as data, DNA, VTK files |
//! | `parallel` | threads; results are the same bits without |
//! | `solver` | equilibria, paths, stability, observation; faer |
//! | `serde` | states, restarts and reports can be written and read with serde |
//! | `scenes` | scene files (TOML); `serde` |
//! | `tables` | tables and states as CSV; `solver` |
//! | `pictures` | pictures of tubes, plots |
//! | `view` | films of rods as a page for the browser, as glTF; `pictures` |
//! | `runs` | a scene from start to files, with checkpoints; all but `parallel` |
//! | `sweeps` | thousands of scenes: plans, shards, results in Parquet; `runs` |
//! | `cli` | the command line; `sweeps` |
//!
//! Without `solver` there are no modules `sparse`, `solve` and `observe`. Without features and with
//! `solver` it builds for `wasm32-unknown-unknown` and runs in the browser (`live/` is a page with the solver in it).
//!
//! # Conventions
//!
//! The library never prints and never panics on input: bad input is an [`InputError`] with field and value,
//! numbers that break down are a [`SolveError`], and a run that does not converge has a [`Status`](solve::Status) that
//! says so. Work is parallel in the caller's rayon pool (or in one of its own), with the feature `parallel`; results
//! are the same bits for any number of threads.

// the lower layers have items that only the solver or scene files use
#![cfg_attr(not(all(feature = "solver", feature = "scenes")), allow(dead_code))]

#[cfg(feature = "solver")]
pub mod certificate;
pub mod contact;
pub mod dna;
pub mod error;
#[doc(hidden)]
pub mod internals;
pub mod io;
pub mod math;
#[cfg(any(feature = "scenes", feature = "solver"))]
mod memory;
#[cfg(feature = "solver")]
pub mod observe;
pub mod rod;
pub mod scene;
#[cfg(feature = "solver")]
pub mod solve;
#[cfg(feature = "solver")]
pub(crate) mod sparse;
#[cfg(feature = "solver")]
pub mod tangent;

pub(crate) mod text;

pub use error::{InputError, SolveError};
pub use nalgebra;

/// The README's code is tested with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// The book's code is tested, too.
#[cfg(doctest)]
#[doc = include_str!("../docs/book/src/contact-alone.md")]
struct Book;
