//! Rods: section, DNA, base sequence.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::InputError;

use super::ShapeText;
use super::values::{At, List, NaturalText, Pair, some_table, table, tables};

/// Name of the only rod of a scene, if it has none.
const ONLY_ROD: &str = "rod";

fn default_order() -> usize {
    3
}

fn whole() -> f64 {
    1.0
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct RodText {
    /// Name by which supports, loads, joints and stages call it.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "unlike the others", "x-default" = "`rod`, of an only rod"))]
    pub name: String,
    /// Whether its end is joined to its start.
    #[serde(default)]
    pub closed: bool,
    /// Centreline at the start.
    #[serde(deserialize_with = "table")]
    pub shape: ShapeText,
    /// Stiffnesses and contact radius.
    #[serde(default, deserialize_with = "some_table")]
    #[schemars(extend("x-default" = "from `dna`"))]
    pub section: Option<SectionText>,
    /// DNA, in place of `section` and of the shape's length.
    #[serde(default, deserialize_with = "some_table")]
    pub dna: Option<DnaText>,
    /// Mass per volume: times the area of the section's `circle` or `rectangle` and `gravity`, weight per length.
    #[schemars(extend("x-unit" = "mass/L³", "exclusiveMinimum" = 0, "x-allowed" = "with `gravity` or `output.modes`",
        "x-default" = "none"))]
    pub density: Option<f64>,
    /// Mass of the rod, in place of `density`.
    #[schemars(extend("x-unit" = "mass", "exclusiveMinimum" = 0, "x-allowed" = "with `gravity` or `output.modes`",
        "x-default" = "none"))]
    pub mass: Option<f64>,
    /// Weight per reference length, in place of `density`; of `gravity` the direction counts.
    #[schemars(extend("x-unit" = "F/L", "exclusiveMinimum" = 0, "x-allowed" = "with `gravity`", "x-default" = "none"))]
    pub weight: Option<f64>,
    /// Part of the natural state of a table, or of the change of it by proteins, that is in force at the start; the
    /// rest is that of a straight rod, or of the sequence alone.
    #[serde(default = "whole")]
    #[schemars(extend("minimum" = 0, "maximum" = 1, "x-allowed" = "`natural` of a table, `sequence.proteins`"))]
    pub binding: f64,
    /// Number of elements.
    #[schemars(extend("minimum" = 1,
        "x-default" = "by `fidelity`; a node a base pair of a `sequence`; those of a `state`"))]
    pub elements: Option<usize>,
    /// Order of the elements.
    #[serde(default = "default_order")]
    #[schemars(extend("minimum" = 1, "maximum" = 3))]
    pub order: usize,
    /// Curvature and twist of the unstressed rod, rad/L; k1 bends about d1. As shaped: those of the start shape and its
    /// `roll`, before link or twist is added.
    #[serde(default)]
    #[schemars(extend("x-default" = "`\"straight\"`"))]
    pub natural: NaturalText,
    /// Base sequence of DNA: gives stiffness and natural strains; with `section = { contact_radius }`.
    #[serde(default, deserialize_with = "some_table")]
    pub sequence: Option<SequenceText>,
    /// Turn of every frame about d3; without it d1 is the normal of plane curves in the x-y plane.
    #[serde(default)]
    #[schemars(extend("x-unit" = "turns"))]
    pub roll: f64,
    /// Link at the start beyond that of the relaxed rod, its twist spread evenly.
    #[schemars(extend("x-unit" = "turns", "x-allowed" = "closed rods", "x-default" = "the writhe of the shape"))]
    pub excess_link: Option<f64>,
    /// Whole link at the start, the natural one (∫k3 ds/2π) included; in place of `excess_link`.
    #[schemars(extend("x-unit" = "turns", "x-allowed" = "closed rods"))]
    pub link: Option<f64>,
    /// Supercoiling density ΔLk / (base_pairs/helical_repeat) at the start; in place of `excess_link`.
    #[schemars(extend("x-allowed" = "closed rods with `dna`"))]
    pub sigma: Option<f64>,
    /// Twist at the start beyond the natural one, spread evenly; the frame at s = 0 stays.
    #[schemars(extend("x-unit" = "turns", "x-allowed" = "open rods", "x-default" = "0"))]
    pub twist: Option<f64>,
    /// Rigid balls about nodes, which move with them and take part in contact.
    #[serde(default, deserialize_with = "tables")]
    pub beads: Vec<BeadText>,
}

