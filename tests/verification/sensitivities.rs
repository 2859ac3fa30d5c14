//! Sensitivities against central differences of whole runs, 1e-6 of each derivative, or of the largest of its
//! observable where it is small: with points of contact between rods, also sheared ones, and on obstacles, with rods
//! that are joined, or curved by a table; along a line under a penalty.
//!
//! Differences are of fourth order, of equilibria that converged to increments of 1e-12 and penetrations of 1e-13. Gaps
//! that are open by less than 1e-6 radii are left open by the augmented Lagrangian, so that a force that sinks ends up
//! to 1e-5 off (derivatives of runs then differ by 1e-5 to 1e-4 from each other). Each run is therefore approached from
//! less contact: forces that rise are right to the tolerance of penetrations.

use crate::common;

use common::verify;
use supercoil::math::Vec3;
use supercoil::rod::{Along, Natural, NaturalStrains, Rod, RodMesh, RodNumber, Section, Shape};
use supercoil::scene::model::{Hinge, Side};
use supercoil::scene::{
    Contact, ContactLaw, Electrostatics, Joint, LineLoad, Model, NodeLoad, NodeRef, Obstacle, ObstacleNumber, Ramp,
    Support,
};
use supercoil::solve::{Options, Solver, Status};
use supercoil::tangent::{ContactResponse, EquilibriumTangent, Observable, PrescribedNumber};

/// A parameter, the ramp that changes it by so much, and the step of differences.
type Varied = (PrescribedNumber, Box<dyn Fn(f64) -> Ramp>, f64);

fn solver(model: Model) -> Solver {
    let mut options = Options::default();
    options.newton.tol_increment = 1e-12;
    Solver::new(model, options).unwrap()
}

fn reach(solver: &mut Solver, ramps: &[Ramp]) {
    let report = solver.step_to(ramps).unwrap();
    assert_eq!(report.status, Status::Converged, "{ramps:?}: {}", common::history(&report));
}

fn hard(stiffness: f64) -> Contact {
    Contact { law: ContactLaw::AugmentedLagrangian { stiffness, tol_penetration: 1e-13 } }
}

fn number(rod: usize, which: RodNumber, value: f64, step: f64) -> Varied {
    let ramp = move |by: f64| Ramp::Number { rod, which, to: value + by };
    (PrescribedNumber::Number { rod, which: vec![which] }, Box::new(ramp), step)
}

fn load(step: f64) -> Varied {
    (PrescribedNumber::Load, Box::new(|by| Ramp::Load { to: 1.0 + by }), step)
}

/// Checks derivatives of some observables by some parameters. `press` has a ramp that lessens contact, and the one
/// back.
fn against_runs(
    name: &str,
    solver: &mut Solver,
    (of, to): (&[Observable], &[Varied]),
    press: &dyn Fn(bool) -> Ramp,
    tolerance: f64,
) {
    reach(solver, &[press(false)]);
    reach(solver, &[press(true)]);
    let contacts = ContactResponse::of_law(solver.engine().model().contact.law);
    let parameters: Vec<PrescribedNumber> = to.iter().map(|(parameter, _, _)| parameter.clone()).collect();
    let mut tangent = EquilibriumTangent::at(solver, contacts).unwrap();
    let found: Vec<Vec<f64>> = of.iter().map(|of| tangent.gradient(of, &parameters).unwrap()).collect();
    let values = |solver: &mut Solver| -> Vec<f64> {
        let mut tangent = EquilibriumTangent::at(solver, contacts).unwrap();
        of.iter().map(|of| tangent.value(of).unwrap()).collect()
    };
    for (k, (parameter, ramp, step)) in to.iter().enumerate() {
        let mut at = |by: f64| {
            reach(solver, &[press(false)]);
            // two ramps of one number are refused: the load's own presses, too
            let both = [ramp(by * step), press(true)];
            let count = if matches!(both, [Ramp::Load { .. }, Ramp::Load { .. }]) { 1 } else { 2 };
            reach(solver, &both[..count]);
            values(solver)
        };
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(&mut at);
        at(0.0);
        for (i, of) in of.iter().enumerate() {
            let exact = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step);
            // a parameter in its own unit: over how much it takes to change the observable by itself
            let size = exact.abs().max(1e-2 * values(solver)[i].abs() / step.abs().max(1.0));
            verify(name, &format!("d {of:?} / d {parameter:?}"), found[i][k], exact, tolerance * size);
        }
    }
}

