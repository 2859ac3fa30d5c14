//! Options of the detector.

use crate::error::InputError;
use crate::math::LARGEST;

/// Which segments of one curve are too close along it to be in contact with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Neighbours {
    /// Less than π/2 of accumulated turning between them: such points provably cannot be each other's nearest (see
    /// [`Exclusion`](crate::contact::tree::exclusion::Exclusion)). Independent of how finely the curve is cut.
    #[default]
    Turning,
    /// This many segments before and after each, whatever the geometry; adjacent segments are left out even at 0. The
    /// energy of contact jumps where a nearest point passes from a segment left out to one that counts.
    Segments(usize),
}

/// Options of [`Detector`](super::Detector).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Sites and zones with a gap of at most this are found \[L\]. May be negative (only overlaps deeper than that).
    /// Raising it costs pairs.
    pub range: f64,
    /// Extra reach of the candidate list \[L\], at least 0: the list is kept until a point has moved half of it. 0
    /// makes a new list at every call, which is the best choice for steps larger than about a tenth of a radius.
    pub margin: f64,
    /// Which neighbours along a curve are left out.
    pub neighbours: Neighbours,
    /// Bound of the work on one pair of cubics, in \[1, 1024\]: 64 times as many parameter cells are looked at. (Pairs
    /// that cross were seen to need 1 to 6, those along a contact line 2 to 9 on average and 25 at most.) What is left
    /// then hangs together in groups, each of which gives *one* site, marked `flat`. At 8 that has been seen only where
    /// the distance along the valley changes by less than the coordinates' rounding. Polylines are exact without it.
    pub sampling: usize,
    /// Whether to look for zones (they cost about as much again as the sites).
    pub zones: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { range: 0.0, margin: 0.0, neighbours: Neighbours::Turning, sampling: 8, zones: true }
    }
}

impl Options {
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
