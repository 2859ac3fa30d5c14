//! Scene files: what is accepted means what it says, what is refused is refused with the key, the value and what is
//! allowed.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::io::run::run_scene;
use supercoil::math::{Quat, Vec3};
use supercoil::rod::{Natural, Plectoneme, Shape};
use supercoil::scene::{ContactLaw, Fidelity, Joint, NodeRef, PosePath, Ramp, Scene};
use supercoil::solve::{Options, Solver, Status};

const RING: &str = r#"
title = "ring"
units = { length = "nm", force = "pN" }
[[rods]]
name = "dna"
closed = true
shape = { kind = "circle", length = 114.24 }
section = { bending = 205.7, twisting = 308.6, stretching = 1100, shearing = 1100.0, contact_radius = 2.5 }
elements = 12
[contact]
law = "augmented-lagrangian"
tol_penetration = 1e-8
[[stages]]
ramp = { excess_link = { rod = "dna", to = -3.0 } }
steps = 30
[output]
every = 2
"#;

const BEAM: &str = r#"
[[rods]]
name = "beam"
shape = { kind = "line", length = 2.0 }
section = { young = 12.0, poisson = 0.25, rectangle = [1.0, 0.1], contact_radius = 0.05 }
elements = 4
order = 2
natural = { curvature = [0.1, 0], twist = 0.2 }
[[supports]]
at = "start"
position = true
rotation = true
[[supports]]
at = { arc = 1.6 }
position = ["y"]
[[loads]]
at = "end"
force = [0, 0, -1]
[[stages]]
ramp = { load = 2.0, rotation = { at = 0, axis = [0, 0, 1], turns = 0.5 } }
steps = 5
"#;

fn read(text: &str) -> Result<Scene, supercoil::InputError> {
    Scene::from_toml(text, Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").as_path())
}

/// The message after replacing `from`, which must be there, by `to`.
fn refusal(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    read(&text.replacen(from, to, 1)).map(|_| format!("accepted: {to}")).unwrap_or_else(|error| error.to_string())
}

/// Asserts that the message holds every part.
fn refused(text: &str, from: &str, to: &str, parts: &[&str]) {
    let message = refusal(text, from, to);
    for part in parts {
        assert!(message.contains(part), "\"{part}\" is not in: {message}");
    }
}

#[test]
fn ring_means_what_it_says() {
    let scene = read(RING).unwrap();
    assert_eq!((scene.title.as_str(), scene.units.length.as_str(), scene.output.every), ("ring", "nm", 2));
    let rod = &scene.model.rods[0];
    assert_eq!((rod.order, rod.num_elements, rod.num_nodes(), rod.closed), (3, 12, 36, true));
    assert_eq!((rod.section.bending, rod.section.stretching), ([205.7; 2], 1100.0));
    assert_eq!(scene.model.contact.law, ContactLaw::ByMesh { least: 10.0, tol_penetration: 1e-8 });
    assert_eq!(scene.stages[0].ramps, [Ramp::ExcessLink { rod: 0, to: -3.0 }]);
    assert_eq!(scene.stages[0].steps, 30);
}

#[test]
fn beam_means_what_it_says() {
    let scene = read(BEAM).unwrap();
    let (model, rod) = (&scene.model, &scene.model.rods[0]);
    assert_eq!(rod.natural, Natural::Uniform { kappa: [0.1, 0.0, 0.2] });
    assert!((rod.section.bending[0] - 12.0 * 1e-3 / 12.0).abs() < 1e-15);
    assert_eq!(model.supports[1].node, NodeRef { rod: 0, node: 6 });
    assert_eq!((model.supports[1].position, model.supports[1].rotation), ([false, true, false], [false; 3]));
    assert_eq!((model.loads[0].node.node, model.loads[0].force), (8, -Vec3::z()));
    let rotation = Ramp::Rotation { node: NodeRef { rod: 0, node: 0 }, axis: Vec3::z(), to: 0.5 };
    assert_eq!(scene.stages[0].ramps, [rotation, Ramp::Load { to: 2.0 }]);
}

#[test]
fn the_examples_are_accepted() {
    let plain = ["minicircle", "elastica", "ring_pressure", "crossed_beams", "puc19", "pbr322", "lambda_phage"];
    for name in plain.into_iter().chain(["cable", "loop_between_poses"]) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(format!("{name}.toml"));
        Scene::read(&path).unwrap_or_else(|error| panic!("{error}"));
    }
}

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
    let loose = ["rods.beam: loads[0] acts on it", "free to move as a rigid body", "rotation about the axis"];
    refused(BEAM, "rotation = true", "rotation = [\"z\"]", &loose);
    refused(BEAM, "load = 2.0, ", "", &["no stage ramps their factor", "load = 1.0"]);
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
    let again = "[[rods]]\nname = \"dna\"\nshape = { kind = \"line\", length = 1 }\nsection = { young = 1, poisson = 0, circle = 1 }\nelements = 1\n[contact]";
    refused(RING, "[contact]", again, &["rods[1].name = \"dna\": must be a name that no other rod has"]);
}

