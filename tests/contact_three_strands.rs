//! A beam pressed from both sides at the same place, by forces that differ: each contact is closed at its own pressure.
//!
//! ```text
//!      ═══════════════  upper, pressed down by q₂        A = ½q₁ − 192 B g₁/L⁴        F₁ = (2A + B)/3
//!      ───────────────  middle                           B = ½q₂ − 192 B g₂/L⁴        F₂ = (A + 2B)/3
//!      ═══════════════  lower, pressed up by q₁
//! ```
//!
//! Three parallel clamped beams (bending stiffness 1, length 1), gaps g₁ and g₂, touch at mid-span: clamped beams deflect by q/384 and F/192. Offsets of the augmented
//! Lagrangian that were the same for all that a node touches held the lighter of the two contacts open.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

mod common;

use common::{history, observed};
use supercoil::math::Vec3;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, LineLoad, Model, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status, StepReport};

const RADIUS: f64 = 0.05;
const GAPS: [f64; 2] = [5e-4, 5e-4];

fn beams(law: ContactLaw, pressures: [f64; 2], planar: bool) -> Solver {
    let section = Section::isotropic(1.0, 1.0, 1e2, 1e9, RADIUS);
    let heights = [0.0, 2.0 * RADIUS + GAPS[0], 4.0 * RADIUS + GAPS[0] + GAPS[1]];
    let beam = |height: f64| {
        let shape = Shape::Line { start: Vec3::y() * height, direction: Vec3::x(), length: 1.0 };
        Rod::new("beam", &shape, false, section, 24, 3, Natural::Straight).unwrap()
    };
    let rods = heights.map(beam).to_vec();
    let last = rods[0].num_nodes() - 1;
    let ends = (0..3).flat_map(|rod| [0, last].map(|node| Support::clamp(NodeRef { rod, node })));
    let line_loads = vec![
        LineLoad { rod: 0, force: Vec3::y() * pressures[0] },
        LineLoad { rod: 2, force: Vec3::y() * -pressures[1] },
    ];
    let model =
        Model { rods, supports: ends.collect(), line_loads, contact: Contact { law }, planar, ..Model::default() };
    Solver::new(model, Options::default()).unwrap()
}

fn pressed(law: ContactLaw, pressures: [f64; 2], planar: bool) -> (Observation, StepReport) {
    let mut solver = beams(law, pressures, planar);
    let report = solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap();
    if report.status != Status::Converged {
        println!("!!! {:.300}", history(&report))
    }
    (observed(&solver, &report), report)
}

fn forces(seen: &Observation) -> [f64; 2] {
    let between = |a: usize| seen.sites.iter().filter(|site| site.rod_a == a).map(|site| site.force).sum();
    [between(0), between(1)]
}

#[test]
fn each_side_is_pressed_by_its_own_force() {
    let first = 192.0 * GAPS[0];
    for factors in [[2.0, 2.5], [0.0, 3.0], [0.0, 4.0], [4.5, 0.0]] {
        let pressures = factors.map(|f| f * 2.0 * first);
        let [a, b] = [0, 1].map(|k| 0.5 * pressures[k] - 192.0 * GAPS[k]);
        let exact = [(2.0 * a + b) / 3.0, (a + 2.0 * b) / 3.0];
        let (stiff, report) = pressed(ContactLaw::Penalty { stiffness: 1e7 }, pressures, true);
        println!(
            "penalty {:.7?} exact {exact:.7?} {} iterations, gaps {:?}",
            forces(&stiff),
            report.iterations,
            stiff.sites.iter().map(|s| s.gap / RADIUS).collect::<Vec<_>>()
        );
        for stiffness in [0.01, 0.1, 1.0, 100.0, 1e4] {
            let law = ContactLaw::AugmentedLagrangian { stiffness, tol_penetration: 1e-9 };
            let (seen, report) = pressed(law, pressures, true);
            println!(
                "{factors:?} κ' {stiffness}: {:.7?}; {} iterations, {} augmentations, penetration {:.1e}, held {:.1e}",
                forces(&seen),
                report.iterations,
                report.augmentations,
                report.penetration,
                report.held_open
            );
            for site in &seen.sites {
                println!(
                    "    {:?} {} {} gap {:.2e} radii, force {:.6}",
                    site.kind,
                    site.rod_a,
                    site.rod_b,
                    site.gap / RADIUS,
                    site.force
                );
            }
        }
    }
}
