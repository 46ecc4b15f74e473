//! Handling of signals from a user or a batch system.

/// From now on a signal that ends the program (INT, TERM, HUP, and of the rarer ones QUIT, ALRM, USR1, USR2, XCPU)
/// first removes the partial files and then has its default effect, so that a shell sees the status 130, 143 or 129.
/// Signals that were ignored when the program started, as `nohup` does with HUP, stay ignored. Exceeding `ulimit -f` is
/// an error of writing, not a signal.
pub fn watch() {
    #[cfg(unix)]
    on_unix::watch();
}

#[cfg(unix)]
mod on_unix {
    use std::sync::atomic::AtomicBool;
    use std::sync::{Arc, mpsc};
    use std::thread;

    use signal_hook::consts::{
        SIGALRM, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU, SIGXFSZ,
    };
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;
    use tercio::image::remove_partial_files;

    const ENDING: [i32; 8] = [SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGALRM, SIGUSR1, SIGUSR2, SIGXCPU];

    const STACK_BYTES: usize = 128 << 10;

    pub fn watch() {
        // With any handler the write that exceeds the limit fails; without one the signal ends the program, which also
        // happens if the handler cannot be installed.
        let _ = signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
        let (ready, is_ready) = mpsc::channel::<()>();
        let wait = move || {
            let ignored = ignored_signals();
            let watched = ENDING.into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
            // Without handlers, signals have their default effect.
            let Ok(mut signals) = Signals::new(watched) else { return };
            drop(ready);
            if let Some(signal) = signals.forever().next() {
                remove_partial_files();
                let _ = emulate_default_handler(signal);
            }
        };
        // Handlers without a thread that waits for them would swallow the signals: so the thread installs them.
        if thread::Builder::new().name("tercio-signals".into()).stack_size(STACK_BYTES).spawn(wait).is_ok() {
            let _ = is_ready.recv();
        }
    }

    /// One bit a signal, the lowest for signal 1; 0 where the system does not report it.
    fn ignored_signals() -> u64 {
        in_status(&std::fs::read_to_string("/proc/self/status").unwrap_or_default()).unwrap_or(0)
    }

    fn in_status(status: &str) -> Option<u64> {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    }

    #[cfg(test)]
    mod tests {
        #[test]
        fn ignored_signals_are_found() {
            assert_eq!(super::in_status("SigBlk:\t3\nSigIgn:\t0000000000001001\n"), Some(0x1001));
            assert_eq!(super::in_status("SigIgn:\tmany"), None);
        }
    }
}
