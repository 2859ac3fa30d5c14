//! Rigid bodies that rods touch without friction, and where stages, or the nodes that carry them, have moved them.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::error::InputError;
use crate::math::bernstein::cubic_weights;
use crate::math::handles::control_points;
use crate::math::quaternion::exp;
use crate::math::signed_distance::Surface;
use crate::math::{Mat3, Quat, Vec3};
use crate::rod::Rod;

pub use crate::math::signed_distance::Skeleton;

use super::{Model, NodeRef, unit};

/// Names that columns of tables begin with, of contact and of ends of rods: `contact_force`, `end_displaced_x`.
const TAKEN: [&str; 3] = ["contact", "start", "end"];
/// Deviation of a normal's or an axis's length from 1 that counts as rounding.
const TOL_UNIT: f64 = 1e-9;
/// Depth of a rod's surface at the start, over its contact radius, that is refused: more than a penalty leaves at rest.
const DEEP: f64 = 0.1;
/// Points of a segment that are looked at for that.
const POINTS: usize = 8;

/// Side of a surface that rods are on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Side {
    /// Away from the skeleton: a post, a pulley, a ball; a plane's side that its normal points to.
    #[default]
    Outside,
    /// About the skeleton: a tube, a cavity.
    Inside,
}

/// A line fixed in space, about which stages turn an obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Hinge {
    /// A point on it \[L\].
    pub through: Vec3,
    /// Direction, of any length.
    pub axis: Vec3,
}

/// A rigid body that rods touch on one side, and that pushes without friction: a table, a press, a pulley, a tube, a
/// capsid.
///
/// Its surface is at the distance `radius` from its skeleton, see [`Skeleton`]: a plane, a sphere about a point, a
/// cylinder about a line. Rods that take part in contact keep their contact radius from it, under the law of contact
/// between rods. [`Ramp::Obstacle`](super::Ramp::Obstacle) moves it and changes its radius. It may be parted from: by
/// itself it holds a rod only against dead forces that press the rod onto it.
///
/// A node may carry it ([`Obstacle::bead`], [`Obstacle::grip`]): it moves and turns with the node, and what rods exert
/// on it acts on the node. The rod of that node, and rods joined there, do not touch it next to the node: as far as a
/// curve that turns by less than half a turn may need to leave it, π/2 (radius + contact radius) along the rod. Carried
/// bodies do not touch each other, nor other obstacles.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Obstacle {
    /// Name in reports.
    pub name: String,
    /// What its surface is everywhere equally far from. In a planar model the x-y plane of the rods is a plane of
    /// symmetry.
    pub skeleton: Skeleton,
    /// Distance of the surface from the skeleton at the start \[L\]; 0 of a plane.
    pub radius: f64,
    /// Where rods are; of a plane outside.
    pub side: Side,
    /// What it may be turned about.
    pub hinge: Option<Hinge>,
    /// The node that carries it, at the skeleton's point.
    #[cfg_attr(feature = "serde", serde(default))]
    pub carrier: Option<NodeRef>,
}

/// Where an obstacle is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ObstaclePose {
    /// Distance of the surface from the skeleton \[L\]: a radius; of a plane how far it has been moved along its
    /// normal.
    pub level: f64,
    /// Displacement since the start, after the turn \[L\].
    pub displacement: Vec3,
    /// Turns about the hinge since the start.
    pub turns: f64,
    /// Rotation vector since the start of what a node carries, about the node, rad.
    #[cfg_attr(feature = "serde", serde(default))]
    pub rotation: Vec3,
}

/// A number of a [`ObstaclePose`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ObstacleNumber {
    /// [`ObstaclePose::level`] \[L\].
    Level,
    /// Component of [`ObstaclePose::displacement`] along x (0), y (1) or z (2) \[L\].
    Displacement(usize),
    /// [`ObstaclePose::turns`].
    Turns,
}

impl ObstacleNumber {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Level, Self::Displacement(0), Self::Displacement(1), Self::Displacement(2), Self::Turns];
}

impl ObstaclePose {
    /// One of its numbers.
    pub fn get(&self, which: ObstacleNumber) -> f64 {
        match which {
            ObstacleNumber::Level => self.level,
            ObstacleNumber::Displacement(k) => self.displacement[k],
            ObstacleNumber::Turns => self.turns,
        }
    }

    /// Changes one of its numbers.
    pub fn set(&mut self, which: ObstacleNumber, to: f64) {
        match which {
            ObstacleNumber::Level => self.level = to,
            ObstacleNumber::Displacement(k) => self.displacement[k] = to,
            ObstacleNumber::Turns => self.turns = to,
        }
    }

