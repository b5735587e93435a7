//! Measurements as fits take them.

use crate::instrument::{Incidence, Instrument};
use crate::io::measured::{AtAngle, Measurements};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::{Error, Result};

/// Samples of one reading, at most: neighbours of finer ones are averaged.
const MOST_SAMPLES: usize = 401;

/// One direction that light comes from, and leaves again as from a mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// θ_i (along the barbule) and φ_i (across), rad.
    pub direction: (f64, f64),
    /// What its reflectance is multiplied by in the reading, as [`crate::instrument::Incidence::weight`].
    pub weight: f64,
}

impl Beam {
    /// The angle from the normal of flat layers, rad.
    pub(super) fn angle(&self) -> f64 {
        let (theta, phi) = self.direction;
        // From the sine, which keeps its digits near the normal.
        let sine = (theta.sin().powi(2) + (theta.cos() * phi.sin()).powi(2)).sqrt();
        sine.asin()
    }
}

/// How measurements were lit.
#[derive(Debug, Clone, Copy)]
pub struct Lighting<'a> {
    /// The instrument; none: light from one direction alone.
    pub instrument: Option<&'a Instrument>,
    /// Whether the angles are along the barbule rather than across it.
    pub along: bool,
    /// All layers together of the thickest stack that is looked at, nm, whose fringes an instrument's directions follow.
    pub thickest_nm: f64,
}

/// One measured spectrum, and how it was lit.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// What it is called in messages and figures.
    pub name: String,
    /// The mean over samples, or the only one.
    pub mean: Spectrum,
    /// The samples one by one, at the wavelengths of the mean; empty where there is one.
    pub samples: Vec<Spectrum>,
    /// Where the light comes from, at least one direction.
    pub beams: Vec<Beam>,
}

impl Reading {
    /// A reading within a range of wavelengths, in nm, thinned by averaging to what a fit takes.
    ///
    /// # Errors
    /// Fewer than two samples lie within the range, or nothing that is mirrored is collected.
    pub fn new(
        name: impl Into<String>,
        mean: &Spectrum,
        samples: &[Spectrum],
        beams: Vec<Beam>,
        range_nm: Option<[f64; 2]>,
    ) -> Result<Self> {
        let name = name.into();
        if !beams.iter().map(|beam| beam.weight).sum::<f64>().is_normal() {
            return Err(Error::input(format!(
                "{name}: nothing of the light that flat layers mirror is collected there; give the angles at which it was measured"
            )));
        }
        let within = |curve: &Spectrum| match range_nm {
            None => Some(thinned(curve)),
            Some(range) => cut(curve, range).map(|curve| thinned(&curve)),
        };
        let Some(mean) = within(mean) else {
            let (first, last) = mean.wavelengths().range_nm();
            let [from, to] = range_nm.unwrap_or([first, last]);
            return Err(Error::input(format!(
                "{name}: fewer than two of its wavelengths, {first} to {last} nm, lie within {from} to {to} nm; give a range that they lie in"
            ))
            .naming(&["range_nm"]));
        };
        let samples =
            if samples.len() > 1 { samples.iter().filter_map(within).collect() } else { Vec::new() };
        Ok(Self { name, mean, samples, beams })
    }