#[test]
fn points_come_from_files_beside_the_scene() {
    let points = "kind = \"points\", file = \"oval.csv\"";
    let scene = read(&RING.replace("kind = \"circle\", length = 114.24", points).replace("= 2.5", "= 0.1")).unwrap();
    let rod = &scene.model.rods[0];
    assert!((rod.length - 6.2838).abs() < 1e-3, "{}", rod.length);
    assert_eq!(rod.start_excess_link, 0.0);
    let none = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no_points.csv");
    std::fs::write(&none, "x,y,z\n# none\n").unwrap();
    let empty = format!("kind = \"points\", file = {none:?}");
    refused(RING, "kind = \"circle\", length = 114.24", &empty, &["no_points.csv: holds no points"]);
    let absent = "kind = \"points\", file = \"nowhere.csv\"";
    refused(RING, "kind = \"circle\", length = 114.24", absent, &["nowhere.csv", "No such file"]);
}

/// The unit circle as the file `name` holds it, closed; the text after the shape's `file`.
fn imported(name: &str, text: &str, keys: &str) -> Result<supercoil::rod::Rod, String> {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&file, text).unwrap();
    let points = format!("kind = \"points\", file = {file:?}{keys}");
    let scene = read(&RING.replace("kind = \"circle\", length = 114.24", &points).replace("= 2.5", "= 0.1"));
    scene.map(|mut scene| scene.model.rods.remove(0)).map_err(|error| error.to_string())
}

/// What people have centrelines in, all the same circle; the closing point repeated or not.
#[test]
fn centrelines_come_in_many_formats() {
    let circle: Vec<[f64; 2]> =
        (0..=40).map(|k| f64::from(k) * std::f64::consts::TAU / 40.0).map(|t| [t.cos(), t.sin()]).collect();
    let rows = |points: &[[f64; 2]], row: &dyn Fn(usize, f64, f64) -> String| -> String {
        points.iter().enumerate().map(|(i, [x, y])| row(i, *x, *y)).collect()
    };
    let open = &circle[..40];
    let csv = |points: &[[f64; 2]]| format!("x,y,z\n{}", rows(points, &|_, x, y| format!("{x},{y},0\n")));
    let reference = imported("circle.csv", &csv(open), "").unwrap();
    assert!((reference.length - std::f64::consts::TAU).abs() < 1e-4);
    let pandas = format!(",force,x,z,y\n{}", rows(open, &|i, x, y| format!("{i},1e3,{x},0.0,{y}\n")));
    let named = format!("X (A),Y (A),t,n\n{}", rows(open, &|_, x, y| format!("{},{},{},0\n", 10.0 * x, 10.0 * y, 7)));
    let line = |_: usize, x: f64, y: f64| format!("P {x} {y} 0\n");
    let frames = format!("3\nold\nC 1 2 3\nC 2 3 4\nC 9 9 9\n40\nnew\n{}", rows(open, &line));
    let vertex = |_: usize, x: f64, y: f64| format!("{x} {y} 0\n");
    let vect = format!("VECT\n1 40 1\n-40\n1\n{}0 0 1 1\n", rows(open, &vertex));
    let atom = |i: usize, x: f64, y: f64| {
        format!("ATOM  {i:>5}  P    DA B{i:>4}    {:>8.3}{:>8.3}{:>8.3}  1.00\n", 100.0 * x, 100.0 * y, 0.0)
    };
    let pdb = rows(open, &atom) + "TER\nATOM      1  P    DT C   1       0.000   0.000   9.000  1.00\n";
    for (name, text, keys, tolerance) in [
        ("repeated.csv", csv(&circle), "", 1e-12),
        ("pandas.csv", pandas, "", 1e-12),
        ("named.csv", named, ", columns = [\"X (A)\", \"Y (A)\", \"n\"], scale = 0.1", 1e-12),
        ("twice.csv", csv(&circle), ", every = 2", 1e-4),
        ("frames.xyz", frames.clone(), ", frame = -1", 1e-12),
        ("frames.xyz", frames.clone(), ", frame = 1", 1e-12),
        ("circle.vect", vect, "", 1e-12),
        ("circle.pdb", pdb.clone(), ", chain = \"B\", scale = 0.01", 1e-4),
    ] {
        let rod = imported(name, &text, keys).unwrap();
        let apart = rod.positions.iter().zip(&reference.positions).map(|(a, b)| (a - b).norm());
        let most = apart.fold(0.0, f64::max);
        assert!(rod.num_nodes() == reference.num_nodes() && most < tolerance, "{name}{keys}: {most:e}");
    }
    for (name, text, keys, part) in [
        ("frames.xyz", frames, "", "holds 2 frames: say which by frame"),
        ("chains.pdb", pdb, "", "has chains B, C: say which by chain"),
        ("columns.csv", csv(open), ", columns = [\"x\", \"y\"]", "rods.dna.shape.columns: takes three names"),
        ("columns.csv", csv(open), ", columns = [\"x\", \"y\", \"w\"]", "no column \"w\"; the head line has x, y, z"),
        ("every.csv", csv(open), ", every = 0", "rods.dna.shape.every = 0"),
        ("scale.csv", csv(open), ", scale = -1", "rods.dna.shape.scale = -1"),
    ] {
        let message = imported(name, &text, keys).unwrap_err();
        assert!(message.contains(part), "{part} is not in: {message}");
    }
}

