//! Large arrays in large pages.
//!
//! Loading a model of hundreds of megabytes takes a page fault every 4 KB and misses the translation buffer at
//! nearly every vertex; with pages of 2 MB both are rare. Linux gives them, where it is set to `madvise` (as most
//! distributions set it), only to memory that asks. The library leaves memory to the program that uses it, so the
//! asking is done here.

use std::alloc::{GlobalAlloc, Layout, System};

/// The system's allocator, and large pages for large allocations.
pub struct HugePages;

/// Smaller allocations share their pages with others.
#[cfg(target_os = "linux")]
const LEAST: usize = 4 << 20;

// SAFETY: all is left to the system's allocator; advice on a range of memory changes nothing that is in it.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise.
        let memory = unsafe { System.alloc(layout) };
        ask_for_large_pages(memory, layout.size());
        memory
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise.
        let memory = unsafe { System.alloc_zeroed(layout) };
        ask_for_large_pages(memory, layout.size());
        memory
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller's promise.
        let memory = unsafe { System.realloc(memory, layout, size) };
        ask_for_large_pages(memory, size);
        memory
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(memory, layout) }
    }
}

/// Asks for large pages for all pages that hold a part of an allocation. They may hold a part of others, too; but a
/// mapping of its own is advised as a whole, so that it stays one, and can grow without being copied.
#[cfg(target_os = "linux")]
fn ask_for_large_pages(memory: *mut u8, size: usize) {
    use rustix::mm::{Advice, madvise};
    if memory.is_null() || size < LEAST {
        return;
    }
    let page = rustix::param::page_size();
    let before = memory.addr() % page;
    let length = (before + size).next_multiple_of(page);
    // SAFETY: the pages are mapped, and the advice changes nothing that is in them.
    let _ = unsafe { madvise(memory.wrapping_sub(before).cast(), length, Advice::LinuxHugepage) };
}

#[cfg(not(target_os = "linux"))]
fn ask_for_large_pages(_: *mut u8, _: usize) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_zeroed_grows_and_keeps_what_is_in_it() {
        let layout = Layout::from_size_align(9 << 20, 64).unwrap();
        // SAFETY: every pointer comes from this allocator and is used inside its size.
        unsafe {
            let memory = HugePages.alloc_zeroed(layout);
            assert!(!memory.is_null() && memory.addr().is_multiple_of(64));
            assert!((0..layout.size()).step_by(4096).all(|i| *memory.add(i) == 0));
            (0..layout.size()).step_by(4096).for_each(|i| *memory.add(i) = (i >> 12) as u8);
            let larger = HugePages.realloc(memory, layout, 30 << 20);
            assert!(!larger.is_null());
            assert!((0..layout.size()).step_by(4096).all(|i| *larger.add(i) == (i >> 12) as u8));
            HugePages.dealloc(larger, Layout::from_size_align(30 << 20, 64).unwrap());
        }
    }
}
