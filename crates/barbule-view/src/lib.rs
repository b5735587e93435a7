//! The window in which Barbule's structures, materials and feathers are looked at.
//!
//! [`gpu`] draws, with wgpu and without any window: materials are textures that shaders evaluate wavelength by wavelength.

pub mod gpu;

use barbule_base::{Error, Result};
