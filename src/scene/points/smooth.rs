//! Smoothing of measured centrelines.

use crate::error::InputError;
use crate::math::Vec3;

/// Neighbours that a row of the folded system reaches on either side: two along the curve, which folding a ring
/// doubles.
const BAND: usize = 4;
/// Longest smoothing length, in mean distances of points: rounding is amplified by its fourth power.
const LONGEST: f64 = 100.0;

/// A curve through points, smoothed: the r that minimises
///
/// ```text
/// ∫ |r − p|² ds + ℓ⁴ ∫ |r″|² ds
/// ```
///
/// over the points p, in sums over them with s along the polygon (Whittaker 1923). Of a wave of wavenumber k it keeps
/// the part 1/(1 + (kℓ)⁴): half of waves 2πℓ long, next to nothing of shorter ones, all of longer ones; a circle of
/// radius R shrinks by (ℓ/R)⁴. Closed curves stay closed, end points of open ones stay where they are, straight lines
/// stay as they are.
///
/// ```
/// use supercoil::{math::Vec3, scene::smooth_points};
/// let noisy: Vec<Vec3> = (0..40).map(|k| Vec3::new(k as f64, if k % 2 == 0 { 0.1 } else { -0.1 }, 0.0)).collect();
/// let smooth = smooth_points(&noisy, false, 2.0)?;
/// assert!(smooth[20].y.abs() < 0.01);
/// # Ok::<(), supercoil::InputError>(())
/// ```
///
/// # Errors
/// A `length` ℓ \[L\] that is not above 0, or more than 100 mean distances of points; fewer than 5 points, of which two
/// neighbours coincide.
pub fn smooth_points(points: &[Vec3], closed: bool, length: f64) -> Result<Vec<Vec3>, InputError> {
    InputError::positive("smooth", length)?;
    let polygon = Polygon::new(points, closed)?;
    let mean = polygon.steps.iter().sum::<f64>() / polygon.steps.len() as f64;
    InputError::check("smooth", length, length <= LONGEST * mean, "at most 100 mean distances of points")?;
    let solved = polygon.system(length).solve();
    Ok((0..points.len()).map(|i| solved[polygon.row(i)]).collect())
}

/// The points with the lengths of the sides between them.
struct Polygon<'a> {
    points: &'a [Vec3],
    closed: bool,
    /// From each point to the next, of an open polygon without the last.
    steps: Vec<f64>,
}

impl<'a> Polygon<'a> {
    fn new(points: &'a [Vec3], closed: bool) -> Result<Self, InputError> {
        let count = points.len();
        if count < 5 {
            let allowed = "at least 5 to be smoothed";
            return Err(InputError::Count { field: "points".to_owned(), value: count, allowed });
        }
        let sides = if closed { count } else { count - 1 };
        let steps: Vec<f64> = (0..sides).map(|i| (points[(i + 1) % count] - points[i]).norm()).collect();
        if let Some(index) = steps.iter().position(|step| *step <= 0.0) {
            let reason = format!("points {index} and {} coincide", (index + 1) % count);
            return Err(InputError::inconsistent("points", reason));
        }
        Ok(Self { points, closed, steps })
    }

    /// Row of a point in the system: a ring is folded, so that its ends are near to each other.
    fn row(&self, i: usize) -> usize {
        let count = self.points.len();
        match i {
            _ if !self.closed => i,
            _ if 2 * i < count => 2 * i,
            _ => 2 * (count - i) - 1,
        }
    }

    /// Part of ∫ds that a point stands for.
    fn share(&self, i: usize) -> f64 {
        let (count, steps) = (self.points.len(), &self.steps);
        match (self.closed, i) {
            (true, _) => 0.5 * (steps[i] + steps[(i + count - 1) % count]),
            (false, 0) => 0.5 * steps[0],
            (false, _) if i + 1 == count => 0.5 * steps[i - 1],
            _ => 0.5 * (steps[i] + steps[i - 1]),
        }
    }

