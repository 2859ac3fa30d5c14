//! Lighting: from visible surfaces to pixels.

use super::camera::Camera;
use super::palette::{encoded, linear};
use super::raster::{self, NOTHING, Samples, ScreenCapsule};
use super::tube::TubeSegment;
use super::{Picture, TubePicture};
use crate::math::{Mat3, Vec3, parallel};
use std::f64::consts::TAU;

/// Direction to the key light in sample coordinates (left, above, in front).
const KEY: Vec3 = Vec3::new(-0.43, -0.62, 0.66);
/// Direction to the fill light (right, a little below, in front).
const FILL: Vec3 = Vec3::new(0.75, 0.25, 0.61);
/// Rays for the occlusion, and again for the soft shadow, of each surface seen in a pixel.
const RAYS: usize = 32;
/// Reach of the ambient occlusion, in tube radii.
const REACH: f64 = 3.5;
/// Largest side of the shadow map, in its samples.
const SHADOW_SIDE: f64 = 2000.0;

/// The scene as seen from the key light.
pub(super) struct Light {
    axes: Mat3,
    low: Vec3,
    scale: f64,
    map: Samples,
}

impl Light {
    pub fn new(shapes: &[ScreenCapsule]) -> Self {
        let toward = KEY.normalize();
        let right = Vec3::y().cross(&toward).normalize();
        let axes = Mat3::from_rows(&[right.transpose(), right.cross(&toward).transpose(), toward.transpose()]);
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for (shape, end) in shapes.iter().flat_map(|s| s.ends.map(|e| (s, axes * e))) {
            low = low.inf(&end.add_scalar(-shape.radius));
            high = high.sup(&end.add_scalar(shape.radius));
        }
        let size = (high - low).xy().amax().max(1.0);
        let scale = if shapes.is_empty() { 1.0 } else { (SHADOW_SIDE / size).min(1.0) };
        let place = |p: Vec3| (axes * p - low) * scale;
        let shapes: Vec<ScreenCapsule> =
            shapes.iter().map(|s| ScreenCapsule { ends: s.ends.map(place), radius: s.radius * scale }).collect();
        let side = |k: usize| if shapes.is_empty() { 1 } else { ((high - low)[k] * scale).ceil() as usize + 1 };
        let map = raster::draw(&shapes, side(0), side(1));
        Self { axes, low, scale, map }
    }

    /// Fraction (0 to 1) of the key light that reaches a point; `spread` is the radius of the penumbra in samples.
    fn reaches(&self, point: Vec3, spread: f64, rays: Rays) -> f64 {
        let seen = (self.axes * point - self.low) * self.scale;
        let lit = rays.iter().filter(|[dx, dy]| {
            let (x, y) = (seen.x + dx * spread * self.scale, seen.y + dy * spread * self.scale);
            !lookup(&self.map, x, y).is_some_and(|z| z > seen.z)
        });
        lit.count() as f64 / rays.spiral.len() as f64
    }
}

/// Depth at a place of the buffer, `None` outside and on the background.
fn lookup(samples: &Samples, x: f64, y: f64) -> Option<f64> {
    if x < 0.0 || y < 0.0 || x >= samples.width as f64 || y >= samples.height as f64 {
        return None;
    }
    let z = samples.depth[y as usize * samples.width + x as usize];
    z.is_finite().then_some(f64::from(z))
}

/// A sunflower spiral of `num` points in the unit disc (golden angle, equal areas).
fn spiral(num: usize) -> Vec<[f64; 2]> {
    let point = |k: usize| {
        let (sin, cos) = (2.399_963_229_728_653 * k as f64).sin_cos();
        let r = ((k as f64 + 0.5) / num as f64).sqrt();
        [r * cos, r * sin]
    };
    (0..num).map(point).collect()
}

/// The spiral as rotated for one sample.
#[derive(Clone, Copy)]
struct Rays<'a> {
    spiral: &'a [[f64; 2]],
    cos: f64,
    sin: f64,
}

impl Rays<'_> {
    fn iter(&self) -> impl Iterator<Item = [f64; 2]> {
        self.spiral.iter().map(|[x, y]| [x * self.cos - y * self.sin, x * self.sin + y * self.cos])
    }
}

/// Pseudo-random angle of a sample, as cosine and sine.
fn dither(x: usize, y: usize) -> (f64, f64) {
    let mut h = (x as u32).wrapping_mul(0x9E37_79B9) ^ (y as u32).wrapping_mul(0x85EB_CA6B);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    let (sin, cos) = (f64::from(h ^ (h >> 15)) / 4_294_967_296.0 * TAU).sin_cos();
    (cos, sin)
}

