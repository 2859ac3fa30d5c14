//! `supercoil modes DIR` and `supercoil sensitivity DIR`: what the tangent at the final state of a run says.

use std::path::{Path, PathBuf};

use clap::Args;
use supercoil::InputError;
use supercoil::io::asked::Asked;
use supercoil::io::final_state::FinalState;
use supercoil::io::record::Record;
use supercoil::io::run::snapshots;
use supercoil::solve::RunError;

use super::code_of;
use super::print::say;

#[derive(Args)]
pub struct ModesArguments {
    /// Folder of the run.
    dir: PathBuf,
    /// How many.
    #[arg(long, value_name = "N", default_value_t = 6)]
    count: usize,
    /// Write the swinging modes as this binary glTF file, too.
    #[arg(long, value_name = "FILE")]
    glb: Option<PathBuf>,
    #[command(flatten)]
    scene: SceneOfRun,
}

#[derive(Args)]
pub struct SensitivityArguments {
    /// Folder of the run.
    dir: PathBuf,
    /// What is differentiated: energy, contact_force, twist, writhe, extension, seam_moment (of the first rod or
    /// writhe:NAME); position_x, force_z, moment_y … of a node (force_z:NAME:end).
    #[arg(long, value_name = "OBSERVABLE", value_delimiter = ',', required = true)]
    of: Vec<String>,
    /// With respect to what: load, link, pressure, bending, twisting, contact_radius, length, natural_twist …,
    /// natural_strains (all rows of a table or a sequence), displacement_x … and rotation_x … of a supported node,
    /// obstacle_level, obstacle_x …; as sensitivity_to of a scene.
    #[arg(long, value_name = "PARAMETER", value_delimiter = ',', required = true)]
    to: Vec<String>,
    #[command(flatten)]
    scene: SceneOfRun,
}

/// The scene of a finished run.
#[derive(Args)]
struct SceneOfRun {
    /// Where its scene file is now [default: where it was].
    #[arg(long = "scene", value_name = "FILE")]
    file: Option<PathBuf>,
}

impl ModesArguments {
    pub fn go(self) -> Result<u8, InputError> {
        ask(&self.dir, &self.scene, (self.count, &[], &[]), self.glb.as_deref())
    }
}

impl SensitivityArguments {
    pub fn go(self) -> Result<u8, InputError> {
        ask(&self.dir, &self.scene, (0, &self.of, &self.to), None)
    }
}

/// Asks the tangent at the final state of a run; the modes into a glTF file, too.
fn ask(
    dir: &Path,
    scene: &SceneOfRun,
    (modes, of, to): (usize, &[String], &[String]),
    glb: Option<&Path>,
) -> Result<u8, InputError> {
    let answer = || -> Result<_, RunError> {
        let FinalState { scene, mut solver } = FinalState::read(dir, scene.file.as_deref())?;
        let answers = Asked::new(&scene, modes, of, to)?.answer(&mut solver)?;
        let text = answers.to_string();
        Ok((text, Record::write_answers(&scene, dir, snapshots(solver.engine()), (answers, glb))?))
    };
    code_of(answer().map(|(text, written)| {
        say(format_args!("{}", text.trim_end()));
        written.iter().for_each(|path| say(format_args!("{}", path.display())));
    }))
}
