//! Arrays in memory or in a mapped file.

use std::fmt;
use std::ops::{Deref, Range};
use std::sync::Arc;

use bytemuck::{AnyBitPattern, Pod, Zeroable};
use memmap2::Mmap;

/// A cache line. The data of clusters begin at multiples of it, so that vector loads are aligned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Line(pub [u8; 64]);

impl Line {
    /// Bytes of a line.
    pub const BYTES: usize = 64;
}

/// An array in memory of its own or in a mapped file.
pub enum Buffer<T> {
    /// In memory.
    Owned(Vec<T>),
    /// In zeroed memory from the system; its byte range. The system assigns such memory page by page to the threads
    /// that write it first, but not at the alignment of a [`Line`].
    Zeroed(Vec<u64>, Range<usize>),
    /// In a file: the map, and its byte range in it.
    Mapped(Arc<Mmap>, Range<usize>),
}

impl<T: Pod> Buffer<T> {
    /// This many zero elements.
    pub(super) fn zeroed(count: usize) -> Self {
        let bytes = count * size_of::<T>();
        let words: Vec<u64> = bytemuck::zeroed_vec((bytes + align_of::<T>()).div_ceil(size_of::<u64>()));
        let first = words.as_ptr().align_offset(align_of::<T>()) * size_of::<u64>();
        Self::Zeroed(words, first..first + bytes)
    }

    /// The elements for writing.
    ///
    /// # Panics
    /// If they are in a file.
    pub(super) fn as_mut_slice(&mut self) -> &mut [T] {
        match self {
            Self::Owned(values) => values,
            Self::Zeroed(words, range) => {
                bytemuck::cast_slice_mut(&mut bytemuck::cast_slice_mut::<u64, u8>(words)[range.clone()])
            }
            Self::Mapped(..) => unreachable!("files are not written"),
        }
    }
}

impl<T: AnyBitPattern> Clone for Buffer<T> {
    fn clone(&self) -> Self {
        match self {
            Self::Mapped(file, range) => Self::Mapped(Arc::clone(file), range.clone()),
            // A copy of the words may be aligned differently.
            _ => Self::Owned(self.to_vec()),
        }
    }
}

impl<T: AnyBitPattern> Buffer<T> {
    /// A byte range of a mapped file; `None` if it is out of bounds, does not hold whole elements or is not aligned.
    pub fn mapped(file: &Arc<Mmap>, range: Range<usize>) -> Option<Self> {
        let bytes = file.get(range.clone())?;
        bytemuck::try_cast_slice::<u8, T>(bytes).ok()?;
        Some(Self::Mapped(Arc::clone(file), range))
    }

    /// Some of the elements; those in a file are not copied.
    ///
    /// # Panics
    /// If there are no such elements.
    pub(crate) fn part(&self, elements: Range<usize>) -> Self {
        let size = size_of::<T>();
        match self {
            Self::Mapped(file, range) => {
                assert!(elements.end * size <= range.len(), "elements of the buffer");
                let first = range.start;
                Self::Mapped(Arc::clone(file), first + elements.start * size..first + elements.end * size)
            }
            _ => Self::Owned(self[elements].to_vec()),
        }
    }

    /// Bytes in memory of its own, not in a file.
    pub fn owned_bytes(&self) -> usize {
        match self {
            Self::Owned(values) => values.capacity() * size_of::<T>(),
            Self::Zeroed(words, _) => words.capacity() * size_of::<u64>(),
            Self::Mapped(..) => 0,
        }
    }

    /// Bytes that are in a file.
    pub fn mapped_bytes(&self) -> usize {
        match self {
            Self::Owned(_) | Self::Zeroed(..) => 0,
            Self::Mapped(_, range) => range.len(),
        }
    }
}

impl<T> Default for Buffer<T> {
    fn default() -> Self {
        Self::Owned(Vec::new())
    }
}

impl<T: AnyBitPattern> Deref for Buffer<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match self {
            Self::Owned(values) => values,
            Self::Zeroed(words, range) => {
                bytemuck::cast_slice(&bytemuck::cast_slice::<u64, u8>(words)[range.clone()])
            }
            Self::Mapped(file, range) => bytemuck::cast_slice(&file[range.clone()]),
        }
    }
}

impl<T> From<Vec<T>> for Buffer<T> {
    fn from(values: Vec<T>) -> Self {
        Self::Owned(values)
    }
}

impl<T: AnyBitPattern + PartialEq> PartialEq for Buffer<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: AnyBitPattern> fmt::Debug for Buffer<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = if matches!(self, Self::Mapped(..)) { "mapped" } else { "in memory" };
        write!(f, "{} elements {place}", self.len())
    }
}
