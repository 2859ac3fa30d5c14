//! Pressures of contact as they pass from one law to the next: what the law in force gives, and offsets that give a new
//! law the same.

use crate::contact::curve::CurveSet;
use crate::contact::law::{Law, shortest_line};
use crate::solve::load_step::complementarity::{Complementarity, TOL_COMPLEMENTARITY, TOL_OPENING};
use crate::solve::path::run::Solver;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::contact_field::{self, ContactField};
use crate::solve::problem::contact_side::ContactSide;

/// Pressure, over a core law's own, at which its stiffness is read.
const USUAL_PRESSURE: f64 = 0.1;
/// Largest growth of a secant step from one augmentation to the next. A secant through two nearly equal gaps would
/// overshoot.
const FASTER: f64 = 2.0;
/// Releases in a row, none of which brings the work of offsets on what they hold open below half of its least, after which
/// no more is released: on lines of contact along a coarse mesh the ripples of elements stay open. The secant takes
/// that many to find how fast a gap closes.
const IN_VAIN: usize = 2;
/// First rounds in which offsets are lowered and raised at once, because they come from another law. Later rounds lower
/// only when nothing is left to raise: doing both at once may go on for ever (a ply of three strands).
const EARLY: usize = 3;

/// How far the contact conditions are from met, by nodes and in all.
#[derive(Debug, Default)]
pub(in crate::solve) struct ContactErrors {
    /// Smallest gap of each contact near each node, see [`Solver::window`] \[L\]; infinite where nothing is in reach.
    pub(in crate::solve) gaps: ContactField,
    /// Worst penetration over the smallest contact radius.
    pub(in crate::solve) penetration: f64,
}

/// What an augmented Lagrangian has yet to do.
#[derive(Debug)]
pub(in crate::solve) struct Outstanding {
    /// Worst penetration over the smallest contact radius.
    pub(in crate::solve) penetration: f64,
    /// Work of offsets on what they hold open over the elastic energy; none while the contact conditions are not met.
    pub(in crate::solve) complementarity: Option<f64>,
    /// What offsets are to be raised and lowered by \[L\]; none where all is done.
    pub(in crate::solve) gaps: Option<ContactField>,
}

impl Solver {
    /// Replaces the law; the pressures of the state at rest become those of strands that just touch.
    pub(in crate::solve) fn change_law_keeping_pressures(&mut self, law: Law) {
        let pressures = self.pressures();
        self.change_law_to(law, &pressures);
    }

    /// Replaces the law, with offsets that give touching strands these pressures (per node; none if empty).
    pub(in crate::solve) fn change_law(&mut self, law: Law, pressures: &[f64]) {
        let mut of_nodes = pressures.to_vec();
        of_nodes.resize(self.engine.num_nodes(), 0.0);
        let num_planes = self.engine.model.planes.len();
        self.change_law_to(law, &ContactField::of_nodes(&of_nodes, num_planes));
    }

    fn change_law_to(&mut self, law: Law, pressures: &ContactField) {
        let Some(side) = &mut self.engine.contact else { return };
        let distance = 2.0 * side.min_radius;
        side.change_law(law, pressures.map(|_, pressure| law.overlap(pressure, distance)));
    }

    /// Replaces the law like [`Solver::change_law`]; the first step starts from the new law's pressures instead of the
    /// old ones.
    pub(in crate::solve) fn start_under(&mut self, law: Law, pressures: &[f64]) {
        self.change_law(law, pressures);
        self.forget_pressures();
    }

    /// The first step after a change of law or offsets starts from the present pressures instead of those before.
    pub(in crate::solve) fn forget_pressures(&mut self) {
        if let Some(side) = &mut self.engine.contact {
            side.before = None;
        }
    }

