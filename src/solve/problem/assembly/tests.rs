//! The whole problem: derivatives against differences, and far from the origin.

use super::*;
use crate::math::Vec3;
use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
use crate::scene::{
    Contact, ContactLaw, Electrostatics, LineLoad, Model, NodeLoad, NodeRef, Obstacle, ObstaclePose, Side, Skeleton,
};
use crate::solve::problem::moment_load::work_of_moments;

/// Two free rings that overlap, with dead loads and pressure, moved off every symmetry.
fn engine() -> Engine {
    engine_with(None)
}

fn engine_with(electrostatics: Option<Electrostatics>) -> Engine {
    let section = Section { bending: [1.0, 1.3], ..Section::isotropic(1.0, 1.5, 900.0, 700.0, 0.06) };
    let ring = |name: &str, center: Vec3, normal: Vec3| {
        let shape = Shape::Circle { length: 2.0, center, normal };
        Rod::new(name, &shape, RodMesh::closed(8, 3), section, Natural::Straight).unwrap()
    };
    let rods = vec![ring("a", Vec3::zeros(), Vec3::z()), ring("b", Vec3::new(0.55, 0.0, 0.02), Vec3::y())];
    let law = ContactLaw::Penalty { stiffness: 0.5 };
    let model = Model { rods, contact: Contact { law }, electrostatics, ..Model::default() };
    let mut engine = Engine::new(model, None).unwrap();
    // loads and pressure belong to supported or planar scenes; here only their derivatives are of interest
    let node = NodeRef { rod: 0, node: 5 };
    engine.model.loads.push(NodeLoad { node, force: Vec3::new(1.0, -2.0, 0.5), moment: Vec3::zeros() });
    engine.model.line_loads.push(LineLoad::of_force(1, Vec3::new(0.3, 0.2, -0.4)));
    engine.state.load_factor = 0.7;
    engine.state.pressures[0] = 1.1;
    engine.state.seams[0] = 0.4;
    let direction = direction(engine.num_nodes(), 3.0);
    engine.state = engine.retract(&engine.state, &direction, 0.003);
    engine
}

fn direction(num_nodes: usize, phase: f64) -> Vec<f64> {
    (0..6 * num_nodes).map(|i| (phase + 1.7 * i as f64 + 0.3 * (i * i % 17) as f64).sin()).collect()
}

fn at(engine: &mut Engine, state: &State) -> Residual {
    engine.update_contact(state).unwrap();
    engine.residual(state)
}

/// Symptom: rods that reach 10⁵ node spacings from the origin converged no nearer than a relative residual of 1e-8.
/// Mechanism: a unit in the last place of a position is a stretch of the elements beside it and an overlap of strands.
#[test]
fn far_from_the_origin_forces_are_the_same() {
    let mut engine = engine();
    // loads only know where the origin is
    engine.model.loads.clear();
    engine.model.line_loads.clear();
    engine.state.load_factor = 0.0;
    engine.state.pressures[0] = 0.0;
    let state = engine.state.clone();
    let here = at(&mut engine, &state);
    let shift = Vec3::new(1e6, -0.4e6, 0.7e6);
    let by: Vec<f64> = (0..6 * engine.num_nodes()).map(|i| if i % 6 < 3 { shift[i % 6] } else { 0.0 }).collect();
    let far = state.moved(&by, 1.0);
    // motions far below the resolution of the coordinates are kept
    let small: Vec<f64> = direction(engine.num_nodes(), 0.2).iter().map(|x| 1e-13 * x).collect();
    let moved = far.moved(&small, 1.0).increment_since(&far);
    for node in 0..engine.num_nodes() {
        (6 * node..6 * node + 3).for_each(|i| assert!((moved[i] - small[i]).abs() < 1e-20));
    }
    let there = at(&mut engine, &far);
    let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    let largest = here.magnitude.iter().copied().fold(0.0, f64::max);
    let pressed = here.contact_gradient.iter().map(|x| x.abs()).fold(0.0, f64::max);
    assert!(pressed > 1e-3 * largest, "{pressed} {largest}");
    assert!(difference(&here.gradient, &there.gradient) < 1e-13 * largest);
    assert!(difference(&here.contact_gradient, &there.contact_gradient) < 1e-12 * pressed);
}

