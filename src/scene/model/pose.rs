//! Prescribed poses of nodes, and the paths to them.

use std::f64::consts::{PI, TAU};

use crate::math::quaternion::spin;
use crate::math::screw::{screw, unscrew};
use crate::math::{Quat, Vec3};

/// Distance from half a turn, rad, within which the shorter rotation is ambiguous.
const HALF_TURN: f64 = 1e-6;
/// Components of a velocity below this, relative to the whole, count as rounding in the comparison of paths.
const ROUNDING: f64 = 1e-9;

/// The pose of a clamped node at the end of a stage, and the path to it.
///
/// The frame makes the shortest rotation, at a constant rate about an axis fixed in space; `turns` about the rod's
/// tangent d3 are added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position \[L\], global; `None`: unchanged.
    pub position: Option<Vec3>,
    /// Frame (columns d1, d2, d3); `None`: unchanged but for `turns`.
    pub frame: Option<Quat>,
    /// The path of the position.
    pub path: PosePath,
    /// Whole turns about d3 at the end of the stage, since the start of the run, or since a stage held the node's
    /// rotation, in all (those of [`super::Ramp::Rotation`] included); `None`: unchanged. They do not change the final
    /// frame, but the link of the rod.
    pub turns: Option<f64>,
    /// Side that selects one of two half turns; zero: the one whose axis has its largest component positive.
    pub half_turn: Vec3,
}

/// Path of a node from one position to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PosePath {
    /// A straight line.
    #[default]
    Straight,
    /// The screw motion that also rotates the frame: a helix about its axis, an arc if there is no advance along it.
    Screw,
}

/// The rest of the path to a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RemainingPath {
    path: PosePath,
    /// From the present to the target position \[L\].
    chord: Vec3,
    /// Rotation vector without the turns about the tangent, rad, global.
    pub(crate) rotation: Vec3,
    /// Turns about the tangent.
    pub(crate) turns: f64,
}

impl Pose {
    /// The path from a present pose of the node, which has made `turned` turns about its tangent.
    pub(crate) fn remaining_path(&self, position: &Vec3, remainder: &Vec3, frame: &Quat, turned: f64) -> RemainingPath {
        let turns = self.turns.map_or(0.0, |turns| turns - turned);
        let chord = self.position.map_or(Vec3::zeros(), |to| (to - position) - remainder);
        let rotation = self.frame.map_or(Vec3::zeros(), |to| {
            let vector = (to * spin(-TAU * turns.fract()) * frame.inverse()).scaled_axis();
            if PI - vector.norm() < HALF_TURN { self.side_of_half_turn(vector) } else { vector }
        });
        RemainingPath { path: self.path, chord, rotation, turns }
    }

    fn side_of_half_turn(&self, vector: Vec3) -> Vec3 {
        let side = if self.half_turn == Vec3::zeros() { vector[vector.iamax()] } else { self.half_turn.dot(&vector) };
        if side < 0.0 { -vector } else { vector }
    }
}

impl RemainingPath {
    /// Displacement \[L\] over the first fraction `part` of the path.
    pub(crate) fn displacement(&self, part: f64) -> Vec3 {
        match self.path {
            PosePath::Screw if part < 1.0 => screw(&(self.rotation * part), &(self.velocity() * part)),
            PosePath::Straight if part < 1.0 => self.chord * part,
            _ => self.chord,
        }
    }

    /// Initial velocity of the node, for a path of duration 1 \[L\].
    fn velocity(&self) -> Vec3 {
        match self.path {
            PosePath::Straight => self.chord,
            PosePath::Screw => unscrew(&self.rotation, &self.chord),
        }
    }

    /// Six numbers proportional to the fraction of the path, for a node at `position`: velocity (on a screw, of the
    /// body at the origin \[L\]) and rotation vector.
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

    fn frame_after(rest: &RemainingPath, frame: &Quat, part: f64) -> Quat {
        exp(&(rest.rotation * part)) * frame * spin(TAU * rest.turns * part)
    }

    fn pose(path: PosePath, turns: f64) -> Pose {
        let frame = exp(&Vec3::new(0.3, 2.0, -0.8));
        let position = Some(Vec3::new(1.0, -2.0, 0.5));
        Pose { position, frame: Some(frame), path, turns: Some(turns), half_turn: Vec3::zeros() }
    }

    /// A path does not depend on its division into parts: parts lie on it, the controls grow linearly, and it ends in
    /// the pose.
    #[test]
    fn parts_of_a_path_lie_on_it() {
        for path in [PosePath::Straight, PosePath::Screw] {
            let pose = pose(path, 3.0);
            let (start, frame) = (Vec3::new(0.2, 0.1, -0.4), exp(&Vec3::new(-0.5, 0.1, 0.2)));
            let whole = pose.remaining_path(&start, &Vec3::zeros(), &frame, 0.75);
            let grown = whole.controls(&start);
            let (mut position, mut here, mut turned, mut done) = (start, frame, 0.75, 0.0);
            for part in [0.25, 0.4, 0.5, 1.0] {
                let rest = pose.remaining_path(&position, &Vec3::zeros(), &here, turned);
                let take = part * (1.0 - done);
                for (now, all) in rest.controls(&position).iter().zip(&grown) {
                    assert!((now - all * (1.0 - done)).norm() < 1e-12, "{path:?} {done}");
                }
                let (by, to) = (rest.displacement(part), frame_after(&rest, &here, part));
                (position, here, turned, done) = (position + by, to, turned + rest.turns * part, done + take);
                assert!((position - start - whole.displacement(done)).norm() < 1e-12, "{path:?} {done}");
                assert!(here.angle_to(&frame_after(&whole, &frame, done)) < 1e-12, "{path:?} {done}");
            }
            assert!((position - pose.position.unwrap()).norm() < 1e-14 && here.angle_to(&pose.frame.unwrap()) < 1e-14);
            assert!((turned - 3.0).abs() < 1e-14);
        }
    }

    /// A screw keeps its distance from its axis; half a turn about y leads from x = 1 to x = −1 through z.
    #[test]
    fn half_turns_go_to_the_given_side() {
        for side in [1.0, -1.0] {
            let pose = Pose {
                position: Some(Vec3::new(-1.0, 0.0, 0.0)),
                frame: Some(exp(&(Vec3::y() * PI))),
                path: PosePath::Screw,
                turns: None,
                half_turn: Vec3::y() * side,
            };
            let rest = pose.remaining_path(&Vec3::x(), &Vec3::zeros(), &Quat::identity(), 0.0);
            let middle = Vec3::x() + rest.displacement(0.5);
            assert!((middle + Vec3::z() * side).norm() < 1e-14, "{middle}");
        }
    }
}
