//! Which segments may touch which obstacles: the broad phase of surfaces, one pass over all segments.
//!
//! As in the broad phase of strands the list is made for pairs within `range + margin`, holds all within `range`, and
//! is kept while it does and nothing in it has gone far. A ball about a segment settles most pairs.

use std::ops::Range;

use crate::contact::curve::CurveSet;
use crate::contact::potential::surface::{ball, relative};
use crate::math::parallel::{self, CHEAP};
use crate::math::signed_distance::Surface;

/// Pairs of a segment and a surface.
#[derive(Debug, Default)]
pub(crate) struct NearSurfaces {
    /// Ascending.
    pairs: Vec<[u32; 2]>,
    generation: u64,
}

impl NearSurfaces {
    /// Segments with surfaces that they are near, ascending by both.
    pub(crate) fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// Counts changes of those pairs that the tangent couples: of surfaces that nodes carry.
    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }

    /// Renews the list if a pair within `range` \[L\] of touching is not in it, or one that is in it is farther than
    /// when it was made by another `margin`.
    pub(crate) fn update(
        &mut self,
        (set, surfaces): (&CurveSet, &[Surface]),
        (range, margin): (f64, f64),
        can_touch: impl Fn(usize, usize) -> bool + Sync,
    ) {
        if surfaces.is_empty() {
            return;
        }
        let found = within((set, surfaces), range + 2.0 * margin, can_touch);
        let is_known = |pair: &[u32; 2]| self.pairs.binary_search(pair).is_ok();
        let kept = found.iter().filter(|(pair, _)| is_known(pair)).count();
        if kept == self.pairs.len() && found.iter().all(|(pair, gap)| *gap > range || is_known(pair)) {
            return;
        }
        let pairs: Vec<[u32; 2]> = found.into_iter().filter(|(_, gap)| *gap <= range + margin).map(|at| at.0).collect();
        let is_coupled = |pair: &&[u32; 2]| surfaces[pair[1] as usize].carried;
        self.generation += u64::from(!pairs.iter().filter(is_coupled).eq(self.pairs.iter().filter(is_coupled)));
        self.pairs = pairs;
    }
}

/// Pairs that may be as near to touching as `reach` \[L\], with a bound of their gap from below \[L\].
fn within(
    (set, surfaces): (&CurveSet, &[Surface]),
    reach: f64,
    can_touch: impl Fn(usize, usize) -> bool + Sync,
) -> Vec<([u32; 2], f64)> {
    let of_range = |range: Range<usize>| {
        let mut found = Vec::new();
        for segment in range {
            let (middle, size) = ball(set, segment);
            let radius = set.radius_of(segment);
            for (index, surface) in surfaces.iter().enumerate() {
                if surface.distance(&(middle - surface.point())) - size - radius > reach {
                    continue;
                }
                let gap = surface.least_in_hull(&relative(surface, set, segment)) - radius;
                if gap <= reach && can_touch(segment, index) {
                    found.push(([segment as u32, index as u32], gap));
                }
            }
        }
        found
    };
    parallel::map_ranges(set.len(), CHEAP, &of_range).concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::curve::{Cubic, CurveInput};
    use crate::contact::potential::surface::point_of;
    use crate::math::Vec3;
    use crate::math::signed_distance::Skeleton;

    const RADIUS: f64 = 0.05;
    const SEGMENTS: usize = 40;
    const RANGE: f64 = 0.1;
    const MARGIN: f64 = 0.04;

    /// A wavy strand that drifts, at a height.
    fn strand(time: f64, height: f64) -> CurveSet {
        let node = |k: usize| {
            let s = k as f64 / SEGMENTS as f64;
            Vec3::new(3.0 * s - 1.5 + 0.3 * time, (5.0 * s + time).sin(), 0.4 * (11.0 * s).cos() + 0.2 * time + height)
        };
        let segment = |k: usize| {
            let [a, b] = [node(k), node(k + 1)];
            let bulge = Vec3::new(0.0, 0.01, 0.02);
            Cubic { b: [a, a + (b - a) / 3.0 + bulge, b - (b - a) / 3.0 - bulge, b] }
        };
        let segments = (0..SEGMENTS).map(segment).collect();
        let lengths = vec![3.0 / SEGMENTS as f64; SEGMENTS];
        CurveSet::new(vec![CurveInput { segments, lengths, closed: false, radius: RADIUS }]).unwrap()
    }

    fn surfaces(carried: bool) -> Vec<Surface> {
        let (point, axis) = (Vec3::new(0.4, 0.1, -0.2), Vec3::new(2.0, -1.0, 2.0) / 3.0);
        let of = |skeleton, level, sign| Surface { skeleton, level, lost: Vec3::zeros(), sign, carried };
        vec![
            of(Skeleton::Plane { point, normal: axis }, 0.0, 1.0),
            of(Skeleton::Point { point }, 0.7, 1.0),
            of(Skeleton::Line { point, axis }, 0.4, 1.0),
            of(Skeleton::Line { point, axis }, 1.4, -1.0),
            of(Skeleton::Piece { point, axis, length: Some(0.5) }, 0.2, 1.0),
        ]
    }

    /// All pairs within the range by points of the curves are listed, and none that the list would not be made for with
    /// twice the margin; changes of pairs that nothing couples are not counted. The last strand comes from afar, to a
    /// list without pairs.
    #[test]
    fn the_list_holds_what_is_near_by_points() {
        let sphere = surfaces(false)[1..2].to_vec();
        for (surfaces, falls) in [(surfaces(false), false), (surfaces(true), false), (sphere, true)] {
            let strand = |time: f64| if falls { strand(0.0, 3.0 - 2.0 * time) } else { strand(time, 0.0) };
            let mut near = NearSurfaces::default();
            let (mut renewed, mut most) = (0, 0);
            for step in 0..200 {
                let set = strand(0.01 * f64::from(step));
                let before = near.pairs.clone();
                near.update((&set, &surfaces), (RANGE, MARGIN), |segment, surface| (segment, surface) != (7, 1));
                assert!(near.pairs.is_sorted());
                renewed += u64::from(near.pairs != before);
                most = most.max(near.pairs.len());
                for (segment, index) in (0..SEGMENTS).flat_map(|k| (0..surfaces.len()).map(move |index| (k, index))) {
                    let r = relative(&surfaces[index], &set, segment);
                    let gap = |k: u32| surfaces[index].distance(&point_of(&r, f64::from(k) / 64.0)) - RADIUS;
                    let least = (0..=64).map(gap).fold(f64::INFINITY, f64::min);
                    let is_listed = near.pairs.contains(&[segment as u32, index as u32]);
                    assert!(is_listed || least > RANGE || (segment, index) == (7, 1), "{segment} {index}: {least}");
                    // hulls are nearer than curves, by no more than a segment is long
                    assert!(!is_listed || least <= RANGE + 2.0 * MARGIN + 0.1, "{segment} {index}: {least}");
                }
                assert!(!near.pairs.contains(&[7, 1]));
            }
            assert!((3..150).contains(&renewed) && most < SEGMENTS * surfaces.len(), "{renewed} {most}");
            assert_eq!(near.generation(), if surfaces[0].carried { renewed } else { 0 });
        }
    }
}
