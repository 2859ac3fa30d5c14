//! Planes, other obstacles and what nodes carry in a scene file, and how stages call them.

use crate::error::InputError;
use crate::math::Vec3;
use crate::rod::Rod;
use crate::scene::file::syntax::values::GripText;
use crate::scene::{Hinge, NodeRef, Obstacle, ObstacleNumber, Ramp, Side};

use super::places::{node, nodes};
use crate::scene::file::syntax::{
    BeadText, HingeText, ObstacleRampText, ObstacleText, SceneText, ShapeOfObstacle, SideOfObstacle,
};

/// All obstacles of a scene: planes, others, beads of the rods, grips of the supports. The only plane needs no name,
/// nor does the only other obstacle.
pub(super) fn obstacles(text: &SceneText, rods: &[Rod]) -> Result<Vec<Obstacle>, InputError> {
    let (planes, others) = (&text.planes, &text.obstacles);
    let mut all: Vec<Obstacle> = Vec::new();
    for (i, plane) in planes.iter().enumerate() {
        let named = Obstacle::plane(plane.name.as_str(), plane.point.into(), plane.normal.into());
        add(&mut all, named, (&format!("planes[{i}]"), planes.len() == 1))?;
    }
    for (i, text) in others.iter().enumerate() {
        let place = format!("obstacles[{i}]");
        add(&mut all, obstacle(&place, text)?, (&place, others.len() == 1))?;
    }
    for (index, rod) in text.rods.iter().enumerate() {
        for (i, bead) in rod.beads.iter().enumerate() {
            let place = format!("rods.{}.beads[{i}]", rods[index].name);
            let name = if rod.beads.len() == 1 { "bead".to_owned() } else { format!("bead_{}", i + 1) };
            add(&mut all, carried_ball(&place, bead, rods, (index, &name))?, (&place, false))?;
        }
    }
    for (i, support) in text.supports.iter().enumerate() {
        let place = format!("supports[{i}]");
        let length = match support.grip {
            GripText::None => continue,
            GripText::Endless => None,
            GripText::Length(length) => Some(length),
        };
        for at in nodes(rods, &place, &support.rod, support.at)? {
            add(&mut all, grip(&place, rods, at, length)?, (&place, false))?;
        }
    }
    Ok(all)
}

fn carried_ball(
    place: &str,
    text: &BeadText,
    rods: &[Rod],
    (rod, default): (usize, &str),
) -> Result<Obstacle, InputError> {
    InputError::check(&format!("{place}.radius"), text.radius, text.radius > 0.0, "a finite number > 0")?;
    let at = node(rods, place, rod, text.at)?;
    let name = if text.name.is_empty() { format!("{}_{default}", rods[rod].name) } else { text.name.clone() };
    Ok(Obstacle::bead(name, rods, at, text.radius))
}

fn grip(place: &str, rods: &[Rod], at: NodeRef, length: Option<f64>) -> Result<Obstacle, InputError> {
    let (field, rod) = (format!("{place}.grip"), &rods[at.rod]);
    let end = match at.node {
        _ if rod.closed => None,
        0 => Some("start"),
        node => (node + 1 == rod.num_nodes()).then_some("end"),
    };
    let Some(end) = end else {
        return Err(InputError::inconsistent(field, "prolongs an end of an open rod: set at to \"start\" or \"end\""));
    };
    if rod.section.contact_radius <= 0.0 {
        let reason = format!("is as thick as the rod: give rod \"{}\" a contact_radius", rod.name);
        return Err(InputError::inconsistent(field, reason));
    }
    if let Some(length) = length {
        InputError::check(&field, length, length > 0.0, "a finite length > 0, \"endless\" or \"none\"")?;
    }
    Ok(Obstacle::grip(format!("{}_{end}_grip", rod.name), rods, at, length))
}

