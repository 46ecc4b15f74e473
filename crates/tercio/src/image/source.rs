//! What decoders of pictures read.

use std::io::{BufRead, Cursor, Seek};

/// Bytes that a decoder reads, and seeks in.
pub(crate) trait Input: BufRead + Seek {}

impl<R: BufRead + Seek> Input for R {}

/// The one type of reader that decoders are given: they are generic, and the compiler makes all of them again for each
/// other type.
pub(crate) type Source<'a> = Box<dyn Input + 'a>;

/// The bytes of a picture file.
pub(crate) fn in_memory(bytes: &[u8]) -> Source<'_> {
    Box::new(Cursor::new(bytes))
}
