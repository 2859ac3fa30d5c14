//! A twisted rod between coaxial clamps that are brought together writhes; the writhed shape may turn about the clamps'
//! axis at no cost while the sections spin back (isotropic, naturally straight).
//!
//! Symptom: half way on, a step halved 256 times ended as "load step too small". Mechanism: the tangent is singular
//! along that motion; increments of some 1e-3 node spacings went on for ever at residuals of 1e-11, and pushed searches
//! never settled. Threshold: such steps settle in tens of iterations, from step to step, and end quadratically.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::observe::observe;
use supercoil::scene::Scene;
use supercoil::solve::{self, Options, Status};

fn scene(direction: [f64; 3], elements: usize, steps: usize) -> Scene {
    let norm = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    let to = direction.map(|x| -0.15 * x / norm);
    let text = format!(
        "[[rods]]\nname = \"rod\"\nshape = {{ kind = \"line\", direction = {direction:?}, length = 1.0 }}\n\
         section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }}\n\
         elements = {elements}\n[[supports]]\nat = \"start\"\nposition = true\nrotation = true\n\
         [[supports]]\nat = \"end\"\nposition = true\nrotation = true\n\
         [[stages]]\nsteps = {steps}\nramp = {{ displacement = {{ at = \"end\", to = {to:?} }}, \
         rotation = {{ at = \"end\", axis = {direction:?}, turns = 1.0 }} }}\n"
    );
    Scene::from_toml(&text, Path::new("")).unwrap()
}

/// Whatever the axis, the same energy: 1e-7 of it, as increments of 1e-8 leave.
#[test]
fn writhing_between_coaxial_clamps() {
    let mut energies = Vec::new();
    for direction in [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 2.0, -0.5]] {
        let scene = scene(direction, 60, 8);
        let (mut most, mut energy) = (0, 0.0);
        let solution = solve::run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
            most = most.max(progress.report.iterations);
            energy = observe(progress).energies.total;
            ControlFlow::Continue(())
        });
        let solution = solution.unwrap();
        assert_eq!(solution.status, Status::Converged, "{direction:?}: {:?}", solution.failure.map(|f| f.to_string()));
        assert_eq!(solution.num_steps, 8, "no step is halved");
        assert!(most <= 40, "{direction:?}: {most} iterations in a step");
        energies.push(energy);
    }
    assert!(energies.iter().all(|e| (e - energies[0]).abs() < 1e-7 * energies[0]), "{energies:?}");
}
