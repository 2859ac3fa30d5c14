//! Contacts that offsets hold open.
//!
//! The augmented Lagrangian raises and lowers an offset by the smallest gap in a window ([`Solver::contact_errors`]), as one contact needs it. A contact within
//! the window of another that touches would keep its force over any gap: a state in balance, stable, and with too much energy. So contacts are told apart here.
//! Pieces of zones that follow each other along a strand are one contact, and its gap is the smallest in it: the ripples that elements in line contact have
//! are inside of one contact and none of this. Contacts nearer to each other than the nodes are share their offsets, and
//! the mesh cannot tell them apart: what these carry is reported, not released.

use crate::contact::detect::ZonePiece;
use crate::solve::assembly::Residual;
use crate::solve::engine::ContactSide;
use crate::solve::path::Solver;
use crate::solve::settle::TOL_OPENING;

/// Ends of pieces that meet agree to this on the strand, in parameters of its segments.
const TOL_MEET: f64 = 1e-6;
/// Work that offsets may do on what they hold open, over the elastic energy: what the energy is too high by.
pub(super) const TOL_HELD_OPEN: f64 = 2e-6;

/// Contacts that carry force over a gap.
#[derive(Debug, Default)]
pub(super) struct HeldOpen {
    /// Σ force × gap over the elastic energy …
    pub(super) work: f64,
    /// … and of those contacts alone that have an offset of their own to lower.
    pub(super) releasable: f64,
    /// What the offsets are to be lowered by, per node \[L\]: the gap of the open contact there, zero where there is none or another one touches.
    pub(super) gaps: Vec<f64>,
}

/// One contact as seen from one strand: pieces that follow each other without a break.
#[derive(Debug)]
struct Stretch {
    /// Segments, and the parameter up to which it goes on the last one.
    segments: Vec<usize>,
    end: f64,
    /// Parameter of its start on the first segment.
    start: f64,
    /// Smallest gap \[L\].
    gap: f64,
    /// This strand's half of the force \[F\].
    half_force: f64,
}

impl Stretch {
    fn of(segment: usize, zone: &ZonePiece) -> Self {
        let [start, end] = zone.piece.u;
        Self { segments: vec![segment], end, start, gap: zone.min_gap, half_force: zone.half_force }
    }

    /// Whether `other`, which starts no earlier on the strand, starts before this one ends or where it does.
    fn reaches(&self, side: &ContactSide, other: &Self) -> bool {
        self.segments.last() == other.segments.first() && other.start <= self.end + TOL_MEET
            || self.goes_on_in(side, other)
    }

    /// Whether it ends at the joint to a segment that `other` starts at.
    fn goes_on_in(&self, side: &ContactSide, other: &Self) -> bool {
        let next = self.segments.last().and_then(|&last| side.set.next(last));
        self.end >= 1.0 - TOL_MEET
            && other.start <= TOL_MEET
            && next.is_some()
            && next.as_ref() == other.segments.first()
    }

    fn join(&mut self, other: Self) {
        let same = self.segments.last() == other.segments.last();
        self.end = if same { self.end.max(other.end) } else { other.end };
        self.segments.extend(other.segments);
        self.gap = self.gap.min(other.gap);
        self.half_force += other.half_force;
    }
}

/// Contacts of all strands, each as seen from either side.
fn stretches(side: &ContactSide, residual: &Residual) -> Vec<Stretch> {
    let counted = |zone: &&ZonePiece| !zone.piece.branch.is_counted_off();
    let mut pieces: Vec<Stretch> = residual
        .meetings
        .iter()
        .flat_map(|term| term.zones.iter().filter(counted).map(|zone| Stretch::of(term.slave, zone)))
        .collect();
    pieces.sort_by(|a, b| a.segments.cmp(&b.segments).then(a.start.total_cmp(&b.start)));
    let mut joined: Vec<Stretch> = Vec::new();
    for piece in pieces {
        match joined.last_mut() {
            Some(last) if last.reaches(side, &piece) => last.join(piece),
            _ => joined.push(piece),
        }
    }
    // over the seams of closed strands: there, and only there, a later one goes on in an earlier one
    for last in (1..joined.len()).rev() {
        let next = joined[last].segments.last().and_then(|&segment| side.set.next(segment));
        let first = joined[..last].partition_point(|stretch| stretch.segments.first().copied() < next);
        if first < last && joined[last].goes_on_in(side, &joined[first]) {
            let part = joined.remove(last);
            joined[first].join(part);
        }
    }
    joined
}

impl Solver {
    /// Contacts that offsets hold open, from the residual of the present state, with zones.
    pub(super) fn held_open(&self, residual: &Residual) -> HeldOpen {
        let holds = |side: &&ContactSide| side.offsets.iter().any(|offset| *offset > 0.0);
        let Some(side) = self.engine.contact.as_ref().filter(holds) else { return HeldOpen::default() };
        let stretches = stretches(side, residual);
        let open = TOL_OPENING * side.min_radius;
        let nodes = |stretch: &Stretch| -> Vec<usize> {
            stretch.segments.iter().flat_map(|&segment| side.nodes[segment]).collect()
        };
        let mut gaps = vec![f64::INFINITY; side.offsets.len()];
        for stretch in &stretches {
            nodes(stretch).into_iter().for_each(|node| gaps[node] = gaps[node].min(stretch.gap));
        }
        for (gap, offset) in gaps.iter_mut().zip(&side.offsets) {
            let held = gap.is_finite() && *gap > open && *offset > 0.0;
            *gap = if held { *gap } else { 0.0 };
        }
        let energy: f64 = residual.potential.elastic.iter().sum();
        let work = |stretch: &Stretch| {
            if energy > 0.0 && stretch.gap > open { stretch.half_force * stretch.gap / energy } else { 0.0 }
        };
        let own = |stretch: &&Stretch| nodes(stretch).iter().any(|&node| gaps[node] > 0.0);
        let releasable = stretches.iter().filter(own).map(work).fold(0.0, |a, b| a + b);
        HeldOpen { work: stretches.iter().map(work).fold(0.0, |a, b| a + b), releasable, gaps }
    }
}
