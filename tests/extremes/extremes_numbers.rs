//! NaN, infinities and denormals in every number of a problem, one at a time.
//!
//! What is not finite is *refused* with an `InputError` that names a field; a finite number, however small or large, is
//! *refused*, by an error or by the status that a run ends with, or *returns* what the number next to it that is
//! neither would. Never a panic.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use common::observed;
use supercoil::InputError;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, LineLoad, Model, NodeLoad, NodeRef, Ramp, Stage, Support};
use supercoil::solve::{Options, Solver, State, Status};

/// A problem with one of everything: a cantilever, and a closed ring near it.
#[derive(Clone)]
struct Problem {
    model: Model,
    ramps: Vec<Ramp>,
    options: Options,
}

fn problem() -> Problem {
    let section = Section { bending: [1.0, 1.2], ..Section::isotropic(1.0, 0.8, 1e3, 1e3, 0.03) };
    let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let natural = Natural::Uniform { kappa: [0.1, 0.2, 0.3] };
    // far from relaxed: frames that do not turn
    let beam = Rod::new("beam", &line, RodMesh::open(4, 2), section, Natural::Straight).unwrap();
    let beam = Rod { natural, ..beam };
    let circle = Shape::Circle { length: 1.0, center: Vec3::new(0.5, 0.0, 0.25), normal: Vec3::y() };
    let ring = Rod::new("ring", &circle, RodMesh::closed(6, 2), section, Natural::Straight).unwrap();
    let tip = NodeRef { rod: 0, node: 8 };
    let model = Model {
        rods: vec![beam, ring],
        supports: vec![
            Support::clamp(NodeRef { rod: 0, node: 0 }),
            Support::clamp(tip),
            Support::clamp(NodeRef { rod: 1, node: 0 }),
        ],
        loads: vec![NodeLoad {
            node: NodeRef { rod: 0, node: 3 },
            force: Vec3::new(0.1, 0.2, 0.3),
            moment: Vec3::new(0.3, 0.2, 0.1),
        }],
        line_loads: vec![LineLoad::of_force(0, Vec3::new(0.0, 0.1, 0.0))],
        contact: Contact { law: ContactLaw::AugmentedLagrangian { stiffness: 100.0, tol_penetration: 1e-6 } },
        ..Model::default()
    };
    let ramps = vec![
        Ramp::Load { to: 0.5 },
        Ramp::Rotation { node: tip, axis: Vec3::x(), to: 0.05 },
        Ramp::Displacement { node: tip, to: Vec3::new(-0.01, 0.0, 0.0) },
        Ramp::ExcessLink { rod: 1, to: 0.1 },
        Ramp::RotationAbout {
            node: NodeRef { rod: 1, node: 0 },
            axis: Vec3::z(),
            through: Vec3::new(0.1, 0.2, 0.3),
            to: 0.01,
        },
    ];
    let mut options = Options { max_augmentations: 10, max_escapes: 1, ..Options::default() };
    options.newton.max_iterations = 40;
    Problem { model, ramps, options }
}

type Field = (String, Box<dyn Fn(&mut Problem) -> &mut f64>);

