//! Rods at cylinders and in spheres: closed forms, without friction.
//!
//! * A ring of length L and radius ρ about a cylinder that is blown up. Its curvature per reference length stays 2π/L
//!   and its stretch is λ = 2πρ/L, so that the energy is ½L EA (λ − 1)² and a constant. The pressure in all is its
//!   slope, 2π T with the tension T = EA (λ − 1), the same everywhere: T/ρ per present length.
//! * A rope over a pulley, W at each end. On the cylinder its curvature is 1/ρ, ρ = R + ε, its tension T is even, and
//!   the pressure is T/ρ. A long free end has ½B κ² = W (1 − cos θ), θ its angle with the weight. Curvature is
//!   continuous where it lifts off: cos θ = 1 − B/(2 W ρ²). There T = W cos θ, and the cylinder pushes with W sin θ at
//!   the one point, because shear is W sin θ beyond and zero on the arc, whose half angle is ½π − θ. The pressure in
//!   all is 2 (T (½π − θ) + W sin θ); its sum as vectors is 2W. Beyond, ds = dφ/κ(φ) from φ = θ on, so that the end
//!   hangs ρ cos θ + 2√(B/W) sin ½θ beside the axle and, s long from where it lifts off, s − 2√(B/W) (1 − cos ½θ) − ρ
//!   sin θ below it, longer by W/EA.
//! * A ring in a sphere that is made smaller than it: as long as it is a circle, on a great circle, its energy is as
//!   about the cylinder, with λ < 1. A wave w cos nφ across has the geodesic curvature w (1 − n²)/ρ² and lengthens the
//!   ring by ½w² (n² − 1)/ρ² a length. Its energy, ½B times the square of the curvature per reference length and ½EA (λ
//!   − 1)², grows by ½w² (n² − 1)/ρ² times B (n² − 1)/ρ² − P + B/ρ², P = EA (1 − λ): the circle is left at P = 4B/ρ², n
//!   = 2.
//! * A rod in a tube, pushed and turned: Thompson, Silveira, van der Heijden and Wiercigroch, Proc. R. Soc. A 468
//!   (2012) 1591. Away from its ends it is a helix on a cylinder of radius a = R − ε at the angle β to the axis. Its
//!   curvature is sin²β/a, it turns by sin β/a about the axis a length, and its torque is the moment M about the axis
//!   throughout. Under the tension T along the axis
//!
//!   ```text
//!   V = ½B sin⁴β/a² − T cos β − M sin β (1 − cos β)/a      ∂V/∂β = 0, p = −∂V/∂a
//!   ```
//!
//!   p the force of the wall per length. Forces at nodes, h apart, of a pressure that turns by k = h sin β/a from one
//!   to the next are shorter by ∫(1 − cos ku)(1 − u)² (1 + 2u) du of both sides: k²/15.
//! * A coil of many turns in a cavity: a closed curve, or nearly, in a ball of radius ρ has a mean curvature of at
//!   least 1/ρ (Fáry 1950), so its energy is at least ½BL/ρ².

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::common::{root, run_to_end as last, verify};
use crate::planes::steps;

use supercoil::math::Vec3;
use supercoil::observe::report::SiteKind;

/// A closed ring of radius 1, EA = 1000, in the x-y plane.
const RING: &str = "planar = true\n[[rods]]\nname = \"ring\"\nclosed = true\n\
    shape = { kind = \"circle\", radius = 1.0 }\n\
    section = { bending = 1.0, twisting = 1.0, stretching = 1e3, shearing = 1e3, contact_radius = 0.05 }\n\
    elements = 48\n";

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
    verify("ring about a cylinder", "pressure in all", last.obstacle_reactions[0].force, force, 5e-5 * force);
    let energy = 0.5 * TAU * 1e3 * 0.1f64.powi(2);
    verify("ring about a cylinder", "stretching energy", last.energies.stretching, energy, 1e-4 * energy);
    let push: f64 = last.obstacle_reactions[0].force_on_rods.iter().map(|f| f.abs()).sum();
    assert!(push < 1e-6 * force, "{push}");
}

