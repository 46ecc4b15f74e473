//! Abnormal ends of the program that bypass the commands: out of memory, and bugs (panics).
//!
//! Both print one line, clean up, and end with the exit code of an error, never by a signal. Nothing is allocated on
//! the way, because there may be no memory. The only lock that is taken is that of the name of a stage, and nothing is
//! allocated while it is held.

use std::cell::Cell;
use std::fmt::Write as _;
use std::panic::PanicHookInfo;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::Duration;

use tercio::mesh::Progress;

use crate::{memory, messages};

/// The exit code of errors: `compare` uses another.
static CODE: AtomicU8 = AtomicU8::new(1);
static CLEAN_UP: OnceLock<fn()> = OnceLock::new();
/// The prefix of errors: coloured on terminals.
static PREFIX: OnceLock<String> = OnceLock::new();
static MODEL: Mutex<Option<String>> = Mutex::new(None);
static WATCHED: Mutex<Option<Arc<Progress>>> = Mutex::new(None);

/// From now on a panic in any thread is reported in one line and ends the program.
pub fn prepare() {
    let _ = PREFIX.set(messages::error_prefix());
    std::panic::set_hook(Box::new(|panic| {
        let mut line = Line::error();
        // A library that panics when data are damaged has found them.
        if let Some(damage) = tercio::mesh::guard::damage() {
            line.put(format_args!("{damage}"));
            finish(line);
        }
        line.mistake(panic);
        // Empty unless RUST_BACKTRACE is set.
        let trace = std::backtrace::Backtrace::capture();
        if trace.status() == std::backtrace::BacktraceStatus::Captured {
            line.end();
            use std::io::Write as _;
            let _ = writeln!(std::io::stderr(), "{trace}");
        }
        finish(line)
    }));
}

/// Sets the exit code of errors.
pub fn set_code(code: u8) {
    CODE.store(code, Ordering::Relaxed);
}

/// Sets the function that is called once before such an end: it removes partial files. It should not allocate.
pub fn at_end(clean_up: fn()) {
    let _ = CLEAN_UP.set(clean_up);
}

/// Sets the name of the model for messages.
pub fn name_model(name: String) {
    if let Ok(mut model) = MODEL.lock() {
        let before = model.replace(name);
        drop(model);
        drop(before);
    }
}

/// Messages name the current stage of this progress.
pub fn watch(progress: &Arc<Progress>) {
    if let Ok(mut watched) = WATCHED.lock() {
        *watched = Some(Arc::clone(progress));
    }
}

/// Ends the program because `size` bytes cannot be allocated besides those in use: they would exceed the `limit`, or
/// the system refuses them.
#[cold]
pub fn out_of_memory(in_use: usize, size: usize, limit: Option<usize>) -> ! {
    memory::lift_limit();
    let stage = WATCHED.try_lock().ok().and_then(|w| w.as_ref().map(|p| p.state().0));
    let stage = stage.filter(|s| !s.is_empty()).unwrap_or("this command");
    let mut line = Line::error();
    if let Some(model) = MODEL.try_lock().ok().as_ref().and_then(|m| m.as_ref()) {
        line.put(format_args!("{model}: "));
    }
    match limit {
        // Worded like the errors of the reader; what is already in use is part of what is needed.
        Some(limit) => {
            let source = memory::limit_source();
            line.put(format_args!(
                "needs {in_use} bytes or more for {stage}, the limit is {limit} bytes ({source})"
            ));
        }
        None => line.put(format_args!(
            "needs {size} bytes more for {stage} besides the {in_use} in use, and the system gives no more (see ulimit -v)"
        )),
    }
    finish(line)
}

thread_local! {
    static IS_ENDING_THREAD: Cell<bool> = const { Cell::new(false) };
}

/// Prints the line and ends the program. The first thread that arrives does so; others wait for the end.
fn finish(mut line: Line) -> ! {
    static ENDING: AtomicBool = AtomicBool::new(false);
    if ENDING.swap(true, Ordering::SeqCst) {
        if IS_ENDING_THREAD.get() {
            // Reached again if the cleaning up panics.
            exit();
        }
        loop {
            std::thread::sleep(Duration::from_secs(1));
        }
    }
    IS_ENDING_THREAD.set(true);
    line.end();
    if let Some(clean_up) = CLEAN_UP.get() {
        clean_up();
    }
    exit()
}

#[cfg(unix)]
fn exit() -> ! {
    // SAFETY: ends the process at once, whatever other threads are doing.
    unsafe { libc::_exit(i32::from(CODE.load(Ordering::Relaxed))) }
}

#[cfg(not(unix))]
fn exit() -> ! {
    std::process::exit(i32::from(CODE.load(Ordering::Relaxed)))
}

/// Enough for the longest path on Linux, and the message about it.
const LONGEST_LINE: usize = 6 << 10;

/// One line of text in a fixed buffer; text that does not fit is dropped.
struct Line {
    text: [u8; LONGEST_LINE],
    length: usize,
}

impl Line {
    fn error() -> Self {
        let mut line = Self { text: [0; LONGEST_LINE], length: 0 };
        // Including its control characters.
        let prefix = PREFIX.get().map_or("error: ", String::as_str);
        prefix.bytes().for_each(|byte| line.push(byte));
        line
    }

    fn push(&mut self, byte: u8) {
        if let Some(place) = self.text.get_mut(self.length) {
            *place = byte;
            self.length += 1;
        }
    }

