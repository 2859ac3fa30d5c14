//! What accuracy costs: errors against work over the knobs of `docs/ACCURACY.md`, with the Pareto front of each case
//! and where the presets ([`Fidelity`]) lie on it.
//!
//! `cargo bench --bench work_precision` writes `target/work_precision/*.csv` and one plot a case; a word behind `--`
//! picks the cases whose names have it. Work is counted in node iterations (Newton iterations times nodes, from the
//! start state to rest), which other work on the machine does not touch; the time of one run on one thread stands
//! beside it. A mesh may be lucky: where ends of lines of contact and points lie between nodes makes two beams on 23,
//! 24 and 26 elements wrong by 8e-4, 2e-5 and 5e-4 (κ' = 100). So in contact each setting runs on three meshes, some 4
//! % apart, and counts with the worst of their errors and the mean of their work. The last part measures condition:
//! size of residual and increment where they stop falling, against slenderness and number of elements.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::f64::consts::{FRAC_PI_4, PI, TAU};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

use supercoil::dna;
use supercoil::io::picture::{PlotSpec, Series, SeriesStyle, plot_lines};
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Plectoneme, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Fidelity, LineLoad, Model, NodeLoad, NodeRef, Ramp, Stage, Support};
use supercoil::solve::{Options, Solver, Status, run};

/// One setting of the knobs.
#[derive(Debug, Clone, Copy)]
struct Knobs {
    order: usize,
    elements: usize,
    /// Contact stiffness κ ε⁴/B, none: by the mesh; and whether an augmented Lagrangian closes the gaps.
    stiffness: Option<f64>,
    augmented: bool,
    tol_penetration: f64,
    tol_increment: f64,
    /// Load steps.
    steps: usize,
    preset: Option<Fidelity>,
}

const MIDDLE: Knobs = Knobs {
    order: 3,
    elements: 24,
    stiffness: Some(100.0),
    augmented: true,
    tol_penetration: 1e-8,
    tol_increment: 1e-8,
    steps: 4,
    preset: None,
};

/// A preset's settings for a rod of this length, turns and contact radius.
fn preset(fidelity: Fidelity, [length, turns, radius]: [f64; 3], steps: usize) -> Knobs {
    let ContactLaw::ByMesh { tol_penetration, .. } = fidelity.contact().law else {
        panic!("presets augment");
    };
    let elements = fidelity.elements(length, turns, radius);
    let tol_increment = fidelity.tol_increment();
    Knobs { elements, stiffness: None, tol_penetration, tol_increment, steps, preset: Some(fidelity), ..MIDDLE }
}

/// Numbers a state is judged by; NaN where a case has none.
#[derive(Debug, Clone, Copy)]
struct Numbers {
    energy: f64,
    moment: f64,
    writhe: f64,
    force: f64,
    tip: [f64; 3],
}

/// Mean work and worst errors over some meshes. Errors are relative to the reference; the gap's is the penetration over
/// the contact radius.
struct Row {
    case: &'static str,
    knobs: Knobs,
    seconds: f64,
    iterations: f64,
    /// Newton iterations × nodes.
    work: f64,
    energy: f64,
    moment: f64,
    writhe: f64,
    force: f64,
    tip: f64,
    gap: f64,
    worst: f64,
}

struct Case {
    name: &'static str,
    title: &'static str,
    /// What the presets' meshes go by: length, turns, contact radius.
    rod: [f64; 3],
    /// Builds and loads; `None` when a step does not converge.
    run: fn(&Knobs) -> Option<(Solver, Observation, usize)>,
    reference: fn() -> Numbers,
    knobs: Vec<Knobs>,
}

fn law(knobs: &Knobs) -> Contact {
    let Knobs { stiffness, tol_penetration, .. } = *knobs;
    let law = match stiffness {
        None => {
            let least = knobs.preset.map_or(Contact::DEFAULT_LEAST_STIFFNESS, Fidelity::least_stiffness);
            ContactLaw::ByMesh { least, tol_penetration }
        }
        Some(stiffness) if knobs.augmented => ContactLaw::AugmentedLagrangian { stiffness, tol_penetration },
        Some(stiffness) => ContactLaw::Penalty { stiffness },
    };
    Contact { law }
}

fn options(knobs: &Knobs) -> Options {
    let mut options = Options { threads: Some(1), ..Options::default() };
    options.newton.tol_increment = knobs.tol_increment;
    options
}

