//! Pictures of a run: final shape, film strip, writhe against excess link.

use std::f64::consts::TAU;
use std::path::PathBuf;

use crate::error::InputError;
use crate::io::picture::camera::principal_axes;
use crate::io::picture::obstacle::{self, round_below};
use crate::io::picture::{
    Palette, Picture, PlotSpec, Series, SeriesStyle, Spot, Stripe, Tube, TubePicture, View, colors_by_value,
    film_strip, plot_lines,
};
use crate::io::plot_run::with_jumps;
use crate::io::table::fixed;
use crate::math::{Mat3, Vec3};
use crate::scene::file::ColorBy;
use crate::scene::{Obstacle, ObstaclePose, Skeleton};

use super::still::{Still, StillRod};
use super::{Record, RecordedFrame, RodHead, files, placements};

/// Pictures in the film strip.
const STRIP: usize = 6;
/// Largest width and height of `picture.png`, pixels.
const PICTURE: [usize; 2] = [1600, 1200];
/// Largest width and height of a picture in the film strip, pixels.
const FRAME: [usize; 2] = [560, 420];
/// Angle at which planes are seen, rad: their grids are open, and what lies on them is hardly foreshortened.
const ELEVATION: f64 = 0.3;
/// Curvature and twist rate over those of one turn along the rod that are shown as none: below the tolerance of the solver.
const NO_TURN: f64 = 1e-6;
/// Variance of a flat or straight state across it, over the largest: what is straight is then seen well from all sides but
/// along it.
const THIN: f64 = 1e-3;
/// Margin of a picture on each side, over the extent of its rods.
const MARGIN: f64 = 0.03;
/// Width with a colour bar over that without: the bar and its title take a fifth of the picture.
const BAR: f64 = 1.3;
/// Largest width over height, because legends need room in pictures of rods that are long and thin.
const FLATTEST: usize = 5;

