//! Cylinders and spheres as the solver sees them: rods held by them alone, bodies that move, turn and change their size in one
//! step, the same bits for any number of threads, the same state in other units and turned.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::scene::Scene;
use supercoil::scene::file::TEMPLATES;
use supercoil::solve::{self, Options, Solution, Status};

fn run(text: &str, options: &Options) -> (Solution, Vec<Observation>) {
    let scene = Scene::from_toml(text, Path::new("")).unwrap();
    let mut seen = Vec::new();
    let solution = solve::run(scene.model, &scene.stages, options, &mut |progress| {
        seen.push(observe(progress));
        ControlFlow::Continue(())
    });
    let solution = solution.unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure.map(|failure| failure.to_string()));
    assert_eq!(seen[seen.len() - 1].status, "converged", "{text}");
    (solution, seen)
}

/// A ring in space, of radius `f`, at a height, tilted.
fn ring(f: f64) -> String {
    format!(
        "[[rods]]\nname = \"ring\"\nclosed = true\n\
         shape = {{ kind = \"circle\", radius = {f:?}, normal = [0.3, -0.2, 1.0], center = [0, 0, {:?}] }}\n\
         section = {{ bending = {:?}, twisting = {:?}, stretching = {:?}, shearing = {:?}, contact_radius = {:?} }}\n\
         elements = 16\n",
        0.2 * f,
        f.powi(4),
        f.powi(4),
        1e4 * f * f,
        1e4 * f * f,
        0.05 * f
    )
}

/// A cavity that a ring is squeezed in, smaller than the ring.
fn squeezed(f: f64, steps: usize) -> String {
    let [radius, to] = [1.3 * f, 0.95 * f];
    ring(f)
        + &format!(
            "[[obstacles]]\nname = \"cavity\"\nshape = \"sphere\"\nside = \"inside\"\nradius = {radius:?}\n\
             [[stages]]\nramp = {{ obstacle = {{ radius = {to:?} }} }}\nsteps = {steps}\n"
        )
}

/// A ring in a cavity that becomes smaller than it folds and stays inside; threads, units and the number of steps do not matter.
#[test]
fn a_ring_folds_in_a_cavity() {
    let with = |threads: usize| Options { threads: Some(threads), ..Options::default() };
    let (one, seen) = run(&squeezed(1.0, 4), &with(1));
    let (several, _) = run(&squeezed(1.0, 4), &with(3));
    assert_eq!(one.solver.engine().state(), several.solver.engine().state());
    let farthest = one.solver.engine().centerline(0, 8).0.iter().map(|r| r.norm()).fold(0.0, f64::max);
    assert!(farthest <= 0.9 + 1e-8, "{farthest}");
    let last = &seen[seen.len() - 1];
    assert!(last.obstacle_reactions[0].force > 0.1 && last.energies.bending > 1.01 * std::f64::consts::PI);
    let (_, large) = run(&squeezed(64.0, 4), &Options::default());
    let large = &large[large.len() - 1];
    let ratio = large.energies.total / last.energies.total / 64f64.powi(3);
    assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
}

/// A free ring is carried along by a post inside it, pushed in one step by more than it is wide, and is left without stress.
#[test]
fn a_post_carries_a_ring_along() {
    for (name, shape) in [
        ("post", "shape = \"cylinder\"\naxis = [0.1, 0, 1]"),
        ("tube", "shape = \"cylinder\"\naxis = [0, 1, 0.2]\nside = \"inside\""),
    ] {
        let radius = if name == "post" { 0.5 } else { 1.4 };
        let text = ring(1.0)
            + &format!(
                "[[obstacles]]\n{shape}\nradius = {radius:?}\n\
                 [[stages]]\nramp = {{ obstacle = {{ displacement = [5.0, 0.0, 0.0] }} }}\nsteps = 1\n"
            );
        let (solution, seen) = run(&text, &Options::default());
        let points = solution.solver.engine().centerline(0, 8).0;
        let middle = points.iter().map(|r| r.x).sum::<f64>() / points.len() as f64;
        assert!(middle > 3.0, "{name} {middle}");
        let last = &seen[seen.len() - 1];
        assert!((last.energies.total - std::f64::consts::PI).abs() < 1e-4, "{name} {}", last.energies.total);
    }
}

