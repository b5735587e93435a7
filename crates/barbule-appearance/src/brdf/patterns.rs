//! Synthesized patterns beside simulated ones: the check that instances vary as the simulated barbules do.

use rayon::prelude::*;

use super::fitted::{Fitted, direction, fitted, place};
use super::material::FeatherMaterial;
use super::noise::{At, Noise};
use crate::scattering::directions;
use crate::scattering::statistics::{AZIMUTHS, Axes, Statistics};
use crate::spectrum::wave_number_per_um;

/// Least number of instances drawn per (λ, ω_i): few of them make most of the wings' contrast.
const DRAWS: usize = 4000;

/// The parts of a lobe in which contrasts are compared: mean intensity over its peak, from and to.
const REGIONS: [[f64; 2]; 3] = [[0.5, 1.01], [0.1, 0.5], [0.02, 0.1]];

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
    /// Standard deviation over mean of unpolarized light, simulated and synthesized.
    pub contrast: [f64; 2],
    /// The same of each polarization's intensity about the mirror direction (mean at least half its peak), on the
    /// shoulders (a tenth) and in the wings (0.02): per azimuth, root mean square weighted by the mean. `None` where a lobe
    /// has no such part. `[polarization][part]`.
    pub regions: [[Option<[f64; 2]>; 3]; 2],
    /// 4 f (1 − f) with polarization 1's part f of the energy: what the correlation weighs in the variance of
    /// unpolarized light.
    pub balance: f64,
}

