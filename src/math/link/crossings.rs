//! Writhe and link of long closed polygons from the crossings of one projection.
//!
//! Seen along n, the ribbon that points towards the eye has the link Σ ±1 over the self-crossings of the projection,
//! hence `Wr = Σ ±1 − Tw(n)` where Tw(n) is the twist of the constant field n about the polygon (Fuller 1978; Agarwal,
//! Edelsbrunner & Wang 2004). Crossings are found with a uniform grid, so the cost is that of the edges plus the pairs
//! that share a cell. A crossing too close to call discards the viewing direction; the next one is tried.

use std::ops::Range;

use super::twist_with_seam;
use crate::math::direction::any_normal;
use crate::math::{Vec3, parallel};

/// Viewing directions without any relation to the axes, tried in turn.
const DIRECTIONS: [[f64; 3]; 4] = [
    [0.271_828_18, 0.577_215_66, 0.761_803_39],
    [-0.641_421_35, 0.317_320_51, 0.414_159_26],
    [0.683_147_18, -0.441_213_56, 0.236_067_97],
    [0.202_056_9, 0.373_205_08, -0.915_965_59],
];

/// Relative size below which the sign of a product of coordinate differences is not trusted.
const CLEAR: f64 = 1e-13;
/// Edges, and cells with several of them, per parallel task.
const EDGES: usize = 4096;
const CELLS: usize = 256;

/// Writhe (turns) of a closed polygon of extent about 1; `None` if no direction shows all crossings clearly, or if an
/// edge folds straight back on the one before, where no ribbon has a definite twist.
pub(super) fn writhe(points: &[Vec3]) -> Option<f64> {
    let num = points.len();
    let folds_back = |i: usize| {
        let (into, out) = (points[(i + 1) % num] - points[i], points[(i + 2) % num] - points[(i + 1) % num]);
        into.dot(&out) <= (1e-12 - 1.0) * into.norm() * out.norm()
    };
    if (0..num).any(folds_back) {
        return None;
    }
    DIRECTIONS.iter().find_map(|d| {
        let n = Vec3::from(*d).normalize();
        let edges = project(points, n);
        let crossings = count(&edges, |i, j| i < j && !adjacent(edges.len(), i, j))?;
        Some(crossings as f64 - twist_with_seam(points, &vec![n; points.len()], true, 0.0))
    })
}

/// Linking number of two closed polygons of extent about 1; `None` if no direction shows all crossings clearly.
pub(super) fn link(a: &[Vec3], b: &[Vec3]) -> Option<f64> {
    DIRECTIONS.iter().find_map(|d| {
        let n = Vec3::from(*d).normalize();
        let mut edges = project(a, n);
        edges.extend(project(b, n));
        let crossings = count(&edges, |i, j| i < a.len() && j >= a.len())?;
        Some(0.5 * crossings as f64)
    })
}

/// A crossing of a closed polygon's picture with itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    /// Where the upper strand passes: edge and fraction of it, as one number.
    pub over: f64,
    /// Where the lower strand passes.
    pub under: f64,
    /// +1 right-handed, −1 left-handed.
    pub sign: i64,
}

/// All crossings of a closed polygon of extent about 1, seen along the viewing direction with the fewest crossings
/// among those that show all of them clearly.
pub(super) fn list(points: &[Vec3]) -> Option<Vec<Crossing>> {
    let along = |d: &[f64; 3]| {
        let edges = project(points, Vec3::from(*d).normalize());
        let mut found = crossed(&edges, |i, j| i < j && !adjacent(edges.len(), i, j))?;
        found.sort_unstable();
        Some(found.into_iter().map(|(i, j, sign)| placed(&edges, i as usize, j as usize, sign)).collect::<Vec<_>>())
    };
    DIRECTIONS.iter().filter_map(along).min_by_key(Vec::len)
}

/// The crossing of edges i and j.
fn placed(edges: &[Edge], i: usize, j: usize, sign: i64) -> Crossing {
    let ([a, b], [c, d]) = (&edges[i], &edges[j]);
    let (u, v, w) = (b - a, d - c, c - a);
    let across = u.x * v.y - u.y * v.x;
    let (s, t) = ((w.x * v.y - w.y * v.x) / across, (w.x * u.y - w.y * u.x) / across);
    let (first, second) = (i as f64 + s, j as f64 + t);
    let above = a.z + s * u.z > c.z + t * v.z;
    let (over, under) = if above { (first, second) } else { (second, first) };
    Crossing { over, under, sign }
}

/// An edge as seen along the viewing direction: two picture coordinates and the height towards the eye.
type Edge = [Vec3; 2];

/// Edges of a closed polygon in coordinates whose third axis is `n`.
fn project(points: &[Vec3], n: Vec3) -> Vec<Edge> {
    let x = any_normal(n);
    let y = n.cross(&x);
    let seen: Vec<Vec3> = points.iter().map(|p| Vec3::new(x.dot(p), y.dot(p), n.dot(p))).collect();
    (0..seen.len()).map(|i| [seen[i], seen[(i + 1) % seen.len()]]).collect()
}

/// Whether edges i < j of a closed polygon meet at a vertex.
fn adjacent(num_edges: usize, i: usize, j: usize) -> bool {
    j == i + 1 || (i == 0 && j + 1 == num_edges)
}

/// Sum of the signs of all crossings between edges i, j with `wanted(i, j)`; `None` if one is too close to call.
fn count(edges: &[Edge], wanted: impl Fn(usize, usize) -> bool + Sync) -> Option<i64> {
    Some(crossed(edges, wanted)?.into_iter().map(|(.., sign)| sign).sum())
}

