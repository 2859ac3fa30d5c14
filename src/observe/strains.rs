//! Strains and stress resultants of the elements at the integration points.

use crate::rod::element::{Strain, Stress, raw_strains};
use crate::solve::Engine;

/// Strains and stress resultants of one rod, each at `order` integration points an element, along the rod.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RodStrains {
    /// Reference arc length of each point \[L\].
    pub arc_lengths: Vec<f64>,
    /// Γ1, Γ2, Γ3 (1 at rest) and K1, K2, K3 \[1/L\] of the present shape, natural strains included.
    pub strains: Vec<Strain>,
    /// Forces \[F\] and moments \[F·L\] along d1, d2, d3: stiffness × (strain − natural strain).
    pub stresses: Vec<Stress>,
}

/// Strains and stress resultants of a rod at the present state.
///
/// # Panics
/// If there is no such rod.
#[must_use]
pub fn strains(engine: &Engine, rod: usize) -> RodStrains {
    let (table, length) = (engine.table(rod), engine.element_length(rod));
    let natural = &engine.reference[rod];
    let mut out = RodStrains::default();
    for (index, e) in engine.elements_of(rod).enumerate() {
        let nodes = engine.element_nodes(engine.state(), &engine.elements[e]);
        let (strains, natural) = (raw_strains(table, &nodes, length), natural.of(e));
        let material = engine.body(e).material;
        for (g, point) in table.rule.points.iter().enumerate() {
            out.arc_lengths.push((index as f64 + point) * length);
            out.strains.push(strains[g]);
            out.stresses.push(material.stress(g, &std::array::from_fn(|k| strains[g][k] - natural[g][k])));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::Model;
    use std::f64::consts::TAU;

    /// A circle of a rod straight by nature: K1² + K2² = (2π/L)², moment EI·2π/L, no force.
    #[test]
    fn strains_of_a_circle() {
        let shape = Shape::Circle { length: 2.0, center: Vec3::zeros(), normal: Vec3::z() };
        let section = Section::isotropic(3.0, 1.5, 100.0, 100.0, 0.05);
        let rod = Rod::new("ring", &shape, RodMesh::closed(32, 3), section, Natural::Straight).unwrap();
        let engine = Engine::new(Model { rods: vec![rod], ..Model::default() }, None).unwrap();
        let found = strains(&engine, 0);
        assert_eq!((found.arc_lengths.len(), found.strains.len(), found.stresses.len()), (96, 96, 96));
        assert!(found.arc_lengths.windows(2).all(|pair| pair[0] < pair[1]) && found.arc_lengths[95] < 2.0);
        let curvature = TAU / 2.0;
        for (strain, stress) in found.strains.iter().zip(&found.stresses) {
            assert!((strain[3].hypot(strain[4]) / curvature - 1.0).abs() < 1e-6, "{strain:?}");
            assert!((stress[3].hypot(stress[4]) / (3.0 * curvature) - 1.0).abs() < 1e-6, "{stress:?}");
            assert!((strain[2] - 1.0).abs() < 1e-6 && strain[5].abs() < 1e-6, "{strain:?}");
        }
    }
}
