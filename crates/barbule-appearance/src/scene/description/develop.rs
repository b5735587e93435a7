//! How light becomes a picture's values: tone, and the white that looks white.

use std::fmt;

use super::ReadyScene;
use super::lights::LightColour;
use super::sky::SkyDescription;
use crate::error::shortened;
use crate::fields::{FieldValue, Kind, Value, within};
use crate::identity::Hasher;
use crate::scene::emission::Emission;
use crate::spectrum::temperature::{WHITES_K, balance, correlated_temperature_k, white_of_temperature};
use crate::{Error, Result, words};

words! {
    /// The curve from linear light to what a screen shows.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum ToneWord {
        /// As it is up to 0.6, with a shoulder above.
        #[default]
        "plain": Plain,
        /// Of film: more contrast in the middle, six stops over it, highlights that turn white at their hue.
        "filmic": Filmic,
    }
}

/// As a scene has it: [`ToneWord`], which decides nothing about a picture's samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tone(pub ToneWord);

impl FieldValue for Tone {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        ToneWord::of_value(value, path, &()).map(Self)
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        Some(self.0.word().into())
    }

    fn check_value(&self, _: &str, (): &()) -> Result<()> {
        Ok(())
    }

    fn feed_value(&self, _: &str, _: &mut Hasher) {}

    fn kind((): &()) -> Kind {
        ToneWord::kind(&())
    }
}

/// Which light looks white.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum WhiteBalance {
    /// Daylight, D65, as it is.
    #[default]
    None,
    /// That of the scene's lamps and sky together.
    Auto,
    /// That of a temperature, K.
    Kelvin(f64),
}

impl WhiteBalance {
    /// What it takes, for messages.
    const WORDS: &str = "\"auto\" or \"none\"";

    /// `auto`, `none` or a temperature in K.
    ///
    /// # Errors
    /// None of these.
    pub fn parse(text: &str) -> Result<Self> {
        match text {
            "auto" => Ok(Self::Auto),
            "none" => Ok(Self::None),
            other => match other.trim_end_matches(['k', 'K']).trim_end().parse::<f64>() {
                Ok(kelvin) if (WHITES_K[0]..=WHITES_K[1]).contains(&kelvin) => Ok(Self::Kelvin(kelvin)),
                _ => Err(Error::input(format!(
                    "'{}' is no white; give auto, none, or a colour temperature from {} to {} K",
                    shortened(other),
                    WHITES_K[0],
                    WHITES_K[1]
                ))),
            },
        }
    }

    /// The matrix of linear sRGB of a scene, if it is to be balanced.
    ///
    /// # Errors
    /// As [`ReadyScene::white`].
    pub fn matrix(self, scene: &ReadyScene) -> Result<Option<[[f64; 3]; 3]>> {
        match self {
            Self::None => Ok(None),
            Self::Auto => scene.white().map(|white| Some(balance(white))),
            Self::Kelvin(kelvin) => white_of_temperature(kelvin).map(|white| Some(balance(white))),
        }
    }
}

impl fmt::Display for WhiteBalance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Auto => f.write_str("auto"),
            Self::Kelvin(kelvin) => write!(f, "{kelvin} K"),
        }
    }
}

impl FieldValue for WhiteBalance {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        match value {
            Value::String(word) => Self::parse(word).map_err(|error| error.at(path)),
            other => f64::of_value(other, path, &within(WHITES_K[0], WHITES_K[1])).map(Self::Kelvin),
        }
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        match self {
            Self::None => Some("none".into()),
            Self::Auto => Some("auto".into()),
            Self::Kelvin(kelvin) => Some(Value::from(*kelvin)),
        }
    }

    fn check_value(&self, path: &str, (): &()) -> Result<()> {
        match self {
            Self::None | Self::Auto => Ok(()),
            Self::Kelvin(kelvin) => kelvin.check_value(path, &within(WHITES_K[0], WHITES_K[1])),
        }
    }

    /// It decides nothing about a picture's samples.
    fn feed_value(&self, _: &str, _: &mut Hasher) {}

    fn kind((): &()) -> Kind {
        let [low, high] = WHITES_K;
        Kind::Either(vec![Kind::Number { low, high, whole: false }, Kind::Text(Self::WORDS)])
    }
}

/// A light of a scene, as pictures say it.
#[derive(Debug, Clone, PartialEq)]
pub struct ToldLamp {
    /// The key that says it: `light`, `lights[0]`, `sky` or `sky_image`.
    pub name: String,
    /// What colour it was given: an illuminant of the CIE, `sRGB #ff8000`, a file, or `image`.
    pub illuminant: String,
    /// Its correlated colour temperature, K; none of a light that is no shade of white.
    pub cct_k: Option<f64>,
    /// X, Y, Z of what a surface that faces it (of a sky, one in the vane's plane) gets; daylight of strength 1 has sRGB's white.
    xyz: [f64; 3],
}

impl ToldLamp {
    fn new(name: String, illuminant: String, xyz: [f64; 3]) -> Self {
        Self { name, illuminant, cct_k: correlated_temperature_k(xyz), xyz }
    }
}

