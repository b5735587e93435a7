//! Where light leaves along the barbule: the spread E/Q, as a mixture of Gaussians, and draws from it.
//!
//! Each Gaussian is E = exp(−t²/σ²), t = sin((θ_i + θ_o)/2), which is h_y of a half vector in the barbule's long plane, over
//! Q = ∫ E cosθ_o dθ_o. The first is the narrow one of the barbule's own bends, the others are the halo. Their widths are the
//! same at all wavelengths and directions, their shares are not: so one exponential serves all wavelengths, and what nodes with
//! other shares mix reflects exactly what they reflect.

use std::borrow::Cow;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

use bytemuck::cast_slice;

use super::arrays::{Arrays, Numbers, TableArray};
use super::halo::{HALO_SIGMAS, MOST_HALOS};
use super::material::check_sigma;
use super::table::{Shares, Simplex};
use crate::math::normal;
use crate::math::quadrature::gauss_legendre;
use crate::{Error, Result};

/// Gaussians of a mixture at most.
pub(super) const PARTS: usize = 1 + MOST_HALOS;

/// Intervals of the table of 1/Q: linear interpolation is right to 1e-6 at σ = 0.04, to 1e-5 at the smallest.
const INTERVALS: usize = 4096;

/// exp(−this) is nothing.
pub(super) const END: f64 = 45.0;

/// erf of more than this is 1.
const SURE: f64 = 6.0;

/// The longitudinal spread.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Longitudinal {
    /// σ of the narrow Gaussian, then of the halo's, rising.
    sigmas: Vec<f64>,
    /// 1/Q of each Gaussian at evenly spaced √cosθ_i; 0 where there is none.
    inverse_q: Vec<[f64; PARTS]>,
    /// Of the nodes of the tables, `[θ_i, φ_i, λ]`; the unused ones 0. Empty without a halo.
    shares: Vec<Shares>,
}

impl Longitudinal {
    /// `shares` are empty for a single σ.
    pub(super) fn new(sigmas: Vec<f64>, shares: Vec<Shares>) -> Self {
        let rule = gauss_legendre(32);
        let inverse_q = (0..=INTERVALS)
            .map(|k| {
                let cos_theta = (k as f64 / INTERVALS as f64).powi(2);
                let theta_i = libm::acos(cos_theta);
                let of = |sigma: &f64| 1.0 / spread_integral(&rule, *sigma, theta_i);
                std::array::from_fn(|part| sigmas.get(part).map_or(0.0, of))
            })
            .collect();
        Self { sigmas, inverse_q, shares }
    }

