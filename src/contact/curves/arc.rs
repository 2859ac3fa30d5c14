//! Arcs of curves: intervals of arc length, on a closed curve modulo its `period`.

/// `x` shifted by whole periods so that it is nearest to `target`.
pub(crate) fn near(x: f64, target: f64, period: Option<f64>) -> f64 {
    period.map_or(x, |p| x + p * ((target - x) / p).round())
}

pub(crate) fn ascending(arc: [f64; 2]) -> [f64; 2] {
    [arc[0].min(arc[1]), arc[0].max(arc[1])]
}

/// Distance of two ascending arcs; negative: their overlap. On a closed curve their middles are first shifted together.
pub(crate) fn apart(x: [f64; 2], y: [f64; 2], period: Option<f64>) -> f64 {
    let distance = (near(middle(y), middle(x), period) - middle(x)).abs();
    distance - 0.5 * (x[1] - x[0] + y[1] - y[0])
}

/// The union of two ascending arcs, on the branch of the first.
pub(crate) fn joined(x: [f64; 2], y: [f64; 2], period: Option<f64>) -> [f64; 2] {
    let shift = near(middle(y), middle(x), period) - middle(y);
    [x[0].min(y[0] + shift), x[1].max(y[1] + shift)]
}

fn middle(arc: [f64; 2]) -> f64 {
    0.5 * (arc[0] + arc[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_overlap_across_the_period() {
        assert!(apart([9.5, 10.5], [0.2, 0.4], Some(10.0)) <= 0.0);
        assert!(apart([9.5, 10.5], [0.2, 0.4], None) > 0.0);
        assert!(apart(ascending([3.0, 1.0]), [2.9, 4.0], None) <= 0.0);
        assert!((apart([9.5, 10.5], [0.7, 0.9], Some(10.0)) - 0.2).abs() < 1e-12);
        assert_eq!(joined([9.0, 10.5], [0.2, 0.8], Some(10.0)), [9.0, 10.8]);
    }
}