impl Record {
    pub(super) fn write_pictures(&self, last: &RecordedFrame) -> Result<(), InputError> {
        let final_state = self.still(last, false);
        let axes = self.axes(&[&final_state]);
        let region = self.region(&final_state, &axes);
        let range = self.range(std::iter::once(&final_state));
        let shown = extents(region, range.is_some());
        let [width, height] = self.choice.size.unwrap_or_else(|| canvas(shown, PICTURE));
        let visible = width_shown(shown, [width, height]);
        let (center, visible_width) = (Some(middle(region, &axes, range.map(|_| visible))), Some(visible));
        let picture = self.picture(&final_state, &[&final_state], &axes, range);
        let picture = TubePicture { width, height, center, visible_width, ..picture };
        self.write_picture(picture, range)?;
        let mut stills = Vec::new();
        let last = self.still(last, true);
        let frames = self.strip(&last);
        // one camera for all, so that what is held stands still, and for all of the motion
        let axes = self.axes(&frames);
        let regions = frames.iter().map(|frame| self.region(frame, &axes));
        let region = regions.reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])]).unwrap_or_default();
        let empty = of_strip(region, &axes);
        let range = self.range(frames.iter().copied());
        for &frame in &frames {
            let TubePicture { tubes, spots, lines, .. } = self.picture(frame, &frames, &axes, range);
            let mut drawn = TubePicture { tubes, spots, lines, ..empty.clone() }.render()?;
            self.add_legends(&mut drawn, empty.visible_width, None);
            stills.push((drawn, self.caption(frame.step)));
        }
        film_strip(&stills, 3, [255; 3])?.save_png(&self.dir.join(files::FILM_STRIP))?;
        self.write_plot()
    }

    /// Writes a picture of each mode: the nodes of the rods at rest, grey, and at the end of a swing, with its caption.
    pub(super) fn write_picture_of_modes(
        &self,
        rest: &[Vec<Vec3>],
        ends: &[(Vec<Vec<Vec3>>, String)],
    ) -> Result<PathBuf, InputError> {
        const SWUNG: [u8; 3] = [62, 112, 178];
        const AT_REST: [u8; 3] = [200, 200, 200];
        let still = |rods: &[Vec<Vec3>]| {
            let rod = |points: &Vec<Vec3>| {
                let (radii, directions, values) = (Vec::new(), Vec::new(), Vec::new());
                StillRod { points: points.clone(), radii, directions, values }
            };
            Still { step: 0, rods: rods.iter().map(rod).collect(), spots: Vec::new() }
        };
        let all: Vec<Still> = ends.iter().map(|(rods, _)| still(rods)).chain([still(rest)]).collect();
        let axes = self.axes(&all.iter().collect::<Vec<_>>());
        let radius = self.rods.iter().map(RodHead::radius).fold(0.0, f64::max);
        let points = all.iter().flat_map(|still| &still.rods).flat_map(|rod| &rod.points);
        let empty = of_strip(region_of(points, radius, &axes), &axes);
        let tubes = |rods: &[Vec<Vec3>], color: [u8; 3]| -> Vec<Tube> {
            let tube = |(points, head): (&Vec<Vec3>, &RodHead)| {
                let (points, radii, closed) = (points.clone(), vec![head.radius()], head.closed);
                Tube { points, radii, closed, colors: vec![color], stripe: None }
            };
            rods.iter().zip(&self.rods).map(tube).collect()
        };
        let mut stills = Vec::new();
        for (rods, caption) in ends {
            let tubes = [tubes(rest, AT_REST), tubes(rods, SWUNG)].concat();
            stills.push((TubePicture { tubes, ..empty.clone() }.render()?, caption.clone()));
        }
        let path = self.dir.join(files::MODES_PICTURE);
        film_strip(&stills, 3, [255; 3])?.save_png(&path)?;
        Ok(path)
    }

    /// Up to six frames evenly spread over the run, the last state always among them.
    pub(super) fn strip<'a>(&'a self, last: &'a Still) -> Vec<&'a Still> {
        let mut frames: Vec<&Still> = self.film.iter().filter(|frame| frame.step < last.step).collect();
        frames.push(last);
        let count = STRIP.min(frames.len());
        let target = |k: usize| last.step as f64 * k as f64 / (count - 1).max(1) as f64;
        let distance = |frame: &Still, k: usize| (frame.step as f64 - target(k)).abs();
        let nearest = |k: usize| frames.iter().copied().min_by(|a, b| distance(a, k).total_cmp(&distance(b, k)));
        let mut chosen: Vec<&Still> = (0..count).filter_map(nearest).collect();
        chosen.dedup_by_key(|frame| frame.step);
        chosen
    }

    /// Writes the large picture with its legends.
    fn write_picture(&self, picture: TubePicture, range: Option<[f64; 2]>) -> Result<(), InputError> {
        let path = self.dir.join(files::PICTURE);
        let mut drawn = picture.render()?;
        self.add_legends(&mut drawn, picture.visible_width, range);
        if !self.choice.transparent {
            return drawn.save_png(&path);
        }
        // the same on black: the difference is the background
        let mut on_black = TubePicture { background: [0; 3], ..picture.clone() }.render()?;
        self.add_legends(&mut on_black, picture.visible_width, range);
        drawn.save_transparent_png(&on_black, &path)
    }

    /// Scale bar and colour bar, if requested.
    fn add_legends(&self, picture: &mut Picture, visible_width: Option<f64>, range: Option<[f64; 2]>) {
        if let (true, Some(visible)) = (self.choice.scale_bar, visible_width) {
            let length = round_below(0.25 * visible);
            let pixels = length / visible * picture.width() as f64;
            picture.scale_bar(pixels, &format!("{length} {}", self.units.length));
        }
        let (length, force) = (&self.units.length, &self.units.force);
        let title = match self.choice.color_by {
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
        if self.choice.color_by == ColorBy::TwistRate { Palette::CoolWarm } else { Palette::Viridis }
    }

    /// Range of the colours over all these states: from zero; for twist symmetric about zero.
    fn range<'a>(&self, frames: impl Iterator<Item = &'a Still>) -> Option<[f64; 2]> {
        let values = frames.flat_map(|frame| &frame.rods).flat_map(|rod| &rod.values);
        let largest = values.map(|value| value.abs()).fold(0.0, f64::max);
        let longest = self.rods.iter().map(|rod| rod.length).fold(0.0, f64::max);
        let (low, least) = match self.choice.color_by {
            ColorBy::Strand | ColorBy::Pressure => (0.0, 0.0),
            ColorBy::Curvature => (0.0, NO_TURN * TAU / longest),
            ColorBy::TwistRate => (-largest, NO_TURN * TAU / longest),
        };
        (largest > least).then_some([low, largest])
    }

    /// Directions to the right and upwards in pictures of these frames: those of the scene, or those of [`best_axes`]; above
    /// a plane it is below.
    fn axes(&self, frames: &[&Still]) -> [Vec3; 2] {
        if let Some(camera) = self.choice.camera.map(Vec3::from) {
            let camera = camera / camera.amax();
            let along_z = camera.xy().norm() < 1e-6 * camera.norm();
            let up = self.choice.up.map_or(if along_z { Vec3::y() } else { Vec3::z() }, Vec3::from);
            let right = up.cross(&camera).normalize();
            return [right, camera.cross(&right).normalize()];
        }
        if self.planar {
            return [Vec3::x(), Vec3::y()];
        }
        let axes = best_axes(frames);
        let normal = self.obstacles.iter().find_map(|obstacle| match obstacle.skeleton {
            Skeleton::Plane { normal, .. } => Some(normal),
            _ => None,
        });
        match normal {
            Some(normal) => above(normal, axes),
            None => [axes.row(0).transpose(), -axes.row(1).transpose()],
        }
    }

    /// Smallest and largest coordinates \[L\] of what a frame shows: to the right, upwards, towards the eye.
    fn region(&self, frame: &Still, axes: &[Vec3; 2]) -> [Vec3; 2] {
        let radius = (0..self.rods.len()).map(|rod| self.head(rod, frame.step).radius()).fold(0.0, f64::max);
        let points = frame.rods.iter().flat_map(|rod| &rod.points);
        // a plane is seen as far as rods are
        let lines = self.lines(frame, &[frame], |obstacle, _, _| !obstacle.is_plane());
        region_of(points.chain(lines.iter().flatten()), radius, axes)
    }

    fn caption(&self, step: usize) -> String {
        let observation = &self.steps[step];
        match observation.links.first() {
            Some(link) if self.has_link() => {
                format!("ΔLk {}  Wr {}", fixed(link.excess_link, 2), fixed(link.writhe, 2))
            }
            _ => format!("stage {} at {:.0} %", observation.stage + 1, 100.0 * observation.fraction),
        }
    }

    /// Whether a closed rod has a non-zero excess link in any step.
    fn has_link(&self) -> bool {
        self.steps.iter().flat_map(|step| &step.links).any(|link| link.excess_link != 0.0)
    }

    /// The first rod whose excess link is not the same in all steps.
    fn rod_with_changing_link(&self) -> Option<usize> {
        let links = || self.steps.iter().flat_map(|step| &step.links);
        let start = |rod: usize| links().find(|link| link.rod == rod).map(|link| link.excess_link);
        links().find(|link| start(link.rod) != Some(link.excess_link)).map(|link| link.rod)
    }

    /// One of the pictures of `all` frames.
    fn picture(&self, frame: &Still, all: &[&Still], axes: &[Vec3; 2], range: Option<[f64; 2]>) -> TubePicture {
        const COLORS: [[u8; 3]; 4] = [[62, 112, 178], [206, 112, 58], [84, 150, 96], [150, 104, 170]];
        let observation = &self.steps[frame.step];
        let tube = |(index, (head, rod)): (usize, (&RodHead, &StillRod))| {
            let link = observation.links.iter().find(|link| link.rod == index);
            let seam_turns = link.map_or(0.0, |link| link.link);
            let stripe =
                (!rod.directions.is_empty()).then(|| Stripe { seam_turns, ..Stripe::along(rod.directions.clone()) });
            let radii = match rod.radii.as_slice() {
                [] => vec![self.head(index, frame.step).radius()],
                radii => radii.to_vec(),
            };
            let colors = match range {
                Some([low, high]) if !rod.values.is_empty() => {
                    colors_by_value(&rod.values, self.palette(), Some((low, high)))
                }
                _ => vec![COLORS[index % COLORS.len()]],
            };
            Tube { points: rod.points.clone(), radii, closed: head.closed, colors, stripe }
        };
        let tubes = self.rods.iter().zip(&frame.rods).enumerate().map(tube).collect();
        let view = view_along(axes);
        let eye = axes[0].cross(&axes[1]);
        let seen = |obstacle: &Obstacle, pose: &ObstaclePose, line: &_| {
            obstacle::normal(obstacle, pose, line).dot(&eye) >= 0.0
        };
        let (spots, lines) = (self.spots(frame), self.lines(frame, all, seen));
        TubePicture { tubes, view, spots, lines, ..TubePicture::default() }
    }

    /// A highlight at every contact site, unless colours show the pressure.
    fn spots(&self, frame: &Still) -> Vec<Spot> {
        if self.choice.color_by == ColorBy::Pressure {
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
        self.obstacles.iter().zip(placements(&self.steps[frame.step])).flat_map(of).collect()
    }

    fn write_plot(&self) -> Result<(), InputError> {
        let Some(rod) = self.rod_with_changing_link() else { return Ok(()) };
        let links = || self.steps.iter().flat_map(|step| &step.links).filter(|link| link.rod == rod);
        let writhe: Vec<(f64, f64)> = links().map(|link| (link.excess_link, link.writhe)).collect();
        let twist: Vec<(f64, f64)> = links().map(|link| (link.excess_link, link.twist)).collect();
        let snapped: Vec<bool> = self.steps.iter().map(|step| step.energy_released > 0.0).collect();
        let ((writhe, mut jumps), (twist, more)) = (with_jumps(&writhe, &snapped), with_jumps(&twist, &snapped));
        jumps.extend(more);
        let series = |name: &str, points: Vec<(f64, f64)>, style| Series { name: name.to_owned(), points, style };
        let plot = PlotSpec {
            title: self.title.clone(),
            x_label: "excess link ΔLk, turns".to_owned(),
            y_label: "turns".to_owned(),
            series: vec![
                series("writhe", writhe, SeriesStyle::LinePoints),
                series("twist", twist, SeriesStyle::LinePoints),
            ],
            ..PlotSpec::default()
        };
        let snaps = (!jumps.is_empty()).then(|| series("snap", jumps, SeriesStyle::Dashed));
        let plot = PlotSpec { series: plot.series.into_iter().chain(snaps).collect(), ..plot };
        plot_lines(&self.dir.join(files::WRITHE), &plot)
    }
}

