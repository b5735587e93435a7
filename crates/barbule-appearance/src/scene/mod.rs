//! Scenes as data: objects, lamps, a sky and a camera; feathers, presets and files that they are made from.
//!
//! A feather's frame: x to the right, y along the shaft towards its tip, z out of the side that the camera sees.
//! Lengths are mm.

pub mod backdrop;
pub mod camera;
pub mod coat;
pub mod description;
pub mod emission;
pub mod eye_maps;
pub mod faces;
pub mod feather;
pub mod form;
pub mod geometry;
pub mod light;
pub mod memory;
pub mod preset;
pub mod primaries;
pub mod rows;
pub mod sky;
pub mod snake;
pub mod spline;
pub mod window;

use camera::Camera;
use geometry::Geometry;
use light::Lamp;
use sky::Environment;

use crate::bsdf::Surface;
use crate::progress::Progress;
use crate::{Error, Result};

/// Ends work that shall stop.
pub(crate) fn go_on(progress: &dyn Progress) -> Result<()> {
    if progress.is_cancelled() { Err(Error::interrupted()) } else { Ok(()) }
}

/// Shapes of one surface.
#[derive(Debug, Clone)]
pub struct Object {
    /// The shapes.
    pub geometry: Geometry,
    /// What they are made of.
    pub surface: Surface,
}

/// Everything that a picture shows.
#[derive(Debug, Clone)]
pub struct Scene {
    /// What is seen.
    pub objects: Vec<Object>,
    /// What shines.
    pub lamps: Vec<Lamp>,
    /// What shines from everywhere else.
    pub environment: Option<Environment>,
    /// The camera.
    pub camera: Camera,
}