/// The ring as a plectoneme, with `keys` more on the shape and `link` on the rod.
fn plectoneme(keys: &str, link: &str) -> String {
    let shape = format!("kind = \"plectoneme\", length = 114.24{keys}");
    RING.replace("kind = \"circle\", length = 114.24", &shape)
        .replace("elements = 12", &format!("elements = 48\n{link}"))
}

#[test]
fn plectonemes_are_wound_by_link_turns_or_angle() {
    let rod = |keys: &str, link: &str| read(&plectoneme(keys, link)).unwrap().model.rods.remove(0);
    let by_link = rod("", "excess_link = -3.0");
    assert_eq!((by_link.start_excess_link, by_link.length), (-3.0, 114.24));
    let least = Plectoneme::of_link(114.24, 5.0, 205.7, 308.6, -3.0).unwrap();
    assert_eq!(by_link.positions, Shape::Plectoneme(least.clone()).place(true, 144).unwrap().positions);
    let by_turns = rod(", turns = 0.5, distance = 5.5", "excess_link = -2.5");
    assert_eq!(by_turns.start_excess_link, -2.5);
    let across = (by_turns.positions[36] - by_turns.positions[108]).norm();
    assert!((across - 5.5).abs() < 1e-9, "{across}");
    let untwisted = rod(", angle = 0.08", "");
    assert!(untwisted.start_excess_link < -1.0 && untwisted.start_excess_link > -3.0);
    let moved = rod(", center = [1, 2, 3], direction = [0, 0, 2]", "excess_link = -3");
    let middle = moved.positions.iter().sum::<Vec3>() / 144.0;
    assert!((middle - Vec3::new(1.0, 2.0, 3.0)).norm() < 1e-9);
    let coiled = rod(", axis = { kind = \"arc\", radius = 50.0, turns = 0.5 }", "excess_link = -3");
    assert_eq!(coiled.start_excess_link, -3.0);
}

#[test]
fn unfit_plectonemes_and_knots_are_refused() {
    let text = |keys: &str, link: &str| read(&plectoneme(keys, link)).unwrap_err().to_string();
    assert!(text("", "").contains("rods.dna.shape: how tightly is it wound?"));
    assert!(text(", turns = 2.0, angle = 0.1", "").contains("one of them"));
    assert!(text("", "excess_link = -1").contains("rods.dna.shape: an excess link of -1 turns is too small"));
    assert!(text("", "excess_link = 0").contains("rods.dna.excess_link = 0"));
    assert!(text(", angle = 0.2", "").contains("rods.dna.shape.angle"));
    assert!(text(", turns = 9", "").contains("rods.dna.shape.turns = 9"));
    let arc = "axis = { kind = \"arc\", radius = 9.0, turns = 1.0 }";
    assert!(text(&format!(", center = [0, 0, 0], {arc}"), "excess_link = -3").contains("remove center and direction"));
    assert!(text(", axis = { kind = \"circle\", radius = 9 }", "excess_link = -3").contains("an open curve"));
    let open = plectoneme("", "excess_link = -3").replace("closed = true", "");
    assert!(read(&open).unwrap_err().to_string().contains("a plectoneme is closed"));
    let knot = |windings: &str| {
        let shape = format!("kind = \"torus_knot\", windings = {windings}, length = 114.24");
        read(&RING.replace("kind = \"circle\", length = 114.24", &shape).replace("elements = 12", "elements = 30"))
    };
    assert!(knot("[2, 3]").unwrap().model.rods[0].start_excess_link > 3.0);
    assert!(knot("[2, 4]").unwrap_err().to_string().contains("rods.dna.shape.windings: (2, 4) is a link of 2"));
}

