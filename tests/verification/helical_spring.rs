//! Love's helical spring (A. E. H. Love, Treatise, §271): a helix pulled and turned by a wrench about its axis stays a
//! helix, at any size of the deformation.
//!
//! Radius 1, pitch ½, four turns, natural as shaped, B = 1, C = .8 (EA = GA = 1e8), under the axial force F and couple
//! T. With r the radius, 2πc the pitch, q = r² + c², curvature κ = r/q, torsion τ = c/q and sin α = c/√q, the moments B
//! (κ − κ₀) about the binormal and C (τ − τ₀) about the tangent balance the wrench:
//!
//! ```text
//! T   =  B (κ − κ₀) cos α + C (τ − τ₀) sin α
//! F r = −B (κ − κ₀) sin α + C (τ − τ₀) cos α
//! ```
//!
//! The end bears force and moment of the wrench where it comes to be; the start is clamped and turned to its final
//! slope, so that what the clamp exerts is the wrench, too. A scene in one file; its natural strains are measured on
//! the start shape. (Tolerance: these are known to the fourth order of the mesh, 24 elements a turn: 48 in all are 16
//! times as far off.)

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;

use common::{verify, verify_point};
use supercoil::observe::observe;
use supercoil::scene::Scene;
use supercoil::solve::{self, Options, Status};

const TURNS: f64 = 4.0;
const PITCH: f64 = 0.5;
const C: f64 = 0.8;

/// Radius and pitch/2π under the wrench, by Newton's method with differences.
fn helix(force: f64, couple: f64) -> [f64; 2] {
    let strains = |r: f64, c: f64| [r / (r * r + c * c), c / (r * r + c * c)];
    let [k0, t0] = strains(1.0, PITCH / TAU);
    let unbalanced = |r: f64, c: f64| {
        let ([k, t], size) = (strains(r, c), r.hypot(c));
        let (bending, twisting, sin, cos) = (k - k0, C * (t - t0), c / size, r / size);
        [bending * cos + twisting * sin - couple, -bending * sin + twisting * cos - force * r]
    };
    let (mut r, mut c) = (1.0, PITCH / TAU);
    for _ in 0..50 {
        let (f, h) = (unbalanced(r, c), 1e-7);
        let (fr, fc) = (unbalanced(r + h, c), unbalanced(r, c + h));
        let [a, b, d, e] = [(fr[0] - f[0]) / h, (fc[0] - f[0]) / h, (fr[1] - f[1]) / h, (fc[1] - f[1]) / h];
        let det = a * e - b * d;
        (r, c) = (r - (e * f[0] - b * f[1]) / det, c - (a * f[1] - d * f[0]) / det);
    }
    let left = unbalanced(r, c);
    assert!(left[0].abs() + left[1].abs() < 1e-14, "{left:?}");
    [r, c]
}

#[test]
fn a_helix_under_a_wrench_is_a_helix() {
    for (force, couple) in [(0.02, 0.01), (0.1, -0.05), (-0.01, 0.1)] {
        let [r, c] = helix(force, couple);
        let c0 = PITCH / TAU;
        let angle = TURNS * TAU * 1f64.hypot(c0) / r.hypot(c);
        // the start stays at (1, 0, 0), the axis moves to x = 1 − r
        let end = [1.0 - r + r * angle.cos(), r * angle.sin(), c * angle];
        let moment = [-force * r * angle.sin(), force * r * angle.cos(), couple];
        let slope = ((c / r).atan() - c0.atan()) / TAU;
        let text = format!(
            "[[rods]]\nname = \"spring\"\nshape = {{ kind = \"helix\", radius = 1.0, pitch = {PITCH}, turns = {TURNS} \
             }}\n\
             section = {{ bending = 1.0, twisting = {C}, stretching = 1e8, shearing = 1e8, contact_radius = 0.001 }}\n\
             elements = 96\nnatural = \"as-shaped\"\n\
             [[supports]]\nat = \"start\"\nposition = true\nrotation = true\n\
             [[loads]]\nat = \"end\"\nforce = [0.0, 0.0, {force:?}]\nmoment = {moment:?}\n\
             [[stages]]\nramp = {{ load = 1.0, rotation = {{ at = \"start\", axis = [1, 0, 0], turns = {slope:?} }} \
             }}\nsteps = 8\n"
        );
        let scene = Scene::from_toml(&text, Path::new("")).unwrap();
        let mut clamp = None;
        let solution = solve::run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
            clamp = observe(progress).reactions.pop();
            ControlFlow::Continue(())
        });
        let solution = solution.unwrap();
        assert_eq!(solution.status, Status::Converged);
        let case = format!("helical spring, F = {force}, T = {couple}");
        let tip = solution.solver.engine().positions(0)[96 * 3];
        verify_point(&format!("{case}, end"), &tip, end, 2e-6 * end[2]);
        let clamp = clamp.unwrap();
        for (k, exact) in [0.0, -force * r, -couple].into_iter().enumerate() {
            verify(&case, &format!("moment of the clamp about {}", ["x", "y", "z"][k]), clamp.moment[k], exact, 1e-6);
        }
    }
}
