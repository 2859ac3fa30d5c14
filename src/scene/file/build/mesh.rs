//! Default number of elements of a rod of a scene: see [`Fidelity::elements`].

use std::f64::consts::TAU;

use crate::error::InputError;
use crate::math::Vec3;
use crate::rod::{Axis, Natural, Section, Shape};
use crate::scene::Fidelity;

use super::by_base_pairs::Dna;
use super::gravity;
use crate::scene::file::syntax::values::{List, RodNames};
use crate::scene::file::syntax::{LawText, RampText, RodText, SceneText};

/// Turns of bending by moved supports, about one because a rod whose ends are brought together forms a loop.
const MOVED: f64 = 1.0;
/// Largest number of samples for the turning of a start shape, enough for any shape that can be run.
const FINEST: usize = 1 << 20;

/// A rod whose number of elements is not given.
pub(super) struct Unmeshed<'a> {
    pub scene: &'a SceneText,
    pub rod: &'a RodText,
    pub shape: &'a Shape,
    pub section: &'a Section,
    pub natural: &'a Natural,
    pub dna: Option<&'a Dna>,
    /// Pieces of a sequence: steps, or blocks of them.
    pub pieces: Option<usize>,
}

impl Unmeshed<'_> {
    /// Number of elements of the rod, with as many nodes as the cubic ones of the preset.
    pub(super) fn elements(&self, fidelity: Fidelity) -> Result<usize, InputError> {
        let (length, turns) = self.turns()?;
        let touches = !matches!(self.scene.contact.law, LawText::None);
        let cubic = fidelity.elements(length, turns, if touches { self.section.contact_radius } else { 0.0 });
        let elements = cubic.saturating_mul(Fidelity::ORDER).div_ceil(self.rod.order.max(1));
        Ok(elements.max(self.by_sequence().unwrap_or(0)))
    }

    /// Number of elements for a node a base pair, or a node a block of them; `None` without a sequence.
    pub(super) fn by_sequence(&self) -> Option<usize> {
        self.pieces.map(|pieces| pieces.div_ceil(self.rod.order.max(1)))
    }

    /// Length of a rod \[L\] and an estimate of its turns of bending and twist in the scene.
    fn turns(&self) -> Result<(f64, f64), InputError> {
        let Self { scene, rod, natural, .. } = *self;
        let (length, tangent_turns) = measure(self.shape, rod.closed)?;
        let by_nature = natural.turning(length) * length / TAU;
        let is_this = |name: &Option<String>| name.as_ref().is_none_or(|name| *name == rod.name);
        let is_among = |names: &RodNames| names.0.is_empty() || names.0.contains(&rod.name);
        let stages = || scene.stages.iter().map(|stage| &stage.ramp);
        let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
        let natural = natural.mean_twist(length) * length / TAU;
        let beyond = stages().flat_map(|r| &r.excess_link.0).filter(|r| is_this(&r.rod)).map(|r| r.to);
        let in_all = stages().flat_map(|r| &r.link.0).filter(|r| is_this(&r.rod)).map(|r| r.to);
        let density = stages().flat_map(|r| &r.sigma.0).filter(|r| is_this(&r.rod)).map(|r| r.to).chain(rod.sigma);
        let beyond = beyond.chain(density.map(|sigma| sigma * self.dna.map_or(0.0, |dna| dna.relaxed_link)));
        let link = largest(&mut beyond.chain(rod.excess_link).chain(in_all.chain(rod.link).map(|link| link - natural)));
        let wound = if rod.closed { 1.0 + link } else { 0.0 };
        let rotations = || stages().flat_map(|r| &r.rotation.0).filter(|r| is_among(&r.rod));
        let extra_turns =
            || stages().flat_map(|r| &r.pose.0).filter(|r| is_among(&r.rod)).filter_map(|r| r.extra_turns);
        let rotation = largest(&mut rotations().map(|r| r.turns).chain(extra_turns()).chain(rod.twist));
        let is_displaced = |r: &RampText| r.displacement.0.iter().any(|r| is_among(&r.rod));
        let is_posed = |r: &RampText| r.pose.0.iter().any(|r| is_among(&r.rod));
        let is_moved = stages().any(|r| is_displaced(r) || is_posed(r));
        let moved = if is_moved { MOVED } else { 0.0 };
        let factor = largest(&mut stages().filter_map(|r| r.load).chain([gravity::start_factor(scene)]));
        let size = |v: List<f64, 3>| v.0.iter().map(|x| x * x).sum::<f64>().sqrt() * factor;
        let together = joined(scene, &rod.name);
        // a load as often as rods feel it
        let felt = |names: &RodNames| match names.0.len() {
            0 => 1,
            _ => names.0.iter().filter(|name| together.contains(&name.as_str())).count(),
        };
        let loads = || scene.loads.iter().flat_map(|load| std::iter::repeat_n(load, felt(&load.rod)));
        let force: f64 = loads().map(|load| size(load.force)).sum();
        let line_loads = || scene.line_loads.iter().flat_map(|load| std::iter::repeat_n(load, felt(&load.rod)));
        let spread: f64 = line_loads().map(|load| size(load.moment)).sum();
        let moment = loads().map(|load| size(load.moment)).sum::<f64>() + spread * length;
        let weight = gravity::weight(scene, rod, length)?.map_or(0.0, |weight| weight.norm() * factor);
        let line: f64 = line_loads().map(|load| size(load.force)).sum::<f64>() + weight;
        let pressure = largest(&mut stages().flat_map(|r| &r.pressure.0).filter(|r| is_this(&r.rod)).map(|r| r.to));
        // lengths over which loads bend a rod: (B/F)^½, (B/q)^⅓, B/M
        let bending = self.section.smaller_bending();
        let loaded = (force / bending).sqrt() + ((line + pressure) / bending).cbrt() + moment / bending;
        Ok((length, tangent_turns.max(by_nature).max(wound) + rotation + moved + loaded * length / TAU))
    }
}

