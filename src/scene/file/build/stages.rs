//! Stages: what is ramped, held and released, and the path that the last one follows.

use crate::error::InputError;
use crate::rod::{Rod, RodNumber};
use crate::scene::file::syntax::choices::FollowChoice;
use crate::scene::file::syntax::values::GripText;
use crate::scene::file::syntax::{RampText, StageText, SupportText};
use crate::scene::{Model, Obstacle, ObstacleNumber, Ramp, Stage, SupportChange};

use super::by_base_pairs::NEEDS_DNA;
use super::places::{find_rod, nodes};
use super::{obstacles, poses, supports};

/// Stages that follow others, which may have ramped the loads. `relaxed_links`: link of relaxed DNA by rod, turns.
pub(in crate::scene::file) fn stages(
    text: &[StageText],
    model: &Model,
    relaxed_links: &[Option<f64>],
) -> Result<Vec<Stage>, InputError> {
    let stage = |(i, stage): (usize, &StageText)| {
        let mut changes = Vec::new();
        for (k, gone) in stage.release.iter().enumerate() {
            let field = format!("stages[{i}].release[{k}]");
            check_no_grip(&field, gone)?;
            let supports = supports(&field, gone, &model.rods)?;
            changes.extend(supports.into_iter().map(SupportChange::Release));
        }
        for (k, held) in stage.hold.iter().enumerate() {
            let field = format!("stages[{i}].hold[{k}]");
            check_no_grip(&field, held)?;
            let supports = supports(&field, held, &model.rods)?;
            changes.extend(supports.into_iter().map(SupportChange::Hold));
        }
        let ramps = ramps(&format!("stages[{i}].ramp"), &stage.ramp, model, relaxed_links)?;
        Ok(Stage { supports: changes, ramps, steps: stage.steps })
    };
    let stages = text.iter().enumerate().map(stage).collect::<Result<Vec<_>, _>>()?;
    model.check_stages(&stages)?;
    Ok(stages)
}

/// A grip is a body that is there from the start.
fn check_no_grip(field: &str, text: &SupportText) -> Result<(), InputError> {
    if text.grip == GripText::None {
        return Ok(());
    }
    let reason = "is there from the start, and stays when its support is released: set it in [[supports]]";
    Err(InputError::inconsistent(format!("{field}.grip"), reason))
}

/// Path following of the last stage, if any.
pub(super) fn follow(text: &[StageText], model: &Model, stages: &[Stage]) -> Result<Option<FollowChoice>, InputError> {
    let Some(place) = text.iter().position(|stage| stage.follow.is_some()) else { return Ok(None) };
    let field = format!("stages[{place}].follow");
    if !model.obstacles.is_empty() {
        return Err(InputError::inconsistent(
            field,
            "paths of rods that may touch planes or other obstacles cannot be followed: remove them",
        ));
    }
    if place + 1 < text.len() {
        return Err(InputError::inconsistent(field, "is only for the last stage: a path may end anywhere"));
    }
    let steady = |ramp: &Ramp| {
        matches!(
            ramp,
            Ramp::ExcessLink { .. }
                | Ramp::Rotation { .. }
                | Ramp::Displacement { .. }
                | Ramp::Load { .. }
                | Ramp::Pressure { .. }
        )
    };
    if !stages[place].only_ramp().is_some_and(steady) {
        let reason = "follows one ramp: of excess_link, rotation (without through), displacement of a node, load or \
            pressure; nodes are held and released by a stage of their own";
        return Err(InputError::inconsistent(field, reason));
    }
    text[place].follow.map(|choice| choice.check().map(|()| choice)).transpose()
}

