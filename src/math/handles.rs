//! The cubic between two points with given tangents, and how its control points move with these.
//!
//! A handle leads from an end of a cubic to the control point next to it. Both are a third as long as an arc of the
//! same chord that turns by as much, so that the ends are passed at the speed of the whole,
//!
//! ```text
//! ⅓ c (φ/2)/sin(φ/2) = ⅓ c g,   g = 1 + ⅔ z + 6/5 z² + 20/7 z³ + O(z⁴),   z = (1 − cos φ)/8 = |t_a − t_b|²/16
//! ```
//!
//! c the chord, φ the angle between the unit tangents t_a and t_b. The series stands for the formula, whose slope is
//! infinite at half a turn; at a radian it is 1e-4 less. So a cubic between two nodes of a rod follows a stretched rod
//! as it follows one that keeps its length, its parameter goes with the arc length, and it depends on nothing but the
//! two nodes.
//!
//! With λ the logarithm of that length, displacements δ and rotation vectors θ of the ends, and h a handle,
//!
//! ```text
//! h ↦ e^δλ e^θ h      δλ = e·(δ_b − δ_a) + w·(θ_b − θ_a) + …      e = chord/c²,  w = −(ln g)′ t_a × t_b, ′ by cos φ
//! ```

use crate::math::{Mat3, Vec3};

/// g and its first two derivatives by cos φ.
fn of_cosine(z: f64) -> [f64; 3] {
    const C: [f64; 3] = [2.0 / 3.0, 6.0 / 5.0, 20.0 / 7.0];
    let slope = -(C[0] + z * (2.0 * C[1] + z * 3.0 * C[2])) / 8.0;
    [1.0 + z * (C[0] + z * (C[1] + z * C[2])), slope, (2.0 * C[1] + z * 6.0 * C[2]) / 64.0]
}

/// Bounds of |g′| and |g″|, their values at half a turn.
const STEEPEST: [f64; 2] = [0.2253, 0.1045];

/// Length of both handles \[L\] of a cubic with this chord \[L\] and these unit tangents at its ends.
pub(crate) fn handle_length(chord: &Vec3, tangents: [&Vec3; 2]) -> f64 {
    let z = (tangents[0] - tangents[1]).norm_squared() / 16.0;
    chord.norm() * of_cosine(z)[0] / 3.0
}

/// Control points \[L\] of the cubic between two points with these unit tangents.
pub(crate) fn control_points([start, end]: [Vec3; 2], [after, before]: [Vec3; 2]) -> [Vec3; 4] {
    let handle = handle_length(&(end - start), [&after, &before]);
    [start, start + after * handle, end - before * handle, end]
}

/// How the control points of such a cubic move with its ends: twelve coordinates, displacement and rotation vector of
/// the start, then of the end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Handles {
    /// From the start, and from the end, to the control point next to it \[L\].
    pub(crate) of_ends: [Vec3; 2],
    /// e and w: the rate of λ by δ_b − δ_a \[1/L\] and by θ_b − θ_a.
    rate: [Vec3; 2],
}

impl Handles {
    /// Those of control points that were placed by [`handle_length`].
    pub(crate) fn of(b: &[Vec3; 4]) -> Self {
        let (of_ends, chord) = ([b[1] - b[0], b[2] - b[3]], b[3] - b[0]);
        let cross = of_ends[1].cross(&of_ends[0]) / (of_ends[0].norm() * of_ends[1].norm());
        let [g, slope, _] = Self::of_cosine(&of_ends);
        Self { of_ends, rate: [chord / chord.norm_squared(), cross * (-slope / g)] }
    }

    fn of_cosine(of_ends: &[Vec3; 2]) -> [f64; 3] {
        of_cosine((of_ends[0] / of_ends[0].norm() + of_ends[1] / of_ends[1].norm()).norm_squared() / 16.0)
    }

    /// Work of forces on the four control points in a stretch of both handles by the factor e.
    fn stretching(&self, forces: [&Vec3; 2]) -> f64 {
        self.of_ends[0].dot(forces[0]) + self.of_ends[1].dot(forces[1])
    }

    /// Rate of λ in a motion of the ends: by their displacements and their rotation vectors.
    pub(crate) fn rate_in(&self, displacements: [&Vec3; 2], rotations: [&Vec3; 2]) -> f64 {
        let [e, w] = &self.rate;
        e.dot(&(displacements[1] - displacements[0])) + w.dot(&(rotations[1] - rotations[0]))
    }

