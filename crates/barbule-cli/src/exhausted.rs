//! What happens when the system has no more memory: one sentence and exit code 1, where Rust would abort.

#![allow(unsafe_code)] // an allocator is unsafe by its trait; this one hands every call on

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};

/// The system's allocator, which never gives nothing: the program ends instead.
#[derive(Debug, Clone, Copy, Default)]
pub struct EndsWhenExhausted;

// SAFETY: every call is the system allocator's with the same arguments, and what it returns is passed on; where it
// returns null, nothing is returned at all.
unsafe impl GlobalAlloc for EndsWhenExhausted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps what the trait asks for.
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above; `block` came from the system's allocator, since all do.
        given(unsafe { System.realloc(block, layout, size) }, size)
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(block, layout) }
    }
}

fn given(block: *mut u8, size: usize) -> *mut u8 {
    if block.is_null() {
        end(size);
    }
    block
}

/// Says what happened and ends the program. Nothing here allocates.
#[cold]
fn end(size: usize) -> ! {
    static SAID: AtomicBool = AtomicBool::new(false);
    thread_local! {
        static HERE: Cell<bool> = const { Cell::new(false) };
    }
    if HERE.replace(true) {
        // Even the sentence found no memory.
        std::process::abort();
    }
    if SAID.swap(true, Ordering::SeqCst) {
        // Another thread is ending the program.
        loop {
            std::thread::park();
        }
    }
    let _ = writeln!(
        std::io::stderr(),
        "barbule: the system has no more memory ({} MB at once were asked for); ask for less, or free some (--memory refuses early what will not fit)",
        size.div_ceil(1_000_000)
    );
    std::process::exit(1);
}
