//! Two rods wound round each other: the inside of a plectoneme, against its closed forms.
//!
//! ```text
//!   clamped                         clamped, free to slide along z
//!    ▌══╲  ╱══╲  ╱══╲  ╱══╲  ╱══▐
//!    ▌   ╲╱    ╲╱    ╲╱    ╲╱   ▐ → z      angle α between either strand and z, radius R = ε
//!    ▌══╱  ╲══╱  ╲══╱  ╲══╱  ╲══▐
//! ```
//!
//! Two naturally straight rods, B = 1, C = 1, ε = 1, start as the two strands of a right-handed double helix with nine
//! tenths of the twist below, clamped at their ends in its directions, one end of each free to slide. They are twisted
//! further by turning these ends about their own axes until the pair carries no torque about z: then no net force and
//! no net moment crosses a section, as in a plectoneme with a free end loop.
//!
//! Contact by a penalty of 100 B/ε⁴: the strands sink into each other by p/κ, of the order of 1e-3 ε, and R is what is
//! then measured.
//!
//! Exact, with α, R of the middle of the pair: twisting moment M = 2B sin³α cosα/(R cos 2α), contact force per length p
//! = B sin⁴α/(R³ cos 2α), and F = (B sin⁴α/R²)(½ + 1/cos 2α), the tension of tails that go on straight from such a ply:
//! contact without friction leaves n·t + ½Bκ² + M²/2C the same along a strand, so F = n·t + ½Bκ² is measured inside the
//! ply.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use super::{history, observed, strains};
use supercoil::internals::quaternion::spin;
use supercoil::math::{Quat, Vec3};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status};

const STIFF: f64 = 1e5;