    /// A bound of what a motion of the ends moves the control points by beyond its linear part, over the fraction t ≤ 1
    /// of the motion \[L\].
    pub(crate) fn beyond_linear(&self, displacements: [&Vec3; 2], rotations: [&Vec3; 2]) -> f64 {
        let (chord, length) = (1.0 / self.rate[0].norm(), self.of_ends[0].norm());
        let apart = displacements[1] - displacements[0];
        let turn = rotations[0].norm().max(rotations[1].norm());
        let bends = (rotations[1] - rotations[0]).norm();
        let (along, size) = (chord * self.rate[0].dot(&apart), apart.norm());
        // a chord grows by turning, never by more than its ends come apart
        let across_sq = (size * size - along * along).max(0.0);
        let chord_grows = (across_sq / (2.0 * (chord + along.min(0.0)).max(0.0))).min(size - along);
        let [slope, bend] = STEEPEST;
        let factor_grows = bends * (0.5 * bend * bends + slope * turn);
        let grows = length / chord * chord_grows + (chord * factor_grows + slope * size * bends) / 3.0;
        let rate = length * self.rate_in(displacements, rotations).abs();
        grows + turn * (0.5 * length * turn + rate)
    }

    /// ∂λ by the coordinates.
    fn gradient(&self) -> [f64; 12] {
        let [e, w] = &self.rate;
        [-e.x, -e.y, -e.z, -w.x, -w.y, -w.z, e.x, e.y, e.z, w.x, w.y, w.z]
    }

    /// Forces on the control points as forces on the coordinates.
    #[inline]
    pub(crate) fn pull(&self, forces: [&Vec3; 4]) -> [f64; 12] {
        let [start, after, before, end] = forces;
        let stretching = self.stretching([after, before]);
        let [e, w] = self.rate.map(|rate| rate * stretching);
        let of_ends =
            [start + after - e, self.of_ends[0].cross(after) - w, end + before + e, self.of_ends[1].cross(before) + w];
        std::array::from_fn(|k| of_ends[k / 3][k % 3])
    }

    /// ∂²λ by the coordinates.
    fn curvature(&self) -> [[f64; 12]; 12] {
        let [a, b] = [self.of_ends[0] / self.of_ends[0].norm(), -self.of_ends[1] / self.of_ends[1].norm()];
        let [g, slope, bend] = Self::of_cosine(&self.of_ends);
        let (first, cross, cos) = (slope / g, a.cross(&b), a.dot(&b));
        let second = bend / g - first * first;
        let e = self.rate[0];
        let by_chord = Mat3::identity() * e.norm_squared() - e * e.transpose() * 2.0;
        let along = cross * cross.transpose() * second;
        let both = (a * b.transpose() + b * a.transpose()) * 0.5 - Mat3::identity() * cos;
        let own = along + both * first;
        let mixed = (Mat3::identity() * cos - b * a.transpose()) * first - along;
        let mut out = [[0.0; 12]; 12];
        let mut put = |p: usize, q: usize, block: &Mat3| {
            (0..9).for_each(|k| out[3 * p + k / 3][3 * q + k % 3] = block[(k / 3, k % 3)]);
        };
        put(0, 0, &by_chord);
        put(0, 2, &-by_chord);
        put(2, 0, &-by_chord);
        put(2, 2, &by_chord);
        put(1, 1, &own);
        put(1, 3, &mixed);
        put(3, 1, &mixed.transpose());
        put(3, 3, &own);
        out
    }
}

/// The part of a second derivative that is due to the stretches λ of S cubics. The first 12 S of the N coordinates are
/// theirs, twelve of each.
pub(crate) struct StretchTerms<const S: usize, const N: usize> {
    /// ∂²U/∂λ∂x, x the coordinates with λ held.
    pub(crate) mixed: [[f64; N]; S],
    /// ∂²U/∂λ∂λ.
    pub(crate) own: [[f64; S]; S],
    /// ∂U/∂λ.
    pub(crate) slopes: [f64; S],
}

impl<const S: usize, const N: usize> StretchTerms<S, N> {
    pub(crate) const ZERO: Self = Self { mixed: [[0.0; N]; S], own: [[0.0; S]; S], slopes: [0.0; S] };

    /// Adds the part of the stretch of the end p's handle and of the motion of the end q, whose handle is given:
    /// `moved` is the rate of ∂U/∂λ with the displacement of q, `turned` that with the motion of the tip of q's handle
    /// against q.
    pub(crate) fn add_motion(&mut self, [p, q]: [usize; 2], handle: &Vec3, [moved, turned]: [&Vec3; 2]) {
        let moment = handle.cross(turned);
        for k in 0..3 {
            self.mixed[p / 2][6 * q + k] += moved[k];
            self.mixed[p / 2][6 * q + 3 + k] += moment[k];
        }
        self.own[p / 2][q / 2] += handle.dot(turned);
    }