    /// Gives the nodes offsets that make smooth pressures of the gaps there are: the means of the present ones over an
    /// element. Elements in line contact have ripples, and offsets that are the same along a line make ripples of the
    /// pressure of them. Strands in which these face each other lower the energy by sliding along each other; under
    /// smooth pressures they raise it. For a single closed rod.
    pub(in crate::solve) fn smooth_pressures(&mut self) {
        let gaps = self.node_gaps();
        let (nodes, order) = (gaps.len(), self.engine.model.rods[0].order);
        let Some(side) = &mut self.engine.contact else { return };
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
        let offsets = ContactField::of_nodes(&offsets, side.planes.len());
        side.change_law(side.law, offsets);
    }

    /// Gap at each node \[L\]; infinite where nothing touches.
    fn node_gaps(&self) -> Vec<f64> {
        let Some(side) = &self.engine.contact else { return Vec::new() };
        let mut gaps = vec![f64::INFINITY; side.offsets.num_nodes()];
        for term in &self.engine.residual(&self.engine.state).contact_pairs {
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
        let Some(side) = &self.engine.contact else { return ContactField::default() };
        let offsets = side.offsets.at_places_of(&side.set, &gaps);
        gaps.map(|k, gap| {
            let pressure = side.law.response(offsets.values[k] - gap, 2.0 * side.min_radius).pressure;
            if pressure.is_finite() { pressure } else { 0.0 }
        })
    }

    /// How far the contact conditions are from met.
    pub(in crate::solve) fn contact_errors(&self) -> ContactErrors {
        if self.engine.contact.is_none() {
            return ContactErrors::default();
        }
        self.contact_errors_of(&self.engine.residual(&self.engine.state))
    }

    /// [`Solver::contact_errors`] from the residual of the present state, with zones.
    pub(in crate::solve) fn contact_errors_of(&self, residual: &Residual) -> ContactErrors {
        let Some(side) = &self.engine.contact else { return ContactErrors::default() };
        let window = |slave, master| self.window(side, slave, master);
        let gaps = contact_field::smallest_gaps(side, residual, &self.engine.state.positions, window);
        let penetration = gaps.values.iter().map(|g| -g).fold(0.0, f64::max) / side.min_radius;
        ContactErrors { gaps, penetration }
    }

    /// Arc length \[L\] within which an offset belongs to a contact (with a plane, without a master), and is raised and lowered by its smallest gap:
    /// where the contact may still be one and the same point. In a wider window an offset would see other contacts
    /// too, not be lowered while strands touch there, and hold open what is apart at its own place; in a narrower one
    /// it would be raised at wave numbers q that the rods do not follow: of these an augmentation mends only a share
    /// κ/(κ + Bq⁴). For that reason it is never shorter than an element either.
    pub(in crate::solve) fn window(&self, side: &ContactSide, slave: usize, master: Option<usize>) -> f64 {
        let rod = |segment: usize| &self.engine.model.rods[self.engine.rod_of(side.nodes[segment][0])];
        let (a, b) = (rod(slave), master.map(rod));
        // planes do not bend
        let bending = [a.section.smaller_bending(), b.map_or(f64::INFINITY, |b| b.section.smaller_bending())];
        let stiffness = match side.law {
            Law::Linear { stiffness } => stiffness,
            Law::Core { pressure, .. } => {
                let distance = 2.0 * side.min_radius;
                side.law.response(side.law.overlap(USUAL_PRESSURE * pressure, distance), distance).stiffness
            }
        };
        let half_point = 0.5 * shortest_line(stiffness, bending);
        half_point.max(a.length / a.num_elements as f64)
    }

    /// What is left to do until the contact conditions are met to a tolerance relative to the contact radius and
    /// offsets hold nothing open that can be released.
    pub(in crate::solve) fn outstanding(&self, tol: f64, secant_steps: &mut SecantSteps) -> Outstanding {
        if self.engine.contact.is_none() {
            return Outstanding { penetration: 0.0, complementarity: Some(0.0), gaps: None };
        }
        let residual = self.engine.residual(&self.engine.state);
        let ContactErrors { mut gaps, penetration } = self.contact_errors_of(&residual);
        let met = penetration <= tol;
        let mut outstanding = Outstanding { penetration, complementarity: None, gaps: None };
        let mut releases = false;
        if secant_steps.rounds < EARLY || met {
            let Complementarity { work, releasable, gaps: own } = self.complementarity(&residual);
            outstanding.complementarity = met.then_some(work);
            if met {
                secant_steps.note(releasable);
            }
            releases = releasable > TOL_COMPLEMENTARITY && secant_steps.in_vain < IN_VAIN;
            if let Some(side) = self.engine.contact.as_ref().filter(|_| releases) {
                let own = own.at_places_of(&side.set, &gaps).values;
                gaps = gaps.map(|k, gap| if own[k] > 0.0 { own[k] } else { gap });
            }
        }
        secant_steps.rounds += 1;
        outstanding.gaps = (!met || releases).then_some(gaps);
        outstanding
    }

    /// Raises the contact offsets by the smallest gap found around each node, never below zero; lowers them, each at
    /// its pace, where it is wider than it may stay.
    pub(in crate::solve) fn augment(&mut self, gaps: &ContactField, secant_steps: &mut SecantSteps) {
        let Some(side) = &mut self.engine.contact else { return };
        let open = TOL_OPENING * side.min_radius;
        let before = side.offsets.at_places_of(&side.set, gaps);
        secant_steps.adapt(&side.set, gaps, open);
        let raised = |k: usize, gap: f64| {
            let offset = before.values[k];
            // lowered by what may stay, little by little, an offset would keep others from closing their gaps
            let stays = gap > 0.0 && gap <= open;
            if stays { offset } else { (offset - secant_steps.secant_steps.values[k] * gap).max(0.0) }
        };
        let offsets = gaps.map(raised);
        secant_steps.before = Some([gaps.clone(), before.map(|k, offset| offset - offsets.values[k])]);
        side.change_law(side.law, offsets);
    }
}

/// How fast offsets that hold gaps open are lowered: a secant on offset and gap. At the edge of a zone, or between two
/// nodes that carry a contact, a gap may hardly depend on the offset, which lowered by the gap at a time would take for
/// ever to let go.
#[derive(Debug)]
pub(in crate::solve) struct SecantSteps {
    secant_steps: ContactField,
    /// Gap at the augmentation before, and by how much it lowered the offset \[L\].
    before: Option<[ContactField; 2]>,
    /// Least work of offsets on what they hold open and could release, over the elastic energy.
    least: f64,
    /// Releases in a row that did not halve it.
    in_vain: usize,
    /// How often it was asked what is left to do.
    rounds: usize,
}

impl Default for SecantSteps {
    fn default() -> Self {
        Self { secant_steps: ContactField::default(), before: None, least: f64::INFINITY, in_vain: 0, rounds: 0 }
    }
}

impl SecantSteps {
    /// Takes note of the work that is left to release where the contact conditions are met.
    fn note(&mut self, work: f64) {
        self.in_vain = if work > 0.5 * self.least { self.in_vain + 1 } else { 0 };
        self.least = self.least.min(work);
    }

    /// Paces for these gaps: 1 where strands touch or overlap; where a gap was `open` \[L\] before and still is, what
    /// would have closed it, at most [`FASTER`] than before.
    fn adapt(&mut self, set: &CurveSet, gaps: &ContactField, open: f64) {
        let Some(before) = &self.before else {
            self.secant_steps = gaps.map(|_, _| 1.0);
            return;
        };
        let [before, lowered] = before.each_ref().map(|numbers| numbers.at_places_of(set, gaps).values);
        let secant_steps = self.secant_steps.at_places_of(set, gaps).values;
        self.secant_steps = gaps.map(|k, gap| {
            let stays = gap > open && before[k] > open && lowered[k] > 0.0;
            let closed = if stays { ((before[k] - gap) / lowered[k]).max(0.0) } else { 1.0 };
            (1.0 / closed).min(FASTER * secant_steps[k]).max(1.0)
        });
    }
}
