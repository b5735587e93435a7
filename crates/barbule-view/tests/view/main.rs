//! The viewer from outside.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod feather;
mod grating;
mod layers;
mod page;
mod picture;
mod questions;
mod tone;
