//! A run as a table: for people ([`StepTable`]) and for programs ([`Columns`]).

use std::fmt;
use std::path::Path;

use crate::error::InputError;
use crate::observe::SNAP;
use crate::observe::report::{JointForce, LineSample, Observation, ObstacleSite, RodEnds, SiteReport};
use crate::scene::Units;

use super::csv::{Cell, columns_in, write_explained};

mod columns;
#[cfg(feature = "runs")]
mod resultants;

pub use columns::Columns;
#[cfg(feature = "runs")]
pub(super) use columns::PRESCRIBED;
#[cfg(feature = "runs")]
pub(super) use resultants::{ResultantsOf, write_resultants};

/// Accepted steps as a table for reading, one line a step, units in the head; link numbers of the first closed rod, or
/// of an open rod if it is the only one.
#[derive(Debug, Clone, Copy)]
pub struct StepTable<'a> {
    /// Names of the units.
    pub units: &'a Units,
    /// The steps.
    pub steps: &'a [Observation],
}

/// Name of a column in two lines, its unit and its width.
type PrintedColumn = ([&'static str; 2], String, usize);

/// The columns, named as in `table.csv` (link numbers without the rod's name). An open rod has no excess link.
fn columns(units: &Units, steps: &[Observation]) -> [PrintedColumn; 13] {
    let link = if steps.iter().any(|step| only_open_rod(step).is_some()) { ["", "link"] } else { ["excess_", "link"] };
    let energy = format!("{} {}", units.force, units.length);
    let turns = || "turns".to_owned();
    let none = String::new;
    [
        (["", "step"], none(), 5),
        (link, turns(), 9),
        (["", "writhe"], turns(), 9),
        (["", "twist"], turns(), 9),
        (["bending_", "energy"], energy.clone(), 11),
        (["twisting_", "energy"], energy.clone(), 11),
        (["stretching_", "energy"], energy.clone(), 12),
        (["shearing_", "energy"], energy, 11),
        (["min_", "gap"], units.length.clone(), 11),
        (["num_", "sites"], none(), 6),
        (["contact_", "force"], units.force.clone(), 12),
        (["num_", "unstable"], none(), 9),
        (["", "iterations"], none(), 11),
    ]
}

/// Names, names continued, units and a rule.
fn head(columns: &[PrintedColumn]) -> [String; 4] {
    let names = |line: usize| -> String {
        columns.iter().map(|(names, _, width)| format!("{:>width$}", names[line])).collect()
    };
    let units: String = columns.iter().map(|(_, unit, width)| format!("{unit:>width$}")).collect();
    let rule = "-".repeat(units.chars().count());
    [names(0), names(1), units, rule]
}

/// The open rod of a model with no other.
fn only_open_rod(step: &Observation) -> Option<&RodEnds> {
    match (&step.links[..], &step.ends[..]) {
        ([], [only]) => Some(only),
        _ => None,
    }
}

/// The cells of a step, each as wide as its column.
fn cells(step: &Observation) -> [String; 13] {
    let [link, writhe, twist] = match (step.links.first(), only_open_rod(step)) {
        (Some(rod), _) => [rod.excess_link, rod.writhe, rod.twist].map(Some),
        (None, Some(rod)) => [rod.link, rod.writhe, Some(rod.twist)],
        (None, None) => [None; 3],
    };
    // six digits and no more, so that long molecules keep columns apart
    let decimals = |x: f64| [100.0, 1e3, 1e4, 1e5].iter().filter(|&&limit| x.abs() < limit).count();
    let turns =
        |value: Option<f64>| value.map_or_else(|| format!("{:>9}", "-"), |x| format!("{:>9}", fixed(x, decimals(x))));
    // what is rounding beside the others, or beside a bend by one radian, is zero
    let e = &step.energies;
    let of_a_bend = step.sizes.iter().map(|size| size.bending / size.length).fold(0.0, f64::max);
    let least = ROUNDING * e.total.abs().max(of_a_bend);
    let energy = |x: f64| number(if x.abs() < least { 0.0 } else { x });
    let iterations = match step.iterations_on_other_meshes {
        0 => step.iterations.to_string(),
        elsewhere => format!("{}+{elsewhere}", step.iterations),
    };
    [
        format!("{:>5}", step.step),
        turns(link),
        turns(writhe),
        turns(twist),
        energy(e.bending),
        energy(e.twisting),
        format!(" {}", energy(e.stretching)),
        energy(e.shearing),
        step.min_gap.map_or_else(|| format!("{:>11}", "-"), |gap| number(gap.lower)),
        format!("{:>6}", step.num_sites),
        format!(" {}", number(step.total_contact_force)),
        format!("{:>9}", step.num_unstable),
        format!("{iterations:>11}"),
    ]
}

/// The line of one step.
fn line(step: &Observation) -> String {
    cells(step).concat() + &remark(step)
}

/// After the last column: a status other than converged, a star for notes.
fn remark(step: &Observation) -> String {
    let status = if step.status == CONVERGED { String::new() } else { format!("  {}", step.status) };
    status + if step.notes.is_empty() { "" } else { "  *" }
}

impl StepTable<'_> {
    /// The table in lines of at most `width` columns: blocks one below the other, each with the numbers of the steps
    /// and as many columns as fit, at least one. Notes are not broken.
    pub fn within(&self, width: usize) -> String {
        let columns = columns(self.units, self.steps);
        let remarks: Vec<String> = self.steps.iter().map(remark).collect();
        let cells: Vec<_> = self.steps.iter().map(cells).collect();
        let longest = remarks.iter().map(|remark| remark.chars().count()).max().unwrap_or(0);
        let (first, mut text) = (columns[0].2, String::new());
        let mut from = 1;
        while from < columns.len() {
            let (mut to, mut used) = (from + 1, first + columns[from].2);
            while let Some(column) = columns.get(to) {
                // remarks follow the last column
                let more = column.2 + if to + 1 == columns.len() { longest } else { 0 };
                if used + more > width {
                    break;
                }
                (to, used) = (to + 1, used + more);
            }
            let shown: Vec<_> = columns[..1].iter().chain(&columns[from..to]).cloned().collect();
            text += if from > 1 { "\n" } else { "" };
            head(&shown).iter().for_each(|line| text += &format!("{line}\n"));
            for (cells, remark) in cells.iter().zip(&remarks) {
                let remark = if to == columns.len() { remark.as_str() } else { "" };
                text += &format!("{}{}{remark}\n", cells[0], cells[from..to].concat());
            }
            from = to;
        }
        self.footnotes().iter().for_each(|note| text += &format!("{note}\n"));
        text
    }

    /// A note with the number that its column of `table.csv` has.
    fn told(&self, step: &Observation, note: &str) -> String {
        let Units { length, force } = self.units;
        match note {
            SNAP => format!("{note}; it set {:.4} {force} {length} of energy free", step.energy_released),
            other => other.to_owned(),
        }
    }

    /// Notes of the steps marked by a star, one a line; steps that follow each other with the same note share a line.
    /// Further lines are counted in the last one.
    fn footnotes(&self) -> Vec<String> {
        let mut runs: Vec<(usize, usize, String)> = Vec::new();
        let notes = self.steps.iter().flat_map(|step| step.notes.iter().map(|note| (step.step, self.told(step, note))));
        for (step, note) in notes {
            match runs.iter_mut().rev().find(|run| run.2 == note && run.1 + 1 == step) {
                Some(run) => run.1 = step,
                None => runs.push((step, step, note)),
            }
        }
        let line = |(from, to, note): &(usize, usize, String)| match from == to {
            true => format!("* step {from}: {note}"),
            false => format!("* steps {from} to {to}: {note}"),
        };
        let left_out = runs.len().saturating_sub(MOST_NOTES);
        // the last ones are those of the final state
        let shown = runs
            .iter()
            .take(MOST_NOTES - 1)
            .chain(runs.iter().skip((MOST_NOTES - 1).max(runs.len().saturating_sub(1))));
        let mut lines: Vec<String> = shown.map(line).collect();
        if left_out > 0 {
            lines.insert(MOST_NOTES - 1, format!("* {left_out} more notes: column notes of table.csv"));
        }
        let blank = |step: &Observation| only_open_rod(step).is_some_and(|rod| rod.link.is_none());
        if self.steps.iter().any(blank) {
            lines.push("- link and writhe of an open rod need parallel ends".to_owned());
        }
        lines
    }
}

/// An energy below this part of the total, or of that of a rod bent by one radian, is printed as zero.
const ROUNDING: f64 = 1e-14;
/// Notes printed below a table.
const MOST_NOTES: usize = 12;

/// A number with so many decimals; rounding must not print as -0.00.
pub(super) fn fixed(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    if text.bytes().any(|c| (b'1'..=b'9').contains(&c)) { text } else { text.trim_start_matches('-').to_owned() }
}

/// [`Observation::status`] of a converged step.
const CONVERGED: &str = "converged";

/// A number in 11 columns, one of them blank: plain where that shows 5 digits, else in powers of ten.
fn number(x: f64) -> String {
    let x = x + 0.0; // + 0.0 turns −0 into 0
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) { format!("{x:>11.4}") } else { format!("{x:>11.3e}") }
}