/// All crossings between edges i, j with `wanted(i, j)`, with their signs; `None` if one is too close to call.
fn crossed(edges: &[Edge], wanted: impl Fn(usize, usize) -> bool + Sync) -> Option<Vec<(u32, u32, i64)>> {
    let grid = Grid::new(edges);
    let in_range = |range: Range<usize>| -> Vec<(u64, u32)> {
        let mut entries: Vec<(u64, u32)> =
            range.flat_map(|i| grid.cells(&edges[i]).map(move |cell| (cell, i as u32))).collect();
        entries.sort_unstable();
        entries
    };
    let mut entries = parallel::map_ranges(edges.len(), EDGES, &in_range).concat();
    // a stable sort merges the runs that are in order already
    entries.sort();
    let cells: Vec<&[(u64, u32)]> = entries.chunk_by(|a, b| a.0 == b.0).filter(|c| c.len() > 1).collect();
    let in_cell = |cell: &[(u64, u32)]| {
        let mut found = Vec::new();
        for (k, &(key, i)) in cell.iter().enumerate() {
            for &(_, j) in &cell[k + 1..] {
                let (a, b) = (&edges[i as usize], &edges[j as usize]);
                // A pair that shares several cells is tested in one of them only.
                if wanted(i as usize, j as usize) && grid.first_shared(a, b) == key {
                    let sign = crossing(a, b)?;
                    found.extend((sign != 0).then_some((i, j, sign)));
                }
            }
        }
        Some(found)
    };
    let of_cells = |range: Range<usize>| -> Option<Vec<Vec<_>>> { cells[range].iter().copied().map(in_cell).collect() };
    let found: Option<Vec<Vec<Vec<_>>>> = parallel::map_ranges(cells.len(), CELLS, &of_cells).into_iter().collect();
    Some(found?.into_iter().flatten().flatten().collect())
}

/// A uniform grid over the picture plane.
struct Grid {
    low: [f64; 2],
    per_length: f64,
}

impl Grid {
    /// Cells as large as the root mean square of the edges: an edge touches (1 + length/cell)² of them at most, so all
    /// edges together touch a few times their number even if one is as long as the whole.
    fn new(edges: &[Edge]) -> Self {
        let (mut low, mut total) = ([f64::MAX; 2], 0.0);
        for [a, b] in edges {
            total += (a.x - b.x).powi(2) + (a.y - b.y).powi(2);
            for k in 0..2 {
                low[k] = low[k].min(a[k]);
            }
        }
        Self { low, per_length: (edges.len() as f64 / total.max(f64::MIN_POSITIVE)).sqrt() }
    }

    /// Column and row of a picture point.
    fn cell(&self, x: f64, y: f64) -> [u64; 2] {
        [((x - self.low[0]) * self.per_length) as u64, ((y - self.low[1]) * self.per_length) as u64]
    }

    /// Lowest and highest column and row that an edge's bounding rectangle touches.
    fn range(&self, [a, b]: &Edge) -> [[u64; 2]; 2] {
        [self.cell(a.x.min(b.x), a.y.min(b.y)), self.cell(a.x.max(b.x), a.y.max(b.y))]
    }

    /// Keys of all cells an edge's bounding rectangle touches.
    fn cells(&self, edge: &Edge) -> impl Iterator<Item = u64> + use<> {
        let [low, high] = self.range(edge);
        (low[0]..=high[0]).flat_map(move |column| (low[1]..=high[1]).map(move |row| key([column, row])))
    }

    /// Key of the lowest cell that two edges' rectangles share (meaningless if they share none).
    fn first_shared(&self, a: &Edge, b: &Edge) -> u64 {
        let (a, b) = (self.range(a)[0], self.range(b)[0]);
        key([a[0].max(b[0]), a[1].max(b[1])])
    }
}

/// One number per cell. Columns and rows stay far below 2³² for up to 2³⁰ edges.
fn key([column, row]: [u64; 2]) -> u64 {
    column << 32 | row
}

/// Sign of the crossing of two edges (+1 right-handed), 0 if they do not cross in the picture, `None` if in doubt.
fn crossing([a, b]: &Edge, [c, d]: &Edge) -> Option<i64> {
    let apart = |k: usize| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k]);
    if apart(0) || apart(1) {
        return Some(0);
    }
    let (u, v) = (b - a, d - c);
    let side = |from: &Vec3, along: &Vec3, p: &Vec3| {
        let to = p - from;
        let value = along.x * to.y - along.y * to.x;
        (value, value.abs() > CLEAR * (along.x.abs() + along.y.abs()) * (to.x.abs() + to.y.abs()).max(CLEAR))
    };
    let [oc, od, oa, ob] = [side(a, &u, c), side(a, &u, d), side(c, &v, a), side(c, &v, b)];
    for (p, q) in [(oc, od), (oa, ob)] {
        if p.1 && q.1 && p.0 * q.0 > 0.0 {
            return Some(0);
        }
    }
    if ![oc, od, oa, ob].iter().all(|o| o.1) {
        return None;
    }
    let (s, t) = (oa.0 / (oa.0 - ob.0), oc.0 / (oc.0 - od.0));
    let height = (a.z + s * u.z) - (c.z + t * v.z);
    if height.abs() <= CLEAR {
        return None;
    }
    Some(if height * (u.x * v.y - u.y * v.x) > 0.0 { 1 } else { -1 })
}
