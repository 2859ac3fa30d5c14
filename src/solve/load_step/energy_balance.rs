//! Energy balance of a load step: a snap is reported by the energy that is missing.
//!
//! Along a branch the energy E of equilibria changes by the work of what is prescribed: dE = Σ F dλ, F = ∂E/∂λ at a
//! fixed configuration. For turns of seams F is the twisting moment, for motions of supports the reactions, for
//! obstacles and contact radii the contact forces, for load factors, pressures and other numbers of rods the derivative
//! of the potential itself. Let W₀ and W₁ be the work of a step under the forces at its start and at its end. Along a
//! smooth branch E₁ − E₀ is ½ (W₀ + W₁) but for an error of third order.
//!
//! With the change ΔW of the last step's work, and r the step over the last one, the branch goes on to
//!
//! ```text
//! E* = E₀ + W₀ + ½ r² ΔW        E₀ + min(W₀, W₁) where no last step is known
//! ```
//!
//! A step that ends lower by a tenth of the work, and lower than its own balance, too, has left its branch by a snap.
//! It has set free E* − E₁. Where a branch bends sharply, as that of a strut does that buckles, E* is missed, too, but
//! not the balance.
//!
//! The four numbers E₁ − E₀, W₀, W₁ and ΔW do not tell all snaps from all curvatures. Such steps are made again in
//! halves ([`Solver::advance`]):
//! * With r = 10, a ring that loses one of two contacts has the numbers of a smooth parabola of F. So a step too long
//!   to be predicted that ends lower or higher by a hundredth of its work, and whose search neither began where the
//!   branch leads nor found it unstable there, is halved until the branch can be predicted from its own states.
//! * A step that ends far below E*, but not clearly below its balance, is that of a branch which bends much, as that of
//!   a taut rope which is let down (for a parabola of F, E* − E₁ is −5 times ½ (W₀ + W₁) − (E₁ − E₀)) or of a ring
//!   that buckles, or that of a snap into a state of other forces. Unless it ends where it was foreseen it is halved
//!   [`HALVINGS_OF_A_BEND`] times. A snap sets as much free in a half as in the whole; what a smooth branch misses
//!   falls eightfold.
//!
//! E is what the rods store and the loads: elasticity, screened charges, dead loads and pressures. Contact that is
//! enforced closes gaps exactly and stores nothing, whatever the offsets of its law; a penalty's energy is stored.

use crate::contact::potential::surface::SurfaceZone;
use crate::math::Vec3;
use crate::rod::RodNumber;
use crate::scene::ContactLaw;
use crate::scene::model::Push;
use crate::solve::load_step::solver::Solver;
use crate::solve::measures::{LAST_PLACES, NOTHING, ROUNDING};
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::{Lifted, PrescribedMotion, Target};
use crate::solve::problem::state::{PrescribedValue, State};
use crate::solve::search::contact_balance::bends_nothing;

/// Part of the change of numbers in central differences of the potential, because the fifth derivative counts by its
/// fourth power, 1e-12, and rounding is divided by no less.
const DIFFERENCE: f64 = 1e-3;

/// Part of the energy set free by which the balance of a step's own forces is open at least, because it is 0.11 where a
/// ring of DNA unfolds and 0.46 where it supercoils, and 0.03 in the step after a loop has buckled.
const CLOSED: f64 = 0.05;

/// The same of a step that has clearly snapped, because it is up to 0.08 where a ring buckles under pressure without a
/// snap, in steps of a quarter of the critical one.
const CLEAR: f64 = 0.1;

/// Part of its work by which a step ends below its branch at least if it is reported as a snap, because steps that bend
/// sharply miss their branch by a few hundredths.
const SNAP: f64 = 0.1;
/// Part of its work by which the energy of a step may miss that of its branch before the step is made again in halves,
/// because a doubt costs iterations only: a tenth of what is reported as a snap. A ring that lost one of two contacts
/// missed it by 0.096.
const DOUBTFUL: f64 = 0.01;

/// Times that a step is halved which has snapped or bends, because what a smooth branch misses then is a sixteenth,
/// over its work, and more than sixteen times [`SNAP`] is no bend.
pub(super) const HALVINGS_OF_A_BEND: usize = 2;

/// Changes that a step prescribes.
#[derive(Debug)]
pub(in crate::solve) struct Changes {
    drive: PrescribedMotion,
    /// Angles by which nodes are spun about their tangents, rad.
    spun: Vec<(usize, f64)>,
    /// Load factor, pressures, obstacles and numbers before and after.
    from: State,
    to: State,
}

/// Energy of an equilibrium, and the work of a step under its forces \[F·L\].
#[derive(Debug, Clone, Copy)]
pub(in crate::solve) struct Balance {
    energy: f64,
    pub(in crate::solve) work: f64,
    /// Rounding of the energy and of the work \[F·L\].
    rounding: f64,
}