#[test]
fn a_rope_over_a_pulley_lifts_off_where_its_curvature_says() {
    let (bending, weight, radius) = (0.2_f64, 2.0, 0.02);
    let rho = 1.0 + radius;
    let text = format!(
        "planar = true\n[[rods]]\nname = \"rope\"\n\
         shape = {{ kind = \"line\", start = [-4.3, {rho:?}, 0], length = 8.6 }}\n\
         section = {{ bending = {bending:?}, twisting = 0.2, stretching = 1e5, shearing = 1e5, contact_radius = \
         {radius:?} }}\n\
         elements = 96\n[[obstacles]]\nname = \"pulley\"\nshape = \"cylinder\"\naxis = [0, 0, 1]\nradius = 1.0\n\
         [[supports]]\nat = {{ arc = 4.3 }}\nposition = [\"x\"]\n\
         [[loads]]\nat = \"start\"\nforce = [0, {down:?}, 0]\n[[loads]]\nat = \"end\"\nforce = [0, {down:?}, 0]\n\
         [[stages]]\nramp = {{ load = 1.0 }}\nsteps = 10\n",
        down = -weight,
    );
    let (solution, last) = last(&text);
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
    let engine = solution.solver.engine();
    let (points, fields) = (engine.state().positions(), engine.nodal_fields(0));
    let free = 4.3 - rho * half;
    let end = points[points.len() - 1];
    let across = 2.0 * (bending / weight).sqrt();
    let beside = rho * angle.cos() + across * (0.5 * angle).sin();
    verify("rope over a pulley", "end beside the axle", end.x, beside, 1e-4);
    let below = free * (1.0 + weight / 1e5) - across * (1.0 - (0.5 * angle).cos()) - rho * angle.sin();
    verify("rope over a pulley", "end below the axle", -end.y, below, 2e-4);
    // away from the points where it lifts off
    let on_it = |p: &Vec3| p.y > rho * (0.7 * half).cos();
    let (mut even, mut pressed) = ([f64::INFINITY, 0.0f64], Vec::new());
    for (k, p) in points.iter().enumerate().filter(|(_, p)| on_it(p)) {
        let along = Vec3::new(p.y, -p.x, 0.0).normalize();
        let pull = fields.internal_force[k].dot(&along);
        even = [even[0].min(pull), even[1].max(pull)];
        pressed.push(fields.contact_force[k].norm());
    }
    for (name, found) in [("least", even[0]), ("largest", even[1])] {
        verify("rope over a pulley", &format!("{name} tension on it"), found, tension, 1e-3 * tension);
    }
    // from node to node it has the ripples of the mesh
    let mean = pressed.iter().sum::<f64>() / pressed.len() as f64;
    verify("rope over a pulley", "mean pressure, T/ρ", mean, tension / rho, 5e-3 * tension);
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

/// Below 4B/ρ² the ring stays on the great circle, above it folds along the wall.
#[test]
fn a_ring_in_a_sphere_leaves_the_great_circle() {
    let stretching = 1e3;
    let critical = stretching * (1.0 - root(0.9, 1.0, |rho| stretching * (1.0 - rho) - 4.0 / (rho * rho)));
    for (times, leaves) in [(0.98, false), (1.02, true)] {
        let compression = times * critical;
        let text = format!(
            "{}[[obstacles]]\nname = \"cavity\"\nshape = \"sphere\"\nside = \"inside\"\nradius = 1.06\n\
             [[stages]]\nramp = {{ obstacle = {{ radius = {:?} }} }}\nsteps = 3\n",
            RING.replace("planar = true\n", ""),
            1.0 - compression / stretching + 0.05
        );
        let seen = steps(&text);
        let last = &seen[seen.len() - 1];
        let bends = last.energies.bending / std::f64::consts::PI - 1.0;
        assert_eq!(bends > 1e-4, leaves, "{times} of the critical compression: {bends:e}");
        if !leaves {
            let force = TAU * compression;
            verify(
                "ring in a sphere",
                "pressure just below buckling",
                last.obstacle_reactions[0].force,
                force,
                1e-3 * force,
            );
        }
    }
}

#[test]
fn a_rod_in_a_tube_buckles_to_a_helix() {
    const RADIUS: f64 = 0.2;
    let (tube, thickness, twisting) = (0.25, 0.05, 0.8);
    for turns in [1.0, -0.5] {
        let text = format!(
            "[[rods]]\nname = \"rod\"\nshape = {{ kind = \"line\", direction = [0, 0, 1], length = 16.0 }}\n\
             section = {{ bending = 1.0, twisting = {twisting:?}, stretching = 1e6, shearing = 1e6, \
             contact_radius = {thickness:?} }}\nelements = 80\n\
             [[obstacles]]\nname = \"tube\"\nshape = \"cylinder\"\naxis = [0, 0, 1]\nradius = {tube:?}\n\
             side = \"inside\"\n\
             [[supports]]\nat = \"start\"\nposition = true\nrotation = true\n\
             [[supports]]\nat = \"end\"\nposition = true\nrotation = true\n\
             [[stages]]\nramp = {{ rotation = {{ at = \"end\", axis = [0, 0, 1], turns = {turns:?} }} }}\nsteps = 2\n\
             [[stages]]\nramp = {{ displacement = {{ at = \"end\", to = [0, 0, -0.5] }} }}\nsteps = 4\n"
        );
        let (solution, last) = last(&text);
        let engine = solution.solver.engine();
        let points = engine.state().positions();
        let [.., end] = &last.reactions[..] else { panic!("{:?}", last.reactions) };
        let (tension, moment) = (end.force[2], end.moment[2]);
        // the middle third: boundary layers decay by e^(−4π) a pitch
        let (from, to) = (points.len() * 2 / 5, points.len() * 3 / 5);
        let angle = |k: usize| points[k].y.atan2(points[k].x);
        let step = |k: usize| (angle(k + 1) - angle(k) + 1.5 * TAU).rem_euclid(TAU) - 0.5 * TAU;
        let turned: f64 = (from..to).map(step).sum();
        let pitch = TAU * (points[to].z - points[from].z) / turned;
        let slope = |b: f64| {
            let (sin, cos) = b.sin_cos();
            2.0 * sin.powi(3) * cos / (RADIUS * RADIUS) + tension * sin - moment / RADIUS * (cos - (2.0 * b).cos())
        };
        let measured = (TAU * RADIUS / pitch).atan();
        let angle = root(0.8 * measured, 1.2 * measured, slope);
        let reference = TAU * RADIUS / angle.tan();
        verify("rod in a tube", &format!("pitch, {turns} turns"), pitch, reference, 1e-4 * reference.abs());
        let sin = angle.sin();
        let wall = sin.powi(4) / RADIUS.powi(3) - moment * sin * (1.0 - angle.cos()) / (RADIUS * RADIUS);
        let forces = engine.nodal_fields(0).contact_force;
        let inwards = |k: usize| -forces[k].dot(&points[k]) / points[k].xy().norm();
        let mean = (from..to).map(inwards).sum::<f64>() / (to - from) as f64;
        let between = turned / (to - from) as f64;
        let pressure = mean / (1.0 - between * between / 15.0);
        verify("rod in a tube", &format!("force of the wall, {turns} turns"), pressure, wall, 1e-4 * wall);
    }
}
