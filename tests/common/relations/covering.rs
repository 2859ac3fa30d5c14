//! A covering array: few scenes in which any two values of different axes occur together, where that is possible.
//!
//! Greedy, after Cohen, Dalal, Fredman & Patton (1997), IEEE Trans. Softw. Eng. 23:437: each scene begins with a pair
//! that is missing still, and takes on axis after axis the value that completes the most missing pairs, in as many
//! random orders of axes as there are attempts. Combinations that are refused are left by backtracking, so that every
//! scene is legal.

use std::collections::BTreeSet;

use super::super::random::Random;
use super::axes::{AXES, Features, NUM_AXES, REFUSALS, UNBOUND, parts};

/// Two values of different axes, the lower axis first.
pub type Pair = [(usize, usize); 2];

/// Orders of axes that are tried for each scene.
const ATTEMPTS: usize = 30;

type Partial = [Option<usize>; NUM_AXES];

/// Refused combinations as axes and values.
pub struct Rules(Vec<Vec<(usize, Vec<usize>)>>);

impl Rules {
    /// All refusals, or all but one.
    pub fn new(but: Option<usize>) -> Self {
        let kept = REFUSALS.iter().enumerate().filter(|(index, _)| Some(*index) != but);
        let unbound = UNBOUND.iter().map(|together| parts(together));
        Self(kept.map(|(_, refusal)| parts(refusal.together)).chain(unbound).collect())
    }

    fn allow(&self, partial: &Partial) -> bool {
        let applies = |rule: &Vec<(usize, Vec<usize>)>| {
            rule.iter().all(|(axis, values)| partial[*axis].is_some_and(|value| values.contains(&value)))
        };
        !self.0.iter().any(applies)
    }

    /// A legal scene with the values of `partial`, the others as `order` prefers: for each axis its values, the best
    /// first.
    pub fn complete(&self, partial: Partial, order: &[(usize, Vec<usize>)]) -> Option<Features> {
        if !self.allow(&partial) {
            return None;
        }
        let Some(((axis, values), rest)) = order.split_first() else {
            let features: Vec<usize> = partial.iter().flatten().copied().collect();
            return features.try_into().ok();
        };
        if partial[*axis].is_some() {
            return self.complete(partial, rest);
        }
        values.iter().find_map(|&value| {
            let mut next = partial;
            next[*axis] = Some(value);
            self.complete(next, rest)
        })
    }
}

/// The first values of all axes first.
pub fn plain_order() -> Vec<(usize, Vec<usize>)> {
    AXES.iter().enumerate().map(|(axis, it)| (axis, (0..it.values.len()).collect())).collect()
}

/// A scene with certain values and nothing else refused.
pub fn scene_with(values: &[(usize, usize)], rules: &Rules) -> Option<Features> {
    let mut partial = [None; NUM_AXES];
    values.iter().for_each(|&(axis, value)| partial[axis] = Some(value));
    rules.complete(partial, &plain_order())
}

/// All pairs of values of different axes.
pub fn all_pairs() -> Vec<Pair> {
    let values = |axis: usize| (0..AXES[axis].values.len()).map(move |value| (axis, value));
    let axes = (0..NUM_AXES).flat_map(|a| (a + 1..NUM_AXES).map(move |b| (a, b)));
    axes.flat_map(|(a, b)| values(a).flat_map(move |x| values(b).map(move |y| [x, y]))).collect()
}

/// Pairs of a scene.
pub fn pairs_of(features: &Features) -> Vec<Pair> {
    let at = |axis: usize| (axis, features[axis]);
    (0..NUM_AXES).flat_map(|a| (a + 1..NUM_AXES).map(move |b| [at(a), at(b)])).collect()
}

/// Pairs that occur in a legal scene.
pub fn legal_pairs() -> BTreeSet<Pair> {
    let rules = Rules::new(None);
    all_pairs().into_iter().filter(|pair| scene_with(pair, &rules).is_some()).collect()
}

/// Scenes with all legal pairs; other ones for another seed.
pub fn covering(seed: u64) -> Vec<Features> {
    let (rules, mut missing) = (Rules::new(None), legal_pairs());
    let mut random = Random::of(54, seed);
    let mut scenes = Vec::new();
    while let Some(&first) = missing.iter().nth(random.below(missing.len().max(1) as u64) as usize) {
        let mut best: Option<(usize, Features)> = None;
        for _ in 0..ATTEMPTS {
            let Some(features) = attempt(first, &missing, &rules, &mut random) else { continue };
            let gain = pairs_of(&features).iter().filter(|pair| missing.contains(*pair)).count();
            if best.is_none_or(|(most, _)| gain > most) {
                best = Some((gain, features));
            }
        }
        let Some((_, features)) = best else { unreachable!("a legal pair has a legal scene") };
        pairs_of(&features).iter().for_each(|pair| {
            missing.remove(pair);
        });
        scenes.push(features);
    }
    scenes
}

/// A scene with the pair `first`; each further axis takes the value with the most missing pairs with those before.
fn attempt(first: Pair, missing: &BTreeSet<Pair>, rules: &Rules, random: &mut Random) -> Option<Features> {
    let mut partial: Partial = [None; NUM_AXES];
    first.iter().for_each(|&(axis, value)| partial[axis] = Some(value));
    let mut axes: Vec<usize> = (0..NUM_AXES).collect();
    shuffle(&mut axes, random);
    for (done, &axis) in axes.iter().enumerate() {
        if partial[axis].is_some() {
            continue;
        }
        let mut values: Vec<usize> = (0..AXES[axis].values.len()).collect();
        shuffle(&mut values, random);
        let gain = |value: usize| {
            let with = |(other, taken): (usize, &Option<usize>)| {
                taken.is_some_and(|taken| {
                    let mut pair = [(axis, value), (other, taken)];
                    pair.sort_unstable();
                    missing.contains(&pair)
                })
            };
            partial.iter().enumerate().filter(|it| with(*it)).count()
        };
        values.sort_by_key(|&value| std::cmp::Reverse(gain(value)));
        // the first that leaves a legal scene possible
        let rest: Vec<(usize, Vec<usize>)> =
            axes[done..].iter().map(|&axis| (axis, (0..AXES[axis].values.len()).collect())).collect();
        let legal = values.into_iter().find(|&value| {
            let mut next = partial;
            next[axis] = Some(value);
            rules.complete(next, &rest).is_some()
        });
        partial[axis] = Some(legal?);
    }
    rules.complete(partial, &[])
}

fn shuffle(list: &mut [usize], random: &mut Random) {
    for last in (1..list.len()).rev() {
        list.swap(last, random.below(last as u64 + 1) as usize);
    }
}
