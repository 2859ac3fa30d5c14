//! Numeric LDLᵀ by fronts, and solves with it, on all threads.
//!
//! Supernodes form a tree: the parent of one holds the first of its rows. A supernode's front is its own columns of the
//! matrix plus the updates of its children. Elimination leaves columns of L and D in the panel, and an update of the
//! other rows for the parent. Disjoint subtrees share nothing: they are tasks for threads. The rest follows on one
//! thread. A front adds its children's updates in the order of their numbers, whichever thread made them, so the
//! factor has the same bits for any number of threads.
//!
//! Within a task supernodes follow in postorder, so that few updates wait at a time.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::math::parallel;
use crate::sparse::Pattern;
use crate::sparse::forest::{Forest, NONE};

/// A sparse symmetric matrix: entries of a pattern.
#[derive(Clone, Copy)]
pub(super) struct Lower<'a> {
    pub(super) pattern: &'a Pattern,
    pub(super) values: &'a [f64],
}

/// Columns and rows of supernodes, and where their panels lie among the values of the factor.
#[derive(Clone, Copy)]
pub(super) struct Supernodes<'a> {
    /// First column of each, and past its last.
    pub(super) columns: [&'a [u32]; 2],
    /// First of its rows in `rows`, and their number, without those of its own columns.
    pub(super) row_ptr: &'a [u32],
    pub(super) num_rows: &'a [u32],
    pub(super) rows: &'a [u32],
    /// One more than there are supernodes.
    pub(super) panel_ptr: &'a [u32],
}

impl<'a> Supernodes<'a> {
    fn count(&self) -> usize {
        self.num_rows.len()
    }

    fn columns(&self, s: usize) -> Range<usize> {
        self.columns[0][s] as usize..self.columns[1][s] as usize
    }

    /// Rows below its own columns, ascending.
    fn rows(&self, s: usize) -> &'a [u32] {
        &self.rows[self.row_ptr[s] as usize..][..self.num_rows[s] as usize]
    }

    fn panel_size(&self, s: usize) -> usize {
        (self.panel_ptr[s + 1] - self.panel_ptr[s]) as usize
    }

    fn panel<'b>(&self, values: &'b [f64], s: usize) -> &'b [f64] {
        &values[self.panel_ptr[s] as usize..][..self.panel_size(s)]
    }
}

/// Eliminates the columns of a front in place: panel (columns and rows), update of the rows, scratch; false if a pivot
/// vanishes. The panel becomes columns of L with D on the diagonal, 0 above it.
pub(super) type Eliminate = fn(&mut [f64], [usize; 2], &mut [f64], &mut Vec<f64>) -> bool;

/// The tree of supernodes, cut into tasks.
pub(super) struct EliminationTree {
    forest: Forest,
    /// Supernodes of disjoint subtrees, each in postorder.
    tasks: Vec<Vec<u32>>,
    /// All others, in postorder.
    rest: Vec<u32>,
    /// Per supernode: whether it is the root of a task.
    is_root: Vec<bool>,
}

/// Updates that wait for their parents, by supernode: lower triangles, column after column.
type Updates = BTreeMap<u32, Vec<f64>>;

/// A task with the panels of its supernodes.
struct FactorTask<'a> {
    supernodes: &'a [u32],
    panels: Vec<&'a mut [f64]>,
    /// Updates left; `None` if a pivot vanished.
    left: Option<Updates>,
}

impl EliminationTree {
    /// Tasks for the threads there are, of a factorisation of more multiplications than `least`; `None` of others. The
    /// factor does not depend on the number of threads.
    pub(super) fn of_more(shape: &Supernodes, least: f64) -> Option<Self> {
        let count = shape.count();
        let mut of_column = Vec::new();
        for s in 0..count {
            of_column.resize(shape.columns(s).end, s as u32);
        }
        let parent = |s: usize| shape.rows(s).first().map_or(NONE, |&row| of_column[row as usize]);
        let work = |s: usize| {
            let (columns, rows) = (shape.columns(s).len() as f64, shape.rows(s).len() as f64);
            columns * (columns + rows).powi(2)
        };
        let forest = Forest::new((0..count).map(parent).collect(), (0..count).map(work).collect());
        if forest.work() <= least {
            return None;
        }
        let mut is_root = vec![false; count];
        forest.cut(parallel::num_threads()).roots.iter().for_each(|&root| is_root[root as usize] = true);
        let mut tree = Self { forest, tasks: Vec::new(), rest: Vec::new(), is_root };
        let (mut tasks, mut rest) = (Vec::new(), Vec::new());
        for root in tree.forest.roots() {
            tree.postorder(root, Some(&mut tasks), &mut rest);
        }
        (tree.tasks, tree.rest) = (tasks, rest);
        Some(tree)
    }