fn crossed(contact: Contact, shearing: f64) -> Solver {
    let rod = |name: &str, start: Vec3, direction: Vec3, radius: f64| {
        let section = Section::isotropic(50.0 * radius, 0.8, 1e5, shearing, radius);
        let shape = Shape::Line { start, direction, length: 1.0 };
        Rod::new(name, &shape, RodMesh::open(15, 3), section, Natural::Straight).unwrap()
    };
    let low = rod("low", Vec3::new(-0.5, 0.0, 0.0), Vec3::x(), 0.02);
    let high = rod("high", Vec3::new(0.03, -0.45, 0.05), Vec3::y(), 0.03);
    let last = low.num_nodes() - 1;
    let ends = [(0, 0), (0, last), (1, 0), (1, last)].map(|(rod, node)| NodeRef { rod, node });
    let supports = ends.map(Support::clamp).to_vec();
    let mut solver = solver(Model { rods: vec![low, high], supports, contact, ..Model::default() });
    let lower = |node: NodeRef, by: f64| Ramp::Displacement { node, to: Vec3::z() * -by };
    for part in [0.4, 0.7, 1.0] {
        reach(&mut solver, &[lower(ends[2], 0.05 * part), lower(ends[3], 0.06 * part)]);
    }
    solver
}

/// The far end of the upper rod, up by a fiftieth and down again.
fn press_crossed(down: bool) -> Ramp {
    Ramp::Displacement { node: NodeRef { rod: 1, node: 45 }, to: Vec3::z() * if down { -0.06 } else { -0.0588 } }
}

/// All loads, lessened by a fiftieth.
fn press_by_load(down: bool) -> Ramp {
    Ramp::Load { to: if down { 1.0 } else { 0.98 } }
}

fn of_crossed() -> Vec<Observable> {
    vec![
        Observable::Energy,
        Observable::ContactForce,
        Observable::Reaction { node: NodeRef { rod: 0, node: 45 }, component: 2 },
        Observable::Position { node: NodeRef { rod: 0, node: 22 }, axis: 2 },
    ]
}

fn to_crossed() -> Vec<Varied> {
    let node = NodeRef { rod: 1, node: 0 };
    let moved = PrescribedNumber::Displacement { node, direction: Vec3::z() };
    let turned = PrescribedNumber::Rotation { node, axis: Vec3::x() };
    vec![
        number(0, RodNumber::ContactRadius, 0.02, 1e-5),
        number(1, RodNumber::ContactRadius, 0.03, 1e-5),
        number(1, RodNumber::Bending2, 1.5, 1e-3),
        number(0, RodNumber::Stretching, 1e5, 1e2),
        number(1, RodNumber::Length, 1.0, 1e-5),
        (moved, Box::new(move |by| Ramp::Displacement { node, to: Vec3::z() * (by - 0.05) }), 2e-5),
        (turned, Box::new(move |by| Ramp::Rotation { node, axis: Vec3::x(), to: by }), 1e-4),
    ]
}

#[test]
fn crossed_rods_in_hard_contact() {
    let mut solver = crossed(hard(1e3), 1e5);
    against_runs("crossed rods, hard", &mut solver, (&of_crossed(), &to_crossed()), &press_crossed, 1e-6);
}

#[test]
fn crossed_rods_under_a_penalty() {
    let mut solver = crossed(Contact { law: ContactLaw::Penalty { stiffness: 0.05 } }, 1e5);
    against_runs("crossed rods, penalty", &mut solver, (&of_crossed(), &to_crossed()), &press_crossed, 1e-6);
}

#[test]
fn crossed_rods_that_shear() {
    let mut solver = crossed(hard(1e3), 3000.0);
    against_runs("crossed rods, sheared", &mut solver, (&of_crossed(), &to_crossed()), &press_crossed, 1e-6);
}

/// A number of an obstacle that a scene gives it.
fn obstacle(which: ObstacleNumber, value: f64, step: f64) -> Varied {
    let ramp = move |by: f64| Ramp::Obstacle { obstacle: 0, which, to: value + by };
    (PrescribedNumber::Obstacle { obstacle: 0, which }, Box::new(ramp), step)
}

