//! Errors of a thread's last call.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CString, c_char, c_int};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What functions return if they failed.
const FAILED: c_int = 1;

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// The reason why the last function that failed on this thread did so; an empty string if none did. The text is valid until another
/// function fails.
#[unsafe(no_mangle)]
pub extern "C" fn tercio_last_error() -> *const c_char {
    LAST.with_borrow(|last| last.as_ptr())
}

/// The version of the library, as in "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn tercio_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Stores the reason of a failure.
pub fn remember(reason: &dyn Display) {
    let text: Vec<u8> = reason.to_string().bytes().filter(|byte| *byte != 0).collect();
    LAST.set(CString::new(text).unwrap_or_default());
}

/// Runs the work of a function: `None` if it failed or panicked, with the reason stored.
pub fn attempt<T>(work: impl FnOnce() -> Result<T, Box<dyn std::error::Error>>) -> Option<T> {
    let done = catch_unwind(AssertUnwindSafe(work));
    match done {
        Ok(Ok(value)) => return Some(value),
        Ok(Err(error)) => remember(&error),
        Err(panic) => remember(&format!("tercio failed, which is a defect: {}", message(&*panic))),
    }
    None
}

/// The same for functions that return a status.
pub fn status(work: impl FnOnce() -> Result<(), Box<dyn std::error::Error>>) -> c_int {
    attempt(work).map_or(FAILED, |()| 0)
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use super::*;

    fn last() -> String {
        // SAFETY: the text ends with a zero, and no function fails before it is copied.
        unsafe { CStr::from_ptr(tercio_last_error()) }.to_str().expect("UTF-8").to_owned()
    }

    #[test]
    fn errors_and_panics_have_a_reason() {
        assert_eq!((status(|| Ok(())), last().as_str()), (0, ""));
        assert_eq!(status(|| Err("no\0 space".into())), FAILED);
        assert_eq!(last(), "no space");
        assert_eq!(status(|| panic!("at {}", 7)), FAILED);
        assert_eq!(last(), "tercio failed, which is a defect: at 7");
        // What succeeds keeps it.
        assert_eq!((status(|| Ok(())), last().is_empty()), (0, false));
    }
}