/// One word sets what is left open; what is given wins. (Meshes: three, eight, sixteen elements a turn, 1 + 3 turns
/// here; nodes within 2, 0.7, 0.25 of the contact distance of 5, on 114.24.)
#[test]
fn a_fidelity_sets_what_is_left_open() {
    let scene = |fidelity: &str, from: &str, to: &str| {
        let open = RING.replace("elements = 12", "").replace("tol_penetration = 1e-8", "").replace(from, to);
        read(&format!("fidelity = \"{fidelity}\"\n{open}")).unwrap()
    };
    for (word, fidelity, elements, law, tol) in [
        ("draft", Fidelity::Draft, 12, (10.0, 1e-2), 1e-4),
        ("balanced", Fidelity::Balanced, 32, (10.0, 1e-4), 1e-6),
        ("reference", Fidelity::Reference, 64, (1000.0, 1e-8), 1e-8),
    ] {
        let open = scene(word, "", "");
        assert_eq!(open.fidelity, Some(fidelity));
        let rod = &open.model.rods[0];
        assert_eq!((rod.order, rod.num_elements), (3, elements));
        let (least, tol_penetration) = law;
        assert_eq!(open.model.contact.law, ContactLaw::ByMesh { least, tol_penetration });
        let hard = scene(word, "[contact]", "[contact]\nstiffness = 300.0");
        let law = ContactLaw::AugmentedLagrangian { stiffness: 300.0, tol_penetration };
        assert_eq!(hard.model.contact.law, law);
        assert_eq!(open.solver.tol_increment, Some(tol));
        // ten times as long at the same thickness: the contact distance decides
        let long = scene(word, "length = 114.24", "length = 1142.4");
        assert_eq!(long.model.rods[0].num_elements, [39, 109, 305][fidelity as usize]);
        let quadratic = scene(word, "[contact]", "order = 2\n[contact]");
        assert_eq!(quadratic.model.rods[0].num_nodes(), 3 * elements, "as many nodes");
        let given = scene(
            word,
            "[contact]\nlaw = \"augmented-lagrangian\"",
            "elements = 17\n[solver]\ntol_increment = 1e-5\n[contact]\nlaw = \"penalty\"\nstiffness = 3.0",
        );
        assert_eq!(given.model.rods[0].num_elements, 17);
        assert_eq!(given.model.contact.law, ContactLaw::Penalty { stiffness: 3.0 });
        assert_eq!(given.solver.tol_increment, Some(1e-5));
        let off = scene(word, "law = \"augmented-lagrangian\"", "law = \"none\"");
        assert_eq!((off.model.contact.law, off.model.rods[0].num_elements), (ContactLaw::None, elements));
    }
    refused(
        RING,
        "title = \"ring\"",
        "fidelity = \"fine\"",
        &["fidelity", "`fine`", "`draft`, `balanced`, `reference`"],
    );
}

/// What a rod will go through is read from shapes, natural strains, moved supports and loads.
#[test]
fn meshes_foresee_what_a_scene_asks_for() {
    let elements = |shape: &str, rest: &str| {
        let closed = ["circle", "knot", "plectoneme", "closed"].iter().any(|word| shape.contains(word));
        let text = format!(
            "fidelity = \"balanced\"\n[contact]\nlaw = \"none\"\n[[rods]]\nname = \"a\"\nclosed = {closed}\nshape = {{ {shape} }}\n\
             section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }}\n{rest}"
        );
        read(&text).unwrap().model.rods[0].num_elements
    };
    let clamp = "[[supports]]\nat = \"start\"\nposition = true\nrotation = true\n";
    let clamps = format!("{clamp}[[supports]]\nat = \"end\"\nposition = true\nrotation = true\n");
    let line = "kind = \"line\", length = 6.283185307179586";
    assert_eq!(elements(line, ""), 8);
    assert_eq!(elements("kind = \"helix\", radius = 1.0, pitch = 1.0, turns = 5.0", ""), 40);
    assert_eq!(elements("kind = \"circle\", length = 1.0", "excess_link = -2.0"), 24);
    assert_eq!(elements(line, "natural = { curvature = [3.0, 0.0], twist = 4.0 }"), 40);
    let turned = "[[stages]]\nramp = { rotation = { at = \"end\", axis = [1, 0, 0], turns = -7.0 } }\nsteps = 1";
    assert_eq!(elements(line, &format!("{clamps}{turned}")), 56);
    let moved = "[[stages]]\nramp = { rotation = { at = \"end\", axis = [1, 0, 0], turns = 2.0 }, displacement = { at = \"end\", to = [-1, 0, 0] } }\nsteps = 1";
    assert_eq!(elements(line, &format!("{clamps}{moved}")), 24);
    for (load, turns) in [("force = [0, 0, -4.0]", 2.0 * 1.5f64.sqrt()), ("moment = [0, 3.0, 0]", 4.5)] {
        let loaded = format!("{clamp}[[loads]]\nat = \"end\"\n{load}\n[[stages]]\nramp = {{ load = 1.5 }}\nsteps = 1");
        assert_eq!(elements(line, &loaded), (8.0 * turns).ceil() as usize, "{load}");
    }
    let line_load =
        format!("{clamp}[[line_loads]]\nforce = [0, 0, -13.5]\n[[stages]]\nramp = {{ load = 2.0 }}\nsteps = 1");
    assert_eq!(elements(line, &line_load), 24);
    // measured: a trefoil turns between 2 and 5 times, and a curve through points as they say
    let knot = elements("kind = \"torus_knot\", length = 1.0, windings = [2, 3]", "");
    assert!((16..=40).contains(&knot), "{knot}");
    let plectoneme = elements("kind = \"plectoneme\", length = 1.0, distance = 0.01", "excess_link = 4.0");
    assert!((40..=64).contains(&plectoneme), "{plectoneme}");
}

