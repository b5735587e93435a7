//! The window in which Barbule's structures, materials and feathers are looked at.
//!
//! ```text
//! state ──► live          what is open and how it is looked at ──► what is computed of it, beside the window
//!   │
//!   └─────► scene         meshes of what is shown, with the names that the renderer gives their parts
//!
//! stage ──► gpu, scene    one shape in what it wears, drawn in real time ──► with wgpu and without any window: materials are textures
//!                         that shaders evaluate, wavelength by wavelength
//!
//! page ──► stage          the viewer in a browser: a few materials, films and a grating
//! ```
//!
//! Feature `desk` (the default) is the program; without it and with `page` the same crate compiles for `wasm32-unknown-unknown`.
//!
//! Angles are radians inside and degrees where people read them, lengths of scenes mm, of structures µm, of films and of wavelengths nm.

#[cfg(feature = "desk")]
pub mod arguments;
pub mod gpu;
#[cfg(feature = "desk")]
pub mod headless;
#[cfg(feature = "desk")]
pub mod live;
pub mod page;
pub mod scene;
#[cfg(feature = "desk")]
pub mod show;
pub mod stage;
#[cfg(feature = "desk")]
pub mod state;
#[cfg(feature = "desk")]
pub mod ui;

use barbule_base::{Error, Result};
