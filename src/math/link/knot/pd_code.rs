//! From a PD code to a braid, by Vogel's algorithm (Vogel 1990, Comment. Math. Helv. 65:104).
//!
//! Smoothed along their directions, the crossings of a diagram leave circles. While two of them run along one face on
//! the same side, an edge of one is laid over an edge of the other across that face. Then the circles are nested on the
//! sphere, all in one direction: a closed braid, each circle a strand.
//!
//! A dart is an end of an edge at a crossing. Crossing c has the darts 4c to 4c + 3, counterclockwise, as the code has
//! them: the lower strand comes in at 4c and goes out at 4c + 2.

use std::collections::BTreeMap;

use crate::error::InputError;

/// Most crossings of a code, and of the diagram when all circles are nested.
const MOST_CROSSINGS: usize = 1000;

/// A diagram with directions.
struct Diagram {
    /// The other dart of the same edge.
    mate: Vec<usize>,
    /// Whether the strand leaves the crossing there.
    leaves: Vec<bool>,
}

/// The braid word of a PD code: of each crossing its four edges counterclockwise, from the lower one that comes in.
///
/// # Errors
/// [`InputError::Inconsistent`] for a code in which an edge does not occur twice, in which directions contradict each
/// other, that is no picture on the plane, or that falls apart.
pub(crate) fn braid_of(code: &[[i32; 4]]) -> Result<Vec<i32>, InputError> {
    let mut diagram = Diagram::read(code)?;
    let mut circles = diagram.circles();
    while let Some([over, under]) = diagram.defect(&circles) {
        if diagram.num_crossings() >= MOST_CROSSINGS {
            return Err(refused("needs a braid of more than 1000 crossings: give a code with fewer"));
        }
        diagram.lay_over(over, under);
        circles = diagram.circles();
    }
    diagram.word(&circles)
}

fn refused(reason: impl Into<String>) -> InputError {
    InputError::inconsistent("shape.pd", reason)
}

impl Diagram {
    fn read(code: &[[i32; 4]]) -> Result<Self, InputError> {
        if code.is_empty() || code.len() > MOST_CROSSINGS {
            return Err(refused("is a list of 1 to 1000 crossings such as [[1, 5, 2, 4], [3, 1, 4, 6], [5, 3, 6, 2]]"));
        }
        let mut ends: BTreeMap<i32, Vec<usize>> = BTreeMap::new();
        let edges = code.as_flattened();
        edges.iter().enumerate().for_each(|(dart, edge)| ends.entry(*edge).or_default().push(dart));
        let mut mate = vec![0; edges.len()];
        for (edge, darts) in &ends {
            let [a, b] = darts[..] else {
                let times = darts.len();
                return Err(refused(format!("has the edge {edge} at {times} places: each has two ends")));
            };
            (mate[a], mate[b]) = (b, a);
        }
        let leaves = directions(code, &mate)?;
        let diagram = Self { mate, leaves };
        diagram.check_planar()?;
        Ok(diagram)
    }

    fn num_crossings(&self) -> usize {
        self.mate.len() / 4
    }

    /// Euler's formula of a connected picture on the sphere: as many faces as crossings, and two.
    fn check_planar(&self) -> Result<(), InputError> {
        let (mut seen, mut left) = (vec![false; self.num_crossings()], vec![0]);
        while let Some(crossing) = left.pop() {
            if !std::mem::replace(&mut seen[crossing], true) {
                left.extend((0..4).map(|slot| self.mate[4 * crossing + slot] / 4));
            }
        }
        if !seen.iter().all(|seen| *seen) {
            return Err(refused("falls apart into pictures that share no crossing: give each a shape of its own"));
        }
        if self.faces().len() != self.num_crossings() + 2 {
            return Err(refused("is no picture on the plane: edges must be listed counterclockwise at each crossing"));
        }
        Ok(())
    }

    /// Of each face the darts that begin the edges about it, the face on the left of the way along each.
    fn faces(&self) -> Vec<Vec<usize>> {
        self.orbits(|dart| turned(self.mate[dart], 3))
    }

