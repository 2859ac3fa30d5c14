//! Base-pair steps taken together in blocks with effective constants, for molecules of more than some kb.
//!
//! A rod whose frames carry the double helix needs a node every few base pairs, for no element may turn by half a turn.
//! A rod in blocks is the axis instead: the double helix, a whole number T of turns, is taken out of its frames evenly,
//! so that they are the base pairs' own at both ends of the molecule. Each block has constant natural strains and a
//! constant stiffness, such that
//!
//! * the block at rest leads from the frame and place of its first base pair to those of its last, exactly;
//! * a force and a moment that are constant in the block's frames cost the energy that they cost in the steps, exactly:
//!   the compliance C⁻¹ is the mean over the block of Aᵀ C(s)⁻¹ A, where A carries force and moment rigidly from the
//!   block's own axis to the place and frame of the rod that has a constant piece a step.
//!
//! Neglected is how force and moment change within a block: second order in its length over that of the bends (a tenth
//! of an end loop, say). Couplings that the helix turns round once within a block average out by themselves. The idea
//! that blocks of steps have constants of their own is that of Skoruppa & Schiessel (2024, arXiv 2409.05510), who
//! average over thermal motion; here the state of rest is linearised.

use std::f64::consts::{PI, TAU};

use crate::dna::pose::strains_between;
use crate::dna::sequence::Helix;
use crate::error::InputError;
use crate::math::quadrature::gauss;
use crate::rod::rest::RestPose;
use crate::rod::{Along, NaturalStrains, Stiffness};

/// Points a step for mean compliances. Frames turn by a tenth of a turn in a step: the mean is right to 1e-8.
const POINTS: usize = 3;
/// Most that a block may be bent, or twisted beyond the mean, rad: constant strains lead the shorter way round.
const MOST_TURNED: f64 = 0.9 * PI;

impl Helix {
    /// The same molecule in blocks of so many steps, or one fewer or more so that they share the molecule evenly:
    /// natural strains and stiffness of the axis, see the [module](self).
    ///
    /// # Errors
    /// [`InputError::Count`] for blocks of no step; [`InputError::Inconsistent`] for a block that at rest is bent, or
    /// twisted beyond the mean, by nearly half a turn.
    ///
    /// ```
    /// use supercoil::dna::sequence::{Sequence, Steps};
    /// let helix = Sequence::parse(&"A".repeat(210))?.helix(&Steps::ideal(), true)?.in_blocks(10)?;
    /// let c = helix.stiffness.at(1.0); // what is isotropic stays as it is
    /// assert!((c[(3, 3)] / (4.114 * 47.6598) - 1.0).abs() < 1e-6);
    /// assert_eq!(helix.turns_left_out, 20.0); // 210 × 34.2857°
    /// # Ok::<(), supercoil::InputError>(())
    /// ```
    pub fn in_blocks(&self, steps: usize) -> Result<Self, InputError> {
        if steps == 0 {
            let field = "sequence.block".to_owned();
            return Err(InputError::Count { field, value: steps, allowed: "at least 1 step" });
        }
        let (count, spacing) = (self.num_steps, self.length / self.num_steps as f64);
        let blocks = (count as f64 / steps as f64).round().max(1.0) as usize;
        let turns = self.turns.round();
        let rate = TAU * turns / self.length;
        let (mut ends, mut natural, mut stiffness) = (Vec::new(), Vec::new(), Vec::new());
        let mut here = RestPose::START;
        for block in 0..blocks {
            let [first, last] = [block, block + 1].map(|k| k * count / blocks);
            let parts = (first..last).map(|k| self.natural.at((k as f64 + 0.5) * spacing));
            let excess: f64 = parts.clone().map(|part| (part[5] - rate) * spacing).sum();
            let there = parts.fold(here, |place, part| place.along(&part, spacing));
            let [start, end] =
                [(here, first), (there, last)].map(|(place, k)| place.turned(-rate * k as f64 * spacing));
            let pose = start.to(&end);
            if excess.abs() > MOST_TURNED || pose.0.angle() > MOST_TURNED {
                let reason = format!(
                    "base pairs {} to {} make a block that is turned by {:.0}° and twisted by {:.0}° beyond the mean \
                     at rest: take smaller blocks",
                    first + 1,
                    last + 1,
                    pose.0.angle().to_degrees(),
                    excess.to_degrees()
                );
                return Err(InputError::Inconsistent { field: "sequence.block".to_owned(), reason });
            }
            let length = (last - first) as f64 * spacing;
            let strains = strains_between(&pose, length);
            stiffness.push(self.block_stiffness(first..last, &strains, (here, start)));
            natural.push(strains);
            ends.push(self.length * (last as f64 / count as f64));
            here = there;
        }
        let pieces = natural
            .iter()
            .zip(&ends)
            .scan(0.0, |before, (strains, end)| Some(strains[5] * (end - std::mem::replace(before, *end))));
        let turns_of_axis = pieces.sum::<f64>() / TAU;
        Ok(Self {
            natural: Along::pieces(ends.clone(), natural)?,
            stiffness: Along::pieces(ends, stiffness)?,
            turns: turns + turns_of_axis,
            turns_left_out: turns,
            ..self.clone()
        })
    }

