//! Cost of contact detection against the number of segments, stage by stage, with rivals on the same inputs in the same
//! run.
//!
//! ```text
//! cargo bench --bench scaling                       # 1e4, 1e5, 1e6 segments, 1 and 2 threads: a few minutes
//! cargo bench --bench scaling -- --max 100000       # smaller
//! cargo bench --bench scaling -- --repeat 9 --input packed
//! # one round for rivals_external/compare.py
//! cargo bench --bench scaling -- --round packed --segments 100000 --write points.f64
//! ```
//!
//! Answers are verified (counts of an independent program, brute force at 1e4) before anything is timed. Times are
//! medians: of the thread's processor time where there is one thread, of the clock where there are two. Beside the
//! detector's exponents are printed those of two loops that do nothing but go through memory of its size: the boxes of
//! all segments are written one after the other, and as many are read in no order. A search lies between these; what
//! they grow by more than 1 is the machine's: 1e4 segments fit its caches, 1e6 do not. Bytes are what the detector
//! holds after a detection, by the capacities of its lists; those of sites apart. Writes `target/scaling/scaling.csv`
//! and `scaling.svg`.

#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod fit;
mod inputs;
mod rivals;

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use fit::exponent;
use inputs::Kind;
use supercoil::contact::Want;
use supercoil::contact::{Curve, Detector, DetectorOptions, Neighbours};
use supercoil::internals::capsule::segment_distance;
use supercoil::internals::steps::DetectorStep;
use supercoil::io::picture::{PlotSpec, Series, SeriesStyle, plot_lines};
use supercoil::math::Vec3;

const RADIUS: f64 = 1.0;

struct Arguments {
    one_thread: bool,
    max: usize,
    repeat: usize,
    input: Option<String>,
    round: Option<String>,
    segments: usize,
    write: Option<String>,
}

fn arguments() -> Arguments {
    let list: Vec<String> = std::env::args().collect();
    let value = |name: &str| list.iter().position(|a| a == name).and_then(|k| list.get(k + 1)).cloned();
    let number = |name: &str, default: usize| value(name).map_or(default, |v| v.parse().unwrap());
    Arguments {
        one_thread: list.iter().any(|a| a == "--one-thread"),
        max: number("--max", 1_000_000),
        repeat: number("--repeat", 5),
        input: value("--input"),
        round: value("--round"),
        segments: number("--segments", 1_000_000),
        write: value("--write"),
    }
}

/// One measured time.
struct Row {
    input: &'static str,
    segments: usize,
    threads: usize,
    stage: &'static str,
    seconds: f64,
    found: usize,
}

/// Seconds of processor time of this thread, which other work on the machine does not count for; `None` where the
/// system does not tell.
fn thread_time() -> Option<f64> {
    // The system brings its account up to date when the thread offers to give way.
    std::thread::yield_now();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse().ok().map(|ns: f64| ns * 1e-9)
}

/// Median of the processor time (one thread) or of the time on the clock (several), and what the last run found.
fn median(repeat: usize, mut run: impl FnMut() -> usize) -> (f64, usize) {
    let mut found = 0;
    let mut times: Vec<f64> = (0..repeat)
        .map(|_| {
            let (clock, own) = (Instant::now(), thread_time());
            found = run();
            let elapsed = clock.elapsed().as_secs_f64();
            let own = own.zip(thread_time()).map(|(before, after)| after - before);
            if rayon::current_num_threads() == 1 { own.unwrap_or(elapsed) } else { elapsed }
        })
        .collect();
    times.sort_by(f64::total_cmp);
    (times[repeat / 2], found)
}

/// The independent program's three counts, from the detector's own box pairs.
fn verify(kind: Kind, points: &[Vec3]) {
    let Some(expected) = kind.reference(points.len() - 1) else { return };
    let options = DetectorOptions { neighbours: Neighbours::Segments(1), ..DetectorOptions::default() };
    let curve = [Curve::polyline(points, RADIUS)];
    let mut detector = Detector::new(options);
    for stage in [DetectorStep::Prepare, DetectorStep::Refit, DetectorStep::Boxes] {
        detector.run_stage(&curve, stage).unwrap();
    }
    let neighbours = inputs::neighbours(points);
    let mut counts = [0; 3];
    for &[i, j] in detector.candidates() {
        let (i, j) = (i as usize, j as usize);
        if !rivals::boxes_overlap(points, RADIUS, i, j) {
            continue;
        }
        counts[0] += 1;
        if segment_distance(&points[i], &points[i + 1], &points[j], &points[j + 1]) < 2.0 * RADIUS {
            counts[1] += 1;
            counts[2] += usize::from(j - i > neighbours);
        }
    }
    let verdict = if counts == expected { "as expected" } else { "DIFFERENT" };
    println!(
        "{:<11} {:>8} counts box/capsule/nonlocal {counts:?} {verdict} {expected:?}",
        kind.name(),
        points.len() - 1
    );
    assert_eq!(counts, expected);
}

