//! The command line: `supercoil run FILE --out DIR` and `supercoil check FILE`.
//!
//! Exit codes: 0 converged, 1 ran but did not converge, 2 bad input.
#![allow(clippy::print_stderr)] // a program talks to its user

use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use supercoil::InputError;
use supercoil::io::run::{Outcome, run_scene};
use supercoil::io::table::StepTable;
use supercoil::scene::Scene;
use supercoil::solve::{RunError, Status};

const CONVERGED: u8 = 0;
const NOT_CONVERGED: u8 = 1;
const BAD_INPUT: u8 = 2;

/// Equilibria of elastic rods that touch themselves and each other.
#[derive(Parser)]
#[command(version, after_help = "Exit codes: 0 converged, 1 ran but did not converge, 2 bad input.")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene file and write its outputs.
    Run {
        /// Scene file (TOML).
        file: PathBuf,
        /// Folder for the outputs [default: output.dir of the scene, or out/NAME].
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Threads; results do not depend on it [default: solver.threads of the scene, or all].
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
        threads: Option<u16>,
        /// Print nothing but errors.
        #[arg(long)]
        quiet: bool,
    },
    /// Check a scene file without running it.
    Check {
        /// Scene file (TOML).
        file: PathBuf,
    },
}

fn main() -> ExitCode {
    let code = match Arguments::parse().command {
        Command::Check { file } => check(&file),
        Command::Run { file, out, threads, quiet } => run(&file, out, threads, quiet),
    };
    ExitCode::from(code)
}

/// Prints a line; a reader that has gone away (`supercoil check FILE | head`) is no failure.
fn say(line: std::fmt::Arguments) {
    std::io::stdout().write_fmt(format_args!("{line}\n")).ok();
}

fn refuse(error: &InputError) -> u8 {
    eprintln!("error: {error}");
    BAD_INPUT
}

fn check(file: &Path) -> u8 {
    let scene = match Scene::read(file) {
        Ok(scene) => scene,
        Err(error) => return refuse(&error),
    };
    say(format_args!("{}: {}", file.display(), if scene.title.is_empty() { "no title" } else { &scene.title }));
    for rod in &scene.model.rods {
        let (kind, unit) = (if rod.closed { "closed" } else { "open" }, &scene.units.length);
        let (name, elements, order, length) = (&rod.name, rod.num_elements, rod.order, rod.length);
        say(format_args!("  rod {name}: {kind}, length {length} {unit}, {elements} elements of order {order}"));
    }
    let steps: usize = scene.stages.iter().map(|stage| stage.steps).sum();
    let (supports, stages) = (scene.model.supports.len(), scene.stages.len());
    say(format_args!("  {supports} supports, {stages} stages of {steps} steps in all; nothing to object"));
    CONVERGED
}

fn run(file: &Path, out: Option<PathBuf>, threads: Option<u16>, quiet: bool) -> u8 {
    let mut scene = match Scene::read(file) {
        Ok(scene) => scene,
        Err(error) => return refuse(&error),
    };
    scene.solver.threads = threads.map(usize::from).or(scene.solver.threads);
    let default = || Path::new("out").join(file.file_stem().unwrap_or_default());
    let dir = out.or_else(|| scene.output.dir.clone()).unwrap_or_else(default);
    let units = scene.units.clone();
    if !quiet && !scene.title.is_empty() {
        say(format_args!("{}", scene.title));
    }
    let bar = if quiet { ProgressBar::hidden() } else { bar() };
    let num_stages = scene.stages.len().max(1) as f64;
    let result = run_scene(scene, &dir, &mut |step| {
        bar.set_position((1000.0 * (step.stage as f64 + step.fraction) / num_stages) as u64);
        bar.set_message(format!("{} contact sites, {} iterations", step.sites.len(), step.iterations));
        ControlFlow::Continue(())
    });
    bar.finish_and_clear();
    match result {
        Ok(outcome) => report(&outcome, &units, &dir, quiet),
        Err(RunError::Input(error)) => refuse(&error),
        Err(error) => {
            eprintln!("error: {error}; what was reached is in {}", dir.display());
            NOT_CONVERGED
        }
    }
}

fn report(outcome: &Outcome, units: &supercoil::scene::file::Units, dir: &Path, quiet: bool) -> u8 {
    if !quiet {
        say(format_args!("{}", StepTable { units, steps: &outcome.steps }));
        say(format_args!("{} after {:.1} s; files are in {}", outcome.status, outcome.seconds, dir.display()));
    }
    if outcome.status == Status::Converged {
        return CONVERGED;
    }
    eprintln!("not converged: {}", outcome.status);
    NOT_CONVERGED
}

fn bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {elapsed}  {msg}");
    ProgressBar::new(1000).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
