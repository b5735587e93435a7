//! What both sides of Barbule speak of: wavelengths and colour, media and their films, directions and what is scattered into
//! them.
//!
//! ```text
//! material ──► stack ──► film
//! ```
//!
//! The wave side makes [`scattering`] data, the picture side reads them; neither knows the other. Flat boundaries and films
//! reflect alike on both.

pub mod film;
pub mod fresnel;
pub mod instrument;
pub mod material;
pub mod scattering;
pub mod spectrum;
pub mod stack;
pub mod vision;

use barbule_base::{Complex64, Error, Result, error, fields, identity, math, progress};
