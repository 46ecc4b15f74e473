//! What loops are over: slices, their chunks, ranges and vectors.

use std::marker::PhantomData;
use std::mem::ManuallyDrop;
use std::ops::Range;

use super::Loop;

/// The loops over the elements of a slice.
pub trait ParallelSlice<T> {
    /// Over references to elements.
    fn par_iter(&self) -> Slice<'_, T>
    where
        T: Sync;

    /// Over chunks of elements, of which the last may be shorter.
    ///
    /// # Panics
    /// If `length` is 0.
    fn par_chunks(&self, length: usize) -> Chunks<'_, T>
    where
        T: Sync;

    /// Over mutable references to elements.
    fn par_iter_mut(&mut self) -> SliceMut<'_, T>
    where
        T: Send;

    /// Over mutable chunks of elements, of which the last may be shorter.
    ///
    /// # Panics
    /// If `length` is 0.
    fn par_chunks_mut(&mut self, length: usize) -> ChunksMut<'_, T>
    where
        T: Send;

    /// Sorts; the order of equal elements is unspecified.
    fn par_sort_unstable(&mut self)
    where
        T: Ord + Send;

    /// Sorts by keys; the order of elements with equal keys is unspecified.
    fn par_sort_unstable_by_key<K: Ord>(&mut self, key: impl Fn(&T) -> K + Sync)
    where
        T: Send;
}

impl<T> ParallelSlice<T> for [T] {
    fn par_iter(&self) -> Slice<'_, T>
    where
        T: Sync,
    {
        Slice { list: self }
    }

    fn par_chunks(&self, length: usize) -> Chunks<'_, T>
    where
        T: Sync,
    {
        assert!(length > 0, "chunks of no elements");
        Chunks { list: self, length }
    }

    fn par_iter_mut(&mut self) -> SliceMut<'_, T>
    where
        T: Send,
    {
        SliceMut(Shared::new(self))
    }

    fn par_chunks_mut(&mut self, length: usize) -> ChunksMut<'_, T>
    where
        T: Send,
    {
        assert!(length > 0, "chunks of no elements");
        ChunksMut { list: Shared::new(self), length }
    }

    fn par_sort_unstable(&mut self)
    where
        T: Ord + Send,
    {
        rayon::slice::ParallelSliceMut::par_sort_unstable(self);
    }

    fn par_sort_unstable_by_key<K: Ord>(&mut self, key: impl Fn(&T) -> K + Sync)
    where
        T: Send,
    {
        rayon::slice::ParallelSliceMut::par_sort_unstable_by_key(self, key);
    }
}

/// What there is a loop over.
pub trait IntoParallelIterator {
    /// The loop.
    type Loop: Loop;

    /// The loop over it.
    fn into_par_iter(self) -> Self::Loop;
}

impl<L: Loop> IntoParallelIterator for L {
    type Loop = L;

    fn into_par_iter(self) -> L {
        self
    }
}

/// The elements of a slice.
pub struct Slice<'a, T> {
    list: &'a [T],
}

// SAFETY: one item for each element.
unsafe impl<'a, T: Sync> Loop for Slice<'a, T> {
    type Item = &'a T;
    const EXACT: bool = true;

    fn len(&self) -> usize {
        self.list.len()
    }

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = &'a T> {
        self.list[range].iter()
    }
}

impl<'a, T: Sync> IntoParallelIterator for &'a [T] {
    type Loop = Slice<'a, T>;

    fn into_par_iter(self) -> Self::Loop {
        Slice { list: self }
    }
}

impl<'a, T: Sync> IntoParallelIterator for &'a Vec<T> {
    type Loop = Slice<'a, T>;

    fn into_par_iter(self) -> Self::Loop {
        Slice { list: self }
    }
}

/// Chunks of a slice.
pub struct Chunks<'a, T> {
    list: &'a [T],
    length: usize,
}

// SAFETY: one item for each chunk.
unsafe impl<'a, T: Sync> Loop for Chunks<'a, T> {
    type Item = &'a [T];
    const EXACT: bool = true;

    fn len(&self) -> usize {
        self.list.len().div_ceil(self.length)
    }

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = &'a [T]> {
        let end = range.end.saturating_mul(self.length).min(self.list.len());
        self.list[range.start * self.length..end].chunks(self.length)
    }
}

/// A slice of which each thread gets another part.
struct Shared<'a, T> {
    first: *mut T,
    len: usize,
    owner: PhantomData<&'a mut [T]>,
}

// SAFETY: threads get elements that no other one has, as the caller of `part` says.
unsafe impl<T: Send> Sync for Shared<'_, T> {}

impl<'a, T> Shared<'a, T> {
    fn new(list: &'a mut [T]) -> Self {
        Self { first: list.as_mut_ptr(), len: list.len(), owner: PhantomData }
    }

