//! Screened repulsion of line charges (Debye–Hückel): an energy of all pairs of points within range, beside the contact
//! law.
//!
//! ```text
//! U = ½ ∫∫ w(s,t) A exp(−r/λ)/r S(r) ds dt        r = |r(s) − r(t)|, λ the Debye length
//! ```
//!
//! A contact zone holds nearest points only, and a potential with a range needs more than these: this is a double sum
//! over Gauss points of pairs of segments, found by the broad phase. Gradient and tangent are the derivatives of the
//! sum itself.
//!
//! **Range.** S falls from 1 to 0, twice differentiable, between 9 and [`RANGE`] = 10 Debye lengths. This cut-off
//! removes 0.2 % of the energy of two parallel strands five Debye lengths apart, 7e-5 at two Debye lengths, and a
//! fraction exp(d/λ − 9) at a crossing at a distance d.
//!
//! **Neighbours along the strand.** The contact law excludes points with less than a right angle of turning between
//! them, so a straight or gently bent rod does not touch itself. That limit moves with the shape, and a potential with
//! a range would jump there. Here the weight w is a function of the reference arc length between the points: 0 up to 4
//! Debye lengths (at least a segment), 1 from 8. Nearer points contribute to the measured bending stiffness: at most 7
//! % of the electrostatic stiffening A λ²/4 of Odijk, Skolnick and Fixman is counted twice. The energy of points of one
//! curve is that beyond the straight rod, so a straight rod has none.
//!
//! **Quadrature.** Three Gauss points on each piece of 0.75 contact distances, or two Debye lengths if that is less
//! (`scene::Electrostatics::piece`): the energy of strands that touch is known to 1e-4.

use super::broad_phase::BroadPhase;
use super::curve::CurveSet;
use super::curves::input::Strands;
use super::exclusion::Exclusion;
use super::law::potential::Hessian;
use super::law::potential::stiffness::{Coordinates, PairStiffness, PairTangent};
use crate::error::InputError;
use crate::math::bernstein::cubic_weights;
use crate::math::parallel::DEAR;
use crate::math::quadrature::gauss;
use crate::math::{Mat3, Vec3, parallel};

/// Range of the potential, in Debye lengths, because a cut-off there removes 7e-5 of the energy of parallel strands two
/// Debye lengths apart. The potential is switched off over the last Debye length.
pub const RANGE: f64 = 10.0;
/// Arc length, in Debye lengths, where the weight of points of one curve begins to rise from 0, because the measured
/// bending stiffness contains the repulsion of nearer points. It reaches 1 at twice this.
const NEIGHBOURS: f64 = 4.0;
/// Movement of nodes, in Debye lengths, after which pairs are searched again, because a longer list costs more than a
/// search.
const MARGIN: f64 = 0.5;

/// Energy A exp(−r/λ)/r of two points per product of their lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screened {
    /// A \[F\]: kT × Bjerrum length × (charges per length)².
    pub strength: f64,
    /// λ \[L\].
    pub debye_length: f64,
}

/// Energy of two points and its derivatives by their distance.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PairEnergy {
    /// Energy per product of lengths \[F/L\].
    pub energy: f64,
    /// Its slope \[F/L²\]; negative: repulsion.
    pub slope: f64,
    /// Its second derivative \[F/L³\].
    pub curvature: f64,
}

impl PairEnergy {
    fn times(self, weight: f64) -> Self {
        Self { energy: weight * self.energy, slope: weight * self.slope, curvature: weight * self.curvature }
    }
}

impl Screened {
    /// The energy of points at a distance r > 0 \[L\], switched off at the end of the range.
    #[must_use]
    pub fn at(&self, r: f64) -> PairEnergy {
        let x = r / self.debye_length;
        if x >= RANGE {
            return PairEnergy::default();
        }
        let (inverse, per) = (1.0 / r, 1.0 / self.debye_length);
        let energy = self.strength * (-x).exp() * inverse;
        let decay = per + inverse;
        let slope = -energy * decay;
        let curvature = energy * (decay * decay + inverse * inverse);
        if x <= RANGE - 1.0 {
            return PairEnergy { energy, slope, curvature };
        }
        let [s, ds, dds] = smooth_step(RANGE - x);
        let (ds, dds) = (ds * -per, dds * per * per);
        PairEnergy {
            energy: energy * s,
            slope: slope * s + energy * ds,
            curvature: curvature * s + 2.0 * slope * ds + energy * dds,
        }
    }
}