impl fmt::Display for StepTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", head(&columns(self.units, self.steps)).join("\n"))?;
        self.steps.iter().try_for_each(|step| writeln!(f, "{}", line(step)))?;
        self.footnotes().iter().try_for_each(|note| writeln!(f, "{note}"))
    }
}

/// Name of a rod of a step or site.
fn name_of(rods: &[String], rod: usize) -> Result<&str, InputError> {
    let refuse = || InputError::Count { field: "rods".to_owned(), value: rods.len(), allowed: "one name a rod" };
    rods.get(rod).map(String::as_str).ok_or_else(refuse)
}

/// Length of an interval; across the seam of a closed rod if its end is below its start.
fn length_of(arc: [f64; 2], rod: Option<&f64>) -> f64 {
    let length = arc[1] - arc[0];
    if length < 0.0 { length + rod.copied().unwrap_or(0.0) } else { length }
}

/// Columns of `sites.csv`: name, dimension, meaning.
const SITE_COLUMNS: [[&str; 3]; 21] = [
    ["rod_a", "", "name of the first strand's rod"],
    ["from_a", "L", "arc length where contact begins on strand a"],
    ["to_a", "L", "where it ends; below from_a across the seam of a closed rod"],
    ["rod_b", "", "name of the second strand's rod, or of the obstacle"],
    ["from_b", "L", "arc length where contact begins on strand b; blank with an obstacle"],
    ["to_b", "L", "where it ends"],
    ["kind", "", "point or line"],
    ["length", "L", "of the contact on strand a"],
    ["pressure", "F/L", "mean contact force per length: force over length; 0 at points without a length"],
    ["gap", "L", "smallest gap: distance of the centrelines minus both radii; negative: penetration"],
    ["force", "F", "∫p ds of the contact force per length"],
    ["angle", "degrees", "crossing angle of the strands where the gap is smallest; blank with an obstacle"],
    ["force_on_a_x", "F", FORCE_ON_A],
    ["force_on_a_y", "F", FORCE_ON_A],
    ["force_on_a_z", "F", FORCE_ON_A],
    ["foot_a_x", "L", FOOT_A],
    ["foot_a_y", "L", FOOT_A],
    ["foot_a_z", "L", FOOT_A],
    ["foot_b_x", "L", FOOT_B],
    ["foot_b_y", "L", FOOT_B],
    ["foot_b_z", "L", FOOT_B],
];
const FORCE_ON_A: &str = "contact force on strand a as a vector";
const FOOT_A: &str = "point of the centreline of strand a where the gap is smallest";
const FOOT_B: &str = "point of the centreline of strand b there; blank with an obstacle";

