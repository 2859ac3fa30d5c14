//! The smooth curve through the points of a tube, with its material direction.

use crate::math::Vec3;
use crate::math::direction::transport;
use std::f64::consts::TAU;

/// Data at a node of a tube.
#[derive(Clone, Copy)]
pub(in crate::io) struct Node {
    pub point: Vec3,
    pub tangent: Vec3,
    pub radius: f64,
    /// Linear light.
    pub color: Vec3,
    /// Direction of the stripe, normal to the tangent; zero without stripe.
    pub stripe: Vec3,
}

/// The piece of tube between two nodes: a cubic whose material direction turns evenly.
pub(in crate::io) struct Span {
    a: Node,
    b: Node,
    /// Distance of the nodes.
    pub length: f64,
    /// Turning of the tangent, rad.
    pub turning: f64,
    /// Turn of the stripe, rad.
    pub twist: f64,
    /// Change of the radius.
    pub taper: f64,
}

impl Span {
    /// The span from `a` to `b`; the frame at `b` is rotated by `seam` turns.
    pub fn new(a: Node, b: Node, seam: f64) -> Self {
        let chord = b.point - a.point;
        let twist = twist_between(&a, &b) + TAU * (seam - seam.round());
        let twist = twist - TAU * (twist / TAU).round();
        let turning = a.tangent.angle(&b.tangent).max(2.0 * a.tangent.angle(&chord)).max(2.0 * b.tangent.angle(&chord));
        Self { a, b, length: chord.norm(), turning, twist, taper: (b.radius - a.radius).abs() }
    }

    /// The node at `u` from 0 to 1.
    pub fn at(&self, u: f64) -> Node {
        let (a, b) = (&self.a, &self.b);
        let (point, tangent) = hermite(a, b, self.length, u);
        let base = transport(a.stripe, a.tangent, tangent);
        let (sin, cos) = (u * self.twist).sin_cos();
        let stripe = base * cos + tangent.cross(&base) * sin;
        let radius = a.radius + u * (b.radius - a.radius);
        Node { point, tangent, radius, color: a.color.lerp(&b.color, u), stripe }
    }
}

/// Unit tangents at the points: of the circle (or parabola, at ends) through neighbouring points.
pub(in crate::io) fn tangents(points: &[Vec3], closed: bool) -> Vec<Vec3> {
    let num = points.len();
    let tangent = |i: usize| {
        let (before, after) = match (closed, i) {
            (false, 0) => (None, points.get(1)),
            (false, i) if i + 1 == num => (Some(&points[i - 1]), None),
            (_, i) => (Some(&points[(i + num - 1) % num]), Some(&points[(i + 1) % num])),
        };
        let here = points[i];
        let slope = match (before, after) {
            (Some(b), Some(a)) => {
                let (into, out) = (here - b, a - here);
                into * (out.norm() / into.norm().max(f64::MIN_POSITIVE))
                    + out * (into.norm() / out.norm().max(f64::MIN_POSITIVE))
            }
            (None, Some(a)) => a - here,
            (Some(b), None) => here - b,
            (None, None) => Vec3::x(),
        };
        slope.try_normalize(0.0).unwrap_or_else(Vec3::x)
    };
    (0..num).map(tangent).collect()
}

/// Point and unit tangent of the cubic through two nodes with their tangents.
fn hermite(a: &Node, b: &Node, length: f64, u: f64) -> (Vec3, Vec3) {
    let (v, third) = (1.0 - u, length / 3.0);
    let c = [a.point, a.point + a.tangent * third, b.point - b.tangent * third, b.point];
    let point = c[0] * (v * v * v) + c[1] * (3.0 * v * v * u) + c[2] * (3.0 * v * u * u) + c[3] * (u * u * u);
    let slope = (c[1] - c[0]) * (v * v) + (c[2] - c[1]) * (2.0 * u * v) + (c[3] - c[2]) * (u * u);
    (point, slope.try_normalize(0.0).unwrap_or(a.tangent))
}

/// Angle (rad) of the stripe of `b` relative to that of `a` after parallel transport.
fn twist_between(a: &Node, b: &Node) -> f64 {
    let carried = transport(a.stripe, a.tangent, b.tangent);
    b.tangent.dot(&carried.cross(&b.stripe)).atan2(carried.dot(&b.stripe))
}
