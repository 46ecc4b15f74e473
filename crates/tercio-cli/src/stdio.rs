//! Whether the program was given a standard output.

/// True if standard output was closed when the program began (`>&-`).
///
/// Before `main` the standard library opens `/dev/null` in place of standard streams that are closed, where everything
/// written is lost without an error. Afterwards that cannot be told from a `/dev/null` that the caller chose, so it is
/// looked at earlier. Told on Linux only.
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

    // SAFETY: the loader calls the functions that this section lists before `main`, and ignores what they leave in
    // registers. This one asks the kernel one thing and stores the answer; it needs nothing that is set up later.
    #[used]
    #[unsafe(link_section = ".init_array")]
    static RECORD_STDOUT_STATE: extern "C" fn() = record_stdout_state;

    extern "C" fn record_stdout_state() {
        CLOSED.store(rustix::io::fcntl_getfd(rustix::stdio::stdout()).is_err(), Relaxed);
    }
}