/// Every number that a user may set.
fn fields() -> Vec<Field> {
    fn law(p: &mut Problem) -> (&mut f64, &mut f64) {
        match &mut p.model.contact.law {
            ContactLaw::AugmentedLagrangian { stiffness, tol_penetration } => (stiffness, tol_penetration),
            _ => unreachable!(),
        }
    }
    fn target(p: &mut Problem, ramp: usize) -> &mut f64 {
        match &mut p.ramps[ramp] {
            Ramp::Load { to }
            | Ramp::Rotation { to, .. }
            | Ramp::RotationAbout { to, .. }
            | Ramp::ExcessLink { to, .. }
            | Ramp::Obstacle { to, .. }
            | Ramp::Number { to, .. }
            | Ramp::Pressure { to, .. } => to,
            Ramp::Displacement { to, .. } => &mut to.x,
            Ramp::Pose { pose, .. } => pose.turns.get_or_insert(0.0),
        }
    }
    let mut all: Vec<Field> = Vec::new();
    let mut add = |name: &str, field: Box<dyn Fn(&mut Problem) -> &mut f64>| all.push((name.to_owned(), field));
    add("rods.beam.length", Box::new(|p| &mut p.model.rods[0].length));
    add("rods.ring.start_excess_link", Box::new(|p| &mut p.model.rods[1].start_excess_link));
    add("contact.stiffness", Box::new(|p| law(p).0));
    add("contact.tol_penetration", Box::new(|p| law(p).1));
    add("options.escape_step", Box::new(|p| &mut p.options.escape_step));
    add("options.min_step", Box::new(|p| &mut p.options.min_step));
    add("options.newton.tol_increment", Box::new(|p| &mut p.options.newton.tol_increment));
    for (rod, name) in ["beam", "ring"].into_iter().enumerate() {
        let section = |what: &str| format!("rods.{name}.section.{what}");
        add(&section("stretching"), Box::new(move |p| &mut p.model.rods[rod].section.stretching));
        add(&section("twisting"), Box::new(move |p| &mut p.model.rods[rod].section.twisting));
        add(&section("contact_radius"), Box::new(move |p| &mut p.model.rods[rod].section.contact_radius));
        for k in 0..2 {
            add(&section("shearing"), Box::new(move |p| &mut p.model.rods[rod].section.shearing[k]));
            add(&section("bending"), Box::new(move |p| &mut p.model.rods[rod].section.bending[k]));
        }
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let name = format!("rods.{name}.positions, {axis}");
            add(&name, Box::new(move |p| &mut p.model.rods[rod].positions[4][k]));
        }
    }
    for k in 0..3 {
        add(
            "rods.beam.natural.kappa",
            Box::new(move |p| match &mut p.model.rods[0].natural {
                Natural::Uniform { kappa } => &mut kappa[k],
                _ => unreachable!(),
            }),
        );
        add("force", Box::new(move |p| &mut p.model.loads[0].force[k]));
        add("moment", Box::new(move |p| &mut p.model.loads[0].moment[k]));
        add("line load", Box::new(move |p| &mut p.model.line_loads[0].force[k]));
        add(
            if k == 0 { "axis, x" } else { "axis" },
            Box::new(move |p| match &mut p.ramps[1] {
                Ramp::Rotation { axis, .. } => &mut axis[k],
                _ => unreachable!(),
            }),
        );
        add(
            "displacement",
            Box::new(move |p| match &mut p.ramps[2] {
                Ramp::Displacement { to, .. } => &mut to[k],
                _ => unreachable!(),
            }),
        );
    }
    for k in 0..3 {
        add(
            if k == 2 { "through, z" } else { "through" },
            Box::new(move |p| match &mut p.ramps[4] {
                Ramp::RotationAbout { through, .. } => &mut through[k],
                _ => unreachable!(),
            }),
        );
    }
    add("turns", Box::new(|p| target(p, 4)));
    for ramp in [0, 1, 3] {
        add("target", Box::new(move |p| target(p, ramp)));
    }
    all
}

fn ends(problem: &Problem) -> Result<Status, InputError> {
    run(problem).map(|(status, _)| status)
}

fn run(problem: &Problem) -> Result<(Status, State), InputError> {
    let Problem { model, ramps, options } = problem.clone();
    model.check_stages(&[Stage::new(ramps.clone(), 1)])?;
    let mut solver = Solver::new(model, options)?;
    let report = solver.step_to(&ramps)?;
    let seen = observed(&solver, &report);
    if report.status == Status::Converged {
        assert!(seen.energies.total.is_finite(), "converged to {:?}", seen.energies);
    }
    Ok((report.status, solver.engine().state().clone()))
}

#[test]
fn numbers_that_are_none_are_refused() {
    assert_eq!(ends(&problem()), Ok(Status::Converged));
    for (name, field) in fields() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut broken = problem();
            *field(&mut broken) = value;
            match ends(&broken) {
                Err(error) => assert!(error.to_string().len() > 10, "{name}: {error}"),
                Ok(status) => panic!("{name} = {value} was taken: {status}"),
            }
        }
    }
    // frames are quaternions: any component
    for rod in 0..2 {
        let mut broken = problem();
        let frame = broken.model.rods[rod].frames[2].into_inner() * f64::NAN;
        broken.model.rods[rod].frames[2] = supercoil::math::Quat::new_unchecked(frame);
        assert!(ends(&broken).is_err(), "a frame of NaN on rod {rod}");
    }
}

/// How a problem with an odd number in it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    /// *Refused* before anything is computed, by an error that names the field.
    Refused,
    /// *Returns* the state of the problem with this number there, to 1e-9.
    Like(f64),
    /// *Returns* the state of the problem as it is, to 1e-9.
    Same,
    /// *Refused* in bounded work by a status: no result.
    Fails,
}
use End::{Fails, Like, Refused, Same};

/// Zero of either sign; what is next to nothing, and negative; 1e30; what overflows when it is squared; negative.
const VALUES: [&[f64]; 6] =
    [&[0.0, -0.0], &[5e-324, 1e-310, 1e-160], &[-5e-324, -1e-30], &[1e30], &[1e154, 1e308, f64::MAX], &[-1e308]];

