//! Scene files: what is accepted means what it says, what is refused is refused with the key, the value and what is
//! allowed.

#![allow(clippy::unwrap_used)] // helpers of tests

mod joints;
mod meshes;
mod refusals;
mod shapes;

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::io::run::run_scene;
use supercoil::math::{Quat, Vec3};
use supercoil::rod::{Natural, Plectoneme, Shape};
use supercoil::scene::{ContactLaw, Fidelity, Joint, JointKind, LineLoad, NodeRef, PosePath, Ramp, Scene};
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

/// The pose of the only ramp of the only stage.
fn posed(keys: &str) -> Result<supercoil::scene::Pose, String> {
    let text = format!(
        "{}\n[[supports]]\nat = \"end\"\nposition = true\nrotation = true\n[[stages]]\nsteps = 1\n\
         ramp = {{ pose = {{ at = \"end\", {keys} }} }}",
        BEAM.split("[[supports]]").next().unwrap()
    );
    match read(&text).map_err(|error| error.to_string())?.stages[0].ramps[..] {
        [Ramp::Pose { node: NodeRef { rod: 0, node: 8 }, pose }] => Ok(pose),
        ref other => Err(format!("{other:?}")),
    }
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
    // that of the constants
    assert!(temperature == 298.0 && unit == 4.114);
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