    #[cfg(test)]
    pub(super) fn num_tasks(&self) -> usize {
        self.tasks.len()
    }

    fn children(&self, s: u32) -> &[u32] {
        self.forest.children(s)
    }

    /// Appends a subtree to `list` in postorder; subtrees that are tasks are added to these, if there are any.
    fn postorder(&self, root: u32, mut tasks: Option<&mut Vec<Vec<u32>>>, list: &mut Vec<u32>) {
        // supernodes to visit, and whether their children have been
        let mut stack = vec![(root, false)];
        while let Some((s, ready)) = stack.pop() {
            match &mut tasks {
                _ if ready => list.push(s),
                Some(tasks) if self.is_root[s as usize] => {
                    let mut own = Vec::new();
                    self.postorder(s, None, &mut own);
                    tasks.push(own);
                }
                _ => {
                    stack.push((s, true));
                    stack.extend(self.children(s).iter().rev().map(|&child| (child, false)));
                }
            }
        }
    }

    /// Factorises a matrix into the panels of all supernodes; false if a pivot vanishes.
    pub(super) fn factorise(
        &self,
        shape: &Supernodes,
        matrix: Lower,
        mut values: &mut [f64],
        eliminate: Eliminate,
    ) -> bool {
        let mut panels: Vec<Option<&mut [f64]>> = Vec::with_capacity(shape.count());
        for s in 0..shape.count() {
            let (panel, rest) = values.split_at_mut(shape.panel_size(s));
            panels.push(Some(panel));
            values = rest;
        }
        let mut job = |supernodes: &'_ [u32]| -> Vec<&mut [f64]> {
            supernodes.iter().filter_map(|&s| panels[s as usize].take()).collect()
        };
        let mut jobs: Vec<FactorTask> = self
            .tasks
            .iter()
            .map(|task| FactorTask { supernodes: task, panels: job(task), left: Some(Updates::new()) })
            .collect();
        let mut last = FactorTask { supernodes: &self.rest, panels: job(&self.rest), left: Some(Updates::new()) };
        parallel::each(&mut jobs, 1, &|_, job| self.run((shape, matrix), job, eliminate));
        for job in jobs {
            match (&mut last.left, job.left) {
                (Some(all), Some(mut left)) => all.append(&mut left),
                _ => return false,
            }
        }
        self.run((shape, matrix), &mut last, eliminate);
        last.left.is_some()
    }

    /// Factorises the supernodes of a task. `left` are the updates from other tasks before it, those for others after
    /// it.
    fn run(&self, (shape, matrix): (&Supernodes, Lower), job: &mut FactorTask, eliminate: Eliminate) {
        let Some(mut waiting) = job.left.take() else { return };
        let (mut spare, mut runs, mut product) = (Vec::new(), Vec::new(), Vec::new());
        for (&s, panel) in job.supernodes.iter().zip(&mut job.panels) {
            let (columns, rows) = (shape.columns(s as usize), shape.rows(s as usize));
            let mut update: Vec<f64> = spare.pop().unwrap_or_default();
            update.clear();
            update.resize(rows.len() * rows.len(), 0.0);
            let size = [columns.len(), rows.len()];
            let mut front = Front { columns, rows, panel, update: &mut update };
            front.add_matrix(matrix);
            for child in self.children(s) {
                let Some(added) = waiting.remove(child) else { continue };
                front.add_update(shape.rows(*child as usize), &added, &mut runs);
                spare.push(added);
            }
            if !eliminate(panel, size, &mut update, &mut product) {
                return;
            }
            waiting.insert(s, update);
        }
        job.left = Some(waiting);
    }
}

