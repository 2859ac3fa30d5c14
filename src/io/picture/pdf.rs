//! A plot as PDF: the shapes of its SVG one by one, and its text as outlines of the bundled font, so that it looks the
//! same everywhere.
//!
//! The SVG is that of [`super::plot`]: one element a line, attributes in double quotes, no nesting. An element that is
//! not known here is an error, not left out.

use std::fmt::Write as _;

use ab_glyph::{Font as _, FontRef, OutlineCurve, Point};

use super::text::DEJAVU;

/// Points (1/72 inch) per pixel (1/96 inch).
const POINTS: f64 = 0.75;
/// Distance of the control points of a Bézier quarter circle from its ends, over the radius.
const QUARTER: f64 = 0.552_285;
/// Height of a small x over the size of the font (DejaVu Sans: 1120 of 2048 units).
const EX: f64 = 0.547;

/// The PDF of a plot whose SVG is shown `scale` times smaller than its units.
pub(super) fn from_svg(svg: &str, scale: f64) -> Result<Vec<u8>, String> {
    let font = FontRef::try_from_slice(DEJAVU).map_err(|e| e.to_string())?;
    let mut page = Page { content: String::new(), font };
    let mut size = [0.0; 2];
    // the text of a <text> element stands on the lines after it
    for part in svg.split('<').filter(|part| !part.trim().is_empty()) {
        let (tag, inner) = part.split_once('>').unwrap_or((part, ""));
        let element = Element { tag };
        match tag.split_whitespace().next().unwrap_or_default() {
            "svg" => size = [element.number("width")?, element.number("height")?],
            "rect" => page.rectangle(&element)?,
            "line" => page.line(&element)?,
            "polyline" => page.polyline(&element, false)?,
            "polygon" => page.polyline(&element, true)?,
            "circle" => page.circle(&element)?,
            "text" => page.text(&element, inner)?,
            "/svg" | "/text" => {}
            other => return Err(format!("unknown element {other}")),
        }
    }
    let [width, height] = size.map(|pixels| POINTS * pixels);
    let unit = POINTS / scale;
    Ok(file(&format!("{unit} 0 0 {} 0 {height} cm\n{}", -unit, page.content), width, height))
}

/// A start tag.
struct Element<'a> {
    tag: &'a str,
}

impl<'a> Element<'a> {
    fn attribute(&self, name: &str) -> Option<&'a str> {
        let from = self.tag.find(&format!(" {name}=\""))? + name.len() + 3;
        self.tag[from..].split('"').next()
    }

    fn number(&self, name: &str) -> Result<f64, String> {
        let text = self.attribute(name).ok_or_else(|| format!("no {name} in <{}>", self.tag))?;
        text.parse().map_err(|_| format!("{name}=\"{text}\" is no number"))
    }

    /// A colour as PDF takes it, mixed with the white below it; none for "none".
    fn color(&self, name: &str) -> Result<Option<String>, String> {
        let Some(hex) = self.attribute(name).and_then(|text| text.strip_prefix('#')) else { return Ok(None) };
        let opacity = if self.attribute("opacity").is_some() { self.number("opacity")? } else { 1.0 };
        let code = u32::from_str_radix(hex, 16).map_err(|_| format!("{name}=\"#{hex}\" is no colour"))?;
        let channel = |shift: u32| 1.0 - opacity * (1.0 - f64::from(code >> shift & 255) / 255.0);
        Ok((opacity > 0.0).then(|| format!("{:.3} {:.3} {:.3}", channel(16), channel(8), channel(0))))
    }
}

/// The content of the page, in the units of the SVG.
struct Page<'a> {
    content: String,
    font: FontRef<'a>,
}