/// A ball without friction that a node carries: what other strands exert on it acts on the node. The rod's own strand
/// next to the node, π/2 (radius + contact radius) to either side, does not touch it. Beads do not touch each other,
/// nor obstacles.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct BeadText {
    /// Node at its centre.
    pub at: At,
    /// Radius.
    #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0))]
    pub radius: f64,
    /// Name by which stages and reports call it.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "unlike those of planes, obstacles and other beads",
        "x-default" = "`ROD_bead`, with a number if the rod has several"))]
    pub name: String,
}

impl RodText {
    /// Steps of a block of the sequence.
    pub fn block(&self) -> Option<usize> {
        self.sequence.as_ref().and_then(|sequence| sequence.block)
    }
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct SectionText {
    /// Full stiffness along the rod, and `contact_radius` if it is tapered; in place of the others, see
    /// `scene::read_section` in the library.
    #[schemars(extend("x-value" = "text", "x-allowed" = "CSV"))]
    pub table: Option<PathBuf>,
    /// Full stiffness, order shear 1, shear 2, stretch, bending about d1, about d2, twist; in place of the others.
    #[schemars(extend("x-value" = "six rows of six numbers", "x-unit" = "F, F L, F L²",
        "x-allowed" = "symmetric, positive definite"))]
    pub stiffness: Option<List<List<f64, 6>, 6>>,
    /// Bending stiffness EI.
    #[schemars(extend("x-value" = "number or [about d1, about d2]", "x-unit" = "F L²", "exclusiveMinimum" = 0,
        "x-default" = "needed without moduli"))]
    pub bending: Option<Pair>,
    /// Twisting stiffness GJ.
    #[schemars(extend("x-unit" = "F L²", "exclusiveMinimum" = 0, "x-default" = "needed without moduli"))]
    pub twisting: Option<f64>,
    /// Stretching stiffness EA.
    #[schemars(extend("x-unit" = "F", "exclusiveMinimum" = 0, "x-default" = "needed without moduli"))]
    pub stretching: Option<f64>,
    /// Shear stiffness GA.
    #[schemars(extend("x-value" = "number or [along d1, along d2]", "x-unit" = "F", "exclusiveMinimum" = 0,
        "x-default" = "needed without moduli"))]
    pub shearing: Option<Pair>,
    /// Young's modulus; with `poisson` or `shear_modulus` and `circle` or `rectangle` it gives the stiffnesses.
    #[schemars(extend("x-unit" = "F/L²", "exclusiveMinimum" = 0))]
    pub young: Option<f64>,
    /// Poisson's ratio.
    #[schemars(extend("exclusiveMinimum" = -1, "maximum" = 0.5))]
    pub poisson: Option<f64>,
    /// Shear modulus, in place of Poisson's ratio.
    #[schemars(extend("x-unit" = "F/L²", "exclusiveMinimum" = 0))]
    pub shear_modulus: Option<f64>,
    /// Radius of a disc.
    #[schemars(extend("x-unit" = "L", "exclusiveMinimum" = 0))]
    pub circle: Option<f64>,
    /// Sides of a rectangle.
    #[schemars(extend("x-value" = "[along d1, along d2]", "x-unit" = "L", "x-allowed" = "> 0"))]
    pub rectangle: Option<List<f64, 2>>,
    /// Factor on the shear stiffness of moduli.
    #[schemars(extend("exclusiveMinimum" = 0, "x-default" = "Cowper's"))]
    pub shear_correction: Option<f64>,
    /// Radius of the tube that touches; a rod with 0 takes no part in contact.
    #[schemars(extend("x-unit" = "L", "minimum" = 0, "x-default" = "that of the `circle`"))]
    pub contact_radius: Option<f64>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct DnaText {
    /// Number of base pairs: gives the length, with `rise`; a shape with a length of its own must agree within 1 %.
    #[schemars(extend("minimum" = 1))]
    pub base_pairs: usize,
    /// Sodium chloride: gives the contact diameter (5 nm at 150); not with `contact.electrostatics`.
    #[serde(rename = "salt_mM")]
    #[schemars(extend("x-unit" = "mmol/l", "minimum" = 10, "maximum" = 1000, "x-default" = "150"))]
    pub salt: Option<f64>,
    /// Contact diameter.
    #[schemars(extend("x-unit" = "nm", "exclusiveMinimum" = 0, "x-default" = "by `salt_mM`"))]
    pub diameter: Option<f64>,
    /// Base pairs a turn: gives the link of the relaxed molecule, for `sigma`.
    #[schemars(extend("x-unit" = "base pairs/turn", "exclusiveMinimum" = 0, "x-default" = "10.5"))]
    pub helical_repeat: Option<f64>,
    /// Length of a base pair.
    #[schemars(extend("x-unit" = "nm", "exclusiveMinimum" = 0, "x-default" = "0.34"))]
    pub rise: Option<f64>,
    /// Persistence length of bending: times kT at 298 K, EI.
    #[schemars(extend("x-unit" = "nm", "exclusiveMinimum" = 0, "x-default" = "50"))]
    pub bending_persistence: Option<f64>,
    /// Persistence length of twist: times kT at 298 K, GJ.
    #[schemars(extend("x-unit" = "nm", "exclusiveMinimum" = 0, "x-default" = "75"))]
    pub twist_persistence: Option<f64>,
    /// Stretch modulus: EA and GA.
    #[schemars(extend("x-unit" = "pN", "exclusiveMinimum" = 0, "x-default" = "1100"))]
    pub stretch_modulus: Option<f64>,
}

