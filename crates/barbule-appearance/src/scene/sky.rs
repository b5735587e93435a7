//! A sky: radiance on an equirectangular grid, sampled in proportion to it.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::emission::Emission;
use super::light::LightSample;
use super::primaries::primaries;
use crate::{Error, Result};

/// Radiance from all directions. Row 0 is at the zenith (+z), the last at the nadir; columns go clockwise from +y
/// seen from above, as azimuths of lights do. Constant within a texel.
#[derive(Debug, Clone)]
pub struct Sky {
    width: usize,
    height: usize,
    /// By how much the map is turned clockwise seen from above, in whole turns.
    turn: f64,
    /// Weights of the three emissions, per texel.
    texels: Vec<[f32; 3]>,
    /// Spectra of the three weights: one alone (a grey sky) or those of red, green and blue.
    basis: Vec<Emission>,
    /// Cosines of the polar angles between rows, `height` + 1 values.
    edges: Vec<f64>,
    /// Cumulative distribution over rows, `height` + 1 values.
    rows: Vec<f64>,
    /// Cumulative distribution over columns in each row, `width` + 1 values a row.
    columns: Vec<f64>,
}

impl Sky {
    /// A sky without colour of its own: `luminance(direction)` times one spectrum.
    ///
    /// # Errors
    /// Negative, not finite or everywhere zero.
    pub fn grey(
        width: usize,
        height: usize,
        emission: Emission,
        luminance: impl Fn(DVec3) -> f64,
    ) -> Result<Self> {
        let texels = (0..height * width)
            .map(|i| {
                let u = DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
                [luminance(direction_of(u / DVec2::new(width as f64, height as f64))) as f32, 0.0, 0.0]
            })
            .collect();
        Self::build(width, height, texels, vec![emission])
    }

    /// A sky from an image of linear sRGB in which 1 is the radiance of daylight, with the spectra of
    /// [`primaries`]; negative components (colours outside sRGB) count as 0.
    ///
    /// `strength` multiplies it; `turn` turns it clockwise seen from above, degrees.
    ///
    /// # Errors
    /// The size is not `width` × `height`, a value is not finite, or none is over zero.
    pub fn image(
        width: usize,
        height: usize,
        mut rgb: Vec<[f32; 3]>,
        strength: f64,
        turn: f64,
    ) -> Result<Self> {
        if !((0.0..=1e6).contains(&strength) && turn.is_finite()) {
            return Err(Error::input(format!(
                "a sky's strength is {strength} and its turn {turn}; give a strength of 0 to 1000000 and a turn in degrees"
            )));
        }
        for value in rgb.iter_mut().flatten() {
            // Not max(): it would hide what is not a number.
            *value = if *value < 0.0 { 0.0 } else { *value * strength as f32 };
        }
        let sky = Self::build(width, height, rgb, primaries()?.to_vec())?;
        Ok(Self { turn: turn / 360.0, ..sky })
    }

    fn build(width: usize, height: usize, texels: Vec<[f32; 3]>, basis: Vec<Emission>) -> Result<Self> {
        if width == 0 || height == 0 || texels.len() != width * height {
            return Err(Error::input(format!(
                "a sky of {width} x {height} needs as many texels, not {}",
                texels.len()
            )));
        }
        if texels.iter().flatten().any(|v| !v.is_finite() || *v < 0.0) {
            return Err(Error::input("a sky's radiance must be finite and not negative"));
        }
        let edges: Vec<f64> = (0..=height).map(|row| (PI * row as f64 / height as f64).cos()).collect();
        let mut rows = vec![0.0; height + 1];
        let mut columns = vec![0.0; (width + 1) * height];
        for row in 0..height {
            let line = &mut columns[row * (width + 1)..][..=width];
            for column in 0..width {
                let weight: f64 = texels[row * width + column].iter().map(|&v| f64::from(v)).sum();
                line[column + 1] = line[column] + weight;
            }
            let total = line[width];
            if total > 0.0 {
                line.iter_mut().for_each(|v| *v /= total);
            }
            rows[row + 1] = rows[row] + total * solid_angle(&edges, row, width);
        }
        let total = rows[height];
        if total <= 0.0 {
            return Err(Error::input("a sky must shine somewhere"));
        }
        rows.iter_mut().for_each(|v| *v /= total);
        Ok(Self { width, height, turn: 0.0, texels, basis, edges, rows, columns })
    }

    /// Radiance from a direction.
    #[must_use]
    pub fn radiance(&self, direction: DVec3, wavelengths_nm: [f64; 4]) -> [f64; 4] {
        let (row, column) = self.texel(direction);
        self.spectrum(row, column, wavelengths_nm)
    }

    /// A direction drawn in proportion to the radiance.
    #[must_use]
    pub fn sample(&self, u: DVec2, wavelengths_nm: [f64; 4]) -> Option<LightSample> {
        let (row, v) = invert(&self.rows, u.y);
        let (column, h) = invert(&self.columns[row * (self.width + 1)..][..=self.width], u.x);
        // Uniform in solid angle within the texel: uniform in azimuth and in the cosine.
        let z = self.edges[row] + (self.edges[row + 1] - self.edges[row]) * v;
        let (sin, cos) = (TAU * ((column as f64 + h) / self.width as f64 + self.turn)).sin_cos();
        let sine = (1.0 - z * z).max(0.0).sqrt();
        let direction = DVec3::new(sine * sin, sine * cos, z);
        let pdf = self.texel_pdf(row, column);
        (pdf > 0.0).then(|| LightSample {
            direction,
            distance: f64::INFINITY,
            pdf,
            radiance: self.spectrum(row, column, wavelengths_nm),
        })
    }

