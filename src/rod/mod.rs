//! Cosserat rods: [`section`] (stiffnesses), [`shape`] (where a rod starts), [`Along`] (what varies along
//! a rod), [`element`] (energy, residual, tangent
//! of one element), [`Rod`] (a rod as elements and nodes).

mod along;
mod body;
pub mod element;
mod link;
mod number;
mod refine;
pub mod section;
pub mod shape;
mod stiffness;

pub use along::{Along, Values};
pub(crate) use body::STRAINS;
#[cfg(feature = "scenes")]
pub(crate) use body::within;
pub use body::{MAX_TURN, Natural, NaturalStrains, Rod};
pub use number::RodNumber;
pub use section::{CrossSection, Section};
pub use shape::{Axis, Placement, Plectoneme, Shape, TorusKnot};
pub use stiffness::Stiffness;
pub(crate) use stiffness::check_stiffness;
