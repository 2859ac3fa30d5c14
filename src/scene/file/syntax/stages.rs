//! Stages: motions and changes.

use schemars::JsonSchema;
use serde::Deserialize;

use super::SupportText;
use super::choices::FollowChoice;
use super::values::{At, List, OneOrMany, Pair, RodNames, some_table, table, tables};

fn one() -> usize {
    1
}

/// Stages without a scene.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct StagesText {
    pub stages: Vec<StageText>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct StageText {
    /// All motions and changes of the stage together, from the present values; a stage without a ramp needs `hold` or
    /// `release`.
    #[serde(default, deserialize_with = "table")]
    pub ramp: RampText,
    /// Nodes held from the beginning of the stage on, where they then are: displacement and turns count from there.
    #[serde(default, deserialize_with = "tables")]
    pub hold: Vec<SupportText>,
    /// Components of nodes let go from the beginning of the stage on.
    #[serde(default, deserialize_with = "tables")]
    pub release: Vec<SupportText>,
    /// Following of the path through limit points, in place of steps.
    #[serde(default, deserialize_with = "some_table")]
    #[schemars(extend("x-allowed" = "the last stage, one ramp"))]
    pub follow: Option<FollowChoice>,
    /// Number of equal steps; those that fail are halved, and come back to the grid.
    #[serde(default = "one")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000))]
    pub steps: usize,
}