    /// A part of the slice.
    ///
    /// # Safety
    /// The range is inside the slice, and no other call has elements of it.
    unsafe fn part(&self, range: Range<usize>) -> &'a mut [T] {
        // SAFETY: inside the slice, which is borrowed for 'a, and nobody else's, as the caller says.
        unsafe { std::slice::from_raw_parts_mut(self.first.add(range.start), range.len()) }
    }
}

/// The elements of a mutable slice.
pub struct SliceMut<'a, T>(Shared<'a, T>);

// SAFETY: one item for each element.
unsafe impl<'a, T: Send> Loop for SliceMut<'a, T> {
    type Item = &'a mut T;
    const EXACT: bool = true;

    fn len(&self) -> usize {
        self.0.len
    }

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = &'a mut T> {
        // SAFETY: the caller upholds the same contract.
        unsafe { self.0.part(range) }.iter_mut()
    }
}

impl<'a, T: Send> IntoParallelIterator for &'a mut [T] {
    type Loop = SliceMut<'a, T>;

    fn into_par_iter(self) -> Self::Loop {
        SliceMut(Shared::new(self))
    }
}

impl<'a, T: Send> IntoParallelIterator for &'a mut Vec<T> {
    type Loop = SliceMut<'a, T>;

    fn into_par_iter(self) -> Self::Loop {
        SliceMut(Shared::new(self))
    }
}

/// Chunks of a mutable slice.
pub struct ChunksMut<'a, T> {
    list: Shared<'a, T>,
    length: usize,
}

// SAFETY: one item for each chunk.
unsafe impl<'a, T: Send> Loop for ChunksMut<'a, T> {
    type Item = &'a mut [T];
    const EXACT: bool = true;

    fn len(&self) -> usize {
        self.list.len.div_ceil(self.length)
    }

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = &'a mut [T]> {
        let end = range.end.saturating_mul(self.length).min(self.list.len);
        // SAFETY: the chunks of other numbers have other elements.
        unsafe { self.list.part(range.start * self.length..end) }.chunks_mut(self.length)
    }
}

/// Consecutive numbers.
pub struct Numbers<T> {
    first: T,
    len: usize,
}

macro_rules! numbers {
    ($($number:ty)*) => {$(
        // SAFETY: one item for each number.
        unsafe impl Loop for Numbers<$number> {
            type Item = $number;
            const EXACT: bool = true;

            fn len(&self) -> usize {
                self.len
            }

            unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = $number> {
                self.first + range.start as $number..self.first + range.end as $number
            }
        }

        impl IntoParallelIterator for Range<$number> {
            type Loop = Numbers<$number>;

            fn into_par_iter(self) -> Self::Loop {
                let len = usize::try_from(self.end.saturating_sub(self.start)).expect("as many numbers as memory has addresses");
                Numbers { first: self.start, len }
            }
        }
    )*};
}

numbers!(u32 u64 usize);

/// The elements of a `Vec`, by value. Those of pieces that are not begun (because a thread panicked, or what is zipped with them is
/// shorter) are not dropped.
#[must_use = "elements are dropped by the loop"]
pub struct Owned<T> {
    list: Vec<ManuallyDrop<T>>,
}

// SAFETY: elements are moved out by the thread to which they belong alone, as the caller of `piece` says.
unsafe impl<T: Send> Sync for Owned<T> {}

// SAFETY: one item for each element.
unsafe impl<T: Send> Loop for Owned<T> {
    type Item = T;
    const EXACT: bool = true;

    fn len(&self) -> usize {
        self.list.len()
    }

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = T> {
        Moved { left: self.list[range].iter() }
    }
}

/// Moves elements out of a piece, and drops those that nobody asked for.
struct Moved<'a, T> {
    left: std::slice::Iter<'a, ManuallyDrop<T>>,
}

impl<T> Iterator for Moved<'_, T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        // SAFETY: each element belongs to one piece, is moved out once, and never dropped in place.
        self.left.next().map(|element| unsafe { std::ptr::read(&**element) })
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.left.size_hint()
    }
}

impl<T> Drop for Moved<'_, T> {
    fn drop(&mut self) {
        if std::mem::needs_drop::<T>() {
            self.for_each(drop);
        }
    }
}

impl<T: Send> IntoParallelIterator for Vec<T> {
    type Loop = Owned<T>;

    fn into_par_iter(self) -> Self::Loop {
        let mut list = ManuallyDrop::new(self);
        // SAFETY: `ManuallyDrop<T>` has the layout of `T`, and the memory has one owner.
        let list = unsafe { Vec::from_raw_parts(list.as_mut_ptr().cast(), list.len(), list.capacity()) };
        Owned { list }
    }
}
