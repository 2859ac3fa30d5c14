//! Internal items for benchmarks and white-box tests. Not part of the interface; may change at any time.

/// Bernstein polynomials.
pub mod bernstein {
    pub use crate::math::bernstein::{Roots, SignChange, eval, roots};
}

/// Gauss rules.
pub mod quadrature {
    pub use crate::math::quadrature::{Rule, gauss};
}

/// Quaternions as arrays.
pub mod quaternion {
    pub use crate::math::quaternion::{spin, to_array};
}

/// Shape functions.
pub mod shape_functions {
    pub use crate::math::shape_functions::{ShapeTable, lagrange};
}

/// Sets of curves.
pub mod curve {
    pub use crate::contact::curve::{CurveInfo, CurveInput, CurveSet, angle};
}

/// Candidate pairs.
pub mod broad_phase {
    pub use crate::contact::broad_phase::{BroadPhase, brute_force_candidates};
}

/// Neighbours along a curve.
pub mod exclusion {
    pub use crate::contact::exclusion::Exclusion;
}

/// Bounds of the distance of two segments.
pub mod capsule {
    pub use crate::contact::capsule::{Capsule, distance_lower_bound, segment_distance, segment_distance_sq};
}

/// Orthogonal projection.
pub mod projection {
    pub use crate::contact::projection::{Feet, Foot, feet_on_segment, local_minima, stationarity};
}

/// The contact potential.
pub mod potential {
    pub use crate::contact::potential::{Offsets, evaluate};
}

/// The smallest gap.
pub mod clearance {
    pub use crate::contact::clearance::smallest_clearance;
}

/// The detector's steps one by one.
pub mod steps {
    pub use crate::contact::steps::DetectorStep;
}

/// One rod element.
pub mod element {
    pub use crate::rod::element::{
        ElementNodes, ElementOutput, ElementProperties, ElementTangent, MAX_DOF, Material, NodeValues, RodPlane,
        Strain, Stress, evaluate, predicted_stress, raw_strains, second_order_force, stiffness,
    };
}

/// The record of a run.
#[cfg(feature = "runs")]
pub mod record {
    pub use crate::io::record::{MAX_SITES, Record, RodSnapshot};
}
