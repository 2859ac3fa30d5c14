//! Round the corners of a path: where a contact begins or ends, the first, the last or one among others.
//!
//! While strands are apart the path has the tangent t₋ of the rods and of the contacts there are, K Δ + c δλ = 0. From
//! first touch on a force of some pattern N (forces and moments on the nodes) keeps the gap closed, K Δ + c δλ + N δp =
//! 0 with N·Δ = 0: another tangent t₊. Its direction is the one in which the force rises. Where a contact ends it is
//! the other way round: the force has come to zero, and the tangent without it goes on in the direction in which the
//! gap opens. λ may turn back at such a point, and unstable directions appear or vanish without an eigenvalue that
//! passes zero.
//!
//! Newton's method does not converge from one side to the other, because before contact the tangent has no contact
//! stiffness. So the first point beyond is predicted with the overlap under which the contact law exerts the force
//! expected there.

use crate::error::SolveError;
use crate::solve::measures::{ARC, HALVINGS};
use crate::solve::path::continuation::MAX_CHORD;
use crate::solve::path::continuation::contacts::LabelledContacts;
use crate::solve::path::continuation::corrector::{Hyperplane, PathMotion, Point, Tracer};

/// Part of the reach, or of the place of a corner, by which a point is clear of it.
const CLEAR: f64 = 0.01;
/// Largest change of a gap along a corner's directions, over the contact radius, because its linearisation holds so
/// far.
const CHANGE: f64 = 0.1;

/// A corner and the first point beyond it.
pub(super) struct Corner {
    /// Extrapolated along the tangent before it.
    pub(super) corner: Point,
    /// Arc length from the base to the corner.
    pub(super) before: f64,
    pub(super) next: Point,
    /// Arc length from the corner to `next`.
    pub(super) after: f64,
}

/// Which contacts begin or end at a corner.
struct Change {
    begins: bool,
    /// If they begin: the others, that were there before; if they end: they themselves, as they were.
    known: LabelledContacts,
}

/// The tangent beyond a corner and the rate of the contact force along it.
struct Beyond {
    tangent: PathMotion,
    force_rate: f64,
    /// Force of the contacts that begin or end, of unit size.
    pattern: Vec<f64>,
    change: Change,
    /// A motion that presses the strands together: positive work against the pattern.
    press: PathMotion,
}

