//! Pictures without their noise: what the denoiser makes of a film, and what of it the film's own samples know better.

use std::path::Path;
use std::sync::Arc;

use crate::io::{Denoiser, Noisy};
use crate::render::film::Film;
use crate::spectrum::colour::{into_gamut, rgb_from_xyz, xyz_from_rgb};
use crate::{Error, Result};

/// Takes the noise out of films with Open Image Denoise.
///
/// The library gets linear light of each pixel's own samples (the tent of a finished pixel shares samples with its neighbours, and what neighbours share it
/// takes for texture), with the first hits' albedo and normals, both of which it cleans first. It also takes for noise what is as small as a pixel: glints. What the
/// samples themselves are sure of therefore stays: a pixel is d + w (n − d), d without and n with noise, both through the tent, of which the share w = max(0, 1 − k σ²/s²) has the form
/// of James & Stein's (*Estimation with quadratic loss*, 1961), σ² the variance of the pixel's luminance or of those about it, whichever is larger, and s² the square of its distance from d. With k = 1, as
/// theirs, one pixel of ten stands off by over σ by chance: texture of a close-up hides that, on a whole feather these are dots, and k is up to 9. A pixel with one bright sample, a firefly, differs from d by its own standard error and goes, but its light stays: what is taken from pixels is given back to those about
/// them, in proportion to d.
pub struct Cleaner {
    denoiser: Denoiser,
}

impl Cleaner {
    /// With the library that the system has, or that is in this file.
    ///
    /// # Errors
    /// It is not there: how to install it.
    pub fn load(library: Option<&Path>) -> Result<Self> {
        Denoiser::load(library).map(|denoiser| Self { denoiser })
    }

    /// Its name and version.
    #[must_use]
    pub fn name(&self) -> String {
        format!("Open Image Denoise {}", self.denoiser.version())
    }

    /// CIE XYZ of a film's pixels, row by row, without noise. The same bits for the same film, library, processor and number of threads.
    ///
    /// # Errors
    /// A film of another sensor than the human eye or without albedo, or the library fails.
    pub fn clean(&self, film: &Film) -> Result<Arc<[[f32; 3]]>> {
        let [width, height] = film.size();
        let places = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        if !film.planes().sensor.is_human() || !film.planes().compositing {
            return Err(Error::input("only pictures that people see, with their albedo, are denoised"));
        }
        let size = film.size().map(|side| side as usize);
        let threads = rayon::current_num_threads();
        let single = |values: [f64; 3]| values.map(|value| value as f32);
        let own = |(x, y)| film.own_xyz(x, y).unwrap_or_default();
        let inside = |xyz: [f64; 3]| single(rgb_from_xyz(xyz).map(|v| v.max(0.0)));
        let colour: Vec<[f32; 3]> = places().map(own).map(inside).collect();
        let albedo: Vec<[f32; 3]> = places().map(|(x, y)| single(albedo(film, x, y))).collect();
        let normal: Vec<[f32; 3]> = places().map(|(x, y)| single(normal(film, x, y))).collect();
        let run = |noisy: &Noisy<'_>| self.denoiser.denoise(noisy, threads);
        let alone = |plane: &[[f32; 3]], is_albedo: bool| {
            let none: &[[f32; 3]] = &[];
            let (albedo, normal) = if is_albedo { (plane, none) } else { (none, plane) };
            run(&Noisy { size, colour: none, albedo, normal, is_clean: false })
        };
        let (albedo, normal) = (alone(&albedo, true)?, alone(&normal, false)?);
        let smooth = run(&Noisy { size, colour: &colour, albedo: &albedo, normal: &normal, is_clean: true })?;
        let smooth = through_tent(&smooth, size);
        let noisy: Vec<[f64; 3]> = places().map(|(x, y)| film.xyz(x, y)).collect();
        let evenness = film.evenness();
        let own: Vec<f64> = places().map(|(x, y)| evenness * film.variance(x, y)).collect();
        // Where no sample met what is bright, none knows that there is something: the neighbours do.
        let mut variances = own.clone();
        spread(&mut variances, size, 1);
        let caution = caution(evenness);
        variances.iter_mut().zip(own).for_each(|(about, own)| *about = caution * about.max(own));
        Ok(kept(&noisy, &variances, &smooth, size))
    }
}

