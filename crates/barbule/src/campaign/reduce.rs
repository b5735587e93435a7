//! Statistics of one unit's fields.

use num_complex::{Complex, Complex64};
use rayon::prelude::*;

use super::Fields;
use super::covariance::Covariance;
use crate::math::band_limited::{TAPS, weights};
use crate::scattering::directions::AZIMUTH_MARGIN;
use crate::scattering::lobe::{FitKind, fit};
use crate::scattering::statistics::{self, AZIMUTHS, Axes, NOISE_POINTS, UnitStatistics};

/// Forms the statistics of the fields of one (λ, θ_i), φ_i in parallel, instances in order.
pub(super) fn unit(axes: &Axes, fields: &Fields) -> UnitStatistics {
    let grid = NoiseGrid::new(fields.theta_i, fields.refine);
    let covariance = Covariance::<f32>::new();
    let parts: Vec<Direction> = (0..axes.phis())
        .into_par_iter()
        .map(|phi| direction(fields, axes.phi_i(phi), phi, &grid, &covariance))
        .collect();
    let mut unit = UnitStatistics::default();
    for part in parts {
        for polarization in part.polarizations {
            unit.u.extend(polarization.u.iter().map(|&v| v as f32));
            unit.v.extend(polarization.v.iter().map(|&v| v as f32));
            unit.autocovariance.extend(polarization.autocovariance);
            unit.reflected.push(polarization.reflected);
            unit.reflected_std.push(polarization.reflected_std);
            unit.contrast.extend(polarization.contrast);
        }
        unit.pattern_correlation.push(part.pattern_correlation);
        unit.unpolarized_contrast.push(part.unpolarized_contrast);
        unit.glints.extend(part.glints);
    }
    unit
}

/// The fields on the tabulated azimuths, `[φ_i, polarization, e₁ e₂, instance, AZIMUTHS]`.
pub(super) fn kept(fields: &Fields, phis: usize) -> Vec<Complex<f32>> {
    let mut kept = Vec::with_capacity(phis * 4 * fields.values.len() * AZIMUTHS);
    for pair in 0..2 * phis {
        for component in 0..2 {
            for instance in 0..fields.values.len() {
                let parts = components(fields, instance, pair);
                let field = if component == 0 { parts.0 } else { parts.1 };
                kept.extend(tabulated(fields).map(|at| field[at]));
            }
        }
    }
    kept
}

/// U of S.12 of one (φ_i, polarization).
pub(super) fn mean_intensity(fields: &Fields, pair: usize) -> Vec<f64> {
    let mut u = vec![0.0; AZIMUTHS];
    for instance in 0..fields.values.len() {
        let (e1, e2) = components(fields, instance, pair);
        for (n, at) in tabulated(fields).enumerate() {
            u[n] += f64::from(e1[at].norm_sqr() + e2[at].norm_sqr()) / fields.values.len() as f64;
        }
    }
    u
}

struct Direction {
    polarizations: [Polarization; 2],
    glints: Vec<f32>,
    pattern_correlation: f64,
    unpolarized_contrast: f64,
}

struct Polarization {
    u: Vec<f64>,
    v: Vec<f64>,
    autocovariance: Vec<f32>,
    reflected: f64,
    reflected_std: f64,
    contrast: Vec<f32>,
}

fn direction(
    fields: &Fields,
    phi_i: f64,
    phi: usize,
    grid: &NoiseGrid,
    covariance: &Covariance<f32>,
) -> Direction {
    let polarizations =
        [0, 1].map(|polarization| of_polarization(fields, phi_i, 2 * phi + polarization, grid, covariance));
    let (pattern_correlation, unpolarized_contrast) =
        patterns(fields, phi, [&polarizations[0].u, &polarizations[1].u]);
    let glints = glints(fields, phi_i, phi);
    Direction { polarizations, glints, pattern_correlation, unpolarized_contrast }
}

/// Unpolarized intensities about the mirror direction, `[GLINTS, instance]`.
fn glints(fields: &Fields, phi_i: f64, phi: usize) -> Vec<f32> {
    let intensity = |instance: usize, at: usize| -> f32 {
        let of = |polarization: usize| {
            let (e1, e2) = components(fields, instance, 2 * phi + polarization);
            e1[at].norm_sqr() + e2[at].norm_sqr()
        };
        0.5 * (of(0) + of(1))
    };
    statistics::glints(phi_i)
        .into_iter()
        .flat_map(|azimuth| {
            let at = azimuth.map(|azimuth| tabulated_at(fields, azimuth));
            (0..fields.values.len()).map(move |instance| at.map_or(0.0, |at| intensity(instance, at)))
        })
        .collect()
}