/// Smallest and largest coordinates \[L\] of balls about points: to the right, upwards, towards the eye.
fn region_of<'a>(points: impl Iterator<Item = &'a Vec3>, radius: f64, axes: &[Vec3; 2]) -> [Vec3; 2] {
    let axes = coordinates(axes);
    let none = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    points
        .map(|point| axes * point)
        .fold(none, |[low, high], p| [low.inf(&p.add_scalar(-radius)), high.sup(&p.add_scalar(radius))])
}

fn view_along(axes: &[Vec3; 2]) -> View {
    View::Along { forward: -axes[0].cross(&axes[1]), up: axes[1] }
}

/// A picture of a strip that shows a region, with nothing in it yet.
fn of_strip(region: [Vec3; 2], axes: &[Vec3; 2]) -> TubePicture {
    let shown = extents(region, false);
    let [width, height] = canvas(shown, FRAME);
    let (center, visible_width) = (Some(middle(region, axes, None)), Some(width_shown(shown, [width, height])));
    let view = view_along(axes);
    TubePicture { width, height, supersampling: 2, center, visible_width, view, ..TubePicture::default() }
}

/// Width and height \[L\] that show a whole region, with room for a colour bar on the right if there is one.
fn extents([low, high]: [Vec3; 2], has_bar: bool) -> [f64; 2] {
    let room = if has_bar { BAR } else { 1.0 } + 2.0 * MARGIN;
    [room * (high.x - low.x), (1.0 + 2.0 * MARGIN) * (high.y - low.y)]
}

