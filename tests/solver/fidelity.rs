//! Presets keep to the errors they state ([`Fidelity::accuracy`]), on cases that they were not chosen on.
//!
//! Chosen on (`benches/work_precision.rs`): twisted rings with D/L = .01 and .03 at excess links of 1.8, 2.2, 2.8 and
//! 3.2, a minicircle, plectonemes with D/L = .01 and .005, clamped crossed and parallel beams, the Bathe–Bolourchi
//! bend. Here:
//!
//! * twisted ring, C/B = 1.5, D/L = .02: contact force at one point (excess link 1.9), writhe and energy in line
//!   contact (3); D/L = .03 where three points become a line, and as a plectoneme: writhe, twisting moment, energy.
//!   Kirchhoff rod with hard contact, recomputed by shooting.
//! * crossed beams on simple supports: 24 B δ/L³ each.
//! * no contact: Princeton beam; a rod bent into an eighth of a circle and into ten (Ibrahimbegović). Boundary value
//!   problems, to all digits.
//! * scenes as files, whose meshes come from what they ask for: a circle of C/B = 1, closed trefoil, elastica that
//!   touches itself; reference: half as many elements again as `Reference` and a law ten times as hard.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::path::Path;

use common::{any_equilibrium, cantilever};
use supercoil::math::Vec3;
use supercoil::observe::report::Observation;
use supercoil::observe::{mesh_note, observe};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Fidelity, Model, NodeRef, Ramp, Scene, Stage, Support};
use supercoil::solve::{Options, Solver, Status, run};