    /// Density with which [`Sky::sample`] draws a direction, 1/sr.
    #[must_use]
    pub fn pdf(&self, direction: DVec3) -> f64 {
        let (row, column) = self.texel(direction);
        self.texel_pdf(row, column)
    }

    fn texel_pdf(&self, row: usize, column: usize) -> f64 {
        let line = &self.columns[row * (self.width + 1)..];
        let share = (self.rows[row + 1] - self.rows[row]) * (line[column + 1] - line[column]);
        share / solid_angle(&self.edges, row, self.width)
    }

    fn texel(&self, direction: DVec3) -> (usize, usize) {
        let row = (direction.z.clamp(-1.0, 1.0).acos() / PI * self.height as f64) as usize;
        let turns = (direction.x.atan2(direction.y) / TAU - self.turn).rem_euclid(1.0);
        let column = (turns * self.width as f64) as usize;
        (row.min(self.height - 1), column.min(self.width - 1))
    }

    fn spectrum(&self, row: usize, column: usize, wavelengths_nm: [f64; 4]) -> [f64; 4] {
        let texel = &self.texels[row * self.width + column];
        let mut radiance = [0.0; 4];
        for (weight, emission) in texel.iter().zip(&self.basis) {
            for (sum, value) in radiance.iter_mut().zip(emission.at4(wavelengths_nm)) {
                *sum += f64::from(*weight) * value;
            }
        }
        radiance
    }
}

/// Solid angle of a texel, sr.
fn solid_angle(edges: &[f64], row: usize, width: usize) -> f64 {
    TAU / width as f64 * (edges[row] - edges[row + 1])
}

/// The direction of a point of the map, both coordinates 0 … 1.
fn direction_of(point: DVec2) -> DVec3 {
    let (sin_polar, cos_polar) = (PI * point.y).sin_cos();
    let (sin_azimuth, cos_azimuth) = (TAU * point.x).sin_cos();
    DVec3::new(sin_polar * sin_azimuth, sin_polar * cos_azimuth, cos_polar)
}

/// The interval of a cumulative distribution that holds `u`, and where in it, 0 … 1.
fn invert(cumulative: &[f64], u: f64) -> (usize, f64) {
    let last = cumulative.len() - 2;
    let mut index = (cumulative.partition_point(|&c| c <= u).max(1) - 1).min(last);
    // Rounding may end in an interval of no weight; the one before has some.
    while index > 0 && cumulative[index + 1] <= cumulative[index] {
        index -= 1;
    }
    let width = cumulative[index + 1] - cumulative[index];
    (index, if width > 0.0 { ((u - cumulative[index]) / width).clamp(0.0, 1.0) } else { 0.5 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky() -> Sky {
        let emission = Emission::new(|_| 1.0).unwrap();
        Sky::grey(32, 16, emission, |d| (1.2 + d.z + 0.5 * d.x).max(0.0)).unwrap()
    }

    #[test]
    fn samples_have_the_stated_density_and_radiance() {
        let sky = sky();
        let mut stream = crate::math::rng::Stream::new(1, &[]);
        for _ in 0..2000 {
            let u = DVec2::new(stream.unit(), stream.unit());
            let sample = sky.sample(u, [500.0; 4]).unwrap();
            assert!((sample.direction.length() - 1.0).abs() < 1e-12);
            assert!((sky.pdf(sample.direction) / sample.pdf - 1.0).abs() < 1e-9);
            assert_eq!(sky.radiance(sample.direction, [500.0; 4]), sample.radiance);
        }
    }

    #[test]
    fn the_density_integrates_to_one() {
        let sky = sky();
        let total: f64 = (0..16)
            .flat_map(|row| (0..32).map(move |column| (row, column)))
            .map(|(row, column)| sky.texel_pdf(row, column) * solid_angle(&sky.edges, row, 32))
            .sum();
        assert!((total - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_turned_image_is_seen_and_sampled_where_it_was_turned_to() {
        let mut rgb = vec![[0.0; 3]; 64 * 32];
        rgb[10 * 64] = [3.0, 1.0, 0.5];
        let sky = Sky::image(64, 32, rgb, 2.0, 90.0).unwrap();
        let sample = sky.sample(DVec2::new(0.5, 0.5), [550.0; 4]).unwrap();
        // Column 0 begins at +y; turned by 90° it begins at +x.
        assert!(sample.direction.x > 0.8 && sample.direction.y.abs() < 0.1, "{}", sample.direction);
        assert!((sky.pdf(sample.direction) / sample.pdf - 1.0).abs() < 1e-9);
        assert!(sky.radiance(sample.direction, [550.0; 4])[0] > 1.0);
        assert_eq!(sky.radiance(DVec3::Y, [550.0; 4]), [0.0; 4]);
    }

    #[test]
    fn negative_colours_are_cut_and_what_is_no_number_is_refused() {
        let image = |value: f32| Sky::image(2, 1, vec![[value, 1.0, 0.0]; 2], 1.0, 0.0);
        assert_eq!(
            image(-1.0).unwrap().radiance(DVec3::Z, [650.0; 4]),
            image(0.0).unwrap().radiance(DVec3::Z, [650.0; 4])
        );
        assert!(image(f32::NAN).is_err() && image(f32::INFINITY).is_err());
        assert!(Sky::image(2, 1, vec![[0.0; 3]; 2], 1.0, 0.0).is_err());
        assert!(Sky::image(2, 1, vec![[1.0; 3]; 2], -1.0, 0.0).is_err());
    }

    #[test]
    fn a_dark_sky_is_refused() {
        let emission = Emission::new(|_| 1.0).unwrap();
        assert!(Sky::grey(4, 2, emission, |_| 0.0).is_err());
    }
}
