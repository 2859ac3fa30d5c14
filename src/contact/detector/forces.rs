//! Energy, forces and Hessians of a contact law on curves.

use super::Detector;
use crate::contact::curves::input::{Curve, CurveShape, Strands};
use crate::contact::law::Law;
use crate::contact::law::potential::{self, ContactGeometry, PairForce, PairSearch, PairTerm, Pressures, Want};
use crate::error::InputError;
use crate::math::parallel::DEAR;
use crate::math::{Vec3, parallel};

/// Candidate pairs whose forces are computed before they are summed in order, because memory should not grow with
/// the number of pairs.
const BLOCK: usize = 8192;

/// Energy and forces of the contact of curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Forces {
    /// Energy \[F·L\].
    pub energy: f64,
    /// Forces \[F\] on each curve's control points, −∂energy/∂point at fixed arc lengths: one for each point of a
    /// polyline, four for each cubic piece (pieces that share a joint each have their share).
    pub forces: Vec<Vec<Vec3>>,
    /// Smallest gap \[L\]; infinite if nothing overlaps.
    pub min_gap: f64,
}

impl Default for Forces {
    fn default() -> Self {
        Self { energy: 0.0, forces: Vec::new(), min_gap: f64::INFINITY }
    }
}

impl Forces {
    /// Sets the result to no contact and reuses the buffers.
    fn clear(&mut self, strands: &Strands) {
        (self.energy, self.min_gap) = (0.0, f64::INFINITY);
        self.forces.resize_with(strands.curves.len(), Vec::new);
        for (forces, strand) in self.forces.iter_mut().zip(&strands.curves) {
            forces.clear();
            forces.resize(strand.num_control_points(), Vec3::zeros());
        }
    }

    fn add(&mut self, strands: &Strands, pair: [u32; 2], found: &PairForce) {
        if found.min_gap == f64::INFINITY {
            return;
        }
        self.energy += found.energy;
        self.min_gap = self.min_gap.min(found.min_gap);
        for (segment, force) in pair.into_iter().zip(&found.force) {
            let curve = strands.curve_of(segment as usize);
            let strand = &strands.curves[curve];
            let (k, sums) = (segment as usize - strand.first, &mut self.forces[curve]);
            if matches!(strand.shape, CurveShape::Polyline(_)) {
                sums[k] += force[0];
                let next = if k + 1 < sums.len() { k + 1 } else { 0 };
                sums[next] += force[3];
            } else {
                (0..4).for_each(|m| sums[4 * k + m] += force[m]);
            }
        }
    }
}

impl Detector {
    /// Energy, forces and smallest gap of a contact law, integrated over the parts of each curve that overlap another
    /// (half from each side). A number is the stiffness κ \[F/L²\] of the penalty ½κ⟨−gap⟩² per length. For explicit
    /// time steppers. It costs up to four times [`Detector::detect`] for polylines in contact along their whole length.
    /// The result stays in buffers.
    ///
    /// Every strand within the contact distance of a point pushes it, at its nearest points; the farthest points
    /// between two nearest ones are subtracted (see `contact::zones`), corners of polylines included. So the force is
    /// continuous and the exact derivative of the energy, also where a strand slides over a kink, inside or outside, or
    /// is bent tighter than the contact distance. There are two exceptions: the force jumps where a radius per segment
    /// steps, and where adjacent segments of one curve, which never push each other, turn by a right angle or more.
    /// Points where centrelines coincide have energy, but no direction and no force.
    ///
    /// # Errors
    /// As [`Detector::detect`], and numbers of the law that are not finite and positive.
    pub fn forces(&mut self, curves: &[Curve], law: impl Into<Law>) -> Result<&Forces, InputError> {
        let law = checked(law.into())?;
        let strands = self.update(curves, self.options.range.max(0.0))?;
        let mut forces = std::mem::take(&mut self.forces);
        forces.clear(&strands);
        let mut found = std::mem::take(&mut self.pair_forces);
        let this = &*self;
        let geometry = ContactGeometry::new(strands.clone(), &this.lengths, Some(&this.exclusion));
        let pressures = Pressures::without_offsets(law);
        for block in this.broad.pairs().chunks(BLOCK) {
            found.resize(block.len(), PairForce::NONE);
            parallel::each_part(&mut found, DEAR, &|first, part| {
                let mut search = PairSearch::new(&pressures, true);
                for (force, pair) in part.iter_mut().zip(&block[first..]) {
                    let pair = pair.map(|k| k as usize);
                    *force = if potential::wanted(&strands, &this.exclusion, pair) {
                        geometry.force(pair, &mut search)
                    } else {
                        PairForce::NONE
                    };
                }
            });
            block.iter().zip(&found).for_each(|(pair, found)| forces.add(&strands, *pair, found));
        }
        (self.forces, self.pair_forces) = (forces, found);
        Ok(&self.forces)
    }

    /// The terms whose sum is [`Detector::forces`], with Hessians on request, for implicit time steppers: one term per
    /// ordered pair of segments in contact, with respect to the control points of both cubics; see [`PairTerm`]. A
    /// polyline's segment p₀p₁ counts as the cubic with b₁ = p₀ + (p₁ − p₀)/3, b₂ likewise:
    /// [`PairTerm::point_gradient`] and [`PairTerm::point_hessian`] bring gradient and Hessian to its points. A term
    /// takes about 400 bytes, with Hessian 5 kB.
    ///
    /// # Errors
    /// As [`Detector::forces`].
    pub fn terms(&mut self, curves: &[Curve], law: impl Into<Law>, want: Want) -> Result<Vec<PairTerm>, InputError> {
        let law = checked(law.into())?;
        let strands = self.update(curves, self.options.range.max(0.0))?;
        let wanted = |p: &&[u32; 2]| potential::wanted(&strands, &self.exclusion, p.map(|k| k as usize));
        let pairs: Vec<[u32; 2]> = self.broad.pairs().iter().filter(wanted).copied().collect();
        let pressures = Pressures::without_offsets(law);
        let geometry = ContactGeometry::new(strands, &self.lengths, Some(&self.exclusion));
        Ok(potential::evaluate_within(&geometry, &pairs, &pressures, want))
    }
}

impl From<f64> for Law {
    /// The penalty of this stiffness \[F/L²\].
    fn from(stiffness: f64) -> Self {
        Self::Linear { stiffness }
    }
}

/// The law, if its numbers are finite and positive.
fn checked(law: Law) -> Result<Law, InputError> {
    match law {
        Law::Linear { stiffness } => InputError::positive("stiffness", stiffness)?,
        Law::Core { pressure, depth } => {
            InputError::positive("pressure", pressure)?;
            InputError::positive("depth", depth)?;
        }
    }
    Ok(law)
}
