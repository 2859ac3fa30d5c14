//! The twisted closed ring in self-contact, C/B = 1.5, from the flat circle by ramping excess link.
//!
//! A naturally straight isotropic rod of length L = 1, B = 1, closed into a flat circle; its ends are turned against
//! each other before closing (excess link ΔLk). Past ΔLk = √3·B/C the circle is unstable, the ring folds into a
//! figure-eight that touches itself in one point, then in two, three, then along a line between two isolated points.
//!
//! Reference: Kirchhoff rod (inextensible, unshearable) with hard contact, recomputed by shooting; forces in B/L²,
//! energies in B/L. Stretch and shear stiffness 1e8 B/L² take the comparison to about 1e-5.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::f64::consts::{PI, TAU};

use common::{observed, verify};
use supercoil::math::Vec3;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, Ramp};
use supercoil::solve::{Options, Solver, Status, StepReport};

fn ring(elements: usize, diameter: f64, stiff: f64, law: impl Fn(f64) -> ContactLaw) -> Solver {
    let section = Section::isotropic(1.0, 1.5, stiff, stiff, 0.5 * diameter);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(elements, 3), section, Natural::Straight).unwrap();
    let contact = Contact { law: law((0.5 * diameter).powi(4)) };
    Solver::new(Model { rods: vec![rod], contact, ..Model::default() }, Options::default()).unwrap()
}

/// Augmented Lagrangian with κ in B/L⁴.
fn augmented(kappa: f64) -> impl Fn(f64) -> ContactLaw {
    move |radius4| ContactLaw::AugmentedLagrangian { stiffness: kappa * radius4, tol_penetration: 1e-8 }
}

fn to(solver: &mut Solver, excess_link: f64) -> (StepReport, Observation) {
    let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to: excess_link }]).unwrap();
    let seen = observed(solver, &report);
    (report, seen)
}

/// What holds in every rest state of a run: converged, stable, no overlap, link conserved.
fn check_rest(report: &StepReport, seen: &Observation, excess_link: f64, diameter: f64) {
    assert_eq!(report.status, Status::Converged, "ΔLk = {excess_link}");
    assert_eq!(report.num_unstable, 0, "ΔLk = {excess_link}");
    assert!((seen.links[0].link - excess_link).abs() < 1e-9, "link {} at {excess_link}", seen.links[0].link);
    if let Some(gap) = seen.contact_gap {
        assert!(gap.lower >= -1e-6 * diameter, "overlap {} at {excess_link}", gap.lower);
    }
}

/// Contact force at one point to 1e-4; then two points, three, line contact to 0.1 % in writhe and elastic energy.
#[test]
fn contact_forces_and_topology_of_the_thick_ring() {
    let mut solver = ring(48, 0.02, 1e8, augmented(1e11));
    let states = [
        (0.5, None, 0),
        (1.1, None, 0),
        (1.2, Some(48.701169), 1),
        (1.4, None, 1),
        (1.6, Some(169.920755), 1),
        (1.8, None, 1),
        (1.9, Some(285.039450), 1),
        (2.05, None, 2),
        (2.2, None, 2),
        (2.42, None, 3),
        (2.6, None, 3),
        (2.8, None, 3),
        (3.0, None, 3),
    ];
    for (excess_link, force, sites) in states {
        let (report, seen) = to(&mut solver, excess_link);
        println!(
            "ΔLk {excess_link}: {} iterations, force {:.6}, writhe {:.6}, energy {:.5}, sites {:?}, pen {:.1e}",
            report.iterations,
            seen.total_contact_force,
            seen.links[0].writhe,
            seen.energies.total,
            seen.sites.iter().map(|s| (s.kind, s.force)).collect::<Vec<_>>(),
            report.penetration
        );
        check_rest(&report, &seen, excess_link, 0.02);
        if let Some(exact) = force {
            let case = format!("twisted ring, D/L = 0.02, ΔLk = {excess_link}");
            verify(&case, "contact force, B/L²", seen.total_contact_force, exact, 1e-4 * exact);
        }
        if sites < 3 {
            assert_eq!(seen.sites.len(), sites, "sites at {excess_link}");
        } else {
            assert!(seen.sites.len() >= sites, "sites at {excess_link}");
        }
    }
    let (_, seen) = to(&mut solver, 3.0);
    let elastic = seen.energies.total - seen.energies.contact;
    let case = "twisted ring, D/L = 0.02, ΔLk = 3 (line contact)";
    verify(case, "writhe", seen.links[0].writhe, 2.371617, 5e-4);
    verify(case, "elastic energy, B/L", elastic, 112.061, 2e-2);
}

