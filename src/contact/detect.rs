//! From candidate pairs to terms of the contact potential: energy, gradient and symmetric Hessian with respect to the
//! control points of both cubics, and the zones for reports.
//!
//! ```text
//! U = Σ_ordered pairs ½ ∫_zone ½ κ ⟨c(s) − gap(s)⟩² ds        gap = |a(u) − b(v(u))| − ε_a − ε_b
//! ```
//!
//! Each strand integrates over its own length with factor ½. With d the distance at the foot, n the unit normal from foot
//! to slave point, w_m the eight Bernstein weights (minus on the master):
//! δd = n·Σ w_m δx_m (envelope theorem), and ∇²d = (I − n⊗n)/d on w_m w_n minus q⊗q/d_vv, the Schur complement of the foot.

use rayon::prelude::*;

use super::capsule::Capsule;
use super::curve::CurveSet;
use super::law::{Law, Response};
use super::zone::{FootKind, Joint, Pair, Piece, Sample};
use crate::math::quadrature::gauss;
use crate::math::{Mat3, Vec3};

/// Points of the Gauss rule on each piece of a zone.
const POINTS_PER_PIECE: usize = 5;

/// Hessian with respect to eight control points (slave 0..4, master 4..8): blocks m ≤ n filled.
pub type Hessian = [[Mat3; 8]; 8];

/// One piece of a contact zone, for reports and multiplier updates.
#[derive(Debug, Clone, Copy)]
pub struct ZonePiece {
    /// Geometry of the piece.
    pub piece: Piece,
    /// Smallest gap inside \[L\].
    pub min_gap: f64,
    /// ½∫p ds \[F\]: this strand's half of the contact force.
    pub half_force: f64,
    /// ½∫p u ds and ½∫p u² ds \[F\], u the slave parameter: where in the piece the force sits.
    pub half_moments: [f64; 2],
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
    /// Symmetric Hessian \[F/L\]; empty unless asked for.
    pub hessian: Option<Box<Hessian>>,
    /// Zones of this pair.
    pub zones: Vec<ZonePiece>,
}

impl PairTerm {
    /// The gradient with respect to the ends of two *straight* segments: slave's start and end, master's start and end \[F\].
    #[must_use]
    pub fn point_gradient(&self) -> [Vec3; 4] {
        let ends = |g: &[Vec3]| [g[0] + (g[1] * 2.0 + g[2]) / 3.0, (g[1] + g[2] * 2.0) / 3.0 + g[3]];
        let ([a0, a1], [b0, b1]) = (ends(&self.gradient[..4]), ends(&self.gradient[4..]));
        [a0, a1, b0, b1]
    }
}

/// What [`evaluate`] computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Want {
    /// Energy, gradient, zones.
    Gradient,
    /// Also the Hessian.
    Hessian,
}

/// Offsets c at both ends of a segment \[L\].
pub type Offsets<'a> = dyn Fn(usize) -> [f64; 2] + Sync + 'a;

/// What decides over pressures.
#[derive(Clone, Copy)]
pub(crate) struct Pressures<'a> {
    pub(crate) law: Law,
    pub(crate) offset: &'a Offsets<'a>,
    /// The law that the present pressures come from, if it has just been replaced: they are kept, and linearised is the new law about
    /// the overlap at which it has the same pressure. A Newton step then moves the strands there.
    pub(crate) before: Option<(Law, &'a Offsets<'a>)>,
}

/// Terms of all candidate pairs in contact, both ways round, in the order of the candidates (slave i, master j first).
///
/// `offset(segment)` is the offset c at both ends of a segment \[L\] (0 for a plain penalty). Parallel over candidates in the current rayon
/// pool; the result does not depend on the number of threads.
pub fn evaluate(set: &CurveSet, candidates: &[[u32; 2]], law: Law, offset: &Offsets, want: Want) -> Vec<PairTerm> {
    evaluate_within(set, &capsules_of(set), candidates, &Pressures { law, offset, before: None }, want)
}

