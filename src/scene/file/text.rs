//! The text of a scene file: one struct per table; unknown keys are refused. The parent module gives the meaning.

use std::path::PathBuf;

use serde::Deserialize;

use crate::dna::salt::Charge;
use crate::scene::{Fidelity, Units};

use super::values::{At, FixedAxes, List, NaturalText, OneOrMany, Pair, RodNames, some_table, table, tables};
use super::{FollowChoice, OutputChoice, PictureChoice, SolverChoice};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneText {
    #[serde(default)]
    pub title: String,
    #[serde(default, deserialize_with = "table")]
    pub units: Units,
    #[serde(default)]
    pub planar: bool,
    pub temperature: Option<f64>,
    pub fidelity: Option<Fidelity>,
    #[serde(deserialize_with = "tables")]
    pub rods: Vec<RodText>,
    #[serde(default, deserialize_with = "tables")]
    pub supports: Vec<SupportText>,
    #[serde(default, deserialize_with = "tables")]
    pub joints: Vec<JointText>,
    #[serde(default, deserialize_with = "tables")]
    pub loads: Vec<LoadText>,
    #[serde(default, deserialize_with = "tables")]
    pub line_loads: Vec<LineLoadText>,
    #[serde(default, deserialize_with = "tables")]
    pub planes: Vec<PlaneText>,
    #[serde(default, deserialize_with = "table")]
    pub contact: ContactText,
    #[serde(default, deserialize_with = "tables")]
    pub stages: Vec<StageText>,
    #[serde(default, deserialize_with = "table")]
    pub solver: SolverChoice,
    #[serde(default, deserialize_with = "table")]
    pub output: OutputChoice,
    #[serde(default, deserialize_with = "table")]
    pub picture: PictureChoice,
}

