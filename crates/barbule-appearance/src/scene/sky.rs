//! A sky: radiance on an equirectangular grid.

use std::f64::consts::{PI, TAU};

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use super::emission::Emission;
use super::primaries::primaries;
use crate::math::elementary::{ROUGH, atan2, atan2_rough};
use crate::spectrum::dense::{Lambdas, WAVES};
use crate::{Error, Result};

/// Radiance from all directions. Row 0 is at the zenith (+z), the last at the nadir; columns go clockwise from +y
/// seen from above, as azimuths of lights do. Constant within a texel. A copy costs nothing.
#[derive(Debug, Clone)]
pub struct Sky {
    width: usize,
    height: usize,
    /// By how much the map is turned clockwise seen from above, in whole turns.
    turn: f64,
    /// From the map's directions to the scene's.
    rotation: DMat3,
    /// Weights of the three emissions, per texel.
    texels: Arc<[[f32; 3]]>,
    /// Spectra of the three weights: one alone (a grey sky) or those of red, green and blue.
    basis: Arc<[Emission]>,
}

/// The sky with its share of the samples.
#[derive(Debug, Clone)]
pub struct Environment {
    /// Radiance from everywhere.
    pub sky: Sky,
    /// How often it is chosen, relative to the lamps; over 0.
    pub weight: f64,
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
        if texels.iter().flatten().all(|v| *v <= 0.0) {
            return Err(Error::input("a sky must shine somewhere"));
        }
        Ok(Self {
            width,
            height,
            turn: 0.0,
            rotation: DMat3::IDENTITY,
            texels: texels.into(),
            basis: basis.into(),
        })
    }

    /// The sky after a further rotation about the origin.
    #[must_use]
    pub fn rotated(self, rotation: DMat3) -> Self {
        Self { rotation: rotation * self.rotation, ..self }
    }

    /// From the map's directions to the scene's.
    #[must_use]
    pub fn rotation(&self) -> DMat3 {
        self.rotation
    }

    /// Columns and rows of the map.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// By how much the map is turned clockwise seen from above, in whole turns.
    #[must_use]
    pub fn turn(&self) -> f64 {
        self.turn
    }

    /// Weights of the spectra per texel, row by row.
    #[must_use]
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    /// The spectra that texels weigh: one or three.
    #[must_use]
    pub fn basis(&self) -> &[Emission] {
        &self.basis
    }

    /// Irradiance over π that a surface facing the map's zenith gets, as weights of the spectra.
    #[must_use]
    pub fn irradiance(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for row in 0..self.height {
            // ∫ cosθ dω between the row's polar angles over its columns; below the horizon there is none.
            let [above, below] =
                [row, row + 1].map(|edge| (PI * edge as f64 / self.height as f64).cos().max(0.0));
            let share = (above * above - below * below) / self.width as f64;
            for texel in &self.texels[row * self.width..][..self.width] {
                for (sum, weight) in sum.iter_mut().zip(texel) {
                    *sum += share * f64::from(*weight);
                }
            }
        }
        sum
    }

    /// Radiance from a direction.
    #[must_use]
    pub fn radiance(&self, direction: DVec3, wavelengths: Lambdas) -> [f64; WAVES] {
        let (row, column) = self.texel(direction);
        self.spectrum(row, column, wavelengths)
    }

    /// Row and column of the texel in a direction.
    #[inline(always)]
    #[must_use]
    pub fn texel(&self, direction: DVec3) -> (usize, usize) {
        let direction = self.rotation.transpose() * direction;
        let across = (direction.x * direction.x + direction.y * direction.y).sqrt();
        let rough = [atan2_rough(across, direction.z), atan2_rough(direction.x, direction.y)];
        let (row, column) = self.place(rough);
        let (rows, columns) = (ROUGH / PI * self.height as f64, ROUGH / TAU * self.width as f64);
        // Near an edge between texels it takes more care.
        let is_sure = |place: f64, doubt: f64| (place - (place + 0.5).floor()).abs() > doubt;
        let (row, column) = if is_sure(row, rows) && is_sure(column, columns) {
            (row, column)
        } else {
            self.place([atan2(across, direction.z), atan2(direction.x, direction.y)])
        };
        ((row as usize).min(self.height - 1), (column as usize).min(self.width - 1))
    }

    /// Rows and columns from the map's upper left corner to a polar angle and an azimuth, rad.
    #[inline(always)]
    fn place(&self, [polar, azimuth]: [f64; 2]) -> (f64, f64) {
        let turns = azimuth * (1.0 / TAU) - self.turn;
        (polar * (1.0 / PI) * self.height as f64, (turns - turns.floor()) * self.width as f64)
    }

    /// Radiance of a texel.
    #[inline(always)]
    #[must_use]
    pub fn spectrum(&self, row: usize, column: usize, wavelengths: Lambdas) -> [f64; WAVES] {
        let texel = &self.texels[row * self.width + column];
        let mut radiance = [0.0; WAVES];
        for (weight, emission) in texel.iter().zip(self.basis.iter()) {
            for (sum, value) in radiance.iter_mut().zip(emission.at_each(wavelengths)) {
                *sum += f64::from(*weight) * value;
            }
        }
        radiance
    }
}

