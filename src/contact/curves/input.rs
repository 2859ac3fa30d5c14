//! Borrowed curves of the caller: points of polylines or cubic pieces; nothing is copied.

use crate::contact::curves::curve::{Cubic, CurveSet};
use crate::contact::curves::radius::Radius;
use crate::error::InputError;
use crate::math::{LARGEST, Vec3};

/// Distance from an end of a segment, as a parameter, below which a point counts as the joint, because roots of a
/// quintic are rounded by less, and no two sites are as near.
pub(crate) const JOINT: f64 = 1e-9;

/// Where the centreline runs.
#[derive(Clone, Copy, Debug)]
pub enum CurveShape<'a> {
    /// Straight segments through the points \[L\], consecutive ones different; at least 2 points (3 if closed, where
    /// the last is joined to the first by one more segment). 24 bytes a segment.
    Polyline(&'a [Vec3]),
    /// Cubic pieces, each starting where the one before ends; at least 1. From nodes and tangents:
    /// [`Cubic::from_hermite`]. 96 bytes a segment.
    Cubics(&'a [Cubic]),
}

/// A curve with a contact radius.
#[derive(Clone, Copy, Debug)]
pub struct Curve<'a> {
    /// Where it runs.
    pub shape: CurveShape<'a>,
    /// Contact radius \[L\], greater than 0: one number or one for each segment.
    pub radius: Radius<'a>,
    /// Whether its end is joined to its start.
    pub closed: bool,
}

impl<'a> Curve<'a> {
    /// Open polyline through `points`; `radius` is a number or a borrowed list with one for each segment.
    #[must_use]
    pub fn polyline(points: &'a [Vec3], radius: impl Into<Radius<'a>>) -> Self {
        Self { shape: CurveShape::Polyline(points), radius: radius.into(), closed: false }
    }

    /// Open curve of cubic pieces.
    #[must_use]
    pub fn cubics(pieces: &'a [Cubic], radius: impl Into<Radius<'a>>) -> Self {
        Self { shape: CurveShape::Cubics(pieces), radius: radius.into(), closed: false }
    }

    /// The same curve with its end joined to its start.
    #[must_use]
    pub const fn closed(self) -> Self {
        Self { closed: true, ..self }
    }

    fn num_segments(&self) -> usize {
        match self.shape {
            CurveShape::Polyline(points) if self.closed => points.len(),
            CurveShape::Polyline(points) => points.len().saturating_sub(1),
            CurveShape::Cubics(pieces) => pieces.len(),
        }
    }

    /// Refuses curves that contact cannot be computed for; `index` names the curve in the error.
    fn check(&self, index: usize) -> Result<(), InputError> {
        let field = |what: &str| format!("curves[{index}].{what}");
        match self.shape {
            CurveShape::Polyline(points) => check_points(points, self.closed, &field)?,
            CurveShape::Cubics(pieces) => check_pieces(pieces, self.closed, &field)?,
        }
        self.radius.check(self.num_segments(), &field)
    }
}

fn check_points(points: &[Vec3], closed: bool, field: &dyn Fn(&str) -> String) -> Result<(), InputError> {
    let (least, allowed) = if closed { (3, "at least 3 (closed)") } else { (2, "at least 2") };
    if points.len() < least {
        return Err(InputError::Count { field: field("points"), value: points.len(), allowed });
    }
    for (i, p) in points.iter().enumerate() {
        check_finite(p, || field(&format!("points[{i}]")))?;
        if i > 0 && points[i - 1] == *p {
            return Err(repeated(field(&format!("points[{i}]"))));
        }
    }
    if closed && points[0] == points[points.len() - 1] {
        return Err(repeated(field(&format!("points[{}]", points.len() - 1))));
    }
    Ok(())
}

fn repeated(field: String) -> InputError {
    let reason = "the same point as its neighbour: leave one out (a closed curve does not repeat its first point)";
    InputError::Inconsistent { field, reason: reason.to_owned() }
}

