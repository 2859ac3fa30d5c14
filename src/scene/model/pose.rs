//! Poses that supports take nodes to, and the ways there.

use std::f64::consts::{PI, TAU};

use crate::math::quaternion::spin;
use crate::math::screw::{screw, unscrew};
use crate::math::{Quat, Vec3};

/// A turn by less than half a turn less this, rad, is the shorter one without a doubt.
const HALF_TURN: f64 = 1e-6;
/// Parts of a velocity below this, relative to the whole, count as rounding where ways are compared.
const ROUNDING: f64 = 1e-9;

/// Where a clamped node is to be at the end of a stage, and the way there.
///
/// The frame turns by the shortest turn, at an even rate about an axis that is fixed in space; `turns` go on top, about
/// the rod's own tangent d3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position \[L\], global; `None`: it stays.
    pub position: Option<Vec3>,
    /// Frame (columns d1, d2, d3); `None`: it stays but for `turns`.
    pub frame: Option<Quat>,
    /// The way of the position.
    pub path: PosePath,
    /// Whole turns about d3 at the end of the stage, since the start of the run, in all (those of [`super::Ramp::Rotation`]
    /// count, too); `None`: no more than before. They do not show in the frame that is reached: they put link into the
    /// rod.
    pub turns: Option<f64>,
    /// Of two half turns the one about this side is taken; zero: the one whose axis has its largest component positive.
    pub half_turn: Vec3,
}

/// Way of a node from one position to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PosePath {
    /// A straight line.
    #[default]
    Straight,
    /// The screw that turns the frame as well: a helix about its axis, an arc if there is no advance along it.
    Screw,
}

/// What is left of a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Way {
    path: PosePath,
    /// From here to the position wanted \[L\].
    chord: Vec3,
    /// Rotation vector without the turns about the tangent, rad, global.
    pub(crate) rotation: Vec3,
    /// Turns about the tangent.
    pub(crate) turns: f64,
}

impl Pose {
    /// The way from a place of the node, which has been turned by so many turns.
    pub(crate) fn way(&self, position: &Vec3, remainder: &Vec3, frame: &Quat, turned: f64) -> Way {
        let turns = self.turns.map_or(0.0, |turns| turns - turned);
        let chord = self.position.map_or(Vec3::zeros(), |to| (to - position) - remainder);
        let rotation = self.frame.map_or(Vec3::zeros(), |to| {
            let vector = (to * spin(-TAU * turns.fract()) * frame.inverse()).scaled_axis();
            if PI - vector.norm() < HALF_TURN { self.side_of_half_turn(vector) } else { vector }
        });
        Way { path: self.path, chord, rotation, turns }
    }

    fn side_of_half_turn(&self, vector: Vec3) -> Vec3 {
        let side = if self.half_turn == Vec3::zeros() { vector[vector.iamax()] } else { self.half_turn.dot(&vector) };
        if side < 0.0 { -vector } else { vector }
    }
}

impl Way {
    /// Displacement \[L\] on the first part of the way.
    pub(crate) fn displacement(&self, part: f64) -> Vec3 {
        match self.path {
            PosePath::Screw if part < 1.0 => screw(&(self.rotation * part), &(self.velocity() * part)),
            PosePath::Straight if part < 1.0 => self.chord * part,
            _ => self.chord,
        }
    }

    /// Velocity with which the node sets out, for a way that takes the time 1 \[L\].
    fn velocity(&self) -> Vec3 {
        match self.path {
            PosePath::Straight => self.chord,
            PosePath::Screw => unscrew(&self.rotation, &self.chord),
        }
    }

    /// Six numbers that grow evenly along the way, from a node at `position`: velocity (on a screw, of the body at the
    /// origin \[L\]) and rotation vector.
    pub(crate) fn controls(&self, position: &Vec3) -> [Vec3; 2] {
        let velocity = self.velocity();
        let at_origin = match self.path {
            PosePath::Straight => velocity,
            PosePath::Screw => velocity - self.rotation.cross(position),
        };
        let scale = velocity.norm() + self.rotation.norm() * position.norm();
        let without = |v: Vec3, scale: f64| v.map(|x| if x.abs() < ROUNDING * scale { 0.0 } else { x });
        [without(at_origin, scale), without(self.rotation, self.rotation.norm())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quaternion::exp;

    fn frame_after(way: &Way, frame: &Quat, part: f64) -> Quat {
        exp(&(way.rotation * part)) * frame * spin(TAU * way.turns * part)
    }

    fn pose(path: PosePath, turns: f64) -> Pose {
        let frame = exp(&Vec3::new(0.3, 2.0, -0.8));
        let position = Some(Vec3::new(1.0, -2.0, 0.5));
        Pose { position, frame: Some(frame), path, turns: Some(turns), half_turn: Vec3::zeros() }
    }

    /// However the way is cut into parts, it is the same: parts lie on it, what grows evenly does, and it ends in the
    /// pose.
    #[test]
    fn parts_of_a_way_lie_on_it() {
        for path in [PosePath::Straight, PosePath::Screw] {
            let pose = pose(path, 3.0);
            let (start, frame) = (Vec3::new(0.2, 0.1, -0.4), exp(&Vec3::new(-0.5, 0.1, 0.2)));
            let whole = pose.way(&start, &Vec3::zeros(), &frame, 0.75);
            let grown = whole.controls(&start);
            let (mut position, mut here, mut turned, mut done) = (start, frame, 0.75, 0.0);
            for part in [0.25, 0.4, 0.5, 1.0] {
                let way = pose.way(&position, &Vec3::zeros(), &here, turned);
                let take = part * (1.0 - done);
                for (now, all) in way.controls(&position).iter().zip(&grown) {
                    assert!((now - all * (1.0 - done)).norm() < 1e-12, "{path:?} {done}");
                }
                let (by, to) = (way.displacement(part), frame_after(&way, &here, part));
                (position, here, turned, done) = (position + by, to, turned + way.turns * part, done + take);
                assert!((position - start - whole.displacement(done)).norm() < 1e-12, "{path:?} {done}");
                assert!(here.angle_to(&frame_after(&whole, &frame, done)) < 1e-12, "{path:?} {done}");
            }
            assert!((position - pose.position.unwrap()).norm() < 1e-14 && here.angle_to(&pose.frame.unwrap()) < 1e-14);
            assert!((turned - 3.0).abs() < 1e-14);
        }
    }

    /// A screw keeps its distance from its axis; half a turn about y leads from x = 1 to x = −1 through z.
    #[test]
    fn half_turns_go_the_way_they_are_asked_to() {
        for side in [1.0, -1.0] {
            let pose = Pose {
                position: Some(Vec3::new(-1.0, 0.0, 0.0)),
                frame: Some(exp(&(Vec3::y() * PI))),
                path: PosePath::Screw,
                turns: None,
                half_turn: Vec3::y() * side,
            };
            let way = pose.way(&Vec3::x(), &Vec3::zeros(), &Quat::identity(), 0.0);
            let middle = Vec3::x() + way.displacement(0.5);
            assert!((middle + Vec3::z() * side).norm() < 1e-14, "{middle}");
        }
    }
}
