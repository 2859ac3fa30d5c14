//! Writes the reference of keys of scene files from their types: `cargo run -p supercoil-tools --bin reference`.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../src/scene/reference.md");
    std::fs::write(page, supercoil::scene::file::reference())
}
