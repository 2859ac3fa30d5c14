//! Text in pictures and plots, in a bundled font: a subset of DejaVu Sans.

use super::Picture;
use plotters::prelude::*;
use std::sync::LazyLock;

/// Font family of all text. The viewer of an SVG may lack the first.
const FAMILY: &str = "DejaVu Sans, sans-serif";

/// The bundled font.
pub(super) const DEJAVU: &[u8] = include_bytes!("../../../assets/DejaVuSans-subset.ttf");

/// Height of a capital over a font's size as plotters takes it: 1493 units of the ascent's 1901 and the descent's 483.
const CAPITAL: f64 = 1493.0 / 2384.0;

/// Whether the bundled font can be used; not on WebAssembly, where plotters cannot draw text into a picture.
#[cfg(not(target_arch = "wasm32"))]
static READY: LazyLock<bool> =
    LazyLock::new(|| plotters::style::register_font(FAMILY, FontStyle::Normal, DEJAVU).is_ok());
#[cfg(target_arch = "wasm32")]
static READY: LazyLock<bool> = LazyLock::new(|| false);

/// The font for plots, `size` units high from ascent to descent.
pub(super) fn font(size: u32) -> FontDesc<'static> {
    LazyLock::force(&READY);
    FontDesc::new(FontFamily::Name(FAMILY), f64::from(size), FontStyle::Normal)
}

/// The font in which a capital is `height` pixels high, and its whole size in pixels.
fn by_capital(height: usize) -> (FontDesc<'static>, u32) {
    let size = (height as f64 / CAPITAL).round() as u32;
    (font(size), size)
}

/// Width in pixels of text whose capitals are `height` pixels high.
pub(super) fn width(text: &str, height: usize) -> usize {
    by_capital(height).0.box_size(text).map_or(0, |(width, _)| width as usize)
}

/// Draws text; see [`Picture::write`].
pub(super) fn write(picture: &mut Picture, text: &str, [left, top]: [usize; 2], height: usize, [r, g, b]: [u8; 3]) {
    if height == 0 || !*READY {
        return;
    }
    let (font, size) = by_capital(height);
    // plotters puts the baseline half the font's size below the point it is given
    let corner = (left as i32, top as i32 + height as i32 - size as i32 / 2);
    let area = BitMapBackend::with_buffer(&mut picture.rgb, (picture.width as u32, picture.height as u32));
    // a picture in memory never fails
    let _ = area.into_drawing_area().draw_text(text, &font.color(&RGBColor(r, g, b)), corner);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns and rows that text covers: first and last of each.
    fn extent(text: &str, corner: [usize; 2], height: usize) -> [usize; 4] {
        let mut picture = Picture::filled(400, 100, [255; 3]);
        write(&mut picture, text, corner, height, [0; 3]);
        let dark = |&(c, r): &(usize, usize)| picture.pixel(c, r)[0] < 128;
        let inked: Vec<_> = (0..100).flat_map(|r| (0..400).map(move |c| (c, r))).filter(dark).collect();
        let of =
            |f: fn(&(usize, usize)) -> usize| (inked.iter().map(f).min().unwrap(), inked.iter().map(f).max().unwrap());
        let ((left, right), (top, bottom)) = (of(|p| p.0), of(|p| p.1));
        [left, right, top, bottom]
    }

    #[test]
    fn capitals_are_as_high_and_text_as_wide_as_asked() {
        for height in [12, 30, 55] {
            let text = "ΔH";
            let [left, right, top, bottom] = extent(text, [50, 20], height);
            assert!(top.abs_diff(20) <= 1 && bottom.abs_diff(20 + height - 1) <= 1, "{height}: rows {top} to {bottom}");
            let wide = width(text, height);
            assert!(left >= 50 && right < 50 + wide && right + height / 3 > 50 + wide, "{wide}: {left} to {right}");
        }
    }

    /// Every sign that captions use is in the font: none is drawn as the box for those that are not.
    #[test]
    fn signs_of_captions_are_in_the_font() {
        let drawn = |character: char| {
            let mut picture = Picture::filled(60, 60, [255; 3]);
            write(&mut picture, &character.to_string(), [10, 10], 30, [0; 3]);
            picture
        };
        let missing = drawn('漢');
        for character in "ΔσκλπεΩ−±°·×²³₀≤≥≈∞…éß".chars() {
            assert!(drawn(character) != missing, "{character}");
        }
    }
}