/// Runs as a scene does; the last state and all iterations.
fn go(model: Model, knobs: &Knobs, stages: &[Stage]) -> Option<(Solver, Observation, usize)> {
    let mut last = None;
    let solution = run(model, stages, &options(knobs), &mut |progress| {
        if stages.is_empty() || progress.stage + 1 == stages.len() && progress.fraction > 1.0 - 1e-9 {
            last = Some(observe(progress));
        }
        ControlFlow::Continue(())
    });
    let solution = solution.ok().filter(|solution| solution.status == Status::Converged)?;
    Some((solution.solver, last?, solution.iterations))
}

/// Length of the 45° bend, R = 100.
const BEND_LENGTH: f64 = 100.0 * FRAC_PI_4;

fn bend(knobs: &Knobs) -> Option<(Solver, Observation, usize)> {
    let section = Section {
        shearing: [5e6 * 5.0 / 6.0; 2],
        stretching: 1e7,
        bending: [1e7 / 12.0; 2],
        twisting: 5e6 / 6.0,
        contact_radius: 0.0,
    };
    let arc =
        Shape::Arc { start: Vec3::zeros(), tangent: Vec3::x(), towards: Vec3::y(), radius: 100.0, angle: FRAC_PI_4 };
    let rod = Rod::new("bend", &arc, RodMesh::open(knobs.elements, knobs.order), section, Natural::AsShaped).ok()?;
    let tip = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
    let model = Model {
        rods: vec![rod],
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        loads: vec![NodeLoad { node: tip, force: Vec3::z() * 600.0, moment: Vec3::zeros() }],
        contact: Contact::NONE,
        ..Model::default()
    };
    go(model, knobs, &[Stage::new(vec![Ramp::Load { to: 1.0 }], knobs.steps)])
}

/// The twisted ring, taken past its instability in two steps and then to an excess link in the stated number.
fn ring(knobs: &Knobs, diameter: f64, target: f64, steps: usize) -> Option<(Solver, Observation, usize)> {
    let section = Section::isotropic(1.0, 1.5, 1e8, 1e8, 0.5 * diameter);
    let circle = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod =
        Rod::new("ring", &circle, RodMesh::closed(knobs.elements, knobs.order), section, Natural::Straight).ok()?;
    let stage = |(to, steps)| Stage::new(vec![Ramp::ExcessLink { rod: 0, to }], steps);
    let stages = [(1.1, 1), (1.2, 1), (target, steps)].map(stage);
    go(Model { rods: vec![rod], contact: law(knobs), ..Model::default() }, knobs, &stages)
}

fn thick_ring(knobs: &Knobs) -> Option<(Solver, Observation, usize)> {
    ring(knobs, 0.03, 1.8, knobs.steps)
}

fn thin_ring(knobs: &Knobs) -> Option<(Solver, Observation, usize)> {
    ring(knobs, 0.01, 1.8, knobs.steps)
}

/// The ring in contact along a line.
fn line_ring(knobs: &Knobs) -> Option<(Solver, Observation, usize)> {
    ring(knobs, 0.01, 2.8, 2 * knobs.steps)
}

/// A DNA minicircle of 336 base pairs with three turns taken out, as `examples/minicircle.toml`.
fn minicircle(knobs: &Knobs) -> Option<(Solver, Observation, usize)> {
    let (bending, twisting, stretching) = (dna::BENDING_STIFFNESS, dna::TWIST_STIFFNESS, dna::STRETCH_MODULUS);
    let section = Section::isotropic(bending, twisting, stretching, stretching, 2.5);
    let circle = Shape::Circle { length: 336.0 * dna::RISE, center: Vec3::zeros(), normal: Vec3::z() };
    let rod =
        Rod::new("dna", &circle, RodMesh::closed(knobs.elements, knobs.order), section, Natural::Straight).ok()?;
    let stage = Stage::new(vec![Ramp::ExcessLink { rod: 0, to: -3.0 }], 5 * knobs.steps);
    go(Model { rods: vec![rod], contact: law(knobs), ..Model::default() }, knobs, &[stage])
}