/// A post that turns about a hinge bends a clamped rod as the same post does that is displaced to where it turns to.
#[test]
fn a_post_turned_to_a_place_is_a_post_moved_there() {
    let rod = "planar = true\n[[rods]]\nname = \"rod\"\nshape = { kind = \"line\", start = [0, 0, 0], length = 2.0 }\n\
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.02 }\nelements = 24\n\
        [[supports]]\nat = \"start\"\nposition = true\nrotation = true\n\
        [[obstacles]]\nname = \"post\"\nshape = \"cylinder\"\naxis = [0, 0, 1]\npoint = [1.5, 0.25, 0]\nradius = 0.2\n";
    let hinge = "hinge = { through = [1.5, 1.25, 0], axis = [0, 0, 1] }\n";
    let (sin, cos) = (0.05 * std::f64::consts::TAU).sin_cos();
    // from the lowest point of a circle of radius 1
    let displaced = format!("displacement = [{:?}, {:?}, 0]", -sin, 1.0 - cos - 0.3);
    let ends: Vec<Observation> = [
        "[[stages]]\nramp = { obstacle = { turns = -0.05, displacement = [0, -0.3, 0] } }\nsteps = 4\n".to_owned(),
        format!("[[stages]]\nramp = {{ obstacle = {{ {displaced} }} }}\nsteps = 4\n"),
    ]
    .iter()
    .map(|stage| run(&format!("{rod}{hinge}{stage}"), &Options::default()).1.pop().unwrap())
    .collect();
    let [a, b] = [&ends[0], &ends[1]].map(|end| (end.energies.total, end.obstacle_reactions[0].force));
    assert!(a.1 > 0.01, "{a:?}");
    assert!((a.0 - b.0).abs() < 1e-6 * b.0 && (a.1 - b.1).abs() < 1e-6 * b.1, "{a:?} {b:?}");
}

/// What is wrong with an obstacle is refused by name.
#[test]
fn obstacles_without_sense_are_refused() {
    let good = ring(1.0)
        + "[[obstacles]]\nname = \"tube\"\nshape = \"cylinder\"\naxis = [0, 1, 0]\nside = \"inside\"\nradius = 1.4\n\
           [[stages]]\nramp = { obstacle = { radius = 1.3 } }\nsteps = 1\n";
    assert!(Scene::from_toml(&good, Path::new("")).is_ok());
    let cases = [
        ("radius = 1.4", "radius = 0.05", &["obstacles[0].radius", "no room inside", "\"ring\""][..]),
        ("radius = 1.4", "radius = 0.9", &["obstacles[0]", "\"ring\" starts beyond it", "deep at arc"]),
        ("radius = 1.4", "radius = nan", &["obstacles[0].radius", "finite"]),
        ("radius = 1.4", "radius = -1.0", &["obstacles[0].radius", "> 0"]),
        ("axis = [0, 1, 0]", "axis = [0, 0, 0]", &["obstacles[0].axis", "not all zero"]),
        ("axis = [0, 1, 0]", "axis = [0, nan, 0]", &["obstacles[0].axis", "finite"]),
        ("axis = [0, 1, 0]\n", "", &["obstacles[0].axis", "missing"]),
        ("axis = [0, 1, 0]", "axis = [0, 1, 0]\npoint = [inf, 0, 0]", &["obstacles[0].point", "finite"]),
        (
            "axis = [0, 1, 0]",
            "axis = [0, 1, 0]\nhinge = { axis = [0, 0, 0] }",
            &["obstacles[0].hinge.axis", "not all zero"],
        ),
        ("shape = \"cylinder\"", "shape = \"sphere\"", &["obstacles[0].axis", "leave it out"]),
        ("{ radius = 1.3 }", "{ radius = 0.01 }", &["stages[0].ramp.obstacle.radius", "no room inside"]),
        ("{ radius = 1.3 }", "{ turns = 0.5 }", &["stages[0].ramp.obstacle.turns", "hinge"]),
        ("{ radius = 1.3 }", "{ name = \"tub\", radius = 1.3 }", &["stages[0].ramp.obstacle.name", "\"tube\""]),
        ("{ radius = 1.3 }", "{}", &["stages[0].ramp.obstacle", "nothing to do"]),
    ];
    for (from, to, parts) in cases {
        assert!(good.contains(from), "{from}");
        let error = Scene::from_toml(&good.replace(from, to), Path::new("")).unwrap_err().to_string();
        assert!(parts.iter().all(|part| error.contains(part)), "{to}: {error}");
    }
}

/// The scenes of `supercoil new` converge, and their obstacles bear something.
#[test]
fn templates_with_obstacles_converge() {
    for name in ["pulley", "tube", "capsid"] {
        let template = TEMPLATES.iter().find(|template| template.name == name).unwrap();
        let (_, seen) = run(template.text, &Options::default());
        assert!(seen[seen.len() - 1].obstacle_reactions[0].force > 0.1, "{name}");
    }
}
