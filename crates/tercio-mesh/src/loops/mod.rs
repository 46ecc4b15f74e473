//! Parallel loops over slices, chunks, ranges and vectors, on rayon's threads.
//!
//! The methods are called as those of rayon and mean the same. What differs is how they are compiled: rayon compiles its
//! division of work once for every chain of adapters, which was more than half of the machine code of this crate and most
//! of the time of its compilation; here the division is compiled once ([`divide`]), and a chain of adapters is a sequential
//! iterator over the items of a piece. There are at most some dozens of pieces a thread, whatever the number of items, and
//! which items are in which piece depends on the number of threads: results must not depend on it, as with rayon.
//!
//! Searches ([`Loop::find_map_first`]) and collected errors are those of the first item, in the order of items. A thread that has
//! begun with a piece finishes it, whatever the others have found.

mod adapters;
mod collected;
mod divide;
mod sources;
#[cfg(test)]
mod tests;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

pub use adapters::{Chain, Enumerate, Filter, FilterMap, FlatMap, Flatten, Map, MapInit, WithLengths, Zip};
pub use collected::{Collected, ParallelExtend};
pub use divide::Lengths;
use divide::{Target, divide, gather};
pub use sources::{Chunks, ChunksMut, IntoParallelIterator, Numbers, Owned, ParallelSlice, Slice, SliceMut};

/// What has to be imported for the methods of slices, ranges, vectors and loops.
pub mod prelude {
    pub use super::{IntoParallelIterator, Loop, ParallelExtend, ParallelSlice};
}

/// Items that threads process in pieces.
///
/// # Safety
/// If `EXACT`, the iterator over a piece has as many items as its range has numbers.
pub unsafe trait Loop: Sync + Sized {
    /// One item.
    type Item;
    /// Whether there is one item for each number below `len`: not behind a filter.
    const EXACT: bool;

    /// The numbers that are divided among pieces.
    fn len(&self) -> usize;

    /// Whether there is nothing to divide.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How long pieces are at least and at most.
    fn lengths(&self) -> Lengths {
        Lengths::ANY
    }

    /// The items of a piece, in order.
    ///
    /// # Safety
    /// The range is within `0..len()`, and each number is in one call at most: items may be mutable references or owned.
    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = Self::Item>;

    /// Pieces have at least this many items, if there are so many.
    fn with_min_len(self, min: usize) -> WithLengths<Self> {
        let lengths = Lengths { min, ..self.lengths() };
        WithLengths { items: self, lengths }
    }

    /// Pieces have at most this many items.
    fn with_max_len(self, max: usize) -> WithLengths<Self> {
        let lengths = Lengths { max, ..self.lengths() };
        WithLengths { items: self, lengths }
    }

    /// A function of each item.
    fn map<R, F: Fn(Self::Item) -> R + Sync>(self, of: F) -> Map<Self, F> {
        Map { items: self, of }
    }

    /// A function of each item and of something that each piece makes for itself.
    fn map_init<T, R, G, F>(self, init: G, of: F) -> MapInit<Self, G, F>
    where
        G: Fn() -> T + Sync,
        F: Fn(&mut T, Self::Item) -> R + Sync,
    {
        MapInit { items: self, init, of }
    }

    /// Pairs of the items of two loops, as many as the shorter one has.
    fn zip<B: IntoParallelIterator>(self, other: B) -> Zip<Self, B::Loop> {
        Zip { a: self, b: other.into_par_iter() }
    }

    /// Items with their numbers.
    fn enumerate(self) -> Enumerate<Self> {
        Enumerate { items: self }
    }

    /// The items for which this holds.
    fn filter<F: Fn(&Self::Item) -> bool + Sync>(self, holds: F) -> Filter<Self, F> {
        Filter { items: self, holds }
    }

    /// The results that are there.
    fn filter_map<R, F: Fn(Self::Item) -> Option<R> + Sync>(self, of: F) -> FilterMap<Self, F> {
        FilterMap { items: self, of }
    }

    /// All items of a sequential iterator for each item.
    fn flat_map_iter<R: IntoIterator, F: Fn(Self::Item) -> R + Sync>(self, of: F) -> FlatMap<Self, F> {
        FlatMap { items: self, of }
    }

    /// The items of each item.
    fn flatten_iter(self) -> Flatten<Self>
    where
        Self::Item: IntoIterator,
    {
        FlatMap { items: self, of: |item| item }
    }

    /// The items of another loop behind these.
    fn chain<B: IntoParallelIterator>(self, other: B) -> Chain<Self, B::Loop>
    where
        B::Loop: Loop<Item = Self::Item>,
    {
        Chain { a: self, b: other.into_par_iter() }
    }

