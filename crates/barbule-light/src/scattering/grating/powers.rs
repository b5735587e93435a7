//! The powers of a patch's diffraction orders over κ: what it scatters in the mean over places, at any wavelength.

use super::{Setup, WINDOW, q};
use crate::{Error, Result};
use glam::DVec3;

/// Most orders along a window, so that its weights fit into registers and stack.
const MOST_TAPS: usize = 128;
/// Most terms over κ.
pub(super) const MOST_TERMS: usize = 128;
/// Most numbers of all series, 2 GiB.
const MOST_VALUES: usize = 1 << 29;

/// The diffraction orders j of a patch that repeats: a rectangle about order 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orders {
    /// The highest along x and y.
    pub most: [usize; 2],
    /// Periods of the patch, µm.
    pub period_um: [f64; 2],
}

/// Orders along one axis that a window lets through.
#[derive(Debug, Clone, Copy)]
pub struct Taps {
    /// Place of the first on the axis, counted from the lowest order.
    pub first: usize,
    count: usize,
    weights: [f64; MOST_TAPS],
}

impl Taps {
    /// What the amplitude of each is weighed by.
    #[inline]
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.count]
    }

    /// With the weights of powers.
    #[inline]
    #[must_use]
    pub fn squared(mut self) -> Self {
        self.weights[..self.count].iter_mut().for_each(|weight| *weight *= *weight);
        self
    }
}

impl Orders {
    /// How many there are along x and y.
    #[must_use]
    pub fn counts(&self) -> [usize; 2] {
        self.most.map(|most| 2 * most + 1)
    }

    /// Refuses windows of a standard deviation s_f with more orders than [`Self::taps`] holds.
    ///
    /// # Errors
    /// s_f, 1/µm, is too great for the patch's periods.
    pub fn check_window(&self, s_f: f64) -> Result<()> {
        let side = self.period_um[0].max(self.period_um[1]);
        if 2.0 * WINDOW * s_f * side > MOST_TAPS as f64 - 2.0 {
            let least = WINDOW * side / (std::f64::consts::PI * (MOST_TAPS as f64 - 2.0));
            return Err(Error::input(format!(
                "a patch of {side} µm is far wider than the coherence: give a coherence of {least:.2} µm or more, or a smaller patch"
            )));
        }
        Ok(())
    }

    /// Orders about a frequency (1/µm) along an axis, weighed by a Gaussian of standard deviation s_f; none beyond the highest.
    ///
    /// A window of more than [`Self::check_window`] admits is cut.
    #[inline]
    #[must_use]
    pub fn taps(&self, axis: usize, frequency: f64, s_f: f64) -> Taps {
        let side = self.period_um[axis];
        let most = self.most[axis] as f64;
        let reach = WINDOW * s_f * side;
        let low = (frequency * side - reach).ceil().max(-most);
        let high = (frequency * side + reach).floor().min(most);
        let count = ((high - low + 1.0).max(0.0) as usize).min(MOST_TAPS);
        let mut weights = [0.0; MOST_TAPS];
        let scale = 1.0 / (side * s_f);
        for (i, weight) in weights[..count].iter_mut().enumerate() {
            let away = (frequency * side - low - i as f64) * scale;
            *weight = libm::exp(-0.5 * away * away);
        }
        Taps { first: if count > 0 { (low + most) as usize } else { 0 }, count, weights }
    }
}

/// |c_j(κ)|² of every order as Chebyshev series over κ = kw from −`kappa_most` to 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Powers {
    orders: Orders,
    kappa_most: f64,
    terms: usize,
    /// `[jy][jx][term]`
    series: Vec<f32>,
}

