//! Cylinders and spheres as the solver sees them: rods held by them alone, bodies that move, turn and change their size
//! in one step, the same bits for any number of threads, the same state in other units and turned.

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

/// A ring in a cavity that becomes smaller than it folds and stays inside; threads, units and the number of steps do
/// not matter.
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

/// A free ring is carried along by a post inside it, pushed in one step by more than it is wide, and is left without
/// stress.
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
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.02 }\n\
        elements = 24\n\
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

/// A catheter free in a bent row of posts, straight by nature, leans on the outer ones at its ends and on the inner
/// ones between. The posts' forces and moments on it cancel, it is as symmetric as the row, and bent less than the row
/// is.
#[test]
fn a_catheter_in_a_bent_row_of_posts() {
    use std::f64::consts::FRAC_PI_2;
    let (bend, radius, post, play) = (2.0, 0.05, 0.1, 0.04);
    let mut text = format!(
        "planar = true\n[[rods]]\nname = \"catheter\"\n\
         shape = {{ kind = \"arc\", start = [{bend:?}, 0, 0], tangent = [0, 1, 0], towards = [-1, 0, 0], radius = \
         {bend:?}, turns = 0.25 }}\n\
         section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = {radius:?} }}\n\
         elements = 48\n"
    );
    let mut places = Vec::new();
    for k in 0..7 {
        for side in [-1.0, 1.0] {
            let (sin, cos) = (FRAC_PI_2 * (f64::from(k) + 0.5) / 7.0).sin_cos();
            let out = bend + side * (radius + post + play);
            places.push([out * cos, out * sin]);
            text += &format!(
                "[[obstacles]]\nname = \"post{k}{side}\"\nshape = \"cylinder\"\naxis = [0, 0, 1]\nradius = {post:?}\n\
                 point = [{:?}, {:?}, 0]\n",
                out * cos,
                out * sin
            );
        }
    }
    let (solution, seen) = run(&text, &Options::default());
    let last = &seen[seen.len() - 1];
    let length = bend * FRAC_PI_2;
    let of_arc = 0.5 * length / (bend * bend);
    assert!(last.energies.bending > 0.3 * of_arc && last.energies.bending < 0.95 * of_arc, "{:?}", last.energies);
    let pushes = &last.obstacle_reactions;
    let largest = pushes.iter().map(|push| push.force).fold(0.0, f64::max);
    let sum = |k: usize| pushes.iter().map(|push| push.force_on_rods[k]).sum::<f64>();
    // forces go through the axes of the posts
    let turn: f64 =
        pushes.iter().zip(&places).map(|(push, [x, y])| x * push.force_on_rods[1] - y * push.force_on_rods[0]).sum();
    assert!([sum(0), sum(1), turn].iter().all(|sum| sum.abs() < 1e-6 * largest), "{} {} {turn}", sum(0), sum(1));
    for (a, b) in
        pushes.iter().zip(pushes.iter().rev().collect::<Vec<_>>().chunks(2).flat_map(|pair| [pair[1], pair[0]]))
    {
        assert!((a.force - b.force).abs() < 1e-6 * largest, "{} {}", a.force, b.force);
    }
    // the outer ones bear the ends, and no point is nearer to a post than the radius
    assert!(pushes[1].force > 0.1 * largest && pushes[0].force == 0.0, "{pushes:?}");
    let points = solution.solver.engine().centerline(0, 8).0;
    let clear = |[x, y]: &[f64; 2]| points.iter().map(|p| (p.x - x).hypot(p.y - y)).fold(f64::INFINITY, f64::min);
    assert!(places.iter().all(|place| clear(place) > radius + post - 1e-8));
}

/// A coil of thirty turns, as one for an aneurysm, in a cavity that shrinks about it: its ends are pressed inwards, and
/// all of it stays inside, in order.
#[test]
#[ignore = "slow: half a minute"]
fn a_coil_of_thirty_turns_in_a_cavity() {
    let text = "[[rods]]\nname = \"coil\"\nnatural = \"as-shaped\"\nelements = 180\n\
        shape = { kind = \"helix\", radius = 0.7, pitch = 0.04, turns = 30.0, center = [0, 0, -0.6] }\n\
        section = { bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, contact_radius = 0.01 }\n\
        [[obstacles]]\nshape = \"sphere\"\nside = \"inside\"\nradius = 0.95\n\
        [[stages]]\nramp = { obstacle = { radius = 0.86 } }\nsteps = 3\n";
    let (solution, seen) = run(text, &Options::default());
    let points = solution.solver.engine().centerline(0, 8).0;
    let farthest = points.iter().map(|r| r.norm()).fold(0.0, f64::max);
    assert!(farthest <= 0.85 + 1e-8, "{farthest}");
    let angle = |p: &supercoil::math::Vec3| p.y.atan2(p.x);
    let turned: f64 = points
        .windows(2)
        .map(|pair| {
            let step = (angle(&pair[1]) - angle(&pair[0])) / std::f64::consts::TAU;
            step - step.round()
        })
        .sum();
    assert!((turned - 30.0).abs() < 0.1, "{turned}");
    // the length of a spring whose ends are pressed together
    let last = &seen[seen.len() - 1];
    let height = points.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    assert!(last.obstacle_reactions[0].force > 1e-3 && height < 0.55, "{height} {:?}", last.obstacle_reactions);
    let both: Vec<f64> = last.obstacle_sites.iter().map(|site| site.force_on_rod[2]).collect();
    assert!(both.iter().sum::<f64>().abs() < 1e-6 && both.iter().any(|f| *f > 1e-4), "{both:?}");
}

/// A string of a thousand nodes that is wound up in space is pressed to a ball.
#[test]
#[ignore = "slow: some minutes"]
fn a_ball_of_string() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/ball_of_string.toml");
    let (solution, seen) = run(&std::fs::read_to_string(path).unwrap(), &Options::default());
    let engine = solution.solver.engine();
    assert_eq!(engine.state().positions().len(), 999);
    let farthest = engine.centerline(0, 8).0.iter().map(|r| r.norm()).fold(0.0, f64::max);
    assert!(farthest <= 0.88 + 1e-8, "{farthest}");
    let last = &seen[seen.len() - 1];
    assert!(last.obstacle_reactions[0].force > 1.0 && last.sites.len() > 3, "{}", last.certificate);
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