    /// Copies of what the items refer to.
    fn copied<'a, T: Copy + 'a>(self) -> Map<Self, fn(&'a T) -> T>
    where
        Self: Loop<Item = &'a T>,
    {
        Map { items: self, of: |&item| item }
    }

    /// Calls a function with each item.
    fn for_each(self, work: impl Fn(Self::Item) + Sync) {
        // SAFETY: each number is in one piece.
        divide(self.len(), self.lengths(), &|_, range| unsafe { self.piece(range) }.for_each(&work));
    }

    /// Calls a function with each item and something that each piece makes for itself.
    fn for_each_init<T>(self, init: impl Fn() -> T + Sync, work: impl Fn(&mut T, Self::Item) + Sync) {
        divide(self.len(), self.lengths(), &|_, range| {
            let mut own = init();
            // SAFETY: each number is in one piece.
            unsafe { self.piece(range) }.for_each(|item| work(&mut own, item));
        });
    }

    /// Calls a function with each item: the error of the first item for which it fails.
    ///
    /// # Errors
    /// That of the function.
    fn try_for_each<E: Send>(self, work: impl Fn(Self::Item) -> Result<(), E> + Sync) -> Result<(), E> {
        self.find_map_first(|item| work(item).err()).map_or(Ok(()), Err)
    }

    /// The first result, in the order of items, that is there.
    fn find_map_first<R: Send>(self, of: impl Fn(Self::Item) -> Option<R> + Sync) -> Option<R> {
        let first = AtomicUsize::new(usize::MAX);
        let found = gather(self.len(), self.lengths(), |number, range| {
            if first.load(Ordering::Relaxed) < number {
                return None;
            }
            // SAFETY: each number is in one piece.
            let result = unsafe { self.piece(range) }.find_map(&of)?;
            first.fetch_min(number, Ordering::Relaxed);
            Some(result)
        });
        found.into_iter().flatten().next()
    }

    /// The number of the first item for which this holds.
    fn position_first(self, holds: impl Fn(Self::Item) -> bool + Sync) -> Option<usize> {
        self.enumerate().find_map_first(|(number, item)| holds(item).then_some(number))
    }

    /// Whether this holds for any item.
    fn any(self, holds: impl Fn(Self::Item) -> bool + Sync) -> bool {
        let found = AtomicBool::new(false);
        divide(self.len(), self.lengths(), &|_, range| {
            // SAFETY: each number is in one piece.
            if !found.load(Ordering::Relaxed) && unsafe { self.piece(range) }.any(&holds) {
                found.store(true, Ordering::Relaxed);
            }
        });
        found.into_inner()
    }

    /// Whether this holds for all items.
    fn all(self, holds: impl Fn(Self::Item) -> bool + Sync) -> bool {
        !self.any(|item| !holds(item))
    }

    /// The largest item; of equal ones the last.
    fn max_by(
        self,
        compare: impl Fn(&Self::Item, &Self::Item) -> std::cmp::Ordering + Sync,
    ) -> Option<Self::Item>
    where
        Self::Item: Send,
    {
        // SAFETY: each number is in one piece.
        let of_piece = |_, range| unsafe { self.piece(range) }.max_by(&compare);
        gather(self.len(), self.lengths(), of_piece).into_iter().flatten().max_by(compare)
    }

    /// How many items there are.
    fn count(self) -> usize {
        // SAFETY: each number is in one piece.
        gather(self.len(), self.lengths(), |_, range| unsafe { self.piece(range) }.count()).into_iter().sum()
    }

    /// The sum of all items, which must not depend on their order.
    fn sum<S: Send + std::iter::Sum<Self::Item> + std::iter::Sum<S>>(self) -> S {
        // SAFETY: each number is in one piece.
        gather(self.len(), self.lengths(), |_, range| unsafe { self.piece(range) }.sum::<S>())
            .into_iter()
            .sum()
    }

    /// All items joined by an associative function, in order.
    fn reduce(
        self,
        identity: impl Fn() -> Self::Item + Sync,
        join: impl Fn(Self::Item, Self::Item) -> Self::Item + Sync,
    ) -> Self::Item
    where
        Self::Item: Send,
    {
        // SAFETY: each number is in one piece.
        let of_piece = |_, range| unsafe { self.piece(range) }.fold(identity(), &join);
        gather(self.len(), self.lengths(), of_piece).into_iter().fold(identity(), &join)
    }

    /// What each piece makes of its items, beginning with what `identity` gives.
    fn fold<T: Send>(
        self,
        identity: impl Fn() -> T + Sync,
        add: impl Fn(T, Self::Item) -> T + Sync,
    ) -> Owned<T> {
        // SAFETY: each number is in one piece.
        let of_piece = |_, range| unsafe { self.piece(range) }.fold(identity(), &add);
        gather(self.len(), self.lengths(), of_piece).into_par_iter()
    }

    /// All items, in order, as `Vec`, `Option<Vec>` or `Result<Vec, E>`: with the error of the first item that has one.
    fn collect<C: Collected<Self::Item>>(self) -> C {
        C::of(self)
    }

    /// The two parts of all items, in order.
    fn unzip<A: Send, B: Send>(self) -> (Vec<A>, Vec<B>)
    where
        Self: Loop<Item = (A, B)>,
    {
        const { assert!(Self::EXACT, "the number of items is known") };
        let len = self.len();
        let (mut a, mut b) = (Vec::with_capacity(len), Vec::with_capacity(len));
        let (to_a, to_b) = (Target::new(&mut a), Target::new(&mut b));
        divide(len, self.lengths(), &|_, range| {
            // SAFETY: each number is in one piece.
            let (a, b): (Vec<A>, Vec<B>) = unsafe { self.piece(range.clone()) }.unzip();
            // SAFETY: less than the capacity, and each number is in one piece.
            unsafe {
                to_a.write(range.clone(), a.into_iter());
                to_b.write(range, b.into_iter());
            }
        });
        // SAFETY: each piece of an exact loop has written all of its items.
        unsafe { (a.set_len(len), b.set_len(len)) };
        (a, b)
    }
}
