//! The film: sums per pixel, in tiles with sample counts of their own.

use std::sync::Arc;

use super::faults::{Fault, Faults};
use super::integrator::{Behind, NO_HIT, Sample};
pub use super::pixel::{Pixel, RUNS};
use super::planes::{Compositing, Planes};
use super::response::{Response, Rows, lanes, seen};
use crate::identity::hash;
use crate::progress::Shard;
use crate::spectrum::colour::rgb_from_xyz;
use crate::spectrum::dense::WAVES;
use crate::spectrum::sensor::{MOST_CHANNELS, Sensor};
use crate::{Error, Result};

mod share;

/// Side of a tile, pixels.
pub const TILE: u32 = 32;

/// A tile's share of the picture: each of its samples adds to the four pixels whose tents it lies in, also to those just
/// outside, so that tiles need nothing from each other while they grow.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Tile {
    /// Samples per pixel.
    pub(super) count: u32,
    /// Those that were left out.
    pub(super) faults: Faults,
    /// Of each pixel the sensor's channels, alpha and the tent itself; of the human eye daylight of radiance 1 from everywhere on white
    /// gives Y = 1. Row by row, with a border of one pixel.
    pub(super) sums: Vec<f64>,
    /// Of the pixels without the border.
    pub(super) pixels: Vec<Pixel>,
    /// Of the same pixels, where the film keeps it.
    pub(super) compositing: Vec<Compositing>,
    /// Likewise the sums of the albedos of first hits as the sensor's channels see them.
    pub(super) albedo: Vec<f64>,
    /// Likewise the sums of the sensor's channels, of the pixel's own samples alone.
    pub(super) own: Vec<f64>,
    /// Radiance in the film's bands, pixel by pixel as in `sums`.
    pub(super) spectra: Vec<f64>,
}

/// Bytes that a film takes per pixel while it is rendered: its sums, and those of the tiles in work.
#[must_use]
pub fn bytes_per_pixel(planes: &Planes) -> usize {
    let albedo = lanes(&planes.sensor) * size_of::<f64>();
    let compositing = if planes.compositing { size_of::<Compositing>() + 2 * albedo } else { 0 };
    let bordered = stride(&planes.sensor) * size_of::<f64>() + size_of_val(planes.spectral.nm());
    2 * (size_of::<Pixel>() + compositing + bordered * 9 / 8)
}

/// Numbers that a pixel sums up: its channels, alpha and the tent.
pub(super) fn stride(sensor: &Sensor) -> usize {
    lanes(sensor) + 2
}

/// The part of a tent of half width 1, the filter of a pixel, that lies in the pixel itself; the rest is in both
/// neighbours.
const INSIDE: f64 = 0.75;
const BESIDE: f64 = 0.125;

/// The same of the tent's square.
const SQUARE_INSIDE: f64 = 7.0 / 12.0;
const SQUARE_BESIDE: f64 = 1.0 / 24.0;

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
    planes: Planes,
    response: Arc<Response>,
    /// Which part of the picture it holds.
    shard: Shard,
    /// The tiles of that part, in their order.
    held: Vec<usize>,
    /// Row by row; those that are not held are empty.
    pub(super) tiles: Vec<Tile>,
}

impl Film {
    /// A black film of colour, normals and depth, seen by the human eye.
    ///
    /// # Errors
    /// As [`check_size`].
    pub fn new(size: [u32; 2]) -> Result<Self> {
        Self::with(size, Planes::default())
    }

    /// A black film of any sensor, with further planes.
    ///
    /// # Errors
    /// As [`check_size`].
    pub fn with(size: [u32; 2], planes: Planes) -> Result<Self> {
        Self::part(size, planes, Shard::WHOLE)
    }

    /// Shows on a screen what another sensor with the same channels makes of them.
    ///
    /// # Errors
    /// Its channels are others than those that the film was made with.
    pub fn show_by(&mut self, sensor: Sensor) -> Result<()> {
        if hash("sensor", &sensor) != hash("sensor", &self.planes.sensor) {
            return Err(Error::input(format!(
                "a film of the channels of '{}' cannot be shown by those of '{}'",
                self.planes.sensor.name(),
                sensor.name()
            )));
        }
        self.planes.sensor = sensor;
        Ok(())
    }

