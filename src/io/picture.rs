//! Pictures: rods as shaded tubes (PNG), strips of several pictures with captions, line plots (SVG, PDF).
//!
//! ```text
//! tubes ──resample──▶ short capsules ──z-buffer──▶ depth + capsule per sample ──light──▶ colour ──average──▶ pixels
//! ```
//! Orthographic view, key light with a soft shadow, fill and rim light, ambient occlusion from the depth buffer. The
//! work is that of the covered samples plus the capsules, in parallel over bands of rows; the same bytes for any number
//! of threads. Rods thinner than a pixel are drawn as lines one pixel wide, of no more points than can be
//! distinguished, so that a rod of a million nodes costs little more than one of a thousand. Text is in a bundled font;
//! no system fonts are needed.

pub(super) mod camera;
mod legend;
pub mod obstacle;
pub(super) mod palette;
mod pdf;
mod plot;
mod raster;
mod shade;
pub(super) mod span;
mod strip;
mod text;
mod tube;

use crate::error::InputError;
use crate::math::Vec3;
use std::path::Path;

pub use palette::{Palette, colors_by_value};
pub use plot::{PlotSpec, Series, SeriesStyle, plot_lines};
pub use strip::film_strip;

/// A rod to be drawn.
#[derive(Debug, Clone, Default)]
pub struct Tube {
    /// Centreline points \[L\]. A smooth curve through them is drawn, so a coarse mesh looks smooth.
    pub points: Vec<Vec3>,
    /// Radii \[L\], greater than 0: one per point, or one for the whole tube.
    pub radii: Vec<f64>,
    /// Whether the curve returns to its first point (which is not repeated).
    pub closed: bool,
    /// Colours (sRGB): one per point, one for the whole tube, or none for grey.
    pub colors: Vec<[u8; 3]>,
    /// Material line to be drawn on the surface, so that twist can be seen.
    pub stripe: Option<Stripe>,
}

/// A material line on a tube.
#[derive(Debug, Clone)]
pub struct Stripe {
    /// Material direction (d1) at each point of the tube; need not be unit or exactly normal. Neighbours may differ by
    /// less than half a turn.
    pub directions: Vec<Vec3>,
    /// Rotation of the frame at the end of a closed tube relative to that at its start, turns (see `link_numbers`); 0
    /// if open.
    pub seam_turns: f64,
    /// Colour (sRGB).
    pub color: [u8; 3],
    /// Half the angle of the stripe on the cross-section, rad; 0.3 is usual. Legal: 0 to π.
    pub half_angle: f64,
}

impl Stripe {
    /// A white stripe of usual width along `directions`.
    pub fn along(directions: Vec<Vec3>) -> Self {
        Self { directions, seam_turns: 0.0, color: [250, 248, 240], half_angle: 0.3 }
    }
}

/// A highlight on the surfaces within a sphere: a contact site.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Centre \[L\]; the middle between the two surfaces for a contact.
    pub center: Vec3,
    /// Radius within which surfaces are coloured \[L\]; fades towards it.
    pub radius: f64,
    /// Colour (sRGB).
    pub color: [u8; 3],
}

/// Viewing direction of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum View {
    /// Along the direction of least extent of the points, with the direction of largest extent along the picture's
    /// longer side.
    #[default]
    Auto,
    /// Along `forward` (from the eye into the scene), `up` towards the top of the picture; neither need be unit.
    Along {
        /// Viewing direction.
        forward: Vec3,
        /// Upward direction; must not be parallel to `forward`.
        up: Vec3,
    },
}

/// A picture of tubes, to be completed and rendered.
///
/// ```
/// use supercoil::{io::picture::{Tube, TubePicture}, math::Vec3};
/// let ring = (0..60).map(|i| f64::from(i) * 0.1047198).map(|t| Vec3::new(t.cos(), t.sin(), 0.3 * (2.0 * t).sin()));
/// let (radii, colors) = (vec![0.1], vec![[60, 120, 180]]);
/// let tube = Tube { points: ring.collect(), radii, closed: true, colors, stripe: None };
/// let picture = TubePicture { tubes: vec![tube], width: 320, height: 240, ..TubePicture::default() }.render()?;
/// assert_eq!(picture.pixels().len(), 3 * 320 * 240);
/// # Ok::<(), supercoil::InputError>(())
/// ```
#[derive(Debug, Clone)]
pub struct TubePicture {
    /// The tubes.
    pub tubes: Vec<Tube>,
    /// Highlighted contact sites.
    pub spots: Vec<Spot>,
    /// Ends \[L\] of straight pale lines one pixel wide, such as those of an [obstacle]. They cast no shadow, and the
    /// view is not fitted to them.
    pub lines: Vec<[Vec3; 2]>,
    /// Width in pixels, 1 to 20000.
    pub width: usize,
    /// Height in pixels, 1 to 20000.
    pub height: usize,
    /// Viewing direction.
    pub view: View,
    /// Point in the middle of the picture \[L\], the same for several pictures that are to be compared; `None` fits the
    /// tubes.
    pub center: Option<Vec3>,
    /// Background (sRGB).
    pub background: [u8; 3],
    /// Width of the visible region \[L\], the same for several pictures that are to be compared; `None` fits the tubes.
    pub visible_width: Option<f64>,
    /// Samples per pixel and direction, 1 to 6: 2 is good, 3 better, the cost grows with the square.
    pub supersampling: usize,
}

