//! Counts the memory that is allocated on the heap, and checks it against the limit.
//!
//! Large blocks are counted exactly and at once. Small ones are counted by the allocating thread and added to the sum
//! in steps, so that threads do not wait for each other. Free memory of small blocks stays with the C library, so they
//! count with their maximum so far, until the library is made to return free memory.

use std::cell::Cell;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::{AtomicIsize, AtomicUsize, Ordering::Relaxed};

use crate::ending;

/// Blocks of this size and larger have pages of their own (`mallopt(M_MMAP_THRESHOLD)`, see `return_what_is_free`).
pub const LARGE: usize = 128 << 10;

/// A thread adds its small blocks to the sum in steps of this many bytes.
const STEP: isize = 16 << 10;

/// Free memory that may stay with the C library above the limit.
const SLACK: usize = 2 << 20;

static LIMIT: AtomicUsize = AtomicUsize::new(usize::MAX);
static LARGE_BLOCKS: AtomicUsize = AtomicUsize::new(0);
static SMALL_BLOCKS: AtomicIsize = AtomicIsize::new(0);
/// The maximum of [`SMALL_BLOCKS`] since free memory was last returned to the system.
static MOST_SMALL: AtomicIsize = AtomicIsize::new(0);
/// Large blocks that were freed since then, if they may not have had pages of their own.
static FREED: AtomicUsize = AtomicUsize::new(0);
static OWN_PAGES: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// Bytes not yet added to the sum. Without a destructor, so that it is usable while a thread starts and ends.
    static PENDING: Cell<isize> = const { Cell::new(0) };
    /// This thread has no limit.
    static IS_EXEMPT: Cell<bool> = const { Cell::new(false) };
}

/// Sets the limit; `besides` are bytes outside the heap that count as well.
pub fn set_limit(limit: Option<u64>, besides: usize) {
    let limit = limit.map_or(usize::MAX, |l| usize::try_from(l).unwrap_or(usize::MAX));
    LIMIT.store(limit, Relaxed);
    LARGE_BLOCKS.fetch_add(besides, Relaxed);
}

/// Removes the limit for this thread, which is ending the program and has to print why. It stays for the others, which go on until
/// then: without one they would take what the first of them was refused.
pub fn lift_limit() {
    IS_EXEMPT.set(true);
}

/// From now on large blocks have pages of their own.
pub fn large_blocks_have_own_pages() {
    OWN_PAGES.store(true, Relaxed);
}

/// Counts a new block of `size` bytes. Does not return if that exceeds the limit.
#[inline]
pub fn take(size: usize) {
    if size < LARGE {
        flush_if_large(small(size));
    } else {
        take_large(size);
    }
}

/// Counts a freed block of `size` bytes.
#[inline]
pub fn give(size: usize) {
    if size < LARGE {
        flush_if_large(-small(size));
    } else {
        LARGE_BLOCKS.fetch_sub(pages(size), Relaxed);
        if !OWN_PAGES.load(Relaxed) {
            FREED.fetch_add(pages(size), Relaxed);
        }
    }
}

/// Counts a change of a block's size.
#[inline]
pub fn change(old: usize, new: usize) {
    if old < LARGE && new < LARGE {
        return flush_if_large(small(new) - small(old));
    }
    // A large block grows in place: its pages are moved, not copied. So old and new do not count at the same time.
    match (old < LARGE, new < LARGE) {
        (true, _) => flush_if_large(-small(old)),
        (false, _) => _ = LARGE_BLOCKS.fetch_sub(pages(old), Relaxed),
    }
    take(new);
}

/// What the C library allocates for a small block.
#[inline]
fn small(size: usize) -> isize {
    // The cast is exact: below 128 KiB.
    (((size + 23) & !15).max(32)) as isize
}

#[inline]
fn pages(size: usize) -> usize {
    size.saturating_add(4096 + 31) & !4095
}

#[inline]
fn flush_if_large(bytes: isize) {
    // While a thread ends, after its thread-local memory is gone, nothing is counted.
    let _ = PENDING.try_with(|pending| {
        let all = pending.get() + bytes;
        if all.unsigned_abs() < STEP as usize {
            pending.set(all);
        } else {
            pending.set(0);
            flush(all);
        }
    });
}

#[cold]
fn flush(bytes: isize) {
    let now = SMALL_BLOCKS.fetch_add(bytes, Relaxed) + bytes;
    if bytes > 0 {
        MOST_SMALL.fetch_max(now, Relaxed);
        hold_against_limit(0);
    }
}

#[cold]
fn take_large(size: usize) {
    LARGE_BLOCKS.fetch_add(pages(size), Relaxed);
    hold_against_limit(size);
}

fn positive(bytes: isize) -> usize {
    bytes.max(0).unsigned_abs()
}

/// Bytes in use: blocks of the heap and mapped files.
pub fn in_use() -> usize {
    let mapped = usize::try_from(tercio::mesh::io::input::mapped_bytes()).unwrap_or(usize::MAX);
    (LARGE_BLOCKS.load(Relaxed)).saturating_add(positive(SMALL_BLOCKS.load(Relaxed))).saturating_add(mapped)
}

fn hold_against_limit(size: usize) {
    let limit = LIMIT.load(Relaxed);
    let used = in_use();
    let idle = || {
        let small = positive(MOST_SMALL.load(Relaxed).saturating_sub(SMALL_BLOCKS.load(Relaxed)));
        small.saturating_add(FREED.load(Relaxed))
    };
    if used > limit && !IS_EXEMPT.get() {
        ending::out_of_memory(used, size, Some(limit));
    }
    if limit < usize::MAX && used.saturating_add(idle()) > limit.saturating_add(SLACK) {
        FREED.store(0, Relaxed);
        MOST_SMALL.store(SMALL_BLOCKS.load(Relaxed), Relaxed);
        super::allocator::give_back();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_given_back_no_longer_counts() {
        // Other tests of this process allocate memory, too, but not in such sizes.
        let (mib, most) = (1 << 20, 300 << 20);
        let before = in_use();
        take(most);
        assert!(in_use() >= before + most - 50 * mib);
        change(most, 2 * most);
        assert!(in_use() >= before + 2 * most - 50 * mib);
        change(2 * most, 100);
        assert!(in_use() <= before + 50 * mib);
        (0..10_000).for_each(|_| take(100_000));
        assert!(in_use() >= before + 950 * mib);
        (0..10_000).for_each(|_| give(100_000));
        give(100);
        assert!(in_use() <= before + 50 * mib);
    }
}
