//! `picture.png`: the final shape.

use crate::error::InputError;
use crate::io::picture::TubePicture;
use crate::io::record::run::{RecordedFrame, RecordedRun};
use crate::io::record::{Writer, files};

use super::camera::{PICTURE, canvas, extents, middle, width_shown};
use super::drawing::Drawing;
use super::still::Still;

#[derive(Debug)]
pub(in crate::io::record) struct PictureWriter;

impl Writer for PictureWriter {
    fn last(&mut self, run: &RecordedRun, last: &RecordedFrame) -> Result<(), InputError> {
        if !run.output.picture {
            return Ok(());
        }
        let still = Still::of(run, last, false);
        let drawing = Drawing::of(run, vec![&still]);
        let (axes, range) = (drawing.axes, drawing.range);
        let region = drawing.region(&still);
        let shown = extents(region, range.is_some());
        let [width, height] = run.choice.size.unwrap_or_else(|| canvas(shown, PICTURE));
        let visible = width_shown(shown, [width, height]);
        let (center, visible_width) = (Some(middle(region, &axes, range.map(|_| visible))), Some(visible));
        let picture = TubePicture { width, height, center, visible_width, ..drawing.picture(&still) };
        let path = run.dir.join(files::PICTURE);
        let mut drawn = picture.render()?;
        drawing.add_legends(&mut drawn, visible_width, range);
        if !run.choice.transparent {
            return drawn.save_png(&path);
        }
        // the same on black: the difference is the background
        let mut on_black = TubePicture { background: [0; 3], ..picture }.render()?;
        drawing.add_legends(&mut on_black, visible_width, range);
        drawn.save_transparent_png(&on_black, &path)
    }
}
