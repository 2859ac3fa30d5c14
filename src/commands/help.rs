//! `supercoil help`, `completions` and `man`: what the program says of itself.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, Command};
use supercoil::InputError;
use supercoil::io::schema::scene_schema;
use supercoil::scene::file::help;

use super::CONVERGED;
use super::print::say;

#[derive(Args)]
pub struct HelpArguments {
    /// "scene", "schema", or a command.
    topic: Option<String>,
    /// A key of scene files, for example excess_link, rods.shape or stages.ramp.pose.
    key: Option<String>,
}

#[derive(Args)]
pub struct CompletionsArguments {
    /// Which shell.
    shell: clap_complete::Shell,
}

#[derive(Args)]
pub struct ManArguments {
    /// Folder; is created.
    dir: PathBuf,
}

impl HelpArguments {
    pub fn go(self, mut program: Command) -> Result<u8, InputError> {
        let Self { topic, key } = self;
        program.build();
        match topic.as_deref() {
            Some("scene") => say(format_args!("{}", help(key.as_deref())?.trim_end())),
            Some("schema") => say(format_args!("{}", scene_schema().trim_end())),
            None => say(format_args!("{}", program.render_help())),
            Some(topic) => match program.find_subcommand_mut(topic) {
                Some(command) => say(format_args!("{}", command.render_long_help())),
                None => {
                    let allowed = "\"scene\", \"schema\" or a command".to_owned();
                    return Err(InputError::Name { field: "topic".to_owned(), name: topic.to_owned(), allowed });
                }
            },
        }
        Ok(CONVERGED)
    }
}

impl CompletionsArguments {
    /// Prints the completions of a shell.
    pub fn go(self, mut program: Command) -> Result<u8, InputError> {
        // by way of a buffer: a closed pipe is not an error
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut program, "supercoil", &mut text);
        std::io::stdout().write_all(&text).ok();
        Ok(CONVERGED)
    }
}

impl ManArguments {
    /// Writes the manual: a page of the program, and one of each command.
    pub fn go(self, program: Command) -> Result<u8, InputError> {
        let dir = self.dir;
        let refuse = |e: std::io::Error| InputError::Write { path: dir.clone(), reason: e.to_string() };
        std::fs::create_dir_all(&dir).map_err(refuse)?;
        clap_mangen::generate_to(program, &dir).map_err(refuse)?;
        say(format_args!("{}; to read it: man {}", dir.display(), dir.join("supercoil.1").display()));
        Ok(CONVERGED)
    }
}
