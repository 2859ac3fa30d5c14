//! Directions of contact forces.
//!
//! ```text
//! n(s) = (r(s) − r(t))/|r(s) − r(t)|      r(t) the nearest point of the partner's part; and the other way round
//! ∠(F, n̄) ≤ α,  cos α ≤ |F|/∫p ds ≤ 1     n̄ the direction of Σ n, α the largest angle of a normal from it
//! ```
//!
//! Contact has no friction, and pushes. So the force of a site is a sum of its normals with weights that are not
//! negative: it lies in the cone of all of them, and is as long as such a sum. Normals are those of the elements' own
//! centreline at points along the site. Curves that are smooth through the nodes have normals that differ by the mesh's
//! resolution over the distance. Of strands that wind about each other by half a turn or more only |F| ≤ ∫p ds is left.
//! Half of the pressure acts at points of either strand, so the cone is that of the normals of both. Where feet run
//! forth and back, what is counted twice is subtracted as a site of its own, of negative pressure: the balance has it.

use std::f64::consts::FRAC_PI_2;

use super::arcs::{Arc, Arcs};
use super::obstacles::at_obstacle;
use super::{Check, ContactForce, Counterpart, Subject, Worst};
use crate::math::Vec3;

/// Points along a site at least and at most: an end of a site is a normal, and a line of more turns between them than
/// that counts.
const POINTS: [usize; 2] = [4, 32];
/// Angle beyond the cone, times the force over the largest one, that is explained by forces being known to 1e-6 of the
/// largest one.
const TOL_ANGLE: f64 = 1e-6;
/// Newton steps for the nearest point of an arc, because each squares the error of a point that the chord gives.
const MAX_STEPS: usize = 8;
/// Size of the last of these steps, as a parameter of the arc.
const TOL_STEP: f64 = 1e-10;

/// Unit of the deviation.
const UNIT: &str = "rad beyond the normals × force over the largest";

/// The normals of a site.
struct Cone {
    axis: Vec3,
    /// Largest angle of a normal from the axis, and by how much normals are uncertain, rad.
    angle: f64,
}

pub(super) fn check(subject: &Subject, arcs: &Arcs) -> Option<Check> {
    let contact = subject.contact.filter(|contact| !contact.is_empty())?;
    let largest = contact.iter().map(|at| at.force.norm()).fold(0.0, f64::max);
    let mut worst = Worst::none();
    for at in contact.iter().filter(|at| at.carried >= 0.0) {
        let cone = match at.partner {
            Counterpart::Strand { rod, arc } => Cone::of_strands(arcs, at, (rod, arc)),
            Counterpart::Opposite => continue,
            Counterpart::Obstacle(k) => Cone::at_obstacle(arcs, at, at_obstacle(subject, k)),
        };
        let off = beyond(at, cone.as_ref()) * at.force.norm() / largest;
        worst.add(off, || format!("rod \"{}\" at arc {:.4}", subject.model.rods[at.rod].name, at.arc[0]));
    }
    Some(Check::new("normals", worst.value, TOL_ANGLE, worst.detail(UNIT)))
}

/// Angle by which a force is beyond a cone, or shorter than it may be; by how much it is longer than the pressure
/// carries.
fn beyond(at: &ContactForce, cone: Option<&Cone>) -> f64 {
    let part = at.force.norm() / at.carried;
    let longer = (part - 1.0).max(0.0);
    let Some(cone) = cone.filter(|cone| cone.angle < FRAC_PI_2) else { return longer };
    let from_axis = at.force.angle(&cone.axis).max(part.min(1.0).acos());
    (from_axis - cone.angle).max(longer)
}

impl Cone {
    /// Of two strands, from the partner to the strand; `None` where no normal is found.
    fn of_strands(arcs: &Arcs, at: &ContactForce, (rod, arc): (usize, [f64; 2])) -> Option<Self> {
        let mut all = Normals::default();
        let near = |rod: usize, arc: [f64; 2]| (arcs.along(rod, arc, 1.0), arcs.tips(rod));
        all.add(&arcs.along(at.rod, at.arc, 0.0), &near(rod, arc), 1.0);
        all.add(&arcs.along(rod, arc, 0.0), &near(at.rod, at.arc), -1.0);
        all.cone()
    }

