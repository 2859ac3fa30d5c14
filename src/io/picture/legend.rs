//! Legends in pictures: colour bar and scale bar.

use super::palette::Palette;
use super::text::width as text_width;
use super::{Picture, text};

/// Height of the picture over that of capitals, and its width over that of capitals in flat pictures.
const CAPITAL: [usize; 2] = [48, 128];
const INK: [u8; 3] = [40, 44, 52];

impl Picture {
    /// Draws a bar with the colours of a palette along the right edge, its ends labelled, `title` above it.
    pub(crate) fn color_bar(&mut self, palette: Palette, range: [f64; 2], title: &str) {
        let (width, height) = (self.width, self.height);
        let letter = self.letter();
        let (thick, tall) = (letter * 3 / 2, height / 2);
        let labels = [short(range[1]), short(range[0])];
        let widest = labels.iter().map(|label| text_width(label, letter)).max().unwrap_or(0);
        let left = width.saturating_sub(thick + widest + 3 * letter);
        let top = (height - tall) / 2;
        for row in 0..tall {
            let color = palette.color(1.0 - row as f64 / (tall - 1).max(1) as f64);
            (left..(left + thick).min(width)).for_each(|column| self.set(column, top + row, color));
        }
        let beside = left + thick + letter / 2;
        text::write(self, &labels[0], [beside, top], letter, INK);
        text::write(self, &labels[1], [beside, (top + tall).saturating_sub(letter)], letter, INK);
        let title_left = width.saturating_sub(text_width(title, letter) + letter);
        text::write(self, title, [title_left.min(left), top.saturating_sub(2 * letter)], letter, INK);
    }

    /// Draws a bar of `pixels` length at the bottom left, its length written above it.
    pub fn scale_bar(&mut self, pixels: f64, label: &str) {
        let letter = self.letter();
        let (left, top) = (2 * letter, self.height.saturating_sub(2 * letter));
        let end = (left + pixels.round() as usize).min(self.width);
        for row in top..(top + letter / 3 + 1).min(self.height) {
            (left..end).for_each(|column| self.set(column, row, INK));
        }
        text::write(self, label, [left, top.saturating_sub(2 * letter)], letter, INK);
    }

    /// Height of capitals.
    fn letter(&self) -> usize {
        (self.height / CAPITAL[0]).max(self.width / CAPITAL[1]).max(6)
    }

    fn set(&mut self, column: usize, row: usize, color: [u8; 3]) {
        let at = 3 * (row * self.width + column);
        if let Some(pixel) = self.rgb.get_mut(at..at + 3) {
            pixel.copy_from_slice(&color);
        }
    }
}

/// A number as short text.
fn short(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&size) {
        let digits = (2 - size.log10().floor() as i32).max(0) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.2e}")
    }
}
