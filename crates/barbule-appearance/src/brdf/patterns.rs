//! Synthesized patterns beside simulated ones: the check that instances vary as the simulated barbules do.

use super::fitted::{direction, fitted_scale};
use super::material::{FeatherMaterial, LobeSet};
use super::noise::Noise;
use crate::scattering::directions;
use crate::scattering::lobe::Lobe;
use crate::scattering::statistics::{AZIMUTHS, Statistics};

/// Least number of instances drawn per (λ, ω_i).
const DRAWS: usize = 64;

/// Simulated against synthesized patterns at one (λ, ω_i).
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Pattern {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// θ_i, degrees.
    pub theta_deg: f64,
    /// φ_i, degrees.
    pub phi_deg: f64,
    /// Correlation between the two incident polarizations, simulated and synthesized.
    pub correlation: [f64; 2],
    /// Standard deviation over mean, simulated and synthesized.
    pub contrast: [f64; 2],
    /// 4 f (1 − f) with polarization 1's part f of the energy: what the correlation weighs in the variance of
    /// unpolarized light.
    pub balance: f64,
}

/// What a material's instances send to the azimuths of one node of its tables.
pub struct Synthesis {
    /// Mean and steady intensity by incident polarization, each on the azimuths.
    sides: [[Vec<f64>; 2]; 2],
    /// Arguments of the noise.
    positions: Vec<f32>,
}

impl Synthesis {
    /// Prepares node number `node` of the tables, on the azimuths of U.
    #[must_use]
    pub fn new(material: &FeatherMaterial, node: usize) -> Self {
        let phi_o: Vec<f64> = directions::azimuths(AZIMUTHS).collect();
        Self::on(material, node, &phi_o)
    }

    /// The same on other azimuths φ_o, rad.
    #[must_use]
    pub fn on(material: &FeatherMaterial, node: usize, phi_o: &[f64]) -> Self {
        let (_, theta_deg, phi_deg) = direction(&material.axes, node);
        let (theta, phi_i) = (theta_deg.to_radians(), phi_deg.to_radians());
        let sides = [0, 1].map(|polarization| {
            let set = &material.sets[polarization.min(material.sets.len() - 1)];
            let share = |fractions: &[f32]| match fractions.get(node) {
                Some(&first) if polarization == 0 => 2.0 * f64::from(first),
                Some(&first) => 2.0 - 2.0 * f64::from(first),
                None => 1.0,
            };
            let values = |lobe: &LobeSet, share: f64| -> Vec<f64> {
                let shape = Lobe { m: f64::from(lobe.m[node]), phi: f64::from(lobe.phi[node]) };
                let scale =
                    fitted_scale(material.kind, shape, theta, share * f64::from(lobe.reflected[node]));
                phi_o.iter().map(|phi| scale * shape.shape(material.kind, theta, *phi)).collect()
            };
            [
                values(&set.mean, share(&set.fraction_1)),
                values(&set.stationary, share(&set.stationary_fraction_1)),
            ]
        });
        let length = f64::from(material.sets[0].length[node]);
        let cosine = libm::cos(theta);
        let positions = phi_o
            .iter()
            .map(|phi_o| (cosine * (libm::sin(phi_i) + libm::sin(*phi_o)) / length) as f32)
            .collect();
        Self { sides, positions }
    }

    /// The fitted mean intensity, by incident polarization.
    #[must_use]
    pub fn mean(&self) -> [&[f64]; 2] {
        [0, 1].map(|p| &self.sides[p][0][..])
    }

    /// The real and imaginary part of an instance's field, by incident polarization, on the azimuths; the squared
    /// modulus is the intensity (S.25).
    pub fn fields<'a>(&'a self, noise: &'a Noise, instance: u64) -> impl Iterator<Item = [[f64; 2]; 2]> + 'a {
        let draw = noise.draw(instance);
        self.positions.iter().enumerate().map(move |(k, &x)| {
            let [qr, qi] = noise.at(&draw, x).map(f64::from);
            [0, 1].map(|p| {
                let mean = self.sides[p][0][k];
                let steady = self.sides[p][1][k].min(mean);
                let spread = (0.5 * (mean - steady)).sqrt();
                [spread * qr + steady.sqrt(), spread * qi]
            })
        })
    }

    /// The intensity of an instance in unpolarized light.
    #[must_use]
    pub fn intensity(&self, noise: &Noise, instance: u64) -> Vec<f64> {
        self.fields(noise, instance)
            .map(|sides| 0.5 * sides.iter().flatten().map(|v| v * v).sum::<f64>())
            .collect()
    }
}

