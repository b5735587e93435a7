//! The picture side of Barbule: BRDFs, scenes and the spectral renderer.
//!
//! ```text
//! scattering (barbule-light) ──► brdf ──► scene ──► render
//! ```

pub mod brdf;
pub mod render;
pub mod scene;

use barbule_base::{Error, Result, error, identity, math, progress};
use barbule_light::{scattering, spectrum};
