//! A plot as PDF: a page on which plotters draws as on an SVG. Its text is outlines of the bundled font, so that it
//! looks the same everywhere.
//!
//! `pdf-writer` writes the file. It is one crate more, because all that it needs is here already; `svg2pdf`, which
//! takes the finished SVG, would bring 43 (docs/notes/build.md).

use std::convert::Infallible;

use ab_glyph::{Font as _, FontRef, OutlineCurve, Point};
use pdf_writer::{Content, Pdf, Rect, Ref};
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind};

use super::text::DEJAVU;

/// Points (1/72 inch) per pixel (1/96 inch).
const POINTS: f32 = 0.75;
/// Distance of the control points of a Bézier quarter circle from its ends, over the radius.
const QUARTER: f32 = 0.552_285;
/// Height of a line over the size of the font, as plotters counts it.
const LINE: f64 = 1.24;

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// A page to be drawn on.
pub(super) struct Page {
    content: Content,
    font: FontRef<'static>,
    /// Width and height in units of the drawing.
    size: (u32, u32),
    /// Points (1/72 inch) per unit of the drawing.
    unit: f32,
}

impl Page {
    /// A white page of so many pixels, each of `fine` units of the drawing.
    pub(super) fn new((width, height): (u32, u32), fine: u32) -> Result<Self, String> {
        let font = FontRef::try_from_slice(DEJAVU).map_err(|e| e.to_string())?;
        let unit = POINTS / fine as f32;
        let mut content = Content::new();
        // rows are counted from the top
        content.transform([unit, 0.0, 0.0, -unit, 0.0, POINTS * height as f32]);
        Ok(Self { content, font, size: (fine * width, fine * height), unit })
    }

    /// The file.
    pub(super) fn finish(self) -> Vec<u8> {
        let [catalog, pages, page, content] = [1, 2, 3, 4].map(Ref::new);
        let (width, height) = (self.unit * self.size.0 as f32, self.unit * self.size.1 as f32);
        let mut pdf = Pdf::new();
        pdf.catalog(catalog).pages(pages);
        pdf.pages(pages).kids([page]).count(1);
        pdf.page(page).parent(pages).media_box(Rect::new(0.0, 0.0, width, height)).contents(content).resources();
        pdf.stream(content, &self.content.finish());
        pdf.finish()
    }

    /// Lays a path and fills or strokes it, unless it cannot be seen.
    fn paint(&mut self, style: &impl BackendStyle, fill: bool, lay: impl FnOnce(&mut Content)) {
        let Some([r, g, b]) = on_white(style.color()) else { return };
        if fill {
            self.content.set_fill_rgb(r, g, b);
        } else {
            self.content.set_stroke_rgb(r, g, b).set_line_width(style.stroke_width() as f32);
        }
        lay(&mut self.content);
        if fill {
            self.content.fill_nonzero()
        } else {
            self.content.stroke()
        };
    }

    /// Fills a glyph whose origin is at a place.
    fn glyph(&mut self, curves: &[OutlineCurve], [left, down]: [f32; 2], scale: f32) {
        let place = |p: Point| [left + p.x * scale, down - p.y * scale];
        let third = |a: [f32; 2], b: [f32; 2]| [0, 1].map(|k| a[k] + 2.0 / 3.0 * (b[k] - a[k]));
        let mut pen = None;
        for curve in curves {
            let (start, controls) = match *curve {
                OutlineCurve::Line(a, b) => (place(a), vec![place(b)]),
                // the same curve as a cubic
                OutlineCurve::Quad(a, b, c) => {
                    (place(a), vec![third(place(a), place(b)), third(place(c), place(b)), place(c)])
                }
                OutlineCurve::Cubic(a, b, c, d) => (place(a), vec![place(b), place(c), place(d)]),
            };
            if pen != Some(start) {
                self.content.move_to(start[0], start[1]);
            }
            match controls[..] {
                [a, b, c] => self.content.cubic_to(a[0], a[1], b[0], b[1], c[0], c[1]),
                [a, ..] => self.content.line_to(a[0], a[1]),
                [] => continue,
            };
            pen = controls.last().copied();
        }
        if pen.is_some() {
            self.content.fill_nonzero();
        }
    }
}

/// A colour mixed with the white below it; none if it cannot be seen.
fn on_white(color: BackendColor) -> Option<[f32; 3]> {
    let (r, g, b) = color.rgb;
    let mixed = |channel: u8| (1.0 - color.alpha * (1.0 - f64::from(channel) / 255.0)) as f32;
    (color.alpha > 0.0).then(|| [r, g, b].map(mixed))
}

