//! The amplitudes of a patch's orders over κ, from a few transforms.
//!
//! p = e^{jκh} depends on the wavelength and on the directions through κ = kw alone. So a series over κ, of transforms of the
//! patch at a few κ, serves all of them: Chebyshev's over all κ that come up, or Taylor's about κ = 0, whose images are the
//! transforms of (jh)ⁿ (Dhillon et al. 2014).

use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use super::cis;
use crate::math::chebyshev;
use crate::math::fft::Transformable;
use crate::progress::Progress;
use crate::scattering::grating::{Orders, Place, Powers, Setup, Taps, WINDOW, q};
use crate::spectrum::Wavelengths;
use crate::structure::Heightfield;
use crate::{Error, Result};

/// What a series of amplitudes leaves out, at most.
const AMPLITUDES_REST: f64 = 1e-10;
/// What series of powers and of tables leave out, about, of a single order's power.
const POWERS_REST: f64 = 3e-8;
/// Most bytes of a series of all orders.
const MOST_BYTES: usize = 6 << 30;

/// How far orders and κ are needed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Frequencies along either axis, 1/µm.
    pub frequency_per_um: f64,
    /// −κ, rad/µm.
    pub kappa_per_um: f64,
}

impl Reach {
    /// For all directions at wavelengths through a window.
    #[must_use]
    pub fn of(setup: &Setup, at: &Wavelengths) -> Self {
        let shortest_um = at.range_nm().0 * 1e-3;
        let window = at.nm().iter().map(|nm| setup.coherence.frequency_per_um(nm * 1e-3)).fold(0.0, f64::max);
        Self { frequency_per_um: 2.0 / shortest_um + WINDOW * window, kappa_per_um: 2.0 * TAU / shortest_um }
    }
}

/// In which functions of κ amplitudes are expanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Series {
    /// Chebyshev polynomials over all κ, as many as needed.
    Chebyshev,
    /// Powers of κ up to this order.
    Taylor(usize),
}

/// Amplitudes c_j(κ) = Σ_n b_n(κ) a_nj of all orders.
pub struct Amplitudes {
    orders: Orders,
    series: Series,
    kappa_most: f64,
    /// Largest height, µm: what Taylor's terms are scaled by.
    height_um: f64,
    terms: usize,
    /// Re and Im of a, `[jy][jx][term]`.
    values: Vec<[f64; 2]>,
}

/// Terms of a Chebyshev series of e^{jax} on \[−1, 1\] that leaves out no more than `rest`: its coefficients are 2 J_n(a) ≤
/// 2 (a/2)ⁿ/n!.
fn needed_terms(a: f64, rest: f64) -> usize {
    // The bound as its logarithm: it grows to about e^{a/2} before it falls.
    let rest = libm::log(rest);
    let (mut bound, mut n) = (std::f64::consts::LN_2, 0.0);
    while bound > rest || n < 0.5 * a {
        n += 1.0;
        bound += libm::log(0.5 * a / n);
    }
    n as usize + 1
}

/// Largest height that series are scaled by, µm.
fn scale_um(field: &Heightfield) -> f64 {
    field.reach_um().max(1e-6)
}

/// Which orders, and how many terms.
fn plan(field: &Heightfield, reach: Reach, series: Series) -> (Orders, usize) {
    let most = [0, 1].map(|axis| {
        let needed = (reach.frequency_per_um * field.size_um()[axis]).ceil() as usize;
        // Beyond half the sampling frequency orders would be others'.
        needed.min((field.cells()[axis] - 1) / 2)
    });
    let terms = match series {
        Series::Chebyshev => needed_terms(0.5 * reach.kappa_per_um * scale_um(field), AMPLITUDES_REST),
        Series::Taylor(orders) => orders + 1,
    };
    (Orders { most, period_um: field.size_um() }, terms)
}

impl Amplitudes {
    /// Memory that [`Self::new`] takes at most at once, bytes.
    #[must_use]
    pub fn bytes(field: &Heightfield, reach: Reach, series: Series) -> u64 {
        let (orders, terms) = plan(field, reach, series);
        let [columns, rows] = orders.counts().map(|count| count as u64);
        // The series, and one image: by rows of the patch, by columns, and whole.
        16 * columns * (rows * (terms as u64 + 2) + field.cells()[1] as u64)
    }

    /// Numbers of orders, of terms of the series and of those of powers, before there are any.
    pub(super) fn foretell(field: &Heightfield, reach: Reach, series: Series) -> [u64; 3] {
        let (orders, terms) = plan(field, reach, series);
        let [columns, rows] = orders.counts().map(|count| count as u64);
        let of_powers = needed_terms(reach.kappa_per_um * scale_um(field), POWERS_REST);
        [columns * rows, terms as u64, of_powers as u64]
    }

