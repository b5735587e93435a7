//! What the graphics card does, without a window: devices, materials as textures, shaders, pictures read back.
//!
//! ```text
//! device ◄── tables, colour ◄── probe
//!    ▲                            │
//!    └──────── offscreen ◄────────┘
//! ```
//!
//! A [`Gpu`] is asked for no more than browsers have under WebGL2, so what runs here runs there: tables are textures that
//! are read by `textureLoad`, there are no storage buffers and no samplers. Shaders bind the wavelengths of the picture as
//! group 0 ([`Waves`]), a material as group 1 ([`Feather`]); group 2 is the pass's own.
//!
//! [`Probe`] asks the shaders for values one by one, and so holds them against their references.

mod colour;
mod device;
mod offscreen;
mod probe;
mod tables;

pub use colour::{MOST_WAVES, Waves, WavesOnGpu};
pub use device::{Api, Gpu};
pub use offscreen::Target;
pub use probe::{Answer, Probe, Question};
pub use tables::{Feather, PackedTables};

/// Shaders in WGSL; those that name others go behind them in one module.
pub mod shaders {
    /// A feather's BRDF from its tables: group 1.
    pub const FEATHER: &str = include_str!("shaders/feather.wgsl");
    /// From wavelengths to linear sRGB: group 0. Goes with [`FEATHER`].
    pub const COLOUR: &str = include_str!("shaders/colour.wgsl");
    /// From linear sRGB to what a screen shows; stands alone.
    pub const TONE: &str = include_str!("shaders/tone.wgsl");
    /// Values one by one. Goes with all the others.
    pub(super) const PROBE: &str = include_str!("shaders/probe.wgsl");
}
