//! A quantity along a rod: constant, piecewise constant, piecewise linear, or a function.

use std::fmt;
use std::ops::{Add, Mul, Range};
use std::sync::Arc;

use crate::error::InputError;
use crate::math::quadrature::Rule;

/// Values that can be averaged: numbers, vectors, matrices.
pub trait Averaged: Copy + PartialEq + Add<Output = Self> + Mul<f64, Output = Self> + Send + Sync + 'static {}

impl<T: Copy + PartialEq + Add<Output = T> + Mul<f64, Output = T> + Send + Sync + 'static> Averaged for T {}

/// Largest relative difference between the end of a table and the length of its rod, because tables are written with
/// few digits.
const TOL_LENGTH: f64 = 1e-6;

/// A quantity as a function of the reference arc length s of a rod, independent of the mesh. Clones share their data.
///
/// Elements use values at their integration points. Constant pieces are averaged over each point's share of its
/// element, a part as long as the point's weight: no piece is missed, and the integral along the rod is exact. Points
/// and functions are evaluated at the integration points. Natural strains that jump inside an element are those that
/// its interpolation has on the stress-free rod, see [`Natural::Varying`](crate::rod::Natural).
///
/// ```
/// use supercoil::rod::Along;
/// let twist = Along::pieces(vec![1.0, 3.0], vec![0.2, 0.5])?; // 0.2 up to s = 1, 0.5 up to s = 3
/// assert_eq!((twist.at(0.5), twist.at(2.9)), (0.2, 0.5));
/// let turning = Along::function(|s: f64| (2.0 * s).cos());
/// assert_eq!(turning.at(0.0), 1.0);
/// # Ok::<(), supercoil::InputError>(())
/// ```
#[derive(Clone)]
pub struct Along<T>(Arc<Kind<T>>);

enum Kind<T> {
    Constant(T),
    /// Value k holds up to end k.
    Pieces(Vec<f64>, Vec<T>),
    Points(Vec<f64>, Vec<T>),
    Function(Box<dyn Fn(f64) -> T + Send + Sync>),
}

impl<T: Averaged> Along<T> {
    /// A constant.
    pub fn constant(value: T) -> Self {
        Self(Arc::new(Kind::Constant(value)))
    }

    /// Constant pieces: `values[k]` from the end of the piece before, or 0, to `ends[k]` \[L\]. The last end is the
    /// length of the rod.
    ///
    /// # Errors
    /// No piece, ends that do not increase from 0, other numbers of ends than of values.
    pub fn pieces(ends: Vec<f64>, values: Vec<T>) -> Result<Self, InputError> {
        check_lists("ends", &ends, values.len(), 1)?;
        InputError::positive("ends[0]", ends[0])?;
        Ok(Self(Arc::new(Kind::Pieces(ends, values))))
    }

    /// Points `arcs` \[L\] with straight lines between them. The first is 0, the last the length of the rod.
    ///
    /// # Errors
    /// Fewer than two points, a first one that is not 0, arc lengths that do not increase, other numbers of arc lengths
    /// than of values.
    pub fn points(arcs: Vec<f64>, values: Vec<T>) -> Result<Self, InputError> {
        check_lists("arcs", &arcs, values.len(), 2)?;
        InputError::check("arcs[0]", arcs[0], arcs[0] == 0.0, "0, the start of the rod")?;
        Ok(Self(Arc::new(Kind::Points(arcs, values))))
    }

    /// Any function of s \[L\], evaluated from 0 to the length of the rod.
    pub fn function(of_arc: impl Fn(f64) -> T + Send + Sync + 'static) -> Self {
        Self(Arc::new(Kind::Function(Box::new(of_arc))))
    }