    /// Who sees it, and what it keeps beside what is seen, normals and depth.
    #[must_use]
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// The sensor as samples are added.
    pub(super) fn response(&self) -> &Response {
        &self.response
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Number of tiles.
    #[must_use]
    pub fn tiles(&self) -> usize {
        self.tiles.len()
    }

    /// Samples per pixel of the tile that a pixel lies in.
    #[must_use]
    pub fn count(&self, x: u32, y: u32) -> u32 {
        self.tiles[self.tile_at(x, y)].count
    }

    /// All samples taken so far.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.tiles.iter().map(|tile| tile.pixels.len() as u64 * u64::from(tile.count)).sum()
    }

    /// Samples that no light can make, which are left out of everything else that the film keeps.
    #[must_use]
    pub fn faults(&self) -> Faults {
        self.tiles.iter().fold(Faults::default(), |all, tile| all.with(&tile.faults))
    }

    /// The pixels of a tile: x from, y from, x to, y to.
    #[must_use]
    pub fn bounds(&self, tile: usize) -> [u32; 4] {
        bounds(self.size, tile)
    }

    /// What a pixel knows of its own samples; nothing of those that a part of a picture does not hold.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> &Pixel {
        let tile = self.tile_at(x, y);
        let [x0, y0, x1, _] = self.bounds(tile);
        self.tiles[tile].pixels.get(((y - y0) * (x1 - x0) + x - x0) as usize).unwrap_or(&Pixel::EMPTY)
    }

    /// Noise of the tile that has most of it: the standard error of a pixel's luminance over the luminance (with 0.05 added), mean over the
    /// tile, which a [`Goal`](super::run::Goal) may ask for. `None` where a tile has less than two samples, of which nothing is known.
    #[must_use]
    pub fn noise(&self) -> Option<f64> {
        let known = self.tiles.iter().all(|tile| tile.count >= 2);
        known.then(|| self.tiles.iter().map(Tile::noise).fold(0.0, f64::max))
    }

    /// Means of the sensor's channels of a pixel through its tent; zero before its first sample. The mean is over the samples' own
    /// weights, so light that is the same everywhere has no noise, and where a part of the tent lies outside the picture or in a
    /// tile without samples it is that of the rest.
    #[must_use]
    pub fn channels(&self, x: u32, y: u32) -> Vec<f64> {
        self.seen(x, y)[..self.planes.sensor.channels().len()].to_vec()
    }

    /// CIE XYZ of the same as [`Sensor::xyz`] makes it.
    #[must_use]
    pub fn xyz(&self, x: u32, y: u32) -> [f64; 3] {
        self.planes.sensor.xyz(&self.seen(x, y))
    }

    fn seen(&self, x: u32, y: u32) -> [f64; MOST_CHANNELS] {
        let (mut seen, stride) = ([0.0; MOST_CHANNELS], stride(&self.planes.sensor));
        self.through_tent(x, y, &mut seen[..stride - 2], |tile, at| &tile.sums[at * stride..]);
        seen
    }

    /// Share of a pixel, through its tent, that is not background: exactly 1 where no sample saw the background, 0 where all did.
    #[must_use]
    pub fn alpha(&self, x: u32, y: u32) -> f64 {
        let (mut alpha, stride) = ([0.0], stride(&self.planes.sensor));
        self.through_tent(x, y, &mut alpha, |tile, at| &tile.sums[(at + 1) * stride - 2..]);
        alpha[0]
    }

    /// Mean spectral radiance of a pixel in the film's bands, seen as [`Film::channels`].
    #[must_use]
    pub fn spectrum(&self, x: u32, y: u32) -> Vec<f64> {
        let bands = self.planes.spectral.nm().len();
        let mut spectrum = vec![0.0; bands];
        self.through_tent(x, y, &mut spectrum, |tile, at| &tile.spectra[at * bands..]);
        spectrum
    }

    /// Means of what tiles sum up per pixel, through the tent of a pixel.
    fn through_tent(&self, x: u32, y: u32, to: &mut [f64], sums: impl Fn(&Tile, usize) -> &[f64]) {
        let (mut weight, stride) = (0.0, stride(&self.planes.sensor));
        for index in self.tiles_about(x, y) {
            let tile = &self.tiles[index];
            if tile.count > 0 {
                let [x0, y0, x1, _] = self.bounds(index);
                let at = ((y + 1 - y0) * (x1 - x0 + 2) + x + 1 - x0) as usize;
                let share = 1.0 / f64::from(tile.count);
                for (sum, value) in to.iter_mut().zip(sums(tile, at)) {
                    *sum += value * share;
                }
                weight += tile.sums[(at + 1) * stride - 1] * share;
            }
        }
        to.iter_mut().for_each(|value| *value = if weight > 0.0 { *value / weight } else { 0.0 });
    }

    /// What compositors want to know of a pixel, where the film keeps it.
    #[must_use]
    pub fn compositing(&self, x: u32, y: u32) -> Option<&Compositing> {
        let tile = self.tile_at(x, y);
        let [x0, y0, x1, _] = self.bounds(tile);
        self.tiles[tile].compositing.get(((y - y0) * (x1 - x0) + x - x0) as usize)
    }

    /// Mean albedo of a pixel's first hits as the sensor's channels see it, where the film keeps it, over what they see of a white one:
    /// under daylight by the human eye, XYZ of which white has sRGB's white; by others under the same power at all wavelengths.
    #[must_use]
    pub fn albedo(&self, x: u32, y: u32) -> Option<Vec<f64>> {
        let tile = self.tile_at(x, y);
        let [x0, y0, x1, _] = self.bounds(tile);
        let (sensor, count) = (&self.planes.sensor, f64::from(self.count(x, y).max(1)));
        let at = ((y - y0) * (x1 - x0) + x - x0) as usize * lanes(sensor);
        let sums = self.tiles[tile].albedo.get(at..at + lanes(sensor))?.iter().zip(self.response.white);
        Some(sums.take(sensor.channels().len()).map(|(sum, white)| sum / count / white).collect())
    }

    /// CIE XYZ of a pixel's own samples alone, where the film keeps it: its noise has nothing in common with that of its neighbours, as denoisers want
    /// it.
    #[must_use]
    pub fn own_xyz(&self, x: u32, y: u32) -> Option<[f64; 3]> {
        let tile = self.tile_at(x, y);
        let [x0, y0, x1, _] = self.bounds(tile);
        let (sensor, count) = (&self.planes.sensor, f64::from(self.count(x, y).max(1)));
        let at = ((y - y0) * (x1 - x0) + x - x0) as usize * lanes(sensor);
        let sums = self.tiles[tile].own.get(at..at + lanes(sensor))?;
        let mut seen = [0.0; MOST_CHANNELS];
        seen.iter_mut().zip(sums).for_each(|(mean, sum)| *mean = sum / count);
        Some(sensor.xyz(&seen))
    }

    /// How much less runs of samples scatter than independent ones would, all pixels together: the factor from [`Film::variance`] to what is seen, 0 … 1.
    #[must_use]
    pub fn evenness(&self) -> f64 {
        let [width, height] = self.size;
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let (runs, samples) = places.fold((0.0, 0.0), |(runs, samples), (x, y)| {
            let (pixel, count) = (self.pixel(x, y), self.count(x, y));
            let error = pixel.error(count);
            (runs + error * error, samples + pixel.variance(count))
        });
        if samples > 0.0 { f64::min(runs / samples, 1.0) } else { 1.0 }
    }

    /// Variance of a pixel's mean Y, as of independent samples.
    #[must_use]
    pub fn variance(&self, x: u32, y: u32) -> f64 {
        let (mut sum, mut mass) = (0.0, 0.0);
        for (neighbour, share) in neighbours(x, self.size[0], [INSIDE, BESIDE]) {
            for (other, height) in neighbours(y, self.size[1], [INSIDE, BESIDE]) {
                let squared = |share: f64| if share == INSIDE { SQUARE_INSIDE } else { SQUARE_BESIDE };
                let variance = self.pixel(neighbour, other).variance(self.count(neighbour, other));
                sum += squared(share) * squared(height) * variance;
                mass += share * height;
            }
        }
        sum / (mass * mass)
    }

    fn tile_at(&self, x: u32, y: u32) -> usize {
        (y / TILE * tiles(self.size)[0] + x / TILE) as usize
    }

    /// The tiles that a pixel's tent reaches into.
    fn tiles_about(&self, x: u32, y: u32) -> impl Iterator<Item = usize> + '_ {
        let along = |place: u32, side: u32| {
            let [first, last] = [place.saturating_sub(1), (place + 1).min(side - 1)];
            first / TILE..=last / TILE
        };
        let [width, height] = self.size;
        along(y, height).flat_map(move |row| {
            along(x, width).map(move |column| (row * tiles([width, height])[0] + column) as usize)
        })
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

