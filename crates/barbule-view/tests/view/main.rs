//! The viewer from outside.

mod feather;
mod grating;
mod layers;
mod page;
mod picture;
mod questions;
mod tone;
