//! Tables of colour from a patch.
//!
//! At each wavelength the images of a series are seen through the window at each place (u, v) of the grid; what they give at the
//! nodes of w, or for each power of w, is summed over the wavelengths with the observer's weights. The window is separable: for a
//! row of places its rows of orders are summed once. Cost: about (orders along x + 2·size)·taps·terms for each row of places
//! and each wavelength, 10¹⁰ in all for 501² places of a patch of 65 µm.

use rayon::prelude::*;

use super::{Amplitudes, Reach, Series, check_patch};
use crate::math::chebyshev;
use crate::progress::Progress;
use crate::scattering::grating::{
    Basis, Orders, Place, Setup, TableGrid, Tables, check_size, interpolated, q,
};
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::Observer;
use crate::structure::Heightfield;
use crate::{Error, Result};
use glam::DVec3;

/// One wavelength.
struct Wave {
    um: f64,
    s_f: f64,
    /// The observer's weights times the setup's.
    xyz: [f64; 3],
    /// What images are multiplied by: `[node of w][image]`, or one row of factors of Taylor's terms.
    factors: Vec<f64>,
}

/// Makes tables, wholly or at single places.
pub struct Builder {
    grid: TableGrid,
    basis: Basis,
    setup: Setup,
    waves: Vec<Wave>,
    orders: Orders,
    /// Real numbers of each order: Re and Im of the amplitudes' images, or images of powers.
    numbers: usize,
    /// `[jy][jx][number]`
    images: Vec<f64>,
}

/// What a [`Builder`] and its tables take: memory in bytes, and time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TablesNeed {
    /// While the builder is made, at most at once.
    pub making: u64,
    /// What it keeps.
    pub kept: u64,
    /// All its tables.
    pub tables: u64,
    /// The powers of all orders that a renderer reads, which are no part of it.
    pub powers: u64,
    /// About how long it takes to make it on one thread, s.
    pub seconds: f64,
}

/// What a transform takes of each height, s.
const SECONDS_PER_HEIGHT: f64 = 35e-9;

impl Builder {
    /// What [`Self::new`] and [`Self::tables`] will take; while tables are made they are there twice.
    #[must_use]
    pub fn need(
        field: &Heightfield,
        setup: &Setup,
        grid: TableGrid,
        series: Series,
        at: &Wavelengths,
    ) -> TablesNeed {
        let reach = Reach::of(setup, at);
        let [orders, terms, of_powers] = Amplitudes::foretell(field, reach, series);
        let (numbers, count) = match (setup.place, series) {
            (Place::At(_), Series::Chebyshev) => (2 * terms, of_powers),
            (Place::Anywhere, Series::Chebyshev) => (of_powers, of_powers),
            (Place::At(_), Series::Taylor(order)) => (2 * terms, 2 * order as u64 + 1),
            (Place::Anywhere, Series::Taylor(order)) => (2 * order as u64 + 1, 2 * order as u64 + 1),
        };
        let kept = 8 * orders * numbers;
        let powers = 4 * orders * of_powers;
        // Powers are gathered from many threads' parts.
        let gathered =
            if setup.place == Place::Anywhere && series == Series::Chebyshev { 2 * powers } else { 0 };
        let size = grid.size as u64;
        TablesNeed {
            making: Amplitudes::bytes(field, reach, series).max(16 * orders * terms + kept + gathered),
            kept,
            tables: 12 * size * size * count,
            powers,
            seconds: field.height_um().len() as f64 * terms as f64 * SECONDS_PER_HEIGHT,
        }
    }

    /// For tables of a patch under a light's observer; `at` are the wavelengths that are summed.
    ///
    /// # Errors
    /// A setup or a grid out of range, too many tables, a patch far wider than the coherence, interruption.
    pub fn new(
        field: &Heightfield,
        setup: &Setup,
        grid: TableGrid,
        series: Series,
        observer: &Observer,
        at: &Wavelengths,
        progress: &dyn Progress,
    ) -> Result<Self> {
        grid.check()?;
        if let Series::Taylor(orders) = series {
            check_size(grid, Basis::Taylor { orders })?;
        }
        check_patch(field.size_um(), setup, at)?;
        let amplitudes = Amplitudes::new(field, setup, Reach::of(setup, at), series, progress)?;
        let basis = match series {
            Series::Taylor(orders) => Basis::Taylor { orders },
            Series::Chebyshev => Basis::Chebyshev { terms: amplitudes.power_terms() },
        };
        check_size(grid, basis)?;
        let images = match setup.place {
            Place::At(_) => amplitudes_images(&amplitudes),
            Place::Anywhere => powers_images(&amplitudes, series)?,
        };
        let orders = *amplitudes.orders();
        let numbers = images.len() / (orders.counts()[0] * orders.counts()[1]);
        let weights = observer.weights(at);
        let waves = (0..at.len()).map(|i| {
            let um = at[i] * 1e-3;
            let s_f = setup.coherence.frequency_per_um(um);
            let xyz = weights.xyz_parts()[i].map(|weight| weight * setup.of_wavelength(um));
            Wave { um, s_f, xyz, factors: factors(&amplitudes, basis, setup.place, um, numbers) }
        });
        Ok(Self { grid, basis, setup: *setup, waves: waves.collect(), orders, numbers, images })
    }