    /// Transforms of a patch; where the window stands is a phase of each order.
    ///
    /// # Errors
    /// More orders than memory should be spent on, a setup out of range, interruption.
    pub fn new(
        field: &Heightfield,
        setup: &Setup,
        reach: Reach,
        series: Series,
        progress: &dyn Progress,
    ) -> Result<Self> {
        setup.check()?;
        let (orders, terms) = plan(field, reach, series);
        let height_um = scale_um(field);
        let counts = orders.counts();
        if counts[0].saturating_mul(counts[1]).saturating_mul(terms) > MOST_BYTES / 16 {
            return Err(Error::input(format!(
                "{} × {} orders of {terms} terms are more than {} GiB: give a smaller patch, or flatter heights",
                counts[0],
                counts[1],
                MOST_BYTES >> 30
            )));
        }
        let mut values = vec![[0.0; 2]; counts[0] * counts[1] * terms];
        let cosines = chebyshev::cosines(terms);
        let nodes: Vec<f64> = chebyshev::nodes(terms).collect();
        progress.begin("transforms", terms as u64);
        for step in 0..terms {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let kappa = 0.5 * reach.kappa_per_um * (nodes[step] - 1.0);
            let p = |height: f64| match series {
                Series::Chebyshev => cis(kappa * height),
                Series::Taylor(_) => {
                    let power = (height / height_um).powi(step as i32);
                    // jⁿ
                    [Complex64::ONE, Complex64::I, -Complex64::ONE, -Complex64::I][step % 4] * power
                }
            };
            let image = transform(field, &orders, p);
            // What the image at node κ adds to each coefficient; Taylor's images are coefficients.
            let shares: Vec<f64> = match series {
                Series::Taylor(_) => (0..terms).map(|n| f64::from(u8::from(n == step))).collect(),
                Series::Chebyshev => (0..terms)
                    .map(|k| {
                        let weight = if k == 0 { 1.0 } else { 2.0 } / terms as f64;
                        weight * cosines[k * (2 * step + 1) % (4 * terms)]
                    })
                    .collect(),
            };
            values.par_chunks_exact_mut(terms).zip(&image).for_each(|(series, value)| {
                for (sum, share) in series.iter_mut().zip(&shares) {
                    sum[0] += share * value.re;
                    sum[1] += share * value.im;
                }
            });
            progress.advance(1);
        }
        let mut all = Self { orders, series, kappa_most: reach.kappa_per_um, height_um, terms, values };
        if let Place::At(place) = setup.place {
            all.shift(place);
        }
        Ok(all)
    }

    /// Turns the orders' phases to those of a window at a place of the patch.
    fn shift(&mut self, place_um: [f64; 2]) {
        let [columns, _] = self.orders.counts();
        let Orders { most, period_um } = self.orders;
        let turns =
            |axis: usize, place: usize| (place as f64 - most[axis] as f64) * place_um[axis] / period_um[axis];
        for (index, series) in self.values.chunks_exact_mut(self.terms).enumerate() {
            // p = Σ c_j e^{−2πi j·x/T}: seen from the place, an order has this much of its phase already.
            let turn = cis(-TAU * (turns(0, index % columns) + turns(1, index / columns)));
            for value in series {
                let turned = turn * Complex64::new(value[0], value[1]);
                *value = [turned.re, turned.im];
            }
        }
    }

    /// The orders.
    #[must_use]
    pub fn orders(&self) -> &Orders {
        &self.orders
    }

    /// Terms of the series.
    #[must_use]
    pub fn terms(&self) -> usize {
        self.terms
    }

    /// Largest height, µm.
    pub(super) fn height_um(&self) -> f64 {
        self.height_um
    }

    /// Re and Im of the coefficients of an order by its place, one after the other.
    pub(super) fn series_of(&self, place: usize) -> &[[f64; 2]] {
        &self.values[place * self.terms..][..self.terms]
    }

    /// The functions b_n at κ.
    pub(super) fn basis(&self, kappa: f64) -> Vec<f64> {
        if self.series == Series::Chebyshev {
            return self.polynomials(kappa, self.terms);
        }
        let mut basis = vec![1.0];
        for n in 1..self.terms {
            basis.push(basis[n - 1] * kappa * self.height_um / n as f64);
        }
        basis
    }

