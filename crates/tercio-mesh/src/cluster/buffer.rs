//! Arrays that were made here or lie in a mapped file.

use std::fmt;
use std::ops::{Deref, Range};
use std::sync::Arc;

use bytemuck::{AnyBitPattern, Pod, Zeroable};
use memmap2::Mmap;

/// A cache line. The stretches of clusters begin at its borders, so that vectors are loaded aligned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Line(pub [u8; 64]);

impl Line {
    /// Bytes of a line.
    pub const BYTES: usize = 64;
}

/// An array in memory of its own or in a mapped file.
#[derive(Clone)]
pub enum Buffer<T> {
    /// In memory.
    Owned(Vec<T>),
    /// In a file: the file, and which of its bytes.
    Mapped(Arc<Mmap>, Range<usize>),
}

impl<T: AnyBitPattern> Buffer<T> {
    /// Some bytes of a mapped file; `None` if they lie outside of it, are not whole elements or not aligned.
    pub fn mapped(file: &Arc<Mmap>, range: Range<usize>) -> Option<Self> {
        let bytes = file.get(range.clone())?;
        bytemuck::try_cast_slice::<u8, T>(bytes).ok()?;
        Some(Self::Mapped(Arc::clone(file), range))
    }

    /// Bytes that are in memory of its own, not in a file.
    pub fn owned_bytes(&self) -> usize {
        match self {
            Self::Owned(values) => values.capacity() * size_of::<T>(),
            Self::Mapped(..) => 0,
        }
    }

    /// Bytes that are in a file.
    pub fn mapped_bytes(&self) -> usize {
        match self {
            Self::Owned(_) => 0,
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
        let place = if matches!(self, Self::Owned(_)) { "in memory" } else { "mapped" };
        write!(f, "{} elements {place}", self.len())
    }
}