/// A cantilever in two halves, joined end to end, pulled down at its tip.
const HALVES: &str = r#"
contact = { law = "none" }
[[rods]]
name = "near"
shape = { kind = "line", length = 1.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4 }
elements = 4
[[rods]]
name = "far"
shape = { kind = "line", start = [1, 0, 0], length = 1.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4 }
elements = 4
[[supports]]
rod = "near"
at = "start"
position = true
rotation = true
[[joints]]
a = { rod = "near", at = "end" }
b = { rod = "far", at = "start" }
[[loads]]
rod = "far"
at = "end"
force = [0, 0.2, -1]
[[stages]]
ramp = { load = 1.0 }
steps = 1
"#;

/// Where the last node of the last rod comes to rest at the end of the first stage.
fn tip(scene: Scene) -> Vec3 {
    let mut solver = Solver::new(scene.model, Options::default()).unwrap();
    let report = solver.step_to(&scene.stages[0].ramps).unwrap();
    assert_eq!(report.status, Status::Converged);
    let engine = solver.engine();
    engine.positions(engine.model().rods.len() - 1).last().copied().unwrap()
}

#[test]
fn joined_halves_bend_like_the_whole() {
    let scene = read(HALVES).unwrap();
    let (near, far) = (NodeRef { rod: 0, node: 12 }, NodeRef { rod: 1, node: 0 });
    assert_eq!(scene.model.joints, [Joint { a: near, b: far }]);
    let without = HALVES.split("[[joints]]").next().unwrap();
    let loads = HALVES.split("[[loads]]").nth(1).unwrap();
    let loose = format!("{without}[[loads]]{loads}");
    assert!(read(&loose).unwrap_err().to_string().contains("rods.far: loads[0] acts on it"));
    let clamp = &loose[loose.find("[[supports]]").unwrap()..loose.find("[[loads]]").unwrap()];
    let whole = format!(
        "contact = {{ law = \"none\" }}\n[[rods]]\nshape = {{ kind = \"line\", length = 2.0 }}\nsection = {{ bending = 1.0, \
         twisting = 1.0, stretching = 1e4, shearing = 1e4 }}\nelements = 8\n{clamp}[[loads]]{loads}"
    );
    let whole = read(&whole.replace("rod = \"near\"", "").replace("rod = \"far\"", "")).unwrap();
    assert_eq!(whole.model.rods[0].name, "rod");
    let (halves, whole) = (tip(scene), tip(whole));
    assert!(whole.z < -0.9, "bent: {whole}");
    assert!((halves - whole).norm() < 1e-11, "{halves} {whole}");
}

#[test]
fn joints_that_cannot_be_are_refused() {
    refused(
        HALVES,
        "b = { rod = \"far\"",
        "b = { rod = \"fur\"",
        &["joints[0].b.rod = \"fur\": must be one of \"near\""],
    );
    refused(HALVES, "a = { rod = \"near\", ", "a = { ", &["joints[0].a.rod: missing: one of \"near\", \"far\""]);
    refused(HALVES, "b = { rod = \"far\", at = \"start\" }", "", &["missing field `b`", "line 18"]);
    refused(HALVES, "at = \"start\" }", "at = 13 }", &["joints[0].b.at = 13", "the index of a node"]);
    refused(HALVES, "at = \"start\" }", "at = 1 }", &["joints[0]: joins nodes that are 0.08", "they must coincide"]);
    refused(HALVES, "rod = \"far\", at = \"start\" }", "rod = \"near\", at = \"end\" }", &["joins a node to itself"]);
    let touching = ["joints[0]: joins two rods that take part in contact", "contact_radius of 0"];
    let thick = HALVES.replace("1e4 }", "1e4, contact_radius = 0.01 }");
    refused(&thick, "contact = { law = \"none\" }", "", &touching);
    let moved = "displacement = { rod = \"far\", at = \"start\", to = [0, 0, 0] }, load =";
    refused(HALVES, "load =", moved, &["is joined to another rod at this node", "joints cannot be moved"]);
}

