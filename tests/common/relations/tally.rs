//! The table: how many scenes agree, relation by relation and quantity by quantity.

use std::fmt::Write;

use super::measure::Quantity;
use super::relation::{Findings, Relation};

/// A number as `3e-9`, or as `–` where there is nothing.
fn brief(x: f64) -> String {
    if x.is_finite() { format!("{x:.0e}") } else { "–".to_owned() }
}

/// A row of relation and quantity: scenes, those that agree, the largest difference of these and of all.
pub fn table(all: &[Findings]) -> String {
    let mut out =
        "| relation | quantity | scenes | agree | tolerance | largest of those that agree | largest |\n".to_owned();
    out.push_str("|---|---|---|---|---|---|---|\n");
    for relation in Relation::ALL {
        for quantity in Quantity::ALL {
            let differences = all.iter().flat_map(|it| &it.differences);
            let of: Vec<_> = differences.filter(|it| (it.relation, it.quantity) == (relation, quantity)).collect();
            if of.is_empty() {
                continue;
            }
            let agreeing: Vec<_> = of.iter().filter(|it| it.agrees()).collect();
            let worst = agreeing.iter().map(|it| it.size).fold(0.0, f64::max);
            let largest = of.iter().map(|it| it.size).fold(0.0, f64::max);
            let tolerance = relation.tolerance(quantity);
            let _ = writeln!(
                out,
                "| {} | {} | {} | {} | {} | {} | {} |",
                relation.name(),
                quantity.name(),
                of.len(),
                agreeing.len(),
                brief(tolerance),
                brief(worst),
                brief(largest)
            );
        }
    }
    out
}
