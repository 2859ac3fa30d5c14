//! The problem as plain data: rods, supports, loads, contact, stages. [`Model::check`] and [`Model::check_stages`]
//! check everything; the solver calls them first.

mod carried;
mod check;
mod joint_surroundings;
mod obstacle;
mod pose;

use crate::math::Vec3;
use crate::rod::{Rod, RodNumber};

pub use obstacle::{Hinge, Obstacle, ObstacleNumber, ObstaclePose, Side, Skeleton};
#[cfg(feature = "solver")]
pub(crate) use obstacle::{Push, overlaps};
#[cfg(feature = "solver")]
pub(crate) use pose::RemainingPath;
pub use pose::{Pose, PosePath};

/// A node of a rod.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NodeRef {
    /// Index of the rod in [`Model::rods`].
    pub rod: usize,
    /// Index of the node along the rod, 0 at s = 0.
    pub node: usize,
}

/// Fixes components of position and rotation of one node, in the global axes x, y, z.
///
/// Rotation components are spatial: fixing all three clamps the cross-section's frame, fixing two leaves a hinge about
/// the third axis. Fixing one alone makes a constant-velocity joint: the section may tilt, and its rotation vector
/// since the start has no component along the axis, for any history.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Support {
    /// Supported node.
    pub node: NodeRef,
    /// Fixed position components.
    pub position: [bool; 3],
    /// Fixed rotation components.
    pub rotation: [bool; 3],
}

impl Support {
    /// Position and rotation all fixed.
    pub fn clamp(node: NodeRef) -> Self {
        Self { node, position: [true; 3], rotation: [true; 3] }
    }

    /// Position fixed, rotation free.
    pub fn pin(node: NodeRef) -> Self {
        Self { node, position: [true; 3], rotation: [false; 3] }
    }
}

/// What the nodes of a joint share, besides their position.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum JointKind {
    /// All rotation. Their frames may differ, so rods can meet at any angle (the corner of a frame, a tee, a branching
    /// cable).
    #[default]
    Rigid,
    /// No rotation: each rod turns as it likes.
    Pin,
    /// All rotation but that about one axis, which turns with both rods.
    Hinge {
        /// Direction of the axis in space, in the initial shapes; of any length but 0. In a planar scene along z.
        axis: Vec3,
    },
}

impl JointKind {
    /// Its word in scene files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Rigid => "rigid",
            Self::Pin => "pin",
            Self::Hinge { .. } => "hinge",
        }
    }
}

/// A joint of two nodes: they share their position throughout, and of their rotation what its kind says. Several joints
/// at one point join all its nodes.
///
/// The nodes must coincide at the start. Contact is left out where joined rods overlap next to the joint at the start;
/// farther away they may touch. Hinges that meet at one point share one axis, and supports there hold all rotation or
/// none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// One node.
    pub a: NodeRef,
    /// The other.
    pub b: NodeRef,
    /// What they share besides their position.
    pub kind: JointKind,
}

impl Joint {
    /// Position and rotation shared.
    pub fn rigid(a: NodeRef, b: NodeRef) -> Self {
        Self { a, b, kind: JointKind::Rigid }
    }

    /// Position shared.
    pub fn pin(a: NodeRef, b: NodeRef) -> Self {
        Self { a, b, kind: JointKind::Pin }
    }

    /// Position shared, and all rotation but that about an axis, given by its direction in the initial shapes.
    pub fn hinge(a: NodeRef, b: NodeRef, axis: Vec3) -> Self {
        Self { a, b, kind: JointKind::Hinge { axis } }
    }
}

/// Dead force \[F\] and dead (fixed-axis) moment \[F·L\] at a node, in the global axes.
///
/// Multiplied by the load factor of the running stage, see [`Ramp::Load`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeLoad {
    /// Loaded node.
    pub node: NodeRef,
    /// Force \[F\].
    pub force: Vec3,
    /// Moment \[F·L\]; keeps its direction in space while the node turns.
    pub moment: Vec3,
}

/// Dead force and fixed-axis moment per reference arc length on a whole rod, in the global axes (self-weight, a torque
/// spread over the rod).
///
/// Multiplied by the load factor like [`NodeLoad`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineLoad {
    /// Loaded rod.
    pub rod: usize,
    /// Force per length \[F/L\].
    pub force: Vec3,
    /// Moment per length \[F\]; keeps its direction in space while the rod turns. In three dimensions each Newton step
    /// then costs three more solves a node.
    pub moment: Vec3,
}

