//! Stages that change the problem: numbers of rods ramped, supports set and taken away.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::io::run::run_observed;
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::scene::{NodeRef, Scene, Support, SupportChange};
use supercoil::solve::{Options, Restart, Solution, Status, run_from};

const BEAM: &str = r#"
[[rods]]
name = "beam"
shape = { kind = "line", length = 2.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }
elements = 8
[[supports]]
at = "start"
position = true
rotation = true
"#;

fn run(text: &str) -> (Solution, Vec<Observation>) {
    let scene = Scene::from_toml(text, Path::new("")).unwrap();
    let mut seen = Vec::new();
    let solution = run_from(scene.model, &scene.stages, &Options::default(), None, &mut |progress, _| {
        seen.push(observe(progress));
        ControlFlow::Continue(())
    });
    let solution = solution.unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure);
    (solution, seen)
}

fn end(seen: &[Observation], step: usize) -> Vec3 {
    seen[step].ends[0].end.into()
}

/// A cantilever whose natural curvature grows is an arc of it, free of stress.
#[test]
fn a_rod_bends_by_nature() {
    let curvature = 1.2;
    let stage = format!("[[stages]]\nramp = {{ natural = {{ curvature = [{curvature}, 0.0] }} }}\nsteps = 4\n");
    let (_, seen) = run(&format!("{BEAM}{stage}"));
    let angle = 2.0 * curvature;
    let out = end(&seen, 4);
    let across = (out.y.hypot(out.z), out.x);
    assert!((across.0 - (1.0 - f64::cos(angle)) / curvature).abs() < 1e-6, "{out}");
    assert!((across.1 - f64::sin(angle) / curvature).abs() < 1e-6, "{out}");
    assert!(seen[4].energies.total < 1e-12, "{}", seen[4].energies.total);
    assert_eq!(seen.len(), 5);
}

/// Clamped ends keep their distance while the rod between them shrinks: tension EA (l/L − 1).
#[test]
fn a_rod_that_shrinks_is_stretched() {
    let held = "[[supports]]\nat = \"end\"\nposition = true\nrotation = true\n";
    let (_, seen) = run(&format!("{BEAM}{held}[[stages]]\nramp = {{ length = {{ to = 1.9 }} }}\nsteps = 2\n"));
    let tension = seen[2].reactions[1].force[0];
    assert!((tension - 1e4 * (2.0 / 1.9 - 1.0)).abs() < 1e-6 * tension, "{tension}");
}

/// However stiffness came about, the deflection is that of a beam that had it from the start.
#[test]
fn a_beam_that_softens_is_a_soft_beam() {
    let load = "[[loads]]\nat = \"end\"\nforce = [0.0, 0.0, -0.3]\n[[stages]]\nramp = { load = 1.0 }\nsteps = 2\n";
    let softens = "[[stages]]\nramp = { section = { bending = 0.25, contact_radius = 0.02 } }\nsteps = 3\n";
    let (_, softened) = run(&format!("{BEAM}{load}{softens}"));
    let (_, soft) = run(&format!("{}{load}", BEAM.replace("bending = 1.0", "bending = 0.25")));
    let apart = end(&softened, 5) - end(&soft, 2);
    assert!(apart.norm() < 1e-9, "{apart}");
    assert!((end(&softened, 2) - end(&softened, 5)).norm() > 0.1);
}

const HELD: &str = r#"
[[loads]]
at = "end"
force = [0.0, 0.0, -0.3]
[[stages]]
ramp = { load = 1.0 }
steps = 2
[[stages]]
hold = [{ at = "end", position = true }]
ramp = { load = 0.0 }
steps = 2
[[stages]]
ramp = { displacement = { at = "end", to = [0.0, 0.0, 0.1] } }
steps = 1
[[stages]]
release = [{ at = "end", position = true }]
steps = 1
"#;

