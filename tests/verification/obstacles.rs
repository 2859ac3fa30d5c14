//! Rods at cylinders and in spheres: closed forms, without friction.
//!
//! * A ring of length L and radius ρ about a cylinder that is blown up. Its curvature per reference length stays 2π/L and its
//!   stretch is λ = 2πρ/L, so that the energy is ½L EA (λ − 1)² and a constant. The pressure in all is its slope, 2π T with the
//!   tension T = EA (λ − 1), the same everywhere: T/ρ per present length. The contact curve of a
//!   stretched rod lies beside the rod between its nodes, h apart; forces are off by about (λh/ρ)²/4 for it: 4.0e-3 on 16
//!   elements, 4.2e-4 on 48.
//! * A rope over a pulley, W at each end. On the cylinder its curvature is 1/ρ, ρ = R + ε, its tension T is even, and the
//!   pressure is T/ρ. A long free end has ½B κ² = W (1 − cos θ), θ its angle with the weight. Curvature is continuous where it
//!   lifts off: cos θ = 1 − B/(2 W ρ²). There T = W cos θ, and the cylinder pushes with W sin θ at the one point, because shear is W
//!   sin θ beyond and zero on the arc, whose half angle is ½π − θ. The pressure in all is 2 (T (½π − θ) + W sin θ); its sum as
//!   vectors is 2W.
//! * A ring in a sphere that is made smaller than it: as long as it is a circle, on a great circle, its energy is as about the
//!   cylinder, with λ < 1.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::common::verify;
use crate::planes;

use supercoil::observe::report::{Observation, SiteKind};

/// All steps of a scene, each with its certificate.
fn steps(text: &str) -> Vec<Observation> {
    let seen = planes::steps(text);
    seen.iter().for_each(|step| assert_eq!(step.status, "converged", "{}", step.certificate));
    seen
}

/// A closed ring of radius 1, EA = 1000, in the x-y plane.
const RING: &str = "planar = true\n[[rods]]\nname = \"ring\"\nclosed = true\nshape = { kind = \"circle\", radius = 1.0 }\n\
    section = { bending = 1.0, twisting = 1.0, stretching = 1e3, shearing = 1e3, contact_radius = 0.05 }\nelements = 48\n";

#[test]
fn a_ring_about_a_growing_cylinder_is_stretched_evenly() {
    let text = format!(
        "{RING}[[obstacles]]\nname = \"balloon\"\nshape = \"cylinder\"\naxis = [0, 0, 2]\nradius = 0.94\n\
         [[stages]]\nramp = {{ obstacle = {{ radius = 1.05 }} }}\nsteps = 4\n"
    );
    let seen = steps(&text);
    let last = &seen[seen.len() - 1];
    assert!(seen[0].obstacle_sites.is_empty());
    let force = TAU * 1e3 * (1.10 - 1.0);
    verify("ring about a cylinder", "pressure in all", last.obstacle_reactions[0].force, force, 1e-3 * force);
    let energy = 0.5 * TAU * 1e3 * 0.1f64.powi(2);
    verify("ring about a cylinder", "stretching energy", last.energies.stretching, energy, 2e-3 * energy);
    let push: f64 = last.obstacle_reactions[0].force_on_rods.iter().map(|f| f.abs()).sum();
    assert!(push < 1e-6 * force, "{push}");
}

#[test]
fn a_rope_over_a_pulley_lifts_off_where_its_curvature_says() {
    let (bending, weight, radius) = (0.2_f64, 2.0, 0.02);
    let rho = 1.0 + radius;
    let text = format!(
        "planar = true\n[[rods]]\nname = \"rope\"\nshape = {{ kind = \"line\", start = [-4.3, {rho:?}, 0], length = 8.6 }}\n\
         section = {{ bending = {bending:?}, twisting = 0.2, stretching = 1e5, shearing = 1e5, contact_radius = {radius:?} }}\n\
         elements = 96\n[[obstacles]]\nname = \"pulley\"\nshape = \"cylinder\"\naxis = [0, 0, 1]\nradius = 1.0\n\
         [[supports]]\nat = {{ arc = 4.3 }}\nposition = [\"x\"]\n\
         [[loads]]\nat = \"start\"\nforce = [0, {down:?}, 0]\n[[loads]]\nat = \"end\"\nforce = [0, {down:?}, 0]\n\
         [[stages]]\nramp = {{ load = 1.0 }}\nsteps = 10\n",
        down = -weight,
    );
    let seen = steps(&text);
    let last = &seen[seen.len() - 1];
    let angle = (1.0 - bending / (2.0 * weight * rho * rho)).acos();
    let (tension, half) = (weight * angle.cos(), FRAC_PI_2 - angle);
    let all = 2.0 * (tension * half + weight * angle.sin());
    let pulley = &last.obstacle_reactions[0];
    verify("rope over a pulley", "pressure in all", pulley.force, all, 1e-4 * all);
    verify("rope over a pulley", "force on the rope", pulley.force_on_rods[1], 2.0 * weight, 1e-7 * weight);
    let lines: Vec<_> = last.obstacle_sites.iter().filter(|site| site.kind == SiteKind::Line).collect();
    let (from, to) =
        lines.iter().fold((f64::INFINITY, 0.0f64), |(from, to), site| (from.min(site.arc[0]), to.max(site.arc[1])));
    verify("rope over a pulley", "arc on the pulley", to - from, 2.0 * rho * half, 0.05);
    // 5 N hold 5 N: the post at the middle bears nothing along x
    assert!(last.reactions[0].force[0].abs() < 1e-6 * weight, "{:?}", last.reactions);
}

#[test]
fn a_ring_in_a_shrinking_sphere_is_compressed_evenly() {
    let text = format!(
        "{RING}[[obstacles]]\nname = \"cavity\"\nshape = \"sphere\"\nside = \"inside\"\nradius = 1.06\n\
         [[stages]]\nramp = {{ obstacle = {{ radius = 1.0495 }} }}\nsteps = 3\n"
    );
    let seen = steps(&text);
    let last = &seen[seen.len() - 1];
    let force = TAU * 1e3 * 0.0005;
    verify("ring in a sphere", "pressure in all", last.obstacle_reactions[0].force, force, 1e-3 * force);
}
