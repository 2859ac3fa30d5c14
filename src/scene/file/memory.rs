//! Whether there is memory enough for a scene, before any is taken: running out of it ends a program without a word.

use crate::error::InputError;

/// Least memory that a node takes in a run, bytes: in space, in the plane. Rings of 12000 nodes at a single step take
/// 7500 to 10000 and 4000 to 5000; contact and long runs take more.
const BYTES_A_NODE: [f64; 2] = [7000.0, 4000.0];
const GIB: f64 = (1u64 << 30) as f64;

/// Least memory of a run, bytes.
pub(super) fn least(nodes: usize, planar: bool) -> f64 {
    nodes as f64 * BYTES_A_NODE[usize::from(planar)]
}

/// Refuses a rod with which the scene, of so many nodes up to it, takes more memory than there is.
pub(super) fn check(field: String, elements: usize, nodes: usize, planar: bool) -> Result<(), InputError> {
    let needed = least(nodes, planar);
    match available() {
        Some(available) if needed > available => {
            let (needed, available) = (needed / GIB, available / GIB);
            let reason = format!(
                "{elements} elements are too many: {nodes} nodes take at least {needed:.1} GiB, and {available:.1} GiB \
                 are available"
            );
            Err(InputError::inconsistent(field, &reason))
        }
        _ => Ok(()),
    }
}

/// Memory that this process may still take, bytes, as far as the system tells: what is free, and what limits leave
/// (containers, `ulimit -v`). Linux tells; where nothing does, there is no limit.
fn available() -> Option<f64> {
    let number = |path: &str, name: &str, unit: f64| {
        let text = std::fs::read_to_string(path).ok()?;
        let rest = text.lines().find_map(|line| line.strip_prefix(name))?;
        rest.split_whitespace().next()?.parse::<f64>().ok().map(|value| unit * value)
    };
    let limits = [
        number("/proc/meminfo", "MemAvailable:", 1024.0),
        number("/proc/self/limits", "Max address space", 1.0),
        number("/sys/fs/cgroup/memory.max", "", 1.0),
    ];
    limits.into_iter().flatten().reduce(f64::min)
}
