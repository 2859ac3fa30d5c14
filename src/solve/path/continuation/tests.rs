use super::*;
use crate::math::Vec3;
use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
use crate::scene::{Contact, LineLoad, Model, NodeLoad, NodeRef, Support};
use crate::solve::Options;
use crate::solve::problem::state::PrescribedValue;

/// A bent, twisted cantilever with loads, its last node held.
fn open_rod() -> Solver {
    let section = Section { bending: [1.0, 1.3], ..Section::isotropic(1.0, 1.5, 900.0, 700.0, 0.0) };
    let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 2.0 };
    let rod = Rod::new("rod", &line, RodMesh::open(4, 3), section, Natural::Straight).unwrap();
    let ends = [0, rod.num_nodes() - 1].map(|node| NodeRef { rod: 0, node });
    let middle = NodeRef { rod: 0, node: 6 };
    let model = Model {
        supports: ends.map(Support::clamp).to_vec(),
        loads: vec![NodeLoad { node: middle, force: Vec3::new(1.0, -2.0, 0.5), moment: Vec3::zeros() }],
        line_loads: vec![LineLoad::of_force(0, Vec3::new(0.1, 0.2, 0.3))],
        contact: Contact::NONE,
        rods: vec![rod],
        ..Model::default()
    };
    Solver::new(model, Options::default()).unwrap()
}

fn ring(planar: bool) -> Solver {
    let section = Section::isotropic(1.0, 1.5, 900.0, 700.0, 0.0);
    let circle = Shape::Circle { length: 2.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &circle, RodMesh::closed(4, 3), section, Natural::Straight).unwrap();
    let model = Model { contact: Contact::NONE, rods: vec![rod], planar, ..Model::default() };
    Solver::new(model, Options::default()).unwrap()
}

/// Off every symmetry, supports left where they are.
fn disturb(solver: &mut Solver) {
    let free: Vec<bool> = solver.engine.free.iter().flatten().copied().collect();
    let field: Vec<f64> =
        free.iter().enumerate().map(|(i, f)| if *f { 0.05 * (1.0 + 1.7 * i as f64).sin() } else { 0.0 }).collect();
    let state = solver.engine.retract(solver.engine.state(), &field, 1.0);
    solver.engine.take_state(state);
    solver.engine.prescribe([PrescribedValue::Load(0.7)]);
}

/// ∂gradient/∂parameter of every kind of ramp against central differences.
#[test]
fn rates_match_finite_differences() {
    let last = NodeRef { rod: 0, node: 12 };
    let cases = [
        (open_rod(), Ramp::Load { to: 3.0 }),
        (open_rod(), Ramp::Displacement { node: last, to: Vec3::new(0.3, -0.2, 0.4) }),
        (open_rod(), Ramp::Rotation { node: last, axis: Vec3::new(1.0, 2.0, -0.5), to: 0.4 }),
        (ring(false), Ramp::ExcessLink { rod: 0, to: 2.0 }),
        (ring(true), Ramp::Pressure { rod: 0, to: 2.0 }),
    ];
    for (mut solver, ramp) in cases {
        disturb(&mut solver);
        let seam = solver.engine.state().seams()[0] + if solver.engine.model.planar { 0.0 } else { 0.4 };
        solver.engine.prescribe([PrescribedValue::Seam(0, seam)]);
        let parameter = Parameter::new(&solver, &ramp).unwrap();
        let state = solver.engine.state().clone();
        solver.workspace.refresh(&mut solver.engine, &state).unwrap();
        let stress = solver.engine.actual_stress(&state);
        solver.workspace.linearise(&solver.engine, &state, &stress, &parameter.drive());
        let rate = parameter.rate(&solver.engine, &state, &stress, &solver.workspace.tangent.drive);
        let gradient = |by: f64| {
            let mut field = vec![0.0; rate.len()];
            for (node, displacement, rotation) in parameter.drive().nodes {
                (0..3).for_each(|k| field[6 * node + k] = by * displacement[k]);
                (0..3).for_each(|k| field[6 * node + 3 + k] = by * rotation[k]);
            }
            let mut moved = solver.engine.retract(&state, &field, 1.0);
            parameter.advance(&mut moved, by);
            solver.engine.residual(&moved).gradient
        };
        let h = 1e-4;
        let [a, b, c, d] = [2.0 * h, h, -h, -2.0 * h].map(gradient);
        let largest = rate.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        assert!(largest > 0.0, "{ramp:?}");
        for i in (0..rate.len()).filter(|i| solver.engine.free[i / 6][i % 6]) {
            let difference = (8.0 * (b[i] - c[i]) - (a[i] - d[i])) / (12.0 * h);
            assert!((difference - rate[i]).abs() < 1e-7 * largest, "{ramp:?}, {i}: {difference} {}", rate[i]);
        }
    }
}

