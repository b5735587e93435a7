//! Synthesized patterns beside simulated ones: the check that instances vary as the simulated barbules do.

use super::fit::{Pattern, direction, fitted_values};
use super::material::Material;
use super::noise::Noise;
use crate::scattering::directions;
use crate::scattering::lobe::{FitKind, Lobe};
use crate::scattering::statistics::{AZIMUTHS, Statistics};

/// Instances drawn per (λ, ω_i).
const DRAWS: usize = 64;

/// Correlation and contrast, simulated and synthesized, at up to three wavelengths and four azimuths of θ_i near 0.
pub(super) fn compare(statistics: &Statistics, kind: FitKind, material: &Material) -> Vec<Pattern> {
    let axes = &statistics.axes;
    let noise = Noise::new(&material.noise_power, material.seed);
    let theta = axes.cos_theta.len() - 1;
    let mut waves = vec![0, axes.wavelengths_nm.len() / 2, axes.wavelengths_nm.len() - 1];
    waves.dedup();
    let mut phis: Vec<usize> = [1.0, 0.85, 0.65, 0.35]
        .iter()
        .filter_map(|c| {
            (0..axes.cos_phi.len())
                .min_by(|&a, &b| (axes.cos_phi[a] - c).abs().total_cmp(&(axes.cos_phi[b] - c).abs()))
        })
        .collect();
    phis.dedup();
    let mut patterns = Vec::new();
    for &wave in &waves {
        for &phi in &phis {
            let node = axes.index(wave, theta, phi);
            let (correlation, contrast) = synthesize(material, kind, &noise, node);
            let (wavelength_nm, theta_deg, phi_deg) = direction(axes, node);
            patterns.push(Pattern {
                wavelength_nm,
                theta_deg,
                phi_deg,
                correlation: [statistics.pattern_correlation[node], correlation],
                contrast: [statistics.contrast[node], contrast],
            });
        }
    }
    patterns
}

/// Mean of the two polarizations' correlation over instances and azimuths (each divided by its
/// mean), and contrast of their mean, of drawn instances.
fn synthesize(material: &Material, kind: FitKind, noise: &Noise, node: usize) -> (f64, f64) {
    let axes = &material.axes;
    let (_, theta_deg, phi_deg) = direction(axes, node);
    let (theta, phi_i) = (theta_deg.to_radians(), phi_deg.to_radians());
    let sides: Vec<(Vec<f64>, Vec<f64>)> = (0..2)
        .map(|polarization| {
            let set = &material.sets[polarization.min(material.sets.len() - 1)];
            let share = |fractions: &[f32]| match fractions.get(node) {
                Some(&first) if polarization == 0 => 2.0 * f64::from(first),
                Some(&first) => 2.0 - 2.0 * f64::from(first),
                None => 1.0,
            };
            let values = |lobe: &super::LobeSet, share: f64| {
                let shape = Lobe { m: f64::from(lobe.m[node]), phi: f64::from(lobe.phi[node]) };
                fitted_values(kind, shape, theta, share * f64::from(lobe.reflected[node]))
            };
            (
                values(&set.mean, share(&set.fraction_1)),
                values(&set.stationary, share(&set.stationary_fraction_1)),
            )
        })
        .collect();
    let length = f64::from(material.sets[0].length[node]);
    let cosine = libm::cos(theta);
    let positions: Vec<f32> = directions::azimuths(AZIMUTHS)
        .map(|phi_o| (cosine * (libm::sin(phi_i) + libm::sin(phi_o)) / length) as f32)
        .collect();
    let mut moments = Moments::new();
    for instance in 0..DRAWS {
        let draw = noise.draw(instance as u64);
        for (k, &x) in positions.iter().enumerate() {
            let [qr, qi] = noise.at(&draw, x).map(f64::from);
            let [first, second] = [0, 1].map(|p| {
                let mean = sides[p].0[k];
                let stationary = sides[p].1[k].min(mean);
                let spread = (0.5 * (mean - stationary)).sqrt();
                (spread * qr + stationary.sqrt()).powi(2) + (spread * qi).powi(2)
            });
            moments.add(k, first, second);
        }
    }
    (moments.correlation(), moments.contrast())
}

/// Sums over instances, per azimuth.
struct Moments {
    sums: Vec<[f64; 7]>,
    count: f64,
}

impl Moments {
    fn new() -> Self {
        Self { sums: vec![[0.0; 7]; AZIMUTHS], count: DRAWS as f64 }
    }

    fn add(&mut self, azimuth: usize, first: f64, second: f64) {
        let both = 0.5 * (first + second);
        let terms = [first, second, first * first, second * second, first * second, both, both * both];
        for (sum, term) in self.sums[azimuth].iter_mut().zip(terms) {
            *sum += term;
        }
    }

    /// Correlation of the intensities, each divided by its mean, over instances and azimuths.
    fn correlation(&self) -> f64 {
        let (mut a, mut b, mut ab) = (0.0, 0.0, 0.0);
        for s in &self.sums {
            let [m1, m2, s1, s2, s12, ..] = s.map(|v| v / self.count);
            if m1 > 0.0 && m2 > 0.0 {
                a += s1 / (m1 * m1) - 1.0;
                b += s2 / (m2 * m2) - 1.0;
                ab += s12 / (m1 * m2) - 1.0;
            }
        }
        if a > 1e-9 && b > 1e-9 { ab / (a * b).sqrt() } else { 1.0 }
    }

    /// Standard deviation over mean of the unpolarized intensity, weighted by the mean.
    fn contrast(&self) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for s in &self.sums {
            let (mean, square) = (s[5] / self.count, s[6] / self.count);
            sum += (square - mean * mean).max(0.0).sqrt();
            weight += mean;
        }
        if weight > 0.0 { sum / weight } else { 0.0 }
    }
}