    /// The quantity `of` makes of this one at each arc length, over arc lengths `factor` times as long: pieces stay
    /// pieces, points stay points. `of` takes arc lengths before they are multiplied: the end of a piece, 0 for a
    /// constant.
    ///
    /// ```
    /// use supercoil::rod::Along;
    /// let twist = Along::pieces(vec![1.0, 3.0], vec![0.2, 0.5])?;
    /// let in_half_units = twist.map(2.0, |_, twist| 0.5 * twist);
    /// assert_eq!(in_half_units, Along::pieces(vec![2.0, 6.0], vec![0.1, 0.25])?);
    /// # Ok::<(), supercoil::InputError>(())
    /// ```
    #[must_use]
    pub fn map<U: Averaged>(&self, factor: f64, of: impl Fn(f64, T) -> U + Send + Sync + 'static) -> Along<U> {
        let each = |arcs: &[f64], values: &[T]| arcs.iter().zip(values).map(|(arc, value)| of(*arc, *value)).collect();
        let longer = |arcs: &[f64]| arcs.iter().map(|arc| factor * arc).collect();
        Along(Arc::new(match &*self.0 {
            Kind::Constant(value) => Kind::Constant(of(0.0, *value)),
            Kind::Pieces(ends, values) => Kind::Pieces(longer(ends), each(ends, values)),
            Kind::Points(arcs, values) => Kind::Points(longer(arcs), each(arcs, values)),
            Kind::Function(_) => {
                let given = self.clone();
                Kind::Function(Box::new(move |s| of(s / factor, given.at(s / factor))))
            }
        }))
    }

    /// Whether it was made as a constant.
    pub(crate) fn is_constant(&self) -> bool {
        matches!(&*self.0, Kind::Constant(_))
    }

    /// Value at s. At a joint of pieces the later one counts; beyond the ends the nearest value.
    pub fn at(&self, s: f64) -> T {
        match &*self.0 {
            Kind::Constant(value) => *value,
            Kind::Pieces(ends, values) => values[piece(ends, s)],
            Kind::Points(arcs, values) => {
                let after = arcs.partition_point(|arc| *arc <= s).clamp(1, arcs.len() - 1);
                let (from, to) = (arcs[after - 1], arcs[after]);
                let part = ((s - from) / (to - from)).clamp(0.0, 1.0);
                values[after - 1] * (1.0 - part) + values[after] * part
            }
            Kind::Function(of_arc) => of_arc(s),
        }
    }

    /// (1 − part) × this + part × other, exact where both are tables of the same arc lengths, or one is constant.
    pub(crate) fn mixed(&self, other: &Self, part: f64) -> Self {
        let mix = move |a: T, b: T| a * (1.0 - part) + b * part;
        let with = |values: &[T], of: &dyn Fn(T) -> T| values.iter().map(|value| of(*value)).collect();
        let both = |a: &[T], b: &[T]| a.iter().zip(b).map(|(a, b)| mix(*a, *b)).collect();
        Self(Arc::new(match (&*self.0, &*other.0) {
            (Kind::Constant(a), Kind::Constant(b)) => Kind::Constant(mix(*a, *b)),
            (Kind::Constant(a), Kind::Pieces(ends, b)) => Kind::Pieces(ends.clone(), with(b, &|b| mix(*a, b))),
            (Kind::Constant(a), Kind::Points(arcs, b)) => Kind::Points(arcs.clone(), with(b, &|b| mix(*a, b))),
            (Kind::Pieces(ends, a), Kind::Pieces(same, b)) if ends == same => Kind::Pieces(ends.clone(), both(a, b)),
            (Kind::Points(arcs, a), Kind::Points(same, b)) if arcs == same => Kind::Points(arcs.clone(), both(a, b)),
            _ => {
                let (a, b) = (self.clone(), other.clone());
                Kind::Function(Box::new(move |s| mix(a.at(s), b.at(s))))
            }
        }))
    }

    /// Values at the integration points of the element that begins at `start` and has length `length`; entries beyond
    /// the rule's points repeat the first.
    pub(crate) fn on_element(&self, start: f64, length: f64, rule: &Rule) -> [T; 3] {
        let mut from = start;
        let mut out = [None; 3];
        for (g, (point, weight)) in rule.points.iter().zip(rule.weights).enumerate() {
            let to = from + weight * length;
            out[g] = Some(match &*self.0 {
                Kind::Pieces(ends, values) => mean(ends, values, from, to),
                _ => self.at(start + point * length),
            });
            from = to;
        }
        out.map(|value| value.or(out[0]).unwrap_or_else(|| self.at(start)))
    }