fn measure(kind: Kind, points: &[Vec3], threads: usize, arguments: &Arguments, rows: &mut Vec<Row>) {
    let n = points.len() - 1;
    let repeat = arguments.repeat;
    let curve = [Curve::polyline(points, RADIUS)];
    let mut push = |stage: &'static str, (seconds, found): (f64, usize)| {
        rows.push(Row { input: kind.name(), segments: n, threads, stage, seconds, found });
    };
    let options = DetectorOptions { zones: false, ..DetectorOptions::default() };
    let mut fresh = || {
        let mut detector = Detector::new(options);
        detector.run_stage(&curve, DetectorStep::Refit).unwrap()
    };
    push("build", median(repeat, &mut fresh));
    let mut detector = Detector::new(options);
    let mut stage = |stage: DetectorStep| median(repeat, || detector.run_stage(&curve, stage).unwrap());
    push("check+exclusion", stage(DetectorStep::Prepare));
    let refit = stage(DetectorStep::Refit);
    push("refit", refit);
    let boxes = stage(DetectorStep::Boxes);
    push("box pairs", boxes);
    if threads == 1 {
        // How the machine itself takes to more data than its caches hold.
        let mut written = Vec::new();
        push("memory: write", median(repeat, || rivals::write_boxes(points, RADIUS, &mut written)));
        push("memory: read", median(repeat, || rivals::read_boxes(&written)));
    }
    let candidates = stage(DetectorStep::Candidates);
    push("capsules", (candidates.0 - boxes.0, candidates.1));
    push("refit+candidates", (refit.0 + candidates.0, candidates.1));
    push("projections", stage(DetectorStep::Sites));
    push("zones", stage(DetectorStep::Zones));
    let mut detector = Detector::new(options);
    push("whole detection", median(repeat, || detector.detect(&curve).unwrap().sites.len()));
    let (kept, found) = detector.memory();
    push("bytes held", (0.0, kept));
    push("bytes of sites", (0.0, found));
    push("forces", median(repeat, || detector.forces(&curve, 1.0).unwrap().forces[0].len()));
    // "assembly" makes Hessians, 5 kB a term: the 3e6 terms of a plectoneme of 1e6 segments would not fit, so beyond
    // 1e5 gradients only.
    let few = if n > 100_000 { 1 } else { repeat.min(3) };
    if n <= 100_000 {
        push("assembly", median(few, || detector.terms(&curve, 1.0, Want::Hessian).unwrap().len()));
    }
    push("terms", median(few, || detector.terms(&curve, 1.0, Want::Gradient).unwrap().len()));
    if threads == 1 {
        let neighbours = inputs::neighbours(points);
        push("plain grid", median(repeat.min(3), || rivals::grid(points, RADIUS, neighbours).len()));
        let mut tree = rivals::Tree::new(points, RADIUS);
        push("parry build", median(repeat.min(3), || rivals::Tree::new(points, RADIUS).num_leaves()));
        push("parry refit+pairs", median(repeat, || tree.refit_and_list(points, RADIUS)));
        let mut chain = rivals::Chain::default();
        push("chain refit+pairs", median(repeat, || chain.refit_and_list(points, RADIUS, neighbours)));
        if n <= 10_000 {
            push("brute force", median(1, || rivals::brute_force(points, RADIUS, neighbours).len()));
        }
    }
}

/// What is compared with other programs: medians on one thread of an input, and its points as little-endian f64 in a
/// file if asked for.
fn round(name: &str, arguments: &Arguments) {
    let kind = *Kind::ALL.iter().find(|kind| kind.name() == name).unwrap();
    let points = kind.points(arguments.segments);
    let neighbours = inputs::neighbours(&points);
    println!("ours neighbours {neighbours}");
    if let Some(file) = &arguments.write {
        let bytes: Vec<u8> =
            points.iter().flat_map(|p| p.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>()).collect();
        std::fs::write(file, bytes).unwrap();
        return;
    }
    let curve = [Curve::polyline(&points, RADIUS)];
    // The same neighbours as the others leave out.
    let options =
        DetectorOptions { zones: false, neighbours: Neighbours::Segments(neighbours), ..DetectorOptions::default() };
    let mut detector = Detector::new(options);
    detector.detect(&curve).unwrap();
    let mut stage = |stage: DetectorStep| median(arguments.repeat, || detector.run_stage(&curve, stage).unwrap());
    let (refit, boxes, candidates) =
        (stage(DetectorStep::Refit), stage(DetectorStep::Boxes), stage(DetectorStep::Candidates));
    println!("ours refit {:.6}\nours boxes {:.6}\nours candidates {:.6}", refit.0, boxes.0, candidates.0);
    println!("ours refit+candidates {:.6}\nours pairs {}\nours near {}", refit.0 + candidates.0, boxes.1, candidates.1);
    let turning = DetectorOptions { zones: false, ..DetectorOptions::default() };
    for (name, options) in [("whole", options), ("whole-by-turning", turning)] {
        let mut detector = Detector::new(options);
        detector.detect(&curve).unwrap();
        let whole = median(arguments.repeat, || detector.detect(&curve).unwrap().sites.len());
        println!("ours {name} {:.6}\nours sites {}", whole.0, whole.1);
    }
}

