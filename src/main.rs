//! The command line: `supercoil new KIND`, `supercoil run FILE --out DIR`, `supercoil resume DIR`, `supercoil check FILE`,
//! `supercoil view DIR`, `supercoil export DIR`, `supercoil sweep …` and `supercoil help scene [KEY]`.
//!
//! Exit codes: 0 converged, 1 ran but did not converge, 2 bad input, 3 outputs could not be written (disk full,
//! read-only, folder in use), 4 converged with tubes inside each other, 130 stopped by Ctrl-C or `--time-limit`.
#![allow(clippy::print_stderr)] // a program prints to its user

mod progress;
mod sweep;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, CommandFactory, Parser, Subcommand};
use console::Term;
use supercoil::dna::sequence::Sequence;
use supercoil::io::asked::Asked;
use supercoil::io::checkpoint::{Checkpoint, FILE_NAME};
use supercoil::io::comparison::StateComparison;
use supercoil::io::export::{Formats, base_pairs};
use supercoil::io::final_state::FinalState;
use supercoil::io::plot_run::{PLOTTED, RunTable};
use supercoil::io::record::Record;
use supercoil::io::run::{Outcome, SceneRun, scene_of, snapshots};
use supercoil::io::schema::scene_schema;
use supercoil::io::table::StepTable;
use supercoil::io::thermal::ThermalState;
use supercoil::io::view::{self, GlbOptions, Quantity};
use supercoil::observe::{StartOverlap, ending, start_overlaps};
use supercoil::scene::file::{MOST_THREADS, TEMPLATES, help};
use supercoil::scene::{Joint, Scene, Units};
use supercoil::solve::{Interrupt, Options, RunError, Solver, Status};
use supercoil::{InputError, dna};

use progress::{Bar, terminal_width};

const CONVERGED: u8 = 0;
const NOT_CONVERGED: u8 = 1;
const BAD_INPUT: u8 = 2;
const NOT_WRITTEN: u8 = 3;
const OVERLAPS: u8 = 4;
const CHECK_FAILS: u8 = 5;
const INTERRUPTED: u8 = 130;

/// Most overlaps listed one by one.
const MOST_WARNINGS: usize = 10;

