//! Line plots as SVG.

use crate::error::InputError;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::path::Path;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SeriesStyle {
    /// A line.
    #[default]
    Line,
    /// A dashed line.
    Dashed,
    /// Dots.
    Points,
    /// A line with dots at its points.
    LinePoints,
}

/// One curve of a plot.
#[derive(Debug, Clone, Default)]
pub struct Series {
    /// Name in the legend; empty for none.
    pub name: String,
    /// (x, y) pairs; those that are not finite (or not positive on a logarithmic axis) interrupt the line.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: SeriesStyle,
}

/// A plot of several curves over common axes.
#[derive(Debug, Clone)]
pub struct PlotSpec {
    /// Title; empty for none.
    pub title: String,
    /// Label of the horizontal axis, with unit.
    pub x_label: String,
    /// Label of the vertical axis, with unit.
    pub y_label: String,
    /// The curves.
    pub series: Vec<Series>,
    /// Logarithmic horizontal axis.
    pub log_x: bool,
    /// Logarithmic vertical axis.
    pub log_y: bool,
    /// Size in pixels: width, height.
    pub size: (u32, u32),
}

impl Default for PlotSpec {
    fn default() -> Self {
        let empty = String::new;
        Self {
            title: empty(),
            x_label: empty(),
            y_label: empty(),
            series: vec![],
            log_x: false,
            log_y: false,
            size: (760, 500),
        }
    }
}

/// Colours that stay apart for colour-blind readers (Okabe & Ito 2008).
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(60, 60, 60),
];

const FONT: &str = "sans-serif";

/// Draws a plot as SVG, replacing what is there; text is left to the viewer's own sans-serif font.
///
/// # Errors
/// [`InputError::Inconsistent`] if no point can be drawn, [`InputError::File`] if the file cannot be written.
pub fn plot_lines(path: &Path, plot: &PlotSpec) -> Result<(), InputError> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, plot.size).into_drawing_area();
        let (x, y) = (range(plot, 0)?, range(plot, 1)?);
        let drawn = match (plot.log_x, plot.log_y) {
            (false, false) => draw(&area, plot, x, y),
            (true, false) => draw(&area, plot, x.log_scale(), y),
            (false, true) => draw(&area, plot, x, y.log_scale()),
            (true, true) => draw(&area, plot, x.log_scale(), y.log_scale()),
        };
        drawn.and_then(|()| area.present().map_err(|e| e.to_string())).map_err(|reason| refuse(path, reason))?;
    }
    std::fs::write(path, text).map_err(|e| refuse(path, e.to_string()))
}

fn refuse(path: &Path, reason: String) -> InputError {
    InputError::File { path: path.to_owned(), reason }
}

/// Whether a point can be drawn on the plot's axes.
fn is_drawable(plot: &PlotSpec, (x, y): (f64, f64)) -> bool {
    x.is_finite() && y.is_finite() && (!plot.log_x || x > 0.0) && (!plot.log_y || y > 0.0)
}

/// Range of an axis (0: x, 1: y) with a little room at the ends.
fn range(plot: &PlotSpec, axis: usize) -> Result<std::ops::Range<f64>, InputError> {
    let logarithmic = [plot.log_x, plot.log_y][axis];
    let values =
        plot.series.iter().flat_map(|s| &s.points).filter(|p| is_drawable(plot, **p)).map(|p| [p.0, p.1][axis]);
    let values = values.map(|v| if logarithmic { v.ln() } else { v });
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        let reason = "no point with finite coordinates (positive on logarithmic axes)".to_owned();
        return Err(InputError::Inconsistent { field: "series".to_owned(), reason });
    }
    let room = if high > low { 0.04 * (high - low) } else { 0.5 * low.abs().max(1.0) };
    let (low, high) = (low - room, high + room);
    Ok(if logarithmic { low.exp()..high.exp() } else { low..high })
}

