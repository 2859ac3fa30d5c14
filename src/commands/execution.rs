//! How `run` and `resume` execute a scene: progress, interrupts, results.

use std::path::Path;
use std::time::Duration;

use clap::Args;
use console::Term;
use supercoil::InputError;
use supercoil::dna;
use supercoil::io::run::{Outcome, SceneRun};
use supercoil::io::table::StepTable;
use supercoil::observe::ending;
use supercoil::scene::Units;
use supercoil::scene::file::MOST_THREADS;
use supercoil::solve::{RunError, Status};

use super::print::say;
use super::progress::{Bar, terminal_width};
use super::signals::stop_on_signal;
use super::{CHECK_FAILS, CONVERGED, INTERRUPTED, NOT_CONVERGED, OVERLAPS, seconds};

#[derive(Args)]
pub struct Choices {
    /// Threads; results do not depend on it [default: solver.threads of the scene, or all].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS as i64))]
    threads: Option<u16>,
    /// Write a checkpoint every so many accepted steps
    /// [default: output.checkpoint_steps of the scene, or by time only].
    #[arg(long, value_name = "STEPS", value_parser = clap::value_parser!(u32).range(1..))]
    checkpoint_every: Option<u32>,
    /// Write a checkpoint when the last is so many seconds old
    /// [default: output.checkpoint_seconds of the scene, or 60].
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    checkpoint_seconds: Option<f64>,
    /// Estimate the error of the final state, by settling it again on twice the elements and under a harder contact
    /// law.
    #[arg(long)]
    error_estimate: bool,
    /// Find that many of the softest modes of the final state.
    #[arg(long, value_name = "N")]
    modes: Option<usize>,
    /// Stop after so many seconds, as Ctrl-C does: with all files in order, to be resumed.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    time_limit: Option<f64>,
    /// Print nothing but errors.
    #[arg(long)]
    pub quiet: bool,
}

/// Runs a scene from its start or, with `from` (stage, fraction), from the checkpoint in its folder.
pub fn execute(mut run: SceneRun, from: Option<(usize, f64)>, choices: &Choices) -> Result<u8, InputError> {
    let scene = &mut run.scene;
    scene.solver.threads = choices.threads.map(usize::from).or(scene.solver.threads);
    let output = &mut scene.output;
    output.checkpoint_steps = choices.checkpoint_every.map(|n| n as usize).or(output.checkpoint_steps);
    output.error_estimate |= choices.error_estimate;
    output.modes = choices.modes.unwrap_or(output.modes);
    output.checkpoint_seconds = choices.checkpoint_seconds.unwrap_or(output.checkpoint_seconds);
    let (units, thermal) = (scene.units.clone(), scene.thermal());
    let bar = Bar::new(&scene.stages, from, choices.quiet);
    let dir = run.dir.clone();
    let shown = bar.clone();
    stop_on_signal(run.interrupt.clone(), move |line| shown.note(line));
    let interrupt = run.interrupt.clone();
    // a limit beyond the range of Duration is none
    if let Some(limit) = choices.time_limit.and_then(|s| Duration::try_from_secs_f64(s).ok()) {
        let (interrupt, shown) = (interrupt.clone(), bar.clone());
        std::thread::spawn(move || {
            std::thread::sleep(limit);
            interrupt.raise();
            shown.note("time limit reached: stopping");
        });
    }
    let mut watch = |step: &_| bar.step(step);
    let result = if from.is_some() { run.resume(&mut watch) } else { run.start(&mut watch) };
    bar.clear();
    match result {
        Ok(outcome) => {
            if !choices.quiet {
                print_results(&outcome, &units, thermal, &dir);
            }
            Ok(report_status(&outcome, &dir, interrupt.is_raised()))
        }
        Err(RunError::Input(error)) => Err(error),
        Err(error) => {
            eprintln!("error: {error}; what was reached is in {}", dir.display());
            Ok(NOT_CONVERGED)
        }
    }
}

fn print_results(outcome: &Outcome, units: &Units, thermal: Option<(f64, f64)>, dir: &Path) {
    let table = StepTable { units, steps: &outcome.steps };
    match terminal_width(&Term::stdout()) {
        Some(width) => say(format_args!("{}", table.within(width))),
        None => say(format_args!("{table}")),
    }
    if let (Some((temperature, unit)), Some(last)) = (thermal, outcome.steps.last()) {
        let (total, in_kt) = (last.energies.total, last.energies.over(unit).total);
        let stiff = if temperature == dna::TEMPERATURE {
            String::new()
        } else {
            format!("; constants of DNA are those at {} K, where kT is {} pN nm", dna::TEMPERATURE, dna::THERMAL_ENERGY)
        };
        say(format_args!("energy {total:.4} pN nm, {in_kt:.4} kT at {temperature} K{stiff}"));
    }
    if let Some(estimate) = &outcome.error_estimate {
        say(format_args!("{}", estimate.in_units(units)));
    }
    let answers = outcome.answers.to_string();
    if !answers.is_empty() {
        say(format_args!("{}", answers.trim_end()));
    }
    if let Some(last) = outcome.steps.last().filter(|_| outcome.status == Status::Converged) {
        say(format_args!("{}", last.certificate));
    }
    let status = ending(outcome.status, outcome.steps.last());
    say(format_args!("{status} after {:.1} s; files are in {}", outcome.seconds, dir.display()));
}

/// Explains a run that did not converge; returns the exit code.
fn report_status(outcome: &Outcome, dir: &Path, interrupted: bool) -> u8 {
    if outcome.overlaps() {
        let notes = outcome.steps.last().map_or_else(String::new, |last| last.notes.join("; "));
        eprintln!("overlap: {notes}");
        return OVERLAPS;
    }
    if outcome.status == Status::Converged {
        let Some(last) = outcome.steps.last().filter(|last| last.fails()) else { return CONVERGED };
        eprintln!("{}", last.certificate);
        return CHECK_FAILS;
    }
    if interrupted && outcome.status == Status::Stopped {
        match outcome.checkpoint {
            Some(_) => eprintln!("stopped; to go on: supercoil resume {}", dir.display()),
            None => eprintln!("stopped before the initial state converged: there is nothing to resume from"),
        }
        return INTERRUPTED;
    }
    eprintln!("not converged: {}", outcome.status);
    if let Some(failure) = &outcome.failure {
        eprintln!("{failure}");
    }
    NOT_CONVERGED
}