#[test]
fn rods_are_named_where_there_are_several() {
    let nameless = HALVES.replace("name = \"far\"", "");
    let message = read(&nameless).unwrap_err().to_string();
    assert!(message.starts_with("rods[1].name: missing: where there are several rods, each needs a name"), "{message}");
    refused(HALVES, "name = \"far\"", "name = \"near\"", &["rods[1].name = \"near\": must be a name that no other"]);
    let only = read(&BEAM.replace("name = \"beam\"", "")).unwrap();
    assert_eq!(only.model.rods[0].name, "rod");
}

/// A list of rods stands for as many tables; turned about an axis through a point, nodes are carried round together.
#[test]
fn lists_of_rods_stand_for_each() {
    let both = "rod = [\"near\", \"far\"]\nat = \"end\"\nposition = true\nrotation = true";
    let text = HALVES.replacen("[[joints]]", &format!("[[supports]]\n{both}\n[[joints]]"), 1);
    let nodes = |scene: &Scene| scene.model.supports.iter().map(|s| (s.node.rod, s.node.node)).collect::<Vec<_>>();
    assert_eq!(nodes(&read(&text).unwrap()), [(0, 0), (0, 12), (1, 12)]);
    refused(&text, "\"near\", \"far\"", "\"near\", \"fur\"", &["supports[1].rod = \"fur\": must be one of"]);
    refused(&text, "\"near\", \"far\"", "\"far\", \"far\"", &["supports[1].rod = \"far\": must be named once"]);
    refused(&text, "\"near\", \"far\"", "", &["invalid length 0", "the name of a rod or a list of names"]);
    refused(&text, "[\"near\", \"far\"]", "3", &["the name of a rod or a list of names"]);
    let turn = "rotation = { rod = \"far\", at = \"end\", axis = [1, 0, 0], through = [0, 1, 0], turns = 2.0 }";
    let turned = text.replace("ramp = { load = 1.0 }", &format!("ramp = {{ load = 1.0, {turn} }}"));
    let node = NodeRef { rod: 1, node: 12 };
    let about = Ramp::RotationAbout { node, axis: Vec3::x(), through: Vec3::y(), to: 2.0 };
    assert_eq!(read(&turned).unwrap().stages[0].ramps, [about, Ramp::Load { to: 1.0 }]);
    refused(&turned, "[0, 1, 0], turns", "[0, nan, 0], turns", &["stages[0].ramp.rotation.through = (0, NaN, 0)"]);
    refused(&turned, "turns = 2.0", "turns = 2e9", &["stages[0].ramp.rotation.turns = 2000000000: must be at most"]);
}

/// A load bends the rods that are joined to the one it acts on, too.
#[test]
fn meshes_foresee_loads_on_joined_rods() {
    let open = |text: &str| format!("fidelity = \"balanced\"\n{}", text.replace("elements = 4", ""));
    let elements =
        |text: &str| read(&open(text)).unwrap().model.rods.iter().map(|rod| rod.num_elements).collect::<Vec<_>>();
    let heavy = HALVES.replace("[0, 0.2, -1]", "[0, 0, -400]");
    let of = elements(&heavy);
    assert!(of[0] == of[1] && of[0] > elements(HALVES)[0], "{of:?}");
}

/// The pose of the only ramp of the only stage.
fn posed(keys: &str) -> Result<supercoil::scene::Pose, String> {
    let text = format!(
        "{}\n[[supports]]\nat = \"end\"\nposition = true\nrotation = true\n[[stages]]\nsteps = 1\nramp = {{ pose = {{ at = \"end\", {keys} }} }}",
        BEAM.split("[[supports]]").next().unwrap()
    );
    match read(&text).map_err(|error| error.to_string())?.stages[0].ramps[..] {
        [Ramp::Pose { node: NodeRef { rod: 0, node: 8 }, pose }] => Ok(pose),
        ref other => Err(format!("{other:?}")),
    }
}

#[test]
fn link_is_said_once_and_twist_of_open_rods_only() {
    let parts = ["rods.dna: excess_link, sigma, link and twist say one thing"];
    refused(RING, "elements = 12", "elements = 12\nexcess_link = 1\nlink = 1", &parts);
    refused(RING, "elements = 12", "elements = 12\ntwist = 1", &["rods.dna.twist: the rod is closed"]);
    refused(BEAM, "order = 2", "order = 2\ntwist = 4", &["rods.beam.twist: 4 turns are more than 0.4"]);
    refused(BEAM, "order = 2", "order = 2\nlink = 1", &["rods.beam.excess_link: the rod is open"]);
}

