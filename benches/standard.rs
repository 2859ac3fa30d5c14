//! Standard runs: how many Newton iterations the solver takes for problems that do not change, and whether their
//! answers are right.
//!
//! ```text
//! cargo bench --bench standard                               # all runs, 200 random ones among them
//! cargo bench --bench standard -- --random 20                # fewer random ones
//! cargo bench --bench standard -- --only ring,minicircle
//! cargo bench --bench standard -- --csv new.csv --compare old.csv
//! ```
//!
//! One thread. Iterations are the same on every machine, seconds (of the processor) are not. A run whose answer is off
//! does not pass. References are exact (shooting, closed forms), or the same rod's on a finer mesh where it says so.

#![allow(clippy::print_stdout, clippy::unwrap_used, clippy::expect_used, missing_docs)]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/knots.rs"]
mod knots;
#[path = "../tests/common/play.rs"]
mod play;
#[path = "../src/math/random.rs"]
mod random;
#[path = "../tests/common/supercoiling.rs"]
mod supercoiling;
#[path = "../tests/common/tally.rs"]
mod tally;

use std::path::{Path, PathBuf};

use clap::Parser;
use play::{Clock, Limit, Row, Watch, play, play_watched, within_limit};
use supercoil::observe::observe;
use supercoil::scene::Scene;
use supercoil::solve::Options;
use supercoiling::Way;

/// Standard runs: iterations, cut-backs, seconds, and a checked answer.
#[derive(Parser)]
struct Choices {
    /// Runs to make, separated by commas [default: all].
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    only: Vec<String>,
    /// Random supercoiling runs, turn by turn and at once.
    #[arg(long, default_value_t = 200)]
    random: u64,
    /// Seconds of the processor after which a run is stopped.
    #[arg(long, default_value_t = 300.0)]
    limit: f64,
    /// Where to write a row for every run.
    #[arg(long, default_value = "target/families/standard.csv")]
    csv: PathBuf,
    /// Rows of an earlier run to compare with.
    #[arg(long)]
    compare: Option<PathBuf>,
    /// Given by cargo.
    #[arg(long, hide = true)]
    bench: bool,
}

/// Makes the rows of a run.
type Make = fn(&Choices) -> Vec<Row>;

/// The runs by name.
const RUNS: [(&str, Make); 9] = [
    ("ring", ring),
    ("minicircle", minicircle),
    ("puc19", puc19),
    ("random", |choices| random_supercoiling(choices, "random", Way::TurnByTurn)),
    ("random_at_once", |choices| random_supercoiling(choices, "random_at_once", Way::AtOnce)),
    ("lambda", lambda),
    ("two_ply", two_ply),
    ("five_strand_cable", five_strand_cable),
    ("coaxial_clamps", coaxial_clamps),
];

/// A row does not pass if a number is off its reference by more than a relative tolerance.
fn expect(row: &mut Row, what: &str, found: f64, reference: f64, tolerance: f64) {
    println!("  {} {}: {what} {found:.9e}, reference {reference:.9e}", row.family, row.case);
    if !within_limit((found - reference).abs(), tolerance * reference.abs()) {
        row.passed = false;
        let reason = format!("{what} is {found:.6e}, not {reference:.6e}");
        row.reason =
            [row.reason.as_str(), &reason].iter().filter(|r| !r.is_empty()).copied().collect::<Vec<_>>().join("; ");
    }
}

fn limit(choices: &Choices) -> Limit {
    Limit { seconds: choices.limit, clock: Clock::Processor }
}