    /// Number of the circle of each edge, at the dart where it begins; other darts have that of their edge, too.
    fn circles(&self) -> Vec<usize> {
        let mut circles = vec![usize::MAX; self.mate.len()];
        let begins = (0..self.mate.len()).filter(|&dart| self.leaves[dart]);
        let mut count = 0;
        for first in begins {
            let mut at = first;
            while circles[at] == usize::MAX {
                (circles[at], circles[self.mate[at]]) = (count, count);
                at = self.onward(self.mate[at]);
            }
            count += usize::from(circles[first] == count);
        }
        circles
    }

    /// The way on along a circle from the dart at which it comes in: the neighbouring one that goes out.
    fn onward(&self, dart: usize) -> usize {
        let next = turned(dart, 1);
        if self.leaves[next] { next } else { turned(dart, 3) }
    }

    /// The cycles of a permutation of the darts.
    fn orbits(&self, next: impl Fn(usize) -> usize) -> Vec<Vec<usize>> {
        let mut seen = vec![false; self.mate.len()];
        let mut all = Vec::new();
        for first in 0..self.mate.len() {
            let mut orbit = Vec::new();
            let mut at = first;
            while !std::mem::replace(&mut seen[at], true) {
                orbit.push(at);
                at = next(at);
            }
            if !orbit.is_empty() {
                all.push(orbit);
            }
        }
        all
    }

    /// Two edges, as darts at which the way along a face begins, that different circles have on one side of it.
    fn defect(&self, circles: &[usize]) -> Option<[usize; 2]> {
        self.faces().iter().find_map(|face| {
            let first = |(k, &a): (usize, &usize)| {
                let unlike = |&&b: &&usize| self.leaves[a] == self.leaves[b] && circles[a] != circles[b];
                face[k + 1..].iter().find(unlike).map(|&b| [a, b])
            };
            face.iter().enumerate().find_map(first)
        })
    }

    /// Lays one edge over another across the face on the left of both darts: two crossings more (Reidemeister's second
    /// move).
    ///
    /// ```text
    ///               p ┌───────┐ q
    ///   under   ←─────│───────│─────←
    ///                 │       │
    ///   over    →─────┘       └─────→
    /// ```
    fn lay_over(&mut self, over: usize, under: usize) {
        let (p, q) = (self.mate.len(), self.mate.len() + 4);
        // edges run with the face on their left, or both against that
        let along = self.leaves[over];
        let begin = |of: &Self, dart: usize| if along { [dart, of.mate[dart]] } else { [of.mate[dart], dart] };
        let ([from, to], [below_from, below_to]) = (begin(self, over), begin(self, under));
        self.mate.extend([0; 8]);
        // the lower strand comes in at 0 and goes out at 2, the upper one goes up at p and down at q, or the other way
        // round
        let (near, far) = if along { (3, 1) } else { (1, 3) };
        self.leaves.extend([false, far == 1, true, far == 3, false, near == 1, true, near == 3]);
        let joined =
            [(from, p + near), (p + far, q + far), (q + near, to), (below_from, q), (q + 2, p), (p + 2, below_to)];
        for (a, b) in joined {
            (self.mate[a], self.mate[b]) = (b, a);
        }
    }

