//! The genome of phage λ, closed, at the supercoiling density of bacteria (units nm, pN; `examples/lambda_phage.toml`),
//! from the plectoneme of its link: how long it takes to come to rest, and its middle beside the closed forms.
//!
//! `cargo run --release --example lambda_phage`
#![allow(clippy::print_stdout)] // an example talks to its reader

mod plasmid;

fn main() -> Result<(), supercoil::solve::RunError> {
    println!("{:#?}", plasmid::run("lambda_phage.toml")?);
    Ok(())
}
