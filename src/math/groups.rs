//! Disjoint sets (union–find) over indices.

/// Disjoint sets of the indices 0, 1, 2 …; each set is represented by its smallest member.
pub(crate) struct Groups<'a>(&'a mut Vec<u32>);

impl<'a> Groups<'a> {
    /// `count` sets of one index each; `scratch` is overwritten.
    pub(crate) fn apart(count: usize, scratch: &'a mut Vec<u32>) -> Self {
        scratch.clear();
        scratch.extend(0..count as u32);
        Self(scratch)
    }

    /// Smallest member of the set that an index is in.
    pub(crate) fn first(&mut self, mut k: usize) -> usize {
        while self.0[k] as usize != k {
            self.0[k] = self.0[self.0[k] as usize];
            k = self.0[k] as usize;
        }
        k
    }

    /// Unites the sets of two indices.
    pub(crate) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_joined_by_others_is_one_group() {
        let mut scratch = vec![7; 3];
        let mut groups = Groups::apart(8, &mut scratch);
        for (a, b) in [(6, 4), (2, 6), (5, 3), (5, 5), (4, 2)] {
            groups.join(a, b);
        }
        let firsts: Vec<usize> = (0..8).map(|k| groups.first(k)).collect();
        assert_eq!(firsts, [0, 1, 2, 3, 2, 3, 2, 7]);
        groups.join(3, 4);
        assert_eq!([groups.first(5), groups.first(6)], [2, 2]);
    }
}