/// Columns of `lines.csv`: name, dimension, meaning.
const LINE_COLUMNS: [[&str; 3]; 7] = [
    ["site", "", "index of the line's site in sites.csv, from 0"],
    ["rod_a", "", "name of the first strand's rod"],
    ["arc_a", "L", "arc length on strand a"],
    ["rod_b", "", "name of the second strand's rod"],
    ["arc_b", "L", "arc length on strand b, opposite"],
    [
        "pressure",
        "F/L",
        "contact force per length of strand a, smoothed over the width of the contact law or half an element",
    ],
    ["gap", "L", "distance of the centrelines minus both radii; negative: penetration"],
];

/// Names of rods and obstacles, lengths \[L\] of the rods, units: what files of contacts name.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Named<'a> {
    pub rods: &'a [String],
    pub lengths: &'a [f64],
    pub obstacles: &'a [String],
    pub units: &'a Units,
}

/// Writes contact sites as CSV, one a line: rods and intervals of arc length, kind, length on rod a, mean force per
/// length, smallest gap, force, crossing angle, force on rod a as a vector, the points of both centrelines where the
/// gap is smallest (see [`SiteReport`]). Sites with obstacles follow: the obstacle's name in place of rod b's; no arc
/// length, angle or foot on it. Units and meanings are in `sites_columns.csv`.
///
/// # Errors
/// [`InputError::Count`] if a rod has no name, [`InputError::Write`] if the file cannot be written.
pub(crate) fn write_sites(
    path: &Path,
    sites: &[SiteReport],
    obstacle_sites: &[ObstacleSite],
    named: Named,
) -> Result<(), InputError> {
    let Named { rods, lengths, obstacles, units } = named;
    let row = |site: &SiteReport| -> Result<Vec<Cell>, InputError> {
        let strand =
            |rod: usize, arc: [f64; 2]| name_of(rods, rod).map(|name| [Cell::from(name), arc[0].into(), arc[1].into()]);
        let mut cells: Vec<Cell> = [strand(site.rod_a, site.arc_a)?, strand(site.rod_b, site.arc_b)?].concat();
        cells.push(site.kind.as_str().into());
        let length = length_of(site.arc_a, lengths.get(site.rod_a));
        cells.extend([length, if length > 0.0 { site.force / length } else { 0.0 }].map(Cell::from));
        cells.extend([site.gap, site.force, site.angle].map(Cell::from));
        cells.extend([site.force_on_a, site.feet[0], site.feet[1]].into_iter().flatten().map(Cell::from));
        Ok(cells)
    };
    let row_of_obstacle = |site: &ObstacleSite| -> Result<Vec<Cell>, InputError> {
        let blank = || Cell::from("");
        let length = length_of(site.arc, lengths.get(site.rod));
        let mut cells = vec![Cell::from(name_of(rods, site.rod)?), site.arc[0].into(), site.arc[1].into()];
        cells.extend([name_of(obstacles, site.obstacle)?.into(), blank(), blank(), site.kind.as_str().into()]);
        cells.extend([length, if length > 0.0 { site.force / length } else { 0.0 }].map(Cell::from));
        cells.extend([site.gap.into(), site.force.into(), blank()]);
        cells.extend([site.force_on_rod, site.nearest].into_iter().flatten().map(Cell::from));
        cells.extend([blank(), blank(), blank()]);
        Ok(cells)
    };
    let rows = sites.iter().map(row).chain(obstacle_sites.iter().map(row_of_obstacle));
    write_explained(path, &columns_in(units, &SITE_COLUMNS), rows.collect::<Result<Vec<_>, _>>()?)
}