impl ReadyScene {
    /// The lights that shine, with their colour temperatures: key light, lamps, sky.
    ///
    /// # Errors
    /// A spectrum or an image that is not read, or that the eye sees nothing of.
    pub fn told_lamps(&self) -> Result<Vec<ToldLamp>> {
        let mut told = Vec::new();
        let daylight = Emission::daylight();
        if self.light.strength > 0.0 {
            let xyz = daylight.pictured().map(|value| value * self.light.strength);
            told.push(ToldLamp::new("light".to_owned(), "D65".to_owned(), xyz));
        }
        for (index, light) in self.lights.iter().enumerate().filter(|(_, light)| light.strength > 0.0) {
            let name = format!("lights[{index}]");
            let emission = light.colour.emission().map_err(|error| error.at(&name))?;
            let xyz = emission.pictured().map(|value| value * light.strength);
            told.push(ToldLamp::new(name, light.colour.words(), xyz));
        }
        if let Some(environment) = self.environment()? {
            let (name, illuminant) = match &self.sky {
                SkyDescription::Gradient { .. } => ("sky", "D65"),
                SkyDescription::Image(_) => ("sky_image", "image"),
            };
            let sky = environment.sky;
            let basis: Vec<[f64; 3]> = sky.basis().iter().map(Emission::pictured).collect();
            let mut xyz = [0.0; 3];
            for (weight, spectrum) in sky.irradiance().iter().zip(&basis) {
                for (sum, value) in xyz.iter_mut().zip(spectrum) {
                    *sum += weight * value;
                }
            }
            if xyz[1] > 0.0 {
                told.push(ToldLamp::new(name.to_owned(), illuminant.to_owned(), xyz));
            }
        }
        Ok(told)
    }

    /// X, Y, Z (Y = 1) of all lights together, each by the illuminance that a surface facing it gets, the sky by that in the vane's plane: what
    /// a white card shows that is turned about.
    ///
    /// # Errors
    /// As [`ReadyScene::told_lamps`], or nothing shines from above.
    pub fn white(&self) -> Result<[f64; 3]> {
        let sum = self
            .told_lamps()?
            .iter()
            .fold([0.0; 3], |sum: [f64; 3], lamp| std::array::from_fn(|c| sum[c] + lamp.xyz[c]));
        if sum[1] > 0.0 {
            return Ok(sum.map(|value| value / sum[1]));
        }
        Err(Error::input(
            "white_balance: nothing shines from above, so there is no white; give a temperature in K",
        ))
    }
}

impl LightColour {
    /// What it was given as.
    fn words(&self) -> String {
        match self {
            Self::Illuminant(name) => (*name).to_owned(),
            Self::Rgb(rgb) => {
                let [r, g, b] = rgb.map(|value| (255.0 * value).round() as u8);
                format!("sRGB #{r:02x}{g:02x}{b:02x}")
            }
            Self::Table(slot) => shortened(&slot.name).to_owned(),
            Self::Glassner([r, g, b]) => format!("Glassner's R, G, B {r}, {g}, {b}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::description::SceneDescription;

    fn scene(text: &str) -> SceneDescription {
        let camera = "[camera]\nazimuth_deg = 180\nelevation_deg = 80\nwidth_mm = 10\n";
        SceneDescription::parse(&format!("shows_feather = false\n{text}\n{camera}")).unwrap()
    }

    #[test]
    fn lamps_tell_their_temperatures() {
        let text = "sky = 0.5\n[light]\nazimuth_deg = 0\nelevation_deg = 45\nradius_deg = 2\nstrength = 1\n[[lights]]\ntype = 'sun'\n\
                    azimuth_deg = 0\nelevation_deg = 45\nstrength = 3\nilluminant = 'A'\n[[lights]]\ntype = 'sun'\nazimuth_deg = 0\n\
                    elevation_deg = 45\nstrength = 0.1\ncolour = '#00ff00'";
        let told = ReadyScene::new(scene(text)).unwrap().told_lamps().unwrap();
        let names: Vec<&str> = told.iter().map(|lamp| lamp.name.as_str()).collect();
        assert_eq!(names, ["light", "lights[0]", "lights[1]", "sky"]);
        let illuminants: Vec<&str> = told.iter().map(|lamp| lamp.illuminant.as_str()).collect();
        assert_eq!(illuminants, ["D65", "A", "sRGB #00ff00", "D65"]);
        let cct: Vec<Option<f64>> = told.iter().map(|lamp| lamp.cct_k.map(f64::round)).collect();
        // The tables end at 720 nm for pictures, which the eye hardly sees.
        assert!(
            (cct[0].unwrap() - 6504.0).abs() < 10.0 && (cct[1].unwrap() - 2856.0).abs() < 10.0,
            "{cct:?}"
        );
        assert_eq!((cct[2], cct[3]), (None, cct[0]));
        // By strengths: a plain sky of radiance 0.5 lights the plane with 0.5 (0.35 + 0.65 · 2/3).
        assert!((told[3].xyz[1] - 0.5 * (0.35 + 0.65 * 2.0 / 3.0)).abs() < 2e-3, "{:?}", told[3]);
        assert!((told[1].xyz[1] - 3.0).abs() < 1e-9);
    }

    #[test]
    fn balances_are_read_and_refused() {
        assert_eq!(WhiteBalance::parse("auto").unwrap(), WhiteBalance::Auto);
        assert_eq!(WhiteBalance::parse("3200K").unwrap(), WhiteBalance::Kelvin(3200.0));
        for bad in ["warm", "900", "nan", "3200 mired"] {
            assert!(WhiteBalance::parse(bad).unwrap_err().to_string().contains("give auto, none"), "{bad}");
        }
        let text = "white_balance = 3200\ntone = 'filmic'\nsky = 1.0";
        let read = scene(text);
        assert_eq!((read.white_balance, read.tone), (WhiteBalance::Kelvin(3200.0), Tone(ToneWord::Filmic)));
        let again = SceneDescription::parse(&read.to_toml().unwrap()).unwrap();
        assert_eq!(again, read);
    }
}
