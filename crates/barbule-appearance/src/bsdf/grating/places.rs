//! Where the powers of orders stand over frequencies, and how each is spread about its place by the window of coherence.
//!
//! Orders that lie as far apart as the window is wide, or farther, are summed themselves, each with its Gaussian ([`Spread::Window`]): there
//! are few at a time, and their powers are read where they lie. Denser ones are seen through the window once, at places one standard
//! deviation apart, with tents between ([`Spread::Tents`]). So neither memory nor the number of places about a frequency grows with
//! the coherence.

use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::sync::Arc;

use rayon::prelude::*;

use super::Grating;
use crate::scattering::grating::{Orders, Powers};

/// The window counts up to so many standard deviations along an axis.
pub(super) const REACH: f64 = 3.5;
/// erf(REACH/√2): what the window holds along an axis.
const WITHIN: f64 = 0.999_534_741_841_929;
/// A table's narrower one up to so many: as large as a table is, more cost little.
const TABLE_REACH: f64 = 4.5;
/// Frequencies of a table are so far apart, in standard deviations of the window.
const STEP: f64 = 1.0;
/// Orders within the window, in both axes, up to which they are summed themselves.
const MOST_TAPS: usize = 25;
/// Most terms over κ.
pub(super) const MOST_TERMS: usize = 64;

/// Powers over frequencies.
#[derive(Debug)]
pub(super) struct Places {
    spread: Spread,
    /// Distance of places along x and y, 1/µm.
    pub(super) step: [f64; 2],
    /// Places on either side of frequency 0.
    pub(super) most: [usize; 2],
    kappa_most: f64,
    terms: usize,
    series: Series,
}

/// What a place of a table stands for of the window's integral.
pub(super) const SHARE_OF_WINDOW: f64 = STEP * STEP / (2.0 * PI);

/// How the power of a place reaches its neighbourhood.
#[derive(Debug, Clone, Copy)]
enum Spread {
    /// 1 at the place, 0 at its neighbours.
    Tents,
    /// exp(−f²/2σ²) of this standard deviation, 1/µm.
    Window(f64),
}

/// Chebyshev series over κ, `[fy][fx][term]`.
#[derive(Debug)]
enum Series {
    OfOrders(Arc<Powers>),
    Smoothed(Vec<f32>),
}

/// The places about a frequency along an axis and their weights.
#[derive(Clone, Copy)]
struct Taps {
    first: usize,
    count: usize,
    weights: [f32; MOST_TAPS],
}

impl Taps {
    const NONE: Self = Self { first: 0, count: 0, weights: [0.0; MOST_TAPS] };
}

/// Highest frequency of light of any direction, 1/µm.
fn highest() -> f64 {
    2e3 / Grating::BAND.low_nm()
}

/// Whether so few orders are in the window at a time that they are summed themselves.
fn is_sparse(orders: &Orders, deviation: f64) -> bool {
    let within = [0, 1].map(|axis| {
        let about = (2.0 * REACH * deviation * orders.period_um[axis]).floor() + 1.0;
        about.min(orders.counts()[axis] as f64)
    });
    within[0] * within[1] <= MOST_TAPS as f64
}

/// Places of a table on either side of frequency 0.
fn places_of_table(orders: &Orders, deviation: f64) -> [usize; 2] {
    [0, 1].map(|axis| {
        let far = orders.most[axis] as f64 / orders.period_um[axis] + TABLE_REACH * deviation;
        (far.min(highest()) / (STEP * deviation)).ceil() as usize
    })
}

impl Places {
    /// For a window of which powers have the standard deviation `deviation`, 1/µm.
    pub(super) fn new(powers: &Arc<Powers>, deviation: f64) -> Self {
        let orders = powers.orders();
        if !is_sparse(orders, deviation) {
            return Self::smoothed(powers, deviation);
        }
        Self {
            spread: Spread::Window(deviation),
            step: orders.period_um.map(f64::recip),
            most: orders.most,
            kappa_most: powers.kappa_most(),
            terms: powers.terms(),
            series: Series::OfOrders(powers.clone()),
        }
    }

    /// A table, whatever its size.
    pub(super) fn smoothed(powers: &Powers, deviation: f64) -> Self {
        let (step, most) = (STEP * deviation, places_of_table(powers.orders(), deviation));
        Self {
            spread: Spread::Tents,
            step: [step; 2],
            most,
            kappa_most: powers.kappa_most(),
            terms: powers.terms(),
            series: Series::Smoothed(through_window(powers, most, step, deviation)),
        }
    }

