//! Everything between the bytes of a file and the pixels of a small picture.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tercio_fuzz::picture::draw_bytes;

fuzz_target!(|bytes: &[u8]| draw_bytes(bytes));
