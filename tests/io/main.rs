//! Scene files, tables, pictures, checkpoints, examples.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on; rows for whoever asks

#[path = "../common/mod.rs"]
mod common;
#[path = "../../examples/crossed_beams.rs"]
#[allow(dead_code)] // each module uses its part
mod crossed_beams;
#[path = "../../examples/dna_minicircle.rs"]
#[allow(dead_code)] // each module uses its part
mod dna_minicircle;
#[path = "../../examples/elastica.rs"]
#[allow(dead_code)] // each module uses its part
mod elastica;
#[path = "../../examples/lee_frame.rs"]
#[allow(dead_code)] // each module uses its part
mod lee_frame;
#[path = "../common/plectoneme.rs"]
mod plectoneme;
#[path = "../../examples/ring_pressure.rs"]
#[allow(dead_code)] // each module uses its part
mod ring_pressure;

mod dna_examples;
mod examples;
mod export;
mod fences;
mod final_state;
mod fuzz_scenes;
mod gallery;
mod long_output;
mod paraview;
mod pictures;
mod planes;
mod program;
mod scene_files;
mod scene_help;
mod scene_reference;
mod scene_tables;
mod stage_changes;
mod survive;
mod sweep;
mod tangent;
mod tasks;
mod told;
mod view;
