//! Sweeps: thousands of runs of one scene with other values. A sweep file is planned into cases, any number of
//! processes run the cases in any order, and their results are collected into one table.
//!
//! ```toml
//! scene = "minicircle.toml"                                # the base scene, relative to this file
//! rows = "last"                                            # a row a case; "all" (default): a row each accepted step
//!
//! [set]                                                    # what all cases share
//! "rods.dna.elements" = 24
//!
//! [axes]                                                   # every combination; keys as in `run --set`
//! "rods.dna.dna.salt_mM" = [20, 50, 150]
//! "stages.0.ramp.sigma.to" = { from = -0.08, to = -0.02, count = 7 }
//!
//! [[linked]]                                               # go together, first with first
//! "rods.dna.dna.base_pairs" = [200, 336]
//! "stages.0.steps" = [10, 20]
//!
//! [random]                                                 # every combination with each of so many draws
//! seed = 1
//! draws = 100
//! [random.keys]
//! "rods.dna.dna.bending_persistence" = { normal = [50.0, 3.0] }
//! ```
//!
//! Draws are `uniform = [low, high]`, `normal = [mean, deviation]`, `whole = [low, high]` (whole numbers, both ends
//! included), `choice = [...]` and `bases = N` (a word of N letters A, C, G, T). A draw depends on the seed, its key
//! and its number only.
//!
//! The folder of a sweep:
//!
//! | file | content |
//! |---|---|
//! | `plan.jsonl` | the base scene, then a line a case: id and values as `KEY=VALUE` |
//! | `parts/HASH.parquet` | rows of finished cases; the name is the hash of the content, so that a part that was cut short is seen |
//! | `parts/….tmp` | a part being written; it gets its name when it is on the disk |
//! | `table.parquet` | all rows in the order of the plan, written by [`collect()`](collect()) |
//!
//! The id of a case is the hash of its scene in canonical form (values replaced, keys in order; title, outputs and
//! threads left out), of the files that it names, and of the version of this format. A sweep that is planned again with
//! more values keeps what was computed. A case that fails is a row with status and message; the column `notes` has
//! warnings about a state.

mod case;
mod collect;
mod columns;
mod file;
mod parquet;
mod parts;
mod plan;
mod plot;
mod random;
mod run;

pub use collect::{Collected, SweepStatus, collect, finished_ids, merge, ranges, status};
pub use columns::{Column, ColumnValues, SweepTable};
pub use file::Rows;
pub use parquet::{from_bytes, to_bytes};
pub use parts::write_part;
pub use plan::{Case, PLAN, Plan};
pub use plot::{PlotAxes, plot};
pub use run::{Shard, SweepRun, Tally};
