//! What is refused, and how it is told: the key, the value and what is allowed.

use super::*;

#[test]
fn unknown_keys_are_named_with_line_and_allowed_keys() {
    refused(RING, "bending", "bendig", &["unknown field `bendig`", "line 8", "`bending`", "`contact_radius`"]);
    refused(RING, "title", "tittle", &["unknown field `tittle`", "line 2", "`title`", "`stages`"]);
    refused(RING, "length = 114.24", "length = 114.24, lenght = 1", &["unknown field `lenght`", "line 7", "`radius`"]);
    refused(RING, "every", "evry", &["unknown field `evry`", "`every`", "`picture`"]);
    refused(RING, "excess_link", "excess", &["unknown field `excess`", "`excess_link`", "`pressure`"]);
    refused(RING, "to = -3.0", "till = -3.0", &["unknown field `till`", "`to`"]);
    let knot = "kind = \"torus_knot\", windings = [2, 3], aspekt = 0.4, length";
    refused(RING, "kind = \"circle\", length", knot, &["unknown field `aspekt`", "`aspect`"]);
    refused(BEAM, "curvature", "kurvature", &["unknown field `kurvature`", "`curvature`", "`twist`"]);
    refused(BEAM, "{ arc = 1.6 }", "{ s = 1.6 }", &["unknown field `s`", "`arc`"]);
}

#[test]
fn missing_and_ill_typed_values_are_named() {
    refused(RING, "elements = 12", "", &["rods.dna.elements", "missing", "fidelity"]);
    refused(
        RING,
        "elements = 12",
        "elements = -3",
        &["elements = -3", "invalid value", "expected a whole number of at least 0"],
    );
    refused(RING, "length = 114.24", "length = \"long\"", &["string \"long\"", "expected a number"]);
    refused(RING, "closed = true", "closed = 1", &["integer `1`", "expected true or false"]);
    refused(RING, "\"ring\"", "7", &["integer `7`", "expected text in quotes"]);
    refused(RING, "twisting = 308.6,", "", &["rods.dna.section.twisting: missing", "bending, twisting"]);
    refused(RING, ", contact_radius = 2.5", "", &["rods.dna.section.contact_radius: missing"]);
    refused(RING, "kind = \"circle\"", "kind = \"square\"", &["unknown variant `square`", "`circle`", "`helix`"]);
    refused(RING, "\"augmented-lagrangian\"", "\"lagrange\"", &["unknown variant `lagrange`", "`penalty`", "`none`"]);
    refused(BEAM, "\"start\"", "\"middle\"", &["string \"middle\"", "\"start\", \"end\", a node index"]);
    refused(BEAM, "position = true", "position = [\"w\"]", &["string \"w\"", "\"x\", \"y\", \"z\""]);
    refused(BEAM, "natural = {", "natural = \"bent\" #", &["string \"bent\"", "\"as-shaped\""]);
    refused(BEAM, "order = 2", "order = [", &["TOML parse error at line"]);
}

/// Where a key is missing is told as `--set` would address it, not by line only.
#[test]
fn tables_without_a_key_are_named() {
    for (text, from, place) in [
        (RING, "shape = { kind = \"circle\", length = 114.24 }\n", "line 4, column 1\n  |\n4 | [[rods]]"),
        (RING, "shape = { kind = \"circle\", length = 114.24 }\n", "missing field `shape` in rods.dna"),
        (RING, "kind = \"circle\", ", "missing field `kind` in rods.dna.shape"),
        (RING, ", to = -3.0", "missing field `to` in stages.0.ramp.excess_link"),
        (BEAM, "at = { arc = 1.6 }\n", "missing field `at` in supports.1"),
    ] {
        refused(text, from, "", &[place]);
    }
}

/// Before, numbers beyond those that are meant were dropped without a word.
#[test]
fn lists_of_the_wrong_length_are_refused() {
    let three = ["a list of 3 numbers", "invalid length"];
    for (from, to) in [
        ("force = [0, 0, -1]", "force = [0, 0, -1, 5]"),
        ("force = [0, 0, -1]", "force = [0, -1]"),
        ("force = [0, 0, -1]", "force = [0, 0, -1]\nmoment = [0, 0, 0, 0]"),
        ("axis = [0, 0, 1]", "axis = [0, 0, 1, 0]"),
        ("length = 2.0", "length = 2.0, start = [0, 0, 0, 0]"),
    ] {
        refused(BEAM, from, to, &three);
    }
    let two = ["a list of 2 numbers", "invalid length"];
    refused(BEAM, "curvature = [0.1, 0]", "curvature = [0.1, 0, 0]", &two);
    refused(BEAM, "[1.0, 0.1]", "[1.0, 0.1, 0.1]", &two);
    refused(RING, "205.7", "[205.7, 205.7, 1.0]", &two);
    refused(RING, "205.7", "[205.7]", &two);
    refused(RING, "kind = \"circle\"", "kind = \"torus_knot\", windings = [2, 3, 4]", &two);
}

