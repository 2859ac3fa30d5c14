//! Curvature of a rod where a concentrated contact force makes its slope jump, and interpolation of states to an event.

use supercoil::internals::element::{ElementNodes, raw_strains};
use supercoil::internals::quadrature::gauss;
use supercoil::internals::quaternion::{spin, to_array};
use supercoil::internals::shape_functions::ShapeTable;
use supercoil::math::{Quat, Vec3};
use supercoil::nalgebra::{Quaternion, SMatrix, UnitQuaternion};
use supercoil::solve::Solver;

/// Concentrated force on a strand: resultant and standard deviation of its distribution along the strand.
#[derive(Debug, Clone, Copy)]
pub struct PointForce {
    /// Resultant \[F\].
    pub force: Vec3,
    /// \[L\].
    pub spread: f64,
}

/// Cells on either side whose moments are used: polynomials of degree 2 × CELLS − 1.
const CELLS: usize = 3;
/// Within this many layers (B/κ)^¼ of the contact law the rods feel more of it than the spread of its force tells:
/// elements that lie there are left out. A cell has as many elements as are left out, one at least: from cells of one
/// element seven elements away a quintic carries errors 590 000-fold to where the force is, from cells as wide as their
/// distance 930-fold.
const LAYERS: f64 = 8.0;

/// Tangent d3 and curvature vector d3' \[1/L\] that a rod would have at an arc length if the contact force there were
/// concentrated; the mean of what the elements on either side say.
///
/// A force F at s₀ gives the curvature a kink, F|s − s₀|/2B. The contact law smears it, and the elements know only as
/// much of it as their strains can hold: correct are, in every element, the mean and the first moment of the curvature
/// (their virtual displacements are a parabola and a cubic, on which the contact centreline agrees with the elements').
/// From these, the smeared kink's own are taken off, and the kink's branch of the side in question put on; the
/// polynomial of degree five that has the moments so found in three cells of elements of that side is evaluated at s₀.
pub fn tangent_and_curvature(solver: &Solver, rod: usize, arc: f64, point: PointForce) -> (Vec3, Vec3) {
    let engine = solver.engine();
    let data = &engine.model().rods[rod];
    let length = data.length / data.num_elements as f64;
    let boundary = (arc / length).round();
    let softness = data.section.contact_radius.powi(4) / engine.model().contact.law.stiffness().unwrap();
    let skipped = (LAYERS * softness.powf(0.25) / length) as isize;
    let width = skipped.max(1);
    let unit = width as f64 * length;
    let (mut tangent, mut curvature) = (Vec3::zeros(), Vec3::zeros());
    for side in [-1.0, 1.0] {
        let mut system = SMatrix::<f64, { 2 * CELLS }, { 2 * CELLS }>::zeros();
        let (mut tangents, mut bends) = (Vec::new(), Vec::new());
        for row in 0..CELLS {
            // in elements from the nearest boundary, and in cells from `arc`
            let beyond = skipped + row as isize * width;
            let first = if side < 0.0 { -beyond - width } else { beyond };
            let from = (boundary + first as f64 - arc / length) / width as f64;
            let (d3, bend) = moments_of_cell(solver, rod, boundary as isize + first, width);
            let sigma = point.spread / unit;
            let mend = moments(from, &[-sigma, sigma], |x| side * x - 0.5 * ((x - sigma).abs() + (x + sigma).abs()));
            for k in 0..2 {
                tangents.push(d3[k]);
                bends.push(bend[k] + point.force * (mend[k] * unit / (2.0 * data.section.bending[0])));
                for power in 0..2 * CELLS {
                    system[(2 * row + k, power)] = moments(from, &[], |x| x.powi(power as i32))[k];
                }
            }
        }
        let inverse = system.try_inverse().unwrap();
        for k in 0..2 * CELLS {
            tangent += tangents[k] * (0.5 * inverse[(0, k)]);
            curvature += bends[k] * (0.5 * inverse[(0, k)]);
        }
    }
    (tangent.normalize(), curvature)
}

