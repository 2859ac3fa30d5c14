//! The problem assembled: unknowns, potential, gradient, tangent.
//!
//! | | |
//! |---|---|
//! | `engine` | model, unknowns, state, in one place |
//! | `state` | positions and unit quaternions, and how an increment moves them |
//! | `joints` | joined nodes, which follow the first of them |
//! | `prescribed_motion` | motions of supports and seams, lifted to the rods |
//! | `assembly` | elements, loads and contact summed into gradient and tangent |
//! | `contact_side`, `contact_field` | contact curves of the rods, the law in force; numbers per contact and node |
//! | `contact_tangents`, `measured_tangents` | tangents of the contact curves at the nodes, and how they are measured on a state |
//! | `carrier`, `carried_bodies` | nodes that carry rigid bodies; where these are |
//! | `near_surfaces` | which segments may touch which obstacles |
//! | `contact_gaps` | the smallest gap of each contact near each node |
//! | `reduction` | from numbers of nodes to those of equations, and back |
//! | `linearised` | tangent and factor at a state, for those above the solver |
//! | `swivel`, `moment_load` | supports that hold the rotation about one axis; moments of fixed direction |
//! | `zero_energy` | motions that nothing resists, and the springs that hold them |
//! | `sliding_constraint` | what holds the sliding of a uniform ring along itself |
//! | `falling` | rods that nothing is left to carry |
//! | `twist_limit` | no frame turns past half a turn against its neighbour |
//! | `bend` | how tightly rods are bent for their thickness |
//! | `changes` | another state, contact law or number of a rod |
//! | `fields`, `problem_size` | strains and forces along the rods; unknowns and entries |

pub(crate) mod assembly;
pub(crate) mod bend;
pub(crate) mod carried_bodies;
pub(in crate::solve) mod carrier;
pub(in crate::solve) mod changes;
pub(in crate::solve) mod contact_field;
pub(in crate::solve) mod contact_gaps;
pub(crate) mod contact_side;
pub(in crate::solve) mod contact_tangents;
pub(crate) mod engine;
pub(in crate::solve) mod falling;
pub(in crate::solve) mod fields;
pub(in crate::solve) mod follower;
pub(in crate::solve) mod joints;
pub(crate) mod linearised;
mod measured_tangents;
pub(in crate::solve) mod moment_load;
mod near_surfaces;
pub(in crate::solve) mod prescribed_motion;
pub(in crate::solve) mod problem_size;
pub(in crate::solve) mod reduction;
pub(in crate::solve) mod sliding_constraint;
pub(crate) mod state;
pub(crate) mod swivel;
mod twist_limit;
pub(crate) mod zero_energy;
