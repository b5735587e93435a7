//! From a description to a scene.

use std::sync::Arc;

use glam::DVec3;

use super::{Bearing, FibreDescription, PigmentedKeratin, SceneDescription, SkyDescription};
use crate::brdf::FeatherBrdf;
use crate::bsdf::{
    Absorption, BarbuleSurface, FibreIndex, Hair, HairParameters, Keratin, Reflectance, Surface,
};
use crate::math::rng::hash;
use crate::scene::camera::{Camera, Projection, direction};
use crate::scene::emission::Emission;
use crate::scene::feather::Counts;
use crate::scene::light::{Lamp, Light, Sun, disc_radiance};
use crate::scene::sky::{Environment, Sky};
use crate::scene::{Object, Scene};
use crate::{Error, Result};

/// Shares of the samples that the key light and the sky get.
const KEY_WEIGHT: f64 = 0.6;
const SKY_WEIGHT: f64 = 0.4;

/// The camera's distance over the picture's width.
const DISTANCE: f64 = 4.0;

impl SceneDescription {
    /// The whole scene under the description's own sky. All lights have the spectrum of daylight (D65).
    ///
    /// # Errors
    /// A number out of range, or a sky that is an image: give it to [`SceneDescription::environment`].
    pub fn scene(&self, brdf: Arc<FeatherBrdf>, seed: u64) -> Result<(Scene, Counts)> {
        let (objects, counts) = self.objects(brdf, seed)?;
        let environment = self.environment(None)?;
        Ok((Scene { objects, lamps: self.lamps(), environment, camera: self.camera() }, counts))
    }

    /// The feather: shaft, rami, barbules.
    ///
    /// # Errors
    /// A number out of range.
    pub fn objects(&self, brdf: Arc<FeatherBrdf>, seed: u64) -> Result<(Vec<Object>, Counts)> {
        self.check()?;
        let grown = self.feather.grow(self.window, seed, hash(seed, &[1]))?;
        let counts = grown.counts();
        let barbule =
            BarbuleSurface { brdf, instances: true, under: keratin(&self.surfaces.underside)?, opacity: 1.0 };
        let parts = [
            (grown.shaft, Surface::Keratin(keratin(&self.surfaces.shaft)?)),
            match &self.surfaces.hair {
                Some(fibre) => (grown.fibres, Surface::Hair(hair(fibre)?)),
                None => (grown.rami, Surface::Keratin(keratin(&self.surfaces.ramus)?)),
            },
            (grown.barbules, Surface::Barbule(barbule)),
        ];
        Ok((parts.map(|(geometry, surface)| Object { geometry, surface }).into(), counts))
    }

    /// The key light, if it shines.
    #[must_use]
    pub fn lamps(&self) -> Vec<Lamp> {
        if self.light.strength <= 0.0 {
            return Vec::new();
        }
        let radius = self.light.radius_deg.to_radians();
        let sun = Sun {
            direction: self.light.bearing.direction(),
            cos_radius: radius.cos(),
            emission: Emission::daylight().scaled(disc_radiance(radius, self.light.strength)),
        };
        vec![Lamp { light: Light::Sun(sun), weight: KEY_WEIGHT }]
    }

    /// The sky: that of `image`, or the description's gradient, brightest at the zenith, a third at the horizon, dark
    /// below; `None` where it is dark.
    ///
    /// # Errors
    /// A description that needs an image.
    pub fn environment(&self, image: Option<Sky>) -> Result<Option<Environment>> {
        let sky = match (image, &self.sky) {
            (Some(sky), _) => sky,
            (None, _) if self.is_sky_dark() => return Ok(None),
            (None, SkyDescription::Gradient(zenith)) => Sky::grey(64, 32, Emission::daylight(), |d| {
                if d.z >= 0.0 { zenith * (0.35 + 0.65 * d.z) } else { 0.02 * zenith }
            })?,
            (None, SkyDescription::Image(image)) => {
                return Err(Error::input(format!(
                    "the sky is the image '{}', which is not read",
                    image.file
                )));
            }
        };
        Ok(Some(Environment { sky, weight: SKY_WEIGHT }))
    }

    /// Whether nothing comes from the sky.
    #[must_use]
    pub fn is_sky_dark(&self) -> bool {
        let strength = match &self.sky {
            SkyDescription::Gradient(zenith) => *zenith,
            SkyDescription::Image(image) => image.strength,
        };
        strength <= 0.0
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> Camera {
        let view = &self.camera;
        let distance = DISTANCE * view.width_mm;
        let roll = view.roll_deg.to_radians();
        let up = DVec3::new(roll.sin(), roll.cos(), 0.0);
        let towards = view.bearing.direction();
        // Straight along the picture's own upward direction the vane's normal is upwards.
        let up = if towards.cross(up).length() < 1e-3 { DVec3::Z } else { up };
        Camera {
            eye: towards * distance,
            target: DVec3::ZERO,
            up,
            width_mm: view.width_mm,
            projection: Projection::Perspective { lens_radius: view.lens * distance },
        }
    }
}

impl Bearing {
    /// Unit vector towards it.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        direction(self.azimuth_deg.to_radians(), self.elevation_deg.to_radians())
    }
}

fn keratin(of: &PigmentedKeratin) -> Result<Keratin> {
    Keratin::new(of.roughness, of.index, Reflectance::melanin(of.melanin)?)
}

fn hair(of: &FibreDescription) -> Result<Hair> {
    Hair::new(HairParameters {
        longitudinal_roughness: of.longitudinal_roughness,
        azimuthal_roughness: of.azimuthal_roughness,
        scale_tilt: of.scale_tilt_deg.to_radians(),
        index: of.index.map_or(FibreIndex::Keratin, FibreIndex::Constant),
        absorption: Absorption::pigments(of.eumelanin, of.pheomelanin)?,
    })
}
