//! Cases in which something was reported that was not so. Each has its scene, the right value, and how it is known.

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;

use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Model, NodeRef, Scene, Support};
use supercoil::solve::{self, Options, Status};

fn states(scene: Scene) -> Vec<Observation> {
    let mut states = Vec::new();
    let solution = solve::run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
        states.push(observe(progress));
        ControlFlow::Continue(())
    });
    assert_eq!(solution.unwrap().status, Status::Converged);
    states
}

fn of_file(name: &str) -> Vec<Observation> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes").join(name).with_extension("toml");
    states(Scene::read(&path).unwrap())
}

fn of_text(text: &str) -> Vec<Observation> {
    states(Scene::from_toml(text, Path::new("")).unwrap())
}

/// Symptom: a ring without contact had link 0 where 4 was prescribed, and nothing said so. Without contact its strands
/// pass through each other, as theory has it (the ring turns over at a link of √3 B/C, and comes back to the circle
/// with two turns less).
#[test]
fn a_link_that_is_lost_without_contact_is_noted() {
    let ring = |twisting: f64, to: f64| {
        format!(
            "[[rods]]\nclosed = true\nelements = 32\nshape = {{ kind = \"circle\", length = 1.0 }}\n\
             section = {{ bending = 1.0, twisting = {twisting}, stretching = 1e5, shearing = 1e5, contact_radius = \
             0.01 }}\n\
             [contact]\nlaw = \"none\"\n[[stages]]\nramp = {{ excess_link = {{ to = {to} }} }}\nsteps = 12\n"
        )
    };
    let mut lost_in_all = 0;
    for states in [of_file("ring_without_contact"), of_text(&ring(1.0, 3.0)), of_text(&ring(2.0, -2.5))] {
        let mut lost = 0;
        for state in &states {
            let link = state.links[0];
            let off = (link.link - link.excess_link).abs();
            let noted = state.notes.iter().any(|note| note.contains("than prescribed: strands have passed through"));
            assert_eq!(noted, off > 0.5, "step {}: link {} of {}", state.step, link.link, link.excess_link);
            assert!((off - off.round()).abs() < 1e-9 && state.status == "converged", "{off} {}", state.status);
            lost += usize::from(noted);
        }
        assert!(states.iter().any(|state| state.notes.is_empty()));
        lost_in_all += lost;
    }
    assert!(lost_in_all > 3, "{lost_in_all}");
}

/// Symptom: sites with a force of 5e-7 of the strongest at gaps of 2e-4, whose force on a strand was larger than the
/// integral of their pressure, and a snap that set 0.0000 free where nothing had moved. Mechanism: where the feet of a
/// strand run forth and back on a thick rod, what is counted twice is subtracted, but was not in the report.
#[test]
fn a_site_that_carries_nothing_is_none() {
    for name in ["site_without_force", "site_without_force_longer"] {
        let states = of_file(name);
        for state in &states {
            assert!(state.certificate.holds(), "{name}, step {}: {}", state.step, state.certificate);
            assert!(state.notes.is_empty(), "{name}, step {}: {:?}", state.step, state.notes);
            for site in &state.sites {
                let resultant = site.force_on_a.iter().map(|x| x * x).sum::<f64>().sqrt();
                let at = format!("{name}, step {}: force {resultant} of {} at {}", state.step, site.force, site.gap);
                assert!(site.force > 1e-3 && site.gap < 1e-6, "{at}");
                assert!(resultant <= site.force * (1.0 + 1e-9), "{at}");
            }
        }
        assert!(states.last().unwrap().sites.len() == 1, "{name}");
    }
}

/// A torus knot with its ends apart by a part of a turn, in an open rod that is straight by nature and clamped at one
/// end.
fn open_knot(windings: [f64; 2], hand: f64, gap: f64) -> Model {
    let [around, across] = windings;
    let point = |k: usize| {
        let t = 0.5 * gap + (TAU - gap) * k as f64 / 120.0;
        let out = 2.0 + (across * t).cos();
        Vec3::new(out * (around * t).cos(), out * (around * t).sin(), hand * (across * t).sin())
    };
    let shape = Shape::Points((0..=120).map(point).collect());
    let section = Section::isotropic(1.0, 1.0, 1e3, 1e3, 0.05);
    let rod = Rod::new("rope", &shape, RodMesh::open(32, 3), section, Natural::Straight).unwrap();
    let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 })];
    Model { rods: vec![rod], supports, ..Model::default() }
}