/// CIE XYZ of a picture in linear sRGB, each pixel with what of its neighbours lies in its tent.
fn through_tent(picture: &[[f32; 3]], [width, height]: [usize; 2]) -> Vec<[f64; 3]> {
    // Of a tent of half width 1 three quarters lie in the pixel; what lies outside the picture does not count.
    let near = |at: usize, side: usize| {
        let before = at.checked_sub(1).map(|before| (before, 0.125));
        let after = (at + 1 < side).then_some((at + 1, 0.125));
        before.into_iter().chain([(at, 0.75)]).chain(after)
    };
    let pixel = |at: usize| {
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        for (row, tall) in near(at / width, height) {
            for (column, wide) in near(at % width, width) {
                let share = tall * wide;
                weight += share;
                for (sum, value) in sum.iter_mut().zip(picture[row * width + column]) {
                    *sum += share * f64::from(value);
                }
            }
        }
        xyz_from_rgb(sum.map(|value| value / weight))
    };
    (0..picture.len()).map(pixel).collect()
}

/// The smooth picture with what the noisy one is sure of by its variances, both in CIE XYZ; with the noisy one's light.
fn kept(noisy: &[[f64; 3]], variances: &[f64], smooth: &[[f64; 3]], size: [usize; 2]) -> Arc<[[f32; 3]]> {
    let share = |((noisy, variance), smooth): ((&[f64; 3], &f64), &[f64; 3])| {
        let away = noisy[1] - smooth[1];
        if away == 0.0 { 0.0 } else { (1.0 - variance / (away * away)).max(0.0) }
    };
    let shares: Vec<f64> = noisy.iter().zip(variances).zip(smooth).map(share).collect();
    // The light of what is replaced, and of what replaces it.
    let replaced = |picture: &[[f64; 3]]| {
        let mut light: Vec<f64> =
            picture.iter().zip(&shares).map(|(xyz, share)| (1.0 - share) * xyz[1]).collect();
        (0..3).for_each(|_| spread(&mut light, size, REACH));
        light
    };
    let (taken, given) = (replaced(noisy), replaced(smooth));
    let pixel = |at: usize| {
        let gain = if given[at] > 0.0 { taken[at] / given[at] } else { 1.0 };
        std::array::from_fn(|c| {
            (shares[at] * noisy[at][c] + (1.0 - shares[at]) * gain * smooth[at][c]) as f32
        })
    };
    (0..noisy.len()).map(pixel).collect()
}

/// By how much a pixel's variance is multiplied before it is asked whether the pixel stands off by more than chance. Where samples of a pixel are as good as independent
/// ([`Film::evenness`] near 1), they are few for what it holds, and the variance that they tell is as uncertain as their mean: nothing within three standard deviations is
/// kept. Where they are spread evenly over what the pixel holds (close-ups, 0.3 to 0.4), texture is as large as noise and better kept.
fn caution(evenness: f64) -> f64 {
    const EVEN: f64 = 0.4;
    const INDEPENDENT: f64 = 0.9;
    1.0 + 8.0 * ((evenness - EVEN) / (INDEPENDENT - EVEN)).clamp(0.0, 1.0)
}

/// How far light is given back, pixels, in each of three steps.
const REACH: usize = 6;

/// Each value becomes the mean of those at most `reach` rows and columns away, of which those beyond an edge are the edge's, so that the sum of an even
/// picture stays.
fn spread(values: &mut [f64], [width, height]: [usize; 2], reach: usize) {
    let mut line = Vec::with_capacity(width.max(height));
    let mut along = |first: usize, step: usize, count: usize| {
        line.clear();
        line.extend((0..count).map(|k| values[first + k * step]));
        let at = |k: usize| line[k.saturating_sub(reach).min(count - 1)];
        // The sum about the place before the first one, whose window goes from −reach − 1 to reach − 1.
        let mut sum: f64 = (0..=2 * reach).map(|k| at(k.saturating_sub(1))).sum();
        for k in 0..count {
            sum += at(k + 2 * reach) - if k == 0 { at(0) } else { at(k - 1) };
            values[first + k * step] = (sum / (2 * reach + 1) as f64).max(0.0);
        }
    };
    (0..height).for_each(|row| along(row * width, 1, width));
    (0..width).for_each(|column| along(column, width, height));
}

