//! From the nanostructure of a bird's feather to its reflectance, its BRDF and its picture.
//!
//! ```text
//! structure ──► solve ──► scattering ──► brdf ──► scene ──► render
//! (sections)   (waves)   (statistics)  (material) (feather)  (picture)
//! ```
//!
//! Modules only use those to their left, plus [`error`], [`math`], [`spectrum`] and [`material`]; `io` is the only
//! one that touches files. `ARCHITECTURE.md` has the list of permitted arrows and a test enforces it.
//!
//! # Conventions
//!
//! Time runs as exp(−jωt), so absorbing media have Im n > 0. A barbule's frame is x across, y along, z out of the top
//! surface. Directions are unit vectors that point away from the surface,
//! ω = (cosθ sinφ, sinθ, cosθ cosφ). Lengths are µm in structures and simulations, wavelengths nm in vacuum, angles
//! radians; feather-scale lengths are mm. Magnetic fields are scaled by the vacuum impedance.

pub mod campaign;
pub mod characterize;
pub mod figures;
pub mod io;
pub mod plot;

pub use barbule_appearance::{brdf, bsdf, render, scene};
pub use barbule_base::{Complex64, Error, Result, error, fields, identity, math, progress};
pub use barbule_light::{scattering, spectrum};
pub use barbule_optics::{material, solve, structure};
