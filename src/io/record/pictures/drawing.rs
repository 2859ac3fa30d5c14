//! Pictures of states of one run, seen from one place and in one scale of colours.

use std::f64::consts::TAU;

use crate::io::picture::obstacle::{self, round_below};
use crate::io::picture::{Palette, Picture, Spot, Stripe, Tube, TubePicture, colors_by_value};
use crate::io::record::rods::RodHead;
use crate::io::record::run::{RecordedRun, placements};
use crate::math::Vec3;
use crate::scene::file::ColorBy;
use crate::scene::{Obstacle, ObstaclePose};

use super::camera::{axes, region_of, view_along};
use super::still::{Still, StillRod};

/// Curvature and twist rate over those of one turn along the rod that are shown as none: below the tolerance of the
/// solver.
const NO_TURN: f64 = 1e-6;

/// How frames of a run are drawn.
pub(super) struct Drawing<'a> {
    run: &'a RecordedRun,
    frames: Vec<&'a Still>,
    /// Directions to the right and upwards.
    pub axes: [Vec3; 2],
    /// Range of the colours; none where all is of one colour.
    pub range: Option<[f64; 2]>,
}

impl<'a> Drawing<'a> {
    /// Of these frames, which are seen from where all are seen well.
    pub fn of(run: &'a RecordedRun, frames: Vec<&'a Still>) -> Self {
        Self { run, axes: axes(run, &frames), range: range(run, &frames), frames }
    }

    /// The picture of one of the frames.
    pub fn picture(&self, frame: &Still) -> TubePicture {
        const COLORS: [[u8; 3]; 4] = [[62, 112, 178], [206, 112, 58], [84, 150, 96], [150, 104, 170]];
        let observation = &self.run.steps[frame.step];
        let tube = |(index, (head, rod)): (usize, (&RodHead, &StillRod))| {
            let link = observation.links.iter().find(|link| link.rod == index);
            let seam_turns = link.map_or(0.0, |link| link.link);
            let stripe =
                (!rod.directions.is_empty()).then(|| Stripe { seam_turns, ..Stripe::along(rod.directions.clone()) });
            let radii = match rod.radii.as_slice() {
                [] => vec![self.run.head(index, frame.step).radius()],
                radii => radii.to_vec(),
            };
            let colors = match self.range {
                Some([low, high]) if !rod.values.is_empty() => {
                    colors_by_value(&rod.values, self.palette(), Some((low, high)))
                }
                _ => vec![COLORS[index % COLORS.len()]],
            };
            Tube { points: rod.points.clone(), radii, closed: head.closed, colors, stripe }
        };
        let tubes = self.run.rods.iter().zip(&frame.rods).enumerate().map(tube).collect();
        let view = view_along(&self.axes);
        let eye = self.axes[0].cross(&self.axes[1]);
        let seen = |obstacle: &Obstacle, pose: &ObstaclePose, line: &_| {
            obstacle::normal(obstacle, pose, line).dot(&eye) >= 0.0
        };
        let (spots, lines) = (self.spots(frame), self.lines(frame, &self.frames, seen));
        TubePicture { tubes, view, spots, lines, ..TubePicture::default() }
    }

    /// A highlight at every contact site, unless colours show the pressure.
    fn spots(&self, frame: &Still) -> Vec<Spot> {
        if self.run.choice.color_by == ColorBy::Pressure {
            return Vec::new();
        }
        let spot = |&(center, radius): &(Vec3, f64)| Spot { center, radius: 0.8 * radius, color: [235, 64, 52] };
        frame.spots.iter().map(spot).collect()
    }

    /// Lines of the obstacles where they are in this state, along the rods of all frames.
    fn lines(
        &self,
        frame: &Still,
        all: &[&Still],
        wanted: impl Fn(&Obstacle, &ObstaclePose, &[Vec3; 2]) -> bool,
    ) -> Vec<[Vec3; 2]> {
        let points = || all.iter().flat_map(|frame| &frame.rods).flat_map(|rod| &rod.points);
        let of = |(obstacle, placement): (&Obstacle, ObstaclePose)| {
            let mut lines = obstacle::placed_lines(obstacle, &placement, points());
            lines.retain(|line| wanted(obstacle, &placement, line));
            lines
        };
        self.run.obstacles.iter().zip(placements(&self.run.steps[frame.step])).flat_map(of).collect()
    }

    /// Smallest and largest coordinates \[L\] of what a frame shows: to the right, upwards, towards the eye.
    pub fn region(&self, frame: &Still) -> [Vec3; 2] {
        let radius = self.run.heads(frame.step).iter().map(RodHead::radius).fold(0.0, f64::max);
        let points = frame.rods.iter().flat_map(|rod| &rod.points);
        // a plane is seen as far as rods are
        let lines = self.lines(frame, &[frame], |obstacle, _, _| !obstacle.is_plane());
        region_of(points.chain(lines.iter().flatten()), radius, &self.axes)
    }

    /// Scale bar and colour bar, if requested.
    pub fn add_legends(&self, picture: &mut Picture, visible_width: Option<f64>, range: Option<[f64; 2]>) {
        if let (true, Some(visible)) = (self.run.choice.scale_bar, visible_width) {
            let length = round_below(0.25 * visible);
            let pixels = length / visible * picture.width() as f64;
            picture.scale_bar(pixels, &format!("{length} {}", self.run.units.length));
        }
        let (length, force) = (&self.run.units.length, &self.run.units.force);
        let title = match self.run.choice.color_by {
            ColorBy::Strand => return,
            ColorBy::Pressure => format!("contact force, smoothed, {force}/{length}"),
            ColorBy::Curvature => format!("curvature, 1/{length}"),
            ColorBy::TwistRate => format!("twist rate, rad/{length}"),
        };
        if let Some(range) = range {
            picture.color_bar(self.palette(), range, &title);
        }
    }

    fn palette(&self) -> Palette {
        if self.run.choice.color_by == ColorBy::TwistRate { Palette::CoolWarm } else { Palette::Viridis }
    }
}

/// Range of the colours over all these states: from zero; for twist symmetric about zero.
fn range(run: &RecordedRun, frames: &[&Still]) -> Option<[f64; 2]> {
    let values = frames.iter().flat_map(|frame| &frame.rods).flat_map(|rod| &rod.values);
    let largest = values.map(|value| value.abs()).fold(0.0, f64::max);
    let longest = run.rods.iter().map(|rod| rod.length).fold(0.0, f64::max);
    let (low, least) = match run.choice.color_by {
        ColorBy::Strand | ColorBy::Pressure => (0.0, 0.0),
        ColorBy::Curvature => (0.0, NO_TURN * TAU / longest),
        ColorBy::TwistRate => (-largest, NO_TURN * TAU / longest),
    };
    (largest > least).then_some([low, largest])
}
