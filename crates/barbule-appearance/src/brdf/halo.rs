//! What leaves a barbule off its cone, as segments in three dimensions show it: a halo along the barbule, and the power that
//! three dimensions reflect over that of 2.5D.

use super::material::{FeatherMaterial, check_axis, check_range};
use crate::{Error, Result};

/// Gaussians that a halo has at most.
pub const MOST_HALOS: usize = 3;

/// Widths that a halo may have, in the σ of exp(−sin²((θ_i + θ_o)/2)/σ²).
pub const HALO_SIGMAS: [f64; 2] = [0.002, 0.6];

/// Factors on what is reflected.
const POWERS: [f32; 2] = [0.1, 4.0];

/// More knots than this no axis of a halo has.
const MOST_KNOTS: usize = 512;

/// Indices of refraction that colours may shift by.
const INDICES: [f64; 2] = [1.05, 10.0];

/// Shares of what is reflected that leave in wide Gaussians beside the narrow one of [`FeatherMaterial::sigma`], and a factor
/// on what is reflected, at knots; between them linear in λ, cosθ_i and cosφ_i, beyond them as at the last.
///
/// Where colours are of layers, all of it follows their bands, which shift to shorter wavelengths as light slants: a knot of
/// another direction is read at the wavelength at which it has the same phase, λ c_k/c with c = √(1 − (1 − (z·ω_i)²)/n²), the
/// cosine within layers of index n.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Halo {
    /// σ of one to three Gaussians, rising.
    pub sigma: Vec<f64>,
    /// Vacuum wavelengths of the knots, nm, rising.
    pub wavelengths_nm: Vec<f64>,
    /// cosθ_i of the knots, rising, in (0, 1\].
    pub cos_theta: Vec<f64>,
    /// cosφ_i of the knots, for either sign of φ_i, rising, in (0, 1\].
    pub cos_phi: Vec<f64>,
    /// n, by which colours shift with the direction of light.
    pub index: f64,
    /// The share of each Gaussian; those of a knot sum to 1 at most, the rest is the narrow one's. Shape `[σ, λ, θ_i, φ_i]`.
    pub shares: Vec<f32>,
    /// What is reflected over the ρ of the material's lobes. Shape `[λ, θ_i, φ_i]`.
    pub power: Vec<f32>,
}

/// A halo under light of one wavelength from one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HaloAt {
    /// Share of each Gaussian.
    pub shares: [f64; MOST_HALOS],
    /// Factor on what is reflected.
    pub power: f64,
}

impl Halo {
    /// Knots.
    #[must_use]
    pub fn knots(&self) -> usize {
        self.wavelengths_nm.len() * self.cos_theta.len() * self.cos_phi.len()
    }

    /// Checks shapes, ranges and finiteness; the message names the array and the index.
    ///
    /// # Errors
    /// Anything that a renderer could not use.
    pub fn check(&self) -> Result<()> {
        let most = [
            ("halo_sigma", self.sigma.len(), MOST_HALOS),
            ("halo_wavelengths_nm", self.wavelengths_nm.len(), MOST_KNOTS),
            ("halo_cos_theta", self.cos_theta.len(), MOST_KNOTS),
            ("halo_cos_phi", self.cos_phi.len(), MOST_KNOTS),
        ];
        if let Some((name, count, most)) = most.into_iter().find(|(_, count, most)| count > most) {
            return Err(Error::input(format!("{name} has {count} values, over the limit of {most}")));
        }
        let [low, high] = HALO_SIGMAS;
        check_axis("halo_sigma", &self.sigma, low, high)?;
        check_axis("halo_wavelengths_nm", &self.wavelengths_nm, 100.0, 20_000.0)?;
        check_range("halo_index", &[self.index], 1, INDICES[0], INDICES[1])?;
        check_axis("halo_cos_theta", &self.cos_theta, 1e-6, 1.0)?;
        check_axis("halo_cos_phi", &self.cos_phi, 1e-6, 1.0)?;
        let knots = self.knots();
        check_range("halo_shares", &self.shares, knots * self.sigma.len(), 0.0, 1.0)?;
        check_range("halo_power", &self.power, knots, POWERS[0], POWERS[1])?;
        let sum = |knot: usize| self.shares.iter().skip(knot).step_by(knots).sum::<f32>();
        match (0..knots).find(|knot| sum(*knot) > 1.0 + 1e-5) {
            None => Ok(()),
            Some(knot) => Err(Error::input(format!(
                "the halo_shares of knot {knot} sum to {}, more than all that is reflected; fit the material again",
                sum(knot)
            ))),
        }
    }

