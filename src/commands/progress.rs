//! Progress of the command line: the fraction done and the time left. A bar on a terminal; a line every half minute if
//! standard error is a file or a pipe.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use console::Term;
use indicatif::{ProgressBar, ProgressStyle};
use supercoil::observe::report::Observation;
use supercoil::scene::Stage;

/// Time between two lines without a terminal: few lines in a log, yet a sign of life.
const HEARTBEAT: Duration = Duration::from_secs(30);

/// Ticks of the bar per planned step.
const TICKS: f64 = 100.0;

/// Width of a terminal, in columns, from which bars have both times: they take up to 75.
const WIDE: usize = 80;

/// Columns of a terminal: those of the variable `COLUMNS` if it is set, else what the terminal says. None if there is
/// no terminal.
pub fn terminal_width(terminal: &Term) -> Option<usize> {
    let told = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok()).filter(|&columns| columns > 0);
    told.or_else(|| terminal.size_checked().map(|(_, columns)| usize::from(columns)))
}

/// The first style, or the second on a narrow terminal, where a longer line would wrap and leave its remains behind.
pub fn bar_style(wide: &str, narrow: &str) -> ProgressStyle {
    let is_narrow = terminal_width(&Term::stderr()).is_some_and(|width| width < WIDE);
    ProgressStyle::with_template(if is_narrow { narrow } else { wide }).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// A bar over all planned steps of all stages. Clones show the same bar.
#[derive(Clone)]
pub struct Bar {
    bar: ProgressBar,
    /// Planned steps of each stage.
    steps: Vec<usize>,
    /// Whether no more lines are printed.
    is_over: Arc<AtomicBool>,
}

impl Bar {
    /// A bar that begins at `from` (stage, fraction of it); `quiet` shows nothing.
    pub fn new(stages: &[Stage], from: Option<(usize, f64)>, quiet: bool) -> Self {
        let steps: Vec<usize> = stages.iter().map(|stage| stage.steps).collect();
        let total = (TICKS * steps.iter().sum::<usize>().max(1) as f64) as u64;
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(total) };
        bar.set_style(bar_style(
            "{bar:20} {percent:>3} %  {elapsed} spent, about {eta} left  {wide_msg}",
            "{percent:>3} %  {eta:>4} left {wide_bar}",
        ));
        bar.enable_steady_tick(Duration::from_millis(500));
        let this = Self { bar, steps, is_over: Arc::default() };
        if !quiet && !std::io::stderr().is_terminal() {
            let (told, beat) = (this.clone(), HEARTBEAT);
            std::thread::spawn(move || told.tell_every(beat));
        }
        if let Some((stage, fraction)) = from {
            this.bar.set_position(this.position(stage, fraction));
            this.bar.reset_eta();
        }
        this
    }

    fn position(&self, stage: usize, fraction: f64) -> u64 {
        let before: usize = self.steps.iter().take(stage).sum();
        let here = self.steps.get(stage).map_or(0.0, |&steps| steps as f64);
        (TICKS * (before as f64 + fraction * here)) as u64
    }

    /// Shows an accepted step.
    pub fn step(&self, step: &Observation) -> ControlFlow<()> {
        self.bar.set_position(self.position(step.stage, step.fraction));
        let (stage, stages) = (step.stage + 1, self.steps.len());
        let place = format!("stage {stage} of {stages} at {:.1} %, step {}", 100.0 * step.fraction, step.step);
        self.bar.set_message(format!("{place}: {} contact sites, {} iterations", step.num_sites, step.iterations));
        ControlFlow::Continue(())
    }

    /// Prints a line above the bar.
    pub fn note(&self, line: &str) {
        self.bar.suspend(|| eprintln!("{line}"));
    }

    /// Prints a line at such intervals until the bar is removed.
    fn tell_every(&self, time: Duration) {
        loop {
            std::thread::sleep(time);
            if self.is_over.load(Ordering::Relaxed) {
                return;
            }
            let percent = 100.0 * self.bar.position() as f64 / self.bar.length().unwrap_or(1).max(1) as f64;
            let (seconds, message) = (self.bar.elapsed().as_secs(), self.bar.message());
            let message = if message.is_empty() { "bringing the start to rest".to_owned() } else { message };
            eprintln!("{percent:.0} %, {seconds} s spent: {message}");
        }
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.is_over.store(true, Ordering::Relaxed);
        self.bar.finish_and_clear();
    }
}
