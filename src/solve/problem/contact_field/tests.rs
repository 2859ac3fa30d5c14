use super::*;
use crate::math::Vec3;
use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
use crate::scene::{Contact, ContactLaw, LineLoad, Model, NodeRef, Ramp, Support};
use crate::solve::problem::contact_gaps::joined;
use crate::solve::{Options, Solver, Status};

fn entry(node: u32, curve: u32, arc: [f64; 2]) -> Entry {
    Entry { node, curve, arc }
}

/// A closed and an open strand, ten segments of length 1 each.
fn strands() -> CurveSet {
    let points: Vec<Vec3> = (0..=10).map(|k| Vec3::x() * f64::from(k)).collect();
    let mut set = CurveSet::from_polylines(&[(&points[..10], 0.1, true), (&points[..], 0.1, false)]).unwrap();
    set.set_lengths(&[1.0; 20]);
    set
}

#[test]
fn places_that_meet_are_one() {
    let set = strands();
    let places = [
        entry(3, 0, [9.7, 9.9]), // goes on over the seam in the next
        entry(3, 0, [0.1, 0.2]),
        entry(3, 0, [4.0, 5.0]),
        entry(3, 0, [5.4, 5.5]), // within .5 of the one before, on either side
        entry(3, 0, [3.6, 3.7]),
        entry(3, 1, [4.0, 5.0]), // another strand
        entry(4, 1, [9.7, 9.9]), // an open strand has no seam
        entry(4, 1, [0.1, 0.2]),
        entry(5, 1, [1.0, 1.1]),
    ];
    let found = joined(&set, places.iter().rev().map(|e| (*e, 0.5)).collect());
    let near = |e: &Entry, node: u32, curve: u32, arc: [f64; 2]| {
        let apart = set.period(curve as usize).map_or(e.arc[0] - arc[0], |p| (e.arc[0] - arc[0]).rem_euclid(p));
        e.node == node
            && e.curve == curve
            && apart.abs() < 1e-12
            && (e.arc[1] - e.arc[0] - (arc[1] - arc[0])).abs() < 1e-12
    };
    let expected = [
        (3, 0, [9.7, 10.2]),
        (3, 0, [3.6, 5.5]),
        (3, 1, [4.0, 5.0]),
        (4, 1, [0.1, 0.2]),
        (4, 1, [9.7, 9.9]),
        (5, 1, [1.0, 1.1]),
    ];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (node, curve, arc) in expected {
        assert!(found.iter().any(|e| near(e, node, curve, arc)), "{node} {curve} {arc:?}: {found:?}");
    }
}

/// A segment has the number of the entry nearest along its curve, over the seam too; of what a node does not touch the
/// node's own.
#[test]
fn segments_belong_to_the_nearest_place() {
    let set = strands();
    let entries = vec![entry(1, 0, [9.5, 10.5]), entry(1, 0, [4.0, 5.0])];
    let numbers = ContactField { num_nodes: 3, num_surfaces: 0, values: vec![0.1, 0.2, 0.3, 7.0, 8.0], entries };
    let of = |node: usize, segment: usize| numbers.at(&set, node, segment);
    let expected = [7.0, 7.0, 8.0, 8.0, 8.0, 8.0, 8.0, 7.0, 7.0, 7.0];
    for (segment, expected) in expected.into_iter().enumerate() {
        // segments 2 and 7 start or end half way between the two
        if segment != 2 && segment != 7 {
            assert_eq!(of(1, segment), expected, "{segment}");
        }
        assert_eq!((of(0, segment), of(2, segment), of(1, 10 + segment)), (0.1, 0.3, 0.2));
    }
    assert_eq!(numbers.per_node(f64::max), [0.1, 8.0, 0.3]);
    assert!(numbers.fits([3, 0], &set) && !numbers.fits([4, 0], &set) && !numbers.fits([3, 1], &set));
    let elsewhere = ContactField { entries: vec![entry(1, 2, [0.0, 1.0]), entry(1, 0, [4.0, 5.0])], ..numbers.clone() };
    assert!(!elsewhere.fits([3, 0], &set));
    assert!(!ContactField { values: vec![0.0; 4], ..numbers.clone() }.fits([3, 0], &set));

    // where places come and go: new ones start from what held there, nodes that have one again take the largest
    let moved = ContactField { entries: vec![entry(1, 0, [5.5, 5.6]), entry(2, 0, [3.0, 3.1])], ..numbers.clone() };
    assert_eq!(numbers.at_places_of(&set, &moved).values, [0.1, 0.0, 0.0, 8.0, 0.3]);
    assert_eq!(numbers.at_places_of(&set, &ContactField::uniform(3, 0, 0.0)).values, [0.1, 8.0, 0.3]);

    // twice the nodes: the same there, means between
    let fine = numbers.interleaved(&set, &[([0, 0], 0.0), ([0, 1], 0.5), ([1, 1], 0.0), ([1, 2], 0.5), ([2, 2], 0.0)]);
    assert!(fine.fits([5, 0], &set));
    for segment in [0, 4, 12] {
        let [a, b, c] = [0, 1, 2].map(|node| of(node, segment));
        let expected = [a, 0.5 * (a + b), b, 0.5 * (b + c), c];
        for (node, expected) in expected.into_iter().enumerate() {
            assert!((fine.at(&set, node, segment) - expected).abs() < 1e-15, "{node} {segment}");
        }
    }
}

