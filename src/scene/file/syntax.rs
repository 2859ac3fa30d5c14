//! What a scene file may say: one struct per table; unknown keys are refused. `build` gives the meaning.
//!
//! Doc comments and attributes of the fields are the reference of keys (`supercoil help scene`), its page and the JSON
//! Schema: a comment is the meaning, `x-unit` the unit, a bound or `x-allowed` the range, serde's default or
//! `x-default` the default, `x-value` the form of a value where its type does not tell.

#[cfg(feature = "sweeps")]
pub(super) mod canonical;
pub(super) mod choices;
mod rods;
pub(super) mod set;
mod shapes;
mod stages;
pub(super) mod values;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::dna::salt::Charge;
use crate::error::InputError;
use crate::scene::{Fidelity, Units};

use choices::{OutputChoice, PictureChoice, SolverChoice, check_choices};
use values::{At, FixedAxes, GripText, List, RodNames, some_table, table, tables};

use rods::name_rods;
pub(super) use rods::{BeadText, DnaText, RodText, SectionText, SequenceText};
pub(super) use shapes::ShapeText;
pub(super) use stages::{ObstacleRampText, PathText, PoseText, RampText, StageText, StagesText};

/// Lengths are in one unit of length \[L\], forces in one unit of force \[F\]; all angles are in turns.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "scene of supercoil")]
pub(super) struct SceneText {
    /// Title, for reports.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "one line", "x-default" = "none"))]
    pub title: String,
    /// Names of the units, for reports; nothing is converted.
    #[serde(default, deserialize_with = "table")]
    #[schemars(extend("x-allowed" = "one line", "x-default" = "`L`, `F`; nm, pN with `dna` or `sequence`"))]
    pub units: Units,
    /// Whether all rods lie in a plane of constant z, and stay there.
    #[serde(default)]
    pub planar: bool,
    /// Temperature at which energies are also given in kT, where units are nm and pN. Stiffnesses of `dna` and
    /// `sequence` are those at 298 K, where kT is 4.114 pN nm.
    #[schemars(extend("x-unit" = "K", "exclusiveMinimum" = 0, "x-allowed" = "units nm and pN", "x-default" = "298"))]
    pub temperature: Option<f64>,
    /// Accuracy preset: sets elements, contact law and tolerances that are not given.
    pub fidelity: Option<Fidelity>,
    /// The rods.
    #[serde(deserialize_with = "tables")]
    #[schemars(extend("x-allowed" = "at least one"))]
    pub rods: Vec<RodText>,
    /// Supports of nodes.
    #[serde(default, deserialize_with = "tables")]
    pub supports: Vec<SupportText>,
    /// Nodes joined for good, rigidly, by pins or by hinges.
    #[serde(default, deserialize_with = "tables")]
    pub joints: Vec<JointText>,
    /// Dead forces and moments at nodes.
    #[serde(default, deserialize_with = "tables")]
    pub loads: Vec<LoadText>,
    /// Dead forces and moments per length.
    #[serde(default, deserialize_with = "tables")]
    pub line_loads: Vec<LineLoadText>,
    /// Acceleration that gives rods a weight; their `density`, `mass` or `weight` says how much. The weight is a line
    /// load.
    #[schemars(extend("x-unit" = "F/(unit of mass)", "x-allowed" = "not zero", "x-default" = "none"))]
    pub gravity: Option<List<f64, 3>>,
    /// Factor on all loads at the start, from which stages ramp it.
    #[schemars(extend("x-default" = "0 if a stage ramps `load`, otherwise 1"))]
    pub load: Option<f64>,
    /// Planes that rods touch on one side.
    #[serde(default, deserialize_with = "tables")]
    pub planes: Vec<PlaneText>,
    /// Cylinders and spheres that rods touch, from outside or from inside.
    #[serde(default, deserialize_with = "tables")]
    pub obstacles: Vec<ObstacleText>,
    /// Enforcement of contact.
    #[serde(default, deserialize_with = "table")]
    #[schemars(extend("x-default" = "those of its keys"))]
    pub contact: ContactText,
    /// Motions and changes, one stage after the other.
    #[serde(default, deserialize_with = "tables")]
    pub stages: Vec<StageText>,
    /// Tolerances, threads.
    #[serde(default, deserialize_with = "table")]
    #[schemars(extend("x-default" = "those of its keys"))]
    pub solver: SolverChoice,
    /// Files of a run.
    #[serde(default, deserialize_with = "table")]
    #[schemars(extend("x-default" = "those of its keys"))]
    pub output: OutputChoice,
    /// Settings of pictures.
    #[serde(default, deserialize_with = "table")]
    #[schemars(extend("x-default" = "those of its keys"))]
    pub picture: PictureChoice,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SupportText {
    /// Rod whose node is held.
    #[serde(default)]
    #[schemars(extend("x-default" = "the only rod"))]
    pub rod: RodNames,
    /// Node that is held.
    pub at: At,
    /// Components of its position that are held.
    #[serde(default)]
    pub position: FixedAxes,
    /// Axes about which its rotation is held; one alone is a joint of constant velocity.
    #[serde(default)]
    pub rotation: FixedAxes,
    /// Rigid capsule as thick as the rod that prolongs its end outwards along d3 and moves with the node. It takes part
    /// in contact, so that no loop and no knot slips over the end.
    #[serde(default)]
    #[schemars(extend("x-unit" = "L", "x-allowed" = "an end of an open rod that takes part in contact; not in stages"))]
    pub grip: GripText,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct JointText {
    /// One node. A stage that moves either node moves both; hinges are not turned.
    #[serde(deserialize_with = "table")]
    #[schemars(extend("x-allowed" = "at one place with `b`"))]
    pub a: EndText,
    /// The other node.
    #[serde(deserialize_with = "table")]
    #[schemars(extend("x-allowed" = "of another element"))]
    pub b: EndText,
    /// What the nodes share besides their position: all rotation, none, or all but that about `axis`.
    #[serde(default)]
    pub kind: JointWord,
    /// Axis of a hinge, in space, by the initial shapes; it turns with both rods. Hinges that meet at one point share
    /// one axis.
    #[schemars(extend("x-allowed" = "`kind = \"hinge\"`; not zero; along z in a planar scene",
        "x-default" = "needed for a hinge"))]
    pub axis: Option<List<f64, 3>>,
}

