//! The reference of keys (`supercoil help scene`) holds: each default that is written there is the one that a scene
//! without the key has, and of each range of numbers or list of words the ends are taken and what is just outside is
//! refused. What is told in words (`the only rod`) is listed here, so that nothing is left out unseen.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::path::Path;
use std::sync::OnceLock;

use supercoil::io::csv::{RodState, write_state};
use supercoil::math::{Quat, Vec3};
use supercoil::scene::file::{Key, keys};
use supercoil::scene::{Scene, Units};
use supercoil::solve::Options;

const SECTION: &str = "bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 1e-5";

/// A scene with `@` in the place of an assignment to a key of this table; for keys that need others with those.
fn template(key: &Key) -> String {
    let rod = |more: &str| format!("[[rods]]\nelements = 12\nsection = {{ {SECTION} }}\n{more}\n");
    let line = || rod("shape = { kind = \"line\", length = 6.0 }");
    let ring = || rod("closed = true\nshape = { kind = \"circle\", length = 6.0 }");
    let shape = |kind: &str, more: &str| rod(&format!("{more}shape = {{ {kind}, @ }}"));
    let section = |more: &str| {
        let shape = "shape = { kind = \"line\", length = 6.0 }";
        format!("[[rods]]\nelements = 12\n{shape}\nsection = {{ {more}@ }}\n")
    };
    let dna = |more: &str| {
        format!(
            "[[rods]]\nname = \"dna\"\nelements = 12\nclosed = true\nshape = {{ kind = \"circle\" }}\n\
             dna = {{ {more}@ }}\n"
        )
    };
    let held = || "[[supports]]\nat = \"start\"\nposition = true\nrotation = true\n";
    let clamped = || line() + held() + &held().replace("start", "end");
    let ramp = |more: &str| format!("[[stages]]\nramp = {{ {more} }}\n");
    let charged = "elements = 48\nclosed = true\nshape = { kind = \"circle\", length = 600.0 }";
    let charged = format!("[[rods]]\n{charged}\nsection = {{ {} }}\n", SECTION.replace("1e-5", "1.0"));
    let planar = || "planar = true\n".to_owned() + &ring();
    let heavy = |rod: &str| "gravity = [0, 0, -1]\n".to_owned() + rod + "@\n" + held();
    let bound = || ring() + &format!("natural = {{ table = \"{}\" }}\n@\n", natural());
    match (key.table.as_str(), key.name.as_str()) {
        ("scene", "temperature") => "@\nunits = { length = \"nm\", force = \"pN\" }\n".to_owned() + &ring(),
        ("scene", "rods") | ("rods.shape", "kind") => String::new(),
        ("scene", "gravity") => "@\n".to_owned() + &ring() + "mass = 1.0\n" + held(),
        ("scene", _) => "@\n".to_owned() + &ring(),
        ("rods", "density") => heavy(&section("young = 1.0, poisson = 0.3, circle = 0.1, ").replace('@', "")),
        ("rods", "mass" | "weight") => heavy(&ring()),
        ("rods", "binding") => bound(),
        ("rods", "elements") => ring().replace("elements = 12", "@"),
        ("rods", "closed") => line() + "@\n",
        ("rods", "twist") => line() + "@\n",
        ("rods", _) => ring() + "@\n",
        ("rods.shape", "fit") => {
            let circle = "shape = { kind = \"circle\" }";
            let points = "shape = { kind = \"points\", file = \"oval.csv\", @ }";
            dna("base_pairs = 336, diameter = 1e-3, ").replace('@', "").replace(circle, points)
        }
        ("rods.shape", name) => {
            let kind = key.kind.as_deref().unwrap();
            let others = match (kind, name) {
                ("line", "length") => "",
                ("line", _) => "length = 6.0, ",
                ("circle", "length" | "radius") => "",
                ("circle", _) => "length = 6.0, ",
                ("arc", "turns") => "radius = 1.0, ",
                ("arc", "radius") => "turns = 0.25, ",
                ("arc", "tangent") => "radius = 1.0, turns = 0.25, towards = [0, 1, 0], ",
                ("arc", "towards") => "radius = 1.0, turns = 0.25, tangent = [1, 0, 0], ",
                ("arc", _) => "radius = 1.0, turns = 0.25, ",
                ("helix", "radius") => "pitch = 1.0, turns = 2.0, ",
                ("helix", _) => "radius = 1.0, pitch = 1.0, turns = 2.0, ",
                ("knot", "length" | "distance") => "name = \"3_1\", ",
                ("knot", "component") => "braid = [1, 1, 1], length = 60.0, ",
                ("knot", "name" | "braid" | "pd") => "length = 60.0, ",
                ("knot", _) => "name = \"3_1\", length = 60.0, ",
                ("overhand", "length") => "radius = 1e-5, ",
                ("overhand", "radius") => "length = 0.03, ",
                ("overhand", _) => "length = 6.0, radius = 0.1, ",
                ("torus_knot", "length") => "windings = [2, 3], ",
                ("torus_knot", _) => "length = 6.0, windings = [2, 3], ",
                ("plectoneme", "angle") => "length = 6.0, distance = 0.2, ",
                ("plectoneme", "distance") => "length = 6.0, turns = 3, ",
                ("plectoneme", "length") => "distance = 1e-5, turns = 0.5, ",
                ("plectoneme", _) => "length = 6.0, distance = 0.2, turns = 1, ",
                ("points", _) => "file = \"oval.csv\", ",
                ("state", _) => &format!("file = \"{}\", ", state()),
                (kind, name) => panic!("no scene for {name} of a {kind}"),
            };
            let closed = ["circle", "points", "knot", "torus_knot", "plectoneme"].contains(&kind);
            shape(&format!("{others}kind = \"{kind}\""), if closed { "closed = true\n" } else { "" })
        }
        ("rods.beads", "radius") => line() + "beads = [{ at = 18, @ }]\n",
        ("rods.beads", _) => line() + "beads = [{ at = 18, radius = 0.1, @ }]\n",
        ("rods.section", "contact_radius") => {
            section("bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, ")
        }
        ("rods.section", "young") => section("poisson = 0.3, circle = 0.1, "),
        ("rods.section", "poisson" | "shear_modulus") => section("young = 1.0, circle = 0.1, "),
        ("rods.section", "circle") => section("young = 1.0, poisson = 0.3, "),
        ("rods.section", "rectangle") => section("young = 1.0, poisson = 0.3, contact_radius = 0.0, "),
        ("rods.section", "shear_correction") => section("young = 1.0, poisson = 0.3, circle = 0.1, "),
        ("rods.section", name) => {
            let others = SECTION.split(", ").filter(|other| !other.starts_with(name)).collect::<Vec<_>>();
            section(&(others.join(", ") + ", "))
        }
        ("rods.dna", "base_pairs") => dna("diameter = 1e-3, "),
        ("rods.dna", "rise") => dna("base_pairs = 336, diameter = 1e-3, "),
        ("rods.dna", _) => dna("base_pairs = 336, "),
        ("rods.sequence", _) => {
            let letters = "ACGT".repeat(15);
            let shape =
                "elements = 12\nshape = { kind = \"line\", length = 20.06 }\nsection = { contact_radius = 1.0 }";
            format!("[[rods]]\n{shape}\nsequence = {{ letters = \"{letters}\", steps = \"ideal\", @ }}\n")
        }
        ("supports", _) => {
            line()
                + "[[supports]]\nat = \"start\"\n@\n"
                + if key.name == "position" { "rotation" } else { "position" }
                + " = true\n"
        }
        ("loads", _) => clamped() + "[[loads]]\nat = 3\n@\n" + &ramp("load = 1.0"),
        ("line_loads", _) => clamped() + "[[line_loads]]\n@\n" + &ramp("load = 1.0"),
        ("planes", "normal") => ring() + "[[planes]]\npoint = [-9, -9, -9]\n@\n",
        ("planes", _) => {
            ring().replace("length = 6.0", "length = 6.0, center = [0, 0, 1]") + "[[planes]]\nnormal = [0, 0, 1]\n@\n"
        }
        ("obstacles", name) => {
            let cylinder = ["point", "axis"].contains(&name);
            let shape = if cylinder { "cylinder" } else { "sphere" };
            let keys = [
                ("shape", format!("shape = \"{shape}\"\n")),
                ("radius", "radius = 0.2\n".to_owned()),
                ("axis", if cylinder { "axis = [0, 0, 1]\n".to_owned() } else { String::new() }),
            ];
            let others: String = keys.into_iter().filter(|(key, _)| *key != name).map(|(_, text)| text).collect();
            let center = if name == "side" { "" } else { ", center = [9, 9, 9]" };
            let radius = if name == "side" { others.replace("0.2", "0.01") } else { others };
            ring().replace("length = 6.0", &format!("length = 6.0{center}")) + "[[obstacles]]\n" + &radius + "@\n"
        }
        ("obstacles.hinge", name) => {
            let axis = if name == "axis" { "" } else { "axis = [0, 0, 1], " };
            ring().replace("length = 6.0", "length = 6.0, center = [9, 9, 9]")
                + &format!("[[obstacles]]\nshape = \"sphere\"\nradius = 0.2\nhinge = {{ {axis}@ }}\n")
        }
        ("contact", _) => ring() + "[contact]\n@\n",
        ("contact.electrostatics", "debye_length") => charged + "[contact]\nelectrostatics = { strength = 1e-3, @ }\n",
        ("contact.electrostatics", "strength") => charged + "[contact]\nelectrostatics = { debye_length = 2.0, @ }\n",
        ("contact.electrostatics", name) => {
            let salt = if name == "charge" { "salt_mM = 150, " } else { "" };
            dna("base_pairs = 336, ").replace('@', "") + &format!("[contact]\nelectrostatics = {{ {salt}@ }}\n")
        }
        ("joints", "axis") => joined() + "kind = \"hinge\"\n@\n",
        ("joints", _) => joined() + "@\n",
        ("stages", _) => ring() + &ramp("excess_link = { to = 1.0 }") + "@\n",
        ("stages.ramp", "binding") => bound().replace('@', "") + &ramp("@"),
        ("stages.ramp", _) => ring() + &ramp("@"),
        ("stages.ramp.rotation", "axis") => clamped() + &ramp("rotation = { at = \"end\", turns = 1.0, @ }"),
        ("stages.ramp.rotation", "turns") => {
            clamped() + &ramp("rotation = { at = \"end\", axis = [1, 0, 0], through = [0, 0, 0], @ }")
        }
        ("stages.ramp.pose", name) => {
            let place = if name == "position" { "" } else { "position = [5.5, 0, 0], " };
            clamped() + &ramp(&format!("pose = {{ at = \"end\", {place}@ }}"))
        }
        ("stages.ramp.obstacle", name) => {
            let other = if name == "displacement" { "radius = 0.3" } else { "displacement = [0, 0, 0.1]" };
            let hinge = "[[obstacles]]\nshape = \"sphere\"\nradius = 0.2\nhinge = { axis = [0, 0, 1] }\n";
            ring().replace("length = 6.0", "length = 6.0, center = [9, 9, 9]")
                + hinge
                + &ramp(&format!("obstacle = {{ {other}, @ }}"))
        }
        ("stages.ramp.section", _) => ring() + &ramp("section = { @ }"),
        ("stages.follow", "max_step") => ring() + &ramp("excess_link = { to = 1.0 }") + "follow = { step = 0.05, @ }\n",
        ("stages.follow", _) => ring() + &ramp("excess_link = { to = 1.0 }") + "follow = { @ }\n",
        ("solver", _) => ring() + "[solver]\n@\n",
        ("output", "view") => ring() + "[output]\nvtk = true\n@\n",
        ("output", _) => ring() + "[output]\n@\n",
        ("picture", "up") => ring() + "[picture]\ncamera = [1, 0, 0]\n@\n",
        ("picture", _) => ring() + "[picture]\n@\n",
        ("stages.ramp.natural", _) => planar(),
        (table, name) => panic!("no scene for {table}.{name}"),
    }
}

