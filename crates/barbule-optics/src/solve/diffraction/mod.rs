//! Diffraction by heightfields: the reference that tables are judged by, and what makes tables.
//!
//! [`value`] is the sum over all heights of a patch, as [`crate::scattering::grating`] defines it, with nothing precomputed. What is
//! precomputed are [`Amplitudes`]: transforms of the patch at a few κ, from which any direction and wavelength follow, [`Builder`]'s
//! tables of colour, and the powers that a renderer reads.

mod amplitudes;
mod build;
#[cfg(test)]
mod tests;

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

pub use amplitudes::{Amplitudes, Reach, Series};
pub use build::Builder;

use crate::Result;
use crate::scattering::grating::{Place, Setup, WINDOW, q};
use crate::spectrum::Wavelengths;
use crate::structure::Heightfield;

/// 380, 385, …, 780 nm: what colours are summed over.
///
/// # Errors
/// None.
pub fn usual_wavelengths() -> Result<Wavelengths> {
    Wavelengths::new((0..81).map(|i| 380.0 + 5.0 * f64::from(i)).collect::<Vec<_>>())
}

/// f at each wavelength for light from `w_i` towards `w_o`, 1/sr or relative; 0 below the surface and beyond the frequencies
/// that the heights' distance can tell.
///
/// # Errors
/// A setup out of range.
pub fn spectrum(
    field: &Heightfield,
    setup: &Setup,
    at: &Wavelengths,
    w_i: DVec3,
    w_o: DVec3,
) -> Result<Vec<f64>> {
    setup.check()?;
    Ok(at.nm().par_iter().map(|nm| value(field, setup, *nm, w_i, w_o)).collect())
}

/// [`spectrum`] at one wavelength; the setup is not checked.
#[must_use]
pub fn value(field: &Heightfield, setup: &Setup, wavelength_nm: f64, w_i: DVec3, w_o: DVec3) -> f64 {
    let wavelength_um = wavelength_nm * 1e-3;
    let weight = setup.of_directions(w_i, w_o);
    if weight == 0.0 {
        return 0.0;
    }
    let s_f = setup.coherence.frequency_per_um(wavelength_um);
    let squared = squared_amplitude(field, setup.place, wavelength_um, s_f, q(w_i, w_o));
    // A sum over no orders is a zero with a sign.
    weight * setup.of_wavelength(wavelength_um) * squared + 0.0
}

/// e^{j angle}, the same bits on every system.
fn cis(angle: f64) -> Complex64 {
    let (sin, cos) = libm::sincos(angle);
    Complex64::new(cos, sin)
}

/// The orders of a patch along one axis that the window lets through, and their weights.
fn orders(field: &Heightfield, axis: usize, frequency: f64, s_f: f64) -> Vec<(i64, f64)> {
    let (side, count) = (field.size_um()[axis], field.cells()[axis]);
    let weight = |j: i64| libm::exp(-(frequency - j as f64 / side).powi(2) / (2.0 * s_f * s_f));
    if count == 1 {
        return vec![(0, weight(0))];
    }
    let reach = WINDOW * s_f * side;
    let (low, high) = ((frequency * side - reach).ceil() as i64, (frequency * side + reach).floor() as i64);
    // Beyond half the sampling frequency orders would be others'.
    let most = (count as i64 - 1) / 2;
    (low.max(-most)..=high.min(most)).map(|j| (j, weight(j))).collect()
}

/// |P_g|², or its mean over all places of the window.
fn squared_amplitude(field: &Heightfield, place: Place, wavelength_um: f64, s_f: f64, q: DVec3) -> f64 {
    let [columns, rows] = field.cells();
    let frequencies = [q.x / wavelength_um, q.y / wavelength_um];
    let [across, along] = [0, 1].map(|axis| orders(field, axis, frequencies[axis], s_f));
    let phase_per_um = std::f64::consts::TAU / wavelength_um * q.z;
    // e^{2πi j x/T} at each cell, `[order][cell]`.
    let turns = |orders: &[(i64, f64)], axis: usize| -> Vec<Vec<Complex64>> {
        let count = field.cells()[axis] as i64;
        let turn = |j: i64, cell: i64| {
            cis(std::f64::consts::TAU * (j * cell).rem_euclid(count) as f64 / count as f64)
        };
        orders.iter().map(|&(j, _)| (0..count).map(|cell| turn(j, cell)).collect()).collect()
    };
    let (by_x, by_y) = (turns(&across, 0), turns(&along, 1));
    // c_j, `[along][across]`
    let mut sums = vec![Complex64::ZERO; across.len() * along.len()];
    let mut line = vec![Complex64::ZERO; across.len()];
    for (row, heights) in field.height_um().chunks_exact(columns).enumerate() {
        line.fill(Complex64::ZERO);
        for (cell, height) in heights.iter().enumerate() {
            let p = cis(phase_per_um * height);
            for (sum, turns) in line.iter_mut().zip(&by_x) {
                *sum += p * turns[cell];
            }
        }
        for (turns, sums) in by_y.iter().zip(sums.chunks_exact_mut(across.len().max(1))) {
            for (sum, value) in sums.iter_mut().zip(&line) {
                *sum += value * turns[row];
            }
        }
    }
    let scale = 1.0 / (columns * rows) as f64;
    let terms = along.iter().flat_map(|a| across.iter().map(move |b| (a, b))).zip(&sums);
    match place {
        Place::Anywhere => terms.map(|((a, b), c)| (a.1 * b.1 * scale).powi(2) * c.norm_sqr()).sum(),
        Place::At([x, y]) => {
            let [width, height] = field.size_um();
            let shift = |j: i64, at: f64, side: f64| std::f64::consts::TAU * j as f64 * at / side;
            terms
                .map(|((a, b), c)| c * a.1 * b.1 * scale * cis(shift(b.0, x, width) + shift(a.0, y, height)))
                .sum::<Complex64>()
                .norm_sqr()
        }
    }
}