/// What counts as rounding of the potential is some times its scatter between states that are next to the same. With
/// 10⁻¹¹ of the energy, far more than that, searches did not see what they gained along soft slides, and went to and
/// fro.
#[test]
fn rounding_of_the_potential_is_its_scatter() {
    for mut engine in [engine(), engine_on_planes()] {
        let (state, by) = (engine.state.clone(), direction(engine.num_nodes(), 0.7));
        let rounding = at(&mut engine, &state).rounding;
        let moved = |k: usize| at(&mut engine, &state.moved(&by, 1e-14 * k as f64)).potential.total();
        let potentials: Vec<f64> = (0..60).map(moved).collect();
        // second differences have no part of the slope, and six times the variance
        let squares: Vec<f64> = potentials.windows(3).map(|u| (u[0] - 2.0 * u[1] + u[2]).powi(2) / 6.0).collect();
        let scatter = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        assert!(3.0 * scatter < rounding && rounding < 500.0 * scatter, "{rounding:e} {scatter:e}");
    }
}

#[test]
fn gradient_and_tangent_of_the_whole_problem_match_finite_differences() {
    check_derivatives(engine());
}

/// The rings with sections tilted against their centrelines, which contact lies along.
#[test]
fn gradient_and_tangent_of_sheared_rods_match_finite_differences() {
    let mut engine = engine();
    let tilt = crate::math::quaternion::exp(&Vec3::new(0.2, -0.1, 0.3));
    engine.state.frames.iter_mut().for_each(|frame| *frame *= tilt);
    engine.take_tangents();
    assert!(engine.contact.tangents.are_sheared());
    check_derivatives(engine);
}

/// The rings with charges: they feel each other, and themselves.
#[test]
fn gradient_and_tangent_with_charges_match_finite_differences() {
    // range of .3: the rings have a circumference of 2
    let mut engine = engine_with(Some(Electrostatics { strength: 200.0, debye_length: 0.03 }));
    let state = engine.state.clone();
    let potential = at(&mut engine, &state).potential;
    assert!(potential.electrostatic > 0.05 * potential.total(), "{potential:?}");
    check_derivatives(engine);
}

/// The rings under moments, whose work along a step counts as a potential does.
#[test]
fn gradient_and_tangent_under_moments_match_finite_differences() {
    let mut engine = engine();
    let node = NodeRef { rod: 1, node: 11 };
    engine.model.loads.push(NodeLoad { node, force: Vec3::zeros(), moment: Vec3::new(4.0, -3.0, 2.0) });
    let along = LineLoad { moment: Vec3::new(-1.0, 5.0, 3.0), ..LineLoad::of_force(0, Vec3::zeros()) };
    engine.model.line_loads.push(along);
    check_derivatives(engine);
}

/// The rings with planes that have been moved into them, under offsets that vary along the rods.
fn engine_on_planes() -> Engine {
    let Engine { mut model, state, .. } = engine();
    let plane = |name: &str, normal: Vec3, distance: f64| {
        let normal = normal.normalize();
        Obstacle::plane(name, normal * -distance + normal.cross(&Vec3::y()), normal)
    };
    model.obstacles =
        vec![plane("below", Vec3::new(0.6, 0.1, 0.8), 1.0), plane("beside", Vec3::new(-0.8, 0.3, 0.1), 2.0)];
    let at = |level: f64| ObstaclePose { level, ..ObstaclePose::default() };
    touching(model, State { placements: vec![at(0.78), at(1.15)], load_factor: 0.0, ..state })
}