    /// Whether all its numbers are finite.
    pub fn is_finite(&self) -> bool {
        ObstacleNumber::ALL.iter().all(|which| self.get(*which).is_finite())
    }
}

/// What an obstacle exerts on a part of a rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Push {
    /// ∫p ds \[F\].
    pub(crate) pressure: f64,
    /// \[F\]
    pub(crate) force: Vec3,
    /// About `at` \[F·L\].
    pub(crate) torque: Vec3,
    /// \[L\]
    pub(crate) at: Vec3,
}

impl Obstacle {
    /// The half-space n·(x − p) ≥ 0 that rods stay in.
    pub fn plane(name: impl Into<String>, point: Vec3, normal: Vec3) -> Self {
        Self::new(name, Skeleton::Plane { point, normal }, (0.0, Side::Outside))
    }

    /// A ball or a cavity.
    pub fn sphere(name: impl Into<String>, center: Vec3, (radius, side): (f64, Side)) -> Self {
        Self::new(name, Skeleton::Point { point: center }, (radius, side))
    }

    /// An endless post or tube about a line through a point.
    pub fn cylinder(name: impl Into<String>, [point, axis]: [Vec3; 2], (radius, side): (f64, Side)) -> Self {
        Self::new(name, Skeleton::Line { point, axis }, (radius, side))
    }

    /// A ball about a node that carries it.
    ///
    /// # Panics
    /// If there is no such node.
    pub fn bead(name: impl Into<String>, rods: &[Rod], node: NodeRef, radius: f64) -> Self {
        let made = Self::sphere(name, rods[node.rod].positions[node.node], (radius, Side::Outside));
        Self { carrier: Some(node), ..made }
    }

    /// A rod's end prolonged by a rigid capsule as thick as its contact radius there, outwards along d3; endless
    /// without a length.
    ///
    /// # Panics
    /// If there is no such node.
    pub fn grip(name: impl Into<String>, rods: &[Rod], node: NodeRef, length: Option<f64>) -> Self {
        let rod = &rods[node.rod];
        let tangent = rod.frames[node.node] * Vec3::z();
        let (axis, last) = if node.node == 0 { (-tangent, 0) } else { (tangent, rod.num_segments().saturating_sub(1)) };
        let skeleton = Skeleton::Piece { point: rod.positions[node.node], axis, length };
        let made = Self::new(name, skeleton, (rod.contact_radius_of(last), Side::Outside));
        Self { carrier: Some(node), ..made }
    }

    fn new(name: impl Into<String>, skeleton: Skeleton, (radius, side): (f64, Side)) -> Self {
        Self { name: name.into(), skeleton, radius, side, hinge: None, carrier: None }
    }

    /// Whether it is a plane.
    pub fn is_plane(&self) -> bool {
        self.skeleton.is_flat()
    }