/// Point in the middle of the picture of a region. With a colour bar the region is at the left of the width shown.
fn middle([low, high]: [Vec3; 2], axes: &[Vec3; 2], with_bar: Option<f64>) -> Vec3 {
    let mut point = 0.5 * (low + high);
    if let Some(width) = with_bar {
        point.x = low.x - MARGIN * (high.x - low.x) + 0.5 * width;
    }
    coordinates(axes).transpose() * point
}

/// Rows to the right, upwards, towards the eye.
fn coordinates([right, up]: &[Vec3; 2]) -> Mat3 {
    Mat3::from_rows(&[right.transpose(), up.transpose(), right.cross(up).transpose()])
}

/// Width and height of a picture as wide as `largest` and only as high as is needed to show what is seen.
fn canvas(extents: [f64; 2], largest: [usize; 2]) -> [usize; 2] {
    let [width, height] = largest;
    let needed = (width as f64 * extents[1] / extents[0]).ceil();
    [width, (needed as usize).clamp(width / FLATTEST, height)]
}

/// Width \[L\] at which both extents fit into a picture of that many pixels.
fn width_shown(extents: [f64; 2], [width, height]: [usize; 2]) -> f64 {
    extents[0].max(extents[1] * width as f64 / height as f64)
}

/// Rows right, down, towards the eye for pictures of states of one run, so that none is seen edge-on: of the directions
/// along which single states spread least, and those midway between two of them, the eye is where the worst seen state is
/// seen best. A state is seen as well as the area of its shadow is large. The widest axis of the last is to the right.
fn best_axes(frames: &[&Still]) -> Mat3 {
    let own: Vec<(Mat3, Vec3)> = frames.iter().map(|frame| spreads(frame)).collect();
    let least = || own.iter().map(|(axes, _)| Vec3::from(axes.row(2).transpose()));
    let between = least().flat_map(|a| least().flat_map(move |b| [a + b, a - b]));
    let candidates = between.filter_map(|eye| eye.try_normalize(0.1));
    let seen = |(axes, variances): &(Mat3, Vec3), eye: &Vec3| {
        let shares = (axes * eye).component_mul(&(axes * eye));
        shares.component_div(variances).sum() * variances[2]
    };
    let worst = |eye: &Vec3| own.iter().map(|own| seen(own, eye)).fold(f64::INFINITY, f64::min);
    // the first of equals
    let better = |best: Vec3, eye: Vec3| if worst(&eye) > worst(&best) { eye } else { best };
    let last = own.last().map_or_else(Mat3::identity, |(axes, _)| *axes);
    let eye = candidates.fold(last.row(2).transpose(), better);
    let right = across(eye, last);
    Mat3::from_rows(&[right.transpose(), right.cross(&eye).transpose(), eye.transpose()])
}

