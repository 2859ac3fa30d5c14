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
//! A naturally straight isotropic rod, L = 1, B = 1, C = 1.5, diameters D/L = .03 and .01, is closed into a flat circle
//! and turned by the excess link ΔLk. It is followed under a soft penalty on 96 cubic elements through whatever states
//! the engine finds, without any symmetry imposed. Near an event each state is interpolated to meshes of twice the
//! elements, once, four or five times, and brought to rest there under penalties raised to κ = 1e14 B/L⁴ (penetration
//! below 1e-6 D). EA = GA = 1e9 B/L²: their effect is about 1e-6, but for the later events, which have 1e10.
//!
//! Reference: writhe, torque M₃L/(2πB) and bending energy of the Kirchhoff rod (inextensible, unshearable, hard
//! contact) at the four events, by shooting (`common/kirchhoff_ring.rs`), which a test here compares with an earlier
//! computation, five decimals. ΔLk = Wr + (M₃L/2πB)(B/C).
//!
//! What vanishes at an event is extrapolated to it from states on one side (polynomial through six, each half as far
//! from the event as the one before):
//! * first contact, two → three: the force of the contact in the middle, from the side where it is; it starts linearly;
//! * one → two, three → line: the smaller eigenvalue of the Hessian of the distance |r(s) − r(t)| at the contact point
//!   in the middle. With positive curvature of the gap one point carries the force; at zero it opens to two points or a
//!   line. The curvature of the rods there is extrapolated from the elements left and right, so that what the spread
//!   force does to it between them (∝ κ^(−1/3)) does not enter.
//!
//! What the states themselves are off by is the penetration, ∝ κ^(−2/3) at a point, which two laws a decade apart tell
//! and Richardson's rule takes away; and the elements' compliance to forces that lie inside them, ∝ h³ and dependent on
//! where they lie. Of writhe and torque this leaves 1e-6, and one → two, where the contact lies on a node, is found as
//! well on 192 elements as on 1536. But the gap in the middle is so small between two and three points that a hundredth
//! of that moves the later events: by 1e-4 on 192 elements; on 768 two → three by 1e-5, three → line by 6e-5 at most;
//! on 1536 by 3e-6 and 1e-6 … 8e-6, by where the contacts come to lie; on 3072 by 1e-7 and 1e-6 … 2e-6 (with
//! [`ELEMENTS`] of 97 and 98, where they lie otherwise, the thin ring's by 5e-6). What the latter is made of was found
//! by comparing the eigenvalue in states with three points with shooting, state by state (thick ring, ΔLk 2.345 …
//! 2.3793, divided by its slope, 1.8 per turn). All but the figures on 3072 were found with curvatures from cells of
//! single elements. Stretch and shear: 9e-6 of ΔLk at EA = GA = 1e9, ten times as much at 1e8 (a strain N/EA changes
//! D/L by 1e-8, and the gap in the middle with it). The mesh: a wave in the place of the outer contacts within their
//! elements, of mean zero, ± 3e-5 on 768 elements, ± 5e-6 on 1536. The law: less than 1e-6 after Richardson's rule. So
//! EA = 1e10 alone does not reach 1e-6 (on 1536 elements two → three was then 2e-6 off); with 3072 elements it brings
//! three → line from 8e-6 to 2.7e-6 in writhe, 5e-6 to 1.6e-6 in torque. The curvature is taken from elements outside
//! the layer (B/κ)^¼ of the law (with those beside the contact one → two got worse with refinement: 3e-8, 6e-7, 3e-6 on
//! 192, 384, 768 elements). A polynomial through the last four states left 7e-6 of one → two of the thin ring, whose
//! writhe turns steeply there; through all six it leaves 2e-6.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::f64::consts::TAU;

use common::curvature::{PointForce, interpolate_to_zero, tangent_and_curvature};
use common::kirchhoff_ring::{Event, event_of};
use common::{history, observed, verify};
use supercoil::math::Vec3;
use supercoil::observe::report::{Observation, SiteReport};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, Ramp};
use supercoil::solve::{Options, Solver, Status, StepReport};

const ORDER: usize = 3;
const ELEMENTS: usize = 96;
/// Decade of the harder of the two penalties whose states are used. With 15 rounding moves the thin ring's three → line
/// by 5e-6.
const HARD: i32 = 14;

/// How finely states are resolved.
#[derive(Debug, Clone, Copy)]
struct Fineness {
    /// How often the elements are doubled; each refinement comes with a decade of the penalty.
    refinements: i32,
    /// Decade of the penalty on the way.
    soft: i32,
    /// EA = GA, B/L².
    stretch: f64,
}

