//! What a sensor answers to what the renderer gathers: to spectra at the wavelengths of a path, and to whole ones.

use crate::scene::emission::Emission;
use crate::spectrum::dense::{DenseSpectrum, VALUES, WAVES};
use crate::spectrum::hero::Hero;
use crate::spectrum::sensor::{MOST_CHANNELS, Sensor};

/// Values of the human eye: X, Y and Z.
pub(super) const EYE: usize = 3;

/// Values of a film's pixel, of which those beyond the sensor's channels stay 0.
pub(super) fn lanes(sensor: &Sensor) -> usize {
    if sensor.is_human() { EYE } else { MOST_CHANNELS }
}

/// A sensor's curves as films read them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Response {
    pub(super) sensor: Sensor,
    pub(super) rows: Rows,
    /// The light in which albedos are seen: daylight by the eye, so that white is sRGB's white, by others the same power at all
    /// wavelengths.
    light: DenseSpectrum,
    /// What each channel answers to a white albedo; of the eye 1, since its XYZ are colours as they are.
    pub(super) white: [f64; MOST_CHANNELS],
    /// Each channel's part in how bright a sample is, of which noise is judged: to the eye Y, to others the mean of all, each
    /// over its white.
    brightness: [f64; MOST_CHANNELS],
}

/// All channels' curves at each nm of a [`DenseSpectrum`], 0 outside the sensor's band. Zeros fill rows to the width of registers.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Rows {
    /// The human eye's.
    Eye(Box<[[f64; EYE + 1]; VALUES]>),
    /// Of any sensor.
    Any(Box<[[f64; MOST_CHANNELS]; VALUES]>),
}

impl Response {
    pub(super) fn new(sensor: &Sensor) -> Self {
        let own = sensor.clone();
        if sensor.is_human() {
            let (rows, light) = (Rows::Eye(rows(sensor)), Emission::daylight().spectrum().clone());
            let mut brightness = [0.0; MOST_CHANNELS];
            brightness[1] = 1.0;
            return Self { sensor: own, rows, light, white: [1.0; MOST_CHANNELS], brightness };
        }
        let (rows, light, white) = (Rows::Any(rows(sensor)), DenseSpectrum::new(|_| 1.0), *sensor.white());
        let brightness = white.map(|white| 1.0 / (white * sensor.channels().len() as f64));
        Self { sensor: own, rows, light, white, brightness }
    }

    /// What is seen of an albedo at the wavelengths of a path, over their densities.
    pub(super) fn lit(&self, albedo: &[f64; WAVES], hero: &Hero) -> [f64; WAVES] {
        let light = self.light.at_each(hero.wavelengths);
        std::array::from_fn(|k| albedo[k] * light[k] / hero.pdf[k])
    }

    /// What the channels answer to a light: what paths find in the mean. Both it and the curves are linear between whole nanometres.
    pub(super) fn of(&self, light: &Emission) -> [f64; MOST_CHANNELS] {
        let values = light.spectrum().values();
        let [first, last] = self.sensor.band().places();
        let mut seen = [0.0; MOST_CHANNELS];
        for (seen, curve) in seen.iter_mut().zip(self.sensor.channels()) {
            let response = curve.response.values();
            let cell = |k: usize| {
                let (low, high) = (response[k], response[k + 1]);
                (values[k] * (2.0 * low + high) + values[k + 1] * (low + 2.0 * high)) / 6.0
            };
            *seen = (first..last).map(cell).sum();
        }
        seen
    }

    /// How bright a sample is.
    #[inline(always)]
    pub(super) fn brightness<const LANES: usize>(&self, channels: &[f64; LANES]) -> f64 {
        channels.iter().zip(self.brightness).map(|(value, part)| value * part).sum()
    }
}

fn rows<const LANES: usize>(sensor: &Sensor) -> Box<[[f64; LANES]; VALUES]> {
    let mut rows = Box::new([[0.0; LANES]; VALUES]);
    let [first, last] = sensor.band().places();
    for (channel, curve) in sensor.channels().iter().enumerate() {
        for (row, value) in rows[first..=last].iter_mut().zip(sensor.band().of(&curve.response)) {
            row[channel] = *value;
        }
    }
    rows
}

/// What the channels of these rows answer to a spectrum at the wavelengths of a path, over their densities.
#[inline(always)]
pub(super) fn seen<const LANES: usize>(
    rows: &[[f64; LANES]; VALUES],
    over_pdf: &[f64; WAVES],
    hero: &Hero,
) -> [f64; LANES] {
    let places = hero.wavelengths.places();
    let mut seen = [0.0; LANES];
    for (k, value) in over_pdf.iter().enumerate() {
        let index = (places.below[k] as usize).min(VALUES - 2);
        let (low, high) = (&rows[index], &rows[index + 1]);
        let share = value / WAVES as f64;
        for i in 0..LANES {
            seen[i] += share * (low[i] + (high[i] - low[i]) * places.rest[k]);
        }
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::colour::rgb_from_xyz;

    #[test]
    fn daylight_of_radiance_1_is_white() {
        let (daylight, response) = (Emission::daylight(), Response::new(&Sensor::human()));
        let Rows::Eye(rows) = &response.rows else { panic!("the eye's rows") };
        let mut sum = [0.0; 3];
        let count = 4096;
        for i in 0..count {
            let hero = response.sensor.density().draw((f64::from(i) + 0.5) / f64::from(count));
            let emitted = daylight.at_each(hero.wavelengths);
            let over_pdf = std::array::from_fn(|k| emitted[k] / hero.pdf[k]);
            for (sum, value) in sum.iter_mut().zip(seen(rows, &over_pdf, &hero)) {
                *sum += value / f64::from(count);
            }
        }
        // Quadrature of the sharp lines of D65's table: 1e-4.
        assert!(rgb_from_xyz(sum).iter().all(|v| (v - 1.0).abs() < 1e-4), "{sum:?}");
        // Both are integrals of the same two broken lines, one of them from 32768 wavelengths.
        for (whole, sum) in response.of(&daylight).into_iter().zip(sum) {
            assert!((whole / sum - 1.0).abs() < 1e-6, "{whole} {sum}");
        }
    }
}
