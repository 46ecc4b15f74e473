//! Page faults and context switches of this process.

use std::fs;

use serde::{Deserialize, Serialize};

/// Counts since the process began; all zero where the system does not report them (it does on Linux).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Usage {
    /// Minor page faults: first accesses to pages of anonymous memory.
    pub page_faults: u64,
    /// Voluntary context switches of the running threads: a thread had to wait.
    pub waits: u64,
    /// Involuntary context switches of the running threads: another thread got the processor.
    pub preemptions: u64,
}

impl Usage {
    /// The counts so far.
    pub fn now() -> Self {
        let mut usage = Self::default();
        if let Ok(stat) = fs::read_to_string("/proc/self/stat") {
            usage.page_faults = minor_faults(&stat).unwrap_or(0);
        }
        let Ok(threads) = fs::read_dir("/proc/self/task") else { return usage };
        for thread in threads.flatten() {
            if let Ok(status) = fs::read_to_string(thread.path().join("status")) {
                usage.waits += number(&status, "voluntary_ctxt_switches:").unwrap_or(0);
                usage.preemptions += number(&status, "nonvoluntary_ctxt_switches:").unwrap_or(0);
            }
        }
        usage
    }

    /// The sum with the counts of another process.
    pub fn plus(self, other: Self) -> Self {
        Self {
            page_faults: self.page_faults + other.page_faults,
            waits: self.waits + other.waits,
            preemptions: self.preemptions + other.preemptions,
        }
    }

    /// The difference to an earlier count.
    pub fn since(self, earlier: Self) -> Self {
        Self {
            page_faults: self.page_faults.saturating_sub(earlier.page_faults),
            waits: self.waits.saturating_sub(earlier.waits),
            preemptions: self.preemptions.saturating_sub(earlier.preemptions),
        }
    }
}

/// The tenth field. The second one is the program's name in parentheses and may contain anything.
fn minor_faults(stat: &str) -> Option<u64> {
    stat[stat.rfind(')')? + 1..].split_whitespace().nth(7)?.parse().ok()
}

fn number(status: &str, name: &str) -> Option<u64> {
    status.lines().find_map(|line| line.strip_prefix(name)?.trim().parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found() {
        assert_eq!(minor_faults("7 (a) b) S 1 2 3 4 5 6 77 0 9"), Some(77));
        assert_eq!(minor_faults("7 (a"), None);
        let status = "Name:\tx\nvoluntary_ctxt_switches:\t12\nnonvoluntary_ctxt_switches:\t3\n";
        assert_eq!(number(status, "voluntary_ctxt_switches:"), Some(12));
        assert_eq!(number(status, "nonvoluntary_ctxt_switches:"), Some(3));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn page_faults_of_touched_memory_are_counted() {
        let before = Usage::now();
        // Larger than the memory that an allocator keeps.
        let mut memory = vec![0u8; 64 << 20];
        memory.iter_mut().step_by(4096).for_each(|byte| *byte = 1);
        assert!(std::hint::black_box(memory).len() > 1);
        // Pages have 2 MiB at most.
        assert!(Usage::now().since(before).page_faults >= 32);
    }
}
