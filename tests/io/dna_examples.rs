//! Examples of DNA with sequences, proteins and salt: one number each.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::io::run::options;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::scene::{ContactLaw, Scene};
use supercoil::solve::{self, Status};

fn steps(name: &str) -> Vec<Observation> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("examples/{name}.toml"));
    let scene = Scene::read(&file).unwrap();
    assert!(scene.model.electrostatics.is_some() && scene.model.contact.law != ContactLaw::None);
    let (choices, mut all) = (options(&scene), Vec::new());
    let solution = solve::run(scene.model, &scene.stages, &choices, &mut |progress| {
        all.push(observe(progress));
        ControlFlow::Continue(())
    });
    assert_eq!(solution.unwrap().status, Status::Converged, "{name}");
    all
}

/// The loop that is closed costs 17 kT, the one with a turn more 52; charges have their share, and strands stay apart.
#[test]
fn the_lac_repressor_closes_a_loop() {
    let all = steps("laci_loop");
    let [closed, turned] = [all[20].energies, all[28].energies].map(|energies| energies.over(4.142));
    assert!((closed.total - 16.95).abs() < 0.05, "{closed:?}");
    assert!((turned.total - 52.12).abs() < 0.05, "{turned:?}");
    assert!(closed.electrostatic > 1.0 && turned.electrostatic > closed.electrostatic, "{closed:?} {turned:?}");
    let gap = all[28].min_gap.unwrap().lower;
    assert!(gap > 3.0, "{gap}");
}

/// A figure-eight at Lk 16, its crossing held open by charges.
#[test]
fn a_minicircle_with_a_tracts_coils_up() {
    let all = steps("a_tract_minicircle");
    let last = all.last().unwrap();
    assert!((last.links[0].link - 16.0).abs() < 1e-6, "{:?}", last.links);
    assert!((last.links[0].writhe + 0.807).abs() < 2e-3, "{:?}", last.links);
    assert!(last.num_sites == 0 && last.energies.electrostatic > 10.0, "{:?}", last.energies);
}
