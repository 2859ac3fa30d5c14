//! Rods that fall for ever: those that only contact with other rods could carry, once these are behind them.
//!
//! A potential that falls along the way has no minimum there. As long as other rods lie ahead, the search goes on.

use std::collections::BTreeSet;

use crate::math::Vec3;
use crate::math::signed_distance::{Skeleton, Surface};
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;

impl Engine {
    /// A rod that neither supports nor planes hold against its dead forces, that touches no rod it is not joined to,
    /// and that has all of these behind it.
    pub(in crate::solve) fn falling_for_ever(&self, state: &State, residual: &Residual) -> Option<usize> {
        let rods = 0..self.model.rods.len();
        if state.load_factor == 0.0 || rods.len() == 1 {
            return None;
        }
        rods.into_iter().filter(|rod| self.bears_loads(*rod)).find(|&rod| {
            let body = self.model.joined_rods(rod);
            let Some(way) = self.model.way_down(&body, state.load_factor) else { return false };
            let touches = || self.touched(residual).any(|pair| pair.iter().filter(|r| body.contains(r)).count() == 1);
            !touches() && self.is_ahead_of_all(state, &body, &way)
        })
    }

    /// Rods that touch, pair by pair.
    fn touched(&self, residual: &Residual) -> impl Iterator<Item = [usize; 2]> {
        let side = &self.contact;
        let pairs = residual.contact_pairs.iter().map(|pair| {
            let [a, _, b, _] = side.nodes_of(pair).map(|node| self.rod_of(node));
            [a, b]
        });
        let at_bodies = residual.surface_contacts.iter().filter_map(|contact| self.rods_at_body(contact));
        pairs.chain(at_bodies).collect::<BTreeSet<_>>().into_iter()
    }

    /// Whether a body is, with its surface, ahead of all other rods along a way.
    fn is_ahead_of_all(&self, state: &State, body: &[usize], way: &Vec3) -> bool {
        let (mut hindmost, mut foremost) = (f64::INFINITY, f64::NEG_INFINITY);
        for (rod, data) in self.model.rods.iter().enumerate() {
            // a cubic stays within a spacing of its nodes
            let reach = data.section.contact_radius + data.spacing();
            for node in self.nodes(rod) {
                let along = state.positions[node].dot(way);
                if body.contains(&rod) {
                    hindmost = hindmost.min(along - reach);
                } else {
                    foremost = foremost.max(along + reach);
                }
            }
        }
        let of_others = |index: &usize| self.model.obstacles[*index].carrier.is_some_and(|at| !body.contains(&at.rod));
        let side = &self.contact;
        let bodies = (0..side.obstacles.len()).filter(of_others).map(|index| side.surface_in(state, index));
        foremost = bodies.map(|surface| reach_along(&surface, way)).fold(foremost, f64::max);
        hindmost > foremost
    }
}

/// How far a sphere or a capsule reaches along a way, from the origin \[L\].
fn reach_along(surface: &Surface, way: &Vec3) -> f64 {
    let beyond = match surface.skeleton {
        Skeleton::Piece { axis, length, .. } if axis.dot(way) > 0.0 => axis.dot(way) * length.unwrap_or(f64::INFINITY),
        _ => 0.0,
    };
    surface.point().dot(way) + beyond + surface.level
}
