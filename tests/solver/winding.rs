//! A soft rope laid about half of a stiff post: it lies along a light line of contact. The centre of curvature of the
//! rope is on the post's centreline, so an integral along the post would have no second derivative.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::f64::consts::PI;
use std::fmt::Write;
use std::path::PathBuf;

use crate::common;
use supercoil::io::run::options;
use supercoil::observe::report::Observation;
use supercoil::solve::Options;

/// Load on the free end, N.
const LOAD: f64 = 5.0;

/// Points of a rope that comes up on one side of a post along y through the origin, goes over it, and hangs down on the
/// other.
fn over(distance: f64) -> String {
    let mut text = String::from("x,y,z\n");
    let mut add = |x: f64, z: f64| writeln!(text, "{x:.9},0,{z:.9}").unwrap();
    (0..20).for_each(|k| add(-distance, -4.0 * distance * (1.0 - f64::from(k) / 20.0)));
    (0..30).map(|k| PI * f64::from(k) / 30.0).for_each(|a| add(-distance * a.cos(), distance * a.sin()));
    (0..=20).for_each(|k| add(distance, -5.0 * distance * f64::from(k) / 20.0));
    text
}

/// The steps of a rope over a post: radii, mm, and Young's moduli, MPa, of rope and post; a gap of 3 % of the radius of
/// the post at the start. One end of the rope is clamped, the other pulled down, held at first, then released.
fn pulled([rope, post]: [f64; 2], [soft, stiff]: [f64; 2]) -> Vec<Observation> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("winding_{rope}_{post}"));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("rope.csv"), over(1.03 * (rope + post))).unwrap();
    let clamp = |rod: &str, at: &str| {
        format!("[[supports]]\nrod = \"{rod}\"\nat = \"{at}\"\nposition = true\nrotation = true\n")
    };
    let text = format!(
        "[[rods]]\nname = \"post\"\nshape = {{ kind = \"line\", start = [0, {:?}, 0], direction = [0, 1, 0], length = \
         {:?} }}\n\
         section = {{ young = {stiff:?}, poisson = 0.3, circle = {post:?} }}\nelements = 8\n\
         [[rods]]\nname = \"rope\"\nshape = {{ kind = \"points\", file = \"rope.csv\" }}\n\
         section = {{ young = {soft:?}, poisson = 0.4, circle = {rope:?} }}\nelements = 64\n\
         {}{}{}\
         [[supports]]\nrod = \"rope\"\nat = \"end\"\nposition = true\n\
         [[loads]]\nrod = \"rope\"\nat = \"end\"\nforce = [0, 0, {:?}]\n\
         [[stages]]\nramp = {{ load = 1.0 }}\n\
         [[stages]]\nrelease = [{{ rod = \"rope\", at = \"end\", position = true }}]\nsteps = 5\n",
        -1.3 * post,
        2.6 * post,
        clamp("post", "start"),
        clamp("post", "end"),
        clamp("rope", "start"),
        -LOAD,
    );
    common::run(&text, &folder, |scene| Options { threads: Some(1), ..options(scene) }).1
}

/// Without friction n·t + M²/2B is the same all along the rope: the load at its free end, at the clamp what this bears.
#[test]
fn a_rope_on_a_post_carries_its_load_on_both_sides() {
    for (radii, moduli) in [([2.0, 30.0], [100.0, 7e4]), ([3.0, 30.0], [60.0, 7e4]), ([2.0, 20.0], [50.0, 2e5])] {
        let seen = pulled(radii, moduli);
        let clamp = seen[seen.len() - 1].reactions.iter().find(|reaction| reaction.rod == 1).unwrap();
        let bending = moduli[0] * PI * radii[0].powi(4) / 4.0;
        let moment: f64 = clamp.moment.iter().map(|m| m * m).sum();
        let found = -clamp.force[2] + moment / (2.0 * bending);
        assert!((found / LOAD - 1.0).abs() < 1e-3, "{radii:?}: {found}, {:?}", clamp.force);
    }
}
