//! Eyes: what each cone answers to quanta, how many of each there are, and how noisy they are.

use crate::error::{counted, shortened};
use crate::fields::{Fields, at_line, parse_toml};
use crate::spectrum::dense::{DenseSpectrum, LONGEST_NM, SHORTEST_NM};
use crate::spectrum::sensor::Sensor;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::{Error, Result};

use super::pigment::{AVERAGE_HALF_NM, Droplet, ocular_media, pigment};

/// Cones that an eye may have beside the double one.
pub const MOST_CONES: usize = 8;

/// The noise of a cone where nobody says another: a Weber fraction.
const USUAL_WEBER: f64 = 0.1;

/// Letters of a cone's name.
const LONGEST_NAME: usize = 32;

/// The name by which a sensor's channel is a double cone.
const DOUBLE: &str = "double";

const CONE_KEYS: [&str; 8] =
    ["name", "pigment_nm", "droplet", "cut_nm", "wavelength_nm", "values", "abundance", "source"];

/// A class of cones.
#[derive(Debug, Clone, PartialEq)]
pub struct Cone {
    /// As in `UV`.
    pub name: String,
    /// Answer to a quantum by its wavelength, from 0 to 1; of templates 0 below 300 nm, where nothing is known of them.
    pub sensitivity: DenseSpectrum,
    /// Where that is 1, nm.
    pub peak_nm: f64,
    /// How many there are, in any unit.
    pub abundance: f64,
    /// Where its numbers come from.
    pub source: String,
}

/// An eye: one to eight classes of cones in the order of their peaks, and perhaps double cones.
#[derive(Debug, Clone, PartialEq)]
pub struct Eye {
    /// What people call the bird.
    pub name: String,
    /// Its Latin name, or nothing.
    pub latin: String,
    /// Where its numbers come from: a sentence for each kind of them.
    pub sources: Vec<String>,
    /// The classes of cones that see colour, rising in their peaks.
    pub cones: Vec<Cone>,
    /// The double cones, which see how bright it is.
    pub double: Option<Cone>,
    /// Weber fraction of the class of cones that [`super::Reference`] names.
    pub weber: f64,
    /// Weber fraction of the double cones.
    pub weber_double: f64,
}

/// What all cones of a table share.
struct Media {
    half_nm: f64,
    beta: bool,
}

impl Eye {
    /// Reads an eye from a TOML text, as `docs/formats/bird.md` describes it; `stem` is its name unless it says another.
    ///
    /// # Errors
    /// Not TOML, a key that is unknown, missing or out of range; the message names it.
    pub fn parse(text: &str, stem: &str) -> Result<Self> {
        Self::of_table(&Fields::new(&parse_toml(text)?, "", &KEYS)?, stem)
            .map_err(|error| at_line(error, text))
    }

    fn of_table(fields: &Fields<'_>, stem: &str) -> Result<Self> {
        let optional = |key: &str, usual: f64, low: f64, high: f64| match fields.get(key) {
            None => Ok(usual),
            Some(_) => fields.number_within(key, low, high),
        };
        let beta = match fields.get("beta") {
            None => false,
            Some(value) => {
                value.as_bool().ok_or_else(|| Error::input("beta must be true or false").about("beta"))?
            }
        };
        let media = Media { half_nm: optional("ocular_half_nm", AVERAGE_HALF_NM, 300.0, 450.0)?, beta };
        let cones = fields
            .list("cones", "tables [[cones]]")?
            .iter()
            .enumerate()
            .map(|(i, table)| cone(&Fields::new(table, &format!("cones[{i}]"), &CONE_KEYS)?, &media, None))
            .collect::<Result<Vec<_>>>()?;
        let double = match fields.get("double") {
            None => None,
            Some(table) => Some(cone(&Fields::new(table, "double", &CONE_KEYS)?, &media, Some(DOUBLE))?),
        };
        let sources = ["source", "ocular_source", "abundance_source", "weber_source"];
        let sources = sources.into_iter().map(|key| fields.text(key)).collect::<Result<Vec<_>>>()?;
        let weber = optional("weber", USUAL_WEBER, 1e-6, 10.0)?;
        Self {
            name: fields.text("name")?.unwrap_or(stem).to_owned(),
            latin: fields.text("latin")?.unwrap_or_default().to_owned(),
            sources: sources.into_iter().flatten().map(str::to_owned).collect(),
            cones,
            double,
            weber,
            weber_double: optional("weber_double", weber, 1e-6, 10.0)?,
        }
        .checked()
    }

