//! Terms of the contact potential, one for each pair of segments in contact.

use super::stiffness::{Hessian, PairTangent};
use crate::contact::curves::input::Strands;
use crate::contact::zones::{BranchPiece, FootKind};
use crate::math::{Mat3, Vec3};

/// One piece of a contact zone, for reports and multiplier updates.
#[derive(Debug, Clone, Copy)]
pub struct ZonePiece {
    /// Geometry of the piece.
    pub(crate) piece: BranchPiece,
    /// Smallest gap inside \[L\].
    pub min_gap: f64,
    /// w∫p ds \[F\], w the slave's share of the pair's contact: its part of the contact force; negative where it is
    /// subtracted.
    pub force: f64,
    /// w∫p u ds and w∫p u² ds \[F\], u the slave parameter: first and second moment of the force.
    pub moments: [f64; 2],
    /// w∫p n ds \[F\], n from the foot to the slave: its part of the force on the slave.
    pub push: Vec3,
    /// w∫p (x − x₀) × n ds \[F·L\], x on the slave, x₀ the start of its segment: its part of the moment of the force on
    /// the slave. The force on the master acts along the same lines.
    pub torque: Vec3,
}

impl ZonePiece {
    /// Slave parameters of both ends, ascending, in \[0, 1\].
    #[must_use]
    pub fn u(&self) -> [f64; 2] {
        self.piece.u
    }

    /// Parameters of the master at the feet of both ends, in \[0, 1\].
    #[must_use]
    pub fn v(&self) -> [f64; 2] {
        self.piece.v
    }
}

/// Contribution of one ordered pair (slave, master) that is in contact.
#[derive(Debug, Clone)]
pub struct PairTerm {
    /// Slave segment.
    pub slave: usize,
    /// Master segment.
    pub master: usize,
    /// Energy \[F·L\].
    pub energy: f64,
    /// ∂U/∂(control points): slave's four, master's four \[F\].
    pub gradient: [Vec3; 8],
    /// Symmetric Hessian \[F/L\]; `None` with [`Want::Gradient`].
    pub hessian: Option<Box<Hessian>>,
    /// Zones of this pair.
    pub zones: Vec<ZonePiece>,
    /// Points in contact, if the tangent is requested.
    pub(crate) points: Vec<QuadraturePoint>,
}

impl PairTerm {
    /// The gradient with respect to the ends of two *straight* segments: slave's start and end, master's start and end
    /// \[F\].
    #[must_use]
    pub fn point_gradient(&self) -> [Vec3; 4] {
        let ends = |g: &[Vec3]| [g[0] + (g[1] * 2.0 + g[2]) / 3.0, (g[1] + g[2] * 2.0) / 3.0 + g[3]];
        let ([a0, a1], [b0, b1]) = (ends(&self.gradient[..4]), ends(&self.gradient[4..]));
        [a0, a1, b0, b1]
    }

    /// The Hessian with respect to the ends of two *straight* segments, in the order of [`PairTerm::point_gradient`]:
    /// all 16 blocks \[F/L\]; zero with [`Want::Gradient`].
    #[must_use]
    pub fn point_hessian(&self) -> [[Mat3; 4]; 4] {
        // Weights of the ends in the control points of a straight segment.
        let parts = [[1.0, 2.0 / 3.0, 1.0 / 3.0, 0.0], [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]];
        let mut sum = [[Mat3::zeros(); 4]; 4];
        let Some(hessian) = &self.hessian else { return sum };
        for (m, n) in (0..8).flat_map(|m| (0..8).map(move |n| (m, n))) {
            let block = if m <= n { hessian[m][n] } else { hessian[n][m].transpose() };
            for (p, q) in (0..2).flat_map(|p| (0..2).map(move |q| (p, q))) {
                sum[p + 2 * (m / 4)][q + 2 * (n / 4)] += block * (parts[p][m % 4] * parts[q][n % 4]);
            }
        }
        sum
    }
}