    /// Whether constant pieces of different values meet between two arc lengths. A joint within rounding of an end is
    /// none.
    pub(crate) fn jumps_between(&self, from: f64, to: f64) -> bool {
        let Kind::Pieces(ends, values) = &*self.0 else { return false };
        let margin = TOL_JOINT * (to - from);
        let (first, last) = (piece(ends, from + margin), piece(ends, to - margin));
        values[first..=last].windows(2).any(|pair| pair[0] != pair[1])
    }

    /// The constant pieces from one arc length to another: their values and lengths; `None` if it is not made of
    /// pieces.
    pub(crate) fn pieces_between(&self, from: f64, to: f64) -> Option<Vec<(T, f64)>> {
        let (ends, values): (&[f64], &[T]) = match &*self.0 {
            Kind::Pieces(ends, values) => (ends, values),
            Kind::Constant(value) => return Some(vec![(*value, to - from)]),
            Kind::Points(..) | Kind::Function(_) => return None,
        };
        let (first, last) = (piece(ends, from), piece(ends, to));
        let part = |k: usize| {
            let begin = if k == first { from } else { ends[k - 1] };
            let end = if k == last { to } else { ends[k] };
            (values[k], end - begin)
        };
        Some((first..=last).map(part).collect())
    }

    /// Number of rows of a table; `None` of a constant or a function.
    pub(crate) fn num_rows(&self) -> Option<usize> {
        match &*self.0 {
            Kind::Pieces(_, values) | Kind::Points(_, values) => Some(values.len()),
            Kind::Constant(_) | Kind::Function(_) => None,
        }
    }

    /// The rows of a table that act between two arc lengths, as a table of their own, and which they are. All of a
    /// constant or a function, which have none.
    pub(crate) fn rows_between(&self, from: f64, to: f64) -> (Self, Range<usize>) {
        match &*self.0 {
            Kind::Pieces(ends, values) => {
                let range = piece(ends, from)..piece(ends, to) + 1;
                let part = Kind::Pieces(ends[range.clone()].to_vec(), values[range.clone()].to_vec());
                (Self(Arc::new(part)), range)
            }
            Kind::Points(arcs, values) => {
                let last = arcs.len() - 1;
                let after = |s: f64| arcs.partition_point(|arc| *arc <= s).clamp(1, last);
                let range = after(from) - 1..after(to) + 1;
                let part = Kind::Points(arcs[range.clone()].to_vec(), values[range.clone()].to_vec());
                (Self(Arc::new(part)), range)
            }
            Kind::Constant(_) | Kind::Function(_) => (self.clone(), 0..0),
        }
    }

    /// The table with a row changed.
    pub(crate) fn with_row_changed(&self, row: usize, by: &T) -> Self {
        let changed = |values: &[T]| {
            let mut values = values.to_vec();
            values[row] = values[row] + *by;
            values
        };
        match &*self.0 {
            Kind::Pieces(ends, values) => Self(Arc::new(Kind::Pieces(ends.clone(), changed(values)))),
            Kind::Points(arcs, values) => Self(Arc::new(Kind::Points(arcs.clone(), changed(values)))),
            Kind::Constant(_) | Kind::Function(_) => self.clone(),
        }
    }

    /// Mean over a rod of length `length`. The mean of a function is that of samples, accurate enough for scales.
    pub(crate) fn mean(&self, length: f64) -> T {
        match &*self.0 {
            Kind::Constant(value) => *value,
            Kind::Pieces(ends, values) => mean(ends, values, 0.0, length),
            Kind::Points(arcs, values) => {
                let trapezium = |k: usize| (values[k] + values[k + 1]) * (0.5 * (arcs[k + 1] - arcs[k]) / length);
                (1..arcs.len() - 1).map(trapezium).fold(trapezium(0), |sum, next| sum + next)
            }
            Kind::Function(of_arc) => {
                let sample =
                    |k: u32| of_arc(length * (f64::from(k) + 0.5) / f64::from(SAMPLES)) * f64::from(SAMPLES).recip();
                (1..SAMPLES).map(sample).fold(sample(0), |sum, next| sum + next)
            }
        }
    }