fn ramps(field: &str, text: &RampText, model: &Model, relaxed_links: &[Option<f64>]) -> Result<Vec<Ramp>, InputError> {
    let rods = &model.rods;
    let mut ramps = Vec::new();
    for ramp in &text.excess_link.0 {
        let rod = find_rod(rods, &format!("{field}.excess_link"), ramp.rod.as_deref())?;
        ramps.push(Ramp::ExcessLink { rod, to: ramp.to });
    }
    for ramp in &text.sigma.0 {
        let field = format!("{field}.sigma");
        let rod = find_rod(rods, &field, ramp.rod.as_deref())?;
        InputError::check(&format!("{field}.to"), ramp.to, true, "a finite number")?;
        let relaxed =
            relaxed_links.get(rod).copied().flatten().ok_or_else(|| InputError::inconsistent(field, NEEDS_DNA))?;
        ramps.push(Ramp::ExcessLink { rod, to: ramp.to * relaxed });
    }
    for ramp in &text.link.0 {
        let rod = find_rod(rods, &format!("{field}.link"), ramp.rod.as_deref())?;
        ramps.push(Ramp::ExcessLink { rod, to: ramp.to - rods[rod].relaxed_link() });
    }
    for ramp in &text.rotation.0 {
        let (axis, to) = (ramp.axis.into(), ramp.turns);
        let turn = |node| match ramp.through {
            None => Ramp::Rotation { node, axis, to },
            Some(through) => Ramp::RotationAbout { node, axis, through: through.into(), to },
        };
        let nodes = nodes(rods, &format!("{field}.rotation"), &ramp.rod, ramp.at)?;
        ramps.extend(nodes.into_iter().map(turn));
    }
    for ramp in &text.displacement.0 {
        let nodes = nodes(rods, &format!("{field}.displacement"), &ramp.rod, ramp.at)?;
        ramps.extend(nodes.into_iter().map(|node| Ramp::Displacement { node, to: ramp.to.into() }));
    }
    for ramp in &text.pose.0 {
        let field = format!("{field}.pose");
        for node in nodes(rods, &field, &ramp.rod, ramp.at)? {
            ramps.push(Ramp::Pose { node, pose: poses::pose(&field, ramp, model, node)? });
        }
    }
    for ramp in &text.plane.0 {
        let obstacle =
            obstacles::find(&model.obstacles, (&format!("{field}.plane"), Obstacle::is_plane), ramp.name.as_deref())?;
        ramps.push(Ramp::Obstacle { obstacle, which: ObstacleNumber::Level, to: ramp.to });
    }
    for ramp in &text.obstacle.0 {
        ramps.extend(obstacles::ramps(&format!("{field}.obstacle"), ramp, &model.obstacles)?);
    }
    ramps.extend(text.load.map(|to| Ramp::Load { to }));
    for ramp in &text.pressure.0 {
        let rod = find_rod(rods, &format!("{field}.pressure"), ramp.rod.as_deref())?;
        ramps.push(Ramp::Pressure { rod, to: ramp.to });
    }
    numbers(field, text, rods).map(|numbers| ramps.into_iter().chain(numbers).collect())
}

/// Ramps of the numbers of rods.
fn numbers(field: &str, text: &RampText, rods: &[Rod]) -> Result<Vec<Ramp>, InputError> {
    let mut ramps = Vec::new();
    let mut add = |field: String, name: Option<&str>, numbers: &[(RodNumber, Option<f64>)]| {
        let rod = find_rod(rods, &field, name)?;
        let given = numbers.iter().filter_map(|&(which, to)| to.map(|to| Ramp::Number { rod, which, to }));
        let before = ramps.len();
        ramps.extend(given);
        if ramps.len() == before { Err(InputError::inconsistent(field, "names no number to ramp")) } else { Ok(()) }
    };
    for ramp in &text.section.0 {
        let (bending, shearing) = (ramp.bending.map(|pair| pair.0), ramp.shearing.map(|pair| pair.0));
        let numbers = [
            (RodNumber::ContactRadius, ramp.contact_radius),
            (RodNumber::Bending1, bending.map(|pair| pair[0])),
            (RodNumber::Bending2, bending.map(|pair| pair[1])),
            (RodNumber::Twisting, ramp.twisting),
            (RodNumber::Stretching, ramp.stretching),
            (RodNumber::Shearing1, shearing.map(|pair| pair[0])),
            (RodNumber::Shearing2, shearing.map(|pair| pair[1])),
        ];
        add(format!("{field}.section"), ramp.rod.as_deref(), &numbers)?;
    }
    for ramp in &text.length.0 {
        add(format!("{field}.length"), ramp.rod.as_deref(), &[(RodNumber::Length, Some(ramp.to))])?;
    }
    for ramp in &text.natural.0 {
        let curvature = ramp.curvature.map(|pair| pair.0);
        let numbers = [
            (RodNumber::Curvature1, curvature.map(|pair| pair[0])),
            (RodNumber::Curvature2, curvature.map(|pair| pair[1])),
            (RodNumber::Twist, ramp.twist),
        ];
        add(format!("{field}.natural"), ramp.rod.as_deref(), &numbers)?;
    }
    for ramp in &text.binding.0 {
        add(format!("{field}.binding"), ramp.rod.as_deref(), &[(RodNumber::Binding, Some(ramp.to))])?;
    }
    Ok(ramps)
}
