//! The picture side of Barbule: BRDFs, surfaces, scenes and the spectral renderer.
//!
//! ```text
//! scattering (barbule-light) ──► brdf ──► bsdf ──► scene ──► render
//! ```

pub mod brdf;
pub mod bsdf;
pub mod render;
pub mod scene;

use barbule_base::{Error, Result, error, fields, identity, math, progress, record, variants, words};
use barbule_light::{film, fresnel, material, scattering, spectrum, stack};
