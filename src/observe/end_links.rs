//! Loops that pass over an end of an open rod.
//!
//! A rod ends in a point, and nothing is in the way of a loop beyond it. Where both ends hold their frames, the link
//! between them is what was prescribed for as long as no loop passes over an end, which changes it by two turns: what
//! an end is fixed to (a bead, a wall) would not let that happen.

use crate::math::Vec3;
use crate::scene::ramped::{Prescribed, prescribed, ramped_name};
use crate::scene::{Model, NodeRef, Ramp, Stage};

use super::report::Observation;
use super::state::PARALLEL;

/// Largest distance from two turns, because link is measured on polygons, where it is exact but for rounding.
const TOL_TURNS: f64 = 1e-3;

/// The link that stages prescribe between the ends of open rods.
///
/// ```no_run
/// # fn watched(scene: supercoil::scene::Scene) -> Result<(), Box<dyn std::error::Error>> {
/// use std::ops::ControlFlow;
/// use supercoil::observe::report::Observation;
/// use supercoil::observe::{EndLinks, observe};
///
/// let links = EndLinks::new(&scene.model, &scene.stages);
/// let mut steps: Vec<Observation> = Vec::new();
/// supercoil::solve::run(scene.model, &scene.stages, &Default::default(), &mut |progress| {
///     let now = observe(progress);
///     links.notes(&now, steps.first()).iter().for_each(|note| println!("step {}: {note}", now.step));
///     steps.push(now);
///     ControlFlow::Continue(())
/// })?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct EndLinks {
    rods: Vec<HeldEnds>,
}

/// An open rod whose ends hold their frames, and turn about their tangents only.
#[derive(Debug, Clone)]
struct HeldEnds {
    rod: usize,
    name: String,
    /// What turns its ends, with the sign that it has in the link.
    turned: Vec<(Prescribed, f64)>,
}

impl EndLinks {
    /// Of the open rods with contact whose ends are held throughout and turned about their tangents, if at all.
    pub fn new(model: &Model, stages: &[Stage]) -> Self {
        let all = prescribed(model, stages);
        let held = |rod: usize| {
            let turned = turned_ends(model, stages, rod)?;
            let column = |(name, sign): (String, f64)| Some((all.iter().find(|of| of.name == name)?.clone(), sign));
            let turned = turned.into_iter().map(column).collect::<Option<_>>()?;
            Some(HeldEnds { rod, name: model.rods[rod].name.clone(), turned })
        };
        let rods = if model.contact.law.is_on() { 0..model.rods.len() } else { 0..0 };
        Self { rods: rods.filter_map(held).collect() }
    }

    /// A note for each rod whose link is no longer that of the `start` (an earlier observation, the first of the run as
    /// a rule) and of the turns prescribed since.
    pub fn notes(&self, now: &Observation, start: Option<&Observation>) -> Vec<String> {
        let Some(start) = start else { return Vec::new() };
        let link = |of: &Observation, rod: usize| of.ends.iter().find(|ends| ends.rod == rod)?.link;
        let note = |held: &HeldEnds| {
            let turned = |(of, sign): &(Prescribed, f64)| {
                sign * (of.at(now.stage, now.fraction) - of.at(start.stage, start.fraction))
            };
            let due = link(start, held.rod)? + held.turned.iter().map(turned).sum::<f64>();
            let off = link(now, held.rod)? - due;
            let loops = (0.5 * off).round();
            (loops != 0.0 && (off - 2.0 * loops).abs() < TOL_TURNS).then(|| {
                let than = if loops < 0.0 { "less" } else { "more" };
                format!(
                    "the link of rod \"{}\" is {} turns {than} than prescribed: a loop has passed over an end, where \
                     nothing is in its way",
                    held.name,
                    2.0 * loops.abs()
                )
            })
        };
        self.rods.iter().filter_map(note).collect()
    }
}

