//! Close-ups of one feather that need no file.

use std::sync::Arc;

use glam::DVec3;

use super::camera::{Camera, Projection, direction};
use super::emission::Emission;
use super::feather::{Counts, Feather, Parts, Window, species};
use super::geometry::Geometry;
use super::keratin::{Keratin, Reflectance};
use super::light::{Light, Sun, disc_radiance};
use super::sky::Sky;
use super::surface::{Barbule, Surface};
use super::{Lamp, Scene};
use crate::brdf::FeatherBrdf;
use crate::error::did_you_mean;
use crate::math::rng::hash;
use crate::{Error, Result};

/// An azimuth and elevation over the vane, degrees: azimuth in its plane from the shaft's tip, clockwise seen from the
/// camera's side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bearing {
    /// Azimuth, degrees.
    pub azimuth: f64,
    /// Elevation over the vane's plane, degrees.
    pub elevation: f64,
}

/// A close-up of one feather.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    /// Name on the command line.
    pub name: &'static str,
    /// The structure that it shows unless told otherwise.
    pub material: &'static str,
    /// The feather.
    pub feather: Feather,
    /// The part of it that is grown.
    pub window: Window,
    /// Where the camera stands.
    pub view: Bearing,
    /// Direction in the vane's plane that is upwards in the picture, degrees from the shaft's tip, clockwise.
    pub roll: f64,
    /// Width of the picture in the plane of focus, mm.
    pub width_mm: f64,
    /// Radius of the lens over its distance: 0 is sharp everywhere.
    pub lens: f64,
    /// Where the key light stands.
    pub light: Bearing,
    /// Angular radius of the key light, degrees.
    pub light_radius: f64,
    /// Key light: irradiance over that of a sky of radiance 1.
    pub key: f64,
    /// Radiance of the sky at the zenith.
    pub sky: f64,
    /// Factor from radiance to the picture's linear values.
    pub exposure: f64,
    /// Melanin in the shaft and in the rami: absorption over scattering at 550 nm.
    pub pigment: [f64; 2],
}

/// All presets.
#[must_use]
pub fn all() -> [Preset; 7] {
    let usual = Preset {
        name: "starling",
        material: "starling",
        feather: species::starling(),
        window: Window { along_mm: 18.0, radius_mm: 3.0 },
        view: Bearing { azimuth: 190.0, elevation: 60.0 },
        roll: -35.0,
        width_mm: 3.9,
        lens: 0.005,
        light: Bearing { azimuth: 20.0, elevation: 62.0 },
        light_radius: 8.0,
        key: 2.5,
        sky: 0.8,
        exposure: 0.28,
        pigment: [4.0, 8.0],
    };
    [
        Preset { name: "rock-dove", material: "rock-dove", feather: species::rock_dove(), ..usual },
        usual,
        Preset {
            name: "bronzewing",
            material: "bronzewing",
            feather: species::bronzewing(),
            exposure: 0.2,
            window: Window { along_mm: 30.0, radius_mm: 3.0 },
            ..usual
        },
        Preset {
            name: "hummingbird",
            material: "hummingbird",
            feather: species::hummingbird(),
            window: Window { along_mm: 4.7, radius_mm: 2.2 },
            width_mm: 2.7,
            exposure: 0.3,
            ..usual
        },
        Preset {
            name: "mallard",
            material: "mallard",
            feather: species::mallard(),
            window: Window { along_mm: 9.0, radius_mm: 3.0 },
            ..usual
        },
        Preset {
            name: "magpie",
            material: "magpie",
            feather: species::magpie(),
            window: Window { along_mm: 150.0, radius_mm: 3.4 },
            ..usual
        },
        Preset {
            name: "peafowl",
            material: "peafowl",
            feather: species::peafowl(),
            window: Window { along_mm: 85.0, radius_mm: 3.4 },
            exposure: 0.22,
            ..usual
        },
    ]
}

/// The preset of a name.
///
/// # Errors
/// There is none; the message offers the nearest.
pub fn named(name: &str) -> Result<Preset> {
    let presets = all();
    presets.iter().find(|p| p.name == name).copied().ok_or_else(|| {
        Error::input(format!("there is no preset '{name}'{}", did_you_mean(name, presets.map(|p| p.name))))
    })
}

