//! Line plots as SVG and PDF.

use super::pdf::Page;
use super::text::font;
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
    /// Large dots, for emphasis.
    Marks,
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
    /// Size in pixels: width, height. Legal: 1 to 20000.
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

/// Units of the drawing per pixel, because the backend rounds to whole units, which would be visible in smooth curves.
const FINE: u32 = 8;

/// Most pixels a side.
const MAX_SIZE: u32 = 20_000;
/// Largest end of an axis, because ticks of larger ones overflow.
const FARTHEST: f64 = 1e300;

/// Draws a plot, replacing what is there: as PDF if the file's name ends in `.pdf`, else as SVG, whose text is DejaVu
/// Sans where the viewer has it, else the viewer's own sans-serif.
///
/// # Errors
/// [`InputError::Count`] for an illegal size, [`InputError::Inconsistent`] for a file of another kind, if no point can
/// be drawn or an axis would have to reach beyond 1e300, [`InputError::Write`] if the file cannot be written.
pub fn plot_lines(path: &Path, plot: &PlotSpec) -> Result<(), InputError> {
    for (field, value) in [("size.0", plot.size.0), ("size.1", plot.size.1)] {
        if !(1..=MAX_SIZE).contains(&value) {
            let allowed = "between 1 and 20000";
            return Err(InputError::Count { field: field.to_owned(), value: value as usize, allowed });
        }
    }
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    if ending != "pdf" && ending != "svg" {
        let reason = "is neither .svg nor .pdf: the file's ending says what is written".to_owned();
        return Err(InputError::Inconsistent { field: path.display().to_string(), reason });
    }
    let ranges = [range(plot, 0)?, range(plot, 1)?];
    let bytes = if ending == "pdf" { pdf(plot, ranges) } else { svg(plot, ranges) };
    let bytes = bytes.map_err(|reason| refuse(path, reason))?;
    std::fs::write(path, bytes).map_err(|e| refuse(path, e.to_string()))
}

fn pdf(plot: &PlotSpec, ranges: [Interval; 2]) -> Result<Vec<u8>, String> {
    let mut page = Page::new(plot.size, FINE)?;
    draw((&mut page).into_drawing_area(), plot, ranges)?;
    Ok(page.finish())
}

fn svg(plot: &PlotSpec, ranges: [Interval; 2]) -> Result<Vec<u8>, String> {
    let mut text = String::new();
    let backend = SVGBackend::with_string(&mut text, (FINE * plot.size.0, FINE * plot.size.1));
    draw(backend.into_drawing_area(), plot, ranges)?;
    // The drawing keeps its fine units in the view box; only the size it is shown at is that in pixels.
    let size = |scale: u32| format!("<svg width=\"{}\" height=\"{}\"", scale * plot.size.0, scale * plot.size.1);
    Ok(text.replacen(&size(FINE), &size(1), 1).into_bytes())
}

type Interval = std::ops::Range<f64>;

/// Draws a plot over its ranges of x and y.
fn draw<B: DrawingBackend>(area: DrawingArea<B, Shift>, plot: &PlotSpec, [x, y]: [Interval; 2]) -> Result<(), String> {
    let corner = free_corner(plot, [&x, &y]);
    match (plot.log_x, plot.log_y) {
        (false, false) => draw_over(&area, plot, corner, x, y),
        (true, false) => draw_over(&area, plot, corner, x.log_scale(), y),
        (false, true) => draw_over(&area, plot, corner, x, y.log_scale()),
        (true, true) => draw_over(&area, plot, corner, x.log_scale(), y.log_scale()),
    }?;
    area.present().map_err(|e| e.to_string())
}

fn refuse(path: &Path, reason: String) -> InputError {
    InputError::Write { path: path.to_owned(), reason }
}

/// Whether a point can be drawn on the plot's axes.
fn is_drawable(plot: &PlotSpec, (x, y): (f64, f64)) -> bool {
    x.is_finite() && y.is_finite() && (!plot.log_x || x > 0.0) && (!plot.log_y || y > 0.0)
}

/// Range of an axis (0: x, 1: y) with a little room at the ends.
fn range(plot: &PlotSpec, axis: usize) -> Result<Interval, InputError> {
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
    let range = if logarithmic { low.exp()..high.exp() } else { low..high };
    if range.start.abs().max(range.end.abs()) > FARTHEST {
        let reason = format!("values up to {:e}: more than an axis can show", range.start.abs().max(range.end.abs()));
        return Err(InputError::Inconsistent { field: "series".to_owned(), reason });
    }
    Ok(range)
}

