//! Directions towards a sky, drawn in proportion to its radiance.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::cumulative::Cumulative;
use super::sample::LightSample;
use crate::math::elementary::sin_cos_turns;
use crate::scene::emission::Emission;
use crate::scene::sky::Sky;
use crate::spectrum::dense::{Lambdas, WAVES};
use crate::spectrum::sensor::MOST_CHANNELS;

/// A sky with the distributions that its samples follow.
#[derive(Debug)]
pub(super) struct SkySampler {
    sky: Sky,
    /// Cosines of the polar angles between rows, `height` + 1 values.
    edges: Vec<f64>,
    rows: Cumulative,
    /// Of each row.
    columns: Cumulative,
    /// One over the solid angle of a row's texels, 1/sr.
    inverse_solid_angles: Vec<f64>,
}

impl SkySampler {
    /// Sums the sky's radiance.
    pub(super) fn new(sky: Sky) -> Self {
        let [width, height] = sky.size();
        let weight = |texel: &[f32; 3]| texel.iter().map(|&v| f64::from(v)).sum();
        let weights: Vec<f64> = sky.texels().iter().map(weight).collect();
        let (columns, totals) = Cumulative::new(width, &weights);
        let edges: Vec<f64> = (0..=height).map(|row| (PI * row as f64 / height as f64).cos()).collect();
        let angle = |row: usize| solid_angle(&edges, row, width);
        let lines: Vec<f64> = totals.iter().enumerate().map(|(row, total)| total * angle(row)).collect();
        let (rows, _) = Cumulative::new(height, &lines);
        let inverse_solid_angles = (0..height).map(|row| 1.0 / angle(row)).collect();
        Self { sky, edges, rows, columns, inverse_solid_angles }
    }

    /// Row and column of the texel in a direction.
    #[inline(always)]
    pub(super) fn texel(&self, direction: DVec3) -> [usize; 2] {
        self.sky.texel(direction).into()
    }

    /// Radiance of a texel.
    #[inline(always)]
    pub(super) fn spectrum(&self, [row, column]: [usize; 2], wavelengths: Lambdas) -> [f64; WAVES] {
        self.sky.spectrum(row, column, wavelengths)
    }

    /// The spectra that its texels are sums of.
    pub(super) fn basis(&self) -> &[Emission] {
        self.sky.basis()
    }

    /// What a sensor sees of a texel, by what it sees of each of the sky's spectra.
    #[inline(always)]
    pub(super) fn glow<const LANES: usize>(
        &self,
        basis: &[[f64; MOST_CHANNELS]],
        [row, column]: [usize; 2],
    ) -> [f64; LANES] {
        let texel = &self.sky.texels()[row * self.sky.size()[0] + column];
        let mut seen = [0.0; LANES];
        for (weight, basis) in texel.iter().zip(basis) {
            for (sum, value) in seen.iter_mut().zip(basis) {
                *sum += f64::from(*weight) * value;
            }
        }
        seen
    }

    /// A direction drawn in proportion to the radiance.
    #[inline(always)]
    pub(super) fn sample(&self, u: DVec2, wavelengths: Lambdas) -> Option<LightSample> {
        let [width, _] = self.sky.size();
        let (row, v) = self.rows.invert(0, u.y);
        let (column, h) = self.columns.invert(row, u.x);
        // Uniform in solid angle within the texel: uniform in azimuth and in the cosine.
        let z = self.edges[row] + (self.edges[row + 1] - self.edges[row]) * v;
        let [sin, cos] = sin_cos_turns((column as f64 + h) / width as f64 + self.sky.turn());
        let sine = (1.0 - z * z).max(0.0).sqrt();
        let direction = self.sky.rotation() * DVec3::new(sine * sin, sine * cos, z);
        let pdf = self.texel_pdf([row, column]);
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
        self.texel_pdf(self.texel(direction))
    }

    /// The same for any direction of a texel.
    #[inline(always)]
    pub(super) fn texel_pdf(&self, [row, column]: [usize; 2]) -> f64 {
        self.rows.share(0, row) * self.columns.share(row, column) * self.inverse_solid_angles[row]
    }
}

/// Solid angle of a texel, sr.
fn solid_angle(edges: &[f64], row: usize, width: usize) -> f64 {
    TAU / width as f64 * (edges[row] - edges[row + 1])
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(sky.spectrum(sky.texel(sample.direction), Lambdas::splat(500.0)), sample.radiance);
        }
    }

    #[test]
    fn the_density_integrates_to_one() {
        let sky = sky();
        let total: f64 = (0..16)
            .flat_map(|row| (0..32).map(move |column| (row, column)))
            .map(|(row, column)| sky.texel_pdf([row, column]) * solid_angle(&sky.edges, row, 32))
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
        assert!(sky.spectrum(sky.texel(sample.direction), Lambdas::splat(550.0))[0] > 1.0);
        assert_eq!(sky.spectrum(sky.texel(DVec3::Y), Lambdas::splat(550.0)), [0.0; WAVES]);
        assert_eq!(sky.pdf(DVec3::Y), 0.0);
        // Rotated about y by 90°: what was at +x is at −z.
        let rotation = glam::DMat3::from_rotation_y(std::f64::consts::FRAC_PI_2);
        let rotated = SkySampler::new(sky.sky.clone().rotated(rotation));
        let again = rotated.sample(DVec2::new(0.5, 0.5), Lambdas::splat(550.0)).unwrap();
        assert!((again.direction - rotation * sample.direction).length() < 1e-12 && again.direction.z < -0.8);
        assert!((rotated.pdf(again.direction) / again.pdf - 1.0).abs() < 1e-9);
    }
}