/// Principal axes of a state, and the variances along them over the largest, at least [`THIN`].
fn spreads(frame: &Still) -> (Mat3, Vec3) {
    let points = frame.rods.iter().flat_map(|rod| &rod.points);
    let axes = principal_axes(points.clone(), true);
    let mean = points.clone().sum::<Vec3>() / points.clone().count().max(1) as f64;
    let along = points.map(|point| axes * (point - mean)).fold(Vec3::zeros(), |sum, p| sum + p.component_mul(&p));
    (axes, along.map(|sum| (sum / along[0].max(f64::MIN_POSITIVE)).clamp(THIN, 1.0)))
}

/// The widest axis of a picture across a direction.
fn across(direction: Vec3, axes: Mat3) -> Vec3 {
    let across = |row: usize| {
        let axis: Vec3 = axes.row(row).transpose();
        axis - direction * direction.dot(&axis)
    };
    // the widest axis may be the direction itself
    if across(0).norm() > 0.5 { across(0).normalize() } else { across(1).normalize() }
}

/// Axes of a picture in which a plane's normal points upwards: to the right what is widest along it, seen from a little
/// above it, so that its grid can be seen.
fn above(normal: Vec3, axes: Mat3) -> [Vec3; 2] {
    let right = across(normal, axes);
    let (sin, cos) = ELEVATION.sin_cos();
    [right, normal * cos - right.cross(&normal) * sin]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Symptom: a colour bar covered the rod in pictures that are wider than it needs.
    #[test]
    fn a_colour_bar_has_its_own_place() {
        let axes = [Vec3::y(), Vec3::z()];
        for region in [[Vec3::zeros(), Vec3::new(1.0, 4.0, 4.0)], [Vec3::new(5.0, 2.0, 2.0), Vec3::new(9.0, 4.0, 9.0)]]
        {
            let needed = extents(region, true);
            let size = canvas(needed, PICTURE);
            let width = width_shown(needed, size);
            let middle = coordinates(&axes) * super::middle(region, &axes, Some(width));
            let [left, right] = region.map(|corner| corner.x - middle.x);
            assert!(left > -0.5 * width && right < 0.3 * width, "{left} {right} {width}");
            assert_eq!(middle.y, 0.5 * (region[0].y + region[1].y));
        }
    }

    /// A ring that folds into a figure-eight in another plane: no state is seen edge-on, and one alone is seen face-on.
    #[test]
    fn no_state_of_a_film_is_seen_edge_on() {
        let still = |point: fn(f64) -> Vec3| {
            let points = (0..100).map(|k| point(TAU * f64::from(k) / 100.0)).collect();
            let rod = StillRod { points, radii: Vec::new(), directions: Vec::new(), values: Vec::new() };
            Still { step: 0, rods: vec![rod], spots: Vec::new() }
        };
        let ring = still(|t| Vec3::new(3.0 * t.cos(), 3.0 * t.sin(), 0.0));
        let eight = still(|t| Vec3::new(4.0 * t.cos(), 0.1 * t.sin(), 2.0 * (2.0 * t).sin()));
        let straight = still(|t| Vec3::new(t, 0.0, 0.0));
        let eye = |frames: &[&Still]| Vec3::from(best_axes(frames).row(2).transpose());
        assert!(eye(&[&ring]).z.abs() > 0.999 && eye(&[&eight]).y.abs() > 0.999);
        let both = eye(&[&straight, &ring, &ring, &ring, &eight]);
        assert!(both.z.abs() > 0.5 && both.y.abs() > 0.5, "{both}");
        let axes = best_axes(&[&ring, &eight]);
        assert!((axes * axes.transpose() - Mat3::identity()).norm() < 1e-12, "{axes}");
    }

    #[test]
    fn planes_are_seen_from_a_little_above() {
        let normal = Vec3::z();
        // rods that spread most along x, y or z
        for axes in [[0, 1, 2], [1, 0, 2], [2, 0, 1], [2, 1, 0]] {
            let rows = axes.map(|k| Vec3::ith(k, 1.0).transpose());
            let [right, up] = above(normal, Mat3::from_rows(&rows));
            let eye = right.cross(&up);
            assert!(right.dot(&up).abs() < 1e-15 && right.dot(&normal).abs() < 1e-15);
            assert!(up.dot(&normal) > 0.9 && (eye.dot(&normal) - ELEVATION.sin()).abs() < 1e-15, "{eye}");
        }
    }

    #[test]
    fn pictures_are_as_high_as_their_rods_need() {
        for (extents, expected) in [([4.0, 4.0], 1200), ([10.0, 3.0], 480), ([10.0, 0.1], 320), ([0.0, 9.0], 1200)] {
            let size = canvas(extents, PICTURE);
            assert_eq!(size, [1600, expected], "{extents:?}");
            let visible = width_shown(extents, size);
            assert!(visible >= extents[0] && visible * expected as f64 / 1600.0 >= extents[1] * (1.0 - 1e-12));
        }
    }
}
