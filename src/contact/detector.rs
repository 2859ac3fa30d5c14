//! The detector: curves in, contact sites and zones out.

mod forces;
mod minima;

use crate::contact::curves::curve::{Cubic, CurveInput, CurveSet, norm};
use crate::contact::curves::input::{Curve, JOINT, Strands};
use crate::contact::law::potential::PairForce;
use crate::contact::measures::SUM_ROUNDING;
use crate::contact::options::{DetectorOptions, Neighbours};
use crate::contact::sites::site::{Minimum, Site};
use crate::contact::tree::broad_phase::BroadPhase;
use crate::contact::tree::exclusion::{Exclusion, bytes};
use crate::contact::zones::interval::{self, Part, PartSearch, Zone};
use crate::error::{InputError, SolveError};
use crate::math::parallel::CHEAP;
use crate::math::quadrature::gauss;
use crate::math::{Vec3, parallel};

pub use forces::Forces;

/// Sites and zones found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Sites ordered by (curve, segment, parameter) of a, then of b.
    pub sites: Vec<Site>,
    /// Zones ordered by curve, partner, start of the interval; empty without [`DetectorOptions::zones`].
    pub zones: Vec<Zone>,
}

/// Finds contacts of curves and keeps tree, lists and buffers from one call to the next.
///
/// ```
/// use supercoil::contact::{Curve, Detector, DetectorOptions};
/// use supercoil::math::Vec3;
/// let a = [Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)];
/// let b = [Vec3::new(0.0, -1.0, 0.25), Vec3::new(0.0, 1.0, 0.25)];
/// let mut detector = Detector::new(DetectorOptions { range: 0.1, ..DetectorOptions::default() });
/// let contacts = detector.detect(&[Curve::polyline(&a, 0.1), Curve::polyline(&b, 0.1)])?;
/// assert_eq!(contacts.sites.len(), 1);
/// assert!((contacts.sites[0].gap - 0.05).abs() < 1e-15);
/// # Ok::<(), supercoil::InputError>(())
/// ```
///
/// **Guarantee.** All local minima with gap ≤ `range` of the distance between different curves, and between parts of
/// one curve that are not neighbours, are found. Broad phase and capsule test discard a pair only if it is provably
/// farther apart. Straight pairs are solved in closed form. For pairs of cubics the square of parameters is subdivided;
/// each part is discarded or accepted by bounds of the first and second derivatives of the distance in Bernstein form,
/// roundings included. This holds for lines of contact, too; the exception are curves that are parallel to rounding
/// (below), marked `flat`. No tolerance is a length. The result depends on the curves only (with `margin` 0 not even on
/// earlier calls), never on the number of threads.
///
/// **Units.** All lengths in one unit of the caller's choice; no tolerance is absolute, so results scale with it.
///
/// **Special cases.**
/// * *Parallel* or *coincident* straight segments, and cubics that are so to rounding: one site per pair of segments,
///   marked `flat`, in the middle of the overlap; the zones hold the whole interval.
/// * Centrelines that *cross* or coincide: gap −(r_a + r_b), normal zero. Forces have no direction there and are
///   omitted.
/// * *Tangent* curves: the touching point is one site. Where minima merge with saddles to within rounding, one of the
///   group is returned, marked `flat`.
/// * *Kinks* and *open ends*: minima there are found by the one-sided slopes.
/// * *Repeated* control points within a cubic are legal; repeated points of a polyline and cubics shrunk to a point are
///   refused by name.
/// * *Nearly closed* curves are open ones: their ends are sites if near each other.
///
/// **Cost** O(segments + pairs) for curves of bounded crowding. Memory about 130 bytes a segment (boxes and tree 70,
/// turning 44, arc length 16; cubics 8 more), 8 bytes a candidate pair, 144 a site (32 of them to look for it), 160 a
/// part of a zone (two for each pair of segments along a contact line), 24 a control point for forces, and a copy of
/// the points if `margin` > 0.
#[derive(Debug, Default)]
pub struct Detector {
    pub(super) options: DetectorOptions,
    pub(super) exclusion: Exclusion,
    pub(super) broad: BroadPhase,
    /// Arc length before each segment, and length of each segment.
    start: Vec<f64>,
    lengths: Vec<f64>,
    minima: Vec<Minimum>,
    /// Parts of zones, by chunks of the candidate list, and the buffers that join them.
    parts: Vec<Vec<Part>>,
    joining: interval::JoinBuffers,
    pub(super) contacts: Contacts,
    forces: Forces,
    pair_forces: Vec<PairForce>,
    set: CurveSet,
}

