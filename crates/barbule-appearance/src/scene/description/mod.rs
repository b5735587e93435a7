//! What a scene file says: feathers, coats and other objects with their dress, lights, a sky, a camera and what is seen behind.
//!
//! Every table is a record whose keys are defined once, where its type is (`fields::record`). Presets are such files, which a user's
//! file may change (`docs/guide/render.md`). As in files, angles are degrees here.

mod albedo;
mod barbules;
mod build;
mod coat;
mod colour;
mod detail;
mod develop;
mod dress;
mod file;
mod files;
mod form;
mod ground;
mod lights;
mod memory;
mod objects;
mod parts;
mod row;
mod sequence;
mod shapes;
mod sides;
mod sky;
mod slot;
mod surfaces;
mod view;

pub use barbules::{BarbuleClothing, LowerSide, Under};
pub use coat::{BareDescription, CoatDescription, CoatFeather, CoatObject, GuideDescription};
pub use colour::{Colour, parse_colour};
pub use detail::{Detail, DetailLevel, ViewModel};
pub use develop::{ToldLamp, Tone, ToneWord, WhiteBalance};
pub use dress::{BarbuleDress, Dress, FeatherObject, RamusDress, Ring, Zone};
pub use file::scene_keys;
pub use files::{Named, ReadyScene};
pub use form::{FormDescription, PartDescription};
pub use lights::{KeyLight, LightColour, LightDescription, LightShape};
pub use memory::{Foreseen, Holds};
pub use objects::{ObjectDescription, ObjectShape, Placement, SnakeShape};
pub use row::{RowDescription, RowFeather, RowObject, StationDescription};
pub use sequence::{Motion, Moved, USUAL_ARC_DEG, Waypoint};
pub use sides::Remark;
pub use sky::{Background, SkyDescription, SkyImage};
pub use slot::Slot;
pub use surfaces::{
    Diffuse, FibreDescription, FilmDescription, Glass, GratingDescription, MeasuredFile, Metal, NamedSurface,
    PigmentedKeratin, RoughMetal, Surfaces, SurfacesByPlace,
};
pub use view::{Up, View, ViewProjection};

use self::lights::MOST_LIGHTS;
use self::objects::MOST_OBJECTS;
use crate::fields::{FieldValue, Kind, Record, Value, up_to, within};
use crate::identity::{Hasher, Identify};
use crate::scene::feather::Feather;
use crate::{Error, Result, record};

/// Azimuths and turns are at most this many degrees, ten turns: far beyond, digits are lost.
const MOST_TURN_DEG: f64 = 3600.0;

record! {
    /// A picture to be rendered. What it names is read by whoever opens it; see [`ReadyScene`].
    #[derive(Debug, Clone, PartialEq)]
    pub struct SceneDescription {
        /// Width and height in pixels.
        size: Option<[u32; 2]> = "size", within(1, 16384);
        /// Factor from radiance to the picture's linear values, or "auto": so that its middle is that of a grey card and highlights keep their
        /// colours, with stops more or less as in "auto-1.5".
        exposure: Exposure = "exposure", (), or Exposure::AUTO;
        /// The curve from linear values to the screen's.
        tone: Tone = "tone", (), or Tone::default();
        /// Which light looks white: none for daylight, auto for that of lamps and sky together, or a colour temperature in K.
        white_balance: WhiteBalance = "white_balance", (), or WhiteBalance::None;
        /// Most scatterings of a light path.
        scatterings: u32 = "scatterings", within(1, 1000), or 5;
        /// By how much the objects are turned about the picture's upward direction, counter-clockwise seen from above.
        turn_deg: f64 = "turn_deg" | "turn", within(-MOST_TURN_DEG, MOST_TURN_DEG), or 0.0;
        /// What is seen behind everything.
        background: Background = "background", (), or Background::Sky;
        /// The key light, a disc at infinity in daylight.
        light: KeyLight = "light", (), or KeyLight::OFF;
        /// Lamps beside it.
        lights: Vec<LightDescription> = "lights", up_to(MOST_LIGHTS), or Vec::new();
        /// Where the camera stands.
        camera: View = "camera", ();
        /// What things are made of, by names.
        surfaces: Surfaces = "surfaces", (), or Surfaces::default();
        /// What stands in the scene.
        objects: Vec<ObjectDescription> = "objects", up_to(MOST_OBJECTS), or Vec::new();
        @flat {
            /// What shines from everywhere.
            sky: SkyDescription;
        }
        @agree SceneDescription::agree;
    }
}