impl Powers {
    /// From coefficients `[jy][jx][term]`; `kappa_most` in rad/µm.
    ///
    /// # Errors
    /// Counts that do not fit each other or are too great, numbers that are not finite.
    pub fn new(orders: Orders, kappa_most: f64, terms: usize, series: Vec<f32>) -> Result<Self> {
        let counts = orders.most.map(|most| most.checked_mul(2).and_then(|twice| twice.checked_add(1)));
        let whole = counts[0].zip(counts[1]).and_then(|(x, y)| x.checked_mul(y)?.checked_mul(terms));
        if whole != Some(series.len()) || series.len() > MOST_VALUES || !(1..=MOST_TERMS).contains(&terms) {
            return Err(Error::input(format!(
                "{} numbers do not fit ±{} × ±{} orders of {terms} terms (at most {MOST_TERMS})",
                series.len(),
                orders.most[0],
                orders.most[1]
            )));
        }
        if !orders.period_um.iter().all(|side| (1e-3..=1e6).contains(side))
            || !(1e-3..=1e4).contains(&kappa_most)
        {
            return Err(Error::input("a grating's periods or its range of κ are out of range"));
        }
        if let Some(bad) = series.iter().position(|value| !value.is_finite()) {
            return Err(Error::input(format!("number {bad} of a grating's series is not finite")));
        }
        Ok(Self { orders, kappa_most, terms, series })
    }

    /// The mean of several patches of the same orders, which are taken one after the other.
    ///
    /// # Errors
    /// A patch's own; no patches, or such of other orders or another range of κ.
    pub fn mean(patches: impl IntoIterator<Item = Result<Self>>) -> Result<Self> {
        let mut patches = patches.into_iter();
        let none = || Error::input("gratings of other orders have no mean");
        let mut sum = patches.next().ok_or_else(none)??;
        let mut count = 1.0;
        for patch in patches {
            let patch = patch?;
            if patch.orders != sum.orders || patch.kappa_most != sum.kappa_most {
                return Err(none());
            }
            let (mut more, fewer) = if patch.terms > sum.terms { (patch, sum) } else { (sum, patch) };
            let series = more.series.chunks_exact_mut(more.terms).zip(fewer.series.chunks_exact(fewer.terms));
            for (sums, values) in series {
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            }
            sum = more;
            count += 1.0;
        }
        sum.series.iter_mut().for_each(|value| *value /= count);
        Ok(sum)
    }

    /// The orders.
    #[must_use]
    pub fn orders(&self) -> &Orders {
        &self.orders
    }

    /// −κ where the series end, rad/µm.
    #[must_use]
    pub fn kappa_most(&self) -> f64 {
        self.kappa_most
    }

    /// Terms of each series.
    #[must_use]
    pub fn terms(&self) -> usize {
        self.terms
    }

    /// The coefficients, `[jy][jx][term]`.
    #[must_use]
    pub fn series(&self) -> &[f32] {
        &self.series
    }

    /// Chebyshev polynomials at κ (held at the ends of the range).
    #[inline]
    fn basis(&self, kappa: f64) -> [f32; MOST_TERMS] {
        let x = (2.0 * kappa / self.kappa_most + 1.0).clamp(-1.0, 1.0);
        let mut basis = [0.0; MOST_TERMS];
        let (mut before, mut now) = (x, 1.0);
        for term in &mut basis[..self.terms] {
            *term = now as f32;
            (before, now) = (now, 2.0 * x * now - before);
        }
        basis
    }

    /// |c_j|² of an order by its place, `jy·columns + jx` from the lowest.
    #[inline]
    fn sum(&self, place: usize, basis: &[f32; MOST_TERMS]) -> f64 {
        let series = &self.series[place * self.terms..][..self.terms];
        let sum: f32 = series.iter().zip(basis).map(|(c, t)| c * t).sum();
        f64::from(sum.max(0.0))
    }

    /// All |c_j|² at κ, `[jy][jx]`.
    #[must_use]
    pub fn all_at(&self, kappa: f64) -> Vec<f64> {
        let basis = self.basis(kappa);
        let [columns, rows] = self.orders.counts();
        (0..columns * rows).map(|place| self.sum(place, &basis)).collect()
    }

