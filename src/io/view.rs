//! Interactive views of a run: one page for the browser ([`Film::page`]), one glTF file for Blender, slides and viewers
//! ([`Film::glb`]), STL of the last state ([`Film::stl`]). [`of_run`] makes a film of the folder of a run (feature
//! `runs`).
//!
//! The page needs no network and no other file. Its 50 kB of text (`assets/view`) draw with WebGL 2: a rod is one
//! instanced tube that its vertex shader bends along the nodes, so a step is shown by uploading its nodes. A library
//! would not replace that shader, which is the larger part of the work, and would be larger than all data of a usual
//! run (three.js 0.187: 2.1 MB of source).

mod glb;
mod mesh;
mod page;
#[cfg(feature = "runs")]
mod run;
mod stl;

use crate::error::InputError;
use crate::io::picture::span::{Node, tangents};
use crate::io::picture::{Palette, obstacle, radius_at};
use crate::math::{Mat3, Vec3};
use crate::scene::{Obstacle, ObstaclePose, Units};

use super::picture::camera::principal_axes;

pub use glb::GlbOptions;
#[cfg(feature = "runs")]
pub use run::{MAX_NODES, of_run, write_page};
#[cfg(feature = "runs")]
pub(super) use run::{Parts, film};

/// States of rods, one after the other.
#[derive(Debug, Clone, Default)]
pub struct Film {
    /// Title; may be empty.
    pub title: String,
    /// Names of the units.
    pub units: Units,
    /// The rods.
    pub rods: Vec<FilmRod>,
    /// Rigid bodies that rods touch.
    pub obstacles: Vec<Obstacle>,
    /// The states, in order.
    pub frames: Vec<Frame>,
    /// Numbers of all steps.
    pub table: FilmTable,
    /// Plots of columns of the table.
    pub plots: Vec<Plot>,
    /// A remark about the film, such as steps and nodes left out; may be empty.
    pub note: String,
}

/// A rod of a film.
#[derive(Debug, Clone, Default)]
pub struct FilmRod {
    /// Name.
    pub name: String,
    /// Whether it returns to its first point (which is not repeated).
    pub closed: bool,
}

/// One state.
#[derive(Debug, Clone, Default)]
pub struct Frame {
    /// Row of the table for this state.
    pub step: usize,
    /// The rods, in the film's order.
    pub rods: Vec<FrameRod>,
    /// Contact forces \[F\] and the points they act on \[L\].
    pub forces: Vec<[Vec3; 2]>,
    /// Where the obstacles are, in the film's order.
    pub placements: Vec<ObstaclePose>,
}

/// A rod in one state; lists have one entry per point.
#[derive(Debug, Clone, Default)]
pub struct FrameRod {
    /// Points of the centreline \[L\]; a smooth curve through them is drawn.
    pub points: Vec<Vec3>,
    /// Material direction d1, along which a stripe is drawn; zero for none. Neighbours may differ by less than half a
    /// turn.
    pub directions: Vec<Vec3>,
    /// Contact force per length \[F/L\].
    pub pressure: Vec<f64>,
    /// Curvature \[1/L\].
    pub curvature: Vec<f64>,
    /// Twist a length \[rad/L\].
    pub twist_rate: Vec<f64>,
    /// Radii it is drawn with \[L\], greater than 0: one per point, or one for the whole rod.
    pub radii: Vec<f64>,
    /// Turns of the frame at the end of a closed rod against that at its start; 0 if open.
    pub seam_turns: f64,
}

/// Numbers of the steps.
#[derive(Debug, Clone, Default)]
pub struct FilmTable {
    /// Name and unit of each column; the unit may be empty.
    pub columns: Vec<(String, String)>,
    /// One row a step, one number a column; NaN where there is none.
    pub rows: Vec<Vec<f64>>,
}

/// A plot of columns of the table against another; with fewer than two steps none is shown.
#[derive(Debug, Clone, Default)]
pub struct Plot {
    /// Column along the horizontal axis.
    pub x: usize,
    /// Columns along the vertical axis, all of one unit.
    pub y: Vec<usize>,
}

/// Quantity that colours the rods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quantity {
    /// One colour for each rod.
    #[default]
    Strand,
    /// Contact force per length \[F/L\].
    Pressure,
    /// Curvature \[1/L\].
    Curvature,
    /// Twist a length \[rad/L\].
    TwistRate,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Strand, Self::Pressure, Self::Curvature, Self::TwistRate];

    /// "strand", "pressure", "curvature" or "twist_rate".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Strand => "strand",
            Self::Pressure => "pressure",
            Self::Curvature => "curvature",
            Self::TwistRate => "twist_rate",
        }
    }

    /// The quantity of that [`name`](Self::name).
    ///
    /// # Errors
    /// [`InputError::Name`] for another.
    pub fn from_name(name: &str) -> Result<Self, InputError> {
        Self::ALL.into_iter().find(|quantity| quantity.name() == name).ok_or_else(|| InputError::Name {
            field: "color".to_owned(),
            name: name.to_owned(),
            allowed: "strand, pressure, curvature or twist_rate".to_owned(),
        })
    }

    /// Its values at the points of a rod; none for [`Quantity::Strand`].
    fn of(self, rod: &FrameRod) -> &[f64] {
        match self {
            Self::Strand => &[],
            Self::Pressure => &rod.pressure,
            Self::Curvature => &rod.curvature,
            Self::TwistRate => &rod.twist_rate,
        }
    }

    fn palette(self) -> Palette {
        if self == Self::TwistRate { Palette::CoolWarm } else { Palette::Viridis }
    }
}