/// A task of a solve.
struct SolveTask<'a> {
    supernodes: &'a [u32],
    /// Numbers of their columns, one supernode after the other.
    own: Vec<f64>,
    /// Numbers of the rows of supernodes whose parent is in another task: sums to subtract, later the solution.
    between: Updates,
}

impl EliminationTree {
    /// Solves with the panels of a factorisation, in place.
    pub(super) fn solve(&self, shape: &Supernodes, values: &[f64], x: &mut [f64]) {
        let sweep = |supernodes| SolveTask { supernodes, own: Vec::new(), between: Updates::new() };
        let mut sweeps: Vec<SolveTask> = self.tasks.iter().map(|task| sweep(task)).collect();
        let mut last = sweep(&self.rest);
        let given: &[f64] = x;
        parallel::each(&mut sweeps, 1, &|_, sweep| self.forward((shape, values), given, sweep));
        sweeps.iter_mut().for_each(|sweep| last.between.append(&mut sweep.between));
        self.forward((shape, values), given, &mut last);
        self.backward((shape, values), &mut last);
        for sweep in &mut sweeps {
            let root = sweep.supernodes.last();
            sweep.between.extend(root.and_then(|root| last.between.remove_entry(root)));
        }
        parallel::each(&mut sweeps, 1, &|_, sweep| self.backward((shape, values), sweep));
        sweeps.push(last);
        for sweep in &sweeps {
            let mut own = sweep.own.as_slice();
            for &s in sweep.supernodes {
                let columns = shape.columns(s as usize);
                let (here, rest) = own.split_at(columns.len());
                x[columns].copy_from_slice(here);
                own = rest;
            }
        }
    }

    /// Solves L D y = b for the columns of a task.
    fn forward(&self, (shape, values): (&Supernodes, &[f64]), b: &[f64], sweep: &mut SolveTask) {
        // sums of the supernodes whose parents are still to come
        let (mut stack, mut front): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for &s in sweep.supernodes {
            let (columns, rows) = (shape.columns(s as usize), shape.rows(s as usize));
            front.clear();
            front.extend_from_slice(&b[columns.clone()]);
            front.resize(columns.len() + rows.len(), 0.0);
            let children = self.children(s);
            let here = |child: &&u32| !self.is_root[**child as usize];
            let waiting: usize = children.iter().filter(here).map(|&child| shape.rows(child as usize).len()).sum();
            let first = stack.len() - waiting;
            let mut next = first;
            for child in children {
                let (other, of_child) = (sweep.between.remove(child), shape.rows(*child as usize));
                let added = other.as_deref().unwrap_or_else(|| {
                    next += of_child.len();
                    &stack[next - of_child.len()..next]
                });
                let mut at = 0;
                for (&row, value) in of_child.iter().zip(added) {
                    front[place(row, columns.start, columns.len(), rows, &mut at)] += value;
                }
            }
            stack.truncate(first);
            let height = front.len();
            for (k, column) in shape.panel(values, s as usize).chunks_exact(height).enumerate() {
                let (pivot, own) = (column[k], front[k]);
                front[k + 1..].iter_mut().zip(&column[k + 1..]).for_each(|(y, l)| *y -= l * own);
                front[k] = own / pivot;
            }
            sweep.own.extend_from_slice(&front[..columns.len()]);
            stack.extend_from_slice(&front[columns.len()..]);
        }
        if let Some(&root) = sweep.supernodes.last().filter(|root| self.is_root[**root as usize]) {
            sweep.between.insert(root, stack);
        }
    }