/// pUC19 at a supercoiling density of -0.06, brought to rest from a plectoneme: `examples/puc19.toml` without the way
/// there from the circle.
fn puc19(knobs: &Knobs) -> Option<(Solver, Observation, usize)> {
    let (bending, twisting, stretching) = (dna::BENDING_STIFFNESS, dna::TWIST_STIFFNESS, dna::STRETCH_MODULUS);
    let section = Section::isotropic(bending, twisting, stretching, stretching, 2.5);
    let shape = Shape::Plectoneme(Plectoneme::of_link(PUC19_LENGTH, 5.1, bending, twisting, PUC19_LINK).ok()?);
    let rod = Rod::new("dna", &shape, RodMesh::closed(knobs.elements, knobs.order), section, Natural::Straight).ok()?;
    let rod = rod.with_excess_link(PUC19_LINK).ok()?;
    go(Model { rods: vec![rod], contact: law(knobs), ..Model::default() }, knobs, &[])
}

const PUC19_LENGTH: f64 = 2686.0 * dna::RISE;
const PUC19_LINK: f64 = -15.0;

/// The ring with D/L = .01 as a plectoneme, from a plectoneme: link at which its exact writhe and moment are known.
const PLECTONEME_LINK: f64 = 4.18363 + 0.88448 / 1.5;

fn plectoneme(knobs: &Knobs) -> Option<(Solver, Observation, usize)> {
    let section = Section::isotropic(1.0, 1.5, 1e8, 1e8, 0.005);
    let shape = Shape::Plectoneme(Plectoneme::of_link(1.0, 0.0102, 1.0, 1.5, PLECTONEME_LINK).ok()?);
    let rod =
        Rod::new("ring", &shape, RodMesh::closed(knobs.elements, knobs.order), section, Natural::Straight).ok()?;
    let rod = rod.with_excess_link(PLECTONEME_LINK).ok()?;
    go(Model { rods: vec![rod], contact: law(knobs), ..Model::default() }, knobs, &[])
}

/// Two clamped beams pushed together by line loads, twelve times beyond first touch.
fn beams(knobs: &Knobs) -> Option<(Solver, Observation, usize)> {
    let (radius, gap) = (0.01, 1e-4);
    let section = Section::isotropic(1.0, 1.0, 1e7, 1e7, radius);
    let beam = |name: &str, start: Vec3| {
        let shape = Shape::Line { start, direction: Vec3::x(), length: 1.0 };
        Rod::new(name, &shape, RodMesh::open(knobs.elements, knobs.order), section, Natural::Straight)
    };
    let rods = vec![beam("lower", Vec3::zeros()).ok()?, beam("upper", Vec3::y() * (2.0 * radius + gap)).ok()?];
    let last = rods[0].num_nodes() - 1;
    let supports = (0..2).flat_map(|rod| [0, last].map(|node| Support::clamp(NodeRef { rod, node }))).collect();
    let line_loads = vec![LineLoad::of_force(0, Vec3::y()), LineLoad::of_force(1, -Vec3::y())];
    let model = Model { rods, supports, line_loads, contact: law(knobs), planar: true, ..Model::default() };
    let touch = 192.0 * gap;
    go(model, knobs, &[Stage::new(vec![Ramp::Load { to: 12.0 * touch }], knobs.steps.max(2))])
}

const NONE: Numbers =
    Numbers { energy: f64::NAN, moment: f64::NAN, writhe: f64::NAN, force: f64::NAN, tip: [f64::NAN; 3] };

fn numbers(solver: &Solver, seen: &Observation) -> Numbers {
    let tip = solver.engine().positions(0).last().unwrap();
    Numbers {
        energy: seen.energies.stretching + seen.energies.shearing + seen.energies.bending + seen.energies.twisting,
        moment: seen.links.first().map_or(f64::NAN, |link| link.seam_moment),
        writhe: seen.links.first().map_or(f64::NAN, |link| link.writhe),
        force: if seen.num_sites > 0 { seen.total_contact_force } else { f64::NAN },
        tip: (*tip).into(),
    }
}

/// A far finer run, for want of exact values.
fn finest(run: fn(&Knobs) -> Option<(Solver, Observation, usize)>, elements: usize, stiffness: f64) -> Numbers {
    let (solver, seen, _) = run(&Knobs { elements, stiffness: Some(stiffness), ..MIDDLE }).unwrap();
    Numbers { tip: [f64::NAN; 3], ..numbers(&solver, &seen) }
}