    /// The eye whose cones are a sensor's channels: what they answer to quanta, as many of each class as of any other. A channel called
    /// `double` is the double cones.
    ///
    /// # Errors
    /// No channel but `double`.
    pub fn of_sensor(sensor: &Sensor) -> Result<Self> {
        let band = sensor.band();
        let mut cones = Vec::new();
        let mut double = None;
        for curve in sensor.channels() {
            let within = |nm: f64| if band.contains(nm) { curve.response.at(nm) } else { 0.0 };
            let cone = normalized(curve.name.clone(), within, 1.0, format!("the file of {}", sensor.name()))?;
            if curve.name == DOUBLE { double = Some(cone) } else { cones.push(cone) }
        }
        Self {
            name: sensor.name().to_owned(),
            latin: String::new(),
            sources: Vec::new(),
            cones,
            double,
            weber: USUAL_WEBER,
            weber_double: USUAL_WEBER,
        }
        .checked()
    }

    /// With other numbers of cones, one for each in the order of their peaks.
    ///
    /// # Errors
    /// Not one finite number over 0 for each class of cones.
    pub fn with_abundance(mut self, abundance: &[f64]) -> Result<Self> {
        if abundance.len() != self.cones.len() || abundance.iter().any(|n| !(n.is_finite() && *n > 0.0)) {
            let names: Vec<&str> = self.cones.iter().map(|cone| cone.name.as_str()).collect();
            return Err(Error::input(format!(
                "{} for the {} of {} ({}); give one number over 0 for each, as in 1,2,2,4",
                counted(abundance.len(), "number"),
                counted(names.len(), "cone"),
                shortened(&self.name),
                names.join(", ")
            )));
        }
        for (cone, n) in self.cones.iter_mut().zip(abundance) {
            cone.abundance = *n;
        }
        Ok(self)
    }

    /// All cones, the double ones last.
    pub fn all_cones(&self) -> impl Iterator<Item = &Cone> {
        self.cones.iter().chain(&self.double)
    }

    fn checked(mut self) -> Result<Self> {
        if !(1..=MOST_CONES).contains(&self.cones.len()) {
            return Err(Error::input(format!(
                "an eye with {} classes of single cones: give 1 to {MOST_CONES}",
                self.cones.len()
            )));
        }
        self.cones.sort_by(|a, b| a.peak_nm.total_cmp(&b.peak_nm));
        for (index, cone) in self.cones.iter().enumerate() {
            if self.cones[..index].iter().any(|other| other.name.eq_ignore_ascii_case(&cone.name)) {
                return Err(Error::input(format!(
                    "two classes of cones are called '{}'; give each a name of its own",
                    cone.name
                )));
            }
        }
        Ok(self)
    }
}

const KEYS: [&str; 12] = [
    "name",
    "latin",
    "source",
    "ocular_half_nm",
    "ocular_source",
    "beta",
    "abundance_source",
    "weber",
    "weber_double",
    "weber_source",
    "cones",
    "double",
];

/// A cone of a table: a pigment behind a droplet, or a curve. `name`: where the table needs none.
fn cone(fields: &Fields<'_>, media: &Media, name: Option<&str>) -> Result<Cone> {
    let name = fields.text("name")?.or(name).unwrap_or_default().to_owned();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(is_plain) {
        let key = fields.path("name");
        return Err(Error::input(format!(
            "{key} is '{}'; name cones with up to {LONGEST_NAME} letters, digits, - and _",
            shortened(&name)
        ))
        .about(key));
    }
    let abundance = match fields.get("abundance") {
        None => 1.0,
        Some(_) => fields.number_within("abundance", 1e-6, 1e12)?,
    };
    let source = fields.text("source")?.unwrap_or_default().to_owned();
    if fields.get("values").is_some() || fields.get("wavelength_nm").is_some() {
        if let Some(key) = ["pigment_nm", "droplet", "cut_nm"].iter().find(|key| fields.get(key).is_some()) {
            let key = fields.path(key);
            return Err(Error::input(format!(
                "{key} stands beside a curve; give either pigment_nm and droplet, or wavelength_nm and values"
            ))
            .about(key));
        }
        let table = curve(fields)?;
        return normalized(name, |nm| table.value(nm).unwrap_or(0.0), abundance, source)
            .map_err(|error| error.at(fields.place()));
    }
    let maximum = fields.number_within("pigment_nm", 300.0, 700.0)?;
    let droplet = match fields.text("droplet")? {
        None => Droplet::Transparent,
        Some(letter) => {
            let key = fields.path("droplet");
            Droplet::of_letter(letter).map_err(|error| Error::input(format!("{key} {error}")).about(key))?
        }
    };
    let cut = match droplet {
        Droplet::Transparent => 0.0,
        _ => fields.number_within("cut_nm", 300.0, 680.0)?,
    };
    let answer = |nm: f64| {
        pigment(maximum, nm, media.beta) * droplet.transmittance(cut, nm) * ocular_media(media.half_nm, nm)
    };
    normalized(name, answer, abundance, source).map_err(|error| error.at(fields.place()))
}