/// Data for the colour of a sample.
struct LitScene<'a> {
    capsules: &'a [TubeSegment],
    samples: &'a Samples,
    light: &'a Light,
    spiral: Vec<[f64; 2]>,
    key: Vec3,
    fill: Vec3,
    half: Vec3,
    spots: SpotGrid,
    background: Vec3,
    /// Depth of the nearest surface and of the whole scene.
    front: f64,
    range: f64,
}

/// Light that reaches a point, computed once for all samples of a pixel on the same surface.
#[derive(Clone, Copy)]
struct Visibility {
    point: Vec3,
    open: f64,
    shadow: f64,
}

/// Colours all samples and averages them to pixels.
pub(super) fn develop(
    picture: &TubePicture,
    camera: &Camera,
    capsules: &[TubeSegment],
    samples: &Samples,
    light: &Light,
) -> Picture {
    let heights = || capsules.iter().flat_map(|c| c.shape.ends.map(|e| e.z));
    let front = heights().fold(f64::NEG_INFINITY, f64::max);
    let range = (front - heights().fold(f64::INFINITY, f64::min)).max(1.0);
    let background = linear(picture.background);
    let spots = SpotGrid::new(picture, camera);
    let key = KEY.normalize();
    let (fill, half) = (FILL.normalize(), (key + Vec3::z()).normalize());
    let n = picture.supersampling;
    let scene =
        LitScene { capsules, samples, light, spiral: spiral(RAYS), key, fill, half, spots, background, front, range };
    let mut rgb = vec![0; 3 * picture.width * picture.height];
    let mut lines: Vec<&mut [u8]> = rgb.chunks_mut(3 * picture.width).collect();
    parallel::each(&mut lines, 1, &|row, line| {
        for (column, pixel) in line.chunks_exact_mut(3).enumerate() {
            let (mut sum, mut last) = (Vec3::zeros(), None);
            for (x, y) in (0..n * n).map(|k| (n * column + k % n, n * row + k / n)) {
                sum += scene.color(x, y, &mut last);
            }
            pixel.copy_from_slice(&encoded(sum / (n * n) as f64));
        }
    });
    Picture { width: picture.width, height: picture.height, rgb }
}

impl LitScene<'_> {
    /// Colour of a sample, linear light; `last` is the visibility of the pixel's previous sample.
    fn color(&self, x: usize, y: usize, last: &mut Option<Visibility>) -> Vec3 {
        let at = y * self.samples.width + x;
        let index = self.samples.capsule[at];
        if index == NOTHING {
            return self.background;
        }
        let capsule = &self.capsules[index as usize];
        let point = Vec3::new(x as f64 + 0.5, y as f64 + 0.5, f64::from(self.samples.depth[at]));
        let (normal, mut albedo) = surface(capsule, point);
        let glow = self.spots.paint(point, &mut albedo);
        let radius = capsule.shape.radius;
        let known = last.filter(|v| (v.point - point).norm_squared() < (0.2 * radius).powi(2));
        let seen = known.unwrap_or_else(|| self.visibility(point, normal, radius, dither(x, y)));
        *last = Some(seen);
        let Visibility { open, shadow, .. } = seen;
        let direct = 0.86 * shadow * ((normal.dot(&self.key) + 0.15) / 1.15).max(0.0);
        let sky = 0.34 * open * (0.8 - 0.2 * normal.y);
        let soft = 0.16 * open * normal.dot(&self.fill).max(0.0);
        let gloss = 0.22 * shadow * normal.dot(&self.half).max(0.0).powi(50);
        let edge = (1.0 - normal.z).clamp(0.0, 1.0).powi(3);
        let lit = albedo * ((direct + sky + soft) * (1.0 - 0.5 * edge)) + Vec3::repeat(gloss) + glow;
        let haze = 0.1 * ((self.front - point.z) / self.range).clamp(0.0, 1.0);
        lit.lerp(&self.background, haze)
    }

    /// Sky and key light that reach a point; `(cos, sin)` rotates the rays.
    fn visibility(&self, point: Vec3, normal: Vec3, radius: f64, (cos, sin): (f64, f64)) -> Visibility {
        let rays = Rays { spiral: &self.spiral, cos, sin };
        let open = self.openness(point, normal, REACH * radius, rays);
        let shadow = self.light.reaches(point + normal * (0.12 * radius + 1.5), 0.45 * radius, rays);
        Visibility { point, open, shadow }
    }

    /// Ambient occlusion from the depth buffer: 1 in the open, towards 0 in a crevice.
    fn openness(&self, point: Vec3, normal: Vec3, reach: f64, rays: Rays) -> f64 {
        let blocked: f64 = rays
            .iter()
            .filter_map(|[dx, dy]| {
                let (x, y) = (point.x + dx * reach, point.y + dy * reach);
                let way = Vec3::new(dx * reach, dy * reach, lookup(self.samples, x, y)? - point.z);
                let distance = way.norm().max(1.0);
                Some((normal.dot(&way) / distance - 0.12).max(0.0) / (1.0 + (distance / reach).powi(4)))
            })
            .sum();
        (1.0 - 3.0 * blocked / rays.spiral.len() as f64).max(0.12)
    }
}

