//! Rods that fall for ever: those that only contact with other rods could carry, once these are behind them.
//!
//! A potential that falls along the way has no minimum there. As long as other rods lie ahead, the search goes on.

use std::collections::BTreeSet;

use crate::contact::potential::ContactPair;
use crate::math::Vec3;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;

impl Engine {
    /// A rod that neither supports nor planes hold against its dead forces, that touches no rod it is not joined to, and that
    /// has all of these behind it.
    pub(in crate::solve) fn falling_for_ever(&self, state: &State, contact_pairs: &[ContactPair]) -> Option<usize> {
        let rods = 0..self.model.rods.len();
        if state.load_factor == 0.0 || rods.len() == 1 {
            return None;
        }
        rods.into_iter().filter(|rod| self.bears_loads(*rod)).find(|&rod| {
            let body = self.model.joined_rods(rod);
            let Some(way) = self.model.way_down(&body, state.load_factor) else { return false };
            let touches =
                || self.touched(contact_pairs).any(|pair| pair.iter().filter(|r| body.contains(r)).count() == 1);
            !touches() && self.is_ahead_of_all(state, &body, &way)
        })
    }

    /// Rods that touch, pair by pair.
    fn touched(&self, contact_pairs: &[ContactPair]) -> impl Iterator<Item = [usize; 2]> {
        let side = self.contact.as_ref();
        let pairs = contact_pairs.iter().filter_map(|pair| {
            let [a, _, b, _] = side?.nodes_of(pair).map(|node| self.rod_of(node));
            Some([a, b])
        });
        pairs.collect::<BTreeSet<_>>().into_iter()
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
        hindmost > foremost
    }
}