/// Linear sRGB of the share of light that the first hits scatter, 0 … 1.
fn albedo(film: &Film, x: u32, y: u32) -> [f64; 3] {
    match film.albedo(x, y).as_deref() {
        Some(&[x, y, z]) => into_gamut(rgb_from_xyz([x, y, z])).map(|v| v.clamp(0.0, 1.0)),
        _ => [0.0; 3],
    }
}

/// The mean shading normal of the first hits.
fn normal(film: &Film, x: u32, y: u32) -> [f64; 3] {
    let pixel = film.pixel(x, y);
    pixel.normal.map(|sum| sum / f64::from(pixel.hits.max(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An even picture stays, and a point becomes a square of the same sum.
    #[test]
    fn light_that_is_spread_keeps_its_sum() {
        let size = [40, 30];
        let mut even = vec![2.0; 1200];
        spread(&mut even, size, REACH);
        assert!(even.iter().all(|v| (v - 2.0).abs() < 1e-12));
        let mut point = vec![0.0; 1200];
        point[15 * 40 + 20] = 1.0;
        spread(&mut point, size, REACH);
        assert!((point.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let (inside, outside) = (point[9 * 40 + 26], point[9 * 40 + 27]);
        assert!((inside - 1.0 / 169.0).abs() < 1e-12 && outside.abs() < 1e-12, "{inside} {outside}");
    }

    /// Noise alone: where samples are independent hardly a pixel is left that stands off the smooth ones by more than its deviation, dark or bright, while what stands off by ten deviations stays.
    #[test]
    fn chance_leaves_no_dots() {
        let size = [100, 100];
        let (smooth, mut noisy) = (vec![[1.0; 3]; 10_000], vec![[1.0; 3]; 10_000]);
        let mut stream = crate::math::rng::Stream::new(3, &[]);
        let deviation = 0.1;
        noisy.iter_mut().for_each(|pixel| *pixel = [1.0 + deviation * stream.normal(); 3]);
        let glint = 50 * 100 + 50;
        noisy[glint] = [1.0 + 10.0 * deviation; 3];
        let dots = |evenness| {
            let clean = kept(&noisy, &vec![caution(evenness) * deviation * deviation; 10_000], &smooth, size);
            (clean.iter().filter(|pixel| f64::from(pixel[1] - 1.0).abs() > deviation).count(), clean)
        };
        // Of normal numbers 4 are beyond 3.54 deviations, and the glint is; 1,060 beyond 1.62.
        let ((few, clean), (many, _)) = (dots(1.0), dots(0.3));
        assert!((1..15).contains(&few) && (900..1200).contains(&many), "{few} {many}");
        assert!((f64::from(clean[glint][1]) - 1.91).abs() < 0.02, "{}", clean[glint][1]);
    }

    /// A firefly, whose standard error is its own height, goes with its light kept about it; a glint that all samples saw stays.
    #[test]
    fn glints_stay_and_fireflies_are_spread() {
        let size = [64, 64];
        let smooth = vec![[1.0; 3]; 4096];
        let (mut noisy, mut variances) = (smooth.clone(), vec![1e-4; 4096]);
        let (firefly, glint) = (20 * 64 + 20, 40 * 64 + 40);
        (noisy[firefly], variances[firefly]) = ([101.0; 3], 100.0 * 100.0);
        (noisy[glint], variances[glint]) = ([101.0; 3], 1.0);
        let clean = kept(&noisy, &variances, &smooth, size);
        assert!(clean[firefly][1] < 2.0 && (clean[glint][1] - 101.0).abs() < 0.1, "{:?}", clean[firefly]);
        let sum = |pixels: &mut dyn Iterator<Item = f64>| pixels.sum::<f64>();
        let (before, after) =
            (sum(&mut noisy.iter().map(|v| v[1])), sum(&mut clean.iter().map(|v| f64::from(v[1]))));
        assert!((after / before - 1.0).abs() < 5e-3, "{before} {after}");
    }
}
