//! Rods on planes: closed forms of beams on a rigid table and of a ring between plates, without friction.
//!
//! * A heavy beam laid down on a table: the pressure is its weight per length.
//! * A heavy beam on a table, lifted at one end by h: EI y⁗ = −w over the length L that is lifted, y = y′ = y″ = 0
//!   where it touches down (it is flat beyond), so y = −w s⁴/(24 EI) + a s³. An end that may turn has y″(L) = 0: a =
//!   wL/(12 EI), h = wL⁴/(24 EI), and the end carries wL/2. One that is clamped has y′(L) = 0: a = wL/(18 EI), h =
//!   wL⁴/(72 EI), and the end carries 2wL/3. The table carries the rest, of which 6 EI a = EI y‴(0) right where the
//!   beam touches down.
//! * A ring of radius R pressed between two plates by F, each quarter an elastica: B θ″ = ½F cos θ, θ from 0 at the
//!   plate to ½π, so θ′² = κ₀² + (F/B) sin θ, κ₀ the curvature at the plate. It flattens where κ₀ = 0: there ½πR =
//!   √(B/F) C, F = 2.786 B/R². Further on a length 2a lies flat on the plate and bears no load; half the height of the
//!   centreline is Y = √(B/F) D and a = ½πR − YC/D, with C = ∫dθ/√sin θ = 2.6220576 and D = ∫√sin θ dθ = 1.1981402 over
//!   0 … ½π.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use crate::common::{self, root, verify};

use supercoil::observe::report::{Observation, ObstacleSite, SiteKind};
use supercoil::solve::Options;

/// All steps of a scene, each with its certificate; none penetrates by more than is tolerated.
pub(crate) fn steps(text: &str) -> Vec<Observation> {
    let seen = common::run(text, Path::new(""), |_| Options::default()).1;
    for step in &seen {
        let deepest = step.obstacle_sites.iter().map(|site| -site.gap).fold(0.0, f64::max);
        assert!(deepest <= 1e-8 * step.sizes[0].contact_radius * (1.0 + 1e-6), "{deepest}");
    }
    seen
}

/// A beam of length 1 above a table, EI = 1.
fn beam(height: f64, elements: usize, weight: f64) -> String {
    format!(
        "planar = true\n[[rods]]\nname = \"beam\"\n\
         shape = {{ kind = \"line\", start = [0.0, {height:?}, 0.0], length = 1.0 }}\n\
         section = {{ bending = 1.0, twisting = 1.0, stretching = 1e5, shearing = 1e5, contact_radius = 0.01 }}\n\
         elements = {elements}\n[[planes]]\nname = \"table\"\nnormal = [0.0, 1.0, 0.0]\n\
         [[line_loads]]\nforce = [0.0, {:?}, 0.0]\n",
        -weight
    )
}

fn clamp(at: &str, axes: &str) -> String {
    format!("[[supports]]\nat = \"{at}\"\nposition = {axes}\nrotation = true\n")
}

#[test]
fn a_heavy_beam_lies_on_a_table_with_its_weight() {
    let (height, weight) = (0.012, 40.0);
    let down = "[[stages]]\nramp = { displacement = [{ at = \"start\", to = [0.0, -0.002, 0.0] }, \
                { at = \"end\", to = [0.0, -0.002, 0.0] }] }\nsteps = 4\n";
    let supports = clamp("start", "true") + &clamp("end", "[\"y\"]");
    let text = format!("{}{supports}[[stages]]\nramp = {{ load = 1.0 }}\nsteps = 2\n{down}", beam(height, 24, weight));
    let seen = steps(&text);
    for step in &seen {
        let held: f64 = step.reactions.iter().map(|reaction| reaction.force[1]).sum();
        let load = weight * if step.stage == 0 { step.fraction } else { 1.0 };
        verify(
            "beam on a table",
            "supports and table carry",
            held + step.obstacle_reactions[0].force,
            load,
            1e-7 * weight,
        );
        let sites: f64 = step.obstacle_sites.iter().map(|site| site.force).sum();
        verify("beam on a table", "sites and reaction", sites, step.obstacle_reactions[0].force, 1e-12 * weight);
    }
    let last = &seen[seen.len() - 1];
    let [site] = &last.obstacle_sites[..] else { panic!("{:?}", last.obstacle_sites) };
    assert_eq!(site.kind, SiteKind::Line);
    verify("beam on a table", "length of the line", site.arc[1] - site.arc[0], 1.0, 1e-12);
    // at the ends the loads of elements and the pressure are shared out to nodes in different ways, O(element), which
    // the supports make up for
    verify("beam on a table", "pressure over weight", site.force / weight, 1.0, 1e-2);
    verify("beam on a table", "centre of pressure", site.center, 0.5, 1e-6);
}

