//! Scenes to begin with.

/// A commented scene that runs as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Template {
    /// Name, one word.
    pub name: &'static str,
    /// Description, one line.
    pub about: &'static str,
    /// The scene file.
    pub text: &'static str,
}

macro_rules! template {
    ($name:literal, $about:literal) => {
        template!($name, $about, "assets/scenes")
    };
    ($name:literal, $about:literal, $folder:literal) => {
        Template {
            name: $name,
            about: $about,
            text: include_str!(concat!("../../../../", $folder, "/", $name, ".toml")),
        }
    };
}

/// All scenes to begin with.
pub const TEMPLATES: [Template; 12] = [
    template!("minicircle", "a DNA minicircle supercoils"),
    template!("plasmid", "a plasmid, from the flat circle to a plectoneme"),
    template!("loop", "DNA between two sites that a protein holds: both ends' poses"),
    template!("tweezers", "DNA pulled and turned until it winds up", "examples"),
    template!("knot", "the equilibrium of a closed trefoil knot"),
    template!("overhand", "an overhand knot between grips, pulled tight"),
    template!("hanging", "a rope between two hooks under its weight, one hook moved in"),
    template!("net", "a net of pinned cords, hung by its corners"),
    template!("cable", "three wires twisted into a cable"),
    template!("pulley", "a rope over a pulley: 5 N hold 5 N"),
    template!("tube", "a rod in a tube, pushed in at one end"),
    template!("capsid", "a DNA ring in a capsid that shrinks"),
];
