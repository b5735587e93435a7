//! Scene files: a preset with changes, in TOML.
//!
//! ```toml
//! preset = "starling"
//! material = "starling:pink"
//! size = [1280, 800]
//! exposure = 0.5
//! sky = 0.7
//! # in place of `sky`:
//! # [sky_image]
//! # file = "studio.exr"
//! # strength = 1.0
//! # turn = 0.0
//! [light]
//! azimuth = 20.0
//! elevation = 60.0
//! radius = 7.0
//! strength = 2.2
//! [camera]
//! azimuth = 190.0
//! elevation = 58.0
//! width_mm = 4.4
//! roll = -38.0
//! lens = 0.005
//! ```
//! Only `preset` is needed; the rest is the preset's own.

use serde::Deserialize;

use super::preset::{self, Preset};
use crate::error::did_you_mean;
use crate::{Error, Result};

/// A picture to be rendered: a preset, perhaps changed, and what its barbules are made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Feather, light and camera.
    pub preset: Preset,
    /// Name or file of the material.
    pub material: String,
    /// Width and height in pixels, if the scene says so.
    pub size: Option<[u32; 2]>,
    /// An image in place of the preset's plain sky.
    pub sky_image: Option<SkyImage>,
}

/// A sky from a file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkyImage {
    /// Equirectangular EXR, relative to the scene's folder.
    pub file: String,
    /// Factor to the image's radiance.
    #[serde(default = "one")]
    pub strength: f64,
    /// By how much it is turned clockwise seen from above, degrees.
    #[serde(default)]
    pub turn: f64,
}

fn one() -> f64 {
    1.0
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    preset: String,
    material: Option<String>,
    size: Option<[u32; 2]>,
    exposure: Option<f64>,
    sky: Option<f64>,
    sky_image: Option<SkyImage>,
    #[serde(default)]
    light: LightFile,
    #[serde(default)]
    camera: CameraFile,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct LightFile {
    azimuth: Option<f64>,
    elevation: Option<f64>,
    radius: Option<f64>,
    strength: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraFile {
    azimuth: Option<f64>,
    elevation: Option<f64>,
    width_mm: Option<f64>,
    roll: Option<f64>,
    lens: Option<f64>,
}

/// Keys of a scene file, for suggestions.
const KEYS: [&str; 19] = [
    "preset",
    "material",
    "size",
    "exposure",
    "sky",
    "light",
    "camera",
    "azimuth",
    "elevation",
    "radius",
    "strength",
    "width_mm",
    "roll",
    "lens",
    "light.radius",
    "camera.width_mm",
    "sky_image",
    "file",
    "turn",
];

impl Description {
    /// A preset by its name, or `SPECIES:VARIANT`: the species' preset with that variant's material.
    ///
    /// # Errors
    /// No such preset.
    pub fn named(name: &str) -> Result<Self> {
        let preset = preset::named(name.split_once(':').map_or(name, |(species, _)| species))?;
        let material = if name.contains(':') { name.to_owned() } else { preset.material.to_owned() };
        Ok(Self { preset, material, size: None, sky_image: None })
    }

    /// A scene file's text.
    ///
    /// # Errors
    /// Not TOML, an unknown key, a value of the wrong kind or out of range.
    pub fn parse(text: &str) -> Result<Self> {
        let file: File = toml::from_str(text).map_err(|error| refusal(text, &error))?;
        let mut description = Self::named(&file.preset)?;
        if let Some(material) = file.material {
            description.material = material;
        }
        description.size = file.size;
        if file.sky.is_some() && file.sky_image.is_some() {
            return Err(Error::input("sky and [sky_image] are both given; leave one out"));
        }
        description.sky_image = file.sky_image;
        let preset = &mut description.preset;
        let fields = [
            (&mut preset.exposure, file.exposure),
            (&mut preset.sky, file.sky),
            (&mut preset.light.azimuth, file.light.azimuth),
            (&mut preset.light.elevation, file.light.elevation),
            (&mut preset.light_radius, file.light.radius),
            (&mut preset.key, file.light.strength),
            (&mut preset.view.azimuth, file.camera.azimuth),
            (&mut preset.view.elevation, file.camera.elevation),
            (&mut preset.width_mm, file.camera.width_mm),
            (&mut preset.roll, file.camera.roll),
            (&mut preset.lens, file.camera.lens),
        ];
        for (field, value) in fields {
            if let Some(value) = value {
                *field = value;
            }
        }
        preset.check()?;
        Ok(description)
    }
}

/// One sentence of a TOML error: the line, what it is, and for an unknown key the nearest known.
fn refusal(text: &str, error: &toml::de::Error) -> Error {
    let place = error.span().map_or_else(String::new, |span| {
        let line = text.get(..span.start).map_or(1, |before| before.matches('\n').count() + 1);
        format!("line {line}: ")
    });
    let message: String = error.message().lines().next().unwrap_or("not TOML").chars().take(300).collect();
    let unknown = message.strip_prefix("unknown field `").and_then(|rest| rest.split('`').next());
    match unknown {
        Some(key) => {
            let key: String = key.chars().take(40).collect();
            Error::input(format!("{place}there is no key '{key}'{}", did_you_mean(&key, KEYS)))
        }
        None => Error::input(format!("{place}{message}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_a_preset_with_changes() {
        let text = "preset = \"starling\"\nmaterial = \"starling:pink\"\n[light]\nazimuth = 77.0\n";
        let scene = Description::parse(text).unwrap();
        assert_eq!(scene.material, "starling:pink");
        assert_eq!(scene.preset.light.azimuth, 77.0);
        assert_eq!(scene.preset.view, preset::named("starling").unwrap().view);
        assert_eq!(Description::named("starling:pink").unwrap().preset.name, "starling");
    }

    #[test]
    fn bad_scenes_are_refused_in_a_sentence() {
        let message = |text: &str| Description::parse(text).unwrap_err().to_string();
        assert!(message("preset = \"starlign\"").contains("did you mean 'starling'"));
        assert!(
            message("preset = \"starling\"\nexposre = 1.0")
                .contains("line 2: there is no key 'exposre', did you mean 'exposure'")
        );
        assert!(message("preset = 3").contains("invalid type"));
        assert!(message("preset = \"starling\"\nexposure = -1.0").contains("must be"));
        assert!(message("preset = \"starling\"\n[light]\nelevation = 100.0").contains("elevation must be"));
        assert!(message("material = \"x\"").contains("preset"));
        assert!(message("preset = \"starling\"\nsky = 1.0\n[sky_image]\nfile = \"a.exr\"").contains("both"));
        assert!(
            message("preset = \"starling\"\n[sky_image]\nfiel = \"a.exr\"").contains("did you mean 'file'")
        );
        assert!(message("[[[").len() < 400);
    }
}
