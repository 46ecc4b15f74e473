//! Placement of threads on processors.
//!
//! New threads start on the processor of their parent, and a run of a second may be over before a scheduler has moved
//! one: those that pack threads onto few processors to save energy never do. So each thread is moved to a processor of
//! its own, where it stays until the system has a reason to move it. The first stays with the parent, because the
//! processes of one machine start on different processors. Only Linux: elsewhere nothing is moved.

use rayon::ThreadPoolBuilder;

pub use processor::{current, move_to};

/// The builder of a pool whose thread `n` starts on processor `first + n` of those that it may [use](move_to).
pub fn spread(builder: ThreadPoolBuilder, first: usize) -> ThreadPoolBuilder {
    builder.start_handler(move |n| move_to(first.wrapping_add(n)))
}

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

    /// The processor with a number among those that are allowed.
    pub(super) fn chosen(allowed: &CpuSet, number: usize) -> Option<usize> {
        let count = allowed.count() as usize;
        (0..CpuSet::MAX_CPU).filter(|&i| allowed.is_set(i)).nth(number % count.max(1))
    }

    /// Moves this thread to one of the processors that it may use; `number` wraps round. It may still use all of them.
    pub fn move_to(number: usize) {
        let Ok(allowed) = sched_getaffinity(None) else { return };
        if let Some(processor) = chosen(&allowed, number) {
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
    /// The index of this thread's processor among those it may use; 0 where the system does not report it.
    pub fn current() -> usize {
        0
    }

    /// Moves this thread to one of the processors that it may use, where the system allows that.
    pub fn move_to(_: usize) {}
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use rustix::thread::{CpuSet, sched_getaffinity};

    use super::processor::{chosen, in_stat};
    use super::*;

    #[test]
    fn the_processor_of_a_thread_is_found() {
        let fields: Vec<_> = (3..=52).map(|field| field.to_string()).collect();
        assert_eq!(in_stat(&format!("7 (a (b) c) {}", fields.join(" "))), Some(39));
        assert_eq!(["", "7 (a) 1 2 3", &format!("7 (a) {}", "x ".repeat(50))].map(in_stat), [None; 3]);
        let own = std::fs::read_to_string("/proc/thread-self/stat").expect("a file of /proc");
        assert!(in_stat(&own).is_some(), "{own}");
    }

    #[test]
    fn numbers_of_processors_wrap_round_and_pass_over_gaps() {
        let mut allowed = CpuSet::new();
        assert_eq!(chosen(&allowed, 3), None);
        [1, 4, 6].iter().for_each(|&processor| allowed.set(processor));
        assert_eq!([0, 1, 2, 3, 7].map(|number| chosen(&allowed, number)), [1, 4, 6, 1, 4].map(Some));
    }

    #[test]
    fn a_thread_is_where_it_was_moved() {
        let processors = sched_getaffinity(None).expect("the system reports it").count() as usize;
        // The system may move it again at once, but not always.
        let is_there = |number: usize| {
            move_to(number);
            current() == number % processors
        };
        let moved = |number| (0..100).any(|_| is_there(number));
        std::thread::scope(|scope| {
            assert!(scope.spawn(|| (0..processors).all(moved)).join().expect("a thread"))
        });
    }

    #[test]
    fn threads_that_were_moved_may_use_all_processors() {
        let allowed = || sched_getaffinity(None).expect("the system reports it");
        let before = allowed();
        let pool = spread(ThreadPoolBuilder::new().num_threads(3), usize::MAX).build().expect("threads");
        assert!(pool.broadcast(|_| allowed()).iter().all(|now| *now == before));
    }
}