impl Default for TubePicture {
    fn default() -> Self {
        Self {
            tubes: Vec::new(),
            spots: Vec::new(),
            lines: Vec::new(),
            width: 1200,
            height: 900,
            view: View::Auto,
            center: None,
            background: [255, 255, 255],
            visible_width: None,
            supersampling: 3,
        }
    }
}

/// Largest number of samples of a picture, because at 8 bytes each they take 2 GB.
const MAX_SAMPLES: usize = 1 << 28;

impl TubePicture {
    /// Draws the picture; an empty one shows the background.
    ///
    /// # Errors
    /// [`InputError`] naming the field if a size, radius, colour count, direction count or view is unusable, or a point
    /// is not finite.
    pub fn render(&self) -> Result<Picture, InputError> {
        self.check()?;
        let camera = camera::Camera::new(self)?;
        let mut capsules = tube::capsules(&self.tubes, &camera);
        let opaque = capsules.len();
        capsules.extend(tube::lines(&self.lines, &camera));
        let shapes: Vec<raster::ScreenCapsule> = capsules.iter().map(|c| c.shape).collect();
        let light = shade::Light::new(&shapes[..opaque]);
        let samples = raster::draw(&shapes, camera.width, camera.height);
        Ok(shade::develop(self, &camera, &capsules, &samples, &light))
    }

    /// Refuses what cannot be drawn.
    fn check(&self) -> Result<(), InputError> {
        for (field, value, most) in
            [("width", self.width, 20_000), ("height", self.height, 20_000), ("supersampling", self.supersampling, 6)]
        {
            if !(1..=most).contains(&value) {
                let allowed = if most == 6 { "between 1 and 6" } else { "between 1 and 20000" };
                return Err(InputError::Count { field: field.to_owned(), value, allowed });
            }
        }
        let samples = self.width * self.height * self.supersampling * self.supersampling;
        if samples > MAX_SAMPLES {
            let field = "width × height × supersampling²".to_owned();
            return Err(InputError::Count { field, value: samples, allowed: "at most 268435456 samples (2 GB)" });
        }
        check_vectors("center", self.center.as_slice())?;
        if let Some(width) = self.visible_width {
            InputError::positive("visible_width", width)?;
        }
        for (index, tube) in self.tubes.iter().enumerate() {
            tube.check(&format!("tubes[{index}]"))?;
        }
        for (index, ends) in self.lines.iter().enumerate() {
            check_vectors(&format!("lines[{index}]"), ends)?;
        }
        for (index, spot) in self.spots.iter().enumerate() {
            check_vectors(&format!("spots[{index}].center"), &[spot.center])?;
            InputError::positive(&format!("spots[{index}].radius"), spot.radius)?;
        }
        Ok(())
    }
}

/// Radius at a point of a tube whose radii are one per point, or one for all.
pub(in crate::io) fn radius_at(radii: &[f64], point: usize) -> f64 {
    radii.get(point).or(radii.first()).copied().unwrap_or(0.0)
}

impl Tube {
    /// Radius at a point.
    fn radius(&self, point: usize) -> f64 {
        radius_at(&self.radii, point)
    }

