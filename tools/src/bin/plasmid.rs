//! A plasmid of `examples/` brought to rest: how long it takes, and the middle of its plectoneme beside the closed
//! forms. Units nm, pN.
//!
//! `cargo run --release -p supercoil-tools --bin plasmid -- puc19`; or `pbr322`, `lambda_phage`, `ecoli_length` (5 min
//! on two threads, 10.1 GiB).
#![allow(clippy::print_stdout)] // a program talks to its reader

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use supercoil::math::Vec3;
use supercoil::observe::{observe, report::SiteKind};
use supercoil::rod::superhelix_angle;
use supercoil::scene::Scene;
use supercoil::solve::{self, RunError, Status};

/// What a run came to. Lengths in nm, angles in degrees.
#[derive(Debug)]
#[allow(dead_code)] // printed as a whole
struct Summary {
    status: Status,
    steps: usize,
    iterations: usize,
    /// Iterations on a shorter rod or a coarser mesh beforehand.
    iterations_on_other_meshes: usize,
    /// Largest residual over its largest contribution.
    residual: f64,
    seconds: f64,
    excess_link: f64,
    /// Wr/ΔLk.
    writhe_share: f64,
    num_unstable: usize,
    /// Half the distance of the strands at the middle of the longest line of contact, and the contact radius.
    superhelix_radius: [f64; 2],
    /// Angle of the strands to the axis there; that which the twisting moment asks for; that of an endless plectoneme
    /// of the whole link.
    superhelix_angle: [f64; 3],
    /// 2πR/tan α, from the first and the second of these angles.
    pitch: [f64; 2],
}

/// Nodes on either side of the middle of a line among which the one that faces the other strand's is sought.
const REACH: usize = 50;

/// Angle α at which a plectoneme of radius R has the twisting moment M = 2B sin³α cosα/(R cos2α), by bisection.
fn angle_of_moment(moment: f64, bending: f64, radius: f64) -> f64 {
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_4);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        let at = 2.0 * bending * middle.sin().powi(3) * middle.cos() / (radius * (2.0 * middle).cos());
        if at < moment { low = middle } else { high = middle }
    }
    low
}

fn run(name: &str) -> Result<Summary, RunError> {
    let file = format!("{}/../examples/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let scene = Scene::read(Path::new(&file))?;
    let (rod, started) = (scene.model.rods[0].clone(), Instant::now());
    let (mut last, mut iterations_on_other_meshes) = (None, 0);
    let solution = solve::run(scene.model, &scene.stages, &solve::Options::default(), &mut |progress| {
        last = Some(observe(progress));
        iterations_on_other_meshes += progress.report.iterations_on_other_meshes;
        ControlFlow::Continue(())
    })?;
    let state = last.unwrap_or_else(|| unreachable!("the start state is observed"));
    let (section, engine) = (&rod.section, solution.solver.engine());
    let node = |arc: f64| (arc / rod.length * rod.num_nodes() as f64).round() as usize % rod.num_nodes();
    let line = state.sites.iter().filter(|s| s.kind == SiteKind::Line).max_by(|a, b| a.force.total_cmp(&b.force));
    let (distance, angle) = line.map_or((f64::NAN, f64::NAN), |site| {
        // the middles of a line on either strand need not face each other
        let [a, beside] = site.center.map(node);
        let (nodes, away) = (rod.num_nodes(), |n: usize| (engine.positions(0)[n] - engine.positions(0)[a]).norm());
        let around = (0..2 * REACH).map(|k| (beside + nodes - REACH + k) % nodes);
        let b = around.min_by(|p, q| away(*p).total_cmp(&away(*q))).unwrap_or(beside);
        let tangent = |n: usize| engine.frames(0)[n] * Vec3::z();
        // nodes do not face each other exactly: the distance across the strands
        let (chord, across) =
            (engine.positions(0)[a] - engine.positions(0)[b], tangent(a).cross(&tangent(b)).normalize());
        (chord.dot(&across).abs(), 0.5 * tangent(a).angle(&-tangent(b)))
    });
    let link = &state.links[0];
    let of_moment = angle_of_moment(link.seam_moment.abs(), section.bending[0], section.contact_radius);
    let ratio = section.twisting / section.bending[0];
    let endless = superhelix_angle(2.0 * section.contact_radius, ratio, link.excess_link / rod.length)?;
    let pitch = |angle: f64| std::f64::consts::TAU * section.contact_radius / angle.tan();
    Ok(Summary {
        status: solution.status,
        steps: solution.num_steps,
        iterations: solution.iterations,
        iterations_on_other_meshes,
        residual: engine.relative_residual(),
        seconds: started.elapsed().as_secs_f64(),
        excess_link: link.excess_link,
        writhe_share: link.writhe / link.excess_link,
        num_unstable: state.num_unstable,
        superhelix_radius: [0.5 * distance, section.contact_radius],
        superhelix_angle: [angle, of_moment, endless].map(f64::to_degrees),
        pitch: [angle, of_moment].map(pitch),
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).ok_or("say which: puc19, pbr322, lambda_phage or ecoli_length")?;
    println!("{:#?}", run(&name)?);
    Ok(())
}