/// The direction of a point of the map, both coordinates 0 … 1.
fn direction_of(point: DVec2) -> DVec3 {
    let (sin_polar, cos_polar) = (PI * point.y).sin_cos();
    let (sin_azimuth, cos_azimuth) = (TAU * point.x).sin_cos();
    DVec3::new(sin_polar * sin_azimuth, sin_polar * cos_azimuth, cos_polar)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_colours_are_cut_and_what_is_no_number_is_refused() {
        let image = |value: f32| Sky::image(2, 1, vec![[value, 1.0, 0.0]; 2], 1.0, 0.0);
        assert_eq!(
            image(-1.0).unwrap().radiance(DVec3::Z, Lambdas::splat(650.0)),
            image(0.0).unwrap().radiance(DVec3::Z, Lambdas::splat(650.0))
        );
        assert!(image(f32::NAN).is_err() && image(f32::INFINITY).is_err());
        assert!(Sky::image(2, 1, vec![[0.0; 3]; 2], 1.0, 0.0).is_err());
        assert!(Sky::image(2, 1, vec![[1.0; 3]; 2], -1.0, 0.0).is_err());
    }

    /// By arc functions of `libm`, for directions anywhere and a hair's breadth from the edges of texels.
    #[test]
    fn texels_are_those_of_the_exact_angles() {
        let emission = Emission::new(|_| 1.0).unwrap();
        let sky = Sky::grey(64, 32, emission, |_| 1.0).unwrap();
        let mut stream = crate::math::rng::Stream::new(9, &[]);
        for k in 0..50_000 {
            let mut point = [stream.uniform(0.0, 1.0), stream.uniform(0.01, 0.99)];
            if k % 2 == 0 {
                let near = stream.uniform(1e-12, 1e-6) * f64::from(k % 4 - 1);
                point = [(point[0] * 64.0).round() / 64.0 + near, (point[1] * 32.0).round() / 32.0 + near];
            }
            let direction = direction_of(DVec2::from(point));
            let polar = libm::atan2(direction.x.hypot(direction.y), direction.z);
            let turns = (libm::atan2(direction.x, direction.y) / TAU).rem_euclid(1.0);
            assert_eq!(
                sky.texel(direction),
                ((polar / PI * 32.0) as usize, (turns * 64.0) as usize),
                "{point:?}"
            );
        }
    }

    #[test]
    fn a_dark_sky_is_refused() {
        let emission = Emission::new(|_| 1.0).unwrap();
        assert!(Sky::grey(4, 2, emission, |_| 0.0).is_err());
    }
}
