//! The viewer from outside.

mod feather;
mod grating;
mod questions;
mod tone;