record! {
    /// An azimuth and elevation over the plane z = 0, a feather's vane: azimuth from +y, the shaft's tip, clockwise seen from +z, the
    /// camera's side.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Bearing {
        /// Azimuth, from the shaft's tip clockwise.
        azimuth_deg: f64 = "azimuth_deg" | "azimuth", within(-MOST_TURN_DEG, MOST_TURN_DEG);
        /// Elevation over the vane.
        elevation_deg: f64 = "elevation_deg" | "elevation", within(-90, 90);
    }
}

/// How radiance becomes a picture's values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Exposure {
    /// By what the picture shows.
    Auto {
        /// So many times 2 brighter than that.
        stops: f64,
    },
    /// By this factor.
    Factor(f64),
}

impl Exposure {
    /// By what the picture shows alone.
    pub const AUTO: Self = Self::Auto { stops: 0.0 };
    const RANGE: [f64; 2] = [1e-6, 1e6];
    /// Most stops to either side.
    pub const MOST_STOPS: f64 = 20.0;
    /// What `auto` takes, for messages.
    const WORDS: &str = "\"auto\", with stops as in \"auto-1.5\"";

    /// The factor, where there is one.
    #[must_use]
    pub fn factor(self) -> Option<f64> {
        match self {
            Self::Auto { .. } => None,
            Self::Factor(factor) => Some(factor),
        }
    }

    /// The factor, where a picture by itself has the factor that `automatic` says.
    #[must_use]
    pub fn or_by(self, automatic: impl FnOnce() -> f64) -> f64 {
        let [low, high] = Self::RANGE;
        match self {
            Self::Auto { stops } => (automatic() * libm::exp2(stops)).clamp(low, high),
            Self::Factor(factor) => factor,
        }
    }

    /// The same by so many stops brighter; a factor stays in its range.
    #[must_use]
    pub fn brighter(self, by: f64) -> Self {
        let [low, high] = Self::RANGE;
        match self {
            Self::Auto { stops } => Self::Auto { stops: stops + by },
            Self::Factor(factor) => Self::Factor((factor * libm::exp2(by)).clamp(low, high)),
        }
    }

    /// `auto`, `auto-1.5` or `auto+1`; nothing if it is none of them.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        match word.strip_prefix("auto")? {
            "" => Some(Self::AUTO),
            stops => Self::stops(stops).map(|stops| Self::Auto { stops }),
        }
    }

    /// Stops with their sign, as in `+1` or `-1.5`.
    #[must_use]
    pub fn stops(text: &str) -> Option<f64> {
        let stops = text.starts_with(['+', '-']).then(|| text.parse::<f64>().ok()).flatten()?;
        (stops.abs() <= Self::MOST_STOPS).then_some(stops)
    }
}

impl FieldValue for Exposure {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        let [low, high] = Self::RANGE;
        match value {
            Value::String(word) => Self::of_word(word).ok_or_else(|| {
                let word = crate::error::shortened(word);
                Error::input(format!("{path} is '{word}'; give a number or {}", Self::WORDS))
            }),
            other => f64::of_value(other, path, &within(low, high)).map(Self::Factor),
        }
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        Some(match self {
            Self::Factor(factor) => Value::from(*factor),
            Self::Auto { stops: 0.0 } => "auto".into(),
            Self::Auto { stops } => format!("auto{stops:+}").into(),
        })
    }

    fn check_value(&self, path: &str, (): &()) -> Result<()> {
        let [low, high] = Self::RANGE;
        if let Self::Auto { stops } = self
            && (stops.is_nan() || stops.abs() > Self::MOST_STOPS)
        {
            return Err(Error::input(format!("{path} is auto by {stops} stops; give -20 to 20")));
        }
        self.factor().check_value(path, &within(low, high))
    }

    /// It decides nothing about a picture's samples.
    fn feed_value(&self, _: &str, _: &mut Hasher) {}

    fn kind((): &()) -> Kind {
        let [low, high] = Self::RANGE;
        Kind::Either(vec![Kind::Number { low, high, whole: false }, Kind::Text(Self::WORDS)])
    }
}

impl Identify for SceneDescription {
    /// Everything that decides a picture's samples, but for its seed: the same for the same scene, however it was put together. Its size
    /// is fed too, which whoever keeps samples asks for anyway.
    fn feed(&self, to: &mut Hasher) {
        self.feed_fields(to);
    }
}

impl SceneDescription {
    /// Refuses numbers that make no picture.
    ///
    /// # Errors
    /// The first number out of range.
    pub fn check(&self) -> Result<()> {
        Record::check(self, "")?;
        self.frame_of("camera.about", self.camera.about.as_deref()).map(|_| ())
    }

