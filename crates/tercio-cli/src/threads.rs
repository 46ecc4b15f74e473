//! How many threads the process may use.

use anyhow::{Context, Result};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::mpi;

/// The largest number of threads.
pub const MAX_THREADS: usize = 256;

/// The pool in which everything runs, with the requested or allowed number of threads.
///
/// # Errors
/// If the system refuses that many threads.
pub fn pool(requested: Option<usize>) -> Result<ThreadPool> {
    let threads = wanted(requested);
    let first = processor::current();
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|n| format!("tercio-{n}"))
        .start_handler(move |n| processor::move_to(first + n))
        .build();
    pool.with_context(|| format!("cannot start {threads} threads"))
}

/// The number of threads that the pool will have.
pub fn wanted(requested: Option<usize>) -> usize {
    requested.unwrap_or_else(allowed)
}

/// Placement of threads on processors.
///
/// New threads start on the processor of their parent, and a run of a second may be over before a scheduler has moved
/// one: those that pack threads onto few processors to save energy never do. So each thread is moved to a processor of
/// its own, where it stays until the system has a reason to move it. The first stays with the parent, because the
/// processes of one machine start on different processors.
#[cfg(target_os = "linux")]
mod processor {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

    /// The index of this thread's processor among those it may use; 0 where the system does not report it.
    pub fn current() -> usize {
        let stat = std::fs::read_to_string("/proc/thread-self/stat").unwrap_or_default();
        let processor = in_stat(&stat).unwrap_or(0);
        sched_getaffinity(None).map_or(0, |allowed| (0..processor).filter(|&i| allowed.is_set(i)).count())
    }

    /// The processor in a thread's `stat`: field 39. The second field, a name in brackets, may contain spaces.
    pub(super) fn in_stat(stat: &str) -> Option<usize> {
        let (_, fields) = stat.rsplit_once(')')?;
        let processor = fields.split_whitespace().nth(36)?.parse().ok()?;
        Some(processor).filter(|&p| p < CpuSet::MAX_CPU)
    }

    /// Moves this thread to one of the processors that it may use; `number` wraps round.
    pub fn move_to(number: usize) {
        let Ok(allowed) = sched_getaffinity(None) else { return };
        let count = allowed.count() as usize;
        let processor = (0..CpuSet::MAX_CPU).filter(|&i| allowed.is_set(i)).nth(number % count.max(1));
        if let Some(processor) = processor {
            let mut own = CpuSet::new();
            own.set(processor);
            // A thread that cannot be moved stays where it is.
            if sched_setaffinity(None, &own).is_ok() {
                let _ = sched_setaffinity(None, &allowed);
            }
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod processor {
    pub fn current() -> usize {
        0
    }

    pub fn move_to(_: usize) {}
}

/// The number that affinity mask, cgroup quota, batch system and the other processes of an MPI job on this machine leave.
fn allowed() -> usize {
    limit(mpi::own_processors(), std::env::var("SLURM_CPUS_PER_TASK").ok().as_deref())
}

/// Processors that this process may use, however many threads it has.
pub fn of_process() -> usize {
    allowed()
}

/// Processors of all processes of an MPI job together, if there are as many for each as for this one.
pub fn of_job(processes: usize) -> usize {
    let local = mpi::local_processes().max(1);
    match of_machine() {
        // More processes than processors.
        Some(all) if all < local => (all * processes / local).max(1),
        _ => allowed() * processes,
    }
}

/// Processors of the machine, whether this process may use them or not, where Linux reports them.
pub fn of_machine() -> Option<usize> {
    processors(&std::fs::read_to_string("/sys/devices/system/cpu/online").ok()?)
}

/// The length of a list in the format of Linux: 0-3,8,10-11.
fn processors(list: &str) -> Option<usize> {
    let count = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (first, last): (usize, usize) = (first.parse().ok()?, last.parse().ok()?);
        last.checked_sub(first)?.checked_add(1)
    };
    list.trim().split(',').map(count).sum()
}

/// A job step may see more processors than it was given if Slurm does not bind its tasks.
fn limit(system: usize, slurm: Option<&str>) -> usize {
    let slurm = slurm.and_then(|s| s.trim().parse().ok()).filter(|&n: &usize| n > 0);
    system.min(slurm.unwrap_or(usize::MAX)).clamp(1, MAX_THREADS)
}

#[cfg(test)]
mod tests {
    use super::{limit, processors};

    #[cfg(target_os = "linux")]
    #[test]
    fn the_processor_of_a_thread_is_found() {
        use super::processor::in_stat;
        let fields: Vec<_> = (3..=52).map(|field| field.to_string()).collect();
        assert_eq!(in_stat(&format!("7 (a (b) c) {}", fields.join(" "))), Some(39));
        assert_eq!(["", "7 (a) 1 2 3", &format!("7 (a) {}", "x ".repeat(50))].map(in_stat), [None; 3]);
        let own = std::fs::read_to_string("/proc/thread-self/stat").expect("a file of /proc");
        assert!(in_stat(&own).is_some(), "{own}");
    }

    #[test]
    fn lists_of_processors_are_counted() {
        assert_eq!(["0\n", "0-3", "0-3,8,10-11\n"].map(processors), [Some(1), Some(4), Some(7)]);
        assert_eq!(["", "a-b", "3-1"].map(processors), [None; 3]);
    }

    #[test]
    fn the_smaller_limit_holds() {
        assert_eq!(limit(64, None), 64);
        assert_eq!(limit(64, Some("8")), 8);
        assert_eq!(limit(4, Some("8")), 4);
        assert_eq!(limit(1024, None), 256);
    }

    #[test]
    fn nonsense_of_the_batch_system_is_ignored() {
        for nonsense in ["", "0", "-1", "many", "8.5", "99999999999999999999999"] {
            assert_eq!(limit(16, Some(nonsense)), 16, "{nonsense}");
        }
    }
}