fn check_pieces(pieces: &[Cubic], closed: bool, field: &dyn Fn(&str) -> String) -> Result<(), InputError> {
    if pieces.is_empty() {
        return Err(InputError::Count { field: field("pieces"), value: 0, allowed: "at least 1" });
    }
    for (i, piece) in pieces.iter().enumerate() {
        for (k, p) in piece.b.iter().enumerate() {
            check_finite(p, || field(&format!("pieces[{i}].b[{k}]")))?;
        }
        if piece.edges().iter().all(|e| *e == Vec3::zeros()) {
            let reason = "all four control points are one: leave the piece out".to_owned();
            return Err(InputError::Inconsistent { field: field(&format!("pieces[{i}]")), reason });
        }
        let next = if i + 1 < pieces.len() { Some(&pieces[i + 1]) } else { closed.then(|| &pieces[0]) };
        if next.is_some_and(|next| !piece.joins(next)) {
            let reason = "its end is not the start of the next piece: make them the same point".to_owned();
            return Err(InputError::Inconsistent { field: field(&format!("pieces[{i}]")), reason });
        }
    }
    Ok(())
}

fn check_finite(p: &Vec3, field: impl Fn() -> String) -> Result<(), InputError> {
    if p.iter().all(|x| x.abs() <= LARGEST) {
        return Ok(());
    }
    Err(InputError::Vector { field: field(), value: [p.x, p.y, p.z], allowed: "finite, and at most 1e100 in size" })
}

/// Componentwise minimum. One instruction a component, unlike `inf`, which handles NaN.
#[inline(always)]
pub(crate) fn lower(a: &Vec3, b: &Vec3) -> Vec3 {
    a.zip_map(b, |x, y| if x < y { x } else { y })
}

/// Componentwise maximum.
#[inline(always)]
pub(crate) fn upper(a: &Vec3, b: &Vec3) -> Vec3 {
    a.zip_map(b, |x, y| if x > y { x } else { y })
}

/// One curve with its place in the common numbering of segments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strand<'a> {
    pub(crate) shape: CurveShape<'a>,
    pub(crate) radius: Radius<'a>,
    pub(crate) closed: bool,
    pub(crate) first: usize,
    pub(crate) count: usize,
}

impl Strand<'_> {
    /// Points of a polyline, or four for each cubic.
    pub(crate) fn num_control_points(&self) -> usize {
        match self.shape {
            CurveShape::Polyline(points) => points.len(),
            CurveShape::Cubics(pieces) => 4 * pieces.len(),
        }
    }
}

/// Several curves under one numbering of segments, 0..`len`; a view, cheap to make.
#[derive(Clone, Debug)]
pub(crate) struct Strands<'a> {
    pub(crate) curves: Vec<Strand<'a>>,
    /// Curve of each segment; empty if there is only one curve.
    owner: Vec<u32>,
    len: usize,
    /// Whether some curve has a radius per segment.
    varied: bool,
}

