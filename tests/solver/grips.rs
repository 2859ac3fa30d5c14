//! Bodies that nodes carry: beads and grips. Forces by statics, knots that stay tied, turns that tweezers keep.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::path::Path;

use crate::common;
use supercoil::io::run::options;
use supercoil::math::Vec3;
use supercoil::observe::report::Observation;
use supercoil::scene::Scene;
use supercoil::scene::file::TEMPLATES;
use supercoil::solve::{Options, Solution};

fn run(text: &str) -> (Solution, Vec<Observation>) {
    common::run(text, Path::new(""), |scene| Options { threads: Some(1), ..options(scene) })
}

const SECTION: &str =
    "section = { bending = 1.0, twisting = 1.0, stretching = 1e5, shearing = 1e5, contact_radius = 0.01 }";

/// A cantilever with a ball at its end, above the middle of a beam across it that is clamped at both ends; the clamp of
/// the cantilever goes down by `depth` beyond the height at which the ball touches.
fn pressed(carrier: &str, depth: f64) -> String {
    let height = 0.21;
    format!(
        "[[rods]]\nname = \"beam\"\nshape = {{ kind = \"line\", start = [-1, 0, 0], direction = [1, 0, 0], length = \
         2.0 }}\n\
         {SECTION}\nelements = 16\n\
         [[rods]]\nname = \"arm\"\n\
         shape = {{ kind = \"line\", start = [0, -1, {height:?}], direction = [0, 1, 0], length = 1.0 }}\n{SECTION}\n\
         elements = 8\n\
         {carrier}\n\
         [[supports]]\nrod = \"beam\"\nat = \"start\"\nposition = true\nrotation = true\n\
         [[supports]]\nrod = \"beam\"\nat = \"end\"\nposition = true\nrotation = true\n\
         [[supports]]\nrod = \"arm\"\nat = \"start\"\nposition = true\nrotation = true\n\
         [[stages]]\nramp = {{ displacement = {{ rod = \"arm\", at = \"start\", to = [0, 0, {:?}] }} }}\nsteps = 2\n",
        -depth
    )
}

/// The ball presses with F = depth/(L³/192B + l³/3B), which the clamps of the beam share; the clamp of the arm bears F,
/// and F l about the beam.
#[test]
fn a_bead_presses_on_a_beam() {
    let depth = 0.01;
    let (_, seen) = run(&pressed("beads = [{ at = \"end\", radius = 0.2 }]", depth));
    let last = &seen[seen.len() - 1];
    let force = depth / (8.0 / 192.0 + 1.0 / 3.0);
    let [left, right, arm] =
        [0, 1, 2].map(|k| (Vec3::from(last.reactions[k].force), Vec3::from(last.reactions[k].moment)));
    assert!((arm.0.z + force).abs() < 2e-3 * force, "{} {force}", arm.0.z);
    assert!((left.0.z + right.0.z + arm.0.z).abs() < 1e-6 * force && (left.0.z - right.0.z).abs() < 1e-6 * force);
    let moment = arm.1.x.abs() / arm.0.z.abs();
    assert!((moment - 1.0).abs() < 1e-3, "{moment}");
    assert!(last.obstacle_sites.len() == 1 && last.obstacle_sites[0].gap.abs() < 1e-6, "{:?}", last.obstacle_sites);
    // it has gone down with its node
    let moved = last.obstacle_reactions[0].placement;
    assert!((moved.displacement.z + force / 24.0).abs() < 0.02 * force / 24.0, "{moved:?}");
}

/// A grip that prolongs the arm, and lies on the beam with its side, a = 0.2 beyond the arm's end: a force F there
/// deflects it by F (l³/3 + l² a + l a²)/B, and the clamp bears F (l + a).
#[test]
fn a_grip_bears_as_the_rod_would() {
    let text = pressed("", 0.0)
        .replace("start = [0, -1, 0.21], direction = [0, 1, 0]", "start = [0, -1.2, 0.02], direction = [0, 1, 0]");
    let grip = "rod = \"arm\"\nat = \"end\"\nposition = [\"x\"]\nrotation = [\"y\", \"z\"]\ngrip = 0.5\n[[stages]]";
    let text =
        text.replace("[[stages]]", &format!("[[supports]]\n{grip}")).replace("to = [0, 0, -0.0]", "to = [0, 0, -0.01]");
    let (_, seen) = run(&text);
    let last = &seen[seen.len() - 1];
    let (l, a) = (1.0, 0.2);
    let compliance = 8.0 / 192.0 + l * l * l / 3.0 + a * l * l + a * a * l;
    let force = 0.01 / compliance;
    let arm = [Vec3::from(last.reactions[2].force), Vec3::from(last.reactions[2].moment)];
    assert!((arm[0].z + force).abs() < 5e-3 * force, "{} {force}", arm[0].z);
    assert!((arm[1].x.abs() / arm[0].z.abs() - l - a).abs() < 2e-3, "{}", arm[1].x / arm[0].z);
}

