//! What [`observe`] says of states that are known by other means.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use supercoil::math::Vec3;
use supercoil::observe::{observe, report::Observation};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Stage, Support};
use supercoil::solve::{self, Options, Status};

/// Every accepted state of a run that must converge.
fn observations(model: Model, ramp: Ramp, steps: usize, options: &Options) -> Vec<Observation> {
    let mut found = Vec::new();
    let stage = Stage::new(vec![ramp], steps);
    let solution = solve::run(model, &[stage], options, &mut |progress| {
        found.push(observe(progress));
        ControlFlow::Continue(())
    });
    assert_eq!(solution.unwrap().status, Status::Converged);
    found
}

fn ring(natural: Natural, shearing: f64) -> Model {
    let section = Section::isotropic(1.0, 1.5, 2e4, shearing, 0.01);
    let circle = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    Model {
        rods: vec![Rod::new("ring", &circle, RodMesh::closed(24, 3), section, natural).unwrap()],
        ..Model::default()
    }
}

/// From the flat ring through the figure-eight: Lk = Tw + Wr is the excess link put in, at every step; the flat ring
/// does not writhe, the figure-eight writhes by almost a turn.
#[test]
fn link_is_what_was_put_in() {
    let steps =
        observations(ring(Natural::Straight, 2e4), Ramp::ExcessLink { rod: 0, to: 1.4 }, 7, &Options::default());
    for step in &steps {
        let link = step.links[0];
        assert!((link.link - link.excess_link).abs() < 1e-12, "{link:?}");
        assert!((link.link - link.twist - link.writhe).abs() < 1e-15);
        if link.excess_link < 1.1 {
            assert!(link.writhe.abs() < 1e-6, "a flat ring does not writhe: {link:?}");
            // K3 is uniform, the moment GJ K3; shear (C ΔLk 2π against GA) takes up a 300th of the link
            assert!((link.seam_moment - 1.5 * TAU * link.excess_twist).abs() < 1e-6, "{link:?}");
            assert!((link.excess_twist - link.excess_link).abs() < 4e-3 * link.excess_link.abs() + 1e-12, "{link:?}");
        }
    }
    let last = steps.last().unwrap();
    assert!(last.links[0].writhe > 0.8 && last.links[0].writhe < 1.0, "{:?}", last.links);
    assert_eq!(last.sites.len(), 1, "{:?}", last.sites);
    assert_eq!(last.sites[0].kind, "point");
    let gap = last.contact_gap.unwrap();
    assert!(gap.upper - gap.lower < 1e-10 && gap.lower > -1e-9, "{gap:?}");
    assert!((gap.upper - last.sites[0].gap).abs() < 1e-11, "the certified gap is the site's: {gap:?} {:?}", last.sites);
}

/// Soft in shear the tangent leans against d3, and still the flat ring does not writhe.
#[test]
fn shear_does_not_count_as_writhe() {
    let steps =
        observations(ring(Natural::Straight, 1e3), Ramp::ExcessLink { rod: 0, to: 0.5 }, 1, &Options::default());
    let link = steps[1].links[0];
    assert!((link.excess_twist - link.twist).abs() > 1e-3 && link.writhe.abs() < 1e-4, "{link:?}");
}

/// A ring with natural twist k3 starts relaxed; link is counted from there.
#[test]
fn natural_twist_is_told_apart() {
    let natural = Natural::Uniform { kappa: [0.0, 0.0, 0.2 * TAU] };
    let options = Options { leave_unstable: false, ..Options::default() };
    let steps = observations(ring(natural, 2e4), Ramp::ExcessLink { rod: 0, to: -0.2 }, 1, &options);
    let [before, after] = [steps[0].links[0], steps[1].links[0]];
    assert!((before.twist - 0.2).abs() < 1e-9 && before.excess_twist.abs() < 1e-9, "{before:?}");
    assert!(before.excess_link.abs() < 1e-12 && (before.link - 0.2).abs() < 1e-12, "{before:?}");
    assert!(before.seam_moment.abs() < 1e-6 && steps[0].energies.twisting < 1e-12, "{before:?}");
    assert!(after.twist.abs() < 1e-9 && (after.excess_twist + 0.2).abs() < 1e-3, "{after:?}");
    assert!((after.excess_link + 0.2).abs() < 1e-12 && after.link.abs() < 1e-12, "{after:?}");
}

/// The clamp of a cantilever carries the tip's load: force −F, moment −(r_tip × F), whatever the deflection.
#[test]
fn the_clamp_carries_the_load() {
    let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.0);
    let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod = Rod::new("cantilever", &line, RodMesh::open(8, 3), section, Natural::Straight).unwrap();
    let tip = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
    let (force, moment) = (Vec3::new(0.3, -2.0, 4.0), Vec3::new(0.1, 0.0, 0.2));
    let model = Model {
        rods: vec![rod],
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        loads: vec![NodeLoad { node: tip, force, moment }],
        contact: Contact::NONE,
        ..Model::default()
    };
    let (mut state, mut arm) = (None, Vec3::zeros());
    let stage = Stage::new(vec![Ramp::Load { to: 1.0 }], 4);
    let solution = solve::run(model, &[stage], &Options::default(), &mut |progress| {
        arm = progress.engine.positions(0)[tip.node];
        state = Some(observe(progress));
        ControlFlow::Continue(())
    });
    assert_eq!(solution.unwrap().status, Status::Converged);
    let state = state.unwrap();
    assert_eq!(state.reactions.len(), 1);
    assert!(arm.x < 0.8, "large deflection: {arm}");
    let found = &state.reactions[0];
    assert!((Vec3::from(found.force) + force).norm() < 1e-9, "{found:?}");
    assert!((Vec3::from(found.moment) + moment + arm.cross(&force)).norm() < 1e-8, "{found:?}");
    assert!(state.links.is_empty() && state.sites.is_empty() && state.contact_gap.is_none());
}

/// Energies by kind of a ring bent from straight: ½ B (2π/L)² L; twisted, ½ C K3² L more.
#[test]
fn energies_are_told_apart() {
    let steps =
        observations(ring(Natural::Straight, 2e4), Ramp::ExcessLink { rod: 0, to: 0.5 }, 1, &Options::default());
    let (start, twisted) = (steps[0].energies, steps[1].energies);
    assert!((start.bending - 2.0 * PI * PI).abs() < 1e-5 && start.twisting < 1e-12, "{start:?}");
    let k3 = TAU * steps[1].links[0].excess_twist;
    assert!((twisted.twisting - 0.75 * k3 * k3).abs() < 1e-6 && (k3 - PI).abs() < 0.01, "{twisted:?}");
    assert!(twisted.shearing > 0.0 && twisted.shearing < 0.03 && twisted.stretching < 1e-6, "{twisted:?}");
    let sum = twisted.stretching + twisted.shearing + twisted.bending + twisted.twisting + twisted.contact;
    assert_eq!(sum, twisted.total);
}
