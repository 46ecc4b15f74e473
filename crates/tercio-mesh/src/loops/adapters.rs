//! Loops over what is made of the items of other loops.

use std::ops::Range;

use super::{Lengths, Loop};

/// The numbers of a loop that has those of its `items`.
macro_rules! numbered_as_items {
    () => {
        fn len(&self) -> usize {
            self.items.len()
        }

        fn lengths(&self) -> Lengths {
            self.items.lengths()
        }
    };
}

/// A function of each item.
pub struct Map<I, F> {
    pub(super) items: I,
    pub(super) of: F,
}

// SAFETY: one item for each.
unsafe impl<I: Loop, R, F: Fn(I::Item) -> R + Sync> Loop for Map<I, F> {
    type Item = R;
    const EXACT: bool = I::EXACT;

    numbered_as_items!();

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = R> {
        // SAFETY: the caller upholds the same contract.
        unsafe { self.items.piece(range) }.map(&self.of)
    }
}

/// A function of each item and of something that a piece has made for itself.
pub struct MapInit<I, G, F> {
    pub(super) items: I,
    pub(super) init: G,
    pub(super) of: F,
}

// SAFETY: one item for each.
unsafe impl<I: Loop, T, R, G: Fn() -> T + Sync, F: Fn(&mut T, I::Item) -> R + Sync> Loop
    for MapInit<I, G, F>
{
    type Item = R;
    const EXACT: bool = I::EXACT;

    numbered_as_items!();

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = R> {
        let mut own = (self.init)();
        // SAFETY: the caller upholds the same contract.
        unsafe { self.items.piece(range) }.map(move |item| (self.of)(&mut own, item))
    }
}

/// Items in pieces of other lengths.
pub struct WithLengths<I> {
    pub(super) items: I,
    pub(super) lengths: Lengths,
}

// SAFETY: the same items.
unsafe impl<I: Loop> Loop for WithLengths<I> {
    type Item = I::Item;
    const EXACT: bool = I::EXACT;

    fn len(&self) -> usize {
        self.items.len()
    }

    fn lengths(&self) -> Lengths {
        self.lengths
    }

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = I::Item> {
        // SAFETY: the caller upholds the same contract.
        unsafe { self.items.piece(range) }
    }
}

/// Pairs of items.
pub struct Zip<A, B> {
    pub(super) a: A,
    pub(super) b: B,
}

// SAFETY: both have an item for each number.
unsafe impl<A: Loop, B: Loop> Loop for Zip<A, B> {
    type Item = (A::Item, B::Item);
    const EXACT: bool = {
        assert!(A::EXACT && B::EXACT, "items that have numbers");
        true
    };

    fn len(&self) -> usize {
        self.a.len().min(self.b.len())
    }

    fn lengths(&self) -> Lengths {
        self.a.lengths().and(self.b.lengths())
    }

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = Self::Item> {
        const { assert!(Self::EXACT) };
        // SAFETY: the caller upholds the same contract, for a length that neither exceeds.
        unsafe { self.a.piece(range.clone()).zip(self.b.piece(range)) }
    }
}

/// Items with their numbers.
pub struct Enumerate<I> {
    pub(super) items: I,
}

// SAFETY: one item for each.
unsafe impl<I: Loop> Loop for Enumerate<I> {
    type Item = (usize, I::Item);
    const EXACT: bool = {
        assert!(I::EXACT, "items that have numbers");
        true
    };

    numbered_as_items!();

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = Self::Item> {
        const { assert!(Self::EXACT) };
        // SAFETY: the caller upholds the same contract.
        range.clone().zip(unsafe { self.items.piece(range) })
    }
}

/// The items for which something holds.
pub struct Filter<I, F> {
    pub(super) items: I,
    pub(super) holds: F,
}

// SAFETY: not exact.
unsafe impl<I: Loop, F: Fn(&I::Item) -> bool + Sync> Loop for Filter<I, F> {
    type Item = I::Item;
    const EXACT: bool = false;

    numbered_as_items!();

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = I::Item> {
        // SAFETY: the caller upholds the same contract.
        unsafe { self.items.piece(range) }.filter(&self.holds)
    }
}

/// Several items for each, or none.
pub struct FlatMap<I, F> {
    pub(super) items: I,
    pub(super) of: F,
}

/// All items of each.
pub type Flatten<I> = FlatMap<I, fn(<I as Loop>::Item) -> <I as Loop>::Item>;

// SAFETY: not exact.
unsafe impl<I: Loop, R: IntoIterator, F: Fn(I::Item) -> R + Sync> Loop for FlatMap<I, F> {
    type Item = R::Item;
    const EXACT: bool = false;

    numbered_as_items!();

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = R::Item> {
        // SAFETY: the caller upholds the same contract.
        unsafe { self.items.piece(range) }.flat_map(&self.of)
    }
}

/// The results that are there.
pub struct FilterMap<I, F> {
    pub(super) items: I,
    pub(super) of: F,
}

// SAFETY: not exact.
unsafe impl<I: Loop, R, F: Fn(I::Item) -> Option<R> + Sync> Loop for FilterMap<I, F> {
    type Item = R;
    const EXACT: bool = false;

    numbered_as_items!();

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = R> {
        // SAFETY: the caller upholds the same contract.
        unsafe { self.items.piece(range) }.filter_map(&self.of)
    }
}

/// The items of two loops, one after the other.
pub struct Chain<A, B> {
    pub(super) a: A,
    pub(super) b: B,
}

// SAFETY: exact if both are.
unsafe impl<A: Loop, B: Loop<Item = A::Item>> Loop for Chain<A, B> {
    type Item = A::Item;
    const EXACT: bool = A::EXACT && B::EXACT;

    fn len(&self) -> usize {
        self.a.len().checked_add(self.b.len()).expect("as many items as memory has addresses")
    }

    fn lengths(&self) -> Lengths {
        self.a.lengths().and(self.b.lengths())
    }

    unsafe fn piece(&self, range: Range<usize>) -> impl Iterator<Item = A::Item> {
        let middle = self.a.len();
        let a = range.start.min(middle)..range.end.min(middle);
        let b = range.start.max(middle) - middle..range.end.max(middle) - middle;
        // SAFETY: the caller upholds the same contract.
        unsafe { self.a.piece(a).chain(self.b.piece(b)) }
    }
}