/// A ring about a hanging rod, wider than the rod and narrower than the ball at its lower end, falls onto the ball and
/// tilts until the rod is in its way: the clamp of the rod bears its weight.
#[test]
fn a_ring_hangs_on_a_bead() {
    let text = "gravity = [0.0, 0.0, -1.0]\n[[rods]]\nname = \"stick\"\n\
        shape = { kind = \"line\", direction = [0.1, 0.0, -1.0], length = 3.0 }\n\
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.02 }\n\
        elements = 12\n\
        beads = [{ at = \"end\", radius = 0.5, name = \"bob\" }]\n\
        [[rods]]\nname = \"ring\"\nclosed = true\n\
        shape = { kind = \"circle\", radius = 0.45, center = [0.26, 0.0, -2.5], normal = [0.1, 0.05, -1.0] }\n\
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.02 }\n\
        elements = 12\n\
        weight = 0.05\n[[supports]]\nrod = \"stick\"\nat = \"start\"\nposition = true\nrotation = true\n";
    let (_, seen) = run(text);
    let (last, weight) = (&seen[0], 0.05 * 0.45 * std::f64::consts::TAU);
    let clamp = Vec3::from(last.reactions[0].force);
    assert!((clamp - Vec3::z() * weight).norm() < 1e-6 * weight, "{clamp} {weight}");
    assert!(last.obstacle_reactions[0].force > weight && !last.sites.is_empty(), "{:?}", last.obstacle_reactions);
}

/// An overhand knot between grips keeps its type at every step while it is pulled to its tightest.
#[test]
fn an_overhand_knot_stays_tied() {
    let template = TEMPLATES.iter().find(|template| template.name == "overhand").unwrap();
    let (_, seen) = run(template.text);
    for step in &seen {
        assert_eq!(step.knots[0].name, "3_1", "step {}", step.step);
        assert!(step.notes.iter().all(|note| !note.contains("passed over")), "{:?}", step.notes);
    }
    let pressed: f64 = seen[seen.len() - 1].sites.iter().map(|site| site.force).sum();
    assert!(pressed > 1.0, "{pressed}");
}

/// The same rope, its ends pushed together until the loop is wide: over a point it slips and the knot is gone, over a
/// grip it does not.
#[test]
fn a_knot_slips_over_points_and_not_over_grips() {
    let template = TEMPLATES.iter().find(|template| template.name == "overhand").unwrap();
    let pushed = template.text.replace("length = 800.0", "length = 600.0").replace("elements = 96", "elements = 72");
    let pushed = pushed.replace("[290.0, 0.0, 0.0]", "[-150.0, 0.0, 0.0]").replace("steps = 16", "steps = 3");
    let last = |text: &str| run(text).1.pop().unwrap();
    let [held, lost] = [last(&pushed), last(&pushed.replace("\"endless\"", "\"none\""))];
    assert!(
        held.knots[0].name == "3_1" && held.notes.iter().all(|note| !note.contains("passed over")),
        "{:?}",
        held.notes
    );
    assert!(held.obstacle_reactions.len() == 2 && lost.knots[0].name == "0_1", "{}", lost.knots[0].name);
    // what the rope exerts on the grips its clamps bear
    let sum: Vec3 = held.reactions.iter().map(|reaction| Vec3::from(reaction.force)).sum();
    assert!(sum.norm() < 1e-6, "{sum}");
}

/// Tweezers at a force so low that loops pass over the ends: between points all six turns are lost, between grips, or
/// beads as large as the magnetic ones are for short molecules, none.
#[test]
fn tweezers_keep_every_turn() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/tweezers.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.replace("length = 400.0", "length = 200.0").replace("force = [2.0", "force = [0.05");
    let text =
        text.replace("turns = 12.0", "turns = 6.0").replace("steps = 12", "steps = 3").replace("balanced", "draft");
    let turns = |text: &str| run(text).1.iter().map(|step| step.ends[0].link.unwrap()).collect::<Vec<f64>>();
    let beads = "[[rods]]\nbeads = [{ at = \"start\", radius = 60.0 }, { at = \"end\", radius = 60.0 }]";
    let held = [text.replace("[[supports]]", "[[supports]]\ngrip = \"endless\""), text.replace("[[rods]]", beads)];
    for text in held {
        for (step, kept) in turns(&text)[1..].iter().enumerate() {
            assert!((kept - 2.0 * step as f64).abs() < 1e-4, "{kept} at step {step}");
        }
    }
    assert!(turns(&text)[4].abs() < 1e-4, "points keep them, too: nothing is tested");
}

/// What is wrong with a bead or a grip is refused by name.
#[test]
fn beads_and_grips_without_sense_are_refused() {
    let good = pressed("beads = [{ at = \"end\", radius = 0.2 }]", 0.01);
    let support = |grip: &str| {
        good.replace("at = \"end\"\nposition = true", &format!("at = \"end\"\ngrip = {grip}\nposition = true"))
    };
    let cases = [
        (good.replace("radius = 0.2", "radius = -1.0"), "rods.arm.beads[0].radius"),
        (good.replace("radius = 0.2", "radius = 0.3"), "starts beyond it"),
        (good.replace("at = \"end\", radius", "at = 99, radius"), "rods.arm.beads[0].at"),
        (support("-1.0"), "supports[1].grip"),
        (support("\"long\""), "\"endless\" or a length"),
        (good.replace("at = \"end\"\nposition", "at = 5\ngrip = 0.1\nposition"), "supports[1].grip: prolongs an end"),
        (
            good.replace(
                "[[stages]]",
                "[[stages]]\nhold = [{ rod = \"arm\", at = \"end\", position = true, grip = 1 }]",
            ),
            "stages[0].hold[0].grip",
        ),
        (
            good.replace("ramp = {", "ramp = { obstacle = { name = \"arm_bead\", displacement = [0, 0, 1] },"),
            "only its radius is ramped",
        ),
    ];
    for (text, reason) in cases {
        let refused = Scene::from_toml(&text, Path::new("")).unwrap_err().to_string();
        assert!(refused.contains(reason), "{reason}: {refused}");
    }
}
