//! Libraries that panic when data are damaged.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static DAMAGE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Runs a library's work on data that may be damaged; if it panics, that is this error. It is an error for programs that unwind; one
/// that ends on a panic, as it may be built to, reports [`damage`].
///
/// # Errors
/// Those of `work`, and `error` if it panics.
pub(crate) fn guarded<T, E: ToString>(error: E, work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    let text = error.to_string();
    DAMAGE.with(|damage| damage.replace(Some(text)));
    let result = catch_unwind(AssertUnwindSafe(work));
    DAMAGE.with(|damage| damage.replace(None));
    result.unwrap_or(Err(error))
}

/// What is wrong with the data that a library reads on this thread, if it panics now: for panic hooks.
pub fn damage() -> Option<String> {
    DAMAGE.with(|damage| damage.try_borrow().ok()?.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error() {
        assert_eq!(damage(), None);
        let text = || "bytes are damaged".to_owned();
        assert_eq!(guarded(text(), || Ok(damage())), Ok(Some(text())));
        assert_eq!(guarded(text(), || Err::<(), _>("other".to_owned())), Err("other".to_owned()));
        let none: [u8; 0] = [];
        let index = std::hint::black_box(3);
        assert_eq!(guarded(text(), || Ok(none[index])), Err(text()));
        assert_eq!(damage(), None);
    }
}