/// Numbers towards planes stay with their nodes and planes, wherever places on strands come and go.
#[test]
fn planes_have_numbers_of_their_own() {
    let set = strands();
    let values = vec![0.1, 0.2, 0.3, 1.0, 2.0, 3.0, -1.0, -2.0, -3.0, 7.0];
    let numbers = ContactField { num_nodes: 3, num_surfaces: 2, values, entries: vec![entry(1, 0, [4.0, 5.0])] };
    assert!(numbers.fits([3, 2], &set) && !numbers.fits([3, 1], &set));
    assert_eq!(
        (numbers.values[numbers.index_of_surface(2, 0)], numbers.values[numbers.index_of_surface(0, 1)]),
        (3.0, -1.0)
    );
    assert_eq!(numbers.at(&set, 1, 4), 7.0);
    assert_eq!(numbers.per_node(f64::max), [1.0, 7.0, 3.0]);
    let moved = ContactField { entries: vec![entry(2, 0, [3.0, 3.1])], ..numbers.clone() };
    assert_eq!(numbers.at_places_of(&set, &moved).values, [0.1, 7.0, 0.0, 1.0, 2.0, 3.0, -1.0, -2.0, -3.0, 0.3]);
    let fine = numbers.interleaved(&set, &[([0, 0], 0.0), ([0, 1], 0.5), ([1, 1], 0.0), ([1, 2], 0.5), ([2, 2], 0.0)]);
    assert!(fine.fits([5, 2], &set));
    assert_eq!(fine.values[5..15], [1.0, 1.5, 2.0, 2.5, 3.0, -1.0, -1.5, -2.0, -2.5, -3.0]);
    assert_eq!(ContactField::of_nodes(&[1.0, 2.0], 1).values, [1.0, 2.0, 1.0, 2.0]);
}

/// Three beams, the middle one pressed on the lower one by the upper one.
fn beams() -> Solver {
    let section = Section::isotropic(1.0, 1.0, 1e2, 1e5, 0.05);
    let beam = |k: i32| {
        let shape = Shape::Line { start: Vec3::y() * (0.1005 * f64::from(k)), direction: Vec3::x(), length: 1.0 };
        Rod::new("beam", &shape, RodMesh::open(12, 3), section, Natural::Straight).unwrap()
    };
    let rods: Vec<Rod> = (0..3).map(beam).collect();
    let ends = (0..3).flat_map(|rod| [0, 36].map(|node| Support::clamp(NodeRef { rod, node })));
    let law = ContactLaw::AugmentedLagrangian { stiffness: 1.0, tol_penetration: 1e-9 };
    let line_loads = vec![LineLoad::of_force(2, Vec3::y() * -0.768)];
    let model = Model { rods, supports: ends.collect(), line_loads, contact: Contact { law }, ..Model::default() };
    Solver::new(model, Options::default()).unwrap()
}

