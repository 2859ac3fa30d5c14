//! Where the contact of the closed twisted ring changes: first contact, one point → two, two → three, three → a line.
//!
//! ```text
//!      ΔLk      1.04        1.91          2.32           2.38        (D/L = .03)
//!    ___         _  _        _  _          _   _          _   _
//!   /   \       / \/ \      / \/ \        / \_/ \        / \_/ \
//!   \___/       \_/\_/      \_/\_/        \_/ \_/        \_/ \_/
//!   circle      1 point     2 points      3 points       line + 2 points
//! ```
//!
//! A naturally straight isotropic rod, L = 1, B = 1, C = 1.5, diameters D/L = .03 and .01, is closed into a flat circle and
//! turned by the excess link ΔLk. It is followed through whatever states the engine finds, without any symmetry imposed:
//! cubic elements, EA = GA = 1e8 B/L² (their effect on writhe and torque is about 1e-6), penalty raised to κ = 1e13 B/L⁴ (penetration
//! below 1e-5 D, the force of a point spread over about 1e-4 L).
//!
//! Reference: writhe and torque M₃L/(2πB) of the Kirchhoff rod (inextensible, unshearable, hard contact) at the four events,
//! recomputed by shooting, five decimals; ΔLk = Wr + (M₃L/2πB)(B/C).
//!
//! What is bisected are not events of the regularised law, which happen a layer width late, but quantities that are smooth up to
//! the event, and whose hard limit is known, interpolated to zero from states on one side:
//! * first contact, two → three: the contact force, from the side with contact; it starts linearly;
//! * one → two, three → line: the smaller eigenvalue of the Hessian of the distance |r(s) − r(t)| at the contact point in
//!   question. With positive curvature of the gap one point carries the force; at zero it opens to two points or a line. The
//!   curvature of the rods there is extrapolated from the elements left and right, so that what the spread force does to it between
//!   them (∝ κ^(−1/3)) does not enter.

//!
//! What limits the later events is the mesh at the two outer points, whose forces lie inside elements: the gap in the middle is so
//! small that their local compliance (∝ h³, whatever their place in the element makes of it) moves ΔLk by 1e-4 to 4e-4 when the force is
//! concentrated on much less than an element. Writhe at two → three and three → line with D/L = .03, κ = 1e14: 1.66830, 1.71202 (192
//! elements), 1.66811, 1.71163 (256), 1.66818, 1.71182 (320); reference 1.66818, 1.71196. A law under which a point is as long as the distance
//! of nodes does not see the mesh, but shifts the events by its penetration, ∝ κ^(−2/3); that can be extrapolated. From κ = 1e11 and
//! 1e12: 1.66831, 1.71201 (192), 1.66812, 1.71190 (256).

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

mod common;

use std::f64::consts::TAU;

use common::curvature::{PointForce, interpolate_to_zero, tangent_and_curvature};
use common::verify;
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::{Observation, SiteReport};
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, Ramp};
use supercoil::solve::{Drive, Options, Progress, Solver, Status};

const ORDER: usize = 3;

fn penalty(kappa: f64, diameter: f64) -> ContactLaw {
    ContactLaw::Penalty { stiffness: kappa * (0.5 * diameter).powi(4) }
}

struct Ring {
    solver: Solver,
    elements: usize,
    diameter: f64,
    iterations: usize,
}

/// Excess link, writhe, torque M₃L/(2πB) and bending energy over that of the ring of a state.
#[derive(Clone, Copy)]
struct Numbers([f64; 4]);

impl Ring {
    fn new(elements: usize, diameter: f64) -> Self {
        let section = Section::isotropic(1.0, 1.5, 1e8, 1e8, 0.5 * diameter);
        let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
        let rod = Rod::new("ring", &shape, true, section, elements, ORDER, Natural::Straight).unwrap();
        let contact = Contact { law: penalty(1e7, diameter) };
        let solver = Solver::new(Model { rods: vec![rod], contact, ..Model::default() }, Options::default()).unwrap();
        Self { solver, elements, diameter, iterations: 0 }
    }

