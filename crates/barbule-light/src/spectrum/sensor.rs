//! Who looks: a band of wavelengths, and what each channel of a sensor answers to light in it.

use std::sync::{Arc, LazyLock};

use super::colour::{D65_WHITE, Illuminant, matching, xyz_from_rgb};
use super::dense::{DenseSpectrum, LONGEST_NM, SHORTEST_NM};
use super::hero::HeroDensity;
use crate::error::shortened;
use crate::identity::{Hasher, Identify};
use crate::{Error, Result};

/// Channels that a sensor may have.
pub const MOST_CHANNELS: usize = 8;

/// Letters of a channel's name.
const LONGEST_NAME: usize = 32;

/// A range of wavelengths between whole nm within 300 … 830.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Band {
    low_nm: u32,
    high_nm: u32,
}

impl Band {
    /// What the human eye's pictures are sampled in.
    pub const HUMAN: Self = Self { low_nm: 380, high_nm: 720 };

    /// From its ends, nm.
    ///
    /// # Errors
    /// An end outside 300 to 830 nm, or the second not above the first.
    pub fn new(low_nm: u32, high_nm: u32) -> Result<Self> {
        if f64::from(low_nm) < SHORTEST_NM || f64::from(high_nm) > LONGEST_NM || low_nm >= high_nm {
            return Err(Error::input(format!(
                "a band of {low_nm} to {high_nm} nm: give two rising wavelengths within {SHORTEST_NM} to {LONGEST_NM} nm"
            )));
        }
        Ok(Self { low_nm, high_nm })
    }

    /// Its first wavelength, nm.
    #[must_use]
    pub fn low_nm(self) -> f64 {
        f64::from(self.low_nm)
    }

    /// Its last wavelength, nm.
    #[must_use]
    pub fn high_nm(self) -> f64 {
        f64::from(self.high_nm)
    }

    /// How wide it is, nm.
    #[must_use]
    pub fn width_nm(self) -> f64 {
        self.high_nm() - self.low_nm()
    }

    /// Whether a wavelength in nm lies in it.
    #[must_use]
    pub fn contains(self, nm: f64) -> bool {
        (self.low_nm()..=self.high_nm()).contains(&nm)
    }

    /// Its whole nanometres, both ends included.
    pub fn each_nm(self) -> impl Iterator<Item = f64> {
        (self.low_nm..=self.high_nm).map(f64::from)
    }

    /// Where its values begin and end in a [`DenseSpectrum`]'s.
    #[must_use]
    pub fn places(self) -> [usize; 2] {
        [self.low_nm, self.high_nm].map(|nm| nm as usize - SHORTEST_NM as usize)
    }

    /// Its part of a spectrum: one value per nm.
    #[must_use]
    pub fn of(self, spectrum: &DenseSpectrum) -> &[f64] {
        let [first, last] = self.places();
        &spectrum.values()[first..=last]
    }

    /// Integral over the band of a spectrum that is linear between whole nm.
    #[must_use]
    pub fn integral(self, spectrum: &DenseSpectrum) -> f64 {
        self.of(spectrum).windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).sum()
    }
}

/// Integrals of channels, between which quotients and sums of them stay numbers.
const USUAL_SUMS: std::ops::RangeInclusive<f64> = 1e-100..=1e100;

/// What a channel answers to light, by wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Name: letters, digits, `-` and `_`.
    pub name: String,
    /// Answer to a radiance of 1 per nm, in the unit that the channel is read in. Outside the sensor's band it does not count.
    pub response: DenseSpectrum,
}

/// An observer, an animal's eye or a camera: how its channels answer to light within a band, and with which wavelengths paths look
/// for it. A channel's value is ∫ L(λ) S(λ) dλ, with λ in nm and L = 1 for daylight of radiance 1 at 560 nm. A copy costs nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor(Arc<Parts>);

#[derive(Debug, Clone, PartialEq)]
struct Parts {
    name: String,
    band: Band,
    channels: Vec<Curve>,
    white: [f64; MOST_CHANNELS],
    to_xyz: Option<[[f64; MOST_CHANNELS]; 3]>,
    density: HeroDensity,
}