    /// Σ_j |c_j(κ)|² exp(−|f − j/T|²/s_f²) at a frequency f and a window s_f, both 1/µm.
    #[inline]
    #[must_use]
    pub fn smoothed(&self, frequency: [f64; 2], kappa: f64, s_f: f64) -> f64 {
        let [across, along] = [0, 1].map(|axis| self.orders.taps(axis, frequency[axis], s_f).squared());
        let basis = self.basis(kappa);
        let columns = self.orders.counts()[0];
        let mut all = 0.0;
        for (row, a) in along.weights().iter().enumerate() {
            let start = (along.first + row) * columns + across.first;
            let line: f64 =
                across.weights().iter().enumerate().map(|(i, b)| b * self.sum(start + i, &basis)).sum();
            all += a * line;
        }
        all
    }

    /// f at a wavelength in the mean over places, 1/sr or relative. The setup's place is not asked.
    #[must_use]
    pub fn value(&self, setup: &Setup, wavelength_um: f64, w_i: DVec3, w_o: DVec3) -> f64 {
        let weight = setup.of_directions(w_i, w_o);
        if weight == 0.0 {
            return 0.0;
        }
        let q = q(w_i, w_o);
        let s_f = setup.coherence.frequency_per_um(wavelength_um);
        let kappa = std::f64::consts::TAU * q.z / wavelength_um;
        let squared = self.smoothed([q.x / wavelength_um, q.y / wavelength_um], kappa, s_f);
        weight * setup.of_wavelength(wavelength_um) * squared
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two orders of constant power: the sum of two Gaussians.
    #[test]
    fn powers_are_seen_through_the_window() {
        let orders = Orders { most: [1, 0], period_um: [10.0, 10.0] };
        let powers = Powers::new(orders, 30.0, 2, vec![0.25, 0.0, 0.0, 0.0, 0.5, 0.25]).unwrap();
        let (f, s_f, kappa) = ([0.02, 0.01], 0.05, -15.0 * 0.5);
        let gauss = |x: f64, y: f64| (-(x * x + y * y) / (s_f * s_f)).exp();
        // The second series is 0.5 + 0.25 x, x = 0.5 at this κ.
        let expected = 0.25 * gauss(0.12, 0.01) + 0.625 * gauss(-0.08, 0.01);
        assert!((powers.smoothed(f, kappa, s_f) / expected - 1.0).abs() < 1e-7);
        // Nothing beyond the highest order, though the patch repeats.
        assert_eq!(powers.smoothed([0.2, 1.0], kappa, s_f), 0.0);
        assert!((powers.all_at(kappa)[2] - 0.625).abs() < 1e-7);
    }

    #[test]
    fn patches_of_one_or_several_terms_have_a_mean() {
        let orders = Orders { most: [1, 0], period_um: [10.0, 10.0] };
        let of = |terms: usize, values: &[f32]| Powers::new(orders, 30.0, terms, values.to_vec());
        let flat = [0.25, 0.0, 0.5];
        let sloping = [0.5, 0.25, 0.0, 0.5, 0.25, 0.0];
        let expected = of(2, &[0.375, 0.125, 0.0, 0.25, 0.375, 0.0]).unwrap();
        assert_eq!(Powers::mean([of(1, &flat), of(2, &sloping)]).unwrap(), expected);
        assert_eq!(Powers::mean([of(2, &sloping), of(1, &flat)]).unwrap(), expected);
        let other = Powers::new(orders, 31.0, 1, flat.to_vec());
        assert!(Powers::mean([of(1, &flat), other]).is_err() && Powers::mean([]).is_err());
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let orders = Orders { most: [1, 0], period_um: [10.0, 10.0] };
        assert!(Powers::new(orders, 30.0, 2, vec![0.0; 5]).is_err());
        assert!(Powers::new(orders, 30.0, 1, vec![0.0, f32::NAN, 0.0]).is_err());
        assert!(Powers::new(orders, 0.0, 1, vec![0.0; 3]).is_err());
        let huge = Orders { most: [usize::MAX, 3], period_um: [10.0, 10.0] };
        assert!(Powers::new(huge, 30.0, 1, vec![]).is_err());
        assert!(orders.check_window(0.1).is_ok() && orders.check_window(3.0).is_err());
    }
}