/// Short label of a tick.
fn tick(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{value:.1e}").replace(".0e", "e");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Draws axes, curves and legend.
fn draw<X, Y>(area: &Area, plot: &PlotSpec, x: X, y: Y) -> Result<(), String>
where
    X: AsRangedCoord<Value = f64, CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>>,
    Y: AsRangedCoord<Value = f64, CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>>,
{
    let words = |e: DrawingAreaErrorKind<std::io::Error>| e.to_string();
    area.fill(&WHITE).map_err(words)?;
    let mut builder = ChartBuilder::on(area);
    builder.margin(14).margin_right(24).x_label_area_size(48).y_label_area_size(72);
    if !plot.title.is_empty() {
        builder.caption(&plot.title, (FONT, 20));
    }
    let mut chart = builder.build_cartesian_2d(x, y).map_err(words)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .axis_style(BLACK.mix(0.6))
        .label_style((FONT, 14))
        .axis_desc_style((FONT, 16))
        .x_desc(&plot.x_label)
        .y_desc(&plot.y_label)
        .x_label_formatter(&|v| tick(*v))
        .y_label_formatter(&|v| tick(*v))
        .draw()
        .map_err(words)?;
    for (series, color) in plot.series.iter().zip(COLORS.iter().cycle()) {
        let stroke = color.stroke_width(2);
        let pieces = series.points.split(|p| !is_drawable(plot, *p)).filter(|piece| !piece.is_empty());
        for (index, piece) in pieces.enumerate() {
            let points = piece.iter().copied();
            let drawn = match series.style {
                SeriesStyle::Line => chart.draw_series(LineSeries::new(points, stroke)),
                SeriesStyle::Dashed => chart.draw_series(DashedLineSeries::new(points, 7, 5, stroke)),
                SeriesStyle::Points => chart.draw_series(points.map(|p| Circle::new(p, 3, color.filled()))),
                SeriesStyle::LinePoints => {
                    chart.draw_series(LineSeries::new(points.clone(), stroke)).map_err(words)?;
                    chart.draw_series(points.map(|p| Circle::new(p, 3, color.filled())))
                }
            };
            let shown = drawn.map_err(words)?;
            if index == 0 && !series.name.is_empty() {
                let ([first, second], radius) = key(series.style);
                let line = move |[from, to]: [i32; 2]| PathElement::new(vec![(from, 0), (to, 0)], stroke);
                shown.label(&series.name).legend(move |at| {
                    let dot = Circle::new((11, 0), radius, color.filled());
                    EmptyElement::at(at) + line(first) + line(second) + dot
                });
            }
        }
    }
    if plot.series.iter().all(|s| s.name.is_empty()) {
        return Ok(());
    }
    let mut legend = chart.configure_series_labels();
    legend.background_style(WHITE.mix(0.85)).border_style(BLACK.mix(0.2)).label_font((FONT, 14)).draw().map_err(words)
}

/// Legend sample of a style: ends of two strokes (one may be empty) and radius of a dot, in pixels.
fn key(style: SeriesStyle) -> ([[i32; 2]; 2], i32) {
    match style {
        SeriesStyle::Line => ([[0, 22], [22, 22]], 0),
        SeriesStyle::Dashed => ([[0, 8], [14, 22]], 0),
        SeriesStyle::Points => ([[11, 11], [11, 11]], 3),
        SeriesStyle::LinePoints => ([[0, 22], [22, 22]], 3),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(points: Vec<(f64, f64)>) -> PlotSpec {
        let series = vec![Series { name: "measured".to_owned(), points, style: SeriesStyle::LinePoints }];
        PlotSpec { title: "Cost".to_owned(), series, log_x: true, log_y: true, ..PlotSpec::default() }
    }

    #[test]
    fn plot_has_curve_text_and_generic_font() {
        let path = std::env::temp_dir().join(format!("supercoil_plot_{}.svg", std::process::id()));
        plot_lines(&path, &spec(vec![(1.0, 0.1), (10.0, 5.0), (100.0, f64::NAN), (1e3, 7e3)])).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
        assert!(text.contains("font-family=\"sans-serif\"") && text.contains("Cost") && text.contains("measured"));
        assert!(text.matches("<circle").count() >= 3 && text.contains("<polyline"));
    }

    #[test]
    fn nothing_to_draw_is_refused() {
        assert!(plot_lines(Path::new("/nowhere/a.svg"), &spec(vec![(-1.0, 1.0)])).is_err());
        assert!(plot_lines(Path::new("/nowhere/a.svg"), &spec(vec![(1.0, 1.0)])).is_err());
    }

    #[test]
    fn ticks_are_short() {
        assert_eq!([0.25, -3.0, 0.0, 1e-7, 1.5e6].map(tick), ["0.25", "-3", "0", "1e-7", "1.5e6"]);
    }
}
