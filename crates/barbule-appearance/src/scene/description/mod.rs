//! What a scene file says: one feather, its surfaces, lights, a sky, a camera and what is seen behind.
//!
//! Presets are such files, which a user's file may change (`docs/guide/render.md`). As in files, angles are degrees here.

mod build;
mod coat;
mod colour;
mod detail;
mod file;
mod kinds;
mod lights;
mod objects;
mod parts;
mod sequence;
mod surfaces;
mod text;

pub use coat::{CoatBody, CoatDescription};
pub use colour::parse_colour;
pub use detail::{Detail, DetailLevel, ViewModel};
pub use file::SkyImage;
pub use lights::{LightColour, LightDescription, LightShape};
pub use objects::{ObjectDescription, ObjectShape, Placement};
pub use sequence::{Motion, Moved, USUAL_ARC_DEG, Waypoint};
pub use surfaces::{GratingDescription, GratingSource, Metal, NamedSurface, TextureFile};

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

use super::backdrop::Backdrop;
use super::feather::{Feather, VaneDisc};
use crate::error::shortened;
use crate::fields::Fields;
use crate::identity::{Hasher, Identify};
use crate::{Error, Result};

/// Azimuths and turns are at most this many degrees, ten turns: far beyond, digits are lost.
const MOST_TURN_DEG: f64 = 3600.0;

/// A picture to be rendered.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneDescription {
    /// Name or file of the barbules' material.
    #[serde(skip)]
    pub material: String,
    /// Width and height in pixels, if the scene says so.
    #[serde(skip)]
    pub size: Option<[u32; 2]>,
    /// Factor from radiance to the picture's linear values; by a key where there is none.
    #[serde(skip)]
    pub exposure: Option<f64>,
    /// Most scatterings of a light path.
    pub scatterings: u32,
    /// What shines from everywhere.
    pub sky: SkyDescription,
    /// The key light.
    pub light: KeyLight,
    /// Lamps beside it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<LightDescription>,
    /// Where the camera stands.
    pub camera: View,
    /// What is seen behind the feather.
    #[serde(serialize_with = "shows_sky")]
    pub background: Background,
    /// By how much the feather is turned about the picture's upward direction, degrees, counter-clockwise seen from above.
    pub turn_deg: f64,
    /// The part of the feather that is grown.
    pub window: VaneDisc,
    /// How finely it is made.
    pub detail: Detail,
    /// What the feather's parts are made of, barbules' upper sides aside.
    pub surfaces: Surfaces,
    /// The feather.
    pub feather: Feather,
    /// Whether it is there; without it a scene has its other objects only.
    pub shows_feather: bool,
    /// The body that it covers, many times, in place of standing alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coat: Option<CoatDescription>,
    /// What else stands in the scene.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<ObjectDescription>,
    /// What that is made of.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub named_surfaces: BTreeMap<String, NamedSurface>,
}

/// An azimuth and elevation over the vane: azimuth in its plane from the shaft's tip, clockwise seen from the camera's
/// side.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bearing {
    /// Azimuth, degrees.
    pub azimuth_deg: f64,
    /// Elevation over the vane's plane, degrees.
    pub elevation_deg: f64,
}

/// What shines from everywhere.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum SkyDescription {
    /// A gradient from the zenith to the horizon, and one value below.
    Gradient {
        /// Radiance at the zenith.
        zenith: f64,
        /// That at the horizon over it.
        horizon: f64,
        /// That below the horizon over it.
        below: f64,
    },
    /// An image.
    Image(SkyImage),
}

/// A disc at infinity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct KeyLight {
    /// Where it stands.
    pub bearing: Bearing,
    /// Angular radius, degrees.
    pub radius_deg: f64,
    /// Irradiance over that of a sky of radiance 1; 0: there is none.
    pub strength: f64,
}

/// What is seen behind the feather.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Background {
    /// The sky and the lights at infinity.
    #[default]
    Sky,
    /// Nothing.
    None,
    /// A colour on the screen: sRGB, 0 … 1.
    Colour([f64; 3]),
    /// A picture, relative to the scene's folder.
    Picture {
        /// Its file.
        file: String,
        /// What is in it, once it is read.
        picture: Backdrop,
    },
}

