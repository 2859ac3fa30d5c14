//! Sensitivities with respect to natural strains along rods: all rows of a table, or of a sequence, at once.
//!
//! The residual is linear in the natural strains ε⁰ at the integration points, r = ∫Bᵀ C (ε − ε⁰) ds. With the adjoint
//! λ and its strains Bλ
//!
//! ```text
//! dq/dε⁰ = ∂q/∂ε⁰ + w C Bλ        w the weight of the point, a length
//! ```
//!
//! A row of a table acts on the elements that it reaches, by [`Rod::natural_on_element`](crate::rod::Rod).

use super::EquilibriumTangent;
use super::modes::strains_along;
use super::observables::Observable;
use crate::error::InputError;
use crate::rod::{Natural, NaturalStrains};
use crate::solve::RunError;

/// Step of differences of natural strains over 1, or over 1/(element length) of curvatures: they are nearly linear in
/// the rows, by rotations of as much.
const STEP: f64 = 1e-4;

impl EquilibriumTangent<'_> {
    /// dq/dn for the six natural strains n (Γ1 Γ2 Γ3 K1 K2 K3) of each row of the table of a rod, or of each step of
    /// its sequence, shape (rows, 6). Of a natural state that is in force in part, the rows are those in force.
    ///
    /// # Errors
    /// A rod whose natural strains are no table; the moment at a seam; as [`EquilibriumTangent::gradient`].
    pub fn gradient_of_table(&mut self, of: &Observable, rod: usize) -> Result<Vec<[f64; 6]>, RunError> {
        let refuse = |reason: &str| Err(InputError::inconsistent("natural_strains", reason).into());
        let Some(data) = self.engine.model().rods.get(rod).cloned() else {
            return refuse("are of a rod that is not there");
        };
        let table = match &data.natural {
            Natural::Varying(along) => along.num_rows().map(|count| (along.clone(), count)),
            _ => None,
        };
        let Some((along, count)) = table else {
            return refuse("have no rows: the rod has no table of natural strains, and no sequence");
        };
        if matches!(of, Observable::SeamMoment { .. }) {
            return refuse("change the moment at a seam directly: differentiate the energy by the link instead");
        }
        let mut motion = self.adjoint(of)?.motion;
        if let Observable::Reaction { node, component } = of {
            // a reaction is the residual at a support
            motion[6 * self.engine.index(*node) + component] -= 1.0;
        }
        let slopes = strains_along(self.engine, &motion);
        let mut rows = vec![[0.0; 6]; count];
        let first = (0..self.engine.elements.len()).find(|e| self.engine.elements[*e].rod == rod).unwrap_or(0);
        let length = self.engine.element_length(rod);
        for local in 0..data.num_elements {
            let (e, start) = (first + local, local as f64 * length);
            let body = self.engine.body(first + local);
            let strain = self.engine.element_strain(e, self.engine.state());
            let by_point: [NaturalStrains; 3] = std::array::from_fn(|g| {
                let weight = body.table.rule.weights.get(g).map_or(0.0, |weight| weight * length);
                let mut slope = NaturalStrains::from(body.material.stress(g, &slopes[e][g]));
                if *of == Observable::Energy {
                    slope -= NaturalStrains::from(body.material.stress(g, &strain[g]));
                }
                slope * weight
            });
            let (part, range) = along.rows_between(start, start + length);
            for (k, row) in range.enumerate() {
                for component in 0..6 {
                    let step = if component < 3 { STEP } else { STEP / length };
                    let mut change = NaturalStrains::zeros();
                    change[component] = step;
                    let [more, less] = [change, -change].map(|by| {
                        data.natural_on_element(&part.with_row_changed(k, &by), local).map(NaturalStrains::from)
                    });
                    let sum: f64 = (0..3).map(|g| by_point[g].dot(&(more[g] - less[g]))).sum();
                    rows[row][component] += sum / (2.0 * step);
                }
            }
        }
        Ok(rows)
    }
}