    /// Word for what it is.
    pub(crate) fn kind(&self) -> &'static str {
        match self.skeleton {
            Skeleton::Plane { .. } => "plane",
            Skeleton::Point { .. } => "sphere",
            Skeleton::Line { .. } => "cylinder",
            Skeleton::Piece { .. } => "capsule",
        }
    }

    /// Arc length from a carrying node within which a rod of this contact radius does not touch a body of this radius
    /// \[L\]: a curve that turns by less than π over a length ends 2/π of it or farther from where it began (Schur).
    pub(crate) fn surroundings(radius: f64, contact_radius: f64) -> f64 {
        FRAC_PI_2 * (radius + contact_radius)
    }

    /// Where it is at the start.
    pub fn start(&self) -> ObstaclePose {
        ObstaclePose { level: self.radius, ..ObstaclePose::default() }
    }

    /// Its rotation, and where it takes points to.
    fn motion(&self, placement: &ObstaclePose) -> (Quat, impl Fn(&Vec3) -> Vec3) {
        let (through, rotation) = match self.hinge.filter(|_| placement.turns != 0.0) {
            Some(hinge) => (hinge.through, exp(&(unit(&hinge.axis) * (placement.turns * TAU)))),
            None => (Vec3::zeros(), Quat::identity()),
        };
        let carried = self.carrier.filter(|_| placement.rotation != Vec3::zeros());
        let (through, rotation) =
            carried.map_or((through, rotation), |_| (self.skeleton.point(), exp(&placement.rotation)));
        let displacement = placement.displacement;
        (rotation, move |x: &Vec3| {
            let turned = if rotation == Quat::identity() { *x } else { through + rotation * (x - through) };
            turned + displacement
        })
    }

    /// Its skeleton at the start, its axis of length 1.
    fn normalised(&self) -> Skeleton {
        match self.skeleton {
            Skeleton::Line { point, axis } => Skeleton::Line { point, axis: unit(&axis) },
            other => other,
        }
    }

    /// Its surface where it is placed.
    pub(crate) fn placed(&self, placement: &ObstaclePose) -> Surface {
        let (rotation, moved) = self.motion(placement);
        self.surface(placement.level, (moved(&self.skeleton.point()), Vec3::zeros()), &rotation)
    }

    /// Its surface with the skeleton's point at the sum of two vectors, the second what the first is rounded by.
    pub(crate) fn surface(&self, level: f64, (point, lost): (Vec3, Vec3), rotation: &Quat) -> Surface {
        let sign = if self.side == Side::Outside { 1.0 } else { -1.0 };
        let skeleton = self.normalised().moved(point, rotation);
        Surface { skeleton, level, lost, sign, carried: self.carrier.is_some() }
    }

    /// Where it is with a carrying node that has come to a place and turned by a rotation vector since the start.
    pub(crate) fn carried(&self, placement: &ObstaclePose, place: &Vec3, rotation: Vec3) -> ObstaclePose {
        ObstaclePose { displacement: place - self.skeleton.point(), rotation, ..*placement }
    }

    /// Whether it passes one of some points \[L\], or comes to have it beyond its middle, on its way from one placement
    /// to another: what moves by more than its radius may do so. Points count that are as near as it moves, and
    /// `spacing` more. Hollow bodies and planes have no far side.
    pub(crate) fn leaps_over(&self, [from, to]: [&ObstaclePose; 2], points: &[Vec3], spacing: f64) -> bool {
        let surface = self.placed(from);
        if surface.is_hollow() {
            return false;
        }
        let turned = ObstaclePose { turns: to.turns - from.turns, ..ObstaclePose::default() };
        let (_, turn) = self.motion(&turned);
        let way = |x: &Vec3| (turn(&(x - from.displacement)) + to.displacement - x).norm();
        let is_near = |x: &Vec3, way: f64| surface.distance(&(x - surface.point())) <= way + spacing;
        points.iter().any(|x| way(x) > to.level.min(from.level) && is_near(x, way(x)))
    }

    /// The map x ↦ A x + b that takes its surface at the start to where it is placed.
    pub fn image(&self, placement: &ObstaclePose) -> (Mat3, Vec3) {
        let (rotation, moved) = self.motion(placement);
        let point = self.skeleton.point();
        let grown = if self.is_plane() { 1.0 } else { placement.level / self.radius };
        let stretch = match self.skeleton {
            Skeleton::Line { axis, .. } | Skeleton::Piece { axis, .. } => {
                let along = unit(&axis) * unit(&axis).transpose();
                along + (Mat3::identity() - along) * grown
            }
            _ => Mat3::identity() * grown,
        };
        let matrix = rotation.to_rotation_matrix() * stretch;
        let lifted = match self.skeleton {
            Skeleton::Plane { normal, .. } => rotation * normal * placement.level,
            _ => Vec3::zeros(),
        };
        (matrix, moved(&point) + lifted - matrix * point)
    }

    /// Work of what it exerts on rods, where it is placed, over a small motion from one placement to another \[F·L\].
    pub(crate) fn work(&self, placement: &ObstaclePose, [from, to]: [&ObstaclePose; 2], push: &Push) -> f64 {
        let grows = push.pressure * (to.level - from.level);
        let moves = push.force.dot(&(to.displacement - from.displacement));
        let turns = self.hinge.map_or(0.0, |hinge| {
            let arm = push.at - placement.displacement - hinge.through;
            unit(&hinge.axis).dot(&(push.torque + arm.cross(&push.force))) * TAU * (to.turns - from.turns)
        });
        moves + turns + if self.side == Side::Outside { grows } else { -grows }
    }

    /// Directions in which it can push a rod that leans on it with its weight; `None`: any, or none, as the rod lies.
    pub(super) fn pushes(&self) -> Option<Vec<Vec3>> {
        let all = [Vec3::x(), Vec3::y(), Vec3::z()];
        let both = |along: &Vec3| all.map(|e| e - along * along.dot(&e)).into_iter().flat_map(|e| [e, -e]).collect();
        match (self.skeleton, self.side) {
            (Skeleton::Plane { normal, .. }, _) => Some(vec![normal]),
            (Skeleton::Point { .. }, Side::Inside) => Some(both(&Vec3::zeros())),
            (Skeleton::Line { axis, .. }, Side::Inside) => Some(both(&unit(&axis))),
            (Skeleton::Piece { .. }, Side::Inside) | (_, Side::Outside) => None,
        }
    }
}