impl Changes {
    /// Numbers of rods that change, with their values after it.
    fn numbers(&self) -> impl Iterator<Item = (&(usize, RodNumber), &f64)> {
        self.to.numbers().iter().filter(|(key, value)| self.from.numbers().get(key) != Some(value))
    }
}

/// How the end of a step compares with where its branch leads.
#[derive(Debug, Clone, Copy)]
pub(in crate::solve) struct Departure {
    /// Energy below the branch's \[F·L\].
    released: f64,
    /// What the balance of the step's own forces lacks \[F·L\].
    gap: f64,
    /// Size of the step's work \[F·L\].
    work: f64,
    rounding: f64,
}

impl Departure {
    /// Whether it is more than a part of the work.
    fn is_above(&self, part: f64) -> bool {
        self.released.abs() > part * self.work + self.rounding
    }

    /// Whether the branch may be lost, if nothing else is known of the step: neither E* nor the balance of the step's
    /// own forces is met. A state of another branch may lie higher.
    pub(in crate::solve) fn is_doubtful(&self) -> bool {
        self.is_above(DOUBTFUL) && self.gap.abs() > CLOSED * self.released.abs()
    }

    /// Energy that the step has set free \[F·L\], where it ends below both; 0 on a branch.
    pub(in crate::solve) fn released(&self) -> f64 {
        if self.is_above(SNAP) && self.gap > CLOSED * self.released { self.released.max(0.0) } else { 0.0 }
    }

    /// Whether the step ends below E*, but not clearly below the balance: it has snapped, or its branch bends.
    pub(in crate::solve) fn snaps_or_bends(&self) -> bool {
        let is_open = self.gap.abs() > CLOSED * self.released && self.gap < CLEAR * self.released;
        self.is_above(SNAP) && self.released > 0.0 && is_open
    }
}

impl Balance {
    /// How the end of a step from here compares with its branch. `last` is the work of the step before
    /// under the forces at both of its ends, and how many times as long this step is.
    pub(in crate::solve) fn departure(&self, end: &Self, last: Option<([f64; 2], f64)>) -> Departure {
        let branch = last.map_or(self.work.min(end.work), |([start, end], stride)| {
            self.work + 0.5 * stride * stride * (end - start)
        });
        let gained = end.energy - self.energy;
        let (released, gap) = (branch - gained, 0.5 * (self.work + end.work) - gained);
        let work = self.work.abs().max(end.work.abs()).max(branch.abs());
        Departure { released, gap, work, rounding: self.rounding + end.rounding }
    }
}

impl Solver {
    /// The changes of a target, whose drive is `lifted`, from the present state.
    pub(in crate::solve) fn changes(&self, target: &Target, lifted: &Lifted) -> Changes {
        let from = self.engine.state().clone();
        let mut to = from.clone();
        to.prescribe(target.values());
        let drive = PrescribedMotion { seams: target.drive.seams.clone(), nodes: lifted.drive.nodes.clone() };
        Changes { drive, spun: lifted.spun.clone(), from, to }
    }

    /// The balance at the present equilibrium; `None` where the energy or a force has no closed form: fixed-axis
    /// moments, a penalty's stiffness that follows ramped numbers, charges on a rod that grows.
    pub(in crate::solve) fn balance(&mut self, changes: &Changes) -> Option<Balance> {
        let engine = &mut self.engine;
        let is_penalty = matches!(engine.model.contact.law, ContactLaw::Penalty { .. });
        let grows = changes.numbers().any(|((_, which), _)| *which == RodNumber::Length);
        let unclear =
            is_penalty && changes.numbers().next().is_some() || grows && engine.model.electrostatics.is_some();
        if unclear || engine.bears_moments() {
            return None;
        }
        let state = engine.state().clone();
        engine.update_contact(&state).ok()?;
        let residual = engine.residual(&state);
        let elastic = residual.potential.elastic.total();
        let kept = if is_penalty { residual.potential.contact } else { 0.0 };
        let energy = elastic + residual.potential.electrostatic + residual.potential.load + kept;
        let of_contact = work_of_contact(engine, &residual, changes);
        let work = work_of_motions(engine, &residual, changes) + of_contact + work_of_numbers(engine, &state, changes);
        // a search does not balance such forces
        let of_nothing = if bends_nothing(engine, &residual) { of_contact.abs() } else { 0.0 };
        // what a rod without forces stores is nothing beside that of a bend
        let bent: f64 = engine.model.rods.iter().map(|rod| rod.section.smaller_bending() / rod.length).sum();
        let stored = elastic + residual.potential.electrostatic;
        let rounding = ROUNDING * stored + NOTHING * bent + of_nothing + rounding_of_reactions(engine, changes);
        Some(Balance { energy, work, rounding })
    }
}

