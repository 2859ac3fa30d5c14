//! Pictures of a run: final shape, film strip, writhe against excess link.

use crate::error::InputError;
use crate::io::picture::{
    PlotSpec, Series, SeriesStyle, Spot, Stripe, Tube, TubePicture, View, film_strip, plot_lines,
};
use crate::io::table::fixed;
use crate::math::{Mat3, Vec3};

use super::still::{Still, StillRod};
use super::{Frame, Record, RodHead, files};

/// Pictures in the film strip.
const STRIP: usize = 6;

impl Record {
    pub(super) fn write_pictures(&self, last: &Frame) -> Result<(), InputError> {
        let picture = TubePicture { width: 1600, height: 1200, ..self.picture(&self.still(last, false)) };
        picture.render()?.save_png(&self.dir.join(files::PICTURE))?;
        let mut stills = Vec::new();
        let last = self.still(last, true);
        let frames = self.strip(&last);
        let visible_width = frames.iter().map(|frame| self.visible_width(frame)).reduce(f64::max);
        for frame in frames {
            let picture =
                TubePicture { width: 560, height: 420, supersampling: 2, visible_width, ..self.picture(frame) };
            stills.push((picture.render()?, self.caption(frame.step)));
        }
        film_strip(&stills, 3, [255; 3])?.save_png(&self.dir.join(files::FILM_STRIP))?;
        self.write_plot()
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

    /// Width that shows the whole frame in a picture of 4:3 as it is viewed.
    fn visible_width(&self, frame: &Still) -> f64 {
        let points = || frame.rods.iter().flat_map(|rod| &rod.points);
        let center = points().sum::<Vec3>() / points().count() as f64;
        let axes = if self.planar { [Vec3::x(), Vec3::y()] } else { widest_axes(points(), &center) };
        let radius = self.rods.iter().map(|rod| rod.contact_radius).fold(0.0, f64::max);
        let extent = |axis: usize| {
            let along = |point: &Vec3| axes[axis].dot(&(point - center)).abs();
            2.0 * (points().map(along).fold(0.0, f64::max) + radius)
        };
        1.06 * extent(0).max(extent(1) * 4.0 / 3.0)
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

    /// Whether a closed rod's excess link is ever other than zero.
    fn has_link(&self) -> bool {
        self.steps.iter().flat_map(|step| &step.links).any(|link| link.excess_link != 0.0)
    }

    fn picture(&self, frame: &Still) -> TubePicture {
        const COLORS: [[u8; 3]; 4] = [[62, 112, 178], [206, 112, 58], [84, 150, 96], [150, 104, 170]];
        let observation = &self.steps[frame.step];
        let tube = |(index, (head, rod)): (usize, (&RodHead, &StillRod))| {
            let link = observation.links.iter().find(|link| link.rod == index);
            let seam_turns = link.map_or(0.0, |link| link.link);
            let stripe =
                (!rod.directions.is_empty()).then(|| Stripe { seam_turns, ..Stripe::along(rod.directions.clone()) });
            let radius = head.radius();
            let colors = vec![COLORS[index % COLORS.len()]];
            Tube { points: rod.points.clone(), radius, closed: head.closed, colors, stripe }
        };
        let tubes = self.rods.iter().zip(&frame.rods).enumerate().map(tube).collect();
        let from_above = View::Along { forward: -Vec3::z(), up: Vec3::y() };
        let view = if self.planar { from_above } else { View::Auto };
        TubePicture { tubes, view, spots: self.spots(frame), ..TubePicture::default() }
    }

    /// A glow at every contact site.
    fn spots(&self, frame: &Still) -> Vec<Spot> {
        let radius = |rod: usize| 0.8 * self.rods[rod].contact_radius;
        let spot = |&(center, rod): &(Vec3, usize)| Spot { center, radius: radius(rod), color: [235, 64, 52] };
        frame.spots.iter().map(spot).collect()
    }

    fn write_plot(&self) -> Result<(), InputError> {
        if !self.has_link() {
            return Ok(());
        }
        let rod =
            self.steps.iter().flat_map(|step| &step.links).find(|link| link.excess_link != 0.0).map(|link| link.rod);
        let links = || self.steps.iter().flat_map(|step| &step.links).filter(|link| Some(link.rod) == rod);
        let writhe = links().map(|link| (link.excess_link, link.writhe)).collect();
        let twist = links().map(|link| (link.excess_link, link.twist)).collect();
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
        plot_lines(&self.dir.join(files::WRITHE), &plot)
    }
}

/// The two axes along which the points spread most, widest first.
fn widest_axes<'a>(points: impl Iterator<Item = &'a Vec3>, center: &Vec3) -> [Vec3; 2] {
    let spread: Mat3 = points.map(|point| (point - center) * (point - center).transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    [0, 1].map(|k| eigen.eigenvectors.column(axes[k]).into_owned())
}