#[derive(Deserialize, JsonSchema, Clone)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct SequenceText {
    /// File of the base sequence, relative to the scene file.
    #[schemars(extend("x-allowed" = "FASTA or oxDNA's topology", "x-default" = "needed without `letters`"))]
    pub fasta: Option<PathBuf>,
    /// The base sequence itself, in place of `fasta`.
    #[schemars(extend("x-allowed" = "A, C, G, T; `random:336:7` (336 bases, seed 7); `poly:AT:336`"))]
    pub letters: Option<String>,
    /// Means and stiffness of the base-pair steps, see `dna::sequence` in the library; a step from base pair to base
    /// pair, of closed rods also back to the first.
    #[schemars(extend("x-allowed" = "`ideal`, `protein-dna-1998`, or a CSV file: of the sixteen steps, or of all \
        steps in order"))]
    pub steps: String,
    /// Pieces that proteins hold: `hold` (frozen, steps, block), `from`, `to` (base pairs from 1), `tilt`, `roll`,
    /// `twist`, `shift`, `slide`, `rise`, see `dna::bound` in the library.
    #[schemars(extend("x-allowed" = "CSV"))]
    pub proteins: Option<PathBuf>,
    /// So many steps together, with effective constants: the rod is the axis, its frames without the double helix, and
    /// needs no node a base pair; see `dna::blocks` in the library.
    #[schemars(extend("x-unit" = "steps", "minimum" = 1))]
    pub block: Option<usize>,
}

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
            let reason = "missing: where there are several rods, each needs a name, by which supports, loads, joints \
                and stages call it";
            return Err(InputError::inconsistent(field(), reason));
        }
        if rods[..i].iter().any(|other| other.name == rod.name) {
            let allowed = "a name that no other rod has".to_owned();
            return Err(InputError::Name { field: field(), name: rod.name.clone(), allowed });
        }
    }
    Ok(())
}