    /// The conditions of the minimum.
    fn system(&self, length: f64) -> Banded {
        let (points, count) = (self.points, self.points.len());
        let mut system = Banded::new(count);
        for (i, point) in points.iter().enumerate() {
            system.add(self.row(i), self.row(i), self.share(i));
            system.right[self.row(i)] += point * self.share(i);
        }
        let bent = if self.closed { 0..count } else { 1..count - 1 };
        for i in bent {
            let nodes = [(i + count - 1) % count, i, (i + 1) % count];
            let [before, after] = [1.0 / self.steps[nodes[0]], 1.0 / self.steps[i]];
            let weights = [before, -before - after, after].map(|w| w / self.share(i));
            let rows = nodes.map(|node| self.row(node));
            for (a, wa) in rows.into_iter().zip(weights) {
                for (b, wb) in rows.into_iter().zip(weights).filter(|(b, _)| *b <= a) {
                    system.add(a, b, length.powi(4) * self.share(i) * wa * wb);
                }
            }
        }
        if !self.closed {
            system.hold(0, points[0]);
            system.hold(count - 1, points[count - 1]);
        }
        system
    }
}

/// A symmetric positive definite system with few diagonals, three right-hand sides.
struct Banded {
    /// Row i, columns i − BAND to i.
    rows: Vec<[f64; BAND + 1]>,
    right: Vec<Vec3>,
}

impl Banded {
    fn new(count: usize) -> Self {
        Self { rows: vec![[0.0; BAND + 1]; count], right: vec![Vec3::zeros(); count] }
    }

    /// Adds to an entry of the lower triangle.
    fn add(&mut self, row: usize, column: usize, value: f64) {
        self.rows[row][BAND + column - row] += value;
    }

    fn entry(&self, row: usize, column: usize) -> f64 {
        if column + BAND < row { 0.0 } else { self.rows[row][BAND + column - row] }
    }

    /// Prescribes an unknown.
    fn hold(&mut self, index: usize, value: Vec3) {
        for other in index.saturating_sub(BAND)..(index + BAND + 1).min(self.rows.len()) {
            let (row, column) = (index.max(other), index.min(other));
            if other != index {
                let entry = self.entry(row, column);
                self.right[other] -= value * entry;
                self.rows[row][BAND + column - row] = 0.0;
            }
        }
        self.rows[index][BAND] = 1.0;
        self.right[index] = value;
    }

