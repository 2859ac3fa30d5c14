//! Closed braids as curves.

use std::f64::consts::TAU;

use crate::error::InputError;
use crate::math::Vec3;

/// Points on a strand from one crossing to the next.
const POINTS: usize = 16;
/// Way from one crossing to the next along the middle of the braid, in distances of strands: at twice the distance
/// strands cross at about half a right angle.
const PITCH: f64 = 2.5;
/// Smallest radius of the inmost strand, in distances of strands: it bends gently, and leaves the middle free.
const INMOST: f64 = 2.0;

/// A component of the closed braid of a word, around the z-axis; neighbouring strands are 1 apart, as crossing ones
/// are.
///
/// # Errors
/// [`InputError::Inconsistent`] for an empty word or a letter 0; several components and none chosen;
/// [`InputError::Count`] for a component that is not there.
pub(crate) fn closed_braid(word: &[i32], component: Option<usize>) -> Result<Vec<Vec3>, InputError> {
    if word.is_empty() || word.len() > MOST_LETTERS || word.iter().any(|k| *k == 0 || k.unsigned_abs() > MOST_STRANDS) {
        let reason = "is a list of whole numbers such as [1, -2, 1, -2]: ±k exchanges strands k and k + 1; at most \
            1000 letters, and 1 to 100";
        return Err(InputError::inconsistent("shape.braid", reason));
    }
    let strands = word.iter().map(|k| k.unsigned_abs() as usize).max().unwrap_or(0) + 1;
    let components = components(word, strands);
    let chosen = match (component, components.len()) {
        (None, 1) => 0,
        (None, several) => {
            let reason = format!(
                "missing: these are {several} curves, a link. Give each a rod, with component = 0 to {}",
                several - 1
            );
            return Err(InputError::inconsistent("shape.component", reason));
        }
        (Some(chosen), count) if chosen < count => chosen,
        (Some(chosen), _) => {
            let allowed = "less than the number of curves that the braid closes to";
            return Err(InputError::Count { field: "shape.component".to_owned(), value: chosen, allowed });
        }
    };
    let middle = 0.5 * (strands - 1) as f64;
    let radius = (PITCH * word.len() as f64 / TAU).max(INMOST + middle);
    let mut points = Vec::new();
    for &first in &components[chosen] {
        let mut place = first;
        for (slot, &letter) in word.iter().enumerate() {
            let (next, rises) = exchange(place, letter);
            for k in 0..POINTS {
                let part = k as f64 / POINTS as f64;
                let (sin, cos) = (TAU * (slot as f64 + part) / word.len() as f64).sin_cos();
                // from place to place, level at both ends; half a distance up or down where strands cross
                let blend = 0.5 * (1.0 - (0.5 * TAU * part).cos());
                let out = radius - middle + place as f64 + (next as f64 - place as f64) * blend;
                let height = 0.5 * rises * (0.5 * TAU * part).sin().powi(2);
                points.push(Vec3::new(out * cos, out * sin, height));
            }
            place = next;
        }
    }
    Ok(points)
}

/// Half of the distance of the tails of an overhand knot where they wind about each other, over the radius of its loop:
/// a sixth of the loop is open still.
const TAILS_APART: f64 = 0.12;
/// Most half turns of an overhand knot's tails.
const MOST_HALF_TURNS: u32 = 99;

/// An overhand knot in a rod of this length, for a loop of radius 1: a tail along x from the origin, a loop, and a tail
/// along x. Where both tails pass, they wind about each other by half turns, right-handed positive.
///
/// # Errors
/// [`InputError::Inconsistent`] for numbers of half turns that tie no knot; [`InputError::Value`] for a rod that is too
/// short.
pub(crate) fn overhand(length: f64, half_turns: i32) -> Result<Vec<Vec3>, InputError> {
    let count = half_turns.unsigned_abs();
    if count.is_multiple_of(2) || !(3..=MOST_HALF_TURNS).contains(&count) {
        let reason =
            format!("{half_turns} tie no knot: give an odd number, 3 to {MOST_HALF_TURNS} or −{MOST_HALF_TURNS} to −3");
        return Err(InputError::inconsistent("shape.half_turns", reason));
    }
    let crossings = f64::from(count);
    let half = (0.5 * crossings + 0.25) * (2.0 * TAILS_APART).sqrt();
    // both tails wind from −half to half and leave each other over twice that; the loop is round but for its feet
    let wound = |tail: f64| tied(crossings, half, tail);
    let size = |points: &[Vec3]| points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
    let least = 3.0 * half;
    let straight = 0.5 * (length - size(&wound(least)));
    InputError::check(
        "shape.length",
        length,
        straight >= 0.0,
        "longer: there is no room for the knot, over the radius",
    )?;
    let points = wound(least + straight);
    let (first, up) = (points[0], f64::from(half_turns.signum()));
    Ok(points.into_iter().map(|p| p - first).map(|p| Vec3::new(p.x, p.y, up * p.z)).collect())
}