/// Two rods in line, the first clamped; the table of their joint goes on.
fn joined() -> String {
    let rod = |name: &str, start: f64| {
        format!(
            "[[rods]]\nname = \"{name}\"\nelements = 6\n\
             shape = {{ kind = \"line\", start = [{start:?}, 0, 0], direction = [1, 0, 0], length = 6.0 }}\n\
             section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.1 }}\n"
        )
    };
    rod("a", 0.0)
        + &rod("b", 6.0)
        + "[[supports]]\nrod = \"a\"\nat = \"start\"\nposition = true\nrotation = true\n\
           [[joints]]\na = { rod = \"a\", at = \"end\" }\nb = { rod = \"b\", at = \"start\" }\n"
}

/// Path of a file that is written once: tests run side by side, and one must not read what the other has begun to
/// write.
fn written(once: &OnceLock<String>, name: &str, write: impl FnOnce(&Path)) -> String {
    let path = || {
        let path = std::env::temp_dir().join(format!("supercoil_{name}_{}.csv", std::process::id()));
        write(&path);
        path.to_str().unwrap().to_owned()
    };
    once.get_or_init(path).clone()
}

/// A final state of a straight rod of 12 elements.
fn state() -> String {
    static STATE: OnceLock<String> = OnceLock::new();
    let rod = RodState {
        arc_lengths: (0..37).map(f64::from).collect(),
        positions: (0..37).map(|k| Vec3::new(0.0, 0.0, f64::from(k))).collect(),
        frames: vec![Quat::identity(); 37],
    };
    written(&STATE, "reference", |path| write_state(path, &[rod], &Units::default()).unwrap())
}

