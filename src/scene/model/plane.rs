//! Planes that rods rest on: half-spaces that no rod enters.

use crate::error::InputError;
use crate::math::bernstein::cubic_weights;
use crate::math::{Mat3, Vec3};
use crate::rod::Rod;

use super::Model;

/// Deviation of a normal's length from 1, and of forces from those that normals balance, that counts as rounding.
const TOL_UNIT: f64 = 1e-9;
/// Depth of a rod's surface at the start, over its contact radius, that is refused: more than a penalty leaves at rest.
const DEEP: f64 = 0.1;
/// Points of a segment that are looked at for that.
const POINTS: usize = 8;

/// A plane that rods touch on one side, and that pushes without friction: a table, a press, the surface that tweezers
/// hold a molecule to. Rods that take part in contact stay in n·(x − p) ≥ their contact radius, under the law of contact
/// between rods; [`Ramp::Plane`](super::Ramp::Plane) moves it along its normal. A plane holds a rod by itself only
/// against dead forces that press the rod onto it: it may be parted from.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Name in reports.
    pub name: String,
    /// A point p on the plane \[L\].
    pub point: Vec3,
    /// Unit normal n, towards the rods. In the x-y plane where the model is planar.
    pub normal: Vec3,
}

impl Model {
    /// Refuses planes that are none, or that rods start beyond.
    pub(super) fn check_planes(&self) -> Result<(), InputError> {
        for (i, plane) in self.planes.iter().enumerate() {
            let field = |key: &str| format!("planes[{i}].{key}");
            if !plane.point.iter().all(|x| x.is_finite()) {
                let (value, allowed) = (plane.point.into(), "three finite numbers");
                return Err(InputError::Vector { field: field("point"), value, allowed });
            }
            let is_unit = (plane.normal.norm() - 1.0).abs() <= TOL_UNIT;
            if !is_unit || self.planar && plane.normal.z != 0.0 {
                let allowed = if self.planar { "a unit vector in the x-y plane" } else { "a unit vector" };
                return Err(InputError::Vector { field: field("normal"), value: plane.normal.into(), allowed });
            }
            if !self.touches().any(|_| true) {
                let reason = "no rod can touch it: give one a contact_radius, and leave contact on";
                return Err(InputError::inconsistent(format!("planes[{i}]"), reason));
            }
            self.touches().try_for_each(|rod| check_above(&format!("planes[{i}]"), plane, rod))?;
        }
        Ok(())
    }

    /// Whether planes carry the dead forces on a rod that nothing else holds, so that no way down is open to it: minus the sum
    /// of the forces is a sum of normals, none of which counts negative, or else a motion away from all planes exists that they
    /// do work on (Farkas). Three normals are enough (Carathéodory).
    pub(super) fn is_carried(&self, rod: usize) -> bool {
        let at_nodes = self.loads.iter().filter(|load| load.node.rod == rod);
        let along = self.line_loads.iter().filter(|load| load.rod == rod);
        let turned = at_nodes.clone().any(|load| load.moment != Vec3::zeros())
            || along.clone().any(|load| load.moment != Vec3::zeros());
        let length = self.rods[rod].length;
        let down = at_nodes.map(|load| load.force).sum::<Vec3>() + along.map(|load| load.force * length).sum::<Vec3>();
        let normal = |plane: usize| self.planes[plane].normal;
        let count = self.planes.len();
        let sets = (0..count).flat_map(|i| (i..count).flat_map(move |j| (j..count).map(move |k| [i, j, k])));
        self.is_touchable(&self.rods[rod])
            && !turned
            && down != Vec3::zeros()
            && sets.map(|set| set.map(normal)).any(|set| balances(set, &-down))
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

/// Refuses a rod whose surface is beyond a plane.
fn check_above(field: &str, plane: &Plane, rod: &Rod) -> Result<(), InputError> {
    let (spacing, radius) = (rod.spacing(), rod.section.contact_radius);
    let mut deepest = (DEEP * radius, None);
    for k in 0..rod.num_segments() {
        let [a, b] = [k, (k + 1) % rod.num_nodes()];
        let handle = |n: usize| rod.frames[n] * Vec3::z() * (spacing / 3.0);
        let (start, end) = (rod.positions[a], rod.positions[b]);
        // the contact centreline
        let points = [start, start + handle(a), end - handle(b), end];
        for i in 0..=POINTS {
            let u = i as f64 / POINTS as f64;
            let point: Vec3 = cubic_weights(u).iter().zip(&points).map(|(w, point)| point * *w).sum();
            let depth = radius - plane.normal.dot(&(point - plane.point));
            if depth > deepest.0 {
                deepest = (depth, Some((spacing * (k as f64 + u), point)));
            }
        }
    }
    let (depth, Some((arc, at))) = deepest else { return Ok(()) };
    let reason = format!(
        "rod \"{}\" starts beyond it: its surface is {depth} deep at arc {arc}, where its centreline is at ({}, {}, {}); move \
         the rod, or the plane, by that along the normal",
        rod.name, at.x, at.y, at.z
    );
    Err(InputError::inconsistent(field, reason))
}

/// Whether a force is a sum of these directions, none of which counts negative; they may repeat.
fn balances(directions: [Vec3; 3], force: &Vec3) -> bool {
    let shares = Mat3::from_columns(&directions).pseudo_inverse(TOL_UNIT).map(|inverse| inverse * force);
    let is_met = |shares: Vec3| {
        let sum: Vec3 = directions.iter().zip(shares.iter()).map(|(direction, share)| direction * *share).sum();
        let least = TOL_UNIT * force.norm();
        shares.min() >= -least && (sum - force).norm() <= least
    };
    shares.is_ok_and(is_met)
}
