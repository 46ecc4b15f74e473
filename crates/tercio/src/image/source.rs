//! What decoders of pictures read.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom};

/// Bytes that a decoder reads, and seeks in: the one type of reader that decoders are given. They are generic, and the compiler makes
/// all of them again for each other type. A trait object would be called for each byte of some formats.
pub(crate) enum Source<'a> {
    Memory(Cursor<&'a [u8]>),
    File(BufReader<File>),
}

/// The bytes of a picture file.
pub(crate) fn in_memory(bytes: &[u8]) -> Source<'_> {
    Source::Memory(Cursor::new(bytes))
}

/// A picture file that is not read yet.
pub(crate) fn in_file(file: File) -> Source<'static> {
    Source::File(BufReader::new(file))
}

macro_rules! of_either {
    ($source:expr, $reader:ident => $value:expr) => {
        match $source {
            Source::Memory($reader) => $value,
            Source::File($reader) => $value,
        }
    };
}

impl Read for Source<'_> {
    #[inline]
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        of_either!(self, reader => reader.read(to))
    }

    #[inline]
    fn read_exact(&mut self, to: &mut [u8]) -> io::Result<()> {
        of_either!(self, reader => reader.read_exact(to))
    }
}

impl BufRead for Source<'_> {
    #[inline]
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        of_either!(self, reader => reader.fill_buf())
    }

    #[inline]
    fn consume(&mut self, count: usize) {
        of_either!(self, reader => reader.consume(count));
    }
}

impl Seek for Source<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        of_either!(self, reader => reader.seek(to))
    }
}