impl Page<'_> {
    /// Fills and strokes a path as the element says.
    fn paint(&mut self, element: &Element, path: &str) -> Result<(), String> {
        if let Some(color) = element.color("fill")? {
            self.add(format_args!("{color} rg\n{path}f"));
        }
        if let Some(color) = element.color("stroke")? {
            let width = if element.attribute("stroke-width").is_some() { element.number("stroke-width")? } else { 1.0 };
            self.add(format_args!("{color} RG {width} w\n{path}S"));
        }
        Ok(())
    }

    fn add(&mut self, line: std::fmt::Arguments) {
        // writing to a String cannot fail
        let _ = self.content.write_fmt(format_args!("{line}\n"));
    }

    fn rectangle(&mut self, element: &Element) -> Result<(), String> {
        let [x, y, width, height] = numbers(element, ["x", "y", "width", "height"])?;
        self.paint(element, &format!("{x} {y} {width} {height} re\n"))
    }

    fn line(&mut self, element: &Element) -> Result<(), String> {
        let [x1, y1, x2, y2] = numbers(element, ["x1", "y1", "x2", "y2"])?;
        self.paint(element, &format!("{x1} {y1} m {x2} {y2} l\n"))
    }

    fn polyline(&mut self, element: &Element, closed: bool) -> Result<(), String> {
        let mut path = String::new();
        for (index, point) in element.attribute("points").unwrap_or_default().split_whitespace().enumerate() {
            let place = point.split_once(',').and_then(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)));
            let (x, y): (f64, f64) = place.ok_or_else(|| format!("{point} is no point"))?;
            let _ = writeln!(path, "{x} {y} {}", if index == 0 { "m" } else { "l" });
        }
        self.paint(element, &(path + if closed { "h\n" } else { "" }))
    }

    fn circle(&mut self, element: &Element) -> Result<(), String> {
        let [x, y, r] = numbers(element, ["cx", "cy", "r"])?;
        let corner = |angle: i32| match angle.rem_euclid(4) {
            0 => (1.0, 0.0),
            1 => (0.0, 1.0),
            2 => (-1.0, 0.0),
            _ => (0.0, -1.0),
        };
        let mut path = format!("{} {y} m\n", x + r);
        for quarter in 0..4 {
            let ((ax, ay), (bx, by)) = (corner(quarter), corner(quarter + 1));
            let place = |u: f64, v: f64| format!("{} {}", x + r * (u * ax + v * bx), y + r * (u * ay + v * by));
            let _ = writeln!(path, "{} {} {} c", place(1.0, QUARTER), place(QUARTER, 1.0), place(0.0, 1.0));
        }
        self.paint(element, &path)
    }

    /// Outlines of the text; anchor and shift as SVG defines them.
    fn text(&mut self, element: &Element, inner: &str) -> Result<(), String> {
        let text = inner.trim().replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&");
        let [x, y, size] = numbers(element, ["x", "y", "font-size"])?;
        let Some(color) = element.color("fill")? else { return Ok(()) };
        let scale = size / f64::from(self.font.units_per_em().ok_or("the font has no size")?);
        let width = text.chars().map(|c| f64::from(self.font.h_advance_unscaled(self.font.glyph_id(c)))).sum::<f64>();
        let left = match element.attribute("text-anchor") {
            Some("middle") => -0.5 * width * scale,
            Some("end") => -width * scale,
            _ => 0.0,
        };
        let down = element.attribute("dy").map_or(Ok(0.0), |dy| shift(dy, size))?;
        let (cos, sin) = match element.attribute("transform") {
            None => (1.0, 0.0),
            Some(turn) if turn.starts_with("rotate(90,") => (0.0, 1.0),
            Some(turn) if turn.starts_with("rotate(270,") => (0.0, -1.0),
            Some(turn) if turn.starts_with("rotate(180,") => (-1.0, 0.0),
            Some(other) => return Err(format!("unknown transform {other}")),
        };
        self.add(format_args!("q {color} rg {cos} {sin} {} {cos} {x} {y} cm", -sin));
        let mut at = left;
        for c in text.chars() {
            let glyph = self.font.glyph_id(c);
            let curves = self.font.outline(glyph).map_or_else(Vec::new, |outline| outline.curves);
            self.glyph(&curves, [at, down], scale);
            at += f64::from(self.font.h_advance_unscaled(glyph)) * scale;
        }
        self.add(format_args!("Q"));
        Ok(())
    }

    /// Fills a glyph whose origin is at a place.
    fn glyph(&mut self, curves: &[OutlineCurve], [left, down]: [f64; 2], scale: f64) {
        if curves.is_empty() {
            return;
        }
        let place = |p: Point| [left + f64::from(p.x) * scale, down - f64::from(p.y) * scale];
        let third = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|k| a[k] + 2.0 / 3.0 * (b[k] - a[k]));
        let (mut path, mut pen) = (String::new(), None);
        for curve in curves {
            let (start, controls) = match *curve {
                OutlineCurve::Line(a, b) => (a, vec![place(b)]),
                // the same curve as a cubic
                OutlineCurve::Quad(a, b, c) => {
                    (a, vec![third(place(a), place(b)), third(place(c), place(b)), place(c)])
                }
                OutlineCurve::Cubic(a, b, c, d) => (a, vec![place(b), place(c), place(d)]),
            };
            let start = place(start);
            if pen != Some(start) {
                let _ = write!(path, "{:.2} {:.2} m ", start[0], start[1]);
            }
            controls.iter().for_each(|[x, y]| {
                let _ = write!(path, "{x:.2} {y:.2} ");
            });
            path += if controls.len() == 1 { "l\n" } else { "c\n" };
            pen = controls.last().copied();
        }
        self.add(format_args!("{path}f"));
    }
}

