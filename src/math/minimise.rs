//! Minimum of a function of one variable.

/// (3 − √5)/2, the golden section.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// Largest number of iterations; then the best point is returned. Golden section alone shrinks an interval by 1e-20 in
/// 100.
const MAX_ITERATIONS: usize = 100;

/// Argument and value of a local minimum of `f` in `low`..`high`. The argument is accurate to about `tolerance`
/// (absolute; no better than √ε_machine |x| is possible). An end of the interval is returned if `f` decreases towards
/// it.
///
/// Brent's method (Brent 1973, ch. 5): parabolas through the three best points, golden sections where they do not help.
/// A NaN counts as worse than anything.
pub fn minimum(f: impl Fn(f64) -> f64, low: f64, high: f64, tolerance: f64) -> (f64, f64) {
    let value = |x: f64| Some(f(x)).filter(|y| !y.is_nan()).unwrap_or(f64::INFINITY);
    let (mut a, mut b) = (low.min(high), low.max(high));
    let mut x = a + GOLDEN * (b - a);
    let (mut w, mut v) = (x, x);
    let mut fx = value(x);
    let (mut fw, mut fv) = (fx, fx);
    let (mut step, mut before_last) = (0.0_f64, 0.0_f64);
    for _ in 0..MAX_ITERATIONS {
        let middle = 0.5 * (a + b);
        let tol = 1e-9 * x.abs() + 0.25 * tolerance;
        if (x - middle).abs() <= 2.0 * tol - 0.5 * (b - a) {
            break;
        }
        let (mut p, mut q) = (0.0, 0.0);
        if before_last.abs() > tol && fw.is_finite() && fv.is_finite() {
            (p, q) = to_vertex([x, w, v], [fx, fw, fv]);
        }
        if q > 0.0 && p.abs() < (0.5 * q * before_last).abs() && p > q * (a - x) && p < q * (b - x) {
            before_last = step;
            step = p / q;
            let next = x + step;
            if next - a < 2.0 * tol || b - next < 2.0 * tol {
                step = if x < middle { tol } else { -tol };
            }
        } else {
            before_last = if x < middle { b - x } else { a - x };
            step = GOLDEN * before_last;
        }
        let next = x + if step.abs() >= tol { step } else { tol.copysign(step) };
        let found = value(next);
        if found <= fx {
            *(if next < x { &mut b } else { &mut a }) = x;
            ((v, fv), (w, fw), (x, fx)) = ((w, fw), (x, fx), (next, found));
        } else {
            *(if next < x { &mut a } else { &mut b }) = next;
            if found <= fw || w == x {
                ((v, fv), (w, fw)) = ((w, fw), (next, found));
            } else if found <= fv || v == x || v == w {
                (v, fv) = (next, found);
            }
        }
    }
    [low, high]
        .map(|end| (end, value(end)))
        .into_iter()
        .fold((x, fx), |best, end| if end.1 < best.1 { end } else { best })
}

/// From x to the vertex of the parabola through three points (x, fx), (w, fw), (v, fv): numerator and denominator, this
/// not negative, and 0 on a line.
fn to_vertex([x, w, v]: [f64; 3], [fx, fw, fv]: [f64; 3]) -> (f64, f64) {
    let r = (x - w) * (fx - fv);
    let s = (x - v) * (fx - fw);
    let p = (x - v) * s - (x - w) * r;
    let q = 2.0 * (s - r);
    if q > 0.0 { (-p, q) } else { (p, -q) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minima_are_found() {
        let (x, y) = minimum(|x| (x - 0.3).powi(2) + 2.0, -1.0, 5.0, 1e-10);
        assert!((x - 0.3).abs() < 1e-8 && (y - 2.0).abs() < 1e-15, "{x} {y}");
        let (x, _) = minimum(|x: f64| x.powi(4) - x, 0.0, 3.0, 1e-9);
        assert!((x - 0.25_f64.cbrt()).abs() < 1e-7, "{x}");
        let (x, _) = minimum(|x: f64| (x - 1.7).abs().sqrt(), 0.0, 3.0, 1e-10);
        assert!((x - 1.7).abs() < 1e-8, "{x}");
    }

    #[test]
    fn ends_and_gaps() {
        assert_eq!(minimum(|x| x, 2.0, 3.0, 1e-9).0, 2.0);
        assert_eq!(minimum(|x| -x, 2.0, 3.0, 1e-9).0, 3.0);
        let (x, _) = minimum(|x| if x > 2.0 { f64::NAN } else { (x - 1.0).powi(2) }, 0.0, 4.0, 1e-9);
        assert!((x - 1.0).abs() < 1e-7, "{x}");
    }
}