const COARSE: Fineness = Fineness { refinements: 1, soft: 9, stretch: 1e9 };
const FINE: Fineness = Fineness { refinements: 4, soft: 9, stretch: 1e9 };
const FINEST: Fineness = Fineness { refinements: 5, soft: 8, stretch: 1e10 };

fn penalty(decade: i32, diameter: f64) -> ContactLaw {
    ContactLaw::Penalty { stiffness: 10f64.powi(decade) * (0.5 * diameter).powi(4) }
}

/// Share of the way to where an event seems to be that the next state goes.
const APPROACH: f64 = 0.5;
/// States per event, all of them extrapolated.
const STATES: usize = 6;

/// Excess link, writhe, torque M₃L/(2πB), bending energy over that of the ring, what vanishes at the event.
type Numbers = [f64; 5];

/// What vanishes at an event, of a state at rest.
type Indicator<'a> = &'a dyn Fn(&Solver, &Observation) -> f64;

fn seen(solver: &Solver, report: &StepReport) -> Observation {
    assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", history(report));
    let seen = observed(solver, report);
    let link = seen.links[0];
    assert!((link.link - link.excess_link).abs() < 1e-9, "link {} at {}", link.link, link.excess_link);
    seen
}

struct Ring {
    /// Under the soft law on the coarse mesh.
    solver: Solver,
    diameter: f64,
    fineness: Fineness,
}

impl Ring {
    fn new(diameter: f64, fineness: Fineness) -> Self {
        let section = Section::isotropic(1.0, 1.5, fineness.stretch, fineness.stretch, 0.5 * diameter);
        let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
        let rod = Rod::new("ring", &shape, RodMesh::closed(ELEMENTS, ORDER), section, Natural::Straight).unwrap();
        let contact = Contact { law: penalty(fineness.soft, diameter) };
        let solver = Solver::new(Model { rods: vec![rod], contact, ..Model::default() }, Options::default()).unwrap();
        Self { solver, diameter, fineness }
    }

    fn go_to(&mut self, excess_link: f64) -> Observation {
        let report = self.solver.step_to(&[Ramp::ExcessLink { rod: 0, to: excess_link }]).unwrap();
        seen(&self.solver, &report)
    }

    /// The state at an excess link on the finest mesh, as hard contact has it: Richardson's rule on the last two laws.
    fn hard(&mut self, excess_link: f64, indicator: Indicator) -> Numbers {
        self.go_to(excess_link);
        let mut fine = self.solver.refined(2).unwrap();
        let Fineness { refinements, soft, .. } = self.fineness;
        for level in 1..refinements {
            fine.set_contact_law(penalty(soft + level, self.diameter)).unwrap();
            assert_eq!(fine.resettle().status, Status::Converged);
            fine = fine.refined(2).unwrap();
        }
        let mut last = [[0.0; 5]; 2];
        for decade in soft + refinements..=HARD {
            fine.set_contact_law(penalty(decade, self.diameter)).unwrap();
            let report = fine.resettle();
            let seen = seen(&fine, &report);
            let (link, bending) = (seen.links[0], seen.energies.bending / (0.5 * TAU * TAU));
            let of_event = indicator(&fine, &seen);
            last = [last[1], [excess_link, link.writhe, link.seam_moment / TAU, bending, of_event]];
            println!("    κ 1e{decade}: {:.8?}, {} sites, {} iterations", last[1], seen.sites.len(), report.iterations);
        }
        let ratio = 10f64.powf(2.0 / 3.0);
        let hard = std::array::from_fn(|k| last[1][k] + (last[1][k] - last[0][k]) / (ratio - 1.0));
        println!("  {hard:.8?}");
        hard
    }

    /// Where the indicator vanishes: from states at two excess links, then half the way towards where it seems to, four
    /// times.
    fn locate(&mut self, from: [f64; 2], indicator: Indicator) -> Numbers {
        let mut states: Vec<Numbers> = from.iter().map(|&link| self.hard(link, indicator)).collect();
        let at_zero = |states: &[Numbers], value: usize| {
            let of = |k: usize| states.iter().map(|s| s[k]).collect::<Vec<_>>();
            interpolate_to_zero(&of(4), &of(value))
        };
        while states.len() < STATES {
            let (last, seems) = (states[states.len() - 1][0], at_zero(&states, 0));
            let link = last + APPROACH * (seems - last);
            states.push(self.hard(link, indicator));
        }
        let found: Numbers = std::array::from_fn(|k| at_zero(&states, k));
        let fewer: Numbers = std::array::from_fn(|k| at_zero(&states[1..], k));
        println!("  → {found:.8?}, one degree lower {fewer:.8?}");
        found
    }
}