/// ∫d3 dη, ∫d3 (2η − 1) dη and the same of d3' over the cell of `width` elements from the `first` on, 0 < η < 1 along
/// it.
fn moments_of_cell(solver: &Solver, rod: usize, first: isize, width: isize) -> ([Vec3; 2], [Vec3; 2]) {
    let count = solver.engine().model().rods[rod].num_elements as isize;
    let (mut d3, mut bend) = ([Vec3::zeros(); 2], [Vec3::zeros(); 2]);
    for k in 0..width {
        for point in gauss_points(solver, rod, (first + k).rem_euclid(count) as usize) {
            let eta = (k as f64 + point.xi) / width as f64;
            let weight = point.weight / width as f64;
            for (moment, weight) in [weight, (2.0 * eta - 1.0) * weight].into_iter().enumerate() {
                d3[moment] += point.d3 * weight;
                bend[moment] += point.bend * weight;
            }
        }
    }
    (d3, bend)
}

/// A Gauss point of an element: place in it (0 to 1), weight, d3 and d3' \[1/L\].
struct GaussPoint {
    xi: f64,
    weight: f64,
    d3: Vec3,
    bend: Vec3,
}

fn gauss_points(solver: &Solver, rod: usize, element: usize) -> Vec<GaussPoint> {
    let engine = solver.engine();
    let data = &engine.model().rods[rod];
    let order = data.order;
    let table = ShapeTable::new(order);
    let (positions, frames) = (engine.positions(rod), engine.frames(rod));
    let seam = spin(engine.state().seams()[rod]);
    let mut nodes = ElementNodes::default();
    for a in 0..=order {
        let place = element * order + a;
        let (over, node) = (place >= positions.len(), place % positions.len());
        nodes.r[a] = positions[node].into();
        nodes.q[a] = to_array(&if over { frames[node] * seam } else { frames[node] });
    }
    nodes.align_signs(order + 1);
    let strains = raw_strains(&table, &nodes, data.length / data.num_elements as f64);
    let point = |g: usize| {
        let q: [f64; 4] = std::array::from_fn(|k| (0..=order).map(|a| table.n[g][a] * nodes.q[a][k]).sum());
        let frame: Quat = UnitQuaternion::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3]));
        let kappa = Vec3::new(strains[g][3], strains[g][4], strains[g][5]);
        let (d3, bend) = (frame * Vec3::z(), frame * kappa.cross(&Vec3::z()));
        GaussPoint { xi: table.rule.points[g], weight: table.rule.weights[g], d3, bend }
    };
    (0..order).map(point).collect()
}

/// ∫f dξ and ∫f (2ξ − 1) dξ over the unit cell that starts at `from`, for a function smooth between `kinks`.
fn moments(from: f64, kinks: &[f64], f: impl Fn(f64) -> f64) -> [f64; 2] {
    let mut cuts = vec![from, from + 1.0];
    cuts.extend(kinks.iter().filter(|&&x| x > from && x < from + 1.0));
    cuts.sort_by(f64::total_cmp);
    let rule = gauss(5);
    let mut sum = [0.0; 2];
    for piece in cuts.windows(2) {
        for (&t, &w) in rule.points.iter().zip(rule.weights) {
            let x = piece[0] + (piece[1] - piece[0]) * t;
            let value = f(x) * w * (piece[1] - piece[0]);
            sum[0] += value;
            sum[1] += value * (2.0 * (x - from) - 1.0);
        }
    }
    sum
}

/// Value at x = 0 of the polynomial through all (x, y) (Neville).
pub fn interpolate_to_zero(x: &[f64], y: &[f64]) -> f64 {
    let mut y = y.to_vec();
    for k in 1..x.len() {
        for i in 0..x.len() - k {
            y[i] = (x[i + k] * y[i] - x[i] * y[i + 1]) / (x[i + k] - x[i]);
        }
    }
    y[0]
}
