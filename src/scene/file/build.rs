//! From the text of a scene to the model.

use std::f64::consts::TAU;
use std::path::Path;

use crate::dna::base_pairs::AtRest;
use crate::dna::bound::Bound;
use crate::dna::sequence::{Helix, Sequence, Steps};
use crate::error::InputError;
use crate::math::{Quat, Vec3};
use crate::rod::within;
use crate::rod::{Along, Binding, Natural, Rod, RodMesh, RodNumber, Section, Shape, Stiffness};
use crate::scene::{Contact, ContactLaw, Fidelity, Joint, JointKind, LineLoad, Model, NodeLoad, Ramp, Stage, Support};
use crate::scene::{Obstacle, ObstacleNumber, read_natural, smooth_points};

use super::FollowChoice;
use super::by_base_pairs::{Dna, electrostatics};
use super::mesh::Unmeshed;
use super::places::{find_rod, find_rods, node, nodes};
use super::section::{GivenSection, section};
use super::shapes::{Wound, shape};
use super::text::{
    ContactText, EndText, JointText, JointWord, LawText, RampText, RodText, SceneText, SequenceText, ShapeText,
    StageText, SupportText,
};
use super::values::{GripText, NaturalText};
use super::{frames, gravity, memory, obstacles, poses, state};

/// Name of the only rod of a scene, if it has none.
const ONLY_ROD: &str = "rod";

/// Names the only rod of a scene if it has no name; refuses several rods without distinct names.
pub(super) fn name_rods(rods: &mut [RodText]) -> Result<(), InputError> {
    if let [only] = rods {
        if only.name.is_empty() {
            ONLY_ROD.clone_into(&mut only.name);
        }
        return Ok(());
    }
    for (i, rod) in rods.iter().enumerate() {
        let field = || format!("rods[{i}].name");
        if rod.name.is_empty() {
            let reason = "missing: where there are several rods, each needs a name, by which supports, loads, joints and \
                stages call it";
            return Err(InputError::inconsistent(field(), reason));
        }
        if rods[..i].iter().any(|other| other.name == rod.name) {
            let allowed = "a name that no other rod has".to_owned();
            return Err(InputError::Name { field: field(), name: rod.name.clone(), allowed });
        }
    }
    Ok(())
}