/// One rotation, written in three ways; relative to the start of the run, the frame there turned about the global axes.
#[test]
fn poses_mean_what_they_say() {
    let turn = Quat::from_scaled_axis(Vec3::y() * std::f64::consts::FRAC_PI_2);
    let frame = |keys: &str| posed(keys).unwrap().frame.unwrap();
    assert!(frame("axis_angle = [0, 3, 0, 0.25]").angle_to(&turn) < 1e-15);
    assert!(frame("quaternion = [0.7071068, 0, 0.7071068, 0]").angle_to(&turn) < 1e-15);
    assert!(frame("matrix = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]").angle_to(&turn) < 1e-15);
    let start = read(BEAM).unwrap().model.rods[0].frames[8];
    assert!(frame("relative = true, axis_angle = [0, 3, 0, 0.25]").angle_to(&(turn * start)) < 1e-15);
    let pose = posed("position = [1, 2, 3], path = \"screw\", extra_turns = -2").unwrap();
    assert_eq!((pose.position, pose.frame, pose.turns), (Some(Vec3::new(1.0, 2.0, 3.0)), None, Some(-2.0)));
    assert_eq!(pose.path, PosePath::Screw);
    let pose = posed("position = [0, 0, 1], relative = true").unwrap();
    assert_eq!((pose.position, pose.path), (Some(Vec3::new(2.0, 0.0, 1.0)), PosePath::Straight));
    let half = posed("axis_angle = [0, 0, 2, -0.5]").unwrap();
    assert!(half.half_turn.z < 0.0);
    for (keys, parts) in [
        ("axis_angle = [0, 0, 1, 0.75]", &["stages[0].ramp.pose.axis_angle = 0.75", "extra_turns"][..]),
        ("axis_angle = [0, 0, 0, 0.25]", &["axis_angle", "not zero"]),
        ("quaternion = [1, 1, 0, 0]", &["pose.quaternion", "length 1.414"]),
        ("matrix = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]", &["pose.matrix", "determinant -1"]),
        ("matrix = [[1, 0], [0, 1, 0], [0, 0, -1]]", &["a list of 3"]),
        ("quaternion = [1, 0, 0, 0], axis_angle = [0, 0, 1, 0.25]", &["one of quaternion, axis_angle, matrix"]),
        ("relative = true", &["goes nowhere"]),
        ("position = [0, 0, 1], path = \"line\"", &["unknown variant `line`", "`screw`"]),
    ] {
        let message = posed(keys).unwrap_err();
        parts.iter().for_each(|part| assert!(message.contains(part), "\"{part}\" is not in: {message}"));
    }
}

/// The ring of 336 base pairs in the words of those who work with it.
const DNA: &str = r#"
[[rods]]
name = "dna"
closed = true
shape = { kind = "circle" }
dna = { base_pairs = 336, salt_mM = 150, helical_repeat = 10.5 }
elements = 12
[[stages]]
ramp = { sigma = { to = -0.09375 } }
steps = 30
"#;