/// A curved cantilever, pressed on a post beside it by its load.
fn on_a_post(stiffness: f64) -> Solver {
    let section = Section { bending: [1.0, 1.4], ..Section::isotropic(1.0, 0.8, 1e4, 1e4, 0.02) };
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod =
        Rod::new("rod", &shape, RodMesh::open(14, 3), section, Natural::Uniform { kappa: [0.1, 0.2, 0.3] }).unwrap();
    let post = Obstacle::cylinder("post", [Vec3::new(0.62, 0.0, -0.2), Vec3::y()], (0.1, Side::Outside));
    let hinge = Some(Hinge { through: Vec3::zeros(), axis: Vec3::new(0.1, 1.0, 0.2) });
    let model = Model {
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        loads: vec![NodeLoad { node: common::end_of(&rod), force: Vec3::new(0.4, 0.7, -6.0), moment: Vec3::zeros() }],
        line_loads: vec![LineLoad::of_force(0, Vec3::new(0.0, 0.3, -1.0))],
        contact: hard(stiffness),
        obstacles: vec![Obstacle { hinge, ..post }],
        rods: vec![rod],
        ..Model::default()
    };
    let mut solver = solver(model);
    [0.2, 0.5, 1.0].into_iter().for_each(|to| reach(&mut solver, &[Ramp::Load { to }]));
    solver
}

#[test]
fn cantilever_on_a_post() {
    use ObstacleNumber::{Displacement, Level, Turns};
    // at 10⁵ gaps are 10⁻⁶ radii
    for (stiffness, tolerance) in [(1e3, 1e-6), (1e5, 1e-5)] {
        let mut solver = on_a_post(stiffness);
        let end = common::end_of(&solver.engine().model().rods[0]);
        let of = [
            Observable::Energy,
            Observable::Extension { rod: 0 },
            Observable::Position { node: end, axis: 1 },
            Observable::Reaction { node: NodeRef { rod: 0, node: 0 }, component: 4 },
        ];
        let to = [
            load(1e-3),
            obstacle(Level, 0.1, 2e-5),
            obstacle(Displacement(0), 0.0, 1e-4),
            obstacle(Displacement(2), 0.0, 2e-5),
            obstacle(Turns, 0.0, 1e-5),
            number(0, RodNumber::ContactRadius, 0.02, 1e-5),
            number(0, RodNumber::Bending1, 1.0, 1e-3),
        ];
        let name = format!("cantilever on a post, κε⁴/B = {stiffness:e}");
        against_runs(&name, &mut solver, (&of, &to), &press_by_load, tolerance);
        // its quadrature has 1e-6
        against_runs(&name, &mut solver, (&[Observable::ContactForce], &to[..2]), &press_by_load, 3.0 * tolerance);
    }
}

/// Two rods joined at a right angle, clamped at one end, across a bar near the other.
#[test]
fn joined_rods_across_a_bar() {
    let section = Section::isotropic(1.0, 0.8, 1e4, 1e4, 0.02);
    let rod = |name: &str, start: Vec3, direction: Vec3| {
        let shape = Shape::Line { start, direction, length: 1.0 };
        Rod::new(name, &shape, RodMesh::open(8, 3), section, Natural::Straight).unwrap()
    };
    let (first, second) = (rod("first", Vec3::zeros(), Vec3::x()), rod("second", Vec3::x(), Vec3::y()));
    let last = first.num_nodes() - 1;
    let joint = Joint::rigid(NodeRef { rod: 0, node: last }, NodeRef { rod: 1, node: 0 });
    let node = NodeRef { rod: 0, node: 0 };
    let model = Model {
        supports: vec![Support::clamp(node)],
        joints: vec![joint],
        loads: vec![NodeLoad { node: NodeRef { rod: 1, node: last }, force: Vec3::z() * -2.0, moment: Vec3::zeros() }],
        contact: hard(1e3),
        obstacles: vec![Obstacle::cylinder("bar", [Vec3::new(0.0, 0.6, -0.3), Vec3::x()], (0.1, Side::Outside))],
        rods: vec![first, second],
        ..Model::default()
    };
    let mut solver = solver(model);
    [0.2, 0.5, 1.0].into_iter().for_each(|to| reach(&mut solver, &[Ramp::Load { to }]));
    let of = [
        Observable::Energy,
        Observable::ContactForce,
        Observable::Position { node: NodeRef { rod: 1, node: last / 2 }, axis: 0 },
        Observable::Reaction { node, component: 3 },
    ];
    let name = "joined rods across a bar";
    against_runs(name, &mut solver, (&of, &[load(1e-3)]), &press_by_load, 1e-6);
    // gaps that a run leaves open
    let radius = obstacle(ObstacleNumber::Level, 0.1, 3e-4);
    against_runs(name, &mut solver, (&of, &[radius]), &press_by_load, 2e-5);
}