/// Equilibria of elastic rods that touch themselves and each other.
#[derive(Parser)]
#[command(
    name = "supercoil",
    version,
    disable_help_subcommand = true,
    after_help = "Exit codes: 0 converged, 1 ran but did not converge, 2 bad input, 3 outputs could not be written (disk \
    full, read-only, folder in use), 4 converged with tubes inside each other (status overlap), 5 converged, but a check of the \
    certificate fails (status fails …), 130 stopped by Ctrl-C or --time-limit."
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene file and write its outputs. Ctrl-C ends the run with all files in order; a second one ends it at
    /// once.
    Run {
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
    },
    /// Go on with a run that was stopped or killed, from its last checkpoint.
    Resume {
        /// Folder of the run.
        dir: PathBuf,
        /// Where its scene file is now [default: where it was].
        #[arg(long, value_name = "FILE")]
        scene: Option<PathBuf>,
        #[command(flatten)]
        choices: Choices,
    },
    /// Write view.html into the folder of a run, as the run itself does: a page for the browser, to turn and to step
    /// through. Or write a glTF file, for Blender, slides and viewers, or an STL file of the final state, for printers.
    View {
        /// Folder of the run.
        dir: PathBuf,
        /// Write the tubes of the final state as this binary STL file, in the scene's unit of length, instead of the page.
        #[arg(long, value_name = "FILE", conflicts_with = "glb")]
        stl: Option<PathBuf>,
        /// Write this binary glTF file instead of the page.
        #[arg(long, value_name = "FILE")]
        glb: Option<PathBuf>,
        /// By which rods are coloured in the glTF file: strand, pressure (contact force per length), curvature or twist_rate.
        #[arg(long, value_name = "QUANTITY", default_value = "strand", requires = "glb")]
        color: String,
    },
    /// Plot columns of a table of a run as SVG or PDF. A dashed line joins the steps between which the rods snapped.
    Plot(PlotChoice),
    /// Find the softest modes of a run's final state. Writes modes.vtp for ParaView and modes.html, a page that shows them
    /// swing. Of rods with masses (density, mass or weight) frequencies.
    Modes {
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
    },
    /// Print derivatives of a run's final state, and write them to sensitivities.csv.
    Sensitivity {
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
    },
    /// Print the harmonic free energy of a run's final state less that of another run of the same rods on the same mesh;
    /// standard deviations; what loads and motions do at this temperature.
    FreeEnergy(FreeEnergy),
    /// Print the J-factor of a ring or a loop: the run of the ring (closed), or of the loop between its clamps, and that of the
    /// same rod on the same mesh with a free end.
    JFactor(TwoRuns),
    /// Check a scene file without running it.
    Check {
        /// Scene file (TOML).
        file: PathBuf,
        #[command(flatten)]
        set: Replacements,
    },
    /// Write the base pairs of a run's final state for programs that simulate DNA. Its unit of length must be nm.
    Export(Export),
    /// Run a scene many times with other values: `supercoil help sweep`.
    #[command(after_long_help = sweep::SWEEP_FILE)]
    Sweep {
        #[command(subcommand)]
        command: sweep::SweepCommand,
    },
    /// Write a commented scene to begin with.
    New {
        /// Which.
        #[arg(value_parser = kinds())]
        kind: String,
        /// File to write; must not be there yet [default: KIND.toml]. Of a knot its name, too: `new knot 8_19` writes
        /// knot_8_19.toml.
        file: Option<PathBuf>,
    },
    /// Print the completions of a shell; its manual says where they belong.
    Completions {
        /// Which shell.
        shell: clap_complete::Shell,
    },
    /// Write the manual, a page of the program and one of each command, into a folder.
    Man {
        /// Folder; is created.
        dir: PathBuf,
    },
    /// Explain the keys of scene files (`help scene`, `help scene KEY`), or a command; `help schema` prints the JSON Schema
    /// of scene files, for editors.
    Help {
        /// "scene", "schema", or a command.
        topic: Option<String>,
        /// A key of scene files, for example excess_link, rods.shape or stages.ramp.pose.
        key: Option<String>,
    },
}

fn kinds() -> clap::builder::PossibleValuesParser {
    TEMPLATES.map(|template| clap::builder::PossibleValue::new(template.name).help(template.about)).into()
}

/// The scene of a finished run.
#[derive(Args)]
struct SceneOfRun {
    /// Where its scene file is now [default: where it was].
    #[arg(long = "scene", value_name = "FILE")]
    file: Option<PathBuf>,
}

/// Two runs that are compared at a temperature.
#[derive(Args)]
struct TwoRuns {
    /// Folder of the run.
    dir: PathBuf,
    /// Folder of the run that it is compared with.
    reference: PathBuf,
    /// Thermal energy, F L [default: that of the scene's temperature, where units are nm and pN].
    #[arg(long = "kT", value_name = "KT")]
    thermal_energy: Option<f64>,
}

