//! The table: how many scenes agree, relation by relation, and by how much they differ.

use std::fmt::Write;

use super::known::is_known;
use super::measure::Quantity;
use super::relation::{Difference, Findings, Relation};

/// Quantities with a column of their own.
const COLUMNS: [Quantity; 5] =
    [Quantity::Energy, Quantity::Position, Quantity::Reaction, Quantity::Contact, Quantity::Link];

/// A number as `3e-9`, or as `–` where there is nothing.
fn brief(x: f64) -> String {
    if x.is_finite() { format!("{x:.0e}") } else { "–".to_owned() }
}

/// The largest difference of a quantity under a relation among some scenes; NaN where there is none.
fn worst(scenes: &[&Findings], relation: Relation, quantity: Quantity) -> f64 {
    let differences = scenes.iter().flat_map(|it| &it.differences);
    let of = differences.filter(|it| (it.relation, it.quantity) == (relation, quantity));
    of.map(|it| it.size).fold(f64::NAN, f64::max)
}

/// A row of a relation: scenes, those that agree, those known not to, and the largest differences of those that agree.
pub fn table(all: &[Findings]) -> String {
    let mut out = "| relation | scenes | agree | known |".to_owned();
    COLUMNS.iter().for_each(|quantity| {
        let _ = write!(out, " {} |", quantity.name());
    });
    out.push_str("\n|---|---|---|---|---|---|---|---|---|\n");
    for relation in Relation::ALL {
        let of: Vec<&Findings> =
            all.iter().filter(|it| it.differences.iter().any(|it| it.relation == relation)).collect();
        if of.is_empty() {
            continue;
        }
        let (agree, differ): (Vec<&Findings>, Vec<_>) = of.iter().partition(|it| !it.broken().contains(&relation));
        let known = differ.iter().filter(|it| is_known(relation, &it.name)).count();
        let _ = write!(out, "| {} | {} | {} | {known} |", relation.name(), of.len(), agree.len());
        COLUMNS.iter().for_each(|&quantity| {
            let _ = write!(out, " {} |", brief(worst(&agree, relation, quantity)));
        });
        out.push('\n');
    }
    out
}

/// Findings as lines: scene, relation, quantity, whether contact bears a force, and size, tabs between them.
pub fn lines(found: &Findings) -> String {
    let line = |it: &Difference| {
        let names = [found.name.as_str(), it.relation.name(), it.quantity.name()].join("\t");
        format!("{names}\t{}\t{:e}\n", it.bears, it.size)
    };
    found.differences.iter().map(line).collect()
}

/// Findings from such lines, the last ones of each scene, relation and quantity; lines that are none are left out.
pub fn from_lines(text: &str) -> Vec<Findings> {
    let mut all: Vec<Findings> = Vec::new();
    for line in text.lines() {
        let [name, relation, quantity, bears, size] = line.split('\t').collect::<Vec<_>>()[..] else { continue };
        let relation = Relation::ALL.into_iter().find(|it| it.name() == relation);
        let quantity = Quantity::ALL.into_iter().find(|it| it.name() == quantity);
        let (Some(relation), Some(quantity)) = (relation, quantity) else { continue };
        let (Ok(bears), Ok(size)) = (bears.parse(), size.parse()) else { continue };
        let at = all.iter().position(|it| it.name == name).unwrap_or_else(|| {
            all.push(Findings {
                name: name.to_owned(),
                differences: Vec::new(),
                notes: Vec::new(),
                checks: Vec::new(),
            });
            all.len() - 1
        });
        all[at].differences.retain(|it| (it.relation, it.quantity, it.bears) != (relation, quantity, bears));
        all[at].differences.push(Difference { relation, quantity, bears, size });
    }
    all
}
