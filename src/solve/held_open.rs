//! Contacts that offsets hold open.
//!
//! The augmented Lagrangian raises and lowers an offset by the smallest gap in a window ([`Solver::contact_errors`]), as one contact needs it. A contact within
//! the window of another that touches would keep its force over any gap: a state in balance, stable, and with too much energy. So contacts are told apart here.
//! Pieces of zones that follow each other along a strand are one contact, and its gap is the smallest in it: the ripples that elements in line contact have
//! are inside of one contact and none of this. Contacts so near each other that they share all offsets are beyond what the mesh tells apart.

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
    /// Σ force × gap over the elastic energy.
    pub(super) work: f64,
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

    /// Whether `other`, which starts no earlier, starts before this one ends, or where it does.
    fn reaches(&self, side: &ContactSide, other: &Self) -> bool {
        let (Some(&last), Some(&first)) = (self.segments.last(), other.segments.first()) else { return false };
        let over_joint = || self.end >= 1.0 - TOL_MEET && other.start <= TOL_MEET && side.set.next(last) == Some(first);
        last == first && other.start <= self.end + TOL_MEET || over_joint()
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
        .terms
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
        if let Some(first) = (0..last).find(|&first| joined[last].reaches(side, &joined[first])) {
            let part = joined.remove(last);
            joined[first].join(part);
        }
    }
    joined
}

impl Solver {
    /// Contacts that offsets hold open at the present state.
    pub(super) fn held_open(&self) -> HeldOpen {
        let holds = |side: &&ContactSide| side.offsets.iter().any(|offset| *offset > 0.0);
        let Some(side) = self.engine.contact.as_ref().filter(holds) else { return HeldOpen::default() };
        let residual = self.engine.residual(&self.engine.state);
        let stretches = stretches(side, &residual);
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
        let held = stretches.iter().filter(|stretch| nodes(stretch).iter().any(|&node| gaps[node] > 0.0));
        let work: f64 = held.map(|stretch| stretch.half_force * stretch.gap.max(0.0)).sum();
        let energy: f64 = residual.potential.elastic.iter().sum();
        HeldOpen { work: if energy > 0.0 { work / energy } else { 0.0 }, gaps }
    }
}
