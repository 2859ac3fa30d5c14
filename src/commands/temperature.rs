//! `supercoil free-energy DIR` and `supercoil j-factor DIR`: final states of runs at a temperature.

use std::path::PathBuf;

use clap::Args;
use supercoil::InputError;
use supercoil::io::comparison::StateComparison;
use supercoil::io::final_state::FinalState;
use supercoil::io::thermal::ThermalState;
use supercoil::solve::RunError;

use super::code_of;
use super::print::say;

#[derive(Args)]
pub struct FreeEnergyArguments {
    /// Folder of the run.
    dir: PathBuf,
    /// Folder of the run that it is compared with.
    #[arg(required_unless_present_any = ["of", "to"])]
    reference: Option<PathBuf>,
    /// Whose standard deviations: extension, writhe, twist, energy, position_x:NAME:end …; as --of of sensitivity.
    #[arg(long, value_name = "OBSERVABLE", value_delimiter = ',')]
    of: Vec<String>,
    /// Slopes of the free energy: by load −force × extension, by link or rotation_x:NAME:end 2π × torque; as --to of
    /// sensitivity.
    #[arg(long, value_name = "PARAMETER", value_delimiter = ',')]
    to: Vec<String>,
    /// Thermal energy, F L [default: that of the scene's temperature, where units are nm and pN].
    #[arg(long = "kT", value_name = "KT")]
    thermal_energy: Option<f64>,
}

#[derive(Args)]
pub struct JFactorArguments {
    /// Folder of the run.
    dir: PathBuf,
    /// Folder of the run that it is compared with.
    reference: PathBuf,
    /// Thermal energy, F L [default: that of the scene's temperature, where units are nm and pN].
    #[arg(long = "kT", value_name = "KT")]
    thermal_energy: Option<f64>,
}

impl FreeEnergyArguments {
    pub fn go(self) -> Result<u8, InputError> {
        let Self { dir, reference, of, to, thermal_energy } = self;
        let answer = || -> Result<(), RunError> {
            let mut state = FinalState::read(&dir, None)?;
            if let Some(reference) = &reference {
                let states = [&mut state, &mut FinalState::read(reference, None)?];
                say(format_args!("{}", StateComparison::of_free_energies(states, thermal_energy)?));
            }
            if !of.is_empty() || !to.is_empty() {
                say(format_args!("{}", ThermalState::new(&mut state, thermal_energy, (&of, &to))?));
            }
            Ok(())
        };
        code_of(answer())
    }
}

impl JFactorArguments {
    pub fn go(self) -> Result<u8, InputError> {
        let answer = || -> Result<(), RunError> {
            let states = [&mut FinalState::read(&self.dir, None)?, &mut FinalState::read(&self.reference, None)?];
            say(format_args!("{}", StateComparison::of_ends(states, self.thermal_energy)?));
            Ok(())
        };
        code_of(answer())
    }
}
