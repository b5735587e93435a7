//! The viewer from outside.

mod feather;
mod questions;
mod tone;