/// Writes the pressure along lines of contact as CSV: index of the site (line of `sites.csv`, from 0), rods and arc
/// lengths, force per length of rod a, gap. Units and meanings are in `lines_columns.csv`.
///
/// # Errors
/// As `write_sites`.
pub(crate) fn write_lines(path: &Path, samples: &[LineSample], named: Named) -> Result<(), InputError> {
    let Named { rods, units, .. } = named;
    let row = |sample: &LineSample| -> Result<[Cell; 7], InputError> {
        let (a, b) = (name_of(rods, sample.rod_a)?, name_of(rods, sample.rod_b)?);
        let LineSample { site, arc_a, arc_b, pressure, gap, .. } = *sample;
        Ok([site.into(), a.into(), arc_a.into(), b.into(), arc_b.into(), pressure.into(), gap.into()])
    };
    write_explained(path, &columns_in(units, &LINE_COLUMNS), samples.iter().map(row).collect::<Result<Vec<_>, _>>()?)
}

/// Columns of `joints.csv`: name, dimension, meaning.
const JOINT_COLUMNS: [[&str; 3]; 9] = [
    ["point", "", "index of the point where rods are joined, from 0: the forces of its lines add up to zero"],
    ["rod", "", "name of the rod that the joint acts on"],
    ["arc", "L", "arc length of the joined node on the rod"],
    ["force_x", "F", JOINT_FORCE],
    ["force_y", "F", JOINT_FORCE],
    ["force_z", "F", JOINT_FORCE],
    ["moment_x", "F L", JOINT_MOMENT],
    ["moment_y", "F L", JOINT_MOMENT],
    ["moment_z", "F L", JOINT_MOMENT],
];
const JOINT_FORCE: &str = "force of the joint on the rod as a vector";
const JOINT_MOMENT: &str =
    "moment of the joint on the rod about the node: zero of a pin, zero about the axis of a hinge";