#[test]
fn bad_numbers_are_named_with_value_and_range() {
    refused(RING, "205.7", "nan", &["rods.dna.section.bending[0] = NaN: must be a finite number greater than 0"]);
    refused(RING, "205.7", "[205.7, -1]", &["rods.dna.section.bending[1] = -1"]);
    refused(RING, "114.24", "0.0", &["rods.dna.shape.length = 0: must be a finite number greater than 0"]);
    refused(RING, "114.24", "inf", &["rods.dna.shape.length = inf"]);
    refused(RING, "to = -3.0", "to = nan", &["stages[0].ramp.excess_link.to = NaN"]);
    refused(RING, "steps = 30", "steps = 0", &["stages[0].steps = 0: must be at least 1"]);
    refused(RING, "elements = 12", "elements = 12\norder = 4", &["rods.dna.order = 4: must be 1, 2 or 3"]);
    refused(RING, "elements = 12", "elements = 0", &["elements = 0: must be at least 1"]);
    refused(RING, "1e-8", "1.5", &["contact.tol_penetration = 1.5: must be between 0 and 1"]);
    refused(RING, "every = 2", "every = 0", &["output.every = 0: must be at least 1"]);
    refused(RING, "[output]", "[solver]\nthreads = 0\n[output]", &["solver.threads = 0"]);
    refused(RING, "elements = 12", "elements = 12\nexcess_link = nan", &["rods.dna.excess_link = NaN"]);
    refused(RING, "elements = 12", "elements = 12\nexcess_link = 40", &["rods.dna.excess_link", "use more elements"]);
    refused(BEAM, "order = 2", "order = 2\nexcess_link = 1.0", &["rods.beam.excess_link: the rod is open"]);
    refused(BEAM, "poisson = 0.25", "poisson = 0.7", &["rods.beam.section.poisson = 0.7: must be greater than -1"]);
    refused(BEAM, "[1.0, 0.1]", "[1.0, -0.1]", &["rods.beam.section.rectangle[1] = -0.1"]);
    refused(BEAM, "arc = 1.6", "arc = 2.6", &["supports[1].at.arc = 2.6: must be between 0 and the length"]);
    refused(BEAM, "at = 0", "at = 9", &["stages[0].ramp.rotation.at = 9"]);
    refused(BEAM, "axis = [0, 0, 1]", "axis = [0, 0, 0]", &["axis = (0, 0, 0): must be finite and not zero"]);
    refused(BEAM, "force = [0, 0, -1]", "force = [0, nan, -1]", &["loads[0].force = (0, NaN, -1)"]);
}

#[test]
fn ill_posed_scenes_are_refused_with_a_reason() {
    let thick = ["rods.dna: a rod thicker than its own curvature allows", "contact_radius = 19", "0.05500"];
    refused(RING, "contact_radius = 2.5", "contact_radius = 19", &thick);
    let loose = ["rods.beam: loads[0] acts on it", "along (0, 0, -1)", "would fall for ever"];
    refused(BEAM, "position = true", "position = [\"x\"]", &loose);
    let heavy = |keys: &str| format!("elements = 4\n{keys}\n");
    let gravity = "gravity = [0, 0, -9.81]\n[[rods]]";
    refused(BEAM, "[[rods]]", gravity, &["gravity: pulls at nothing", "density, a mass or a weight"]);
    refused(BEAM, "elements = 4", &heavy("mass = 2.0"), &["rods.beam.mass: has no meaning without gravity"]);
    let with_gravity = BEAM.replacen("[[rods]]", gravity, 1);
    let both = ["rods.beam: density, mass and weight say one thing"];
    refused(&with_gravity, "elements = 4", &heavy("mass = 2.0\nweight = 1.0"), &both);
    refused(&with_gravity, "elements = 4", &heavy("mass = -2.0"), &["rods.beam.mass = -2"]);
    refused(BEAM, "[[rods]]", "load = inf\n[[rods]]", &["load = inf: must be a finite number"]);
    refused(BEAM, "elements = 4", &heavy("binding = 0.5"), &["rods.beam.binding", "has neither"]);
    refused(
        BEAM,
        "load = 2.0, ",
        "binding = { to = 0.5 }, ",
        &["stages[0].ramp.binding", "no natural state that could"],
    );
    refused(BEAM, "at = 0,", "at = 3,", &["stages[0].ramp.rotation", "no support that fixes its rotation"]);
    refused(RING, "closed = true", "", &["rods.dna.shape: a circle is closed"]);
    refused(BEAM, "order = 2", "closed = true", &["rods.beam.shape: a line is open"]);
    refused(RING, "rod = \"dna\"", "rod = \"rna\"", &["excess_link.rod = \"rna\": must be one of \"dna\""]);
    let both = &["rods.dna.section: keys of both kinds", "either by bending"];
    refused(RING, "bending = 205.7", "bending = 205.7, young = 1.0", both);
    refused(
        RING,
        "augmented-lagrangian",
        "penalty",
        &["contact.tol_penetration: has no meaning with law = \"penalty\""],
    );
    refused(RING, "title", "planar = true\ntitle", &["\"dna\" is in a planar scene"]);
    refused(BEAM, "position = [\"y\"]", "position = false", &["supports[1]: names no component"]);
    let again = "[[rods]]\nname = \"dna\"\nshape = { kind = \"line\", length = 1 }\n\
        section = { young = 1, poisson = 0, circle = 1 }\nelements = 1\n[contact]";
    refused(RING, "[contact]", again, &["rods[1].name = \"dna\": must be a name that no other rod has"]);
}

#[test]
fn link_is_said_once_and_twist_of_open_rods_only() {
    let parts = ["rods.dna: excess_link, sigma, link and twist say one thing"];
    refused(RING, "elements = 12", "elements = 12\nexcess_link = 1\nlink = 1", &parts);
    refused(RING, "elements = 12", "elements = 12\ntwist = 1", &["rods.dna.twist: the rod is closed"]);
    refused(BEAM, "order = 2", "order = 2\ntwist = 4", &["rods.beam.twist: 4 turns are more than 0.4"]);
    refused(BEAM, "order = 2", "order = 2\nlink = 1", &["rods.beam.link: the rod is open"]);
}
