//! `resultants.csv`: forces and moments along the rods of one state.

use std::path::Path;

use crate::error::InputError;
use crate::io::csv::{Cell, columns_in, write_explained};
use crate::math::{Quat, Vec3};
use crate::scene::Units;
use crate::solve::NodalFields;

/// Columns of `resultants.csv`: name, dimension, meaning.
const COLUMNS: [[&str; 3]; 11] = [
    ["rod", "", "name of the rod"],
    ["node", "", "index of the node in its rod, from 0"],
    ["arc_length", "L", "reference arc length from the rod's start"],
    ["tension", "F", "internal force along d3; negative: compression"],
    ["shear_1", "F", "internal force along d1"],
    ["shear_2", "F", "internal force along d2"],
    ["moment_1", "F L", "bending moment about d1"],
    ["moment_2", "F L", "bending moment about d2"],
    ["torque", "F L", "internal moment about d3"],
    ["curvature", "1/L", "curvature of the present shape, natural curvature included"],
    [
        "contact_force",
        "F/L",
        "contact force per reference length, smoothed over the width of the contact law or half an element",
    ],
];

/// One rod of the table; lists have one entry per node.
pub(in crate::io) struct ResultantsOf<'a> {
    pub name: &'a str,
    pub arc_lengths: Vec<f64>,
    pub frames: &'a [Quat],
    pub fields: &'a NodalFields,
    pub contact_force: &'a [Vec3],
}

impl ResultantsOf<'_> {
    fn row(&self, node: usize) -> Vec<Cell> {
        let [n, m] = [&self.fields.internal_force, &self.fields.internal_moment]
            .map(|global| self.frames[node].inverse_transform_vector(&global[node]));
        let contact = self.contact_force.get(node).map_or(0.0, Vec3::norm);
        let numbers = [n.z, n.x, n.y, m.x, m.y, m.z, self.fields.curvature[node], contact];
        let head = [self.name.into(), node.into(), self.arc_lengths[node].into()];
        head.into_iter().chain(numbers.map(Cell::Number)).collect()
    }
}

/// Writes internal forces and moments at the nodes, in the frame of each node: what the rod beyond the node exerts on
/// the rod before it. Units and meanings are in `resultants_columns.csv`.
///
/// # Errors
/// [`InputError::Write`] if the file cannot be written.
pub(in crate::io) fn write_resultants(path: &Path, rods: &[ResultantsOf], units: &Units) -> Result<(), InputError> {
    let rows = rods.iter().flat_map(|rod| (0..rod.arc_lengths.len()).map(|node| rod.row(node)));
    write_explained(path, &columns_in(units, &COLUMNS), rows)
}
