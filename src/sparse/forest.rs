//! Forests of elimination, and how to cut them into subtrees for threads.
//!
//! A column of a factor depends on the columns of its subtree alone. Disjoint subtrees share nothing, so they are tasks
//! for threads; what lies above them follows on one thread (Geist & Ng 1989).

use std::collections::BinaryHeap;

/// Parent of a root.
pub(super) const NONE: u32 = u32::MAX;

/// Vertices that come after their children, and the work that each takes by itself.
pub(super) struct Forest {
    parents: Vec<u32>,
    own: Vec<f64>,
    /// Range in `children` of each vertex, with one entry more.
    firsts: Vec<u32>,
    children: Vec<u32>,
}

/// Disjoint subtrees, and the work that one after the other must be done with them on all threads.
pub(super) struct SubtreeCut {
    /// Roots of the subtrees, ascending.
    pub(super) roots: Vec<u32>,
    /// What lies above the subtrees, and the largest of these or a thread's share of all.
    pub(super) longest: f64,
}

impl Forest {
    /// `parents` are [`NONE`] or larger than the index of their child.
    pub(super) fn new(parents: Vec<u32>, own: Vec<f64>) -> Self {
        let mut firsts = vec![0u32; parents.len() + 1];
        let inner = || parents.iter().enumerate().filter(|(_, parent)| **parent != NONE);
        inner().for_each(|(_, &parent)| firsts[parent as usize + 1] += 1);
        (1..firsts.len()).for_each(|k| firsts[k] += firsts[k - 1]);
        let (mut next, mut children) = (firsts.clone(), vec![0; firsts[parents.len()] as usize]);
        for (child, &parent) in inner() {
            children[next[parent as usize] as usize] = child as u32;
            next[parent as usize] += 1;
        }
        Self { parents, own, firsts, children }
    }

    /// Children of a vertex, ascending.
    pub(super) fn children(&self, vertex: u32) -> &[u32] {
        &self.children[self.firsts[vertex as usize] as usize..self.firsts[vertex as usize + 1] as usize]
    }

    /// Vertices without parents, ascending.
    pub(super) fn roots(&self) -> impl Iterator<Item = u32> {
        (0u32..).zip(&self.parents).filter(|(_, parent)| **parent == NONE).map(|(vertex, _)| vertex)
    }

    /// All work.
    pub(super) fn work(&self) -> f64 {
        self.own.iter().sum()
    }

    /// The cut with the least of [`SubtreeCut::longest`] for a number of threads: the largest subtree makes way for its
    /// children as long as that may be less.
    pub(super) fn cut(&self, threads: usize) -> SubtreeCut {
        let mut work = self.own.clone();
        for (vertex, &parent) in self.parents.iter().enumerate().filter(|(_, parent)| **parent != NONE) {
            work[parent as usize] += work[vertex];
        }
        // of positive numbers the bits are in the same order
        let entry = |vertex: u32| (work[vertex as usize].to_bits(), vertex);
        let mut subtrees: BinaryHeap<(u64, u32)> = self.roots().map(entry).collect();
        let (mut above, mut below) = (0.0, self.work());
        let (mut opened, mut num_opened, mut longest) = (Vec::new(), 0, f64::INFINITY);
        while let Some(&(bits, largest)) = subtrees.peek() {
            let here = above + f64::from_bits(bits).max(below / threads as f64);
            if here < longest {
                (longest, num_opened) = (here, opened.len());
            }
            // opening a subtree takes work from those that share it
            if above + below / threads as f64 >= longest {
                break;
            }
            subtrees.pop();
            subtrees.extend(self.children(largest).iter().copied().map(entry));
            (above, below) = (above + self.own[largest as usize], below - self.own[largest as usize]);
            opened.push(largest);
        }
        let mut is_opened = vec![false; self.parents.len()];
        opened[..num_opened].iter().for_each(|&vertex| is_opened[vertex as usize] = true);
        let is_below = |parent: u32| parent == NONE || is_opened[parent as usize];
        let roots =
            (0u32..).zip(&self.parents).filter(|(vertex, parent)| is_below(**parent) && !is_opened[*vertex as usize]);
        SubtreeCut { roots: roots.map(|(vertex, _)| vertex).collect(), longest }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain has no two subtrees; two chains that meet are two tasks, whatever is above them; of one thread all is
    /// one task.
    #[test]
    fn chains_are_cut_where_they_meet() {
        let chain = Forest::new(vec![1, 2, 3, NONE], vec![1.0; 4]);
        let cut = chain.cut(2);
        assert_eq!((cut.roots, cut.longest), (vec![3], 4.0));
        // 0–1–2 and 3–4 meet in 5, above which is 6
        let two = Forest::new(vec![1, 2, 5, 4, 5, 6, NONE], vec![1.0, 1.0, 1.0, 1.0, 2.0, 1.0, 1.0]);
        let cut = two.cut(2);
        assert_eq!((cut.roots, cut.longest), (vec![2, 4], 5.0));
        let cut = two.cut(1);
        assert_eq!((cut.roots, cut.longest), (vec![6], 8.0));
    }

    /// What a cut says of itself against a plain count, and never more than all work.
    #[test]
    fn cuts_take_as_long_as_they_say() {
        let mut numbers = crate::math::random::Random(3);
        for _ in 0..200 {
            let count = 9;
            let parents: Vec<u32> = (0..count)
                .map(|k| {
                    let parent = k + 1 + (numbers.unit().abs() * 3.0) as u32;
                    if parent < count { parent } else { NONE }
                })
                .collect();
            let own: Vec<f64> = (0..count).map(|_| 0.1 + numbers.unit().abs()).collect();
            let forest = Forest::new(parents.clone(), own.clone());
            for threads in [1, 2, 3] {
                let cut = forest.cut(threads);
                let task_of = |vertex: u32| {
                    let mut at = vertex;
                    while at != NONE && !cut.roots.contains(&at) {
                        at = parents[at as usize];
                    }
                    at
                };
                let sum = |task: u32| -> f64 {
                    (0..count).filter(|vertex| task_of(*vertex) == task).map(|vertex| own[vertex as usize]).sum()
                };
                let largest = cut.roots.iter().map(|&root| sum(root)).fold(0.0, f64::max);
                let below = forest.work() - sum(NONE);
                let longest = sum(NONE) + largest.max(below / threads as f64);
                assert!((cut.longest - longest).abs() < 1e-12, "{} {longest}", cut.longest);
                assert!(cut.longest <= forest.work() + 1e-12);
            }
        }
    }
}
