//! Options of the detector.

use crate::error::InputError;
use crate::math::LARGEST;

/// Rule for segments of one curve that are too close along it to be in contact with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Neighbours {
    /// Less than π/2 of total curvature between them: such points provably cannot be each other's nearest (see
    /// [`Exclusion`](crate::contact::tree::exclusion::Exclusion)). Independent of the number of segments.
    #[default]
    Turning,
    /// This many segments before and after each, whatever the geometry; adjacent segments are excluded even at 0. The
    /// energy of contact jumps where a nearest point passes from an excluded segment to the next.
    Segments(usize),
}

/// Options of [`Detector`](super::Detector).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectorOptions {
    /// Largest gap of sites and zones \[L\]. May be negative (only overlaps deeper than that). A larger range means
    /// more pairs.
    pub range: f64,
    /// Extra reach of the candidate list \[L\], at least 0: the list is kept until a point has moved by half of it. 0
    /// builds a new list at every call, the best choice for steps larger than about a tenth of a radius.
    pub margin: f64,
    /// Exclusion of neighbours along a curve.
    pub neighbours: Neighbours,
    /// Bound of the work on one pair of cubics, in \[1, 1024\]: at most 64 times as many parameter cells are examined.
    /// (Crossing pairs needed 1 to 6 cells, pairs along a contact line 2 to 9 on average and 25 at most.) The cells
    /// that remain form connected groups, each of which gives *one* site, marked `flat`. At 8 this happened only where
    /// the distance along the valley changes by less than the rounding of the coordinates. Polylines are exact without
    /// it.
    pub sampling: usize,
    /// Whether zones are computed; they cost about as much as the sites.
    pub zones: bool,
}

impl Default for DetectorOptions {
    fn default() -> Self {
        Self { range: 0.0, margin: 0.0, neighbours: Neighbours::Turning, sampling: 8, zones: true }
    }
}

impl DetectorOptions {
    pub(super) fn check(&self) -> Result<(), InputError> {
        InputError::check("range", self.range, self.range.abs() <= LARGEST, "finite, and at most 1e100 in size")?;
        let ok = (0.0..=LARGEST).contains(&self.margin);
        InputError::check("margin", self.margin, ok, "finite, at least 0 and at most 1e100")?;
        if (1..=1024).contains(&self.sampling) {
            return Ok(());
        }
        Err(InputError::Count { field: "sampling".to_owned(), value: self.sampling, allowed: "from 1 to 1024" })
    }
}
