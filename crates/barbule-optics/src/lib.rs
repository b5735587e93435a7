//! The wave side of Barbule: materials, nanostructures and the solvers of what they scatter.
//!
//! ```text
//! material ──► structure ──► solve ──► scattering (barbule-light)
//! ```

pub mod material;
pub mod solve;
pub mod structure;

use barbule_base::{Complex64, Error, Result, error, fields, identity, math, progress};
use barbule_light::{scattering, spectrum};
