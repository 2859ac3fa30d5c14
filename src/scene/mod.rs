//! The problem: [`model`] holds rods, supports, loads, contact choice and stages as plain data; `file` (feature
//! `scenes`) reads them from a scene file (TOML); [`Fidelity`] is a preset of mesh, contact law and tolerances.

mod fidelity;
#[cfg(feature = "scenes")]
pub mod file;
pub mod model;
mod points;
#[cfg(feature = "tables")]
pub(crate) mod ramped;
mod tables;
mod units;

#[cfg(feature = "tables")]
pub(crate) use crate::text::finite;
pub use fidelity::{Accuracy, Fidelity};
#[cfg(feature = "scenes")]
pub use file::Scene;
pub use model::{
    Contact, ContactLaw, Electrostatics, Hinge, Joint, JointKind, LineLoad, Model, NodeLoad, NodeRef, Obstacle,
    ObstacleNumber, ObstaclePose, Pose, PosePath, Ramp, Side, Skeleton, Stage, Support, SupportChange,
};
pub use points::{Import, read_points, read_points_with, smooth_points};
pub use tables::{SectionTable, read_natural, read_section};
pub use units::Units;