    /// Adds what a force ∂U/∂h on the handle of an end adds as it turns and stretches.
    pub(crate) fn add_force(&mut self, end: usize, handle: &Vec3, force: &Vec3) {
        let (cubic, moment, slope) = (end / 2, handle.cross(force), handle.dot(force));
        (0..3).for_each(|k| self.mixed[cubic][6 * end + 3 + k] += moment[k]);
        self.own[cubic][cubic] += slope;
        self.slopes[cubic] += slope;
    }

    /// Calls `add(row, column, value)` for every entry of the second derivative by the coordinates.
    pub(crate) fn each_entry(&self, handles: [&Handles; S], mut add: impl FnMut(usize, usize, f64)) {
        let gradients = handles.map(Handles::gradient);
        for cubic in 0..S {
            let (gradient, first) = (&gradients[cubic], 12 * cubic);
            let mut mixed = self.mixed[cubic];
            for (other, of_other) in gradients.iter().enumerate() {
                let half = 0.5 * self.own[cubic][other];
                (0..12).for_each(|k| mixed[12 * other + k] += half * of_other[k]);
            }
            let curvature = handles[cubic].curvature();
            for (i, by_i) in gradient.iter().enumerate() {
                for (j, mixed) in mixed.iter().enumerate() {
                    add(first + i, j, by_i * mixed);
                    add(j, first + i, by_i * mixed);
                }
                (0..12).for_each(|j| add(first + i, first + j, self.slopes[cubic] * curvature[i][j]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quaternion::exp;

    /// Control points between two points with unit tangents, moved by twelve coordinates.
    fn moved(ends: [Vec3; 2], tangents: [Vec3; 2], step: &[f64; 12]) -> [Vec3; 4] {
        let part = |k: usize| Vec3::new(step[k], step[k + 1], step[k + 2]);
        let [start, end] = [ends[0] + part(0), ends[1] + part(6)];
        control_points([start, end], [exp(&part(3)) * tangents[0], exp(&part(9)) * tangents[1]])
    }

    const FORCES: [Vec3; 4] =
        [Vec3::new(0.3, -1.1, 0.7), Vec3::new(1.9, 0.4, -0.2), Vec3::new(-0.8, 0.9, 1.3), Vec3::new(0.1, -0.6, 0.5)];

    /// Ends with tangents that turn by a little, by much, and by nearly half a turn.
    fn bends() -> [([Vec3; 2], [Vec3; 2]); 3] {
        let v = Vec3::new;
        [
            ([v(0.1, 0.2, 0.3), v(1.2, 0.1, 0.5)], [v(1.0, 0.1, 0.0), v(1.0, -0.2, 0.1)]),
            ([v(0.1, 0.2, 0.3), v(1.2, 0.1, 0.5)], [v(0.3, 1.0, 0.2), v(0.9, -1.0, 0.1)]),
            ([v(0.0, 0.0, 0.0), v(0.5, 0.1, 0.0)], [v(0.0, 1.0, 0.05), v(0.02, -1.0, 0.0)]),
        ]
        .map(|(ends, tangents)| (ends, tangents.map(|t| t.normalize())))
    }

    fn work(ends: [Vec3; 2], tangents: [Vec3; 2], step: &[f64; 12]) -> f64 {
        moved(ends, tangents, step).iter().zip(&FORCES).map(|(point, force)| point.dot(force)).sum()
    }

    /// The work of constant forces on the control points has the gradient and second derivative of the coordinates.
    #[test]
    fn derivatives_are_those_of_the_points() {
        for (ends, tangents) in bends() {
            let handles = Handles::of(&moved(ends, tangents, &[0.0; 12]));
            let gradient = handles.pull([&FORCES[0], &FORCES[1], &FORCES[2], &FORCES[3]]);
            let mut terms = StretchTerms::<1, 12>::ZERO;
            let mut second = [[0.0; 12]; 12];
            for (end, force) in [FORCES[1], FORCES[2]].iter().enumerate() {
                let (handle, first) = (&handles.of_ends[end], 6 * end + 3);
                terms.add_force(end, handle, force);
                // θ × (θ × h) of a turning handle
                for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                    second[first + i][first + j] += 0.5 * (force[i] * handle[j] + handle[i] * force[j]);
                    second[first + i][first + j] -= if i == j { force.dot(handle) } else { 0.0 };
                }
            }
            terms.each_entry([&handles], |i, j, value| second[i][j] += value);
            let at = |pairs: &[(usize, f64)]| {
                let mut step = [0.0; 12];
                pairs.iter().for_each(|(k, by)| step[*k] += by);
                work(ends, tangents, &step)
            };
            for i in 0..12 {
                let slope = (at(&[(i, 1e-5)]) - at(&[(i, -1e-5)])) / 2e-5;
                assert!((slope - gradient[i]).abs() < 1e-8, "{i}: {slope} {}", gradient[i]);
                for j in 0..12 {
                    let difference = |h: f64| {
                        let of = |a: f64, b: f64| at(&[(i, a * h), (j, b * h)]);
                        (of(1.0, 1.0) - of(1.0, -1.0) - of(-1.0, 1.0) + of(-1.0, -1.0)) / (4.0 * h * h)
                    };
                    let difference = (4.0 * difference(1e-3) - difference(2e-3)) / 3.0;
                    assert!((difference - second[i][j]).abs() < 1e-6, "({i},{j}): {difference} {}", second[i][j]);
                }
            }
        }
    }

    /// Nothing moves farther than is said, in small motions and in those that turn a chord round.
    #[test]
    fn motions_keep_within_their_bound() {
        let mut closest = 0.0f64;
        for (ends, tangents) in bends() {
            let start = moved(ends, tangents, &[0.0; 12]);
            let handles = Handles::of(&start);
            for (seed, by, turn) in (0..60)
                .flat_map(|seed| [(1e-3, 1e-3), (0.1, 0.1), (0.1, 1.0), (3.0, 0.3)].map(|(by, turn)| (seed, by, turn)))
            {
                let wave = |k: usize| (1.7 * f64::from(seed) + 2.3 * k as f64).sin();
                let step: [f64; 12] = std::array::from_fn(|k| wave(k) * if k % 6 < 3 { by } else { turn });
                let part = |k: usize| Vec3::new(step[k], step[k + 1], step[k + 2]);
                let (displacements, rotations) = ([part(0), part(6)], [part(3), part(9)]);
                let bound =
                    handles.beyond_linear([&displacements[0], &displacements[1]], [&rotations[0], &rotations[1]]);
                let stretch = handles.rate_in([&displacements[0], &displacements[1]], [&rotations[0], &rotations[1]]);
                for (end, m) in [1, 2].into_iter().enumerate() {
                    let handle = handles.of_ends[end];
                    let linear = displacements[end] + rotations[end].cross(&handle) + handle * stretch;
                    for t in [0.05, 0.2, 0.5, 0.8, 1.0] {
                        let there = moved(ends, tangents, &step.map(|x| t * x))[m];
                        let beyond = (there - start[m] - linear * t).norm();
                        assert!(beyond <= t * bound * (1.0 + 1e-9) + 1e-15, "{seed} {by} {turn} {t}: {beyond} {bound}");
                        closest = closest.max(beyond / (t * bound));
                    }
                }
            }
        }
        assert!(closest > 0.5, "{closest}: it could be less");
    }

    /// Arcs of a circle are met to φ⁴/384 of the radius and at their speed; a straight segment is at constant speed.
    #[test]
    fn arcs_keep_their_radius_and_speed() {
        for angle in [0.0f64, 0.2, 0.5, 1.0] {
            let tol = angle.powi(4) / 384.0 * 1.1 + 1e-15;
            let at = |x: f64| Vec3::new(x.sin(), 1.0 - x.cos(), 0.0) * 3.0;
            let (ends, tangents) = match angle {
                0.0 => ([Vec3::zeros(), Vec3::x() * 3.0], [Vec3::x(); 2]),
                _ => ([at(0.0), at(angle)], [Vec3::x(), Vec3::new(angle.cos(), angle.sin(), 0.0)]),
            };
            let b = moved(ends, tangents, &[0.0; 12]);
            for k in 0..=20 {
                let u = f64::from(k) / 20.0;
                let weights = crate::math::bernstein::cubic_weights(u);
                let point: Vec3 = b.iter().zip(weights).map(|(b, w)| b * w).sum();
                let off = match angle {
                    0.0 => (point - Vec3::x() * (3.0 * u)).norm(),
                    _ => ((point - Vec3::y() * 3.0).norm() / 3.0 - 1.0).abs(),
                };
                assert!(off <= tol, "{angle} {u}: {off:e}");
            }
            let third_of_arc = if angle == 0.0 { 1.0 } else { angle };
            let off = (b[1] - b[0]).norm() / third_of_arc - 1.0;
            assert!(off.abs() < 1.2e-4 * angle.powi(8) + 1e-15, "{angle}: {off:e}");
        }
    }
}
