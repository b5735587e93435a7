//! What shines from everywhere: a gradient or an image; and what is seen behind.

use super::MOST_TURN_DEG;
use super::colour::{Colour, parse_colour};
use super::slot::Slot;
use crate::error::{did_you_mean, shortened};
use crate::fields::{FieldValue, Fields, Key, Kind, Map, Record, Several, Text, Value, within};
use crate::identity::Hasher;
use crate::scene::backdrop::BackdropPicture;
use crate::scene::sky::Sky;
use crate::{Error, Result, record};

/// Radiance of a plain sky at the horizon and below over that at the zenith, where nothing is said.
const SKY_HORIZON: f64 = 0.35;
const SKY_BELOW: f64 = 0.02;

/// What shines from everywhere.
#[derive(Debug, Clone, PartialEq)]
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

record! {
    /// A sky from a file.
    #[derive(Debug, Clone, PartialEq)]
    pub struct SkyImage {
        /// Equirectangular EXR.
        file: Slot<Sky> = "file", Text("the name of an .exr or .hdr");
        /// Factor to the image's radiance.
        strength: f64 = "strength", within(0, 1e6), or 1.0;
        /// By how much it is turned clockwise seen from above.
        turn_deg: f64 = "turn_deg" | "turn", within(-MOST_TURN_DEG, MOST_TURN_DEG), or 0.0;
    }
}

record! {
    /// The sky's keys as files have them.
    #[derive(Debug, Clone, PartialEq)]
    struct SkyKeys {
        /// Radiance of a plain sky at the zenith.
        sky: Option<f64> = "sky", within(0, 1e4);
        /// Radiance at the horizon over that at the zenith.
        sky_horizon: f64 = "sky_horizon", within(0, 100), or SKY_HORIZON;
        /// Radiance below the horizon over that at the zenith.
        sky_below: f64 = "sky_below", within(0, 100), or SKY_BELOW;
        /// An image in place of a plain sky.
        sky_image: Option<SkyImage> = "sky_image", ();
    }
}

impl SkyDescription {
    fn of_keys(keys: SkyKeys) -> Result<Self> {
        match (keys.sky_image, keys.sky) {
            (Some(image), None) => Ok(Self::Image(image)),
            (None, Some(zenith)) => {
                Ok(Self::Gradient { zenith, horizon: keys.sky_horizon, below: keys.sky_below })
            }
            (None, None) => {
                Err(Error::input("sky is missing; give a number from 0 to 10000, or [sky_image]"))
            }
            (Some(_), Some(_)) => Err(Error::input("sky and [sky_image] are both given; leave one out")),
        }
    }

    fn keys_of(&self) -> SkyKeys {
        match self {
            Self::Gradient { zenith, horizon, below } => {
                SkyKeys { sky: Some(*zenith), sky_horizon: *horizon, sky_below: *below, sky_image: None }
            }
            Self::Image(image) => SkyKeys {
                sky: None,
                sky_horizon: SKY_HORIZON,
                sky_below: SKY_BELOW,
                sky_image: Some(image.clone()),
            },
        }
    }

    /// Whether nothing comes from it.
    #[must_use]
    pub fn is_dark(&self) -> bool {
        let strength = match self {
            Self::Gradient { zenith, .. } => *zenith,
            Self::Image(image) => image.strength,
        };
        strength <= 0.0
    }

    /// The key that makes it brighter.
    pub(super) fn strength_key(&self) -> &'static str {
        match self {
            Self::Gradient { .. } => "sky",
            Self::Image(_) => "sky_image.strength",
        }
    }
}

impl Record for SkyDescription {
    fn keys() -> Vec<Key> {
        SkyKeys::keys()
    }

    fn read_fields(fields: &Fields<'_>) -> Result<Self> {
        Self::of_keys(SkyKeys::read_fields(fields)?)
    }

    fn check_given(fields: &Fields<'_>) -> Result<()> {
        SkyKeys::check_given(fields)
    }

    fn write_into(&self, table: &mut Map<String, Value>) {
        self.keys_of().write_into(table);
    }

    fn check(&self, place: &str) -> Result<()> {
        Record::check(&self.keys_of(), place)
    }

    fn feed_fields(&self, to: &mut Hasher) {
        self.keys_of().feed_fields(to);
    }
}