/// A cantilever rolled up by a dead force on 3000 nodes, EA L²/B = 10⁶: in the sums of its tangent stretch and shear
/// hide bending, so that a response without refinement is 7e-5 off.
#[test]
fn cantilever_on_a_fine_mesh() {
    let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, 0.0);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let natural = Natural::Uniform { kappa: [0.5, 1.0, 2.0] };
    let rod = Rod::new("rod", &shape, RodMesh::open(1000, 3), section, natural).unwrap();
    let node = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
    let model = Model {
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        loads: vec![NodeLoad { node, force: Vec3::new(-1.0, 2.0, 3.0), moment: Vec3::zeros() }],
        contact: Contact::NONE,
        rods: vec![rod],
        ..Model::default()
    };
    let mut solver = solver(model);
    reach(&mut solver, &[Ramp::Load { to: 1.0 }]);
    let of = [Observable::Extension { rod: 0 }, Observable::Position { node, axis: 2 }, Observable::Energy];
    let to = [load(1e-2), number(0, RodNumber::Bending1, 1.0, 1e-2)];
    against_runs("cantilever, 3000 nodes", &mut solver, (&of, &to), &|_| Ramp::Load { to: 1.0 }, 1e-6);
}

/// Height of [`on_a_table`] over the table.
const HEIGHT: f64 = 0.01;

/// A beam, clamped over a table, that its load presses flat on it: a line of contact.
fn on_a_table(contact: Contact) -> Solver {
    let section = Section::isotropic(1.0, 0.8, 1e6, 1e6, 0.02);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 2.0 };
    let rod = Rod::new("rod", &shape, RodMesh::open(80, 3), section, Natural::Straight).unwrap();
    let model = Model {
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        line_loads: vec![LineLoad::of_force(0, Vec3::z() * -20.0)],
        contact,
        obstacles: vec![Obstacle::plane("table", Vec3::z() * -(0.02 + HEIGHT), Vec3::z())],
        rods: vec![rod],
        ..Model::default()
    };
    let mut solver = solver(model);
    [0.5, 1.0].into_iter().for_each(|to| reach(&mut solver, &[Ramp::Load { to }]));
    solver
}

/// Along a line under a penalty.
#[test]
fn beam_on_a_table_under_a_penalty() {
    let mut solver = on_a_table(Contact { law: ContactLaw::Penalty { stiffness: 0.1 } });
    let start = NodeRef { rod: 0, node: 0 };
    let of = [
        Observable::Energy,
        Observable::ContactForce,
        Observable::Position { node: NodeRef { rod: 0, node: 40 }, axis: 2 },
        Observable::Reaction { node: start, component: 4 },
    ];
    let moved = PrescribedNumber::Displacement { node: start, direction: Vec3::z() };
    let to = [
        load(1e-3),
        obstacle(ObstacleNumber::Level, 0.0, 1e-5),
        number(0, RodNumber::ContactRadius, 0.02, 1e-5),
        number(0, RodNumber::Stretching, 1e6, 1e3),
        (moved, Box::new(move |by| Ramp::Displacement { node: start, to: Vec3::z() * by }), 1e-5),
    ];
    against_runs("beam on a table, penalty", &mut solver, (&of, &to), &press_by_load, 1e-6);
}