/// The colour-matching functions, each scaled so that daylight (D65, 1 at 560 nm) cut to the band has exactly the X, Y and Z
/// of sRGB's white.
static HUMAN: LazyLock<Sensor> = LazyLock::new(|| {
    let band = Band::HUMAN;
    let mut sums = [0.0; 3];
    for nm in band.each_nm() {
        let weight = if nm == band.low_nm() || nm == band.high_nm() { 0.5 } else { 1.0 };
        let daylight = weight * Illuminant::D65.power(nm) / Illuminant::D65.power(560.0);
        for (sum, value) in sums.iter_mut().zip(matching(nm)) {
            *sum += daylight * value;
        }
    }
    let white = xyz_from_rgb([1.0; 3]);
    let curve = |(k, name): (usize, &str)| Curve {
        name: name.to_owned(),
        response: DenseSpectrum::new(|nm| matching(nm)[k] * (white[k] / sums[k])),
    };
    let channels: Vec<Curve> = ["X", "Y", "Z"].into_iter().enumerate().map(curve).collect();
    let mut identity = [[0.0; MOST_CHANNELS]; 3];
    (0..3).for_each(|k| identity[k][k] = 1.0);
    Sensor(Arc::new(Parts {
        name: "human".to_owned(),
        band,
        white: white_of(band, &channels),
        channels,
        to_xyz: Some(identity),
        density: HeroDensity::of_eye(),
    }))
});

impl Default for Sensor {
    fn default() -> Self {
        Self::human()
    }
}

impl Sensor {
    /// The CIE's observer of 1931 (2°) from 380 to 720 nm: X, Y and Z, of which daylight of radiance 1 has those of sRGB's white.
    #[must_use]
    pub fn human() -> Self {
        HUMAN.clone()
    }

    /// One to eight channels, whose curves may be in different units: each has the same part in where wavelengths are
    /// drawn.
    ///
    /// # Errors
    /// No channel or over eight, a name that is empty, long, given twice or has other letters, a value in the band that is negative
    /// or not finite, or a channel that sees nothing there.
    pub fn new(name: &str, band: Band, channels: Vec<Curve>) -> Result<Self> {
        if !(1..=MOST_CHANNELS).contains(&channels.len()) {
            return Err(Error::input(format!(
                "a sensor of {} channels: give 1 to {MOST_CHANNELS}",
                channels.len()
            )));
        }
        for (index, curve) in channels.iter().enumerate() {
            check_name(&curve.name, &channels[..index])?;
            let place = format!("channel '{}'", curve.name);
            let mut values = band.each_nm().zip(band.of(&curve.response));
            if let Some((nm, value)) = values.find(|(_, value)| !(value.is_finite() && **value >= 0.0)) {
                return Err(Error::input(format!(
                    "{place}: its value at {nm} nm is {value}; give finite ones not below 0"
                )));
            }
            let sum = band.integral(&curve.response);
            if sum <= 0.0 {
                return Err(Error::input(format!(
                    "{place}: it is 0 from {} to {} nm, so it sees nothing; leave it out",
                    band.low_nm(),
                    band.high_nm()
                )));
            }
            if !USUAL_SUMS.contains(&sum) {
                return Err(Error::input(format!(
                    "{place}: its integral over the wavelengths is {sum:e}; give values in a unit that makes it {:e} to {:e}",
                    USUAL_SUMS.start(),
                    USUAL_SUMS.end()
                )));
            }
        }
        let white = white_of(band, &channels);
        let mut weights = vec![0.0; band.each_nm().count()];
        for (curve, white) in channels.iter().zip(white) {
            for (weight, value) in weights.iter_mut().zip(band.of(&curve.response)) {
                *weight += value / white;
            }
        }
        let (name, density) = (name.to_owned(), HeroDensity::of_weights(band, &weights));
        Ok(Self(Arc::new(Parts { name, band, channels, white, to_xyz: None, density })))
    }

    /// With what turns its channels into CIE XYZ relative to D65, a row for each of X, Y and Z: how its pictures look on a
    /// screen.
    ///
    /// # Errors
    /// A row that has not one finite number for each channel.
    pub fn with_xyz(self, rows: &[Vec<f64>; 3]) -> Result<Self> {
        let mut to_xyz = [[0.0; MOST_CHANNELS]; 3];
        let count = self.channels().len();
        for (to, row) in to_xyz.iter_mut().zip(rows) {
            if row.len() != count || row.iter().any(|value| !value.is_finite()) {
                return Err(Error::input(format!(
                    "to_xyz has a row of {} numbers; give three rows of {count} finite ones, one for each channel",
                    row.len()
                )));
            }
            to[..count].copy_from_slice(row);
        }
        let Self(parts) = self;
        Ok(Self(Arc::new(Parts { to_xyz: Some(to_xyz), ..Arc::unwrap_or_clone(parts) })))
    }

