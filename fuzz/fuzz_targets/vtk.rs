//! The readers of VTK's files: XML if the bytes look like it.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tercio_fuzz::read_bytes;
use tercio_mesh::io::vtk;

fuzz_target!(|bytes: &[u8]| {
    let is_xml = bytes.trim_ascii_start().starts_with(b"<");
    read_bytes(if is_xml { vtk::read_xml } else { vtk::read_legacy }, bytes);
});