/// Hard contact at the height H under the load q: the beam lies from ℓ on, qℓ⁴ = 72 BH, and stores E ∝ BH²/ℓ³ ∝ B^(1/4)
/// q^(3/4) H^(5/4): dE/dx = aE/x for these exponents a. Pressures along lines are those of nodes: derivatives are right
/// to the mesh, not to 1e-6.
#[test]
fn beam_on_a_table() {
    let mut solver = on_a_table(hard(1e3));
    let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::Locked).unwrap();
    let to = [
        PrescribedNumber::Load,
        PrescribedNumber::Obstacle { obstacle: 0, which: ObstacleNumber::Level },
        PrescribedNumber::Number { rod: 0, which: vec![RodNumber::Bending1, RodNumber::Bending2] },
    ];
    let energy = tangent.value(&Observable::Energy).unwrap();
    let found = tangent.gradient(&Observable::Energy, &to).unwrap();
    for (name, found, exact) in [
        ("q dE/dq over E", found[0], 0.75 * energy),
        ("−H dE/dlevel over E", -HEIGHT * found[1], 1.25 * energy),
        ("B dE/dB over E", found[2], 0.25 * energy),
    ] {
        verify("beam on a table", name, found / energy, exact / energy, 5e-4);
    }
}

/// A ring of length L about a cylinder that is too large for it, in hard contact all along: its curvature a reference
/// length is 2π/L and its stretch λ = 2πρ/L, so that its energy is ½EA L (λ − 1)² + 2π²B/L, and the contact force 2π EA
/// (λ − 1).
#[test]
fn ring_about_a_cylinder() {
    const STRETCHING: f64 = 1e3;
    let section = Section::isotropic(1.0, 1.0, STRETCHING, STRETCHING, 0.05);
    let shape = Shape::Circle { length: std::f64::consts::TAU, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(48, 3), section, Natural::Straight).unwrap();
    let post = Obstacle::cylinder("post", [Vec3::zeros(), Vec3::z()], (0.94, Side::Outside));
    let model = Model { rods: vec![rod], obstacles: vec![post], contact: hard(1e3), planar: true, ..Model::default() };
    let mut solver = solver(model);
    for to in [0.97, 1.0, 1.03, 1.05] {
        reach(&mut solver, &[Ramp::Obstacle { obstacle: 0, which: ObstacleNumber::Level, to }]);
    }
    let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::Locked).unwrap();
    let to =
        ["length", "stretching", "obstacle_level"].map(|name| PrescribedNumber::parse(tangent.model(), name).unwrap());
    let (stretch, length) = (1.1, std::f64::consts::TAU);
    let of_energy = tangent.gradient(&Observable::Energy, &to).unwrap();
    let by_length = STRETCHING * (0.5 * (stretch - 1.0) * (stretch - 1.0) - (stretch - 1.0) * stretch) - 0.5;
    verify("ring about a cylinder", "dE/dL", of_energy[0], by_length, 1e-3 * by_length.abs());
    let by_stretching = 0.5 * length * (stretch - 1.0) * (stretch - 1.0);
    verify("ring about a cylinder", "dE/dEA", of_energy[1], by_stretching, 2e-3 * by_stretching);
    let by_radius = length * STRETCHING * (stretch - 1.0);
    verify("ring about a cylinder", "dE/dR", of_energy[2], by_radius, 1e-3 * by_radius);
    let of_force = tangent.gradient(&Observable::ContactForce, &to).unwrap();
    verify("ring about a cylinder", "dF/dR", of_force[2], length * STRETCHING, 2e-3 * length * STRETCHING);
    verify("ring about a cylinder", "dF/dL", of_force[0], -STRETCHING * stretch, 2e-3 * STRETCHING * stretch);
}