    /// Refuses darkness, and names of surfaces and objects that do not exist.
    fn agree(&self, _place: &str) -> Result<()> {
        let is_lamp_on = self.lights.iter().any(|light| light.strength > 0.0);
        if self.light.strength <= 0.0 && self.sky.is_dark() && !is_lamp_on {
            return Err(Error::input(format!(
                "{} and light.strength are both 0, so nothing shines; give one of them more than 0",
                self.sky.strength_key()
            )));
        }
        let places = self.object_places();
        self.objects.iter().zip(&places).try_for_each(|(object, at)| object.check_surface(at, &self.surfaces))
    }

    /// Where a scene file says each object: at its top (which has no path), or in one of its tables.
    fn object_places(&self) -> Vec<String> {
        let lone = usize::from(self.objects.first().is_some_and(ObjectDescription::stands_at_top));
        let place = |i: usize| if i < lone { String::new() } else { format!("objects[{}]", i - lone) };
        (0..self.objects.len()).map(place).collect()
    }

    /// The first feather, or that of the first coat or row.
    #[must_use]
    pub fn feather(&self) -> Option<&Feather> {
        self.objects.iter().find_map(|object| match &object.shape {
            ObjectShape::Feather(of) => Some(&of.feather),
            ObjectShape::Coat(of) => Some(&of.feather),
            ObjectShape::Row(of) => Some(&of.first.feather),
            _ => None,
        })
    }

    /// The first feather that stands alone.
    #[must_use]
    pub fn lone_feather(&self) -> Option<&FeatherObject> {
        self.objects.iter().find_map(|object| match &object.shape {
            ObjectShape::Feather(of) => Some(&**of),
            _ => None,
        })
    }

    /// The same, to be changed.
    pub fn lone_feather_mut(&mut self) -> Option<&mut FeatherObject> {
        self.objects.iter_mut().find_map(|object| match &mut object.shape {
            ObjectShape::Feather(of) => Some(&mut **of),
            _ => None,
        })
    }

    /// The dress of the first feather or coat.
    pub fn dress_mut(&mut self) -> Option<&mut Dress> {
        self.objects.iter_mut().find_map(|object| match &mut object.shape {
            ObjectShape::Feather(of) => Some(&mut of.dress),
            ObjectShape::Coat(of) => Some(&mut of.dress),
            ObjectShape::Row(of) => Some(&mut of.first.dress),
            _ => None,
        })
    }

    /// How barbs of the first feather or coat are seen, to be changed.
    pub fn detail_mut(&mut self) -> Option<&mut Detail> {
        self.objects.iter_mut().find_map(|object| match &mut object.shape {
            ObjectShape::Feather(of) => Some(&mut of.detail),
            ObjectShape::Coat(of) => Some(&mut of.detail),
            ObjectShape::Row(of) => Some(&mut of.detail),
            _ => None,
        })
    }

    /// The name of the material of the first feather's or coat's barbules, where they wear one.
    #[must_use]
    pub fn material(&self) -> Option<&str> {
        self.objects.iter().find_map(|object| match &object.shape {
            ObjectShape::Feather(of) => of.dress.material(),
            ObjectShape::Coat(of) => of.dress.material(),
            ObjectShape::Row(of) => of.first.dress.material(),
            _ => None,
        })
    }

    /// Puts another material on the first feather's or coat's barbules, where they wear one.
    pub fn set_material(&mut self, name: &str) {
        self.clothing_mut().for_each(|of| of.material = Slot::new(name));
    }

    /// Puts something else on the lower sides of the first feather's or coat's barbules, where they wear a material.
    pub fn set_under(&mut self, under: &Under) {
        self.clothing_mut().for_each(|of| of.under = under.clone());
    }

    fn clothing_mut(&mut self) -> impl Iterator<Item = &mut BarbuleClothing> {
        self.dress_mut().into_iter().flat_map(Dress::clothing_mut)
    }

    /// Takes the ground away from beneath a lone feather that the camera looks up at: it would see nothing else.
    pub fn uncover(&mut self) {
        if self.lone_feather().is_some() && self.camera.bearing.elevation_deg < 0.0 {
            self.leave_ground();
        }
    }

    /// Whether the key light shines from behind the vane of a lone feather, as the camera sees it.
    #[must_use]
    pub fn is_lit_from_behind(&self) -> bool {
        self.lone_feather().is_some()
            && self.light.strength > 0.0
            && self.light.bearing.elevation_deg * self.camera.bearing.elevation_deg.signum() <= 0.0
    }
}
