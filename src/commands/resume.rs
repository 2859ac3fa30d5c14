//! `supercoil resume DIR`.

use std::path::PathBuf;

use clap::Args;
use supercoil::InputError;
use supercoil::io::checkpoint::{Checkpoint, FILE_NAME};
use supercoil::io::run::{SceneRun, scene_of};
use supercoil::scene::Scene;

use super::execution::{Choices, execute};
use super::print::say;

#[derive(Args)]
pub struct ResumeArguments {
    /// Folder of the run.
    dir: PathBuf,
    /// Where its scene file is now [default: where it was].
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    #[command(flatten)]
    choices: Choices,
}

impl ResumeArguments {
    pub fn go(self) -> Result<u8, InputError> {
        let Self { dir, scene, choices } = self;
        let checkpoint = Checkpoint::read(&dir.join(FILE_NAME))?;
        let scene = match &scene {
            Some(file) => Scene::read_with(file, &checkpoint.set)?,
            None => scene_of(&checkpoint)?,
        };
        let place = checkpoint.restart.place;
        if !choices.quiet {
            let title = if scene.title.is_empty() { "going on" } else { &scene.title };
            say(format_args!(
                "{title}: from step {}, stage {} at {:.1} %",
                place.num_steps,
                place.stage + 1,
                100.0 * place.fraction
            ));
        }
        if checkpoint.program != env!("CARGO_PKG_VERSION") {
            let (then, now) = (&checkpoint.program, env!("CARGO_PKG_VERSION"));
            eprintln!(
                "note: the run began with version {then}, this is {now}: the last digits may differ from here on"
            );
        }
        execute(SceneRun::new(scene, &dir), Some((place.stage, place.fraction)), &choices)
    }
}