#[derive(Deserialize, JsonSchema, serde::Serialize, Clone, Copy, Default)]
#[serde(rename_all = "lowercase")]
pub(super) enum JointWord {
    #[default]
    Rigid,
    Pin,
    Hinge,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EndText {
    /// Rod of the node.
    #[schemars(extend("x-value" = "name", "x-default" = "the only rod"))]
    pub rod: Option<String>,
    /// The node.
    pub at: At,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LoadText {
    /// Rod whose node is loaded; each rod of a list bears the whole load.
    #[serde(default)]
    #[schemars(extend("x-default" = "the only rod"))]
    pub rod: RodNames,
    /// Node that is loaded.
    pub at: At,
    /// Force; keeps its direction, times the load factor of the stages.
    #[serde(default)]
    #[schemars(extend("x-unit" = "F"))]
    pub force: List<f64, 3>,
    /// Moment; keeps its direction, times the load factor of the stages.
    #[serde(default)]
    #[schemars(extend("x-unit" = "F L"))]
    pub moment: List<f64, 3>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LineLoadText {
    /// Rod that is loaded; each rod of a list bears the whole load.
    #[serde(default)]
    #[schemars(extend("x-default" = "the only rod"))]
    pub rod: RodNames,
    /// Force per reference length; keeps its direction, times the load factor of the stages.
    #[serde(default)]
    #[schemars(extend("x-unit" = "F/L"))]
    pub force: List<f64, 3>,
    /// Moment per reference length; keeps its direction in space, times the load factor of the stages.
    #[serde(default)]
    #[schemars(extend("x-unit" = "F"))]
    pub moment: List<f64, 3>,
}

/// A plane pushes rods away along its normal, without friction, under the law of `[contact]`: their surfaces stay above
/// it. It holds a rod by itself only where it faces the sum of the dead forces on the rod, as a table does its weight.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PlaneText {
    /// Name by which stages and reports call it.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "unlike the others", "x-default" = "`plane`, of an only plane"))]
    pub name: String,
    /// A point on it.
    #[serde(default)]
    #[schemars(extend("x-unit" = "L", "x-allowed" = "no rod starts below"))]
    pub point: List<f64, 3>,
    /// Unit normal, towards the rods.
    #[schemars(extend("x-allowed" = "length 1; in the x-y plane of planar scenes"))]
    pub normal: List<f64, 3>,
}

#[derive(Deserialize, JsonSchema, serde::Serialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
pub(super) enum ShapeOfObstacle {
    Cylinder,
    Sphere,
}

#[derive(Deserialize, JsonSchema, serde::Serialize, Clone, Copy, Default)]
#[serde(rename_all = "lowercase")]
pub(super) enum SideOfObstacle {
    #[default]
    Outside,
    Inside,
}

/// A rigid body without friction, under the law of `[contact]`: a post, a pulley, a ball that rods stay outside of; a
/// tube, a cavity that they stay inside. A cylinder has no ends.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ObstacleText {
    /// Name by which stages and reports call it.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "unlike the others", "x-default" = "that of the shape, of an only obstacle"))]
    pub name: String,
    /// What it is.
    pub shape: ShapeOfObstacle,
    /// A point on the axis; the centre of a sphere.
    #[serde(default)]
    #[schemars(extend("x-unit" = "L"))]
    pub point: List<f64, 3>,
    /// Direction of a cylinder.
    #[schemars(extend("x-allowed" = "not zero; along z, or in the x-y plane of the rods, in planar scenes",
        "x-default" = "needed for a cylinder"))]
    pub axis: Option<List<f64, 3>>,
    /// Radius.
    #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0,
        "x-allowed" = "more than the contact radii of rods inside"))]
    pub radius: f64,
    /// Where rods are.
    #[serde(default)]
    pub side: SideOfObstacle,
    /// Line fixed in space about which stages turn it.
    #[serde(default, deserialize_with = "some_table")]
    pub hinge: Option<HingeText>,
}

