//! Scene files, in TOML: a whole scene, or a preset with changes.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{
    Background, Bearing, CoatDescription, Detail, KeyLight, SceneDescription, SkyDescription, Surfaces, View,
    ViewProjection, colour, lights, objects,
};
use crate::error::{did_you_mean, shortened};
use crate::fields::{Fields, at_span, in_toml};
use crate::scene::backdrop::Backdrop;
use crate::scene::feather::{self, Feather, VaneDisc};
use crate::scene::preset;
use crate::{Error, Result};

/// A sky from a file.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SkyImage {
    /// Equirectangular EXR, relative to the scene's folder.
    #[serde(skip_serializing)]
    pub file: String,
    /// Factor to the image's radiance.
    #[serde(default = "one")]
    pub strength: f64,
    /// By how much it is turned clockwise seen from above, degrees.
    #[serde(default, alias = "turn")]
    pub turn_deg: f64,
}

fn one() -> f64 {
    1.0
}

/// A table of a scene file whose keys may all be left out.
macro_rules! layer {
    ($name:ident { $($(#[$attribute:meta])* $field:ident: $kind:ty),* $(,)? }) => {
        #[derive(Debug, Default, Deserialize)]
        #[serde(deny_unknown_fields)]
        struct $name { $($(#[$attribute])* $field: Option<$kind>,)* }

        impl $name {
            /// These values, and the base's where there are none.
            fn over(self, base: Self) -> Self {
                Self { $($field: self.$field.or(base.$field),)* }
            }
        }
    };
}

layer!(LightLayer {
    #[serde(alias = "azimuth")]
    azimuth_deg: f64,
    #[serde(alias = "elevation")]
    elevation_deg: f64,
    #[serde(alias = "radius")]
    radius_deg: f64,
    strength: f64,
});

layer!(CameraLayer {
    #[serde(alias = "azimuth")]
    azimuth_deg: f64,
    #[serde(alias = "elevation")]
    elevation_deg: f64,
    #[serde(alias = "roll")]
    roll_deg: f64,
    width_mm: f64,
    lens: f64,
    projection: String,
    position_mm: [f64; 3],
    target_mm: [f64; 3],
    focal_length_mm: f64,
    focus_distance_mm: f64,
    f_number: f64,
});

layer!(WindowLayer { along_mm: f64, radius_mm: f64, whole: bool });

/// Radiance of a plain sky at the horizon and below over that at the zenith, where nothing is said.
const SKY_HORIZON: f64 = 0.35;
const SKY_BELOW: f64 = 0.02;

/// A factor, or a word: `"auto"` is by a key.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Exposure {
    Factor(f64),
    Word(String),
}

/// A scene file as it is written.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Layer {
    preset: Option<String>,
    material: Option<String>,
    size: Option<[u32; 2]>,
    exposure: Option<Exposure>,
    scatterings: Option<u32>,
    sky: Option<f64>,
    sky_horizon: Option<f64>,
    sky_below: Option<f64>,
    sky_image: Option<SkyImage>,
    background: Option<Value>,
    #[serde(alias = "turn")]
    turn_deg: Option<f64>,
    #[serde(default)]
    light: LightLayer,
    lights: Option<Value>,
    #[serde(default)]
    camera: CameraLayer,
    #[serde(default)]
    window: WindowLayer,
    detail: Option<Value>,
    surfaces: Option<Value>,
    feather: Option<Value>,
    shows_feather: Option<bool>,
    coat: Option<Value>,
    objects: Option<Value>,
}

/// Keys of a scene file, for suggestions; those of feathers and surfaces are known where they are read.
const KEYS: [&str; 47] = [
    "preset",
    "material",
    "size",
    "exposure",
    "scatterings",
    "sky",
    "sky_horizon",
    "sky_below",
    "sky_image",
    "background",
    "light",
    "lights",
    "camera",
    "projection",
    "position_mm",
    "target_mm",
    "focal_length_mm",
    "focus_distance_mm",
    "f_number",
    "window",
    "detail",
    "level",
    "view_model",
    "surfaces",
    "feather",
    "shows_feather",
    "coat",
    "objects",
    "azimuth",
    "azimuth_deg",
    "elevation",
    "elevation_deg",
    "radius",
    "radius_deg",
    "strength",
    "width_mm",
    "roll",
    "roll_deg",
    "lens",
    "light.radius",
    "camera.width_mm",
    "along_mm",
    "radius_mm",
    "whole",
    "file",
    "turn",
    "turn_deg",
];

impl SceneDescription {
    /// A preset by its name, or `SPECIES:VARIANT`: the species' preset with that variant's material.
    ///
    /// # Errors
    /// No such preset.
    pub fn named(name: &str) -> Result<Self> {
        let species = name.split_once(':').map_or(name, |(species, _)| species);
        let mut layer = Layer::of_preset(species)?;
        if name.contains(':') {
            layer.material = Some(name.to_owned());
        }
        layer.resolved()
    }

    /// A scene file's text.
    ///
    /// # Errors
    /// Not TOML, an unknown key, a value that is missing, of the wrong kind or out of range.
    pub fn parse(text: &str) -> Result<Self> {
        let own = Layer::parse(text)?;
        let base = own.preset.as_deref().map(Layer::of_preset).transpose()?;
        own.over(base.unwrap_or_default()).resolved().map_err(|error| in_toml(error, text))
    }
}

impl Layer {
    fn of_preset(name: &str) -> Result<Self> {
        let own = Self::parse(preset::toml(name)?)?;
        match own.preset.clone() {
            Some(base) => Ok(own.over(Self::of_preset(&base)?)),
            None => Ok(own),
        }
    }

    fn parse(text: &str) -> Result<Self> {
        let layer: Self = toml::from_str(text).map_err(|error| refusal(text, &error))?;
        if layer.sky.is_some() && layer.sky_image.is_some() {
            return Err(Error::input("sky and [sky_image] are both given; leave one out"));
        }
        Ok(layer)
    }

    /// These values, and the base's where there are none.
    fn over(self, base: Self) -> Self {
        let has_sky = self.sky.is_some() || self.sky_image.is_some();
        let (sky, sky_image) = if has_sky { (self.sky, self.sky_image) } else { (base.sky, base.sky_image) };
        Self {
            preset: self.preset,
            material: self.material.or(base.material),
            size: self.size.or(base.size),
            exposure: self.exposure.or(base.exposure),
            scatterings: self.scatterings.or(base.scatterings),
            sky,
            sky_horizon: self.sky_horizon.or(base.sky_horizon),
            sky_below: self.sky_below.or(base.sky_below),
            sky_image,
            background: self.background.or(base.background),
            turn_deg: self.turn_deg.or(base.turn_deg),
            light: self.light.over(base.light),
            lights: self.lights.or(base.lights),
            camera: self.camera.over(base.camera),
            window: self.window.over_extent(base.window),
            detail: merged(self.detail, base.detail),
            surfaces: merged(self.surfaces, base.surfaces),
            feather: feather::layered(self.feather, base.feather),
            shows_feather: self.shows_feather.or(base.shows_feather),
            coat: self.coat.or(base.coat),
            objects: self.objects.or(base.objects),
        }
    }

    /// The description, of which nothing may be missing.
    fn resolved(self) -> Result<SceneDescription> {
        let Self { light, camera, window, .. } = self;
        let sky = match (self.sky_image, self.sky) {
            (Some(image), _) => SkyDescription::Image(image),
            (None, sky) => SkyDescription::Gradient {
                zenith: need(sky, "sky")?,
                horizon: self.sky_horizon.unwrap_or(SKY_HORIZON),
                below: self.sky_below.unwrap_or(SKY_BELOW),
            },
        };
        let (surfaces, named_surfaces) = Surfaces::read(&need(self.surfaces, "surfaces")?)?;
        let description = SceneDescription {
            material: match self.material {
                // Barbules that are fibres need none.
                None if surfaces.barbule.is_some() => String::new(),
                material => need(material, "material")?,
            },
            size: self.size,
            exposure: match self.exposure {
                Some(Exposure::Factor(factor)) => Some(factor),
                Some(Exposure::Word(word)) if word != "auto" => {
                    let word = shortened(&word);
                    return Err(Error::input(format!("exposure is '{word}'; give a number or \"auto\"")));
                }
                Some(Exposure::Word(_)) | None => None,
            },
            scatterings: need(self.scatterings, "scatterings")?,
            sky,
            light: KeyLight {
                bearing: Bearing {
                    azimuth_deg: need(light.azimuth_deg, "light.azimuth_deg")?,
                    elevation_deg: need(light.elevation_deg, "light.elevation_deg")?,
                },
                radius_deg: need(light.radius_deg, "light.radius_deg")?,
                strength: need(light.strength, "light.strength")?,
            },
            lights: match &self.lights {
                Some(list) => lights::read(list)?,
                None => Vec::new(),
            },
            camera: camera.resolved()?,
            background: self.background.as_ref().map_or(Ok(Background::Sky), Background::read)?,
            turn_deg: self.turn_deg.unwrap_or(0.0),
            window: window.resolved()?,
            detail: self.detail.as_ref().map_or(Ok(Detail::default()), Detail::read)?,
            surfaces,
            feather: Feather::read(&need(self.feather, "feather")?)?,
            shows_feather: self.shows_feather.unwrap_or(true),
            coat: self.coat.as_ref().map(CoatDescription::read).transpose()?,
            objects: match &self.objects {
                Some(list) => objects::read(list, &named_surfaces)?,
                None => Vec::new(),
            },
            named_surfaces,
        };
        description.check()?;
        Ok(description)
    }
}

impl WindowLayer {
    /// These values, and the base's where there are none; how far it reaches is said by one of two keys.
    fn over_extent(self, mut base: Self) -> Self {
        if self.radius_mm.is_some() || self.whole.is_some() {
            base.radius_mm = base.radius_mm.filter(|_| self.whole == Some(false));
            base.whole = None;
        }
        self.over(base)
    }

    fn resolved(self) -> Result<VaneDisc> {
        let is_whole = self.whole == Some(true);
        if is_whole && self.radius_mm.is_some() {
            return Err(Error::input("window.whole and window.radius_mm are both given; leave one out"));
        }
        Ok(VaneDisc {
            along_mm: need(self.along_mm, "window.along_mm")?,
            radius_mm: if is_whole { None } else { Some(need(self.radius_mm, "window.radius_mm")?) },
        })
    }
}

impl CameraLayer {
    fn resolved(self) -> Result<View> {
        let projection = match self.projection {
            None => ViewProjection::Perspective,
            Some(name) => {
                let known = ViewProjection::ALL;
                let found = known.iter().find(|(known, _)| *known == name).map(|(_, projection)| *projection);
                found.ok_or_else(|| {
                    let near = did_you_mean(&name, known.map(|(known, _)| known));
                    let name = shortened(&name);
                    Error::input(format!(
                        "camera.projection is '{name}'{near}; give perspective or orthographic"
                    ))
                })?
            }
        };
        Ok(View {
            bearing: Bearing {
                azimuth_deg: need(self.azimuth_deg, "camera.azimuth_deg")?,
                elevation_deg: need(self.elevation_deg, "camera.elevation_deg")?,
            },
            position: self.position_mm,
            target: self.target_mm.unwrap_or_default(),
            projection,
            focal_length_mm: self.focal_length_mm,
            focus_distance_mm: self.focus_distance_mm,
            f_number: self.f_number,
            roll_deg: need(self.roll_deg, "camera.roll_deg")?,
            width_mm: need(self.width_mm, "camera.width_mm")?,
            lens: need(self.lens, "camera.lens")?,
        })
    }
}

impl Background {
    /// A background as the command line has it: `sky`, `none`, `#rrggbb` or the name of a picture.
    ///
    /// # Errors
    /// A colour that is none.
    pub fn parse(text: &str) -> Result<Self> {
        match text {
            "sky" => Ok(Self::Sky),
            "none" => Ok(Self::None),
            _ if text.starts_with('#') => Ok(Self::Colour(colour::parse_colour(text)?)),
            file => Ok(Self::Picture { file: file.to_owned(), picture: Backdrop::None }),
        }
    }

    /// Reads `background = "sky"`, `"none"`, or a table with `colour` or `file`.
    fn read(value: &Value) -> Result<Self> {
        match value {
            Value::String(word) if word == "sky" || word == "none" => Self::parse(word),
            Value::String(word) => {
                let near = did_you_mean(word, ["sky", "none"]);
                let word = shortened(word);
                Err(Error::input(format!(
                    "background is '{word}'{near}; give \"sky\", \"none\", or the table [background] with colour or file"
                )))
            }
            table => {
                let fields = Fields::new(table, "background", &["colour", "file"])?;
                match (fields.get("colour"), fields.text("file")?) {
                    (Some(value), None) => Ok(Self::Colour(colour::colour(value, "background.colour")?)),
                    (None, Some(file)) => {
                        Ok(Self::Picture { file: file.to_owned(), picture: Backdrop::None })
                    }
                    (Some(_), Some(_)) => Err(Error::input(
                        "background.colour and background.file are both given; leave one out",
                    )),
                    (None, None) => Err(Error::input("[background] is empty; give colour or file")),
                }
            }
        }
    }
}

fn need<T>(value: Option<T>, key: &str) -> Result<T> {
    value.ok_or_else(|| {
        Error::input(format!("{key} is missing; give it, or preset = \"starling\" to change a preset"))
    })
}

/// A table with the keys of both; where both have one that is no table, this one's value holds.
fn merged(own: Option<Value>, base: Option<Value>) -> Option<Value> {
    match (own, base) {
        (Some(Value::Object(own)), Some(Value::Object(mut base))) => {
            for (key, value) in own {
                let both = merged(Some(value), base.remove(&key));
                base.extend(both.map(|value| (key, value)));
            }
            Some(Value::Object(base))
        }
        (own, base) => own.or(base),
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
    let refusal = match unknown {
        Some(key) => {
            let key: String = key.chars().take(40).collect();
            Error::input(format!("{place}there is no key '{key}'{}", did_you_mean(&key, KEYS)))
        }
        None => Error::input(format!("{place}{message}")),
    };
    at_span(refusal, text, error.span())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identity::hash;

    #[test]
    fn a_scene_is_a_preset_with_changes() {
        let text = "preset = \"starling\"\nmaterial = \"starling:pink\"\n[light]\nazimuth = 77.0\n";
        let scene = SceneDescription::parse(text).unwrap();
        let starling = SceneDescription::named("starling").unwrap();
        assert_eq!(scene.material, "starling:pink");
        assert_eq!(scene.light.bearing.azimuth_deg, 77.0);
        assert_eq!((scene.camera, scene.feather), (starling.camera, starling.feather));
        let identity = |scene: &SceneDescription| hash("scene", scene);
        assert_eq!(identity(&SceneDescription::named("starling:pink").unwrap()), identity(&starling));
        assert_ne!(identity(&scene), identity(&starling));
        let other = SceneDescription::parse("preset = \"starling\"\n[light]\nazimuth_deg = 77.0").unwrap();
        assert_eq!(identity(&other), identity(&scene));
    }

    #[test]
    fn whatever_a_preset_sets_a_scene_can_set() {
        for name in preset::names() {
            let text = preset::toml(name).unwrap();
            assert_eq!(SceneDescription::parse(text).unwrap(), SceneDescription::named(name).unwrap());
            if text.contains("preset =") {
                continue;
            }
            let other = if name == "magpie" { "mallard" } else { "magpie" };
            let changed = SceneDescription::parse(&format!("preset = \"{other}\"\n{text}")).unwrap();
            // Keys that a preset leaves out are those of the proximal barbules.
            assert_eq!(changed.feather.distal, SceneDescription::named(name).unwrap().feather.distal);
        }
        let text = "preset = \"magpie\"\n[feather.proximal]\ntilt_deg = 5.0\n[surfaces.ramus]\nmelanin = 0.5\n\
                    [window]\nradius_mm = 1.0\n";
        let (scene, magpie) =
            (SceneDescription::parse(text).unwrap(), SceneDescription::named("magpie").unwrap());
        assert_eq!(scene.feather.proximal.tilt, 5.0_f64.to_radians());
        assert_eq!(scene.feather.proximal.base_lift, magpie.feather.proximal.base_lift);
        assert_eq!(scene.feather.distal, magpie.feather.distal);
        assert_eq!((scene.surfaces.ramus.melanin, scene.surfaces.ramus.index), (0.5, 1.56));
        assert_eq!((scene.window.radius_mm, scene.window.along_mm), (Some(1.0), 150.0));
    }

    /// Rami of hair are a further table; without it a scene is the one that it was before there was hair.
    #[test]
    fn rami_may_be_fibres_of_hair() {
        let text = "preset = \"rock-dove\"\n[surfaces.hair]\nlongitudinal_roughness = 0.25\nazimuthal_roughness = 0.3\n\
                    eumelanin = 0.6\npheomelanin = 0.1\nindex = 1.55\nheight_over_width = 2.5\n";
        let scene = SceneDescription::parse(text).unwrap();
        let hair = scene.surfaces.hair.unwrap();
        assert_eq!((hair.longitudinal_roughness, hair.azimuthal_roughness), (0.25, 0.3));
        assert_eq!(
            (hair.eumelanin, hair.pheomelanin, hair.index, hair.scale_tilt_deg),
            (0.6, 0.1, Some(1.55), 0.0)
        );
        assert_eq!(hair.height_over_width, 2.5);
        let bare = SceneDescription::named("rock-dove").unwrap();
        assert!(bare.surfaces.hair.is_none() && !serde_json::to_string(&bare).unwrap().contains("hair"));
        assert_ne!(hash("scene", &scene), hash("scene", &bare));
        let message = |text: &str| {
            let text = format!("preset = \"rock-dove\"\n[surfaces.hair]\n{text}");
            SceneDescription::parse(&text).unwrap_err().to_string()
        };
        assert!(message("eumelanine = 1").contains("did you mean 'eumelanin'"));
        assert!(message("index = 1.0").contains("surfaces.hair.index"));
        assert!(message("azimuthal_roughness = 0").contains("surfaces.hair.azimuthal_roughness"));
        assert!(message("height_over_width = 20").contains("surfaces.hair.height_over_width is 20"));
    }

    #[test]
    fn a_whole_feather_takes_the_place_of_a_radius() {
        let window = |text: &str| {
            SceneDescription::parse(&format!("preset = 'starling'\n[window]\n{text}"))
                .map(|scene| scene.window)
        };
        assert_eq!(window("whole = true").unwrap().radius_mm, None);
        assert_eq!(window("whole = false").unwrap(), SceneDescription::named("starling").unwrap().window);
        assert_eq!(window("whole = false\nradius_mm = 2").unwrap().radius_mm, Some(2.0));
        let both = window("whole = true\nradius_mm = 2").unwrap_err().to_string();
        assert_eq!(both, "window.whole and window.radius_mm are both given; leave one out");
    }

    #[test]
    fn bad_scenes_are_refused_in_a_sentence() {
        let message = |text: &str| SceneDescription::parse(text).unwrap_err().to_string();
        let starling = |text: &str| message(&format!("preset = \"starling\"\n{text}"));
        assert!(message("preset = \"starlign\"").contains("did you mean 'starling'"));
        assert!(
            starling("exposre = 1.0").contains("line 2: there is no key 'exposre', did you mean 'exposure'")
        );
        assert!(message("preset = 3").contains("invalid type"));
        assert!(starling("exposure = -1.0").contains("exposure is -1, outside 0.000001 to 1000000"));
        assert!(
            starling("[light]\nelevation = 100.0").contains("light.elevation_deg is 100, outside -90 to 90")
        );
        assert!(starling("[light]\nelevation = 10.0\nelevation_deg = 20.0").contains("duplicate"));
        assert!(message("material = \"x\"").contains("preset"));
        assert!(starling("sky = 1.0\n[sky_image]\nfile = \"a.exr\"").contains("both"));
        assert!(starling("[sky_image]\nfiel = \"a.exr\"").contains("did you mean 'file'"));
        assert!(starling("[feather.distal]\nlenght_um = 3").contains("did you mean 'length_um'"));
        let range = "feather.distal.length_um is 0, outside 5 to 10000";
        assert!(starling("[feather.distal]\nlength_um = 0").contains(range));
        assert!(starling("[feather]\ndistal = 3").contains("feather.distal is the number 3"));
        assert!(starling("[surfaces.shaft]\nroughness = nan").contains("surfaces.shaft.roughness"));
        assert!(starling("[window]\nradius_mm = 0.0").contains("window.radius_mm is 0, outside 0.01 to 500"));
        assert!(starling("scatterings = 0").contains("scatterings is 0, outside 1 to 1000"));
        assert!(starling("[light]\nazimuth = 1e17").contains("light.azimuth_deg is 1"));
        let turned = "[sky_image]\nfile = \"a.exr\"\nturn = -1e17";
        assert!(starling(turned).contains("outside -3600 to 3600"));
        assert!(
            starling("sky = 0\nlights = []\n[light]\nstrength = 0")
                .contains("sky and light.strength are both 0")
        );
        let dark = "lights = []\n[sky_image]\nfile = \"a.exr\"\nstrength = 0\n[light]\nstrength = 0";
        assert!(starling(dark).contains("sky_image.strength and light.strength are both 0"));
        assert!(message("[[[").len() < 400);
    }
}
