//! `supercoil sweep`: plan, run, status, collect, plot.

use std::path::{Path, PathBuf};

use clap::Subcommand;
use indicatif::ProgressBar;
use supercoil::InputError;
use supercoil::io::csv::{Cell, write_table};
use supercoil::io::sweep::{
    Collected, ColumnValues, Plan, PlotAxes, Shard, SweepRun, SweepTable, Tally, collect, plot, ranges, status,
};

use super::print::say;
use super::progress::bar_style;
use super::signals::stop_on_signal;
use super::{CONVERGED, INTERRUPTED, NOT_CONVERGED, seconds};

/// A sweep file with all its keys.
pub const SWEEP_FILE: &str = r#"A sweep file:

  scene = "minicircle.toml"              # the base scene, relative to this file
  rows = "last"                          # a row a case; "all" (default): a row each accepted step

  [set]                                  # shared by all cases; keys are those of `run --set`
  "rods.dna.elements" = 24

  [axes]                                 # every combination
  "rods.dna.dna.salt_mM" = [20, 50, 150]
  "stages.0.ramp.sigma.to" = { from = -0.08, to = -0.02, count = 7 }

  [[linked]]                             # these go together, first with first
  "rods.dna.dna.base_pairs" = [200, 336]
  "stages.0.steps" = [10, 20]

  [random]                               # every combination with each of the draws
  seed = 1
  draws = 100
  [random.keys]                          # uniform = [low, high], normal = [mean, deviation], whole = [low, high],
  "rods.dna.dna.bending_persistence" = { normal = [50.0, 3.0] }          # choice = [...] or bases = N (letters ACGT)"#;