/// The curve of [`overhand`], from x = −`tail` to `tail`.
fn tied(crossings: f64, half: f64, tail: f64) -> Vec<Vec3> {
    // 0 to 1 with level ends
    let smooth = |t: f64| {
        let t = t.clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    let offset = |x: f64| {
        let angle = crossings * 0.5 * TAU * smooth(0.5 + 0.5 * x / half);
        let fade = 1.0 - smooth((x.abs() - half) / (2.0 * half));
        Vec3::new(0.0, -angle.cos(), -angle.sin()) * (TAILS_APART * fade)
    };
    let step = 0.05 * half;
    let count = |length: f64| (length / step).ceil() as usize;
    let (ends, turn) = (count(tail + half), count(TAU));
    let part = |i: usize, n: usize| i as f64 / n as f64;
    let first = (0..ends).map(|i| -tail + (tail + half) * part(i, ends)).map(|x| Vec3::x() * x + offset(x));
    let around = (0..turn).map(|i| TAU * part(i, turn)).map(|a| {
        let base = Vec3::new(a.sin() + half * (0.5 * a).cos(), 1.0 - a.cos(), 0.0);
        base + if a < 0.5 * TAU { offset(half + a) } else { -offset(a - TAU - half) }
    });
    let last = (0..=ends).map(|i| (tail + half) * part(i, ends) - half).map(|x| Vec3::x() * x - offset(x));
    first.chain(around).chain(last).collect()
}

/// Limits of words: more make no rod that can be run.
const MOST_LETTERS: usize = 1000;
const MOST_STRANDS: u32 = 100;

/// Where a letter takes a strand, and whether the strand goes over (1), under (−1) or straight on (0) there. With the
/// braid counterclockwise about z and places outward, a crossing is right-handed where the strand that goes outward is
/// above.
fn exchange(place: usize, letter: i32) -> (usize, f64) {
    let (inner, sign) = (letter.unsigned_abs() as usize - 1, f64::from(letter.signum()));
    match place {
        _ if place == inner => (inner + 1, sign),
        _ if place == inner + 1 => (inner, -sign),
        _ => (place, 0.0),
    }
}

/// The curves of a closed braid: the places at which each begins its rounds.
fn components(word: &[i32], strands: usize) -> Vec<Vec<usize>> {
    let around = |first: usize| word.iter().fold(first, |place, &letter| exchange(place, letter).0);
    let (mut all, mut seen): (Vec<Vec<usize>>, _) = (Vec::new(), vec![false; strands]);
    for first in 0..strands {
        let mut rounds = Vec::new();
        let mut place = first;
        while !seen[place] {
            seen[place] = true;
            rounds.push(place);
            place = around(place);
        }
        if !rounds.is_empty() {
            all.push(rounds);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::alexander;
    use super::super::table::KNOTS;
    use super::*;
    use crate::math::link::linking_number;

    /// Overhand knots have the length, straight tails along one line, and the determinant of the torus knot (2, n).
    #[test]
    fn overhand_knots_are_tied() {
        for (half_turns, length) in [(3, 20.0), (-3, 40.0), (5, 30.0)] {
            let points = overhand(length, half_turns).unwrap();
            let found: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
            assert!((found - length).abs() < 1e-3 * length, "{found}");
            let (first, last) = (points[0], points[points.len() - 1]);
            assert!(first == Vec3::zeros() && last.yz().norm() < 1e-12);
            let mut closed = points.clone();
            closed.extend([[2.0, 0.0], [2.0, -9.0], [-1.0, -9.0]].map(|[x, y]| Vec3::new(x * last.x, y * length, 0.0)));
            let found = alexander(&closed).unwrap().determinant;
            assert!((found - f64::from(half_turns.abs())).abs() < 1e-6, "{half_turns} {found}");
        }
        for (length, half_turns, key) in [(20.0, 2, "half_turns"), (20.0, 1, "half_turns"), (5.0, 3, "length")] {
            let refused = overhand(length, half_turns).unwrap_err().to_string();
            assert!(refused.starts_with(&format!("shape.{key}")), "{refused}");
        }
    }

    /// Strands stay a distance apart, also where they cross.
    #[test]
    fn strands_do_not_touch() {
        for (name, word) in KNOTS {
            let points = closed_braid(word, None).unwrap();
            let count = points.len();
            let apart = |i: usize, j: usize| (j - i).min(count - (j - i)) > 2 * POINTS / 3;
            let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j))).filter(|&(i, j)| apart(i, j));
            let least = pairs.map(|(i, j)| (points[i] - points[j]).norm()).fold(f64::INFINITY, f64::min);
            assert!(least > 0.8, "{name}: {least}");
        }
    }

    /// Two strands that cross twice are a link of one turn, right-handed crossings a positive one.
    #[test]
    fn links_have_components() {
        for (word, link) in [([1, 1], 1.0), ([-1, -1], -1.0)] {
            let curves = [0, 1].map(|k| closed_braid(&word, Some(k)).unwrap());
            assert!((linking_number(&curves[0], &curves[1]) - link).abs() < 1e-9, "{word:?}");
        }
        let refused = closed_braid(&[1, 1], None).unwrap_err().to_string();
        assert!(refused.starts_with("shape.component: missing: these are 2 curves, a link."), "{refused}");
        assert!(
            closed_braid(&[1, 1], Some(2)).unwrap_err().to_string().starts_with("shape.component = 2: must be less")
        );
        for word in [&[][..], &[1, 0], &[101]] {
            assert!(closed_braid(word, None).unwrap_err().to_string().starts_with("shape.braid: is a list of whole"));
        }
    }
}
