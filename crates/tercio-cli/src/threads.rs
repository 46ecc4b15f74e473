//! How many threads the process may use.

use anyhow::{Context, Result};
use rayon::{ThreadPool, ThreadPoolBuilder};
use tercio::parallel::placement;

use crate::mpi;

/// The largest number of threads.
pub const MAX_THREADS: usize = 256;

/// The pool in which everything runs, with the requested or allowed number of threads.
///
/// # Errors
/// If the system refuses that many threads.
pub fn pool(requested: Option<usize>) -> Result<ThreadPool> {
    let threads = wanted(requested);
    let builder = ThreadPoolBuilder::new().num_threads(threads).thread_name(|n| format!("tercio-{n}"));
    let pool = placement::spread(builder, placement::current()).build();
    pool.with_context(|| format!("cannot start {threads} threads"))
}

/// The number of threads that the pool will have.
pub fn wanted(requested: Option<usize>) -> usize {
    requested.unwrap_or_else(allowed)
}

/// The number that affinity mask, cgroup quota, batch system and the other processes of an MPI job on this machine leave.
fn allowed() -> usize {
    limit(mpi::own_processors(), std::env::var("SLURM_CPUS_PER_TASK").ok().as_deref())
}

/// The number that affinity mask and cgroup quota leave, when the other processes of an MPI job have ended.
pub fn without_others() -> usize {
    limit(std::thread::available_parallelism().map_or(1, usize::from), None)
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
