//! Several pictures side by side.

use super::{Picture, text::width as text_width};
use crate::error::InputError;

/// Composes `(picture, caption)` pairs, row by row with `columns` in each, captions centred below the pictures.
///
/// All pictures get the space of the largest. Captions are dark on a light `background` (sRGB) and light on a dark one,
/// and are as large as fits, at most 1/14 of the height of a picture, or 1/32 of its width if that is more.
///
/// # Errors
/// [`InputError::Count`] if there is no picture or `columns` is 0.
pub fn film_strip(frames: &[(Picture, String)], columns: usize, background: [u8; 3]) -> Result<Picture, InputError> {
    for (field, value) in [("frames", frames.len()), ("columns", columns)] {
        if value == 0 {
            return Err(InputError::Count { field: field.to_owned(), value, allowed: "at least 1" });
        }
    }
    let columns = columns.min(frames.len());
    let width = frames.iter().map(|(p, _)| p.width).max().unwrap_or(1);
    let height = frames.iter().map(|(p, _)| p.height).max().unwrap_or(1);
    let largest = (height / 14).max(width / 32).max(5);
    let longest = frames.iter().map(|(_, caption)| text_width(caption, largest)).max().unwrap_or(0);
    let letter = (largest * width * 9 / (10 * longest.max(1))).clamp(5, largest);
    let caption = if longest == 0 { 0 } else { 2 * letter };
    let rows = frames.len().div_ceil(columns);
    let mut sheet = Picture::filled(columns * width, rows * (height + caption), background);
    let luminance: u32 = background.iter().zip([2, 7, 1]).map(|(c, w)| u32::from(*c) * w).sum();
    let ink = if luminance > 1200 { [40, 44, 52] } else { [225, 228, 235] };
    for (index, (picture, text)) in frames.iter().enumerate() {
        let (left, top) = ((index % columns) * width, (index / columns) * (height + caption));
        let corner = [left + (width - picture.width) / 2, top + (height - picture.height) / 2];
        paste(&mut sheet, picture, corner);
        let wide = text_width(text, letter);
        sheet.write(text, [left + width.saturating_sub(wide) / 2, top + height + letter / 4], letter, ink);
    }
    Ok(sheet)
}

/// Copies a picture to a place of a larger one.
fn paste(sheet: &mut Picture, picture: &Picture, [left, top]: [usize; 2]) {
    for row in 0..picture.height {
        let from = 3 * row * picture.width;
        let to = 3 * ((top + row) * sheet.width + left);
        sheet.rgb[to..to + 3 * picture.width].copy_from_slice(&picture.rgb[from..from + 3 * picture.width]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_and_captions_find_their_places() {
        let frame = |c: u8| (Picture::filled(40, 30, [c, 0, 0]), String::from("Lk 1"));
        let sheet = film_strip(&[frame(10), frame(20), frame(30)], 2, [255, 255, 255]).unwrap();
        assert_eq!(sheet.width(), 80);
        assert_eq!(sheet.pixel(0, 0), [10, 0, 0]);
        assert_eq!(sheet.pixel(79, 0), [20, 0, 0]);
        assert_eq!(sheet.pixel(0, sheet.height() / 2), [30, 0, 0]);
        let ink = (30..sheet.height() / 2)
            .flat_map(|r| (0..40).map(move |c| (c, r)))
            .filter(|&(c, r)| sheet.pixel(c, r)[0] < 128);
        assert!(ink.count() > 5, "a caption");
        assert!(film_strip(&[], 2, [0; 3]).is_err());
    }
}
