//! Braid words of the prime knots of up to eight crossings, in Rolfsen's numbering, as tables of knots have them (Jones
//! 1987, Ann. Math. 126:335; KnotInfo). A letter ±k exchanges strands k and k + 1; positive letters are right-handed
//! crossings. Which of two mirror images a name means is not agreed upon: these are those of the words here.

#[cfg(any(test, feature = "scenes"))]
use crate::error::InputError;

/// Name and braid word.
pub(super) const KNOTS: [(&str, &[i32]); 35] = [
    ("3_1", &[1, 1, 1]),
    ("4_1", &[1, -2, 1, -2]),
    ("5_1", &[1, 1, 1, 1, 1]),
    ("5_2", &[1, 1, 1, 2, -1, 2]),
    ("6_1", &[1, 1, 2, -1, -3, 2, -3]),
    ("6_2", &[1, 1, 1, -2, 1, -2]),
    ("6_3", &[1, 1, -2, 1, -2, -2]),
    ("7_1", &[1, 1, 1, 1, 1, 1, 1]),
    ("7_2", &[1, 1, 1, 2, -1, 2, 3, -2, 3]),
    ("7_3", &[1, 1, 1, 1, 1, 2, -1, 2]),
    ("7_4", &[1, 1, 2, -1, 2, 2, 3, -2, 3]),
    ("7_5", &[1, 1, 1, 1, 2, -1, 2, 2]),
    ("7_6", &[1, 1, -2, 1, 3, -2, 3]),
    ("7_7", &[-1, 2, -1, 2, -3, 2, -3]),
    ("8_1", &[1, 1, 2, -1, 2, 3, -2, -4, 3, -4]),
    ("8_2", &[1, 1, 1, 1, 1, -2, 1, -2]),
    ("8_3", &[1, 1, 2, -1, -3, 2, -3, -4, 3, -4]),
    ("8_4", &[-1, -1, -1, 2, -1, 2, 3, -2, 3]),
    ("8_5", &[1, 1, 1, -2, 1, 1, 1, -2]),
    ("8_6", &[1, 1, 1, 1, 2, -1, -3, 2, -3]),
    ("8_7", &[-1, -1, -1, -1, 2, -1, 2, 2]),
    ("8_8", &[-1, -1, -1, -2, 1, 3, -2, 3, 3]),
    ("8_9", &[1, 1, 1, -2, 1, -2, -2, -2]),
    ("8_10", &[-1, -1, -1, 2, -1, -1, 2, 2]),
    ("8_11", &[1, 1, 2, -1, 2, 2, -3, 2, -3]),
    ("8_12", &[1, -2, 1, 3, -2, -4, 3, -4]),
    ("8_13", &[1, 1, -2, 1, -2, -2, -3, 2, -3]),
    ("8_14", &[1, 1, 1, 2, -1, 2, -3, 2, -3]),
    ("8_15", &[1, 1, -2, 1, 3, 2, 2, 2, 3]),
    ("8_16", &[-1, -1, 2, -1, -1, 2, -1, 2]),
    ("8_17", &[1, 1, -2, 1, -2, 1, -2, -2]),
    ("8_18", &[1, -2, 1, -2, 1, -2, 1, -2]),
    ("8_19", &[1, 1, 1, 2, 1, 1, 1, 2]),
    ("8_20", &[1, 1, 1, -2, -1, -1, -1, -2]),
    ("8_21", &[1, 1, 1, 2, -1, -1, 2, 2]),
];

/// The braid word of a knot.
///
/// # Errors
/// [`InputError::Name`] for a name that is not in the table.
#[cfg(any(test, feature = "scenes"))]
pub(crate) fn named(name: &str) -> Result<Vec<i32>, InputError> {
    let found = KNOTS.iter().find(|(known, _)| *known == name);
    found.map(|(_, word)| word.to_vec()).ok_or_else(|| InputError::Name {
        field: "shape.name".to_owned(),
        name: name.to_owned(),
        allowed:
            "a prime knot of three to eight crossings in Rolfsen's numbering, as \"7_4\" (or give a braid or a PD code)"
                .to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::closed_braid::closed_braid;
    use super::*;
    use crate::math::link::alexander;

    /// Determinants of the knots above, from tables of knots.
    const DETERMINANTS: [u32; 35] = [
        3, 5, 5, 7, 9, 11, 13, 7, 11, 13, 15, 17, 19, 21, 13, 17, 17, 19, 21, 23, 23, 25, 25, 27, 27, 29, 29, 31, 33,
        35, 37, 45, 3, 9, 15,
    ];

    #[test]
    fn knots_have_their_determinants() {
        for ((name, word), determinant) in KNOTS.iter().zip(DETERMINANTS) {
            let points = closed_braid(&named(name).unwrap(), None).unwrap();
            let found = alexander(&points).unwrap();
            assert!((found.determinant - f64::from(determinant)).abs() < 1e-6, "{name} {word:?}: {found:?}");
        }
        assert!(named("9_1").unwrap_err().to_string().starts_with("shape.name = \"9_1\": must be a prime knot"));
    }
}