    /// Refuses what cannot be drawn.
    fn check(&self, field: &str) -> Result<(), InputError> {
        check_vectors(&format!("{field}.points"), &self.points)?;
        let num = self.points.len();
        if self.radii.len() != 1 && self.radii.len() != num {
            let field = format!("{field}.radii");
            return Err(InputError::Count { field, value: self.radii.len(), allowed: "1 or one a point" });
        }
        self.radii.iter().try_for_each(|&radius| InputError::positive(&format!("{field}.radii"), radius))?;
        if self.colors.len() > 1 && self.colors.len() != num {
            let field = format!("{field}.colors");
            return Err(InputError::Count { field, value: self.colors.len(), allowed: "0, 1 or one a point" });
        }
        if let Some(stripe) = &self.stripe {
            check_vectors(&format!("{field}.stripe.directions"), &stripe.directions)?;
            if stripe.directions.len() != num {
                let field = format!("{field}.stripe.directions");
                return Err(InputError::Count { field, value: stripe.directions.len(), allowed: "one a point" });
            }
            InputError::check(&format!("{field}.stripe.seam_turns"), stripe.seam_turns, true, "a finite number")?;
            let ok = (0.0..=std::f64::consts::PI).contains(&stripe.half_angle);
            InputError::check(&format!("{field}.stripe.half_angle"), stripe.half_angle, ok, "between 0 and π rad")?;
        }
        Ok(())
    }
}

/// Refuses NaN and infinities.
fn check_vectors(field: &str, vectors: &[Vec3]) -> Result<(), InputError> {
    match vectors.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
        None => Ok(()),
        Some(index) => Err(InputError::Vector {
            field: format!("{field}[{index}]"),
            value: vectors[index].into(),
            allowed: "three finite numbers",
        }),
    }
}

/// A finished picture, 8-bit sRGB.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

impl Picture {
    /// A picture of one colour.
    pub fn filled(width: usize, height: usize, color: [u8; 3]) -> Self {
        Self { width, height, rgb: color.repeat(width * height) }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Red, green, blue of each pixel, row by row from the top.
    pub fn pixels(&self) -> &[u8] {
        &self.rgb
    }

    /// Colour of the pixel in `column`, `row` (from the top left).
    ///
    /// # Panics
    /// If it lies outside the picture.
    pub fn pixel(&self, column: usize, row: usize) -> [u8; 3] {
        assert!(column < self.width && row < self.height, "pixel outside the picture");
        let at = 3 * (row * self.width + column);
        [self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]]
    }

    /// Writes text (Latin-1, Greek, − ± ° ² ₀ ≤ ∞ and the like) with its top left corner at `[column, row]`; a capital
    /// is `height` pixels high. What does not fit is cut off; unknown characters are boxes. Without effect on
    /// WebAssembly.
    pub fn write(&mut self, text: &str, corner: [usize; 2], height: usize, color: [u8; 3]) {
        text::write(self, text, corner, height, color);
    }

    /// Writes the picture as a PNG file, replacing what is there.
    ///
    /// # Errors
    /// [`InputError::Write`] if the file cannot be written.
    pub fn save_png(&self, path: &Path) -> Result<(), InputError> {
        let refuse = |reason: String| InputError::Write { path: path.to_owned(), reason };
        let buffer = image::RgbImage::from_raw(self.width as u32, self.height as u32, self.rgb.clone());
        let buffer = buffer.ok_or_else(|| refuse("picture of inconsistent size".to_owned()))?;
        buffer.save_with_format(path, image::ImageFormat::Png).map_err(|e| refuse(e.to_string()))
    }

    /// Writes a PNG file without background: this picture is drawn before white, the other the same before black.
    ///
    /// # Errors
    /// [`InputError::Write`] if the file cannot be written, or the pictures are not of one size.
    pub(crate) fn save_transparent_png(&self, on_black: &Self, path: &Path) -> Result<(), InputError> {
        let refuse = |reason: String| InputError::Write { path: path.to_owned(), reason };
        let pixel = |(white, black): (&[u8], &[u8])| {
            // the difference of the two is the transparency; the brightest channel determines it
            let differ = (0..3).map(|k| white[k].saturating_sub(black[k])).min().unwrap_or(0);
            let alpha = 255 - differ;
            let channel = |k: usize| (255 * usize::from(black[k]) / usize::from(alpha.max(1))).min(255) as u8;
            [channel(0), channel(1), channel(2), alpha]
        };
        let rgba = self.rgb.chunks_exact(3).zip(on_black.rgb.chunks_exact(3)).flat_map(pixel).collect();
        let buffer = image::RgbaImage::from_raw(self.width as u32, self.height as u32, rgba);
        let buffer = buffer.ok_or_else(|| refuse("picture of inconsistent size".to_owned()))?;
        buffer.save_with_format(path, image::ImageFormat::Png).map_err(|e| refuse(e.to_string()))
    }
}