/// Lays lines from point to point.
fn lay_lines(content: &mut Content, points: impl IntoIterator<Item = BackendCoord>) {
    for (index, (x, y)) in points.into_iter().enumerate() {
        let (x, y) = (x as f32, y as f32);
        if index == 0 {
            content.move_to(x, y)
        } else {
            content.line_to(x, y)
        };
    }
}

impl DrawingBackend for &mut Page {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Drawn {
        self.draw_rect((x, y), (x + 1, y + 1), &color, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, fill: bool) -> Drawn {
        let (width, height) = (to.0 - from.0, to.1 - from.1);
        self.paint(style, fill, |content| {
            content.rect(from.0 as f32, from.1 as f32, width as f32, height as f32);
        });
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Drawn {
        self.paint(style, false, |content| lay_lines(content, path));
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, center: BackendCoord, radius: u32, style: &S, fill: bool) -> Drawn {
        let (x, y, r) = (center.0 as f32, center.1 as f32, radius as f32);
        let corners = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
        self.paint(style, fill, |content| {
            content.move_to(x + r, y);
            for quarter in 0..4 {
                let ((ax, ay), (bx, by)) = (corners[quarter], corners[(quarter + 1) % 4]);
                let place = |u: f32, v: f32| [x + r * (u * ax + v * bx), y + r * (u * ay + v * by)];
                let [a, b, c] = [place(1.0, QUARTER), place(QUARTER, 1.0), place(0.0, 1.0)];
                content.cubic_to(a[0], a[1], b[0], b[1], c[0], c[1]);
            }
        });
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, corners: I, style: &S) -> Drawn {
        self.paint(style, true, |content| lay_lines(content, corners));
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn {
        let (Some([r, g, b]), Some(units)) = (on_white(style.color()), self.font.units_per_em()) else { return Ok(()) };
        let size = (style.size() / LINE) as f32;
        let scale = size / units;
        let font = self.font.clone();
        let advance = |c: char| font.h_advance_unscaled(font.glyph_id(c)) * scale;
        let width: f32 = text.chars().map(advance).sum();
        let mut left = match style.anchor().h_pos {
            HPos::Left => 0.0,
            HPos::Center => -0.5 * width,
            HPos::Right => -width,
        };
        // as in plotters' SVG; a small x is .547 of the size high (DejaVu Sans: 1120 of 2048 units)
        let down = size
            * match style.anchor().v_pos {
                VPos::Top => 0.76,
                VPos::Center => 0.5 * 0.547,
                VPos::Bottom => -0.5 * 0.547,
            };
        let (cos, sin) = match style.transform() {
            FontTransform::None => (1.0, 0.0),
            FontTransform::Rotate90 => (0.0, 1.0),
            FontTransform::Rotate180 => (-1.0, 0.0),
            FontTransform::Rotate270 => (0.0, -1.0),
        };
        self.content.save_state().set_fill_rgb(r, g, b);
        self.content.transform([cos, sin, -sin, cos, at.0 as f32, at.1 as f32]);
        for c in text.chars() {
            let curves = font.outline(font.glyph_id(c)).map_or_else(Vec::new, |outline| outline.curves);
            self.glyph(&curves, [left, down], scale);
            left += advance(c);
        }
        self.content.restore_state();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use plotters::prelude::*;

    use super::*;

    #[test]
    fn shapes_and_text_become_paths() {
        let mut page = Page::new((40, 20), 2).unwrap();
        let area = (&mut page).into_drawing_area();
        area.fill(&WHITE).unwrap();
        area.draw(&PathElement::new(vec![(0, 1), (2, 3)], ShapeStyle::from(&BLACK.mix(0.5)).stroke_width(2))).unwrap();
        area.draw(&Circle::new((9, 8), 3, RGBColor(0, 114, 178).filled())).unwrap();
        let style = super::super::text::font(10).transform(FontTransform::Rotate270).color(&BLACK);
        area.draw(&Text::new("Δ <", (4, 5), style)).unwrap();
        drop(area);
        let pdf = String::from_utf8_lossy(&page.finish()).into_owned();
        for part in [
            "/MediaBox [0 0 30 15]",
            "0.375 0 0 -0.375 0 15 cm\n",
            "1 1 1 rg\n0 0 80 40 re\nf",
            "0.5 0.5 0.5 RG\n2 w\n0 1 m\n2 3 l\nS",
            "0 0.44705883 0.69803923 rg\n12 8 m\n",
            "q\n0 0 0 rg\n0 -1 1 0 4 5 cm\n",
        ] {
            assert!(pdf.contains(part), "{part}: {pdf}");
        }
        // two glyphs, the blank has none
        let text = &pdf[pdf.find("q\n0 0 0 rg").unwrap()..];
        assert_eq!(text.matches("\nf\n").count(), 2, "{text}");
    }
}