    /// The word of a diagram whose circles are nested: cut along a line from the inmost circle to the outmost.
    fn word(&self, circles: &[usize]) -> Result<Vec<i32>, InputError> {
        let count = circles.iter().max().map_or(0, |most| most + 1);
        let broken = || refused("leaves circles that are not nested");
        let joined = |crossing: usize| {
            let begun = (4 * crossing..4 * crossing + 4).filter(|&dart| self.leaves[dart]);
            begun.map(|dart| circles[dart]).collect::<Vec<_>>()
        };
        let pairs: Vec<Vec<usize>> = (0..self.num_crossings()).map(joined).collect();
        let neighbours = |circle: usize| {
            let beside = pairs.iter().filter(|pair| pair.contains(&circle)).flatten().copied();
            beside.filter(|&other| other != circle).collect::<std::collections::BTreeSet<_>>()
        };
        let inmost = (0..count).find(|&circle| neighbours(circle).len() == 1).ok_or_else(broken)?;
        let faces = self.faces();
        let mut face_of = vec![0; self.mate.len()];
        faces.iter().enumerate().for_each(|(k, face)| face.iter().for_each(|&dart| face_of[dart] = k));
        // edges that the line cuts, from circle to circle
        let begin =
            (0..self.mate.len()).find(|&dart| self.leaves[dart] && circles[dart] == inmost).ok_or_else(broken)?;
        let mut cut = vec![begin];
        let mut place = vec![usize::MAX; count];
        place[inmost] = 0;
        while let Some(&at) = cut.last().filter(|_| cut.len() < count) {
            let beside = [at, self.mate[at]].into_iter().flat_map(|dart| &faces[face_of[dart]]);
            let next = beside.copied().find(|&dart| place[circles[dart]] == usize::MAX).ok_or_else(broken)?;
            place[circles[next]] = cut.len();
            cut.push(if self.leaves[next] { next } else { self.mate[next] });
        }
        // crossings along each circle from the cut on; one is next where it is so on both of its circles
        let along = |&first: &usize| {
            let (mut crossings, mut at) = (Vec::new(), first);
            loop {
                crossings.push(self.mate[at] / 4);
                at = self.onward(self.mate[at]);
                if at == first {
                    return crossings;
                }
            }
        };
        let strands: Vec<Vec<usize>> = cut.iter().map(along).collect();
        let mut done = vec![0; count];
        let mut word = Vec::new();
        while word.len() < self.num_crossings() {
            let inner = (0..count - 1).find(|&k| {
                let next = |k: usize| strands[k].get(done[k]);
                next(k).is_some() && next(k) == next(k + 1)
            });
            let inner = inner.ok_or_else(broken)?;
            let crossing = strands[inner][done[inner]];
            // right-handed where the upper strand goes to the right, seen with the lower one going up
            let sign = if self.leaves[4 * crossing + 1] { 1 } else { -1 };
            word.push(sign * (inner as i32 + 1));
            done[inner] += 1;
            done[inner + 1] += 1;
        }
        Ok(word)
    }
}

/// The dart so many places further on, counterclockwise, at the same crossing.
fn turned(dart: usize, places: usize) -> usize {
    dart / 4 * 4 + (dart + places) % 4
}

/// Whether strands leave at each dart. Lower strands have their directions by the code; upper ones follow from those
/// that they go on in, or, of a curve that is above everywhere, from the numbers of its edges, which rise by one.
fn directions(code: &[[i32; 4]], mate: &[usize]) -> Result<Vec<bool>, InputError> {
    let mut leaves: Vec<Option<bool>> = [Some(false), None, Some(true), None].repeat(code.len());
    let mut left: Vec<usize> = (0..code.len()).collect();
    while !left.is_empty() {
        let known = |&at: &usize| {
            let by = |dart: usize, leaves: &[Option<bool>]| leaves[mate[dart]].map(|leaves| !leaves);
            let right = by(4 * at + 1, &leaves).or(by(4 * at + 3, &leaves).map(|leaves| !leaves));
            right.map(|right| (at, right))
        };
        let rises = |at: usize| {
            let [_, right, _, before] = code[at];
            right == before + 1 || before > right + 1
        };
        let (at, right) = left.iter().find_map(known).unwrap_or((left[0], rises(left[0])));
        leaves[4 * at + 1] = Some(right);
        leaves[4 * at + 3] = Some(!right);
        left.retain(|&other| other != at);
    }
    let leaves: Vec<bool> = leaves.into_iter().map(|leaves| leaves.unwrap_or(false)).collect();
    match (0..mate.len()).find(|&dart| leaves[dart] == leaves[mate[dart]]) {
        Some(dart) => {
            let edge = code.as_flattened()[dart];
            Err(refused(format!(
                "gives the edge {edge} two directions: list each crossing from its lower incoming edge"
            )))
        }
        None => Ok(leaves),
    }
}

#[cfg(test)]
mod tests {
    use super::super::closed_braid::closed_braid;
    use super::*;
    use crate::math::link::{knot_type, linking_number};

