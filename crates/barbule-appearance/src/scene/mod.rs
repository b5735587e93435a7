//! Scenes: shapes, surfaces, lights and a camera; feathers and presets built from them.
//!
//! A feather's frame: x to the right, y along the shaft towards its tip, z out of the side that the camera sees.
//! Lengths are mm.

pub mod camera;
pub mod description;
pub mod emission;
pub mod feather;
pub mod frame;
pub mod geometry;
mod identify;
pub mod keratin;
pub mod light;
pub mod preset;
pub mod primaries;
pub mod sky;
pub mod surface;

use camera::Camera;
use geometry::Geometry;
use light::Light;
use surface::Surface;

use crate::{Error, Result};

/// A light with its share of the samples.
#[derive(Debug, Clone)]
pub struct Lamp {
    /// The light.
    pub light: Light,
    /// How often it is chosen, relative to the others; over 0.
    pub weight: f64,
}

/// Everything that a picture needs.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Shapes.
    pub geometry: Geometry,
    /// Surfaces, referred to by index.
    pub surfaces: Vec<Surface>,
    /// Lights.
    pub lights: Vec<Lamp>,
    /// The camera.
    pub camera: Camera,
    /// Most scatterings of a path.
    pub max_depth: u32,
}

impl Scene {
    /// Refuses scenes that cannot be rendered.
    ///
    /// # Errors
    /// Broken geometry, no light, or weights that are not positive.
    pub fn check(&self) -> Result<()> {
        self.geometry.check(self.surfaces.len())?;
        if self.lights.is_empty() {
            return Err(Error::input("the scene has no light"));
        }
        if self.lights.iter().any(|lamp| !(lamp.weight.is_finite() && lamp.weight > 0.0)) {
            return Err(Error::input("a light's weight must be finite and greater than zero"));
        }
        Ok(())
    }

    /// Nearest distance at which a ray that leaves a surface may hit another, mm: a hundred-thousandth of the
    /// scene's size, far less than a barbule's width and far more than rounding.
    #[must_use]
    pub fn nearest_mm(&self) -> f64 {
        let points = (self.geometry.meshes.iter().flat_map(|m| &m.positions))
            .chain(self.geometry.ribbon_nodes.iter().map(|n| &n.point))
            .chain(self.geometry.curve_nodes.iter().map(|n| &n.point));
        let (mut low, mut high) = (glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY);
        for point in points {
            low = low.min(*point);
            high = high.max(*point);
        }
        let size = f64::from((high - low).length());
        if size.is_finite() { 1e-5 * size } else { 1e-5 }
    }

    /// Whether any surface lets light pass straight through.
    #[must_use]
    pub fn passes_light(&self) -> bool {
        self.surfaces.iter().any(|surface| surface.passes() > 0.0)
    }
}
