//! The program as people and scripts use it; one test program, so that it is linked once.

#![allow(clippy::unwrap_used)] // helpers of tests

mod campaign;
mod common;
mod crystal;
mod film;
mod geometry;
mod limits;
mod refusals;
mod render;
mod robustness;