/// Worst errors and mean work over three meshes near the one given; without contact, where errors fall smoothly, on
/// that alone.
fn measure(case: &Case, reference: &Numbers, knobs: Knobs) -> Option<Row> {
    if case.rod[2] == 0.0 {
        return measure_once(case, reference, knobs);
    }
    let count = knobs.elements as f64;
    let meshes = [(0.96 * count).floor(), count, (1.04 * count).ceil()].map(|elements| elements as usize);
    let rows: Option<Vec<Row>> =
        meshes.into_iter().map(|elements| measure_once(case, reference, Knobs { elements, ..knobs })).collect();
    let rows = rows?;
    let mean = |of: fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / rows.len() as f64;
    let worst = |of: fn(&Row) -> f64| rows.iter().map(of).fold(f64::NAN, f64::max);
    Some(Row {
        case: case.name,
        knobs,
        seconds: mean(|row| row.seconds),
        iterations: mean(|row| row.iterations),
        work: mean(|row| row.work),
        energy: worst(|row| row.energy),
        moment: worst(|row| row.moment),
        writhe: worst(|row| row.writhe),
        force: worst(|row| row.force),
        tip: worst(|row| row.tip),
        gap: worst(|row| row.gap),
        worst: worst(|row| row.worst),
    })
}

fn measure_once(case: &Case, reference: &Numbers, knobs: Knobs) -> Option<Row> {
    let started = Instant::now();
    let (solver, seen, iterations) = (case.run)(&knobs)?;
    let seconds = started.elapsed().as_secs_f64();
    let ours = numbers(&solver, &seen);
    let relative = |x: f64, exact: f64| ((x - exact) / exact).abs();
    let apart = (0..3).map(|k| (ours.tip[k] - reference.tip[k]).powi(2)).sum::<f64>().sqrt();
    let radius = solver.engine().model().rods[0].section.contact_radius;
    let gap = seen.min_gap.filter(|_| seen.num_sites > 0).map_or(f64::NAN, |gap| (-gap.lower / radius).max(0.0));
    let length = solver.engine().model().rods[0].length;
    let mut row = Row {
        case: case.name,
        knobs,
        seconds,
        iterations: iterations as f64,
        work: solver.timings().node_iterations as f64,
        energy: relative(ours.energy, reference.energy),
        moment: relative(ours.moment, reference.moment),
        writhe: relative(ours.writhe, reference.writhe),
        force: relative(ours.force, reference.force),
        tip: apart / length,
        gap,
        worst: 0.0,
    };
    let errors = [row.energy, row.moment, row.writhe, row.force, row.tip, row.gap];
    row.worst = errors.into_iter().filter(|e| !e.is_nan()).fold(0.0, f64::max);
    Some(row)
}

/// Rows that no other beats in both work and worst error, least work first.
fn front(rows: &[Row]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by(|&a, &b| rows[a].work.total_cmp(&rows[b].work));
    let mut best = f64::INFINITY;
    order.retain(|&i| {
        let better = rows[i].worst < best;
        best = best.min(rows[i].worst);
        better
    });
    order
}

fn folder() -> PathBuf {
    let dir = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target/work_precision");
    std::fs::create_dir_all(&dir).unwrap();
    dir
}

fn word(preset: Option<Fidelity>) -> String {
    preset.map_or_else(String::new, |fidelity| format!("{fidelity:?}"))
}

fn write(case: &str, rows: &[Row], best: &[usize]) {
    let head = "case,preset,order,elements,stiffness,augmented,tol_penetration,tol_increment,steps,seconds,iterations,\
        work,energy,moment,writhe,force,tip,gap,worst,front\n";
    let mut text = head.to_owned();
    for (index, row) in rows.iter().enumerate() {
        let k = row.knobs;
        let knobs = format!(
            "{},{},{},{},{},{:e},{:e},{}",
            word(k.preset),
            k.order,
            k.elements,
            stiffness(&k),
            k.augmented,
            k.tol_penetration,
            k.tol_increment,
            k.steps
        );
        let errors =
            [row.energy, row.moment, row.writhe, row.force, row.tip, row.gap, row.worst].map(|e| format!("{e:.3e}"));
        let (seconds, errors) = (row.seconds, errors.join(","));
        text += &format!(
            "{},{knobs},{seconds:.4},{:.0},{:.0},{errors},{}\n",
            row.case,
            row.iterations,
            row.work,
            best.contains(&index)
        );
    }
    std::fs::write(folder().join(format!("{case}.csv")), text).unwrap();
}

