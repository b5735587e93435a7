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
/// samples themselves are sure of therefore stays: a pixel is d + w (n − d), d without and n with noise, of which the share w = max(0, 1 − σ²/s²) is
/// that of James & Stein (*Estimation with quadratic loss*, 1961), σ² the variance of the pixel's luminance and s² the square of its distance from d. A pixel with one
/// bright sample, a firefly, differs from d by its own standard error and goes.
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
        let noisy: Vec<[f64; 3]> = places().map(|(x, y)| film.own_xyz(x, y).unwrap_or_default()).collect();
        let inside = |xyz: &[f64; 3]| single(rgb_from_xyz(*xyz).map(|v| v.max(0.0)));
        let colour: Vec<[f32; 3]> = noisy.iter().map(inside).collect();
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
        Ok(kept(&noisy, &film.own_variances(), &smooth))
    }
}

/// CIE XYZ of the smooth picture, in linear sRGB, with what the noisy one, in XYZ, is sure of by its variances.
fn kept(noisy: &[[f64; 3]], variances: &[f64], smooth: &[[f32; 3]]) -> Arc<[[f32; 3]]> {
    let each = noisy.iter().zip(variances).zip(smooth);
    each.map(|((noisy, variance), smooth)| {
        let smooth = xyz_from_rgb(smooth.map(f64::from));
        let away = noisy[1] - smooth[1];
        let share = if away == 0.0 { 0.0 } else { (1.0 - variance / (away * away)).max(0.0) };
        std::array::from_fn(|c| (smooth[c] + share * (noisy[c] - smooth[c])) as f32)
    })
    .collect()
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
