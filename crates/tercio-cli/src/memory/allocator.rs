//! The system's allocator, with what is taken counted, and large arrays in large pages.
//!
//! Loading a model of hundreds of megabytes takes a page fault every 4 KB and misses the translation buffer at
//! nearly every vertex; with pages of 2 MB both are rare. Linux gives them, where it is set to `madvise` (as most
//! distributions set it), only to memory that asks. The library leaves memory to the program that uses it, so the
//! asking is done here.

use std::alloc::{GlobalAlloc, Layout, System};

use super::count;
use crate::ending;

/// The system's allocator; never gives a null pointer but ends the program in its place.
pub struct Allocator;

/// Smaller allocations share their pages with others.
#[cfg(target_os = "linux")]
const LEAST: usize = 4 << 20;

// SAFETY: all is left to the system's allocator; counting does not touch the memory, and advice on a range of it changes
// nothing that is in it.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count::take(layout.size());
        // SAFETY: the caller's promise.
        checked(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count::take(layout.size());
        // SAFETY: the caller's promise.
        checked(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count::change(layout.size(), size);
        // SAFETY: the caller's promise.
        checked(unsafe { System.realloc(memory, layout, size) }, size)
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        count::give(layout.size());
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[inline]
fn checked(memory: *mut u8, size: usize) -> *mut u8 {
    if memory.is_null() {
        ending::out_of_memory(count::in_use(), size, None);
    }
    ask_for_large_pages(memory, size);
    memory
}

/// Asks for large pages for all pages that hold a part of an allocation. They may hold a part of others, too; but a
/// mapping of its own is advised as a whole, so that it stays one, and can grow without being copied.
#[cfg(target_os = "linux")]
#[inline]
fn ask_for_large_pages(memory: *mut u8, size: usize) {
    if size >= LEAST {
        advise(memory, size);
    }
}

#[cfg(target_os = "linux")]
#[cold]
fn advise(memory: *mut u8, size: usize) {
    // SAFETY: a plain question.
    let page = unsafe { libc::sysconf(libc::_SC_PAGESIZE) };
    let page = usize::try_from(page).unwrap_or(4096).max(1);
    let before = memory.addr() % page;
    let length = (before + size).next_multiple_of(page);
    // SAFETY: the pages are mapped, and the advice changes nothing that is in them.
    let _ = unsafe { libc::madvise(memory.wrapping_sub(before).cast(), length, libc::MADV_HUGEPAGE) };
}

#[cfg(not(target_os = "linux"))]
fn ask_for_large_pages(_: *mut u8, _: usize) {}

/// Tells the C library to give free memory back at once, for a limit that is near: large blocks get pages of their own,
/// which go when the block goes, and few threads have small blocks of their own. Without it a run is a little quicker
/// and takes more. Where the address space is limited (`in_little_space`), no thread reserves a part of it.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn return_what_is_free(in_little_space: bool) {
    let large = libc::c_int::try_from(count::LARGE).unwrap_or(libc::c_int::MAX);
    // SAFETY: numbers that the C library takes over; blocks that exist stay as they are.
    let set = unsafe {
        libc::mallopt(libc::M_ARENA_MAX, if in_little_space { 1 } else { 4 }) == 1
            && libc::mallopt(libc::M_TRIM_THRESHOLD, large) == 1
            && libc::mallopt(libc::M_MMAP_THRESHOLD, large) == 1
    };
    if set {
        count::large_blocks_have_own_pages();
    }
}

/// Gives back the pages of small blocks that are free.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn give_back() {
    // SAFETY: only free memory is given back.
    unsafe { libc::malloc_trim(0) };
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub fn return_what_is_free(_in_little_space: bool) {}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub fn give_back() {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_zeroed_grows_and_keeps_what_is_in_it() {
        let layout = Layout::from_size_align(9 << 20, 64).unwrap();
        // SAFETY: every pointer comes from this allocator and is used inside its size.
        unsafe {
            let memory = Allocator.alloc_zeroed(layout);
            assert!(!memory.is_null() && memory.addr().is_multiple_of(64));
            assert!((0..layout.size()).step_by(4096).all(|i| *memory.add(i) == 0));
            (0..layout.size()).step_by(4096).for_each(|i| *memory.add(i) = (i >> 12) as u8);
            let larger = Allocator.realloc(memory, layout, 30 << 20);
            assert!(!larger.is_null());
            assert!((0..layout.size()).step_by(4096).all(|i| *larger.add(i) == (i >> 12) as u8));
            Allocator.dealloc(larger, Layout::from_size_align(30 << 20, 64).unwrap());
        }
    }
}
