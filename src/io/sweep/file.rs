//! Sweep files: a base scene and its axes as TOML text.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Value;

use crate::error::InputError;
use crate::text::read_regular;

use super::random::DrawStream;

/// Largest number of cases of a sweep, because its plan is then a file of a gigabyte.
const MOST_CASES: usize = 10_000_000;
/// Most values of an axis given by its ends.
const MOST_VALUES: usize = 1_000_000;

/// Accepted steps of a case that become rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Rows {
    /// Every step: a load path is one case with many rows.
    #[default]
    All,
    /// The last.
    Last,
}

/// The text of a sweep file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SweepText {
    /// The base scene, relative to the sweep file.
    pub scene: PathBuf,
    #[serde(default)]
    pub rows: Rows,
    /// Values that all cases share.
    #[serde(default)]
    set: BTreeMap<String, Value>,
    /// Every combination of their values.
    #[serde(default)]
    axes: BTreeMap<String, AxisText>,
    /// Linked keys; each group is one axis.
    #[serde(default)]
    linked: Vec<BTreeMap<String, AxisText>>,
    random: Option<RandomText>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "a list of values, or { from, to, count }")]
enum AxisText {
    List(Vec<Value>),
    Range(RangeText),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RangeText {
    from: f64,
    to: f64,
    count: usize,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RandomText {
    seed: u64,
    draws: usize,
    keys: BTreeMap<String, DrawText>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum DrawText {
    Uniform([f64; 2]),
    Normal([f64; 2]),
    Whole([i64; 2]),
    Choice(Vec<Value>),
    Bases(usize),
}

/// The values of one axis, each a group of assignments; a case has one group of each axis.
type SweepAxis = Vec<Vec<String>>;

impl SweepText {
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::parse(&read_regular(path)?, &path.display().to_string())
    }

    fn parse(text: &str, file: &str) -> Result<Self, InputError> {
        let refuse = |e: toml::de::Error| InputError::Parse { file: file.to_owned(), reason: e.to_string() };
        let this: Self = toml::from_str(text).map_err(refuse)?;
        this.check_keys()?;
        Ok(this)
    }

    /// Refuses duplicate keys, because one of the values would be lost.
    fn check_keys(&self) -> Result<(), InputError> {
        let drawn = self.random.iter().flat_map(|random| random.keys.keys());
        let linked = self.linked.iter().flat_map(BTreeMap::keys);
        let mut keys: Vec<&String> = self.set.keys().chain(self.axes.keys()).chain(linked).chain(drawn).collect();
        keys.sort_unstable();
        match keys.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(InputError::inconsistent(pair[0], "is given twice: once in set, axes, linked or random")),
            None => Ok(()),
        }
    }

    /// The assignments that all cases share.
    pub fn shared(&self) -> Vec<String> {
        self.set.iter().map(|(key, value)| assignment(key, value)).collect()
    }

    /// The assignments of every case; the last axis changes fastest.
    pub fn cases(&self) -> Result<Vec<Vec<String>>, InputError> {
        let axes = self.all_axes()?;
        let count = axes.iter().try_fold(1usize, |count, axis| count.checked_mul(axis.len()));
        let Some(count) = count.filter(|&count| count <= MOST_CASES) else {
            return Err(InputError::inconsistent("axes", "make more than 10 million cases"));
        };
        let case = |mut index: usize| {
            let mut groups: Vec<&Vec<String>> = Vec::new();
            for axis in axes.iter().rev() {
                groups.push(&axis[index % axis.len()]);
                index /= axis.len();
            }
            groups.into_iter().rev().flatten().cloned().collect()
        };
        Ok((0..count).map(case).collect())
    }

    fn all_axes(&self) -> Result<Vec<SweepAxis>, InputError> {
        let mut axes = Vec::new();
        for (key, axis) in &self.axes {
            axes.push(axis.values(key)?.iter().map(|value| vec![assignment(key, value)]).collect());
        }
        for group in &self.linked {
            axes.push(linked(group)?);
        }
        axes.extend(self.random.as_ref().map(RandomText::axis).transpose()?);
        Ok(axes)
    }
}

/// The axis of linked keys: the k-th values of all keys go together.
fn linked(group: &BTreeMap<String, AxisText>) -> Result<SweepAxis, InputError> {
    let mut axis: SweepAxis = Vec::new();
    for (key, values) in group {
        let values = values.values(key)?;
        if axis.is_empty() {
            axis = vec![Vec::new(); values.len()];
        }
        if axis.len() != values.len() {
            let reason = format!("has {} values, but it is linked with a key of {}", values.len(), axis.len());
            return Err(InputError::inconsistent(key, &reason));
        }
        axis.iter_mut().zip(&values).for_each(|(case, value)| case.push(assignment(key, value)));
    }
    if axis.is_empty() { Err(InputError::inconsistent("linked", "a group has no keys")) } else { Ok(axis) }
}

impl AxisText {
    fn values(&self, key: &str) -> Result<Vec<Value>, InputError> {
        match self {
            Self::List(values) if values.is_empty() => Err(InputError::inconsistent(key, "has no values")),
            Self::List(values) => Ok(values.clone()),
            Self::Range(range) => range.values(key),
        }
    }
}

/// Largest number of a range that may stand for a whole one, because larger ones have no fractions.
const WHOLE: f64 = 1e15;

impl RangeText {
    fn values(&self, key: &str) -> Result<Vec<Value>, InputError> {
        let Self { from, to, count } = *self;
        InputError::check(&format!("{key}.from"), from, true, "finite")?;
        InputError::check(&format!("{key}.to"), to, true, "finite")?;
        if !(1..=MOST_VALUES).contains(&count) {
            let field = format!("{key}.count");
            return Err(InputError::Count { field, value: count, allowed: "between 1 and 1 million" });
        }
        let last = (count - 1).max(1) as f64;
        // both ends are exact; values between are rounded to 15 digits: 0.025, not 0.02500000000000001
        let short = |x: f64| format!("{x:.14e}").parse().unwrap_or(x);
        let value = |k: usize| match k {
            0 => from,
            k if k + 1 == count => to,
            k => short(from + (to - from) * (k as f64 / last)),
        };
        let values: Vec<f64> = (0..count).map(value).collect();
        // keys that take a fraction take a whole number, too; others do not take 4.0
        let is_whole = |x: &f64| x.fract() == 0.0 && x.abs() <= WHOLE;
        let number = if values.iter().all(is_whole) { |x| Value::Integer(x as i64) } else { Value::Float };
        Ok(values.into_iter().map(number).collect())
    }
}

impl RandomText {
    fn axis(&self) -> Result<SweepAxis, InputError> {
        if !(1..=MOST_CASES).contains(&self.draws) {
            let field = "random.draws".to_owned();
            return Err(InputError::Count { field, value: self.draws, allowed: "between 1 and 10 million" });
        }
        self.keys.iter().try_for_each(|(key, draw)| draw.check(key))?;
        let draw = |index: usize| {
            let one = |(key, draw): (&String, &DrawText)| {
                assignment(key, &draw.value(&mut DrawStream::of(self.seed, key, index)))
            };
            self.keys.iter().map(one).collect()
        };
        Ok((0..self.draws).map(draw).collect())
    }
}

impl DrawText {
    fn check(&self, key: &str) -> Result<(), InputError> {
        let refuse = |reason: &str| Err(InputError::inconsistent(key, reason));
        match self {
            Self::Uniform([low, high]) if !(low.is_finite() && high.is_finite() && low < high) => {
                refuse("uniform must be [low, high], finite, low below high")
            }
            Self::Normal([mean, deviation]) if !(mean.is_finite() && deviation.is_finite() && *deviation > 0.0) => {
                refuse("normal must be [mean, deviation], finite, the deviation above 0")
            }
            Self::Whole([low, high]) if low > high || high.checked_sub(*low).is_none() => {
                refuse("whole must be [low, high], low at most high")
            }
            Self::Choice(values) if values.is_empty() => refuse("choice has no values"),
            Self::Bases(count) if !(1..=MOST_VALUES).contains(count) => refuse("bases must be 1 to 1 million"),
            _ => Ok(()),
        }
    }

