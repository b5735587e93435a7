//! The film: sums per pixel, in tiles with sample counts of their own.

use std::sync::LazyLock;

use super::integrator::Sample;
use crate::spectrum::colour::{Illuminant, matching, rgb_from_xyz, xyz_from_rgb};
use crate::spectrum::dense::{LONGEST_NM, SHORTEST_NM, VALUES};
use crate::{Error, Result};

/// Side of a tile, pixels.
pub const TILE: u32 = 32;

/// The colour-matching functions at the renderer's wavelengths, each scaled so that daylight (D65, 1 at 560 nm) cut to
/// 380 … 720 nm has exactly the X, Y and Z of sRGB's white.
static MATCHING: LazyLock<Vec<[f64; 3]>> = LazyLock::new(|| {
    let nm = |i: usize| SHORTEST_NM + i as f64;
    let mut table: Vec<[f64; 3]> = (0..VALUES).map(|i| matching(nm(i))).collect();
    let mut sums = [0.0; 3];
    for (i, row) in table.iter().enumerate() {
        let weight = if i == 0 || i + 1 == VALUES { 0.5 } else { 1.0 };
        let daylight = weight * Illuminant::D65.power(nm(i)) / Illuminant::D65.power(560.0);
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += daylight * value;
        }
    }
    let white = xyz_from_rgb([1.0; 3]);
    for row in &mut table {
        for k in 0..3 {
            row[k] *= white[k] / sums[k];
        }
    }
    table
});

/// One pixel's sums.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pixel {
    /// CIE XYZ; daylight of radiance 1 from everywhere on white gives Y = 1.
    pub xyz: [f64; 3],
    /// Squares of Y.
    pub squares: f64,
    /// Shading normals of first hits.
    pub normal: [f64; 3],
    /// Distances of first hits, mm.
    pub depth: f64,
    /// How many samples hit something.
    pub hits: u32,
    /// Identity of the object that the first sample hit, 0 for none.
    pub id: u32,
}

/// Bytes that a film takes per pixel while it is rendered: its sums, and those of the tiles in work.
pub const BYTES_PER_PIXEL: usize = 2 * size_of::<Pixel>();

/// Refuses sizes that no film can have.
///
/// # Errors
/// A side of 0 or over 16384 pixels.
pub fn check_size(size: [u32; 2]) -> Result<()> {
    if size.iter().all(|s| (1..=16384).contains(s)) {
        return Ok(());
    }
    Err(Error::input(format!("a picture of {}x{} pixels: each side must be 1 to 16384", size[0], size[1])))
}

/// A picture in the making.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    size: [u32; 2],
    /// Row by row.
    pub(super) pixels: Vec<Pixel>,
    /// Samples per pixel of each tile, row by row.
    pub(super) counts: Vec<u32>,
}

impl Film {
    /// A black film.
    ///
    /// # Errors
    /// As [`check_size`].
    pub fn new(size: [u32; 2]) -> Result<Self> {
        check_size(size)?;
        let tiles = size.map(|s| s.div_ceil(TILE) as usize);
        Ok(Self {
            size,
            pixels: vec![Pixel::default(); size[0] as usize * size[1] as usize],
            counts: vec![0; tiles[0] * tiles[1]],
        })
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Number of tiles.
    #[must_use]
    pub fn tiles(&self) -> usize {
        self.counts.len()
    }

    /// Samples per pixel of the tile that a pixel lies in.
    #[must_use]
    pub fn count(&self, x: u32, y: u32) -> u32 {
        let across = self.size[0].div_ceil(TILE);
        self.counts[(y / TILE * across + x / TILE) as usize]
    }

    /// All samples taken so far.
    #[must_use]
    pub fn samples(&self) -> u64 {
        (0..self.tiles())
            .map(|tile| {
                let [x0, y0, x1, y1] = self.bounds(tile);
                u64::from((x1 - x0) * (y1 - y0)) * u64::from(self.counts[tile])
            })
            .sum()
    }

    /// The pixels of a tile: x from, y from, x to, y to.
    #[must_use]
    pub fn bounds(&self, tile: usize) -> [u32; 4] {
        let across = self.size[0].div_ceil(TILE);
        let (x, y) = (tile as u32 % across * TILE, tile as u32 / across * TILE);
        [x, y, (x + TILE).min(self.size[0]), (y + TILE).min(self.size[1])]
    }

    /// A pixel's sums.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> &Pixel {
        &self.pixels[(y * self.size[0] + x) as usize]
    }

