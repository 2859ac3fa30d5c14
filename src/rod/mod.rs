//! Cosserat rods: [`Rod`] (a rod as elements and nodes), [`Section`] (its stiffnesses), [`Shape`] (its start),
//! [`Along`] (a quantity that varies along it), `element` (energy, residual, tangent of one element).

mod along;
mod body;
pub(crate) mod element;
mod link;
mod refine;
mod section;
mod shape;
mod stiffness;

pub use along::{Along, Values};
pub(crate) use body::STRAINS;
#[cfg(feature = "scenes")]
pub(crate) use body::within;
pub use body::{MAX_TURN, Natural, NaturalStrains, Rod};
pub use section::{CrossSection, Section};
pub use shape::{Axis, Placement, Plectoneme, Shape, TorusKnot, superhelix_angle};
pub use stiffness::Stiffness;
pub(crate) use stiffness::check_stiffness;
