//! From what a scene file says to the problem.

mod by_base_pairs;
mod frames;
mod gravity;
pub(super) mod memory;
mod mesh;
mod obstacles;
mod places;
mod poses;
mod rods;
mod section;
mod shapes;
pub(super) mod stages;
mod state;

use std::path::Path;

use crate::dna::base_pairs::AtRest;
use crate::error::InputError;
use crate::rod::Rod;
use crate::scene::{Contact, ContactLaw, Fidelity, Joint, JointKind, LineLoad, Model, NodeLoad, Scene, Support};

use super::syntax::{ContactText, EndText, JointText, JointWord, LawText, RodText, SceneText, SupportText};
use by_base_pairs::{Dna, electrostatics};
use places::{find_rod, find_rods, node, nodes};
use rods::rod;

/// The scene of a checked text; without notices.
pub(super) fn scene(text: &SceneText, base_dir: &Path) -> Result<Scene, InputError> {
    let units = by_base_pairs::units(text)?;
    let (model, base_pairs) = model(text, base_dir)?;
    let charged = text.contact.electrostatics.is_some();
    let relaxed = |rod: &RodText| rod.dna.as_ref().map(|text| Dna::new(text, charged)).transpose();
    let relaxed = text.rods.iter().map(relaxed).collect::<Result<Vec<_>, _>>()?;
    let num_base_pairs = relaxed.iter().map(|dna| dna.map(|dna| dna.base_pairs)).collect();
    let relaxed_links: Vec<Option<f64>> = relaxed.iter().map(|dna| dna.map(|dna| dna.relaxed_link)).collect();
    let mass = |(rod, built): (&RodText, &Rod)| gravity::line_density(text, rod, built.length);
    let line_densities = text.rods.iter().zip(&model.rods).map(mass).collect::<Result<Vec<_>, _>>()?;
    let stages = stages::stages(&text.stages, &model, &relaxed_links)?;
    let follow = stages::follow(&text.stages, &model, &stages)?;
    let mut solver = text.solver;
    solver.tol_increment = solver.tol_increment.or(text.fidelity.map(Fidelity::tol_increment));
    Ok(Scene {
        title: text.title.clone(),
        units,
        temperature: text.temperature,
        line_densities,
        relaxed_links,
        num_base_pairs,
        base_pairs,
        fidelity: text.fidelity,
        model,
        stages,
        follow,
        solver,
        output: text.output.clone(),
        picture: text.picture.clone(),
        ..Scene::default()
    })
}

/// The problem, and base pairs at rest of the rods that have a sequence.
fn model(text: &SceneText, base_dir: &Path) -> Result<(Model, Vec<Option<AtRest>>), InputError> {
    let (mut rods, mut base_pairs): (Vec<Rod>, Vec<_>) = Default::default();
    for rod_text in &text.rods {
        let nodes = rods.iter().map(Rod::num_nodes).sum();
        let (rod, pairs) = rod(text, rod_text, base_dir, nodes)?;
        rods.push(rod);
        base_pairs.push(pairs);
    }
    let contact = contact(&text.contact, text.fidelity, &rods)?;
    if contact.law.is_on() {
        memory::check_pairs(&rods)?;
    }
    let electrostatics = text.contact.electrostatics.map(electrostatics).transpose()?;
    let mut model = Model { rods, contact, electrostatics, planar: text.planar, ..Default::default() };
    for (i, support) in text.supports.iter().enumerate() {
        let supports = supports(&format!("supports[{i}]"), support, &model.rods)?;
        model.supports.extend(supports);
    }
    for (i, joint) in text.joints.iter().enumerate() {
        let end = |name: &str, end: &EndText| {
            let field = format!("joints[{i}].{name}");
            find_rod(&model.rods, &field, end.rod.as_deref()).and_then(|rod| node(&model.rods, &field, rod, end.at))
        };
        let (a, b) = (end("a", &joint.a)?, end("b", &joint.b)?);
        model.joints.push(Joint { a, b, kind: joint_kind(&format!("joints[{i}]"), joint)? });
    }
    for (i, load) in text.loads.iter().enumerate() {
        let field = format!("loads[{i}]");
        let (force, moment) = (load.force.into(), load.moment.into());
        let nodes = nodes(&model.rods, &field, &load.rod, load.at)?;
        model.loads.extend(nodes.into_iter().map(|node| NodeLoad { node, force, moment }));
    }
    for (i, load) in text.line_loads.iter().enumerate() {
        let (force, moment) = (load.force.into(), load.moment.into());
        let loaded = find_rods(&model.rods, &format!("line_loads[{i}]"), &load.rod)?;
        model.line_loads.extend(loaded.into_iter().map(|rod| LineLoad { rod, force, moment }));
    }
    gravity::check(text)?;
    for (index, rod) in text.rods.iter().enumerate() {
        let weight = gravity::weight(text, rod, model.rods[index].length)?;
        model.line_loads.extend(weight.map(|weight| LineLoad::of_force(index, weight)));
    }
    model.load = gravity::start_factor(text);
    model.obstacles = obstacles::obstacles(text, &model.rods)?;
    model.check().map(|()| (model, base_pairs))
}

