//! Places of contact: local minima of the distance, contacts as chains of zone pieces, and the smallest clearance.

pub mod chain;
pub mod clearance;
pub mod closest;
pub mod site;
pub mod vertex;
