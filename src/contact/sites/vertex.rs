//! Minima of the distance at kinks and open ends of curves, by their one-sided slopes.

use crate::contact::curves::curve::{angle, norm};
use crate::contact::curves::input::Strands;
use crate::contact::projection::{Feet, local_minima};
use crate::contact::sites::site::Minimum;
use crate::math::Vec3;

/// Joints with less than this angle between their tangents, rad, are smooth: minima on them are those of the pieces.
const SMOOTH: f64 = 1e-9;

/// Minima at kinks and open ends of segment `i` that it owns (its start, and its end if open), against segment `j`.
/// In the result the lower segment comes first. Pairs of vertices are found in the call with i < j only.
pub(crate) fn vertex_minima(strands: &Strands, i: usize, j: usize, reach: f64, out: &mut Vec<Minimum>) {
    let (own, other) = (strands.cubic(i), strands.cubic(j));
    for u in [0.0, 1.0] {
        let x = own.b[if u == 0.0 { 0 } else { 3 }];
        let Some(fits) = vertex(strands, i, u) else { continue };
        let mut feet = Feet::new();
        local_minima(&other, &x, reach, &mut feet);
        let inner = feet.as_slice().iter().map(|f| f.u).filter(|&v| v > 0.0 && v < 1.0);
        for v in inner {
            if fits(&(x - other.point(v))) {
                out.push(ordered(i, u, j, v));
            }
        }
        for v in [0.0, 1.0] {
            let y = other.b[if v == 0.0 { 0 } else { 3 }];
            let near = norm(&(x - y)) <= reach;
            if near && i < j && fits(&(x - y)) && vertex(strands, j, v).is_some_and(|f| f(&(y - x))) {
                out.push(ordered(i, u, j, v));
            }
        }
    }
}

fn ordered(i: usize, u: f64, j: usize, v: f64) -> Minimum {
    let (i, u, j, v) = if i < j { (i, u, j, v) } else { (j, v, i, u) };
    Minimum { i: i as u32, u, j: j as u32, v, flat: false }
}

/// For a kink or open end owned by the segment: the test whether the distance to a point does not fall on either side,
/// given the vector from that point. `None` for smooth joints and for ends that belong to the next segment.
fn vertex<'a>(strands: &'a Strands, i: usize, u: f64) -> Option<impl Fn(&Vec3) -> bool + use<'a>> {
    let own = strands.cubic(i);
    let (before, after) = if u == 0.0 {
        (strands.prev(i).map(|p| strands.cubic(p).end_tangent()), Some(own.start_tangent()))
    } else if strands.next(i).is_none() {
        (Some(own.end_tangent()), None)
    } else {
        return None;
    };
    if let (Some(p), Some(n)) = (before, after)
        && angle(&p, &n) <= SMOOTH
    {
        return None;
    }
    Some(move |w: &Vec3| before.is_none_or(|t| w.dot(&t) <= 0.0) && after.is_none_or(|t| w.dot(&t) >= 0.0))
}