impl Model {
    /// Refuses obstacles that are none, or that rods start in.
    pub(super) fn check_obstacles(&self) -> Result<(), InputError> {
        let (mut planes, mut others) = (0, 0);
        for obstacle in &self.obstacles {
            let (list, index) = if obstacle.is_plane() { ("planes", &mut planes) } else { ("obstacles", &mut others) };
            let place = format!("{list}[{index}]");
            *index += 1;
            self.check_obstacle(&place, obstacle)?;
            if !self.touches().any(|_| true) {
                let reason = "no rod can touch it: give one a contact_radius, and leave contact on";
                return Err(InputError::inconsistent(place, reason));
            }
            self.check_level(&format!("{place}.radius"), obstacle, obstacle.radius)?;
            self.check_carrier(&place, obstacle)?;
            (0..self.rods.len()).try_for_each(|rod| self.check_clear(&place, obstacle, rod))?;
        }
        Ok(())
    }

    /// Refuses a node that cannot carry an obstacle.
    fn check_carrier(&self, place: &str, obstacle: &Obstacle) -> Result<(), InputError> {
        let field = format!("{place}.carrier");
        let refuse = |reason: &str| Err(InputError::inconsistent(&field, reason));
        let Some(NodeRef { rod, node }) = obstacle.carrier else {
            let is_piece = matches!(obstacle.skeleton, Skeleton::Piece { .. });
            return if is_piece { refuse("missing: a capsule is carried by a node") } else { Ok(()) };
        };
        let Some(at) = self.rods.get(rod).and_then(|rod| rod.positions.get(node)) else {
            let allowed = "a node of the model";
            return Err(InputError::Count { field, value: node, allowed });
        };
        if matches!(obstacle.skeleton, Skeleton::Plane { .. } | Skeleton::Line { .. }) || obstacle.side == Side::Inside
        {
            return refuse("only spheres and capsules that rods stay outside of are carried by a node");
        }
        if *at != obstacle.skeleton.point() {
            return refuse("must be at the sphere's centre, or where the capsule begins");
        }
        if obstacle.hinge.is_some() {
            return refuse("moves and turns it: leave out the hinge");
        }
        Ok(())
    }

    /// Arc lengths of a rod \[L\] between which it does not touch an obstacle, because it carries it; on a closed rod
    /// perhaps beyond its seam.
    pub(crate) fn left_out(&self, obstacle: &Obstacle, level: f64, rod: usize) -> Vec<[f64; 2]> {
        let reach = Obstacle::surroundings(level, self.rods[rod].thickest());
        let of_node = |at: NodeRef| [-reach, reach].map(|by| self.rods[rod].spacing() * at.node as f64 + by);
        let nodes = obstacle.carrier.map_or(Vec::new(), |node| self.joined_nodes(node));
        nodes.into_iter().filter(|at| at.rod == rod).map(of_node).collect()
    }