    fn put(&mut self, text: std::fmt::Arguments) {
        // Never fails.
        let _ = self.write_fmt(text);
    }

    fn mistake(&mut self, panic: &PanicHookInfo) {
        self.put(format_args!("internal error (a bug in tercio, please report it): "));
        let payload = panic.payload();
        let text = payload.downcast_ref::<&str>().copied();
        let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
        self.put(format_args!("{}", text.unwrap_or("a panic")));
        if let Some(place) = panic.location() {
            self.put(format_args!(" ({place})"));
        }
    }

    /// Prints the line, once.
    fn end(&mut self) {
        if self.length > 0 {
            let length = self.length.min(self.text.len() - 1);
            self.text[length] = b'\n';
            write_to_standard_error(&self.text[..=length]);
            self.length = 0;
        }
    }
}

impl std::fmt::Write for Line {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        // File names and messages may contain line breaks, but a message is one line.
        let bytes = text.bytes().map(|b| if b.is_ascii_control() { b' ' } else { b });
        bytes.for_each(|byte| self.push(byte));
        Ok(())
    }
}

#[cfg(unix)]
fn write_to_standard_error(text: &[u8]) {
    // Not through the standard library: another thread may hold its lock for ever. A closed standard error is no
    // reason to fail.
    // SAFETY: the pointer and the length are those of a slice.
    let _ = unsafe { libc::write(libc::STDERR_FILENO, text.as_ptr().cast(), text.len()) };
}

#[cfg(not(unix))]
fn write_to_standard_error(text: &[u8]) {
    use std::io::Write as _;
    let _ = std::io::stderr().write_all(text);
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use crate::memory;

    /// Runs one test of this file in a process of its own, which the test ends.
    fn run_alone(test: &str) -> (Option<i32>, String) {
        let own = std::env::current_exe().unwrap();
        let name = format!("ending::tests::{test}");
        let run = Command::new(own)
            .args([&name, "--exact", "--nocapture", "--test-threads=2"])
            .env("TERCIO_TEST_ALONE", test)
            .env_remove("RUST_BACKTRACE")
            .output()
            .unwrap();
        (run.status.code(), String::from_utf8_lossy(&run.stderr).into_owned())
    }

    fn is_alone(test: &str) -> bool {
        std::env::var_os("TERCIO_TEST_ALONE").is_some_and(|t| t == test)
    }

    #[test]
    fn a_panic_in_any_thread_is_one_line_and_an_error() {
        let test = "a_panic_in_any_thread_is_one_line_and_an_error";
        if is_alone(test) {
            super::prepare();
            super::set_code(2);
            super::at_end(|| super::write_to_standard_error(b"cleaned up\n"));
            let _ = std::thread::spawn(|| panic!("not\nforeseen")).join();
            unreachable!("the program has ended");
        }
        let (code, stderr) = run_alone(test);
        assert_eq!(code, Some(2), "{stderr}");
        let expected = "error: internal error (a bug in tercio, please report it): not foreseen (";
        assert!(stderr.starts_with(expected) && stderr.contains("ending.rs:"), "{stderr}");
        assert!(stderr.ends_with(")\ncleaned up\n") && stderr.lines().count() == 2, "{stderr}");
    }

    #[test]
    fn memory_that_is_refused_is_one_line_and_an_error() {
        let test = "memory_that_is_refused_is_one_line_and_an_error";
        if is_alone(test) {
            super::name_model("a\nmodel.ply".into());
            // More than any address space; the capacity itself does not overflow.
            let _ = std::hint::black_box(Vec::<u8>::with_capacity(1 << 60));
            unreachable!("the program has ended");
        }
        let (code, stderr) = run_alone(test);
        assert_eq!(code, Some(1), "{stderr}");
        assert!(
            stderr.starts_with("error: a model.ply: needs 1152921504606846976 bytes more for "),
            "{stderr}"
        );
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
    }

    #[test]
    fn other_threads_keep_the_limit_until_the_end() {
        use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
        use std::time::{Duration, Instant};
        static IS_ENDING: AtomicBool = AtomicBool::new(false);
        static IS_OVER: AtomicBool = AtomicBool::new(false);
        const MORE: usize = 64 << 20;
        let allocate = || drop(std::hint::black_box(Vec::<u8>::with_capacity(MORE)));
        let test = "other_threads_keep_the_limit_until_the_end";
        if is_alone(test) {
            super::at_end(|| {
                IS_ENDING.store(true, SeqCst);
                let began = Instant::now();
                while !IS_OVER.load(SeqCst) && began.elapsed() < Duration::from_millis(500) {
                    std::thread::yield_now();
                }
                let what: &[u8] = if IS_OVER.load(SeqCst) { b"over\n" } else { b"kept\n" };
                super::write_to_standard_error(what);
            });
            let _ = std::thread::spawn(move || {
                while !IS_ENDING.load(SeqCst) {
                    std::thread::yield_now();
                }
                allocate();
                IS_OVER.store(true, SeqCst);
            });
            memory::set_limit_in_bytes(Some(MORE as u64 / 2), 0);
            allocate();
            unreachable!("the program has ended");
        }
        let (code, stderr) = run_alone(test);
        assert_eq!(code, Some(1), "{stderr}");
        assert!(stderr.starts_with("error: needs ") && stderr.ends_with("\nkept\n"), "{stderr}");
    }
}
