//! A run's base pairs, from its folder.

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::io::base_pairs::BasePairs;
use supercoil::io::export::base_pairs;
use supercoil::io::run::run_scene;
use supercoil::math::link::linking_number;
use supercoil::scene::Scene;
use supercoil::solve::Status;

const RING: &str = r#"
title = "minicircle of 336 base pairs"
units = { length = "nm", force = "pN" }
[[rods]]
closed = true
shape = { kind = "circle", length = 114.24 }
section = { bending = 205.7, twisting = 308.6, stretching = 1100, shearing = 1100.0, contact_radius = 2.5 }
elements = 24
[[stages]]
ramp = { excess_link = { to = -1.0 } }
steps = 1
[output]
vtk = false
picture = false
"#;

#[test]
fn a_run_is_exported_with_its_link() {
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join("export");
    std::fs::remove_dir_all(&dir).ok();
    let run = |text: &str, dir: &Path| {
        let scene = Scene::from_toml(text, Path::new("")).unwrap();
        let outcome = run_scene(scene, dir, &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(outcome.status, Status::Converged);
    };
    run(RING, &dir);
    let pairs = base_pairs(&dir, None, None).unwrap();
    assert_eq!((pairs.positions.len(), pairs.closed), (336, true));
    // 32 turns at rest
    let [a, b] = pairs.strands();
    assert_eq!(linking_number(&a, &b).round(), 31.0);
    let back = BasePairs::from_oxdna(&pairs.oxdna_configuration(), true).unwrap().strands();
    assert_eq!(linking_number(&back[0], &back[1]).round(), 31.0);
    let refused = base_pairs(&dir, Some("plasmid"), None).unwrap_err().to_string();
    assert_eq!(refused, "rod = \"plasmid\": must be one of \"rod\"");
    let other = dir.join("other_unit");
    run(&RING.replace("\"nm\"", "\"m\""), &other);
    let refused = base_pairs(&other, None, None).unwrap_err().to_string();
    assert!(refused.contains("units.length of the scene = \"m\": must be \"nm\""), "{refused}");
}