/// Correlation and contrast, simulated and synthesized, at up to three wavelengths and four azimuths of θ_i near 0.
pub(super) fn compare(statistics: &Statistics, material: &FeatherMaterial) -> Vec<Pattern> {
    let axes = &statistics.axes;
    let noise = Noise::new(&material.noise_power, material.seed);
    let theta = axes.cos_theta().len() - 1;
    let mut waves = vec![0, axes.wavelengths_nm().len() / 2, axes.wavelengths_nm().len() - 1];
    waves.dedup();
    let mut phis: Vec<usize> = [1.0, 0.85, 0.65, 0.35]
        .iter()
        .filter_map(|c| {
            (0..axes.cos_phi().len())
                .min_by(|&a, &b| (axes.cos_phi()[a] - c).abs().total_cmp(&(axes.cos_phi()[b] - c).abs()))
        })
        .collect();
    phis.dedup();
    let mut patterns = Vec::new();
    for &wave in &waves {
        for &phi in &phis {
            let node = axes.index(wave, theta, phi);
            let synthesis = Synthesis::new(material, node);
            let (correlation, contrast) = synthesis.drawn(&noise, statistics.instances);
            let (wavelength_nm, theta_deg, phi_deg) = direction(axes, node);
            let [first, second] = [0, 1].map(|p| statistics.reflected[node * 2 + p].max(0.0));
            let whole = (first + second).max(f64::MIN_POSITIVE);
            patterns.push(Pattern {
                wavelength_nm,
                theta_deg,
                phi_deg,
                correlation: [statistics.pattern_correlation[node], correlation],
                contrast: [statistics.unpolarized_contrast[node], contrast],
                balance: 4.0 * first * second / (whole * whole),
            });
        }
    }
    patterns
}

impl Synthesis {
    /// Correlation of the polarizations' patterns and contrast of the unpolarized intensity over drawn instances, in
    /// groups as large as the campaign, so that both sides of the comparison have the bias of a finite number.
    fn drawn(&self, noise: &Noise, instances: usize) -> (f64, f64) {
        let instances = instances.max(2);
        let groups = DRAWS.div_ceil(instances);
        let (mut correlation, mut contrast) = (0.0, 0.0);
        for group in 0..groups {
            let mut moments = Moments::new();
            for instance in group * instances..(group + 1) * instances {
                for (k, sides) in self.fields(noise, instance as u64).enumerate() {
                    let [first, second] = sides.map(|[re, im]| re * re + im * im);
                    moments.add(k, first, second);
                }
            }
            let (a, b) = moments.result(instances as f64);
            correlation += a / groups as f64;
            contrast += b / groups as f64;
        }
        (correlation, contrast)
    }
}

/// Sums over instances, per azimuth.
struct Moments {
    sums: Vec<[f64; 5]>,
}

impl Moments {
    fn new() -> Self {
        Self { sums: vec![[0.0; 5]; AZIMUTHS] }
    }

    fn add(&mut self, azimuth: usize, first: f64, second: f64) {
        let terms = [first, second, first * first, second * second, first * second];
        for (sum, term) in self.sums[azimuth].iter_mut().zip(terms) {
            *sum += term;
        }
    }

    /// Correlation of the two intensities, each divided by its mean, and contrast of their sum. As the campaign does,
    /// azimuths are weighted by mean intensity and the contrast is a root of a mean square.
    fn result(&self, count: f64) -> (f64, f64) {
        let (mut cross, mut squares, mut sum, mut total) = (0.0, [0.0; 2], 0.0, 0.0);
        for terms in &self.sums {
            let [m1, m2, s1, s2, s12] = terms.map(|v| v / count);
            if m1 <= 0.0 || m2 <= 0.0 {
                continue;
            }
            let mean = m1 + m2;
            cross += mean * (s12 / (m1 * m2) - 1.0);
            squares[0] += mean * (s1 / (m1 * m1) - 1.0);
            squares[1] += mean * (s2 / (m2 * m2) - 1.0);
            sum += mean * ((s1 + s2 + 2.0 * s12) / (mean * mean) - 1.0);
            total += mean;
        }
        let correlation = if squares.iter().all(|s| *s > 1e-9 * total) {
            cross / (squares[0] * squares[1]).sqrt()
        } else {
            1.0
        };
        (correlation, if total > 0.0 { (sum / total).max(0.0).sqrt() } else { 0.0 })
    }
}