/// How each class of values ends.
fn expected(name: &str) -> [End; 6] {
    const ZERO: End = Like(0.0);
    match name {
        // nothing that doubles resolve
        "rods.beam.length" => [Refused; 6],
        // as far as rounding lets anyone go; or no tolerance at all
        "options.newton.tol_increment" => [Refused, Same, Refused, Refused, Refused, Refused],
        // the strands do not touch, whatever the law
        "contact.stiffness" => [Refused, Same, Refused, Same, Same, Refused],
        "contact.tol_penetration" | "options.escape_step" | "options.min_step" => {
            [Refused, Same, Refused, Refused, Refused, Refused]
        }
        // a ring that has next to no twisting stiffness takes its link without effort
        "rods.ring.section.twisting" => [Refused, Like(1e-30), Refused, Fails, Fails, Refused],
        // touches everything; is also thicker than the ring's curvature allows
        "rods.beam.section.contact_radius" => [ZERO, ZERO, Refused, Fails, Fails, Refused],
        "rods.ring.section.contact_radius" => [ZERO, ZERO, Refused, Refused, Refused, Refused],
        // stiffness ratios beyond 1e8 are lost in rounding
        _ if name.contains(".section.") => [Refused, Fails, Refused, Fails, Fails, Refused],
        // a node on a far one folds the rod onto itself; one far away is known too coarsely
        "rods.beam.positions, x" | "rods.ring.positions, x" | "rods.ring.positions, z" => {
            [Fails, Fails, Fails, Refused, Refused, Refused]
        }
        _ if name.contains(".positions") || name.contains("kappa") => [ZERO, ZERO, ZERO, Refused, Refused, Refused],
        // a direction has no size
        "axis, x" => [Refused, Like(1.0), Like(-1.0), Like(1.0), Like(1.0), Like(-1.0)],
        "axis" => [ZERO, ZERO, ZERO, Like(1e12), Like(1e12), Like(-1e12)],
        // the axis runs along z
        "through, z" => [ZERO; 6],
        "through" => [ZERO, ZERO, ZERO, Fails, Fails, Fails],
        "turns" => [ZERO, ZERO, ZERO, Refused, Refused, Refused],
        "rods.ring.start_excess_link" | "force" | "moment" | "line load" | "displacement" | "target" => {
            [ZERO, ZERO, ZERO, Fails, Fails, Fails]
        }
        _ => unreachable!("{name}"),
    }
}

/// (Symptom before: an axis of 1e308 turned nothing and converged, one of 1e-160 turned by a wrong angle, one of 5e-324
/// broke down. Mechanism: its square over- or underflows. A rod of length 1e30 whose nodes are 1 apart was refused for
/// want of supports.)
#[test]
fn tiny_and_huge_numbers_are_refused_or_return() {
    for (name, field) in fields() {
        let with = |value: f64| {
            let mut odd = problem();
            *field(&mut odd) = value;
            run(&odd)
        };
        let same = |state: &State, problem: Result<(Status, State), InputError>| {
            let (status, reference) = problem.unwrap();
            assert_eq!(status, Status::Converged, "{name}");
            let moved = state.positions().iter().zip(reference.positions()).map(|(a, b)| (a - b).norm());
            let turned = state.frames().iter().zip(reference.frames()).map(|(a, b)| a.angle_to(b));
            moved.chain(turned).fold(0.0, f64::max)
        };
        for (values, end) in VALUES.iter().zip(expected(&name)) {
            for &value in *values {
                let what = format!("{name} = {value:e}");
                match (with(value), end) {
                    (Err(error), Refused) => {
                        let key = name.split(',').next().unwrap();
                        let text = error.to_string();
                        assert!(
                            key.split('.').filter(|part| *part != "section").all(|part| text.contains(part)),
                            "{what}: {text}"
                        );
                    }
                    (Ok((status, state)), Like(_) | Same) => {
                        assert_eq!(status, Status::Converged, "{what}");
                        let reference = if let Like(other) = end { with(other) } else { run(&problem()) };
                        let off = same(&state, reference);
                        assert!(off < 1e-9, "{what}: {off:e} off {end:?}");
                    }
                    (Ok((status, _)), Fails) => {
                        assert!(matches!(status, Status::MaxIterations | Status::BrokeDown), "{what}: {status}");
                    }
                    (other, _) => panic!("{what}: {:?} instead of {end:?}", other.map(|(status, _)| status)),
                }
            }
        }
    }
}

/// Natural curvature that turns by more than .4 turns from node to node is *refused*, below that it *returns*. (Symptom
/// before: 1.8e308 was taken, and a run ended with numbers that broke down. Mechanism: squares of it overflow, and far
/// below that elements take the other way round.)
#[test]
fn natural_curvature_beyond_the_mesh() {
    let most = 0.4 * std::f64::consts::TAU * 8.0;
    for (kappa, ok) in [(0.99 * most, true), (1.01 * most, false), (1e30, false), (f64::MAX, false)] {
        for k in 0..3 {
            let mut odd = problem();
            let mut all = [0.0; 3];
            all[k] = -kappa;
            odd.model.rods[0].natural = Natural::Uniform { kappa: all };
            match ends(&odd) {
                Ok(_) => assert!(ok, "{kappa:e}"),
                Err(error) => {
                    let text = error.to_string();
                    assert!(
                        !ok && text.contains("rods.beam.natural.kappa") && text.contains("use more elements"),
                        "{text}"
                    );
                }
            }
        }
    }
}
