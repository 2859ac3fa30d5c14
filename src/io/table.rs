//! A run as a table: for people ([`StepTable`]) and for programs ([`write_steps`]).

use std::fmt;
use std::path::Path;

use crate::error::InputError;
use crate::observe::report::{Observation, SiteReport};
use crate::scene::Units;

use super::csv::{Cell, write_table};

/// Accepted steps as a table for reading, one line a step, units in the head; link numbers of the first closed rod.
///
/// Columns may be printed as they come: [`StepTable::head`], then [`StepTable::line`] for each step.
#[derive(Debug, Clone, Copy)]
pub struct StepTable<'a> {
    /// Names of the units.
    pub units: &'a Units,
    /// The steps.
    pub steps: &'a [Observation],
}

/// Name and unit of each column, and its width.
fn columns(units: &Units) -> [(&'static str, String, usize); 13] {
    let energy = format!("{} {}", units.force, units.length);
    let turns = || "turns".to_owned();
    let none = String::new;
    [
        ("step", none(), 5),
        ("ex. link", turns(), 9),
        ("writhe", turns(), 9),
        ("twist", turns(), 9),
        ("bending", energy.clone(), 11),
        ("twisting", energy.clone(), 11),
        ("stretch", energy.clone(), 11),
        ("shear", energy, 11),
        ("least gap", units.length.clone(), 11),
        ("sites", none(), 6),
        ("contact", units.force.clone(), 11),
        ("unst.", none(), 6),
        ("iter.", none(), 9),
    ]
}

impl StepTable<'_> {
    /// The two head lines (names, units) and a rule.
    pub fn head(units: &Units) -> String {
        let columns = columns(units);
        let names: String = columns.iter().map(|(name, _, width)| format!("{name:>width$}")).collect();
        let units: String = columns.iter().map(|(_, unit, width)| format!("{unit:>width$}")).collect();
        format!("{names}\n{units}\n{}", "-".repeat(names.len()))
    }

    /// The line of one step.
    pub fn line(step: &Observation) -> String {
        let link = step.links.first();
        let turns = |value: Option<f64>| value.map_or_else(|| format!("{:>9}", "-"), |x| format!("{:>9}", fixed(x, 4)));
        let gap = step.min_gap.map_or_else(|| format!("{:>11}", "-"), |gap| number(gap.lower));
        let e = &step.energies;
        let mut line = format!("{:>5}", step.step);
        line += &[link.map(|l| l.excess_link), link.map(|l| l.writhe), link.map(|l| l.twist)].map(turns).concat();
        line += &[e.bend, e.twist, e.stretch, e.shear].map(number).concat();
        line += &format!("{gap}{:>6}{}", step.num_sites, number(step.total_contact_force));
        let iterations = match step.iterations_elsewhere {
            0 => step.iterations.to_string(),
            elsewhere => format!("{}+{elsewhere}", step.iterations),
        };
        line += &format!("{:>6}{iterations:>9}", step.num_unstable);
        if step.status != CONVERGED {
            line += &format!("  {}", step.status);
        }
        if !step.notes.is_empty() {
            line += "  see notes";
        }
        line
    }
}

/// A number with so many decimals; rounding must not print as -0.00.
pub(super) fn fixed(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    if text.bytes().any(|c| (b'1'..=b'9').contains(&c)) { text } else { text.trim_start_matches('-').to_owned() }
}

/// What [`Observation::status`] says of a converged step.
const CONVERGED: &str = "converged";

/// A number in 11 columns: plain where that shows 5 digits, else in powers of ten.
fn number(x: f64) -> String {
    let x = x + 0.0; // + 0.0 turns −0 into 0
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) { format!("{x:>11.4}") } else { format!("{x:>11.3e}") }
}

impl fmt::Display for StepTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", Self::head(self.units))?;
        self.steps.iter().try_for_each(|step| writeln!(f, "{}", Self::line(step)))
    }
}

/// Writes the steps as CSV: step, stage, fraction, link numbers of each closed rod, energies, smallest gap (lower
/// bound), sites, contact force, unstable directions, energy released by snaps, iterations (and those on shorter rods or coarser meshes),
/// seconds, status. Units as in the scene, links in turns.
///
/// `rods` are the names of all rods; where several are closed their columns carry the name.
///
/// # Errors
/// [`InputError::Count`] if a rod has no name, [`InputError::Write`] if the file cannot be written.
pub fn write_steps(path: &Path, rods: &[String], steps: &[Observation]) -> Result<(), InputError> {
    let header = names(rods, steps)?;
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    write_table(path, &header, steps.iter().map(cells))
}

/// Names of the columns of [`write_steps`].
pub(super) fn names(rods: &[String], steps: &[Observation]) -> Result<Vec<String>, InputError> {
    let closed: Vec<usize> =
        steps.first().map_or_else(Vec::new, |step| step.links.iter().map(|link| link.rod).collect());
    let mut header: Vec<String> = ["step", "stage", "fraction"].map(str::to_owned).to_vec();
    for rod in &closed {
        let suffix = if closed.len() > 1 { format!("_{}", name_of(rods, *rod)?) } else { String::new() };
        header.extend(
            ["excess_link", "link", "twist", "excess_twist", "writhe", "seam_moment"]
                .map(|name| format!("{name}{suffix}")),
        );
    }
    let rest = ["stretch", "shear", "bend", "twist_energy", "contact", "total", "min_gap", "num_sites"];
    header.extend(rest.map(str::to_owned));
    header.extend(["total_contact_force", "num_unstable", "energy_released", "iterations"].map(str::to_owned));
    header.extend(["iterations_elsewhere", "seconds", "status"].map(str::to_owned));
    Ok(header)
}