/// An engine in a state, under offsets towards obstacles that vary along the rods.
fn touching(mut model: Model, state: State) -> Engine {
    model.loads.clear();
    model.line_loads.clear();
    let mut engine = Engine::new(model, None).unwrap();
    engine.state = state;
    let side = &mut engine.contact;
    let offset = |k: usize| if k < side.offsets.num_nodes() { 0.0 } else { 0.012 + 0.009 * (0.9 * k as f64).sin() };
    side.offsets = side.offsets.map(|k, _| offset(k));
    engine
}

/// The same with a tube, a ball, a post and a cavity, as `radii` say how much they have been blown up or tightened.
fn engine_among_bodies(inside: bool) -> Engine {
    let Engine { mut model, state, .. } = engine();
    let points = || state.positions.iter();
    let centre = points().sum::<Vec3>() / state.positions.len() as f64;
    let axis = Vec3::new(0.5, -0.3, 0.8);
    let e = axis.normalize();
    let across = |x: &Vec3, from: &Vec3| ((x - from) - e * e.dot(&(x - from))).norm();
    let far = |from: &Vec3| points().map(|x| (x - from).norm()).fold(0.0, f64::max);
    let near = |from: &Vec3| points().map(|x| (x - from).norm()).fold(f64::INFINITY, f64::min);
    let beside = centre + e.cross(&Vec3::y()) * (2.0 * far(&centre));
    let (cylinder, sphere, levels) = if inside {
        let level = points().map(|x| across(x, &centre)).fold(0.0, f64::max);
        let of = (10.0 * level, Side::Inside);
        (Obstacle::cylinder("tube", [centre, axis], of), Obstacle::sphere("cavity", centre, of), [level, far(&centre)])
    } else {
        let level = points().map(|x| across(x, &beside)).fold(f64::INFINITY, f64::min);
        let of = (0.1 * level, Side::Outside);
        let levels = [level, near(&beside)];
        (Obstacle::cylinder("post", [beside, axis], of), Obstacle::sphere("ball", beside, of), levels)
    };
    model.obstacles = vec![cylinder, sphere];
    let at = |level: f64| ObstaclePose { level, ..ObstaclePose::default() };
    touching(model, State { placements: levels.map(at).to_vec(), load_factor: 0.0, ..state })
}

#[test]
fn gradient_and_tangent_at_curved_surfaces_match_finite_differences() {
    for inside in [true, false] {
        let mut engine = engine_among_bodies(inside);
        let state = engine.state.clone();
        let residual = at(&mut engine, &state);
        let touched = |k: usize| residual.surface_contacts.iter().filter(|contact| contact.surface == k).count();
        assert!(touched(0) >= 2 && touched(1) >= 2, "{inside} {} {}", touched(0), touched(1));
        check_derivatives(engine);
    }
}

/// The rings, each with a body that a node of it carries, and that the other one touches: a bead, or a capsule along an
/// axis.
fn engine_with_bodies(piece: Option<(f64, Option<f64>)>) -> Engine {
    let Engine { mut model, mut state, .. } = engine();
    let [own, other] = [NodeRef { rod: 0, node: 2 }, NodeRef { rod: 1, node: 14 }];
    let body = |name: &str, at: NodeRef| {
        let bead = Obstacle::bead(name, &model.rods, at, 1e-3);
        let point = bead.skeleton.point();
        // off the plane of the ring, and out of it
        let out = point - model.rods[at.rod].positions.iter().sum::<Vec3>() / model.rods[at.rod].num_nodes() as f64;
        let normal = if at.rod == 0 { Vec3::z() } else { Vec3::y() };
        let of_piece = |(slant, length): (f64, _)| {
            let axis = (out.normalize() + normal * slant).normalize();
            Skeleton::Piece { point, axis, length }
        };
        Obstacle { skeleton: piece.map_or(bead.skeleton, of_piece), ..bead }
    };
    model.obstacles = vec![body("on a", own), body("on b", other)];
    state.placements = model.obstacles.iter().map(Obstacle::start).collect();
    state.load_factor = 0.0;
    let mut engine = touching(model, state);
    let state = engine.state.clone();
    // each as large as reaches the other ring's centreline less its radius
    for (k, nodes) in [engine.nodes(1), engine.nodes(0)].into_iter().enumerate() {
        let surface = engine.contact.surface_in(&state, k);
        let distance = |n: usize| surface.distance(&(state.positions[n] - surface.point())) + surface.level;
        engine.state.placements[k].level = nodes.map(distance).fold(f64::INFINITY, f64::min) - 0.055;
    }
    engine
}

