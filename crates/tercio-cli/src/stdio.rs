//! Whether standard output was open when the program started.

/// True if standard output was closed when the program began (`>&-`).
///
/// Before `main` the standard library opens `/dev/null` in place of closed standard streams, so that output is lost
/// without an error. Afterwards this cannot be distinguished from a `/dev/null` that the caller chose, so the check is
/// done earlier. On Linux only.
pub fn output_was_closed() -> bool {
    #[cfg(target_os = "linux")]
    return at_start::CLOSED.load(std::sync::atomic::Ordering::Relaxed);
    #[cfg(not(target_os = "linux"))]
    false
}

#[cfg(target_os = "linux")]
mod at_start {
    use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

    pub static CLOSED: AtomicBool = AtomicBool::new(false);

    // SAFETY: the loader calls the functions listed in this section before `main`, and ignores their return values.
    // This one makes one system call and stores the result; it needs nothing that is initialised later.
    #[used]
    #[unsafe(link_section = ".init_array")]
    static RECORD_STDOUT_STATE: extern "C" fn() = record_stdout_state;

    extern "C" fn record_stdout_state() {
        CLOSED.store(rustix::io::fcntl_getfd(rustix::stdio::stdout()).is_err(), Relaxed);
    }
}
