//! Memory check before a run, because a program that runs out of memory is ended without a message.

use crate::error::InputError;

/// Smallest memory of a node in a run, bytes, in space and in the plane. Rings of 12000 nodes use 7500 to 10000 and
/// 4000 to 5000 in a single step; contact and long runs use more.
const BYTES_A_NODE: [f64; 2] = [7000.0, 4000.0];
const GIB: f64 = (1u64 << 30) as f64;

/// Smallest memory of a run, bytes.
pub(super) fn least(nodes: usize, planar: bool) -> f64 {
    nodes as f64 * BYTES_A_NODE[usize::from(planar)]
}

/// Refuses a rod with which the scene needs more memory than available; `nodes` counts those of the rods before it.
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

/// Memory available to this process, bytes: free memory, and the rest of limits (containers, `ulimit -v`). Known on
/// Linux; `None` elsewhere.
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
