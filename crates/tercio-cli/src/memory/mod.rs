//! How much memory this process takes, and how much it may take.
//!
//! [`Allocator`] is the program's global allocator. It counts allocations; one that exceeds the limit, or that the
//! system refuses, ends the program with one line and an exit code ([`crate::ending`]). In most cases the demand of a
//! stage is known in advance, and the library reports it in better words; this is for all other cases.
//!
//! The limit is kept to within 4 MB, and the pages of the program's own file, which all processes share and the system drops
//! when memory is short. Counted are the blocks of the heap as they are allocated, mapped model files, and the stacks of threads.

mod allocator;
mod count;
mod system;

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU8, Ordering};

pub use allocator::Allocator;
pub use count::lift_limit;
#[cfg(test)]
pub use count::set_limit as set_limit_in_bytes;
pub use system::peak_bytes;

/// Memory of an idle thread: the touched part of its stack, and what the C library keeps for it.
const A_THREAD: usize = 64 << 10;

/// Who set a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Option,
    Machine,
    ControlGroup,
    AddressSpace,
    Data,
    Share,
}

/// A limit in bytes.
type Limit = (u64, Source);

impl Source {
    const ALL: [Self; 6] =
        [Self::Option, Self::Machine, Self::ControlGroup, Self::AddressSpace, Self::Data, Self::Share];

    fn words(self) -> &'static str {
        match self {
            Self::Option => "--memory-limit",
            Self::Machine => "what the machine has available",
            Self::ControlGroup => "what the control groups leave",
            Self::AddressSpace => "what ulimit -v leaves",
            Self::Data => "what ulimit -d leaves",
            Self::Share => "what the machine has available, divided by the processes of the job on it",
        }
    }
}

static SOURCE: AtomicU8 = AtomicU8::new(0);

/// Who set the limit, as messages print it in brackets after the limit. Allocates nothing.
pub fn limit_source() -> &'static str {
    Source::ALL[usize::from(SOURCE.load(Ordering::Relaxed))].words()
}

fn set_limit(limit: Option<Limit>, besides: usize) {
    if let Some((_, source)) = limit {
        SOURCE.store(source as u8, Ordering::Relaxed);
    }
    count::set_limit(limit.map(|l| l.0), besides);
}

/// Sets the limit for every command until it sets its own with [`limit`]: what the system leaves.
pub fn begin() {
    prepare(None);
    set_limit(system::limit(), 0);
}

/// Prepares the allocator for a limit; to be called before there are threads. If a limit was `requested`, or
/// one of the system's holds for this process, free memory is returned to the system at once.
pub fn prepare(requested: Option<u64>) {
    let own = system::own_limits();
    if requested.is_some() || own.is_some() {
        allocator::return_what_is_free(own.is_some());
    }
}

/// Most bytes that models and pictures may take: `requested` if given, else what the system and its limits for this
/// process leave. The first call, after the threads have started, decides; from then on the limit holds for all
/// allocations.
pub fn limit(requested: Option<u64>, threads: usize) -> Option<u64> {
    static LIMIT: OnceLock<Option<u64>> = OnceLock::new();
    *LIMIT.get_or_init(|| {
        let limit = requested.map(|bytes| (bytes, Source::Option)).or_else(system::limit);
        set_limit(limit, threads * A_THREAD);
        limit.map(|l| l.0)
    })
}

#[cfg(test)]
mod tests {
    use super::Source;

    #[test]
    fn a_source_is_recovered_from_its_number() {
        assert!(Source::ALL.into_iter().enumerate().all(|(number, source)| source as usize == number));
    }
}
