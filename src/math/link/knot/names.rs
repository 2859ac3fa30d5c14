//! Names of knots: those with the same Alexander and Jones polynomials as a knot of the table.
//!
//! All prime knots of up to eight crossings and their composites differ in one of the two. Nothing is tabulated but
//! braid words: the polynomials of the named knots are computed as those of any curve.

use std::sync::OnceLock;

use super::jones::Jones;
use super::table::KNOTS;
use super::{Alexander, Invariants, closed_braid, invariants};

/// Largest distance of a value from the whole number that it counts as.
const TOL_WHOLE: f64 = 1e-3;
/// Most crossings of composite knots with names: as many as prime ones.
const MOST_CROSSINGS: u32 = 8;

/// A knot with a name.
#[derive(Clone)]
struct NamedKnot {
    name: String,
    crossings: u32,
    factors: usize,
    alexander: Alexander,
    jones: Jones,
}

/// All knots with names, simple ones first.
fn all() -> &'static [NamedKnot] {
    static ALL: OnceLock<Vec<NamedKnot>> = OnceLock::new();
    ALL.get_or_init(|| {
        let primes: Vec<NamedKnot> = KNOTS.iter().filter_map(|(name, word)| prime(name, word)).flatten().collect();
        let mut all = primes.clone();
        let mut made = primes.iter().enumerate().map(|(last, knot)| (last, knot.clone())).collect::<Vec<_>>();
        while let Some((last, knot)) = made.pop() {
            for (k, factor) in primes.iter().enumerate().skip(last) {
                if knot.crossings + factor.crossings <= MOST_CROSSINGS {
                    made.push((k, composed(&knot, factor)));
                    all.extend(made.last().map(|(_, knot)| knot.clone()));
                }
            }
        }
        all.sort_by_key(|knot| (knot.crossings, knot.factors));
        all
    })
}

/// A knot of the table and its mirror image, where it is another knot.
fn prime(name: &str, word: &[i32]) -> Option<Vec<NamedKnot>> {
    let crossings = name.split('_').next()?.parse().ok()?;
    let Invariants { alexander, jones } = invariants(&closed_braid::closed_braid(word, None).ok()?)?;
    let jones = jones?;
    let knot = NamedKnot { name: name.to_owned(), crossings, factors: 1, alexander, jones };
    let mirrored = NamedKnot { name: format!("{name}*"), jones: jones.mirrored(), ..knot.clone() };
    Some(if jones == jones.mirrored() { vec![knot] } else { vec![knot, mirrored] })
}

fn composed(a: &NamedKnot, b: &NamedKnot) -> NamedKnot {
    let alexander = Alexander {
        determinant: a.alexander.determinant * b.alexander.determinant,
        at_third: a.alexander.at_third * b.alexander.at_third,
    };
    NamedKnot {
        name: format!("{}#{}", a.name, b.name),
        crossings: a.crossings + b.crossings,
        factors: a.factors + b.factors,
        alexander,
        jones: a.jones.composed(b.jones),
    }
}

/// Name of the simplest knot with these invariants; "other" where there is none.
pub(super) fn name(of: &Invariants) -> String {
    let near = |a: f64, b: f64| (a - b).abs() < TOL_WHOLE;
    let fits = |alexander: &Alexander| {
        near(alexander.determinant, of.alexander.determinant) && near(alexander.at_third, of.alexander.at_third)
    };
    if fits(&Alexander::UNKNOT) && of.jones.is_none_or(|jones| jones == Jones::UNKNOT) {
        return "0_1".to_owned();
    }
    let found = all().iter().find(|knot| fits(&knot.alexander) && of.jones.is_none_or(|jones| jones == knot.jones));
    found.map_or_else(|| "other".to_owned(), |knot| knot.name.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No two of all names stand for the same polynomials.
    #[test]
    fn names_differ() {
        let all = all();
        // 35 primes, 28 of them with a mirror image; 14 composites
        let composites = all.iter().filter(|knot| knot.factors > 1).count();
        let mirrored = all.iter().filter(|knot| knot.factors == 1 && knot.name.ends_with('*')).count();
        assert_eq!((all.len() - composites - mirrored, mirrored, composites), (35, 28, 14));
        for (k, a) in all.iter().enumerate() {
            for b in &all[..k] {
                let [same, differ] = [a.alexander == b.alexander && a.jones == b.jones, a.name != b.name];
                assert!(differ && !same, "{} and {}", a.name, b.name);
            }
        }
    }
}
