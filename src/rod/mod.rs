//! Cosserat rods: [`section`] (stiffnesses), [`shape`] (where a rod starts), [`element`] (energy, residual, tangent
//! of one element), [`Rod`] (a rod as elements and nodes).

mod body;
pub mod element;
mod link;
mod refine;
pub mod section;
pub mod shape;

#[cfg(feature = "scenes")]
pub(crate) use body::within;
pub use body::{MAX_TURN, Natural, Rod};
pub use section::{CrossSection, Section};
pub use shape::{Axis, Placement, Plectoneme, Shape, TorusKnot};