/// Capsules of all segments.
pub(crate) fn capsules_of(set: &CurveSet) -> Vec<Capsule> {
    set.segments.par_iter().with_min_len(256).map(Capsule::new).collect()
}

/// [`evaluate`] with the capsules at hand, for callers that go through the candidates in parts.
pub(crate) fn evaluate_within(
    set: &CurveSet,
    capsules: &[Capsule],
    candidates: &[[u32; 2]],
    pressures: &Pressures,
    want: Want,
) -> Vec<PairTerm> {
    const CHUNK: usize = 64;
    candidates
        .par_chunks(CHUNK)
        .flat_map_iter(|chunk| {
            let mut found = Vec::new();
            let mut pieces = Vec::new();
            for &[i, j] in chunk {
                let (i, j) = (i as usize, j as usize);
                let nearest = capsules[i].distance_lower_bound(&capsules[j]);
                for (slave, master) in [(i, j), (j, i)] {
                    let contact_distance = set.radius_of(slave) + set.radius_of(master);
                    let reaching = pressures.before.map_or(pressures.offset, |(_, offset)| offset);
                    let reach = reaching(slave).map(|c| contact_distance + c);
                    if nearest >= reach[0].max(reach[1]) {
                        continue;
                    }
                    // Near the origin: far from it the ends of zones would be lost in rounding, and looked for in vain. The same origin for
                    // every master, so that two that meet at a joint find the same bits there.
                    let near = |k: usize| set.segments[k].relative_to(&set.segments[slave].b[0]);
                    let (own, foreign) = (near(slave), near(master));
                    let (before, after) = (set.prev(master), set.next(master));
                    let pair = Pair {
                        slave: &own,
                        master: &foreign,
                        open_start: before.is_none(),
                        open_end: after.is_none(),
                        reach,
                        joints: Joint::both(before.map(near), &foreign, after.map(near)),
                    };
                    pieces.clear();
                    pair.pieces(&mut pieces);
                    if !pieces.is_empty() {
                        found.push(pair_term(set, slave, master, &pair, &pieces, pressures, want));
                    }
                }
            }
            found
        })
        .collect()
}

fn pair_term(
    set: &CurveSet,
    slave: usize,
    master: usize,
    pair: &Pair,
    pieces: &[Piece],
    pressures: &Pressures,
    want: Want,
) -> PairTerm {
    let mut term = PairTerm {
        slave,
        master,
        energy: 0.0,
        gradient: [Vec3::zeros(); 8],
        hessian: (want == Want::Hessian).then(|| Box::new([[Mat3::zeros(); 8]; 8])),
        zones: Vec::with_capacity(pieces.len()),
    };
    let length = set.lengths[slave];
    let contact_distance = set.radius_of(slave) + set.radius_of(master);
    let local = Local { pressures, contact_distance, offset: (pressures.offset)(slave) };
    for piece in pieces {
        let [half_force, first, second] = integrate(&mut term, pair, piece, length, &local);
        let min_gap = piece.nearest.distance - contact_distance;
        term.zones.push(ZonePiece { piece: *piece, min_gap, half_force, half_moments: [first, second] });
    }
    term
}

/// Integrates one piece and returns ½∫p uᵏ ds for k = 0, 1, 2; long pieces are divided so that each part is shorter than the
/// contact distance.
fn integrate(term: &mut PairTerm, pair: &Pair, piece: &Piece, length: f64, local: &Local) -> [f64; 3] {
    let rule = gauss(POINTS_PER_PIECE);
    let width = piece.u[1] - piece.u[0];
    let parts = (width * length / local.contact_distance).ceil().clamp(1.0, 64.0);
    let mut moments = [0.0; 3];
    for part in 0..parts as usize {
        for (&x, &w) in rule.points.iter().zip(rule.weights) {
            let fraction = (part as f64 + x) / parts;
            let guess = piece.v[0] + (piece.v[1] - piece.v[0]) * fraction;
            let sample = pair.sample(piece.u[0] + width * fraction, guess, piece.kind);
            let weight = 0.5 * w * width * length / parts;
            let force = weight * add_sample(term, pair, piece.kind, &sample, weight, local);
            moments[0] += force;
            moments[1] += force * sample.u;
            moments[2] += force * sample.u * sample.u;
        }
    }
    moments
}