    /// `nodes` are the sizes of the tables.
    pub(super) fn arrays(&self, nodes: [usize; 3]) -> Vec<TableArray<'_>> {
        let count = self.sigmas.len();
        // Rows are as long as the most parts there can be.
        let inverse_q = match count {
            PARTS => Cow::Borrowed(self.inverse_q.as_flattened()),
            _ => Cow::Owned(self.inverse_q.iter().flat_map(|row| row[..count].to_vec()).collect()),
        };
        let mut all = vec![TableArray {
            name: "inverse_q".into(),
            shape: vec![INTERVALS + 1, count],
            numbers: Numbers::F64(inverse_q),
        }];
        if !self.shares.is_empty() {
            let [thetas, phis, waves] = nodes;
            let shares = cast_slice::<Shares, f32>(&self.shares);
            all.push(TableArray::new("along", &[thetas, phis, waves, PARTS], shares));
        }
        all
    }

    pub(super) fn from_arrays(
        from: Arrays<'_>,
        sigma: f64,
        halo: [f64; MOST_HALOS],
        nodes: [usize; 3],
    ) -> Result<Self> {
        let sigmas: Vec<f64> = std::iter::once(sigma).chain(halo.into_iter().filter(|s| *s != 0.0)).collect();
        check_sigma(sigma)?;
        let [low, high] = HALO_SIGMAS;
        if halo != padded(&sigmas[1..]) || sigmas[1..].iter().any(|s| !(low..=high).contains(s)) {
            return Err(Error::input(format!(
                "the halo of the tables has σ {halo:?}, but must have up to {MOST_HALOS} from {low} to {high}"
            )));
        }
        let rows = from.get::<f64>("inverse_q", &[INTERVALS + 1, sigmas.len()], &[[1e-3, 1e9]])?;
        let padded_row = |row: &[f64]| std::array::from_fn(|part| row.get(part).copied().unwrap_or_default());
        let inverse_q = rows.chunks_exact(sigmas.len()).map(padded_row).collect();
        let [thetas, phis, waves] = nodes;
        let shares = if sigmas.len() > 1 {
            let shares =
                from.get::<f32>("along", &[thetas, phis, waves, PARTS], &[[0.0, 1.0]])?.as_chunks().0;
            shares.iter().map(|shares| Shares(*shares)).collect()
        } else {
            Vec::new()
        };
        if let Some(at) = shares.iter().position(|Shares(s)| (s.iter().sum::<f32>() - 1.0).abs() > 1e-5) {
            return Err(Error::input(format!(
                "the shares of node {at} in array along do not sum to 1; make the tables again from the material"
            )));
        }
        Ok(Self { sigmas, inverse_q, shares })
    }

    /// σ of the narrow Gaussian.
    pub(super) fn sigma(&self) -> f64 {
        self.sigmas[0]
    }

    pub(super) fn sigmas(&self) -> &[f64] {
        &self.sigmas
    }

    /// σ of the halo's Gaussians, 0 where there are fewer.
    pub(super) fn halo(&self) -> [f64; MOST_HALOS] {
        padded(&self.sigmas[1..])
    }

    /// Of the nodes; empty without a halo.
    #[inline(always)]
    pub(super) fn shares(&self) -> &[Shares] {
        &self.shares
    }

    /// The shares of mixed nodes.
    pub(super) fn mixed(&self, simplex: &Simplex) -> [f64; PARTS] {
        if self.shares.is_empty() {
            return ALONE;
        }
        let mut mixed = [0.0; PARTS];
        for (at, weight) in simplex.at.iter().zip(simplex.weight) {
            for (sum, share) in mixed.iter_mut().zip(self.shares[*at as usize].0) {
                *sum += f64::from(weight) * f64::from(share);
            }
        }
        mixed
    }

    /// 1/Q of each Gaussian at this cosθ_i; 0 where there is none.
    #[inline(always)]
    pub(super) fn inverse_q(&self, cos_theta: f64) -> [f64; PARTS] {
        let position = cos_theta.clamp(0.0, 1.0).sqrt() * INTERVALS as f64;
        let index = (position as usize).min(INTERVALS - 1);
        let t = position - index as f64;
        let [low, high] = [&self.inverse_q[index], &self.inverse_q[index + 1]];
        std::array::from_fn(|part| low[part] * (1.0 - t) + high[part] * t)
    }

    /// E/Q of the mixture for the y of ω_i and of ω_o and the cosines of θ_i and θ_o.
    pub(super) fn value(&self, shares: &[f64; PARTS], incident: [f64; 2], outgoing: [f64; 2]) -> f64 {
        let t2 = half_sine_squared(incident, outgoing);
        let inverse_q = self.inverse_q(incident[1]);
        let of = |k: usize, sigma: f64| shares[k] * (-t2 / (sigma * sigma)).exp() * inverse_q[k];
        self.sigmas.iter().enumerate().map(|(k, sigma)| of(k, *sigma)).sum()
    }

    /// sinθ_o and cosθ_o. t is normal with the standard deviation σ/√2, cut at the horizons; first its Gaussian is chosen, and
    /// what is left of u is uniform again.
    pub(super) fn draw(&self, shares: &[f64; PARTS], [y_i, cos_i]: [f64; 2], u: f64) -> [f64; 2] {
        let (mut part, mut rest) = (0, u);
        if self.sigmas.len() > 1 {
            let last = (0..self.sigmas.len()).rev().find(|k| shares[*k] > 0.0).unwrap_or(0);
            rest *= shares.iter().sum::<f64>();
            while part < last && rest >= shares[part] {
                rest -= shares[part];
                part += 1;
            }
            rest = (rest / shares[part].max(f64::MIN_POSITIVE)).clamp(0.0, 1.0 - f64::EPSILON);
        }
        let sigma = self.sigmas[part];
        let (low, high) = ends(y_i);
        let [from, to] = [low, high].map(|t| 0.5 * libm::erfc(-t / sigma));
        let p = (from + rest * (to - from)).clamp(1e-300, 1.0 - f64::EPSILON / 2.0);
        let t = sigma * FRAC_1_SQRT_2 * normal::quantile(p);
        let t = t.clamp(low, high);
        let (sine, cosine) = (2.0 * t * (1.0 - t * t).max(0.0).sqrt(), 1.0 - 2.0 * t * t);
        [sine * cos_i - cosine * y_i, (cosine * cos_i + sine * y_i).max(0.0)]
    }

    /// Density of θ_o over cosθ_o of each Gaussian: what the density of φ_o is to be multiplied by for that of ω_o per sr.
    #[inline]
    pub(super) fn densities(&self, [y_i, cos_i]: [f64; 2], [y_o, cos_o]: [f64; 2]) -> [f64; PARTS] {
        let (low, high) = ends(y_i);
        let t2 = half_sine_squared([y_i, cos_i], [y_o, cos_o]);
        let mut values = [0.0; PARTS];
        for (value, &sigma) in values.iter_mut().zip(&self.sigmas) {
            let erf = |t: f64| if t > SURE * sigma { 1.0 } else { libm::erf(t / sigma) };
            let mass = erf(high) + erf(-low);
            // dt = ½ √(1 − t²) dθ_o; the normal density is exp(−t²/σ²)/(σ√π) over half of `mass`.
            let spread = (-t2 / (sigma * sigma)).exp() * (1.0 - t2).max(0.0).sqrt();
            *value = spread / (sigma * PI.sqrt() * mass * cos_o);
        }
        values
    }

    /// That of the mixture.
    pub(super) fn density(&self, shares: &[f64; PARTS], incident: [f64; 2], outgoing: [f64; 2]) -> f64 {
        self.densities(incident, outgoing).iter().zip(shares).map(|(value, share)| value * share).sum()
    }
}