/// The curve of a cone that a table gives: 0 outside it.
fn curve(fields: &Fields<'_>) -> Result<Spectrum> {
    let at = Wavelengths::new(fields.numbers("wavelength_nm")?)
        .map_err(|error| error.at(fields.path("wavelength_nm")))?;
    let (first, last) = at.range_nm();
    if first < SHORTEST_NM || last > LONGEST_NM {
        return Err(Error::input(format!(
            "{} has {first} to {last} nm; give wavelengths within {SHORTEST_NM} to {LONGEST_NM}",
            fields.path("wavelength_nm")
        )));
    }
    Spectrum::new(at, fields.numbers("values")?).map_err(|error| error.at(fields.path("values")))
}

/// A cone whose answers are divided by the largest of them.
fn normalized(name: String, answer: impl Fn(f64) -> f64, abundance: f64, source: String) -> Result<Cone> {
    let raw = DenseSpectrum::new(answer);
    let places = raw.values().iter().enumerate();
    let (at, top) = places.fold((0, 0.0), |best, (i, v)| if *v > best.1 { (i, *v) } else { best });
    // Of the least numbers there is no reciprocal.
    if raw.values().iter().any(|v| !(v.is_finite() && *v >= 0.0)) || top < f64::MIN_POSITIVE {
        return Err(Error::input(format!(
            "the cone '{}' has an answer that is negative or not finite, or sees nothing at all; give values not below 0, one of them above",
            shortened(&name)
        )));
    }
    Ok(Cone { name, peak_nm: SHORTEST_NM + at as f64, sensitivity: raw.scaled(1.0 / top), abundance, source })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: &str = "weber = 0.05\n[[cones]]\nname = 'L'\npigment_nm = 563\ndroplet = 'R'\ncut_nm = 572\nabundance = 4\n\
         [[cones]]\nname = 'S'\nwavelength_nm = [400, 450, 500]\nvalues = [0, 8, 0]\n\
         [double]\npigment_nm = 563\ndroplet = 'P'\ncut_nm = 471\n";

    #[test]
    fn eyes_are_read_with_templates_and_curves_and_stand_in_the_order_of_their_peaks() {
        let eye = Eye::parse(TWO, "mine").unwrap();
        let names: Vec<_> = eye.cones.iter().map(|c| (c.name.as_str(), c.peak_nm, c.abundance)).collect();
        assert_eq!(names, [("S", 450.0, 1.0), ("L", 606.0, 4.0)]);
        assert_eq!((eye.name.as_str(), eye.weber, eye.weber_double), ("mine", 0.05, 0.05));
        let blue = &eye.cones[0].sensitivity;
        assert_eq!([blue.at(350.0), blue.at(425.0), blue.at(450.0), blue.at(600.0)], [0.0, 0.5, 1.0, 0.0]);
        assert_eq!(eye.double.as_ref().unwrap().name, "double");
        assert_eq!(eye.all_cones().count(), 3);
        let fewer = eye.clone().with_abundance(&[1.0]).unwrap_err().to_string();
        assert!(fewer.contains("1 number for the") && fewer.contains("(S, L)"), "{fewer}");
        assert_eq!(eye.with_abundance(&[1.0, 2.0]).unwrap().cones[1].abundance, 2.0);
    }

    #[test]
    fn what_is_no_eye_is_refused_by_line_and_key() {
        for (from, to, part) in [
            (
                "pigment_nm = 563\ndroplet = 'R'",
                "pigment_nm = 900\ndroplet = 'R'",
                "line 4: cones[0].pigment_nm is 900",
            ),
            ("droplet = 'R'", "droplet = 'Z'", "line 5: cones[0].droplet is 'Z', but must be T"),
            ("cut_nm = 572\n", "", "cones[0].cut_nm is missing"),
            ("values = [0, 8, 0]", "values = [0, 8]", "cones[1].values: 2 values do not fit 3 wavelengths"),
            (
                "values = [0, 8, 0]",
                "values = [0, -8, 0]",
                "cones[1]: the cone 'S' has an answer that is negative",
            ),
            ("values = [0, 8, 0]", "values = [0, 8, 0]\ncut_nm = 4", "cones[1].cut_nm stands beside a curve"),
            ("[400, 450, 500]", "[200, 450, 500]", "has 200 to 500 nm; give wavelengths within 300 to 830"),
            ("name = 'S'", "name = 'l'", "two classes of cones are called"),
            ("name = 'S'", "name = 'a b'", "cones[1].name is 'a b'; name cones"),
            ("weber = 0.05", "webber = 0.05", "did you mean 'weber'?"),
            ("weber = 0.05", "beta = 3", "beta must be true or false"),
        ] {
            let text = TWO.replacen(from, to, 1);
            let message = Eye::parse(&text, "x").unwrap_err().to_string();
            assert!(message.contains(part) && message.len() < 600, "{to}: {message}");
        }
        assert!(Eye::parse("cones = []", "x").unwrap_err().to_string().contains("0 classes"));
        assert!(Eye::parse("name = 'a'", "x").unwrap_err().to_string().contains("cones is missing"));
    }
}