const FINITE: &str = "a finite number";

/// Colours (sRGB) of rods one after the other.
const STRANDS: [[u8; 3]; 6] =
    [[62, 112, 178], [206, 112, 58], [84, 150, 96], [150, 104, 170], [188, 160, 62], [96, 158, 170]];

impl Film {
    /// Range of the palette, the same in all frames: from 0 to the largest value; for twist symmetric about 0. \[0, 1\]
    /// if all values are 0.
    fn range(&self, quantity: Quantity) -> [f64; 2] {
        let values = self.frames.iter().flat_map(|frame| &frame.rods).flat_map(|rod| quantity.of(rod));
        let largest = values.fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let largest = if largest > 0.0 { largest } else { 1.0 };
        if quantity == Quantity::TwistRate { [-largest, largest] } else { [0.0, largest] }
    }

    /// The maps x ↦ A x + b that take the obstacles from the start to where they are in a frame.
    fn images(&self, frame: &Frame) -> impl Iterator<Item = (Mat3, Vec3)> {
        self.obstacles.iter().zip(&frame.placements).map(|(obstacle, placement)| obstacle.image(placement))
    }

    /// Lines of all obstacles at the start, each with its obstacle: along the rods of all frames.
    fn lines(&self) -> Vec<(usize, [Vec3; 2])> {
        let points = || self.frames.iter().flat_map(|frame| &frame.rods).flat_map(|rod| &rod.points);
        let of = |(index, obstacle): (usize, &Obstacle)| {
            obstacle::lines(obstacle, points()).into_iter().map(move |line| (index, line)).collect::<Vec<_>>()
        };
        self.obstacles.iter().enumerate().flat_map(of).collect()
    }

    /// Centre of the last frame's box; directions right, up, towards the eye of its best view, as rows; half the
    /// diagonal of the box (at least a radius).
    fn stage(&self) -> (Vec3, Mat3, f64) {
        let points = self.frames.last().into_iter().flat_map(|frame| &frame.rods).flat_map(|rod| &rod.points);
        let (low, high) = points
            .clone()
            .fold((Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)), |(low, high), point| {
                (low.inf(point), high.sup(point))
            });
        if low.x > high.x {
            return (Vec3::zeros(), Mat3::identity(), 1.0);
        }
        let last = self.frames.last().into_iter().flat_map(|frame| &frame.rods);
        let radius = last.flat_map(|rod| &rod.radii).copied().fold(0.0, f64::max);
        let mut axes = principal_axes(points, true);
        let up = -axes.row(1);
        axes.set_row(1, &up);
        (0.5 * (low + high), axes, (0.5 * (high - low).norm()).max(radius))
    }

    /// Refuses films that cannot be shown.
    fn check(&self) -> Result<(), InputError> {
        for (f, frame) in self.frames.iter().enumerate() {
            let count = |field: String, value: usize, expected: usize, allowed| {
                if value == expected { Ok(()) } else { Err(InputError::Count { field, value, allowed }) }
            };
            count(format!("frames[{f}].rods"), frame.rods.len(), self.rods.len(), "one a rod of the film")?;
            let field = format!("frames[{f}].placements");
            count(field, frame.placements.len(), self.obstacles.len(), "one an obstacle of the film")?;
            for (r, rod) in frame.rods.iter().enumerate() {
                let field = |name: &str| format!("frames[{f}].rods[{r}].{name}");
                let num = rod.points.len();
                let lengths = [
                    ("directions", rod.directions.len()),
                    ("pressure", rod.pressure.len()),
                    ("curvature", rod.curvature.len()),
                    ("twist_rate", rod.twist_rate.len()),
                ];
                lengths.into_iter().try_for_each(|(name, found)| count(field(name), found, num, "one a point"))?;
                for (name, vectors) in [("points", &rod.points), ("directions", &rod.directions)] {
                    vectors.iter().flatten().try_for_each(|&x| InputError::check(&field(name), x, true, FINITE))?;
                }
                for (name, values) in
                    [("pressure", &rod.pressure), ("curvature", &rod.curvature), ("twist_rate", &rod.twist_rate)]
                {
                    values.iter().try_for_each(|&x| InputError::check(&field(name), x, true, FINITE))?;
                }
                if rod.radii.len() != 1 {
                    count(field("radii"), rod.radii.len(), num, "1 or one a point")?;
                }
                rod.radii.iter().try_for_each(|&radius| InputError::positive(&field("radii"), radius))?;
                InputError::check(&field("seam_turns"), rod.seam_turns, true, FINITE)?;
            }
        }
        Ok(())
    }
}
impl FrameRod {
    /// Its points with the data for drawing tubes, in these colours (linear light).
    fn nodes(&self, closed: bool, color: impl Fn(usize) -> Vec3) -> Vec<Node> {
        let node = |(i, tangent): (usize, Vec3)| {
            let direction = self.directions[i] - tangent * tangent.dot(&self.directions[i]);
            let stripe = direction.try_normalize(0.0).unwrap_or_default();
            Node { point: self.points[i], tangent, radius: radius_at(&self.radii, i), color: color(i), stripe }
        };
        tangents(&self.points, closed).into_iter().enumerate().map(node).collect()
    }
}
