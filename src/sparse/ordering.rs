//! Orders of elimination of nodes, and what they cost.
//!
//! Approximate minimum degree looks at one node after the other. Rods that lie side by side, bundles and cables, are
//! long: eliminated from one end to the other their front is as wide as a cross-section, which no local rule sees.
//! Reverse Cuthill–McKee (Cuthill & McKee 1969, George 1971) sees nothing else. On ladders both cost the same;
//! where rods cross in all directions a cross-section is wide. So both are made, and their operations are counted.
//!
//! From one end alone each column waits for that before it. From both ends at once there are two halves that share
//! nothing, for the same operations.

use crate::sparse::NodeGraph;
use crate::sparse::forest::{Forest, NONE};

/// Neighbours of each node of a graph, itself left out.
pub(super) struct Adjacency<'a> {
    graph: &'a NodeGraph,
    /// Where those of each node begin.
    first: Vec<u32>,
    all: Vec<u32>,
}

impl<'a> Adjacency<'a> {
    pub(super) fn new(graph: &'a NodeGraph) -> Self {
        let couplings = || graph.pairs().iter().filter(|(a, b)| a != b);
        let mut first = vec![0u32; graph.num_nodes() + 1];
        couplings().flat_map(|&(a, b)| [a, b]).for_each(|node| first[node as usize + 1] += 1);
        (1..first.len()).for_each(|k| first[k] += first[k - 1]);
        let (mut next, mut all) = (first.clone(), vec![0; 2 * couplings().count()]);
        for (node, other) in couplings().flat_map(|&(a, b)| [(a, b), (b, a)]) {
            all[next[node as usize] as usize] = other;
            next[node as usize] += 1;
        }
        Self { graph, first, all }
    }

    fn of(&self, node: u32) -> &[u32] {
        &self.all[self.first[node as usize] as usize..self.first[node as usize + 1] as usize]
    }

    /// The nodes from both ends of all to the middle.
    pub(super) fn ends_to_middle(&self) -> Vec<u32> {
        let mut order = self.end_to_end();
        let middle = order.len() / 2;
        order[middle..].reverse();
        order
    }

    /// The nodes of each connected part from one end to the other: reverse Cuthill–McKee.
    pub(super) fn end_to_end(&self) -> Vec<u32> {
        let num_nodes = self.graph.num_nodes();
        let (mut order, mut is_placed) = (Vec::with_capacity(num_nodes), vec![false; num_nodes]);
        // the round in which a node was met; rounds of different searches differ
        let mut met = vec![0u32; num_nodes];
        let mut round = 0;
        for node in 0..num_nodes as u32 {
            if is_placed[node as usize] {
                continue;
            }
            let (mut end, mut depth) = (node, 0);
            let swept = loop {
                round += 1;
                let (swept, deep) = self.by_distance(end, &mut met, round);
                // from an end of a part no node is farther than from the other end
                if deep <= depth && depth > 0 || swept.len() == 1 {
                    break swept;
                }
                (end, depth) = (swept[swept.len() - 1], deep);
            };
            swept.iter().for_each(|&node| is_placed[node as usize] = true);
            order.extend(swept);
        }
        order.reverse();
        order
    }

