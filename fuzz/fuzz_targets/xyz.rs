//! The reader of point clouds as text.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tercio_fuzz::read_bytes;
use tercio_mesh::io::xyz;

fuzz_target!(|bytes: &[u8]| read_bytes(xyz::read, bytes));