impl Tracer<'_> {
    /// The way on from `here` if a contact begins or ends within the arc length `reach` along the tangent; `longest` is
    /// the first step tried beyond. `None` where nothing of that kind happens or no point was found beyond.
    pub(super) fn round_corner(
        &mut self,
        here: &Point,
        reach: f64,
        longest: f64,
    ) -> Result<Option<Corner>, SolveError> {
        if self.solver.engine.contact.is_empty() {
            return Ok(None);
        }
        self.enter(here)?;
        let at = |s: f64| here.tangent.scaled(s);
        let Some((change, place)) = self.next_change(here, reach)? else { return Ok(None) };
        let begins = change.begins;
        let clear = place + CLEAR * reach;
        let force = self.changing_force(here, &at(if begins { clear } else { 0.0 }), &change)?;
        let size = norm(&force);
        let pattern: Vec<f64> = force.iter().map(|f| f / size).collect();
        // along the path a force that ends falls evenly; with the tangent's overlap, as its power 3/2 at points, it
        // lasts longer
        let little = CLEAR * place;
        let before = if begins {
            place
        } else {
            (little * size / (size - norm(&self.changing_force(here, &at(little), &change)?))).min(place)
        };
        // contact out of the way
        let free = self.moved(here, &at(if begins { 0.0 } else { clear }));
        let Some(beyond) = self.beyond(&free, pattern, change)? else { return Ok(None) };
        let mut corner = self.moved(here, &at(before));
        corner.tangent = here.tangent.clone();
        (corner.num_unstable, corner.num_contacts) = (here.num_unstable, here.num_contacts);
        let mut after = longest;
        while after > before {
            let next = self.first_beyond(here, &at(before), &beyond, after);
            if let Some(next) = next.unwrap_or(None) {
                return Ok(Some(Corner { corner, before, next, after }));
            }
            after *= 0.5;
        }
        Ok(None)
    }

    /// The first contact that begins or ends along the tangent, and where.
    fn next_change(&mut self, here: &Point, reach: f64) -> Result<Option<(Change, f64)>, SolveError> {
        let at = |s: f64| here.tangent.scaled(s);
        let before = self.contacts_after(here, &at(0.0))?;
        let missing = |tracer: &Self, some: &LabelledContacts, others: &LabelledContacts| -> Vec<bool> {
            let side = &tracer.solver.engine.contact;
            some.found_among(others, &side.set, side.min_radius).iter().map(|found| !found).collect()
        };
        let changes = |tracer: &mut Self, s: f64| -> Result<[Vec<bool>; 2], SolveError> {
            let there = tracer.contacts_after(here, &at(s))?;
            Ok([missing(tracer, &there, &before), missing(tracer, &before, &there)])
        };
        let any = |changed: &[Vec<bool>; 2]| changed.iter().flatten().any(|c| *c);
        if !any(&changes(self, reach)?) {
            return Ok(None);
        }
        let (mut low, mut high) = (0.0, reach);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            *(if any(&changes(self, middle)?) { &mut high } else { &mut low }) = middle;
        }
        let [new, gone] = changes(self, high + CLEAR * reach)?;
        let begins = new.iter().any(|c| *c);
        if !begins && !gone.iter().any(|c| *c) {
            return Ok(None);
        }
        let known = if begins { before } else { before.only(&gone) };
        Ok(Some((Change { begins, known }, high)))
    }

    /// A point moved from another, without tangent.
    pub(super) fn moved(&self, base: &Point, motion: &PathMotion) -> Point {
        let mut point = Point { iterations: 0, augmentations: 0, penetration: 0.0, ..base.clone() };
        point.state = self.solver.engine.retract(&base.state, &motion.field, 1.0);
        self.parameter.advance(&mut point.state, motion.parameter);
        point.value += motion.parameter;
        point
    }

    /// The contacts at a point moved from another; the engine is left there.
    fn contacts_after(&mut self, base: &Point, motion: &PathMotion) -> Result<LabelledContacts, SolveError> {
        let state = self.moved(base, motion).state;
        let solver = &mut *self.solver;
        solver.engine.update_contact(&state)?;
        solver.engine.take_state(state);
        Ok(LabelledContacts::of(solver))
    }

    /// Gradient of the contact potential at a point moved from another, of the contacts that begin or end.
    fn changing_force(&mut self, base: &Point, motion: &PathMotion, change: &Change) -> Result<Vec<f64>, SolveError> {
        let there = self.contacts_after(base, motion)?;
        let engine = &self.solver.engine;
        let side = &engine.contact;
        let known = there.found_among(&change.known, &side.set, side.min_radius);
        let chosen: Vec<bool> = known.iter().map(|known| *known != change.begins).collect();
        Ok(there.gradient(engine, &chosen))
    }

    /// The path beyond a corner near a point without the contact that begins or has ended.
    fn beyond(&mut self, free: &Point, pattern: Vec<f64>, change: Change) -> Result<Option<Beyond>, SolveError> {
        self.enter(free)?;
        self.linearise_there(&free.state)?;
        let stress = self.solver.engine.actual_stress(&free.state);
        let mut along = self.response_to_parameter(&free.state, &stress);
        let force: Vec<f64> = pattern.iter().map(|f| -f).collect();
        let solver = &mut *self.solver;
        let apart = PathMotion { field: solver.workspace.respond(&solver.engine, &force), parameter: 0.0 };
        let work = |motion: &PathMotion| motion.field.iter().zip(&pattern).map(|(x, f)| x * f).sum::<f64>();
        let mut force_rate = 0.0;
        // the force rises, or the gap opens
        let mut sense = -work(&along);
        if change.begins {
            force_rate = -work(&along) / work(&apart);
            along.subtract(&apart, -force_rate);
            sense = force_rate;
        }
        let scale = sense.signum() / self.dot(&along, &along).sqrt();
        let (tangent, press) = (along.scaled(scale), apart.scaled(work(&apart).signum()));
        let finite = scale.is_finite() && force_rate.is_finite();
        Ok(finite.then(|| Beyond { tangent, force_rate: (force_rate * scale).abs(), pattern, change, press }))
    }

    /// The point of the path at the arc length `after` beyond the corner.
    fn first_beyond(
        &mut self,
        here: &Point,
        to_corner: &PathMotion,
        beyond: &Beyond,
        after: f64,
    ) -> Result<Option<Point>, SolveError> {
        self.enter(here)?;
        let mut first = to_corner.clone();
        first.subtract(&beyond.tangent, -after);
        if beyond.force_rate > 0.0 {
            let Some(pressed) = self.pressed(here, &first, beyond, beyond.force_rate * after)? else {
                return Ok(None);
            };
            first = pressed;
        }
        let plane = Hyperplane { normal: &beyond.tangent, distance: self.dot(&beyond.tangent, &first) };
        let found = self.correct(here, &first, &plane)?;
        let along = |point: &Point| self.dot(&point.tangent, &beyond.tangent) >= ARC.cos();
        Ok(found
            .filter(|point| along(point) && point.chord <= MAX_CHORD * (after + self.dot(to_corner, to_corner).sqrt())))
    }

    /// The part along the pattern of the force of the contacts that begin or end, at a point moved from another.
    fn exerted(&mut self, here: &Point, motion: &PathMotion, beyond: &Beyond) -> Result<f64, SolveError> {
        let there = self.changing_force(here, motion, &beyond.change)?;
        Ok(there.iter().zip(&beyond.pattern).map(|(g, f)| g * f).sum())
    }

    /// The motion with as much pressing added, or taken away, as the contact law needs for a `force` of the pattern.
    fn pressed(
        &mut self,
        here: &Point,
        motion: &PathMotion,
        beyond: &Beyond,
        force: f64,
    ) -> Result<Option<PathMotion>, SolveError> {
        let radius = self.solver.engine.contact.min_radius;
        let largest = beyond.press.field.chunks(6).flat_map(|node| &node[..3]).fold(0.0f64, |a, b| a.max(b.abs()));
        let with = |amount: f64| {
            let mut pressed = motion.clone();
            pressed.subtract(&beyond.press, -amount);
            pressed
        };
        let (mut low, mut high) = (-CHANGE * radius / largest, CHANGE * radius / largest);
        for end in [low, high] {
            if (self.exerted(here, &with(end), beyond)? > force) != (end == high) {
                return Ok(None);
            }
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let exerted = self.exerted(here, &with(middle), beyond)?;
            *(if exerted > force { &mut high } else { &mut low }) = middle;
        }
        Ok(Some(with(0.5 * (low + high))))
    }
}

fn norm(forces: &[f64]) -> f64 {
    forces.iter().map(|f| f * f).sum::<f64>().sqrt()
}
