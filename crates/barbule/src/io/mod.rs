//! The only module that opens files.

mod stack;
pub mod store;
pub mod tables;
mod whole;

pub use stack::{parse_stack, read_stack};
pub use whole::{LARGEST_INPUT, check_writable, read_bytes, read_text, write_whole};