    /// Of an obstacle, towards the strand.
    fn at_obstacle(arcs: &Arcs, at: &ContactForce, normal: impl Fn(&Vec3) -> (f64, Vec3)) -> Option<Self> {
        let mut all = Normals::default();
        for arc in arcs.along(at.rod, at.arc, 0.0) {
            // a curved surface is seen from the element in another direction than from a smooth curve
            let of_points = [0.0, 0.5, 1.0].map(|t| normal(&arc.point(t)).1);
            let bent = of_points[0].angle(&of_points[2]) / (arc.end() - arc.from).norm();
            all.uncertain = all.uncertain.max(bent * arc.beside);
            all.normals.extend(of_points);
        }
        let turns = all.normals.windows(2).map(|pair| pair[0].angle(&pair[1]));
        all.between = turns.fold(0.0, f64::max);
        all.cone()
    }
}

impl Normals {
    fn cone(&self) -> Option<Cone> {
        let all = self;
        let axis = all.normals.iter().sum::<Vec3>().try_normalize(0.0)?;
        let spread = all.normals.iter().map(|normal| normal.angle(&axis)).fold(0.0, f64::max);
        Some(Cone { axis, angle: spread + 0.5 * all.between + all.uncertain })
    }
}

/// Normals at points along strands.
#[derive(Debug, Default)]
struct Normals {
    normals: Vec<Vec3>,
    /// Largest angle of two in a row, between which normals may turn beyond both, rad.
    between: f64,
    /// By how much those of smooth curves may differ, rad.
    uncertain: f64,
}

impl Normals {
    /// Adds those from the nearest points of a partner to points along a strand, times a sign.
    fn add(&mut self, own: &[Arc], partner: &(Vec<Arc>, [f64; 2]), sign: f64) {
        let count = (2 * own.len()).clamp(POINTS[0], POINTS[1]);
        let first = self.normals.len();
        for k in 0..count {
            let place = k as f64 / (count - 1) as f64 * own.len() as f64;
            let index = (place as usize).min(own.len().saturating_sub(1));
            let Some(arc) = own.get(index) else { return };
            let point = arc.point(place - index as f64);
            let Some((foot, beside)) = nearest(partner, &point) else { continue };
            let normal = point - foot;
            self.uncertain = self.uncertain.max((arc.beside + beside) / normal.norm());
            self.normals.push(normal.normalize() * sign);
        }
        let turns = self.normals[first..].windows(2).map(|pair| pair[0].angle(&pair[1]));
        self.between = turns.fold(self.between, f64::max);
    }
}

/// The point of some arcs that is nearest to a point, and by how much smooth curves lie beside it there; `None` at an
/// end of them that is none of the `tips` of the rod.
fn nearest((arcs, tips): &(Vec<Arc>, [f64; 2]), point: &Vec3) -> Option<(Vec3, f64)> {
    let mut best: Option<(f64, usize, f64)> = None;
    for (k, arc) in arcs.iter().enumerate() {
        let (center, radius) = arc.ball();
        if best.is_some_and(|(least, ..)| (point - center).norm() - radius > least) {
            continue;
        }
        let t = foot(arc, point);
        let distance = (point - arc.point(t)).norm();
        if best.is_none_or(|(least, ..)| distance < least) {
            best = Some((distance, k, t));
        }
    }
    let (_, k, t) = best?;
    let is_end = k == 0 && t == 0.0 || k + 1 == arcs.len() && t == 1.0;
    let place = arcs[k].arc[0] + t * arcs[k].arc[1];
    let is_tip = tips.iter().any(|tip| (place - tip).abs() <= TOL_STEP * arcs[k].arc[1]);
    (!is_end || is_tip).then(|| (arcs[k].point(t), arcs[k].beside))
}

/// Parameter of the point of an arc that is nearest to a point.
fn foot(arc: &Arc, point: &Vec3) -> f64 {
    let chord = arc.end() - arc.from;
    let mut t = ((point - arc.from).dot(&chord) / chord.norm_squared()).clamp(0.0, 1.0);
    for _ in 0..MAX_STEPS {
        let (away, slope) = (arc.point(t) - point, arc.slope(t));
        let second = slope.norm_squared() + away.dot(&arc.bend(t));
        let second = if second > 0.1 * slope.norm_squared() { second } else { slope.norm_squared() };
        let next = (t - away.dot(&slope) / second).clamp(0.0, 1.0);
        let moved = (next - t).abs();
        t = next;
        if moved < TOL_STEP {
            break;
        }
    }
    t
}
