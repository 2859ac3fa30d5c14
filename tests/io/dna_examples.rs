//! Examples of DNA with sequences, proteins and salt: one number each.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::dna::THERMAL_ENERGY;
use supercoil::dna::base_pairs::BasePairs;
use supercoil::dna::sequence::{Sequence, Steps};
use supercoil::io::export::base_pairs;
use supercoil::io::run::{options, run_scene};
use supercoil::math::link::linking_number;
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
    let gap = all[28].contact_gap.unwrap().lower;
    assert!(gap > 3.0, "{gap}");
}

/// Two links of the wild-type loop in one pose; the sweep has five poses. On three and six times the elements they cost
/// 39.36, 39.35 and 21.10, 21.11 kT.
#[test]
fn the_operators_of_lac_close_to_loops_by_a_table_of_poses() {
    let sweep = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/sweeps/lac_loop.toml");
    for (turns, energy) in [("0", 39.49), ("1", 21.15)] {
        let scene = Scene::read_with(&sweep, &[format!("stages.1.ramp.pose.extra_turns={turns}")]).unwrap();
        let (choices, mut last) = (options(&scene), None);
        let solution = solve::run(scene.model, &scene.stages, &choices, &mut |progress| {
            last = Some(observe(progress));
            ControlFlow::Continue(())
        });
        assert_eq!(solution.unwrap().status, Status::Converged, "{turns}");
        let total = last.unwrap().energies.total / THERMAL_ENERGY;
        assert!((total - energy).abs() < 0.05, "{turns}: {total}");
    }
}

/// A plasmid at rest, base by base: two strands that are linked 240 times, and their bases as they were given.
#[test]
fn a_plasmid_is_made_ready_for_oxdna() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join("puc19_to_oxdna");
    std::fs::remove_dir_all(&dir).ok();
    let quiet = ["output.vtk=false", "output.picture=false"].map(str::to_owned);
    let scene = Scene::read_with(&root.join("examples/puc19_to_oxdna.toml"), &quiet).unwrap();
    let outcome = run_scene(scene, &dir, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(outcome.status, Status::Converged);
    let sequence = Sequence::read(&root.join("examples/dna/pUC19.fasta")).unwrap();
    let pairs = base_pairs(&dir, None, Some(sequence.num_bases())).unwrap();
    let back = BasePairs::from_oxdna(&pairs.oxdna_configuration(), true).unwrap();
    let [a, b] = back.strands();
    assert_eq!((a.len(), linking_number(&a, &b).round()), (2686, 240.0));
    let file = dir.join("pUC19.top");
    BasePairs::write(&file, pairs.oxdna_topology(&sequence).unwrap()).unwrap();
    assert_eq!(Sequence::read(&file).unwrap(), sequence);
}

/// The same plasmid with its sequence, ten steps a block: Lk counts the turns that frames leave out, and they are in
/// what is exported.
#[test]
fn a_plasmid_in_blocks_is_exported_with_its_link() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join("puc19_in_blocks");
    std::fs::remove_dir_all(&dir).ok();
    let sequence = Sequence::read(&root.join("examples/dna/pUC19.fasta")).unwrap();
    let helix = sequence.helix(&Steps::protein_dna_1998().unwrap(), true).unwrap();
    let text = format!(
        "units = {{ length = \"nm\", force = \"pN\" }}\n[[rods]]\nclosed = true\n\
         shape = {{ kind = \"circle\", length = {} }}\nelements = 96\nsection = {{ contact_radius = 0.0 }}\n\
         sequence = {{ fasta = \"pUC19.fasta\", steps = \"protein-dna-1998\", block = 10 }}\n\
         link = {}\n[contact]\nlaw = \"none\"\n[output]\nvtk = false\npicture = false\n",
        helix.length,
        helix.turns.round()
    );
    let scene = Scene::from_toml(&text, &root.join("examples/dna")).unwrap();
    let outcome = run_scene(scene, &dir, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(outcome.status, Status::Converged);
    let link = outcome.steps.last().unwrap().links[0].link;
    assert!((link - helix.turns.round()).abs() < 1e-9, "{link} {}", helix.turns);
    let pairs = base_pairs(&dir, None, Some(sequence.num_bases())).unwrap();
    let [a, b] = pairs.strands();
    assert_eq!(linking_number(&a, &b).round(), link.round());
}

/// A figure-eight at Lk 16, its crossing held open by charges. The writhe is that of this mesh, a node a base pair:
/// natural strains jump twice inside an element. On two nodes a base pair it is −0.836.
#[test]
fn a_minicircle_with_a_tracts_coils_up() {
    let all = steps("a_tract_minicircle");
    let last = all.last().unwrap();
    assert!((last.links[0].link - 16.0).abs() < 1e-6, "{:?}", last.links);
    assert!((last.links[0].writhe + 0.920).abs() < 5e-3, "{:?}", last.links);
    assert!(last.num_sites == 0 && last.energies.electrostatic > 10.0, "{:?}", last.energies);
}
