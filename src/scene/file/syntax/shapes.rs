//! Centrelines at the start.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;

use super::values::List;

fn one() -> usize {
    1
}

fn three() -> i32 {
    3
}

fn unit_scale() -> f64 {
    1.0
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

/// What measured points determine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(in super::super) enum Fit {
    /// The length of a base pair.
    Rise,
}

#[derive(Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub(in super::super) enum ShapeText {
    /// A straight line.
    Line {
        /// Start of the line.
        #[serde(default)]
        #[schemars(extend("x-unit" = "L"))]
        start: List<f64, 3>,
        /// Direction of the line.
        #[serde(default = "axis_x")]
        #[schemars(extend("x-allowed" = "not zero"))]
        direction: List<f64, 3>,
        /// Length of the line.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0, "x-default" = "from `dna`"))]
        length: Option<f64>,
    },
    /// A circle.
    Circle {
        /// Circumference.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0, "x-default" = "from `dna`"))]
        length: Option<f64>,
        /// Radius, in place of the length.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0))]
        radius: Option<f64>,
        /// Centre.
        #[serde(default)]
        #[schemars(extend("x-unit" = "L"))]
        center: List<f64, 3>,
        /// Axis of the circle.
        #[serde(default = "axis_z")]
        #[schemars(extend("x-allowed" = "not zero"))]
        normal: List<f64, 3>,
    },
    /// An arc of a circle.
    Arc {
        /// Start of the arc.
        #[serde(default)]
        #[schemars(extend("x-unit" = "L"))]
        start: List<f64, 3>,
        /// Tangent at the start.
        #[serde(default = "axis_x")]
        #[schemars(extend("x-allowed" = "not zero"))]
        tangent: List<f64, 3>,
        /// Direction from the start to the centre.
        #[serde(default = "axis_y")]
        #[schemars(extend("x-allowed" = "not along `tangent`"))]
        towards: List<f64, 3>,
        /// Radius.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0))]
        radius: f64,
        /// Angle of the arc.
        #[schemars(extend("x-unit" = "turns", "exclusiveMinimum" = 0, "maximum" = 1))]
        turns: f64,
    },
    /// A helix.
    Helix {
        /// Start of the axis.
        #[serde(default)]
        #[schemars(extend("x-unit" = "L"))]
        center: List<f64, 3>,
        /// Direction of the axis.
        #[serde(default = "axis_z")]
        #[schemars(extend("x-allowed" = "not zero"))]
        axis: List<f64, 3>,
        /// Radius.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0))]
        radius: f64,
        /// Advance along the axis a turn.
        #[schemars(extend("x-unit" = "L"))]
        pitch: f64,
        /// Number of turns, right-handed positive.
        #[schemars(extend("x-unit" = "turns"))]
        turns: f64,
    },
    /// Points of a file, joined by a smooth curve.
    Points {
        /// File of the points, relative to the scene file. Closed rods: whether the first point is repeated at the end
        /// does not matter.
        #[schemars(extend("x-allowed" = "CSV, `.xyz`, `.vect` (Geomview), `.pdb` (its P atoms), `.npy`, an oxDNA \
            configuration; at most 256 MiB"))]
        file: PathBuf,
        /// Columns of a CSV file.
        #[schemars(extend("x-value" = "[\"x\", \"y\", \"z\"]", "x-allowed" = "names in the head line",
            "x-default" = "x, y, z, or the only three"))]
        columns: Option<Vec<String>>,
        /// Which of several frames (XYZ), curves (VECT), models (PDB), from 0; negative: from the last, −1.
        #[schemars(extend("x-default" = "the only one"))]
        frame: Option<i64>,
        /// Chain of a PDB file.
        #[schemars(extend("x-default" = "the only one"))]
        chain: Option<String>,
        /// Only every so many points, from the first.
        #[serde(default = "one")]
        #[schemars(extend("minimum" = 1))]
        every: usize,
        /// Factor on all coordinates.
        #[serde(default = "unit_scale")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        scale: f64,
        /// Smoothing length ℓ, after `every` and `scale`: the curve r minimises ∫(r − p)² + ℓ⁴ r″² ds for the points p.
        /// Of a wave of wavenumber k the part 1/(1 + (kℓ)⁴) is kept: half of waves 2πℓ long. Closed curves stay closed,
        /// end points of open ones where they are.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0,
            "x-allowed" = "at most 100 mean distances of points"))]
        smooth: Option<f64>,
        /// What follows from the length of the points, where they are a measured molecule: `rise`, the length of a base
        /// pair of `dna`, instead of an error where the two differ by more than 1 %.
        #[schemars(extend("x-allowed" = "with `dna` without `rise`", "x-default" = "none"))]
        fit: Option<Fit>,
    },
    /// Base pairs with their frames, in nm. Those of a rod that is straight at rest and has no `sequence` leave out the
    /// turns of the double helix.
    Frames {
        /// File of the frames, relative to the scene file.
        #[schemars(extend("x-allowed" = "`.npy` of shape (n, 4, 3), an oxDNA configuration of two strands, 3DNA's \
            `bp_step.par` or `ref_frames.dat`; at most 256 MiB"))]
        file: PathBuf,
    },
    /// The final state of a run, or that of its checkpoint.
    State {
        /// File of the state, relative to the scene file.
        #[schemars(extend("x-allowed" = "a `final_state.csv` or a `checkpoint.bin`"))]
        file: PathBuf,
        /// Which rod of the file, from 0. Its nodes and frames are taken as they are, or resampled where `elements` are
        /// given and differ. A closed rod's link is measured on them to a part of a turn; `excess_link` makes it exact.
        #[serde(default)]
        rod: usize,
    },
    /// A plectoneme: a closed superhelix of two strands with a loop at either end.
    Plectoneme {
        /// Length of the rod.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0, "x-default" = "from `dna`"))]
        length: Option<f64>,
        /// Distance of the strands.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0, "x-default" = "twice the contact radius"))]
        distance: Option<f64>,
        /// Turns of the superhelix, right-handed positive, in place of `angle`.
        #[schemars(extend("x-unit" = "turns"))]
        turns: Option<f64>,
        /// Angle of the strands to the axis.
        #[schemars(extend("x-unit" = "turns", "maximum" = 0.125,
            "x-default" = "that of least energy at `excess_link`"))]
        angle: Option<f64>,
        /// Centre.
        #[schemars(extend("x-unit" = "L", "x-default" = "[0, 0, 0]"))]
        center: Option<List<f64, 3>>,
        /// Direction of the axis.
        #[schemars(extend("x-allowed" = "not zero", "x-default" = "[1, 0, 0]"))]
        direction: Option<List<f64, 3>>,
        /// Open shape along which it is coiled up.
        #[schemars(extend("x-default" = "straight"))]
        axis: Option<Box<ShapeText>>,
    },
    /// A knot by its name, its braid word or its PD code, as a closed braid about an axis.
    Knot {
        /// Prime knot in Rolfsen's numbering, with three to eight crossings.
        #[schemars(extend("x-allowed" = "`3_1` to `8_21`", "x-default" = "needed without `braid` or `pd`"))]
        name: Option<String>,
        /// Braid word, in place of `name`: ±k exchanges strands k and k + 1, right-handed where positive.
        #[schemars(extend("x-value" = "list such as [1, -2, 1, -2]", "x-allowed" = "whole numbers, not 0"))]
        braid: Option<Vec<i32>>,
        /// Planar diagram code, in place of `name`: of each crossing its four edges counterclockwise, from the lower
        /// one that comes in, as KnotInfo and SnapPy have it.
        #[schemars(extend("x-value" = "list such as [[1, 5, 2, 4], [3, 1, 4, 6], [5, 3, 6, 2]]",
            "x-allowed" = "each edge twice; at most 1000 crossings"))]
        pd: Option<Vec<List<i32, 4>>>,
        /// Which curve, of a braid or a code of several: each is a rod, all with one `distance`.
        #[schemars(extend("minimum" = 0, "x-default" = "the only one"))]
        component: Option<usize>,
        /// Length of the rod.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0, "x-default" = "from `dna`, or by `distance`"))]
        length: Option<f64>,
        /// Distance between neighbouring strands, in place of `length`.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0))]
        distance: Option<f64>,
        /// Centre.
        #[serde(default)]
        #[schemars(extend("x-unit" = "L"))]
        center: List<f64, 3>,
    },
    /// An overhand knot in an open rod, between straight tails along x; tied loosely, about a round loop.
    Overhand {
        /// Length of the rod.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0, "x-allowed" = "at least 15 radii, of 3 half turns",
            "x-default" = "from `dna`"))]
        length: Option<f64>,
        /// Radius of the loop.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0))]
        radius: f64,
        /// Half turns by which the tails wind about each other: 3 make a trefoil, 5 a cinquefoil; negative ones the
        /// mirror image.
        #[serde(default = "three")]
        #[schemars(extend("x-allowed" = "odd, 3 to 99 or −99 to −3"))]
        half_turns: i32,
        /// Start of the rod.
        #[serde(default)]
        #[schemars(extend("x-unit" = "L"))]
        start: List<f64, 3>,
    },
    /// A torus knot.
    TorusKnot {
        /// Length of the rod.
        #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0, "x-default" = "from `dna`"))]
        length: Option<f64>,
        /// Windings about the axis and about the core.
        #[schemars(extend("x-value" = "[p, q]", "x-allowed" = "without common divisor"))]
        windings: List<i32, 2>,
        /// Small over large radius of the torus.
        #[serde(default = "half")]
        #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
        aspect: f64,
        /// Place on the knot at which the rod begins.
        #[serde(default)]
        #[schemars(extend("x-unit" = "turns"))]
        phase: f64,
        /// Centre.
        #[serde(default)]
        #[schemars(extend("x-unit" = "L"))]
        center: List<f64, 3>,
        /// Axis of the torus.
        #[serde(default = "axis_z")]
        #[schemars(extend("x-allowed" = "not zero"))]
        normal: List<f64, 3>,
    },
}
