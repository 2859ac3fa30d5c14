//! The film of a finished run, from its files.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::error::InputError;
use crate::io::detail::{BLOCK, within};
use crate::io::plot_run::RunTable;
use crate::io::record::{RodHead, VIEW, placements, read_summary, step_of};
use crate::io::vtk::{VtkData, read_vtp};
use crate::math::Vec3;
use crate::observe::report::Observation;
use crate::scene::{Obstacle, Units};

use super::{Film, FilmRod, FilmTable, Frame, FrameRod, Plot};

/// Largest number of nodes of a page, all frames together: at 36 bytes each, and 4/3 of that as text, 29 MB.
pub const MAX_NODES: usize = 600_000;
/// Fewest frames that are kept before nodes are left out.
const MIN_FRAMES: usize = 12;
/// First tolerance for nodes that are left out, in radii from the drawn line: invisible. It is doubled until few enough
/// nodes are left.
const TOLERANCE: f64 = 0.01;

/// The part of `summary.json` for a film.
#[derive(Deserialize)]
struct FilmSummary {
    title: String,
    units: Units,
    rods: Vec<RodHead>,
    #[serde(default)]
    obstacles: Vec<Obstacle>,
    steps: Vec<Observation>,
}

/// The film of the run in the folder `dir`: all steps with a VTK file, and the numbers of `table.csv` that change.
///
/// More than `max_nodes` nodes (all frames together) are reduced. First every other step is left out until 12 are left,
/// the last one always included. Then nodes within a tolerance of the line through the others are left out: a hundredth
/// of the radius, doubled until few enough nodes are left. The film's note states this. No stripe is drawn then,
/// because it may rotate by more than half a turn between nodes.
///
/// # Errors
/// [`InputError::File`] or [`InputError::Parse`] if a file is missing or damaged (a run under way has no summary yet),
/// [`InputError::Inconsistent`] if there are no VTK files.
pub fn of_run(dir: &Path, max_nodes: usize) -> Result<Film, InputError> {
    let FilmSummary { title, units, rods, obstacles, steps } = read_summary(dir)?;
    film(dir, &Parts { title: &title, units: &units, rods: &rods, obstacles: &obstacles, steps: &steps }, max_nodes)
}

/// Writes `view.html` into the folder of a run, as the run itself does: [`Film::page`] of [`of_run`] with at most
/// [`MAX_NODES`] nodes. Returns its path.
///
/// # Errors
/// As there; [`InputError::Write`] if it cannot be written.
pub fn write_page(dir: &Path) -> Result<PathBuf, InputError> {
    let path = dir.join(VIEW);
    of_run(dir, MAX_NODES)?.save_page(&path)?;
    Ok(path)
}

/// Data of a run other than its VTK files.
pub(in crate::io) struct Parts<'a> {
    pub title: &'a str,
    pub units: &'a Units,
    pub rods: &'a [RodHead],
    pub obstacles: &'a [Obstacle],
    pub steps: &'a [Observation],
}

/// [`of_run`] with a given summary; `table.csv` must be written.
pub(in crate::io) fn film(dir: &Path, run: &Parts, max_nodes: usize) -> Result<Film, InputError> {
    let files = step_files(dir, run.steps.len())?;
    let Some((_, first)) = files.first() else {
        let reason = "holds no step_….vtp files: they are what is shown (output.vtk = true)".to_owned();
        return Err(InputError::Inconsistent { field: dir.display().to_string(), reason });
    };
    let num_nodes: usize = read_vtp(first)?.iter().map(|rod| rod.points.len()).sum();
    let (stride, last) = (stride(files.len(), max_nodes / num_nodes.max(1)), files.len() - 1);
    let shown = files.iter().enumerate().filter(|(k, _)| (last - k).is_multiple_of(stride));
    let share = max_nodes as f64 / (shown.clone().count() * num_nodes).max(1) as f64;
    let (mut frames, mut tolerance) = (Vec::new(), 0.0_f64);
    for (_, (step, path)) in shown {
        let observation = &run.steps[*step];
        let placements = placements(observation);
        let mut frame = Frame { step: *step, rods: Vec::new(), forces: forces(observation), placements };
        for (index, data) in in_order(read_vtp(path)?, run.rods.len()).into_iter().enumerate() {
            let link = observation.links.iter().find(|link| link.rod == index);
            let (rod, left_out) = thinned(data, share, run.rods[index].radius());
            tolerance = tolerance.max(left_out);
            frame.rods.push(FrameRod { seam_turns: link.map_or(0.0, |link| link.link), ..rod });
        }
        frames.push(frame);
    }
    let certificate = run.steps.last().map_or_else(String::new, |last| format!("At the end {}.", last.certificate));
    let reduced = note(&frames, files.len(), num_nodes, tolerance, run.units);
    let note = [certificate, reduced].join(" ").trim().to_owned();
    let head = |head: &RodHead| FilmRod { name: head.name.clone(), closed: head.closed };
    let (table, plots) = table(dir)?;
    let (title, units, obstacles) = (run.title.to_owned(), run.units.clone(), run.obstacles.to_vec());
    Ok(Film { title, units, rods: run.rods.iter().map(head).collect(), obstacles, frames, table, plots, note })
}