fn pair(alpha: f64, turns: f64, spacing: f64, twist: f64) -> Solver {
    let section = Section::isotropic(1.0, 1.0, STIFF, STIFF, 1.0);
    let pitch = std::f64::consts::TAU / alpha.tan();
    let shape = Shape::Helix { center: Vec3::zeros(), axis: Vec3::z(), radius: 1.0, pitch, turns };
    let length = std::f64::consts::TAU * turns / alpha.sin();
    let elements = (length / (3.0 * spacing)).ceil() as usize;
    let mut one = Rod::new("one", &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap();
    let step = one.length / (one.num_nodes() - 1) as f64;
    for (k, frame) in one.frames.iter_mut().enumerate() {
        *frame *= spin(twist * step * k as f64);
    }
    let mut two = Rod { name: "two".into(), ..one.clone() };
    let half_turn = Quat::from_axis_angle(&Vec3::z_axis(), std::f64::consts::PI);
    two.positions.iter_mut().for_each(|r| *r = half_turn * *r);
    two.frames.iter_mut().for_each(|q| *q = half_turn * *q);
    let last = one.num_nodes() - 1;
    let supports = (0..2).flat_map(|rod| {
        let slide = Support { position: [true, true, false], ..Support::clamp(NodeRef { rod, node: last }) };
        [Support::clamp(NodeRef { rod, node: 0 }), slide]
    });
    let law = ContactLaw::Penalty { stiffness: 100.0 };
    let model =
        Model { supports: supports.collect(), rods: vec![one, two], contact: Contact { law }, ..Model::default() };
    Solver::new(model, Options::default()).unwrap()
}

/// What is measured in a state.
pub struct Ply {
    /// Torque of the pair about z, at the clamps \[F·L\].
    pub torque: f64,
    pub alpha: f64,
    pub radius: f64,
    /// Twisting moment, tension + ½Bκ² and contact force per length in the middle third of rod 0.
    pub moment: f64,
    pub tail: f64,
    pub pressure: f64,
    /// Newton iterations of this state.
    pub iterations: usize,
}

/// A pressure that turns by `angle` from node to node, weighted with a node's Hermite function and summed, over its
/// size: the nodal force is shorter than the force along the arc that it stands for.
fn lumping(angle: f64) -> f64 {
    let rule = supercoil::internals::quadrature::gauss(5);
    let value = |x: f64| (1.0 - 3.0 * x * x + 2.0 * x * x * x) * (angle * x).cos();
    2.0 * rule.points.iter().zip(rule.weights).map(|(&x, &w)| w * value(x)).sum::<f64>()
}

fn twisted(solver: &mut Solver, turns: f64) -> Ply {
    let last = solver.engine().model().rods[0].num_nodes() - 1;
    let ramps = [0, 1].map(|rod| {
        let axis = solver.engine().frames(rod)[last] * Vec3::z();
        Ramp::Rotation { node: NodeRef { rod, node: last }, axis, to: turns }
    });
    let report = solver.step_to(&ramps).unwrap();
    assert_eq!(report.status, Status::Converged, "{}", history(&report));
    let engine = solver.engine();
    let seen = observed(solver, &report);
    let clamps = seen.reactions.iter().filter(|r| r.node == 0);
    let torque = clamps
        .map(|r| {
            let arm = engine.positions(r.rod)[0];
            r.moment[2] + arm.x * r.force[1] - arm.y * r.force[0]
        })
        .sum();
    let rod = &engine.model().rods[0];
    let points = strains(rod, engine.positions(0), engine.frames(0));
    let middle = &points[points.len() / 3..2 * points.len() / 3];
    let mean = |f: &dyn Fn(&[f64; 6]) -> f64| middle.iter().map(f).sum::<f64>() / middle.len() as f64;
    let contact = engine.nodal_fields(0).contact_force;
    let middle = &contact[contact.len() / 3..2 * contact.len() / 3];
    let node = last / 2;
    let (a, b) = (
        engine.positions(0)[node] - engine.positions(1)[node],
        engine.positions(0)[node + 1] - engine.positions(1)[node + 1],
    );
    let spacing = rod.length / last as f64;
    let winding = a.xy().angle(&b.xy()) / spacing;
    let ply = Ply {
        torque,
        alpha: (engine.frames(0)[node] * Vec3::z()).z.acos(),
        radius: 0.5 * (engine.positions(0)[node] - engine.positions(1)[node]).norm(),
        moment: mean(&|s| s[5]),
        tail: mean(&|s| STIFF * s[2] + 0.5 * (s[3] * s[3] + s[4] * s[4])),
        iterations: report.iterations,
        pressure: middle.iter().map(|p| p.norm()).sum::<f64>() / (middle.len() as f64 * lumping(winding * spacing)),
    };
    println!(
        "{turns:.4} turns: torque {:.6}, α {:.6}, R {:.8}, M {:.6}, F {:.6}, p {:.6}, {} site(s), {} outer, {} inner",
        ply.torque,
        ply.alpha,
        ply.radius,
        ply.moment,
        ply.tail,
        ply.pressure,
        seen.sites.len(),
        report.augmentations,
        report.iterations
    );
    ply
}

/// Torque 2B sin³α cosα/cos 2α of one strand about its own axis, ε = 1: the twisting moment.
fn moment_at(a: f64) -> f64 {
    2.0 * a.sin().powi(3) * a.cos() / (2.0 * a).cos()
}

/// The pair, started at an angle and turned until it carries no torque, and the states on the way: the torque is
/// brought to zero by secants.
pub fn without_torque(alpha: f64, turns: f64) -> Vec<Ply> {
    let mut solver = pair(alpha, turns, 0.25, -0.9 * moment_at(alpha));
    let first = twisted(&mut solver, 0.0);
    let (mut before, mut now) = ((0.0, first.torque), -0.01 * turns);
    let mut plies = vec![first, twisted(&mut solver, now)];
    for _ in 0..2 {
        let torque = plies[plies.len() - 1].torque;
        let next = now - torque * (now - before.0) / (torque - before.1);
        before = (now, torque);
        now = next;
        plies.push(twisted(&mut solver, now));
    }
    plies
}

impl Ply {
    /// Closed forms at the angle and radius measured: twisting moment, tension of the tails, contact force per length.
    pub fn exact(&self) -> [f64; 3] {
        let (a, r) = (self.alpha, self.radius);
        let tail = a.sin().powi(4) / (r * r) * (0.5 + 1.0 / (2.0 * a).cos());
        [moment_at(a) / r, tail, a.sin().powi(4) / (r.powi(3) * (2.0 * a).cos())]
    }
}
