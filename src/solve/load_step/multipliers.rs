//! Contact pressures and the offsets of the augmented Lagrangian: carried from one law to the next, raised and lowered.

use crate::contact::curve::CurveSet;
use crate::contact::law::{Law, shortest_line};
use crate::solve::load_step::complementarity::{Complementarity, OPEN};
use crate::solve::load_step::solver::Solver;
use crate::solve::measures::NOTHING;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::contact_gaps::smallest_gaps;
use crate::solve::problem::contact_side::ContactSide;

/// Largest growth of a secant step from one augmentation to the next, because an extrapolation to twice the distance of
/// what is known has twice to four times its error.
const MAX_SECANT_GROWTH: f64 = 2.0;
/// Augmentations in which offsets are lowered and raised at once, because they come from another law. Later both
/// together may never end.
const FREE_ROUNDS: usize = 3;
/// Releases that did not halve a gap after which there are no more, because the secant needs two tries to find how fast
/// a gap closes.
const MAX_RELEASES: usize = 2;
/// Pressure over that of the core law at which its stiffness counts, because strands are pressed by about as much.
const TYPICAL_PRESSURE: f64 = 0.1;

/// Violation of the contact conditions, by nodes and in all.
#[derive(Debug, Default)]
pub(in crate::solve) struct ContactErrors {
    /// Smallest gap of each contact near each node, see [`Solver::window`] \[L\]; infinite out of reach.
    pub(in crate::solve) gaps: ContactField,
    /// Worst penetration over the smallest contact radius.
    pub(in crate::solve) penetration: f64,
}

/// Next task of the augmented Lagrangian.
#[derive(Debug)]
pub(in crate::solve) struct Outstanding {
    /// Worst penetration over the smallest contact radius.
    pub(in crate::solve) penetration: f64,
    /// Work of offsets on gaps open under force, relative to the elastic energy; `None` while there are penetrations.
    pub(in crate::solve) complementarity: Option<f64>,
    /// Gaps by which offsets are to be raised and lowered \[L\]; `None` at the end.
    pub(in crate::solve) gaps: Option<ContactField>,
}

impl Solver {
    /// Replaces the law; strands that just touch get the pressures of the present equilibrium.
    pub(in crate::solve) fn change_law_keeping_pressures(&mut self, law: Law) {
        let pressures = self.pressures();
        self.change_law_to(law, &pressures);
    }

    /// Replaces the law, with offsets that give touching strands these pressures (per node; none if empty).
    pub(in crate::solve) fn change_law(&mut self, law: Law, pressures: &[f64]) {
        let [num_nodes, num_surfaces] = self.engine.contact.size();
        let mut of_nodes = pressures.to_vec();
        of_nodes.resize(num_nodes, 0.0);
        self.change_law_to(law, &ContactField::of_nodes(&of_nodes, num_surfaces));
    }

    fn change_law_to(&mut self, law: Law, pressures: &ContactField) {
        let side = &mut self.engine.contact;
        let distance = 2.0 * side.min_radius;
        side.change_law(law, pressures.map(|_, pressure| law.overlap(pressure, distance)));
    }

    /// [`Solver::change_law`], but the first step starts from the new law's pressures.
    pub(in crate::solve) fn start_under(&mut self, law: Law, pressures: &[f64]) {
        self.change_law(law, pressures);
        self.forget_pressures();
    }

    /// Makes the first step after a change of law or offsets start from the present pressures.
    pub(in crate::solve) fn forget_pressures(&mut self) {
        self.engine.contact.before = None;
    }

    /// Sets offsets for which the pressures at the present gaps are the means of the present ones over an element.
    /// Elements in line contact have ripples, which uniform offsets turn into ripples of pressure. Where ripples of two
    /// strands face each other, the strands would lower the energy by sliding; under smooth pressures sliding raises
    /// it. For a single closed rod.
    pub(in crate::solve) fn smooth_pressures(&mut self) {
        let gaps = self.node_gaps();
        let (nodes, order) = (gaps.len(), self.engine.model.rods[0].order);
        let side = &mut self.engine.contact;
        let distance = 2.0 * side.min_radius;
        let present = side.offsets.per_node(f64::max);
        let pressure = |i: usize| side.law.response(present[i] - gaps[i], distance).pressure;
        let smooth = |i: usize| {
            // as many nodes as an element has, half of the first and of the last if these are on its joints
            let around = |k: usize| (i + nodes + k - order / 2) % nodes;
            let ends = if order % 2 == 0 { 0.5 } else { 1.0 };
            let last = 2 * (order / 2);
            let weight = |k: usize| if k == 0 || k == last { ends } else { 1.0 };
            let mean = (0..=last).map(|k| weight(k) * pressure(around(k))).sum::<f64>() / order as f64;
            let touches = (0..=last).all(|k| gaps[around(k)].is_finite() && pressure(around(k)) > 0.0);
            if touches { side.law.overlap(mean, distance) + gaps[i] } else { present[i] }
        };
        let offsets: Vec<f64> = (0..nodes).map(smooth).collect();
        let offsets = ContactField::of_nodes(&offsets, side.surfaces.len());
        side.change_law(side.law, offsets);
    }

