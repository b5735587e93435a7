//! Diffraction by heightfields: the reference that tables are judged by, and what makes tables.
//!
//! [`spectrum`] is the sum over all heights of a patch, as [`crate::scattering::grating`] defines it, with nothing precomputed. What is
//! precomputed are [`Amplitudes`]: transforms of the patch at a few κ, from which any direction and wavelength follow, [`Builder`]'s
//! tables of colour, and the powers that a renderer reads. [`ridge_orders`] holds the sum itself against Maxwell's equations.

mod amplitudes;
mod build;
mod exact;
#[cfg(test)]
mod tests;

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

pub use amplitudes::{Amplitudes, Reach, Series};
pub use build::{Builder, TablesNeed};
pub use exact::{OrderPower, RidgeOrders, ridge_orders};

use crate::progress::Progress;
use crate::scattering::grating::{Orders, Place, Setup, WINDOW, q};
use crate::spectrum::Wavelengths;
use crate::structure::Heightfield;
use crate::{Error, Result};

/// 380, 385, …, 780 nm: what colours are summed over.
///
/// # Errors
/// None.
pub fn usual_wavelengths() -> Result<Wavelengths> {
    Wavelengths::new((0..81).map(|i| 380.0 + 5.0 * f64::from(i)).collect::<Vec<_>>())
}

/// f at each wavelength for light from `w_i` towards `w_o`, 1/sr or relative; 0 below the surface and beyond the frequencies
/// that the heights' distance can tell. Beside the heights it takes memory for their rows and columns alone.
///
/// # Errors
/// A setup out of range, a patch far wider than the coherence, interruption.
pub fn spectrum(
    field: &Heightfield,
    setup: &Setup,
    at: &Wavelengths,
    w_i: DVec3,
    w_o: DVec3,
    progress: &dyn Progress,
) -> Result<Vec<f64>> {
    setup.check()?;
    check_patch(field.size_um(), setup, at)?;
    let turns = Turns::of(field);
    progress.begin("sums over heights", (at.len() * field.cells()[1]) as u64);
    let one = |nm: &f64| value(field, &turns, setup, *nm, [w_i, w_o], progress);
    at.nm().par_iter().map(one).collect()
}

/// About how long [`spectrum`] takes on one thread, s.
#[must_use]
pub fn foretell_seconds(field: &Heightfield, setup: &Setup, at: &Wavelengths) -> f64 {
    const PER_TURN: f64 = 3e-9;
    let turns = |nm: &f64| orders(field, 0, 0.0, setup.coherence.frequency_per_um(nm * 1e-3)).len() + 1;
    let all: usize = at.nm().iter().map(turns).sum();
    all as f64 * field.height_um().len() as f64 * PER_TURN
}

/// Refuses a patch with these periods, µm, that is far wider than the window of coherence at one of the wavelengths: its orders
/// in the window would be too many.
///
/// # Errors
/// It is that.
pub fn check_patch(period_um: [f64; 2], setup: &Setup, at: &Wavelengths) -> Result<()> {
    let orders = Orders { most: [0; 2], period_um };
    at.nm().iter().try_for_each(|nm| orders.check_window(setup.coherence.frequency_per_um(nm * 1e-3)))
}