/// The laws on one slave segment.
struct Local<'a> {
    pressures: &'a Pressures<'a>,
    contact_distance: f64,
    offset: [f64; 2],
}

impl Local<'_> {
    /// The response at a sample and the pressure that the geometric stiffness belongs to.
    fn response(&self, pair: &Pair, sample: &Sample) -> (Response, f64) {
        let between = |ends: [f64; 2]| ends[0] + (ends[1] - ends[0]) * sample.u;
        let law = &self.pressures.law;
        let Some((before, _)) = self.pressures.before else {
            let response = law.response(between(pair.reach) - sample.distance, self.contact_distance);
            return (response, response.pressure);
        };
        let pressure = before.response(between(pair.reach) - sample.distance, self.contact_distance).pressure;
        let overlap = law.overlap(pressure, self.contact_distance);
        let there = law.response(overlap, self.contact_distance);
        let way = self.contact_distance + between(self.offset) - sample.distance - overlap;
        let response = Response {
            energy: there.energy + (pressure + 0.5 * there.stiffness * way) * way,
            pressure: pressure + there.stiffness * way,
            stiffness: there.stiffness,
        };
        (response, pressure)
    }
}

fn bernstein_weights(u: f64) -> [f64; 4] {
    let t = 1.0 - u;
    [t * t * t, 3.0 * t * t * u, 3.0 * t * u * u, u * u * u]
}

fn bernstein_slopes(u: f64) -> [f64; 4] {
    let t = 1.0 - u;
    [-3.0 * t * t, 3.0 * t * (t - 2.0 * u), 3.0 * u * (2.0 * t - u), 3.0 * u * u]
}

/// Adds weight × the law at one sample; returns the pressure.
fn add_sample(term: &mut PairTerm, pair: &Pair, kind: FootKind, sample: &Sample, weight: f64, local: &Local) -> f64 {
    let (law, carried) = local.response(pair, sample);
    if carried == 0.0 {
        return 0.0;
    }
    let (b, db, ddb) = pair.master.derivatives(sample.v);
    let normal = (pair.slave.point(sample.u) - b) / sample.distance;
    let (wa, wb) = (bernstein_weights(sample.u), bernstein_weights(sample.v));
    let w: [f64; 8] = std::array::from_fn(|m| if m < 4 { wa[m] } else { -wb[m - 4] });
    term.energy += weight * law.energy;
    for m in 0..8 {
        term.gradient[m] -= normal * (weight * law.pressure * w[m]);
    }
    let Some(hessian) = term.hessian.as_deref_mut() else { return law.pressure };
    let nn = normal * normal.transpose();
    let over_d = carried / sample.distance;
    let plain = (nn * (law.stiffness + over_d) - Mat3::identity() * over_d) * weight;
    let schur = match kind {
        FootKind::Orthogonal => {
            let d_vv = db.norm_squared() / sample.distance - normal.dot(&ddb);
            let slopes = bernstein_slopes(sample.v);
            let q: [Vec3; 8] = std::array::from_fn(|m| {
                let along = db * (-w[m] / sample.distance);
                if m < 4 { along } else { along - normal * slopes[m - 4] }
            });
            Some((q, weight * carried / d_vv))
        }
        FootKind::Start | FootKind::End => None,
    };
    for m in 0..8 {
        for n in m..8 {
            hessian[m][n] += plain * (w[m] * w[n]);
            if let Some((q, factor)) = &schur {
                hessian[m][n] += (q[m] * *factor) * q[n].transpose();
            }
        }
    }
    law.pressure
}

#[cfg(test)]
mod tests {
    use super::super::curve::Cubic;
    use super::*;