    /// The rest state at an excess link: one load step under a soft law, which is then raised to 10^`top` B/L⁴.
    fn at(&mut self, excess_link: f64, soft: i32, top: i32) -> (Numbers, Observation) {
        let law = |decade: i32| penalty(10f64.powi(decade), self.diameter);
        self.solver.engine_mut().set_contact_law(law(soft)).unwrap();
        let mut report = self.solver.step_to(&[Ramp::ExcessLink { rod: 0, to: excess_link }]).unwrap();
        assert_eq!(report.status, Status::Converged, "ΔLk = {excess_link}");
        let mut counts = vec![report.iterations];
        for decade in soft + 1..=top {
            self.solver.engine_mut().set_contact_law(law(decade)).unwrap();
            report = self.solver.settle(&Drive::default());
            assert_eq!(report.status, Status::Converged, "ΔLk = {excess_link}, κ = 1e{decade}");
            counts.push(report.iterations);
        }
        self.iterations += counts.iter().sum::<usize>();
        assert_eq!(report.num_unstable, 0, "ΔLk = {excess_link}");
        let engine = self.solver.engine();
        let seen = observe(&Progress { engine, stage: 0, step: 0, fraction: 1.0, report: &report, seconds: 0.0 });
        let link = seen.links[0];
        assert!((link.link - excess_link).abs() < 1e-9, "link {} at {excess_link}", link.link);
        let bending = seen.energies.bend / (0.5 * TAU * TAU);
        let numbers = Numbers([excess_link, link.writhe, link.seam_moment / TAU, bending]);
        println!(
            "ΔLk {excess_link}: writhe {:.7}, torque {:.7}, {} site(s), force {:.4}, iterations {counts:?}",
            numbers.0[1],
            numbers.0[2],
            seen.sites.len(),
            seen.total_contact_force
        );
        (numbers, seen)
    }

    fn point(&self, arc: f64) -> Vec3 {
        let count = self.elements * ORDER;
        let place = (arc * count as f64).rem_euclid(count as f64);
        let (points, _) = self.solver.engine().centerline(0, 16);
        points[(place * 16.0).round() as usize % points.len()]
    }

    /// Smaller eigenvalue of the Hessian of |r(s) − r(t)| at a contact point \[1/L\].
    fn gap_curvature(&self, site: &SiteReport) -> f64 {
        let at = |side: usize, force: Vec3| {
            let point = PointForce { force, spread: site.spread[side] };
            tangent_and_curvature(&self.solver, 0, site.center[side], point)
        };
        let [ta, tb] = [0, 1].map(|side| at(side, Vec3::zeros()).0);
        let chord = self.point(site.center[0]) - self.point(site.center[1]);
        // the nearest of the sampled points are off along the tangents only
        let normal = ta.cross(&tb).normalize();
        let normal = normal * normal.dot(&chord).signum();
        let (ka, kb) = (at(0, normal * site.force).1, at(1, -normal * site.force).1);
        let (ss, tt) = (1.0 / self.diameter + normal.dot(&ka), 1.0 / self.diameter - normal.dot(&kb));
        let st = -ta.dot(&tb) / self.diameter;
        0.5 * (ss + tt) - (0.25 * (ss - tt) * (ss - tt) + st * st).sqrt()
    }
}

/// States with an indicator, interpolated to where it vanishes.
fn event(states: &[(f64, Numbers)]) -> Numbers {
    let x: Vec<f64> = states.iter().map(|s| s.0).collect();
    println!("    indicator {x:.6?}");
    let with = |list: &[(f64, Numbers)]| -> [f64; 4] {
        let x: Vec<f64> = list.iter().map(|s| s.0).collect();
        std::array::from_fn(|k| interpolate_to_zero(&x, &list.iter().map(|s| s.1.0[k]).collect::<Vec<_>>()))
    };
    let (all, fewer) = (with(states), with(&states[1..]));
    println!("    → {all:.7?}, one degree lower {fewer:.7?}");
    Numbers(all)
}

/// The site at the middle of the contact region: arcs nearest to `arc` on strand a.
fn middle(seen: &Observation, arc: f64) -> &SiteReport {
    let off = |s: &SiteReport| {
        let d = s.center[0] - arc;
        (d - d.round()).abs().min((d - 0.5 - (d - 0.5).round()).abs())
    };
    seen.sites.iter().min_by(|x, y| off(x).total_cmp(&off(y))).unwrap()
}

struct Case {
    diameter: f64,
    elements: usize,
    /// Decade of the penalty for the later events.
    late_top: i32,
    /// Excess links of the states: on the way; with small force; before one → two; beyond two → three; before three → line.
    touch: Vec<f64>,
    split: Vec<f64>,
    third: Vec<f64>,
    line: Vec<f64>,
    /// Writhe, torque, bending energy at the events.
    reference: [[f64; 3]; 4],
}

