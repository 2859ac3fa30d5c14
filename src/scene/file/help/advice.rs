//! Warnings about legal scenes that are unlikely to be intended, or that exceed their mesh.

use std::f64::consts::TAU;

use crate::dna::HELICAL_REPEAT;
use crate::dna::base_pairs::{AtRest, Nodes};
use crate::rod::Rod;
use crate::scene::file::build::memory;
use crate::scene::file::syntax::{RodText, SceneText, ShapeText};
use crate::scene::{Ramp, Scene};

/// Largest natural twist from node to node, turns. At 80° the error is 1 %; it falls with the sixth power.
const MOST_NATURAL: f64 = 1.0 / 12.0;
/// Fewest nodes per turn of link, because each turn of a plectoneme bends the rod by a whole turn.
const FEWEST_A_TURN: f64 = 12.0;
/// Contact radius over length below which its unit is probably wrong: DNA of E. coli's length has 2e-6.
const THINNEST: f64 = 1e-7;
/// Relative difference of excess link and natural link below which the excess link is probably the whole link.
const ALIKE: f64 = 0.25;
/// Nodes per contact diameter that lines of contact need.
const NODES_A_DIAMETER: f64 = 3.0;
/// Newton iterations of an ordinary step, and the time of one for a node in contact, s, on one core: measured on
/// plasmids, 10 to 40 and 25 µs.
const ITERATIONS_A_STEP: f64 = 20.0;
const SECONDS_A_NODE: f64 = 25e-6;
const MIB: f64 = (1u64 << 20) as f64;

/// Deviations of steps at the start, degrees and Å, from which on they are reported: those that files of steps round
/// to.
const FAR_DEGREES: f64 = 0.05;
const FAR_ANGSTROMS: f64 = 0.005;
/// Start link, turns, above which a curve is reported not to begin relaxed.
const WORTH_TELLING: f64 = 1e-3;

/// Choices that the text leaves open and whose outcome its author may not expect.
pub(in crate::scene::file) fn notices(text: &SceneText, scene: &Scene) -> Vec<String> {
    let rods = &scene.model.rods;
    let links = text.rods.iter().zip(rods).filter_map(|(text, rod)| start_link(text, rod));
    let steps = rods.iter().zip(&scene.base_pairs).filter_map(|(rod, pairs)| start_steps(rod, pairs.as_ref()?));
    links.chain(steps).collect()
}

/// Says that a closed curve whose file gives no link begins with that of its shape.
fn start_link(text: &RodText, rod: &Rod) -> Option<String> {
    let is_given = text.excess_link.is_some() || text.link.is_some() || text.sigma.is_some();
    let is_curve = !matches!(text.shape, ShapeText::State { .. } | ShapeText::Frames { .. });
    let link = rod.start_excess_link;
    (rod.closed && is_curve && !is_given && link.abs() > WORTH_TELLING).then(|| {
        format!(
            "rod \"{}\" begins with an excess link of {link:.4} turns, the writhe of its shape, and no twist: its \
             link stays. With excess_link = 0 it has the link of the relaxed rod, and the twist {:.4}",
            rod.name, -link
        )
    })
}

/// Says how far the steps of base pairs are from those at rest where the rod starts.
fn start_steps(rod: &Rod, at_rest: &AtRest) -> Option<String> {
    let (positions, frames) = (&rod.positions, &rod.frames);
    let closed = rod.closed.then_some(rod.start_link());
    let nodes = Nodes {
        positions,
        frames,
        order: rod.order,
        closed,
        turns_left_out: rod.turns_left_out,
        helical_repeat: HELICAL_REPEAT,
    };
    let off = at_rest.deviation(&at_rest.along(&nodes).ok()?);
    let far = off.degrees > FAR_DEGREES || off.angstroms > FAR_ANGSTROMS;
    far.then(|| {
        format!(
            "rod \"{}\" starts with base-pair steps that are up to {off} from those at rest, which its sequence has",
            rod.name
        )
    })
}

impl Scene {
    /// Warnings: a radius probably in another unit than the length, link that the mesh cannot resolve, too much natural
    /// twist from node to node, excess link that is probably the whole link.
    pub fn warnings(&self) -> Vec<String> {
        let rods = self.model.rods.iter().enumerate();
        rods.flat_map(|(index, rod)| {
            let [least, most] = self.links(index, rod);
            let by_nature = match self.base_pairs.get(index) {
                Some(Some(at_rest)) if rod.turns_left_out == 0.0 => steps(rod, at_rest),
                _ => natural(rod),
            };
            [thin(rod), by_nature, link(rod, least.abs().max(most.abs())), is_link(rod, least), is_link(rod, most)]
        })
        .flatten()
        .fold(Vec::new(), |mut all, warning| {
            if !all.contains(&warning) {
                all.push(warning);
            }
            all
        })
    }

