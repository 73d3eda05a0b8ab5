//! What the process has used, as Linux tells it, and what it may use; `None` where the system does not tell.

/// Ticks a second in `/proc/self/stat`: the kernel's interface has had it fixed at 100 on every platform of ours.
const TICKS_PER_SECOND: f64 = 100.0;

/// Largest resident memory so far [B].
pub(super) fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Memory that the machine, and the group of processes that this one is in, can still give [B].
pub(super) fn free_memory_bytes() -> Option<u64> {
    let mut system = sysinfo::System::new().ok()?;
    system.refresh_memory();
    let of_machine = system.available_memory();
    let of_group = system.cgroup_limits().map_or(of_machine, |group| {
        group.total_memory.saturating_sub(group.rss)
    });
    Some(of_machine.min(of_group)).filter(|&bytes| bytes > 0)
}

/// Processor time of all threads so far [s].
pub(super) fn cpu_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name in parentheses may hold anything; the fields after it are numbers.
    let mut fields = stat[stat.rfind(')')? + 1..].split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some((ticks()? + ticks()?) as f64 / TICKS_PER_SECOND)
}