#[derive(Subcommand)]
pub enum SweepCommand {
    /// Make the cases of a sweep file and write them, a line a case, into a folder. Planning again with more values
    /// keeps the rows of earlier cases.
    #[command(after_long_help = SWEEP_FILE)]
    Plan {
        /// Sweep file (TOML): a base scene and its axes.
        file: PathBuf,
        /// Folder of the sweep [default: out/NAME].
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Run the cases that have no rows yet. Failed cases are rows, too. Exit code 0: no case of the shard is left; 130:
    /// stopped before.
    Run {
        /// Folder of the sweep.
        dir: PathBuf,
        /// Only shard i of n, i from 0: case k belongs to shard k modulo n.
        #[arg(long, value_name = "I/N", value_parser = Shard::parse, default_value = "0/1")]
        shard: Shard,
        /// Cases side by side, each on one thread [default: one a core].
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
        jobs: Option<u16>,
        /// Stop after so many seconds; the cases at work are left for the next run.
        #[arg(long, value_name = "T", value_parser = seconds)]
        max_seconds: Option<f64>,
        /// Write finished cases every so many seconds; a run that is killed loses at most those since.
        #[arg(long, value_name = "T", value_parser = seconds, default_value_t = SweepRun::default().part_seconds)]
        part_seconds: f64,
        /// Print nothing but errors.
        #[arg(long)]
        quiet: bool,
    },
    /// Tell how many cases are done, failed and missing. Exit code 0: none is missing; 1: some are.
    Status {
        /// Folder of the sweep.
        dir: PathBuf,
        /// Print only the shards, of so many, that miss cases, as a list for `sbatch --array`.
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
        missing_of: Option<u32>,
    },
    /// Put all rows together in DIR/table.parquet. Exit code 0: no case is missing; 1: some are.
    Collect {
        /// Folder of the sweep.
        dir: PathBuf,
        /// Write them as CSV, too.
        #[arg(long, value_name = "FILE")]
        csv: Option<PathBuf>,
    },
    /// Collect, and draw a column over another as SVG or PDF.
    Plot {
        /// Folder of the sweep.
        dir: PathBuf,
        /// Column along the horizontal axis: a key of the axes, or a column of a run's table.
        #[arg(short, value_name = "COLUMN")]
        x: String,
        /// Column along the vertical axis.
        #[arg(short, value_name = "COLUMN")]
        y: String,
        /// A curve for each value of this column.
        #[arg(long, value_name = "COLUMN")]
        by: Option<String>,
        /// Draw all steps, not the last of each case alone.
        #[arg(long)]
        steps: bool,
        /// File to write, *.svg or *.pdf [default: DIR/Y.svg].
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
}

impl SweepCommand {
    pub fn go(self) -> Result<u8, InputError> {
        match self {
            Self::Plan { file, out } => plan(&file, out),
            Self::Run { dir, shard, jobs, max_seconds, part_seconds, quiet } => {
                let default = SweepRun::default();
                let jobs = jobs.map_or(default.jobs, usize::from);
                run(&dir, &SweepRun { shard, jobs, max_seconds, part_seconds, ..default }, quiet)
            }
            Self::Status { dir, missing_of } => tell(&dir, missing_of),
            Self::Collect { dir, csv } => gather(&dir, csv.as_deref()),
            Self::Plot { dir, x, y, by, steps, out } => {
                let out = out.unwrap_or_else(|| dir.join(format!("{y}.svg")));
                plot(&out, &collect(&dir)?.table, &PlotAxes { x, y, by, steps })?;
                say(format_args!("{}", out.display()));
                Ok(CONVERGED)
            }
        }
    }
}

fn plan(file: &Path, out: Option<PathBuf>) -> Result<u8, InputError> {
    let dir = out.unwrap_or_else(|| Path::new("out").join(file.file_stem().unwrap_or_default()));
    let plan = Plan::of_file(file)?;
    // an error in a key is reported now, not in ten thousand cases
    if let Some(case) = plan.cases().first() {
        plan.scene(case)?;
    }
    plan.write(&dir)?;
    say(format_args!("{} cases; to run them: supercoil sweep run {}", plan.cases().len(), dir.display()));
    Ok(CONVERGED)
}

fn run(dir: &Path, run: &SweepRun, quiet: bool) -> Result<u8, InputError> {
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(0) };
    bar.set_style(bar_style(
        "{bar:30} {pos} of {len} cases  {elapsed} spent, about {eta} left  {msg}",
        "{pos} of {len}  {eta:>4} left {wide_bar}",
    ));
    let shown = bar.clone();
    stop_on_signal(run.interrupt.clone(), move |line| shown.suspend(|| eprintln!("{line}")));
    let started = std::time::Instant::now();
    let tally = run.go(dir, &mut |tally: &Tally| {
        bar.set_length((tally.cases - tally.before) as u64);
        bar.set_position(tally.done as u64);
        if tally.failed > 0 {
            bar.set_message(format!("{} did not converge", tally.failed));
        }
    });
    bar.finish_and_clear();
    let tally = tally?;
    let (done, seconds) = (tally.done, started.elapsed().as_secs_f64());
    if !quiet {
        let rate = done as f64 / seconds.max(1e-3);
        let Tally { before, failed, .. } = tally;
        let missing = tally.missing();
        say(format_args!(
            "{done} cases in {seconds:.1} s ({rate:.2} a second), {failed} of them did not converge; {before} were \
             there, {missing} are left"
        ));
    }
    Ok(if tally.missing() == 0 { CONVERGED } else { INTERRUPTED })
}

fn tell(dir: &Path, missing_of: Option<u32>) -> Result<u8, InputError> {
    let status = status(dir)?;
    match missing_of {
        Some(count) => say(format_args!("{}", ranges(&status.missing_shards(count as usize)))),
        None => {
            say(format_args!("{status}"));
            if !status.missing.is_empty() {
                say(format_args!("missing cases: {}", ranges(&status.missing)));
            }
        }
    }
    Ok(if status.missing.is_empty() { CONVERGED } else { NOT_CONVERGED })
}

fn gather(dir: &Path, csv: Option<&Path>) -> Result<u8, InputError> {
    let Collected { table, missing } = collect(dir)?;
    if let Some(path) = csv {
        write_csv(path, &table)?;
    }
    let (rows, columns) = (table.num_rows(), table.columns().len());
    say(format_args!("{rows} rows of {columns} columns in {}", dir.join("table.parquet").display()));
    if missing.is_empty() {
        return Ok(CONVERGED);
    }
    eprintln!("{} cases are missing: supercoil sweep status {}", missing.len(), dir.display());
    Ok(NOT_CONVERGED)
}

fn write_csv(path: &Path, table: &SweepTable) -> Result<(), InputError> {
    let names: Vec<&str> = table.columns().iter().map(|column| column.name.as_str()).collect();
    let cell = |values: &ColumnValues, row: usize| Cell::Text(values.text(row).unwrap_or_default());
    let row = |row: usize| table.columns().iter().map(|column| cell(&column.values, row)).collect::<Vec<_>>();
    write_table(path, &names, (0..table.num_rows()).map(row))
}
