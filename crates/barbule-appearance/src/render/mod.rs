//! The renderer: spectral path tracing of a scene onto a film.

pub mod accelerator;
pub mod bsdf;
pub mod checkpoint;
pub mod film;
pub mod integrator;
pub mod picture;
pub mod point;
pub mod run;
pub mod sampler;
pub mod tone;
pub mod wavelengths;
