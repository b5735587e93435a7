//! The only module that opens files.

pub mod image;
mod whole;

pub use whole::{LARGEST_INPUT, check_writable, read_at_most, read_bytes, read_text, write_whole};