/// Moments about axes of space where a node turns: at a hinge by anything, at a clamp by its own rotation. The gradient
/// by rotation vectors is symmetric; the rate of a moment is not, by ½ δθ × m.
#[test]
fn moments_at_a_hinge_and_a_clamp() {
    let section = Section { bending: [1.0, 1.4], ..Section::isotropic(1.0, 0.8, 1e3, 1e3, 0.0) };
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod = Rod::new("rod", &shape, RodMesh::open(9, 3), section, Natural::Straight).unwrap();
    let ends = [0, rod.num_nodes() - 1].map(|node| NodeRef { rod: 0, node });
    let hinge = Support { node: ends[0], position: [true; 3], rotation: [true, false, true] };
    let load = NodeLoad { node: NodeRef { rod: 0, node: 13 }, force: Vec3::new(0.5, 2.0, -3.0), moment: Vec3::zeros() };
    for at_start in [Support::clamp(ends[0]), hinge] {
        let model = Model {
            rods: vec![rod.clone()],
            supports: vec![at_start, Support::clamp(ends[1])],
            loads: vec![load],
            contact: Contact::NONE,
            ..Model::default()
        };
        let mut solver = solver(model);
        reach(&mut solver, &[Ramp::Rotation { node: ends[1], axis: Vec3::new(0.2, 1.0, 0.3), to: 0.08 }]);
        let of: Vec<Observable> =
            [3, 5, 2].into_iter().map(|component| Observable::Reaction { node: ends[0], component }).collect();
        let moved = |direction: Vec3| {
            let ramp = move |by: f64| Ramp::Displacement { node: ends[1], to: direction * by };
            let parameter = PrescribedNumber::Displacement { node: ends[1], direction };
            (parameter, Box::new(ramp) as Box<dyn Fn(f64) -> Ramp>, 1e-3)
        };
        let mut to =
            vec![number(0, RodNumber::Bending2, 1.4, 1e-2), moved(Vec3::z()), moved(-Vec3::x()), self::load(1e-2)];
        if at_start == Support::clamp(ends[0]) {
            let axis = Vec3::new(0.3, -0.5, 1.0).normalize();
            let turn = move |by: f64| Ramp::Rotation { node: ends[0], axis, to: by };
            to.push((PrescribedNumber::Rotation { node: ends[0], axis }, Box::new(turn), 1e-3));
        }
        against_runs("moments at a support", &mut solver, (&of, &to), &press_by_load, 1e-5);
    }
}

/// A pressed ring in the plane that one clamp carries: the reaction is the load, and a motion of the clamp moves the
/// whole. (The stiffness of the pressure was missing where nodes are supported.)
#[test]
fn a_pressed_ring_is_carried_by_its_clamp() {
    let section = Section::isotropic(1.0, 1.0, 1e3, 1e3, 0.0);
    let shape = Shape::Circle { length: std::f64::consts::TAU, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(24, 3), section, Natural::Straight).unwrap();
    let [held, loaded, other] = [0, 36, 20].map(|node| NodeRef { rod: 0, node });
    let force = Vec3::new(0.3, 0.5, 0.0);
    let model = Model {
        rods: vec![rod],
        supports: vec![Support::clamp(held)],
        loads: vec![NodeLoad { node: loaded, force, moment: Vec3::zeros() }],
        contact: Contact::NONE,
        planar: true,
        ..Model::default()
    };
    let mut solver = solver(model);
    reach(&mut solver, &[Ramp::Load { to: 1.0 }, Ramp::Pressure { rod: 0, to: 2.0 }]);
    let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap();
    let to = [PrescribedNumber::Load, PrescribedNumber::Displacement { node: held, direction: Vec3::x() }];
    for (component, exact) in [(0, -force.x), (1, -force.y)] {
        let of = Observable::Reaction { node: held, component };
        let found = tangent.gradient(&of, &to).unwrap();
        verify("pressed ring", &format!("d force {component} / d load"), found[0], exact, 1e-8);
        verify("pressed ring", &format!("d force {component} / d displacement"), found[1], 0.0, 1e-6);
    }
    let moved = tangent.gradient(&Observable::Position { node: other, axis: 0 }, &to).unwrap();
    verify("pressed ring", "d position / d displacement", moved[1], 1.0, 1e-8);
}

/// Charges along a ring that grows.
#[test]
fn a_charged_ring_that_grows() {
    let section = Section::isotropic(50.0, 75.0, 1e3, 1e3, 1.0);
    let shape = Shape::Circle { length: 60.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(24, 3), section, Natural::Straight).unwrap();
    let model = Model {
        rods: vec![rod],
        electrostatics: Some(Electrostatics { strength: 4.0, debye_length: 3.0 }),
        ..Model::default()
    };
    let mut solver = solver(model);
    reach(&mut solver, &[Ramp::ExcessLink { rod: 0, to: -1.5 }]);
    let force = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap().value(&Observable::ContactForce);
    assert_eq!(force.unwrap(), 0.0, "charges keep the strands apart");
    let length = number(0, RodNumber::Length, 60.0, 1e-2);
    let press = |_: bool| Ramp::Number { rod: 0, which: RodNumber::Stretching, to: 1e3 };
    let of = [Observable::Energy, Observable::Writhe { rod: 0 }, Observable::SeamMoment { rod: 0 }];
    against_runs("charged ring", &mut solver, (&of, &[length]), &press, 1e-4);
}

