//! Diagrams of knots: the crossings of a projection, without those that can be undone at once.

use super::super::crossings::Crossing;

/// A crossing with its four edges counterclockwise, the incoming lower one first, as an entry of a PD code.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DiagramNode {
    /// Edges are numbered along the knot.
    pub edges: [usize; 4],
    /// +1 right-handed, −1 left-handed.
    pub sign: i64,
}

/// Crossings in the order in which the knot passes them: which, and whether above.
fn passes(crossings: &[Crossing]) -> Vec<(usize, bool)> {
    let both = |(k, crossing): (usize, &Crossing)| [(crossing.over, k, true), (crossing.under, k, false)];
    let mut all: Vec<(f64, usize, bool)> = crossings.iter().enumerate().flat_map(both).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.into_iter().map(|(_, k, above)| (k, above)).collect()
}

/// The diagram without kinks (Reidemeister's first move) and without strands that lie over others (his second): what is
/// left when neither applies.
pub(super) fn reduced(mut crossings: Vec<Crossing>) -> Vec<Crossing> {
    loop {
        let passes = passes(&crossings);
        let count = passes.len();
        let mut lower = vec![0; crossings.len()];
        passes.iter().enumerate().filter(|(_, pass)| !pass.1).for_each(|(place, pass)| lower[pass.0] = place);
        let mut stays = vec![true; crossings.len()];
        for place in 0..count {
            let ((a, above), (b, above_too)) = (passes[place], passes[(place + 1) % count]);
            // two strands that cross twice in a row, the same one above, in opposite senses: nothing is between them
            let is_neighbour = |i: usize, j: usize| (i + 1) % count == j || (j + 1) % count == i;
            let lies_over =
                above && above_too && crossings[a].sign != crossings[b].sign && is_neighbour(lower[a], lower[b]);
            if (a == b || lies_over) && stays[a] && stays[b] {
                (stays[a], stays[b]) = (false, false);
            }
        }
        if stays.iter().all(|stays| *stays) {
            return crossings;
        }
        let mut stays = stays.into_iter();
        crossings.retain(|_| stays.next().unwrap_or(true));
    }
}

/// The diagram of a knot's crossings. Edge k leads to the k-th pass.
pub(super) fn nodes(crossings: &[Crossing]) -> Vec<DiagramNode> {
    let passes = passes(crossings);
    let count = passes.len();
    let mut places = vec![[0; 2]; crossings.len()];
    passes.iter().enumerate().for_each(|(place, (k, above))| places[*k][usize::from(*above)] = place);
    let node = |(crossing, [under, over]): (&Crossing, [usize; 2])| {
        let [below, above] = [under, over].map(|place| (place + 1) % count);
        // seen with the lower strand going up, the upper one of a right-handed crossing goes to the right
        let edges = if crossing.sign > 0 { [under, above, below, over] } else { [under, over, below, above] };
        DiagramNode { edges, sign: crossing.sign }
    };
    crossings.iter().zip(places).map(node).collect()
}