impl LineLoad {
    /// A force per length \[F/L\] alone.
    pub fn of_force(rod: usize, force: Vec3) -> Self {
        Self { rod, force, moment: Vec3::zeros() }
    }
}

/// Enforcement of contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactLaw {
    /// No contact: no tree, no candidate, no site.
    None,
    /// p = κ⟨−gap⟩ with κ = `stiffness`·B/ε⁴ (B smallest bending stiffness, ε smallest contact radius).
    Penalty {
        /// Dimensionless stiffness; raising it lowers penetration (as κ^(−2/3) at points, κ^(−1) along lines) at the
        /// price of more iterations. Legal: > 0.
        stiffness: f64,
    },
    /// p = κ⟨c − gap⟩ with an offset field c raised until no penetration beyond the tolerance is left.
    AugmentedLagrangian {
        /// Dimensionless stiffness as in `Penalty`; resultants depend on it only through the width κ^(−1/3) of a point
        /// contact. It should be at least 1 for lines of contact: below, the contact layer (B/κ)^¼ is longer than the
        /// contact distance and offsets converge slowly. Rounding is the upper limit: the error of pressures is 1e-16 κ
        /// × the size of coordinates. Six decades in between give the same resultants (`tests/solver/contact_laws.rs`).
        stiffness: f64,
        /// Largest penetration accepted, relative to the smallest contact radius. Legal: 0 < tol < 1.
        tol_penetration: f64,
    },
    /// The augmented Lagrangian with the stiffness of [`ContactLaw::stiffness_by_mesh`]. The model of an engine has the
    /// number instead ([`ContactLaw::on_mesh`]) and keeps it when the mesh is refined or coarsened.
    ByMesh {
        /// Smallest stiffness, on coarse meshes, because the resultants of point contacts have an error of κ^(−2/3).
        /// Legal: > 0.
        least: f64,
        /// As in `AugmentedLagrangian`.
        tol_penetration: f64,
    },
}

/// Spacing of nodes in layers (B/κ)^¼ that determines [`ContactLaw::stiffness_by_mesh`].
const LAYERS_BETWEEN_NODES: f64 = 2.0;
/// Nodes of a rod beyond which the spacing is one layer, because ripples of lines of contact add up along a rod, and
/// what resists them, EA/L² against waves of sliding and B/L⁴ against bends, falls with its length: under two layers a
/// plectoneme of 30 000 nodes rests, one of 100 000 does not (`docs/PERFORMANCE.md`).
const MANY_NODES: usize = 30_000;
/// Largest κ ε⁴/B of [`ContactLaw::stiffness_by_mesh`], a layer of a tenth of the contact radius: strands do not wind
/// tightly enough for a stiffer law to change the result.
const MOST_BY_MESH: f64 = 1e4;

impl ContactLaw {
    /// The largest dimensionless stiffness κ ε⁴/B that a mesh of these rods resolves along lines of contact: the
    /// spacing of nodes is two contact layers (B/κ)^¼, one on rods of more than 30 000 nodes, on the rod with the most
    /// layers. Clamped to `least` and 10⁴ (or `least`, if larger); 100 for a spacing of 0.63 contact radii. With a
    /// stiffer law pressure concentrates between nodes and a line breaks up into points; with a softer law points of
    /// contact a few radii apart merge (`docs/ACCURACY.md`). `least` if no rod takes part in contact.
    pub fn stiffness_by_mesh(rods: &[Rod], least: f64) -> f64 {
        let touching = || rods.iter().filter(|rod| rod.section.contact_radius > 0.0);
        let smallest = |of: &dyn Fn(&Rod) -> f64| touching().map(of).fold(f64::INFINITY, f64::min);
        let radius = smallest(&Rod::least_contact_radius);
        let bending = rods.iter().map(|rod| rod.section.smaller_bending()).fold(f64::INFINITY, f64::min);
        // powers of ratios do not overflow in any unit
        let carried = |rod: &Rod| {
            let layers = if rod.num_nodes() > MANY_NODES { 1.0 } else { LAYERS_BETWEEN_NODES };
            rod.section.smaller_bending() / bending * (layers * radius / rod.spacing()).powi(4)
        };
        if radius.is_finite() { smallest(&carried).min(MOST_BY_MESH).max(least) } else { least }
    }

    /// The law with its stiffness as a number, for a mesh of these rods: `ByMesh` becomes `AugmentedLagrangian`, others
    /// are unchanged.
    #[must_use]
    pub fn on_mesh(self, rods: &[Rod]) -> Self {
        match self {
            Self::ByMesh { least, tol_penetration } => {
                Self::AugmentedLagrangian { stiffness: Self::stiffness_by_mesh(rods, least), tol_penetration }
            }
            given => given,
        }
    }

