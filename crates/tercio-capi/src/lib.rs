//! The in-situ interface of tercio for C, C++ and Fortran: a [`tercio::Session`] behind plain functions. `include/tercio.h` is
//! made from this crate by cbindgen (`cargo xtask header`), and the documentation of its functions is here.
//!
//! Functions return 0, or another number if they failed; [`tercio_last_error`] has the reason then. Those that are called
//! *collective* have to be called by all processes of a session, in the same order and with the same values, except for arrays.
//! A panic of the library is an error like any other.

// The names are those of C.
#![allow(non_camel_case_types, reason = "the names are those of C")]

mod arrays;
mod error;
mod session;
mod threads;

pub use arrays::tercio_arrays;
pub use error::{tercio_last_error, tercio_version};
pub use session::*;
pub use threads::tercio_set_threads;