    /// Which columns a factorisation needs for which, with the nodes in an order of elimination, and how many
    /// multiplications each takes, but for a common factor.
    pub(super) fn elimination(&self, order: &[u32]) -> Forest {
        let mut place = vec![0u32; order.len()];
        order.iter().zip(0..).for_each(|(&node, at)| place[node as usize] = at);
        // below the diagonal of a column: the places of the rows; those of eliminated columns are with their parents
        let mut rows: Vec<Vec<u32>> = vec![Vec::new(); order.len()];
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); order.len()];
        let mut met = vec![u32::MAX; order.len()];
        let (mut parents, mut work) = (Vec::with_capacity(order.len()), Vec::with_capacity(order.len()));
        for (&node, at) in order.iter().zip(0u32..) {
            let mut below: Vec<u32> = self.of(node).iter().map(|&other| place[other as usize]).collect();
            for child in std::mem::take(&mut children[at as usize]) {
                below.append(&mut rows[child as usize]);
            }
            below.retain(|&row| row > at && std::mem::replace(&mut met[row as usize], at) != at);
            let width = |place: u32| f64::from(self.graph.num_free(order[place as usize]));
            let own = width(at);
            let front = own + below.iter().map(|&row| width(row)).sum::<f64>();
            work.push(own * front * front);
            let parent = below.iter().min().copied();
            parents.push(parent.unwrap_or(NONE));
            if let Some(parent) = parent {
                children[parent as usize].push(at);
            }
            rows[at as usize] = below;
        }
        Forest::new(parents, work)
    }

    /// The nodes connected with one by their distance from it, neighbours of the same node by how many they have; and
    /// the largest distance. `met` holds the round in which a node was met last.
    fn by_distance(&self, start: u32, met: &mut [u32], round: u32) -> (Vec<u32>, usize) {
        let (mut swept, mut from, mut depth) = (vec![start], 0, 0);
        met[start as usize] = round;
        while from < swept.len() {
            let level = from..swept.len();
            for k in level.clone() {
                let first = swept.len();
                let neighbours = self.of(swept[k]).iter().copied();
                swept.extend(neighbours.filter(|&node| std::mem::replace(&mut met[node as usize], round) != round));
                swept[first..].sort_by_key(|&node| self.of(node).len());
            }
            (from, depth) = (level.end, depth + 1);
        }
        (swept, depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rods side by side, each node coupled with the next of its rod and with those beside it.
    fn bundle(rods: usize, nodes: usize) -> NodeGraph {
        let count = rods * nodes;
        let along = (0..count).filter(move |n| (n + 1) % nodes != 0).map(|n| (n, n + 1));
        let across = (0..count - nodes).map(move |n| (n, n + nodes));
        let owner: Vec<[usize; 6]> = (0..count).map(|node| [node; 6]).collect();
        NodeGraph::new(&vec![[true; 6]; count], &owner, along.chain(across))
    }

    /// From one end of a bundle to the other the front is a cross-section and a node; rod after rod it is a rod.
    #[test]
    fn bundles_are_eliminated_from_end_to_end() {
        let (rods, nodes) = (5, 60);
        let graph = bundle(rods, nodes);
        let adjacency = Adjacency::new(&graph);
        let order = adjacency.end_to_end();
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..(rods * nodes) as u32), "each node once");
        let front = 6.0 * (rods as f64 + 1.0);
        let (ours, most) = (adjacency.elimination(&order).work(), (rods * nodes) as f64 * 6.0 * front * front);
        assert!(ours <= most, "{ours:e} {most:e}");
        let rod_after_rod: Vec<u32> = (0..(rods * nodes) as u32).collect();
        assert!(adjacency.elimination(&rod_after_rod).work() > 20.0 * ours);
    }

    /// From both ends two halves are independent, for the same operations.
    #[test]
    fn both_ends_are_eliminated_at_once() {
        let graph = bundle(5, 60);
        let adjacency = Adjacency::new(&graph);
        let [one, both] =
            [adjacency.end_to_end(), adjacency.ends_to_middle()].map(|order| adjacency.elimination(&order));
        assert!(both.work() < 1.05 * one.work(), "{:e} {:e}", both.work(), one.work());
        assert!(both.cut(2).longest < 0.6 * both.work(), "{:e}", both.cut(2).longest);
        assert!(one.cut(2).longest > 0.9 * one.work(), "{:e}", one.cut(2).longest);
    }

    /// Parts that nothing connects, and single nodes.
    #[test]
    fn parts_follow_each_other() {
        let owner: Vec<[usize; 6]> = (0..7).map(|node| [node; 6]).collect();
        let graph = NodeGraph::new(&[[true; 6]; 7], &owner, [(0, 2), (2, 4), (1, 5)].into_iter());
        let adjacency = Adjacency::new(&graph);
        let order = adjacency.end_to_end();
        let place = |node: u32| order.iter().position(|n| *n == node).unwrap();
        assert_eq!(order.len(), 7);
        assert_eq!((place(0).abs_diff(place(2)), place(2).abs_diff(place(4)), place(1).abs_diff(place(5))), (1, 1, 1));
        // a chain of three, one of two, and two alone
        let exact = 6.0 * (12.0f64.powi(2) * 3.0 + 6.0f64.powi(2) * 4.0);
        assert_eq!(adjacency.elimination(&order).work(), exact);
    }

    /// The count against the entries of a dense elimination.
    #[test]
    fn operations_are_those_of_an_elimination() {
        let graph = bundle(3, 4);
        let order: Vec<u32> = vec![3, 8, 0, 11, 5, 6, 1, 10, 2, 9, 4, 7];
        let n = order.len();
        let mut is_coupled = vec![vec![false; n]; n];
        for &(a, b) in graph.pairs() {
            (is_coupled[a as usize][b as usize], is_coupled[b as usize][a as usize]) = (true, true);
        }
        let (mut left, mut exact): (Vec<usize>, f64) = (order.iter().map(|&node| node as usize).collect(), 0.0);
        while !left.is_empty() {
            let node = left.remove(0);
            let beside: Vec<usize> = left.iter().copied().filter(|&other| is_coupled[node][other]).collect();
            beside.iter().for_each(|&a| beside.iter().for_each(|&b| is_coupled[a][b] = true));
            exact += 6.0 * (6.0 * (1.0 + beside.len() as f64)).powi(2);
        }
        assert_eq!(Adjacency::new(&graph).elimination(&order).work(), exact);
    }
}
