//! The LAS and LAZ reader.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tercio_fuzz::read_bytes;
use tercio_mesh::io::las;

fuzz_target!(|bytes: &[u8]| read_bytes(las::read, bytes));