/// Points on logarithmic axes, a line through some of them, and some with names.
fn plot(name: &str, title: &str, axes: [&str; 2], [points, line]: [Vec<(f64, f64)>; 2], named: Vec<Series>) {
    let [x_label, y_label] = axes.map(str::to_owned);
    let settings = if line.is_empty() { "" } else { "settings" };
    let series = vec![
        Series { name: settings.to_owned(), points, style: SeriesStyle::Points },
        Series { name: "front".to_owned(), points: line, style: SeriesStyle::LinePoints },
    ];
    let series = series.into_iter().chain(named).filter(|s| !s.points.is_empty()).collect();
    let plot =
        PlotSpec { title: title.to_owned(), x_label, y_label, series, log_x: true, log_y: true, ..PlotSpec::default() };
    plot_lines(&folder().join(format!("{name}.svg")), &plot).unwrap();
}

fn with(list: &mut Vec<Knobs>, change: impl Fn(&mut Knobs)) {
    let mut knobs = MIDDLE;
    change(&mut knobs);
    list.push(knobs);
}

/// Meshes with laws together, and one knob at a time off the middle mesh.
fn contact_knobs(elements: &[usize], stiffnesses: &[f64]) -> Vec<Knobs> {
    let mut list = Vec::new();
    let middle = elements[elements.len() / 2];
    let with = |list: &mut Vec<Knobs>, change: &dyn Fn(&mut Knobs)| {
        let mut knobs = Knobs { elements: middle, ..MIDDLE };
        change(&mut knobs);
        list.push(knobs);
    };
    for &count in elements {
        for &stiffness in stiffnesses {
            for augmented in [true, false] {
                with(&mut list, &|k| (k.elements, k.stiffness, k.augmented) = (count, Some(stiffness), augmented));
            }
        }
    }
    for order in [1, 2] {
        with(&mut list, &|k| (k.order, k.elements) = (order, 3 * middle / order));
    }
    for tol in [1e-3, 1e-4, 1e-5] {
        with(&mut list, &|k| k.tol_increment = tol);
    }
    for tol in [1e-2, 1e-4] {
        with(&mut list, &|k| k.tol_penetration = tol);
    }
    for steps in [2, 8, 16] {
        with(&mut list, &|k| k.steps = steps);
    }
    list
}

fn bend_knobs() -> Vec<Knobs> {
    let mut list = Vec::new();
    for order in 1..=3 {
        for nodes in [6, 12, 24, 48, 96] {
            with(&mut list, |k| (k.order, k.elements, k.steps) = (order, nodes / order, 1));
        }
    }
    for steps in [4, 16] {
        with(&mut list, |k| (k.elements, k.steps) = (8, steps));
    }
    list
}

