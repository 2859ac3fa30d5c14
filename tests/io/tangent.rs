//! What a scene requests of the tangent: modes, free energies, sensitivities, in files and on the terminal.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::f64::consts::PI;
use std::path::Path;

use serde_json::Value;
use supercoil::io::vtk::read_vtp;

use crate::program::{folder, run, supercoil, table};

/// A ring of C/B = 1.5 and length 1 with an excess link, in the plane of its circle.
fn ring(link: f64, outputs: &str) -> String {
    format!(
        "[[rods]]\nname = \"ring\"\nclosed = true\nshape = {{ kind = \"circle\", length = 1.0 }}\nelements = 16\n\
         section = {{ bending = 1.0, twisting = 1.5, stretching = 1e8, shearing = 1e8, contact_radius = 0.0 }}\n\
         [[stages]]\nramp = {{ excess_link = {{ to = {link:?} }} }}\nsteps = 2\n\
         [output]\npicture = false\nview = false\n{outputs}\n"
    )
}

fn summary(dir: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(dir.join("out/summary.json")).unwrap()).unwrap()
}

const ALL: &str = "modes = 4\nfree_energy = true\nsensitivity_of = [\"energy\", \"twist:ring\"]\n\
                   sensitivity_to = [\"link\", \"twisting\"]";

#[test]
fn modes_free_energies_and_sensitivities_of_runs() {
    let [less, more] = ["less", "more"].map(folder);
    let (code, _, error) = run(&less, &ring(0.2, ALL));
    assert_eq!(code, 0, "{error}");
    let (code, printed, error) = run(&more, &ring(0.4, ALL));
    assert_eq!(code, 0, "{error}");
    assert!(printed.contains("softest modes") && printed.contains("d(energy)/d(link)"), "{printed}");
    let [flat, twisted] = [summary(&less), summary(&more)];
    let product = |summary: &Value| -> f64 {
        summary["modes"]["eigenvalues"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).product()
    };
    let of = |x: f64| (1.0 - x * x / 3.0).powi(2);
    assert!((product(&twisted) / product(&flat) / (of(0.6) / of(0.3)) - 1.0).abs() < 1e-4);
    let slopes: Vec<f64> =
        twisted["sensitivities"].as_array().unwrap().iter().map(|s| s["value"].as_f64().unwrap()).collect();
    for (found, exact) in slopes.iter().zip([4.0 * PI * PI * 1.5 * 0.4, 2.0 * PI * PI * 0.16, 1.0, 0.0]) {
        assert!((found - exact).abs() < 1e-4, "{slopes:?}");
    }
    let shapes = read_vtp(&more.join("out/modes.vtp")).unwrap();
    assert!(format!("{shapes:?}").contains("mode_4_rotation"));
    let [less, more] = [less, more].map(|dir| dir.join("out"));
    let command = ["free-energy", more.to_str().unwrap(), less.to_str().unwrap(), "--kT", "0.02"];
    let out = supercoil(&command);
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let number = |after: &str| -> f64 {
        let rest = text.split(after).nth(1).unwrap();
        rest.trim_start().split([',', ' ', '\n']).next().unwrap().parse().unwrap()
    };
    let elastic = 2.0 * PI * PI * 1.5 * (0.16 - 0.04) / 0.02;
    let thermal = number("free energy") - number("potential");
    let p = |x: f64| -2.0 * (PI * (1.0 + x * x).sqrt()).sin() / (PI * x * x * (1.0 + x * x).sqrt());
    assert!((number("potential") - elastic).abs() < 1e-2, "{text}");
    // on this mesh; it converges as the node spacing
    assert!((thermal - (p(0.6) / p(0.3)).ln()).abs() < 0.02, "{text}");
    // the same questions to the folder of a run that asked none
    let plain = folder("plain");
    let (code, _, error) = run(&plain, &ring(0.4, ""));
    assert_eq!(code, 0, "{error}");
    let plain = plain.join("out");
    let said = |arguments: &[&str]| {
        let out = supercoil(arguments);
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        String::from_utf8_lossy(&out.stdout).into_owned()
    };
    let glb = plain.join("modes.glb");
    let asked = said(&["modes", plain.to_str().unwrap(), "--count", "4", "--glb", glb.to_str().unwrap()]);
    assert!(glb.metadata().unwrap().len() > 1000);
    assert!(printed.contains(asked.lines().nth(2).unwrap()), "{asked}");
    assert!(plain.join("modes.vtp").exists() && plain.join("modes.html").exists());
    // the scene wants no pictures
    assert!(!plain.join("modes.png").exists());
    let asked = said(&["sensitivity", plain.to_str().unwrap(), "--of", "energy,twist:ring", "--to", "link,twisting"]);
    assert!(asked.lines().filter(|line| printed.contains(line)).count() == 4, "{asked}");
    assert_eq!(table(&plain.join("sensitivities.csv")).1.len(), 4);
    assert!(
        said(&command).contains("free energy")
            && said(&["free-energy", plain.to_str().unwrap(), command[2], "--kT", "0.02"]) == said(&command)
    );
    let out = supercoil(&["j-factor", plain.to_str().unwrap(), command[2], "--kT", "0.02"]);
    assert!(!out.status.success() && String::from_utf8_lossy(&out.stderr).contains("six fewer"));
    let out = supercoil(&["modes", std::env::temp_dir().join("no_such_run").to_str().unwrap()]);
    assert!(!out.status.success() && String::from_utf8_lossy(&out.stderr).contains("no final state"));
    // standard deviations, and slopes, of one run: what is twist is not writhe
    let asked = said(&["free-energy", plain.to_str().unwrap(), "--of", "twist,writhe", "--to", "link", "--kT", "0.02"]);
    let after = |name: &str, text: &str| -> f64 {
        let line = asked.lines().find(|line| line.starts_with(name)).unwrap();
        line.split(text).nth(1).unwrap().split_whitespace().next().unwrap().parse().unwrap()
    };
    assert!((after("twist", "= ") - 0.4).abs() < 1e-5, "{asked}");
    assert!((after("twist", "± ") / after("writhe", "± ") - 1.0).abs() < 1e-3, "{asked}");
    let slope = (p(1.5 * 0.401).ln() - p(1.5 * 0.399).ln()) / 0.002;
    assert!((after("d(free energy)/d(link)", " (") / 0.02 - slope).abs() < 0.1, "{asked} {slope}");
    // units are not nm and pN: kT is not known
    let out = supercoil(&command[..3]);
    assert!(!out.status.success() && String::from_utf8_lossy(&out.stderr).contains("kT"));
}