    /// Shares and power at a wavelength (nm) under light from a direction.
    #[must_use]
    pub fn at(&self, wavelength_nm: f64, cos_theta: f64, cos_phi: f64) -> HaloAt {
        let inside = |z: f64| (1.0 - (1.0 - z * z) / (self.index * self.index)).max(0.0).sqrt();
        let own = inside(cos_theta * cos_phi);
        let ((theta, up_theta), (phi, up_phi)) =
            (between(&self.cos_theta, cos_theta), between(&self.cos_phi, cos_phi));
        let mut found = HaloAt { shares: [0.0; MOST_HALOS], power: 0.0 };
        for (row, column, weight) in [
            (theta, phi, (1.0 - up_theta) * (1.0 - up_phi)),
            (theta, phi + 1, (1.0 - up_theta) * up_phi),
            (theta + 1, phi, up_theta * (1.0 - up_phi)),
            (theta + 1, phi + 1, up_theta * up_phi),
        ] {
            // Beyond the last knot there is none, and no weight.
            if weight > 0.0 {
                let there = inside(self.cos_theta[row] * self.cos_phi[column]);
                let (wave, up) = between(&self.wavelengths_nm, wavelength_nm * there / own);
                self.add(&mut found, [wave, row, column], weight * (1.0 - up));
                if up > 0.0 {
                    self.add(&mut found, [wave + 1, row, column], weight * up);
                }
            }
        }
        found
    }

    /// Adds a knot with its weight.
    fn add(&self, found: &mut HaloAt, [wave, theta, phi]: [usize; 3], weight: f64) {
        let at = (wave * self.cos_theta.len() + theta) * self.cos_phi.len() + phi;
        found.power += weight * f64::from(self.power[at]);
        let shares = self.shares.iter().skip(at).step_by(self.knots());
        for (sum, share) in found.shares.iter_mut().zip(shares) {
            *sum += weight * f64::from(*share);
        }
    }
}

/// The place below and the share of the next; beyond the ends those hold.
fn between(places: &[f64], at: f64) -> (usize, f64) {
    let below = places.partition_point(|place| *place <= at).saturating_sub(1);
    match places.get(below + 1) {
        Some(next) => (below, ((at - places[below]) / (next - places[below])).clamp(0.0, 1.0)),
        None => (below, 0.0),
    }
}

