//! The functions of `tercio.h` as a library for C.

pub use tercio_capi::*;