    /// f at a wavelength within the reach, 1/sr or relative, for the setup that the amplitudes are of.
    #[must_use]
    pub fn value(&self, setup: &Setup, wavelength_um: f64, w_i: DVec3, w_o: DVec3) -> f64 {
        let weight = setup.of_directions(w_i, w_o);
        if weight == 0.0 {
            return 0.0;
        }
        let q = q(w_i, w_o);
        let s_f = setup.coherence.frequency_per_um(wavelength_um);
        let [across, along] =
            [(0, q.x), (1, q.y)].map(|(axis, s)| self.orders.taps(axis, s / wavelength_um, s_f));
        let basis = self.basis(TAU * q.z / wavelength_um);
        weight * setup.of_wavelength(wavelength_um) * self.squared(setup.place, &across, &along, &basis)
    }

    fn squared(&self, place: Place, across: &Taps, along: &Taps, basis: &[f64]) -> f64 {
        let columns = self.orders.counts()[0];
        let (mut amplitude, mut power) = (Complex64::ZERO, 0.0);
        for (row, a) in along.weights().iter().enumerate() {
            for (column, b) in across.weights().iter().enumerate() {
                let series = self.series_of((along.first + row) * columns + across.first + column);
                let c = a * b * sum(series, basis);
                amplitude += c;
                power += c.norm_sqr();
            }
        }
        match place {
            Place::At(_) => amplitude.norm_sqr(),
            Place::Anywhere => power,
        }
    }

    /// Terms over κ, or over w, that powers need.
    pub(super) fn power_terms(&self) -> usize {
        needed_terms(self.kappa_most * self.height_um, POWERS_REST)
    }

    /// So many Chebyshev polynomials over κ.
    pub(super) fn polynomials(&self, kappa: f64, terms: usize) -> Vec<f64> {
        let x = 2.0 * kappa / self.kappa_most + 1.0;
        let mut basis = vec![1.0, x];
        while basis.len() < terms {
            let n = basis.len();
            basis.push(2.0 * x * basis[n - 1] - basis[n - 2]);
        }
        basis.truncate(terms);
        basis
    }

    /// |c_j(κ)|² of all orders.
    ///
    /// # Errors
    /// Too many terms: heights of tens of wavelengths.
    pub fn powers(&self) -> Result<Powers> {
        let terms = self.power_terms();
        let nodes: Vec<Vec<f64>> =
            chebyshev::nodes(terms).map(|x| self.basis(0.5 * self.kappa_most * (x - 1.0))).collect();
        let [columns, rows] = self.orders.counts();
        let series: Vec<f32> = (0..columns * rows)
            .into_par_iter()
            .flat_map_iter(|place| {
                let series = self.series_of(place);
                let at_nodes: Vec<f64> = nodes.iter().map(|basis| sum(series, basis).norm_sqr()).collect();
                chebyshev::coefficients(&at_nodes, 1).into_iter().map(|value| value as f32)
            })
            .collect();
        Powers::new(self.orders, self.kappa_most, terms, series)
    }
}

fn sum(series: &[[f64; 2]], basis: &[f64]) -> Complex64 {
    let [mut re, mut im] = [0.0; 2];
    for (value, b) in series.iter().zip(basis) {
        re += b * value[0];
        im += b * value[1];
    }
    Complex64::new(re, im)
}

/// 1/N Σ p e^{+2πi j·x/T} of the orders, `[jy][jx]`.
fn transform(field: &Heightfield, orders: &Orders, p: impl Fn(f64) -> Complex64 + Sync) -> Vec<Complex64> {
    let [columns, rows] = field.cells();
    let [wanted, rows_wanted] = orders.counts();
    let places = |most: usize, count: usize| move |i: usize| (i + count - most) % count;
    let (column_of, row_of) = (places(orders.most[0], columns), places(orders.most[1], rows));
    let along_x = f64::inverse(columns);
    let lines: Vec<Vec<Complex64>> = field
        .height_um()
        .par_chunks_exact(columns)
        .map(|heights| {
            let mut line: Vec<Complex64> = heights.iter().map(|height| p(*height)).collect();
            along_x.process_once(&mut line);
            (0..wanted).map(|i| line[column_of(i)]).collect()
        })
        .collect();
    let along_y = f64::inverse(rows);
    let scale = 1.0 / (columns as f64 * rows as f64);
    let by_column: Vec<Vec<Complex64>> = (0..wanted)
        .into_par_iter()
        .map(|i| {
            let mut line: Vec<Complex64> = lines.iter().map(|row| row[i]).collect();
            along_y.process_once(&mut line);
            (0..rows_wanted).map(|j| scale * line[row_of(j)]).collect()
        })
        .collect();
    (0..rows_wanted).flat_map(|j| by_column.iter().map(move |column| column[j])).collect()
}
