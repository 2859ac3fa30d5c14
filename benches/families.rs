//! Families of random scenes, and the scenes of `tests/scenes`: how many come to rest, in how many Newton iterations.
//!
//! ```text
//! cargo bench --bench families                                        # all families, 50 cases each, and the scenes
//! cargo bench --bench families -- --families tweezers,beams --number 10 --limit 30
//! cargo bench --bench families -- --csv new.csv --compare old.csv
//! cargo bench --bench families -- --write tweezers 7                  # a scene file for the command line
//! ```
//!
//! Every case runs on one thread, and is stopped when its time is up. What the solver calls converged is checked again:
//! gaps, forces out of balance, link, knots. Iterations are the same on every machine, seconds are not: they are those
//! of the processor, or on the clock where several cases run at a time.

#![allow(clippy::print_stdout, clippy::print_stderr, missing_docs)]

#[path = "../tests/common/families/mod.rs"]
mod families;
#[path = "../tests/common/knots.rs"]
mod knots;
#[path = "../tests/common/play.rs"]
mod play;
#[path = "../src/math/random.rs"]
mod random;
#[path = "../tests/common/tally.rs"]
mod tally;

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Parser;
use families::{CASES, Case, FAMILIES, Family};
use play::{Clock, Limit, Row, play};
use supercoil::InputError;
use supercoil::scene::Scene;

/// What the scenes of `tests/scenes` are called among the families.
const SCENES: &str = "scenes";

/// Families of random scenes, and the scenes of tests/scenes.
#[derive(Parser)]
struct Choices {
    /// Families to run, separated by commas; "scenes" are those of tests/scenes [default: all].
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    families: Vec<String>,
    /// Cases of each family.
    #[arg(long, default_value_t = CASES)]
    number: u64,
    /// Index of the first case.
    #[arg(long, default_value_t = 0)]
    from: u64,
    /// Seconds after which a case is stopped: of the processor, or on the clock where several cases run at a time.
    #[arg(long, default_value_t = 100.0)]
    limit: f64,
    /// Cases that run at a time, each on one thread.
    #[arg(long, default_value_t = 1)]
    jobs: usize,
    /// Where to write a row for every case.
    #[arg(long, default_value = "target/families/families.csv")]
    csv: PathBuf,
    /// Rows of an earlier run to compare with.
    #[arg(long)]
    compare: Option<PathBuf>,
    /// Write the scene file of one case to --dir, and run nothing.
    #[arg(long, num_args = 2, value_names = ["FAMILY", "INDEX"])]
    write: Option<Vec<String>>,
    /// Folder of the scene files.
    #[arg(long, default_value = "target/families")]
    dir: PathBuf,
    /// Given by cargo.
    #[arg(long, hide = true)]
    bench: bool,
}

impl Choices {
    fn limit(&self) -> Limit {
        let clock = if self.jobs > 1 { Clock::Wall } else { Clock::Processor };
        Limit { seconds: self.limit, clock }
    }
}

/// Something to run.
enum Job {
    Case(&'static str, Case),
    Scene(PathBuf),
}

impl Job {
    /// Family and case.
    fn name(&self) -> (&str, String) {
        match self {
            Self::Case(family, case) => (family, case.name.rsplit('_').next().unwrap_or_default().to_owned()),
            Self::Scene(path) => (SCENES, path.file_stem().unwrap_or_default().to_string_lossy().into_owned()),
        }
    }

    fn scene(&self, dir: &Path) -> Result<Scene, InputError> {
        match self {
            Self::Case(_, case) => case.scene(dir),
            Self::Scene(path) => Scene::read(path),
        }
    }

    fn run(&self, choices: &Choices) -> Row {
        let (family, case) = self.name();
        match self.scene(&choices.dir) {
            Ok(scene) => play(family, &case, scene, choices.limit()).row,
            Err(error) => Row {
                family: family.to_owned(),
                case,
                status: "refused".to_owned(),
                reason: error.to_string(),
                ..Row::default()
            },
        }
    }
}

/// Scene files of `tests/scenes`, by name.
fn scenes() -> Vec<PathBuf> {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes");
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut found: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    found.sort();
    found
}

fn jobs(choices: &Choices) -> Result<Vec<Job>, String> {
    let everything = || FAMILIES.iter().map(|family| family.name.to_owned()).chain([SCENES.to_owned()]).collect();
    let names: Vec<String> = if choices.families.is_empty() { everything() } else { choices.families.clone() };
    let mut jobs = Vec::new();
    for name in names {
        if name == SCENES {
            jobs.extend(scenes().into_iter().map(Job::Scene));
            continue;
        }
        let family = named(&name)?;
        let indices = choices.from..choices.from + choices.number;
        jobs.extend(indices.map(|index| Job::Case(family.name, family.case(index))));
    }
    Ok(jobs)
}

fn named(name: &str) -> Result<&'static Family, String> {
    let known = || FAMILIES.map(|family| family.name).join(", ");
    Family::named(name).ok_or_else(|| format!("\"{name}\" is no family; there are {} and {SCENES}", known()))
}

/// Writes one case and says where.
fn write(family: &str, index: &str, dir: &Path) -> Result<(), String> {
    let index = index.parse().map_err(|_| format!("\"{index}\" is no index"))?;
    let path = named(family)?.case(index).write(dir).map_err(|error| error.to_string())?;
    println!("{}", path.display());
    Ok(())
}

/// Runs all jobs, so many at a time; rows in the order of the jobs. The file of rows is written anew after every one.
fn run_all(jobs: &[Job], choices: &Choices) -> Vec<Row> {
    let (next, rows) = (AtomicUsize::new(0), Mutex::new(vec![None; jobs.len()]));
    let work = || {
        while let Some((k, job)) = Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|k| Some((k, jobs.get(k)?))) {
            let row = job.run(choices);
            println!(
                "{} {}: {} in {} iterations, {} of {} steps, {} cut-backs, {:.1} s {}",
                row.family,
                row.case,
                if row.passed { "passed" } else { &row.status },
                row.iterations,
                row.steps,
                row.planned,
                row.cutbacks,
                row.seconds,
                row.reason
            );
            let mut rows = rows.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            rows[k] = Some(row);
            let done: Vec<Row> = rows.iter().flatten().cloned().collect();
            if let Err(error) = tally::write(&choices.csv, &done) {
                eprintln!("{}: {error}", choices.csv.display());
            }
        }
    };
    std::thread::scope(|scope| {
        (0..choices.jobs.max(1)).for_each(|_| {
            scope.spawn(work);
        });
    });
    rows.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).into_iter().flatten().collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let choices = Choices::parse();
    if let Some([family, index]) = choices.write.as_deref() {
        return Ok(write(family, index, &choices.dir)?);
    }
    let before = choices.compare.as_deref().map(tally::read).transpose()?;
    let jobs = jobs(&choices)?;
    let rows = run_all(&jobs, &choices);
    println!();
    tally::print(&rows);
    if let Some(before) = before {
        tally::compare(&before, &rows);
    }
    println!("\nrows: {}", choices.csv.display());
    Ok(())
}