/// A quadrature point in contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct QuadraturePoint {
    pub(super) u: f64,
    pub(super) v: f64,
    pub(super) kind: FootKind,
    /// Weight × stiffness of the law \[F/L\].
    pub(super) stiffness: f64,
}

/// Choice of the quantities that [`evaluate`](super::evaluate) computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Want {
    /// Energy, gradient, zones.
    Gradient,
    /// Also the Hessian.
    Hessian,
}

/// One ordered pair (slave, master) in contact: zones and points of its term, kept after the term is summed.
#[derive(Debug, Clone)]
pub struct ContactPair {
    /// Slave segment.
    pub slave: usize,
    /// Master segment.
    pub master: usize,
    /// Zones of this pair; empty unless requested.
    pub zones: Box<[ZonePiece]>,
    /// Points in contact; empty unless the tangent was requested.
    pub(crate) points: Box<[QuadraturePoint]>,
}

impl From<PairTerm> for ContactPair {
    fn from(PairTerm { slave, master, zones, points, .. }: PairTerm) -> Self {
        Self { slave, master, zones: zones.into(), points: points.into() }
    }
}

/// A term with respect to the ends of both segments: six coordinates each (displacement, rotation vector), slave's
/// start and end, master's start and end. The control points next to an end rotate with it.
pub(crate) struct EndTerm {
    pub(crate) pair: ContactPair,
    /// Energy \[F·L\].
    pub(crate) energy: f64,
    pub(crate) gradient: [f64; 24],
}

/// The terms of one candidate pair, with the first segment as the slave and with the second, as far as they are in
/// contact.
pub(crate) struct CandidateTerms {
    pub(crate) terms: [Option<EndTerm>; 2],
    /// Second derivative of their sum with respect to the first segment's ends, then the second's; not filled if there
    /// are no terms.
    pub(crate) tangent: PairTangent,
}

impl CandidateTerms {
    /// Of a pair that is not in contact.
    pub(crate) const NONE: Self = Self { terms: [None, None], tangent: [[0.0; 24]; 24] };

    /// The second derivative if the pair is in contact.
    pub(crate) fn second_derivative(&self) -> Option<&PairTangent> {
        self.terms.iter().any(Option::is_some).then_some(&self.tangent)
    }
}

/// Quantities to be computed in addition to energy and gradient.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Request {
    pub(crate) tangent: bool,
    pub(crate) zones: bool,
}

/// Energy and forces of one candidate pair on the control points of both segments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairForce {
    /// Energy \[F·L\], with either segment as the slave.
    pub(crate) energy: f64,
    /// Smallest gap \[L\]; infinite if the pair is not in contact.
    pub(crate) min_gap: f64,
    /// −∂U/∂(control points) of i and of j \[F\]; a straight segment has its two ends as the first and last entry.
    pub(crate) force: [[Vec3; 4]; 2],
}

impl PairForce {
    pub(crate) const NONE: Self =
        Self { energy: 0.0, min_gap: f64::INFINITY, force: [[Vec3::new(0.0, 0.0, 0.0); 4]; 2] };

    /// Adds a term; `swapped` if its slave is j.
    pub(super) fn add_term(&mut self, strands: &Strands, term: &PairTerm, swapped: bool) {
        self.energy += term.energy;
        self.min_gap = term.zones.iter().map(|zone| zone.min_gap).fold(self.min_gap, f64::min);
        let ends = term.point_gradient();
        for (side, segment) in [term.slave, term.master].into_iter().enumerate() {
            let force = &mut self.force[side ^ usize::from(swapped)];
            if strands.is_straight(segment) {
                force[0] -= ends[2 * side];
                force[3] -= ends[2 * side + 1];
            } else {
                (0..4).for_each(|m| force[m] -= term.gradient[4 * side + m]);
            }
        }
    }
}