    fn value(&self, random: &mut DrawStream) -> Value {
        match self {
            Self::Uniform([low, high]) => Value::Float(low + (high - low) * random.unit()),
            Self::Normal([mean, deviation]) => Value::Float(mean + deviation * random.normal()),
            Self::Whole([low, high]) => Value::Integer(low + random.below((high - low) as u64 + 1) as i64),
            Self::Choice(values) => values[random.below(values.len() as u64) as usize].clone(),
            Self::Bases(count) => {
                let letter = |_| ['A', 'C', 'G', 'T'][random.below(4) as usize];
                Value::String((0..*count).map(letter).collect())
            }
        }
    }
}

fn assignment(key: &str, value: &Value) -> String {
    format!("{key}={value}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cases(text: &str) -> Result<Vec<String>, InputError> {
        let cases = SweepText::parse(&format!("scene = \"a.toml\"\n{text}"), "sweep.toml")?.cases()?;
        Ok(cases.iter().map(|case| case.join(" ")).collect())
    }

    #[test]
    fn axes_are_combined_and_linked_keys_go_together() {
        let text = "axes = { a = [1, 2.5, 'w'], 'b.0.c' = { from = 0, to = 1, count = 3 } }\n\
                    [[linked]]\nd = [1, 2]\ne = ['x', 'y']\n";
        let found = cases(text).unwrap();
        assert_eq!(found.len(), 18);
        assert_eq!(found[0], "a=1 b.0.c=0.0 d=1 e=\"x\"");
        assert_eq!(found[1], "a=1 b.0.c=0.0 d=2 e=\"y\"");
        assert_eq!(found[17], "a=\"w\" b.0.c=1.0 d=2 e=\"y\"");
        assert_eq!(cases("").unwrap(), [""]);
        // a range of whole numbers suits keys that take no others
        let whole = cases("axes = { a = { from = 4, to = 8, count = 3 } }").unwrap();
        assert_eq!(whole, ["a=4", "a=6", "a=8"]);
        let round = cases("axes = { a = { from = -0.05, to = 0.05, count = 5 } }").unwrap();
        assert_eq!(round, ["a=-0.05", "a=-0.025", "a=0.0", "a=0.025", "a=0.05"]);
    }

    #[test]
    fn more_draws_leave_the_first_as_they_were() {
        let of = |draws: usize, more: &str| {
            let keys = "u = { uniform = [2, 3] }, w = { whole = [-1, 1] }, s = { bases = 12 }";
            cases(&format!("random = {{ seed = 3, draws = {draws}, keys = {{ {keys} {more} }} }}")).unwrap()
        };
        assert_eq!(of(9, "")[..4], of(4, ""));
        let wider = of(4, ", n = { normal = [0, 1] }, c = { choice = ['p', 'q'] }");
        for (one, other) in wider.iter().zip(of(4, "")) {
            assert!(other.split(' ').all(|word| one.contains(word)), "{one} / {other}");
        }
    }

    #[test]
    fn what_makes_no_sweep_is_refused_with_key_and_value() {
        for (text, reason) in [
            ("axes = { a = [] }", "a: has no values"),
            ("axes = { a = 1 }", "a list of values, or { from, to, count }"),
            ("axes = { a = { from = 0, to = 1, count = 0 } }", "a.count = 0: must be between 1 and 1 million"),
            ("axes = { a = { from = 0, to = inf, count = 2 } }", "a.to = inf: must be finite"),
            ("axes = { a = [1] }\nset = { a = 2 }", "a: is given twice"),
            ("[[linked]]\na = [1, 2]\nb = [1]", "b: has 1 values, but it is linked with a key of 2"),
            ("random = { seed = 1, draws = 0, keys = {} }", "random.draws = 0"),
            ("random = { seed = 1, draws = 1, keys = { a = { uniform = [1, 1] } } }", "a: uniform must be [low, high]"),
            ("axis = {}", "unknown field `axis`"),
            ("rows = 'some'", "unknown variant `some`, expected `all` or `last`"),
            (
                "axes = { a = { from = 0, to = 1, count = 1000000 }, b = { from = 0, to = 1, count = 11 } }",
                "10 million",
            ),
        ] {
            let error = cases(text).unwrap_err().to_string();
            assert!(error.contains(reason), "{text}: {error}");
        }
    }
}
