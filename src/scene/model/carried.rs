//! Whether dead loads have a state of rest: what refuses a body that they would move for ever.
//!
//! A body is a rod with all that joints connect it to. Its elastic energy grows with strain, and it has nowhere to
//! go but by rigid motions. Rotations come back to where they began, so forces do bounded work on them: a body that
//! swings comes to hang. Displacements along an axis in which no support holds any of its nodes are unbounded: the sum
//! of the forces must do no work on them, or press the body onto planes. Moments that keep their axis do unbounded
//! work where the body can turn about it, unless forces can hold them in balance.

use crate::error::InputError;
use crate::math::{Mat3, Vec3};

use super::{Model, Obstacle};

/// Sums of forces and moments below this, over the sum of their sizes, count as rounding; deviations of forces from
/// those that normals balance, too.
const ROUNDING: f64 = 1e-9;
/// Eigenvalues of the support constraints below this (of 1) leave a rigid motion free.
const TOL_RANK: f64 = 1e-9;

/// Dead forces \[F\] and moments \[F·L\] on a body.
struct Loads {
    forces: Vec<Vec3>,
    moments: Vec<Vec3>,
}

/// Sum of vectors, and of their sizes.
fn sum_of(all: &[Vec3]) -> (Vec3, f64) {
    (all.iter().sum(), all.iter().map(Vec3::norm).sum())
}

impl Model {
    /// Refuses a rod on which dead loads, times `factor`, do unbounded work.
    pub(super) fn check_carried(&self, at: &str, rod: usize, factor: f64) -> Result<(), InputError> {
        let body = self.joined_rods(rod);
        let loads = self.dead_loads(&body);
        let refuse = |reason: String| {
            Err(InputError::inconsistent(format!("rods.{}", self.rods[rod].name), format!("{at}{reason}")))
        };
        let touches = |rod: &usize| self.is_touchable(&self.rods[*rod]);
        let others = (0..self.rods.len()).any(|other| !body.contains(&other) && touches(&other));
        let is_other = |obstacle: &Obstacle| obstacle.carrier.is_none_or(|node| !body.contains(&node.rod));
        let posts = self.obstacles.iter().any(|obstacle| is_other(obstacle) && obstacle.pushes().is_none());
        // rods and posts that are there may catch it: the search finds out
        let may_be_caught = (others || posts) && body.iter().any(touches);
        if let Some(way) = self.way_down(&body, factor).filter(|_| !may_be_caught) {
            let [x, y, z] = way.map(|x| (x * 1e3).round() / 1e3 + 0.0).into(); // + 0.0 turns −0 into 0
            return refuse(format!(
                "{} acts on it, and nothing holds it against the sum of its dead forces, along ({x}, {y}, {z}): it \
                 would fall for ever; add a support with position, or a plane that faces this sum",
                self.load_on(&body)
            ));
        }
        // what pins and hinges let turn may turn, though others hold the rest
        let part = self.rigidly_joined_rods(rod);
        if let Some(axis) = self.free_axis(&body, &loads).or_else(|| self.free_axis(&part, &self.dead_loads(&part))) {
            return refuse(format!(
                "{} turns it about the axis ({}, {}, {}), about which its supports and joints leave it free to turn \
                 and no force could stop it: add a support that holds it",
                self.load_on(&body),
                axis.x,
                axis.y,
                axis.z
            ));
        }
        Ok(())
    }

    fn dead_loads(&self, body: &[usize]) -> Loads {
        let at_nodes = self.loads.iter().filter(|load| body.contains(&load.node.rod));
        let along = self.line_loads.iter().filter(|load| body.contains(&load.rod));
        let length = |rod: usize| self.rods[rod].length;
        Loads {
            forces: at_nodes.clone().map(|l| l.force).chain(along.clone().map(|l| l.force * length(l.rod))).collect(),
            moments: at_nodes.map(|l| l.moment).chain(along.map(|l| l.moment * length(l.rod))).collect(),
        }
    }

    /// The first load on a body, as text.
    fn load_on(&self, body: &[usize]) -> String {
        let is_load = |(force, moment): (Vec3, Vec3)| (force, moment) != Default::default();
        let node = self.loads.iter().position(|l| body.contains(&l.node.rod) && is_load((l.force, l.moment)));
        let line = self.line_loads.iter().position(|l| body.contains(&l.rod) && is_load((l.force, l.moment)));
        match (node, line) {
            (Some(i), _) => format!("loads[{i}]"),
            (None, Some(i)) => format!("line_loads[{i}]"),
            (None, None) => "a load".to_owned(),
        }
    }

