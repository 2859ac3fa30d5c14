//! The integral over pieces of zones: quadrature points, and their contributions to a term.

use super::guess::Interpolation;
use super::pressure::{PairLaw, without_limit};
use super::stiffness::{Coordinates, PairStiffness};
use super::term::{PairForce, PairTerm, QuadraturePoint, Request, Want, ZonePiece};
use crate::contact::curves::curve::Cubic;
use crate::contact::measures::{MAX_PARTS, POINTS_PER_PART};
use crate::contact::zones::straight::Lines;
use crate::contact::zones::{Branch, BranchPiece, FootKind, Projection};
use crate::math::bernstein::{cubic_slopes, cubic_weights};
use crate::math::quadrature::gauss;
use crate::math::{Mat3, Vec3};

/// Longest pieces of straight pairs, in contact distances, that fewer points integrate as well, and the number of
/// these, because polylines have many short pieces.
const FEWER_POINTS: [(f64, usize); 2] = [(1.0 / 32.0, 2), (0.25, 3)];
/// Parts that a piece through a fold is divided into, because it runs forth and back on the slave.
const PARTS_OF_FOLD: f64 = 4.0;

/// The integral over the contact of one ordered pair.
pub(super) struct PairIntegral<'a> {
    pub(super) slave: usize,
    pub(super) master: usize,
    pub(super) pair_law: &'a PairLaw<'a>,
    pub(super) pieces: &'a [BranchPiece],
    pub(super) project: &'a Projector<'a>,
    /// The slave, relative to its start.
    pub(super) own: Cubic,
}

/// The projection at a parameter t of a branch, from a guess of the other parameter, and du/dt, u the slave's
/// parameter; negative where the branch is subtracted.
pub(super) type Projector<'a> = dyn Fn(f64, f64, &Branch) -> (Projection, f64) + 'a;

impl PairIntegral<'_> {
    pub(super) fn pair_term(&self, want: Want) -> PairTerm {
        let request = Request { zones: true, tangent: false };
        if want == Want::Gradient {
            return self.sum(request, None);
        }
        let mut sum = [[0.0; 24]; 24];
        let mut stiffness = PairStiffness::new(Coordinates::Points, &mut sum);
        let mut term = self.sum(request, Some(&mut stiffness));
        stiffness.finish();
        term.hessian = Some({
            let block = |m: usize, n: usize| Mat3::from_fn(|i, j| if m <= n { sum[3 * m + i][3 * n + j] } else { 0.0 });
            Box::new(std::array::from_fn(|m| std::array::from_fn(|n| block(m, n))))
        });
        term
    }

    /// The integral over the pieces, its second derivative in `stiffness`; with the tangent, the points in contact.
    pub(super) fn sum(&self, request: Request, stiffness: Option<&mut PairStiffness>) -> PairTerm {
        let term = PairTerm {
            slave: self.slave,
            master: self.master,
            energy: 0.0,
            gradient: [Vec3::zeros(); 8],
            hessian: None,
            zones: Vec::new(),
            points: Vec::new(),
        };
        let mut sums = PairSums { term, stiffness };
        for piece in self.pieces {
            // w∫p uᵏ ds, w the slave's share
            let mut moments = [0.0; 3];
            let (mut pushed, mut torque) = (Vec3::zeros(), Vec3::zeros());
            let kind = piece.branch.kind;
            self.pair_law.integrate(piece, |t, guess, weight| {
                let (projection, rate) = (self.project)(t, guess, &piece.branch);
                let weight = weight * rate;
                let force = weight * self.pair_law.add_point(&mut sums, kind, &projection, weight);
                // farthest points, which are subtracted, are not needed later
                if request.tangent && weight > 0.0 {
                    let (law, carried) = self.pair_law.response(projection.u, projection.distance);
                    let known = carried > 0.0 && law.stiffness.is_finite();
                    let point =
                        QuadraturePoint { u: projection.u, v: projection.v, kind, stiffness: weight * law.stiffness };
                    sums.term.points.extend(known.then_some(point));
                }
                moments[0] += force;
                moments[1] += force * projection.u;
                moments[2] += force * projection.u * projection.u;
                if projection.distance > 0.0 {
                    let push = projection.normal * force;
                    pushed += push;
                    torque += self.own.point(projection.u).cross(&push);
                }
                if kind == FootKind::Fold { projection.u } else { projection.v }
            });
            if request.zones {
                let [force, first, second] = moments;
                let min_gap = piece.nearest.distance - self.pair_law.contact_distance;
                let piece = piece.ascending();
                sums.term.zones.push(ZonePiece {
                    piece,
                    min_gap,
                    force,
                    moments: [first, second],
                    push: pushed,
                    torque,
                });
            }
        }
        if let Some(stiffness) = sums.stiffness {
            stiffness.add_gradient(&sums.term.gradient);
        }
        sums.term
    }
}

