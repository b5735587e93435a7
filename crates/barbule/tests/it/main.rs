//! The library against references, laws, statistics and pictures; one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests; some print the figures that they hold

mod agreement;
mod arches;
mod architecture;
mod batch;
mod birds;
mod brdf;
mod clad;
mod colour;
mod crystal_colours;
mod crystal_values;
mod crystals;
mod documented;
mod errors;
mod exported;
mod feather_laws;
mod film;
mod furnace;
mod geometry;
mod golden;
mod gratings;
mod identity;
mod instruments;
mod levels;
mod lights;
mod measure;
mod measured_feathers;
mod objects;
mod peacock;
mod picture;
mod places;
mod polarization;
mod render;
mod render_runs;
mod scenes;
mod sensor;
mod sides;
mod simulation;
mod small_scenes;
mod statistics;