/// What no support holds moves by no ramp and bears nothing.
#[test]
fn only_what_is_held_moves_and_bears() {
    let section = Section::isotropic(1.0, 0.8, 1e3, 1e3, 0.0);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod = Rod::new("rod", &shape, RodMesh::open(4, 3), section, Natural::Straight).unwrap();
    let mut model = common::cantilever(rod, Vec3::new(0.0, 0.1, 0.0), Vec3::zeros());
    let end = NodeRef { rod: 0, node: 12 };
    model.supports.push(Support { node: end, position: [false, true, true], rotation: [false; 3] });
    let mut solver = solver(model);
    reach(&mut solver, &[Ramp::Load { to: 1.0 }]);
    let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap();
    let names = ["displacement_x:rod:end", "displacement_y:rod:end", "rotation_y:rod:end", "displacement_z:rod:3"];
    let refused = names.map(|name| {
        let parameter = PrescribedNumber::parse(tangent.model(), name).unwrap();
        tangent.gradient(&Observable::Energy, &[parameter]).is_err()
    });
    assert_eq!(refused, [true, false, true, true]);
    let names = ["force_x:rod:end", "force_y:rod:end", "moment_x:rod:start", "force_z:rod:5"];
    let refused = names.map(|name| {
        let observable = Observable::parse(tangent.model(), name).unwrap();
        tangent.value(&observable).is_err()
    });
    assert_eq!(refused, [true, false, false, true]);
}

/// Natural strains by the rows of a table, in pieces shorter than elements.
#[test]
fn rows_of_a_table() {
    const ROWS: usize = 21;
    let with = |changed: Option<(usize, usize, f64)>| {
        let strains = |k: usize| {
            let wave = (k as f64).sin();
            let mut row = NaturalStrains::from([0.0, 0.01 * wave, 1.0, 0.4 * wave, 0.3, 0.5 - 0.2 * wave]);
            if let Some((_, component, by)) = changed.filter(|(index, _, _)| *index == k) {
                row[component] += by;
            }
            row
        };
        let ends: Vec<f64> = (1..=ROWS).map(|k| k as f64 / ROWS as f64).collect();
        let natural = Natural::Varying(Along::pieces(ends, (0..ROWS).map(strains).collect()).unwrap());
        let section = Section { bending: [1.0, 1.4], ..Section::isotropic(1.0, 0.8, 1e4, 1e4, 0.0) };
        let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
        let rod = Rod::new("rod", &shape, RodMesh::open(9, 3), section, natural).unwrap();
        let mut solver = solver(common::cantilever(rod, Vec3::new(1.0, -2.0, 0.7), Vec3::zeros()));
        [0.0, 0.5, 1.0].into_iter().for_each(|to| reach(&mut solver, &[Ramp::Load { to }]));
        solver
    };
    let of = [
        Observable::Energy,
        Observable::Extension { rod: 0 },
        Observable::Reaction { node: NodeRef { rod: 0, node: 0 }, component: 5 },
    ];
    let mut solver = with(None);
    let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap();
    let found = of.each_ref().map(|of| tangent.gradient_of_table(of, 0).unwrap());
    assert!(found.iter().all(|rows| rows.len() == ROWS));
    for (row, component) in [(0, 3), (7, 4), (8, 5), (13, 1), (20, 4), (10, 2)] {
        let at = |by: f64| {
            let mut solver = with(Some((row, component, by)));
            let mut tangent = EquilibriumTangent::at(&mut solver, ContactResponse::ByLaw).unwrap();
            of.each_ref().map(|of| tangent.value(of).unwrap())
        };
        let step = if component < 3 { 1e-4 } else { 1e-2 };
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(k * step));
        for (i, of) in of.iter().enumerate() {
            let exact = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step);
            verify(
                "rows of a table",
                &format!("d {of:?} / d row {row}, strain {component}"),
                found[i][row][component],
                exact,
                1e-6 * exact.abs().max(1e-2),
            );
        }
    }
}