    /// Moves the control points of both cubics.
    fn moved(a: &Cubic, b: &Cubic, dof: usize, step: f64) -> (Cubic, Cubic) {
        let (mut a, mut b) = (*a, *b);
        let (m, k) = (dof / 3, dof % 3);
        if m < 4 {
            a.b[m][k] += step;
        } else {
            b.b[m - 4][k] += step;
        }
        (a, b)
    }

    fn term(a: &Cubic, b: &Cubic, open_end: bool, reach: [f64; 2]) -> PairTerm {
        let mut term = PairTerm {
            slave: 0,
            master: 1,
            energy: 0.0,
            gradient: [Vec3::zeros(); 8],
            hessian: Some(Box::new([[Mat3::zeros(); 8]; 8])),
            zones: Vec::new(),
        };
        let pair = Pair { slave: a, master: b, open_start: false, open_end, reach, joints: [None; 2] };
        let mut pieces = Vec::new();
        pair.pieces(&mut pieces);
        assert!(!pieces.is_empty());
        let pressures = Pressures { law: Law::Linear { stiffness: 1e3 }, offset: &|_| [0.0; 2], before: None };
        let local = Local { pressures: &pressures, contact_distance: 0.05, offset: [0.0; 2] };
        for piece in &pieces {
            integrate(&mut term, &pair, piece, 1.3, &local);
        }
        term
    }

    /// Gradient and Hessian of the integrated potential, moving zone ends included, against finite differences: crossing,
    /// grazing and end-cap contacts.
    #[test]
    fn derivatives_of_the_cut_integral_match_finite_differences() {
        let v = Vec3::new;
        let crossing = (
            Cubic { b: [v(-0.9, 0.1, 0.2), v(-0.3, 0.0, 0.26), v(0.3, 0.05, 0.24), v(1.0, 0.0, 0.3)] },
            Cubic { b: [v(-0.8, -0.5, 0.0), v(-0.2, -0.3, 0.05), v(0.2, 0.2, -0.02), v(0.6, 0.7, 0.0)] },
        );
        let grazing = (
            Cubic { b: [v(-0.9, 0.0, 0.32), v(-0.3, 0.02, 0.24), v(0.3, 0.05, 0.24), v(1.0, 0.0, 0.31)] },
            Cubic { b: [v(-1.2, 0.05, 0.0), v(-0.3, 0.0, 0.0), v(0.3, 0.05, 0.02), v(1.3, 0.0, 0.0)] },
        );
        let capped = (
            Cubic { b: [v(-0.9, 0.0, 0.2), v(-0.3, 0.02, 0.2), v(0.3, 0.05, 0.2), v(1.0, 0.0, 0.2)] },
            Cubic { b: [v(-0.1, -1.0, 0.0), v(0.0, -0.7, 0.0), v(0.0, -0.3, 0.02), v(0.1, -0.05, 0.0)] },
        );
        for (name, (a, b), open) in
            [("crossing", crossing, false), ("grazing", grazing, false), ("capped", capped, true)]
        {
            let reach = [0.29, 0.31];
            let base = term(&a, &b, open, reach);
            let hessian = base.hessian.as_deref().unwrap();
            let h = 1e-5;
            for dof in 0..24 {
                let shifted = |step: f64| {
                    let (a, b) = moved(&a, &b, dof, step);
                    term(&a, &b, open, reach)
                };
                let (plus, minus) = (shifted(h), shifted(-h));
                let slope = (plus.energy - minus.energy) / (2.0 * h);
                let ours = base.gradient[dof / 3][dof % 3];
                assert!((slope - ours).abs() < 1e-5 * (1.0 + ours.abs()), "{name} dof {dof}: {slope} {ours}");
                for other in dof..24 {
                    let (m, n) = (dof / 3, other / 3);
                    let difference = (plus.gradient[n][other % 3] - minus.gradient[n][other % 3]) / (2.0 * h);
                    let ours = if m == n && other < dof { 0.0 } else { hessian[m][n][(dof % 3, other % 3)] };
                    assert!(
                        (difference - ours).abs() < 2e-4 * (10.0 + ours.abs()),
                        "{name} ({dof},{other}): {difference} {ours}"
                    );
                }
            }
        }
    }
}