/// Names of the columns of what turns the ends of a rod, and signs; `None` if these are free, or do anything else.
fn turned_ends(model: &Model, stages: &[Stage], rod: usize) -> Option<Vec<(String, f64)>> {
    let of = &model.rods[rod];
    if of.closed || of.section.contact_radius <= 0.0 {
        return None;
    }
    let ends = [(NodeRef { rod, node: 0 }, -1.0), (NodeRef { rod, node: of.num_nodes() - 1 }, 1.0)];
    let mut turned: Vec<(String, f64)> = Vec::new();
    for (node, sign) in ends {
        if model.fixed(node).1 != [true; 3] {
            return None;
        }
        let (tangent, joined) = (of.frames[node.node] * Vec3::z(), model.joined_nodes(node));
        if stages.iter().flat_map(|stage| &stage.supports).any(|change| joined.contains(&change.support().node)) {
            return None;
        }
        for ramp in stages.iter().flat_map(|stage| &stage.ramps) {
            match ramp {
                Ramp::Rotation { node: at, axis, .. } if *at == node => {
                    let (name, way) = (ramped_name(model, ramp)?, sign * axis.dot(&tangent).signum());
                    let known = turned.iter().find(|(other, _)| *other == name).map(|(_, way)| *way);
                    if axis.cross(&tangent).norm() > PARALLEL * axis.norm() || known.is_some_and(|known| known != way) {
                        return None;
                    }
                    if known.is_none() {
                        turned.push((name, way));
                    }
                }
                Ramp::RotationAbout { node: at, .. } | Ramp::Pose { node: at, .. } if *at == node => return None,
                _ => {}
            }
        }
    }
    Some(turned)
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::observe::observe;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::{ContactLaw, Pose, PosePath, Support, SupportChange};
    use crate::solve::{self, Options};

    const ELEMENTS: usize = 6;

    /// A straight rod along −x.
    fn model(elements: usize, supports: Vec<Support>) -> Model {
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.01);
        let shape = Shape::Line { start: Vec3::zeros(), direction: -Vec3::x(), length: 1.0 };
        let rods = vec![Rod::new("rod", &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap()];
        Model { rods, supports, ..Model::default() }
    }

    /// A rod after its ends were turned in three steps.
    fn turned(model: Model, ramps: Vec<Ramp>) -> (EndLinks, Vec<Observation>) {
        let stages = vec![Stage::new(ramps, 3)];
        let links = EndLinks::new(&model, &stages);
        let mut seen = Vec::new();
        let solution = solve::run(model, &stages, &Options::default(), &mut |progress| {
            seen.push(observe(progress));
            ControlFlow::Continue(())
        });
        assert_eq!(solution.unwrap().status, solve::Status::Converged);
        (links, seen)
    }

    fn ends(elements: usize) -> [NodeRef; 2] {
        [0, 3 * elements].map(|node| NodeRef { rod: 0, node })
    }

    fn told(links: &EndLinks, seen: &[Observation], slipped: f64) -> Vec<String> {
        let mut last = seen.last().unwrap().clone();
        last.ends[0].link = last.ends[0].link.map(|link| link + slipped);
        links.notes(&last, seen.first())
    }

    #[test]
    fn a_loop_over_an_end_is_told() {
        for elements in [ELEMENTS, 400] {
            let [start, end] = ends(elements);
            let ramps = vec![
                Ramp::Rotation { node: end, axis: Vec3::x() * 3.0, to: 0.7 },
                Ramp::Rotation { node: start, axis: Vec3::x(), to: -0.4 },
            ];
            let (links, seen) = turned(model(elements, [start, end].map(Support::clamp).to_vec()), ramps);
            let link = seen.last().unwrap().ends[0].link.unwrap();
            assert!((link + 1.1).abs() < 1e-6, "the end about −x, the start against it: {link}");
            assert_eq!(told(&links, &seen, 0.0), Vec::<String>::new());
            assert_eq!(told(&links, &seen, 1.0), Vec::<String>::new(), "no loop takes one turn with it");
            for (slipped, words) in [(-2.0, "2 turns less than"), (4.0, "4 turns more than")] {
                let notes = told(&links, &seen, slipped);
                assert!(notes.len() == 1 && notes[0].contains(words), "{notes:?}");
            }
        }
    }

    /// A rod that is turned twice at one end spins with it if the other is free, which takes the same two turns as a
    /// loop.
    #[test]
    fn a_free_end_has_no_link_to_keep() {
        let [start, end] = ends(ELEMENTS);
        let turn = Ramp::Rotation { node: start, axis: Vec3::x(), to: 2.0 };
        let (links, seen) = turned(model(ELEMENTS, vec![Support::clamp(start), Support::pin(end)]), vec![turn]);
        assert!(seen.last().unwrap().ends[0].link.unwrap().abs() < 1e-6);
        assert_eq!(told(&links, &seen, 0.0), Vec::<String>::new());
    }

    /// Whose link is known: that of ends turned about their tangents, always the same way, and of nothing else.
    #[test]
    fn ends_that_move_otherwise_are_left_alone() {
        let [start, end] = ends(ELEMENTS);
        let about = |node, axis| Ramp::Rotation { node, axis, to: 1.0 };
        let round = |node| Ramp::RotationAbout { node, axis: Vec3::x(), through: Vec3::zeros(), to: 1.0 };
        let release = SupportChange::Release(Support { position: [false; 3], ..Support::clamp(end) });
        let turns =
            Pose { position: None, frame: None, path: PosePath::default(), turns: Some(2.0), half_turn: Vec3::zeros() };
        let middle = NodeRef { rod: 0, node: 9 };
        let cases = [
            (vec![about(start, Vec3::x()), about(end, -Vec3::x())], 1),
            (vec![about(end, Vec3::x()), about(end, Vec3::x())], 1),
            (vec![round(middle)], 1),
            (vec![about(end, Vec3::x()), about(end, -Vec3::x())], 0),
            (vec![about(end, Vec3::new(1.0, 0.01, 0.0))], 0),
            (vec![round(end)], 0),
            (vec![Ramp::Pose { node: start, pose: turns }], 0),
        ];
        let ramped = cases
            .map(|(ramps, followed)| (ramps.into_iter().map(|ramp| Stage::new(vec![ramp], 1)).collect(), followed));
        let released: Vec<Stage> = vec![Stage { supports: vec![release], ..Stage::new(vec![], 1) }];
        for (k, (stages, followed)) in ramped.into_iter().chain([(released, 0)]).enumerate() {
            let mut model = model(ELEMENTS, [start, end].map(Support::clamp).to_vec());
            assert_eq!(EndLinks::new(&model, &stages).rods.len(), followed, "{k}");
            model.contact.law = ContactLaw::None;
            assert!(EndLinks::new(&model, &stages).rods.is_empty(), "{k}: strands pass each other");
        }
    }
}