/// What is asked of a run's final state at a temperature.
#[derive(Args)]
struct FreeEnergy {
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

/// Columns of a table to plot.
#[derive(Args)]
struct PlotChoice {
    /// Folder of the run.
    dir: PathBuf,
    /// Table: of the steps (table), or of the final state: resultants (tension, shear, moments along the rods), lines,
    /// sites.
    #[arg(long, value_name = "TABLE", default_value = PLOTTED[0], value_parser = PLOTTED)]
    of: String,
    /// Only the rows of this rod.
    #[arg(long, value_name = "NAME")]
    rod: Option<String>,
    /// Column along the horizontal axis.
    #[arg(long, value_name = "COLUMN")]
    x: String,
    /// Columns along the vertical axis, of one unit.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',', required = true)]
    y: Vec<String>,
    /// File to write, *.svg or *.pdf [default: DIR/Y.svg].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Formats of a run's base pairs.
#[derive(Args, Clone)]
#[command(group(clap::ArgGroup::new("format").args(["oxdna", "xyz", "vect", "pdb", "par", "ref_frames", "npy"]).required(true).multiple(true)))]
struct Export {
    /// Folder of the run.
    dir: PathBuf,
    /// Rod, where there are several.
    #[arg(long)]
    rod: Option<String>,
    /// Sequence (FASTA): names the bases and their number [default: the sequence of the rod, if it has one].
    #[arg(long, value_name = "FASTA")]
    sequence: Option<PathBuf>,
    /// Number of base pairs, equally spaced [default: those of the sequence, or length / 0.34 nm].
    #[arg(long, value_name = "N", conflicts_with = "sequence")]
    base_pairs: Option<usize>,
    /// oxDNA: writes NAME.top and NAME.dat; needs a sequence.
    #[arg(long, value_name = "NAME")]
    oxdna: Option<PathBuf>,
    /// XYZ, one point a base pair, nm: a centreline for tacoxDNA.
    #[arg(long, value_name = "FILE")]
    xyz: Option<PathBuf>,
    /// Geomview's VECT, one point a base pair, nm.
    #[arg(long, value_name = "FILE")]
    vect: Option<PathBuf>,
    /// PDB, the atoms P of both strands, Å.
    #[arg(long, value_name = "FILE")]
    pdb: Option<PathBuf>,
    /// Step parameters as 3DNA's bp_step.par.
    #[arg(long, value_name = "FILE")]
    par: Option<PathBuf>,
    /// Frames as 3DNA's ref_frames.dat, Å.
    #[arg(long, value_name = "FILE")]
    ref_frames: Option<PathBuf>,
    /// NumPy array of base-pair frames, shape (pairs, 4, 3), nm, as mdna reads them.
    #[arg(long, value_name = "FILE")]
    npy: Option<PathBuf>,
}

#[derive(Args)]
struct Replacements {
    /// Replace a value of the scene, for example rods.dna.elements=96 (by name), stages.0.steps=10 (by index) or
    /// solver.threads=2; may be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

#[derive(Args)]
struct Choices {
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
    quiet: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "a number expected".to_owned())?;
    if seconds >= 0.0 { Ok(seconds) } else { Err("must be at least 0".to_owned()) }
}

fn main() -> ExitCode {
    ExitCode::from(program(std::env::args_os()))
}

/// The program with these arguments, its own name first; its exit code. The Python package has it, too.
pub fn program(arguments: impl IntoIterator<Item = std::ffi::OsString>) -> u8 {
    let code = match Arguments::parse_from(arguments).command {
        Command::Check { file, set } => check(&file, &set.set),
        Command::View { dir, stl: Some(file), .. } => stl(&dir, &file),
        Command::View { dir, glb, color, .. } => view(&dir, glb, &color),
        Command::Run { file, out, force, set, choices } => run(&file, &set.set, out, force, &choices),
        Command::Export(what) => export(&what),
        Command::Modes { dir, count, glb, scene } => ask(&dir, &scene, (count, &[], &[]), glb.as_deref()),
        Command::Sensitivity { dir, of, to, scene } => ask(&dir, &scene, (0, &of, &to), None),
        Command::FreeEnergy(asked) => at_temperature(&asked),
        Command::JFactor(runs) => j_factor(&runs),
        Command::Sweep { command } => command.go(),
        Command::Resume { dir, scene, choices } => resume(&dir, scene, &choices),
        Command::Plot(what) => plot(&what),
        Command::Man { dir } => manual(&dir),
        Command::Completions { shell } => completions(shell),
        Command::New { kind, file } => new(&kind, file),
        Command::Help { topic, key } => explain(topic.as_deref(), key.as_deref()),
    };
    code.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        if let InputError::Write { .. } = error { NOT_WRITTEN } else { BAD_INPUT }
    })
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
    told(answer().map(|(text, written)| {
        say(format_args!("{}", text.trim_end()));
        written.iter().for_each(|path| say(format_args!("{}", path.display())));
    }))
}

/// The J-factor by the final states of two runs.
fn j_factor(runs: &TwoRuns) -> Result<u8, InputError> {
    let answer = || -> Result<(), RunError> {
        let states = [&mut FinalState::read(&runs.dir, None)?, &mut FinalState::read(&runs.reference, None)?];
        say(format_args!("{}", StateComparison::of_ends(states, runs.thermal_energy)?));
        Ok(())
    };
    told(answer())
}

