//! Cosserat rods: [`section`] (stiffnesses), [`shape`] (where a rod starts), [`element`] (energy, residual, tangent
//! of one element), [`rod`](mod@rod) (a rod as elements and nodes).

pub mod element;
pub mod rod;
pub mod section;
pub mod shape;

pub use rod::{Natural, Rod};
pub use section::{CrossSection, Section};
pub use shape::{Placement, Shape};
