//! Numbers and strings of a C program.

use std::ffi::{CStr, c_char};
use std::slice;

use crate::session::Failed;

/// Some values of a program.
///
/// # Safety
/// The pointer is null, or points to so many values.
pub unsafe fn values<T: Copy, const N: usize>(at: *const T, what: &str) -> Result<[T; N], Failed> {
    if at.is_null() {
        return Err(format!("{what} is NULL").into());
    }
    // SAFETY: as required from the caller.
    let values = unsafe { slice::from_raw_parts(at, N) };
    Ok(std::array::from_fn(|k| values[k]))
}

/// A string of a program.
///
/// # Safety
/// The pointer is null, or points to a C string, which lives long enough.
pub unsafe fn text<'a>(at: *const c_char) -> Result<&'a str, Failed> {
    if at.is_null() {
        return Err("a string is NULL".into());
    }
    // SAFETY: as required from the caller.
    let text = unsafe { CStr::from_ptr(at) };
    text.to_str().map_err(|_| format!("{text:?} is not UTF-8").into())
}

/// Numbers from 0 to 1.
pub fn unit<const N: usize>(values: [f64; N]) -> Result<[f64; N], Failed> {
    match values.iter().find(|value| !(0.0..=1.0).contains(*value)) {
        Some(value) => Err(format!("expected numbers from 0 to 1, found {value}").into()),
        None => Ok(values),
    }
}
