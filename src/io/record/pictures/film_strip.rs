//! `filmstrip.png`: six states on the way.

use crate::error::InputError;
use crate::io::picture::{TubePicture, film_strip};
use crate::io::record::run::{RecordedFrame, RecordedRun};
use crate::io::record::{RecordState, Writer, files};
use crate::io::table::fixed;

use super::camera::of_strip;
use super::drawing::Drawing;
use super::still::Still;

/// Most frames kept for the film strip; then every other one is dropped.
const MAX_FILM: usize = 48;
/// Pictures in the film strip.
const STRIP: usize = 6;

/// Keeps a frame every so many steps.
#[derive(Debug)]
pub(in crate::io::record) struct FilmStripWriter {
    film: Vec<Still>,
    /// Steps from one frame to the next.
    stride: usize,
}

impl FilmStripWriter {
    /// Goes on after these frames.
    pub fn new(film: Vec<Still>, stride: usize) -> Self {
        Self { film, stride: stride.max(1) }
    }
}

impl Writer for FilmStripWriter {
    fn step(&mut self, run: &RecordedRun, frame: &RecordedFrame) -> Result<(), InputError> {
        if run.output.picture && frame.step.is_multiple_of(self.stride) {
            self.film.push(Still::of(run, frame, true));
            if self.film.len() == MAX_FILM {
                self.stride *= 2;
                self.film.retain(|kept| kept.step.is_multiple_of(self.stride));
            }
        }
        Ok(())
    }

    fn last(&mut self, run: &RecordedRun, last: &RecordedFrame) -> Result<(), InputError> {
        if !run.output.picture {
            return Ok(());
        }
        let last = Still::of(run, last, true);
        let frames = strip(&self.film, &last);
        // one camera for all, so that what is held stands still, and for all of the motion
        let drawing = Drawing::of(run, frames.clone());
        let regions = frames.iter().map(|frame| drawing.region(frame));
        let region = regions.reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])]).unwrap_or_default();
        let empty = of_strip(region, &drawing.axes);
        let mut stills = Vec::new();
        for frame in frames {
            let TubePicture { tubes, spots, lines, .. } = drawing.picture(frame);
            let mut drawn = TubePicture { tubes, spots, lines, ..empty.clone() }.render()?;
            drawing.add_legends(&mut drawn, empty.visible_width, None);
            stills.push((drawn, caption(run, frame.step)));
        }
        film_strip(&stills, 3, [255; 3])?.save_png(&run.dir.join(files::FILM_STRIP))
    }

    fn save(&self, state: &mut RecordState) {
        self.film.clone_into(&mut state.film);
        state.stride = self.stride;
    }
}

/// Up to six frames evenly spread over the run, the last state always among them.
fn strip<'a>(film: &'a [Still], last: &'a Still) -> Vec<&'a Still> {
    let mut frames: Vec<&Still> = film.iter().filter(|frame| frame.step < last.step).collect();
    frames.push(last);
    let count = STRIP.min(frames.len());
    let target = |k: usize| last.step as f64 * k as f64 / (count - 1).max(1) as f64;
    let distance = |frame: &Still, k: usize| (frame.step as f64 - target(k)).abs();
    let nearest = |k: usize| frames.iter().copied().min_by(|a, b| distance(a, k).total_cmp(&distance(b, k)));
    let mut chosen: Vec<&Still> = (0..count).filter_map(nearest).collect();
    chosen.dedup_by_key(|frame| frame.step);
    chosen
}

fn caption(run: &RecordedRun, step: usize) -> String {
    let observation = &run.steps[step];
    match observation.links.first() {
        Some(link) if has_link(run) => {
            format!("ΔLk {}  Wr {}", fixed(link.excess_link, 2), fixed(link.writhe, 2))
        }
        _ => format!("stage {} at {:.0} %", observation.stage + 1, 100.0 * observation.fraction),
    }
}

/// Whether a closed rod has a non-zero excess link in any step.
fn has_link(run: &RecordedRun) -> bool {
    run.steps.iter().flat_map(|step| &step.links).any(|link| link.excess_link != 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_is_spread_over_the_run() {
        let still = |step: usize| Still { step, rods: Vec::new(), spots: Vec::new() };
        let film: Vec<Still> = (0..99).step_by(4).map(still).collect();
        let last = still(99);
        assert_eq!(strip(&film, &last).iter().map(|f| f.step).collect::<Vec<_>>(), [0, 20, 40, 60, 80, 99]);
    }
}
