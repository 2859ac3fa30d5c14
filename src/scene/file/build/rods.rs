//! Rods: shape, section, natural state, mesh, link at the start.

use std::f64::consts::TAU;
use std::path::Path;

use crate::dna::base_pairs::AtRest;
use crate::dna::bound::Bound;
use crate::dna::sequence::{Helix, Sequence, Steps};
use crate::error::InputError;
use crate::math::{Quat, Vec3};
use crate::rod::within;
use crate::rod::{Along, Binding, Natural, Rod, RodMesh, Section, Shape, Stiffness};
use crate::scene::file::syntax::values::NaturalText;
use crate::scene::file::syntax::{LawText, RodText, SceneText, SequenceText, ShapeText};
use crate::scene::{read_natural, smooth_points};

use super::by_base_pairs::{Dna, NEEDS_DNA};
use super::mesh::Unmeshed;
use super::section::{GivenSection, section};
use super::shapes::{Wound, shape};
use super::{frames, memory, state};

/// Smoothing lengths that are tried, in mean distances of points, up to where smoothing ends.
const SMOOTHING: [f64; 9] = [0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 40.0, 80.0];
const LINK_TWICE: &str = "excess_link, sigma, link and twist say one thing: give one of them";

/// A rod of a scene, and its base pairs at rest if it has a sequence; the rods before it have `nodes` nodes.
pub(super) fn rod(
    scene: &SceneText,
    text: &RodText,
    base_dir: &Path,
    nodes: usize,
) -> Result<(Rod, Option<AtRest>), InputError> {
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
    if let (Some(dna), Some(link)) = (&dna, text.link) {
        check_link_of_dna(&path, link, dna)?;
    }
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
            let reason = "missing: how many elements the rod has, unless the scene has a fidelity \
                = \"draft\", \"balanced\" or \"reference\"";
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

/// The bound natural state of a rod that has one: that of a table, beside a straight rod, or of a sequence with
/// proteins, beside the sequence alone.
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

/// Refuses the link of a rod of DNA that counts the double helix, which `dna` leaves out: half of it is wound off in no
/// molecule.
fn check_link_of_dna(path: &str, link: f64, dna: &Dna) -> Result<(), InputError> {
    if link.abs() < 0.5 * dna.relaxed_link {
        return Ok(());
    }
    let reason = format!(
        "counts no turns of the double helix where a rod has dna: for Lk = {link} give excess_link = {:.4}, which is \
         Lk less base_pairs / helical_repeat = {:.4}",
        link - dna.relaxed_link,
        dna.relaxed_link
    );
    Err(InputError::inconsistent(format!("{path}.link"), &reason))
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
            let reason = "follows from dna (bending_persistence, twist_persistence, stretch_modulus, diameter): give \
                one of them";
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