/// An end held where a load has taken it bears that load when it is gone; let go, the beam is straight again.
#[test]
fn ends_are_held_and_let_go() {
    let (_, seen) = run(&format!("{BEAM}{HELD}"));
    let force = |step: usize| seen[step].reactions.iter().find(|r| r.node > 0).map(|r| Vec3::from(r.force));
    assert_eq!(force(2), None);
    assert!((force(4).unwrap() - Vec3::new(0.0, 0.0, -0.3)).norm() < 1e-8, "{:?}", force(4));
    assert!((end(&seen, 4) - end(&seen, 2)).norm() < 1e-12);
    assert!((end(&seen, 5) - end(&seen, 4) - Vec3::z() * 0.1).norm() < 1e-12);
    assert_eq!(force(6), None);
    assert!((end(&seen, 6) - Vec3::x() * 2.0).norm() < 1e-9, "{}", end(&seen, 6));
}

/// A run taken up in the middle of it ends with the same bits.
/// What holds two joined nodes is let go at either. Symptom: a joint held through both rods was never released, and one
/// held through one rod not by the other.
#[test]
fn joined_ends_are_let_go_at_either_node() {
    let rods = r#"
        [[rods]]
        name = "a"
        shape = { kind = "line", start = [0, 0, 0], direction = [1, 0, 0], length = 1.0 }
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }
        elements = 6
        [[rods]]
        name = "b"
        shape = { kind = "line", start = [1.0, 0, 0], direction = [0, 0, 1.0], length = 1.0 }
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }
        elements = 6
        [[joints]]
        a = { rod = "a", at = "end" }
        b = { rod = "b", at = "start" }
        kind = "pin"
        [[loads]]
        rod = "b"
        at = { arc = 0.5 }
        force = [0.5, 0.3, 0]
        [[supports]]
        rod = "a"
        at = "start"
        position = true
        rotation = true
        [[supports]]
        rod = "b"
        at = "end"
        position = true
        rotation = true
        [[stages]]
        ramp = { load = 1.0 }
        "#;
    let held = |rod: &str, at: &str| format!("[[supports]]\nrod = \"{rod}\"\nat = \"{at}\"\nposition = true\n");
    let [a, b] = [held("a", "end"), held("b", "start")];
    let ends = [[a.clone(), b.clone()].concat(), a.clone(), b.clone()].map(|supports| {
        let released =
            ["{ rod = \"a\", at = \"end\", position = true }", "{ rod = \"b\", at = \"start\", position = true }"];
        released.map(|released| {
            let (_, seen) = run(&format!("{supports}{rods}[[stages]]\nrelease = [{released}]\n"));
            let last = seen.last().unwrap();
            let at_joint = |rod: usize, node: usize| (rod, node) == (0, 18) || (rod, node) == (1, 0);
            assert!(!last.reactions.iter().any(|at| at_joint(at.rod, at.node)), "{supports}");
            last.ends[0].end
        })
    });
    for end in ends.iter().flatten() {
        let apart = (Vec3::from(*end) - Vec3::from(ends[0][0])).norm();
        assert!(apart < 1e-8 && Vec3::from(*end).x != 1.0, "{ends:?}");
    }
}

#[test]
fn changes_survive_a_restart() {
    let text = format!(
        "{BEAM}{HELD}[[stages]]\nramp = {{ section = {{ bending = 0.5 }}, length = {{ to = 2.2 }} }}\nsteps = 4\n"
    );
    let scene = Scene::from_toml(&text, Path::new("")).unwrap();
    let mut kept: Vec<Restart> = Vec::new();
    let go = |from: Option<Restart>, kept: &mut Vec<Restart>| {
        let done = run_from(scene.model.clone(), &scene.stages, &Options::default(), from, &mut |_, waypoint| {
            kept.extend(waypoint.restart());
            ControlFlow::Continue(())
        });
        done.unwrap().solver.engine().state().clone()
    };
    let last = go(None, &mut kept);
    assert_eq!(last.numbers().len(), 3);
    for restart in kept {
        let place = restart.place;
        assert_eq!(go(Some(restart), &mut Vec::new()), last, "{place:?}");
    }
}

