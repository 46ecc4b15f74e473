//! The ends of the program that no command returns from: memory that is not there, and mistakes of the program.
//!
//! Both say one line, clean up, and end with the exit code of an error, never by a signal. Nothing is allocated on the
//! way, because there may be no memory, and no lock is waited for but that of the name of a stage, under which nothing is
//! allocated.

use std::cell::Cell;
use std::fmt::Write as _;
use std::panic::PanicHookInfo;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::Duration;

use tercio::mesh::Progress;

use crate::{memory, messages};

/// The exit code of errors: `compare` has another one.
static CODE: AtomicU8 = AtomicU8::new(1);
static CLEAN_UP: OnceLock<fn()> = OnceLock::new();
/// How an error begins: coloured on terminals.
static PREFIX: OnceLock<String> = OnceLock::new();
static MODEL: Mutex<Option<String>> = Mutex::new(None);
static WATCHED: Mutex<Option<Arc<Progress>>> = Mutex::new(None);

/// From now on a panic, in whatever thread, is reported in one line and ends the program.
pub fn prepare() {
    let _ = PREFIX.set(messages::error_prefix());
    std::panic::set_hook(Box::new(|panic| {
        let mut line = Line::error();
        line.mistake(panic);
        // For who asks for it (RUST_BACKTRACE); else it is empty.
        let trace = std::backtrace::Backtrace::capture();
        if trace.status() == std::backtrace::BacktraceStatus::Captured {
            line.end();
            use std::io::Write as _;
            let _ = writeln!(std::io::stderr(), "{trace}");
        }
        finish(line)
    }));
}

/// The exit code of errors from now on.
pub fn set_code(code: u8) {
    CODE.store(code, Ordering::Relaxed);
}

/// What is called before the program ends in one of these ways, once: removes unfinished files. It should not allocate.
pub fn at_end(clean_up: fn()) {
    let _ = CLEAN_UP.set(clean_up);
}

/// The model that messages name from now on.
pub fn name_model(name: String) {
    if let Ok(mut model) = MODEL.lock() {
        let before = model.replace(name);
        drop(model);
        drop(before);
    }
}

/// Messages name the stage that this progress is in.
pub fn watch(progress: &Arc<Progress>) {
    if let Ok(mut watched) = WATCHED.lock() {
        *watched = Some(Arc::clone(progress));
    }
}

/// Ends the program because there is no room for so many bytes besides those in use: by the `limit`, or because the
/// system gives no more.
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
        // As the errors of the reader; what is counted already is part of what is needed.
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

/// Says it and ends the program. The first thread that comes here does so; others wait for the end.
fn finish(mut line: Line) -> ! {
    static ENDING: AtomicBool = AtomicBool::new(false);
    if ENDING.swap(true, Ordering::SeqCst) {
        if IS_ENDING_THREAD.get() {
            // The cleaning up failed.
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
    // SAFETY: ends the process at once, without what other threads may be in the middle of.
    unsafe { libc::_exit(i32::from(CODE.load(Ordering::Relaxed))) }
}

#[cfg(not(unix))]
fn exit() -> ! {
    std::process::exit(i32::from(CODE.load(Ordering::Relaxed)))
}

/// Room for the longest path that Linux knows, and for what is said of it.
const LONGEST_LINE: usize = 6 << 10;

/// One line of text that needs no memory; what does not fit is left out.
struct Line {
    text: [u8; LONGEST_LINE],
    length: usize,
}

impl Line {
    fn error() -> Self {
        let mut line = Self { text: [0; LONGEST_LINE], length: 0 };
        // With its control characters.
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
        // It never fails.
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

    /// Writes the line, once.
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
        // File names and messages may hold line breaks, and a message is one line.
        let bytes = text.bytes().map(|b| if b.is_ascii_control() { b' ' } else { b });
        bytes.for_each(|byte| self.push(byte));
        Ok(())
    }
}

#[cfg(unix)]
fn write_to_standard_error(text: &[u8]) {
    // Not through the standard library, whose lock another thread may hold for ever. A closed standard error is no
    // reason to fail.
    // SAFETY: the bytes are there.
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

    /// Runs one test of this file in a process of its own, where it ends the program.
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
        let (code, said) = run_alone(test);
        assert_eq!(code, Some(2), "{said}");
        let expected = "error: internal error (a bug in tercio, please report it): not foreseen (";
        assert!(said.starts_with(expected) && said.contains("ending.rs:"), "{said}");
        assert!(said.ends_with(")\ncleaned up\n") && said.lines().count() == 2, "{said}");
    }

    #[test]
    fn memory_that_is_refused_is_one_line_and_an_error() {
        let test = "memory_that_is_refused_is_one_line_and_an_error";
        if is_alone(test) {
            super::name_model("a\nmodel.ply".into());
            // More than any address space holds; the capacity itself is no overflow.
            let _ = std::hint::black_box(Vec::<u8>::with_capacity(1 << 60));
            unreachable!("the program has ended");
        }
        let (code, said) = run_alone(test);
        assert_eq!(code, Some(1), "{said}");
        assert!(said.starts_with("error: a model.ply: needs 1152921504606846976 bytes more for "), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}
