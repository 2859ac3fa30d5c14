//! What the tangent costs over the equilibrium that it belongs to: free energy, gradient, modes; with checked answers.
//!
//! ```text
//! cargo bench --bench tangent                # 1e3 and 1e5 nodes
//! cargo bench --bench tangent -- 1000        # other sizes
//! ```
//!
//! A cantilever rolled up by a dead force, one thread. Exits with 1 if the free energy costs more than twice as much as
//! the equilibrium, a gradient by eight numbers more than a fifth, or an answer is off.

#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use std::process::ExitCode;
use std::time::Instant;

use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status};
use supercoil::tangent::{ContactResponse, EquilibriumTangent, Observable, PrescribedNumber};

/// Largest costs over that of the equilibrium.
const FREE_ENERGY: f64 = 2.0;
const GRADIENT: f64 = 0.2;

const TO: [&str; 8] =
    ["load", "bending", "bending_1", "bending_2", "twisting", "stretching", "natural_curvature_1", "natural_twist"];

fn cantilever(nodes: usize) -> Solver {
    let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, 0.0);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod =
        Rod::new("rod", &shape, RodMesh::open(nodes / 3, 3), section, Natural::Uniform { kappa: [0.5, 1.0, 2.0] });
    let rod = rod.unwrap();
    let end = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
    let model = Model {
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        loads: vec![NodeLoad { node: end, force: Vec3::new(-1.0, 2.0, 3.0), moment: Vec3::zeros() }],
        contact: Contact::NONE,
        rods: vec![rod],
        ..Model::default()
    };
    Solver::new(model, Options { threads: Some(1), ..Options::default() }).unwrap()
}

fn reach(solver: &mut Solver, load: f64) {
    assert_eq!(solver.step_to(&[Ramp::Load { to: load }]).unwrap().status, Status::Converged);
}

/// Seconds of some work.
fn timed<R>(work: impl FnOnce() -> R) -> (f64, R) {
    let start = Instant::now();
    let result = work();
    (start.elapsed().as_secs_f64(), result)
}

fn case(nodes: usize) -> bool {
    let mut solver = cantilever(nodes);
    reach(&mut solver, 0.0);
    let (equilibrium, ()) = timed(|| reach(&mut solver, 1.0));
    let (free_energy, harmonic) =
        timed(|| EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap().harmonic());
    let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap();
    let to: Vec<PrescribedNumber> =
        TO.iter().map(|name| PrescribedNumber::parse(tangent.model(), name).unwrap()).collect();
    let (gradient, slopes) = timed(|| tangent.gradient(&Observable::Extension { rod: 0 }, &to).unwrap());
    let (modes, _) = timed(|| tangent.modes(6).unwrap());
    let extension = |solver: &mut Solver, load: f64| {
        reach(solver, load);
        let of = Observable::Extension { rod: 0 };
        EquilibriumTangent::at(solver, ContactResponse::ByLaw).unwrap().value(&of).unwrap()
    };
    let slope = (extension(&mut solver, 1.001) - extension(&mut solver, 0.999)) / 0.002;
    let is_right = (slopes[0] - slope).abs() < 1e-5 * slope.abs()
        && (slopes[1] - slopes[2] - slopes[3]).abs() < 1e-6 * slopes[1].abs()
        && harmonic.num_unstable == 0
        && harmonic.log_determinant.is_finite();
    let [free_energy, gradient, modes] = [free_energy, gradient, modes].map(|seconds| seconds / equilibrium);
    println!(
        "{nodes:7} nodes: equilibrium {equilibrium:.3} s; over it: free energy {free_energy:.3}, gradient by {} \
         numbers {gradient:.3}, six modes {modes:.3}; answers {}",
        TO.len(),
        if is_right { "right" } else { "WRONG" }
    );
    is_right && free_energy <= FREE_ENERGY && gradient <= GRADIENT
}

fn main() -> ExitCode {
    let given: Vec<usize> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    let sizes = if given.is_empty() { vec![1_000, 100_000] } else { given };
    let all: Vec<bool> = sizes.into_iter().map(case).collect();
    ExitCode::from(u8::from(!all.into_iter().all(|ok| ok)))
}