/// 10 t³ − 15 t⁴ + 6 t⁵ and its first two derivatives; t is clamped to \[0, 1\].
fn smooth_step(t: f64) -> [f64; 3] {
    let t = t.clamp(0.0, 1.0);
    let left = 1.0 - t;
    [t * t * t * (10.0 - 15.0 * t + 6.0 * t * t), 30.0 * t * t * left * left, 60.0 * t * left * (1.0 - 2.0 * t)]
}

/// A Gauss point of the segments of a curve: parameter, weight × reference length \[L\], shape functions of the control
/// points.
#[derive(Debug, Clone, Copy)]
struct GaussPoint {
    u: f64,
    weight: f64,
    shape: [f64; 4],
}

/// Contribution of one pair of segments. The coordinates are displacement and rotation vector of the four ends, as for
/// contact.
pub(crate) struct Term {
    pub(crate) segments: [usize; 2],
    pub(crate) energy: f64,
    pub(crate) gradient: [f64; 24],
    pub(crate) tangent: Option<Box<PairTangent>>,
}

/// The repulsion of the strands of a set.
#[derive(Debug)]
pub(crate) struct Repulsion {
    law: Screened,
    /// Per curve.
    points: Vec<Vec<GaussPoint>>,
    /// Per curve: arc lengths between which points cease to be neighbours \[L\].
    neighbours: Vec<[f64; 2]>,
    exclusion: Exclusion,
    broad_phase: BroadPhase,
}

impl Repulsion {
    /// For a set whose segments have equal reference lengths along each curve; three Gauss points on each piece of at
    /// most the length `piece` \[L\].
    pub(crate) fn new(law: Screened, set: &CurveSet, piece: f64) -> Self {
        let length = |curve: usize| set.lengths[set.curves[curve].first];
        let points = (0..set.curves.len()).map(|curve| points(length(curve), piece)).collect();
        let neighbours: Vec<[f64; 2]> = (0..set.curves.len())
            .map(|curve| {
                let start = (NEIGHBOURS * law.debye_length).max(length(curve));
                [start, 2.0 * start]
            })
            .collect();
        // segments whose points are all neighbours
        let skipped = |curve: usize| (neighbours[curve][0] / length(curve)).floor() as usize - 1;
        let num = (0..set.curves.len()).map(skipped).min().unwrap_or(0);
        let mut exclusion = Exclusion::new();
        exclusion.update_by_count(&Strands::of_set(set), num);
        Self { law, points, neighbours, exclusion, broad_phase: BroadPhase::new() }
    }

    /// Searches pairs again if the present ones may be incomplete.
    pub(crate) fn update(&mut self, set: &CurveSet) -> Result<(), InputError> {
        let (range, margin) = (RANGE * self.law.debye_length, MARGIN * self.law.debye_length);
        self.broad_phase.candidates(set, &self.exclusion, range, margin).map(|_| ())
    }

    /// Forgets the pairs: the next search is a fresh one.
    pub(crate) fn forget(&mut self) {
        self.broad_phase = BroadPhase::new();
    }

    /// Pairs of segments within range, and some beyond.
    pub(crate) fn pairs(&self) -> &[[u32; 2]] {
        self.broad_phase.pairs()
    }

    /// Increments each time the pairs change.
    pub(crate) fn generation(&self) -> u64 {
        self.broad_phase.generation()
    }

    /// The terms of some of the pairs, in their order.
    pub(crate) fn terms(&self, set: &CurveSet, pairs: &[[u32; 2]], tangent: bool) -> Vec<Vec<Term>> {
        parallel::map_ranges(pairs.len(), DEAR, &|range| {
            let term = |pair: &[u32; 2]| self.term(set, pair.map(|k| k as usize), tangent);
            pairs[range].iter().filter_map(term).collect()
        })
    }