    /// Gap at each node \[L\]; infinite where nothing touches.
    fn node_gaps(&self) -> Vec<f64> {
        let side = &self.engine.contact;
        let mut gaps = vec![f64::INFINITY; side.offsets.num_nodes()];
        for term in &self.engine.residual(self.engine.state()).contact_pairs {
            let [slave, master] = [term.slave, term.master].map(|k| &side.set.segments[k]);
            let reach = side.set.radius_of(term.slave) + side.set.radius_of(term.master);
            for (zone, k) in term.zones.iter().flat_map(|zone| [(zone, 0), (zone, 1)]) {
                let (u, v) = (zone.piece.u[k], zone.piece.v[k]);
                if let Some(end) = [0.0, 1.0].iter().position(|at| *at == u) {
                    let gap = &mut gaps[side.nodes[term.slave][end]];
                    *gap = gap.min((slave.point(u) - master.point(v)).norm() - reach);
                }
            }
        }
        gaps
    }

    /// Pressure of each contact near each node \[F/L\], at the smallest gap around it.
    fn pressures(&self) -> ContactField {
        let gaps = self.contact_errors().gaps;
        let side = &self.engine.contact;
        let offsets = side.offsets.at_places_of(&side.set, &gaps);
        gaps.map(|k, gap| {
            let pressure = side.law.response(offsets.values[k] - gap, 2.0 * side.min_radius).pressure;
            if pressure.is_finite() { pressure } else { 0.0 }
        })
    }

    /// Violation of the contact conditions.
    pub(in crate::solve) fn contact_errors(&self) -> ContactErrors {
        if self.engine.contact.is_empty() {
            return ContactErrors::default();
        }
        self.contact_errors_of(&self.engine.residual(self.engine.state()))
    }

    /// [`Solver::contact_errors`] from the residual of the present state, with zones.
    pub(in crate::solve) fn contact_errors_of(&self, residual: &Residual) -> ContactErrors {
        let side = &self.engine.contact;
        let window = |slave, master| self.window(side, slave, master);
        let gaps = smallest_gaps(side, residual, self.engine.state().positions(), window);
        let penetration = gaps.values.iter().map(|g| -g).fold(0.0, f64::max) / side.min_radius;
        ContactErrors { gaps, penetration }
    }

    /// Arc length \[L\] within which an offset belongs to a contact (with an obstacle, without a master), and is raised
    /// and lowered by its smallest gap: where the contact may still be one and the same point. In a wider window an
    /// offset would see other contacts too, not be lowered while strands touch there, and hold open strands that are
    /// apart at its own place; in a narrower one it would be raised at wave numbers q that the rods do not follow: of
    /// these an augmentation mends only a share κ/(κ + Bq⁴). For that reason it is never shorter than an element
    /// either.
    pub(in crate::solve) fn window(&self, side: &ContactSide, slave: usize, master: Option<usize>) -> f64 {
        let rod = |segment: usize| &self.engine.model.rods[self.engine.rod_of(side.nodes[segment][0])];
        let (a, b) = (rod(slave), master.map(rod));
        // obstacles do not bend
        let bending = [a.section.smaller_bending(), b.map_or(f64::INFINITY, |b| b.section.smaller_bending())];
        let stiffness = match side.law {
            Law::Linear { stiffness } => stiffness,
            Law::Core { pressure, .. } => {
                let distance = 2.0 * side.min_radius;
                side.law.response(side.law.overlap(TYPICAL_PRESSURE * pressure, distance), distance).stiffness
            }
        };
        let half_point = 0.5 * shortest_line(stiffness, bending);
        half_point.max(a.length / a.num_elements as f64)
    }

    /// Next task until penetrations are within the tolerance of the secant steps, and no gap is open under force that
    /// can be released.
    pub(in crate::solve) fn outstanding(&self, secant_steps: &mut SecantSteps) -> Outstanding {
        if self.engine.contact.is_empty() {
            return Outstanding { penetration: 0.0, complementarity: Some(0.0), gaps: None };
        }
        let residual = self.engine.residual(self.engine.state());
        let ContactErrors { mut gaps, penetration } = self.contact_errors_of(&residual);
        let met = penetration <= secant_steps.tol;
        let mut outstanding = Outstanding { penetration, complementarity: None, gaps: None };
        let mut releases = false;
        // at first offsets are both lowered and raised, because they come from another law; later they are lowered only
        // if nothing is to be raised, because both together may never end (a ply of three strands)
        if secant_steps.rounds < FREE_ROUNDS || met {
            let Complementarity { work, releasable, gaps: own } = self.complementarity(&residual);
            outstanding.complementarity = met.then_some(work);
            if releasable > NOTHING {
                let side = &self.engine.contact;
                let own = secant_steps.not_in_vain(&side.set, &own).at_places_of(&side.set, &gaps).values;
                releases = own.iter().any(|gap| *gap > 0.0);
                gaps = gaps.map(|k, gap| if own[k] > 0.0 { own[k] } else { gap });
            }
        }
        secant_steps.rounds += 1;
        outstanding.gaps = (!met || releases).then_some(gaps);
        outstanding
    }

