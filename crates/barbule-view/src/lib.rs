//! The viewer of feathers: what its window shows, computes and remembers.
//!
//! ```text
//! state ──► live          what is open and how it is looked at ──► what is computed of it, beside the window
//!   │
//!   └─────► scene         meshes of what is shown, with the names that the renderer gives their parts
//! ```
//!
//! No module here draws or opens a window; everything is tested without one. Angles are radians inside and degrees where people
//! read them, lengths of scenes mm, of structures µm, of films and of wavelengths nm.

pub mod live;
pub mod scene;
pub mod state;