#[test]
fn dna_stands_for_length_section_and_radius() {
    let (scene, plain) = (read(DNA).unwrap(), read(RING).unwrap());
    let (dna, rod) = (&scene.model.rods[0], &plain.model.rods[0]);
    assert_eq!((scene.units.length.as_str(), scene.units.force.as_str()), ("nm", "pN"));
    assert!((dna.length - rod.length).abs() < 1e-12 && dna.section.contact_radius == 2.5);
    assert!((dna.section.bending[0] - 205.7).abs() < 1e-9 && (dna.section.twisting - 308.55).abs() < 1e-9);
    assert_eq!((dna.section.stretching, dna.section.shearing), (1100.0, [1100.0; 2]));
    // 336 base pairs, 32 turns
    assert_eq!(scene.stages[0].ramps, [Ramp::ExcessLink { rod: 0, to: -3.0 }]);
    assert_eq!(scene.relaxed_links, [Some(32.0)]);
    assert_eq!(
        scene.stages_from_toml("[[stages]]\nramp = { sigma = { to = 0.0625 } }\nsteps = 1").unwrap()[0].ramps,
        [Ramp::ExcessLink { rod: 0, to: 2.0 }]
    );
    let started = read(&DNA.replace("elements", "sigma = -0.03125\nelements")).unwrap();
    assert_eq!(started.model.rods[0].start_excess_link, -1.0);
    let softer =
        DNA.replace("salt_mM = 150", "diameter = 2.0, bending_persistence = 45, twist_persistence = 110, rise = 0.33");
    let rod = read(&softer).unwrap().model.rods.remove(0);
    assert!(
        (rod.section.bending[0] - 45.0 * 4.114).abs() < 1e-9 && (rod.section.twisting - 110.0 * 4.114).abs() < 1e-9
    );
    assert!(rod.section.contact_radius == 1.0 && (rod.length - 336.0 * 0.33).abs() < 1e-9);
    let (temperature, unit) = scene.thermal().unwrap();
    assert!(temperature == 300.0 && (unit - 4.141947).abs() < 1e-6);
    assert!(
        (read(&DNA.replacen("[[rods]]", "temperature = 310\n[[rods]]", 1)).unwrap().thermal().unwrap().1 - 4.280012)
            .abs()
            < 1e-6
    );
    assert!(read(BEAM).unwrap().thermal().is_none());
    for (from, to, parts) in [
        ("base_pairs = 336", "base_pairs = 0", &["rods.dna.dna.base_pairs = 0"][..]),
        ("salt_mM = 150", "salt_mM = 2", &["rods.dna.dna.salt_mM = 2", "10 and 1000 mmol/l"]),
        ("salt_mM = 150", "salt_mM = 150, diameter = 2", &["dna.diameter", "one of them"]),
        ("salt_mM = 150", "bending_persistence = -50", &["dna.bending_persistence = -50"]),
        ("\"circle\"", "\"circle\", length = 120", &["dna.base_pairs", "114.24", "120", "1 %"]),
        ("elements", "section = { bending = 1 }\nelements", &["rods.dna.section: follows from dna"]),
        ("elements", "sigma = 0.1\nexcess_link = 1\nelements", &["say one thing"]),
        ("[[rods]]", "units = { length = \"um\", force = \"pN\" }\n[[rods]]", &["rods.dna", "nm and pN", "um"]),
        ("salt_mM", "salt", &["unknown field `salt`", "did you mean `salt_mM`?"]),
    ] {
        refused(DNA, from, to, parts);
    }
    refused(RING, "{ excess_link", "{ sigma", &["stages[0].ramp.sigma", "the rod has no dna"]);
    refused(RING, "contact_radius = 2.5 }", "contact_radius = 2.5 }\nsigma = 1", &["rods.dna.sigma", "has no dna"]);
    refused(RING, "section =", "#", &["rods.dna.section: missing"]);
    refused(RING, "length = 114.24", "", &["a circle is given by its length"]);
    refused(BEAM, "[[rods]]", "temperature = 300\n[[rods]]", &["temperature", "nm and pN"]);
}

/// A run ends; its final state starts another, on the same elements (at rest at once) and on others (nearly).
#[test]
fn a_final_state_starts_another_run() {
    let ring = RING.replace("to = -3.0", "to = -1.6").replace("elements = 12", "elements = 24");
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scene_state");
    let run = |scene: Scene, name: &str| {
        let outcome = run_scene(scene, &dir.join(name), &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(outcome.status, Status::Converged);
        outcome.steps
    };
    let first = run(read(&ring.replace("steps = 30", "steps = 4")).unwrap(), "first");
    let end = first.last().unwrap();
    let file = dir.join("first/final_state.csv");
    let state = format!("kind = \"state\", file = {file:?}");
    let again = ring.split("[[stages]]").next().unwrap().replace("kind = \"circle\", length = 114.24", &state);
    let scene = read(&again.replace("elements = 24", "excess_link = -1.6")).unwrap();
    let rod = &scene.model.rods[0];
    assert_eq!((rod.num_elements, rod.num_nodes()), (24, 72));
    assert!((rod.length - 114.24).abs() < 1e-9);
    let same = run(scene, "again").remove(0);
    assert!((same.energies.total / end.energies.total - 1.0).abs() < 1e-6, "{:?} {:?}", same.energies, end.energies);
    assert!(same.iterations < 40, "{} iterations from a state at rest", same.iterations);
    let finer = read(&again.replace("elements = 24", "elements = 32\nexcess_link = -1.6")).unwrap();
    assert_eq!(finer.model.rods[0].num_nodes(), 96);
    let finer = run(finer, "finer").remove(0);
    assert!((finer.energies.total / end.energies.total - 1.0).abs() < 1e-2, "{:?} {:?}", finer.energies, end.energies);
    assert!((finer.links[0].link + 1.6).abs() < 1e-9, "{:?}", finer.links);
    // without it the link is that of the nodes: right to a part of a turn
    let measured = read(&again.replace("elements = 24", "")).unwrap().model.rods[0].start_excess_link;
    assert!((measured + 1.6).abs() < 1e-2, "{measured}");
    let refused = |from: &str, to: &str| read(&again.replace(from, to)).unwrap_err().to_string();
    assert!(refused("kind = \"state\"", "kind = \"state\", rod = 1").contains("has no rod 1"));
    std::fs::remove_dir_all(&dir).unwrap();
}
