//! Memory that readers take: counted where a program makes [`Counting`] its allocator, else nothing.

#![expect(
    unsafe_code,
    reason = "an allocator is one by its nature; this one adds numbers around that of the system"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Bytes that are allocated now, and the most since the last [`mark`].
static LIVE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

/// A request beyond these bytes in all is refused, so that the process ends with a line rather than with the machine.
const ENOUGH: usize = 3 << 30;

/// The system's allocator, counted.
pub struct Counting;

fn add(bytes: usize) {
    let live = LIVE.fetch_add(bytes, Relaxed) + bytes;
    MOST.fetch_max(live, Relaxed);
}

fn fits(bytes: usize) -> bool {
    LIVE.load(Relaxed).saturating_add(bytes) <= ENOUGH
}

// SAFETY: every call is the system allocator's with the caller's own layout and pointer, or a null pointer, which stands for failure.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if !fits(layout.size()) {
            return std::ptr::null_mut();
        }
        add(layout.size());
        // SAFETY: the caller's promises are those of the system's allocator.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if !fits(layout.size()) {
            return std::ptr::null_mut();
        }
        add(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if size > layout.size() && !fits(size - layout.size()) {
            return std::ptr::null_mut();
        }
        // Both may be there at once.
        add(size);
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// Begins to count anew; the bytes that are there now.
#[must_use]
pub fn mark() -> usize {
    let live = LIVE.load(Relaxed);
    MOST.store(live, Relaxed);
    live
}

/// The most bytes at once since a mark, beside those that were there then.
#[must_use]
pub fn most_since(mark: usize) -> usize {
    MOST.load(Relaxed).saturating_sub(mark)
}