    /// The dimensionless stiffness κ ε⁴/B; `None` without contact and for [`ContactLaw::ByMesh`] (see
    /// [`ContactLaw::on_mesh`]).
    pub fn stiffness(&self) -> Option<f64> {
        match self {
            Self::None | Self::ByMesh { .. } => None,
            Self::Penalty { stiffness } | Self::AugmentedLagrangian { stiffness, .. } => Some(*stiffness),
        }
    }

    /// Whether contact is on.
    pub fn is_on(&self) -> bool {
        !matches!(self, Self::None)
    }
}

/// Contact choice of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The law.
    pub law: ContactLaw,
}

impl Contact {
    /// Default of the least dimensionless contact stiffness κ ε⁴/B: the contact layer (B/κ)^¼ is 0.56 contact radii.
    pub const DEFAULT_LEAST_STIFFNESS: f64 = 10.0;
    /// Default penetration tolerance relative to the contact radius.
    pub const DEFAULT_TOL_PENETRATION: f64 = 1e-8;

    /// No contact.
    pub const NONE: Self = Self { law: ContactLaw::None };
}

impl Default for Contact {
    fn default() -> Self {
        Self {
            law: ContactLaw::ByMesh {
                least: Self::DEFAULT_LEAST_STIFFNESS,
                tol_penetration: Self::DEFAULT_TOL_PENETRATION,
            },
        }
    }
}

/// Screened electrostatic repulsion of rods that are lines of charge: two points at a distance r have the energy A
/// exp(−r/λ)/r per product of their lengths. `contact::screened` defines the pairs of points and the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Electrostatics {
    /// A \[F\]: kT × Bjerrum length × (charges per length)².
    pub strength: f64,
    /// Debye length λ \[L\].
    pub debye_length: f64,
}

/// Length that three Gauss points resolve, in contact distances and in Debye lengths, because the energy of strands
/// that touch is then known to 1e-4.
const PIECE: [f64; 2] = [0.75, 2.0];

impl Electrostatics {
    /// Length of the pieces into which the sums over points divide segments, where the smallest contact radius is
    /// `least_radius` \[L\].
    pub(crate) fn piece(&self, least_radius: f64) -> f64 {
        (PIECE[0] * 2.0 * least_radius).min(PIECE[1] * self.debye_length)
    }
}

/// One quantity moved linearly from its present value to `to` during a stage.
#[derive(Debug, Clone, PartialEq)]
pub enum Ramp {
    /// Excess link of a closed rod, its link beyond [`Rod::natural_link`], in turns (continuous: the seam of the rod is
    /// turned).
    ExcessLink {
        /// The closed rod.
        rod: usize,
        /// Value at the end of the stage, turns.
        to: f64,
    },
    /// Rotates a node (whose rotation a support fixes) about a global axis; many turns are allowed.
    Rotation {
        /// The supported node.
        node: NodeRef,
        /// Axis (need not be unit), global.
        axis: Vec3,
        /// Total angle turned at the end of the stage since the start of the run, or since a stage held the node's
        /// rotation, turns.
        to: f64,
    },
    /// Rotates a node (whose position and rotation a support fixes) about an axis through a point, with its frame:
    /// nodes with one axis move like a rigid body. Many turns are allowed, in steps of at most [`Ramp::MAX_ROUND`]
    /// along chords of the circle. A displacement of the node is added: x = p + R(x₀ − p) + u.
    RotationAbout {
        /// The supported node.
        node: NodeRef,
        /// Axis (need not be unit), global.
        axis: Vec3,
        /// A point p on the axis \[L\].
        through: Vec3,
        /// Total angle turned at the end of the stage since the start of the run, or since a stage held the node's
        /// rotation, turns.
        to: f64,
    },
    /// Moves a node (whose position a support fixes) along a straight line, and the nodes that are joined to it.
    Displacement {
        /// The supported node.
        node: NodeRef,
        /// Total displacement at the end of the stage since the start of the run, or since a stage held the node's
        /// position \[L\].
        to: Vec3,
    },
    /// Moves a node (whose position and rotation supports fix entirely) to a pose, in steps that rotate it by at most
    /// [`Ramp::MAX_ROUND`] (turns about the tangent of an open rod excepted). A pose is absolute; rotations and
    /// displacements of other stages do not include it.
    Pose {
        /// The supported node.
        node: NodeRef,
        /// Pose at the end of the stage.
        pose: Pose,
    },
    /// The factor on all [`NodeLoad`]s and [`LineLoad`]s (that of the [`Model`] at the start of a run; dimensionless).
    Load {
        /// Factor at the end of the stage.
        to: f64,
    },
    /// A number of an obstacle, with rods moving that it pushes: its radius, a component of its displacement, its turns
    /// about its hinge; of a plane how far it is moved along its normal, positive towards the rods.
    Obstacle {
        /// Index of the obstacle.
        obstacle: usize,
        /// The number.
        which: ObstacleNumber,
        /// Value at the end of the stage; of displacements and turns since the start of the run.
        to: f64,
    },
    /// A number of a rod: contact radius, length, stiffness, natural curvature or twist. A change of length or natural
    /// twist keeps the link of a closed rod, so its excess link changes.
    Number {
        /// The rod.
        rod: usize,
        /// The number.
        which: RodNumber,
        /// Value at the end of the stage, in the unit of the number.
        to: f64,
    },
    /// Pressure on a planar closed rod: force per *current* length, along the inward normal in the x-y plane \[F/L\].
    Pressure {
        /// The closed rod.
        rod: usize,
        /// Pressure at the end of the stage \[F/L\]; positive pushes inwards.
        to: f64,
    },
}

