//! Reading a file of any kind: decompression, the choice of the reader, and the reader.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tercio_fuzz::read_bytes;
use tercio_mesh::io::read_input;

fuzz_target!(|bytes: &[u8]| read_bytes(read_input, bytes));