/// Smaller eigenvalue of the Hessian of |r(s) − r(t)| at a contact point \[1/L\].
fn gap_curvature(solver: &Solver, diameter: f64, site: &SiteReport) -> f64 {
    let at = |side: usize, force: Vec3| {
        let point = PointForce { force, spread: site.spread[side] };
        tangent_and_curvature(solver, 0, site.center[side], point)
    };
    let [ta, tb] = [0, 1].map(|side| at(side, Vec3::zeros()).0);
    let (points, _) = solver.engine().centerline(0, 16);
    let count = points.len() as f64;
    let [ra, rb] = site.center.map(|arc| points[(arc * count).round().rem_euclid(count) as usize]);
    // the nearest of the sampled points are off along the tangents only
    let normal = ta.cross(&tb).normalize();
    let normal = normal * normal.dot(&(ra - rb)).signum();
    let (ka, kb) = (at(0, normal * site.force).1, at(1, -normal * site.force).1);
    let (ss, tt) = (1.0 / diameter + normal.dot(&ka), 1.0 / diameter - normal.dot(&kb));
    let st = -ta.dot(&tb) / diameter;
    0.5 * (ss + tt) - (0.25 * (ss - tt) * (ss - tt) + st * st).sqrt()
}

/// Of three sites the one in the middle: without partners of its own kind.
fn middle(seen: &Observation) -> Option<&SiteReport> {
    let sites = (seen.sites.len() == 3).then_some(&seen.sites)?;
    sites.iter().min_by(|a, b| a.force.total_cmp(&b.force))
}

