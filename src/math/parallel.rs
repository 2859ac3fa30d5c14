//! Work shared among threads: the only file that names the library for it.
//!
//! Work is an index range cut into pieces of a given `grain`. Pieces are computed in any order by any thread, and their
//! results are merged in the order of the index. The cuts depend on the length and the grain alone, so results are the
//! same bits for any number of threads. Callers pass a `&dyn Fn`: the machinery is compiled once, not once per
//! caller.
//!
//! Threads are those of the caller's rayon pool, or of a [`Pool`]. Without the feature `parallel` there is one thread,
//! the caller's. So it is in a process that was forked after threads had been used: they are not in the copy, and work
//! given to them would wait for ever (Python's `multiprocessing` forks). A [`Pool`] made there has threads of its own.

use std::ops::Range;
#[cfg(feature = "parallel")]
use std::sync::atomic::AtomicU32;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

#[cfg(feature = "parallel")]
use rayon::prelude::*;

use crate::error::InputError;

/// Items per piece of work of tens to hundreds of nanoseconds each (boxes, capsules, pairs of straight segments),
/// because a piece should take tens of microseconds.
pub(crate) const CHEAP: usize = 1024;
/// Items per piece of work of microseconds each (elements, terms of pairs of segments), for the same reason.
pub(crate) const DEAR: usize = 64;

/// A pool of threads apart from the caller's.
#[derive(Debug)]
pub(crate) struct Pool {
    #[cfg(feature = "parallel")]
    threads: rayon::ThreadPool,
}

impl Pool {
    /// Starts `count` threads.
    ///
    /// # Errors
    /// Threads that cannot be started.
    #[cfg(feature = "parallel")]
    pub(crate) fn new(count: usize) -> Result<Self, InputError> {
        let refuse = |e: rayon::ThreadPoolBuildError| InputError::Inconsistent {
            field: "threads".to_owned(),
            reason: e.to_string(),
        };
        Ok(Self { threads: rayon::ThreadPoolBuilder::new().num_threads(count).build().map_err(refuse)? })
    }

    /// No threads but the caller's, whatever the count: results do not depend on it.
    #[cfg(not(feature = "parallel"))]
    pub(crate) fn new(_count: usize) -> Result<Self, InputError> {
        Ok(Self {})
    }
}

/// Runs `work` inside `pool`, or inside the caller's if there is none: one change of pool for all parallel calls
/// inside.
pub(crate) fn in_pool<R: Send>(pool: Option<&Pool>, work: impl FnOnce() -> R + Send) -> R {
    let (mut work, mut result) = (Some(work), None);
    enter(pool, &mut || result = work.take().map(|work| work()));
    result.expect("a pool runs what it is given")
}

#[cfg(feature = "parallel")]
fn enter(pool: Option<&Pool>, work: &mut (dyn FnMut() + Send)) {
    match pool {
        Some(pool) => pool.threads.install(work),
        None if is_inside_pool() || is_forked() => work(),
        None => rayon::scope(|_| work()),
    }
}

#[cfg(feature = "parallel")]
fn is_inside_pool() -> bool {
    rayon::current_thread_index().is_some()
}

/// The process that first used the common threads; 0: none yet.
#[cfg(feature = "parallel")]
static OWNER: AtomicU32 = AtomicU32::new(0);

/// Whether this process is a copy of one that had used the common threads, which the copy has not.
#[cfg(feature = "parallel")]
fn is_forked() -> bool {
    let here = std::process::id();
    match OWNER.compare_exchange(0, here, Ordering::Relaxed, Ordering::Relaxed) {
        Ok(_) => false,
        Err(owner) => owner != here,
    }
}

#[cfg(not(feature = "parallel"))]
fn enter(_pool: Option<&Pool>, work: &mut (dyn FnMut() + Send)) {
    work();
}

/// Whether only one thread is available.
pub(crate) fn is_serial() -> bool {
    num_threads() == 1
}

/// Number of threads available. Results must not depend on it.
pub(crate) fn num_threads() -> usize {
    #[cfg(feature = "parallel")]
    return if !is_inside_pool() && is_forked() { 1 } else { rayon::current_num_threads() };
    #[cfg(not(feature = "parallel"))]
    return 1;
}