    fn term(&self, set: &CurveSet, [i, j]: [usize; 2], tangent: bool) -> Option<Term> {
        let range = RANGE * self.law.debye_length;
        let origin = set.segments[i].b[0];
        let (a, b) = (set.segments[i].relative_to(&origin), set.segments[j].relative_to(&origin));
        let mut sum = Sum { energy: 0.0, gradient: [Vec3::zeros(); 8], hessian: tangent.then(Default::default) };
        let mut felt = false;
        for p in &self.points[set.curve_of(i)] {
            let x = a.point(p.u);
            let mut here = PointSums::default();
            for q in &self.points[set.curve_of(j)] {
                let Some((weight, straight)) = self.weight(set, [i, j], [p.u, q.u]) else { continue };
                let weight = weight * p.weight * q.weight;
                sum.energy -= weight * straight;
                felt |= straight != 0.0;
                let between = x - b.point(q.u);
                if between.norm_squared() < range * range {
                    felt = true;
                    sum.add(&between, self.law.at(between.norm()).times(weight), q, &mut here);
                }
            }
            sum.close(p, &here);
        }
        felt.then(|| {
            let coordinates = Coordinates::ends(&a, &b);
            let blocks = |hessian: Box<Hessian>| {
                let mut tangent: Box<PairTangent> = Box::new([[0.0; 24]; 24]);
                let mut stiffness = PairStiffness::new(coordinates, &mut tangent);
                stiffness.add_hessian(&hessian);
                stiffness.add_gradient(&sum.gradient);
                stiffness.finish();
                tangent
            };
            Term {
                segments: [i, j],
                energy: sum.energy,
                gradient: coordinates.pull(&sum.gradient),
                tangent: sum.hessian.map(blocks),
            }
        })
    }

    /// Weight of two points, and the energy that they have on a straight rod; `None` if they are neighbours.
    fn weight(&self, set: &CurveSet, [i, j]: [usize; 2], [u, v]: [f64; 2]) -> Option<(f64, f64)> {
        let curve = set.curve_of(i);
        if curve != set.curve_of(j) {
            return Some((1.0, 0.0));
        }
        let straight = (set.arc_length(i, u) - set.arc_length(j, v)).abs();
        let arc = set.period(curve).map_or(straight, |period| straight.min(period - straight));
        let [start, end] = self.neighbours[curve];
        (arc > start).then(|| (smooth_step((arc - start) / (end - start))[0], self.law.at(arc).energy))
    }
}

/// Contribution of the points of a pair of segments, with respect to the control points.
struct Sum {
    energy: f64,
    gradient: [Vec3; 8],
    hessian: Option<Box<Hessian>>,
}

/// Sums over the points of j for one point of i: forces on it, second derivatives, and these times the shape functions
/// of j.
#[derive(Default)]
struct PointSums {
    push: Vec3,
    second: Mat3,
    mixed: [Mat3; 4],
}

impl Sum {
    /// Adds the energy of a pair of points: `between` from the point q of j to that of i.
    fn add(&mut self, between: &Vec3, pair: PairEnergy, q: &GaussPoint, here: &mut PointSums) {
        let r = between.norm();
        self.energy += pair.energy;
        // coincident points have no direction: their energy is infinite, which a search rejects
        let normal = between / r;
        let push = normal * pair.slope;
        here.push += push;
        (0..4).for_each(|n| self.gradient[4 + n] -= push * q.shape[n]);
        let Some(hessian) = &mut self.hessian else { return };
        let sideways = pair.slope / r;
        let second = normal * normal.transpose() * (pair.curvature - sideways) + Mat3::from_diagonal_element(sideways);
        here.second += second;
        for n in 0..4 {
            let part = second * q.shape[n];
            here.mixed[n] += part;
            (n..4).for_each(|k| hessian[4 + n][4 + k] += part * q.shape[k]);
        }
    }

    /// Adds the sums for the point p of i.
    fn close(&mut self, p: &GaussPoint, here: &PointSums) {
        (0..4).for_each(|m| self.gradient[m] += here.push * p.shape[m]);
        let Some(hessian) = &mut self.hessian else { return };
        for m in 0..4 {
            (m..4).for_each(|k| hessian[m][k] += here.second * (p.shape[m] * p.shape[k]));
            (0..4).for_each(|n| hessian[m][4 + n] -= here.mixed[n] * p.shape[m]);
        }
    }
}

/// Gauss points of a segment of this length in equal parts no longer than `piece`.
fn points(length: f64, piece: f64) -> Vec<GaussPoint> {
    let parts = (length / piece).ceil().max(1.0);
    let rule = gauss(3);
    let of_part = |part: usize| {
        rule.points.iter().zip(rule.weights).map(move |(x, w)| {
            let u = (part as f64 + x) / parts;
            GaussPoint { u, weight: w * length / parts, shape: cubic_weights(u) }
        })
    };
    (0..parts as usize).flat_map(of_part).collect()
}

#[cfg(test)]
mod tests;
