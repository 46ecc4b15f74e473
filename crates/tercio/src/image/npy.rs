//! Arrays for Python: NPY, version 1.0, little-endian, C order. Source: NumPy Enhancement Proposal 1.

use std::io::{self, Write};

/// Number of bytes that are converted and written at once.
const CHUNK: usize = 1 << 14;

/// A number type that NPY supports.
pub trait NpyNumber: Copy {
    /// The name, such as `<f4`.
    const DESCR: &'static str;
    /// Four bytes, the least significant one first.
    fn to_le_bytes(self) -> [u8; 4];
}

impl NpyNumber for f32 {
    const DESCR: &'static str = "<f4";
    fn to_le_bytes(self) -> [u8; 4] {
        self.to_le_bytes()
    }
}

impl NpyNumber for u32 {
    const DESCR: &'static str = "<u4";
    fn to_le_bytes(self) -> [u8; 4] {
        self.to_le_bytes()
    }
}

/// Writes an array of this shape, the last index varying fastest.
///
/// # Errors
/// Errors of `out`.
///
/// # Panics
/// If the number of `values` does not match the shape.
pub fn write<T: NpyNumber>(out: &mut dyn Write, shape: &[usize], values: &[T]) -> io::Result<()> {
    assert_eq!(shape.iter().product::<usize>(), values.len(), "values of an array of shape {shape:?}");
    out.write_all(&header(T::DESCR, shape))?;
    let mut bytes = Vec::with_capacity(CHUNK * 4);
    for chunk in values.chunks(CHUNK) {
        bytes.clear();
        chunk.iter().for_each(|v| bytes.extend_from_slice(&v.to_le_bytes()));
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// The header, padded so that the numbers begin at a multiple of 64 bytes.
fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let lengths: Vec<_> = shape.iter().map(usize::to_string).collect();
    // Python distinguishes a tuple of one from a number in parentheses by its comma.
    let comma = if shape.len() == 1 { "," } else { "" };
    let shape = lengths.join(", ");
    let dict = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}{comma}), }}");
    let unpadded = 10 + dict.len() + 1;
    let padding = unpadded.next_multiple_of(64) - unpadded;
    let length = (dict.len() + padding + 1) as u16;
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend_from_slice(&length.to_le_bytes());
    header.extend_from_slice(dict.as_bytes());
    header.resize(header.len() + padding, b' ');
    header.push(b'\n');
    header
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_is_as_numpy_writes_it() {
        let mut bytes = Vec::new();
        write(&mut bytes, &[1, 2], &[1.0f32, -2.0]).unwrap();
        let text = b"{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2), }";
        assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
        assert_eq!(&bytes[10..10 + text.len()], text);
        assert_eq!(bytes[127], b'\n');
        assert_eq!(bytes[128..], [0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0]);
    }
}