impl Preset {
    /// Refuses numbers that make no picture.
    ///
    /// # Errors
    /// The first number out of range.
    pub fn check(&self) -> Result<()> {
        self.view.check("camera")?;
        self.light.check("light")?;
        let ranges = [
            ("the picture's width in mm", self.width_mm, 0.05, 50.0),
            ("the lens", self.lens, 0.0, 0.2),
            ("the light's radius in degrees", self.light_radius, 0.1, 60.0),
            ("the light's strength", self.key, 0.0, 1e4),
            ("the sky's radiance", self.sky, 0.0, 1e4),
            ("the exposure", self.exposure, 1e-6, 1e6),
            ("the roll in degrees", self.roll, -360.0, 360.0),
        ];
        for (name, value, low, high) in ranges {
            if !(low..=high).contains(&value) {
                return Err(Error::input(format!("{name} is {value}, but must be {low} to {high}")));
            }
        }
        Ok(())
    }

    /// Grows the feather and sets up lights and camera. All lights have the spectrum of daylight (D65).
    ///
    /// # Errors
    /// A bearing or width out of range.
    pub fn scene(&self, brdf: Arc<FeatherBrdf>, seed: u64) -> Result<(Scene, Counts)> {
        self.scene_under(None, brdf, seed)
    }

    /// The same under another sky, if there is one.
    ///
    /// # Errors
    /// As [`Preset::scene`].
    pub fn scene_under(
        &self,
        sky: Option<&Sky>,
        brdf: Arc<FeatherBrdf>,
        seed: u64,
    ) -> Result<(Scene, Counts)> {
        self.check()?;
        let daylight = Emission::daylight();
        let mut geometry = Geometry::default();
        let parts = Parts { shaft: 0, ramus: 1, barbule: 2 };
        let counts = self.feather.grow(&mut geometry, parts, self.window, seed, hash(seed, &[1]))?;
        let surfaces = vec![
            Surface::Keratin(Keratin::new(0.22, 1.56, Reflectance::melanin(self.pigment[0])?)?),
            Surface::Keratin(Keratin::new(0.25, 1.56, Reflectance::melanin(self.pigment[1])?)?),
            Surface::Barbule(Barbule {
                brdf,
                instances: true,
                under: Keratin::new(0.35, 1.56, Reflectance::melanin(20.0)?)?,
                passes: 0.0,
            }),
        ];
        let sky = sky.map_or_else(|| self.sky_light(&daylight), |sky| Ok(sky.clone()))?;
        let mut lights = vec![Lamp { light: Light::Sky(sky), weight: 0.4 }];
        if self.key > 0.0 {
            lights.insert(0, Lamp { light: Light::Sun(self.sun(&daylight)), weight: 0.6 });
        }
        let scene = Scene { geometry, surfaces, lights, camera: self.camera(), max_depth: 5 };
        scene.check()?;
        Ok((scene, counts))
    }

    fn sun(&self, daylight: &Emission) -> Sun {
        let radius = self.light_radius.to_radians();
        Sun {
            direction: self.light.direction(),
            cos_radius: radius.cos(),
            emission: daylight.scaled(disc_radiance(radius, self.key)),
        }
    }

    /// Brightest at the zenith, half at the horizon, dark below.
    fn sky_light(&self, daylight: &Emission) -> Result<Sky> {
        let zenith = self.sky;
        Sky::grey(64, 32, daylight.clone(), |d| {
            if d.z >= 0.0 { zenith * (0.35 + 0.65 * d.z) } else { 0.02 * zenith }
        })
    }

    fn camera(&self) -> Camera {
        let distance = 4.0 * self.width_mm;
        let roll = self.roll.to_radians();
        let up = DVec3::new(roll.sin(), roll.cos(), 0.0);
        let towards = self.view.direction();
        // Straight along the picture's own upward direction the vane's normal is upwards.
        let up = if towards.cross(up).length() < 1e-3 { DVec3::Z } else { up };
        Camera {
            eye: towards * distance,
            target: DVec3::ZERO,
            up,
            width_mm: self.width_mm,
            projection: Projection::Perspective { lens_radius: self.lens * distance },
        }
    }
}

impl Bearing {
    /// Unit vector towards it.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        direction(self.azimuth.to_radians(), self.elevation.to_radians())
    }

    fn check(&self, what: &str) -> Result<()> {
        if self.azimuth.is_finite() && (-90.0..=90.0).contains(&self.elevation) {
            return Ok(());
        }
        Err(Error::input(format!(
            "the {what} is at azimuth {} and elevation {} degrees; the elevation must be -90 to 90",
            self.azimuth, self.elevation
        )))
    }
}