/// Free energy, standard deviations, slopes of the free energy at the final state of a run.
fn at_temperature(asked: &FreeEnergy) -> Result<u8, InputError> {
    let FreeEnergy { dir, reference, of, to, thermal_energy } = asked;
    let answer = || -> Result<(), RunError> {
        let mut state = FinalState::read(dir, None)?;
        if let Some(reference) = reference {
            let states = [&mut state, &mut FinalState::read(reference, None)?];
            say(format_args!("{}", StateComparison::of_free_energies(states, *thermal_energy)?));
        }
        if !of.is_empty() || !to.is_empty() {
            say(format_args!("{}", ThermalState::new(&mut state, *thermal_energy, (of, to))?));
        }
        Ok(())
    };
    told(answer())
}

/// The exit code of work without steps.
fn told(result: Result<(), RunError>) -> Result<u8, InputError> {
    match result {
        Ok(()) => Ok(CONVERGED),
        Err(RunError::Input(error)) => Err(error),
        Err(error) => {
            eprintln!("error: {error}");
            Ok(NOT_CONVERGED)
        }
    }
}

fn view(dir: &Path, glb: Option<PathBuf>, color: &str) -> Result<u8, InputError> {
    let written = match glb {
        None => view::write_page(dir)?,
        Some(file) => {
            let options = GlbOptions { color: Quantity::from_name(color)?, ..GlbOptions::default() };
            view::of_run(dir, view::MAX_NODES)?.save_glb(&file, &options)?;
            file
        }
    };
    say(format_args!("{}", written.display()));
    Ok(CONVERGED)
}

fn stl(dir: &Path, file: &Path) -> Result<u8, InputError> {
    view::of_run(dir, view::MAX_NODES)?.save_stl(file)?;
    say(format_args!("{}", file.display()));
    Ok(CONVERGED)
}

fn plot(what: &PlotChoice) -> Result<u8, InputError> {
    let whole = RunTable::read_named(&what.dir, &what.of)?;
    let table = match &what.rod {
        Some(rod) => whole.of_rod(rod)?,
        None => whole,
    };
    let file = what.out.clone().unwrap_or_else(|| what.dir.join(format!("{}.svg", what.y.join("_"))));
    table.plot(&what.x, &what.y, &file)?;
    say(format_args!("{}", file.display()));
    Ok(CONVERGED)
}

/// Prints the completions of a shell.
fn completions(shell: clap_complete::Shell) -> Result<u8, InputError> {
    // by way of a buffer: a closed pipe is not an error
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "supercoil", &mut text);
    std::io::stdout().write_all(&text).ok();
    Ok(CONVERGED)
}

/// Writes the manual: a page of the program, and one of each command.
fn manual(dir: &Path) -> Result<u8, InputError> {
    let refuse = |e: std::io::Error| InputError::Write { path: dir.to_owned(), reason: e.to_string() };
    std::fs::create_dir_all(dir).map_err(refuse)?;
    clap_mangen::generate_to(Arguments::command(), dir).map_err(refuse)?;
    say(format_args!("{}; to read it: man {}", dir.display(), dir.join("supercoil.1").display()));
    Ok(CONVERGED)
}

/// Prints a line; a closed pipe (`supercoil check FILE | head`) is not an error.
fn say(line: std::fmt::Arguments) {
    std::io::stdout().write_fmt(format_args!("{line}\n")).ok();
}

/// Prints the deepest overlaps of a start shape.
fn warn(overlaps: &[StartOverlap]) {
    overlaps.iter().take(MOST_WARNINGS).for_each(|overlap| eprintln!("warning: {overlap}"));
    if let more @ 1.. = overlaps.len().saturating_sub(MOST_WARNINGS) {
        eprintln!("warning: {more} more overlaps, less deep");
    }
}

fn new(kind: &str, file: Option<PathBuf>) -> Result<u8, InputError> {
    let text = TEMPLATES.iter().find(|template| template.name == kind).map_or("", |template| template.text);
    let knot =
        file.as_deref().filter(|_| kind == "knot").and_then(Path::to_str).and_then(|name| knot_scene(text, name));
    let (file, text) = match knot {
        Some(knot) => (PathBuf::from(format!("knot_{}.toml", file.unwrap_or_default().display())), knot?),
        None => (file.unwrap_or_else(|| PathBuf::from(format!("{kind}.toml"))), text.to_owned()),
    };
    let refuse = |e: std::io::Error| InputError::Write { path: file.clone(), reason: e.to_string() };
    let mut made = std::fs::File::create_new(&file).map_err(refuse)?;
    made.write_all(text.as_bytes()).map_err(refuse)?;
    say(format_args!("wrote {0}; to run it: supercoil run {0}", file.display()));
    Ok(CONVERGED)
}

