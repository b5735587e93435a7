//! The program as people and scripts use it; one test program, so that it is linked once.

#![allow(clippy::unwrap_used)] // helpers of tests

mod atlas;
mod bench_render;
mod birds;
mod brdf;
mod cache;
mod campaign;
mod checkpoints;
mod common;
mod completions;
mod crystal;
mod diffract;
mod export;
mod far_field;
mod feather;
mod figures;
mod film;
mod fit_structure;
mod foreign_keys;
mod geometry;
mod inputs_stay;
mod instruments;
mod interruptions;
mod limits;
mod lobes;
mod man;
mod memory;
mod multilayer;
mod outputs;
mod pictures;
mod presets;
mod refusals;
mod render;
mod robustness;
mod shards;
mod sides;
mod species;
mod spectrum;
mod trace;
mod validate;
mod view;
