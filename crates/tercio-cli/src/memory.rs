//! How much memory this process took at most.

/// The largest resident size so far in bytes; `None` where the system does not tell.
pub fn peak_bytes() -> Option<u64> {
    // Elsewhere the file is not there.
    parse(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// Bytes that this process could still take: what the system has available and its control group allows;
/// `None` where the system does not tell.
pub fn available_bytes() -> Option<u64> {
    let file = |path: &str| std::fs::read_to_string(path).ok();
    let number = |path: &str| file(path)?.trim().parse::<u64>().ok();
    let system = file("/proc/meminfo").and_then(|text| line(&text, "MemAvailable:"));
    let group = number("/sys/fs/cgroup/memory.max")
        .map(|most| most.saturating_sub(number("/sys/fs/cgroup/memory.current").unwrap_or(0)));
    system.into_iter().chain(group).min()
}

fn parse(status: &str) -> Option<u64> {
    line(status, "VmHWM:")
}

/// The bytes that a line of the form `KEY 123 kB` tells.
fn line(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find_map(|l| l.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_high_water_mark_is_found() {
        assert_eq!(super::parse("Name:\ttercio\nVmHWM:\t    2048 kB\nVmRSS:\t 1 kB\n"), Some(2 << 20));
        assert_eq!(super::parse("Name:\ttercio\n"), None);
    }
}
