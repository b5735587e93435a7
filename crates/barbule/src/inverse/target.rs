//! What a fit is asked for, and what it answers: the same on the command line and from Python.

use serde_json::{Map, Value, json};

use super::structure::{FittedStructure, Simulation, fit_structure};
use super::subject::{Open, Subject};
use super::{Beam, Estimate, Fit, Parameter, Reading, Settings, Solution, fit_stack};
use crate::error::shortened;
use crate::instrument::{Incidence, Instrument};
use crate::io::measured::{AtAngle, Measurements};
use crate::material::Library;
use crate::progress::Progress;
use crate::spectrum::Spectrum;
use crate::{Error, Result};

/// The stack of a film unless another is given, and where its thickness is looked for, nm.
pub const FILM: &str = "air/keratin:?/air";
/// Where the thickness of a film is looked for, nm.
pub const FILM_NM: [f64; 2] = [50.0, 3000.0];
/// Where the thickness of one of several layers is looked for, nm.
pub const LAYER_NM: [f64; 2] = [20.0, 500.0];

/// What is to be found.
#[derive(Debug, Clone)]
pub enum Target {
    /// Open numbers of a stack of flat layers.
    Stack {
        /// The stack with places, as in `air/keratin:?/air`.
        text: String,
        /// Where a thickness that is only `?` is looked for, nm.
        usual_nm: [f64; 2],
        /// What its media mean.
        library: Box<Library>,
    },
    /// Sizes of a species or a lattice.
    Structure {
        /// The species or lattice.
        subject: Subject,
        /// The open sizes; empty: those that set its colour most.
        open: Vec<Open>,
        /// How its spectra are simulated.
        simulation: Simulation,
    },
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The solutions.
    pub fit: Fit,
    /// The text of a file of the best one, which simulates as any other of its kind.
    pub toml: String,
    /// Of species and lattices: how far the tables are off, and how many spectra were simulated.
    pub tables: Option<(f64, usize)>,
}

impl Target {
    /// Refuses an instrument where its reading does not follow from what flat layers reflect.
    ///
    /// # Errors
    /// It is a species or a lattice.
    pub fn check_instrument(&self, instrument: Option<&Instrument>) -> Result<()> {
        match self {
            Self::Structure { subject, .. } if instrument.is_some() => Err(Error::input(format!(
                "an instrument is for films and multilayers, but {} is not made of flat layers alone; leave it out, and the level free",
                shortened(&subject.name())
            ))
            .naming(&["instrument"])),
            _ => Ok(()),
        }
    }

    /// Fits it to readings.
    ///
    /// # Errors
    /// As [`fit_stack`] and [`fit_structure`].
    pub fn fit(&self, readings: &[Reading], settings: &Settings, progress: &dyn Progress) -> Result<Outcome> {
        match self {
            Self::Stack { text, usual_nm, library } => {
                progress.begin("fitting", 1);
                let found = fit_stack(text, *usual_nm, library, readings, settings)?;
                progress.advance(1);
                let stack = toml::Value::from(found.text(&found.fit.solutions[0]));
                let toml = format!("{}stack = {stack}\n", comments(&found.fit));
                Ok(Outcome { toml, fit: found.fit, tables: None })
            }
            Self::Structure { subject, open, simulation } => {
                let found = fit_structure(subject, open, simulation, readings, settings, progress)?;
                let FittedStructure { fit, best, table_error, simulated } = found;
                let toml = format!("{}{}", comments(&fit), best.toml()?);
                Ok(Outcome { fit, toml, tables: Some((table_error, simulated)) })
            }
        }
    }
}

impl Reading {
    /// One reading for each angle of measurements: with an instrument those of flat layers under it, else light from that angle
    /// alone, across the barbule or `along` it. Where no angle is said it is 0.
    ///
    /// # Errors
    /// As [`Reading::new`], or an instrument that does not see a sample so far turned.
    pub fn of(
        measurements: &Measurements,
        instrument: Option<&Instrument>,
        along: bool,
        range_nm: Option<[f64; 2]>,
    ) -> Result<Vec<Self>> {
        let one = |at: &AtAngle| {
            let samples: Vec<Spectrum> =
                at.measured.samples.iter().map(|sample| sample.spectrum.clone()).collect();
            let angle = at.angle_deg.unwrap_or(0.0);
            Self::at(angle, &at.measured.mean, &samples, instrument, along, range_nm)
        };
        measurements.angles.iter().map(one).collect()
    }