/// What is seen behind everything.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Background {
    /// The sky and the lights at infinity.
    #[default]
    Sky,
    /// Nothing.
    None,
    /// A colour on the screen: sRGB, 0 … 1.
    Colour([f64; 3]),
    /// Colours on the screen from the upper edge to the lower one: sRGB, 0 … 1.
    Gradient(Vec<[f64; 3]>),
    /// A picture.
    Picture(Slot<BackdropPicture>),
}

/// Most colours of a gradient.
const MOST_COLOURS: usize = 16;

record! {
    /// The table `[background]`.
    #[derive(Debug, Clone, PartialEq)]
    struct BackgroundKeys {
        /// A colour on the screen.
        colour: Option<Colour> = "colour", ();
        /// Colours on the screen from the upper edge to the lower one.
        gradient: Vec<Colour> = "gradient", Several { least: 2, most: MOST_COLOURS, of: () }, or Vec::new();
        /// A picture.
        file: Option<Slot<BackdropPicture>> = "file", Text("the name of a .png, .exr or .hdr");
    }
}

impl BackgroundKeys {
    /// The gradient, if there is one.
    fn many(&self) -> Option<Background> {
        let colours: Vec<[f64; 3]> = self.gradient.iter().map(|Colour(colour)| *colour).collect();
        (!colours.is_empty()).then_some(Background::Gradient(colours))
    }
}

impl Background {
    /// A background as the command line has it: `sky`, `none`, `#rrggbb` or the name of a picture.
    ///
    /// # Errors
    /// A colour that is none, or a word that names no file.
    pub fn parse(text: &str) -> Result<Self> {
        match text {
            "sky" => Ok(Self::Sky),
            "none" => Ok(Self::None),
            _ if text.starts_with('#') => Ok(Self::Colour(parse_colour(text)?)),
            // Files that can be read have an ending.
            file if file.contains('.') => Ok(Self::Picture(Slot::new(file))),
            word => {
                let near = did_you_mean(word, ["sky", "none"]);
                let word = shortened(word);
                Err(Error::input(format!(
                    "'{word}' is no background{near}; give sky, none, a colour as in #808080, or a .png or .exr"
                )))
            }
        }
    }
}

impl FieldValue for Background {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        match value {
            Value::String(word) if word == "sky" || word == "none" => Self::parse(word),
            Value::String(word) => {
                let near = did_you_mean(word, ["sky", "none"]);
                let word = shortened(word);
                Err(Error::input(format!(
                    "{path} is '{word}'{near}; give \"sky\", \"none\", or the table [{path}] with colour, gradient or file"
                )))
            }
            table => {
                let keys = BackgroundKeys::read(table, path)?;
                let given = [
                    ("colour", keys.colour.map(|Colour(colour)| Self::Colour(colour))),
                    ("gradient", keys.many()),
                    ("file", keys.file.map(Self::Picture)),
                ];
                let mut given = given.into_iter().filter_map(|(key, one)| Some((key, one?)));
                match (given.next(), given.next()) {
                    (Some((_, background)), None) => Ok(background),
                    (Some((one, _)), Some((other, _))) => Err(Error::input(format!(
                        "{path}.{one} and {path}.{other} are both given; leave one out"
                    ))),
                    (None, _) => {
                        Err(Error::input(format!("[{path}] is empty; give colour, gradient or file")))
                    }
                }
            }
        }
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        let none = BackgroundKeys { colour: None, gradient: Vec::new(), file: None };
        match self {
            Self::Sky => None,
            Self::None => Some("none".into()),
            Self::Colour(colour) => Some(BackgroundKeys { colour: Some(Colour(*colour)), ..none }.table()),
            Self::Gradient(colours) => {
                let gradient = colours.iter().copied().map(Colour).collect();
                Some(BackgroundKeys { gradient, ..none }.table())
            }
            Self::Picture(file) => Some(BackgroundKeys { file: Some(file.clone()), ..none }.table()),
        }
    }

    fn check_value(&self, path: &str, (): &()) -> Result<()> {
        match self {
            Self::Colour(colour) => Colour(*colour).check_value(path, &()),
            Self::Gradient(colours) => {
                colours.iter().try_for_each(|colour| Colour(*colour).check_value(path, &()))
            }
            Self::Sky | Self::None | Self::Picture(_) => Ok(()),
        }
    }

    /// Only whether the sky is seen decides a picture's samples.
    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.count(key, u64::from(*self == Self::Sky));
    }

    fn kind((): &()) -> Kind {
        Kind::Either(vec![Kind::Word(vec!["sky", "none"]), Kind::Table(BackgroundKeys::keys())])
    }
}