fn joint_kind(field: &str, text: &JointText) -> Result<JointKind, InputError> {
    match (text.kind, text.axis) {
        (JointWord::Rigid, None) => Ok(JointKind::Rigid),
        (JointWord::Pin, None) => Ok(JointKind::Pin),
        (JointWord::Hinge, Some(axis)) => Ok(JointKind::Hinge { axis: axis.into() }),
        (JointWord::Hinge, None) => {
            Err(InputError::inconsistent(format!("{field}.axis"), "is missing: kind = \"hinge\" needs an axis"))
        }
        (JointWord::Rigid | JointWord::Pin, Some(_)) => {
            let reason = "is of hinges only: set kind = \"hinge\", or leave the axis out";
            Err(InputError::inconsistent(format!("{field}.axis"), reason))
        }
    }
}

fn supports(field: &str, text: &SupportText, rods: &[Rod]) -> Result<Vec<Support>, InputError> {
    let (position, rotation) = (text.position.0, text.rotation.0);
    if (position, rotation) == ([false; 3], [false; 3]) {
        let reason = "names no component: set position or rotation to true or a list of axes";
        return Err(InputError::inconsistent(field.to_owned(), reason));
    }
    let nodes = nodes(rods, field, &text.rod, text.at)?;
    Ok(nodes.into_iter().map(|node| Support { node, position, rotation }).collect())
}

fn contact(text: &ContactText, fidelity: Option<Fidelity>, rods: &[Rod]) -> Result<Contact, InputError> {
    let unused = |key: &str, law: &str| {
        Err(InputError::inconsistent(
            format!("contact.{key}"),
            format!("has no meaning with law = \"{law}\": remove it"),
        ))
    };
    let least = fidelity.map_or(Contact::DEFAULT_LEAST_STIFFNESS, Fidelity::least_stiffness);
    let law = match text.law {
        LawText::None if text.stiffness.is_some() => return unused("stiffness", "none"),
        LawText::None if text.tol_penetration.is_some() => return unused("tol_penetration", "none"),
        LawText::Penalty if text.tol_penetration.is_some() => return unused("tol_penetration", "penalty"),
        LawText::None => ContactLaw::None,
        LawText::Penalty => {
            let by_mesh = || ContactLaw::stiffness_by_mesh(rods, least);
            ContactLaw::Penalty { stiffness: text.stiffness.unwrap_or_else(by_mesh) }
        }
        LawText::AugmentedLagrangian => {
            let preset = fidelity.map_or(Contact::DEFAULT_TOL_PENETRATION, |fidelity| fidelity.accuracy().penetration);
            let tol_penetration = text.tol_penetration.unwrap_or(preset);
            match text.stiffness {
                Some(stiffness) => ContactLaw::AugmentedLagrangian { stiffness, tol_penetration },
                None => ContactLaw::ByMesh { least, tol_penetration },
            }
        }
    };
    Ok(Contact { law })
}