    fn check_obstacle(&self, place: &str, obstacle: &Obstacle) -> Result<(), InputError> {
        let vector = |key: &str, value: &Vec3, ok: bool, allowed: &'static str| {
            let field = format!("{place}.{key}");
            if ok { Ok(()) } else { Err(InputError::Vector { field, value: (*value).into(), allowed }) }
        };
        if TAKEN.contains(&obstacle.name.as_str()) {
            let reason = format!(
                "is \"{}\", as which columns of tables begin already ({0}_force): give the obstacle another name",
                obstacle.name
            );
            return Err(InputError::inconsistent(format!("{place}.name"), reason));
        }
        let finite = |v: &Vec3| v.iter().all(|x| x.is_finite());
        let point = obstacle.skeleton.point();
        vector("point", &point, finite(&point), "three finite numbers")?;
        let height = self.rods.first().map_or(0.0, |rod| rod.positions[0].z);
        match &obstacle.skeleton {
            Skeleton::Plane { normal, .. } => {
                let is_unit = (normal.norm() - 1.0).abs() <= TOL_UNIT;
                let allowed = if self.planar { "a unit vector in the x-y plane" } else { "a unit vector" };
                vector("normal", normal, is_unit && !(self.planar && normal.z != 0.0), allowed)?;
            }
            Skeleton::Point { .. } => {
                let allowed = "a centre in the plane of the rods, of a planar scene";
                vector("point", &point, !self.planar || point.z == height, allowed)?;
            }
            Skeleton::Line { axis, .. } => {
                vector("axis", axis, finite(axis) && axis.amax() > 0.0, "three finite numbers, not all zero")?;
                let crosses = axis.xy().amax() == 0.0;
                let allowed = "along z, or through a point in the plane of the rods and along it, of a planar scene";
                let lies = axis.z == 0.0 && point.z == height;
                vector("axis", axis, !self.planar || crosses || lies, allowed)?;
            }
            Skeleton::Piece { axis, length, .. } => {
                vector("axis", axis, (axis.norm() - 1.0).abs() <= TOL_UNIT, "a unit vector")?;
                let allowed = "in the x-y plane of the rods, of a planar scene";
                vector("axis", axis, !self.planar || axis.z.abs() <= TOL_UNIT, allowed)?;
                let length = length.unwrap_or(1.0);
                InputError::check(&format!("{place}.length"), length, length > 0.0, "a finite number > 0")?;
            }
        }
        if let Some(Hinge { through, axis }) = &obstacle.hinge {
            vector("hinge.through", through, finite(through), "three finite numbers")?;
            vector("hinge.axis", axis, finite(axis) && axis.amax() > 0.0, "three finite numbers, not all zero")?;
            vector("hinge.axis", axis, !self.planar || axis.xy().amax() == 0.0, "along z, of a planar scene")?;
        }
        Ok(())
    }

    /// Refuses a radius that no rod fits in.
    pub(super) fn check_level(&self, field: &str, obstacle: &Obstacle, radius: f64) -> Result<(), InputError> {
        if obstacle.is_plane() {
            return InputError::check(field, radius, true, "a finite displacement");
        }
        InputError::check(field, radius, radius > 0.0, "a finite number > 0")?;
        let thickest = self.touches().max_by(|a, b| a.section.contact_radius.total_cmp(&b.section.contact_radius));
        let Some(rod) = thickest.filter(|rod| obstacle.side == Side::Inside && rod.section.contact_radius >= radius)
        else {
            return Ok(());
        };
        let reason = format!(
            "{radius}: rod \"{}\", whose contact radius is {}, has no room inside; make it larger than that",
            rod.name, rod.section.contact_radius
        );
        Err(InputError::inconsistent(field, reason))
    }

    /// Whether a rod takes part in contact.
    pub(super) fn is_touchable(&self, rod: &Rod) -> bool {
        rod.section.contact_radius > 0.0 && self.contact.law.is_on()
    }

    /// Rods that take part in contact.
    fn touches(&self) -> impl Iterator<Item = &Rod> {
        self.rods.iter().filter(|rod| self.is_touchable(rod))
    }
}

impl Model {
    /// Refuses a rod whose surface is beyond that of an obstacle.
    fn check_clear(&self, field: &str, obstacle: &Obstacle, index: usize) -> Result<(), InputError> {
        let rod = &self.rods[index];
        if !self.is_touchable(rod) {
            return Ok(());
        }
        let (spacing, radius) = (rod.spacing(), rod.section.contact_radius);
        let surface = obstacle.placed(&obstacle.start());
        let left_out = self.left_out(obstacle, obstacle.radius, index);
        let mut deepest = (DEEP * radius, None);
        let round = if rod.closed { rod.length } else { 0.0 };
        let touches = |k: &usize| !overlaps(&left_out, [*k, *k + 1].map(|k| spacing * k as f64), round);
        for k in (0..rod.num_segments()).filter(touches) {
            let [a, b] = [k, (k + 1) % rod.num_nodes()];
            // the contact centreline
            let points = control_points([a, b].map(|n| rod.positions[n]), [a, b].map(|n| rod.frames[n] * Vec3::z()));
            for i in 0..=POINTS {
                let u = i as f64 / POINTS as f64;
                let point: Vec3 = cubic_weights(u).iter().zip(&points).map(|(w, point)| point * *w).sum();
                let depth = radius - surface.distance(&(point - surface.point()));
                if depth > deepest.0 {
                    deepest = (depth, Some((spacing * (k as f64 + u), point)));
                }
            }
        }
        let (depth, Some((arc, at))) = deepest else { return Ok(()) };
        let reason = format!(
            "rod \"{}\" starts beyond it: its surface is {depth} deep at arc {arc}, where its centreline is at ({}, \
             {}, {}); move the rod, or the {}, by that along the normal",
            rod.name,
            at.x,
            at.y,
            at.z,
            obstacle.kind()
        );
        Err(InputError::inconsistent(field, reason))
    }
}

/// Whether an arc overlaps one of others, on a closed rod of length `round` also over its seam.
pub(crate) fn overlaps(others: &[[f64; 2]], [from, to]: [f64; 2], round: f64) -> bool {
    let shifts = [-round, 0.0, round];
    others.iter().any(|other| shifts.iter().any(|shift| other[0] < to + shift && from + shift < other[1]))
}
