//! pBR322 supercoils from the flat circle to the supercoiling density of bacteria (units nm, pN;
//! `examples/pbr322.toml`): how long it takes, and the middle of its plectoneme beside the closed forms.
//!
//! `cargo run --release --example pbr322`
#![allow(clippy::print_stdout)] // an example talks to its reader

mod plasmid;

fn main() -> Result<(), supercoil::solve::RunError> {
    println!("{:#?}", plasmid::run("pbr322.toml")?);
    Ok(())
}