/// The scene of a knot by its name; `None` for words that are no such name.
fn knot_scene(template: &str, name: &str) -> Option<Result<String, InputError>> {
    let (crossings, index) = name.split_once('_')?;
    let is_name = [crossings, index].iter().all(|part| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit()));
    is_name.then(|| {
        let shape = "kind = \"torus_knot\", windings = [2, 3], length = 300.0";
        // strands two diameters apart; the mesh follows from the length, which differs from knot to knot
        let text = template.replace(shape, &format!("kind = \"knot\", name = \"{name}\", distance = 6.0"));
        let text = text.replace("[[rods]]", "fidelity = \"balanced\"\n\n[[rods]]");
        let text = text.lines().filter(|line| !line.starts_with("elements = ")).collect::<Vec<_>>().join("\n") + "\n";
        let text = text.replace("A closed trefoil knot", &format!("A closed knot {name}"));
        let text = text.replace("elastic trefoil knot", &format!("elastic knot {name}"));
        // a name that there is not is refused here, not by the first run
        Scene::from_toml(&text, Path::new("")).map(|_| text)
    })
}

fn explain(topic: Option<&str>, key: Option<&str>) -> Result<u8, InputError> {
    let mut program = Arguments::command();
    program.build();
    match topic {
        Some("scene") => say(format_args!("{}", help(key)?.trim_end())),
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

fn check(file: &Path, set: &[String]) -> Result<u8, InputError> {
    let scene = Scene::read_with(file, set)?;
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

fn export(what: &Export) -> Result<u8, InputError> {
    let given = what.sequence.as_deref().map(Sequence::read).transpose()?;
    let of_rod = |count: Option<usize>| base_pairs(&what.dir, what.rod.as_deref(), count);
    let mut pairs = of_rod(what.base_pairs)?;
    if let Some(sequence) = given {
        // a rod with a sequence of its own has as many base pairs, whatever is given
        pairs = if pairs.sequence.is_none() { of_rod(Some(sequence.num_bases()))? } else { pairs };
        pairs = pairs.with_sequence(sequence)?;
    }
    let Export { oxdna, xyz, vect, pdb, par, ref_frames, npy, .. } = what.clone();
    let written = Formats { oxdna, xyz, vect, pdb, par, ref_frames, npy }.write(&pairs)?;
    let written: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    say(format_args!("{} base pairs to {}", pairs.positions.len(), written.join(", ")));
    Ok(CONVERGED)
}

fn run(file: &Path, set: &[String], out: Option<PathBuf>, force: bool, choices: &Choices) -> Result<u8, InputError> {
    let scene = Scene::read_with(file, set)?;
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
    go(SceneRun { force, ..SceneRun::new(scene, &dir) }, None, choices)
}

fn resume(dir: &Path, scene: Option<PathBuf>, choices: &Choices) -> Result<u8, InputError> {
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
        eprintln!("note: the run began with version {then}, this is {now}: the last digits may differ from here on");
    }
    go(SceneRun::new(scene, dir), Some((place.stage, place.fraction)), choices)
}

/// Runs a scene from its start or, with `from` (stage, fraction), from the checkpoint in its folder.
fn go(mut run: SceneRun, from: Option<(usize, f64)>, choices: &Choices) -> Result<u8, InputError> {
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

/// Raises `interrupt` at Ctrl-C or a request to terminate; the second one ends the program at once.
fn stop_on_signal(interrupt: Interrupt, note: impl Fn(&str) + Send + 'static) {
    // without a handler Ctrl-C still ends the program, but without outputs
    ctrlc::set_handler(move || {
        if interrupt.is_raised() {
            std::process::exit(i32::from(INTERRUPTED));
        }
        interrupt.raise();
        note("stopping; once more to end at once");
    })
    .ok();
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