    /// How many places [`Self::new`] has, and bytes of their series beside the powers.
    pub(super) fn foretell(powers: &Powers, deviation: f64) -> [u64; 2] {
        let orders = powers.orders();
        let is_sparse = is_sparse(orders, deviation);
        let most = if is_sparse { orders.most } else { places_of_table(orders, deviation) };
        let count = most.map(|most| 2 * most as u64 + 1).into_iter().product::<u64>();
        [count, if is_sparse { 0 } else { 4 * count * powers.terms() as u64 }]
    }

    pub(super) fn kappa_most(&self) -> f64 {
        self.kappa_most
    }

    pub(super) fn columns(&self) -> usize {
        2 * self.most[0] + 1
    }

    pub(super) fn rows(&self) -> usize {
        2 * self.most[1] + 1
    }

    /// ∫ of what a place is spread by over frequencies, 1/µm².
    pub(super) fn area(&self) -> f64 {
        match self.spread {
            Spread::Tents => self.step[0] * self.step[1],
            Spread::Window(deviation) => 2.0 * PI * deviation * deviation,
        }
    }

    /// Standard deviation of the Gaussian by which each place is spread, 1/µm; none of tents.
    pub(super) fn deviation(&self) -> Option<f64> {
        match self.spread {
            Spread::Tents => None,
            Spread::Window(deviation) => Some(deviation),
        }
    }

    pub(super) fn terms(&self) -> usize {
        self.terms
    }

    /// What a sum is multiplied by so that nothing is lost where the window ends.
    pub(super) fn kept(&self) -> f64 {
        match self.spread {
            Spread::Tents => 1.0,
            Spread::Window(_) => 1.0 / (WITHIN * WITHIN),
        }
    }

    /// Chebyshev polynomials at κ.
    #[inline]
    pub(super) fn basis(&self, kappa: f64) -> [f32; MOST_TERMS] {
        let x = ((2.0 * kappa / self.kappa_most + 1.0).clamp(-1.0, 1.0)) as f32;
        let mut basis = [0.0; MOST_TERMS];
        let (mut before, mut now) = (x, 1.0);
        for term in &mut basis[..self.terms] {
            *term = now;
            (before, now) = (now, 2.0 * x * now - before);
        }
        basis
    }

    #[inline]
    pub(super) fn series(&self) -> &[f32] {
        match &self.series {
            Series::OfOrders(powers) => powers.series(),
            Series::Smoothed(series) => series,
        }
    }

    /// Power of a place, with the polynomials at κ.
    #[inline]
    pub(super) fn power(&self, place: usize, basis: &[f32; MOST_TERMS]) -> f32 {
        let series = &self.series()[place * self.terms..][..self.terms];
        series.iter().zip(basis).map(|(c, t)| c * t).sum::<f32>().max(0.0)
    }

    /// At a frequency, 1/µm, and κ: Σ of the powers about it, each by its weight, and of the `share`s of the places.
    #[inline]
    pub(super) fn sums(&self, f: [f64; 2], kappa: f64, share: &[f32]) -> Option<[f32; 2]> {
        let [across, along] = [self.taps(0, f[0]), self.taps(1, f[1])];
        if across.count == 0 || along.count == 0 {
            return None;
        }
        let (series, terms, columns) = (self.series(), self.terms, self.columns());
        let mut sums = [0.0; MOST_TERMS];
        let mut shares = 0.0;
        for (row, by_row) in along.weights[..along.count].iter().enumerate() {
            let start = (along.first + row) * columns + across.first;
            let lines = series[start * terms..].chunks_exact(terms).zip(&share[start..]);
            for (by_column, (line, share)) in across.weights[..across.count].iter().zip(lines) {
                let weight = by_row * by_column;
                for (sum, value) in sums[..terms].iter_mut().zip(line) {
                    *sum += weight * value;
                }
                shares += weight * share;
            }
        }
        let basis = self.basis(kappa);
        let power = sums[..terms].iter().zip(&basis).map(|(c, t)| c * t).sum::<f32>();
        Some([power.max(0.0), shares])
    }

    #[inline]
    fn taps(&self, axis: usize, f: f64) -> Taps {
        let at = f / self.step[axis] + self.most[axis] as f64;
        let last = 2.0 * self.most[axis] as f64;
        match self.spread {
            Spread::Tents => {
                let low = at.floor();
                if !(-1.0..=last).contains(&low) {
                    return Taps::NONE;
                }
                let part = (at - low) as f32;
                let mut taps = Taps::NONE;
                if low < 0.0 {
                    (taps.count, taps.weights[0]) = (1, part);
                } else {
                    taps.first = low as usize;
                    taps.count = if low < last { 2 } else { 1 };
                    taps.weights[..2].copy_from_slice(&[1.0 - part, part]);
                }
                taps
            }
            Spread::Window(deviation) => self.window(axis, at, deviation / self.step[axis]),
        }
    }