/// What a material's instances send to the azimuths of one node of its tables.
pub struct Synthesis {
    /// By incident polarization.
    sides: [Fitted; 2],
    /// Arguments of each polarization's noise.
    places: [Vec<At>; 2],
    /// Slopes t of the facets that mirror.
    facets: Vec<f64>,
    /// Correlation of both polarizations' noise.
    gamma: f64,
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
        let [wave, theta, phi] = place(&material.axes, node);
        let (cosine, phi_i) = (material.axes.cos_theta()[theta], material.axes.phi_i(phi));
        let wave_number = wave_number_per_um(material.axes.wavelengths_nm()[wave]);
        let achromatic = material.slope(node).achromatic_inverse_length;
        let places = [0, 1].map(|polarization| {
            let set = &material.sets[polarization.min(material.sets.len() - 1)];
            let inverse_length = material.inverse_length(set, node);
            let at = |phi_o: &f64| {
                let x = cosine * (libm::sin(phi_i) + libm::sin(*phi_o));
                let z = cosine * (libm::cos(phi_i) + libm::cos(*phi_o));
                At {
                    x: x * inverse_length,
                    achromatic_x: x * achromatic,
                    height_phase_per_um: wave_number * z,
                }
            };
            phi_o.iter().map(at).collect()
        });
        Self {
            sides: fitted(material, node, phi_o),
            places,
            facets: phi_o.iter().map(|phi_o| libm::tan(0.5 * (phi_i + phi_o))).collect(),
            gamma: f64::from(material.correlation[node]),
        }
    }

    /// The fitted mean intensity, by incident polarization.
    #[must_use]
    pub fn mean(&self) -> [&[f64]; 2] {
        [0, 1].map(|p| &self.sides[p].mean[..])
    }

    /// The real and imaginary part of an instance's field, by incident polarization, on the azimuths; the squared
    /// modulus is the intensity (S.25).
    pub fn fields<'a>(&'a self, noise: &'a Noise, instance: u64) -> impl Iterator<Item = [[f64; 2]; 2]> + 'a {
        let draw = noise.draw(instance);
        (0..self.places[0].len()).map(move |k| {
            let facet = self.facets[k];
            let [first, second] = [0, 1].map(|p| &self.places[p][k]);
            let both = noise.at_both(&draw, first, self.gamma);
            // Polarizations whose patterns stretch differently read the noise at different places.
            let other = if second == first { both[1] } else { noise.at_both(&draw, second, self.gamma)[1] };
            [(0, both[0]), (1, other)].map(|(p, [qr, qi])| {
                let (mean, steady) = (self.sides[p].mean[k], self.sides[p].steady[k]);
                let spread = (0.5 * (mean - steady)).max(0.0).sqrt();
                let root = draw.factor(self.sides[p].sloped[k], facet).sqrt();
                [root * (spread * qr + steady.sqrt()), root * spread * qi]
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

/// Up to nine nodes to compare: three wavelengths, each at normal incidence, at φ_i = 45° and at θ_i = 45°, φ_i = 20°.
fn chosen(axes: &Axes) -> Vec<usize> {
    let mut waves = vec![0, axes.wavelengths_nm().len() / 2, axes.wavelengths_nm().len() - 1];
    waves.dedup();
    let nearest = |cosines: &[f64], degrees: f64| {
        let apart = |k: usize| (cosines[k] - libm::cos(degrees.to_radians())).abs();
        (0..cosines.len()).min_by(|&a, &b| apart(a).total_cmp(&apart(b))).unwrap_or(0)
    };
    let mut directions: Vec<[usize; 2]> = [[0.0, 0.0], [0.0, 45.0], [45.0, 20.0]]
        .map(|[theta, phi]| [nearest(axes.cos_theta(), theta), nearest(axes.cos_phi(), phi)])
        .to_vec();
    directions.sort_unstable();
    directions.dedup();
    // From normal incidence on.
    directions.reverse();
    waves
        .iter()
        .flat_map(|&wave| directions.iter().map(move |&[theta, phi]| axes.index(wave, theta, phi)))
        .collect()
}

/// Instances of the material beside what the campaign found, at up to nine (λ, ω_i).
pub(super) fn compare(statistics: &Statistics, material: &FeatherMaterial) -> Vec<Pattern> {
    let axes = &statistics.axes;
    let noise = material.noise();
    let pattern = |node: usize| {
        // Of other instances than any other node's, so that means of all are more certain than each.
        let first = (node * 2 * DRAWS) as u64;
        let synthesized =
            Synthesis::new(material, node).drawn(&noise, first, statistics.instances_of_a_place());
        let (wavelength_nm, theta_deg, phi_deg) = direction(axes, node);
        let [first, second] = [0, 1].map(|p| statistics.reflected[node * 2 + p].max(0.0));
        let whole = (first + second).max(f64::MIN_POSITIVE);
        let regions = [0, 1].map(|p| {
            let row = |array: &[f32]| -> Vec<f64> {
                let from = &array[(node * 2 + p) * AZIMUTHS..][..AZIMUTHS];
                from.iter().map(|v| f64::from(*v)).collect()
            };
            let u = row(&statistics.u);
            let simulated: Vec<f64> = row(&statistics.contrast).into_iter().map(|c| c * c).collect();
            REGIONS.map(|region| {
                Some([contrast(&u, &simulated, region)?, contrast(&u, &synthesized.contrast2[p], region)?])
            })
        });
        Pattern {
            wavelength_nm,
            theta_deg,
            phi_deg,
            correlation: [statistics.pattern_correlation[node], synthesized.correlation],
            contrast: [statistics.unpolarized_contrast[node], synthesized.contrast],
            regions,
            balance: 4.0 * first * second / (whole * whole),
        }
    };
    chosen(axes).into_par_iter().map(pattern).collect()
}

/// Root mean square, weighted by the mean, of contrasts where the mean over its peak is in the region.
pub(super) fn contrast(mean: &[f64], contrast2: &[f64], [from, to]: [f64; 2]) -> Option<f64> {
    let peak = mean.iter().fold(0.0, |a: f64, b| a.max(*b));
    let is_there = |value: f64| value > 0.0 && (from * peak..to * peak).contains(&value);
    let pairs = || mean.iter().zip(contrast2).filter(|(mean, _)| is_there(**mean));
    let weight: f64 = pairs().map(|(mean, _)| mean).sum();
    (weight > 0.0).then(|| (pairs().map(|(mean, c2)| mean * c2).sum::<f64>() / weight).max(0.0).sqrt())
}

/// What drawn instances do.
struct Drawn {
    correlation: f64,
    /// Of unpolarized light.
    contrast: f64,
    /// Squared contrast at each azimuth, by polarization.
    contrast2: [Vec<f64>; 2],
}

impl Synthesis {
    /// Draws instances from number `first` on in groups as large as the campaign, so that both sides of the comparison have the bias of a finite
    /// number.
    fn drawn(&self, noise: &Noise, first: u64, instances: usize) -> Drawn {
        let instances = instances.max(2);
        let groups = DRAWS.div_ceil(instances);
        let mut drawn =
            Drawn { correlation: 0.0, contrast: 0.0, contrast2: [vec![0.0; AZIMUTHS], vec![0.0; AZIMUTHS]] };
        for group in 0..groups {
            let mut moments = Moments::new();
            for instance in group * instances..(group + 1) * instances {
                for (k, sides) in self.fields(noise, first + instance as u64).enumerate() {
                    let [first, second] = sides.map(|[re, im]| re * re + im * im);
                    moments.add(k, first, second);
                }
            }
            let (a, b) = moments.result(instances as f64);
            drawn.correlation += a / groups as f64;
            drawn.contrast += b / groups as f64;
            for (k, terms) in moments.sums.iter().enumerate() {
                for (p, row) in drawn.contrast2.iter_mut().enumerate() {
                    let (mean, square) = (terms[p] / instances as f64, terms[p + 2] / instances as f64);
                    if mean > 0.0 {
                        row[k] += (square / (mean * mean) - 1.0) / groups as f64;
                    }
                }
            }
        }
        drawn
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
