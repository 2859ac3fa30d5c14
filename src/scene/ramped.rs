//! Prescribed quantities at any point of the path, as columns of a table.

use crate::math::Vec3;

use super::model::{Model, NodeRef, ObstacleNumber, Ramp, Stage, Support, SupportChange};
use crate::rod::RodNumber;

/// A prescribed quantity along the path.
#[derive(Debug, Clone, PartialEq)]
pub struct Prescribed {
    /// Name, with the rod's where there are several.
    pub name: String,
    /// Unit: "turns", "L" a length, "F/L" …; empty for a plain number.
    pub unit: &'static str,
    /// Values at the start and at the end of each stage. That of a motion begins at 0 where a stage holds its node.
    spans: Vec<[f64; 2]>,
}

impl Prescribed {
    /// Value at a fraction of a stage.
    pub fn at(&self, stage: usize, fraction: f64) -> f64 {
        let last = self.spans.last().map_or(0.0, |[_, to]| *to);
        let [before, to] = self.spans.get(stage).copied().unwrap_or([last; 2]);
        // + 0.0 turns −0 into 0
        before + (to - before) * fraction + 0.0
    }
}

/// "start", "end" or "nodeK", after the rod's name where there are several.
pub fn place_name(model: &Model, node: NodeRef) -> String {
    let rod = &model.rods[node.rod];
    let at = match node.node {
        0 => "start".to_owned(),
        last if !rod.closed && last + 1 == rod.num_nodes() => "end".to_owned(),
        other => format!("node{other}"),
    };
    if model.rods.len() > 1 { format!("{}_{at}", rod.name) } else { at }
}

/// All prescribed quantities except link and poses, which states contain; whole turns on top of a pose are among them.
pub fn prescribed(model: &Model, stages: &[Stage]) -> Vec<Prescribed> {
    let mut all: Vec<Prescribed> = Vec::new();
    for (k, stage) in stages.iter().enumerate() {
        let anew = counted_anew(model, stage);
        let from = |known: &Prescribed| match anew.iter().any(|motion| known.name.starts_with(motion)) {
            true => 0.0,
            false => known.spans.last().map_or(0.0, |[_, to]| *to),
        };
        for (name, unit, start, to) in stage.ramps.iter().flat_map(|ramp| numbers(model, ramp)) {
            // components of displacements that no stage so far has moved
            if name.contains("_displaced_") && to == start && all.iter().all(|known| known.name != name) {
                continue;
            }
            let index = all.iter().position(|known| known.name == name).unwrap_or_else(|| {
                all.push(Prescribed { name, unit, spans: vec![[start; 2]; k] });
                all.len() - 1
            });
            let before = if k == 0 { start } else { from(&all[index]) };
            all[index].spans.push([before, to]);
        }
        for known in all.iter_mut().filter(|known| known.spans.len() == k) {
            known.spans.push([from(known); 2]);
        }
    }
    all
}

/// Names of the motions of nodes that a stage holds: they count from there.
fn counted_anew(model: &Model, stage: &Stage) -> Vec<String> {
    let held = stage.supports.iter().filter_map(|change| match change {
        SupportChange::Hold(support) => Some(support),
        SupportChange::Release(_) => None,
    });
    let names = |support: &Support| {
        let name = |what: &'static str| move |node: NodeRef| format!("{}_{what}", place_name(model, node));
        let [places, frames] = model.moved_with(support);
        let turns = frames.iter().copied().flat_map(|node| [name("turned")(node), name("extra_turns")(node)]);
        places.iter().copied().map(name("displaced")).chain(turns).collect::<Vec<_>>()
    };
    held.flat_map(names).collect()
}