fn file(path: &str) -> Scene {
    Scene::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// The twisted ring, D/L = .02, C/B = 1.5, 32 cubic elements, to an excess link of 3.6 in 36 steps. References by
/// shooting, for a rod that neither stretches nor shears.
fn ring(choices: &Choices) -> Vec<Row> {
    let text = "[[rods]]\nclosed = true\nshape = { kind = \"circle\", length = 1.0 }\n\
        section = { bending = 1.0, twisting = 1.5, stretching = 1e6, shearing = 1e6, contact_radius = 0.01 }\n\
        elements = 32\n[[stages]]\nramp = { excess_link = { to = 3.6 } }\nsteps = 36\n";
    let scene = Scene::from_toml(text, Path::new("")).unwrap();
    let mut seen = Vec::new();
    let mut row = play_watched("ring", "36 steps", scene, limit(choices), &mut |progress| {
        let at = 3.6 * progress.fraction;
        if [1.2, 1.6, 3.0].iter().any(|wanted| (at - wanted).abs() < 1e-9) {
            seen.push(observe(progress));
        }
    })
    .row;
    if let [one, more, line] = &seen[..] {
        expect(&mut row, "contact force at 1.2", one.total_contact_force, 48.701169, 2e-3);
        expect(&mut row, "contact force at 1.6", more.total_contact_force, 169.920755, 2e-3);
        expect(&mut row, "writhe at 3", line.links[0].writhe, 2.371617, 1e-3);
        expect(&mut row, "elastic energy at 3", line.energies.total - line.energies.contact, 112.061, 1e-3);
    }
    vec![row]
}

fn one(choices: &Choices, name: &str, scene: Scene) -> Vec<Row> {
    let steps: usize = scene.stages.iter().map(|stage| stage.steps).sum();
    vec![play(name, &format!("{steps} steps"), scene, limit(choices)).row]
}

/// The README's minicircle.
fn minicircle(choices: &Choices) -> Vec<Row> {
    one(choices, "minicircle", file("examples/minicircle.toml"))
}

/// pUC19 from the flat circle in 20 steps.
fn puc19(choices: &Choices) -> Vec<Row> {
    let mut scene = file("examples/puc19.toml");
    scene.stages[0].steps = 20;
    one(choices, "puc19", scene)
}

/// Phage λ from a plectoneme.
fn lambda(choices: &Choices) -> Vec<Row> {
    one(choices, "lambda", file("examples/lambda_phage.toml"))
}

/// Wires laid with twist and tension.
fn five_strand_cable(choices: &Choices) -> Vec<Row> {
    one(choices, "five_strand_cable", file("tests/scenes/five_strand_cable.toml"))
}

/// Rings and trefoils of random thickness, C/B, link and start.
fn random_supercoiling(choices: &Choices, name: &str, way: Way) -> Vec<Row> {
    let run = |seed: u64| {
        let clock = Watch::new(Clock::Processor);
        let options = Options { threads: Some(1), ..Options::default() };
        let run = supercoiling::go(supercoiling::start(seed), way, &options);
        Row {
            family: name.to_owned(),
            case: seed.to_string(),
            passed: run.passed(),
            status: run.status.to_string(),
            steps: run.steps,
            planned: run.planned,
            iterations: run.iterations,
            elsewhere: run.elsewhere,
            seconds: clock.seconds(),
            energy: run.energy,
            link_error: Some(run.link_error),
            topology_kept: Some(run.knot[0] == run.knot[1]),
            ..Row::default()
        }
    };
    (0..choices.random).map(run).collect()
}

/// Two rods wound round each other and turned until they carry no torque, against closed forms.
fn two_ply(_: &Choices) -> Vec<Row> {
    let run = |(alpha, turns): (f64, f64)| {
        let clock = Watch::new(Clock::Processor);
        let plies = common::two_ply::without_torque(alpha, turns);
        let mut row = Row {
            family: "two_ply".to_owned(),
            case: format!("angle {alpha}"),
            passed: true,
            status: "converged".to_owned(),
            steps: plies.len(),
            planned: plies.len(),
            iterations: plies.iter().map(|ply| ply.iterations).sum(),
            seconds: clock.seconds(),
            per_step: plies.iter().map(|ply| ply.iterations.to_string()).collect::<Vec<_>>().join(" "),
            ..Row::default()
        };
        let ply = &plies[plies.len() - 1];
        let [moment, tail, pressure] = ply.exact();
        expect(&mut row, "twisting moment", -ply.moment, moment, 1e-3);
        expect(&mut row, "tension of the tails", ply.tail, tail, 1e-3);
        expect(&mut row, "contact force per length", ply.pressure, pressure, 1e-3);
        row
    };
    [(0.35, 3.0), (0.5, 4.0)].into_iter().map(run).collect()
}

/// A rod between coaxial clamps, turned and brought together, its axis in three directions: the same energy.
fn coaxial_clamps(choices: &Choices) -> Vec<Row> {
    let run = |direction: [f64; 3]| {
        let size = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let to = direction.map(|x| -0.15 * x / size);
        let text = format!(
            "[[rods]]\nshape = {{ kind = \"line\", direction = {direction:?}, length = 1.0 }}\n\
             section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }}\n\
             elements = 60\n[[supports]]\nat = \"start\"\nposition = true\nrotation = true\n\
             [[supports]]\nat = \"end\"\nposition = true\nrotation = true\n\
             [[stages]]\nsteps = 8\nramp = {{ displacement = {{ at = \"end\", to = {to:?} }}, \
             rotation = {{ at = \"end\", axis = {direction:?}, turns = 1.0 }} }}\n"
        );
        let scene = Scene::from_toml(&text, Path::new("")).unwrap();
        play("coaxial_clamps", &format!("{direction:?}"), scene, limit(choices)).row
    };
    let mut rows: Vec<Row> = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 2.0, -0.5]].into_iter().map(run).collect();
    let energy = rows[0].energy;
    rows.iter_mut().for_each(|row| expect(row, "energy", row.energy, energy, 1e-7));
    rows
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let choices = Choices::parse();
    let before = choices.compare.as_deref().map(tally::read).transpose()?;
    let mut rows = Vec::new();
    for (name, run) in RUNS {
        if choices.only.is_empty() || choices.only.iter().any(|only| only == name) {
            let mut new = run(&choices);
            let of = |count: fn(&Row) -> usize| new.iter().map(count).sum::<usize>();
            println!("{name}: {} iterations, {} cut-backs", of(|row| row.iterations), of(|row| row.cutbacks));
            rows.append(&mut new);
            tally::write(&choices.csv, &rows)?;
        }
    }
    println!();
    tally::print(&rows);
    if let Some(before) = before {
        tally::compare(&before, &rows);
    }
    println!("\nrows: {}", choices.csv.display());
    Ok(())
}