fn numbers<const N: usize>(element: &Element, names: [&str; N]) -> Result<[f64; N], String> {
    let mut all = [0.0; N];
    for (number, name) in all.iter_mut().zip(names) {
        *number = element.number(name)?;
    }
    Ok(all)
}

/// A length in em or ex.
fn shift(text: &str, size: f64) -> Result<f64, String> {
    let units = [("em", size), ("ex", EX * size)];
    let of = |(unit, size): (&str, f64)| Some(text.strip_suffix(unit)?.parse::<f64>().ok()? * size);
    units.into_iter().find_map(of).ok_or_else(|| format!("dy=\"{text}\" is no length"))
}

/// A file of one page.
fn file(content: &str, width: f64, height: f64) -> Vec<u8> {
    let objects = [
        "<< /Type /Catalog /Pages 2 0 R >>".to_owned(),
        "<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_owned(),
        format!("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width} {height}] /Resources << >> /Contents 4 0 R >>"),
        format!("<< /Length {} >>\nstream\n{content}endstream", content.len()),
    ];
    let mut text = "%PDF-1.4\n".to_owned();
    let mut table = "0000000000 65535 f \n".to_owned();
    for (index, object) in objects.iter().enumerate() {
        let _ = writeln!(table, "{:010} 00000 n ", text.len());
        let _ = write!(text, "{} 0 obj\n{object}\nendobj\n", index + 1);
    }
    let (count, start) = (objects.len() + 1, text.len());
    let _ =
        write!(text, "xref\n0 {count}\n{table}trailer\n<< /Size {count} /Root 1 0 R >>\nstartxref\n{start}\n%%EOF\n");
    text.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_and_text_become_paths() {
        let svg = "<svg width=\"40\" height=\"20\" viewBox=\"0 0 80 40\">\n\
                   <rect x=\"0\" y=\"0\" width=\"80\" height=\"40\" opacity=\"1\" fill=\"#FFFFFF\" stroke=\"none\"/>\n\
                   <polyline fill=\"none\" opacity=\"0.5\" stroke=\"#000000\" stroke-width=\"2\" points=\"0,1 2,3 \"/>\n\
                   <circle cx=\"9\" cy=\"8\" r=\"3\" opacity=\"1\" fill=\"#0072B2\" stroke=\"none\"/>\n\
                   <text x=\"4\" y=\"5\" dy=\"0.5ex\" text-anchor=\"end\" font-size=\"10\" opacity=\"1\" fill=\"#000000\" \
                   transform=\"rotate(270, 4, 5)\">\nΔ &lt;\n</text>\n</svg>\n";
        let pdf = String::from_utf8(from_svg(svg, 2.0).unwrap()).unwrap();
        for part in [
            "/MediaBox [0 0 30 15]",
            "0.375 0 0 -0.375 0 15 cm\n",
            "1.000 1.000 1.000 rg\n0 0 80 40 re\nf",
            "0.500 0.500 0.500 RG 2 w\n0 1 m\n2 3 l\nS",
            "0.000 0.447 0.698 rg\n12 8 m\n",
            "q 0.000 0.000 0.000 rg 0 -1 1 0 4 5 cm\n",
        ] {
            assert!(pdf.contains(part), "{part}: {pdf}");
        }
        // two glyphs, the blank has none
        let text = &pdf[pdf.find("q 0.000").unwrap()..];
        assert_eq!(text.matches("\nf\n").count(), 2, "{text}");
        // the table's offsets are where the objects begin
        let table = pdf.split("xref\n0 5\n").nth(1).unwrap();
        for (index, line) in table.lines().skip(1).take(4).enumerate() {
            let offset: usize = line[..10].parse().unwrap();
            assert!(pdf[offset..].starts_with(&format!("{} 0 obj", index + 1)));
        }
        assert!(from_svg("<svg width=\"1\" height=\"1\"><path d=\"\"/></svg>", 1.0).unwrap_err().contains("path"));
    }
}
