//! Rods and states of rods on finer and coarser meshes.

use crate::error::InputError;
use crate::math::quaternion::spin;
use crate::math::shape_functions::lagrange_weight;
use crate::math::{Quat, Vec3};
use crate::rod::Rod;
use crate::rod::rod::MAX_TURN;

/// Nodes that an intermediate one is interpolated from, if there are enough: degree 7, beyond the sixth order of the
/// best elements.
const STENCIL: usize = 8;

impl Rod {
    /// The same rod with `factor` times the elements; node k becomes node `factor` k.
    ///
    /// New nodes are interpolated between the eight nearest old ones, of higher order than the elements for a smooth
    /// start shape. Corners between the nodes are lost; this matters only if the start shape is the natural one
    /// ([`Natural::AsShaped`](crate::rod::Natural)).
    ///
    /// # Errors
    /// A factor of 0; see [`Rod::check`]; more nodes than a rod may have.
    pub fn refined(&self, factor: usize) -> Result<Self, InputError> {
        if factor == 0 {
            let field = format!("rods.{}.refined", self.name);
            return Err(InputError::Count { field, value: factor, allowed: "a factor of at least 1" });
        }
        let num_elements = self.num_elements.saturating_mul(factor);
        if num_elements.saturating_mul(self.order) > super::shape::MAX_SEGMENTS {
            let allowed = "such that the rod has at most ten million nodes";
            let field = format!("rods.{}.elements", self.name);
            return Err(InputError::Count { field, value: num_elements, allowed });
        }
        let seam = std::f64::consts::TAU * self.start_link();
        let (positions, frames) = self.interleave(&self.positions, &self.frames, seam, factor);
        let fine = Self { num_elements, positions, frames, ..self.clone() };
        fine.check().map(|()| fine)
    }

    /// The same rod on every `factor`-th node; `None` if the number of elements is not divisible, or if frames of
    /// neighbouring nodes would differ too much.
    pub(crate) fn coarsened(&self, factor: usize) -> Option<Self> {
        let seam = std::f64::consts::TAU * self.start_link();
        let coarse = Self {
            num_elements: self.num_elements / factor,
            positions: self.positions.iter().step_by(factor).copied().collect(),
            frames: self.frames.iter().step_by(factor).copied().collect(),
            ..self.clone()
        };
        (self.can_be_coarsened(&self.frames, seam, factor) && coarse.check().is_ok()).then_some(coarse)
    }

    /// Nodes and frames of `num_segments` equal segments, interpolated between the eight nearest nodes.
    ///
    /// # Errors
    /// No segments, or more than a rod may have.
    pub(crate) fn resampled(&self, num_segments: usize) -> Result<(Vec<Vec3>, Vec<Quat>), InputError> {
        if num_segments == 0 || num_segments > super::shape::MAX_SEGMENTS {
            let allowed = "at least 1 element, and at most ten million nodes";
            return Err(InputError::Count { field: "elements".to_owned(), value: num_segments, allowed });
        }
        let seam = std::f64::consts::TAU * self.start_link();
        let last = self.num_segments() - 1;
        let node = |k: usize| {
            let at = k as f64 * self.num_segments() as f64 / num_segments as f64;
            let segment = (at as usize).min(last);
            self.between((&self.positions, &self.frames), seam, segment, at - segment as f64)
        };
        Ok((0..num_segments + usize::from(!self.closed)).map(node).unzip())
    }

    /// Whether every `factor`-th node of a state of this rod determines the rotation of the frames between them,
    /// because whole turns are ambiguous. `seam` as for [`Rod::interleave`].
    pub(crate) fn can_be_coarsened(&self, frames: &[Quat], seam: f64, factor: usize) -> bool {
        let turn = |segment: usize| match frames.get(segment + 1) {
            Some(next) => frames[segment].angle_to(next),
            None => frames[segment].angle_to(&(frames[0] * spin(seam))),
        };
        let turns = |first: usize| (first..first + factor).map(turn).sum::<f64>() / std::f64::consts::TAU;
        self.num_elements.is_multiple_of(factor)
            && (0..self.num_segments()).step_by(factor).all(|first| turns(first) <= MAX_TURN)
    }

    /// Nodes of a state of this rod with every segment cut in `factor` equal parts; `seam` \[rad\] rotates the frame at
    /// s = L relative to that at 0.
    pub(crate) fn interleave(
        &self,
        positions: &[Vec3],
        frames: &[Quat],
        seam: f64,
        factor: usize,
    ) -> (Vec<Vec3>, Vec<Quat>) {
        let count = positions.len();
        let (mut r, mut q) = (Vec::with_capacity(factor * count), Vec::with_capacity(factor * count));
        for segment in 0..self.num_segments() {
            r.push(positions[segment]);
            q.push(frames[segment]);
            for part in 1..factor {
                let (point, frame) = self.between((positions, frames), seam, segment, part as f64 / factor as f64);
                r.push(point);
                q.push(frame);
            }
        }
        if !self.closed {
            r.push(positions[count - 1]);
            q.push(frames[count - 1]);
        }
        (r, q)
    }