/// Of a background only whether the sky is seen decides a picture's samples.
fn shows_sky<S: serde::Serializer>(background: &Background, to: S) -> std::result::Result<S::Ok, S::Error> {
    to.serialize_bool(*background == Background::Sky)
}

/// How a camera projects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum ViewProjection {
    /// Through an eye.
    Perspective,
    /// Along parallel rays.
    Orthographic,
}

impl ViewProjection {
    /// All with their names.
    pub const ALL: [(&'static str, Self); 2] =
        [("perspective", Self::Perspective), ("orthographic", Self::Orthographic)];
}

/// A camera; where nothing else is said it looks at the middle of the window, in the origin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct View {
    /// Where it stands, seen from its target.
    pub bearing: Bearing,
    /// Where it stands in place of that, mm.
    pub position: Option<[f64; 3]>,
    /// What it looks at, mm.
    pub target: [f64; 3],
    /// How it projects.
    pub projection: ViewProjection,
    /// Focal length over a film of 36 mm, mm: how far it stands for the picture's width; from a position, how wide the picture is.
    pub focal_length_mm: Option<f64>,
    /// How far what is sharp lies from it, mm; its target where nothing is said.
    pub focus_distance_mm: Option<f64>,
    /// Direction in the vane's plane that is upwards in the picture, degrees from the shaft's tip, clockwise.
    pub roll_deg: f64,
    /// Width of the picture in the plane of focus, mm.
    pub width_mm: f64,
    /// Radius of the lens over its distance: 0 is sharp everywhere.
    pub lens: f64,
    /// f-number of a lens before a film of 36 mm, in place of that.
    pub f_number: Option<f64>,
}

/// Keratin with pigment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PigmentedKeratin {
    /// GGX α of the boundary.
    pub roughness: f64,
    /// Refractive index.
    pub index: f64,
    /// Melanin: absorption over scattering at 550 nm.
    pub melanin: f64,
}

/// A fibre of the hair model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FibreDescription {
    /// How far lobes spread along the fibre.
    pub longitudinal_roughness: f64,
    /// How far they spread around it.
    pub azimuthal_roughness: f64,
    /// By how much scales stand off it, degrees.
    pub scale_tilt_deg: f64,
    /// Refractive index; that of feather keratin at each wavelength where there is none.
    pub index: Option<f64>,
    /// Concentration of eumelanin: 0.3 is blond, 1.3 brown, 8 black.
    pub eumelanin: f64,
    /// Concentration of pheomelanin.
    pub pheomelanin: f64,
    /// Height of the section, along the vane's normal, over its width.
    pub height_over_width: f64,
}

/// What the parts of a feather are made of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Surfaces {
    /// The shaft.
    pub shaft: PigmentedKeratin,
    /// The rami of the barbs.
    pub ramus: PigmentedKeratin,
    /// The undersides of the barbules.
    pub underside: PigmentedKeratin,
    /// What rami are made of as fibres, in place of `ramus`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hair: Option<FibreDescription>,
    /// What barbules without structural colour are made of, in place of the material and `underside`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub barbule: Option<FibreDescription>,
    /// Barbules of pale places.
    pub pale: PigmentedKeratin,
    /// Barbs and barbules of the downy part.
    pub down: FibreDescription,
}

impl Identify for SceneDescription {
    /// Everything that decides a picture's samples, beside the material, the sky's image, the size and the seed: the same
    /// for the same scene, however it was put together.
    fn feed(&self, to: &mut Hasher) {
        to.text("scene", &serde_json::to_string(self).unwrap_or_default());
    }
}

