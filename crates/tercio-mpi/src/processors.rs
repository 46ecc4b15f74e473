//! The processors that a process of a job may use.

use std::thread::available_parallelism;

use crate::local_processes;

/// Number of processors of this process: what affinity mask, cgroup quota and the other processes of its job on this machine
/// leave, at least 1.
pub fn own_processors() -> usize {
    // On Linux the standard library reads sched_getaffinity and the quotas of cgroup v1 and v2.
    let system = available_parallelism().map_or(1, usize::from);
    share(system, of_launcher(), local_processes())
}

/// The number of processors that the process that started this one may use, unless a quota leaves this process fewer than its
/// own affinity mask has.
#[cfg(target_os = "linux")]
fn of_launcher() -> Option<usize> {
    let own = rustix::thread::sched_getaffinity(None).ok()?.count() as usize;
    let has_quota = available_parallelism().is_ok_and(|all| usize::from(all) < own);
    let launcher = rustix::thread::sched_getaffinity(rustix::process::getppid()).ok()?;
    (!has_quota).then_some(launcher.count() as usize)
}

#[cfg(not(target_os = "linux"))]
fn of_launcher() -> Option<usize> {
    None
}

/// Of the `system` processors that this process may use, its share if there are so many processes of a job on the machine.
/// Those that a launcher has bound to processors of their own keep them: then the `launcher` itself may use more, all of which
/// the processes share.
fn share(system: usize, launcher: Option<usize>, processes: usize) -> usize {
    let all = launcher.map_or(system, |launcher| launcher.max(system));
    system.min(all / processes.max(1)).max(1)
}

#[cfg(test)]
mod tests {
    use super::share;

    #[test]
    fn processes_of_one_machine_share_its_processors() {
        // Alone; not bound; bound to a core, to half of the machine, to more than there is for each.
        assert_eq!(share(16, Some(16), 1), 16);
        assert_eq!([2, 3, 16, 40].map(|processes| share(16, Some(16), processes)), [8, 5, 1, 1]);
        assert_eq!(share(1, Some(16), 4), 1);
        assert_eq!([2, 4].map(|processes| share(8, Some(16), processes)), [8, 4]);
        // A launcher that may use less, or is not known.
        assert_eq!(share(16, Some(1), 4), 4);
        assert_eq!(share(16, None, 4), 4);
    }
}
