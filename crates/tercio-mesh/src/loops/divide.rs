//! The division of a loop among threads, compiled once for all loops.

use std::marker::PhantomData;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Pieces for each thread, if there are as many items: threads that are done take over pieces of others.
const PIECES_OF_THREAD: usize = 16;

/// How long pieces are at least and at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lengths {
    /// Items of a piece at least; where this contradicts the most, that counts.
    pub min: usize,
    /// Items of a piece at most.
    pub max: usize,
}

impl Lengths {
    /// Pieces of any length.
    pub const ANY: Self = Self { min: 1, max: usize::MAX };

    /// The lengths that both allow.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// The number of pieces of so many items on so many threads.
    fn pieces(self, len: usize, threads: usize) -> usize {
        let most =
            if threads == 1 { 1 } else { (len / self.min.max(1)).clamp(1, threads * PIECES_OF_THREAD) };
        most.max(len.div_ceil(self.max.max(1))).min(len)
    }
}

/// Calls a function with the number and the range of each piece of so many items.
pub(super) fn divide(len: usize, lengths: Lengths, work: &(dyn Fn(usize, Range<usize>) + Sync)) {
    let pieces = lengths.pieces(len, rayon::current_num_threads());
    let bound = |piece: usize| (len as u128 * piece as u128 / pieces as u128) as usize;
    halves(0..pieces, &|number| work(number, bound(number)..bound(number + 1)));
}

/// Calls a function with each number, on several threads.
fn halves(numbers: Range<usize>, work: &(dyn Fn(usize) + Sync)) {
    if numbers.len() <= 1 {
        return numbers.for_each(work);
    }
    let middle = numbers.start + numbers.len() / 2;
    rayon::join(|| halves(numbers.start..middle, work), || halves(middle..numbers.end, work));
}

/// What a function makes of the number and the range of each piece, in their order.
pub(super) fn gather<T: Send>(
    len: usize,
    lengths: Lengths,
    of: impl Fn(usize, Range<usize>) -> T + Sync,
) -> Vec<T> {
    let found = Mutex::new(Vec::new());
    divide(len, lengths, &|number, range| {
        let piece = of(number, range);
        found.lock().unwrap_or_else(PoisonError::into_inner).push((number, piece));
    });
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    found.sort_unstable_by_key(|piece| piece.0);
    found.into_iter().map(|piece| piece.1).collect()
}

/// The memory of a `Vec` that threads write, each at its own numbers. What was written is not dropped if a thread panics.
pub(super) struct Target<'a, T> {
    first: *mut T,
    owner: PhantomData<&'a mut Vec<T>>,
}

// SAFETY: values move from the threads that write them to the owner of the `Vec`; `write` says what writers heed.
unsafe impl<T: Send> Sync for Target<'_, T> {}

impl<'a, T> Target<'a, T> {
    /// Behind the elements of a `Vec`.
    pub fn new(list: &'a mut Vec<T>) -> Self {
        Self { first: list.spare_capacity_mut().as_mut_ptr().cast(), owner: PhantomData }
    }

    /// Writes the elements of a piece behind those that the `Vec` has.
    ///
    /// # Safety
    /// The range is within the spare capacity, and no other thread writes a part of it.
    ///
    /// # Panics
    /// If there are fewer items than the range has numbers.
    pub unsafe fn write(&self, range: Range<usize>, mut items: impl Iterator<Item = T>) {
        let mut written = range.start;
        // Whole iterators are faster than their items one by one.
        items.by_ref().take(range.len()).for_each(|item| {
            // SAFETY: inside the memory of the `Vec`, and nobody else's, as the caller says.
            unsafe { self.first.add(written).write(item) };
            written += 1;
        });
        assert_eq!(written, range.end, "a loop that is exact has an item for each number");
    }
}
