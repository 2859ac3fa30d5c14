//! `supercoil view DIR`.

use std::path::PathBuf;

use clap::Args;
use supercoil::InputError;
use supercoil::io::view::{self, GlbOptions, Quantity};

use super::CONVERGED;
use super::print::say;

#[derive(Args)]
pub struct ViewArguments {
    /// Folder of the run.
    dir: PathBuf,
    /// Write the tubes of the final state as this binary STL file, in the scene's unit of length, instead of the page.
    #[arg(long, value_name = "FILE", conflicts_with = "glb")]
    stl: Option<PathBuf>,
    /// Write this binary glTF file instead of the page.
    #[arg(long, value_name = "FILE")]
    glb: Option<PathBuf>,
    /// By which rods are coloured in the glTF file: strand, pressure (contact force per length), curvature or
    /// twist_rate.
    #[arg(long, value_name = "QUANTITY", default_value = "strand", requires = "glb")]
    color: String,
}

impl ViewArguments {
    pub fn go(self) -> Result<u8, InputError> {
        let Self { dir, stl, glb, color } = self;
        let written = if let Some(file) = stl {
            view::of_run(&dir, view::MAX_NODES)?.save_stl(&file)?;
            file
        } else if let Some(file) = glb {
            let options = GlbOptions { color: Quantity::from_name(&color)?, ..GlbOptions::default() };
            view::of_run(&dir, view::MAX_NODES)?.save_glb(&file, &options)?;
            file
        } else {
            view::write_page(&dir)?
        };
        say(format_args!("{}", written.display()));
        Ok(CONVERGED)
    }
}