/// Tiles across and down.
fn tiles(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.div_ceil(TILE))
}

fn bounds(size: [u32; 2], tile: usize) -> [u32; 4] {
    let across = tiles(size)[0];
    let (x, y) = (tile as u32 % across * TILE, tile as u32 / across * TILE);
    [x, y, (x + TILE).min(size[0]), (y + TILE).min(size[1])]
}

/// A place and those beside it within a side, with the first or the second of these numbers.
fn neighbours(place: u32, side: u32, [inside, beside]: [f64; 2]) -> impl Iterator<Item = (u32, f64)> {
    let before = place.checked_sub(1).map(|before| (before, beside));
    let after = (place + 1 < side).then_some((place + 1, beside));
    before.into_iter().chain([(place, inside)]).chain(after)
}

impl Tile {
    fn new([x0, y0, x1, y1]: [u32; 4], planes: &Planes) -> Self {
        let (width, height) = ((x1 - x0) as usize, (y1 - y0) as usize);
        let (own, bordered) = (width * height, (width + 2) * (height + 2));
        let kept = if planes.compositing { own } else { 0 };
        Self {
            count: 0,
            faults: Faults::default(),
            sums: vec![0.0; bordered * stride(&planes.sensor)],
            pixels: vec![Pixel::default(); own],
            compositing: vec![Compositing::default(); kept],
            albedo: vec![0.0; kept * lanes(&planes.sensor)],
            own: vec![0.0; kept * lanes(&planes.sensor)],
            spectra: vec![0.0; bordered * planes.spectral.nm().len()],
        }
    }

