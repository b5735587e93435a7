//! What the graphics card does, without a window: devices, materials as textures, shaders, pictures read back.
//!
//! ```text
//! device ◄── tables, grating, layers, colour ◄── probe, surface ──► film
//!    ▲                                    │
//!    └──────────── offscreen ◄────────────┘
//! ```
//!
//! A [`Gpu`] is asked for no more than browsers have under WebGL2, so what runs here runs there: tables are textures that
//! are read by `textureLoad`, there are no storage buffers and no samplers. Shaders bind the wavelengths of the picture as
//! group 0 ([`Waves`]), a material as group 1 ([`Feather`], [`Grating`] or [`Layers`]); groups 2 and 3 are the pass's own.
//!
//! [`Surfaces`] draws meshes of barbules onto a [`Film`], linear sRGB in half precision, which a [`Developer`] shows.
//! [`Probe`] asks the shaders for values one by one, and so holds them against their references.

mod colour;
mod device;
mod film;
mod grating;
mod layers;
mod offscreen;
mod probe;
mod surface;
mod tables;

pub use colour::{MOST_WAVES, Sight, Waves, WavesOnGpu};
pub use device::{Api, Gpu};
pub use film::{Developer, Exposure, Film, LoadedFilm};
pub use grating::{Grating, PackedGrating};
pub use layers::{Layers, PackedLayers, Reflected};
pub use offscreen::Target;
pub use probe::{Probe, Question, Shader};
pub use surface::{Cells, Coat, Dress, Eye, Mesh, Surfaces, Trim, View};
pub use tables::{Feather, PackedTables};

/// Shaders in WGSL, to be put together in one module with a pass's own.
pub mod shaders {
    /// The wavelengths of a picture: group 0.
    pub const WAVES: &str = include_str!("shaders/waves.wgsl");
    /// A feather's BRDF from its tables: group 1. Goes with [`WAVES`].
    pub const FEATHER: &str = include_str!("shaders/feather.wgsl");
    /// A diffraction grating from its tables: group 1. Goes with [`WAVES`].
    pub const GRATING: &str = include_str!("shaders/grating.wgsl");
    /// Layers on a rough surface: group 1. Goes with [`WAVES`].
    pub const LAYERS: &str = include_str!("shaders/layers.wgsl");
    /// From linear sRGB to what a screen shows; stands alone.
    pub const TONE: &str = include_str!("shaders/tone.wgsl");
    /// Pigmented keratin; stands alone.
    pub const KERATIN: &str = include_str!("shaders/keratin.wgsl");
    /// Meshes under a lamp and an even sky: groups 2 and 3. Goes with [`KERATIN`] and one of the next four.
    pub(super) const SURFACE: &str = include_str!("shaders/surface.wgsl");
    /// Of barbules. Goes with [`FEATHER`].
    pub(super) const SURFACE_FEATHER: &str = include_str!("shaders/surface_feather.wgsl");
    /// Of gratings. Goes with [`GRATING`].
    pub(super) const SURFACE_GRATING: &str = include_str!("shaders/surface_grating.wgsl");
    /// Of layers. Goes with [`LAYERS`].
    pub(super) const SURFACE_LAYERS: &str = include_str!("shaders/surface_layers.wgsl");
    /// Of keratin alone.
    pub(super) const SURFACE_KERATIN: &str = include_str!("shaders/surface_keratin.wgsl");
    /// The development of a film. Goes with [`TONE`].
    pub(super) const DEVELOP: &str = include_str!("shaders/develop.wgsl");
}