/// Smallest residual and increment that a search comes to, and the error of the tip, over slenderness and over
/// elements: half a circle by an end moment.
fn condition() {
    let mut text = "slenderness,elements,residual,increment,tip\n".to_owned();
    let mut lines = [(); 2].map(|()| ["residual", "increment", "tip error / L"].map(|name| (name, Vec::new())));
    let by_slenderness = (2..=14).map(|half_decades| (10f64.powf(0.5 * f64::from(half_decades)), 16));
    let by_elements = [4, 16, 64, 256, 1024, 4096].map(|elements| (1e2, elements));
    for (slenderness, elements) in by_slenderness.chain(by_elements) {
        let section = Section::isotropic(1.0, 0.8, 4.0 * slenderness.powi(2), 1.5 * slenderness.powi(2), 0.0);
        let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
        let rod = Rod::new("beam", &line, RodMesh::open(elements, 3), section, Natural::Straight).unwrap();
        let tip = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
        let loads = vec![NodeLoad { node: tip, force: Vec3::zeros(), moment: Vec3::z() * PI }];
        let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 })];
        let model = Model { rods: vec![rod], supports, loads, contact: Contact::NONE, ..Model::default() };
        let mut knobs = MIDDLE;
        knobs.tol_increment = 1e-7;
        let mut solver = Solver::new(model, options(&knobs)).unwrap();
        for quarter in 1..=4 {
            let _ = solver.step_to(&[Ramp::Load { to: 0.25 * f64::from(quarter) }]).unwrap();
        }
        let tip = (solver.engine().positions(0).last().unwrap() - Vec3::new(0.0, 2.0 / PI, 0.0)).norm();
        // a tolerance that nothing meets: the smallest increment on the way is what rounding leaves
        solver.options_mut().newton.tol_increment = 1e-30;
        solver.options_mut().newton.max_iterations = 12;
        let report = solver.step_to(&[]).unwrap();
        let least = |of: fn(&supercoil::solve::Iteration) -> f64| {
            report.history.iter().flatten().map(of).fold(f64::INFINITY, f64::min)
        };
        let floors = [least(|i| i.residual), least(|i| i.increment), tip];
        let [residual, increment, tip] = floors;
        println!(
            "slenderness {slenderness:.1e}, {elements} elements: residual {residual:.1e}, increment {increment:.1e}, \
             tip {tip:.1e}"
        );
        text += &format!("{slenderness:e},{elements},{residual:.3e},{increment:.3e},{tip:.3e}\n");
        for (plot, wanted, at) in [(0, elements == 16, slenderness), (1, slenderness == 1e2, elements as f64)] {
            if wanted {
                lines[plot].iter_mut().zip(floors).for_each(|((_, points), y)| points.push((at, y)));
            }
        }
    }
    std::fs::write(folder().join("condition.csv"), text).unwrap();
    let named = [
        ("condition_slenderness", "what rounding leaves, 16 cubic elements", "slenderness L/ε"),
        ("condition_elements", "what rounding leaves, L/ε = 100", "cubic elements"),
    ];
    for ((name, title, x_label), lines) in named.into_iter().zip(lines) {
        let series = lines.map(|(name, mut points)| {
            points.sort_by(|a: &(f64, f64), b| a.0.total_cmp(&b.0));
            Series { name: name.to_owned(), points, style: SeriesStyle::LinePoints }
        });
        plot(name, title, [x_label, "relative size"], [Vec::new(), Vec::new()], series.to_vec());
    }
}

fn stiffness(k: &Knobs) -> String {
    k.stiffness.map_or_else(|| "by mesh".to_owned(), |stiffness| format!("{stiffness:.0e}"))
}

fn setting(k: &Knobs) -> String {
    let (order, elements, stiffness) = (k.order, k.elements, stiffness(k));
    let law = if k.augmented { format!("augmented to {:.0e}", k.tol_penetration) } else { "penalty".to_owned() };
    format!("order {order}, {elements} elements, κ' {stiffness}, {law}, tol {:.0e}, {} steps", k.tol_increment, k.steps)
}

/// What a setting cost and how far off it is.
fn line(row: &Row) -> String {
    let (work, seconds, worst) = (row.work, row.seconds, row.worst);
    format!("{work:.1e} node iterations ({seconds:.2} s), worst error {worst:.1e}: {}", setting(&row.knobs))
}

