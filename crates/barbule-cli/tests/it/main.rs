//! The program as people and scripts use it; one test program, so that it is linked once.

#![allow(clippy::unwrap_used)] // helpers of tests

mod brdf;
mod campaign;
mod common;
mod crystal;
mod far_field;
mod film;
mod geometry;
mod lobes;
mod outputs;
mod refusals;
mod render;
mod robustness;
mod species;
mod spectrum;
