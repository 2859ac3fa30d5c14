//! What the mesh costs: an estimate of the energy that a finer one would change.
//!
//! Moments are known best at the integration points of an element, p of them for order p. Between these the polynomial
//! through them is off by e = M⁽ᵖ⁾/p! ∏ (s − s_g), in which the p-th derivative of the moment is unknown. The
//! polynomial of an element, continued to the first point of the next one, is off by the same formula, and there the
//! moment is known:
//!
//! ```text
//! D = m_next(s₁) − P(s₁) = M⁽ᵖ⁾/p! ∏ (s₁ − s_g)       estimate: Σ ½ ∫ e · C⁻¹ e ds over elements, e as D tells
//! ```
//!
//! Moments are continuous where sections or natural strains jump, which strains are not. They jump where a moment acts
//! at a node: such ends of elements are left out, and the seams of closed rods, where frames do.

use crate::rod::element::Material;
use crate::scene::Fidelity;
use crate::solve::Engine;

use super::report::Observation;

/// Error of the energy over the estimate from moments, because at points of contact, where the moment has a kink, the
/// energy is off by 10 to 26 times that: a planar loop whose neck closes, on 5 and on 12 elements, against 24.
const AT_POINTS: f64 = 12.0;
/// Order of the error of the energy in the length of the elements, for the advice on their number. Smooth states have
/// 6, points of contact 3 to 5.
const ADVISED_ORDER: f64 = 4.0;
/// Moment over B/L below which a rod counts as unbent, because rounding alone bends straight rods by less.
const UNBENT: f64 = 2e-3;

/// Bending and twisting energy that a finer mesh would change, over the bending and twisting energy of the state: an
/// estimate from the moments of neighbouring elements, of the order of the relative error of the energy. 0 for rods
/// that are hardly bent or twisted. O(n).
pub(super) fn mesh_error(engine: &Engine, energy: f64) -> f64 {
    let model = engine.model();
    let stress = engine.actual_stress(engine.state());
    let (mut off, mut least) = (0.0, 0.0);
    let mut first = 0;
    for (index, rod) in model.rods.iter().enumerate() {
        let (order, length) = (rod.order, rod.length / rod.num_elements as f64);
        let rule = engine.table(index).rule;
        let jumps_at = moments_act(engine, index);
        let weight = squared_error(order, rule.points);
        for e in first + 1..first + rod.num_elements {
            if jumps_at[(e - first) * order] {
                continue;
            }
            let compliance = compliances(&engine.body(e).material);
            let squares = (0..3).map(|k| {
                let value = |e: usize, g: usize| stress[e][g][3 + k];
                let continued: f64 = (0..order).map(|g| value(e - 1, g) * continuation(order, rule.points, g)).sum();
                (value(e, 0) - continued).powi(2) * compliance[k]
            });
            off += 0.5 * length * weight * squares.sum::<f64>();
        }
        least += 0.5 * UNBENT.powi(2) * rod.section.smaller_bending() / rod.length;
        first += rod.num_elements;
    }
    AT_POINTS * off / (energy + least)
}

/// A note for a state whose bends have outgrown the mesh that a preset chose before they were there.
pub fn mesh_note(fidelity: Fidelity, now: &Observation) -> Option<String> {
    let (found, stated) = (now.mesh_error, fidelity.accuracy().energy);
    (found > stated).then(|| {
        let more = (found / stated).powf(1.0 / ADVISED_ORDER);
        let word = format!("{fidelity:?}").to_lowercase();
        format!(
            "the bends have outgrown the mesh: the energy is off by about {found:.0e} of it, where fidelity \
             = \"{word}\" states {stated:.0e}, and contact forces by more; {more:.1} times as many elements would do"
        )
    })
}

/// Whether a moment may act at a node of a rod, node by node: of a load, a support or a joint.
fn moments_act(engine: &Engine, rod: usize) -> Vec<bool> {
    let model = engine.model();
    let supports = model.supports.iter().filter(|s| s.rotation.contains(&true)).map(|s| s.node);
    let loads = model.loads.iter().map(|load| load.node);
    let joints = model.joints.iter().flat_map(|joint| [joint.a, joint.b]);
    let mut acts = vec![false; model.rods[rod].num_nodes()];
    supports.chain(loads).chain(joints).filter(|node| node.rod == rod).for_each(|node| acts[node.node] = true);
    acts
}

/// Diagonal of the inverse of the bending and twisting stiffness, nearly, of a full matrix.
fn compliances(material: &Material) -> [f64; 3] {
    let of = |diagonal: &dyn Fn(usize) -> f64| std::array::from_fn(|k| 1.0 / diagonal(3 + k));
    match material {
        Material::Diagonal(six) => of(&|k: usize| six[k]),
        Material::Full(points) => of(&|k: usize| points[0][k][k]),
    }
}

/// Weight of the value at integration point `g` of an element in its polynomial, at the first point of the next
/// element.
fn continuation(order: usize, points: &[f64], g: usize) -> f64 {
    crate::math::shape_functions::lagrange_weight(order, |k| points[k], g, 1.0 + points[0])
}

/// ∫ ∏ (s − s_g)² ds over an element of length 1, over the square of the product at the first point of the next
/// element.
fn squared_error(order: usize, points: &[f64]) -> f64 {
    let product = |x: f64| points[..order].iter().map(|g| x - g).product::<f64>();
    let rule = crate::math::quadrature::gauss(5);
    let integral: f64 = rule.points.iter().zip(rule.weights).map(|(x, w)| w * product(*x).powi(2)).sum();
    integral / product(1.0 + points[0]).powi(2)
}
