//! What the graphics card does, without a window: devices, materials as textures, shaders, pictures read back.
//!
//! ```text
//! device ◄── tables, grating, colour ◄── probe, surface ──► film
//!    ▲                                    │
//!    └──────────── offscreen ◄────────────┘
//! ```
//!
//! A [`Gpu`] is asked for no more than browsers have under WebGL2, so what runs here runs there: tables are textures that
//! are read by `textureLoad`, there are no storage buffers and no samplers. Shaders bind the wavelengths of the picture as
//! group 0 ([`Waves`]), a material as group 1 ([`Feather`] or [`Grating`]); group 2 is the pass's own.
//!
//! [`Surfaces`] draws meshes of barbules onto a [`Film`], linear sRGB in half precision, which a [`Developer`] shows.
//! [`Probe`] asks the shaders for values one by one, and so holds them against their references.

mod colour;
mod device;
mod film;
mod grating;
mod offscreen;
mod probe;
mod surface;
mod tables;

pub use colour::{MOST_WAVES, Waves, WavesOnGpu};
pub use device::{Api, Gpu};
pub use film::{Developer, Exposure, Film};
pub use grating::{Grating, PackedGrating};
pub use offscreen::Target;
pub use probe::{Probe, Question, Shader};
pub use surface::{Cells, Coat, Dress, Eye, Mesh, Surfaces, View};
pub use tables::{Feather, PackedTables};

/// Shaders in WGSL, to be put together in one module with a pass's own.
pub mod shaders {
    /// The wavelengths of a picture: group 0.
    pub const WAVES: &str = include_str!("shaders/waves.wgsl");
    /// A feather's BRDF from its tables: group 1. Goes with [`WAVES`].
    pub const FEATHER: &str = include_str!("shaders/feather.wgsl");
    /// A diffraction grating from its tables: group 1. Goes with [`WAVES`].
    pub const GRATING: &str = include_str!("shaders/grating.wgsl");
    /// From linear sRGB to what a screen shows; stands alone.
    pub const TONE: &str = include_str!("shaders/tone.wgsl");
    /// Pigmented keratin; stands alone.
    pub const KERATIN: &str = include_str!("shaders/keratin.wgsl");
    /// Meshes under a lamp and an even sky: group 2. Goes with [`KERATIN`] and one of the next two.
    pub(super) const SURFACE: &str = include_str!("shaders/surface.wgsl");
    /// Of barbules, barbs and shafts. Goes with [`FEATHER`].
    pub(super) const SURFACE_FEATHER: &str = include_str!("shaders/surface_feather.wgsl");
    /// Of gratings. Goes with [`GRATING`].
    pub(super) const SURFACE_GRATING: &str = include_str!("shaders/surface_grating.wgsl");
    /// The development of a film. Goes with [`TONE`].
    pub(super) const DEVELOP: &str = include_str!("shaders/develop.wgsl");
}