    /// Position and frame at a fraction of a segment of a state of this rod; `seam` as for [`Rod::interleave`].
    pub(crate) fn between(
        &self,
        (positions, frames): (&[Vec3], &[Quat]),
        seam: f64,
        segment: usize,
        part: f64,
    ) -> (Vec3, Quat) {
        let count = positions.len();
        let stencil = STENCIL.min(count);
        // the first of the nodes interpolated from; beyond the seam on closed rods
        let centred = segment as isize + 1 - (stencil as isize + 1) / 2;
        let first = if self.closed { centred } else { centred.clamp(0, (count - stencil) as isize) };
        let at = (segment as isize - first) as f64 + part;
        let (mut point, mut sum) = (Vec3::zeros(), nalgebra::Vector4::zeros());
        let mut before = frames[segment].coords;
        for k in 0..stencil {
            let index = first + k as isize;
            let (turns, node) = (index.div_euclid(count as isize), index.rem_euclid(count as isize) as usize);
            let frame = if turns == 0 { frames[node] } else { frames[node] * spin(seam * turns as f64) };
            // each in the hemisphere of its predecessor, because frames may rotate by more than half a turn over the
            // stencil
            let aligned = if k > 0 && before.dot(&frame.coords) < 0.0 { -frame.coords } else { frame.coords };
            let weight = lagrange_weight(stencil, |j| j as f64, k, at);
            point += (positions[node] - positions[segment]) * weight;
            sum += aligned * weight;
            before = aligned;
        }
        (positions[segment] + point, Quat::new_normalize(nalgebra::Quaternion::from(sum)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rod::{Natural, RodMesh, Section, Shape};

    /// The refined rod is the one placed with so many more elements, to the eighth order of the spacing; and carries
    /// its link.
    #[test]
    fn refining_is_placing_with_more_elements() {
        let section = Section::isotropic(1.0, 1.5, 100.0, 100.0, 0.0);
        let axis = Vec3::new(1.0, 2.0, -0.5);
        let helix = Shape::Helix { center: Vec3::x(), axis, radius: 0.7, pitch: 0.9, turns: 1.2 };
        let circle = Shape::Circle { length: 5.0, center: Vec3::y(), normal: axis };
        for (shape, closed, turns, factor) in [
            (&helix, false, 0.0, 2),
            (&circle, true, 0.0, 2),
            (&circle, true, 2.3, 2),
            (&helix, false, 0.0, 5),
            (&circle, true, 2.3, 3),
        ] {
            let place = |elements: usize| {
                let rod = Rod::new(
                    "r",
                    shape,
                    RodMesh { closed, num_elements: elements, order: 3 },
                    section,
                    Natural::AsShaped,
                )
                .unwrap();
                if turns == 0.0 { rod } else { rod.with_excess_link(turns).unwrap() }
            };
            let errors = [10, 20].map(|elements| {
                let (fine, exact) = (place(elements).refined(factor).unwrap(), place(factor * elements));
                assert_eq!((fine.num_elements, fine.num_nodes()), (exact.num_elements, exact.num_nodes()));
                let apart = |(a, b): (&Vec3, &Vec3)| (a - b).norm();
                let turned = |(a, b): (&Quat, &Quat)| a.angle_to(b);
                let by_place = fine.positions.iter().zip(&exact.positions).map(apart).fold(0.0, f64::max);
                by_place.max(fine.frames.iter().zip(&exact.frames).map(turned).fold(0.0, f64::max))
            });
            assert!(errors[0] < 2e-4 && errors[1] < errors[0] / 64.0, "{errors:?}");
        }
    }

    /// Every fourth node of a rod refined four times is the rod; elements that cannot be counted off, or that would
    /// turn too far, are left as they are.
    #[test]
    fn coarsening_takes_back_refining() {
        let section = Section::isotropic(1.0, 1.5, 100.0, 100.0, 0.0);
        let shape = Shape::Circle { length: 5.0, center: Vec3::y(), normal: Vec3::x() };
        for order in 1..=3 {
            let rod = Rod::new("r", &shape, RodMesh::closed(15, order), section, Natural::Straight).unwrap();
            let rod = rod.with_excess_link(2.3).unwrap();
            let same = rod.refined(4).unwrap().coarsened(4).unwrap();
            assert_eq!((same.num_elements, same.start_excess_link), (15, 2.3));
            assert!(same.positions == rod.positions && same.frames == rod.frames);
            assert!(rod.coarsened(2).is_none());
        }
        let twisted = Rod::new("r", &shape, RodMesh::closed(12, 1), section, Natural::Straight).unwrap();
        assert!(twisted.with_excess_link(4.0).unwrap().coarsened(3).is_none());
    }

    /// Symptom: a factor too large for any rod panicked instead of being refused. Mechanism: the nodes were
    /// interpolated before they were counted. Threshold: ten million nodes.
    #[test]
    fn too_many_nodes_are_refused_before_they_are_made() {
        let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 2.0 };
        let section = Section::isotropic(1.0, 1.5, 100.0, 100.0, 0.0);
        let rod = Rod::new("r", &line, RodMesh::open(4, 3), section, Natural::Straight).unwrap();
        for factor in [833_334, usize::MAX / 2, usize::MAX] {
            let refused = rod.refined(factor).unwrap_err().to_string();
            assert!(refused.contains("ten million nodes"), "{refused}");
        }
    }

    /// Too few nodes for the whole stencil.
    #[test]
    fn short_rods_are_refined() {
        let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 2.0 };
        let section = Section::isotropic(1.0, 1.5, 100.0, 100.0, 0.0);
        for order in 1..=3 {
            let rod =
                Rod::new("r", &line, RodMesh::open(1, order), section, Natural::Straight).unwrap().refined(2).unwrap();
            assert_eq!(rod.num_nodes(), 2 * order + 1);
            for (node, position) in rod.positions.iter().enumerate() {
                assert!((position - Vec3::x() * rod.arc_of_node(node)).norm() < 1e-15);
            }
        }
    }
}