fn default_order() -> usize {
    3
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RodText {
    #[serde(default)]
    pub name: String,
    #[serde(default)]
    pub closed: bool,
    #[serde(deserialize_with = "table")]
    pub shape: ShapeText,
    #[serde(default, deserialize_with = "some_table")]
    pub section: Option<SectionText>,
    #[serde(default, deserialize_with = "some_table")]
    pub dna: Option<DnaText>,
    pub elements: Option<usize>,
    #[serde(default = "default_order")]
    pub order: usize,
    #[serde(default)]
    pub natural: NaturalText,
    #[serde(default, deserialize_with = "some_table")]
    pub sequence: Option<SequenceText>,
    #[serde(default)]
    pub roll: f64,
    pub excess_link: Option<f64>,
    pub link: Option<f64>,
    pub sigma: Option<f64>,
    pub twist: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DnaText {
    pub base_pairs: usize,
    #[serde(rename = "salt_mM")]
    pub salt: Option<f64>,
    pub diameter: Option<f64>,
    pub helical_repeat: Option<f64>,
    pub rise: Option<f64>,
    pub bending_persistence: Option<f64>,
    pub twist_persistence: Option<f64>,
    pub stretch_modulus: Option<f64>,
}

fn one() -> usize {
    1
}

fn unit_scale() -> f64 {
    1.0
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SequenceText {
    pub fasta: Option<PathBuf>,
    pub letters: Option<String>,
    pub steps: String,
    pub proteins: Option<PathBuf>,
    pub block: Option<usize>,
}

fn half() -> f64 {
    0.5
}

fn axis_x() -> List<f64, 3> {
    List([1.0, 0.0, 0.0])
}

fn axis_y() -> List<f64, 3> {
    List([0.0, 1.0, 0.0])
}

fn axis_z() -> List<f64, 3> {
    List([0.0, 0.0, 1.0])
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum ShapeText {
    Line {
        #[serde(default)]
        start: List<f64, 3>,
        #[serde(default = "axis_x")]
        direction: List<f64, 3>,
        length: Option<f64>,
    },
    Circle {
        length: Option<f64>,
        radius: Option<f64>,
        #[serde(default)]
        center: List<f64, 3>,
        #[serde(default = "axis_z")]
        normal: List<f64, 3>,
    },
    Arc {
        #[serde(default)]
        start: List<f64, 3>,
        #[serde(default = "axis_x")]
        tangent: List<f64, 3>,
        #[serde(default = "axis_y")]
        towards: List<f64, 3>,
        radius: f64,
        turns: f64,
    },
    Helix {
        #[serde(default)]
        center: List<f64, 3>,
        #[serde(default = "axis_z")]
        axis: List<f64, 3>,
        radius: f64,
        pitch: f64,
        turns: f64,
    },
    Points {
        file: PathBuf,
        columns: Option<Vec<String>>,
        frame: Option<i64>,
        chain: Option<String>,
        #[serde(default = "one")]
        every: usize,
        #[serde(default = "unit_scale")]
        scale: f64,
        smooth: Option<f64>,
    },
    Frames {
        file: PathBuf,
    },
    State {
        file: PathBuf,
        #[serde(default)]
        rod: usize,
    },
    Plectoneme {
        length: Option<f64>,
        distance: Option<f64>,
        turns: Option<f64>,
        angle: Option<f64>,
        center: Option<List<f64, 3>>,
        direction: Option<List<f64, 3>>,
        axis: Option<Box<ShapeText>>,
    },
    TorusKnot {
        length: Option<f64>,
        windings: List<i32, 2>,
        #[serde(default = "half")]
        aspect: f64,
        #[serde(default)]
        phase: f64,
        #[serde(default)]
        center: List<f64, 3>,
        #[serde(default = "axis_z")]
        normal: List<f64, 3>,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SectionText {
    pub table: Option<PathBuf>,
    pub stiffness: Option<List<List<f64, 6>, 6>>,
    pub bending: Option<Pair>,
    pub twisting: Option<f64>,
    pub stretching: Option<f64>,
    pub shearing: Option<Pair>,
    pub young: Option<f64>,
    pub poisson: Option<f64>,
    pub shear_modulus: Option<f64>,
    pub circle: Option<f64>,
    pub rectangle: Option<List<f64, 2>>,
    pub shear_correction: Option<f64>,
    pub contact_radius: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SupportText {
    #[serde(default)]
    pub rod: RodNames,
    pub at: At,
    #[serde(default)]
    pub position: FixedAxes,
    #[serde(default)]
    pub rotation: FixedAxes,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JointText {
    #[serde(deserialize_with = "table")]
    pub a: EndText,
    #[serde(deserialize_with = "table")]
    pub b: EndText,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EndText {
    pub rod: Option<String>,
    pub at: At,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LoadText {
    pub rod: Option<String>,
    pub at: At,
    #[serde(default)]
    pub force: List<f64, 3>,
    #[serde(default)]
    pub moment: List<f64, 3>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LineLoadText {
    pub rod: Option<String>,
    #[serde(default)]
    pub force: List<f64, 3>,
    #[serde(default)]
    pub moment: List<f64, 3>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PlaneText {
    #[serde(default)]
    pub name: String,
    #[serde(default)]
    pub point: List<f64, 3>,
    pub normal: List<f64, 3>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
pub(super) enum LawText {
    None,
    Penalty,
    #[default]
    AugmentedLagrangian,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct ContactText {
    #[serde(default)]
    pub law: LawText,
    pub stiffness: Option<f64>,
    pub tol_penetration: Option<f64>,
    #[serde(default, deserialize_with = "some_table")]
    pub electrostatics: Option<ElectrostaticsText>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(deny_unknown_fields)]
pub(super) struct ElectrostaticsText {
    #[serde(rename = "salt_mM")]
    pub salt: Option<f64>,
    pub charge: Option<Charge>,
    pub strength: Option<f64>,
    pub debye_length: Option<f64>,
}

/// Stages without a scene.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StagesText {
    pub stages: Vec<StageText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StageText {
    #[serde(default, deserialize_with = "table")]
    pub ramp: RampText,
    #[serde(default, deserialize_with = "tables")]
    pub hold: Vec<SupportText>,
    #[serde(default, deserialize_with = "tables")]
    pub release: Vec<SupportText>,
    #[serde(default, deserialize_with = "some_table")]
    pub follow: Option<FollowChoice>,
    #[serde(default = "one")]
    pub steps: usize,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RampText {
    #[serde(default)]
    pub excess_link: OneOrMany<ScalarText>,
    #[serde(default)]
    pub link: OneOrMany<ScalarText>,
    #[serde(default)]
    pub sigma: OneOrMany<ScalarText>,
    #[serde(default)]
    pub rotation: OneOrMany<RotationText>,
    #[serde(default)]
    pub displacement: OneOrMany<DisplacementText>,
    #[serde(default)]
    pub pose: OneOrMany<PoseText>,
    pub load: Option<f64>,
    #[serde(default)]
    pub pressure: OneOrMany<ScalarText>,
    #[serde(default)]
    pub plane: OneOrMany<PlaneRampText>,
    #[serde(default)]
    pub section: OneOrMany<SectionRampText>,
    #[serde(default)]
    pub length: OneOrMany<ScalarText>,
    #[serde(default)]
    pub natural: OneOrMany<NaturalRampText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PlaneRampText {
    pub name: Option<String>,
    pub to: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SectionRampText {
    pub rod: Option<String>,
    pub contact_radius: Option<f64>,
    pub bending: Option<Pair>,
    pub twisting: Option<f64>,
    pub stretching: Option<f64>,
    pub shearing: Option<Pair>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NaturalRampText {
    pub rod: Option<String>,
    pub curvature: Option<List<f64, 2>>,
    pub twist: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScalarText {
    pub rod: Option<String>,
    pub to: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RotationText {
    #[serde(default)]
    pub rod: RodNames,
    pub at: At,
    pub axis: List<f64, 3>,
    pub through: Option<List<f64, 3>>,
    pub turns: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DisplacementText {
    #[serde(default)]
    pub rod: RodNames,
    pub at: At,
    pub to: List<f64, 3>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PoseText {
    #[serde(default)]
    pub rod: RodNames,
    pub at: At,
    pub position: Option<List<f64, 3>>,
    pub quaternion: Option<List<f64, 4>>,
    pub axis_angle: Option<List<f64, 4>>,
    pub matrix: Option<List<List<f64, 3>, 3>>,
    #[serde(default)]
    pub relative: bool,
    #[serde(default)]
    pub path: PathText,
    pub extra_turns: Option<f64>,
}

#[derive(Deserialize, Clone, Copy, Default)]
#[serde(rename_all = "kebab-case")]
pub(super) enum PathText {
    #[default]
    Straight,
    Screw,
}