/// Calls `task` for 0, 1 … `count` − 1.
fn share(count: usize, task: &(dyn Fn(usize) + Sync)) {
    #[cfg(feature = "parallel")]
    if count > 1 && !is_serial() {
        return (0..count).into_par_iter().for_each(task);
    }
    (0..count).for_each(task);
}

/// Results of `piece` on the ranges that 0..`len` is cut into, each but the last of `grain` indices, in their order.
pub(crate) fn map_ranges<T: Send>(len: usize, grain: usize, piece: &(dyn Fn(Range<usize>) -> T + Sync)) -> Vec<T> {
    let range = |k: usize| k * grain..((k + 1) * grain).min(len);
    let results: Vec<Mutex<Option<T>>> = (0..len.div_ceil(grain)).map(|_| Mutex::new(None)).collect();
    share(results.len(), &|k| {
        let result = piece(range(k));
        *results[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
    });
    results.into_iter().filter_map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// `item(k)` for k in 0..`len`, in order.
pub(crate) fn map<T: Send>(len: usize, grain: usize, item: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
    if len <= grain || is_serial() {
        return (0..len).map(item).collect();
    }
    let mut all = Vec::with_capacity(len);
    for part in map_ranges(len, grain, &|range| range.map(item).collect::<Vec<T>>()) {
        all.extend(part);
    }
    all
}

/// Sum of `part` over the ranges that 0..`len` is cut into, each but the last of `grain` indices, in their order.
pub(crate) fn sum(len: usize, grain: usize, part: &(dyn Fn(Range<usize>) -> f64 + Sync)) -> f64 {
    if len <= grain { part(0..len) } else { map_ranges(len, grain, part).iter().sum() }
}

/// Whether `holds` is true for all ranges that 0..`len` is cut into, each but the last of `grain` indices. After the
/// first false one, ranges not yet begun are skipped.
pub(crate) fn all(len: usize, grain: usize, holds: &(dyn Fn(Range<usize>) -> bool + Sync)) -> bool {
    let so_far = AtomicBool::new(true);
    share(len.div_ceil(grain), &|k| {
        if so_far.load(Ordering::Relaxed) && !holds(k * grain..((k + 1) * grain).min(len)) {
            so_far.store(false, Ordering::Relaxed);
        }
    });
    so_far.into_inner()
}

/// Calls `change(first, part)` for the parts that `items` is cut into, each but the last of `grain` items; `first` is
/// the index of the part's first item.
pub(crate) fn each_part<T: Send>(items: &mut [T], grain: usize, change: &(dyn Fn(usize, &mut [T]) + Sync)) {
    let parts: Vec<Mutex<&mut [T]>> = items.chunks_mut(grain).map(Mutex::new).collect();
    share(parts.len(), &|k| change(k * grain, &mut parts[k].lock().unwrap_or_else(PoisonError::into_inner)));
}

/// Calls `change(index, item)` for each of `items`, `grain` of them at a time.
pub(crate) fn each<T: Send>(items: &mut [T], grain: usize, change: &(dyn Fn(usize, &mut T) + Sync)) {
    each_part(items, grain, &|first, part| {
        for (k, item) in part.iter_mut().enumerate() {
            change(first + k, item);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every index appears once, in its place, for any length, grain and number of threads.
    #[test]
    fn what_is_shared_out_comes_back_in_order() {
        for threads in [1, 3] {
            let pool = Pool::new(threads).unwrap();
            for (len, grain) in [(0, 5), (1, 5), (5, 5), (6, 5), (1000, 7)] {
                let expected: Vec<usize> = (0..len).collect();
                let (mapped, ranges, changed) = in_pool(Some(&pool), || {
                    let mut items = vec![0; len];
                    each(&mut items, grain, &|k, item| *item += k);
                    (map(len, grain, &|k| k), map_ranges(len, grain, &|range| range), items)
                });
                assert_eq!((&mapped, &changed), (&expected, &expected), "{len} by {grain}");
                assert!(ranges.iter().flat_map(Clone::clone).eq(0..len) && ranges.len() == len.div_ceil(grain));
                let plain = |range: Range<usize>| range.map(|k| k as f64).sum();
                assert_eq!(in_pool(Some(&pool), || sum(len, grain, &plain)), plain(0..len));
                assert!(in_pool(Some(&pool), || all(len, grain, &|range| range.end <= len)));
                assert_eq!(in_pool(Some(&pool), || all(len, grain, &|range| !range.contains(&(len / 2)))), len == 0);
            }
        }
    }
}