/// Of the work of reactions: strains are known to some units in the last place, the largest tension to that part of EA.
/// Beams of steel that no force has reached yet have reactions of 1e-8 N.
fn rounding_of_reactions(engine: &Engine, changes: &Changes) -> f64 {
    let stiffest = engine.model.rods.iter().map(|rod| rod.section.stretching).fold(0.0, f64::max);
    let way: f64 = changes.drive.nodes.iter().map(|(_, displacement, _)| displacement.norm()).sum();
    LAST_PLACES * f64::EPSILON * stiffest * way
}

fn work_of_motions(engine: &Engine, residual: &Residual, changes: &Changes) -> f64 {
    let force = |node: usize| {
        let owner = &engine.sharing.owner[node];
        let of = |k: usize| Vec3::from_column_slice(&residual.gradient[6 * owner[k] + k..6 * owner[k] + k + 3]);
        (of(0), of(3))
    };
    let seams = changes.drive.seams.iter().zip(&residual.seam_moments).map(|(angle, moment)| angle * moment);
    let supports = changes.drive.nodes.iter().map(|&(node, displacement, rotation)| {
        let (force, moment) = force(node);
        force.dot(&displacement) + moment.dot(&rotation)
    });
    let spins = changes.spun.iter().map(|&(node, angle)| {
        let tangent = engine.state().frames()[node] * Vec3::z();
        force(node).1.dot(&tangent) * angle
    });
    seams.chain(supports).chain(spins).fold(0.0, |sum, work| sum + work)
}

/// Of obstacles that move and contact radii that grow: contact forces times what they close gaps by.
fn work_of_contact(engine: &Engine, residual: &Residual, changes: &Changes) -> f64 {
    let side = &engine.contact;
    let growth = |segment: usize| {
        let key = (side.rods[side.set.curve_of(segment)], RodNumber::ContactRadius);
        let at = |state: &State| state.numbers().get(&key).copied();
        at(&changes.to).zip(at(&changes.from)).map_or(0.0, |(to, from)| to - from)
    };
    let pairs = residual.contact_pairs.iter().map(|pair| {
        let force = pair.zones.iter().fold(0.0, |sum, zone| sum + zone.force);
        force * (growth(pair.slave) + growth(pair.master))
    });
    let obstacles = residual.surface_contacts.iter().map(|contact| {
        let (k, at) = (contact.surface, side.set.segments[contact.segment].b[0]);
        let moved = [&changes.from.placements()[k], &changes.to.placements()[k]];
        let of_zone = |zone: &SurfaceZone| {
            let [pressure, ..] = zone.moments;
            let push = Push { pressure, force: zone.force, torque: zone.torque, at };
            let work = side.obstacles[k].work(&engine.state().placements()[k], moved, &push);
            pressure * growth(contact.segment) + work
        };
        contact.zones.iter().map(of_zone).fold(0.0, |sum, work| sum + work)
    });
    pairs.chain(obstacles).fold(0.0, |sum, work| sum + work)
}

/// Of load factors, pressures and numbers of rods: central differences of the potential at a fixed configuration. The
/// third derivative is left out: that of a stiff rod by its length is far larger than what bends store.
fn work_of_numbers(engine: &mut Engine, state: &State, changes: &Changes) -> f64 {
    let Changes { from, to, .. } = changes;
    let numbers: Vec<_> = changes.numbers().collect();
    if from.load_factor() == to.load_factor() && from.pressures() == to.pressures() && numbers.is_empty() {
        return 0.0;
    }
    let mut at = |part: f64| {
        let mut moved = state.clone();
        let along = |from: f64, to: f64| part * (to - from);
        let load = state.load_factor() + along(from.load_factor(), to.load_factor());
        moved.prescribe([PrescribedValue::Load(load)]);
        let pressure = |rod: usize| state.pressures()[rod] + along(from.pressures()[rod], to.pressures()[rod]);
        moved.prescribe((0..state.pressures().len()).map(|rod| PrescribedValue::Pressure(rod, pressure(rod))));
        moved.prescribe(numbers.iter().filter_map(|&(key, to)| {
            let change = from.numbers().get(key).map_or(0.0, |from| along(*from, *to));
            state.numbers().get(key).map(|value| PrescribedValue::Number(key.0, key.1, value + change))
        }));
        engine.potential_without_contact(&moved)
    };
    let mut difference = |part: f64| (at(part) - at(-part)) / (2.0 * part);
    // without the third derivative
    (4.0 * difference(0.5 * DIFFERENCE) - difference(DIFFERENCE)) / 3.0
}
