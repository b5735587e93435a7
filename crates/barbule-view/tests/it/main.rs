//! The viewer from outside.

mod feather;
mod grating;
mod picture;
mod questions;
mod tone;
