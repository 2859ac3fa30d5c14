//! Planes that rods rest on: half-spaces that no rod enters.

use crate::error::InputError;
use crate::math::Vec3;
use crate::math::bernstein::cubic_weights;
use crate::rod::Rod;

use super::Model;

/// Deviation of a normal's length from 1 that counts as rounding.
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