    /// LDLᵀ in place, then both substitutions.
    fn solve(mut self) -> Vec<Vec3> {
        let count = self.rows.len();
        for i in 0..count {
            let first = i.saturating_sub(BAND);
            for j in first..=i {
                let products: f64 = (first..j).map(|k| self.entry(i, k) * self.entry(j, k) * self.rows[k][BAND]).sum();
                let rest = self.entry(i, j) - products;
                self.rows[i][BAND + j - i] = if i == j { rest } else { rest / self.rows[j][BAND] };
            }
        }
        let mut x = std::mem::take(&mut self.right);
        for i in 0..count {
            for k in i.saturating_sub(BAND)..i {
                let known = x[k];
                x[i] -= known * self.entry(i, k);
            }
        }
        for i in (0..count).rev() {
            x[i] /= self.rows[i][BAND];
            for k in i + 1..(i + BAND + 1).min(count) {
                let known = x[k];
                x[i] -= known * self.entry(k, i);
            }
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A circle keeps its centre and is scaled by the part of its wave that is kept: of the polygon, exactly.
    #[test]
    fn circles_shrink_by_the_fourth_power() {
        let count = 60;
        let at = |i: usize| TAU * i as f64 / count as f64;
        let circle: Vec<Vec3> =
            (0..count).map(|i| Vec3::new(3.0 + 2.0 * at(i).cos(), 2.0 * at(i).sin(), 1.0)).collect();
        let step = (circle[1] - circle[0]).norm();
        let wave = (2.0 - 2.0 * at(1).cos()) / (step * step);
        for length in [0.5, 1.0, 3.0] {
            let kept = 1.0 / (1.0 + (wave * length * length).powi(2));
            let smoothed = smooth_points(&circle, true, length).unwrap();
            let center = Vec3::new(3.0, 0.0, 1.0);
            let off = |(p, q): (&Vec3, &Vec3)| (q - center - kept * (p - center)).norm();
            assert!(circle.iter().zip(&smoothed).map(off).fold(0.0, f64::max) < 1e-9, "{length}");
            assert!((kept - 1.0 / (1.0 + (length / 2.0_f64).powi(4))).abs() < 1e-3, "{kept}");
        }
    }

    #[test]
    fn straight_lines_and_end_points_stay() {
        let line: Vec<Vec3> = (0..20).map(|i| Vec3::new(1.0, 2.0, -1.0) * (i as f64).powf(1.2)).collect();
        let smoothed = smooth_points(&line, false, 10.0).unwrap();
        assert!(line.iter().zip(&smoothed).all(|(p, q)| (p - q).norm() < 1e-9), "{smoothed:?}");
        let zigzag: Vec<Vec3> =
            (0..41).map(|i| Vec3::new(i as f64, if i % 2 == 0 { 0.3 } else { -0.3 }, 0.0)).collect();
        let smoothed = smooth_points(&zigzag, false, 2.0).unwrap();
        assert_eq!((smoothed[0], smoothed[40]), (zigzag[0], zigzag[40]));
        assert!(smoothed[15..26].iter().all(|p| p.y.abs() < 4e-3), "{smoothed:?}");
    }

    /// The banded system against the dense one, points at random places.
    #[test]
    fn the_minimum_is_that_of_the_sums() {
        let mut seed = 7u64;
        let mut random = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        for (closed, count) in [(false, 9), (true, 9), (true, 10)] {
            let points: Vec<Vec3> = (0..count).map(|_| Vec3::new(random(), random(), random())).collect();
            let length = 0.4;
            let smoothed = smooth_points(&points, closed, length).unwrap();
            let value = |r: &[Vec3]| {
                let step = |i: usize| (points[(i + 1) % count] - points[i % count]).norm();
                let (mut sum, ends) = (0.0, [0, count - 1]);
                for i in 0..count {
                    let (before, after) = (step(i + count - 1), step(i));
                    let share = match () {
                        () if closed || !ends.contains(&i) => 0.5 * (before + after),
                        () if i == 0 => 0.5 * after,
                        () => 0.5 * before,
                    };
                    sum += share * (r[i] - points[i]).norm_squared();
                    if closed || !ends.contains(&i) {
                        let slopes = (r[(i + 1) % count] - r[i]) / after - (r[i] - r[(i + count - 1) % count]) / before;
                        sum += length.powi(4) * slopes.norm_squared() / share;
                    }
                }
                sum
            };
            // no movement of a free point lowers it
            let least = value(&smoothed);
            for i in if closed { 0..count } else { 1..count - 1 } {
                for direction in [Vec3::x(), Vec3::y(), Vec3::z()] {
                    for sign in [1.0, -1.0] {
                        let mut moved = smoothed.clone();
                        moved[i] += 1e-4 * sign * direction;
                        assert!(value(&moved) > least, "{closed} {i}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_smoothed_is_refused() {
        let line: Vec<Vec3> = (0..6).map(|i| Vec3::x() * i as f64).collect();
        let refusal = |points: &[Vec3], length| smooth_points(points, false, length).unwrap_err().to_string();
        assert!(refusal(&line, 0.0).starts_with("smooth = 0"));
        assert!(refusal(&line, 101.0).ends_with("at most 100 mean distances of points"));
        assert!(refusal(&line[..4], 1.0).contains("at least 5"));
        assert!(refusal(&[&line[..3], &line[2..]].concat(), 1.0).contains("points 2 and 3 coincide"));
    }
}
