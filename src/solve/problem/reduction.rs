//! From six numbers a node, about x, y and z, to those of the equations, and back.

use crate::solve::problem::swivel::Bases;
use crate::sparse::Pattern;

/// Equations of a pattern, unknowns in bases.
#[derive(Clone, Copy)]
pub(in crate::solve) struct Reduction<'a> {
    pub(in crate::solve) pattern: &'a Pattern,
    pub(in crate::solve) bases: &'a Bases,
}

impl Reduction<'_> {
    /// Forces on the equations: those of joined nodes add up, supports bear the others.
    pub(in crate::solve) fn forces(&self, of_nodes: &[f64]) -> Vec<f64> {
        let mut reduced = vec![0.0; self.pattern.num_equations()];
        for (i, x) in self.bases.resolved(of_nodes).iter().enumerate() {
            if let Some(equation) = self.pattern.equation(i / 6, i % 6) {
                reduced[equation] += x;
            }
        }
        reduced
    }

    /// Motion of the equations: joined nodes have one.
    pub(in crate::solve) fn motion(&self, of_nodes: &[f64]) -> Vec<f64> {
        let mut reduced = vec![0.0; self.pattern.num_equations()];
        for (i, x) in self.bases.resolved(of_nodes).iter().enumerate() {
            if let Some(equation) = self.pattern.equation(i / 6, i % 6) {
                reduced[equation] = *x;
            }
        }
        reduced
    }

    /// Motion of so many numbers of nodes, joined ones alike, 0 where supports hold.
    pub(in crate::solve) fn motion_of_nodes(&self, count: usize, reduced: &[f64]) -> Vec<f64> {
        self.of_nodes(count, |node, k| self.pattern.equation(node, k).map(|equation| reduced[equation]))
    }

    /// Forces on nodes, those on joined ones at the first of them.
    pub(in crate::solve) fn forces_on_nodes(&self, count: usize, reduced: &[f64]) -> Vec<f64> {
        self.of_nodes(count, |node, k| self.pattern.own_equation(node, k).map(|equation| reduced[equation]))
    }

    fn of_nodes(&self, count: usize, number: impl Fn(usize, usize) -> Option<f64>) -> Vec<f64> {
        let mut all: Vec<f64> = (0..count).map(|i| number(i / 6, i % 6).unwrap_or(0.0)).collect();
        self.bases.compose(&mut all);
        all
    }
}