/// Unit normal (smooth over joints) and colour of a capsule at a point of its surface.
fn surface(capsule: &TubeSegment, point: Vec3) -> (Vec3, Vec3) {
    let [a, b] = capsule.shape.ends;
    let axis = b - a;
    let raw = axis.dot(&(point - a)) / axis.norm_squared().max(f64::MIN_POSITIVE);
    // Parameter by the cross-sections at both ends, which neighbouring capsules share: nothing jumps at a joint.
    let (ahead, behind) = (capsule.tangents[0].dot(&(point - a)), capsule.tangents[1].dot(&(b - point)));
    let u = if ahead + behind > 0.2 * axis.norm() {
        (ahead / (ahead + behind)).clamp(-0.5, 1.5)
    } else {
        raw.clamp(0.0, 1.0)
    };
    let offset = point - (a + axis * u);
    let tangent = capsule.tangents[0].lerp(&capsule.tangents[1], u).normalize();
    let on_cap = (raw < 0.0 && capsule.caps[0]) || (raw > 1.0 && capsule.caps[1]);
    let radial = offset - tangent * tangent.dot(&offset);
    let normal = if on_cap { point - if raw < 0.0 { a } else { b } } else { radial };
    let color = capsule.colors[0].lerp(&capsule.colors[1], u.clamp(0.0, 1.0));
    let stripe = capsule.stripe[0].lerp(&capsule.stripe[1], u);
    let (cosine, stripe_color) = capsule.stripe_look;
    let is_striped = stripe.dot(&radial) > cosine * stripe.norm() * radial.norm();
    (normal.normalize(), if is_striped { stripe_color } else { color })
}

/// Spots by tiles of the sample buffer.
struct SpotGrid {
    columns: usize,
    tiles: Vec<Vec<u32>>,
    /// Centre and radius in sample coordinates, colour in linear light.
    spots: Vec<(Vec3, f64, Vec3)>,
}

/// Side of a tile of [`SpotGrid`] in samples.
const TILE: usize = 32;

impl SpotGrid {
    fn new(picture: &TubePicture, camera: &Camera) -> Self {
        let (columns, rows) = (camera.width.div_ceil(TILE), camera.height.div_ceil(TILE));
        let mut grid = Self { columns, tiles: vec![Vec::new(); columns * rows], spots: Vec::new() };
        for spot in &picture.spots {
            let (center, radius) = (camera.place(spot.center), spot.radius * camera.scale);
            let tiles = |at: f64, num: usize| {
                let index = |v: f64| (v / TILE as f64).clamp(0.0, num as f64) as usize;
                index(at - radius)..index(at + radius + TILE as f64)
            };
            for row in tiles(center.y, rows) {
                for column in tiles(center.x, columns) {
                    grid.tiles[row * columns + column].push(grid.spots.len() as u32);
                }
            }
            grid.spots.push((center, radius, linear(spot.color)));
        }
        grid
    }

    /// Blends the spots at a point into the surface's colour; returns the light they add.
    fn paint(&self, point: Vec3, albedo: &mut Vec3) -> Vec3 {
        let mut glow = Vec3::zeros();
        for &index in &self.tiles[point.y as usize / TILE * self.columns + point.x as usize / TILE] {
            let (center, radius, color) = self.spots[index as usize];
            let weight = (1.0 - (point - center).norm_squared() / (radius * radius)).max(0.0);
            *albedo = albedo.lerp(&color, weight.sqrt());
            glow = glow.sup(&(color * (0.35 * weight * weight)));
        }
        glow
    }
}