/// A steel wire between pins, of unit density in N, mm and kg: the frequency of its first mode is π/2 √(EI/μL⁴).
#[test]
fn frequencies_of_a_wire() {
    let dir = folder("wire");
    let scene = "[[rods]]\nname = \"wire\"\nshape = { kind = \"line\", length = 100.0 }\nelements = 16\nmass = 0.02\n\
                 section = { bending = 500.0, twisting = 400.0, stretching = 1e6, shearing = 1e6, contact_radius = \
                 0.0 }\n\
                 [[supports]]\nat = \"start\"\nposition = true\nrotation = [\"x\"]\n\
                 [[supports]]\nat = \"end\"\nposition = true\n\
                 [output]\nmodes = 1\n";
    let (code, printed, error) = run(&dir, scene);
    assert_eq!(code, 0, "{error}");
    let found = summary(&dir)["modes"]["frequencies"][0].as_f64().unwrap();
    let picture = std::fs::read(dir.join("out/modes.png")).unwrap();
    assert!(picture.len() > 1000, "{}", picture.len());
    let exact = PI / 2.0 * (500.0 / (0.02 / 100.0 * 1e8_f64)).sqrt();
    assert!((found / exact - 1.0).abs() < 1e-3 && printed.contains("frequency"), "{found} {exact}");
}

#[test]
fn misspelt_sensitivities_are_refused_before_the_run() {
    let dir = folder("misspelt");
    let wrong = [
        ("sensitivity_of = [\"writing\"]\nsensitivity_to = [\"load\"]", "writhe"),
        ("sensitivity_of = [\"writhe:rung\"]\nsensitivity_to = [\"load\"]", "ring"),
        ("sensitivity_of = [\"writhe\"]\nsensitivity_to = [\"bend\"]", "bending"),
        ("sensitivity_of = [\"writhe\"]", "sensitivity_to"),
    ];
    for (outputs, named) in wrong {
        let (code, _, error) = run(&dir, &ring(0.1, outputs));
        assert!(code != 0 && error.contains(named), "{code} {error}");
        assert!(!dir.join("out/summary.json").exists());
    }
}
