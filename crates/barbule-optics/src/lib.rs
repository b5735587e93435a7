//! The wave side of Barbule: nanostructures and the solvers of what they scatter.
//!
//! ```text
//! material, stack, film (barbule-light) ──► structure ──► solve ──► scattering (barbule-light)
//! ```

pub mod solve;
pub mod structure;

use barbule_base::{Complex64, Error, Result, error, fields, identity, math, progress, record};
use barbule_light::{film, material, scattering, spectrum, stack};
