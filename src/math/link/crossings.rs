//! Writhe and link of long polygons from the crossings of one projection.
//!
//! Seen along n, the ribbon that points towards the eye has the link Σ ±1 over the self-crossings of the projection,
//! hence `Wr = Σ ±1 − Tw(n)` where Tw(n) is the twist of the constant field n about the polygon (Fuller 1978; Agarwal,
//! Edelsbrunner & Wang 2004). Crossings are found with a uniform grid, so the cost is that of the edges plus the pairs
//! that share a cell. A crossing too close to call discards the viewing direction; the next one is tried.

use std::ops::Range;

use super::{extended, twist_with_seam};
use crate::math::direction::any_normal;
use crate::math::{Vec3, parallel};

/// Viewing directions without any relation to the axes, tried in turn.
pub(super) const DIRECTIONS: [[f64; 3]; 4] = [
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
    writhe_along(points, true, DIRECTIONS.iter().map(unit))
}

/// Least sine of the angle between a viewing direction and the rays of an [extended](writhe_extended) polygon.
const ACROSS: f64 = 0.3;
/// Length of the part of a ray that is looked at: seen at an angle of [`ACROSS`], it leaves the picture of a polygon of
/// extent √2, whose points are up to 2√6 apart.
const RAY: f64 = 20.0;

/// Writhe (turns) of an open polygon of extent about 1 that rays along the unit vector `direction` extend to infinity,
/// from −∞ to its first point and from its last one to +∞; `None` as for [`writhe`].
pub(super) fn writhe_extended(points: &[Vec3], direction: Vec3) -> Option<f64> {
    let across = DIRECTIONS.iter().map(unit).filter(|n| n.cross(&direction).norm() >= ACROSS);
    writhe_along(&extended(points, direction * RAY), false, across)
}

fn unit(direction: &[f64; 3]) -> Vec3 {
    Vec3::from(*direction).normalize()
}

/// Writhe (turns) from the crossings seen along the first viewing direction that shows them clearly. Of an open
/// polygon, if its first and its last edge are parallel and none crosses them beyond their ends.
fn writhe_along(points: &[Vec3], closed: bool, mut directions: impl Iterator<Item = Vec3>) -> Option<f64> {
    let num = points.len();
    let folds_back = |i: usize| {
        let (into, out) = (points[(i + 1) % num] - points[i], points[(i + 2) % num] - points[(i + 1) % num]);
        into.dot(&out) <= (1e-12 - 1.0) * into.norm() * out.norm()
    };
    if (0..if closed { num } else { num - 2 }).any(folds_back) {
        return None;
    }
    directions.find_map(|n| {
        let edges = project(points, closed, n);
        let crossings = count(&edges, |i, j| i < j && !adjacent((edges.len(), closed), i, j))?;
        Some(crossings as f64 - twist_with_seam(points, &vec![n; num], closed, 0.0))
    })
}

