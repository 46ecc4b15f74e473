//! How much memory this process took at most.

/// The largest resident size so far in bytes; `None` where the system does not tell.
pub fn peak_bytes() -> Option<u64> {
    // Elsewhere the file is not there.
    parse(&std::fs::read_to_string("/proc/self/status").ok()?)
}

fn parse(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
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