    /// Which functions of w the tables go with, and how many they are.
    #[must_use]
    pub fn basis(&self) -> Basis {
        self.basis
    }

    /// All tables.
    ///
    /// # Errors
    /// Interruption.
    pub fn tables(&self, progress: &dyn Progress) -> Result<Tables> {
        let size = self.grid.size;
        progress.begin("tables", size as u64);
        let rows: Vec<Vec<f32>> = (0..size)
            .into_par_iter()
            .map(|row| {
                if progress.is_cancelled() {
                    return Err(Error::interrupted());
                }
                let values = self.row(row, 0..size).into_iter().map(|value| value as f32).collect();
                progress.advance(1);
                Ok(values)
            })
            .collect::<Result<_>>()?;
        Tables::new(self.grid, self.basis, self.setup, rows.concat())
    }

    /// X, Y, Z that the tables give between two directions, from the places about them alone.
    #[must_use]
    pub fn xyz(&self, w_i: DVec3, w_o: DVec3) -> [f64; 3] {
        let q = q(w_i, w_o);
        let cell = self.grid.cell(q.x, q.y);
        let texels: Vec<Vec<f32>> = cell
            .places
            .iter()
            .map(|&[i, j]| self.row(j, i..i + 1).into_iter().map(|value| value as f32).collect())
            .collect();
        interpolated(self.basis, &self.setup, w_i, w_o, &cell, texels.iter().map(Vec::as_slice))
    }

    /// Tables at some places of a row, `[u][table][X, Y, Z]`.
    fn row(&self, row: usize, places: std::ops::Range<usize>) -> Vec<f64> {
        let (numbers, per_place) = (self.numbers, self.basis.count() * 3);
        let columns = self.orders.counts()[0];
        let v = self.grid.coordinate(row);
        // Directions have u² + v² ≤ 4; places about them are up to two steps further out.
        let step = |i: usize| self.grid.coordinate(i.min(self.grid.size - 1)).abs();
        let inner = |i: usize| step(i + 2).min(step(i.saturating_sub(2)));
        let inner_v = inner(row);
        let is_seen = |i: usize| inner(i).powi(2) + inner_v.powi(2) <= 4.0;
        let (mut line, mut seen) = (vec![0.0; columns * numbers], vec![0.0; numbers]);
        let mut texels = vec![0.0; places.len() * per_place];
        for wave in &self.waves {
            let along = self.orders.taps(1, v / wave.um, wave.s_f);
            if along.weights().is_empty() {
                continue;
            }
            let taps = |i: usize| self.orders.taps(0, self.grid.coordinate(i) / wave.um, wave.s_f);
            let (mut from, mut to) = (columns, 0);
            for i in places.clone().filter(|i| is_seen(*i)) {
                let taps = taps(i);
                if !taps.weights().is_empty() {
                    from = from.min(taps.first);
                    to = to.max(taps.first + taps.weights().len());
                }
            }
            if from >= to {
                continue;
            }
            line[from * numbers..to * numbers].fill(0.0);
            let along = if self.setup.place == Place::Anywhere { along.squared() } else { along };
            for (j, weight) in along.weights().iter().enumerate() {
                let start = (along.first + j) * columns;
                let orders = &self.images[(start + from) * numbers..(start + to) * numbers];
                for (sum, value) in line[from * numbers..to * numbers].iter_mut().zip(orders) {
                    *sum += weight * value;
                }
            }
            for (i, texel) in places.clone().zip(texels.chunks_exact_mut(per_place)) {
                let across = taps(i);
                if across.weights().is_empty() || !is_seen(i) {
                    continue;
                }
                let across = if self.setup.place == Place::Anywhere { across.squared() } else { across };
                seen.fill(0.0);
                for (k, weight) in across.weights().iter().enumerate() {
                    let order = &line[(across.first + k) * numbers..][..numbers];
                    for (sum, value) in seen.iter_mut().zip(order) {
                        *sum += weight * value;
                    }
                }
                self.add(wave, &mut seen, texel);
            }
        }
        if let Basis::Chebyshev { .. } = self.basis {
            for texel in texels.chunks_exact_mut(per_place) {
                let series = chebyshev::coefficients(texel, 3);
                texel.copy_from_slice(&series);
            }
        }
        texels
    }

