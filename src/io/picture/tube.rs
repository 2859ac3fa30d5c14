//! From the points of a tube to short capsules on a smooth curve through them.

use super::camera::Camera;
use super::palette::linear;
use super::raster::Shape;
use super::{Stripe, Tube};
use crate::io::detail::within;
use crate::math::Vec3;
use std::f64::consts::TAU;

/// Largest turning of the tangent (rad) over one capsule; smaller is not seen with interpolated normals.
const TURNING: f64 = 0.1;
/// Largest turn of the stripe (rad) over one capsule.
const TWISTING: f64 = 0.3;
/// Points closer than this many radii to the last one are left out where the tube hardly bends.
const SPARSE: f64 = 0.4;

/// Tubes of a smaller radius, in samples, are lines: neither stripe nor roundness can be seen.
const THIN: f64 = 1.0;
/// Points of a line that lie this near, in samples, to what is drawn without them are left out.
const UNSEEN: f64 = 0.5;
/// Least width of what is drawn, in pixels: a rod much longer than thick must not vanish.
const LEAST_WIDTH: f64 = 1.0;

/// A piece of tube in sample coordinates.
pub(super) struct Capsule {
    /// Axis and radius.
    pub shape: Shape,
    /// Unit tangents at the ends.
    pub tangents: [Vec3; 2],
    /// Colours at the ends, linear light.
    pub colors: [Vec3; 2],
    /// Directions of the stripe at the ends; zero without stripe.
    pub stripe: [Vec3; 2],
    /// Cosine of the stripe's half angle and its colour, linear light.
    pub stripe_look: (f64, Vec3),
    /// Whether the end is that of an open tube and shows a round cap.
    pub caps: [bool; 2],
}

/// What is known at a node of a tube.
#[derive(Clone, Copy)]
struct Node {
    point: Vec3,
    tangent: Vec3,
    color: Vec3,
    stripe: Vec3,
}

/// All tubes cut into capsules.
pub(super) fn capsules(tubes: &[Tube], camera: &Camera) -> Vec<Capsule> {
    let mut all = Vec::new();
    for tube in tubes {
        let look = Look::of(tube, camera);
        let nodes = nodes(&look, 1.0 / camera.scale);
        let spans = if tube.closed { nodes.len() } else { nodes.len().saturating_sub(1) };
        for i in 0..spans {
            let last = i + 1 == nodes.len();
            let caps = [!tube.closed && i == 0, !tube.closed && i + 1 == spans];
            let seam = look.stripe.map_or(0.0, |s| if last { s.seam_turns } else { 0.0 });
            span(&look, nodes[i], nodes[(i + 1) % nodes.len()], seam, caps, camera, &mut all);
        }
        if let ([only], false) = (nodes.as_slice(), tube.closed) {
            span(&look, *only, *only, 0.0, [true; 2], camera, &mut all);
        }
    }
    all
}

/// How a tube is drawn.
struct Look<'a> {
    tube: &'a Tube,
    stripe: Option<&'a Stripe>,
    /// Radius as drawn, samples.
    radius: f64,
    thin: bool,
}

impl<'a> Look<'a> {
    fn of(tube: &'a Tube, camera: &Camera) -> Self {
        let radius = tube.radius * camera.scale;
        let thin = radius < THIN;
        let stripe = tube.stripe.as_ref().filter(|_| !thin);
        Self { tube, stripe, radius: radius.max(0.5 * LEAST_WIDTH * camera.per_pixel), thin }
    }

    /// Pieces beyond which nothing more is seen, of a span that turns by `turning` (rad) over `length` samples: the
    /// sagitta of a piece is then an eighth of a sample.
    fn pieces(&self, turning: f64, length: f64) -> f64 {
        let visible = (turning * length).sqrt();
        if self.thin { visible } else { visible.max(self.radius) }
    }
}

/// Indices of the points worth drawing: none repeated, none closer than can be seen.
fn worth_drawing(tube: &Tube, sample: f64) -> Vec<usize> {
    let points = &tube.points;
    let close = (SPARSE * tube.radius).max(sample);
    let mut kept: Vec<usize> = Vec::new();
    for i in 0..points.len() {
        let Some(&before) = kept.last() else {
            kept.push(i);
            continue;
        };
        let step = points[i] - points[before];
        let bends = points.get(i + 1).is_some_and(|next| step.angle(&(next - points[i])) > TURNING);
        let twists = tube.stripe.as_ref().is_some_and(|s| s.directions[i].angle(&s.directions[before]) > 1.0);
        let is_end = i + 1 == points.len() && !tube.closed;
        let gap = step.norm();
        if gap > 0.0 && (gap >= close || is_end || (gap >= 0.1 * close && (bends || twists))) {
            kept.push(i);
        }
    }
    if tube.closed && kept.len() > 1 && points[kept[0]] == points[kept[kept.len() - 1]] {
        kept.pop();
    }
    kept
}