/// [`spectrum`] at one wavelength; the setup is not checked.
fn value(
    field: &Heightfield,
    turns: &Turns,
    setup: &Setup,
    wavelength_nm: f64,
    [w_i, w_o]: [DVec3; 2],
    progress: &dyn Progress,
) -> Result<f64> {
    let wavelength_um = wavelength_nm * 1e-3;
    let weight = setup.of_directions(w_i, w_o);
    if weight == 0.0 {
        return Ok(0.0);
    }
    let s_f = setup.coherence.frequency_per_um(wavelength_um);
    let squared = squared_amplitude(field, turns, setup.place, (wavelength_um, s_f), q(w_i, w_o), progress)?;
    // A sum over no orders is a zero with a sign.
    Ok(weight * setup.of_wavelength(wavelength_um) * squared + 0.0)
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

/// e^{2πi k/N} for each k of the N cells along either axis: whatever an order turns a cell by is among them.
struct Turns([Vec<Complex64>; 2]);

impl Turns {
    fn of(field: &Heightfield) -> Self {
        let along = |count: usize| {
            (0..count).map(|k| cis(std::f64::consts::TAU * k as f64 / count as f64)).collect::<Vec<_>>()
        };
        Self(field.cells().map(along))
    }
}

/// Where among the turns of an axis each order stands at a cell: 0 at the first, and by how much it goes on from cell to cell.
struct Places {
    steps: Vec<usize>,
    at: Vec<usize>,
}

impl Places {
    fn of(orders: &[(i64, f64)], count: usize) -> Self {
        let steps = orders.iter().map(|(j, _)| j.rem_euclid(count as i64) as usize).collect();
        Self { steps, at: vec![0; orders.len()] }
    }

    /// Gives each order's turn at this cell with its sum, and goes on to the next cell.
    #[inline]
    fn next<T>(
        &mut self,
        turns: &[Complex64],
        sums: impl Iterator<Item = T>,
        mut add: impl FnMut(T, Complex64),
    ) {
        for ((at, step), sum) in self.at.iter_mut().zip(&self.steps).zip(sums) {
            add(sum, turns[*at]);
            *at += step;
            if *at >= turns.len() {
                *at -= turns.len();
            }
        }
    }
}

/// |P_g|², or its mean over all places of the window; at a wavelength through a window of standard deviation s_f, µm and 1/µm.
fn squared_amplitude(
    field: &Heightfield,
    turns: &Turns,
    place: Place,
    (wavelength_um, s_f): (f64, f64),
    q: DVec3,
    progress: &dyn Progress,
) -> Result<f64> {
    let [columns, rows] = field.cells();
    let frequencies = [q.x / wavelength_um, q.y / wavelength_um];
    let [across, along] = [0, 1].map(|axis| orders(field, axis, frequencies[axis], s_f));
    let phase_per_um = std::f64::consts::TAU / wavelength_um * q.z;
    let Turns([by_x, by_y]) = turns;
    let mut rows_at = Places::of(&along, rows);
    // c_j, `[along][across]`
    let mut sums = vec![Complex64::ZERO; across.len() * along.len()];
    let mut line = vec![Complex64::ZERO; across.len()];
    for heights in field.height_um().chunks_exact(columns) {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        line.fill(Complex64::ZERO);
        let mut columns_at = Places::of(&across, columns);
        for height in heights {
            let p = cis(phase_per_um * height);
            columns_at.next(by_x, line.iter_mut(), |sum, turn| *sum += p * turn);
        }
        rows_at.next(by_y, sums.chunks_exact_mut(across.len().max(1)), |sums, turn| {
            for (sum, value) in sums.iter_mut().zip(&line) {
                *sum += value * turn;
            }
        });
        progress.advance(1);
    }
    let scale = 1.0 / (columns * rows) as f64;
    let terms = along.iter().flat_map(|a| across.iter().map(move |b| (a, b))).zip(&sums);
    Ok(match place {
        Place::Anywhere => terms.map(|((a, b), c)| (a.1 * b.1 * scale).powi(2) * c.norm_sqr()).sum::<f64>(),
        Place::At([x, y]) => {
            let [width, height] = field.size_um();
            // p = Σ c_j e^{−2πi j·x/T}: seen from the place, an order has this much of its phase already.
            let shift = |j: i64, at: f64, side: f64| -std::f64::consts::TAU * j as f64 * at / side;
            terms
                .map(|((a, b), c)| c * a.1 * b.1 * scale * cis(shift(b.0, x, width) + shift(a.0, y, height)))
                .sum::<Complex64>()
                .norm_sqr()
        }
    })
}