    /// Adds a wavelength's part to a place: at each node of w, or to each table of Taylor's series.
    fn add(&self, wave: &Wave, seen: &mut [f64], texel: &mut [f64]) {
        let is_amplitude = self.setup.place != Place::Anywhere;
        let into = texel.as_chunks_mut::<3>().0;
        let add = |sums: &mut [f64; 3], power: f64| {
            for (sum, weight) in sums.iter_mut().zip(wave.xyz) {
                *sum += weight * power;
            }
        };
        match self.basis {
            Basis::Chebyshev { .. } if is_amplitude => {
                let images = seen.as_chunks::<2>().0;
                for (sums, factors) in into.iter_mut().zip(wave.factors.chunks_exact(images.len())) {
                    let [mut re, mut im] = [0.0; 2];
                    for (image, factor) in images.iter().zip(factors) {
                        re += factor * image[0];
                        im += factor * image[1];
                    }
                    add(sums, re * re + im * im);
                }
            }
            Basis::Chebyshev { .. } => {
                for (sums, factors) in into.iter_mut().zip(wave.factors.chunks_exact(seen.len())) {
                    add(sums, seen.iter().zip(factors).map(|(image, factor)| image * factor).sum());
                }
            }
            Basis::Taylor { orders } if is_amplitude => {
                let images = seen.as_chunks_mut::<2>().0;
                for (image, factor) in images.iter_mut().zip(&wave.factors) {
                    *image = image.map(|part| part * factor);
                }
                for (p, sums) in into.iter_mut().enumerate() {
                    let pairs = p.saturating_sub(orders)..=p.min(orders);
                    let product = |n: usize| {
                        let (a, b) = (images[n], images[p - n]);
                        a[0] * b[0] + a[1] * b[1]
                    };
                    add(sums, pairs.map(product).sum());
                }
            }
            Basis::Taylor { .. } => {
                for (sums, (image, factor)) in into.iter_mut().zip(seen.iter().zip(&wave.factors)) {
                    add(sums, image * factor);
                }
            }
        }
    }
}

/// Re and Im of each term.
fn amplitudes_images(amplitudes: &Amplitudes) -> Vec<f64> {
    let [columns, rows] = amplitudes.orders().counts();
    (0..columns * rows).flat_map(|place| amplitudes.series_of(place).iter().flatten().copied()).collect()
}

/// Powers of each order as a series: over κ, or Σ_{n+m=p} Re(a_n a_m*)/(n! m!) for each power p.
fn powers_images(amplitudes: &Amplitudes, series: Series) -> Result<Vec<f64>> {
    let Series::Taylor(orders) = series else {
        return Ok(amplitudes.powers()?.series().iter().map(|value| f64::from(*value)).collect());
    };
    let mut factorials = vec![1.0];
    for n in 1..=orders {
        factorials.push(factorials[n - 1] * n as f64);
    }
    let [columns, rows] = amplitudes.orders().counts();
    let images = (0..columns * rows).flat_map(|place| {
        let a = amplitudes.series_of(place);
        let factorials = &factorials;
        (0..=2 * orders).map(move |p| {
            let pairs = p.saturating_sub(orders)..=p.min(orders);
            let product = |n: usize| {
                let m = p - n;
                (a[n][0] * a[m][0] + a[n][1] * a[m][1]) / (factorials[n] * factorials[m])
            };
            pairs.map(product).sum::<f64>()
        })
    });
    Ok(images.collect())
}

/// What images are multiplied by at a wavelength.
fn factors(amplitudes: &Amplitudes, basis: Basis, place: Place, um: f64, numbers: usize) -> Vec<f64> {
    let k = std::f64::consts::TAU / um;
    match basis {
        Basis::Chebyshev { terms } => chebyshev::nodes(terms)
            .flat_map(|x| {
                let kappa = k * (x - 1.0);
                match place {
                    Place::At(_) => amplitudes.basis(kappa),
                    Place::Anywhere => amplitudes.polynomials(kappa, numbers),
                }
            })
            .collect(),
        // (κ h)ⁿ/n! with κ = 2k (w/2): the tables go with powers of w/2.
        Basis::Taylor { .. } => {
            let step = 2.0 * k * amplitudes.height_um();
            let divisor = |n: usize| if place == Place::Anywhere { 1.0 } else { n as f64 };
            let terms = if place == Place::Anywhere { numbers } else { numbers / 2 };
            let mut factors = vec![1.0];
            for n in 1..terms {
                factors.push(factors[n - 1] * step / divisor(n));
            }
            factors
        }
    }
}