/// A trefoil whose rod grows thicker is pulled tight, and stays a trefoil.
#[test]
fn a_knot_is_pulled_tight() {
    let scene = Scene::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/tight_knot.toml")).unwrap();
    let mut last = None;
    let solution = run_from(scene.model, &scene.stages, &Options::default(), None, &mut |progress, _| {
        last = Some(observe(progress));
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure);
    let knot = &last.unwrap().knots[0];
    assert_eq!(knot.name, "3_1");
    let ropelength = knot.ropelength.unwrap();
    assert!((16.3715..20.0).contains(&ropelength), "{ropelength}");
}

/// What cannot be ramped, held or let go is refused in words.
#[test]
fn changes_without_sense_are_refused() {
    let refusal =
        |stage: &str| match Scene::from_toml(&format!("{BEAM}[[stages]]\n{stage}\nsteps = 1\n"), Path::new("")) {
            Ok(_) => format!("accepted: {stage}"),
            Err(error) => error.to_string(),
        };
    for (stage, reason) in [
        ("ramp = { section = { contact_radius = 0.0 } }", "contact_radius = 0"),
        ("ramp = { section = { bending = -1.0 } }", "bending_1 = -1"),
        ("ramp = { section = { rod = \"beam\" } }", "names no number to ramp"),
        ("release = [{ at = \"end\", position = true }]", "changes nothing"),
        ("hold = [{ at = \"start\", position = [\"x\"] }]", "changes nothing"),
        ("hold = [{ at = \"end\", rotation = [\"x\"] }]", "joint of constant velocity"),
        ("ramp = {}", "nothing to do"),
    ] {
        let message = refusal(stage);
        assert!(message.contains(reason), "{stage}: {message}");
    }
}

/// Two beams, one across the middle of the other, that are apart at the start: clamped at both ends.
const CROSSED: &str = r#"
[[rods]]
name = "lower"
shape = { kind = "line", start = [-0.5, 0.0, 0.0], direction = [1.0, 0.0, 0.0], length = 1.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }
elements = 8
[[rods]]
name = "upper"
shape = { kind = "line", start = [0.0, -0.5, 0.05], direction = [0.0, 1.0, 0.0], length = 1.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }
elements = 8
[[supports]]
rod = ["lower", "upper"]
at = "start"
position = true
rotation = true
[[supports]]
rod = ["lower", "upper"]
at = "end"
position = true
rotation = true
"#;

/// A rod may grow until it touches one that touches another already.
#[test]
fn a_rod_that_grows_until_it_touches_is_a_thick_rod() {
    let touching = CROSSED.replace("contact_radius = 0.01", "contact_radius = 0.0255");
    let third = |radius: f64| {
        let supports = touching.find("[[supports]]").unwrap();
        let (rods, supports) = touching.split_at(supports);
        let third = rods[rods.find("[[rods]]\nname = \"upper\"").unwrap()..].replace("upper", "third");
        let third = third.replace("-0.5, 0.05", "-0.5, -0.06").replace("0.0255", &format!("{radius:?}"));
        format!("{rods}{third}{}", supports.replace("\"upper\"", "\"upper\", \"third\""))
    };
    let stage = "[[stages]]\nramp = { section = { rod = \"third\", contact_radius = 0.04 } }\nsteps = 1\n";
    let (_, grown) = run(&format!("{}{stage}", third(0.01)));
    let (_, thick) = run(&third(0.04));
    let [first, grown, thick] = [&grown[0], grown.last().unwrap(), thick.last().unwrap()];
    assert!(first.num_sites == 1 && thick.num_sites == 2, "{} {}", first.num_sites, thick.num_sites);
    let apart = grown.energies.bending / thick.energies.bending - 1.0;
    assert!(apart.abs() < 1e-4, "{apart:e}");
}

/// Symptom: charges were lost where a rod's contact radius changed.
#[test]
fn rods_that_grow_keep_their_charges() {
    let charges = "[contact]\nelectrostatics = { strength = 0.05, debye_length = 0.02 }\n";
    let stage = |to: f64| {
        format!("[[stages]]\nramp = {{ section = {{ rod = \"lower\", contact_radius = {to:?} }} }}\nsteps = 2\n")
    };
    let (_, still) = run(&format!("{CROSSED}{charges}"));
    let (_, grown) = run(&format!("{CROSSED}{charges}{}", stage(0.012)));
    let [still, grown] = [&still, &grown].map(|seen| seen.last().unwrap().energies.electrostatic);
    assert!(still > 1e-6, "{still:e}");
    assert!((grown / still - 1.0).abs() < 1e-9, "{grown:e} {still:e}");
}

/// Symptom: a ring 10⁵ Debye lengths around did not end, one of 10¹⁴ ran out of memory. Mechanism: the Gauss points of
/// a segment were as many as it takes to resolve the Debye length. Both are refused with their number, as are ramps
/// there.
#[test]
fn charges_that_the_mesh_is_too_coarse_for_are_refused() {
    let ring = |radius: f64, stage: &str| {
        let section = "bending = 1.0, twisting = 1.0, stretching = 1e5, shearing = 1e5, contact_radius = 0.01";
        let text = format!(
            "[[rods]]\nname = \"ring\"\nclosed = true\nshape = {{ kind = \"circle\", radius = {radius:?} }}\n\
             section = {{ {section} }}\n\
             elements = 12\n[contact]\nelectrostatics = {{ strength = 1e-6, debye_length = 0.01 }}\n{stage}"
        );
        Scene::from_toml(&text, Path::new("")).map(|_| ()).map_err(|error| error.to_string())
    };
    for (radius, pieces) in [(1000.0, "11636 pieces"), (1e12, "pieces")] {
        let error = ring(radius, "").unwrap_err();
        assert!(
            error.contains("debye_length") && error.contains(pieces) && error.contains("elements would do"),
            "{error}"
        );
    }
    // as many as the refusal advises will do
    assert!(ring(20.0, "").is_ok());
    let grown = ring(20.0, "[[stages]]\nramp = { length = { to = 12566.0 } }\nsteps = 1\n").unwrap_err();
    assert!(grown.contains("stages[0].ramp.length") && grown.contains("pieces"), "{grown}");
    let thin = ring(20.0, "[[stages]]\nramp = { section = { contact_radius = 1e-4 } }\nsteps = 1\n").unwrap_err();
    assert!(thin.contains("contact_radius") && thin.contains("pieces"), "{thin}");
}

/// A stage whose path is followed is one ramp: a scene that the library puts together otherwise is refused, too.
#[test]
fn a_followed_stage_holds_and_releases_nothing() {
    let stage = "[[supports]]\nat = \"end\"\nposition = true\n\
        [[stages]]\nramp = { displacement = { at = \"end\", to = [-0.2, 0.3, 0] } }\nfollow = { max_points = 3 }\n";
    let mut scene = Scene::from_toml(&format!("{BEAM}{stage}"), Path::new("")).unwrap();
    let follow = |scene: &Scene| {
        let seen = &mut |_: supercoil::io::run::ReportedState<'_>| ControlFlow::Continue(());
        run_observed(scene, &Options::default(), (None, &[]), seen)
    };
    assert_eq!(follow(&scene).unwrap().status, Status::Converged);
    let end = Support::clamp(NodeRef { rod: 0, node: 24 });
    scene.stages[0].supports.push(SupportChange::Release(end));
    let error = follow(&scene).unwrap_err().to_string();
    assert!(error.contains("stages[0].follow") && error.contains("one ramp"), "{error}");
}
