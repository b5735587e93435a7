//! Directions towards a sky, drawn in proportion to its radiance.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::sample::LightSample;
use crate::scene::sky::Sky;
use crate::spectrum::dense::{Lambdas, WAVES};

/// A sky with the distributions that its samples follow.
#[derive(Debug)]
pub(super) struct SkySampler {
    sky: Sky,
    /// Cosines of the polar angles between rows, `height` + 1 values.
    edges: Vec<f64>,
    /// Cumulative distribution over rows, `height` + 1 values.
    rows: Vec<f64>,
    /// Cumulative distribution over columns in each row, `width` + 1 values a row.
    columns: Vec<f64>,
}

impl SkySampler {
    /// Sums the sky's radiance.
    pub(super) fn new(sky: Sky) -> Self {
        let [width, height] = sky.size();
        let texels = sky.texels();
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
        rows.iter_mut().for_each(|v| *v /= total);
        Self { sky, edges, rows, columns }
    }

    /// Radiance from a direction.
    pub(super) fn radiance(&self, direction: DVec3, wavelengths: Lambdas) -> [f64; WAVES] {
        self.sky.radiance(direction, wavelengths)
    }

    /// A direction drawn in proportion to the radiance.
    pub(super) fn sample(&self, u: DVec2, wavelengths: Lambdas) -> Option<LightSample> {
        let [width, _] = self.sky.size();
        let (row, v) = invert(&self.rows, u.y);
        let (column, h) = invert(&self.columns[row * (width + 1)..][..=width], u.x);
        // Uniform in solid angle within the texel: uniform in azimuth and in the cosine.
        let z = self.edges[row] + (self.edges[row + 1] - self.edges[row]) * v;
        let (sin, cos) = (TAU * ((column as f64 + h) / width as f64 + self.sky.turn())).sin_cos();
        let sine = (1.0 - z * z).max(0.0).sqrt();
        let direction = self.sky.rotation() * DVec3::new(sine * sin, sine * cos, z);
        let pdf = self.texel_pdf(row, column);
        (pdf > 0.0).then(|| LightSample {
            direction,
            distance: f64::INFINITY,
            pdf,
            radiance: self.sky.spectrum(row, column, wavelengths),
            is_point: false,
        })
    }

    /// Density with which [`SkySampler::sample`] draws a direction, 1/sr.
    pub(super) fn pdf(&self, direction: DVec3) -> f64 {
        let (row, column) = self.sky.texel(direction);
        self.texel_pdf(row, column)
    }

    fn texel_pdf(&self, row: usize, column: usize) -> f64 {
        let [width, _] = self.sky.size();
        let line = &self.columns[row * (width + 1)..];
        let share = (self.rows[row + 1] - self.rows[row]) * (line[column + 1] - line[column]);
        share / solid_angle(&self.edges, row, width)
    }
}

/// Solid angle of a texel, sr.
fn solid_angle(edges: &[f64], row: usize, width: usize) -> f64 {
    TAU / width as f64 * (edges[row] - edges[row + 1])
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
    use crate::scene::emission::Emission;

    fn sky() -> SkySampler {
        let emission = Emission::new(|_| 1.0).unwrap();
        SkySampler::new(Sky::grey(32, 16, emission, |d| (1.2 + d.z + 0.5 * d.x).max(0.0)).unwrap())
    }

    #[test]
    fn samples_have_the_stated_density_and_radiance() {
        let sky = sky();
        let mut stream = crate::math::rng::Stream::new(1, &[]);
        for _ in 0..2000 {
            let u = DVec2::new(stream.unit(), stream.unit());
            let sample = sky.sample(u, Lambdas::splat(500.0)).unwrap();
            assert!((sample.direction.length() - 1.0).abs() < 1e-12);
            assert!((sky.pdf(sample.direction) / sample.pdf - 1.0).abs() < 1e-9);
            assert_eq!(sky.radiance(sample.direction, Lambdas::splat(500.0)), sample.radiance);
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
        let sky = SkySampler::new(Sky::image(64, 32, rgb, 2.0, 90.0).unwrap());
        let sample = sky.sample(DVec2::new(0.5, 0.5), Lambdas::splat(550.0)).unwrap();
        // Column 0 begins at +y; turned by 90° it begins at +x.
        assert!(sample.direction.x > 0.8 && sample.direction.y.abs() < 0.1, "{}", sample.direction);
        assert!((sky.pdf(sample.direction) / sample.pdf - 1.0).abs() < 1e-9);
        assert!(sky.radiance(sample.direction, Lambdas::splat(550.0))[0] > 1.0);
        assert_eq!(sky.radiance(DVec3::Y, Lambdas::splat(550.0)), [0.0; WAVES]);
        // Rotated about y by 90°: what was at +x is at −z.
        let rotation = glam::DMat3::from_rotation_y(std::f64::consts::FRAC_PI_2);
        let rotated = SkySampler::new(sky.sky.clone().rotated(rotation));
        let again = rotated.sample(DVec2::new(0.5, 0.5), Lambdas::splat(550.0)).unwrap();
        assert!((again.direction - rotation * sample.direction).length() < 1e-12 && again.direction.z < -0.8);
        assert!((rotated.pdf(again.direction) / again.pdf - 1.0).abs() < 1e-9);
    }
}