    /// Standard error of a pixel's luminance through its tent over the luminance (with 0.05 added), mean over the tile. From
    /// the tile's own samples alone, so that it does not depend on how far the neighbours are.
    pub(super) fn noise(&self) -> f64 {
        let tent = SQUARE_INSIDE + 2.0 * SQUARE_BESIDE;
        let count = f64::from(self.count.max(1));
        let error =
            |pixel: &Pixel| tent * pixel.error(self.count) / ((pixel.luminance / count).max(0.0) + 0.05);
        self.pixels.iter().map(error).sum::<f64>() / self.pixels.len() as f64
    }

    /// Adds a sample, of this number, of the pixel at `x`, `y` from the tile's corner, `width` that of the tile.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        place: [u32; 2],
        width: u32,
        (planes, response): (&Planes, &Response),
        sample: &Sample,
        number: u32,
    ) {
        match &response.rows {
            Rows::Eye(rows) => {
                self.add_seen(place, width, (planes, response), sample, number, |over_pdf| {
                    let [x, y, z, _] = seen(rows, over_pdf, &sample.hero);
                    [x, y, z]
                });
            }
            Rows::Any(rows) => {
                self.add_seen(place, width, (planes, response), sample, number, |over_pdf| {
                    seen(rows, over_pdf, &sample.hero)
                });
            }
        }
    }

    /// As [`Tile::add`]; `see`: what the sensor's channels answer to a spectrum over its wavelengths' densities.
    #[inline(always)]
    fn add_seen<const LANES: usize>(
        &mut self,
        [x, y]: [u32; 2],
        width: u32,
        (planes, response): (&Planes, &Response),
        sample: &Sample,
        number: u32,
        see: impl Fn(&[f64; WAVES]) -> [f64; LANES],
    ) {
        let channels = see(&sample.radiance);
        let bands = planes.spectral.nm().len();
        self.each_tent([x, y], width, sample.offset, |tile, at, weight| {
            tile.sum(at, weight, &channels, sample.alpha);
            if bands > 0 {
                let sums = &mut tile.spectra[at * bands..][..bands];
                planes.spectral.each(sample, |band, value| sums[band] += weight * value);
            }
        });
        let own = (y * width + x) as usize;
        self.pixels[own].add(&sample.first, response.brightness(&channels), number);
        self.add_own(own, &channels);
        if let Some(compositing) = self.compositing.get_mut(own)
            && sample.first.id != 0
        {
            compositing.add(&sample.first);
            let seen = see(&response.lit(&sample.first.albedo, &sample.hero));
            for (sum, value) in self.albedo[own * LANES..][..LANES].iter_mut().zip(seen) {
                *sum += value;
            }
        }
    }

    /// The same of a sample that sees what is behind the scene, of which no spectrum is kept.
    #[inline(always)]
    pub(super) fn add_behind<const LANES: usize>(
        &mut self,
        [x, y]: [u32; 2],
        width: u32,
        response: &Response,
        sample: &Behind<LANES>,
        number: u32,
    ) {
        let Behind { channels, alpha, offset } = *sample;
        self.each_tent([x, y], width, offset, |tile, at, weight| tile.sum(at, weight, &channels, alpha));
        let own = (y * width + x) as usize;
        self.pixels[own].add(&NO_HIT, response.brightness(&channels), number);
        self.add_own(own, &channels);
    }

    /// Adds to what a pixel sees of its own, where the film keeps it.
    #[inline(always)]
    fn add_own<const LANES: usize>(&mut self, own: usize, channels: &[f64; LANES]) {
        if let Some(sums) = self.own.get_mut(own * LANES..(own + 1) * LANES) {
            sums.iter_mut().zip(channels).for_each(|(sum, value)| *sum += value);
        }
    }

    /// Leaves out a sample of this number, which counts as black.
    pub(super) fn leave_out(&mut self, [x, y]: [u32; 2], width: u32, number: u32, fault: Fault) {
        self.faults.add(fault);
        self.pixels[(y * width + x) as usize].run(number);
    }

    #[inline(always)]
    fn sum<const LANES: usize>(&mut self, at: usize, weight: f64, channels: &[f64; LANES], alpha: f64) {
        let sums = &mut self.sums[at * (LANES + 2)..][..LANES + 2];
        for (sum, value) in sums.iter_mut().zip(channels) {
            *sum += weight * value;
        }
        sums[LANES] += weight * alpha;
        sums[LANES + 1] += weight;
    }

    /// Calls `add(tile, place in its sums, weight)` for the four pixels whose tents a sample lies in.
    #[inline(always)]
    fn each_tent(
        &mut self,
        [x, y]: [u32; 2],
        width: u32,
        offset: [f64; 2],
        mut add: impl FnMut(&mut Self, usize, f64),
    ) {
        // The pixel's column and the one that is nearer, and their weights.
        let along = |place: u32, offset: f64| {
            let beside = if offset < 0.5 { place } else { place + 2 };
            let away = (offset - 0.5).abs();
            [(place + 1, 1.0 - away), (beside, away)]
        };
        for (row, tall) in along(y, offset[1]) {
            for (column, wide) in along(x, offset[0]) {
                add(self, (row * (width + 2) + column) as usize, wide * tall);
            }
        }
    }
}

#[cfg(test)]
mod tests;