struct Case {
    diameter: f64,
    /// Excess links on the way to each event, and the two states that its location begins with.
    ways: [(&'static [f64], [f64; 2]); 4],
}

const THICK: Case = Case {
    diameter: 0.03,
    ways: [
        (&[1.1, 1.2], [1.1, 1.08]),
        (&[1.3, 1.5, 1.7], [1.8, 1.85]),
        (&[1.95, 2.0, 2.1, 2.2, 2.3], [2.345, 2.335]),
        (&[], [2.35, 2.36]),
    ],
};
const THIN: Case = Case {
    diameter: 0.01,
    ways: [
        (&[1.1, 1.2], [1.1, 1.06]),
        (&[1.3, 1.5, 1.7, 1.8], [1.86, 1.9]),
        (&[1.98, 2.1, 2.2, 2.3, 2.4, 2.44], [2.49, 2.475]),
        (&[], [2.51, 2.53]),
    ],
};
const EVENTS: [(Event, &str); 4] = [
    (Event::FirstContact, "first contact"),
    (Event::OneToTwo, "one point → two"),
    (Event::TwoToThree, "two points → three"),
    (Event::ThreeToLine, "three points → line"),
];

/// Follows the ring, locates the events that tolerances are given for, and compares writhe and torque; energy, which
/// changes by twice as much along the path, to twice the tolerance.
fn compare(case: &Case, fineness: Fineness, tolerances: &[Option<f64>]) {
    let diameter = case.diameter;
    let mut ring = Ring::new(diameter, fineness);
    for (k, ((event, name), tolerance)) in EVENTS.into_iter().zip(tolerances).enumerate() {
        let (way, from) = case.ways[k];
        for &excess_link in way {
            ring.go_to(excess_link);
        }
        let Some(tolerance) = *tolerance else { continue };
        println!("{name}");
        let indicator: Indicator = match event {
            Event::FirstContact => &|_, seen| seen.total_contact_force,
            Event::OneToTwo => &|solver, seen| {
                if seen.sites.len() == 1 { gap_curvature(solver, diameter, &seen.sites[0]) } else { f64::NAN }
            },
            Event::TwoToThree => &|_, seen| middle(seen).map_or(f64::NAN, |site| site.force),
            _ => &|solver, seen| middle(seen).map_or(f64::NAN, |site| gap_curvature(solver, diameter, site)),
        };
        let found = ring.locate(from, indicator);
        let exact = event_of(event, diameter);
        let name = |quantity: &str| format!("{quantity} at {name}");
        let case = format!("twisted ring, D/L = {diameter}, {} elements", ELEMENTS << fineness.refinements);
        verify(&case, &name("writhe"), found[1], exact.writhe, tolerance);
        verify(&case, &name("torque M₃L/2πB"), found[2], exact.torque, tolerance);
        verify(&case, &name("bending energy, over that of the ring,"), found[3], exact.bending, 2.0 * tolerance);
    }
}

#[test]
fn first_contact_and_split_of_the_thick_ring() {
    compare(&THICK, COARSE, &[1e-6, 1e-6].map(Some));
}

#[test]
#[ignore = "slow: a minute or two, 1536 elements"]
fn first_events_of_the_thick_ring() {
    compare(&THICK, FINE, &[1e-6, 1e-6].map(Some));
}

#[test]
#[ignore = "slow: minutes, 3072 elements"]
fn last_events_of_the_thick_ring() {
    compare(&THICK, FINEST, &[None, None, Some(1e-6), Some(4e-6)]);
}

#[test]
#[ignore = "slow: a minute or two, 1536 elements"]
fn first_events_of_the_thin_ring() {
    compare(&THIN, FINE, &[1e-6, 2e-6].map(Some));
}

/// Two curvatures of 1/D each differ by nothing at three → line, so 2e-6 asks for 6e-8 of them; the thick ring's 4e-6
/// for 2e-7. Curvatures extrapolated from cells of single elements, much narrower than their distance, left 2.5e-6.
#[test]
#[ignore = "slow: minutes, 3072 elements"]
fn last_events_of_the_thin_ring() {
    compare(&THIN, FINEST, &[None, None, Some(2e-6), Some(2e-6)]);
}

/// States between the events, with one, two and three points, against shooting.
#[test]
fn states_with_one_two_and_three_points() {
    let diameter = 0.03;
    let mut ring = Ring::new(diameter, COARSE);
    let states = [
        (1.2, Event::OnePoint(1.2)),
        (1.5, Event::OnePoint(1.5)),
        (1.8, Event::OnePoint(1.8)),
        (2.1, Event::TwoPoints(2.1)),
        (2.25, Event::TwoPoints(2.25)),
        (2.36, Event::ThreePoints(2.36)),
    ];
    for (link, event) in states {
        let way: &[f64] = if link == 1.8 {
            &[1.65]
        } else if link == 2.1 {
            &[1.95, 2.0]
        } else {
            &[]
        };
        for &excess_link in way {
            ring.go_to(excess_link);
        }
        let found = ring.hard(link, &|_, seen| seen.total_contact_force);
        let exact = event_of(event, diameter);
        assert!(exact.residual < 1e-12, "{exact:?}");
        let case = format!("twisted ring, D/L = {diameter}, ΔLk = {link}");
        // one point lies on a node by symmetry, two and three inside elements
        let tolerance = if matches!(event, Event::OnePoint(_)) { 1e-6 } else { 2e-5 };
        verify(&case, "writhe", found[1], exact.writhe, tolerance);
        verify(&case, "torque M₃L/2πB", found[2], exact.torque, tolerance);
        verify(&case, "bending energy, over that of the ring", found[3], exact.bending, 2.0 * tolerance);
        let force = exact.middle + 2.0 * exact.outer;
        verify(&case, "contact force in all, B/L²", found[4], force, tolerance * force);
    }
}

/// The references by shooting against those computed earlier by other hands, five decimals.
#[test]
fn references_by_shooting() {
    let earlier = [
        (
            0.03,
            [
                [0.86476, 0.26950, 2.81161],
                [1.32404, 0.88280, 3.58558],
                [1.66818, 0.97846, 4.20916],
                [1.71196, 1.00273, 4.29589],
            ],
        ),
        (
            0.01,
            [
                [0.95477, 0.09042, 2.84404],
                [1.62094, 0.48818, 3.68952],
                [2.12632, 0.49945, 4.17004],
                [2.23817, 0.51478, 4.28347],
            ],
        ),
    ];
    for (diameter, numbers) in earlier {
        for ((event, name), numbers) in EVENTS.into_iter().zip(numbers) {
            let found = event_of(event, diameter);
            assert!(found.residual < 1e-12, "{found:?}");
            let case = format!("Kirchhoff ring by shooting, D/L = {diameter}, {name}");
            verify(&case, "writhe", found.writhe, numbers[0], 1e-5);
            verify(&case, "torque M₃L/2πB", found.torque, numbers[1], 1e-5);
            verify(&case, "bending energy over that of the ring", found.bending, numbers[2], 1e-5);
        }
    }
}
