//! `supercoil run FILE`.

use std::path::{Path, PathBuf};

use clap::Args;
use supercoil::InputError;
use supercoil::io::run::SceneRun;
use supercoil::observe::start_overlaps;
use supercoil::scene::Scene;

use super::execution::{Choices, execute};
use super::print::{say, warn};

#[derive(Args)]
pub struct RunArguments {
    /// Scene file (TOML).
    file: PathBuf,
    /// Folder for the outputs [default: output.dir of the scene, or out/NAME].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the results of another scene in that folder.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    set: Replacements,
    #[command(flatten)]
    choices: Choices,
}

#[derive(Args)]
pub struct Replacements {
    /// Replace a value of the scene, for example rods.dna.elements=96 (by name), stages.0.steps=10 (by index) or
    /// solver.threads=2; may be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

impl RunArguments {
    pub fn go(self) -> Result<u8, InputError> {
        let Self { file, out, force, set, choices } = self;
        let scene = Scene::read_with(&file, &set.set)?;
        let default = || Path::new("out").join(file.file_stem().unwrap_or_default());
        let dir = out.or_else(|| scene.output.dir.clone()).unwrap_or_else(default);
        if !choices.quiet && !scene.title.is_empty() {
            say(format_args!("{}", scene.title));
        }
        if !choices.quiet {
            scene.notices.iter().for_each(|notice| eprintln!("note: {notice}"));
            scene.warnings().iter().for_each(|warning| eprintln!("warning: {warning}"));
            // errors here occur in the run, too, which reports them
            let overlaps = start_overlaps(&scene.model).unwrap_or_default();
            warn(&overlaps.into_iter().filter(|overlap| overlap.through).collect::<Vec<_>>());
        }
        execute(SceneRun { force, ..SceneRun::new(scene, &dir) }, None, &choices)
    }
}