    /// Mean XYZ of a pixel; zero before its first sample.
    #[must_use]
    pub fn xyz(&self, x: u32, y: u32) -> [f64; 3] {
        let count = f64::from(self.count(x, y).max(1));
        self.pixel(x, y).xyz.map(|v| v / count)
    }

    /// Variance of a pixel's mean Y.
    #[must_use]
    pub fn variance(&self, x: u32, y: u32) -> f64 {
        self.pixel(x, y).variance(self.count(x, y))
    }

    /// Linear sRGB, row by row.
    #[must_use]
    pub fn linear_srgb(&self) -> Vec<[f32; 3]> {
        let [width, height] = self.size;
        (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| rgb_from_xyz(self.xyz(x, y)).map(|v| v as f32))
            .collect()
    }
}

impl Pixel {
    /// Adds one sample.
    pub fn add(&mut self, sample: &Sample, is_first: bool) {
        let matching = &*MATCHING;
        let mut xyz = [0.0; 3];
        for (radiance, nm) in sample.radiance.iter().zip(sample.hero.wavelengths.nm()) {
            let at = (nm - SHORTEST_NM).clamp(0.0, LONGEST_NM - SHORTEST_NM);
            let index = (at as usize).min(VALUES - 2);
            let rest = at - index as f64;
            for k in 0..3 {
                let value = matching[index][k] + (matching[index + 1][k] - matching[index][k]) * rest;
                xyz[k] += 0.25 * radiance * value;
            }
        }
        for (sum, value) in self.xyz.iter_mut().zip(xyz) {
            *sum += value;
        }
        self.squares += xyz[1] * xyz[1];
        if sample.first.id != 0 {
            for (sum, value) in self.normal.iter_mut().zip(sample.first.normal.to_array()) {
                *sum += value;
            }
            self.depth += sample.first.depth;
            self.hits += 1;
        }
        if is_first {
            self.id = sample.first.id;
        }
    }

    /// Variance of the mean Y after `count` samples; 0 before the second.
    #[must_use]
    pub fn variance(&self, count: u32) -> f64 {
        let n = f64::from(count);
        if count < 2 {
            return 0.0;
        }
        let mean = self.xyz[1] / n;
        ((self.squares / n - mean * mean).max(0.0)) / (n - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::integrator::{FirstHit, NO_HIT};
    use crate::render::wavelengths::Hero;

    #[test]
    fn daylight_of_radiance_1_is_white() {
        let mut pixel = Pixel::default();
        let count = 4096;
        for i in 0..count {
            let hero = Hero::new((f64::from(i) + 0.5) / f64::from(count));
            let daylight = |w: f64| Illuminant::D65.power(w) / Illuminant::D65.power(560.0);
            let radiance = std::array::from_fn(|k| daylight(hero.wavelengths.nm()[k]) / hero.pdf[k]);
            pixel.add(&Sample { radiance, hero, first: NO_HIT }, i == 0);
        }
        let rgb = rgb_from_xyz(pixel.xyz.map(|v| v / f64::from(count)));
        // Quadrature of the sharp lines of D65's table: 1e-4.
        assert!(rgb.iter().all(|v| (v - 1.0).abs() < 1e-4), "{rgb:?}");
    }

    #[test]
    fn tiles_cover_every_pixel_once() {
        let film = Film::new([70, 33]).unwrap();
        let mut seen = vec![0; 70 * 33];
        for tile in 0..film.tiles() {
            let [x0, y0, x1, y1] = film.bounds(tile);
            for y in y0..y1 {
                for x in x0..x1 {
                    seen[(y * 70 + x) as usize] += 1;
                }
            }
        }
        assert!(seen.iter().all(|s| *s == 1));
        assert!(Film::new([0, 5]).is_err() && Film::new([20_000, 5]).is_err());
    }

    #[test]
    fn the_variance_is_that_of_the_mean() {
        let mut pixel = Pixel::default();
        for y in [1.0, 3.0] {
            pixel.xyz[1] += y;
            pixel.squares += y * y;
        }
        // Samples 1 and 3: variance 2, of their mean 1.
        assert!((pixel.variance(2) - 1.0).abs() < 1e-12);
        let first = FirstHit { id: 3, ..NO_HIT };
        assert_eq!((first.id, pixel.variance(1)), (3, 0.0));
    }
}