/// Short label of a tick on an axis whose values reach up to `largest`; on a logarithmic axis only 1, 2 and 5 times a
/// power of ten have one.
fn tick(value: f64, is_log: bool, largest: f64) -> String {
    let mantissa = value / 10_f64.powf(value.log10().floor());
    if is_log && ![1.0, 2.0, 5.0, 10.0].iter().any(|m| (mantissa - m).abs() < 1e-6) {
        return String::new();
    }
    // ticks are sums of steps: a zero tick has a rounding error
    let value = if !is_log && value.abs() < 1e-9 * largest { 0.0 } else { value };
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{value:.1e}").replace(".0e", "e");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Draws axes, curves and legend.
fn draw_over<B, X, Y>(
    area: &DrawingArea<B, Shift>,
    plot: &PlotSpec,
    corner: SeriesLabelPosition,
    x: X,
    y: Y,
) -> Result<(), String>
where
    B: DrawingBackend,
    X: AsRangedCoord<Value = f64, CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>>,
    Y: AsRangedCoord<Value = f64, CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>>,
{
    let words = |e: DrawError<B>| e.to_string();
    let points = || plot.series.iter().flat_map(|s| &s.points);
    let largest_x = points().fold(0.0f64, |a, p| a.max(p.0.abs()));
    let largest_y = points().fold(0.0f64, |a, p| a.max(p.1.abs()));
    area.fill(&WHITE).map_err(words)?;
    let mut builder = ChartBuilder::on(area);
    builder.margin(14 * FINE).margin_right(24 * FINE).x_label_area_size(48 * FINE).y_label_area_size(72 * FINE);
    if !plot.title.is_empty() {
        builder.caption(&plot.title, font(20 * FINE));
    }
    let mut chart = builder.build_cartesian_2d(x, y).map_err(words)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12).stroke_width(FINE))
        .axis_style(BLACK.mix(0.6).stroke_width(FINE))
        .set_all_tick_mark_size(5 * FINE)
        .label_style(font(14 * FINE))
        .axis_desc_style(font(16 * FINE))
        .x_desc(&plot.x_label)
        .y_desc(&plot.y_label)
        .x_label_formatter(&|v| tick(*v, plot.log_x, largest_x))
        .y_label_formatter(&|v| tick(*v, plot.log_y, largest_y))
        .draw()
        .map_err(words)?;
    curves(&mut chart, plot).map_err(words)?;
    if plot.series.iter().any(|s| !s.name.is_empty()) { legend(&mut chart, corner).map_err(words) } else { Ok(()) }
}

/// Draws the legend.
fn legend<'a, B, X, Y>(
    chart: &mut ChartContext<'a, B, Cartesian2d<X, Y>>,
    corner: SeriesLabelPosition,
) -> Result<(), DrawError<B>>
where
    B: DrawingBackend + 'a,
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut legend = chart.configure_series_labels();
    legend
        .position(corner)
        .margin(10 * FINE)
        .legend_area_size(30 * FINE)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.2).stroke_width(FINE))
        .label_font(font(14 * FINE))
        .draw()
}

type DrawError<B> = DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>;

/// Draws the curves and prepares their legend entries.
fn curves<'a, B, X, Y>(chart: &mut ChartContext<'a, B, Cartesian2d<X, Y>>, plot: &PlotSpec) -> Result<(), DrawError<B>>
where
    B: DrawingBackend + 'a,
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    for (series, color) in plot.series.iter().zip(COLORS.iter().cycle()) {
        let stroke = color.stroke_width(2 * FINE);
        let pieces = series.points.split(|p| !is_drawable(plot, *p)).filter(|piece| !piece.is_empty());
        for (index, piece) in pieces.enumerate() {
            let points = piece.iter().copied();
            let drawn = match series.style {
                SeriesStyle::Line => chart.draw_series(LineSeries::new(points, stroke)),
                SeriesStyle::Dashed => chart.draw_series(DashedLineSeries::new(points, 7 * FINE, 5 * FINE, stroke)),
                SeriesStyle::Points => chart.draw_series(points.map(|p| Circle::new(p, 3 * FINE, color.filled()))),
                SeriesStyle::Marks => chart.draw_series(points.map(|p| Circle::new(p, 6 * FINE, color.filled()))),
                SeriesStyle::LinePoints => {
                    chart.draw_series(LineSeries::new(points.clone(), stroke))?;
                    chart.draw_series(points.map(|p| Circle::new(p, 3 * FINE, color.filled())))
                }
            };
            let shown = drawn?;
            if index == 0 && !series.name.is_empty() {
                let ([first, second], radius) = key(series.style);
                let line = move |[from, to]: [i32; 2]| {
                    PathElement::new(vec![(FINE as i32 * from, 0), (FINE as i32 * to, 0)], stroke)
                };
                shown.label(&series.name).legend(move |at| {
                    let dot = Circle::new((11 * FINE as i32, 0), radius * FINE as i32, color.filled());
                    EmptyElement::at(at) + line(first) + line(second) + dot
                });
            }
        }
    }
    Ok(())
}