/// Symptom: a knot with short tails slid off while its start was searched for, every row said 0_1, and no note that it
/// had been another. The note compares with the shape as given.
#[test]
fn a_knot_that_slips_off_before_the_first_step_is_noted() {
    for (windings, hand, name) in [([2.0, 3.0], 1.0, "3_1*"), ([2.0, 3.0], -1.0, "3_1"), ([2.0, 5.0], 1.0, "5_1*")] {
        let mut seen = Vec::new();
        let model = open_knot(windings, hand, 0.3);
        let solution = solve::run(model, &[], &Options::default(), &mut |progress| {
            seen.push(observe(progress));
            ControlFlow::Continue(())
        });
        assert_eq!(solution.unwrap().status, Status::Converged);
        let (knot, notes) = (&seen[0].knots[0].name, &seen[0].notes);
        assert_eq!(knot, "0_1");
        let note = format!("is 0_1, not {name} as given: a strand has passed over an end");
        assert!(notes.iter().any(|it| it.contains(&note)), "{name}: {notes:?}");
    }
}

/// Symptom: forces of sites were off balance on the nodes of a knot by 6e-3, and beside their normals. Mechanism: a
/// strand bent about another one as tightly as they are thick has many nearest points on it; what is subtracted between
/// two of them acts at arcs of neither site. The sites on either side of it are one contact.
#[test]
fn contacts_of_strands_bent_about_each_other_balance() {
    // the first fails if sites have the arcs of one strand's zones only, the second has 12 sites if zones of a fold are
    // not joined
    for (name, sites) in [("knot_6_3_at_rest", 8), ("knot_8_8_at_rest", 11)] {
        let states = of_file(name);
        let start = &states[0];
        assert!(start.certificate.holds(), "{name}: {}", start.certificate);
        assert_eq!(start.sites.len(), sites, "{name}: {:?}", start.sites);
    }
}

/// Symptom: strands pulled to 1.1 of their length told a gap of 0 where the rods were 5e-4 radii apart. Mechanism:
/// contact curves kept the reference spacing of their nodes. Known from the elements' own centreline, which the
/// certificate looks at.
#[test]
fn stretched_strands_touch_where_they_are() {
    let strand = |name: &str, x: f64| {
        format!(
            "[[rods]]\nname = \"{name}\"\nelements = 16\nshape = {{ kind = \"line\", start = [{x}, 0, 0], direction = \
             [0, 0, 1], length = 1.0 }}\nsection = {{ bending = 1.0, twisting = 0.7, stretching = 300.0, shearing = \
             1e5, contact_radius = 0.0495 }}\n"
        )
    };
    let held =
        |at: &str| format!("[[supports]]\nrod = [\"a\", \"b\"]\nat = \"{at}\"\nposition = true\nrotation = true\n");
    for (stretch, turns) in [(0.1, 1.0), (0.0, 1.0), (0.2, 0.6)] {
        let text = strand("a", 0.05)
            + &strand("b", -0.05)
            + &held("start")
            + &held("end")
            + &format!(
                "[[stages]]\nramp = {{ displacement = {{ rod = [\"a\", \"b\"], at = \"end\", to = [0, 0, {stretch}] }} \
                 }}\nsteps = 1\n[[stages]]\nramp = {{ rotation = {{ rod = [\"a\", \"b\"], at = \"end\", axis = [0, 0, \
                 1], through = [0, 0, 0], turns = {turns} }} }}\nsteps = 8\n"
            );
        let states = of_text(&text);
        let last = states.last().unwrap();
        let (own, told) = (last.min_gap.unwrap().lower / 0.0495, last.contact_gap.unwrap().lower / 0.0495);
        println!("stretched by {stretch}: {own:.1e} {told:.1e}");
        assert!(last.certificate.holds() && last.total_contact_force > 1.0, "{}", last.certificate);
        assert!(own.abs() < 1e-4 && told.abs() < 1e-6, "stretched by {stretch}: {own:.1e} {told:.1e}");
    }
}