    /// With the wavelengths of another sensor's paths: pictures through both are of the same paths, so their noise is the same and
    /// what differs is what they see.
    ///
    /// # Errors
    /// The other has another band.
    pub fn drawn_as(self, other: &Self) -> Result<Self> {
        if self.band() != other.band() {
            return Err(Error::input(format!(
                "sensors '{}' and '{}' have different bands and no wavelengths in common",
                self.name(),
                other.name()
            )));
        }
        let Self(parts) = self;
        Ok(Self(Arc::new(Parts { density: other.0.density.clone(), ..Arc::unwrap_or_clone(parts) })))
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// The wavelengths it sees.
    #[must_use]
    pub fn band(&self) -> Band {
        self.0.band
    }

    /// Its channels, 1 to 8.
    #[must_use]
    pub fn channels(&self) -> &[Curve] {
        &self.0.channels
    }

    /// What each channel answers to a radiance of 1 at all wavelengths of the band; 1 beyond its channels.
    #[must_use]
    pub fn white(&self) -> &[f64; MOST_CHANNELS] {
        &self.0.white
    }

    /// With which wavelengths paths look for it.
    #[must_use]
    pub fn density(&self) -> &HeroDensity {
        &self.0.density
    }

    /// Whether it is [`Sensor::human`].
    #[must_use]
    pub fn is_human(&self) -> bool {
        Arc::ptr_eq(&self.0, &HUMAN.0)
    }

    /// Whether it says how its pictures look on a screen.
    #[must_use]
    pub fn has_colours(&self) -> bool {
        self.0.to_xyz.is_some()
    }

    /// CIE XYZ relative to D65 of its channels' values (0 beyond its own); of a sensor without colours the grey of their
    /// mean, each over its [`Sensor::white`].
    #[must_use]
    pub fn xyz(&self, channels: &[f64; MOST_CHANNELS]) -> [f64; 3] {
        match &self.0.to_xyz {
            Some(rows) => {
                rows.map(|row| row.iter().zip(channels).map(|(weight, value)| weight * value).sum())
            }
            None => {
                let sum: f64 = channels.iter().zip(self.white()).map(|(value, white)| value / white).sum();
                let mean = sum / self.channels().len() as f64;
                D65_WHITE.map(|white| white * mean)
            }
        }
    }
}

fn white_of(band: Band, channels: &[Curve]) -> [f64; MOST_CHANNELS] {
    let mut white = [1.0; MOST_CHANNELS];
    for (white, curve) in white.iter_mut().zip(channels) {
        *white = band.integral(&curve.response);
    }
    white
}

/// Refuses names that files of pictures cannot have for a plane.
fn check_name(name: &str, before: &[Curve]) -> Result<()> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(is_plain) {
        return Err(Error::input(format!(
            "channel '{}': name it with up to {LONGEST_NAME} letters, digits, - and _",
            shortened(name)
        )));
    }
    if before.iter().any(|other| other.name.eq_ignore_ascii_case(name)) {
        return Err(Error::input(format!("two channels are called '{name}'; give each a name of its own")));
    }
    Ok(())
}