impl<'a> Strands<'a> {
    /// Checks the curves, O(segments).
    ///
    /// # Errors
    /// [`InputError`] naming curve and index.
    pub(crate) fn new(curves: &[Curve<'a>]) -> Result<Self, InputError> {
        for (index, curve) in curves.iter().enumerate() {
            curve.check(index)?;
        }
        let total: usize = curves.iter().map(Curve::num_segments).sum();
        if total >= u32::MAX as usize {
            return Err(InputError::Count {
                field: "curves".to_owned(), value: total, allowed: "below 2³² segments"
            });
        }
        Ok(Self::view(curves))
    }

    /// Without the checks.
    pub(crate) fn view(curves: &[Curve<'a>]) -> Self {
        Self::join(curves.iter().map(|c| (c.shape, c.radius, c.closed, c.num_segments())))
    }

    /// The curves of a set.
    pub(crate) fn of_set(set: &'a CurveSet) -> Self {
        Self::join(set.curves.iter().map(|c| {
            (CurveShape::Cubics(&set.segments[c.first..c.first + c.count]), set.radius_between(c), c.closed, c.count)
        }))
    }

    fn join(parts: impl Iterator<Item = (CurveShape<'a>, Radius<'a>, bool, usize)>) -> Self {
        let mut len = 0;
        let curves: Vec<_> = parts
            .map(|(shape, radius, closed, count)| {
                let first = len;
                len += count;
                Strand { shape, radius, closed, first, count }
            })
            .collect();
        let mut owner = Vec::new();
        if curves.len() > 1 {
            owner.reserve_exact(len);
            for (index, curve) in curves.iter().enumerate() {
                owner.extend(std::iter::repeat_n(index as u32, curve.count));
            }
        }
        let varied = curves.iter().any(|c| c.radius.list().is_some());
        Self { curves, owner, len, varied }
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    #[inline]
    pub(crate) fn curve_of(&self, segment: usize) -> usize {
        if self.owner.is_empty() { 0 } else { self.owner[segment] as usize }
    }

    #[inline]
    pub(crate) fn strand(&self, segment: usize) -> &Strand<'a> {
        &self.curves[self.curve_of(segment)]
    }

    #[inline]
    pub(crate) fn radius_of(&self, segment: usize) -> f64 {
        let strand = self.strand(segment);
        strand.radius.of(segment - strand.first)
    }

    /// Largest radius at any point of the segment, its joints included.
    #[inline]
    pub(crate) fn reach_of(&self, segment: usize) -> f64 {
        let own = self.radius_of(segment);
        if !self.varied {
            return own;
        }
        let beside = [self.prev(segment), self.next(segment)];
        beside.into_iter().flatten().fold(own, |r, other| r.max(self.radius_of(other)))
    }

    /// Radius at a parameter: the larger at a joint.
    pub(crate) fn radius_at(&self, segment: usize, u: f64) -> f64 {
        let own = self.radius_of(segment);
        let beside = match u {
            _ if !self.varied => None,
            u if u < JOINT => self.prev(segment),
            u if u > 1.0 - JOINT => self.next(segment),
            _ => None,
        };
        beside.map_or(own, |other| own.max(self.radius_of(other)))
    }

    /// Whether some curve has a radius per segment.
    pub(crate) fn varied(&self) -> bool {
        self.varied
    }

    /// Largest radius of all.
    pub(crate) fn largest_radius(&self) -> f64 {
        self.curves.iter().map(|c| c.radius.largest()).fold(0.0, f64::max)
    }

    /// Start and end of a segment.
    #[inline]
    pub(crate) fn ends(&self, segment: usize) -> (Vec3, Vec3) {
        let strand = self.strand(segment);
        let k = segment - strand.first;
        match strand.shape {
            CurveShape::Polyline(points) => (points[k], points[if k + 1 < points.len() { k + 1 } else { 0 }]),
            CurveShape::Cubics(pieces) => (pieces[k].b[0], pieces[k].b[3]),
        }
    }

    /// True if the segment is a straight line at constant speed by construction.
    #[inline]
    pub(crate) fn is_straight(&self, segment: usize) -> bool {
        matches!(self.strand(segment).shape, CurveShape::Polyline(_))
    }

    /// The segment as a cubic.
    pub(crate) fn cubic(&self, segment: usize) -> Cubic {
        let strand = self.strand(segment);
        match strand.shape {
            CurveShape::Polyline(_) => {
                let (a, b) = self.ends(segment);
                Cubic::straight(a, b)
            }
            CurveShape::Cubics(pieces) => pieces[segment - strand.first],
        }
    }

    /// Box of the control points (f64, nothing added).
    #[inline]
    pub(crate) fn bounds(&self, segment: usize) -> (Vec3, Vec3) {
        let strand = self.strand(segment);
        match strand.shape {
            CurveShape::Polyline(_) => {
                let (a, b) = self.ends(segment);
                (lower(&a, &b), upper(&a, &b))
            }
            CurveShape::Cubics(pieces) => {
                let [b0, b1, b2, b3] = &pieces[segment - strand.first].b;
                (lower(&lower(b0, b1), &lower(b2, b3)), upper(&upper(b0, b1), &upper(b2, b3)))
            }
        }
    }

    /// The following segment of the same curve; `None` at an open end.
    pub(crate) fn next(&self, segment: usize) -> Option<usize> {
        let strand = self.strand(segment);
        let last = strand.first + strand.count - 1;
        if segment < last { Some(segment + 1) } else { strand.closed.then_some(strand.first) }
    }

    /// The preceding segment of the same curve; `None` at an open end.
    pub(crate) fn prev(&self, segment: usize) -> Option<usize> {
        let strand = self.strand(segment);
        if segment > strand.first {
            Some(segment - 1)
        } else {
            strand.closed.then_some(strand.first + strand.count - 1)
        }
    }

    /// True if two segments share a joint.
    pub(crate) fn adjacent(&self, i: usize, j: usize) -> bool {
        self.next(i) == Some(j) || self.next(j) == Some(i)
    }

    /// All control points, curve after curve (polylines: their points).
    pub(crate) fn control_points(&self) -> impl Iterator<Item = &'a [Vec3]> + use<'a, '_> {
        self.curves.iter().flat_map(|strand| {
            let (points, pieces): (&'a [Vec3], &'a [Cubic]) = match strand.shape {
                CurveShape::Polyline(points) => (points, &[]),
                CurveShape::Cubics(pieces) => (&[], pieces),
            };
            std::iter::once(points).filter(|p| !p.is_empty()).chain(pieces.iter().map(|c| c.b.as_slice()))
        })
    }
}