/// Writhe, twisting moment and bending energy of a plectoneme.
fn verify_plectoneme(seen: &Observation, diameter: f64, reference: [f64; 3], tolerance: f64) {
    let case = format!("plectoneme of the twisted ring, D/L = {diameter}");
    let measured = [seen.links[0].writhe, seen.links[0].seam_moment / TAU, seen.energies.bending / (2.0 * PI * PI)];
    for (k, quantity) in ["Wr", "M3 L/2πB", "bending energy over that of the ring"].into_iter().enumerate() {
        verify(&case, quantity, measured[k], reference[k], tolerance * reference[k]);
    }
}

#[test]
fn plectoneme_of_the_thin_ring() {
    const THIN: f64 = 4.18363 + 0.88448 / 1.5;
    let mut solver = ring(48, 0.01, 1e7, augmented(1.6e11));
    for excess_link in [1.0, 1.2, 1.5, 1.8, 2.1, 2.4, 2.7, 3.0, 3.3, 3.6, 3.9, 4.2, 4.5, THIN] {
        let (report, seen) = to(&mut solver, excess_link);
        println!("ΔLk {excess_link}: {} iterations, writhe {:.6}", report.iterations, seen.links[0].writhe);
        check_rest(&report, &seen, excess_link, 0.01);
    }
    let (_, seen) = to(&mut solver, THIN);
    verify_plectoneme(&seen, 0.01, [4.18363, 0.88448, 6.93812], 1e-3);
}

#[test]
fn plectoneme_of_the_thick_ring() {
    const LAST: f64 = 3.03002 + 2.32740 / 1.5;
    let mut solver = ring(48, 0.03, 1e7, augmented(2e9));
    for excess_link in [1.0, 1.2, 1.5, 1.8, 2.1, 2.4, 2.7, 3.0, 3.3, 3.6, 3.9, 4.2, 4.4, LAST] {
        let (report, seen) = to(&mut solver, excess_link);
        println!("ΔLk {excess_link}: {} iterations, writhe {:.6}", report.iterations, seen.links[0].writhe);
        check_rest(&report, &seen, excess_link, 0.03);
    }
    let (_, seen) = to(&mut solver, LAST);
    verify_plectoneme(&seen, 0.03, [3.03002, 2.32740, 8.38007], 1e-3);
}

/// Raising the penalty tenfold costs five or six Newton steps, seven along a line, and up to twelve where the penalty
/// is so soft that points of contact are about to split, each search ending superlinearly; at κ = 1e14 the force is the
/// hard one.
#[test]
fn decades_of_the_penalty_converge_superlinearly() {
    let penalty = |kappa: f64| move |radius4: f64| ContactLaw::Penalty { stiffness: kappa * radius4 };
    let radius4 = 0.01f64.powi(4);
    let mut solver = ring(24, 0.02, 1e8, penalty(1e7));
    for (excess_link, force) in
        [(1.1, 0.0), (1.2, 48.701169), (1.6, 169.920755), (1.9, 285.03945), (2.2, 0.0), (3.0, 0.0)]
    {
        solver.set_contact_law(penalty(1e7)(radius4)).unwrap();
        let (report, _) = to(&mut solver, excess_link);
        assert_eq!(report.status, Status::Converged);
        for decade in 8..=14 {
            solver.set_contact_law(penalty(10f64.powi(decade))(radius4)).unwrap();
            let report = solver.find_equilibrium();
            println!(
                "ΔLk {excess_link} κ 1e{decade}: {} steps, penetration {:.1e}",
                report.iterations, report.penetration
            );
            assert_eq!(report.status, Status::Converged);
            let most = if decade > 10 { 7 } else { 12 };
            assert!(report.iterations <= most, "{} steps", report.iterations);
            assert_superlinear(&report, excess_link, decade);
        }
        let (_, seen) = to(&mut solver, excess_link);
        if force > 0.0 {
            assert!((seen.total_contact_force / force - 1.0).abs() < 1e-5, "force {}", seen.total_contact_force);
        }
    }
}

