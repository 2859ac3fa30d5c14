//! Relations that do not hold yet, each with the mechanism. A test fails where one that is listed holds, so that the list
//! shrinks.

use super::relation::Relation;

/// A relation that does not hold, and scenes for which it does not.
pub struct Known {
    pub relation: Relation,
    pub scenes: &'static [&'static str],
    /// The fault.
    pub reason: &'static str,
}

pub const KNOWN: &[Known] = &[];

/// Whether the failure is listed.
pub fn is_known(relation: Relation, scene: &str) -> bool {
    KNOWN.iter().any(|it| it.relation == relation && it.scenes.contains(&scene))
}