/// Stresses predicted along a step with a turn of the seam are those of the moved state to second order.
#[test]
fn predicted_stress_knows_of_the_seam() {
    let mut solver = ring(false);
    disturb(&mut solver);
    let parameter = Parameter::new(&solver, &Ramp::ExcessLink { rod: 0, to: 2.0 }).unwrap();
    let state = solver.engine.state().clone();
    let error = |h: f64| {
        let field: Vec<f64> = (0..6 * solver.engine.num_nodes()).map(|i| h * (0.3 * i as f64).cos()).collect();
        let predicted = parameter.predicted_stress(&solver.engine, &state, &field, h);
        let mut moved = solver.engine.retract(&state, &field, 1.0);
        parameter.advance(&mut moved, h);
        let actual = solver.engine.actual_stress(&moved);
        let pairs = predicted.iter().flatten().flatten().zip(actual.iter().flatten().flatten());
        pairs.map(|(p, a)| (p - a).abs()).fold(0.0, f64::max)
    };
    let ratio = error(1e-3) / error(5e-4);
    assert!((ratio - 4.0).abs() < 0.1, "{ratio}");
}

#[test]
fn bad_input_is_refused() {
    let mut observer = |_: &PathPoint| ControlFlow::Continue(());
    let mut follow =
        |ramp: Ramp, options: FollowOptions| open_rod().follow(&ramp, &options, &mut observer).unwrap_err().to_string();
    let load = |to: f64| Ramp::Load { to };
    assert!(follow(load(0.0), FollowOptions::default()).contains("ramp.to"));
    assert!(follow(load(f64::NAN), FollowOptions::default()).contains("load"));
    assert!(follow(load(1.0), FollowOptions { step: f64::NAN, ..Default::default() }).contains("follow.step"));
    assert!(follow(load(1.0), FollowOptions { max_step: 0.01, ..Default::default() }).contains("follow.max_step"));
    assert!(follow(load(1.0), FollowOptions { max_points: 0, ..Default::default() }).contains("follow.max_points"));
    assert!(follow(Ramp::ExcessLink { rod: 0, to: 1.0 }, FollowOptions::default()).contains("is open"));
}

/// The target is met exactly, ramps know where they are, and the way back ends where it began.
#[test]
fn there_and_back() {
    let mut solver = open_rod();
    let node = NodeRef { rod: 0, node: 12 };
    let start = solver.engine.state().clone();
    for to in [Vec3::new(-0.6, 0.3, 0.1), Vec3::zeros()] {
        let ramp = Ramp::Displacement { node, to };
        let report = solver.follow(&ramp, &FollowOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(report.end, PathEnd::Target, "{report:?}");
        assert!((solver.moved.displaced[&12] - to).norm() < 1e-15);
        assert!((solver.engine.state().positions()[12] - (Vec3::x() * 2.0 + to)).norm() < 1e-12);
    }
    let pairs = solver.engine.state().positions().iter().zip(start.positions());
    assert!(pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) < 1e-9);
}

/// A path from no equilibrium that Newton can find is a status.
#[test]
fn no_start_is_a_status() {
    let mut solver = open_rod();
    disturb(&mut solver);
    solver.engine.prescribe([PrescribedValue::Load(1e9)]);
    let report =
        solver.follow(&Ramp::Load { to: 2e9 }, &FollowOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(matches!(report.end, PathEnd::NoStart | PathEnd::BrokeDown), "{report:?}");
    assert_eq!(report.num_points, 0);
}