/// The problem, and base pairs at rest of the rods that have a sequence.
pub(super) fn model(text: &SceneText, base_dir: &Path) -> Result<(Model, Vec<Option<AtRest>>), InputError> {
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

/// A grip is a body that is there from the start.
fn check_no_grip(field: &str, text: &SupportText) -> Result<(), InputError> {
    if text.grip == GripText::None {
        return Ok(());
    }
    let reason = "is there from the start, and stays when its support is released: set it in [[supports]]";
    Err(InputError::inconsistent(format!("{field}.grip"), reason))
}

pub(super) fn stages(
    text: &[StageText],
    model: &Model,
    relaxed_links: &[Option<f64>],
) -> Result<Vec<Stage>, InputError> {
    further_stages(text, model, relaxed_links)
}

/// Stages that follow others, which may have ramped the loads. `relaxed_links`: link of relaxed DNA by rod, turns.
pub(super) fn further_stages(
    text: &[StageText],
    model: &Model,
    relaxed_links: &[Option<f64>],
) -> Result<Vec<Stage>, InputError> {
    let stage = |(i, stage): (usize, &StageText)| {
        let mut all = Vec::new();
        for (k, gone) in stage.release.iter().enumerate() {
            let field = format!("stages[{i}].release[{k}]");
            check_no_grip(&field, gone)?;
            let supports = supports(&field, gone, &model.rods)?;
            all.extend(supports.into_iter().map(Ramp::Release));
        }
        for (k, held) in stage.hold.iter().enumerate() {
            let field = format!("stages[{i}].hold[{k}]");
            check_no_grip(&field, held)?;
            let supports = supports(&field, held, &model.rods)?;
            all.extend(supports.into_iter().map(Ramp::Hold));
        }
        all.extend(ramps(&format!("stages[{i}].ramp"), &stage.ramp, model, relaxed_links)?);
        Ok(Stage { ramps: all, steps: stage.steps })
    };
    let stages = text.iter().enumerate().map(stage).collect::<Result<Vec<_>, _>>()?;
    model.check_stages(&stages)?;
    Ok(stages)
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
    if !matches!(stages[place].ramps.as_slice(), [only] if steady(only)) {
        let reason =
            "follows one ramp: of excess_link, rotation (without through), displacement of a node, load or pressure";
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

/// A rod of a scene, and its base pairs at rest if it has a sequence; the rods before it have `nodes` nodes.
fn rod(scene: &SceneText, text: &RodText, base_dir: &Path, nodes: usize) -> Result<(Rod, Option<AtRest>), InputError> {
    let path = format!("rods.{}", text.name);
    let contact = !matches!(scene.contact.law, LawText::None);
    let inside = |error| within(&path, error);
    let charged = scene.contact.electrostatics.is_some();
    let dna = text.dna.as_ref().map(|text| Dna::new(text, charged)).transpose().map_err(inside)?;
    let helix = text.sequence.as_ref().map(|given| helix(given, text.closed, base_dir)).transpose().map_err(inside)?;
    let molecule = helix.clone();
    let helix_length = helix.as_ref().map(|helix| helix.length);
    let by_sequence = helix.as_ref().map(|helix| helix.stiffness.clone());
    let turns_left_out = helix.as_ref().map_or(0.0, |helix| helix.turns_left_out);
    let GivenSection { section, stiffness, contact_radii } =
        section_or_dna(text, dna.as_ref(), contact, base_dir, by_sequence).map_err(inside)?;
    let excess_link = excess_link(&path, text, dna.as_ref())?;
    InputError::check(&format!("{path}.roll"), text.roll, true, "a finite number of turns")?;
    let binding = binding(&path, text, helix.as_ref(), base_dir)?;
    let natural = match &binding {
        Some(binding) => binding.natural(),
        None => natural(&path, text, helix, base_dir)?,
    };
    let pieces = molecule.as_ref().map(|helix| helix.num_steps.div_ceil(text.block().unwrap_or(1)));
    let given = GivenRod { scene, text, base_dir, nodes_before: nodes, dna: dna.as_ref(), excess_link, pieces };
    let mut rod = match &text.shape {
        ShapeText::State { file, rod } => {
            given.check_memory(text.elements)?;
            state::rod(text, &base_dir.join(file), *rod, section, natural)?
        }
        ShapeText::Frames { file } => {
            given.check_memory(text.elements)?;
            let length = helix_length.or(dna.as_ref().map(|dna| dna.length));
            frames::rod(text, &base_dir.join(file), (length, turns_left_out), section, natural)?
        }
        _ => given.of_shape(section, natural)?,
    };
    if let Some(stiffness) = stiffness {
        rod = rod.with_stiffness(stiffness)?;
    }
    if let Some(radii) = contact_radii {
        rod = rod.with_contact_radii(radii)?;
    }
    rod.turns_left_out = turns_left_out;
    rod.binding = binding;
    rod = with_link(&path, text, excess_link, rod)?;
    let fitted = matches!(text.shape, ShapeText::Points { fit: Some(_), .. });
    match (&text.dna, &dna) {
        (Some(given), _) if fitted && given.rise.is_none() => {}
        _ if fitted => {
            let reason = "takes the rise from the points: the rod needs dna, and that no rise";
            return Err(InputError::inconsistent(format!("{path}.shape.fit"), reason));
        }
        (_, Some(dna)) => dna.check_length(rod.length).map_err(inside)?,
        (_, None) => {}
    }
    if text.roll != 0.0 {
        roll(&mut rod, text);
    }
    let base_pairs = molecule.and_then(|helix| AtRest::new(&helix, rod.closed, rod.order, rod.num_segments()));
    Ok((rod, base_pairs))
}

/// Shape, section and counts from which a rod is meshed.
struct GivenRod<'a> {
    scene: &'a SceneText,
    text: &'a RodText,
    base_dir: &'a Path,
    /// Nodes of the rods before it.
    nodes_before: usize,
    dna: Option<&'a Dna>,
    excess_link: Option<f64>,
    /// Steps of a sequence, or blocks of them.
    pieces: Option<usize>,
}

impl GivenRod<'_> {
    fn path(&self) -> String {
        format!("rods.{}", self.text.name)
    }

    /// Refuses more elements than there is memory for; without a number the file decides.
    fn check_memory(&self, elements: Option<usize>) -> Result<(), InputError> {
        let Some(elements) = elements else { return Ok(()) };
        let nodes = self.nodes_before.saturating_add(elements.saturating_mul(self.text.order));
        memory::check(format!("{}.elements", self.path()), elements, nodes, self.scene.planar)
    }

    /// The rod of a shape that is given by its form.
    fn of_shape(&self, section: Section, natural: Natural) -> Result<Rod, InputError> {
        let (scene, text, path) = (self.scene, self.text, self.path());
        let length = self.dna.map(|dna| dna.length);
        let wound = Wound { section: &section, excess_link: self.excess_link, closed: text.closed, length };
        let shape = shape(&text.shape, self.base_dir, &wound).map_err(|error| within(&path, error))?;
        let unmeshed = Unmeshed {
            scene,
            rod: text,
            shape: &shape,
            section: &section,
            natural: &natural,
            dna: self.dna,
            pieces: self.pieces,
        };
        let elements = elements(&path, &unmeshed)?;
        self.check_memory(Some(elements)).map_err(|error| by_fidelity(error, scene, text))?;
        let mesh = RodMesh { closed: text.closed, num_elements: elements, order: text.order };
        let rod = Rod::new(&text.name, &shape, mesh, section, natural.clone());
        rod.map_err(|error| {
            let fits = |shape: &Shape| Rod::new(&text.name, shape, mesh, section, natural.clone()).is_ok();
            by_smoothing(error, &shape, text.closed, fits)
        })
    }
}

/// Number of elements: as given, as many as the fidelity asks for, or a node a base pair.
fn elements(path: &str, rod: &Unmeshed) -> Result<usize, InputError> {
    match (rod.rod.elements, rod.scene.fidelity, rod.by_sequence()) {
        (Some(elements), ..) | (None, None, Some(elements)) => Ok(elements),
        (None, Some(fidelity), _) => rod.elements(fidelity).map_err(|error| within(path, error)),
        (None, None, None) => {
            let reason = "missing: how many elements the rod has, unless the scene has a fidelity = \"draft\", \"balanced\" or \"reference\"";
            Err(InputError::inconsistent(format!("{path}.elements"), reason))
        }
    }
}

/// Says of points that make no rod how far they must be smoothed to make one, if that helps.
fn by_smoothing(error: InputError, shape: &Shape, closed: bool, fits: impl Fn(&Shape) -> bool) -> InputError {
    let (Shape::Points(points), InputError::Inconsistent { field, reason }) = (shape, &error) else { return error };
    let way: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let mean = way / points.len().max(1) as f64;
    let lengths = SMOOTHING.iter().map(|factor| rounded(factor * mean));
    let smooth = |length: &f64| smooth_points(points, closed, *length).is_ok_and(|points| fits(&Shape::Points(points)));
    match lengths.into_iter().find(smooth) {
        Some(length) => {
            InputError::inconsistent(field.clone(), format!("{reason}; points with smooth = {length} make a rod"))
        }
        None => error,
    }
}

/// Smoothing lengths that are tried, in mean distances of points, up to where smoothing ends.
const SMOOTHING: [f64; 9] = [0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 40.0, 80.0];

/// A number to two digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}

/// Says of too many elements that the fidelity asks for them, if it does.
fn by_fidelity(error: InputError, scene: &SceneText, text: &RodText) -> InputError {
    match (error, text.elements, scene.fidelity) {
        (InputError::Inconsistent { field, reason }, None, Some(fidelity)) => {
            let word = format!("{fidelity:?}").to_lowercase();
            let reason = format!("{reason}; fidelity = \"{word}\" asks for them: give fewer as elements");
            InputError::Inconsistent { field, reason }
        }
        (error, ..) => error,
    }
}

/// Turns every frame about d3.
fn roll(rod: &mut Rod, text: &RodText) {
    let turn = Quat::from_axis_angle(&Vec3::z_axis(), TAU * text.roll);
    rod.frames.iter_mut().for_each(|frame| *frame *= turn);
    // the shape's curvature keeps its direction in space, a given curvature keeps it in the section
    if let (NaturalText::AsShaped, Natural::Uniform { kappa }) = (&text.natural, &mut rod.natural) {
        *kappa = (turn.inverse() * Vec3::from(*kappa)).into();
    }
}

/// The bound natural state of a rod that has one: that of a table, beside a straight rod, or of a sequence with proteins,
/// beside the sequence alone.
fn binding(path: &str, text: &RodText, helix: Option<&Helix>, base_dir: &Path) -> Result<Option<Binding>, InputError> {
    let part = text.binding;
    InputError::check(&format!("{path}.binding"), part, (0.0..=1.0).contains(&part), "between 0 and 1")?;
    let free = match (&text.sequence, &text.natural) {
        (Some(given), NaturalText::Straight) if given.proteins.is_some() => {
            let alone = SequenceText { proteins: None, ..given.clone() };
            self::helix(&alone, text.closed, base_dir).map_err(|error| within(path, error))?.natural
        }
        (None, NaturalText::Table(_)) => Along::constant([0.0, 0.0, 1.0, 0.0, 0.0, 0.0].into()),
        _ if part == 1.0 => return Ok(None),
        _ => {
            let reason = "is of a natural table, or of the proteins of a sequence: this rod has neither";
            return Err(InputError::inconsistent(format!("{path}.binding"), reason));
        }
    };
    let bound = match (&text.natural, helix) {
        (NaturalText::Table(file), _) => read_natural(&base_dir.join(file))?,
        (_, Some(helix)) => helix.natural.clone(),
        (_, None) => return Ok(None),
    };
    Ok(Some(Binding { free, bound, part }))
}

/// The stress-free state: that of the scene, or of its sequence.
fn natural(path: &str, text: &RodText, helix: Option<Helix>, base_dir: &Path) -> Result<Natural, InputError> {
    Ok(match (&text.natural, helix) {
        (NaturalText::Straight, Some(helix)) => Natural::Varying(helix.natural),
        (_, Some(_)) => {
            return Err(InputError::inconsistent(
                format!("{path}.natural"),
                "the sequence gives the natural strains: remove it",
            ));
        }
        (NaturalText::Straight, None) => Natural::Straight,
        (NaturalText::AsShaped, None) => Natural::AsShaped,
        (NaturalText::Uniform(k), None) => Natural::Uniform { kappa: [k.curvature[0], k.curvature[1], k.twist] },
        (NaturalText::Table(file), None) => Natural::Varying(read_natural(&base_dir.join(file))?),
    })
}

/// The rod with its link or twist at the start.
fn with_link(path: &str, text: &RodText, excess_link: Option<f64>, rod: Rod) -> Result<Rod, InputError> {
    match (excess_link, text.link, text.twist) {
        (None, None, None) => Ok(rod),
        (Some(turns), None, None) => rod.with_excess_link(turns),
        (None, Some(_), None) if !text.closed => {
            let reason = "the rod is open: only a closed rod has a link; give its twist";
            Err(InputError::inconsistent(format!("{path}.link"), reason))
        }
        (None, Some(link), None) => {
            let turns = link - rod.relaxed_link();
            rod.with_excess_link(turns)
        }
        (None, None, Some(turns)) => rod.with_twist(turns),
        _ => Err(InputError::inconsistent(path, LINK_TWICE)),
    }
}

fn section_or_dna(
    text: &RodText,
    dna: Option<&Dna>,
    contact: bool,
    base_dir: &Path,
    by_sequence: Option<Along<Stiffness>>,
) -> Result<GivenSection, InputError> {
    match (&text.section, dna) {
        (Some(text), None) => section(text, contact, base_dir, by_sequence),
        (None, Some(_)) if by_sequence.is_some() => {
            let reason =
                "the sequence gives length, stiffness and natural strains: give it with section = { contact_radius }";
            Err(InputError::inconsistent("dna", reason))
        }
        (None, Some(dna)) => Ok(GivenSection::uniform(dna.section)),
        (Some(_), Some(_)) => {
            let reason = "follows from dna (bending_persistence, twist_persistence, stretch_modulus, diameter): give one of them";
            Err(InputError::inconsistent("section", reason))
        }
        (None, None) => Err(InputError::inconsistent("section", "missing: give a section, or dna")),
    }
}

/// Excess link at the start, turns, if given.
fn excess_link(path: &str, text: &RodText, dna: Option<&Dna>) -> Result<Option<f64>, InputError> {
    match (text.excess_link, text.sigma, dna) {
        (excess_link, None, _) => Ok(excess_link),
        (None, Some(sigma), Some(dna)) => {
            InputError::check(&format!("{path}.sigma"), sigma, true, "a finite number")?;
            Ok(Some(sigma * dna.relaxed_link))
        }
        (None, Some(_), None) => Err(InputError::inconsistent(format!("{path}.sigma"), NEEDS_DNA)),
        (Some(_), Some(_), _) => Err(InputError::inconsistent(path.to_owned(), LINK_TWICE)),
    }
}

const LINK_TWICE: &str = "excess_link, sigma, link and twist say one thing: give one of them";
const NEEDS_DNA: &str =
    "a supercoiling density is counted on the link of relaxed DNA: the rod has no dna, so give excess_link in turns";

/// The molecule of a sequence and a table of steps.
fn helix(text: &SequenceText, closed: bool, base_dir: &Path) -> Result<Helix, InputError> {
    let sequence = match (&text.fasta, &text.letters) {
        (Some(file), None) => Sequence::read(&base_dir.join(file))?,
        (None, Some(letters)) => Sequence::parse(letters)?,
        _ => return Err(InputError::inconsistent("sequence", "give either fasta = file or letters")),
    };
    let steps = match text.steps.as_str() {
        "ideal" => Steps::ideal(),
        "protein-dna-1998" => Steps::protein_dna_1998()?,
        file if Path::new(file).extension().is_some() => Steps::read(&base_dir.join(file))?,
        name => {
            let allowed = "\"ideal\", \"protein-dna-1998\" or a file (CSV)".to_owned();
            return Err(InputError::Name { field: "sequence.steps".to_owned(), name: name.to_owned(), allowed });
        }
    };
    let proteins = text.proteins.as_ref().map(|file| Bound::read(&base_dir.join(file))).transpose()?;
    let helix = sequence.helix_with(&steps, closed, &proteins.unwrap_or_default())?;
    match text.block {
        None => Ok(helix),
        Some(steps) => helix.in_blocks(steps),
    }
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