/// Runs to the end and returns the last state of every stage.
fn run_through(model: Model, stages: &[Stage], options: &Options, case: &str) -> (Vec<Observation>, Solver) {
    let mut ends: Vec<Option<Observation>> = vec![None; stages.len().max(1)];
    let solution = run(model, stages, options, &mut |progress| {
        ends[progress.stage] = Some(observe(progress));
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(solution.status, Status::Converged, "{case}");
    println!("{case}: {} nodes, {} iterations", solution.solver.engine().num_nodes(), solution.iterations);
    (ends.into_iter().map(Option::unwrap).collect(), solution.solver)
}

fn end_of(model: Model, stages: &[Stage], options: &Options, case: &str) -> (Observation, Solver) {
    let (mut seen, solver) = run_through(model, stages, options, case);
    (seen.pop().unwrap(), solver)
}

fn elastic(seen: &Observation) -> f64 {
    let parts = &seen.energies;
    parts.stretching + parts.shearing + parts.bending + parts.twisting
}

/// Holds relative errors to what the preset states.
fn hold(case: &str, values: &[(&str, f64, f64, f64)]) {
    for (name, ours, exact, allowed) in values {
        let error = (ours / exact - 1.0).abs();
        println!("  {name}: off by {error:.1e} ({allowed:.0e} allowed)");
        assert!(error <= *allowed, "{case}, {name}: {ours} {exact}");
    }
}

fn hold_gap(case: &str, seen: &Observation, radius: f64, fidelity: Fidelity) {
    let penetration = seen.contact_gap.map_or(0.0, |gap| -gap.lower / radius);
    // the certified gap is known to 1e-9 of the radius or so
    assert!(penetration <= 1.01 * fidelity.accuracy().penetration, "{case}: {penetration:e}");
}

/// The twisted ring, C/B = 1.5, at two excess links one after the other.
fn ring(fidelity: Fidelity, diameter: f64, excess_links: [f64; 2]) -> [Observation; 2] {
    let section = Section::isotropic(1.0, 1.5, 1e8, 1e8, 0.5 * diameter);
    let circle = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let elements = fidelity.elements(1.0, 1.0 + excess_links[1], 0.5 * diameter);
    let rod =
        Rod::new("ring", &circle, RodMesh::closed(elements, Fidelity::ORDER), section, Natural::Straight).unwrap();
    let model = Model { rods: vec![rod], contact: fidelity.contact(), ..Model::default() };
    let stages = [(1.1, 1), (excess_links[0], 4), (excess_links[1], 6)]
        .map(|(to, steps)| Stage::new(vec![Ramp::ExcessLink { rod: 0, to }], steps));
    let case = format!("{fidelity:?}, ring, D/L = {diameter}, excess links {excess_links:?}");
    let (seen, _) = run_through(model, &stages, &fidelity.into(), &case);
    seen.iter().for_each(|seen| hold_gap(&case, seen, 0.5 * diameter, fidelity));
    let [_, first, second] = seen.try_into().unwrap();
    [first, second]
}

#[test]
fn twisted_rings() {
    for fidelity in Fidelity::ALL {
        let allowed = fidelity.accuracy();
        let [point, line] = ring(fidelity, 0.02, [1.9, 3.0]);
        hold("one point", &[("force", point.total_contact_force, 285.039450, allowed.contact_force)]);
        hold(
            "line",
            &[
                ("writhe", line.links[0].writhe, 2.371617, allowed.writhe),
                ("energy", elastic(&line), 112.061, allowed.energy),
            ],
        );
        // writhe, M L/2πB, bending energy over that of the circle
        let exact = [[1.71196, 1.00273, 4.29589], [3.03002, 2.32740, 8.38007]];
        let seen = ring(fidelity, 0.03, exact.map(|[writhe, moment, _]| writhe + moment / 1.5));
        for (seen, [writhe, moment, bend]) in seen.iter().zip(exact) {
            let energy = bend * 0.5 * TAU * TAU + (moment * TAU).powi(2) / 3.0;
            hold(
                "D/L = .03",
                &[
                    ("writhe", seen.links[0].writhe, writhe, allowed.writhe),
                    ("moment", seen.links[0].seam_moment / TAU, moment, allowed.twisting_moment),
                    ("energy", elastic(seen), energy, allowed.energy),
                ],
            );
        }
    }
}

#[test]
fn crossed_beams_on_simple_supports() {
    let (radius, push) = (0.015, 1e-3);
    for fidelity in Fidelity::ALL {
        let section = Section::isotropic(1.0, 0.8, 1e6, 1e6, radius);
        let elements = fidelity.elements(1.0, 1.0, radius);
        let beam = |name: &str, direction: Vec3, z: f64| {
            let shape = Shape::Line { start: Vec3::z() * z - direction * 0.5, direction, length: 1.0 };
            Rod::new(name, &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap()
        };
        let rods = vec![beam("a", Vec3::x(), 0.0), beam("b", Vec3::y(), 2.0 * radius + 1e-4)];
        let last = rods[0].num_nodes() - 1;
        let mut supports = Vec::new();
        for rod in 0..2 {
            // pinned, no spin about its own axis; the other end slides along the beam
            let own = [rod == 0, rod == 1, false];
            supports.push(Support { node: NodeRef { rod, node: 0 }, position: [true; 3], rotation: own });
            let position = own.map(|along| !along);
            supports.push(Support { node: NodeRef { rod, node: last }, position, rotation: [false; 3] });
        }
        let to = -Vec3::z() * (push + 1e-4);
        let ramps = [0, last].map(|node| Ramp::Displacement { node: NodeRef { rod: 1, node }, to }).to_vec();
        let model = Model { rods, supports, contact: fidelity.contact(), ..Model::default() };
        let case = format!("{fidelity:?}, crossed beams");
        let (seen, _) = end_of(model, &[Stage::new(ramps, 3)], &fidelity.into(), &case);
        hold_gap(&case, &seen, radius, fidelity);
        // each gives way by half of the push
        let exact = 48.0 * 0.5 * push;
        hold(&case, &[("force", seen.total_contact_force, exact, fidelity.accuracy().contact_force)]);
    }
}

#[test]
fn without_contact() {
    for fidelity in Fidelity::ALL {
        let allowed = fidelity.accuracy().position;
        let tip = |case: &str, model: Model, options: Options, exact: [Option<f64>; 3], steps: usize| {
            let stages = [Stage::new(vec![Ramp::Load { to: 1.0 }], steps)];
            let model = Model { contact: Contact::NONE, ..model };
            let case = format!("{fidelity:?}, {case}");
            let (_, solver) = end_of(model, &stages, &options, &case);
            let end = solver.engine().positions(0).last().unwrap();
            let off = (0..3).filter_map(|k| Some(end[k] - exact[k]?));
            let error = off.map(|x| x * x).sum::<f64>().sqrt() / solver.engine().model().rods[0].length;
            println!("  tip off by {error:.1e} ({allowed:.0e} allowed)");
            assert!(error <= allowed, "{case}: {error:e}");
        };
        let straight = |section: Section, length: f64, turns: f64| {
            let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length };
            let elements = fidelity.elements(length, turns, 0.0);
            Rod::new("rod", &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap()
        };
        let section = Section {
            bending: [36.279_363_54, 2.428_734_44],
            twisting: 3.103_338_28,
            shearing: [9.039_150e5; 2],
            stretching: 2.841_909e6,
            contact_radius: 0.0,
        };
        let (sin, cos) = 45f64.to_radians().sin_cos();
        let weight = Vec3::new(0.0, cos, sin) * 8.896;
        let force_turns = |force: f64, bending: f64, length: f64| length / TAU * (force / bending).sqrt();
        let rod = straight(section, 0.508, force_turns(8.896, 2.43, 0.508));
        let model = cantilever(rod, weight, Vec3::zeros());
        // flap and chord displacements are known, that along the beam is not
        tip("Princeton beam", model, fidelity.into(), [None, Some(0.008_888_86), Some(0.109_041_57)], 1);
        let section = Section::isotropic(100.0, 100.0, 1e4, 1e4, 0.0);
        let mut options = any_equilibrium();
        options.newton.tol_increment = fidelity.tol_increment();
        let rod = straight(section, 10.0, 0.125 + force_turns(1.0 / 16.0, 100.0, 10.0));
        let model = cantilever(rod, Vec3::z() / 16.0, Vec3::z() * (2.5 * PI));
        let exact = [10.0 - 0.998_508_359_8, 3.727_561_074_7, 0.195_751_361_6];
        tip("eighth of a circle", model, options.clone(), exact.map(Some), 1);
        let rod = straight(section, 10.0, 10.0 + force_turns(50.0, 100.0, 10.0));
        let model = cantilever(rod, Vec3::z() * 50.0, Vec3::z() * (200.0 * PI));
        let exact = [4.803_249_66e-3, 7.249_684_7e-5, -7.644_174_173_2e-2];
        tip("ten circles", model, options, exact.map(Some), 50);
    }
}

/// A scene with a preset, or with so many elements and a harder law.
fn preset(fidelity: &str, text: &str) -> Scene {
    let text = format!("fidelity = \"{fidelity}\"\n{}", text.replace("ELEMENTS", ""));
    Scene::from_toml(&text, Path::new("")).unwrap()
}

fn finer(elements: usize, text: &str) -> Scene {
    let text = text.replace("ELEMENTS", &format!("elements = {elements}"));
    Scene::from_toml(&format!("{text}\n[contact]\nstiffness = 1e4"), Path::new("")).unwrap()
}

fn run_scene(scene: &Scene, case: &str) -> Observation {
    let mut options = Options::default();
    options.newton.tol_increment = scene.solver.tol_increment.unwrap_or(1e-8);
    end_of(scene.model.clone(), &scene.stages, &options, case).0
}

/// A closed trefoil knot put to rest, without excess link: lines of contact between crossing strands.
const TREFOIL: &str = r#"
[[rods]]
name = "knot"
closed = true
shape = { kind = "torus_knot", length = 1.0, windings = [2, 3] }
section = { bending = 1.0, twisting = 1.0, stretching = 1e6, shearing = 1e6, contact_radius = 0.0075 }
ELEMENTS
"#;

/// An isotropic ring with C/B = 1, D/L = .025, its link lowered by two and a half.
const RING: &str = r#"
[[rods]]
name = "ring"
closed = true
shape = { kind = "circle", length = 2.0 }
section = { bending = 3.0, twisting = 3.0, stretching = 1e6, shearing = 1e6, contact_radius = 0.025 }
ELEMENTS
[[stages]]
ramp = { excess_link = { to = -2.9 } }
steps = 12
"#;

/// A ring in the plane, squeezed by pressure until it touches itself and beyond: pR³/B = 7.
const SQUEEZED: &str = r#"
planar = true
[[rods]]
name = "ring"
closed = true
shape = { kind = "circle", radius = 1.0 }
section = { bending = 1.0, twisting = 1.0, stretching = 1e6, shearing = 1e6, contact_radius = 0.05 }
ELEMENTS
[[stages]]
ramp = { pressure = { to = 7.0 } }
steps = 7
"#;

#[test]
fn scenes() {
    for (case, text) in [("trefoil", TREFOIL), ("ring", RING), ("squeezed ring", SQUEEZED)] {
        let elements = preset("reference", text).model.rods[0].num_elements;
        let exact = run_scene(&finer(3 * elements / 2, text), &format!("{case}, for comparison"));
        for fidelity in Fidelity::ALL {
            let word = format!("{fidelity:?}").to_lowercase();
            let scene = preset(&word, text);
            let case = format!("{fidelity:?}, {case}");
            let seen = run_scene(&scene, &case);
            let allowed = fidelity.accuracy();
            hold_gap(&case, &seen, scene.model.rods[0].section.contact_radius, fidelity);
            hold(
                &case,
                &[
                    ("energy", elastic(&seen), elastic(&exact), allowed.energy),
                    ("force", seen.total_contact_force, exact.total_contact_force, allowed.contact_force),
                ],
            );
            if !scene.model.planar {
                hold(&case, &[("writhe", seen.links[0].writhe, exact.links[0].writhe, allowed.writhe)]);
            }
            if case.ends_with("ring") && !scene.model.planar {
                let moments = [&seen, &exact].map(|s| s.links[0].seam_moment);
                hold(&case, &[("moment", moments[0], moments[1], allowed.twisting_moment)]);
            }
        }
    }
}

/// The minicircle of the examples, from the flat circle through the figure-eight to its supercoil, with meshes of the
/// presets: runs to its end, on every one.
#[test]
fn the_minicircle_with_every_preset() {
    let text =
        include_str!("../../examples/minicircle.toml").replace("elements = 48", "").replace("tol_penetration", "#");
    for (word, elements) in [("draft", 12), ("balanced", 32), ("reference", 64)] {
        let scene = Scene::from_toml(&format!("fidelity = \"{word}\"\n{text}"), Path::new("")).unwrap();
        assert_eq!(scene.model.rods[0].num_elements, elements);
        let seen = run_scene(&scene, &format!("{word}, minicircle"));
        assert!((seen.links[0].link + 3.0).abs() < 1e-9);
        // of finer runs, which agree to 1e-4
        hold(word, &[("writhe", seen.links[0].writhe, -1.8449, scene.fidelity.unwrap().accuracy().writhe)]);
    }
}

/// Symptom: bends that arise from a straight start, here the neck of a planar loop that closes, outgrew the mesh that a
/// preset had chosen: the energy was off by 2 %, the contact force by 14 %, and nothing was reported. The estimate of
/// the mesh's error is within a factor of three of the error, and the note appears where the preset's word does not
/// hold.
#[test]
fn bends_that_outgrow_the_mesh_are_reported() {
    let text = |more: &str| {
        format!(
            "fidelity = \"balanced\"\nplanar = true\n[[rods]]\nshape = {{ kind = \"line\", length = 1.0 }}\n{more}\n\
             section = {{ bending = 1.0, twisting = 1.0, stretching = 1e6, shearing = 1e6, contact_radius = 0.01 }}\n\
             [[supports]]\nat = \"start\"\nposition = true\nrotation = true\n\
             [[supports]]\nat = \"end\"\nposition = true\nrotation = true\n\
             [[stages]]\nramp = {{ displacement = {{ at = \"end\", to = [-0.95, 0.0, 0.0] }} }}\nsteps = 20\n"
        )
    };
    let steps = |more: &str| {
        let scene = Scene::from_toml(&text(more), Path::new("")).unwrap();
        let mut seen = Vec::new();
        let solution = run(scene.model, &scene.stages, &Options::from(Fidelity::Balanced), &mut |progress| {
            seen.push(observe(progress));
            ControlFlow::Continue(())
        });
        assert_eq!(solution.unwrap().status, Status::Converged);
        seen
    };
    let (chosen, fine) = (steps("order = 3"), steps("elements = 48"));
    let mut noted = 0;
    for (ours, exact) in chosen.iter().zip(&fine).skip(19) {
        let error = (elastic(ours) / elastic(exact) - 1.0).abs();
        println!("step {}: off by {error:.1e}, estimated {:.1e}", ours.step, ours.mesh_error);
        assert!(error < 3.0 * ours.mesh_error && ours.mesh_error < 3.0 * error, "{}: {error:e}", ours.step);
        let note = mesh_note(Fidelity::Balanced, ours);
        assert_eq!(note.is_some(), ours.mesh_error > 1e-3);
        noted += usize::from(note.is_some());
    }
    assert_eq!(noted, 1);
    assert!(fine.iter().all(|seen| mesh_note(Fidelity::Balanced, seen).is_none()));
}
