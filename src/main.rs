//! The command line: `supercoil new KIND`, `supercoil run FILE --out DIR`, `supercoil resume DIR`, `supercoil check
//! FILE`, `supercoil view DIR`, `supercoil export DIR`, `supercoil sweep …` and `supercoil help scene [KEY]`.
//!
//! Exit codes: 0 converged, 1 ran but did not converge, 2 bad input, 3 outputs could not be written (disk full,
//! read-only, folder in use), 4 converged with tubes inside each other, 5 converged but a check of the certificate
//! fails, 130 stopped by Ctrl-C or `--time-limit`.
#![allow(clippy::print_stderr)] // a program prints to its user

mod commands;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use supercoil::InputError;

use commands::{
    BAD_INPUT, NOT_WRITTEN, answers, check, export, help, new, plot, resume, run, sweep, temperature, view,
};

/// Equilibria of elastic rods that touch themselves and each other.
#[derive(Parser)]
#[command(
    name = "supercoil",
    version,
    disable_help_subcommand = true,
    after_help = "Exit codes: 0 converged, 1 ran but did not converge, 2 bad input, 3 outputs could not be written \
        (disk full, read-only, folder in use), 4 converged with tubes inside each other (status overlap), 5 \
        converged, but a check of the certificate fails (status fails …), 130 stopped by Ctrl-C or --time-limit."
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene file and write its outputs. Ctrl-C ends the run with all files in order; a second one ends it at
    /// once.
    Run(run::RunArguments),
    /// Go on with a run that was stopped or killed, from its last checkpoint.
    Resume(resume::ResumeArguments),
    /// Write view.html into the folder of a run, as the run itself does: a page for the browser, to turn and to step
    /// through. Or write a glTF file, for Blender, slides and viewers, or an STL file of the final state, for printers.
    View(view::ViewArguments),
    /// Plot columns of a table of a run as SVG or PDF. A dashed line joins the steps between which the rods snapped.
    Plot(plot::PlotArguments),
    /// Find the softest modes of a run's final state. Writes modes.vtp for ParaView and modes.html, a page that shows
    /// them swing. Of rods with masses (density, mass or weight) frequencies.
    Modes(answers::ModesArguments),
    /// Print derivatives of a run's final state, and write them to sensitivities.csv.
    Sensitivity(answers::SensitivityArguments),
    /// Print the harmonic free energy of a run's final state less that of another run of the same rods on the same
    /// mesh; standard deviations; what loads and motions do at this temperature.
    FreeEnergy(temperature::FreeEnergyArguments),
    /// Print the J-factor of a ring or a loop: the run of the ring (closed), or of the loop between its clamps, and
    /// that of the same rod on the same mesh with a free end.
    JFactor(temperature::JFactorArguments),
    /// Check a scene file without running it.
    Check(check::CheckArguments),
    /// Write the base pairs of a run's final state for programs that simulate DNA. Its unit of length must be nm.
    Export(export::ExportArguments),
    /// Run a scene many times with other values: `supercoil help sweep`.
    #[command(after_long_help = sweep::SWEEP_FILE)]
    Sweep {
        #[command(subcommand)]
        command: sweep::SweepCommand,
    },
    /// Write a commented scene to begin with.
    New(new::NewArguments),
    /// Print the completions of a shell; its manual says where they belong.
    Completions(help::CompletionsArguments),
    /// Write the manual, a page of the program and one of each command, into a folder.
    Man(help::ManArguments),
    /// Explain the keys of scene files (`help scene`, `help scene KEY`), or a command; `help schema` prints the JSON
    /// Schema of scene files, for editors.
    Help(help::HelpArguments),
}

fn main() -> ExitCode {
    ExitCode::from(program(std::env::args_os()))
}

/// The program with these arguments, its own name first; its exit code. The Python package has it, too.
pub fn program(arguments: impl IntoIterator<Item = std::ffi::OsString>) -> u8 {
    let code = match Arguments::parse_from(arguments).command {
        Command::Run(arguments) => arguments.go(),
        Command::Resume(arguments) => arguments.go(),
        Command::View(arguments) => arguments.go(),
        Command::Plot(arguments) => arguments.go(),
        Command::Modes(arguments) => arguments.go(),
        Command::Sensitivity(arguments) => arguments.go(),
        Command::FreeEnergy(arguments) => arguments.go(),
        Command::JFactor(arguments) => arguments.go(),
        Command::Check(arguments) => arguments.go(),
        Command::Export(arguments) => arguments.go(),
        Command::Sweep { command } => command.go(),
        Command::New(arguments) => arguments.go(),
        Command::Completions(arguments) => arguments.go(Arguments::command()),
        Command::Man(arguments) => arguments.go(Arguments::command()),
        Command::Help(arguments) => arguments.go(Arguments::command()),
    };
    code.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        if let InputError::Write { .. } = error { NOT_WRITTEN } else { BAD_INPUT }
    })
}