    /// Orders about a place (counted from the lowest one) through a Gaussian as wide as `deviation` orders. Neighbours' weights have ratios
    /// that themselves have one ratio, so that two exponentials give all.
    #[inline]
    fn window(&self, axis: usize, at: f64, deviation: f64) -> Taps {
        let reach = REACH * deviation;
        let low = (at - reach).ceil().max(0.0);
        let high = (at + reach).floor().min(2.0 * self.most[axis] as f64);
        if high < low {
            return Taps::NONE;
        }
        let mut taps = Taps { first: low as usize, ..Taps::NONE };
        taps.count = ((high - low) as usize + 1).min(MOST_TAPS);
        let apart = deviation.recip();
        let away = (at - low) * apart;
        let mut weight = libm::exp(-0.5 * away * away);
        taps.weights[0] = weight as f32;
        if taps.count > 1 {
            let mut ratio = libm::exp(apart * (away - 0.5 * apart));
            let step = libm::exp(-apart * apart);
            for tap in &mut taps.weights[1..taps.count] {
                weight *= ratio;
                ratio *= step;
                *tap = weight as f32;
            }
        }
        taps
    }

    /// A frequency about a place, as its power is spread, from two uniform numbers; none beyond the window's end.
    #[inline]
    pub(super) fn about(&self, [column, row]: [usize; 2], u: [f64; 2]) -> Option<[f64; 2]> {
        let place = [column as f64 - self.most[0] as f64, row as f64 - self.most[1] as f64];
        let offset = match self.spread {
            Spread::Tents => u.map(|u| self.step[0] * tent(u)),
            Spread::Window(deviation) => {
                let radius = (-2.0 * libm::log(1.0 - u[0])).sqrt();
                let (sin, cos) = libm::sincos(2.0 * PI * u[1]);
                let normal = [radius * cos, radius * sin];
                if normal.iter().any(|z| z.abs() >= REACH) {
                    return None;
                }
                normal.map(|z| deviation * z)
            }
        };
        Some([0, 1].map(|axis| place[axis] * self.step[axis] + offset[axis]))
    }
}

/// Standard deviation of the window on powers of one of amplitudes, s_f.
pub(super) fn of_powers(s_f: f64) -> f64 {
    s_f * FRAC_1_SQRT_2
}

/// −1 … 1 with the density 1 − |t| from a uniform number.
fn tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).max(0.0).sqrt() }
}

/// Powers through the window at each place of a table, `[fy][fx][term]`. Its tents widen what they interpolate by step²/6, which the window
/// is narrower for; each order keeps its integral 2πσ².
fn through_window(powers: &Powers, most: [usize; 2], step: f64, deviation: f64) -> Vec<f32> {
    let narrow = (deviation * deviation - step * step / 6.0).sqrt();
    let orders = powers.orders();
    let (terms, [columns, rows]) = (powers.terms(), orders.counts());
    // Orders about a place along an axis, and their weights.
    let window = |axis: usize, place: usize| {
        let f = (place as f64 - most[axis] as f64) * step;
        let (side, highest) = (orders.period_um[axis], orders.most[axis] as f64);
        let reach = TABLE_REACH * narrow;
        let low = ((f - reach) * side).ceil().max(-highest);
        let high = ((f + reach) * side).floor().min(highest);
        let count = (high - low + 1.0).max(0.0) as usize;
        let weight = move |i: usize| {
            let away = (f - (low + i as f64) / side) / narrow;
            (deviation / narrow * libm::exp(-0.5 * away * away)) as f32
        };
        let first = if count > 0 { (low + highest) as usize } else { 0 };
        (0..count).map(move |i| (first + i, weight(i)))
    };
    let [across, along] = most.map(|most| 2 * most + 1);
    let mut series = vec![0.0; across * along * terms];
    let fill = |line: &mut Vec<f32>, (fy, row): (usize, &mut [f32])| {
        line.fill(0.0);
        for (jy, weight) in window(1, fy).filter(|(jy, _)| *jy < rows) {
            let orders = &powers.series()[jy * columns * terms..][..columns * terms];
            line.iter_mut().zip(orders).for_each(|(sum, value)| *sum += weight * value);
        }
        for (fx, place) in row.chunks_exact_mut(terms).enumerate() {
            for (jx, weight) in window(0, fx) {
                let order = &line[jx * terms..][..terms];
                place.iter_mut().zip(order).for_each(|(sum, value)| *sum += weight * value);
            }
        }
    };
    let line = || vec![0.0; columns * terms];
    series.par_chunks_exact_mut(across * terms).enumerate().for_each_init(line, fill);
    series
}