/// Bodies that move and turn with free nodes: spheres, and capsules touched beside, at an end, and where both meet.
#[test]
fn gradient_and_tangent_at_carried_bodies_match_finite_differences() {
    let cases = [
        None,
        Some((0.5, None)),
        Some((-2.0, None)),
        Some((0.8, Some(0.05))),
        Some((-0.7, Some(0.2))),
        Some((3.0, Some(0.3))),
    ];
    for piece in cases {
        let mut engine = engine_with_bodies(piece);
        let state = engine.state.clone();
        let residual = at(&mut engine, &state);
        let touched = |k: usize| residual.surface_contacts.iter().filter(|contact| contact.surface == k).count();
        assert!(touched(0) >= 2 && touched(1) >= 2, "{piece:?} {} {}", touched(0), touched(1));
        check_contact_slope(&mut engine, &residual);
        check_derivatives(engine);
    }
}

/// What the motion of a body, its turns included, does to gaps beyond its linear part is of second order.
#[test]
fn second_order_forces_at_carried_bodies_grow_with_the_square() {
    for piece in [None, Some((0.5, None)), Some((0.8, Some(0.05)))] {
        let mut engine = engine_with_bodies(piece);
        let state = engine.state.clone();
        let v = direction(engine.num_nodes(), 0.5);
        let mut missed = |by: f64| {
            let increment: Vec<f64> = v.iter().map(|v| v * by).collect();
            second_order_at_surfaces(&mut engine, &state, &increment)
        };
        let [half, whole] = [missed(1e-4), missed(2e-4)];
        assert!(half > 1e-12 && (whole / half - 4.0).abs() < 0.2, "{piece:?} {half} {whole}");
    }
}

/// What a motion does to gaps beyond its linear part is of second order in it, sliding round a surface included.
#[test]
fn second_order_forces_at_curved_surfaces_grow_with_the_square() {
    for inside in [true, false] {
        let mut engine = engine_among_bodies(inside);
        let state = engine.state.clone();
        let v = direction(engine.num_nodes(), 0.5);
        let mut missed = |by: f64| {
            let increment: Vec<f64> = v.iter().map(|v| v * by).collect();
            second_order_at_surfaces(&mut engine, &state, &increment)
        };
        let [half, whole] = [missed(1e-4), missed(2e-4)];
        assert!(half > 1e-12 && (whole / half - 4.0).abs() < 0.2, "{inside} {half} {whole}");
    }
}

/// Size of the second-order forces of contact with obstacles alone; strands have tests of their own.
fn second_order_at_surfaces(engine: &mut Engine, state: &State, increment: &[f64]) -> f64 {
    engine.update_contact(state).unwrap();
    let pattern = engine.node_graph().natural();
    let still = PrescribedMotion::default();
    let mut here = engine.linearise(state, None, &still, (&pattern, &mut Tangent::default()));
    here.contact_pairs.clear();
    let there = state.moved(increment, 1.0);
    engine.update_contact(&there).unwrap();
    let mut after = engine.residual_of_trial(&there);
    after.contact_pairs.clear();
    let mut forces = vec![0.0; increment.len()];
    engine.add_contact_second_order((state, increment), &here, &after, &mut forces);
    forces.iter().map(|f| f * f).sum::<f64>().sqrt()
}

#[test]
fn gradient_and_tangent_on_planes_match_finite_differences() {
    let mut engine = engine_on_planes();
    let state = engine.state.clone();
    let residual = at(&mut engine, &state);
    let touched = |plane: usize| residual.surface_contacts.iter().filter(|contact| contact.surface == plane).count();
    assert!(touched(0) >= 3 && touched(1) >= 3, "{} {}", touched(0), touched(1));
    check_contact_slope(&mut engine, &residual);
    check_derivatives(engine);
}