fn main() {
    let wanted = std::env::args().skip(1).find(|word| !word.starts_with('-')).unwrap_or_default();
    let exact_bend = || {
        let (solver, seen, _) = bend(&Knobs { elements: 64, steps: 4, ..MIDDLE }).unwrap();
        Numbers { energy: numbers(&solver, &seen).energy, tip: [47.1500962403, 15.6846894790, 53.4754779982], ..NONE }
    };
    let exact_plectoneme = || Numbers { writhe: 4.18363, moment: 0.88448 * TAU, ..NONE };
    let cases = [
        Case {
            name: "bend",
            title: "45° bend",
            rod: [BEND_LENGTH, 0.125 + BEND_LENGTH / TAU * (600.0 / (1e7 / 12.0f64)).sqrt(), 0.0],
            run: bend,
            reference: exact_bend,
            knobs: bend_knobs(),
        },
        Case {
            name: "thick_ring",
            title: "twisted ring, D/L = .03, one contact",
            rod: [1.0, 2.8, 0.015],
            run: thick_ring,
            reference: || finest(thick_ring, 64, 1e6),
            knobs: contact_knobs(&[12, 16, 24, 32, 48], &[1.0, 10.0, 100.0, 1e4]),
        },
        Case {
            name: "thin_ring",
            title: "twisted ring, D/L = .01, one contact",
            rod: [1.0, 2.8, 0.005],
            run: thin_ring,
            reference: || finest(thin_ring, 96, 1e6),
            knobs: contact_knobs(&[12, 16, 24, 32, 48], &[1.0, 10.0, 100.0, 1e3, 1e4]),
        },
        Case {
            name: "line_ring",
            title: "twisted ring, D/L = .01, line contact",
            rod: [1.0, 3.8, 0.005],
            run: line_ring,
            reference: || finest(line_ring, 400, 300.0),
            knobs: contact_knobs(&[12, 16, 24, 32, 48, 64, 128], &[1.0, 10.0, 100.0, 1e3]),
        },
        Case {
            name: "minicircle",
            title: "DNA minicircle, three turns taken out",
            rod: [336.0 * dna::RISE, 4.0, 2.5],
            run: minicircle,
            reference: || finest(minicircle, 256, 1e4),
            knobs: contact_knobs(&[12, 16, 24, 32, 48, 64], &[1.0, 10.0, 100.0, 1e3]),
        },
        Case {
            name: "beams",
            title: "two beams, line contact",
            rod: [1.0, 1.0, 0.01],
            run: beams,
            reference: || finest(beams, 320, 1e3),
            knobs: contact_knobs(&[8, 16, 24, 48, 64], &[10.0, 100.0, 1e3]),
        },
        Case {
            name: "plectoneme",
            title: "plectoneme of a ring, D/L = .01",
            rod: [1.0, 1.0 + PLECTONEME_LINK, 0.005],
            run: plectoneme,
            reference: exact_plectoneme,
            knobs: contact_knobs(&[16, 24, 48, 64, 128], &[10.0, 100.0, 1e3]),
        },
        Case {
            name: "puc19",
            title: "pUC19, plectoneme at a density of -0.06",
            rod: [PUC19_LENGTH, 1.0 - PUC19_LINK, 2.5],
            run: puc19,
            reference: || finest(puc19, 1024, 1e3),
            knobs: contact_knobs(&[30, 48, 88, 128, 192, 256], &[1.0, 10.0, 100.0, 1e3]),
        },
    ];
    for mut case in cases.into_iter().filter(|case| case.name.contains(&wanted)) {
        let reference = (case.reference)();
        let steps = if case.name == "bend" { 1 } else { MIDDLE.steps };
        case.knobs.extend(Fidelity::ALL.map(|fidelity| preset(fidelity, case.rod, steps)));
        // the coarsest preset's mesh and tolerances under a plain penalty
        case.knobs.push(Knobs {
            augmented: false,
            stiffness: Some(10.0),
            preset: None,
            ..preset(Fidelity::Draft, case.rod, steps)
        });
        let (mut rows, mut failed) = (Vec::new(), Vec::new());
        for &knobs in &case.knobs {
            match measure(&case, &reference, knobs) {
                Some(row) => rows.push(row),
                None => failed.push(setting(&knobs)),
            }
        }
        let best = front(&rows);
        println!("\n{}: {} of {} settings converged; front:", case.name, rows.len(), case.knobs.len());
        for &i in &best {
            println!("  {}", line(&rows[i]));
        }
        failed.iter().for_each(|setting| println!("  not converged: {setting}"));
        let least = |worst: f64| rows.iter().filter(|r| r.worst <= worst).map(|r| r.work).fold(f64::INFINITY, f64::min);
        let presets = || rows.iter().filter(|row| row.knobs.preset.is_some());
        for row in presets() {
            println!(
                "  {}: {:.1} times the least work for that error; {}\n\
                     energy {:.1e}, moment {:.1e}, writhe {:.1e}, force {:.1e}, tip {:.1e}, gap {:.1e}",
                word(row.knobs.preset),
                row.work / least(row.worst),
                line(row),
                row.energy,
                row.moment,
                row.writhe,
                row.force,
                row.tip,
                row.gap
            );
        }
        write(case.name, &rows, &best);
        let point = |row: &Row| (row.work, row.worst);
        let through: Vec<(f64, f64)> = best.iter().map(|&i| point(&rows[i])).filter(|p| p.1 > 0.0).collect();
        let named = presets().map(|row| Series {
            name: word(row.knobs.preset),
            points: vec![point(row)],
            style: SeriesStyle::Marks,
        });
        let all = rows.iter().map(point).collect();
        plot(case.name, case.title, ["node iterations", "worst relative error"], [all, through], named.collect());
    }
    if "condition".contains(&wanted) {
        condition();
    }
}
