//! Sites: local minima of the gap of all candidates.

use super::Detector;
use crate::contact::curves::curve::norm;
use crate::contact::curves::input::Strands;
use crate::contact::measures::COINCIDENT;
use crate::contact::options::Neighbours;
use crate::contact::pairs::capsule;
use crate::contact::sites::closest;
use crate::contact::sites::site::{self, Minimum, Site};
use crate::contact::sites::vertex::vertex_minima;
use crate::math::parallel::{self, CHEAP};

impl Detector {
    pub(in crate::contact) fn find_sites(&mut self, strands: &Strands, sites: &mut Vec<Site>) {
        let mut minima = std::mem::take(&mut self.minima);
        let this = &*self;
        let pairs = this.broad.pairs();
        let lists = parallel::map_ranges(pairs.len(), CHEAP, &|range| {
            let mut minima = Vec::with_capacity(range.len());
            for &[i, j] in &pairs[range] {
                this.pair_minima(strands, i as usize, j as usize, &mut minima);
            }
            minima
        });
        minima.clear();
        lists.iter().for_each(|list| minima.extend_from_slice(list));
        site::put_in_order(strands, &mut minima, |s, u| this.start[s] + u * this.lengths[s], &this.lengths);
        let arc = |s: usize, u: f64| this.arc(strands, s, u);
        sites.clear();
        sites.extend(parallel::map(minima.len(), CHEAP, &|k| site::site_of(strands, arc, &minima[k])));
        self.minima = minima;
    }

    /// All minima in range of one candidate pair.
    fn pair_minima(&self, strands: &Strands, i: usize, j: usize, out: &mut Vec<Minimum>) {
        let reach = strands.reach_of(i) + strands.reach_of(j) + self.options.range;
        if reach < 0.0 || self.exclusion.excluded(i, j) {
            return;
        }
        let first = out.len();
        self.minima_within(strands, [i, j], reach, out);
        if strands.varied() {
            keep_from(out, first, |m| self.in_range(strands, m));
        }
    }

    /// Whether a minimum is in range with the radii at its points.
    fn in_range(&self, strands: &Strands, m: &Minimum) -> bool {
        let (i, j) = (m.i as usize, m.j as usize);
        let w = site::connection(strands, m);
        norm(&w) <= strands.radius_at(i, m.u) + strands.radius_at(j, m.v) + self.options.range
    }

    /// All minima of a pair i < j with distance at most `reach`.
    fn minima_within(&self, strands: &Strands, [i, j]: [usize; 2], reach: f64, out: &mut Vec<Minimum>) {
        if strands.is_straight(i) && strands.is_straight(j) {
            // Adjacent straight segments are nearest at their joint.
            if !strands.adjacent(i, j) {
                out.extend(site::straight_minimum(strands, i, j, reach));
            }
            return;
        }
        let (a, b) = (strands.cubic(i), strands.cubic(j));
        if capsule::distance_lower_bound(&a, &b) > reach {
            return;
        }
        let first = out.len();
        closest::minima(&a, &b, reach, self.options.sampling, |u, v, flat| {
            out.push(Minimum { i: i as u32, u, j: j as u32, v, flat });
        });
        vertex_minima(strands, i, j, reach, out);
        vertex_minima(strands, j, i, reach, out);
        keep_from(out, first, |m| !self.neighbouring_points(strands, m));
    }

    /// Whether the two points are neighbours along the curve; the two parameters of one joint included.
    fn neighbouring_points(&self, strands: &Strands, m: &Minimum) -> bool {
        let (i, j) = (m.i as usize, m.j as usize);
        if strands.curve_of(i) != strands.curve_of(j) {
            return false;
        }
        let same_joint = (strands.next(i) == Some(j) && m.u > 1.0 - COINCIDENT && m.v < COINCIDENT)
            || (strands.next(j) == Some(i) && m.v > 1.0 - COINCIDENT && m.u < COINCIDENT);
        let turning = |from, to| self.exclusion.turning_between_pieces(strands, from, to);
        let (own, other) = ((i, m.u), (j, m.v));
        same_joint
            || (self.options.neighbours == Neighbours::Turning
                && turning(own, other).min(turning(other, own)) < std::f64::consts::FRAC_PI_2)
    }
}

/// Drops those minima from index `first` on that are not `wanted`.
fn keep_from(minima: &mut Vec<Minimum>, first: usize, wanted: impl Fn(&Minimum) -> bool) {
    let mut kept = first;
    for k in first..minima.len() {
        if wanted(&minima[k]) {
            minima[kept] = minima[k];
            kept += 1;
        }
    }
    minima.truncate(kept);
}