/// The two components of one instance, margins included; `pair` counts (φ_i, polarization).
pub(super) fn components(
    fields: &Fields,
    instance: usize,
    pair: usize,
) -> (&[Complex<f32>], &[Complex<f32>]) {
    let start = 2 * pair * fields.points;
    fields.values[instance][start..start + 2 * fields.points].split_at(fields.points)
}

/// Index of a tabulated azimuth in the fine ones.
fn tabulated_at(fields: &Fields, azimuth: usize) -> usize {
    AZIMUTH_MARGIN + fields.refine / 2 + azimuth * fields.refine
}

/// Indices of the tabulated azimuths in the fine ones.
fn tabulated(fields: &Fields) -> impl Iterator<Item = usize> + '_ {
    (0..AZIMUTHS).map(|azimuth| tabulated_at(fields, azimuth))
}

fn of_polarization(
    fields: &Fields,
    phi_i: f64,
    pair: usize,
    grid: &NoiseGrid,
    covariance: &Covariance<f32>,
) -> Polarization {
    let theta_i = fields.theta_i;
    let instances = fields.values.len();
    let count = instances as f64;
    let fine = AZIMUTHS * fields.refine;
    let step = std::f64::consts::PI / fine as f64;
    let mut u = vec![0.0; AZIMUTHS];
    let mut squares = vec![0.0; AZIMUTHS];
    let mut means = vec![[Complex64::ZERO; 2]; AZIMUTHS];
    let mut energy = [0.0; 2];
    let mut fractions = Vec::with_capacity(instances);
    for instance in 0..instances {
        let (e1, e2) = components(fields, instance, pair);
        for (n, at) in tabulated(fields).enumerate() {
            let (a, b) = (widen(e1[at]), widen(e2[at]));
            let intensity = a.norm_sqr() + b.norm_sqr();
            u[n] += intensity;
            squares[n] += intensity * intensity;
            means[n][0] += a;
            means[n][1] += b;
        }
        let inner = AZIMUTH_MARGIN..AZIMUTH_MARGIN + fine;
        let powers = [e1, e2].map(|e| e[inner.clone()].iter().map(|v| f64::from(v.norm_sqr())).sum::<f64>());
        energy[0] += powers[0];
        energy[1] += powers[1];
        fractions.push(theta_i.cos() * step * (powers[0] + powers[1]));
    }
    for value in &mut u {
        *value /= count;
    }
    let contrast = u.iter().zip(&squares).map(|(&u, &square)| contrast(u, square / count)).collect();
    let individuals = count / fields.ways as f64;
    let own = (fields.ways > 1).then(|| intensity_of_both_ways(fields, pair));
    let v = own
        .as_ref()
        .unwrap_or(&u)
        .iter()
        .zip(&means)
        .map(|(&own, mean)| {
            let coherent = (mean[0].norm_sqr() + mean[1].norm_sqr()) / (count * count);
            // M individuals leave (U − V)/M of the incoherent part in |mean|².
            if instances == fields.ways {
                coherent
            } else {
                (individuals * coherent - own) / (individuals - 1.0)
            }
        })
        .collect();
    let reflected = fractions.iter().sum::<f64>() / count;
    let spread = fractions.iter().map(|f| (f - reflected).powi(2)).sum::<f64>();
    let larger = usize::from(energy[1] > energy[0]);
    let lobe = fit(FitKind::Marginal, theta_i, phi_i, &u);
    let envelope: Vec<f32> = grid
        .points
        .iter()
        .map(|p| (lobe.scale * lobe.lobe.shape(FitKind::Marginal, theta_i, p.phi_o)).max(0.0).sqrt() as f32)
        .collect();
    Polarization {
        autocovariance: autocovariance(fields, pair, larger, &envelope, grid, covariance),
        u,
        v,
        reflected,
        reflected_std: (spread / (count - 1.0).max(1.0)).sqrt(),
        contrast,
    }
}

/// Mean over individuals of |𝓔|² of the mean of each one's field and its mirror image's. These two are no different
/// individuals; near the mirror direction at normal incidence they are the same field.
fn intensity_of_both_ways(fields: &Fields, pair: usize) -> Vec<f64> {
    let mut sums = vec![0.0; AZIMUTHS];
    let individuals = fields.values.len() / 2;
    for individual in 0..individuals {
        let [own, image] = [0, 1].map(|way| components(fields, 2 * individual + way, pair));
        for (sum, at) in sums.iter_mut().zip(tabulated(fields)) {
            let mean = [own.0[at] + image.0[at], own.1[at] + image.1[at]].map(|value| 0.5 * widen(value));
            *sum += (mean[0].norm_sqr() + mean[1].norm_sqr()) / individuals as f64;
        }
    }
    sums
}

