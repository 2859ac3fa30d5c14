//! Relations hold for a part of the scenes; `cargo bench --bench relations` has all of them.

use std::f64::consts::FRAC_1_PI;
use std::path::Path;

use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status};

use crate::relations::draft::Draft;
use crate::relations::known::{KNOWN, is_known};
use crate::relations::relation::{Findings, Relation, examine};
use crate::relations::{scenes, tally};

/// Every so many scenes are tried here, of those that take little time.
const EVERY: usize = 3;

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_TARGET_TMPDIR"), "/relations"))
}

/// What takes longer than all others together.
fn is_slow(scene: &Draft) -> bool {
    scene.has("charged") || (scene.has("sequence") && !scene.has("no_contact"))
}

#[test]
fn scenes_agree() {
    let dir = folder().join("agree");
    let quick = scenes().into_iter().step_by(EVERY).filter(|scene| !is_slow(scene));
    let found: Vec<Findings> = quick.map(|scene| examine(&scene, &dir, &Relation::ALL)).collect();
    println!("{}", tally::table(&found));
    let new = |scene: &Findings| {
        let broken = scene.broken().into_iter().filter(|&relation| !is_known(relation, &scene.name));
        broken.map(|relation| format!("{}: {} {:?}", scene.name, relation.name(), scene.notes)).collect::<Vec<_>>()
    };
    let wrong: Vec<String> = found.iter().flat_map(new).collect();
    assert!(found.len() >= 20 && wrong.is_empty(), "{} scenes\n{}", found.len(), wrong.join("\n"));
}

/// What is listed as known is still so: the list shrinks with the faults.
#[test]
fn known_failures_are_still_there() {
    let (dir, all) = (folder().join("known"), scenes());
    for known in KNOWN {
        for name in known.scenes {
            let scene = all.iter().find(|scene| scene.name == *name).unwrap();
            // where rods fall last bits decide whether a search finds a state
            let is_chance = scene.has("unsupported") && known.relation != Relation::Converges;
            if is_slow(scene) || is_chance {
                continue;
            }
            let found = examine(scene, &dir, &[known.relation]);
            let (relation, reason) = (known.relation.name(), known.reason);
            assert!(
                found.broken().contains(&known.relation),
                "{name}: {relation} holds, take it off the list: {reason}"
            );
        }
    }
}

/// Pressure was p times an area with a sign: it blew rings up that run clockwise.
#[test]
fn pressure_pushes_inwards_whichever_way_a_ring_runs() {
    let width = |normal: Vec3| {
        let circle = Shape::Circle { length: 1.0, center: Vec3::new(300.0, 0.0, 0.0), normal };
        let section = Section::isotropic(1.0, 1.0, 1e3, 1e3, 0.0);
        let ring = Rod::new("ring", &circle, RodMesh::closed(8, 3), section, Natural::AsShaped).unwrap();
        let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 })];
        let model = Model { rods: vec![ring], supports, planar: true, contact: Contact::NONE, ..Model::default() };
        let mut solver = Solver::new(model, Options::default()).unwrap();
        let report = solver.step_to(&[Ramp::Pressure { rod: 0, to: 50.0 }]).unwrap();
        assert_eq!(report.status, Status::Converged);
        let positions = solver.engine().positions(0);
        (positions[12] - positions[0]).norm()
    };
    let [left, right] = [width(Vec3::z()), width(-Vec3::z())];
    assert!((left - right).abs() < 1e-9 && left < FRAC_1_PI - 1e-3, "{left} {right}");
}