    /// Codes as KnotInfo has them; of which the last two are not alternating.
    #[test]
    fn codes_are_the_knots_of_their_names() {
        let codes: [(&str, &[[i32; 4]]); 6] = [
            ("3_1", &[[1, 5, 2, 4], [3, 1, 4, 6], [5, 3, 6, 2]]),
            ("4_1", &[[4, 2, 5, 1], [8, 6, 1, 5], [6, 3, 7, 4], [2, 7, 3, 8]]),
            ("6_1", &[[1, 7, 2, 6], [3, 10, 4, 11], [5, 3, 6, 2], [7, 1, 8, 12], [9, 4, 10, 5], [11, 9, 12, 8]]),
            (
                "7_4",
                &[
                    [2, 10, 3, 9],
                    [4, 12, 5, 11],
                    [6, 14, 7, 13],
                    [8, 4, 9, 3],
                    [10, 2, 11, 1],
                    [12, 8, 13, 7],
                    [14, 6, 1, 5],
                ],
            ),
            (
                "8_19",
                &[
                    [2, 14, 3, 13],
                    [5, 11, 6, 10],
                    [7, 15, 8, 14],
                    [9, 5, 10, 4],
                    [11, 7, 12, 6],
                    [12, 2, 13, 1],
                    [15, 9, 16, 8],
                    [16, 4, 1, 3],
                ],
            ),
            (
                "8_20",
                &[
                    [1, 7, 2, 6],
                    [4, 13, 5, 14],
                    [5, 9, 6, 8],
                    [7, 3, 8, 2],
                    [10, 15, 11, 16],
                    [12, 9, 13, 10],
                    [14, 3, 15, 4],
                    [16, 11, 1, 12],
                ],
            ),
        ];
        for (name, code) in codes {
            let found = |code: &[[i32; 4]]| {
                let word = braid_of(code).unwrap();
                (knot_type(&closed_braid(&word, None).unwrap()).unwrap().name, word)
            };
            assert_eq!(found(code).0, name, "{:?}", found(code).1);
            // seen in a mirror: clockwise for counterclockwise
            let mirrored: Vec<[i32; 4]> = code.iter().map(|&[i, j, k, l]| [i, l, k, j]).collect();
            assert_eq!(found(&mirrored).0, if name == "4_1" { "4_1".to_owned() } else { format!("{name}*") });
        }
    }

    /// Two rings through each other, of both hands, and one that lies on the other.
    #[test]
    fn links_have_their_turns() {
        for (code, link) in [
            ([[1, 4, 2, 3], [3, 2, 4, 1]], -1.0),
            ([[1, 3, 2, 4], [3, 1, 4, 2]], 1.0),
            ([[1, 4, 2, 3], [2, 4, 1, 3]], 0.0),
        ] {
            let word = braid_of(&code).unwrap();
            let curves = [0, 1].map(|k| closed_braid(&word, Some(k)).unwrap());
            assert!((linking_number(&curves[0], &curves[1]) - link).abs() < 1e-9, "{code:?}: {word:?}");
        }
    }

    #[test]
    fn other_codes_are_refused() {
        let cases: [(&[[i32; 4]], &str); 5] = [
            (&[], "is a list of 1 to 1000 crossings"),
            (&[[1, 5, 2, 4], [3, 1, 4, 6], [5, 3, 6, 9]], "has the edge 2 at 1 places"),
            (&[[1, 5, 2, 4], [1, 3, 4, 6], [5, 3, 6, 2]], "gives the edge 1 two directions"),
            (&[[1, 1, 2, 2], [3, 3, 4, 4]], "falls apart"),
            (&[[1, 2, 2, 1], [3, 3, 4, 4]], "falls apart"),
        ];
        for (code, reason) in cases {
            let said = braid_of(code).unwrap_err().to_string();
            assert!(said.starts_with(&format!("shape.pd: {reason}")), "{code:?}: {said}");
        }
        // the trefoil with one crossing listed clockwise
        let said = braid_of(&[[1, 4, 2, 5], [3, 1, 4, 6], [5, 3, 6, 2]]).unwrap_err().to_string();
        assert!(said.contains("no picture on the plane") || said.contains("two directions"), "{said}");
    }
}
