//! The renderer: spectral path tracing onto a film.
//!
//! A [`Stage`](stage::Stage) (objects and their hierarchy), a [`Lighting`](light::Lighting) and a
//! [`Camera`](crate::scene::camera::Camera) are made apart and meet in an [`Integrator`](integrator::Integrator), so
//! that a lamp or the camera moves without a new hierarchy.

mod accelerator;
pub mod checkpoint;
pub mod cryptomatte;
pub mod exposure;
pub mod faults;
pub mod film;
pub mod integrator;
pub mod light;
pub mod picture;
mod pixel;
pub mod planes;
mod response;
pub mod run;
pub mod sampler;
pub mod stage;
pub mod tone;
mod window;