/// The last step gains all but two digits, and either the last two together three and a half or the last more than
/// twice what the one before gained (searches so short that the tolerance is met on the way down). A linear rate (.95
/// with sloppy zone ends) or a limit cycle fails.
fn assert_superlinear(report: &StepReport, excess_link: f64, decade: i32) {
    let sizes: Vec<f64> = report.history.iter().flatten().map(|i| i.increment).collect();
    let [.., e1, e2, e3] = sizes[..] else { return };
    let falls = e3 <= 3e-4 * e1 || e3 / e2 <= 0.5 * e2 / e1;
    assert!(e3 <= 2e-2 * e2 && falls, "ΔLk {excess_link} κ 1e{decade}: {sizes:?}");
}

/// A load step far too long: from the flat ring to line contact at once. Wherever it ends, no strand has passed
/// another: the link measured on the curve is the one prescribed (a passage changes it by two).
#[test]
fn a_careless_step_does_not_change_the_link() {
    for excess_link in [2.0, 3.0, -3.0] {
        let mut solver = ring(32, 0.02, 1e6, augmented(1e9));
        assert_eq!(to(&mut solver, 0.5).0.status, Status::Converged);
        let (report, seen) = to(&mut solver, excess_link);
        println!("ΔLk 0.5 → {excess_link}: {:?}, {} iterations", report.status, report.iterations);
        assert!((seen.links[0].link - excess_link).abs() < 1e-9, "link {}", seen.links[0].link);
    }
}

/// One step from one point of contact far past its split into two, on fine meshes. (Symptom before: `Penetration`.
/// Under the deepest core law two points a few radii apart, with a shallow gap between them, took turns: each offset
/// went by the smallest gap within a contact distance, and so by the other point's.)
#[test]
fn a_step_past_the_split_comes_to_rest() {
    for elements in [96, 144] {
        let mut solver = ring(elements, 0.02, 1e6, augmented(1e10));
        for excess_link in [0.5, 1.1, 1.2, 1.5, 2.1] {
            let (report, seen) = to(&mut solver, excess_link);
            check_rest(&report, &seen, excess_link, 0.02);
        }
        assert_eq!(to(&mut solver, 2.1).1.sites.len(), 2);
    }
}

/// The same run on one and on two threads ends in the same bits.
#[test]
fn threads_do_not_change_a_bit() {
    let run = |threads: usize| {
        let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, 0.01);
        let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
        let rod = Rod::new("ring", &shape, RodMesh::closed(24, 3), section, Natural::Straight).unwrap();
        let options = Options { threads: Some(threads), ..Options::default() };
        let mut solver = Solver::new(Model { rods: vec![rod], ..Model::default() }, options).unwrap();
        let mut sites = String::new();
        for excess_link in [1.1, 1.3, 2.1] {
            let (report, seen) = to(&mut solver, excess_link);
            assert_eq!(report.status, Status::Converged);
            // Debug prints every bit of a float
            sites = format!("{:?} {:?} {:?}", seen.sites, seen.contact_gap, seen.energies);
        }
        let bits: Vec<u64> =
            solver.engine().positions(0).iter().flat_map(|r| [r.x, r.y, r.z]).map(f64::to_bits).collect();
        (bits, sites, solver.engine().state().seams()[0] / TAU)
    };
    assert_eq!(run(1), run(2));
}
