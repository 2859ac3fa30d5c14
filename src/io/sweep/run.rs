//! Parallel cases, each on one thread; rows are written at regular intervals.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use crate::error::InputError;
use crate::solve::Interrupt;

use super::case::{CONVERGED, STATUS};
use super::collect::finished_ids;
use super::columns::SweepTable;
use super::parts::write_part;
use super::plan::{Case, Plan};

/// A part of the cases: case k belongs to shard k modulo `count`, so that neighbours, which cost about the same, are
/// spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Index of the shard, from 0.
    pub index: usize,
    /// Number of shards, at least 1.
    pub count: usize,
}

impl Shard {
    /// All cases.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Reads `i/n`.
    ///
    /// # Errors
    /// [`InputError::Name`] for anything but two whole numbers, the first below the second.
    pub fn parse(text: &str) -> Result<Self, InputError> {
        let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((index, count)) if index < count => Ok(Self { index, count }),
            _ => {
                let allowed = "i/n, whole numbers with 0 <= i < n".to_owned();
                Err(InputError::Name { field: "shard".to_owned(), name: text.to_owned(), allowed })
            }
        }
    }

    fn has(self, index: usize) -> bool {
        index % self.count.max(1) == self.index
    }
}

/// Settings of a run of a sweep.
#[derive(Debug, Clone)]
pub struct SweepRun {
    /// The cases to run.
    pub shard: Shard,
    /// Number of parallel cases, at least 1.
    pub jobs: usize,
    /// Time limit, s; running cases are then stopped and left for the next run.
    pub max_seconds: Option<f64>,
    /// Longest time before rows are written \[s\]; a killed process loses at most this.
    pub part_seconds: f64,
    /// Stops all running cases; they are left for the next run.
    pub interrupt: Interrupt,
}

impl Default for SweepRun {
    fn default() -> Self {
        let jobs = std::thread::available_parallelism().map_or(1, usize::from);
        let (max_seconds, interrupt) = (None, Interrupt::default());
        Self { shard: Shard::WHOLE, jobs, max_seconds, part_seconds: 10.0, interrupt }
    }
}

/// Progress of a run of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Cases of the shard.
    pub cases: usize,
    /// Cases that had rows before.
    pub before: usize,
    /// Cases that this run has finished.
    pub done: usize,
    /// Cases among these that did not converge.
    pub failed: usize,
}

impl Tally {
    /// Cases without rows yet.
    #[must_use]
    pub fn missing(&self) -> usize {
        self.cases - self.before - self.done
    }
}

impl SweepRun {
    /// Runs the cases of the shard that have no rows yet in the folder of a sweep; `watch` sees every finished one. Two
    /// runs of the same cases at the same time are safe, because both write the same rows.
    ///
    /// # Errors
    /// A plan or parts that cannot be read, [`InputError::Write`] if rows cannot be written.
    pub fn go(&self, dir: &Path, watch: &mut dyn FnMut(&Tally)) -> Result<Tally, InputError> {
        let plan = Plan::read(dir)?;
        let there = finished_ids(dir)?;
        let shard: Vec<&Case> =
            plan.cases().iter().enumerate().filter(|(k, _)| self.shard.has(*k)).map(|(_, c)| c).collect();
        let left: Vec<&Case> = shard.iter().copied().filter(|case| !there.contains(&case.id)).collect();
        let mut tally = Tally { cases: shard.len(), before: shard.len() - left.len(), ..Tally::default() };
        watch(&tally);
        let (sender, receiver) = channel();
        let next = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..self.jobs.clamp(1, left.len().max(1)) {
                let sender = sender.clone();
                scope.spawn(|| self.work(&plan, &left, &next, sender));
            }
            drop(sender);
            let mut writer = RowWriter { dir, rows: SweepTable::default(), last: Instant::now(), error: None };
            let started = Instant::now();
            loop {
                match receiver.recv_timeout(self.pause(started, &writer)) {
                    Ok(rows) => {
                        tally.done += 1;
                        tally.failed += usize::from(!converged(&rows));
                        writer.rows.append(&rows, 0..rows.num_rows());
                        watch(&tally);
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
                if self.max_seconds.is_some_and(|limit| started.elapsed().as_secs_f64() >= limit) {
                    self.interrupt.raise();
                }
                if writer.last.elapsed().as_secs_f64() >= self.part_seconds && !writer.write() {
                    self.interrupt.raise();
                }
            }
            writer.write();
            writer.error.map_or(Ok(tally), Err)
        })
    }

    fn work(&self, plan: &Plan, cases: &[&Case], next: &AtomicUsize, rows: Sender<SweepTable>) {
        while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            let ended = (!self.interrupt.is_raised()).then(|| plan.run(case, &self.interrupt)).flatten();
            // the receiver is dropped only at the end
            if ended.is_none_or(|ended| rows.send(ended).is_err()) {
                return;
            }
        }
    }

    /// Time to wait for the end of a case.
    fn pause(&self, started: Instant, writer: &RowWriter) -> Duration {
        let until = |seconds: f64, since: Instant| seconds - since.elapsed().as_secs_f64();
        let limit = self.max_seconds.map_or(f64::INFINITY, |limit| until(limit, started));
        let write = if writer.rows.num_rows() > 0 { until(self.part_seconds, writer.last) } else { f64::INFINITY };
        // at least every minute, at most every hundredth of a second
        Duration::from_secs_f64(limit.min(write).clamp(0.01, 60.0))
    }
}

fn converged(rows: &SweepTable) -> bool {
    rows.column(STATUS).and_then(|status| status.text(0)).is_some_and(|status| status == CONVERGED)
}

/// Rows waiting to be written.
struct RowWriter<'a> {
    dir: &'a Path,
    rows: SweepTable,
    last: Instant,
    error: Option<InputError>,
}

impl RowWriter<'_> {
    /// Writes the waiting rows; returns whether it succeeded.
    fn write(&mut self) -> bool {
        if self.error.is_none() && self.rows.num_rows() > 0 {
            match write_part(self.dir, &self.rows) {
                Ok(()) => self.rows = SweepTable::default(),
                Err(error) => self.error = Some(error),
            }
        }
        self.last = Instant::now();
        self.error.is_none()
    }
}