impl Identify for Sensor {
    fn feed(&self, to: &mut Hasher) {
        // Of the curves follows white, and colours are made of a finished film.
        let Parts { name, band: Band { low_nm, high_nm }, channels, white: _, to_xyz: _, density } = &*self.0;
        to.text("name", name).count("low_nm", (*low_nm).into()).count("high_nm", (*high_nm).into());
        for Curve { name, response } in channels {
            to.text("channel", name).numbers("response", self.band().of(response));
        }
        for table in density.tables() {
            to.numbers("bins", table);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identity::hash;

    fn curve(name: &str, value: impl Fn(f64) -> f64) -> Curve {
        Curve { name: name.to_owned(), response: DenseSpectrum::new(value) }
    }

    fn cones() -> Sensor {
        let bell = |middle: f64| move |nm: f64| (-(nm - middle) * (nm - middle) / 800.0).exp();
        let channels = vec![curve("UV", bell(370.0)), curve("S", bell(450.0))];
        Sensor::new("two cones", Band::new(300, 700).unwrap(), channels).unwrap()
    }

    #[test]
    fn the_eye_sees_daylight_as_white() {
        let human = Sensor::human();
        let daylight = |curve: &Curve| {
            let power = |nm: f64| Illuminant::D65.power(nm) / Illuminant::D65.power(560.0);
            DenseSpectrum::new(|nm| curve.response.at(nm) * power(nm))
        };
        let mut seen = [0.0; MOST_CHANNELS];
        for (value, curve) in seen.iter_mut().zip(human.channels()) {
            *value = human.band().integral(&daylight(curve));
        }
        for (value, white) in human.xyz(&seen).into_iter().zip(D65_WHITE) {
            assert!((value / white - 1.0).abs() < 1e-12);
        }
        assert!(human.is_human() && Sensor::default().is_human() && !cones().is_human());
    }

    #[test]
    fn colours_come_from_the_matrix_and_else_are_grey() {
        let mut values = [0.0; MOST_CHANNELS];
        values[..2].copy_from_slice(&[0.5, 0.25]);
        let rows = [vec![1.0, 0.0], vec![0.0, 2.0], vec![1.0, 1.0]];
        assert_eq!(cones().with_xyz(&rows).unwrap().xyz(&values), [0.5, 0.5, 0.75]);
        for (value, white) in values.iter_mut().zip(*cones().white()) {
            *value *= white;
        }
        assert!((cones().xyz(&values)[1] - 0.375).abs() < 1e-15);
        let short = [vec![1.0, 0.0], vec![0.0], vec![1.0, 1.0]];
        assert!(cones().with_xyz(&short).unwrap_err().to_string().contains("three rows of 2 finite ones"));
    }

    #[test]
    fn whatever_decides_a_film_decides_the_identity() {
        let band = |high| Band::new(300, high).unwrap();
        let one = |name: &str, high, value: f64| {
            Sensor::new(name, band(high), vec![curve("a", |_| value)]).unwrap()
        };
        let mut hashes = [
            one("x", 700, 1.0),
            one("y", 700, 1.0),
            one("x", 701, 1.0),
            one("x", 700, 2.0),
            one("x", 700, 1.0)
                .drawn_as(&Sensor::new("z", band(700), vec![curve("a", |nm| nm)]).unwrap())
                .unwrap(),
            Sensor::human(),
        ]
        .map(|sensor| hash("sensor", &sensor));
        hashes.sort();
        assert!(hashes.windows(2).all(|pair| pair[0] != pair[1]));
        let rows = [vec![1.0], vec![1.0], vec![1.0]];
        let coloured = one("x", 700, 1.0).with_xyz(&rows).unwrap();
        assert_eq!(hash("sensor", &coloured), hash("sensor", &one("x", 700, 1.0)));
    }

    #[test]
    fn bad_sensors_are_refused_in_a_sentence() {
        let band = Band::new(300, 400).unwrap();
        let refused = |channels: Vec<Curve>| Sensor::new("x", band, channels).unwrap_err().to_string();
        assert!(refused(vec![]).contains("0 channels: give 1 to 8"));
        assert!(refused((0..9).map(|k| curve(&format!("c{k}"), |_| 1.0)).collect()).contains("9 channels"));
        assert!(refused(vec![curve("a.b", |_| 1.0)]).contains("letters, digits, - and _"));
        assert!(refused(vec![curve("", |_| 1.0)]).contains("name it with"));
        assert!(refused(vec![curve("a", |_| 1.0), curve("A", |_| 1.0)]).contains("two channels are called"));
        assert!(refused(vec![curve("a", |nm| 350.5 - nm)]).contains("at 351 nm is -0.5"));
        assert!(refused(vec![curve("a", |_| f64::NAN)]).contains("at 300 nm is NaN"));
        assert!(refused(vec![curve("a", |nm| f64::from(nm > 400.5))]).contains("sees nothing"));
        for (low, high) in [(299, 400), (400, 831), (400, 400), (500, 400)] {
            assert!(Band::new(low, high).unwrap_err().to_string().contains("within 300 to 830 nm"));
        }
        assert!(cones().drawn_as(&Sensor::human()).unwrap_err().to_string().contains("different bands"));
    }
}