impl SceneDescription {
    /// Refuses numbers that make no picture.
    ///
    /// # Errors
    /// The first number out of range.
    pub fn check(&self) -> Result<()> {
        let ([sky, horizon, below], image) = match &self.sky {
            SkyDescription::Gradient { zenith, horizon, below } => ([*zenith, *horizon, *below], (1.0, 0.0)),
            SkyDescription::Image(image) => ([0.0; 3], (image.strength, image.turn_deg)),
        };
        let [camera, light] = [&self.camera.bearing, &self.light.bearing];
        let ranges = [
            ("camera.azimuth_deg", camera.azimuth_deg, -MOST_TURN_DEG, MOST_TURN_DEG),
            ("camera.elevation_deg", camera.elevation_deg, -90.0, 90.0),
            ("camera.width_mm", self.camera.width_mm, 0.05, 2000.0),
            ("camera.lens", self.camera.lens, 0.0, 0.2),
            ("camera.f_number", self.camera.f_number.unwrap_or(8.0), 1.0, 1000.0),
            ("camera.roll_deg", self.camera.roll_deg, -360.0, 360.0),
            ("camera.focal_length_mm", self.camera.focal_length_mm.unwrap_or(50.0), 5.0, 5000.0),
            ("camera.focus_distance_mm", self.camera.focus_distance_mm.unwrap_or(1.0), 1e-3, 1e5),
            ("turn_deg", self.turn_deg, -MOST_TURN_DEG, MOST_TURN_DEG),
            ("light.azimuth_deg", light.azimuth_deg, -MOST_TURN_DEG, MOST_TURN_DEG),
            ("light.elevation_deg", light.elevation_deg, -90.0, 90.0),
            ("light.radius_deg", self.light.radius_deg, 0.1, 60.0),
            ("light.strength", self.light.strength, 0.0, 1e4),
            ("sky", sky, 0.0, 1e4),
            ("sky_horizon", horizon, 0.0, 100.0),
            ("sky_below", below, 0.0, 100.0),
            ("sky_image.strength", image.0, 0.0, 1e6),
            ("sky_image.turn_deg", image.1, -MOST_TURN_DEG, MOST_TURN_DEG),
            ("exposure", self.exposure.unwrap_or(1.0), 1e-6, 1e6),
            ("scatterings", f64::from(self.scatterings), 1.0, 1000.0),
            ("window.along_mm", self.window.along_mm, 0.0, 2000.0),
            ("window.radius_mm", self.window.radius_mm.unwrap_or(1.0), 0.01, 500.0),
        ];
        for (key, value, low, high) in ranges {
            if !(low..=high).contains(&value) {
                let value = shortened(&value.to_string());
                return Err(Error::input(format!("{key} is {value}, outside {low} to {high}")));
            }
        }
        self.camera.check()?;
        let is_lamp_on = self.lights.iter().any(|light| light.strength > 0.0);
        if self.light.strength <= 0.0 && self.is_sky_dark() && !is_lamp_on {
            let sky = match self.sky {
                SkyDescription::Gradient { .. } => "sky",
                SkyDescription::Image(_) => "sky_image.strength",
            };
            return Err(Error::input(format!(
                "{sky} and light.strength are both 0, so nothing shines; give one of them more than 0"
            )));
        }
        self.check_coat()?;
        self.feather.check()
    }

    /// Memory that its coat, its objects and their pictures take while the scene is built, bytes, once its files are read.
    #[must_use]
    pub fn object_bytes(&self) -> u64 {
        let objects: usize = self.objects.iter().map(ObjectDescription::bytes).sum();
        let pictures: usize = self.named_surfaces.values().map(NamedSurface::bytes).sum();
        let coat = self.coat.as_ref().map_or(0, CoatDescription::bytes);
        (objects + pictures + coat) as u64
    }

    /// Whether the key light shines from behind the vane, as the camera sees it.
    #[must_use]
    pub fn is_lit_from_behind(&self) -> bool {
        self.light.strength > 0.0
            && self.light.bearing.elevation_deg * self.camera.bearing.elevation_deg.signum() <= 0.0
    }
}

impl View {
    /// Refuses a camera that stands in its target or focuses behind itself.
    fn check(&self) -> Result<()> {
        let coordinates = self.target.iter().chain(self.position.iter().flatten());
        if coordinates.into_iter().any(|v| v.is_nan() || v.abs() > 1e6) {
            return Err(Error::input(
                "camera.position_mm or camera.target_mm is over 1000000 mm away; give a nearer one",
            ));
        }
        if let Some(position) = self.position
            && position.iter().zip(self.target).all(|(a, b)| (a - b).abs() < 1e-3)
        {
            return Err(Error::input(
                "camera.position_mm and camera.target_mm are the same place; give the camera another one",
            ));
        }
        if self.projection == ViewProjection::Orthographic && self.focus_distance_mm.is_some() {
            return Err(Error::input(
                "camera.focus_distance_mm is given, but an orthographic camera is sharp everywhere; leave it out",
            ));
        }
        Ok(())
    }
}