    /// Refuses a table that does not end at `length`, the length of the rod. Passes each value and its arc length to
    /// `check`; those of a function at the integration points of the elements.
    pub(crate) fn check(
        &self,
        field: &str,
        length: f64,
        (num_elements, rule): (usize, &Rule),
        mut check: impl FnMut(f64, &T) -> Result<(), InputError>,
    ) -> Result<(), InputError> {
        match &*self.0 {
            Kind::Constant(value) => check(0.0, value),
            Kind::Pieces(arcs, values) | Kind::Points(arcs, values) => {
                let end = arcs[arcs.len() - 1];
                if (end - length).abs() > TOL_LENGTH * length {
                    let reason = format!("ends at s = {end}, but the rod is {length} long");
                    return Err(InputError::Inconsistent { field: field.to_owned(), reason });
                }
                arcs.iter().zip(values).try_for_each(|(arc, value)| check(*arc, value))
            }
            Kind::Function(of_arc) => {
                let spacing = length / num_elements as f64;
                let arcs = (0..num_elements).flat_map(|e| rule.points.iter().map(move |x| (e as f64 + x) * spacing));
                arcs.into_iter().try_for_each(|s| check(s, &of_arc(s)))
            }
        }
    }
}

/// Distance of a joint of pieces from the end of an element, over its length, that is rounding of arc lengths.
const TOL_JOINT: f64 = 1e-9;

/// Samples of a function for its mean, because the mean serves for scales only.
const SAMPLES: u32 = 1000;

/// The piece that s lies in.
fn piece(ends: &[f64], s: f64) -> usize {
    ends.partition_point(|end| *end <= s).min(ends.len() - 1)
}

/// Mean of constant pieces from `from` to `to`; the last piece has no end.
fn mean<T: Averaged>(ends: &[f64], values: &[T], from: f64, to: f64) -> T {
    let (first, last) = (piece(ends, from), piece(ends, to));
    let part = |k: usize| {
        let begin = if k == first { from } else { ends[k - 1] };
        let end = if k == last { to } else { ends[k] };
        values[k] * ((end - begin) / (to - from))
    };
    if first == last { values[first] } else { (first + 1..=last).map(part).fold(part(first), |sum, next| sum + next) }
}

impl Along<f64> {
    /// The smallest value of a table or a constant; of a function, that at 0.
    #[cfg(feature = "scenes")]
    pub(crate) fn least(&self) -> f64 {
        match &*self.0 {
            Kind::Pieces(_, values) | Kind::Points(_, values) => values.iter().copied().fold(f64::INFINITY, f64::min),
            Kind::Constant(_) | Kind::Function(_) => self.at(0.0),
        }
    }
}

fn check_lists(name: &str, arcs: &[f64], num_values: usize, fewest: usize) -> Result<(), InputError> {
    if arcs.len() < fewest {
        let allowed = if fewest == 1 { "at least 1" } else { "at least 2" };
        return Err(InputError::Count { field: format!("number of {name}"), value: arcs.len(), allowed });
    }
    if arcs.len() != num_values {
        let (field, allowed) = ("number of values".to_owned(), "as many as arc lengths");
        return Err(InputError::Count { field, value: num_values, allowed });
    }
    for (k, arc) in arcs.iter().enumerate() {
        let increases = k == 0 || *arc > arcs[k - 1];
        InputError::check(&format!("{name}[{k}]"), *arc, increases, "finite and greater than the one before")?;
    }
    Ok(())
}

/// All its numbers; of functions, nothing.
impl<T: fmt::Debug> fmt::Debug for Along<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &*self.0 {
            Kind::Constant(value) => write!(f, "Along::constant({value:?})"),
            Kind::Pieces(ends, values) => write!(f, "Along::pieces({ends:?}, {values:?})"),
            Kind::Points(arcs, values) => write!(f, "Along::points({arcs:?}, {values:?})"),
            Kind::Function(_) => f.write_str("Along::function"),
        }
    }
}

