//! `supercoil new KIND`.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use supercoil::InputError;
use supercoil::scene::Scene;
use supercoil::scene::file::TEMPLATES;

use super::CONVERGED;
use super::print::say;

#[derive(Args)]
pub struct NewArguments {
    /// Which.
    #[arg(value_parser = kinds())]
    kind: String,
    /// File to write; must not be there yet [default: KIND.toml]. Of a knot its name, too: `new knot 8_19` writes
    /// knot_8_19.toml.
    file: Option<PathBuf>,
}

fn kinds() -> clap::builder::PossibleValuesParser {
    TEMPLATES.map(|template| clap::builder::PossibleValue::new(template.name).help(template.about)).into()
}

impl NewArguments {
    pub fn go(self) -> Result<u8, InputError> {
        let Self { kind, file } = self;
        let text = TEMPLATES.iter().find(|template| template.name == kind).map_or("", |template| template.text);
        let knot =
            file.as_deref().filter(|_| kind == "knot").and_then(Path::to_str).and_then(|name| knot_scene(text, name));
        let (file, text) = match knot {
            Some(knot) => (PathBuf::from(format!("knot_{}.toml", file.unwrap_or_default().display())), knot?),
            None => (file.unwrap_or_else(|| PathBuf::from(format!("{kind}.toml"))), text.to_owned()),
        };
        let refuse = |e: std::io::Error| InputError::Write { path: file.clone(), reason: e.to_string() };
        let mut made = std::fs::File::create_new(&file).map_err(refuse)?;
        made.write_all(text.as_bytes()).map_err(refuse)?;
        say(format_args!("wrote {0}; to run it: supercoil run {0}", file.display()));
        Ok(CONVERGED)
    }
}

/// The scene of a knot by its name; `None` for words that are no such name.
fn knot_scene(template: &str, name: &str) -> Option<Result<String, InputError>> {
    let (crossings, index) = name.split_once('_')?;
    let is_name = [crossings, index].iter().all(|part| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit()));
    is_name.then(|| {
        let shape = "kind = \"torus_knot\", windings = [2, 3], length = 300.0";
        // strands two diameters apart; the mesh follows from the length, which differs from knot to knot
        let text = template.replace(shape, &format!("kind = \"knot\", name = \"{name}\", distance = 6.0"));
        let text = text.replace("[[rods]]", "fidelity = \"balanced\"\n\n[[rods]]");
        let text = text.lines().filter(|line| !line.starts_with("elements = ")).collect::<Vec<_>>().join("\n") + "\n";
        let text = text.replace("A closed trefoil knot", &format!("A closed knot {name}"));
        let text = text.replace("elastic trefoil knot", &format!("elastic knot {name}"));
        // a name that there is not is refused here, not by the first run
        Scene::from_toml(&text, Path::new("")).map(|_| text)
    })
}