    /// The reading of samples and their mean at one angle, as [`Self::of`] makes it.
    ///
    /// # Errors
    /// As there.
    pub fn at(
        angle_deg: f64,
        mean: &Spectrum,
        samples: &[Spectrum],
        instrument: Option<&Instrument>,
        along: bool,
        range_nm: Option<[f64; 2]>,
    ) -> Result<Self> {
        let angle = angle_deg.to_radians();
        let towards = |angle: f64| if along { (angle, 0.0) } else { (0.0, angle) };
        let name = format!("{angle_deg}°");
        let beams = match instrument {
            None => vec![Beam { direction: towards(angle), weight: 1.0 }],
            Some(instrument) => {
                instrument.check(angle).map_err(|error| error.at(&name))?;
                let beam = |light: &Incidence| Beam { direction: towards(light.angle), weight: light.weight };
                instrument.planar(angle).iter().map(beam).collect()
            }
        };
        Self::new(name, mean, samples, beams, range_nm)
    }
}

/// The best solution as comments of a file.
fn comments(fit: &Fit) -> String {
    let best = &fit.solutions[0];
    let lines = fit.parameters.iter().zip(&best.sizes).map(|(p, size)| format!("# {}\n", in_words(p, size)));
    let fitted = "# Fitted to a measurement; 95 % intervals:\n".to_owned();
    std::iter::once(fitted).chain(lines).collect()
}

/// A size with its interval, as `thickness_nm 643.2 (641.0 to 645.4 nm)`.
#[must_use]
pub fn in_words(p: &Parameter, size: &Estimate) -> String {
    let digits = size.digits();
    let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
    let Estimate { value, low, high, open } = *size;
    let bound = |open: bool| if open { " (end of the range)" } else { "" };
    format!(
        "{} {value:.digits$}{unit}, 95 %: {low:.digits$}{} to {high:.digits$}{}",
        p.name,
        bound(open[0]),
        bound(open[1])
    )
}

impl Estimate {
    /// Digits behind the point that show its interval to two figures, at most six.
    #[must_use]
    pub fn digits(&self) -> usize {
        let width = 0.5 * (self.high - self.low);
        if width <= 0.0 {
            return 6;
        }
        (1.0 - width.log10().floor()).clamp(0.0, 6.0) as usize
    }
}

impl Outcome {
    /// Everything as one document; `readings` are those that were fitted. Wavelengths in nm; `level` and `offset` are what the model is
    /// multiplied by and what is added to it, one of each for every reading.
    #[must_use]
    pub fn document(&self, readings: &[Reading]) -> Value {
        let Fit { parameters, solutions, noise, doubts } = &self.fit;
        let solutions: Vec<Value> = solutions.iter().map(|one| solution(parameters, one)).collect();
        let readings: Vec<Value> = readings
            .iter()
            .zip(noise)
            .map(|(reading, noise)| {
                json!({
                    "name": reading.name,
                    "wavelength_nm": reading.mean.wavelengths().nm(),
                    "measured": reading.mean.values(),
                    "samples": reading.samples.len().max(1),
                    "noise": {
                        "sigma": noise.sigma, "correlation_nm": noise.correlation_nm, "white_part": noise.white,
                    },
                })
            })
            .collect();
        let mut document = json!({ "solutions": solutions, "readings": readings, "doubts": doubts });
        if let Some((error, simulated)) = self.tables {
            document["table_error"] = error.into();
            document["simulated"] = simulated.into();
        }
        document
    }
}

fn solution(parameters: &[Parameter], one: &Solution) -> Value {
    let size = |(k, (p, size)): (usize, (&Parameter, &Estimate))| {
        let std = one.between_samples.as_ref().map(|all| all[k]);
        let value = json!({
            "value": size.value, "low": size.low, "high": size.high, "unit": p.unit, "open": size.open,
            "between_samples_std": std,
        });
        (p.name.clone(), value)
    };
    let sizes: Map<String, Value> = parameters.iter().zip(&one.sizes).enumerate().map(size).collect();
    let fitted: Vec<&[f64]> = one.fitted.iter().map(|curve| curve.values()).collect();
    // Infinite variances are null.
    json!({
        "parameters": sizes,
        "rmse": one.rmse,
        "explained": one.explained,
        "worse_by": one.worse_by,
        "as_good": one.as_good,
        "level": one.levels.iter().map(|[level, _]| level).collect::<Vec<_>>(),
        "offset": one.levels.iter().map(|[_, offset]| offset).collect::<Vec<_>>(),
        "covariance": one.covariance,
        "fitted": fitted,
    })
}