    /// Direction of the sum of forces along axes in which nothing holds the body, if planes do not carry it: minus this
    /// part is a sum of their normals along these axes, none of which counts negative, or else a motion away from all
    /// planes exists that the forces do work on (Farkas). Three normals are enough (Carathéodory).
    pub(crate) fn way_down(&self, body: &[usize], factor: f64) -> Option<Vec3> {
        let loads = self.dead_loads(body);
        let mut held = [false, false, self.planar];
        for support in self.supports.iter().filter(|support| body.contains(&support.node.rod)) {
            (0..3).for_each(|k| held[k] |= support.position[k]);
        }
        let along = |v: &Vec3| Vec3::from_fn(|k, _| if held[k] { 0.0 } else { v[k] });
        let (sum, size) = sum_of(&loads.forces);
        let force = along(&sum) * factor;
        if force.norm() <= ROUNDING * size * factor.abs() {
            return None;
        }
        let touches = body.iter().any(|&rod| self.is_touchable(&self.rods[rod]));
        let normals: Vec<Vec3> = if touches {
            self.obstacles.iter().filter_map(Obstacle::pushes).flatten().map(|n| along(&n)).collect()
        } else {
            Vec::new()
        };
        let count = normals.len();
        let mut sets = (0..count).flat_map(|i| (i..count).flat_map(move |j| (j..count).map(move |k| [i, j, k])));
        let is_carried = sets.any(|set| balances(set.map(|plane| normals[plane]), &-force));
        (!is_carried).then(|| force.normalize())
    }

    /// Axis of a rotation that supports leave free and that moments do more work on than all forces could take up with
    /// the body's whole length as their lever.
    fn free_axis(&self, body: &[usize], loads: &Loads) -> Option<Vec3> {
        let (moment, size) = sum_of(&loads.moments);
        if moment.norm() <= ROUNDING * size {
            return None;
        }
        let about: Vec3 = self.free_spins(body).iter().map(|spin| spin * spin.dot(&moment)).sum();
        let axis = about.try_normalize(ROUNDING * size)?;
        let length: f64 = body.iter().map(|&rod| self.rods[rod].length).sum();
        let stopped: f64 = loads.forces.iter().map(|force| force.cross(&axis).norm() * length).sum();
        let text = axis.map(|x| (x * 1e3).round() / 1e3 + 0.0); // + 0.0 turns −0 into 0
        (about.norm() > stopped + ROUNDING * size).then_some(text)
    }

    /// Axes, orthonormal, of the rotations of a body that its supports do not prevent.
    ///
    /// A velocity v of a node and an angular velocity ω (times the length ℓ, for the unit of v) move a node at
    /// distance d from it by v + ω × d.
    fn free_spins(&self, body: &[usize]) -> Vec<Vec3> {
        let (origin, length) = (self.rods[body[0]].positions[0], self.rods[body[0]].length);
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        let mut normal = nalgebra::Matrix6::<f64>::zeros();
        let mut constrain = |v: Vec3, spin: Vec3| {
            let row = nalgebra::Vector6::new(v.x, v.y, v.z, spin.x, spin.y, spin.z);
            normal += row * row.transpose();
        };
        if self.planar {
            constrain(axes[2], Vec3::zeros());
            constrain(Vec3::zeros(), axes[0]);
            constrain(Vec3::zeros(), axes[1]);
        }
        for support in self.supports.iter().filter(|support| body.contains(&support.node.rod)) {
            let arm = (self.rods[support.node.rod].positions[support.node.node] - origin) / length;
            for k in 0..3 {
                if support.position[k] {
                    constrain(axes[k], arm.cross(&axes[k]));
                }
                if support.rotation[k] {
                    constrain(Vec3::zeros(), axes[k]);
                }
            }
        }
        // joints with other bodies hold it as if these were fixed
        for joint in &self.joints {
            let (node, other) = if body.contains(&joint.a.rod) { (joint.a, joint.b) } else { (joint.b, joint.a) };
            if !body.contains(&node.rod) || body.contains(&other.rod) {
                continue;
            }
            let arm = (self.rods[node.rod].positions[node.node] - origin) / length;
            axes.iter().for_each(|axis| constrain(*axis, arm.cross(axis)));
            if let Some(axis) = self.hinge_axis(joint) {
                axes.iter().for_each(|e| constrain(Vec3::zeros(), e - axis * axis.dot(e)));
            }
        }
        let eigen = normal.symmetric_eigen();
        let mut spins = Mat3::zeros();
        for k in (0..6).filter(|&k| eigen.eigenvalues[k] <= TOL_RANK) {
            let spin = eigen.eigenvectors.fixed_view::<3, 1>(3, k).into_owned();
            spins += spin * spin.transpose();
        }
        let spins = spins.symmetric_eigen();
        let is_free = |k: &usize| spins.eigenvalues[*k] > ROUNDING;
        (0..3).filter(is_free).map(|k| spins.eigenvectors.column(k).into_owned()).collect()
    }
}

/// Whether a force is a sum of these directions, none of which counts negative; they may repeat.
fn balances(directions: [Vec3; 3], force: &Vec3) -> bool {
    let shares = Mat3::from_columns(&directions).pseudo_inverse(ROUNDING).map(|inverse| inverse * force);
    let is_met = |shares: Vec3| {
        let sum: Vec3 = directions.iter().zip(shares.iter()).map(|(direction, share)| direction * *share).sum();
        let least = ROUNDING * force.norm();
        shares.min() >= -least && (sum - force).norm() <= least
    };
    shares.is_ok_and(is_met)
}
