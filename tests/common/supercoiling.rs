//! Random supercoiling runs: closed rods of random thickness, C/B and excess link from randomly perturbed starts,
//! unknots and trefoils.

#![allow(dead_code)] // every user takes its part
#![allow(clippy::unwrap_used)] // helpers of tests

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use super::knots::determinant;
use super::random::Random;
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape, TorusKnot};
use supercoil::scene::{Model, Ramp, Stage};
use supercoil::solve::{Options, Status, run};

/// How a run goes to its link.
#[derive(Clone, Copy, PartialEq)]
pub enum Way {
    /// In steps of at most a turn.
    TurnByTurn,
    /// In one step, on a coarse mesh first where there is one.
    AtOnce,
}

/// A rod and where its link goes.
pub struct Start {
    pub rod: Rod,
    pub diameter: f64,
    pub ratio: f64,
    pub to: f64,
}

/// The rod of a seed.
pub fn start(seed: u64) -> Start {
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    (0..4).for_each(|_| {
        random.between(0.0, 1.0);
    });
    let knotted = seed % 4 == 3;
    let diameter = if knotted { random.between(0.012, 0.02) } else { random.between(0.012, 0.04) };
    let ratio = random.between(0.5, 2.0);
    // supercoiling density up to 0.1 with D = 5 nm and 3.57 nm a turn
    let link = random.between(-1.0, 1.0) * 0.1 * (5.0 / diameter) / 3.57;
    let elements = (1.1 / diameter).ceil() as usize;
    let section = Section::isotropic(1.0, ratio, 1e6, 1e6, 0.5 * diameter);
    let shape = if knotted {
        Shape::TorusKnot(TorusKnot::new(1.0, [2, 3]))
    } else {
        Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() }
    };
    let mut rod = Rod::new("random", &shape, RodMesh::closed(elements, 3), section, Natural::Straight).unwrap();
    if !knotted {
        let [a, b, phase] = [random.between(0.0, 0.01), random.between(0.0, 0.01), random.between(0.0, 6.0)];
        let count = rod.positions.len() as f64;
        for (k, r) in rod.positions.iter_mut().enumerate() {
            let t = TAU * k as f64 / count;
            r.z += a * (2.0 * t + phase).sin() + b * (3.0 * t).cos();
        }
    }
    let to = if knotted { rod.start_excess_link + 0.3 * link } else { link };
    Start { rod, diameter, ratio, to }
}

/// How a run ended.
pub struct Run {
    pub status: Status,
    pub steps: usize,
    pub planned: usize,
    pub iterations: usize,
    pub elsewhere: usize,
    /// Of the last state, that of the contact law left out.
    pub energy: f64,
    /// Largest difference of link from what was prescribed, of all steps.
    pub link_error: f64,
    /// Smallest gap over the diameter, of all steps.
    pub gap: f64,
    /// Determinants of the knot before and after.
    pub knot: [f64; 2],
}

impl Run {
    /// Whether it came to rest, and link and knot are what they must be.
    pub fn passed(&self) -> bool {
        let kept = self.link_error < 1e-9 && self.knot[0] == self.knot[1];
        self.status == Status::Converged && kept && self.gap > -1e-6
    }
}

/// Runs the rod to its link.
pub fn go(start: Start, way: Way, options: &Options) -> Run {
    let Start { rod, diameter, to, .. } = start;
    let before = determinant(&rod.positions);
    let turns = (to - rod.start_excess_link).abs();
    let planned = if way == Way::AtOnce { 1 } else { (turns.ceil() as usize).max(1) };
    let stage = Stage::new(vec![Ramp::ExcessLink { rod: 0, to }], planned);
    let (mut link_error, mut gap, mut elsewhere, mut energy) = (0.0f64, f64::INFINITY, 0, 0.0);
    let solution = run(Model { rods: vec![rod], ..Model::default() }, &[stage], options, &mut |progress| {
        elsewhere += progress.report.iterations_on_other_meshes;
        if progress.report.status == Status::Converged {
            let seen = observe(progress);
            energy = seen.energies.total - seen.energies.contact;
            let asked = progress.engine.state().seams()[0] / TAU;
            link_error = link_error.max((seen.links[0].link - asked).abs());
            gap = gap.min(seen.contact_gap.map_or(f64::INFINITY, |gap| gap.lower) / diameter);
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    let after = determinant(solution.solver.engine().positions(0));
    let (steps, iterations) = (solution.num_steps, solution.iterations);
    Run {
        status: solution.status,
        steps,
        planned,
        iterations,
        elsewhere,
        energy,
        link_error,
        gap,
        knot: [before, after],
    }
}
