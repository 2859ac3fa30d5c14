//! Scenes that must agree with each other: every relation for every scene, as a table.
//!
//! ```text
//! cargo bench --bench relations                                  # all 150 scenes
//! cargo bench --bench relations -- --scenes 003,017 --verbose    # some, with each difference that is too large
//! cargo bench --bench relations -- --write 003 --dir found       # a scene file for the command line
//! cargo bench --bench relations -- --scenes 000,001 --keep part  # in parts: differences are appended to a file
//! cargo bench --bench relations -- --of part                     # the table of such a file
//! ```

#![allow(clippy::print_stdout, clippy::print_stderr, missing_docs)]

#[path = "../src/math/random.rs"]
mod random;
#[path = "../tests/common/relations/mod.rs"]
mod relations;

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use clap::Parser;
use relations::draft::{Draft, Mesh};
use relations::known::{KNOWN, is_known};
use relations::relation::{Findings, Relation, examine};
use relations::{scenes, tally};

/// Scenes that must agree with each other.
#[derive(Parser)]
struct Choices {
    /// Scenes, by their numbers, separated by commas [default: all].
    #[arg(long, value_delimiter = ',', value_name = "NUMBERS")]
    scenes: Vec<String>,
    /// Relations, by their names, separated by commas [default: all].
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    relations: Vec<String>,
    /// Print each difference that is too large.
    #[arg(long)]
    verbose: bool,
    /// Write the file of one scene, and run nothing.
    #[arg(long, value_name = "NUMBER")]
    write: Option<String>,
    /// Append all differences to a file.
    #[arg(long, value_name = "FILE")]
    keep: Option<PathBuf>,
    /// Print the table of a file of differences, and run nothing.
    #[arg(long, value_name = "FILE")]
    of: Option<PathBuf>,
    /// Folder of the scene files.
    #[arg(long, default_value = "target/relations")]
    dir: PathBuf,
    /// Given by cargo.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let choices = Choices::parse();
    let all = scenes();
    if let Some(name) = &choices.write {
        let scene = all.iter().find(|scene| scene.name == *name).ok_or("there is no such scene")?;
        println!("{}", scene.write(&choices.dir, Mesh::Times(1))?.display());
        return Ok(());
    }
    if let Some(file) = &choices.of {
        report(&tally::from_lines(&std::fs::read_to_string(file)?));
        return Ok(());
    }
    let chosen = |list: &[String], name: &str| list.is_empty() || list.iter().any(|it| it == name);
    let wanted: Vec<Relation> =
        Relation::ALL.into_iter().filter(|relation| chosen(&choices.relations, relation.name())).collect();
    let mut found = Vec::new();
    for scene in all.iter().filter(|scene| chosen(&choices.scenes, &scene.name)) {
        found.push(run(scene, &choices, &wanted)?);
    }
    report(&found);
    Ok(())
}

/// Prints the table, what is known and what is not.
fn report(found: &[Findings]) {
    println!("{}", tally::table(found));
    let broken =
        |it: &Findings| it.broken().into_iter().map(|relation| (relation, it.name.clone())).collect::<Vec<_>>();
    let (known, new): (Vec<_>, Vec<_>) =
        found.iter().flat_map(broken).partition(|(relation, scene)| is_known(*relation, scene));
    for it in KNOWN {
        println!("Known: {}, scenes {}: {}", it.relation.name(), it.scenes.join(", "), it.reason);
    }
    println!("{} scenes; {} relations broken that are known, {} that are not.", found.len(), known.len(), new.len());
    for (relation, scene) in new {
        println!("New: {scene}, {}", relation.name());
    }
}

fn run(scene: &Draft, choices: &Choices, wanted: &[Relation]) -> std::io::Result<Findings> {
    let started = Instant::now();
    let found = examine(scene, &choices.dir, wanted);
    if choices.verbose {
        println!("{} ({:.1} s)", scene.title(), started.elapsed().as_secs_f64());
        for it in found.differences.iter().filter(|it| !it.agrees()) {
            println!("    {}, {}: {:.1e}", it.relation.name(), it.quantity.name(), it.size);
        }
        found.notes.iter().for_each(|note| println!("    {note}"));
        for (name, [without, with]) in &found.checks {
            println!("    check {name}: {without:.1e} without contact, {with:.1e} with");
        }
    }
    if let Some(file) = &choices.keep {
        let mut file = std::fs::OpenOptions::new().create(true).append(true).open(file)?;
        file.write_all(tally::lines(&found).as_bytes())?;
    }
    Ok(found)
}