/// The parts of a feather that have surfaces of their own.
const PARTS: [&str; 7] = ["shaft", "ramus", "underside", "hair", "barbule", "pale", "down"];

/// Down where nothing is said: grey.
const DOWN: FibreDescription = FibreDescription {
    longitudinal_roughness: 0.3,
    azimuthal_roughness: 0.4,
    scale_tilt_deg: 0.0,
    index: None,
    eumelanin: 2.0,
    pheomelanin: 0.0,
    height_over_width: 1.0,
};

/// Keratin of pale places where nothing is said: buff.
const PALE: PigmentedKeratin = PigmentedKeratin { roughness: 0.4, index: 1.56, melanin: 0.15 };

impl Surfaces {
    /// Reads the table `[surfaces]`: those of the feather's parts, and further ones, which have a type.
    fn read(table: &Value) -> Result<(Self, BTreeMap<String, NamedSurface>)> {
        let mut named = BTreeMap::new();
        let mut own = table.clone();
        if let (Value::Object(all), Value::Object(own)) = (table, &mut own) {
            for (name, surface) in all.iter().filter(|(name, _)| !PARTS.contains(&name.as_str())) {
                if surface.get("type").is_some() {
                    own.remove(name);
                    named.insert(
                        name.clone(),
                        NamedSurface::read(surface, &format!("surfaces.{}", shortened(name)))?,
                    );
                }
            }
        }
        for (name, surface) in &named {
            surface.check(&format!("surfaces.{}", shortened(name)), &named)?;
        }
        let fields = Fields::new(&own, "surfaces", &PARTS)?;
        let keratin = |key: &str| -> Result<PigmentedKeratin> {
            let table = fields.need(key, &format!("the table [surfaces.{key}]"))?;
            PigmentedKeratin::read(table, &fields.path(key))
        };
        let fibre = |key: &str| {
            fields.get(key).map(|table| FibreDescription::read(table, &fields.path(key))).transpose()
        };
        let parts = Self {
            shaft: keratin("shaft")?,
            ramus: keratin("ramus")?,
            underside: keratin("underside")?,
            hair: fibre("hair")?,
            barbule: fibre("barbule")?,
            down: fibre("down")?.unwrap_or(DOWN),
            pale: if fields.get("pale").is_some() { keratin("pale")? } else { PALE },
        };
        Ok((parts, named))
    }
}

impl PigmentedKeratin {
    fn read(table: &Value, place: &str) -> Result<Self> {
        let fields = Fields::new(table, place, &["roughness", "index", "melanin"])?;
        Ok(Self {
            roughness: fields.number_within("roughness", 0.02, 1.0)?,
            index: fields.number_within("index", 1.01, 3.9)?,
            melanin: fields.number_within("melanin", 0.0, 1e6)?,
        })
    }
}

impl FibreDescription {
    /// Reads a table in which every key may be left out: then it is a ramus without pigment.
    fn read(table: &Value, place: &str) -> Result<Self> {
        const KEYS: [&str; 7] = [
            "longitudinal_roughness",
            "azimuthal_roughness",
            "scale_tilt_deg",
            "index",
            "eumelanin",
            "pheomelanin",
            "height_over_width",
        ];
        let fields = Fields::new(table, place, &KEYS)?;
        let within = |key: &str, low: f64, high: f64| -> Result<Option<f64>> {
            fields.get(key).map(|_| fields.number_within(key, low, high)).transpose()
        };
        Ok(Self {
            longitudinal_roughness: within(KEYS[0], 0.02, 1.0)?.unwrap_or(0.3),
            azimuthal_roughness: within(KEYS[1], 0.02, 1.0)?.unwrap_or(0.4),
            scale_tilt_deg: within(KEYS[2], -20.0, 20.0)?.unwrap_or(0.0),
            index: within(KEYS[3], 1.01, 3.9)?,
            eumelanin: within(KEYS[4], 0.0, 1e3)?.unwrap_or(0.0),
            pheomelanin: within(KEYS[5], 0.0, 1e3)?.unwrap_or(0.0),
            height_over_width: within(KEYS[6], 0.1, 10.0)?.unwrap_or(1.0),
        })
    }
}
