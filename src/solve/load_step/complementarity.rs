//! Violation of complementarity: contacts that offsets hold open.
//!
//! The augmented Lagrangian raises and lowers an offset by the smallest gap in a window ([`Solver::contact_errors`]),
//! as a single contact needs it. A contact within the window of another one that touches would keep its force over any
//! gap, in a stable equilibrium with too much energy. So contacts are separated here. A chain of pieces of zones is one
//! contact, and its gap is the smallest in it: ripples of elements in line contact are within one contact and do not
//! count. A contact is released at the nodes that are its own, from the first augmentation on
//! ([`Solver::outstanding`]). A contact that shares each of its nodes with touching neighbours on the same strand has
//! none: the mesh does not resolve them, and its force is reported, not released.

use crate::contact::chain::{ChainPiece, chains};
use crate::contact::potential::surface::{SurfacePiece, surface_runs};
use crate::solve::load_step::solver::Solver;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::contact_side::ContactSide;

/// Gap, over the contact radius, from which a contact is open, because it acts like a rod thicker by this part.
pub(super) const OPEN: f64 = 1e-6;

/// Contacts that carry force over a gap.
#[derive(Debug, Default)]
pub(in crate::solve) struct Complementarity {
    /// Σ force × gap over the elastic energy …
    pub(in crate::solve) work: f64,
    /// … and of those contacts alone that have an offset of their own to lower.
    pub(in crate::solve) releasable: f64,
    /// By how much offsets are to be lowered \[L\]: the gap of the open contact there, zero where there is none or
    /// another one touches.
    pub(in crate::solve) gaps: ContactField,
}

/// One contact as one strand has it.
struct Held {
    /// Smallest gap \[L\].
    gap: f64,
    /// Its force as far as it counts for this strand: half of that between strands, all of that of an obstacle \[F\].
    force: f64,
    /// Where its offsets are.
    places: Vec<usize>,
}

/// Contacts with obstacles: runs of zones that go on in each other.
fn held_by_surfaces<'a>(side: &'a ContactSide, residual: &'a Residual) -> impl Iterator<Item = Held> + 'a {
    let held = |run: Vec<SurfacePiece>| Held {
        gap: run.iter().map(|piece| piece.zone.min_gap).fold(f64::INFINITY, f64::min),
        force: run.iter().map(|piece| piece.zone.moments[0]).sum(),
        places: run
            .iter()
            .flat_map(|piece| side.nodes[piece.segment].map(|node| side.offsets.index_of_surface(node, piece.surface)))
            .collect(),
    };
    surface_runs(&side.set, &residual.surface_contacts).into_iter().map(held)
}

impl Solver {
    /// Contacts that offsets hold open, from the residual of the present state, with zones.
    pub(in crate::solve) fn complementarity(&self, residual: &Residual) -> Complementarity {
        let side = &self.engine.contact;
        if side.largest_offset_in_force() == 0.0 {
            return Complementarity::default();
        }
        let (set, offsets) = (&side.set, &side.offsets);
        // it acts like a rod thicker by this part
        let open = OPEN * side.min_radius;
        let chains = chains(set, &residual.contact_pairs);
        let gap = |chain: &[ChainPiece]| chain.iter().map(|link| link.zone.min_gap).fold(f64::INFINITY, f64::min);
        let places = |chain: &[ChainPiece]| -> Vec<usize> {
            let of_link =
                |link: &ChainPiece| side.nodes[link.segments[0]].map(|node| offsets.index(set, node, link.segments[1]));
            chain.iter().flat_map(of_link).collect()
        };
        let strands = chains.iter().map(|chain| Held {
            gap: gap(chain),
            force: chain.iter().map(|link| link.zone.force).sum(),
            places: places(chain),
        });
        let contacts: Vec<Held> = strands.chain(held_by_surfaces(side, residual)).collect();
        let mut gaps = offsets.map(|_, _| f64::INFINITY);
        for contact in &contacts {
            contact.places.iter().for_each(|&k| gaps.values[k] = gaps.values[k].min(contact.gap));
        }
        let gaps = gaps.map(|k, gap| if gap.is_finite() && gap > open && offsets.values[k] > 0.0 { gap } else { 0.0 });
        let energy: f64 = residual.potential.elastic.total();
        let work = |contact: &Held| {
            if energy > 0.0 && contact.gap > open { contact.force * contact.gap / energy } else { 0.0 }
        };
        let own = |contact: &&Held| contact.places.iter().any(|&k| gaps.values[k] > 0.0);
        let releasable = contacts.iter().filter(own).map(work).fold(0.0, |a, b| a + b);
        Complementarity { work: contacts.iter().map(work).fold(0.0, |a, b| a + b), releasable, gaps }
    }
}
