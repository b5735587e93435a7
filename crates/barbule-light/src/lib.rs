//! What both sides of Barbule speak of: wavelengths and colour, directions and what is scattered into them.
//!
//! The wave side makes [`scattering`] data, the picture side reads them; neither knows the other.

pub mod scattering;
pub mod spectrum;

use barbule_base::{Error, Result, error, math};