/// Contact alone: its gradient is the slope of its energy.
fn check_contact_slope(engine: &mut Engine, residual: &Residual) {
    let state = engine.state.clone();
    let v = direction(engine.num_nodes(), 0.5);
    let energy = |engine: &mut Engine, h: f64| at(engine, &state.moved(&v, h)).potential.contact;
    let h = 1e-6;
    let slope = (8.0 * (energy(engine, h) - energy(engine, -h)) - (energy(engine, 2.0 * h) - energy(engine, -2.0 * h)))
        / (12.0 * h);
    let ours: f64 = residual.contact_gradient.iter().zip(&v).map(|(g, v)| g * v).sum();
    assert!((slope - ours).abs() < 1e-7 * ours.abs(), "{slope} {ours}");
}

/// A motion along the planes is predicted exactly; what a rotation of handles adds beyond its linear part is not, and
/// its forces are κ times the difference of gaps.
#[test]
fn planes_are_surprised_by_turning_handles_only() {
    let mut engine = engine_on_planes();
    let state = engine.state.clone();
    let mut missed = |increment: &[f64]| second_order_at_surfaces(&mut engine, &state, increment);
    let count = state.positions.len();
    let along: Vec<f64> = (0..6 * count).map(|i| if i % 6 < 3 { [3e-6, -2e-6, 1e-6][i % 6] } else { 0.0 }).collect();
    assert!(missed(&along) < 1e-9, "{}", missed(&along));
    let turned = |by: f64| -> Vec<f64> { (0..6 * count).map(|i| if i % 6 == 4 { by } else { 0.0 }).collect() };
    let [half, whole] = [missed(&turned(1e-4)), missed(&turned(2e-4))];
    assert!(half > 1e-9 && (whole / half - 4.0).abs() < 0.05, "{half} {whole}");
}

fn check_derivatives(mut engine: Engine) {
    let state = engine.state.clone();
    let residual = at(&mut engine, &state);
    assert!(residual.potential.contact > 0.0, "the case must have contact");
    engine.update_contact(&state).unwrap();
    let pattern = engine.node_graph().natural();
    let mut tangent = Tangent::default();
    engine.linearise(&state, None, &PrescribedMotion::default(), (&pattern, &mut tangent));
    let v = direction(engine.num_nodes(), 0.5);
    let w = direction(engine.num_nodes(), 8.1);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let potential = |engine: &mut Engine, a: f64, b: f64| {
        let step: Vec<f64> = v.iter().zip(&w).map(|(v, w)| a * v + b * w).collect();
        at(engine, &state.moved(&step, 1.0)).potential.total() - work_of_moments(engine, &step)
    };
    let h = 1e-6;
    let slope = (8.0 * (potential(&mut engine, h, 0.0) - potential(&mut engine, -h, 0.0))
        - (potential(&mut engine, 2.0 * h, 0.0) - potential(&mut engine, -2.0 * h, 0.0)))
        / (12.0 * h);
    let ours = dot(&residual.gradient, &v);
    assert!((slope - ours).abs() < 1e-7 * ours.abs(), "{slope} {ours}");
    // all unknowns are free and numbered in order: the pattern's product needs no mapping
    let ours = dot(&w, &pattern.multiply(&tangent.values, &v));
    let h = 1e-5;
    let second = |engine: &mut Engine, h: f64| {
        (potential(engine, h, h) - potential(engine, h, -h) - potential(engine, -h, h) + potential(engine, -h, -h))
            / (4.0 * h * h)
    };
    let difference = (4.0 * second(&mut engine, h) - second(&mut engine, 2.0 * h)) / 3.0;
    assert!((difference - ours).abs() < 1e-4 * ours.abs().max(1e3), "{difference} {ours}");
}
