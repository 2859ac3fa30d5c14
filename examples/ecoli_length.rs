//! A closed DNA as long as the chromosome of E. coli, a million nodes (units nm, pN; `examples/ecoli_length.toml`),
//! from the plectoneme of its link: how long it takes to come to rest, and its middle beside the closed forms.
//!
//! `cargo run --release --example ecoli_length`
#![allow(clippy::print_stdout)] // an example talks to its reader

mod plasmid;

fn main() -> Result<(), supercoil::solve::RunError> {
    println!("{:#?}", plasmid::run("ecoli_length.toml")?);
    Ok(())
}
