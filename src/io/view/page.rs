//! A film as one page for the browser.

use std::fmt::Write as _;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::error::InputError;
use crate::io::picture::{Stripe, obstacle};
use crate::math::Vec3;

use super::{Film, FilmRod, Frame, Plot, Quantity, STRANDS};

const STYLE: &str = include_str!("../../../assets/view/style.css");
const BODY: &str = include_str!("../../../assets/view/body.html");
/// Scripts in the order of their dependencies.
const SCRIPTS: [&str; 5] = [
    include_str!("../../../assets/view/film.js"),
    include_str!("../../../assets/view/shaders.js"),
    include_str!("../../../assets/view/stage.js"),
    include_str!("../../../assets/view/panel.js"),
    include_str!("../../../assets/view/main.js"),
];
/// Number of colours of a palette in the page.
const COLORS: usize = 17;

impl Film {
    /// The film as a page for the browser: a single file that needs no network. Positions are stored in single
    /// precision about the middle of the last frame. Equal films give equal bytes.
    ///
    /// # Errors
    /// [`InputError`] naming the field if a count, radius or number cannot be used.
    pub fn page(&self) -> Result<String, InputError> {
        self.check()?;
        let (center, ..) = self.stage();
        let title = if self.title.is_empty() { "supercoil" } else { &self.title };
        let mut page = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n{BODY}",
            escaped(title)
        );
        // Writing to a String cannot fail. "<" inside a string of JSON would end the element.
        let head = self.head().to_string().replace('<', "\\u003c");
        let _ = writeln!(page, "<script type=\"application/json\" id=\"film\">{head}</script>");
        for (index, frame) in self.frames.iter().enumerate() {
            let data = STANDARD.encode(numbers(frame, center));
            let _ = writeln!(page, "<script type=\"text/plain\" id=\"frame{index}\">{data}</script>");
        }
        let _ = writeln!(page, "<script>\n\"use strict\";\n{}</script>\n</body>\n</html>", SCRIPTS.concat());
        Ok(page)
    }

    /// Writes [`Film::page`] to a file, replacing what is there.
    ///
    /// # Errors
    /// As there; [`InputError::Write`] if the file cannot be written.
    pub fn save_page(&self, path: &Path) -> Result<(), InputError> {
        let refuse = |e: std::io::Error| InputError::Write { path: path.to_owned(), reason: e.to_string() };
        std::fs::write(path, self.page()?).map_err(refuse)
    }

    /// All data except the nodes.
    fn head(&self) -> Value {
        let (center, axes, extent) = self.stage();
        let rows: [[f64; 3]; 3] = axes.transpose().into();
        let rod = |rod: &FilmRod| json!({ "name": rod.name, "closed": rod.closed });
        let frame = |frame: &Frame| {
            let forces = frame.forces.iter().map(|[at, force]| {
                let at = at - center;
                [at.x, at.y, at.z, force.x, force.y, force.z]
            });
            let images = self.images(frame).map(|(matrix, shift)| {
                let shift = matrix * center + shift - center;
                [0, 1, 2].map(|k| [matrix[(k, 0)], matrix[(k, 1)], matrix[(k, 2)], shift[k]])
            });
            json!({
                "step": frame.step,
                "counts": frame.rods.iter().map(|rod| rod.points.len()).collect::<Vec<_>>(),
                "radii": frame.rods.iter().map(|rod| &rod.radii).collect::<Vec<_>>(),
                "seams": frame.rods.iter().map(|rod| rod.seam_turns).collect::<Vec<_>>(),
                "forces": forces.collect::<Vec<_>>(),
                "images": images.collect::<Vec<_>>(),
            })
        };
        let column = |(name, unit): &(String, String)| json!({ "name": name, "unit": unit });
        let line = |(obstacle, ends): (usize, [Vec3; 2])| {
            let [from, to] = ends.map(|end| <[f64; 3]>::from(end - center));
            let normal = <[f64; 3]>::from(self.normal_of(obstacle, &ends));
            json!({ "obstacle": obstacle, "ends": [from, to], "normal": normal })
        };
        let plot = |plot: &Plot| json!({ "x": plot.x, "y": plot.y });
        json!({
            "program": format!("supercoil {}", env!("CARGO_PKG_VERSION")),
            "title": self.title,
            "note": self.note,
            "force": self.units.force,
            "rods": self.rods.iter().map(rod).collect::<Vec<_>>(),
            "frames": self.frames.iter().map(frame).collect::<Vec<_>>(),
            "lines": self.lines().into_iter().map(line).collect::<Vec<_>>(),
            "axes": rows,
            "extent": extent,
            "quantities": Quantity::ALL.map(|quantity| self.quantity(quantity)),
            "strands": STRANDS,
            "stripe": Stripe::along(Vec::new()).color,
            "columns": self.table.columns.iter().map(column).collect::<Vec<_>>(),
            "rows": self.table.rows,
            "plots": self.plots.iter().map(plot).collect::<Vec<_>>(),
        })
    }

    /// Normal of an obstacle at the start at one of its lines, see [`obstacle::normal`].
    fn normal_of(&self, index: usize, line: &[Vec3; 2]) -> Vec3 {
        let obstacle = &self.obstacles[index];
        obstacle::normal(obstacle, &obstacle.start(), line)
    }

    fn quantity(&self, quantity: Quantity) -> Value {
        let (length, force) = (&self.units.length, &self.units.force);
        let (label, unit) = match quantity {
            Quantity::Strand => ("strand", String::new()),
            Quantity::Pressure => ("contact force per length, smoothed", format!("{force}/{length}")),
            Quantity::Curvature => ("curvature", format!("1/{length}")),
            Quantity::TwistRate => ("twist rate", format!("rad/{length}")),
        };
        let place = |k: usize| k as f64 / (COLORS - 1) as f64;
        let colors: Vec<[u8; 3]> = (0..COLORS).map(|k| quantity.palette().color(place(k))).collect();
        let range = self.range(quantity);
        json!({ "name": quantity.name(), "label": label, "unit": unit, "range": range, "colors": colors })
    }
}

/// Nine numbers a node in single precision, little endian: point, direction, pressure, curvature, twist.
fn numbers(frame: &Frame, center: Vec3) -> Vec<u8> {
    let of_rod = |rod: &super::FrameRod| {
        let node = |i: usize| {
            let (p, d) = (rod.points[i] - center, rod.directions[i]);
            [p.x, p.y, p.z, d.x, d.y, d.z, rod.pressure[i], rod.curvature[i], rod.twist_rate[i]]
        };
        (0..rod.points.len()).flat_map(node).flat_map(|x| (x as f32).to_le_bytes()).collect::<Vec<u8>>()
    };
    frame.rods.iter().flat_map(of_rod).collect()
}

/// Text with reserved characters of HTML escaped.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
