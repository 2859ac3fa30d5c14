//! `writhe.svg`: writhe and twist against excess link.

use crate::error::InputError;
use crate::io::picture::{PlotSpec, Series, SeriesStyle, plot_lines};
use crate::io::plot_run::with_jumps;
use crate::io::record::run::{RecordedFrame, RecordedRun};
use crate::io::record::{Writer, files};

#[derive(Debug)]
pub(in crate::io::record) struct WrithePlotWriter;

impl Writer for WrithePlotWriter {
    fn last(&mut self, run: &RecordedRun, _: &RecordedFrame) -> Result<(), InputError> {
        if !run.output.picture {
            return Ok(());
        }
        let Some(rod) = rod_with_changing_link(run) else { return Ok(()) };
        let links = || run.steps.iter().flat_map(|step| &step.links).filter(|link| link.rod == rod);
        let writhe: Vec<(f64, f64)> = links().map(|link| (link.excess_link, link.writhe)).collect();
        let twist: Vec<(f64, f64)> = links().map(|link| (link.excess_link, link.twist)).collect();
        let snapped: Vec<bool> = run.steps.iter().map(|step| step.energy_released > 0.0).collect();
        let ((writhe, mut jumps), (twist, more)) = (with_jumps(&writhe, &snapped), with_jumps(&twist, &snapped));
        jumps.extend(more);
        let series = |name: &str, points: Vec<(f64, f64)>, style| Series { name: name.to_owned(), points, style };
        let plot = PlotSpec {
            title: run.title.clone(),
            x_label: "excess link ΔLk, turns".to_owned(),
            y_label: "turns".to_owned(),
            series: vec![
                series("writhe", writhe, SeriesStyle::LinePoints),
                series("twist", twist, SeriesStyle::LinePoints),
            ],
            ..PlotSpec::default()
        };
        let snaps = (!jumps.is_empty()).then(|| series("snap", jumps, SeriesStyle::Dashed));
        let plot = PlotSpec { series: plot.series.into_iter().chain(snaps).collect(), ..plot };
        plot_lines(&run.dir.join(files::WRITHE), &plot)
    }
}

/// The first rod whose excess link is not the same in all steps.
fn rod_with_changing_link(run: &RecordedRun) -> Option<usize> {
    let links = || run.steps.iter().flat_map(|step| &step.links);
    let start = |rod: usize| links().find(|link| link.rod == rod).map(|link| link.excess_link);
    links().find(|link| start(link.rod) != Some(link.excess_link)).map(|link| link.rod)
}
