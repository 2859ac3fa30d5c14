//! Search for the zones near a point of a strand, by buckets.

use std::collections::BTreeMap;

use super::{SiteZone, class};
use crate::contact::arc::ascending;
use crate::contact::curve::CurveSet;

/// Zones by strand and partner strand, in buckets of arc length. There are as many buckets as zones; zones hardly
/// overlap on their own strand, so each fills a few buckets.
pub(super) struct ByPlace {
    classes: BTreeMap<(usize, usize), Buckets>,
}

struct Buckets {
    size: f64,
    closed: bool,
    lists: Vec<Vec<u32>>,
}

impl ByPlace {
    /// Buckets of sorted zones.
    pub fn new(set: &CurveSet, zones: &[SiteZone]) -> Self {
        let mut classes = BTreeMap::new();
        let mut first = 0;
        while let Some(zone) = zones.get(first) {
            let range = class(zones, zone.curve_a, zone.curve_b);
            let count = range.len();
            let closed = set.period(zone.curve_a).is_some();
            let size = set.length_of(zone.curve_a) / count as f64;
            let mut buckets = Buckets { size, closed, lists: vec![Vec::new(); count] };
            for index in range.clone() {
                for bucket in buckets.range(zones[index].arc_a, 0.0) {
                    buckets.lists[bucket].push(index as u32);
                }
            }
            classes.insert((zone.curve_a, zone.curve_b), buckets);
            first = range.end;
        }
        Self { classes }
    }

    /// All zones of strand `a` against strand `b` within `pad` of `arc` on `a` (and some beyond), ascending.
    pub fn near(&self, (a, b): (usize, usize), arc: [f64; 2], pad: f64) -> Vec<usize> {
        let Some(buckets) = self.classes.get(&(a, b)) else { return Vec::new() };
        let mut found: Vec<usize> =
            buckets.range(arc, pad).flat_map(|bucket| buckets.lists[bucket].iter().map(|&i| i as usize)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }
}

impl Buckets {
    /// Buckets of an arc widened by `pad`, none twice.
    fn range(&self, arc: [f64; 2], pad: f64) -> impl Iterator<Item = usize> + use<> {
        let count = self.lists.len() as i64;
        let [from, to] = ascending(arc);
        // slightly enlarged: a point on the border of two buckets lies in both
        let pad = pad + 1e-9 * self.size;
        let (low, high) = (((from - pad) / self.size).floor() as i64, ((to + pad) / self.size).floor() as i64);
        let (low, high) = match self.closed {
            true => (low, high.min(low + count - 1)),
            false => (low.clamp(0, count - 1), high.clamp(0, count - 1)),
        };
        (low..=high).map(move |bucket| bucket.rem_euclid(count) as usize)
    }
}
