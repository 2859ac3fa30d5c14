//! Memory that is available, because a program that runs out of it is ended without a message.

/// Bytes of a GiB.
pub(crate) const GIB: f64 = (1u64 << 30) as f64;

/// Memory available to this process, bytes: free memory, and the rest of limits (containers, `ulimit -v`). Known on
/// Linux; `None` elsewhere.
pub(crate) fn available() -> Option<f64> {
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