#[derive(Deserialize, JsonSchema, Clone, Copy)]
#[serde(deny_unknown_fields)]
pub(super) struct HingeText {
    /// A point on it.
    #[serde(default)]
    #[schemars(extend("x-unit" = "L"))]
    pub through: List<f64, 3>,
    /// Its direction.
    #[schemars(extend("x-allowed" = "not zero; along z in planar scenes"))]
    pub axis: List<f64, 3>,
}

#[derive(Deserialize, JsonSchema, serde::Serialize, Default)]
#[serde(rename_all = "kebab-case")]
pub(super) enum LawText {
    None,
    Penalty,
    #[default]
    AugmentedLagrangian,
}

#[derive(Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct ContactText {
    /// Way in which contact is enforced.
    #[serde(default)]
    pub law: LawText,
    /// Stiffness κ ε⁴/B: B smallest bending stiffness, ε smallest contact radius.
    #[schemars(extend("exclusiveMinimum" = 0, "x-default" = "by the mesh"))]
    pub stiffness: Option<f64>,
    /// Penetration left, over the smallest contact radius.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1, "x-default" = "1e-8, or by `fidelity`"))]
    pub tol_penetration: Option<f64>,
    /// Screened repulsion of the strands, beside hard contact.
    #[serde(default, deserialize_with = "some_table")]
    pub electrostatics: Option<ElectrostaticsText>,
}

/// Two points of strands at a distance r have the energy A exp(−r/λ)/r per product of their lengths; up to r = 10 λ.
/// Points of one rod do so from 4 to 8 λ along it on, beyond their energy on a straight rod.
#[derive(Deserialize, JsonSchema, Clone, Copy)]
#[serde(deny_unknown_fields)]
pub(super) struct ElectrostaticsText {
    /// Monovalent salt; gives A and λ. Rods with `dna` then have the bare contact diameter, 2 nm.
    #[serde(rename = "salt_mM")]
    #[schemars(extend("x-unit" = "mmol/l", "minimum" = 10, "maximum" = 1000, "x-allowed" = "units nm and pN",
        "x-default" = "needed without `strength`"))]
    pub salt: Option<f64>,
    /// Charge of the line: as effective diameters have it, or condensed by Manning's rule on a cylinder of 1 nm, see
    /// `dna::salt` in the library.
    #[schemars(extend("x-default" = "`\"diameter\"`"))]
    pub charge: Option<Charge>,
    /// A, in place of `salt_mM`.
    #[schemars(extend("x-unit" = "F", "exclusiveMinimum" = 0))]
    pub strength: Option<f64>,
    /// λ, in place of `salt_mM`.
    #[schemars(extend("x-unit" = "L", "x-allowed" = "0.01 to 100 contact radii"))]
    pub debye_length: Option<f64>,
}

impl SceneText {
    /// The text with a name for each rod; refuses words and settings out of their range.
    pub fn checked(mut self) -> Result<Self, InputError> {
        name_rods(&mut self.rods)?;
        check_words(&self)?;
        check_choices(&self.solver, &self.output)?;
        self.picture.check()?;
        Ok(self)
    }
}

/// Refuses strings with control characters, which would reach tables and terminals.
fn check_words(text: &SceneText) -> Result<(), InputError> {
    let words = [("title", &text.title), ("units.length", &text.units.length), ("units.force", &text.units.force)];
    let words = words.into_iter().map(|(key, word)| (key.to_owned(), word));
    let names = text.rods.iter().enumerate().map(|(i, rod)| (format!("rods[{i}].name"), &rod.name));
    match words.chain(names).find(|(_, word)| word.chars().any(char::is_control)) {
        Some((field, word)) => {
            let allowed = "one line without control characters".to_owned();
            Err(InputError::Name { field, name: word.clone(), allowed })
        }
        None => Ok(()),
    }
}
