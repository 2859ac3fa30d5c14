//! Cosserat rods: [`Rod`] (elements and nodes), [`Section`] (stiffnesses), [`Shape`] (start shape), [`Along`] (a
//! quantity that varies along a rod), `element` (energy, residual and tangent of one element).

mod along;
mod check;
pub(crate) mod element;
mod energy;
mod link;
mod natural;
mod number;
mod refine;
pub(crate) mod rest;
#[allow(clippy::module_inception)] // the rod itself
mod rod;
mod section;
mod shape;
mod stiffness;

pub use along::{Along, Averaged};
pub(crate) use energy::{Deformation, ElasticEnergies};
pub(crate) use natural::STRAINS;
pub use natural::{Natural, NaturalStrains};
pub use number::{Binding, RodNumber};
#[cfg(feature = "scenes")]
pub(crate) use rod::within;
pub use rod::{MAX_TURN, Rod, RodMesh};
pub use section::{CrossSection, Section};
pub use shape::{Axis, Placement, Plectoneme, Shape, TorusKnot, superhelix_angle};
pub use stiffness::Stiffness;
pub(crate) use stiffness::check_stiffness;