fn add(all: &mut Vec<Obstacle>, mut new: Obstacle, (place, is_only): (&str, bool)) -> Result<(), InputError> {
    let field = format!("{place}.name");
    if new.name.is_empty() {
        if !is_only {
            let reason = "missing: where there are several planes, or other obstacles, each needs a name, by which \
                stages and reports call it";
            return Err(InputError::inconsistent(field, reason));
        }
        new.name = new.kind().to_owned();
    }
    if all.iter().any(|other| other.name == new.name) {
        let allowed = "a name that no other plane or obstacle has".to_owned();
        return Err(InputError::Name { field, name: new.name, allowed });
    }
    all.push(new);
    Ok(())
}

fn obstacle(place: &str, text: &ObstacleText) -> Result<Obstacle, InputError> {
    let side = match text.side {
        SideOfObstacle::Outside => Side::Outside,
        SideOfObstacle::Inside => Side::Inside,
    };
    let (name, point, size) = (text.name.as_str(), Vec3::from(text.point), (text.radius, side));
    let mut made = match (text.shape, text.axis) {
        (ShapeOfObstacle::Sphere, None) => Obstacle::sphere(name, point, size),
        (ShapeOfObstacle::Cylinder, Some(axis)) => Obstacle::cylinder(name, [point, axis.into()], size),
        (ShapeOfObstacle::Sphere, Some(_)) => {
            return Err(InputError::inconsistent(format!("{place}.axis"), "a sphere has none: leave it out"));
        }
        (ShapeOfObstacle::Cylinder, None) => {
            return Err(InputError::inconsistent(format!("{place}.axis"), "missing: the direction of the cylinder"));
        }
    };
    made.hinge = text.hinge.map(|HingeText { through, axis }| Hinge { through: through.into(), axis: axis.into() });
    Ok(made)
}

/// Index of the obstacle called `name`; where there is one that may be meant, it needs no name.
pub(super) fn find(
    obstacles: &[Obstacle],
    (field, meant): (&str, impl Fn(&Obstacle) -> bool),
    name: Option<&str>,
) -> Result<usize, InputError> {
    let all: Vec<usize> = (0..obstacles.len()).filter(|k| meant(&obstacles[*k])).collect();
    let found = match name {
        None if all.len() == 1 => all.first(),
        None => None,
        Some(name) => all.iter().find(|k| obstacles[**k].name == name),
    };
    let names = all.iter().map(|k| format!("\"{}\"", obstacles[*k].name)).collect::<Vec<_>>().join(", ");
    let allowed =
        if names.is_empty() { "one of the scene, which has none".to_owned() } else { format!("one of {names}") };
    let name = name.unwrap_or_default().to_owned();
    found.copied().ok_or_else(|| InputError::Name { field: format!("{field}.name"), name, allowed })
}

/// What a stage does to an obstacle.
pub(super) fn ramps(field: &str, text: &ObstacleRampText, obstacles: &[Obstacle]) -> Result<Vec<Ramp>, InputError> {
    // without a name the only one that is no plane is meant
    let meant = |obstacle: &Obstacle| text.name.is_some() || !obstacle.is_plane();
    let index = find(obstacles, (field, meant), text.name.as_deref())?;
    if text.radius.is_some() && obstacles[index].is_plane() {
        let reason = "a plane has none: ramp `plane` to move it along its normal";
        return Err(InputError::inconsistent(format!("{field}.radius"), reason));
    }
    let displacement = text.displacement.map(|to| to.0);
    let numbers = [(ObstacleNumber::Level, text.radius), (ObstacleNumber::Turns, text.turns)];
    let along = (0..3).map(|k| (ObstacleNumber::Displacement(k), displacement.map(|to| to[k])));
    let ramp = |(which, to): (ObstacleNumber, Option<f64>)| to.map(|to| Ramp::Obstacle { obstacle: index, which, to });
    let made: Vec<Ramp> = numbers.into_iter().chain(along).filter_map(ramp).collect();
    if made.is_empty() {
        return Err(InputError::inconsistent(field, "nothing to do: give radius, displacement or turns"));
    }
    Ok(made)
}