/// Energy and derivatives of a pair, summed over the points of its quadrature.
struct PairSums<'a, 'b> {
    term: PairTerm,
    /// Second derivatives, if wanted.
    stiffness: Option<&'a mut PairStiffness<'b>>,
}

impl PairLaw<'_> {
    /// Calls `add(t, guess of the other parameter, weight)` for the points of the quadrature w∫dt, w the slave's share,
    /// of a piece with the parameter t. `add` returns the other parameter. Long pieces are divided into parts shorter
    /// than the contact distance. Guesses interpolate between the ends of the piece and the parameters returned.
    fn integrate(&self, piece: &BranchPiece, mut add: impl FnMut(f64, f64, f64) -> f64) {
        let [t, other] = piece.along();
        let width = t[1] - t[0];
        let extent = width * self.span / self.contact_distance;
        let parts = match piece.branch.kind {
            FootKind::Fold => PARTS_OF_FOLD,
            _ => extent.ceil().clamp(1.0, MAX_PARTS),
        };
        let points = FEWER_POINTS.iter().find(|(longest, _)| self.straight && extent <= *longest);
        let rule = gauss(points.map_or(POINTS_PER_PART, |(_, points)| *points));
        let mut last = [t[0], other[0]];
        for part in 0..parts as usize {
            let mut known = Interpolation::<{ POINTS_PER_PART + 2 }>::between(last, [t[1], other[1]]);
            for (&x, &w) in rule.points.iter().zip(rule.weights) {
                let t = t[0] + width * (part as f64 + x) / parts;
                let other = add(t, known.at(t), self.share * w * width * self.length / parts);
                known.add(t, other);
                last = [t, other];
            }
        }
    }

    /// Adds weight × the law at one point; returns the pressure.
    fn add_point(&self, sums: &mut PairSums, kind: FootKind, projection: &Projection, weight: f64) -> f64 {
        let PairSums { term, stiffness } = sums;
        let Projection { u, v, distance, normal, tangent: db, curvature: ddb } = *projection;
        let (law, carried) = self.response(u, distance);
        if carried == 0.0 || without_limit(&law, weight) {
            return 0.0;
        }
        term.energy += weight * law.energy;
        // Where the centrelines cross, the force has no direction.
        if distance == 0.0 {
            return law.pressure;
        }
        let (wa, wb) = (cubic_weights(u), cubic_weights(v));
        let w: [f64; 8] = std::array::from_fn(|m| if m < 4 { wa[m] } else { -wb[m - 4] });
        let push = normal * (weight * law.pressure);
        for m in 0..8 {
            term.gradient[m] -= push * w[m];
        }
        let Some(stiffness) = stiffness else { return law.pressure };
        let over_d = carried / distance;
        stiffness.add_product(&w.map(|w| normal * w), weight * (law.stiffness + over_d));
        stiffness.subtract_spread(&w, weight * over_d);
        if matches!(kind, FootKind::Orthogonal | FootKind::Fold) {
            let d_vv = db.norm_squared() / distance - normal.dot(&ddb);
            let slopes = cubic_slopes(v);
            let along = db / -distance;
            let motion_of_foot = |m: usize| if m < 4 { along * w[m] } else { along * w[m] - normal * slopes[m - 4] };
            stiffness.add_product(&std::array::from_fn(motion_of_foot), weight * carried / d_vv);
        }
        law.pressure
    }
}

impl PairForce {
    /// Adds one piece of a pair of lines; `swapped` if the slave is j.
    pub(super) fn add_lines(&mut self, lines: &Lines, piece: &BranchPiece, pair_law: &PairLaw, swapped: bool) {
        // ∫p n ds, and the same weighted by u and by v
        let (mut plain, mut at_u, mut at_v) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
        pair_law.integrate(piece, |u, _, weight| {
            let (projection, sign) = lines.project(u, &piece.branch);
            let weight = weight * sign;
            let (law, _) = pair_law.response(u, projection.distance);
            if without_limit(&law, weight) {
                return projection.v;
            }
            self.energy += weight * law.energy;
            let push = projection.normal * (weight * law.pressure);
            plain += push;
            at_u += push * u;
            at_v += push * projection.v;
            projection.v
        });
        self.min_gap = self.min_gap.min(piece.nearest.distance - pair_law.contact_distance);
        let [own, other] = if swapped { [1, 0] } else { [0, 1] };
        self.force[own][0] += plain - at_u;
        self.force[own][3] += at_u;
        self.force[other][0] -= plain - at_v;
        self.force[other][3] -= at_v;
    }
}