/// Follows the ring and locates the events in `wanted` (0..2 or 2..4 or both).
fn run(case: &Case, wanted: std::ops::Range<usize>) -> Vec<Numbers> {
    let mut ring = Ring::new(case.elements, case.diameter);
    ring.at(1.1, 7, 7);
    ring.at(1.2, 7, 9);
    let mut found = Vec::new();
    let mut collect =
        |ring: &mut Ring, list: &[f64], halvings: usize, top: i32, what: &dyn Fn(&Ring, &Observation) -> f64| {
            let mut states: Vec<(f64, Numbers)> = Vec::new();
            for step in 0..list.len() + halvings {
                let excess_link = list.get(step).copied().unwrap_or_else(|| {
                    // where the polynomial through the states so far puts half the last indicator
                    let half = 0.5 * states[step - 1].0;
                    let x: Vec<f64> = states.iter().map(|s| s.0 - half).collect();
                    interpolate_to_zero(&x, &states.iter().map(|s| s.1.0[0]).collect::<Vec<_>>())
                });
                let (numbers, seen) = ring.at(excess_link, 9, top);
                states.push((what(ring, &seen), numbers));
            }
            found.push(event(&states[states.len() - 4..]));
            states[states.len() - 1].1.0[0]
        };
    if wanted.contains(&0) {
        collect(&mut ring, &case.touch, 2, 14, &|_, seen| seen.total_contact_force);
    }
    for excess_link in [1.3, 1.5, 1.7, 1.8] {
        ring.at(excess_link, 8, 9);
    }
    let mut from = case.split[case.split.len() - 1];
    if wanted.contains(&1) {
        from = collect(&mut ring, &case.split, 3, 14, &|ring, seen| {
            assert_eq!(seen.sites.len(), 1);
            ring.gap_curvature(&seen.sites[0])
        });
    }
    if wanted.contains(&2) {
        let until = case.third[0];
        let center = ring.at(from, 9, 10).1.sites[0].center[0];
        for k in 1..=5 {
            let (_, seen) = ring.at(from + (until - from) * f64::from(k) / 6.0, 8, 10);
            // the first of these may be too near the event for a soft law
            assert!(k == 1 || seen.sites.len() == 2, "{:?}", seen.sites);
        }
        collect(&mut ring, &case.third, 2, case.late_top, &|_, seen| {
            assert_eq!(seen.sites.len(), 3);
            middle(seen, center).force
        });
        collect(&mut ring, &case.line, 2, case.late_top, &|ring, seen| {
            assert_eq!(seen.sites.len(), 3);
            ring.gap_curvature(middle(seen, center))
        });
    }
    println!("{} iterations in all", ring.iterations);
    found
}

fn compare(case: &Case, wanted: std::ops::Range<usize>, found: &[Numbers]) {
    let name = format!("twisted ring, D/L = {}", case.diameter);
    let events = ["first contact", "one point → two", "two points → three", "three points → line"];
    let wanted = events[wanted.clone()].iter().zip(&case.reference[wanted]);
    for ((event, reference), found) in wanted.zip(found) {
        verify(&name, &format!("writhe at {event}"), found.0[1], reference[0], 1e-4);
        verify(&name, &format!("torque M₃L/2πB at {event}"), found.0[2], reference[1], 1e-4);
        // which along the path changes by twice as much as writhe
        verify(&name, &format!("bending energy at {event}, over that of the ring"), found.0[3], reference[2], 2e-4);
    }
}

fn thick(elements: usize, late_top: i32) -> Case {
    Case {
        diameter: 0.03,
        elements,
        late_top,
        touch: vec![1.1, 1.07],
        split: vec![1.83, 1.87, 1.89],
        third: vec![2.34, 2.33],
        line: vec![2.345, 2.355, 2.36],
        reference: [
            [0.86476, 0.26950, 2.81161],
            [1.32404, 0.88280, 3.58558],
            [1.66818, 0.97846, 4.20916],
            [1.71196, 1.00273, 4.29589],
        ],
    }
}

#[test]
fn first_contact_and_split_of_the_thick_ring() {
    let case = thick(96, 14);
    compare(&case, 0..2, &run(&case, 0..2));
}

/// Two laws a decade apart, extrapolated: penetration, which shifts these events, goes as κ^(−2/3) at points.
#[test]
#[ignore = "slow: a minute, 256 elements"]
fn late_events_of_the_thick_ring() {
    let [softer, stiffer] = [11, 12].map(|decade| run(&thick(256, decade), 2..4));
    let ratio = 10f64.powf(2.0 / 3.0);
    let hard =
        |(a, b): (&Numbers, &Numbers)| Numbers(std::array::from_fn(|k| b.0[k] + (b.0[k] - a.0[k]) / (ratio - 1.0)));
    let found: Vec<Numbers> = softer.iter().zip(&stiffer).map(hard).collect();
    compare(&thick(256, 12), 2..4, &found);
}

#[test]
#[ignore = "slow: minutes, 256 elements and small steps"]
fn all_events_of_the_thin_ring() {
    let case = Case {
        diameter: 0.01,
        elements: 256,
        late_top: 14,
        touch: vec![1.1, 1.05],
        split: vec![1.86, 1.9, 1.92],
        third: vec![2.48, 2.47],
        line: vec![2.52, 2.54, 2.55],
        reference: [
            [0.95477, 0.09042, 2.84404],
            [1.62094, 0.48818, 3.68952],
            [2.12632, 0.49945, 4.17004],
            [2.23817, 0.51478, 4.28347],
        ],
    };
    compare(&case, 0..4, &run(&case, 0..4));
}