    /// Stiffness of a block with these strains, from the base pair `here`, whose frame as one of the axis is `start`.
    fn block_stiffness(
        &self,
        steps: std::ops::Range<usize>,
        strains: &NaturalStrains,
        (mut here, start): (RestPose, RestPose),
    ) -> Stiffness {
        let (spacing, rule) = (self.length / self.num_steps as f64, gauss(POINTS));
        let (first, count) = (steps.start, steps.len() as f64);
        let mut compliance = Stiffness::zeros();
        for k in steps {
            let middle = (k as f64 + 0.5) * spacing;
            let (part, of_step) = (self.natural.at(middle), self.stiffness.at(middle));
            let softness = of_step.try_inverse().unwrap_or_else(Stiffness::zeros);
            for (x, weight) in rule.points.iter().zip(rule.weights) {
                let axis = start.along(strains, ((k - first) as f64 + x) * spacing);
                let (turn, lever) = axis.to(&here.along(&part, x * spacing));
                let back = turn.inverse().to_rotation_matrix().into_inner();
                let mut carried = Stiffness::zeros();
                carried.fixed_view_mut::<3, 3>(0, 0).copy_from(&back);
                carried.fixed_view_mut::<3, 3>(3, 3).copy_from(&back);
                carried.fixed_view_mut::<3, 3>(3, 0).copy_from(&(-back * lever.cross_matrix()));
                compliance += carried.transpose() * softness * carried * (weight / count);
            }
            here = here.along(&part, spacing);
        }
        let stiffness = compliance.try_inverse().unwrap_or_else(Stiffness::zeros);
        // rounding leaves mirrored entries apart
        (stiffness + stiffness.transpose()) * 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dna::sequence::{Sequence, Steps};
    use crate::math::Vec3;
    use nalgebra::Vector6;

    const LETTERS: &str = "GCTTATAACGGATCCATTGCAGTCAGGTACCAATTCGCAAATTTGGCTTAACGATCGATCCGGTATACGTAAAAATTTGCGC";

    fn helix() -> Helix {
        Sequence::parse(LETTERS).unwrap().helix(&Steps::protein_dna_1998().unwrap(), false).unwrap()
    }

    /// Frames of the axis at the ends of blocks are those of the base pairs there, without the turns taken out; at the
    /// end of the molecule they are its own.
    #[test]
    fn blocks_at_rest_lead_from_base_pair_to_base_pair() {
        let (fine, steps) = (helix(), 81);
        let spacing = fine.length / 81.0;
        for size in [1, 5, 11, 27, 81] {
            let coarse = fine.in_blocks(size).unwrap();
            let (mut pair, mut axis) = (RestPose::START, RestPose::START);
            for k in 0..steps {
                let middle = (f64::from(k) + 0.5) * spacing;
                pair = pair.along(&fine.natural.at(middle), spacing);
                axis = axis.along(&coarse.natural.at(middle), spacing);
                let is_end = (k + 1) % (steps / (81 / size as i32)) == 0;
                if (81 % size == 0 && is_end) || k + 1 == steps {
                    let left_out = TAU * coarse.turns_left_out * f64::from(k + 1) / 81.0;
                    let (turn, shift) = pair.to(&axis.turned(left_out));
                    assert!(turn.angle() < 1e-11 && shift.norm() < 1e-11, "{size} {k}: {turn} {shift}");
                }
            }
            assert!(axis.frame.angle_to(&pair.frame) < 1e-11, "{size}");
            assert!((coarse.turns - fine.turns).abs() < 0.1, "{size}: {} {}", coarse.turns, fine.turns);
        }
    }

    /// The energy of constant force and moment, summed over the steps by brute force: many points, forces carried in
    /// space.
    #[test]
    fn constant_forces_cost_the_energy_of_the_steps() {
        let fine = helix();
        let spacing = fine.length / 81.0;
        let coarse = fine.in_blocks(9).unwrap();
        let stress = Vector6::new(3.0, -2.0, 5.0, 12.0, -7.0, 9.0);
        for block in [0, 4, 8] {
            let from = 9.0 * f64::from(block) * spacing;
            let to = RestPose::along;
            let walk = |helix: &Helix, s: f64| {
                let whole = (s / spacing).floor() as usize;
                let start = (0..whole).fold(RestPose::START, |place, k| {
                    to(&place, &helix.natural.at((k as f64 + 0.5) * spacing), spacing)
                });
                to(&start, &helix.natural.at((whole as f64 + 0.5) * spacing), s - whole as f64 * spacing)
            };
            let (parts, mut sum) = (9 * 40, 0.0);
            for part in 0..parts {
                let s = from + (f64::from(part) + 0.5) / f64::from(parts) * 9.0 * spacing;
                let (axis, pair) = (walk(&coarse, s), walk(&fine, s));
                let (n, m) = (axis.frame * Vec3::new(3.0, -2.0, 5.0), axis.frame * Vec3::new(12.0, -7.0, 9.0));
                let m = m + (axis.position - pair.position).cross(&n);
                let (n, m) = (pair.frame.inverse() * n, pair.frame.inverse() * m);
                let local = Vector6::new(n.x, n.y, n.z, m.x, m.y, m.z);
                sum += 0.5 * local.dot(&(fine.stiffness.at(s).try_inverse().unwrap() * local)) * 9.0 * spacing
                    / f64::from(parts);
            }
            let effective = coarse.stiffness.at(from + spacing).try_inverse().unwrap();
            let energy = 0.5 * stress.dot(&(effective * stress)) * 9.0 * spacing;
            assert!((energy / sum - 1.0).abs() < 1e-4, "{block}: {energy} {sum}");
        }
    }

    #[test]
    fn unusable_blocks_are_refused() {
        let refused = helix().in_blocks(0).unwrap_err().to_string();
        assert_eq!(refused, "sequence.block = 0: must be at least 1 step");
        let bound = crate::dna::bound::Bound::parse(
            "hold, from, to, tilt, roll, twist, shift, slide, rise\nblock, 20, 40, 0, 30, 0, 0, 0, 60\n",
        );
        let steps = Steps::protein_dna_1998().unwrap();
        let held = Sequence::parse(LETTERS).unwrap().helix_with(&steps, false, &bound.unwrap()).unwrap();
        assert!(held.in_blocks(4).is_ok());
        let refused = held.in_blocks(27).unwrap_err().to_string();
        assert!(refused.starts_with("sequence.block: base pairs 28 to 55 make a block that is turned by"), "{refused}");
    }
}