/// Writes the forces of joints on rods as CSV, a line for each joined node; `arcs` are the arc lengths of the nodes of
/// each rod. Units and meanings are in `joints_columns.csv`.
///
/// # Errors
/// As `write_sites`.
pub(crate) fn write_joints(
    path: &Path,
    joints: &[JointForce],
    arcs: &[Vec<f64>],
    named: Named,
) -> Result<(), InputError> {
    let Named { rods, units, .. } = named;
    let row = |at: &JointForce| -> Result<Vec<Cell>, InputError> {
        let mut cells = vec![at.point.into(), name_of(rods, at.rod)?.into(), arcs[at.rod][at.node].into()];
        cells.extend(at.force.into_iter().chain(at.moment).map(Cell::from));
        Ok(cells)
    };
    write_explained(path, &columns_in(units, &JOINT_COLUMNS), joints.iter().map(row).collect::<Result<Vec<_>, _>>()?)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::certificate::Certificate;
    use crate::observe::report::{Energies, RodLink};

    /// A made-up step for the tests of writers.
    pub(in crate::io) fn observation(step: usize) -> Observation {
        let excess_link = -0.1 * step as f64;
        let link = RodLink {
            rod: 0,
            excess_link,
            link: excess_link,
            twist: -0.04,
            excess_twist: -0.04,
            writhe: 0.01,
            seam_moment: 1.5,
        };
        Observation {
            sizes: Vec::new(),
            ends: Vec::new(),
            linking: Vec::new(),
            knots: Vec::new(),
            contact_resultants: 0.0,
            stage: 0,
            step,
            fraction: 0.5,
            status: CONVERGED.to_owned(),
            certificate: Certificate::default(),
            notes: Vec::new(),
            links: vec![link],
            energies: Energies { bending: 123456.789, twisting: 1e-6, total: 123456.789, ..Energies::default() },
            min_gap: None,
            contact_gap: None,
            num_sites: 0,
            sites: Vec::new(),
            obstacle_sites: Vec::new(),
            obstacle_reactions: Vec::new(),
            total_contact_force: 0.0,
            reactions: Vec::new(),
            joints: Vec::new(),
            mesh_error: 0.0,
            num_unstable: 2,
            energy_released: 0.0,
            iterations: 7,
            iterations_on_other_meshes: 12,
            seconds: 0.25,
        }
    }

    #[test]
    fn lines_keep_to_their_columns() {
        let steps: Vec<Observation> = (0..3).map(observation).collect();
        let text = StepTable { units: &Units::default(), steps: &steps }.to_string();
        let widths: Vec<usize> = text.lines().map(|line| line.chars().count()).collect();
        assert_eq!(widths, vec![widths[0]; 7], "{text}");
        assert!(text.contains("1.235e5") && text.contains("1.000e-6"), "{text}");
        let mut long = observation(1);
        long.links[0].excess_link = -26514.04;
        assert_eq!(line(&long).split_whitespace().nth(1), Some("-26514.0"), "columns are apart");
        let failed = Observation { status: "stopped".into(), ..observation(1) };
        assert!(line(&failed).ends_with("  stopped"));
    }

    /// A table for a narrow terminal has the cells of the whole one, in their order, and no line too long.
    #[test]
    fn narrow_terminals_get_blocks_of_columns() {
        let mut steps: Vec<Observation> = (0..12).map(observation).collect();
        steps[11].status = "stopped".to_owned();
        let units = Units::default();
        let table = StepTable { units: &units, steps: &steps };
        let whole: Vec<Vec<String>> =
            steps.iter().map(|step| line(step).split_whitespace().map(str::to_owned).collect()).collect();
        for width in [26, 40, 79, 80, 126, 140, 1000] {
            let text = table.within(width);
            assert!(text.lines().all(|line| line.chars().count() <= width), "{width}:\n{text}");
            let mut rows: Vec<Vec<String>> = (0..12).map(|k| vec![k.to_string()]).collect();
            for block in text.split("\n\n") {
                for (row, line) in rows.iter_mut().zip(block.lines().skip(4)) {
                    let mut words = line.split_whitespace().map(str::to_owned);
                    assert_eq!(words.next(), row.first().cloned(), "{text}");
                    row.extend(words);
                }
            }
            assert_eq!(rows, whole, "{width}:\n{text}");
        }
        assert_eq!(table.within(1000), table.to_string());
        assert!(table.within(1).lines().count() == 12 * 16 + 11, "one column a block");
    }

    #[test]
    fn what_rounds_to_zero_has_no_sign() {
        assert_eq!([-0.004, -0.0, -0.006, 0.0].map(|x| fixed(x, 2)), ["0.00", "0.00", "-0.01", "0.00"]);
        assert_eq!(number(-0.0).trim(), "0.0000");
    }

    fn model(text: &str) -> crate::scene::Scene {
        crate::scene::Scene::from_toml(text, Path::new("")).unwrap()
    }

    /// Every column has a cell in every line; the legend names each.
    #[test]
    fn csv_has_a_column_for_everything() {
        let scene = model(
            r#"
            [[rods]]
            name = "ring"
            closed = true
            shape = { kind = "circle", radius = 1.0 }
            section = { bending = 1.0, twisting = 1.0, stretching = 1e3, shearing = 1e3, contact_radius = 0.05 }
            elements = 8
            [[rods]]
            name = "rod"
            shape = { kind = "line", start = [3.0, 0.0, 0.0], length = 2.0 }
            section = { bending = 1.0, twisting = 1.0, stretching = 1e3, shearing = 1e3, contact_radius = 0.05 }
            elements = 8
            [[supports]]
            rod = "rod"
            at = "start"
            position = true
            rotation = true
            [[supports]]
            rod = "rod"
            at = "end"
            position = ["y", "z"]
            rotation = true
            [[stages]]
            ramp = { rotation = { rod = "rod", at = "end", axis = [1, 0, 0], turns = -2.0 } }
            steps = 4
            [[stages]]
            ramp = { excess_link = { rod = "ring", to = 1.0 } }
            steps = 2
            "#,
        );
        let columns = Columns::new(&scene.model, &scene.stages, &Units::default(), &[], None);
        let names = columns.names();
        for name in [
            "rod_end_turned",
            "excess_link",
            "rod_extension",
            "bending_energy",
            "rod_end_force_y",
            "rod_end_torque",
            "knot_",
            "notes",
        ] {
            assert!(
                names.iter().any(|found| *found == name || (name == "knot_" && found.ends_with("knot"))),
                "{name}: {names:?}"
            );
        }
        assert!(!names.contains(&"rod_end_force_x"), "{names:?}");
        let mut unlike = names.clone();
        unlike.sort_unstable();
        unlike.dedup();
        assert_eq!(unlike.len(), names.len(), "{names:?}");
        let turned = names.iter().position(|name| *name == "rod_end_turned").unwrap();
        assert_eq!(columns.cells(&observation(1))[turned], Cell::Number(-1.0));
        let second = Observation { stage: 1, ..observation(1) };
        assert_eq!(columns.cells(&second)[turned], Cell::Number(-2.0));
    }

    /// An only open rod has its link, writhe and twist where closed rods have theirs; a snap reports its energy with
    /// the unit.
    #[test]
    fn open_rods_and_snaps_are_told() {
        let rod = RodEnds {
            rod: 0,
            start: [0.0; 3],
            end: [0.0; 3],
            twist: 1.25,
            excess_twist: 1.25,
            link: Some(1.5),
            writhe: Some(0.25),
        };
        let (notes, energy_released) = (vec![SNAP.to_owned()], 2.5);
        let step = Observation { links: Vec::new(), ends: vec![rod], notes, energy_released, ..observation(0) };
        let units = Units { length: "nm".to_owned(), force: "pN".to_owned() };
        let text = StepTable { units: &units, steps: &[step] }.to_string();
        assert!(text.contains(" 1.5000   0.2500   1.2500") && !text.contains("excess_"), "{text}");
        assert!(
            text.ends_with("* step 0: snap: the path was no longer stable; it set 2.5000 pN nm of energy free\n"),
            "{text}"
        );
    }

    /// A note of several steps appears once, below the table.
    #[test]
    fn notes_stand_below_the_table() {
        let noted = |step: usize, notes: &[&str]| Observation {
            notes: notes.iter().map(|&note| note.to_owned()).collect(),
            ..observation(step)
        };
        let steps = [noted(0, &[]), noted(1, &["soft"]), noted(2, &["soft", "snap"]), noted(3, &["soft"])];
        let text = StepTable { units: &Units::default(), steps: &steps }.to_string();
        assert!(text.ends_with("\n* steps 1 to 3: soft\n* step 2: snap\n"), "{text}");
        let many: Vec<Observation> = (0..40).map(|k| noted(k, &[&format!("note {k}")])).collect();
        let text = StepTable { units: &Units::default(), steps: &many }.to_string();
        assert!(text.contains("* 28 more notes") && text.ends_with("* step 39: note 39\n"), "{text}");
    }
}