/// All of it in the narrow Gaussian.
pub(super) const ALONE: [f64; PARTS] = [1.0, 0.0, 0.0, 0.0];

fn padded(sigmas: &[f64]) -> [f64; MOST_HALOS] {
    std::array::from_fn(|k| sigmas.get(k).copied().unwrap_or_default())
}

/// t at θ_o = ∓90°.
fn ends(y_i: f64) -> (f64, f64) {
    (-(0.5 * (1.0 - y_i)).max(0.0).sqrt(), (0.5 * (1.0 + y_i)).max(0.0).sqrt())
}

/// t² = sin²((θ_i + θ_o)/2) from sines and cosines, without cancellation.
#[inline]
pub(super) fn half_sine_squared([y_i, cos_i]: [f64; 2], [y_o, cos_o]: [f64; 2]) -> f64 {
    let sine = y_i * cos_o + y_o * cos_i;
    let cosine = cos_i * cos_o - y_i * y_o;
    // For directions that run together, sinδ is small where t is 1.
    if cosine > 0.0 { sine * sine / (2.0 * (1.0 + cosine)) } else { 0.5 * (1.0 - cosine) }
}

/// Q = ∫ exp(−sin²((θ_i + θ_o)/2)/σ²) cosθ_o dθ_o.
fn spread_integral(rule: &[(f64, f64)], sigma: f64, theta_i: f64) -> f64 {
    let farthest = 2.0 * libm::asin((END.sqrt() * sigma).min(1.0));
    let side = |end: f64| -> f64 {
        let width = end.abs().min(farthest) * end.signum();
        let term = |&(u, w): &(f64, f64)| {
            let delta = width * u;
            let t = libm::sin(0.5 * delta) / sigma;
            w * libm::exp(-t * t) * libm::cos(delta - theta_i)
        };
        width.abs() * rule.iter().map(term).sum::<f64>()
    };
    side(FRAC_PI_2 + theta_i) + side(theta_i - FRAC_PI_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ of a function of (sinθ_o, cosθ_o) over θ_o, by the midpoint rule.
    fn over_theta(of: impl Fn([f64; 2]) -> f64) -> f64 {
        let count = 100_000;
        let step = PI / f64::from(count);
        let theta = |k: i32| (f64::from(k) + 0.5) * step - FRAC_PI_2;
        (0..count).map(|k| of([theta(k).sin(), theta(k).cos()])).sum::<f64>() * step
    }

    #[test]
    fn the_spread_integrates_to_one() {
        let mixture = vec![0.02, 0.1, 0.3, 0.6];
        for (sigmas, shares) in [
            (vec![0.01], ALONE),
            (vec![0.04], ALONE),
            (vec![0.25], ALONE),
            (mixture.clone(), [0.5, 0.2, 0.2, 0.1]),
            (mixture, [0.0, 0.0, 0.0, 1.0]),
        ] {
            let longitudinal = Longitudinal::new(sigmas.clone(), Vec::new());
            for theta_i in [0.0, 0.5, -1.0, 1.4, 1.55, 1.5705] {
                let incident = [f64::sin(theta_i), f64::cos(theta_i)];
                let sum =
                    over_theta(|outgoing| longitudinal.value(&shares, incident, outgoing) * outgoing[1]);
                assert!((sum - 1.0).abs() < 4e-6, "{sigmas:?} {theta_i}: {sum}");
                let sum =
                    over_theta(|outgoing| longitudinal.density(&shares, incident, outgoing) * outgoing[1]);
                assert!((sum - 1.0).abs() < 4e-6, "{sigmas:?} {theta_i}: density {sum}");
            }
        }
    }

    /// Draws at evenly spaced u have the density's shares on either side of a θ_o.
    #[test]
    fn draws_of_a_mixture_follow_its_density() {
        let longitudinal = Longitudinal::new(vec![0.03, 0.2], Vec::new());
        let shares = [0.7, 0.3, 0.0, 0.0];
        for theta_i in [0.0, 0.6, -1.3] {
            let incident = [f64::sin(theta_i), f64::cos(theta_i)];
            let count = 40_000;
            let drawn: Vec<f64> = (0..count)
                .map(|k| longitudinal.draw(&shares, incident, (f64::from(k) + 0.5) / f64::from(count))[0])
                .collect();
            for edge in [-0.3, -0.05, 0.01, 0.1, 0.4] {
                let place: f64 = edge - incident[0];
                let found = drawn.iter().filter(|y| **y < place).count() as f64 / f64::from(count);
                let below = |outgoing: [f64; 2]| {
                    let value = longitudinal.density(&shares, incident, outgoing) * outgoing[1];
                    if outgoing[0] < place { value } else { 0.0 }
                };
                let expected = over_theta(below);
                assert!((found - expected).abs() < 3e-4, "{theta_i} {edge}: {found} {expected}");
            }
        }
    }
}
