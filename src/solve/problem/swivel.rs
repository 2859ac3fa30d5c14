//! Supports that hold rotation about one axis alone: joints of constant velocity.
//!
//! Rotations about the two other axes do not commute, so "no increment turns about the axis" would be no support: a
//! section that tilts round a cone comes back turned by the cone's solid angle, and lets twist out. So a function of
//! the orientation is held. Let the unit quaternion (q₀, v) be the rotation of the section since the rod was made, and
//! e the axis. The support holds
//!
//! ```text
//! v·e = 0        the rotation vector has no component along e
//! ```
//!
//! like a homokinetic joint: the turning it lets through about e on one side goes on about the tilted axis
//! on the other. A spin δw changes v·e by ½ c·δw with c = q₀ e + v × e, a unit vector halfway between the axis and
//! where it was tilted to. The orientations that are allowed are a great sphere, so rotations about axes across c stay
//! on it: the two rotations left are those of the plane across c, and nothing has to be put right after a step but
//! rounding.

use std::borrow::Cow;

use nalgebra::Unit;

use crate::math::{Mat3, Quat, Vec3};
use crate::scene::Model;
use crate::solve::problem::follower::{Hinged, Sharing};
use crate::solve::problem::state::State;
use crate::sparse::Pattern;

/// A support that holds rotation about one axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Swivel {
    /// The supported node, of all, and those joined to it.
    pub(crate) nodes: Vec<usize>,
    /// Index of the axis: x, y, z.
    pub(crate) axis: usize,
    /// Frame that the supported node has in the model.
    reference: Quat,
}

impl Swivel {
    /// The swivels of a model, by the free unknowns and their owners. A planar model has none, and no hinge has one.
    pub(crate) fn all(model: &Model, free: &[[bool; 6]], owner: &[[usize; 6]]) -> Vec<Self> {
        let frames = model.rods.iter().flat_map(|rod| rod.frames.iter());
        let swivel = |(node, (frame, free)): (usize, (&Quat, &[bool; 6]))| {
            let held: Vec<usize> = (0..3).filter(|k| !free[3 + k]).collect();
            let [axis] = held[..] else { return None };
            if owner[node][3..] != [node; 3] {
                return None;
            }
            let nodes = (node..owner.len()).filter(|&other| owner[other][3..] == [node; 3]).collect();
            Some(Self { nodes, axis, reference: *frame })
        };
        frames.zip(free).enumerate().filter_map(swivel).collect()
    }

    /// The unit vector c about which the node cannot turn now, and the component of the quaternion that is to be zero.
    fn held(&self, state: &State) -> (Vec3, f64) {
        let q = state.frames[self.nodes[0]] * self.reference.inverse();
        let (e, v) = (Vec3::ith(self.axis, 1.0), q.imag());
        (e * q.w + v.cross(&e), v[self.axis])
    }

    /// Orthonormal basis for the rotations of the node, the held direction at the place of the axis.
    fn basis(&self, state: &State) -> Mat3 {
        let c = self.held(state).0.normalize();
        let other = Vec3::ith(c.iamin(), 1.0).cross(&c).normalize();
        let mut basis = Mat3::zeros();
        basis.set_column(self.axis, &c);
        basis.set_column((self.axis + 1) % 3, &other);
        basis.set_column((self.axis + 2) % 3, &c.cross(&other));
        basis
    }

    /// Turns the node back about the held direction, from which rounding and predictions turn it.
    pub(crate) fn restore(&self, state: &mut State) {
        let (c, off) = self.held(state);
        let angle = -2.0 * off.atan2(c.norm());
        let back = Quat::from_axis_angle(&Unit::new_normalize(c), angle);
        for &node in &self.nodes {
            state.frames[node] = Unit::new_normalize((back * state.frames[node]).into_inner());
        }
    }
}

/// Bases of the rotations of nodes where unknowns are not those about x, y and z: at swivels and hinges.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bases {
    /// By node, ascending: the place of the direction that a swivel holds, and the basis.
    of_nodes: Vec<(usize, Option<usize>, Mat3)>,
}