type Number = (String, &'static str, f64, f64);

/// Name, unit, value at the start of a run and target of each number that a ramp changes.
fn numbers(model: &Model, ramp: &Ramp) -> Vec<Number> {
    let of_rod = |name: &str, rod: usize| {
        if model.rods.len() > 1 { format!("{}_{name}", model.rods[rod].name) } else { name.to_owned() }
    };
    match ramp {
        Ramp::Load { to } => vec![("load".to_owned(), "", model.load, *to)],
        Ramp::Pressure { rod, to } => vec![(of_rod("pressure", *rod), "F/L", 0.0, *to)],
        Ramp::Rotation { node, to, .. } | Ramp::RotationAbout { node, to, .. } => {
            vec![(format!("{}_turned", place_name(model, *node)), "turns", 0.0, *to)]
        }
        Ramp::Displacement { node, to } => {
            let place = place_name(model, *node);
            let axis = |k: usize| (format!("{place}_displaced_{}", ["x", "y", "z"][k]), "L", 0.0, to[k]);
            (0..3).map(axis).collect()
        }
        Ramp::Obstacle { obstacle, which, to } => {
            let obstacle = &model.obstacles[*obstacle];
            let (what, unit) = match which {
                ObstacleNumber::Level if obstacle.is_plane() => ("displaced".to_owned(), "L"),
                ObstacleNumber::Level => ("radius".to_owned(), "L"),
                ObstacleNumber::Displacement(k) => (format!("displaced_{}", ["x", "y", "z"][*k]), "L"),
                ObstacleNumber::Turns => ("turned".to_owned(), "turns"),
            };
            vec![(format!("{}_{what}", obstacle.name), unit, obstacle.start().get(*which), *to)]
        }
        Ramp::Number { rod, which, to } => {
            vec![(of_rod(which.name(), *rod), unit_of(*which), model.rods[*rod].number(*which), *to)]
        }
        Ramp::Pose { node, pose } => {
            let name = || format!("{}_extra_turns", place_name(model, *node));
            pose.turns.map(|turns| (name(), "turns", 0.0, turns)).into_iter().collect()
        }
        Ramp::ExcessLink { .. } => Vec::new(),
    }
}

/// Name of the first number that a ramp moves, as a column of tables; none for link, poses without extra turns and
/// supports.
pub fn ramped_name(model: &Model, ramp: &Ramp) -> Option<String> {
    let mut numbers = numbers(model, ramp);
    let moved = numbers.iter().position(|(_, _, start, to)| to != start).unwrap_or(0);
    (!numbers.is_empty()).then(|| numbers.swap_remove(moved).0)
}

fn unit_of(which: RodNumber) -> &'static str {
    match which {
        RodNumber::ContactRadius | RodNumber::Length => "L",
        RodNumber::Bending1 | RodNumber::Bending2 | RodNumber::Twisting => "F L^2",
        RodNumber::Stretching | RodNumber::Shearing1 | RodNumber::Shearing2 => "F",
        RodNumber::Binding => "",
        RodNumber::Curvature1 | RodNumber::Curvature2 | RodNumber::Twist => "1/L",
    }
}

/// The axis about which stages rotate a node, if any.
pub fn axis_of(stages: &[Stage], at: NodeRef) -> Option<Vec3> {
    stages.iter().flat_map(|stage| &stage.ramps).find_map(|ramp| match ramp {
        Ramp::Rotation { node, axis, .. } | Ramp::RotationAbout { node, axis, .. } if *node == at => {
            Some(super::model::unit(axis))
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};

    /// Motions count from where a stage holds their node, loads do not.
    #[test]
    fn values_go_on_from_stage_to_stage() {
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.0);
        let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
        let rod = Rod::new("rod", &line, RodMesh::open(2, 3), section, Natural::Straight).unwrap();
        let model = Model { rods: vec![rod], ..Model::default() };
        let node = NodeRef { rod: 0, node: 6 };
        let ramps = |x: f64, to: f64, load: f64| {
            let turn = Ramp::Rotation { node, axis: Vec3::x(), to };
            vec![Ramp::Displacement { node, to: Vec3::x() * x }, turn, Ramp::Load { to: load }]
        };
        let hold = |support| Stage { supports: vec![SupportChange::Hold(support)], ..Stage::new(Vec::new(), 1) };
        let stages =
            [Stage::new(ramps(0.5, 0.25, 2.0), 1), hold(Support::pin(node)), Stage::new(ramps(0.25, 0.5, 3.0), 1)];
        let of = |stages: &[Stage], name: &str| {
            let found = prescribed(&model, stages).into_iter().find(|quantity| quantity.name == name).unwrap();
            [(0, 0.5), (1, 0.0), (1, 1.0), (2, 0.5), (2, 1.0)].map(|(stage, fraction)| found.at(stage, fraction))
        };
        assert_eq!(of(&stages, "end_displaced_x"), [0.25, 0.0, 0.0, 0.125, 0.25]);
        assert_eq!(of(&stages, "end_turned"), [0.125, 0.25, 0.25, 0.375, 0.5]);
        let back = [stages[0].clone(), Stage::new(ramps(0.0, 0.0, 2.0), 1), stages[2].clone()];
        assert_eq!(of(&back, "end_displaced_x"), [0.25, 0.5, 0.0, 0.125, 0.25]);
        assert!(prescribed(&model, &stages).iter().all(|quantity| quantity.name != "end_displaced_y"));
        assert_eq!(of(&stages, "load"), [0.5 * (model.load + 2.0), 2.0, 2.0, 2.5, 3.0]);
        let clamped = [stages[0].clone(), hold(Support::clamp(node)), stages[2].clone()];
        assert_eq!(of(&clamped, "end_turned"), [0.125, 0.0, 0.0, 0.25, 0.5]);
    }
}