/// Linking number of two closed polygons of extent about 1; `None` if no direction shows all crossings clearly.
pub(super) fn link(a: &[Vec3], b: &[Vec3]) -> Option<f64> {
    DIRECTIONS.iter().find_map(|d| {
        let n = unit(d);
        let mut edges = project(a, true, n);
        edges.extend(project(b, true, n));
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
        let edges = project(points, true, unit(d));
        let found = crossed(&edges, |i, j| i < j && !adjacent((edges.len(), true), i, j))?;
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

/// Edges of a polygon in coordinates whose third axis is `n`.
fn project(points: &[Vec3], closed: bool, n: Vec3) -> Vec<Edge> {
    let x = any_normal(n);
    let y = n.cross(&x);
    let seen: Vec<Vec3> = points.iter().map(|p| Vec3::new(x.dot(p), y.dot(p), n.dot(p))).collect();
    let num_edges = if closed { seen.len() } else { seen.len() - 1 };
    (0..num_edges).map(|i| [seen[i], seen[(i + 1) % seen.len()]]).collect()
}

/// Whether edges i < j of a polygon, which has so many and may be closed, meet at a vertex.
fn adjacent((num_edges, closed): (usize, bool), i: usize, j: usize) -> bool {
    j == i + 1 || (closed && i == 0 && j + 1 == num_edges)
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
        for (k, &(_, i)) in cell.iter().enumerate() {
            for &(_, j) in &cell[k + 1..] {
                if wanted(i as usize, j as usize) {
                    let sign = crossing(&edges[i as usize], &edges[j as usize])?;
                    found.extend((sign != 0).then_some((i, j, sign)));
                }
            }
        }
        Some(found)
    };
    let of_cells = |range: Range<usize>| -> Option<Vec<Vec<_>>> { cells[range].iter().copied().map(in_cell).collect() };
    let found: Option<Vec<Vec<Vec<_>>>> = parallel::map_ranges(cells.len(), CELLS, &of_cells).into_iter().collect();
    let mut found: Vec<_> = found?.into_iter().flatten().flatten().collect();
    // edges that share several cells cross in each of them
    found.sort_unstable();
    found.dedup();
    Some(found)
}

/// A uniform grid over the picture plane.
struct Grid {
    low: [f64; 2],
    per_length: f64,
}

/// Width by which an edge is thicker than it is, over a cell, so that edges that cross on the border of two cells share
/// one.
const MARGIN: f64 = 1e-6;

impl Grid {
    /// Cells as wide as the edges on the average: an edge touches a few more of them than its length over theirs, so
    /// all edges together touch a few times their number, even if some are as long as the whole.
    fn new(edges: &[Edge]) -> Self {
        let (mut low, mut total) = ([f64::MAX; 2], 0.0);
        for [a, b] in edges {
            total += (a.x - b.x).abs() + (a.y - b.y).abs();
            for k in 0..2 {
                low[k] = low[k].min(a[k]);
            }
        }
        Self { low, per_length: edges.len() as f64 / total.max(f64::MIN_POSITIVE) }
    }

    /// A picture point in widths of a cell from the grid's corner.
    fn place(&self, point: &Vec3) -> [f64; 2] {
        [0, 1].map(|k| (point[k] - self.low[k]) * self.per_length)
    }

    /// Keys of all cells that an edge touches, column by column.
    fn cells(&self, [a, b]: &Edge) -> impl Iterator<Item = u64> + use<> {
        let (a, b) = (self.place(a), self.place(b));
        let (a, b) = if a[0] <= b[0] { (a, b) } else { (b, a) };
        let slope = (b[1] - a[1]) / (b[0] - a[0]);
        let (first, last) = (cell(a[0] - MARGIN), cell(b[0] + MARGIN));
        (first..=last).flat_map(move |column| {
            let height = |x: f64| if slope.is_finite() { a[1] + (x.clamp(a[0], b[0]) - a[0]) * slope } else { b[1] };
            // the ends themselves where the column has them
            let left = if column == first { a[1] } else { height(column as f64 - MARGIN) };
            let right = if column == last { b[1] } else { height(column as f64 + 1.0 + MARGIN) };
            let rows = cell(left.min(right) - MARGIN)..=cell(left.max(right) + MARGIN);
            rows.map(move |row| key([column, row]))
        })
    }
}

/// Column or row of a place; the margin of the lowest edge is in the first.
fn cell(place: f64) -> u64 {
    place.max(0.0) as u64
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    /// Edges a thousandth of the whole beside some as long as the whole, lattice directions among them: all pairs by
    /// the grid and one by one.
    #[test]
    fn the_grid_misses_no_crossing() {
        let mut random = Random(3);
        for case in 0..60 {
            let mut at = Vec3::zeros();
            let points: Vec<Vec3> = (0..300)
                .map(|k| {
                    let step = Vec3::new(random.unit(), random.unit(), random.unit());
                    let step = if case % 3 == 0 { step.map(|x| (2.0 * x).round() + 1e-3 * x) } else { step };
                    at += step * if k % 50 == 0 { 0.5 } else { 0.01 };
                    at
                })
                .collect();
            let edges = project(&points, true, if case % 3 == 1 { Vec3::z() } else { unit(&DIRECTIONS[1]) });
            let wanted = |i: usize, j: usize| i < j && !adjacent((edges.len(), true), i, j);
            let pairs = (0..edges.len()).flat_map(|i| (i + 1..edges.len()).map(move |j| (i, j)));
            let exact = pairs.filter(|&(i, j)| wanted(i, j)).filter_map(|(i, j)| {
                let sign = crossing(&edges[i], &edges[j])?;
                (sign != 0).then_some((i as u32, j as u32, sign))
            });
            let Some(found) = crossed(&edges, wanted) else { continue };
            assert_eq!(found, exact.collect::<Vec<_>>(), "{case}");
            assert!(found.len() > 20, "{case}: {}", found.len());
        }
    }
}