/// Corner of the plot that holds the fewest points, for the legend.
fn free_corner(plot: &PlotSpec, ranges: [&Interval; 2]) -> SeriesLabelPosition {
    let share = |value: f64, range: &Interval, is_log: bool| {
        let place = |v: f64| if is_log { v.ln() } else { v };
        (place(value) - place(range.start)) / (place(range.end) - place(range.start))
    };
    let places: Vec<(f64, f64)> = (plot.series.iter().flat_map(|s| &s.points))
        .filter(|p| is_drawable(plot, **p))
        .map(|p| (share(p.0, ranges[0], plot.log_x), share(p.1, ranges[1], plot.log_y)))
        .collect();
    let corners = [
        (1.0, 1.0, SeriesLabelPosition::UpperRight),
        (0.0, 1.0, SeriesLabelPosition::UpperLeft),
        (1.0, 0.0, SeriesLabelPosition::LowerRight),
        (0.0, 0.0, SeriesLabelPosition::LowerLeft),
    ];
    let crowd = |x: f64, y: f64| places.iter().filter(|p| (p.0 - x).abs() < 0.3 && (p.1 - y).abs() < 0.3).count();
    let best = corners.into_iter().min_by_key(|(x, y, _)| crowd(*x, *y));
    best.map_or(SeriesLabelPosition::UpperRight, |(_, _, position)| position)
}

/// Legend sample of a style: ends of two strokes (one may be empty) and radius of a dot, in pixels.
fn key(style: SeriesStyle) -> ([[i32; 2]; 2], i32) {
    match style {
        SeriesStyle::Line => ([[0, 22], [22, 22]], 0),
        SeriesStyle::Dashed => ([[0, 8], [14, 22]], 0),
        SeriesStyle::Points => ([[11, 11], [11, 11]], 3),
        SeriesStyle::Marks => ([[11, 11], [11, 11]], 6),
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
    fn plot_has_curve_text_and_font_with_generic_family() {
        let path = std::env::temp_dir().join(format!("supercoil_plot_{}.svg", std::process::id()));
        plot_lines(&path, &spec(vec![(1.0, 0.1), (10.0, 5.0), (100.0, f64::NAN), (1e3, 7e3)])).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
        assert!(
            text.contains("font-family=\"DejaVu Sans, sans-serif\"")
                && text.contains("Cost")
                && text.contains("measured")
        );
        assert!(text.matches("<circle").count() >= 3 && text.contains("<polyline"));
    }

    #[test]
    fn a_pdf_has_all_shapes_of_the_svg() {
        let [text, svg] = ["pdf", "svg"].map(|ending| {
            let path = std::env::temp_dir().join(format!("supercoil_plot_{}_all.{ending}", std::process::id()));
            plot_lines(&path, &spec(vec![(1.0, 0.1), (10.0, 5.0), (1e3, 7e3)])).unwrap();
            let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
            std::fs::remove_file(&path).unwrap();
            text
        });
        assert!(text.starts_with("%PDF-1.") && text.trim_end().ends_with("%%EOF"));
        assert!(text.contains("0 0.44705883 0.69803923 RG\n16 w\n"), "the first colour, two pixels wide");
        assert_eq!(text.matches("\nS\n").count(), svg.matches("stroke=\"#").count());
    }

    #[test]
    fn nothing_to_draw_is_refused() {
        assert!(plot_lines(Path::new("/nowhere/a.svg"), &spec(vec![(-1.0, 1.0)])).is_err());
        assert!(plot_lines(Path::new("/nowhere/a.svg"), &spec(vec![(1.0, 1.0)])).is_err());
        let other = plot_lines(Path::new("a.png"), &spec(vec![(1.0, 1.0)])).unwrap_err().to_string();
        assert!(other.contains("neither .svg nor .pdf"), "{other}");
    }

    /// Symptom: values beyond 1e308 apart hung the drawing, large sizes panicked. Mechanism: the width of the axis, and
    /// the fine units of the drawing, overflow.
    #[test]
    fn what_overflows_is_refused() {
        let path = Path::new("/nowhere/a.svg");
        let of = |log_x: bool, x: [f64; 2], size: (u32, u32)| {
            let plot = PlotSpec { log_x, log_y: false, size, ..spec(x.map(|x| (x, 1.0)).to_vec()) };
            plot_lines(path, &plot).unwrap_err().to_string()
        };
        let size = PlotSpec::default().size;
        for (log_x, x) in [(false, [-1e308, 1.7e308]), (false, [1.7e308; 2]), (true, [5e-324, 1.7e308])] {
            assert!(of(log_x, x, size).starts_with("series: values up to"), "{}", of(log_x, x, size));
        }
        assert_eq!(of(false, [0.0, 1.0], (u32::MAX, 10)), "size.0 = 4294967295: must be between 1 and 20000");
        assert_eq!(of(false, [0.0, 1.0], (10, 0)), "size.1 = 0: must be between 1 and 20000");
    }

    #[test]
    fn ticks_are_short() {
        assert_eq!([0.25, -3.0, 0.0, 1e-7, 1.5e6].map(|v| tick(v, false, 3.0)), ["0.25", "-3", "0", "1e-7", "1.5e6"]);
        assert_eq!([0.001, 3.0, 50.0].map(|v| tick(v, true, 50.0)), ["0.001", "", "50"]);
        assert_eq!(tick(-2.2e-16, false, 1.8), "0");
    }
}