    /// Expected cost of a run, as text: mesh by rod, memory, time.
    pub fn expectations(&self) -> Vec<String> {
        let unit = &self.units.length;
        let mesh = |rod: &Rod| {
            let (spacing, diameter) = (rod.spacing(), 2.0 * rod.section.contact_radius);
            let touches = diameter > 0.0 && self.model.contact.law.is_on();
            let by_contact = if touches {
                let nodes = diameter / spacing;
                let needed = if nodes < NODES_A_DIAMETER {
                    format!(" (lines of contact need {NODES_A_DIAMETER})")
                } else {
                    String::new()
                };
                format!(", {nodes:.1} a contact diameter{needed}")
            } else {
                String::new()
            };
            let twist = rod.natural.mean_twist(rod.length).abs() / TAU;
            let by_twist = if twist > 0.0 {
                format!(", {:.0} a turn of natural twist", 1.0 / (twist * spacing))
            } else {
                String::new()
            };
            format!("rod {}: nodes {spacing:.4} {unit} apart{by_contact}{by_twist}", rod.name)
        };
        let nodes: usize = self.model.rods.iter().map(Rod::num_nodes).sum();
        let steps: usize = self.stages.iter().map(|stage| stage.steps).sum::<usize>().max(1);
        let bytes = memory::least(nodes, self.model.planar);
        let seconds = steps as f64 * ITERATIONS_A_STEP * nodes as f64 * SECONDS_A_NODE;
        let time = match seconds {
            ..1.0 => "about a second".to_owned(),
            ..90.0 => format!("about {seconds:.0} s"),
            ..5400.0 => format!("about {:.0} min", seconds / 60.0),
            _ => format!("about {:.0} h", seconds / 3600.0),
        };
        let all = format!(
            "{nodes} nodes take {:.0} MiB or more, {} {time} on one core, several times more where rods snap",
            (bytes / MIB).max(1.0),
            if steps == 1 { "1 step".to_owned() } else { format!("{steps} steps") }
        );
        self.model.rods.iter().map(mesh).chain([all]).collect()
    }

    /// Smallest and largest excess link of a rod, turns, at the start and after stages.
    fn links(&self, index: usize, rod: &Rod) -> [f64; 2] {
        let ramps = self.stages.iter().flat_map(|stage| &stage.ramps);
        let targets = ramps.filter_map(|ramp| match ramp {
            Ramp::ExcessLink { rod, to } if *rod == index => Some(*to),
            Ramp::Rotation { node, to, .. } if node.rod == index => Some(*to),
            _ => None,
        });
        targets.fold([rod.start_excess_link; 2], |[least, most], to| [least.min(to), most.max(to)])
    }
}

fn thin(rod: &Rod) -> Option<String> {
    let (radius, length) = (rod.section.contact_radius, rod.length);
    let slender = radius > 0.0 && radius < THINNEST * length;
    slender.then(|| {
        let part = radius / length;
        format!(
            "rod \"{}\" is {length} long and has a contact radius of {radius}, {part:.0e} of it: are both in one unit?",
            rod.name
        )
    })
}

fn natural(rod: &Rod) -> Option<String> {
    let turns = rod.natural.mean_twist(rod.length).abs() * rod.spacing() / TAU;
    (turns > MOST_NATURAL).then(|| {
        let needed = (turns / MOST_NATURAL * rod.num_elements as f64).ceil();
        format!(
            "rod \"{}\" turns by {:.0}° of natural twist from node to node, which costs accuracy above {:.0}°: \
             {needed} elements would do",
            rod.name,
            360.0 * turns,
            360.0 * MOST_NATURAL
        )
    })
}

/// A sequence wants a node a base pair. Its natural twist needs no other mesh: elements take the steps at rest exactly.
fn steps(rod: &Rod, at_rest: &AtRest) -> Option<String> {
    let (steps, segments) = (at_rest.steps.len(), rod.num_segments());
    (segments < steps).then(|| {
        format!(
            "rod \"{}\" has {segments} segments between nodes for {steps} steps of base pairs: {} elements have a \
             node a base pair",
            rod.name,
            steps.div_ceil(rod.order)
        )
    })
}

fn link(rod: &Rod, turns: f64) -> Option<String> {
    let nodes = rod.num_segments() as f64 / turns;
    (nodes < FEWEST_A_TURN).then(|| {
        let needed = (FEWEST_A_TURN * turns / rod.order as f64).ceil();
        format!(
            "rod \"{}\" is to take {turns} turns on {} elements, {nodes:.1} nodes a turn: {needed} elements would give \
             {FEWEST_A_TURN}",
            rod.name, rod.num_elements
        )
    })
}

fn is_link(rod: &Rod, excess: f64) -> Option<String> {
    let natural = if rod.closed { rod.natural_link() } else { 0.0 };
    let alike = natural.abs() >= 1.0 && (excess.abs() - natural.abs()).abs() <= ALIKE * natural.abs();
    alike.then(|| {
        format!(
            "rod \"{}\" has an excess_link of {excess}, which counts beyond its natural {natural:.2} turns: is link \
             meant?",
            rod.name
        )
    })
}
