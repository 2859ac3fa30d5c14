//! `supercoil check FILE`.

use std::path::PathBuf;

use clap::Args;
use supercoil::InputError;
use supercoil::observe::start_overlaps;
use supercoil::scene::{Joint, Scene};
use supercoil::solve::{Options, RunError, Solver};

use super::print::{say, warn};
use super::run::Replacements;
use super::{BAD_INPUT, CONVERGED};

#[derive(Args)]
pub struct CheckArguments {
    /// Scene file (TOML).
    file: PathBuf,
    #[command(flatten)]
    set: Replacements,
}

impl CheckArguments {
    pub fn go(self) -> Result<u8, InputError> {
        let Self { file, set } = self;
        let scene = Scene::read_with(&file, &set.set)?;
        say(format_args!("{}: {}", file.display(), if scene.title.is_empty() { "no title" } else { &scene.title }));
        for rod in &scene.model.rods {
            let (kind, unit) = (if rod.closed { "closed" } else { "open" }, &scene.units.length);
            let (name, elements, order, length) = (&rod.name, rod.num_elements, rod.order, rounded(rod.length));
            say(format_args!("  rod {name}: {kind}, length {length} {unit}, {elements} elements of order {order}"));
        }
        let steps: usize = scene.stages.iter().map(|stage| stage.steps).sum();
        let (supports, stages) = (scene.model.supports.len(), scene.stages.len());
        let [supports, stages] = [(supports, "support"), (stages, "stage")].map(|(count, what)| counted(count, what));
        let joints = joints(&scene.model.joints);
        say(format_args!("  {supports}, {joints}, {stages} of {} in all", counted(steps, "step")));
        scene.expectations().iter().for_each(|line| say(format_args!("  {line}")));
        scene.notices.iter().for_each(|notice| say(format_args!("  note: {notice}")));
        let warnings = scene.warnings();
        warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
        // errors of a run before its first step
        let overlaps = Solver::new(scene.model.clone(), Options::default())
            .map(drop)
            .map_err(RunError::Input)
            .and_then(|()| start_overlaps(&scene.model));
        match overlaps {
            Ok(overlaps) if overlaps.is_empty() && warnings.is_empty() => say(format_args!("  nothing to object")),
            Ok(overlaps) => warn(&overlaps),
            Err(RunError::Input(error)) => return Err(error),
            Err(error) => {
                eprintln!("error: {error}");
                return Ok(BAD_INPUT);
            }
        }
        Ok(CONVERGED)
    }
}

/// A number to seven digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.6e}").parse().unwrap_or(x)
}

/// A count of things, in words.
fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// A count of joints, with their kinds.
fn joints(all: &[Joint]) -> String {
    let count = |name: &str| all.iter().filter(|joint| joint.kind.name() == name).count();
    let kinds = [(count("rigid"), "rigid joint"), (count("pin"), "pin"), (count("hinge"), "hinge")];
    let kinds: Vec<String> = kinds.iter().filter(|(k, _)| *k > 0).map(|(k, what)| counted(*k, what)).collect();
    if kinds.is_empty() { counted(0, "joint") } else { kinds.join(", ") }
}
