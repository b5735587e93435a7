//! Wave solvers: each takes a structure and gives scattered fields.

mod beam;
pub mod crystal;
pub mod diffraction;
pub mod direct;
pub mod far_fields;
pub mod full_wave;
pub mod segment;
pub mod surface;
pub mod swatch;