    /// Solves Lᵀ x = y for the columns of a task.
    fn backward(&self, (shape, values): (&Supernodes, &[f64]), sweep: &mut SolveTask) {
        let (mut stack, mut front): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut end = sweep.own.len();
        for &s in sweep.supernodes.iter().rev() {
            let (columns, rows) = (shape.columns(s as usize), shape.rows(s as usize));
            let start = end - columns.len();
            front.clear();
            front.extend_from_slice(&sweep.own[start..end]);
            match sweep.between.remove(&s) {
                Some(known) => front.extend_from_slice(&known),
                None => front.extend(stack.drain(stack.len() - rows.len()..)),
            }
            let height = front.len();
            for (k, column) in shape.panel(values, s as usize).chunks_exact(height).enumerate().rev() {
                let known = &front[k + 1..];
                front[k] -= dot(&column[k + 1..], known);
            }
            sweep.own[start..end].copy_from_slice(&front[..columns.len()]);
            end = start;
            for child in self.children(s) {
                let mut at = 0;
                let of_row = |&row: &u32| front[place(row, columns.start, columns.len(), rows, &mut at)];
                let known = shape.rows(*child as usize).iter().map(of_row);
                match self.is_root[*child as usize] {
                    true => drop(sweep.between.insert(*child, known.collect())),
                    false => stack.extend(known),
                }
            }
        }
    }
}

/// Σ a b, in four sums that the processor adds up at once.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (mut sums, (a4, b4)) = ([0.0; 4], (a.chunks_exact(4), b.chunks_exact(4)));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a4.zip(b4) {
        (0..4).for_each(|k| sums[k] += a[k] * b[k]);
    }
    sums[0] + sums[1] + (sums[2] + sums[3]) + rest
}

/// The dense matrix in which the columns of a supernode are eliminated.
struct Front<'a> {
    columns: Range<usize>,
    rows: &'a [u32],
    /// Its columns, from the first of them to the last row.
    panel: &'a mut [f64],
    /// Lower triangle of the rows, column after column.
    update: &'a mut [f64],
}

impl Front<'_> {
    /// Overwrites the panel with the matrix.
    fn add_matrix(&mut self, matrix: Lower) {
        self.panel.fill(0.0);
        let (first, width) = (self.columns.start, self.columns.len());
        for (column, values) in self.columns.clone().zip(self.panel.chunks_exact_mut(width + self.rows.len())) {
            let mut at = 0;
            for (&row, value) in matrix.pattern.rows(column).iter().zip(&matrix.values[matrix.pattern.entries(column)])
            {
                let place = place(row, first, width, self.rows, &mut at);
                values[place] = *value;
            }
        }
    }

    /// Adds the update of a child with these rows.
    fn add_update(&mut self, rows: &[u32], update: &[f64], runs: &mut Vec<RowRun>) {
        let (width, height) = (self.columns.len(), self.rows.len());
        self.find_runs(rows, runs);
        let mut values = update;
        for (index, run) in runs.iter().enumerate() {
            for k in 0..run.len {
                let (column, rest) = values.split_at(rows.len());
                values = rest;
                let at = run.to + k;
                let (own, above) = match at.checked_sub(width) {
                    None => (&mut self.panel[at * (width + height)..][..width + height], 0),
                    Some(at) => (&mut self.update[at * height..][..height], width),
                };
                add(&mut own[at - above..][..run.len - k], &column[run.from + k..]);
                for next in &runs[index + 1..] {
                    add(&mut own[next.to - above..][..next.len], &column[next.from..]);
                }
            }
        }
    }

    /// Rows of a child that are next to each other here, too: nodes have six unknowns, and supernodes several nodes.
    fn find_runs(&self, rows: &[u32], runs: &mut Vec<RowRun>) {
        let (width, mut at) = (self.columns.len(), 0);
        runs.clear();
        for (from, &row) in rows.iter().enumerate() {
            let to = place(row, self.columns.start, width, self.rows, &mut at);
            match runs.last_mut() {
                // a run ends where the panel's columns end
                Some(run) if run.to + run.len == to && to != width => run.len += 1,
                _ => runs.push(RowRun { from, to, len: 1 }),
            }
        }
    }
}

/// Rows of a child from `from` on that are those of a front from `to` on.
struct RowRun {
    from: usize,
    to: usize,
    len: usize,
}

/// Adds the first of `values` to all of `sums`.
#[inline]
fn add(sums: &mut [f64], values: &[f64]) {
    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
}

/// Place of a row in a front of columns from `first` on and these rows. `at` is kept between calls with ascending rows.
#[inline]
fn place(row: u32, first: usize, width: usize, rows: &[u32], at: &mut usize) -> usize {
    let own = row as usize - first;
    if own < width {
        return own;
    }
    while rows[*at] < row {
        *at += 1;
    }
    width + *at
}
