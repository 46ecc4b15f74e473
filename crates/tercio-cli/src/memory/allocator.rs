//! The system's allocator, with counting, and with large pages for large arrays.
//!
//! Loading a model of hundreds of megabytes takes a page fault every 4 KB and a TLB miss at nearly every vertex; with
//! pages of 2 MB both are rare. Linux uses large pages, if it is set to `madvise` (as most distributions are), only for
//! memory that is marked with `madvise`. The library leaves allocation to the program that uses it, so this is done
//! here.

use std::alloc::{GlobalAlloc, Layout, System};

use super::count;
use crate::ending;

/// The system's allocator; instead of returning a null pointer it ends the program.
pub struct Allocator;

/// Smaller allocations share their pages with others.
#[cfg(target_os = "linux")]
const LEAST: usize = 4 << 20;

// SAFETY: all calls go to the system's allocator; counting does not touch the memory, and `madvise` does not change the
// contents of pages.
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

/// Requests large pages for all pages that contain a part of an allocation. They may contain parts of others, too; but
/// a mapping of its own is advised as a whole, so that it stays one mapping and can grow without being copied.
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
    // SAFETY: has no preconditions.
    let page = unsafe { libc::sysconf(libc::_SC_PAGESIZE) };
    let page = usize::try_from(page).unwrap_or(4096).max(1);
    let before = memory.addr() % page;
    let length = (before + size).next_multiple_of(page);
    // SAFETY: the pages are mapped, and the advice does not change their contents.
    let _ = unsafe { libc::madvise(memory.wrapping_sub(before).cast(), length, libc::MADV_HUGEPAGE) };
}

#[cfg(not(target_os = "linux"))]
fn ask_for_large_pages(_: *mut u8, _: usize) {}

/// Makes the C library return free memory at once, which a limit close to the demand needs: large blocks get pages of
/// their own, which are returned when the block is freed, and there are few arenas of small blocks. Without it a run is
/// slightly faster and takes more memory. If the address space is limited (`in_little_space`), no thread reserves an
/// arena.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn return_what_is_free(in_little_space: bool) {
    let large = libc::c_int::try_from(count::LARGE).unwrap_or(libc::c_int::MAX);
    // SAFETY: sets numeric parameters of the C library; existing blocks stay as they are.
    let set = unsafe {
        libc::mallopt(libc::M_ARENA_MAX, if in_little_space { 1 } else { 4 }) == 1
            && libc::mallopt(libc::M_TRIM_THRESHOLD, large) == 1
            && libc::mallopt(libc::M_MMAP_THRESHOLD, large) == 1
    };
    if set {
        count::large_blocks_have_own_pages();
    }
}

/// Returns the pages of free small blocks to the system.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn give_back() {
    // SAFETY: only free memory is returned.
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