/// With offsets that differ from contact to contact, forces are the slope of the energy and the tangent is theirs,
/// along motions of all nodes: to the order of the differences, since nothing jumps.
#[test]
fn forces_are_the_slope_of_the_energy() {
    let mut solver = beams();
    assert_eq!(solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap().status, Status::Converged);
    let middle = solver.engine.first_node[1] + 18;
    let side = &solver.engine.contact;
    let own: Vec<f64> = side.offsets.entries_of(middle).map(|k| side.offsets.values[37 * 3 + k]).collect();
    assert!(own.len() == 2 && own[1] > 1.1 * own[0] && own[0] > 0.0, "{own:?}");
    let state = solver.engine.state.clone();
    let mut random = crate::math::random::Random(5);
    for _ in 0..5 {
        let way: Vec<f64> = (0..6 * 111).map(|_| 0.5 * random.unit()).collect();
        let mut at = |t: f64| {
            let there = state.moved(&way, t);
            solver.engine.update_contact(&there).unwrap();
            let residual = solver.engine.residual(&there);
            let works: Vec<f64> = residual.contact_gradient.iter().zip(&way).map(|(g, w)| g * w).collect();
            (residual.potential.contact, works)
        };
        // forces of both signs cancel to different degrees: errors are small beside their sizes
        let works = at(0.0).1;
        let (slope, force) = (works.iter().sum::<f64>(), works.iter().map(|work| work.abs()).sum::<f64>());
        let error =
            |h: f64, at: &mut dyn FnMut(f64) -> (f64, Vec<f64>)| ((at(h).0 - at(-h).0) / (2.0 * h) - slope).abs();
        let errors = [1e-6, 1e-7].map(|h| error(h, &mut at));
        assert!(errors[0] < 1e-3 * force && errors[1] < 0.05 * errors[0] + 1e-8 * force, "{errors:?} {force}");
    }
}

/// A run that goes on from a restart in which nodes touch two strands takes the same step, bit for bit.
#[cfg(feature = "runs")]
#[test]
fn restarts_carry_all_offsets() {
    let mut solver = beams();
    assert_eq!(solver.step_to(&[Ramp::Load { to: 0.9 }]).unwrap().status, Status::Converged);
    let bytes = postcard::to_allocvec(
        &solver.to_restart(crate::solve::path::restart::Place::start_of(0, 1, 0), &crate::solve::Given::default()),
    )
    .unwrap();
    let mut later = beams();
    later.take_over(postcard::from_bytes(&bytes).unwrap()).unwrap();
    let offsets = |solver: &Solver| solver.engine.contact.offsets.clone();
    assert!(!offsets(&solver).entries.is_empty());
    assert_eq!(offsets(&solver), offsets(&later));
    solver.forget_path().unwrap();
    later.forget_path().unwrap();
    let step = |solver: &mut Solver| solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap();
    assert_eq!(step(&mut solver), step(&mut later));
    assert_eq!(solver.engine.state, later.engine.state);
    assert_eq!(offsets(&solver), offsets(&later));
}

/// Numbers go with their nodes, those of planes too; of a node's entries the largest.
#[test]
fn numbers_move_with_their_nodes() {
    let values = vec![0.1, 0.2, 0.3, 1.1, 1.2, 1.3, 7.0, 8.0];
    let entries = vec![entry(1, 0, [9.5, 10.5]), entry(1, 0, [4.0, 5.0])];
    let numbers = ContactField { num_nodes: 3, num_surfaces: 1, values, entries };
    let moved = numbers.moved([2, 1, 1, 0].into_iter());
    assert_eq!(moved.values, [0.3, 8.0, 8.0, 0.1, 1.3, 1.2, 1.2, 1.1]);
    assert_eq!((moved.num_nodes, moved.num_surfaces, moved.entries.len()), (4, 1, 0));
}