/// Steps with a VTK file, in order. Files of steps that are not in the summary are of another run and skipped.
fn step_files(dir: &Path, num_steps: usize) -> Result<Vec<(usize, PathBuf)>, InputError> {
    let refuse = |e: std::io::Error| InputError::File { path: dir.to_owned(), reason: e.to_string() };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(dir).map_err(refuse)? {
        let path = entry.map_err(refuse)?.path();
        let step = path.file_name().and_then(|name| name.to_str()).and_then(step_of);
        files.extend(step.filter(|&step| step < num_steps).map(|step| (step, path)));
    }
    files.sort();
    Ok(files)
}

/// Number of steps from one shown step to the next: a power of two that leaves at most `affordable` steps, but at least
/// 12.
fn stride(steps: usize, affordable: usize) -> usize {
    let enough = affordable.max(MIN_FRAMES);
    let mut stride = 1;
    while steps.div_ceil(stride) > enough {
        stride *= 2;
    }
    stride
}

/// Rods in the scene's order; rods without points are not in the file.
fn in_order(data: Vec<VtkData>, count: usize) -> Vec<VtkData> {
    let mut rods = vec![VtkData::default(); count];
    data.into_iter().for_each(|rod| {
        if let Some(place) = rods.get_mut(rod.rod) {
            *place = rod;
        }
    });
    rods
}

/// A rod with at most `share` of its nodes, drawn with `radius` if its file has none, and the distance from the line
/// drawn within which nodes were left out.
fn thinned(data: VtkData, share: f64, radius: f64) -> (FrameRod, f64) {
    let one = vec![radius];
    let radii = data.scalars.get("radius").filter(|radii| !radii.is_empty()).unwrap_or(&one);
    let is_uniform = radii.iter().all(|other| *other == radii[0]);
    let thinnest = radii.iter().copied().fold(f64::INFINITY, f64::min);
    let num = data.points.len();
    // `within` keeps the ends of its blocks in any case
    let most = ((share * num as f64) as usize).max(num.div_ceil(BLOCK) + 1);
    let (mut tolerance, mut kept) = (0.0, (0..num).collect::<Vec<_>>());
    while kept.len() > most {
        tolerance = if tolerance > 0.0 { 2.0 * tolerance } else { TOLERANCE * thinnest };
        kept = within(&data.points, tolerance, usize::MAX);
    }
    let empty = Vec::new();
    let numbers = |name: &str| data.scalars.get(name).unwrap_or(&empty);
    let none = Vec::new();
    let vectors = |name: &str| data.vectors.get(name).unwrap_or(&none);
    let (curvature, twist_rate) = (numbers("curvature"), numbers("twist_rate"));
    let force = vectors("smoothed_contact_force_per_length");
    let rod = FrameRod {
        points: kept.iter().map(|&i| data.points[i]).collect(),
        directions: if tolerance > 0.0 {
            vec![Vec3::zeros(); kept.len()]
        } else {
            kept.iter().filter_map(|&i| vectors("d1").get(i).copied()).collect()
        },
        pressure: kept.iter().filter_map(|&i| force.get(i).map(Vec3::norm)).collect(),
        curvature: kept.iter().filter_map(|&i| curvature.get(i).copied()).collect(),
        twist_rate: kept.iter().filter_map(|&i| twist_rate.get(i).copied()).collect(),
        radii: if is_uniform { vec![radii[0]] } else { kept.iter().filter_map(|&i| radii.get(i).copied()).collect() },
        seam_turns: 0.0,
    };
    (rod, tolerance)
}

/// Forces on both strands of each contact site.
fn forces(step: &Observation) -> Vec<[Vec3; 2]> {
    let of = |site: &crate::observe::report::SiteReport| {
        let (force, feet) = (Vec3::from(site.force_on_a), site.feet.map(Vec3::from));
        [[feet[0], force], [feet[1], -force]]
    };
    let on_obstacle = |site: &crate::observe::report::ObstacleSite| [site.nearest, site.force_on_rod].map(Vec3::from);
    step.sites.iter().flat_map(of).chain(step.obstacle_sites.iter().map(on_obstacle)).collect()
}

