//! Features of scenes: axes, their values, and the combinations that there are not.

/// One kind of feature and its values. A value is a word that no other axis has.
pub struct Axis {
    pub name: &'static str,
    pub values: &'static [&'static str],
}

/// Number of axes.
pub const NUM_AXES: usize = 13;

/// All axes, those with the most values first among those that exclude each other most.
pub const AXES: [Axis; NUM_AXES] = [
    Axis {
        name: "ramp",
        values: &[
            "load_factor",
            "link",
            "rotation",
            "round",
            "displacement",
            "pose",
            "lift",
            "radius",
            "stiffness",
            "length",
            "nature",
            "pressure",
        ],
    },
    Axis { name: "support", values: &["clamp", "clamps", "pin", "slide", "spin", "unsupported"] },
    Axis { name: "section", values: &["isotropic", "anisotropic", "full", "tapered", "sequence"] },
    Axis { name: "load", values: &["unloaded", "force", "moment", "line_force", "line_moment"] },
    Axis { name: "natural", values: &["straight", "curved", "table", "shaped"] },
    Axis { name: "law", values: &["by_mesh", "augmented", "penalty", "no_contact"] },
    Axis { name: "order", values: &["cubic", "quadratic", "linear"] },
    Axis { name: "rods", values: &["single", "joined", "crossing"] },
    Axis { name: "change", values: &["kept", "hold", "release"] },
    Axis { name: "topology", values: &["open", "closed"] },
    Axis { name: "space", values: &["spatial", "planar"] },
    Axis { name: "plane", values: &["no_plane", "floor"] },
    Axis { name: "charge", values: &["uncharged", "charged"] },
];

/// A value of each axis.
pub type Features = [usize; NUM_AXES];

/// Axis and value of a word.
pub fn place_of(word: &str) -> (usize, usize) {
    let found = AXES.iter().enumerate().find_map(|(axis, it)| {
        let value = it.values.iter().position(|value| *value == word)?;
        Some((axis, value))
    });
    found.unwrap_or_else(|| panic!("\"{word}\" is no feature"))
}

/// Whether a scene has the feature called `word`.
pub fn has(features: &Features, word: &str) -> bool {
    let (axis, value) = place_of(word);
    features[axis] == value
}

/// The words of a scene.
pub fn words(features: &Features) -> Vec<&'static str> {
    AXES.iter().zip(features).map(|(axis, &value)| axis.values[value]).collect()
}

/// A combination that is refused: one value of each list (of one axis each) together.
pub struct Refusal {
    pub together: &'static [&'static [&'static str]],
    /// A part of the message with which the scene is refused.
    pub message: &'static str,
}

const VARYING: &[&str] = &["table", "shaped"];

/// Every combination that scenes refuse, with the refusal.
pub const REFUSALS: &[Refusal] = &[
    // ramps
    Refusal { together: &[&["load_factor"], &["unloaded"]], message: "there are no loads to ramp" },
    Refusal { together: &[&["link"], &["open"]], message: "only a closed rod has an excess link" },
    Refusal { together: &[&["link"], &["planar"]], message: "excess link needs space" },
    Refusal { together: &[&["pressure"], &["open"]], message: "the only kind that takes pressure" },
    Refusal { together: &[&["pressure"], &["spatial"]], message: "the only kind that takes pressure" },
    Refusal { together: &[&["lift"], &["no_plane"]], message: "plane" },
    Refusal { together: &[&["rotation", "round"], &["unsupported"]], message: "no support that fixes its rotation" },
    Refusal { together: &[&["displacement"], &["unsupported"]], message: "in a direction that no support fixes" },
    Refusal { together: &[&["pose"], &["unsupported"]], message: "is not clamped at this node" },
    Refusal {
        together: &[&["stiffness"], &["full", "tapered", "sequence"]],
        message: "its single numbers cannot be ramped",
    },
    Refusal { together: &[&["length", "nature"], VARYING], message: "need uniform ones" },
    Refusal { together: &[&["length", "nature"], &["sequence"]], message: "need uniform ones" },
    Refusal { together: &[&["length", "radius"], &["tapered"]], message: "a contact radius that varies along it" },
    // sections and natural states
    Refusal {
        together: &[&["sequence"], &["curved", "table", "shaped"]],
        message: "the sequence gives the natural strains",
    },
    Refusal { together: &[&["full", "tapered", "sequence"], &["planar"]], message: "planar = true, but" },
    // supports
    Refusal { together: &[&["unsupported"], &["moment", "line_moment"]], message: "free to turn" },
    Refusal { together: &[&["unsupported"], &["force", "line_force"], &["no_plane"]], message: "acts on it" },
    Refusal { together: &[&["unsupported"], &["release"]], message: "changes nothing" },
    Refusal { together: &[&["clamp"], &["release"], &["force", "line_force"]], message: "would fall for ever" },
    Refusal { together: &[&["clamp"], &["release"], &["moment", "line_moment"]], message: "free to turn" },
    // contact
    Refusal { together: &[&["floor"], &["no_contact"]], message: "no rod can touch it" },
    Refusal { together: &[&["charged"], &["no_contact"]], message: "charged rods need contact" },
];

/// Combinations that are accepted and have no state to come to: rods repel each other and nothing holds one of them.
pub const UNBOUND: &[&[&[&str]]] =
    &[&[&["charged"], &["crossing"], &["unsupported"]], &[&["charged"], &["crossing"], &["clamp"], &["release"]]];

/// Places of the words of a combination.
pub fn parts(together: &[&[&str]]) -> Vec<(usize, Vec<usize>)> {
    let part = |words: &&[&str]| {
        let places: Vec<(usize, usize)> = words.iter().map(|word| place_of(word)).collect();
        assert!(places.iter().all(|place| place.0 == places[0].0), "{words:?} are of several axes");
        (places[0].0, places.into_iter().map(|place| place.1).collect())
    };
    together.iter().map(part).collect()
}
