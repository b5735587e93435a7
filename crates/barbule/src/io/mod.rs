//! The only module that opens files.

mod material;
pub mod store;
mod whole;

pub use material::{decode_material, encode_material, read_material, write_material};
pub use whole::{LARGEST_INPUT, check_writable, read_bytes, read_text, write_whole};