impl Ramp {
    /// Largest rotation of a node in one step of a [`Ramp::RotationAbout`] or a [`Ramp::Pose`], turns, because the
    /// chord is nearer to the axis than the arc, here by 3 %.
    pub const MAX_ROUND: f64 = 1.0 / 12.0;
}

/// A change of supports, made before the first step of a stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SupportChange {
    /// Fixes a node in its present pose.
    Hold(Support),
    /// Releases components of a node from all supports.
    Release(Support),
}

impl SupportChange {
    /// The node and the components that change.
    pub fn support(&self) -> &Support {
        let (Self::Hold(support) | Self::Release(support)) = self;
        support
    }
}

/// A stage of the path: supports change, then all ramps move together from their present values to their targets.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// Changes of supports, in their order.
    pub supports: Vec<SupportChange>,
    /// The ramps.
    pub ramps: Vec<Ramp>,
    /// Number of equal steps first tried; a step that fails is halved and retried. Legal: 1 to 10⁹. With an augmented
    /// Lagrangian a step of several turns is solved turn by turn on a coarse mesh first, which is much cheaper than as
    /// many steps on the full mesh. [`Ramp::RotationAbout`] may need more steps.
    pub steps: usize,
}

impl Stage {
    /// Ramps in so many steps, under the supports of before.
    pub fn new(ramps: Vec<Ramp>, steps: usize) -> Self {
        Self { supports: Vec::new(), ramps, steps }
    }

    /// Its ramp, if that is all there is: a path can be followed along it.
    pub(crate) fn only_ramp(&self) -> Option<&Ramp> {
        match (&self.supports[..], &self.ramps[..]) {
            ([], [ramp]) => Some(ramp),
            _ => None,
        }
    }
}

/// A complete problem.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// The rods.
    pub rods: Vec<Rod>,
    /// Supports; several may act on one node.
    pub supports: Vec<Support>,
    /// Rigid joints, pins and hinges of nodes.
    pub joints: Vec<Joint>,
    /// Dead nodal loads at load factor 1.
    pub loads: Vec<NodeLoad>,
    /// Dead line loads at load factor 1.
    pub line_loads: Vec<LineLoad>,
    /// Load factor at the start of a run.
    pub load: f64,
    /// Rigid bodies that rods touch.
    pub obstacles: Vec<Obstacle>,
    /// Contact choice.
    pub contact: Contact,
    /// Screened repulsion of all rods that take part in contact, in addition to contact.
    pub electrostatics: Option<Electrostatics>,
    /// Planar scene: all rods lie in the x-y plane; z and rotations about x and y are eliminated.
    pub planar: bool,
}

/// A direction normalised, for any magnitude.
pub(crate) fn unit(direction: &Vec3) -> Vec3 {
    (direction / direction.amax()).normalize()
}

impl Model {
    /// Position and rotation components fixed at a node by all its supports and those of joined nodes together, as far
    /// as they share position and rotation (all out-of-plane components too in a planar model).
    pub fn fixed(&self, node: NodeRef) -> ([bool; 3], [bool; 3]) {
        let start = ([false, false, self.planar], [self.planar, self.planar, false]);
        let either = |a: [bool; 3], b: [bool; 3]| std::array::from_fn(|k| a[k] || b[k]);
        let (joined, turning) = (self.joined_nodes(node), self.turning_nodes(node));
        self.supports.iter().fold(start, |(position, rotation), support| {
            let position = if joined.contains(&support.node) { either(position, support.position) } else { position };
            let rotation = if turning.contains(&support.node) { either(rotation, support.rotation) } else { rotation };
            (position, rotation)
        })
    }