    /// One reading for each angle of measurements: with an instrument those of flat layers under it, else light from that angle
    /// alone. Where no angle is said it is 0.
    ///
    /// # Errors
    /// As [`Self::new`], or an instrument that does not see a sample so far turned.
    pub fn of(
        measurements: &Measurements,
        lighting: Lighting<'_>,
        range_nm: Option<[f64; 2]>,
    ) -> Result<Vec<Self>> {
        let one = |at: &AtAngle| {
            let samples: Vec<Spectrum> =
                at.measured.samples.iter().map(|sample| sample.spectrum.clone()).collect();
            let angle = at.angle_deg.unwrap_or(0.0);
            Self::at(angle, &at.measured.mean, &samples, lighting, range_nm)
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
        lighting: Lighting<'_>,
        range_nm: Option<[f64; 2]>,
    ) -> Result<Self> {
        let angle = angle_deg.to_radians();
        let towards = |angle: f64| if lighting.along { (angle, 0.0) } else { (0.0, angle) };
        let name = format!("{angle_deg}°");
        let beams = match lighting.instrument {
            None => vec![Beam { direction: towards(angle), weight: 1.0 }],
            Some(instrument) => {
                instrument.check(angle).map_err(|error| error.at(&name))?;
                let beam = |light: &Incidence| Beam { direction: towards(light.angle), weight: light.weight };
                instrument
                    .planar(angle, lighting.thickest_nm / mean.wavelengths().range_nm().0)
                    .iter()
                    .map(beam)
                    .collect()
            }
        };
        Self::new(name, mean, samples, beams, range_nm)
    }

    /// Its wavelengths, nm.
    pub(super) fn nm(&self) -> &[f64] {
        self.mean.wavelengths().nm()
    }
}

/// The samples of a curve within a range, at least two; nothing is made up at its ends.
fn cut(curve: &Spectrum, [from, to]: [f64; 2]) -> Option<Spectrum> {
    let inside = curve.wavelengths().iter().zip(curve.values()).filter(|(nm, _)| (from..=to).contains(*nm));
    let (nm, values): (Vec<f64>, Vec<f64>) = inside.map(|(nm, value)| (*nm, *value)).unzip();
    if nm.len() < 2 {
        return None;
    }
    Spectrum::new(Wavelengths::new(nm).ok()?, values).ok()
}

/// A curve of at most [`MOST_SAMPLES`], each the mean of as many neighbours.
fn thinned(curve: &Spectrum) -> Spectrum {
    let together = curve.values().len().div_ceil(MOST_SAMPLES);
    if together == 1 {
        return curve.clone();
    }
    let mean = |values: &[f64]| -> Vec<f64> {
        values.chunks(together).map(|run| run.iter().sum::<f64>() / run.len() as f64).collect()
    };
    // Means of rising numbers rise.
    Wavelengths::new(mean(curve.wavelengths().nm()))
        .and_then(|at| Spectrum::new(at, mean(curve.values())))
        .unwrap_or_else(|_| curve.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beam(theta: f64, phi: f64) -> Beam {
        Beam { direction: (theta, phi), weight: 1.0 }
    }

    #[test]
    fn angles_of_beams_are_those_of_their_directions() {
        for (theta, phi) in [(0.0_f64, 0.0_f64), (0.3, 0.0), (0.0, -0.4), (0.5, 0.7), (1.2, 1.1)] {
            let cosine = theta.cos() * phi.cos();
            assert!((beam(theta, phi).angle().cos() - cosine).abs() < 1e-14);
        }
    }

    #[test]
    fn fine_spectra_are_averaged_and_ranges_are_cut() {
        let at = Wavelengths::new((0..1000).map(|k| 300.0 + 0.5 * f64::from(k)).collect::<Vec<_>>()).unwrap();
        let line = Spectrum::new(at.clone(), at.iter().map(|nm| 2.0 * nm).collect()).unwrap();
        let reading = Reading::new("a", &line, &[], vec![beam(0.0, 0.0)], None).unwrap();
        assert_eq!(reading.nm().len(), 334);
        let exact = reading.nm().iter().zip(reading.mean.values()).all(|(nm, v)| (2.0 * nm - v).abs() < 1e-9);
        assert!(exact);
        let part = Reading::new("a", &line, &[], vec![beam(0.0, 0.0)], Some([400.2, 410.0])).unwrap();
        assert_eq!((part.nm()[0], part.nm().len()), (400.5, 20));
        let none = Reading::new("a", &line, &[], vec![beam(0.0, 0.0)], Some([100.0, 200.0])).unwrap_err();
        assert!(none.to_string().contains("a: fewer than two of its wavelengths, 300 to 799.5 nm"), "{none}");
        assert!(Reading::new("a", &line, &[], Vec::new(), None).is_err());
    }
}