impl FeatherMaterial {
    /// The material with the halo's power in its lobes, none reflecting more than all light.
    pub(super) fn with_power(&self, halo: &Halo) -> Self {
        let mut material = self.clone();
        let axes = &self.axes;
        for set in &mut material.sets {
            for node in 0..axes.len() {
                let (phi, rest) = (node % axes.phis(), node / axes.phis());
                let (theta, wave) = (rest % axes.cos_theta().len(), rest / axes.cos_theta().len());
                let cosines = [axes.cos_theta()[theta], axes.cos_phi()[axes.cosine_of(phi)]];
                let power = halo.at(axes.wavelengths_nm()[wave], cosines[0], cosines[1]).power;
                let power = power.min(1.0 / set.reflected(node).max(f64::MIN_POSITIVE)) as f32;
                for lobe in &mut set.mean {
                    lobe.reflected[node] = (lobe.reflected[node] * power).min(1.0);
                }
            }
        }
        material
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::fixtures::{example, halo};

    #[test]
    fn knots_are_mixed_linearly_and_hold_beyond_the_ends() {
        let halo = halo();
        halo.check().unwrap();
        let [nm, theta, phi] = [&halo.wavelengths_nm, &halo.cos_theta, &halo.cos_phi];
        let first = halo.at(nm[0], theta[0], phi[0]);
        assert_eq!(first, halo.at(100.0, 0.0, 0.0));
        assert_eq!(first.power, f64::from(halo.power[0]));
        let last = halo.at(*nm.last().unwrap(), 1.0, 1.0);
        assert_eq!(last, halo.at(900.0, 1.0, 1.0));
        assert_eq!(last.shares[1], f64::from(*halo.shares.last().unwrap()));
        let (a, b) = (halo.at(nm[0], 1.0, 1.0), halo.at(nm[1], 1.0, 1.0));
        let middle = halo.at(0.25 * nm[0] + 0.75 * nm[1], 1.0, 1.0);
        assert!((middle.power - 0.25 * a.power - 0.75 * b.power).abs() < 1e-12);
        assert!((middle.shares[0] - 0.25 * a.shares[0] - 0.75 * b.shares[0]).abs() < 1e-12);
        let single = Halo {
            sigma: vec![0.2],
            wavelengths_nm: vec![500.0],
            cos_theta: vec![1.0],
            cos_phi: vec![1.0],
            index: 1.6,
            shares: vec![0.25],
            power: vec![1.5],
        };
        // Half way to the next direction: each knot at the wavelength of the same phase.
        let inside = |z: f64| (1.0 - (1.0 - z * z) / halo.index.powi(2)).sqrt();
        let [near, far] =
            [0.9, 1.0].map(|cosine| halo.at(470.0 * inside(cosine) / inside(0.95), 1.0, cosine));
        let found = halo.at(470.0, 1.0, 0.95);
        assert!((found.power - 0.5 * (near.power + far.power)).abs() < 1e-12);
        assert!((found.shares[1] - 0.5 * (near.shares[1] + far.shares[1])).abs() < 1e-12);
        assert_eq!(single.at(600.0, 0.3, 0.1), HaloAt { shares: [0.25, 0.0, 0.0], power: 1.5 });
    }

    #[test]
    fn no_power_reflects_more_than_all_light() {
        let mut halo = halo();
        halo.power.fill(3.0);
        let material = example(2).with_power(&halo);
        material.check().unwrap();
        let most = (0..material.axes.len()).map(|node| material.sets[0].reflected(node)).fold(0.0, f64::max);
        assert!((most - 1.0).abs() < 1e-6, "{most}");
    }

    #[test]
    fn what_no_halo_can_be_is_refused_by_name() {
        type Edit = (&'static str, fn(&mut Halo));
        let edits: [Edit; 10] = [
            ("halo_sigma is empty", |h| h.sigma.clear()),
            ("halo_sigma has 4 values, over the limit of 3", |h| h.sigma = vec![0.1, 0.2, 0.3, 0.4]),
            ("halo_sigma[1] = 0.1 does not exceed", |h| h.sigma[1] = 0.1),
            ("halo_sigma[1] = 0.7 is not in 0.002 to 0.6", |h| h.sigma[1] = 0.7),
            ("halo_index[0] = 1 is not in", |h| h.index = 1.0),
            ("halo_shares has", |h| h.shares.truncate(3)),
            ("halo_shares[2] = NaN", |h| h.shares[2] = f32::NAN),
            ("halo_power[0] = -1", |h| h.power[0] = -1.0),
            ("halo_cos_phi[1] =", |h| h.cos_phi[1] = 1.5),
            ("the halo_shares of knot 1 sum to 1.", |h| h.shares[1] = 1.0),
        ];
        for (expected, edit) in edits {
            let mut bad = halo();
            edit(&mut bad);
            let error = bad.check().unwrap_err().to_string();
            assert!(error.contains(expected), "{expected}: {error}");
        }
    }
}