    /// Adds and removes supports; returns whether there was a change. What is let go at a node is let go at all nodes
    /// that share it by joints.
    pub(crate) fn change_supports(&mut self, changes: &[SupportChange]) -> bool {
        let before = self.supports.clone();
        for change in changes {
            match change {
                SupportChange::Release(gone) => {
                    let (joined, turning) = (self.joined_nodes(gone.node), self.turning_nodes(gone.node));
                    for support in &mut self.supports {
                        let shares = [joined.contains(&support.node), turning.contains(&support.node)];
                        for k in 0..3 {
                            support.position[k] &= !(shares[0] && gone.position[k]);
                            support.rotation[k] &= !(shares[1] && gone.rotation[k]);
                        }
                    }
                    self.supports
                        .retain(|support| support.position.contains(&true) || support.rotation.contains(&true));
                }
                SupportChange::Hold(support) if !self.supports.contains(support) => self.supports.push(*support),
                SupportChange::Hold(_) => {}
            }
        }
        self.supports != before
    }

    /// The node and all nodes that joints connect it to.
    pub(crate) fn joined_nodes(&self, node: NodeRef) -> Vec<NodeRef> {
        self.nodes_joined_by(node, |_| true)
    }

    /// Nodes whose displacement, and whose turns, count from where a support of a stage holds them: those joined to its
    /// own, if it holds position, and those that turn with it, if it holds rotation.
    pub(crate) fn moved_with(&self, support: &Support) -> [Vec<NodeRef>; 2] {
        let (joined, turning) = (self.joined_nodes(support.node), self.turning_nodes(support.node));
        let of = |held: [bool; 3], nodes| if held.contains(&true) { nodes } else { Vec::new() };
        [of(support.position, joined), of(support.rotation, turning)]
    }

    /// The node and all nodes that rigid joints connect it to: they share all rotation.
    pub(crate) fn turning_nodes(&self, node: NodeRef) -> Vec<NodeRef> {
        self.nodes_joined_by(node, |joint| joint.kind == JointKind::Rigid)
    }

    /// The node and all nodes that rigid joints and hinges connect it to: they share rotation but about the hinges'
    /// axis. In a plane hinges are pins.
    pub(crate) fn hinged_nodes(&self, node: NodeRef) -> Vec<NodeRef> {
        self.nodes_joined_by(node, |joint| joint.kind == JointKind::Rigid || self.hinge_axis(joint).is_some())
    }

    /// The axis of a hinge in space, of length 1.
    pub(crate) fn hinge_axis(&self, joint: &Joint) -> Option<Vec3> {
        match joint.kind {
            JointKind::Hinge { axis } if !self.planar => Some(unit(&axis)),
            _ => None,
        }
    }

    fn nodes_joined_by(&self, node: NodeRef, by: impl Fn(&Joint) -> bool) -> Vec<NodeRef> {
        let mut found = vec![node];
        let mut next = 0;
        while next < found.len() {
            let here = found[next];
            for joint in self.joints.iter().filter(|joint| by(joint)) {
                let other = if joint.a == here { joint.b } else { joint.a };
                if (joint.a == here || joint.b == here) && !found.contains(&other) {
                    found.push(other);
                }
            }
            next += 1;
        }
        found
    }

    /// The rod and all rods that joints connect it to.
    pub(crate) fn joined_rods(&self, rod: usize) -> Vec<usize> {
        self.rods_joined_by(rod, |_| true)
    }

    /// The rod and all rods that rigid joints connect it to.
    pub(crate) fn rigidly_joined_rods(&self, rod: usize) -> Vec<usize> {
        self.rods_joined_by(rod, |joint| joint.kind == JointKind::Rigid)
    }

    fn rods_joined_by(&self, rod: usize, by: impl Fn(&Joint) -> bool) -> Vec<usize> {
        let mut found = vec![rod];
        let mut next = 0;
        while next < found.len() {
            let here = found[next];
            for joint in self.joints.iter().filter(|joint| by(joint)) {
                let (a, b) = (joint.a.rod, joint.b.rod);
                for other in [a, b] {
                    if (a == here || b == here) && !found.contains(&other) {
                        found.push(other);
                    }
                }
            }
            next += 1;
        }
        found
    }
}