/// Standard deviation over mean, from the means of an intensity and of its square.
fn contrast(mean: f64, mean_square: f64) -> f32 {
    let variance = mean_square - mean * mean;
    if variance > 0.0 && mean > f64::MIN_POSITIVE { (variance.sqrt() / mean) as f32 } else { 0.0 }
}

pub(super) fn widen(value: Complex<f32>) -> Complex64 {
    Complex64::new(f64::from(value.re), f64::from(value.im))
}

/// S.29 and S.30 for the larger component: mean over instances and over real and imaginary parts.
fn autocovariance(
    fields: &Fields,
    pair: usize,
    component: usize,
    envelope: &[f32],
    grid: &NoiseGrid,
    covariance: &Covariance<f32>,
) -> Vec<f32> {
    let first = grid.points.first().map_or(0, |point| point.index);
    let mut sum = covariance.sum();
    for instance in 0..fields.values.len() {
        let parts = components(fields, instance, pair);
        let field = if component == 0 { parts.0 } else { parts.1 };
        let weighted =
            grid.points.iter().zip(envelope).map(|(point, weight)| point.interpolate(field) * weight);
        sum.add(first, weighted);
    }
    sum.mean()
}

/// The points x_j = (2j + 1 − N)/N of S.44 on the cone, with interpolation from the fine azimuths.
pub(super) struct NoiseGrid {
    pub(super) points: Vec<NoisePoint>,
}

pub(super) struct NoisePoint {
    pub(super) index: usize,
    pub(super) phi_o: f64,
    first: usize,
    weights: [f32; TAPS],
}

impl NoisePoint {
    /// The field here, from the fine azimuths.
    pub(super) fn interpolate(&self, field: &[Complex<f32>]) -> Complex<f32> {
        let mut value = Complex::new(0.0, 0.0);
        for (sample, tap) in field[self.first..self.first + TAPS].iter().zip(self.weights) {
            value += sample * tap;
        }
        value
    }
}

impl NoiseGrid {
    pub(super) fn new(theta_i: f64, refine: usize) -> Self {
        let step = std::f64::consts::PI / (AZIMUTHS * refine) as f64;
        let points = (0..NOISE_POINTS)
            .filter_map(|index| {
                let x = (2.0 * index as f64 + 1.0 - NOISE_POINTS as f64) / NOISE_POINTS as f64;
                let sine = x / theta_i.cos();
                (sine.abs() < 1.0).then(|| {
                    let phi_o = sine.asin();
                    let position = (phi_o + std::f64::consts::FRAC_PI_2) / step - 0.5 + AZIMUTH_MARGIN as f64;
                    let cell = position.floor();
                    NoisePoint {
                        index,
                        phi_o,
                        first: cell as usize - (TAPS / 2 - 1),
                        weights: weights(position - cell),
                    }
                })
            })
            .collect();
        Self { points }
    }
}

/// Correlation of the two polarizations' relative intensities, and contrast of their mean, over instances; azimuths
/// are weighted by mean intensity.
fn patterns(fields: &Fields, phi: usize, u: [&[f64]; 2]) -> (f64, f64) {
    let floor = u.map(|u| 1e-12 * u.iter().fold(0.0, |a: f64, &b| a.max(b)));
    let (mut cross, mut squares, mut unpolarized, mut total) = (0.0, [0.0; 2], 0.0, 0.0);
    for instance in 0..fields.values.len() {
        let pairs = [0, 1].map(|polarization| components(fields, instance, 2 * phi + polarization));
        for (n, at) in tabulated(fields).enumerate() {
            if u[0][n] <= floor[0] || u[1][n] <= floor[1] {
                continue;
            }
            let intensity = pairs.map(|(e1, e2)| f64::from(e1[at].norm_sqr() + e2[at].norm_sqr()));
            let deviation = [intensity[0] / u[0][n] - 1.0, intensity[1] / u[1][n] - 1.0];
            let mean = u[0][n] + u[1][n];
            cross += mean * deviation[0] * deviation[1];
            squares[0] += mean * deviation[0] * deviation[0];
            squares[1] += mean * deviation[1] * deviation[1];
            unpolarized += mean * ((intensity[0] + intensity[1]) / mean - 1.0).powi(2);
            total += mean;
        }
    }
    let spread = (squares[0] * squares[1]).sqrt();
    let correlation = if spread > 0.0 { cross / spread } else { 1.0 };
    (correlation, if total > 0.0 { (unpolarized / total).sqrt() } else { 0.0 })
}