impl Bases {
    pub(crate) fn at((swivels, hinged): (&[Swivel], &[Hinged]), state: &State) -> Self {
        let of_swivel = |swivel: &Swivel| {
            let (axis, basis) = (swivel.axis, swivel.basis(state));
            swivel.nodes.clone().into_iter().map(move |node| (node, Some(axis), basis))
        };
        let of_hinge = |hinged: &Hinged| {
            let basis = hinged.basis(state);
            hinged.nodes.clone().into_iter().map(move |node| (node, None, basis))
        };
        let swivels = swivels.iter().flat_map(of_swivel);
        let mut of_nodes: Vec<_> = swivels.chain(hinged.iter().flat_map(of_hinge)).collect();
        of_nodes.sort_by_key(|(node, ..)| *node);
        Self { of_nodes }
    }

    /// Directions that nodes cannot turn about.
    pub(crate) fn held(&self) -> impl Iterator<Item = (usize, Vec3)> + '_ {
        let of =
            |(node, axis, basis): &(usize, Option<usize>, Mat3)| Some((*node, basis.column((*axis)?).into_owned()));
        self.of_nodes.iter().filter_map(of)
    }

    /// The axis of the hinge at a node: the third vector of its basis.
    pub(super) fn axis(&self, node: usize) -> Vec3 {
        self.of(node).map_or(Vec3::z(), |basis| basis.column(2).into_owned())
    }

    /// The vectors of the basis of a node.
    pub(super) fn of(&self, node: usize) -> Option<&Mat3> {
        let at = self.of_nodes.binary_search_by_key(&node, |(node, ..)| *node).ok()?;
        Some(&self.of_nodes[at].2)
    }

    /// Moves the forces and moments on joined nodes, six numbers a node, to the owners of the unknowns. Of moments on
    /// hinged nodes each keeps that about the axis.
    pub(crate) fn give_to_masters(&self, sharing: &Sharing, forces: &mut [f64]) {
        for node in sharing.followers.iter().map(|follower| follower.node) {
            let owner = &sharing.owner[node];
            let six: [f64; 6] = std::array::from_fn(|k| std::mem::take(&mut forces[6 * node + k]));
            (0..3).for_each(|k| forces[6 * owner[k] + k] += six[k]);
            let basis = self.of(node).filter(|_| owner[3] != owner[5]);
            let Some(basis) = basis else {
                (3..6).for_each(|k| forces[6 * owner[k] + k] += six[k]);
                continue;
            };
            let (moment, axis) = (Vec3::new(six[3], six[4], six[5]), basis.column(2));
            let own = axis * axis.dot(&moment);
            (0..3).for_each(|k| forces[6 * owner[5] + 3 + k] += own[k]);
            (0..3).for_each(|k| forces[6 * owner[3] + 3 + k] += moment[k] - own[k]);
        }
    }

    fn turn(&self, all: &mut [f64], by: impl Fn(&Mat3, Vec3) -> Vec3) {
        for (node, _, basis) in &self.of_nodes {
            let part = &mut all[6 * node + 3..6 * node + 6];
            let turned = by(basis, Vec3::new(part[0], part[1], part[2]));
            part.copy_from_slice(turned.as_slice());
        }
    }

    /// From components about x, y and z (six numbers a node) to those in the bases.
    pub(crate) fn resolved<'a>(&self, all: &'a [f64]) -> Cow<'a, [f64]> {
        let mut all = Cow::Borrowed(all);
        if !self.of_nodes.is_empty() {
            self.turn(all.to_mut(), |basis, part| basis.transpose() * part);
        }
        all
    }

    /// Back to components about x, y and z.
    pub(crate) fn compose(&self, all: &mut [f64]) {
        self.turn(all, |basis, part| basis * part);
    }

    /// A gradient without the moments that supports bear.
    pub(crate) fn without_reactions<'a>(&self, gradient: &'a [f64]) -> Cow<'a, [f64]> {
        let mut gradient = Cow::Borrowed(gradient);
        for (node, held) in self.held() {
            let part = &mut gradient.to_mut()[6 * node + 3..6 * node + 6];
            let moment = Vec3::new(part[0], part[1], part[2]);
            part.copy_from_slice((moment - held * held.dot(&moment)).as_slice());
        }
        gradient
    }

    /// [`Pattern::add_block`] of a block in components about x, y and z.
    pub(crate) fn add_block(
        &self,
        pattern: &Pattern,
        values: &mut [f64],
        (p, q): (usize, usize),
        block: impl Fn(usize, usize) -> f64,
    ) {
        match self.resolved_block([p, q], &block) {
            None => pattern.add_block(values, p, q, block),
            Some(block) => pattern.add_block(values, p, q, |i, j| block[i][j]),
        }
    }

    /// A block of two nodes, given in components about x, y and z, in the bases; `None` if neither has one of its own.
    pub(crate) fn resolved_block(
        &self,
        [p, q]: [usize; 2],
        block: impl Fn(usize, usize) -> f64,
    ) -> Option<[[f64; 6]; 6]> {
        if self.of_nodes.is_empty() {
            return None;
        }
        let (left, right) = (self.of(p), self.of(q));
        if left.is_none() && right.is_none() {
            return None;
        }
        let column = |basis: Option<&Mat3>, k: usize| -> Vec<(usize, f64)> {
            match basis {
                Some(basis) if k >= 3 => (0..3).map(|i| (3 + i, basis[(i, k - 3)])).collect(),
                _ => vec![(k, 1.0)],
            }
        };
        let entry = |i: usize, j: usize| {
            let (rows, columns) = (column(left, i), column(right, j));
            let mut sum = 0.0;
            for a in &rows {
                for b in &columns {
                    sum += a.1 * b.1 * block(a.0, b.0);
                }
            }
            sum
        };
        Some(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::math::quaternion::exp;

    fn tilted(axis: usize, tilt: Vec3) -> (Swivel, State) {
        let reference = exp(&Vec3::new(0.3, -1.1, 0.7));
        let mut tilt = tilt;
        tilt[axis] = 0.0;
        let state = State {
            positions: vec![Vec3::zeros()],
            remainders: vec![Vec3::zeros()],
            frames: vec![exp(&tilt) * reference],
            seams: vec![0.0],
            load_factor: 0.0,
            pressures: vec![0.0],
            placements: Vec::new(),
            numbers: Default::default(),
        };
        (Swivel { nodes: vec![0], axis, reference }, state)
    }

    #[test]
    fn rotations_across_the_held_direction_stay_on_the_support() {
        for axis in 0..3 {
            for tilt in [Vec3::zeros(), Vec3::new(0.4, 1.3, -0.2), Vec3::new(-2.0, 1.0, 2.2)] {
                let (swivel, state) = tilted(axis, tilt);
                let (c, off) = swivel.held(&state);
                assert!((c.norm() - 1.0).abs() < 1e-14 && off.abs() < 1e-14, "{c} {off}");
                let basis = swivel.basis(&state);
                assert!((basis.transpose() * basis - Mat3::identity()).amax() < 1e-14);
                assert!((basis.column(axis) - c).amax() < 1e-14);
                for k in (1..3).map(|k| (axis + k) % 3) {
                    let mut turned = state.clone();
                    turned.frames[0] = exp(&(basis.column(k) * 0.9)) * turned.frames[0];
                    assert!(swivel.held(&turned).1.abs() < 1e-14);
                }
                // the derivative along c
                let along = |t: f64| {
                    let mut turned = state.clone();
                    turned.frames[0] = exp(&(c * t)) * turned.frames[0];
                    swivel.held(&turned).1
                };
                assert!(((along(1e-5) - along(-1e-5)) / 2e-5 - 0.5).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn whatever_turned_about_the_held_direction_is_turned_back() {
        let (swivel, mut state) = tilted(1, Vec3::new(0.8, 0.0, -0.5));
        let before = state.frames[0];
        let c = swivel.held(&state).0;
        state.frames[0] = exp(&(c * 0.2)) * state.frames[0];
        swivel.restore(&mut state);
        assert!(swivel.held(&state).1.abs() < 1e-14);
        assert!(state.frames[0].angle_to(&before) < 1e-12);
    }
}
