//! Scenes of rods whose start shape is their natural one: what turns or twists the frames at the start does not change
//! what that is.
//!
//! An arc is at rest where it starts, however its section is rolled; excess link costs the same whether a rod starts
//! with it or is given it in a stage, and whether its circle is called one or given by points.

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::scene::Scene;
use supercoil::solve::{self, Options, Status};

/// The last state of a scene of one rod, its contact radius .02, called "r".
fn rest(closed: bool, shape: &str, section: &str, rest: &str) -> (Observation, Vec<f64>) {
    let text = format!(
        "[[rods]]\nname = \"r\"\nclosed = {closed}\nshape = {{ {shape} }}\n\
         section = {{ {section}, contact_radius = 0.02 }}\nelements = 24\n\
         natural = \"as-shaped\"\n{rest}"
    );
    let scene = Scene::from_toml(&text, Path::new(env!("CARGO_TARGET_TMPDIR"))).expect("sound scene");
    let start = scene.model.rods[0].positions.clone();
    let mut last = None;
    let solution = solve::run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
        last = Some(observe(progress));
        ControlFlow::Continue(())
    });
    let solution = solution.expect("sound scene");
    assert_eq!(solution.status, Status::Converged);
    let moved = start.iter().zip(solution.solver.engine().positions(0)).map(|(a, b)| (a - b).norm()).collect();
    (last.expect("sound scene"), moved)
}

const STRIP: &str = "young = 1e6, poisson = 0.3, rectangle = [0.1, 0.02]";
const ROUND: &str = "bending = 1.0, twisting = 1.0, stretching = 1e6, shearing = 1e6";

/// Before, the natural curvature of arcs and circles turned with the roll: the strip rose out of its plane.
#[test]
fn a_rolled_strip_stays_where_it_is() {
    let clamp = "[[supports]]\nat = \"start\"\nposition = true\nrotation = true";
    for (closed, shape) in
        [(false, "kind = \"arc\", radius = 1.0, turns = 0.5"), (true, "kind = \"circle\", radius = 1.0")]
    {
        for roll in [0.0, 0.1, 0.25] {
            let more = format!("roll = {roll}\n{}", if closed { "" } else { clamp });
            let (state, moved) = rest(closed, shape, STRIP, &more);
            let most = moved.into_iter().fold(0.0, f64::max);
            assert!(
                most < 1e-6 && state.energies.total < 1e-18,
                "{shape}, roll {roll}: {most:e} {:e}",
                state.energies.total
            );
        }
    }
}

/// Before, link at the start of a rod given by points was taken for a part of its nature and cost nothing.
#[test]
fn link_costs_the_same_however_it_is_put_in() {
    let points: String = (0..64)
        .map(|i| f64::from(i) * std::f64::consts::TAU / 64.0)
        .map(|t| format!("{},{},0\n", t.cos(), t.sin()))
        .collect();
    std::fs::write(Path::new(env!("CARGO_TARGET_TMPDIR")).join("as_shaped_circle.csv"), points).unwrap();
    let circle = "kind = \"circle\", radius = 1.0";
    let by_points = "kind = \"points\", file = \"as_shaped_circle.csv\"";
    let (start, stage) = ("excess_link = 0.3", "[[stages]]\nramp = { excess_link = { to = 0.3 } }\nsteps = 2");
    let total = |shape: &str, way: &str| rest(true, shape, ROUND, way).0.energies.total;
    let reference = total(circle, stage);
    // more than a ring straight by nature would take, ½ C (2π ΔLk)²/L = .28, as turning its natural curvature out of
    // the plane costs bending; less than twist spread evenly does
    assert!(reference > 0.3 && reference < 3.4, "{reference}");
    // the spline through 64 points of the circle is 1e-6 off
    for (shape, way, tolerance) in [(circle, start, 1e-10), (by_points, stage, 1e-6), (by_points, start, 1e-6)] {
        let energy = total(shape, way);
        assert!((energy / reference - 1.0).abs() < tolerance, "{shape}, {way}: {energy} {reference}");
    }
}

/// As rolled circles: a section that is stiffer one way keeps its natural curvature in the plane, under link too.
#[test]
fn a_rolled_ring_takes_up_link_as_one_of_exchanged_stiffnesses() {
    let section = |b: &str| format!("bending = {b}, twisting = 1.0, stretching = 1e6, shearing = 1e6");
    let circle = "kind = \"circle\", radius = 1.0";
    let link = "[[stages]]\nramp = { excess_link = { to = 0.2 } }\nsteps = 2";
    let rolled = rest(true, circle, &section("[1.0, 3.0]"), &format!("roll = 0.25\n{link}")).0.energies.total;
    let exchanged = rest(true, circle, &section("[3.0, 1.0]"), link).0.energies.total;
    assert!((rolled / exchanged - 1.0).abs() < 1e-8, "{rolled} {exchanged}");
}
