//! How tightly rods are bent for their thickness.
//!
//! A tube of radius ε about a curve overlaps itself within a bend where the curvature κ of the centreline is above 1/ε,
//! and nowhere else along a bend (Federer 1959: the reach of a curve). Contact acts between strands, not within a bend,
//! so beyond κε = 1 a state is not one of the tube.

use crate::math::Vec3;
use crate::rod::element::{Strain, raw_strains};
use crate::solve::problem::engine::Engine;

/// A bend of a rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bend {
    /// The rod.
    pub(crate) rod: usize,
    /// Reference arc length from its start \[L\].
    pub(crate) arc: f64,
    /// Curvature of the centreline × contact radius.
    pub(crate) tightness: f64,
}

impl Bend {
    /// The tighter of two.
    fn tighter(self, other: Self) -> Self {
        if other.tightness > self.tightness { other } else { self }
    }
}

impl Engine {
    /// Largest curvature \[1/L\] of a rod's centreline at its integration points, and the reference arc length \[L\]
    /// where it is. Where a rod is sheared it is not the bending of the sections. Linear elements have the same shear
    /// all along: how it changes from one to the next is no part of their curvature.
    pub fn largest_curvature(&self, rod: usize) -> [f64; 2] {
        let larger = |a: [f64; 2], b: [f64; 2]| if b[0] > a[0] { b } else { a };
        self.curvatures(rod).fold([0.0, 0.0], larger)
    }

    /// The tightest bend of the rods that may touch others or themselves; `None` without contact.
    pub(crate) fn tightest_bend(&self) -> Option<Bend> {
        let side = &self.contact;
        side.rods.iter().map(|&rod| self.tightest_bend_of(rod)).reduce(Bend::tighter)
    }

    /// The tightest bend of a rod.
    pub(crate) fn tightest_bend_of(&self, rod: usize) -> Bend {
        let thickness = |arc: f64| self.model.rods[rod].contact_radius_at(arc);
        let bend = |[curvature, arc]: [f64; 2]| Bend { rod, arc, tightness: curvature * thickness(arc) };
        let straight = Bend { rod, arc: 0.0, tightness: 0.0 };
        self.curvatures(rod).map(bend).fold(straight, Bend::tighter)
    }

    /// Curvature \[1/L\] and reference arc length \[L\] at the integration points of a rod.
    fn curvatures(&self, rod: usize) -> impl Iterator<Item = [f64; 2]> + '_ {
        let (length, table) = (self.element_length(rod), self.table(rod));
        let points = &table.rule.points;
        self.elements_of(rod).enumerate().flat_map(move |(index, e)| {
            let strains = raw_strains(table, &self.element_nodes(&self.state, &self.elements[e]), length);
            (0..table.order).map(move |g| {
                let rate = rate_of_stretch(&strains, points, g) / length;
                [curvature(&strains[g], &rate), (index as f64 + points[g]) * length]
            })
        })
    }
}

/// Curvature |v × r″|/|v|³ of the centreline from the components v of r′, which change at the rate v′, and the bending
/// and twist k of the frame: r″ = v′ + k × v.
fn curvature(&[v1, v2, v3, k1, k2, k3]: &Strain, rate: &Vec3) -> f64 {
    let (v, k) = (Vec3::new(v1, v2, v3), Vec3::new(k1, k2, k3));
    let size = v.norm();
    if size > 0.0 { v.cross(&(rate + k.cross(&v))).norm() / size.powi(3) } else { f64::INFINITY }
}

/// Slope at integration point `g` of the polynomial through v at the points \[0, 1\] of an element.
fn rate_of_stretch(strains: &[Strain; 3], points: &[f64], g: usize) -> Vec3 {
    let v = |h: usize| Vec3::new(strains[h][0], strains[h][1], strains[h][2]);
    // weight of point h in the barycentric form
    let weight = |h: usize| -> f64 {
        points.iter().enumerate().filter(|(k, _)| *k != h).map(|(_, x)| 1.0 / (points[h] - x)).product()
    };
    let slope = |h: usize| (v(h) - v(g)) * (weight(h) / weight(g) / (points[g] - points[h]));
    (0..points.len()).filter(|&h| h != g).map(slope).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Quat;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::Model;

    /// Sections that lean by 0.4 rad from the tangent of a helix of radius 1 and pitch 2π, and turn about their normal
    /// 9 rad a turn against it: its centreline has curvature ½ all the same, and the sections bend by another amount.
    #[test]
    fn a_sheared_rod_has_the_curvature_of_its_centreline() {
        let shape = Shape::Helix {
            center: Vec3::zeros(),
            axis: Vec3::z(),
            radius: 1.0,
            pitch: std::f64::consts::TAU,
            turns: 1.0,
        };
        for (order, tol) in [(2, 5e-2), (3, 5e-3)] {
            let [coarse, fine] = [48, 96].map(|num_elements| {
                let section = Section::isotropic(1.0, 1.0, 1.0, 1.0, 0.3);
                let mesh = RodMesh::open(num_elements, order);
                let rod = Rod::new("helix", &shape, mesh, section, Natural::Straight).unwrap();
                let mut engine = Engine::new(Model { rods: vec![rod], ..Model::default() }, None).unwrap();
                let plain = engine.largest_curvature(0)[0];
                assert!((plain - 0.5).abs() < 2e-3, "{order}: {plain}");
                let count = engine.state.frames.len();
                for (node, frame) in engine.state.frames.iter_mut().enumerate() {
                    let angle = std::f64::consts::TAU * node as f64 / (count - 1) as f64;
                    let radial = Vec3::new(angle.cos(), angle.sin(), 0.0);
                    let lean = Quat::from_scaled_axis(radial * 0.4);
                    *frame = lean * *frame * Quat::from_scaled_axis(Vec3::z() * (-9.0 * angle / std::f64::consts::TAU));
                }
                let sections = engine.nodal_fields(0).curvature[count / 2];
                assert!((sections - 0.5).abs() > 0.1, "{order}: {sections}");
                let [sheared, _] = engine.largest_curvature(0);
                let bend = engine.tightest_bend_of(0);
                assert!((bend.tightness - 0.3 * sheared).abs() < 1e-12, "{bend:?}");
                (sheared - 0.5).abs()
            });
            assert!(coarse < tol && fine < 0.6 * coarse, "{order}: {coarse} {fine}");
        }
    }
}