/// Note on reduced steps and nodes.
fn note(frames: &[Frame], steps: usize, nodes: usize, tolerance: f64, units: &Units) -> String {
    let mut notes = Vec::new();
    if frames.len() < steps {
        notes.push(format!("{} of {steps} steps are shown.", frames.len()));
    }
    if tolerance > 0.0 {
        let most = frames.iter().map(|frame| frame.rods.iter().map(|rod| rod.points.len()).sum::<usize>()).max();
        let (most, unit) = (most.unwrap_or(0), &units.length);
        let tolerance =
            if (1e-3..1e4).contains(&tolerance) { format!("{tolerance:.4}") } else { format!("{tolerance:.2e}") };
        notes.push(format!(
            "{most} of {nodes} nodes are shown; those left out lie within {tolerance} {unit} of the line through the \
             others."
        ));
    }
    notes.join(" ")
}

/// Columns of `table.csv` that tell a reader of the page nothing beside the others.
const NOT_SHOWN: [&str; 6] =
    ["stage", "fraction", "penetration", "contact_resultants", "iterations_on_other_meshes", "seconds"];
/// What is plotted, by the endings of the columns' names, each group in a plot of its own: what DNA, tweezers, cables
/// and beams are looked at for.
const PLOTS: [&[&str]; 6] = [
    &["writhe", "twist"],
    &["extension"],
    &["torque", "seam_moment"],
    &["bending_energy", "twisting_energy"],
    &["contact_force"],
    &["force_x", "force_y", "force_z"],
];
/// Most plots beside the table.
const MOST_PLOTS: usize = 5;

/// The numbers of `table.csv` that change from step to step (of a single step, those that are not zero), and plots of
/// them against what the last stage changes.
fn table(dir: &Path) -> Result<(FilmTable, Vec<Plot>), InputError> {
    let run = RunTable::read(dir)?;
    let is_told = |name: &str, values: &[f64]| match values {
        [only] => *only != 0.0 && only.is_finite(),
        _ => varies(values) || name == "step",
    };
    let shown = run.columns.iter().filter(|name| !NOT_SHOWN.contains(&name.as_str()));
    let shown: Vec<(&String, Vec<f64>)> = shown
        .filter_map(|name| Some((name, run.numbers(name).ok()?)))
        .filter(|(name, values)| is_told(name, values))
        .collect();
    let last_stage = last_stage(&run);
    let is_prescribed =
        |(name, values): &(&String, Vec<f64>)| run.is_prescribed(name) && varies(&values[last_stage.clone()]);
    let x = shown.iter().position(is_prescribed).unwrap_or(0);
    let ends_in = |endings: &[&str]| -> Vec<usize> {
        let is_of = |name: &str| endings.iter().any(|ending| name == *ending || name.ends_with(&format!("_{ending}")));
        let is_excess = |name: &str| name.contains("excess");
        (0..shown.len()).filter(|&k| k != x && is_of(shown[k].0) && !is_excess(shown[k].0)).collect()
    };
    let plots = PLOTS.iter().map(|endings| Plot { x, y: ends_in(endings) }).filter(|plot| !plot.y.is_empty());
    let plots = plots.take(MOST_PLOTS).collect();
    let unit = |name: &String| run.units.get(name).cloned().unwrap_or_default();
    let rows = (0..run.num_rows()).map(|row| shown.iter().map(|(_, values)| values[row]).collect()).collect();
    let columns = shown.iter().map(|(name, _)| ((*name).clone(), unit(name))).collect();
    Ok((FilmTable { columns, rows }, plots))
}

/// Change of a column, over its largest number, that is more than rounding.
const CHANGE: f64 = 1e-9;

/// Whether a column's numbers change; becoming blank is a change, too.
fn varies(values: &[f64]) -> bool {
    let largest = values.iter().filter(|x| x.is_finite()).fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let differ = |a: f64, b: f64| (a - b).abs() > CHANGE * largest || a.is_finite() != b.is_finite();
    values.windows(2).any(|pair| differ(pair[0], pair[1]))
}

/// Rows of the last stage, with the state that it begins at.
fn last_stage(run: &RunTable) -> std::ops::Range<usize> {
    let stages = run.numbers("stage").unwrap_or_default();
    let last = stages.last().copied().unwrap_or(0.0);
    let first = stages.iter().position(|stage| *stage == last).unwrap_or(0);
    first.saturating_sub(1)..run.num_rows()
}
