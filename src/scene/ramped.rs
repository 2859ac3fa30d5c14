//! Prescribed quantities at any point of the path, as columns of a table.

use crate::math::Vec3;

use super::model::{Model, NodeRef, ObstacleNumber, Ramp, Stage};
use crate::rod::RodNumber;

/// A prescribed quantity along the path.
#[derive(Debug, Clone, PartialEq)]
pub struct Prescribed {
    /// Name, with the rod's where there are several.
    pub name: String,
    /// Unit: "turns", "L" a length, "F/L" …; empty for a plain number.
    pub unit: &'static str,
    /// Value at the start.
    start: f64,
    /// Value at the end of each stage.
    ends: Vec<f64>,
}

impl Prescribed {
    /// Value at a fraction of a stage.
    pub fn at(&self, stage: usize, fraction: f64) -> f64 {
        let before = stage.checked_sub(1).and_then(|k| self.ends.get(k)).copied().unwrap_or(self.start);
        let to = self.ends.get(stage).copied().unwrap_or(before);
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
        for (name, unit, start, to) in stage.ramps.iter().flat_map(|ramp| numbers(model, ramp)) {
            let index = all.iter().position(|known| known.name == name).unwrap_or_else(|| {
                all.push(Prescribed { name, unit, start, ends: vec![start; k] });
                all.len() - 1
            });
            all[index].ends.push(to);
        }
        for known in all.iter_mut().filter(|known| known.ends.len() == k) {
            known.ends.push(known.ends.last().copied().unwrap_or(known.start));
        }
    }
    all
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
            let moved: Vec<usize> = (0..3).filter(|&k| to[k] != 0.0).collect();
            let place = place_name(model, *node);
            let axis = |k: usize| (format!("{place}_displaced_{}", ["x", "y", "z"][k]), "L", 0.0, to[k]);
            moved.into_iter().map(axis).collect()
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
    numbers(model, ramp).into_iter().next().map(|(name, ..)| name)
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
