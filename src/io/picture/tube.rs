//! From the points of a tube to short capsules on a smooth curve through them.

use super::camera::Camera;
use super::palette::{PALE, linear};
use super::raster::ScreenCapsule;
use super::span::{Node, Span, tangents};
use super::{Stripe, Tube};
use crate::io::detail::within;
use crate::math::Vec3;

/// Largest turning of the tangent (rad) over one capsule, because less is invisible with interpolated normals.
const TURNING: f64 = 0.1;
/// Largest turn of the stripe (rad) over one capsule.
const TWISTING: f64 = 0.3;
/// Largest step of the radius, in samples, between capsules of a tapered tube, because less than half a sample is
/// invisible.
const TAPERING: f64 = 0.5;
/// Points closer than this many radii to the previous one are left out where the tube hardly bends.
const SPARSE: f64 = 0.4;

/// Radius, in samples, below which a tube is drawn as a line, because neither stripe nor roundness is visible.
const THIN: f64 = 1.0;
/// Points of a line within this distance, in samples, of the line without them are left out.
const UNSEEN: f64 = 0.5;
/// Smallest width drawn, in pixels, because a rod much longer than thick must not vanish.
const LEAST_WIDTH: f64 = 1.0;

/// A piece of tube in sample coordinates.
pub(super) struct TubeSegment {
    /// Axis and radius.
    pub shape: ScreenCapsule,
    /// Unit tangents at the ends.
    pub tangents: [Vec3; 2],
    /// Colours at the ends, linear light.
    pub colors: [Vec3; 2],
    /// Directions of the stripe at the ends; zero without stripe.
    pub stripe: [Vec3; 2],
    /// Cosine of the stripe's half angle and its colour, linear light.
    pub stripe_look: (f64, Vec3),
    /// Whether the end is an open end with a round cap.
    pub caps: [bool; 2],
}

/// All tubes cut into capsules.
pub(super) fn capsules(tubes: &[Tube], camera: &Camera) -> Vec<TubeSegment> {
    let mut all = Vec::new();
    for tube in tubes {
        let look = TubeStyle::of(tube, camera);
        let nodes = nodes(&look, 1.0 / camera.scale);
        let spans = if tube.closed { nodes.len() } else { nodes.len().saturating_sub(1) };
        for i in 0..spans {
            let last = i + 1 == nodes.len();
            let caps = [!tube.closed && i == 0, !tube.closed && i + 1 == spans];
            let seam = look.stripe.map_or(0.0, |s| if last { s.seam_turns } else { 0.0 });
            look.cut(&Span::new(nodes[i], nodes[(i + 1) % nodes.len()], seam), caps, camera, &mut all);
        }
        if let ([only], false) = (nodes.as_slice(), tube.closed) {
            look.cut(&Span::new(*only, *only, 0.0), [true; 2], camera, &mut all);
        }
    }
    all
}

/// Straight lines as capsules, as thin as is drawn.
pub(super) fn lines(lines: &[[Vec3; 2]], camera: &Camera) -> impl Iterator<Item = TubeSegment> {
    let line = |[from, to]: &[Vec3; 2]| {
        let tangent = camera.turn((to - from).try_normalize(0.0).unwrap_or_default());
        TubeSegment {
            shape: ScreenCapsule { ends: [camera.place(*from), camera.place(*to)], radius: least(camera) },
            tangents: [tangent; 2],
            colors: [linear(PALE); 2],
            stripe: [Vec3::zeros(); 2],
            stripe_look: (0.0, Vec3::zeros()),
            caps: [true; 2],
        }
    };
    lines.iter().map(line)
}

/// Smallest radius drawn, samples.
fn least(camera: &Camera) -> f64 {
    0.5 * LEAST_WIDTH * camera.per_pixel
}

/// Style of a tube.
struct TubeStyle<'a> {
    tube: &'a Tube,
    stripe: Option<&'a Stripe>,
    /// Largest radius as drawn, samples.
    radius: f64,
    thin: bool,
}

impl<'a> TubeStyle<'a> {
    fn of(tube: &'a Tube, camera: &Camera) -> Self {
        let radius = tube.radii.iter().copied().fold(0.0, f64::max) * camera.scale;
        let thin = radius < THIN;
        let stripe = tube.stripe.as_ref().filter(|_| !thin);
        Self { tube, stripe, radius: radius.max(least(camera)), thin }
    }

    /// Largest useful number of pieces of a span that turns by `turning` (rad) over `length` samples: the sagitta of a
    /// piece is then an eighth of a sample.
    fn pieces(&self, turning: f64, length: f64) -> f64 {
        let visible = (turning * length).sqrt();
        if self.thin { visible } else { visible.max(self.radius) }
    }

    /// Cuts the smooth curve between two nodes into capsules.
    fn cut(&self, span: &Span, caps: [bool; 2], camera: &Camera, all: &mut Vec<TubeSegment>) {
        let pieces = (span.turning / TURNING).max(span.twist.abs() / TWISTING);
        let pieces = pieces.min(self.pieces(span.turning, span.length * camera.scale));
        let pieces = pieces.max(span.taper * camera.scale / TAPERING);
        let pieces = pieces.ceil().clamp(1.0, 64.0) as usize;
        let at = |k: usize| span.at(k as f64 / pieces as f64);
        let (half_angle, color) = self.stripe.map_or((0.0, [0; 3]), |s: &Stripe| (s.half_angle, s.color));
        let mut from = at(0);
        for k in 1..=pieces {
            let to = at(k);
            let radius = (0.5 * (from.radius + to.radius) * camera.scale).max(least(camera));
            all.push(TubeSegment {
                shape: ScreenCapsule { ends: [camera.place(from.point), camera.place(to.point)], radius },
                tangents: [camera.turn(from.tangent), camera.turn(to.tangent)],
                colors: [from.color, to.color],
                stripe: [camera.turn(from.stripe), camera.turn(to.stripe)],
                stripe_look: (half_angle.cos(), linear(color)),
                caps: [caps[0] && k == 1, caps[1] && k == pieces],
            });
            from = to;
        }
    }
}

/// Indices of the points to be drawn: none repeated, none closer than visible.
fn worth_drawing(tube: &Tube, sample: f64) -> Vec<usize> {
    let points = &tube.points;
    let mut kept: Vec<usize> = Vec::new();
    for i in 0..points.len() {
        let Some(&before) = kept.last() else {
            kept.push(i);
            continue;
        };
        let step = points[i] - points[before];
        let close = (SPARSE * tube.radius(i)).max(sample);
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

/// Nodes of a tube with their data; `sample` is the size of a sample \[L\].
fn nodes(look: &TubeStyle, sample: f64) -> Vec<Node> {
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
        radius: tube.radius(i),
        color: color(i),
        stripe: stripe(i, tangent),
    };
    kept.iter().zip(&tangents).map(node).collect()
}