/// A natural state along a rod of length 6.
fn natural() -> String {
    static NATURAL: OnceLock<String> = OnceLock::new();
    written(&NATURAL, "natural", |path| std::fs::write(path, "s,kappa1\n0,0.5\n6,0.5\n").unwrap())
}

fn scene(key: &Key, value: Option<&str>) -> Result<Scene, String> {
    let value = value.map(|value| match (key.table.as_str(), key.name.as_str()) {
        ("picture", "size") => format!("[{value}, {value}]"),
        ("stages.ramp.pose", "axis_angle") => format!("[0, 0, 1, {value}]"),
        ("stages.ramp", "length" | "binding") => format!("{{ to = {value} }}"),
        ("rods.section", "rectangle") => format!("[{value}, {value}]"),
        _ => value.to_owned(),
    });
    let assignment = value.map_or_else(String::new, |value| format!("{} = {value}", key.name));
    let text = template(key).replace('@', &assignment);
    // words that need another place, or another key
    let text = match assignment.as_str() {
        "side = \"inside\"" => text.replace("radius = 0.01", "radius = 2.0"),
        "shape = \"cylinder\"" => text.replace("radius = 0.2", "radius = 0.2\naxis = [0, 0, 1]"),
        _ => text,
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    Scene::from_toml(&text, &folder).map_err(|error| format!("{error}\n{text}"))
}

/// All that a run takes from a scene.
fn content(mut scene: Scene) -> String {
    let (thermal, options) = (scene.thermal(), Options::default());
    (scene.temperature, scene.text) = (None, String::new());
    scene.solver.tol_increment.get_or_insert(options.newton.tol_increment);
    scene.solver.max_iterations.get_or_insert(options.newton.max_iterations);
    format!("{scene:?}{thermal:?}")
}

/// Defaults in words.
const DEFAULTS_IN_WORDS: [&str; 39] = [
    "0 if a stage ramps `load`, otherwise 1",
    "needed without `braid` or `pd`",
    "from `dna`, or by `distance`",
    "none",
    "stays",
    "the only rod",
    "the only plane",
    "the only obstacle",
    "that of the shape, of an only obstacle",
    "needed for a cylinder",
    "needed for a hinge",
    "in place",
    "as before",
    "all",
    "straight",
    "by the mesh",
    "by time only",
    "out/NAME",
    "by `salt_mM`",
    "Cowper's",
    "that of the `circle`",
    "from `dna`",
    "needed without moduli",
    "needed without `letters`",
    "needed without `strength`",
    "those of its keys",
    "the only one",
    "x, y, z, or the only three",
    "twice the contact radius",
    "that of least energy at `excess_link`",
    "`rod`, of an only rod",
    "`ROD_bead`, with a number if the rod has several",
    "`\"none\"`: the rod ends in a point",
    "`plane`, of an only plane",
    "the writhe of the shape",
    "by `fidelity`; a node a base pair of a `sequence`; those of a `state`",
    "`L`, `F`; nm, pN with `dna` or `sequence`",
    "1600 wide, as high as the rods need, up to 1200",
    "z, or y",
];

/// A default as a value; none if it is told in words.
fn default_value(key: &Key) -> Option<String> {
    let in_words = |words: &str| DEFAULTS_IN_WORDS.contains(&words) || words.starts_with("from where no state");
    if key.is_required || in_words(&key.default) {
        return None;
    }
    Some(key.default.split(", or by ").next().unwrap().replace('`', ""))
}

#[test]
fn stated_defaults_are_those_of_the_program() {
    let (mut compared, mut failed) = (0, Vec::new());
    for key in keys() {
        let Some(value) = default_value(&key) else { continue };
        let with = scene(&key, Some(&value)).map(content);
        match (with, scene(&key, None).map(content)) {
            (Ok(with), Ok(without)) if with == without => compared += 1,
            (with, without) => failed.push(format!("{} = {value}: {with:?}\nwithout: {without:?}", key.path())),
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
    assert!(compared >= 40, "{compared}");
}

/// Values that are refused and taken, of what a cell allows; none if it tells no range and no list of words.
fn probes(key: &Key) -> Option<[Vec<String>; 2]> {
    let integer = key.value.starts_with("integer") || key.name == "size";
    let number = |text: &str| text.trim_end_matches(',').replace("10⁹", "1000000000").parse::<f64>().ok();
    let told = |x: f64| if integer { format!("{x}") } else { format!("{x:?}") };
    // next to a number, outside or inside of a range
    let beside = |x: f64, sign: f64| x + sign * if integer { 1.0 } else { 1e-9 * x.abs().max(1e-3) };
    let (mut refused, mut taken) = (Vec::new(), Vec::new());
    for part in key.allowed.split(';') {
        let words: Vec<&str> = part.trim().trim_start_matches("arc: ").split_whitespace().collect();
        match words.as_slice() {
            [">", zero, ..] => {
                refused.extend([told(number(zero)?), "-1e-9".to_owned(), "nan".to_owned()]);
                taken.push("1e-3".to_owned());
            }
            ["between", low, "and", high] => {
                let (low, high) = (number(low)?, number(high)?);
                refused.extend([told(low), told(high)]);
                taken.extend([told(low + 1e-3), told(high - 1e-3)]);
            }
            ["at", "least", low] | ["from", low] => match number(low.trim_end_matches(':')) {
                Some(low) => {
                    refused.push(told(beside(low, -1.0)));
                    taken.push(told(low));
                }
                None => continue,
            },
            ["above", low, "at", "most", high] => {
                let (low, high) = (number(low)?, number(high)?);
                refused.extend([told(low), told(beside(high, 1.0))]);
                taken.extend([told(low + 1e-2), told(high)]);
            }
            ["up", "to", high] => {
                refused.push(told(beside(number(high)?, 1.0)));
                taken.push(told(number(high)?));
            }
            [low, "to", high, ..] if number(low).is_some() => {
                let (low, high) = (number(low)?, number(high)?);
                refused.extend([told(beside(low, -1.0)), told(beside(high, 1.0))]);
                taken.extend([told(low), told(high)]);
            }
            ["with", "through", "at", "most", ..] => {
                refused.push("100001.0".to_owned());
                taken.push("100000.0".to_owned());
            }
            ["not", "zero"] => {
                refused.push("[0, 0, 0]".to_owned());
                taken.push("[0, 1e-3, 1e-3]".to_owned());
            }
            ["length", "1"] => {
                let fourth = if key.name == "quaternion" { ", 0" } else { "" };
                refused.push(format!("[0, 0, 1.01{fourth}]"));
                taken.push(format!("[0, 0, 1{fourth}]"));
            }
            ["1,", "2,", "3"] => {
                refused.extend(["0", "4"].map(str::to_owned));
                taken.extend(["1", "2", "3"].map(str::to_owned));
            }
            _ if key.value == "word" && part.trim().starts_with('`') => {
                refused.push("\"zzz\"".to_owned());
                // other kinds of shapes need other keys
                let words = part.split(',').map(|word| word.trim().trim_matches(['`', '"']));
                taken.extend(words.filter(|_| key.name != "kind").map(|word| format!("\"{word}\"")));
            }
            _ => {}
        }
    }
    (!refused.is_empty()).then_some([refused, taken])
}

#[test]
fn stated_ranges_are_those_of_the_program() {
    let (mut tried, mut failed) = (0, Vec::new());
    for key in keys() {
        let Some([refused, taken]) = probes(&key) else { continue };
        for value in &refused {
            if scene(&key, Some(value)).is_ok() {
                failed.push(format!("{} = {value} is taken, allowed: {}", key.path(), key.allowed));
            }
        }
        for value in &taken {
            if let Err(error) = scene(&key, Some(value)) {
                failed.push(format!("{} = {value} is refused, allowed: {}: {error}", key.path(), key.allowed));
            }
        }
        tried += 1;
    }
    assert!(failed.is_empty(), "{} of {tried}\n{}", failed.len(), failed.join("\n\n"));
    assert!(tried >= 60, "{tried}");
}
