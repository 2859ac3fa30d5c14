//! A cantilever along x under a moment m per length about z, which keeps its direction: EI θ″ = −m, so its tip turns by
//! θ = m L²/(2 EI), for any m. L = EI = 1, m = 4: 2 rad. Tolerance 1e-6; 12 cubic elements; GA = EA = 1e9: the moment
//! alone bends.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::{ops::ControlFlow, path::Path};

use crate::common::verify_point;
use supercoil::{math::Vec3, scene::Scene, solve};

const SCENE: &str = r#"
rods = [{ shape = { kind = "line", direction = [1, 0, 0], length = 1 }, elements = 12, section = {
    bending = 1, twisting = 1.3, stretching = 1e9, shearing = 1e9
} }]
supports = [{ at = "start", position = true, rotation = true }]
line_loads = [{ moment = [0, 0, 4] }]
contact = { law = "none" }
stages = [{ ramp = { load = 1 }, steps = 4 }]
"#;

#[test]
fn cantilever_under_a_distributed_moment() {
    let scene = Scene::from_toml(SCENE, Path::new(".")).unwrap();
    let mut go_on = |_: &solve::Progress| ControlFlow::Continue(());
    let solution = solve::run(scene.model, &scene.stages, &solve::Options::default(), &mut go_on).unwrap();
    let tangent = solution.solver.engine().frames(0).last().unwrap() * Vec3::z();
    verify_point("distributed moment, tangent of the tip", &tangent, [2f64.cos(), 2f64.sin(), 0.0], 1e-6);
}
