//! What the halo of a material makes of the 2.5D simulation, against segments.

use super::Comparison;
use super::numbers::{BEYOND, Found};
use crate::brdf::HaloAt;

/// One wavelength and direction with the halo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WithHalo {
    /// Φ_r/Φ_i: 2.5D times the halo's power.
    pub reflected: f64,
    /// The part of the light beyond the window's lobe, with a narrow part as wide as the window, since segments are straight.
    pub beyond: f64,
}

impl Comparison {
    /// The halo of the material under the light of some numbers.
    fn halo_at(&self, found: &Found) -> Option<(HaloAt, &[f64])> {
        let halo = self.plan.material.as_ref()?.halo.as_ref()?;
        let [theta, phi] = found.direction_deg.map(f64::to_radians);
        Some((halo.at(found.wavelength_nm, theta.cos(), phi.cos()), &halo.sigma))
    }

    /// What a material with a halo says of some numbers; `None` without.
    #[must_use]
    pub fn with_halo(&self, found: &Found) -> Option<WithHalo> {
        let (at, sigmas) = self.halo_at(found)?;
        let theta_i = found.direction_deg[0].to_radians();
        // σ of the window is that of t; ω_y has √2 cosθ_i of it.
        let lobe = BEYOND * found.sigma.window * std::f64::consts::SQRT_2 * theta_i.cos();
        let narrow = 1.0 - at.shares.iter().sum::<f64>();
        let mut beyond = narrow * libm::erfc(BEYOND * std::f64::consts::FRAC_1_SQRT_2);
        for (share, sigma) in at.shares.iter().zip(sigmas) {
            let (mut outside, mut whole) = (0.0, 0.0);
            for [u, ..] in &found.over_y {
                let theta_o = (u - theta_i.sin()).clamp(-1.0, 1.0).asin();
                let value = (-((0.5 * (theta_i + theta_o)).sin() / sigma).powi(2)).exp();
                whole += value;
                outside += if u.abs() > lobe { value } else { 0.0 };
            }
            beyond += share * outside / whole.max(f64::MIN_POSITIVE);
        }
        Some(WithHalo { reflected: found.flat.reflected * at.power, beyond })
    }

    /// ΔE00 of the colours of all that is reflected: 2.5D with the halo's power against segments.
    #[must_use]
    pub fn delta_e_with_halo(&self, direction: usize) -> Option<f64> {
        let found = &self.found[direction];
        let with: Option<Vec<f64>> = found.iter().map(|f| Some(self.with_halo(f)?.reflected)).collect();
        Some(self.difference(&with?, &found.iter().map(|f| f.segments.reflected).collect::<Vec<_>>()))
    }

    /// A line of the table for people, where there is a halo: means over the wavelengths of a direction.
    pub(super) fn halo_line(&self, direction: usize) -> Option<String> {
        let found = &self.found[direction];
        let with: Vec<WithHalo> = found.iter().map(|f| self.with_halo(f)).collect::<Option<_>>()?;
        let segments: f64 = found.iter().map(|f| f.segments.reflected).sum();
        let reflected: f64 = with.iter().map(|with| with.reflected).sum();
        let beyond = with.iter().map(|with| with.beyond).sum::<f64>() / with.len() as f64;
        Some(format!(
            "{:>12}  {:>8.4}  {:>8}  {:>+5.1} %  {:>8}  {:>8}  {:>8}  {:>6.1} %  {:>6.1}\n",
            "with halo",
            reflected / with.len() as f64,
            "",
            1e2 * (reflected / segments - 1.0),
            "",
            "",
            "",
            1e2 * beyond,
            self.delta_e_with_halo(direction)?
        ))
    }
}