fn of<'a>(rows: &'a [Row], input: &'a str, stage: &'a str, threads: usize) -> Vec<(f64, f64)> {
    let wanted = |r: &&Row| r.input == input && r.stage == stage && r.threads == threads;
    rows.iter().filter(wanted).map(|r| (r.segments as f64, r.seconds)).collect()
}

fn report(rows: &[Row]) {
    for kind in Kind::ALL {
        for stage in ["refit+candidates", "whole detection", "zones", "forces", "memory: write", "memory: read"] {
            let points = of(rows, kind.name(), stage, 1);
            if points.len() > 1 {
                let name = kind.name();
                println!("exponent {name:<11} {stage:<17} {:.3}  (log time against log segments)", exponent(&points));
            }
        }
    }
    let folder = Path::new("target/scaling");
    std::fs::create_dir_all(folder).unwrap();
    let mut csv = "input,segments,threads,stage,seconds,ns_per_segment,found\n".to_owned();
    for r in rows {
        let ns = r.seconds / r.segments as f64 * 1e9;
        writeln!(csv, "{},{},{},{},{:e},{ns:.2},{}", r.input, r.segments, r.threads, r.stage, r.seconds, r.found)
            .unwrap();
    }
    std::fs::write(folder.join("scaling.csv"), csv).unwrap();
    // The whole only: more lines leave no room for a legend; the table has them.
    let line = |kind: &Kind| {
        let points = of(rows, kind.name(), "whole detection", 1).into_iter().map(|(n, t)| (n, t / n * 1e9)).collect();
        Series { name: kind.title().to_owned(), points, style: SeriesStyle::LinePoints }
    };
    let mut series: Vec<Series> = Kind::ALL.iter().map(line).filter(|s| !s.points.is_empty()).collect();
    // Times from 0 on, and room above the lines for the legend: two points of which nothing is drawn.
    let all = || series.iter().flat_map(|s| &s.points);
    let (first, last) = all().fold((f64::INFINITY, 0.0_f64), |(a, b), p| (a.min(p.0), b.max(p.0)));
    let (middle, top) = ((first * last).sqrt(), 1.5 * all().map(|p| p.1).fold(0.0, f64::max));
    let points = vec![(middle, 0.0), (f64::NAN, 0.0), (middle, top)];
    series.push(Series { name: String::new(), points, style: SeriesStyle::Line });
    let plot = PlotSpec {
        title: "Finding all contact sites of a polyline, one thread".to_owned(),
        x_label: "segments".to_owned(),
        y_label: "processor time per segment, ns".to_owned(),
        series,
        log_x: true,
        ..PlotSpec::default()
    };
    plot_lines(&folder.join("scaling.svg"), &plot).unwrap();
    println!("written: target/scaling/scaling.csv, target/scaling/scaling.svg");
}

fn main() {
    let arguments = arguments();
    if let Some(name) = &arguments.round {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        return pool.install(|| round(name, &arguments));
    }
    let mut rows = Vec::new();
    println!("input       segments thr stage               ms        ns/segment  found");
    for kind in Kind::ALL {
        if arguments.input.as_ref().is_some_and(|name| name != kind.name()) {
            continue;
        }
        for n in [10_000, 100_000, 1_000_000] {
            if n > arguments.max {
                continue;
            }
            let points = kind.points(n);
            verify(kind, &points);
            for threads in 1..=if arguments.one_thread { 1 } else { 2 } {
                let first = rows.len();
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| measure(kind, &points, threads, &arguments, &mut rows));
                for r in &rows[first..] {
                    if r.stage.starts_with("bytes") {
                        let per = r.found as f64 / r.segments as f64;
                        println!(
                            "{:<11} {:>8} {:>3} {:<17} {per:.0} bytes per segment",
                            r.input, r.segments, r.threads, r.stage
                        );
                        continue;
                    }
                    let (ms, ns) = (r.seconds * 1e3, r.seconds / r.segments as f64 * 1e9);
                    println!(
                        "{:<11} {:>8} {:>3} {:<17} {ms:>9.3} {ns:>13.1} {:>9}",
                        r.input, r.segments, r.threads, r.stage, r.found
                    );
                }
            }
        }
    }
    report(&rows);
}