/// Names of a rod and of all rods that joints connect it to, because their loads act on it.
fn joined<'a>(scene: &'a SceneText, rod: &'a str) -> Vec<&'a str> {
    let mut found = vec![rod];
    let mut next = 0;
    while let Some(&here) = found.get(next) {
        for joint in &scene.joints {
            let (Some(a), Some(b)) = (joint.a.rod.as_deref(), joint.b.rod.as_deref()) else { continue };
            let other = if a == here { b } else { a };
            if (a == here || b == here) && !found.contains(&other) {
                found.push(other);
            }
        }
        next += 1;
    }
    found
}

/// Length of a shape \[L\] and the total turning of its tangent, turns.
fn measure(shape: &Shape, closed: bool) -> Result<(f64, f64), InputError> {
    Ok(match shape {
        Shape::Line { length, .. } => (*length, 0.0),
        Shape::Circle { length, .. } => (*length, 1.0),
        Shape::Arc { radius, angle, .. } => (radius * angle, angle / TAU),
        Shape::Helix { turns, .. } => (shape.place(closed, 4)?.length, turns.abs()),
        Shape::Plectoneme(p) => {
            let axis = match &p.axis {
                Axis::Straight { .. } => 0.0,
                Axis::Along(axis) => measure(axis, false)?.1,
            };
            // strands bend by 2 sin²α/distance, both loops by less than two turns
            (p.length, p.length * 2.0 * p.angle.sin().powi(2) / (p.distance * TAU) + 2.0 + axis)
        }
        Shape::TorusKnot(knot) => {
            let windings: usize = knot.windings.iter().map(|w| w.unsigned_abs() as usize).sum();
            sampled(shape, closed, 32 * windings)?
        }
        Shape::Points(points) => sampled(shape, closed, 4 * points.len())?,
    })
}

fn sampled(shape: &Shape, closed: bool, samples: usize) -> Result<(f64, f64), InputError> {
    let placed = shape.place(closed, samples.clamp(8, FINEST))?;
    let tangents: Vec<Vec3> = placed.frames.iter().map(|frame| frame * Vec3::z()).collect();
    let closing = if closed { tangents.first() } else { None };
    let after = tangents.iter().skip(1).chain(closing);
    Ok((placed.length, tangents.iter().zip(after).map(|(a, b)| a.angle(b)).sum::<f64>() / TAU))
}
