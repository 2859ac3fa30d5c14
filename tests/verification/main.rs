//! Closed forms and published cases: one module a physical case; its header gives source and parameters.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on; rows for whoever asks

#[path = "../common/mod.rs"]
mod common;
#[path = "../../benches/inputs.rs"]
#[allow(dead_code)] // each module uses its part
mod inputs;
#[path = "../common/plectoneme.rs"]
mod plectoneme;
#[path = "../../src/math/random.rs"]
mod random;

mod bathe_bolourchi;
mod beams;
mod bound_states;
mod bowed_and_turned;
mod chain_of_rings;
mod clamped_pop;
mod contact_three_strands;
mod deep_arch;
mod distributed_moment;
mod dna_rings;
mod elastic_knots;
mod elastica_branches;
mod electrostatics;
mod free_energies;
mod greenhill;
mod hanging;
mod helical_spring;
mod ibrahimbegovic_helix;
mod intrinsic_curvature;
mod lateral_buckling;
mod lee_frame;
mod michell_zajac;
mod modes;
mod obstacles;
mod path_corners;
mod pins_and_hinges;
mod planar_touch;
mod planes;
mod plectoneme_under_tension;
mod princeton;
mod ring_branches;
mod ring_events;
mod ring_thickness;
mod ring_topology;
mod roll_up;
mod ropelength;
mod sensitivities;
mod shallow_arch;
mod turned_rods;
mod tweezers;
mod twisted_ring;
mod two_ply;
mod varying_rods;
mod writhe_of_long_curves;
