//! A rod whose nodes and frames are the base pairs of a file.

use std::path::Path;

use crate::dna::HELICAL_REPEAT;
use crate::dna::base_pairs::BasePairs;
use crate::error::InputError;
use crate::rod::{Natural, Placement, Rod, Section, within};
use crate::scene::file::syntax::RodText;
use crate::scene::file::syntax::values::NaturalText;

/// The rod of a file of base pairs; on other elements than a node a pair, where the scene says how many. `length`
/// \[nm\] where sequence or dna tell it, else that from pair to pair; `turns` of the double helix that frames of a
/// sequence leave out.
pub(super) fn rod(
    text: &RodText,
    path: &Path,
    (length, turns): (Option<f64>, f64),
    section: Section,
    natural: Natural,
) -> Result<Rod, InputError> {
    let mut pairs = BasePairs::read(path, text.closed)?;
    let count = pairs.positions.len();
    let segments = if text.closed { count } else { count.saturating_sub(1) };
    // base pairs a turn taken out: a rod that is straight and untwisted at rest models the axis, as one in blocks does
    let repeat = match (&text.sequence, &text.natural) {
        (Some(_), _) if turns > 0.0 => Some(segments as f64 / turns),
        (None, NaturalText::Straight) => {
            Some(text.dna.as_ref().and_then(|dna| dna.helical_repeat).unwrap_or(HELICAL_REPEAT))
        }
        _ => None,
    };
    if let Some(repeat) = repeat {
        pairs = pairs.unwound(repeat);
    }
    let way = || (0..segments).map(|k| (pairs.positions[(k + 1) % count] - pairs.positions[k]).norm()).sum();
    let length = length.unwrap_or_else(way);
    let field = format!("rods.{}", text.name);
    let from = |order: usize, positions, frames| {
        let nodes = Placement { length, positions, frames, closed: text.closed };
        Rod::from_nodes(&text.name, nodes, section, order, natural.clone())
    };
    let wanted = text.elements.map(|elements| elements.saturating_mul(text.order));
    let (positions, frames) = (pairs.positions, pairs.frames);
    let rod = if wanted.is_none_or(|wanted| wanted == segments) {
        if !segments.is_multiple_of(text.order.max(1)) {
            let reason = format!("the base pairs make {segments} segments, no multiple of the order: give elements");
            return Err(InputError::inconsistent(format!("{field}.elements"), &reason));
        }
        from(text.order, positions, frames)?
    } else {
        let fine = from(1, positions, frames)?;
        let (positions, frames) = fine.resampled(wanted.unwrap_or(segments)).map_err(|error| within(&field, error))?;
        from(text.order, positions, frames)?
    };
    if !text.closed {
        return Ok(rod);
    }
    // base pairs close on each other, so the strands are linked a whole number of times
    let removed = repeat.map_or(0.0, |repeat| count as f64 / repeat);
    let link = rod.start_link();
    let excess = (link + removed).round() - removed - rod.natural_link();
    rod.with_excess_link(excess)
}
