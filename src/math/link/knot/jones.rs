//! The Jones polynomial of a diagram at a number of a finite field, by Kauffman's bracket (Kauffman 1987, Topology
//! 26:395).
//!
//! `V = (−A³)^(−w) ⟨D⟩` with the writhe w of the diagram; ⟨ ⟩ resolves each crossing into `A ⟨)(⟩ + A⁻¹ ⟨≍⟩`, a closed
//! curve counts `−A² − A⁻²`, and t = A⁻⁴. The crossings are resolved one by one: what is kept are the ways in which the
//! ends of the part that is done are joined, so time grows with the width of the diagram, not with 2 to the number of
//! crossings. Two polynomials of degree n over 𝔽ₚ have the same value at a number that knows nothing of them with a
//! probability below n/p.

use std::collections::BTreeMap;

use super::diagram::DiagramNode;

/// A Mersenne prime, because products modulo it need no division.
const P: u64 = (1 << 61) - 1;
/// The number A: any will do.
const A: u64 = 0x1234_5678_9ABC_DEF1 % P;
/// Most ways to join the ends that are kept: a diagram cut at some 20 ends, a tenth of a second.
const MOST_WAYS: usize = 6000;

fn add(a: u64, b: u64) -> u64 {
    (a + b) % P
}

fn times(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    add((product & u128::from(P)) as u64, (product >> 61) as u64)
}

fn negative(a: u64) -> u64 {
    (P - a) % P
}

fn power(mut base: u64, mut exponent: u64) -> u64 {
    let mut value = 1;
    while exponent > 0 {
        if exponent & 1 == 1 {
            value = times(value, base);
        }
        base = times(base, base);
        exponent >>= 1;
    }
    value
}

fn inverse(a: u64) -> u64 {
    power(a, P - 2)
}

/// The Jones polynomial at two numbers of which one is the other's inverse.
///
/// The mirror image has the values in the other order, a composite knot their products.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Jones(pub [u64; 2]);

impl Jones {
    /// That of no knot.
    pub(super) const UNKNOT: Self = Self([1, 1]);

    pub(super) fn mirrored(self) -> Self {
        Self([self.0[1], self.0[0]])
    }

    pub(super) fn composed(self, other: Self) -> Self {
        Self([0, 1].map(|k| times(self.0[k], other.0[k])))
    }
}

/// The polynomial of a diagram; `None` for one that is too wide.
pub(super) fn jones(diagram: &[DiagramNode]) -> Option<Jones> {
    if diagram.is_empty() {
        return Some(Jones::UNKNOT);
    }
    let (a, b) = (A, inverse(A));
    let writhe: i64 = diagram.iter().map(|node| node.sign).sum();
    let [down, up] = [a, b].map(|number| power(negative(power(number, 3)), writhe.unsigned_abs()));
    let frame = if writhe > 0 { [up, down] } else { [down, up] };
    let [at_a, at_b] = bracket(diagram, [a, b])?;
    Some(Jones([times(at_a, frame[0]), times(at_b, frame[1])]))
}

/// Pairs of ends that are joined, in order.
type Ways = Vec<[usize; 2]>;

/// ⟨D⟩ at two inverse numbers, 1 for a circle.
fn bracket(diagram: &[DiagramNode], [a, b]: [u64; 2]) -> Option<[u64; 2]> {
    let circle = negative(add(times(a, a), times(b, b)));
    let mut left: Vec<[usize; 4]> = diagram.iter().map(|node| node.edges).collect();
    let mut open: Vec<usize> = Vec::new();
    let mut sums: BTreeMap<Ways, [u64; 2]> = BTreeMap::from([(Vec::new(), [1, 1])]);
    while !left.is_empty() {
        // the crossing most of whose edges are open already leaves the fewest
        let known = |edges: &[usize; 4]| edges.iter().filter(|edge| open.contains(edge)).count();
        let next = (0..left.len()).rev().max_by_key(|&k| known(&left[k]))?;
        let edges = left.remove(next);
        for edge in edges {
            match open.iter().position(|at| *at == edge) {
                Some(at) => drop(open.swap_remove(at)),
                None => open.push(edge),
            }
        }
        let [i, j, k, l] = edges;
        let mut after = BTreeMap::new();
        for (ways, value) in sums {
            for (pairs, factors) in [([[i, j], [k, l]], [a, b]), ([[i, l], [j, k]], [b, a])] {
                let mut ways = ways.clone();
                let circles = pairs.into_iter().filter(|&[x, y]| join(&mut ways, x, y)).count();
                ways.sort_unstable();
                let sum = after.entry(ways).or_insert([0, 0]);
                let round = power(circle, circles as u64);
                for at in 0..2 {
                    sum[at] = add(sum[at], times(times(value[at], factors[at]), round));
                }
            }
        }
        if after.len() > MOST_WAYS {
            return None;
        }
        sums = after;
    }
    let whole = sums.get(&Vec::new())?;
    Some(whole.map(|value| times(value, inverse(circle))))
}

/// Joins two ends; whether that closes a circle.
fn join(ways: &mut Ways, x: usize, y: usize) -> bool {
    let mut other_end = |end: usize| match ways.iter().position(|pair| pair.contains(&end)) {
        Some(at) => {
            let [p, q] = ways.swap_remove(at);
            if p == end { q } else { p }
        }
        None => end,
    };
    if x == y {
        return true;
    }
    let from = other_end(x);
    if from == y {
        return true;
    }
    let to = other_end(y);
    ways.push([from.min(to), from.max(to)]);
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// t^k at A: t = A⁻⁴.
    fn t(exponent: i32) -> u64 {
        let value = power(A, 4 * u64::from(exponent.unsigned_abs()));
        if exponent > 0 { inverse(value) } else { value }
    }

    /// Right-handed trefoil: t + t³ − t⁴; figure-eight: t⁻² − t⁻¹ + 1 − t + t² (Jones 1987).
    #[test]
    fn polynomials_of_two_knots() {
        let node = |edges, sign| DiagramNode { edges, sign };
        let trefoil = [node([0, 4, 1, 3], 1), node([2, 0, 3, 5], 1), node([4, 2, 5, 1], 1)];
        let right = add(add(t(1), t(3)), negative(t(4)));
        assert_eq!(jones(&trefoil).unwrap().0[0], right);
        let eight = [node([3, 1, 4, 0], 1), node([7, 5, 0, 4], 1), node([5, 2, 6, 3], -1), node([1, 6, 2, 7], -1)];
        let sum = [t(-2), negative(t(-1)), 1, negative(t(1)), t(2)].into_iter().fold(0, add);
        assert_eq!(jones(&eight).unwrap(), Jones([sum, sum]));
    }

    /// A kink of either hand changes nothing.
    #[test]
    fn kinks_do_not_count() {
        for node in [DiagramNode { edges: [0, 0, 1, 1], sign: 1 }, DiagramNode { edges: [0, 1, 1, 0], sign: -1 }] {
            assert_eq!(jones(&[node]), Some(Jones::UNKNOT), "{node:?}");
        }
    }
}