/// Equality of the data; functions are equal if they are the same object.
impl<T: PartialEq> PartialEq for Along<T> {
    fn eq(&self, other: &Self) -> bool {
        match (&*self.0, &*other.0) {
            _ if Arc::ptr_eq(&self.0, &other.0) => true,
            (Kind::Constant(a), Kind::Constant(b)) => a == b,
            (Kind::Pieces(s, a), Kind::Pieces(t, b)) | (Kind::Points(s, a), Kind::Points(t, b)) => s == t && a == b,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::gauss;

    #[test]
    fn pieces_keep_their_integral_on_any_mesh() {
        let ends = vec![0.3, 0.31, 1.7, 2.0];
        let along = Along::pieces(ends.clone(), vec![1.0, -200.0, 3.0, 0.5]).unwrap();
        let integral = 0.3 - 200.0 * 0.01 + 3.0 * 1.39 + 0.5 * 0.3;
        for (order, elements) in [(1, 1), (1, 7), (2, 3), (3, 1), (3, 11)] {
            let (rule, h) = (gauss(order), 2.0 / f64::from(elements));
            let of = |e: i32| along.on_element(f64::from(e) * h, h, &rule);
            let sum: f64 =
                (0..elements).map(|e| of(e).iter().zip(rule.weights).map(|(v, w)| v * w * h).sum::<f64>()).sum();
            assert!((sum - integral).abs() < 1e-13, "{order} {elements}: {sum}");
        }
        assert!((along.mean(2.0) - 0.5 * integral).abs() < 1e-14);
        assert_eq!(along.on_element(0.4, 0.2, &gauss(3)), [3.0; 3]);
        assert_eq!([0.0, 0.3, 0.305, 2.0, 5.0].map(|s| along.at(s)), [1.0, -200.0, -200.0, 0.5, 0.5]);
    }

    #[test]
    fn points_and_functions_are_evaluated_at_the_points() {
        let along = Along::points(vec![0.0, 1.0, 3.0], vec![2.0, 4.0, 0.0]).unwrap();
        assert_eq!([-1.0, 0.0, 0.5, 2.0, 3.0, 9.0].map(|s| along.at(s)), [2.0, 2.0, 3.0, 2.0, 0.0, 0.0]);
        assert!((along.mean(3.0) - 7.0 / 3.0).abs() < 1e-15);
        let square = Along::function(|s: f64| s * s);
        let (rule, found) = (gauss(3), square.on_element(1.0, 2.0, &gauss(3)));
        for (value, x) in found.iter().zip(rule.points) {
            assert!((value - (1.0 + 2.0 * x).powi(2)).abs() < 1e-14);
        }
        assert!((square.mean(3.0) - 3.0).abs() < 1e-5);
    }

    #[test]
    fn maps_keep_their_kind() {
        let double = |along: &Along<f64>| along.map(4.0, |arc, value| 2.0 * value + arc);
        assert_eq!(double(&Along::constant(3.0)), Along::constant(6.0));
        let (arcs, values) = (vec![0.0, 1.0, 2.0], vec![1.0, 2.0, 5.0]);
        let points = Along::points(arcs, values).unwrap();
        assert_eq!(double(&points), Along::points(vec![0.0, 4.0, 8.0], vec![2.0, 5.0, 12.0]).unwrap());
        let function = Along::function(|s: f64| s * s);
        assert_eq!(double(&function).at(8.0), 2.0 * 4.0 + 2.0);
    }

    #[test]
    fn bad_tables_are_refused() {
        let message = |along: Result<Along<f64>, InputError>| along.unwrap_err().to_string();
        assert_eq!(message(Along::pieces(vec![], vec![])), "number of ends = 0: must be at least 1");
        assert_eq!(message(Along::points(vec![0.0], vec![1.0])), "number of arcs = 1: must be at least 2");
        assert!(message(Along::pieces(vec![1.0, 1.0], vec![0.0; 2])).starts_with("ends[1] = 1: must be finite and g"));
        assert!(message(Along::pieces(vec![1.0, f64::NAN], vec![0.0; 2])).starts_with("ends[1] = NaN"));
        assert!(message(Along::pieces(vec![1.0, 2.0], vec![0.0; 3])).starts_with("number of values = 3"));
        assert!(message(Along::pieces(vec![-1.0], vec![0.0])).starts_with("ends[0] = -1"));
        assert!(message(Along::points(vec![0.1, 1.0], vec![0.0; 2])).starts_with("arcs[0] = 0.1: must be 0"));
        let short = Along::pieces(vec![1.0], vec![0.0]).unwrap();
        let refused = short.check("rods.a.natural", 2.0, (1, &gauss(1)), |_, _| Ok(())).unwrap_err().to_string();
        assert_eq!(refused, "rods.a.natural: ends at s = 1, but the rod is 2 long");
    }
}