/// Each but `load` is a table or a list of tables.
#[derive(Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct RampText {
    /// Link beyond that of the relaxed rod.
    #[serde(default)]
    #[schemars(extend("x-unit" = "turns", "x-allowed" = "closed rods"))]
    pub excess_link: OneOrMany<ScalarText>,
    /// Whole link, the natural one included.
    #[serde(default)]
    #[schemars(extend("x-unit" = "turns", "x-allowed" = "closed rods"))]
    pub link: OneOrMany<ScalarText>,
    /// Supercoiling density: link beyond the relaxed one, over base_pairs/helical_repeat.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "closed rods with `dna`"))]
    pub sigma: OneOrMany<ScalarText>,
    /// Turns of nodes.
    #[serde(default)]
    pub rotation: OneOrMany<RotationText>,
    /// Displacements of nodes.
    #[serde(default)]
    pub displacement: OneOrMany<DisplacementText>,
    /// Positions and frames to which clamped nodes are taken.
    #[serde(default)]
    pub pose: OneOrMany<PoseText>,
    /// Factor on all loads, at the start that of `load`.
    pub load: Option<f64>,
    /// Force per current length, inwards positive.
    #[serde(default)]
    #[schemars(extend("x-unit" = "F/L", "x-allowed" = "closed rods of planar scenes"))]
    pub pressure: OneOrMany<ScalarText>,
    /// Displacement of a plane along its normal, in all since the start of the run.
    #[serde(default)]
    #[schemars(extend("x-unit" = "L"))]
    pub plane: OneOrMany<PlaneRampText>,
    /// Motions of cylinders and spheres, and their radii.
    #[serde(default)]
    pub obstacle: OneOrMany<ObstacleRampText>,
    /// Contact radius and stiffnesses.
    #[serde(default)]
    pub section: OneOrMany<SectionRampText>,
    /// Reference length: the rod grows evenly, its link stays.
    #[serde(default)]
    #[schemars(extend("x-unit" = "L", "x-allowed" = "> 0; uniform natural strains"))]
    pub length: OneOrMany<ScalarText>,
    /// Natural curvature and twist.
    #[serde(default)]
    pub natural: OneOrMany<NaturalRampText>,
    /// Part of the natural state of a table, or of the change of it by proteins, that is in force.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "0 to 1; `natural` of a table, `sequence.proteins`"))]
    pub binding: OneOrMany<ScalarText>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct PlaneRampText {
    /// Name of the plane.
    #[schemars(extend("x-value" = "name", "x-default" = "the only plane"))]
    pub name: Option<String>,
    /// Value at the end of the stage.
    pub to: f64,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct ObstacleRampText {
    /// Name of the obstacle; a plane's, too.
    #[schemars(extend("x-value" = "name", "x-default" = "the only obstacle"))]
    pub name: Option<String>,
    /// Radius at the end of the stage.
    #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0,
        "x-allowed" = "more than the contact radii of rods inside", "x-default" = "stays"))]
    pub radius: Option<f64>,
    /// Displacement, in all since the start of the run.
    #[schemars(extend("x-unit" = "L", "x-default" = "stays"))]
    pub displacement: Option<List<f64, 3>>,
    /// Turns about its hinge, in all since the start of the run; before the displacement.
    #[schemars(extend("x-unit" = "turns", "x-default" = "stays"))]
    pub turns: Option<f64>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct SectionRampText {
    /// Rod whose section changes.
    #[schemars(extend("x-value" = "name", "x-default" = "the only rod"))]
    pub rod: Option<String>,
    /// Radius of the tube that touches.
    #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0, "x-allowed" = "from > 0", "x-default" = "stays"))]
    pub contact_radius: Option<f64>,
    /// Bending stiffness EI.
    #[schemars(extend("x-value" = "number or [about d1, about d2]", "x-unit" = "F L²", "exclusiveMinimum" = 0,
        "x-default" = "stays"))]
    pub bending: Option<Pair>,
    /// Twisting stiffness GJ.
    #[schemars(extend("x-unit" = "F L²", "exclusiveMinimum" = 0, "x-default" = "stays"))]
    pub twisting: Option<f64>,
    /// Stretching stiffness EA.
    #[schemars(extend("x-unit" = "F", "exclusiveMinimum" = 0, "x-default" = "stays"))]
    pub stretching: Option<f64>,
    /// Shear stiffness GA.
    #[schemars(extend("x-value" = "number or [along d1, along d2]", "x-unit" = "F", "exclusiveMinimum" = 0,
        "x-default" = "stays"))]
    pub shearing: Option<Pair>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct NaturalRampText {
    /// Rod whose natural state changes.
    #[schemars(extend("x-value" = "name", "x-allowed" = "straight or uniform by nature", "x-default" = "the only rod"))]
    pub rod: Option<String>,
    /// Natural curvature about d1 and d2.
    #[schemars(extend("x-value" = "[k1, k2]", "x-unit" = "rad/L", "x-default" = "stays"))]
    pub curvature: Option<List<f64, 2>>,
    /// Natural twist; the link of a closed rod stays.
    #[schemars(extend("x-unit" = "rad/L", "x-allowed" = "not in a stage with `excess_link`", "x-default" = "stays"))]
    pub twist: Option<f64>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct ScalarText {
    /// Rod whose quantity changes.
    #[schemars(extend("x-value" = "name", "x-default" = "the only rod"))]
    pub rod: Option<String>,
    /// Value at the end of the stage.
    pub to: f64,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct RotationText {
    /// Rod whose node is turned.
    #[serde(default)]
    #[schemars(extend("x-default" = "the only rod"))]
    pub rod: RodNames,
    /// Node that is turned.
    #[schemars(extend("x-allowed" = "rotation held"))]
    pub at: At,
    /// Axis of the turn.
    #[schemars(extend("x-allowed" = "not zero"))]
    pub axis: List<f64, 3>,
    /// A point of the axis: nodes are carried round together.
    #[schemars(extend("x-unit" = "L", "x-allowed" = "position held", "x-default" = "in place"))]
    pub through: Option<List<f64, 3>>,
    /// Turns in all since the start of the run, where rods are relaxed unless they were given twist, or since a stage
    /// held the node's rotation.
    #[schemars(extend("x-unit" = "turns", "x-allowed" = "with `through` at most 100 000"))]
    pub turns: f64,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct DisplacementText {
    /// Rod whose node moves.
    #[serde(default)]
    #[schemars(extend("x-default" = "the only rod"))]
    pub rod: RodNames,
    /// Node that moves.
    #[schemars(extend("x-allowed" = "position held"))]
    pub at: At,
    /// Displacement in all since the start of the run, or since a stage held the node's position.
    #[schemars(extend("x-unit" = "L"))]
    pub to: List<f64, 3>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct PoseText {
    /// Rod whose node moves.
    #[serde(default)]
    #[schemars(extend("x-default" = "the only rod"))]
    pub rod: RodNames,
    /// Node that moves.
    #[schemars(extend("x-allowed" = "position and rotation held"))]
    pub at: At,
    /// Its position at the end of the stage.
    #[schemars(extend("x-unit" = "L", "x-default" = "stays"))]
    pub position: Option<List<f64, 3>>,
    /// Its frame: the rotation that takes x, y, z to d1, d2, d3.
    #[schemars(extend("x-value" = "[w, x, y, z]", "x-allowed" = "length 1", "x-default" = "stays"))]
    pub quaternion: Option<List<f64, 4>>,
    /// The same as an axis and an angle.
    #[schemars(extend("x-value" = "[x, y, z, turns]", "x-allowed" = "-0.5 to 0.5 turns", "x-default" = "stays"))]
    pub axis_angle: Option<List<f64, 4>>,
    /// The same with columns d1, d2, d3.
    #[schemars(extend("x-value" = "three rows", "x-allowed" = "a rotation", "x-default" = "stays"))]
    pub matrix: Option<List<List<f64, 3>, 3>>,
    /// Whether position is a displacement, the rotation one about the global axes, both of the node as the run started.
    #[serde(default)]
    pub relative: bool,
    /// Way of the position; the frame takes the shortest turn on either.
    #[serde(default)]
    pub path: PathText,
    /// Whole turns about the rod's own tangent on top, in all since the start of the run, or since a stage held the
    /// node's rotation: link put in.
    #[schemars(extend("x-value" = "integer", "x-allowed" = "open rods", "x-default" = "as before"))]
    pub extra_turns: Option<f64>,
}

#[derive(Deserialize, JsonSchema, serde::Serialize, Clone, Copy, Default)]
#[serde(rename_all = "kebab-case")]
pub(in super::super) enum PathText {
    #[default]
    Straight,
    Screw,
}