/// A single [`Detector::detect`].
///
/// # Errors
/// As there.
pub fn detect(curves: &[Curve], options: DetectorOptions) -> Result<Contacts, InputError> {
    let mut detector = Detector::new(options);
    detector.detect(curves)?;
    Ok(detector.contacts)
}

impl Detector {
    /// A detector without results; the options are checked by the first call.
    #[must_use]
    pub fn new(options: DetectorOptions) -> Self {
        Self { options, ..Self::default() }
    }

    /// The options; they may be changed between calls.
    pub fn options_mut(&mut self) -> &mut DetectorOptions {
        &mut self.options
    }

    /// Sites and zones of the curves as they are now. Curves may have moved, grown or changed in number since the last
    /// call.
    ///
    /// # Errors
    /// [`InputError`] naming curve and index: too few points, a coordinate or radius that is not finite, radius ≤ 0,
    /// repeated points, cubics that do not join, and (with [`Neighbours::Turning`]) a cubic that turns by π/2 or more;
    /// or an option out of its range.
    pub fn detect(&mut self, curves: &[Curve]) -> Result<&Contacts, InputError> {
        let strands = self.update(curves, self.options.range)?;
        let mut sites = std::mem::take(&mut self.contacts.sites);
        self.find_sites(&strands, &mut sites);
        self.contacts.sites = sites;
        self.contacts.zones = if self.options.zones { self.find_zones(&strands) } else { Vec::new() };
        Ok(&self.contacts)
    }

    /// Pairs i < j of segments (numbered over all curves) that may be within range, of the last call; sorted.
    #[must_use]
    pub fn candidates(&self) -> &[[u32; 2]] {
        self.broad.pairs()
    }

    /// Certified smallest gap of the curves \[L\], to within `tol` \[L\], if it is at most `max_gap`; see
    /// [`smallest_clearance`](crate::contact::sites::clearance::smallest_clearance).
    ///
    /// # Errors
    /// As [`Detector::detect`].
    pub fn smallest_clearance(
        &mut self,
        curves: &[Curve],
        max_gap: f64,
        tol: f64,
    ) -> Result<Option<crate::contact::sites::clearance::Clearance>, InputError> {
        let strands = self.prepare(curves)?;
        self.place(&strands)?;
        Ok(crate::contact::sites::clearance::smallest_clearance(&self.set, &self.exclusion, max_gap, tol))
    }