/// Values of the columns of [`write_steps`].
pub(super) fn cells(step: &Observation) -> Vec<Cell> {
    let e = &step.energies;
    let mut cells = vec![step.step.into(), step.stage.into(), step.fraction.into()];
    for link in &step.links {
        cells.extend(
            [link.excess_link, link.link, link.twist, link.excess_twist, link.writhe, link.seam_moment].map(Cell::from),
        );
    }
    cells.extend([e.stretch, e.shear, e.bend, e.twist, e.contact, e.total].map(Cell::from));
    cells.push(step.min_gap.map_or_else(|| Cell::from(""), |gap| gap.lower.into()));
    cells.extend([step.num_sites.into(), step.total_contact_force.into(), step.num_unstable.into()]);
    cells.push(step.energy_released.into());
    cells.extend([step.iterations.into(), step.iterations_elsewhere.into()]);
    cells.extend([step.seconds.into(), step.status.as_str().into()]);
    cells
}

/// Name of a rod that a step or site tells of.
fn name_of(rods: &[String], rod: usize) -> Result<&str, InputError> {
    let refuse = || InputError::Count { field: "rods".to_owned(), value: rods.len(), allowed: "one name a rod" };
    rods.get(rod).map(String::as_str).ok_or_else(refuse)
}

/// Writes contact sites as CSV, one a line: rods and intervals of arc length, kind, smallest gap, force, crossing angle,
/// force on rod a as a vector, the points of both centrelines where the gap is smallest (see [`SiteReport`]). `rods`
/// are the names of all rods.
///
/// # Errors
/// [`InputError::Count`] if a rod has no name, [`InputError::Write`] if the file cannot be written.
pub fn write_sites(path: &Path, rods: &[String], sites: &[SiteReport]) -> Result<(), InputError> {
    let header = [
        "rod_a",
        "from_a",
        "to_a",
        "rod_b",
        "from_b",
        "to_b",
        "kind",
        "gap",
        "force",
        "angle",
        "force_on_a_x",
        "force_on_a_y",
        "force_on_a_z",
        "foot_a_x",
        "foot_a_y",
        "foot_a_z",
        "foot_b_x",
        "foot_b_y",
        "foot_b_z",
    ];
    let row = |site: &SiteReport| -> Result<Vec<Cell>, InputError> {
        let strand =
            |rod: usize, arc: [f64; 2]| name_of(rods, rod).map(|name| [Cell::from(name), arc[0].into(), arc[1].into()]);
        let mut cells: Vec<Cell> = [strand(site.rod_a, site.arc_a)?, strand(site.rod_b, site.arc_b)?].concat();
        cells.push(site.kind.as_str().into());
        cells.extend([site.gap, site.force, site.angle].map(Cell::from));
        cells.extend([site.force_on_a, site.feet[0], site.feet[1]].into_iter().flatten().map(Cell::from));
        Ok(cells)
    };
    write_table(path, &header, sites.iter().map(row).collect::<Result<Vec<_>, _>>()?)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
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
            stage: 0,
            step,
            fraction: 0.5,
            status: CONVERGED.to_owned(),
            notes: Vec::new(),
            links: vec![link],
            energies: Energies { bend: 123456.789, twist: 1e-9, total: 123456.789, ..Energies::default() },
            min_gap: None,
            num_sites: 0,
            sites: Vec::new(),
            total_contact_force: 0.0,
            reactions: Vec::new(),
            num_unstable: 2,
            energy_released: 0.0,
            iterations: 7,
            iterations_elsewhere: 12,
            seconds: 0.25,
        }
    }

    #[test]
    fn lines_keep_to_their_columns() {
        let steps: Vec<Observation> = (0..3).map(observation).collect();
        let text = StepTable { units: &Units::default(), steps: &steps }.to_string();
        let widths: Vec<usize> = text.lines().map(|line| line.chars().count()).collect();
        assert_eq!(widths, vec![widths[0]; 6], "{text}");
        assert!(text.contains("123456.7890") && text.contains("1.000e-9"), "{text}");
        let failed = Observation { status: "stopped".into(), ..observation(1) };
        assert!(StepTable::line(&failed).ends_with("  stopped"));
    }

    #[test]
    fn what_rounds_to_zero_has_no_sign() {
        assert_eq!([-0.004, -0.0, -0.006, 0.0].map(|x| fixed(x, 2)), ["0.00", "0.00", "-0.01", "0.00"]);
        assert_eq!(number(-0.0).trim(), "0.0000");
    }

    /// Symptom: too few names panicked. Mechanism: they were indexed by the rods of the steps.
    #[test]
    fn rods_without_a_name_are_refused() {
        let path = Path::new("/nowhere/steps.csv");
        let mut step = observation(0);
        let other = RodLink { rod: 1, ..step.links[0] };
        step.links.push(other);
        let error = write_steps(path, &["dna".into()], &[step]).unwrap_err().to_string();
        assert_eq!(error, "rods = 1: must be one name a rod");
    }

    #[test]
    fn csv_has_a_column_for_everything() {
        let path = std::env::temp_dir().join(format!("supercoil_steps_{}.csv", std::process::id()));
        write_steps(&path, &["dna".into()], &[observation(0), observation(1)]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert!(
            text.starts_with("step,stage,fraction,excess_link,link,twist,excess_twist,writhe,seam_moment,stretch,"),
            "{text}"
        );
        assert!(text.lines().nth(2).unwrap().starts_with("1,0,0.5,-0.1,-0.1,-0.04,-0.04,0.01,1.5,"), "{text}");
    }
}
