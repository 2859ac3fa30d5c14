//! Level of detail: selection of points of a long curve.

use crate::math::Vec3;

/// Points per block, which bounds the work to `BLOCK`/2 distances a point. At least every `BLOCK`-th point is kept.
pub(super) const BLOCK: usize = 512;

/// Every `stride`-th of `count` points and, on open curves, the last.
///
/// ```
/// use supercoil::io::detail::every;
/// assert_eq!(every(10, 4, false), [0, 4, 8, 9]);
/// assert_eq!(every(10, 4, true), [0, 4, 8]);
/// ```
#[must_use]
pub fn every(count: usize, stride: usize, closed: bool) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..count).step_by(stride.max(1)).collect();
    if !closed && count > 0 && kept.last() != Some(&(count - 1)) {
        kept.push(count - 1);
    }
    kept
}

/// Points to keep so that each point left out lies within `tolerance` \[L\] of the straight piece that replaces it
/// (Douglas & Peucker 1973, in blocks of 512 points: time proportional to the points). The first and the last are kept;
/// a closed curve's closing piece is kept as it is. At most `stride` points are passed over at a time.
#[must_use]
pub fn within(points: &[Vec3], tolerance: f64, stride: usize) -> Vec<usize> {
    if points.len() < 3 {
        return (0..points.len()).collect();
    }
    let (last, block) = (points.len() - 1, stride.clamp(1, BLOCK));
    let mut kept = vec![0];
    let mut open: Vec<(usize, usize)> = Vec::new();
    for first in (0..last).step_by(block) {
        open.push((first, (first + block).min(last)));
        while let Some((from, to)) = open.pop() {
            match farthest(points, from, to).filter(|&(_, distance)| distance > tolerance) {
                // the first half on top, so that pieces come out in order
                Some((middle, _)) => open.extend([(middle, to), (from, middle)]),
                None => kept.push(to),
            }
        }
    }
    kept
}

/// The point strictly between two others that is farthest from the segment that joins them, and its distance.
fn farthest(points: &[Vec3], from: usize, to: usize) -> Option<(usize, f64)> {
    let (start, chord) = (points[from], points[to] - points[from]);
    let length_sq = chord.norm_squared();
    let distance_sq = |i: usize| {
        let step = points[i] - start;
        let along = if length_sq > 0.0 { (step.dot(&chord) / length_sq).clamp(0.0, 1.0) } else { 0.0 };
        (step - chord * along).norm_squared()
    };
    let all = (from + 1..to).map(|i| (i, distance_sq(i)));
    all.reduce(|best, next| if next.1 > best.1 { next } else { best }).map(|(i, sq)| (i, sq.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn helix(count: usize) -> Vec<Vec3> {
        (0..count).map(|i| 0.05 * i as f64).map(|t| Vec3::new(t.cos(), t.sin(), 0.1 * t)).collect()
    }

    /// Distance of a point from a polyline, by brute force.
    fn distance(point: &Vec3, line: &[Vec3]) -> f64 {
        let pieces = line.windows(2).map(|w| {
            let chord = w[1] - w[0];
            let along = ((point - w[0]).dot(&chord) / chord.norm_squared()).clamp(0.0, 1.0);
            (point - w[0] - chord * along).norm()
        });
        pieces.fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn what_is_left_out_lies_near_the_line() {
        let points = helix(2000);
        for tolerance in [1e-3, 1e-2, 0.1] {
            let kept = within(&points, tolerance, usize::MAX);
            assert!(kept.windows(2).all(|w| w[0] < w[1]) && kept[0] == 0 && *kept.last().unwrap() == 1999);
            let line: Vec<Vec3> = kept.iter().map(|&i| points[i]).collect();
            let worst = points.iter().map(|p| distance(p, &line)).fold(0.0, f64::max);
            assert!(worst <= tolerance, "{worst}");
            // a chord of sagitta δ on a circle of radius 1 spans the angle √(8δ): not many more points than needed
            let needed = 1999.0 * 0.05 / (8.0 * tolerance).sqrt();
            assert!((kept.len() as f64) < 2.5 * needed, "{} {needed}", kept.len());
        }
    }

    #[test]
    fn straight_lines_keep_a_point_a_block() {
        let points: Vec<Vec3> = (0..10_000).map(|i| Vec3::x() * f64::from(i)).collect();
        assert_eq!(within(&points, 1e-9, usize::MAX).len(), 1 + 9999_usize.div_ceil(BLOCK));
        assert_eq!(within(&points, 1e-9, 10).len(), 1001);
        assert_eq!(within(&points[..2], 1.0, 1), [0, 1]);
        assert_eq!(within(&[Vec3::x(); 5], 0.0, 100), [0, 4]);
        assert!(within(&[], 1.0, 1).is_empty());
    }
}