    pub(super) fn prepare<'a>(&mut self, curves: &[Curve<'a>]) -> Result<Strands<'a>, InputError> {
        self.options.check()?;
        let strands = Strands::new(curves)?;
        match self.options.neighbours {
            Neighbours::Turning => self.exclusion.update_strands(&strands).map_err(too_coarse)?,
            Neighbours::Segments(num) => self.exclusion.update_by_count(&strands, num),
        }
        Ok(strands)
    }

    /// Input check, exclusion of neighbours, tree and candidate list.
    fn update<'a>(&mut self, curves: &[Curve<'a>], range: f64) -> Result<Strands<'a>, InputError> {
        let strands = self.prepare(curves)?;
        self.measure(&strands);
        self.broad.candidates_of(&strands, &self.exclusion, range, self.options.margin)?;
        Ok(strands)
    }

    /// Arc lengths.
    pub(super) fn measure(&mut self, strands: &Strands) {
        let length = |i| {
            if strands.is_straight(i) {
                let (a, b) = strands.ends(i);
                norm(&(b - a))
            } else {
                arc_length(&strands.cubic(i), 1.0)
            }
        };
        self.lengths.resize(strands.len(), 0.0);
        parallel::each(&mut self.lengths, CHEAP, &|k, place| *place = length(k));
        self.start.clear();
        for curve in &strands.curves {
            let mut sum = 0.0;
            for length in &self.lengths[curve.first..curve.first + curve.count] {
                self.start.push(sum);
                sum += length;
            }
        }
    }

    pub(super) fn own_memory(&self) -> usize {
        let parts: usize = self.parts.iter().map(bytes).sum();
        bytes(&self.start)
            + bytes(&self.lengths)
            + bytes(&self.minima)
            + parts
            + self.joining.memory()
            + bytes(&self.pair_forces)
            + self.forces.forces.iter().map(bytes).sum::<usize>()
    }

    fn arc(&self, strands: &Strands, segment: usize, u: f64) -> f64 {
        let part = if strands.is_straight(segment) || u == 0.0 || u == 1.0 {
            u * self.lengths[segment]
        } else {
            arc_length(&strands.cubic(segment), u)
        };
        self.start[segment] + part
    }

    pub(super) fn find_zones(&mut self, strands: &Strands) -> Vec<Zone> {
        let mut lists = std::mem::take(&mut self.parts);
        let mut joining = std::mem::take(&mut self.joining);
        let this = &*self;
        let pairs = this.broad.pairs();
        let arc = |s: usize, u: f64| this.arc(strands, s, u);
        let search = PartSearch { strands, arc, range: this.options.range };
        lists.resize_with(pairs.len().div_ceil(CHEAP), Vec::new);
        parallel::each(&mut lists, 1, &|k, parts| {
            parts.clear();
            for &[i, j] in &pairs[k * CHEAP..pairs.len().min((k + 1) * CHEAP)] {
                let (i, j) = (i as usize, j as usize);
                if this.exclusion.excluded(i, j) || strands.adjacent(i, j) {
                    continue;
                }
                search.both(i, j, parts);
            }
        });
        let far = strands.control_points().flatten().map(Vec3::amax).fold(0.0, f64::max);
        let tolerance = |curve: usize| {
            let c = &strands.curves[curve];
            let mean = (this.start[c.first + c.count - 1] + this.lengths[c.first + c.count - 1]) / c.count as f64;
            // Far from the origin the rounding of the coordinates counts.
            JOINT * mean + 4.0 * SUM_ROUNDING * far
        };
        let zones = interval::join(&lists, strands.len(), tolerance, &mut joining);
        (self.parts, self.joining) = (lists, joining);
        zones
    }

    /// The curves as a set of cubics. Buffers are reused if the numbers of curves and segments have not changed.
    fn place(&mut self, strands: &Strands) -> Result<(), InputError> {
        let same = self.set.curves.len() == strands.curves.len()
            && self.set.curves.iter().zip(&strands.curves).all(|(c, s)| {
                (c.first, c.count, c.closed, self.set.radius_between(c)) == (s.first, s.count, s.closed, s.radius)
            });
        self.measure(strands);
        if same {
            parallel::each(&mut self.set.segments, CHEAP, &|k, segment| *segment = strands.cubic(k));
            self.set.set_lengths(&self.lengths);
            return Ok(());
        }
        let input = |s: &crate::contact::curves::input::Strand| CurveInput {
            segments: (s.first..s.first + s.count).map(|k| strands.cubic(k)).collect(),
            lengths: self.lengths[s.first..s.first + s.count].to_vec(),
            closed: s.closed,
            radius: s.radius.largest(),
        };
        self.set = CurveSet::new(strands.curves.iter().map(input).collect())?;
        if strands.varied() {
            let radii: Vec<f64> = (0..strands.len()).map(|k| strands.radius_of(k)).collect();
            self.set.set_radii(&radii)?;
        }
        Ok(())
    }
}

/// Arc length of a cubic on \[0, u\]: Gauss quadrature, 5 points on each of 4 parts (relative error about 1e-9 for
/// turning below 1 rad).
fn arc_length(cubic: &Cubic, u: f64) -> f64 {
    let rule = gauss(5);
    let part = u / 4.0;
    let speed = |t: f64| norm(&cubic.derivatives(t).1);
    let sum = |k: usize| -> f64 {
        rule.points.iter().zip(rule.weights).map(|(&x, &w)| w * speed((k as f64 + x) * part)).sum()
    };
    (0..4).map(sum).sum::<f64>() * part
}

fn too_coarse(error: SolveError) -> InputError {
    match error {
        SolveError::TooCoarse { curve, segment, turning, limit } => InputError::Inconsistent {
            field: format!("curves[{curve}].pieces[{segment}]"),
            reason: format!("turns by {turning:.3} rad, {limit:.3} or more: split it, or count neighbours by segments"),
        },
        SolveError::TooTight { curve, segment, tightness } => InputError::Inconsistent {
            field: format!("curves[{curve}].pieces[{segment}]"),
            reason: format!(
                "is bent to curvature × radius {tightness:.2}: make it thinner, or count neighbours by segments"
            ),
        },
        other => InputError::Inconsistent { field: "curves".to_owned(), reason: other.to_string() },
    }
}
