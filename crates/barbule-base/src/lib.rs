//! What every part of Barbule stands on: errors, progress, and mathematics without physics.
//!
//! Generic libraries (FFT, dense algebra, Bessel functions, random generators) are used here, behind concrete functions,
//! so that an edit elsewhere does not compile them again.

pub mod error;
pub mod fields;
pub mod identity;
pub mod math;
pub mod progress;

pub use error::{Error, Result};
pub use num_complex::Complex64;