/// The end that is lifted, the start clamped on the table: 24 EI h/w for an end that may turn, 72 EI h/w for a clamped
/// one.
#[test]
fn a_heavy_beam_lifted_at_its_end_touches_down_where_theory_says() {
    let lifted: f64 = 0.6;
    for (factor, share, end) in [
        (24.0, 0.5, "[[supports]]\nat = \"end\"\nposition = [\"y\"]\n".to_owned()),
        (72.0, 2.0 / 3.0, clamp("end", "[\"y\"]")),
    ] {
        let height = 1e-3;
        let weight = factor * height / lifted.powi(4);
        let supports = clamp("start", "true") + &end;
        let stages = format!(
            "[[stages]]\nramp = {{ load = 1.0, displacement = {{ at = \"end\", to = [0.0, {height:?}, 0.0] }} }}\n\
             steps = 4\n"
        );
        let text = beam(0.01, 40, weight) + &supports + &stages;
        let seen = steps(&text);
        let last = &seen[seen.len() - 1];
        let [clamped, end] = &last.reactions[..] else { panic!() };
        let case = format!("heavy beam lifted at its end, {factor} EI h/w");
        // what the end carries tells the length better than where the mesh lets go
        let length = end.force[1] / (share * weight);
        verify(&case, "lifted length, by force", length, lifted, 1e-3 * lifted);
        let touches = last.obstacle_sites.iter().map(|site| site.arc[1]).fold(0.0, f64::max);
        // nodes are 1/120 apart
        verify(&case, "lifted length, by contact", 1.0 - touches, lifted, 0.01);
        let carried = weight - end.force[1] - clamped.force[1];
        verify(&case, "table carries the rest", last.obstacle_reactions[0].force, carried, 1e-7 * weight);
    }
}

/// ∫ f(θ) dθ from 0 to ½π of what is as sin^(−½) at 0 at worst: θ = t⁴ takes that away.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    let end = FRAC_PI_2.powf(0.25);
    let count = 4000;
    let at = |k: usize| (k as f64 + 0.5) / count as f64 * end;
    (0..count).map(|k| f(at(k).powi(4)) * 4.0 * at(k).powi(3) * end / count as f64).sum()
}

/// Force on a plate and half of what lies flat, for a ring with R = B = 1 whose centreline is 2Y high.
fn ring_between_plates(half_height: f64) -> (f64, f64) {
    let c = integral(|t| 1.0 / t.sin().sqrt());
    let d = integral(|t| t.sin().sqrt());
    let flat = FRAC_PI_2 - half_height * c / d;
    if flat >= 0.0 {
        return ((d / half_height).powi(2), flat);
    }
    // F by κ₀² = x F, x ≥ 0: the quarter's length gives F, its height Y
    let parts = |x: f64| {
        let length = integral(|t| 1.0 / (x + t.sin()).sqrt());
        let force = (length / FRAC_PI_2).powi(2);
        (force, integral(|t| t.sin() / (x + t.sin()).sqrt()) / force.sqrt())
    };
    let x = root(0.0, 1e4, |x| parts(x).1 - half_height);
    (parts(x).0, 0.0)
}

#[test]
fn the_reference_of_the_ring_is_what_it_should_be() {
    let c = integral(|t| 1.0 / t.sin().sqrt());
    verify("ring between plates", "C", c, 2.622_057_554_3, 1e-7);
    verify("ring between plates", "D", integral(|t| t.sin().sqrt()), 1.198_140_234_7, 1e-7);
    // a ring hardly pressed: 2Y = 2R − 2(π/8 − 1/π) F R³/B
    let (force, _) = ring_between_plates(0.999);
    let softness = std::f64::consts::PI / 8.0 - 1.0 / std::f64::consts::PI;
    verify("ring between plates", "small force", force, 0.001 / softness, 2e-3 * force);
}

/// The ring presses with the elastica's force all the way; each plate is touched at a point until it flattens, then at
/// both ends of what lies flat. The force at which it flattens is 2.786 B/R².
#[test]
fn a_ring_between_plates_presses_as_the_elastica_does() {
    let radius = 0.01;
    // the upper plate comes down; half heights of the centreline on the way
    let heights = [0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.55, 0.5];
    let text = format!(
        "planar = true\n[[rods]]\nname = \"ring\"\nclosed = true\nshape = {{ kind = \"circle\", radius = 1.0 }}\n\
         section = {{ bending = 1.0, twisting = 1.0, stretching = 1e6, shearing = 1e6, contact_radius = {radius} }}\n\
         elements = 60\n\
         [[planes]]\nname = \"lower\"\npoint = [0.0, {low:?}, 0.0]\nnormal = [0.0, 1.0, 0.0]\n\
         [[planes]]\nname = \"upper\"\npoint = [0.0, {high:?}, 0.0]\nnormal = [0.0, -1.0, 0.0]\n\
         [[stages]]\nramp = {{ plane = {{ name = \"upper\", to = 1.0 }} }}\nsteps = 10\n",
        low = -1.0 - radius,
        high = 1.0 + radius
    );
    let seen = steps(&text);
    assert_eq!(seen.len(), 1 + heights.len());
    for (step, half_height) in seen[1..].iter().zip(heights) {
        let (force, flat) = ring_between_plates(half_height);
        let case = format!("ring between plates, Y/R = {half_height}");
        for plane in &step.obstacle_reactions {
            verify(&case, "force R²/B", plane.force, force, 3e-5 * force);
        }
        let [lower, upper] = [0, 1]
            .map(|k| -> Vec<&ObstacleSite> { step.obstacle_sites.iter().filter(|site| site.obstacle == k).collect() });
        verify(
            &case,
            "the plates press alike",
            step.obstacle_reactions[0].force,
            step.obstacle_reactions[1].force,
            1e-6 * force,
        );
        if force < 0.95 * 2.786 {
            assert_eq!((lower.len(), upper.len()), (1, 1), "{case}");
            assert!(lower.iter().chain(&upper).all(|site| site.kind == SiteKind::Point), "{case}");
        }
        if flat > 0.15 {
            for sites in [lower, upper] {
                let centers: Vec<f64> = sites.iter().map(|site| site.center).collect();
                assert_eq!(centers.len(), 2, "{case}: {sites:?}");
                verify(&case, "half of what lies flat", 0.5 * (centers[1] - centers[0]), flat, 3e-5);
            }
        }
    }
}