/// Nodes of a tube with what is known there; `sample` is the size of a sample \[L\].
fn nodes(look: &Look, sample: f64) -> Vec<Node> {
    let (tube, grey) = (look.tube, [150, 155, 160]);
    let kept = if look.thin { within(&tube.points, UNSEEN * sample, usize::MAX) } else { worth_drawing(tube, sample) };
    let tangents = tangents(&kept.iter().map(|&i| tube.points[i]).collect::<Vec<_>>(), tube.closed);
    let color = |i: usize| linear(tube.colors.get(i).or(tube.colors.first()).copied().unwrap_or(grey));
    let stripe = |i: usize, t: Vec3| {
        let d = look.stripe.map_or(Vec3::zeros(), |s| s.directions[i]);
        (d - t * t.dot(&d)).try_normalize(0.0).unwrap_or_default()
    };
    let node = |(&i, &tangent): (&usize, &Vec3)| Node {
        point: tube.points[i],
        tangent,
        color: color(i),
        stripe: stripe(i, tangent),
    };
    kept.iter().zip(&tangents).map(node).collect()
}

/// Unit tangents at the points: of the circle (or parabola, at ends) through neighbouring points.
fn tangents(points: &[Vec3], closed: bool) -> Vec<Vec3> {
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

/// Cuts the smooth curve between two nodes into capsules.
fn span(look: &Look, a: Node, b: Node, seam: f64, caps: [bool; 2], camera: &Camera, all: &mut Vec<Capsule>) {
    let length = (b.point - a.point).norm();
    let twist = twist_between(&a, &b) + TAU * (seam - seam.round());
    let twist = twist - TAU * (twist / TAU).round();
    let chord = b.point - a.point;
    let turning = a.tangent.angle(&b.tangent).max(2.0 * a.tangent.angle(&chord)).max(2.0 * b.tangent.angle(&chord));
    let pieces = (turning / TURNING).max(twist.abs() / TWISTING).min(look.pieces(turning, length * camera.scale));
    let pieces = pieces.ceil().clamp(1.0, 64.0) as usize;
    let at = |k: usize| {
        let u = k as f64 / pieces as f64;
        let (point, tangent) = hermite(&a, &b, length, u);
        let base = rotate_to(a.stripe, a.tangent, tangent);
        let (sin, cos) = (u * twist).sin_cos();
        let stripe = base * cos + tangent.cross(&base) * sin;
        Node { point, tangent, color: a.color.lerp(&b.color, u), stripe }
    };
    let (half_angle, color) = look.stripe.map_or((0.0, [0; 3]), |s: &Stripe| (s.half_angle, s.color));
    let mut from = at(0);
    for k in 1..=pieces {
        let to = at(k);
        all.push(Capsule {
            shape: Shape { ends: [camera.place(from.point), camera.place(to.point)], radius: look.radius },
            tangents: [camera.turn(from.tangent), camera.turn(to.tangent)],
            colors: [from.color, to.color],
            stripe: [camera.turn(from.stripe), camera.turn(to.stripe)],
            stripe_look: (half_angle.cos(), linear(color)),
            caps: [caps[0] && k == 1, caps[1] && k == pieces],
        });
        from = to;
    }
}

/// Point and unit tangent of the cubic through two nodes with their tangents.
fn hermite(a: &Node, b: &Node, length: f64, u: f64) -> (Vec3, Vec3) {
    let (v, third) = (1.0 - u, length / 3.0);
    let c = [a.point, a.point + a.tangent * third, b.point - b.tangent * third, b.point];
    let point = c[0] * (v * v * v) + c[1] * (3.0 * v * v * u) + c[2] * (3.0 * v * u * u) + c[3] * (u * u * u);
    let slope = (c[1] - c[0]) * (v * v) + (c[2] - c[1]) * (2.0 * u * v) + (c[3] - c[2]) * (u * u);
    (point, slope.try_normalize(0.0).unwrap_or(a.tangent))
}

/// Angle (rad) of the stripe of `b` against that of `a` carried along without turning.
fn twist_between(a: &Node, b: &Node) -> f64 {
    let carried = rotate_to(a.stripe, a.tangent, b.tangent);
    b.tangent.dot(&carried.cross(&b.stripe)).atan2(carried.dot(&b.stripe))
}

/// Smallest rotation from unit vector `from` to `to`, applied to `v`, which is normal to `from`.
fn rotate_to(v: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    let c = 1.0 + from.dot(&to);
    if c < 1e-9 { v } else { v - (from + to) * (to.dot(&v) / c) }
}
