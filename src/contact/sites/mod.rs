//! Contact sites: local minima of the distance, contacts as chains of zone pieces, the smallest clearance.

pub mod chain;
pub mod clearance;
pub mod closest;
pub mod site;
pub mod vertex;