    /// Raises and lowers the offsets by secant steps that close the smallest gap near each node, never below zero.
    pub(in crate::solve) fn augment(&mut self, gaps: &ContactField, secant_steps: &mut SecantSteps) {
        let side = &mut self.engine.contact;
        let open = OPEN * side.min_radius;
        let before = side.offsets.at_places_of(&side.set, gaps);
        secant_steps.adapt(&side.set, gaps, [secant_steps.tol * side.min_radius, open]);
        let raised = |k: usize, gap: f64| {
            let offset = before.values[k];
            // lowering offsets of closed gaps little by little would keep others from closing
            let is_closed = gap > 0.0 && gap <= open;
            if is_closed { offset } else { (offset - secant_steps.secant_steps.values[k] * gap).max(0.0) }
        };
        let offsets = gaps.map(raised);
        secant_steps.before = Some([gaps.clone(), before.map(|k, offset| offset - offsets.values[k])]);
        side.change_law(side.law, offsets);
    }
}

/// Secant steps of the offsets. At the edge of a zone, or between two nodes that carry a contact, a gap may hardly
/// depend on the offset; lowered by the gap alone, such an offset would not let go. Overlaps that vary from node to
/// node would hardly close: at a wave number q rods follow an offset by a share κ/(κ + Bq⁴) of it.
#[derive(Debug)]
pub(in crate::solve) struct SecantSteps {
    /// Penetration that is tolerated, over the smallest contact radius.
    tol: f64,
    secant_steps: ContactField,
    /// Gap at the last augmentation, and the decrease of the offset in it \[L\].
    before: Option<[ContactField; 2]>,
    /// Gap of each place when it was released last \[L\], and how many releases there did not halve it.
    released: Option<[ContactField; 2]>,
    /// Number of rounds so far.
    rounds: usize,
}

impl SecantSteps {
    /// Before the first augmentation; of a penetration that is tolerated, over the smallest contact radius.
    pub(in crate::solve) fn new(tol: f64) -> Self {
        Self { tol, secant_steps: ContactField::default(), before: None, released: None, rounds: 0 }
    }

    /// Gaps to release: none where that was in vain. On lines of contact along a coarse mesh the ripples of elements
    /// stay open; the secant needs two tries to find how fast a gap closes (`contact_held_open`).
    fn not_in_vain(&mut self, set: &CurveSet, gaps: &ContactField) -> ContactField {
        let [last, in_vain] = match &self.released {
            Some(fields) => fields.each_ref().map(|field| field.at_places_of(set, gaps)),
            None => [(); 2].map(|()| gaps.map(|_, _| 0.0)),
        };
        let again = |k: usize, gap: f64| last.values[k] > 0.0 && gap > 0.5 * last.values[k];
        let in_vain = in_vain.map(|k, count| if again(k, gaps.values[k]) { count + 1.0 } else { count });
        let left = gaps.map(|k, gap| if in_vain.values[k] < MAX_RELEASES as f64 { gap } else { 0.0 });
        let last = last.map(|k, last| if left.values[k] > 0.0 { left.values[k] } else { last });
        self.released = Some([last, in_vain]);
        left
    }

    /// Factors for these gaps: 1 at first; where an overlap is not tolerated \[L\] or a gap is wider than `open` \[L\],
    /// though the offset was changed for it, the factor that would have closed it, at most [`MAX_SECANT_GROWTH`] times
    /// the last. An overlap that does not follow at all, as between supports, does not say how far to go.
    fn adapt(&mut self, set: &CurveSet, gaps: &ContactField, [tolerated, open]: [f64; 2]) {
        let Some(before) = &self.before else {
            self.secant_steps = gaps.map(|_, _| 1.0);
            return;
        };
        let [before, lowered] = before.each_ref().map(|numbers| numbers.at_places_of(set, gaps).values);
        let secant_steps = self.secant_steps.at_places_of(set, gaps).values;
        self.secant_steps = gaps.map(|k, gap| {
            let is_met = (-tolerated..=open).contains(&gap);
            let stays = !is_met && gap * lowered[k] > 0.0;
            let followed = if stays { ((before[k] - gap) / lowered[k]).max(0.0) } else { 1.0 };
            let is_held = gap < 0.0 && followed < NOTHING;
            let factor = if is_held { 1.0 } else { 1.0 / followed };
            factor.min(MAX_SECANT_GROWTH * secant_steps[k]).max(1.0)
        });
    }
}
