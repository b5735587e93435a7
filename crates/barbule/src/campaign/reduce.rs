//! Statistics of one unit's fields.
//!
//! Where instances were lit at several places in turn, each place has a mean of its own, and the mean intensity U is that of all.
//! Variances are of the departures from these means, over the mean of their squares: the contrast of a barbule where it is lit,
//! weighted by the light that comes from there. V is the mean over places. With one place all this is as usual.

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
    let covariance = Covariance::<f32>::new(grid.points.len());
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
    let (pattern_correlation, unpolarized_contrast) = patterns(fields, phi);
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
            let count = fields.values.len();
            let Some(at) = azimuth.map(|azimuth| tabulated_at(fields, azimuth)) else {
                return vec![0.0; count];
            };
            let values = (0..count).map(|instance| intensity(instance, at)).collect();
            about_all(fields, values)
        })
        .collect()
}

/// Of one value of each field: the mean of all plus the departure from that of its own place, to the scale at which both have the
/// same contrast.
fn about_all(fields: &Fields, mut values: Vec<f32>) -> Vec<f32> {
    if fields.places == 1 {
        return values;
    }
    let mut means = Means::new(fields, 1);
    for (field, value) in values.iter().enumerate() {
        means.add(fields.place(field), 0, f64::from(*value));
    }
    let scale = means.all(0) / means.square(0).sqrt().max(f64::MIN_POSITIVE);
    for (field, value) in values.iter_mut().enumerate() {
        let departure = f64::from(*value) - means.of(fields.place(field), 0);
        *value = (means.all(0) + scale * departure) as f32;
    }
    values
}

/// Sums of what is added up for each place, on azimuths.
struct Means {
    azimuths: usize,
    /// How many of each place were added up.
    counts: Vec<f64>,
    /// Fields of which one of them is the mean.
    fields_of_individual: f64,
    /// `[place][azimuth]`
    sums: Vec<f64>,
}

impl Means {
    fn new(fields: &Fields, azimuths: usize) -> Self {
        let mut counts = vec![0.0; fields.places];
        (0..fields.values.len()).for_each(|field| counts[fields.place(field)] += 1.0);
        Self { azimuths, sums: vec![0.0; fields.places * azimuths], counts, fields_of_individual: 1.0 }
    }

    fn add(&mut self, place: usize, azimuth: usize, value: f64) {
        self.sums[place * self.azimuths + azimuth] += value;
    }

    /// The mean of one place's.
    fn of(&self, place: usize, azimuth: usize) -> f64 {
        self.sums[place * self.azimuths + azimuth] / self.counts[place].max(1.0)
    }

    /// The mean over all fields.
    fn all(&self, azimuth: usize) -> f64 {
        let sums = self.sums.iter().skip(azimuth).step_by(self.azimuths);
        sums.sum::<f64>() / self.counts.iter().sum::<f64>()
    }

    /// The mean over all fields of the square of the mean of their place.
    fn square(&self, azimuth: usize) -> f64 {
        let squares = self.counts.iter().enumerate().map(|(place, count)| {
            let mean = self.of(place, azimuth);
            count * mean * mean
        });
        squares.sum::<f64>() / self.counts.iter().sum::<f64>()
    }
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
    let mut intensities = Means::new(fields, AZIMUTHS);
    let mut squares = vec![0.0; AZIMUTHS];
    // `[place][azimuth]`
    let mut amplitudes = vec![[Complex64::ZERO; 2]; fields.places * AZIMUTHS];
    let mut energy = [0.0; 2];
    let mut fractions = Vec::with_capacity(instances);
    for instance in 0..instances {
        let (e1, e2) = components(fields, instance, pair);
        let place = fields.place(instance);
        let amplitudes = &mut amplitudes[place * AZIMUTHS..][..AZIMUTHS];
        for ((n, at), mean) in tabulated(fields).enumerate().zip(amplitudes) {
            let (a, b) = (widen(e1[at]), widen(e2[at]));
            let intensity = a.norm_sqr() + b.norm_sqr();
            intensities.add(place, n, intensity);
            squares[n] += intensity * intensity;
            mean[0] += a;
            mean[1] += b;
        }
        let inner = AZIMUTH_MARGIN..AZIMUTH_MARGIN + fine;
        let powers = [e1, e2].map(|e| e[inner.clone()].iter().map(|v| f64::from(v.norm_sqr())).sum::<f64>());
        energy[0] += powers[0];
        energy[1] += powers[1];
        fractions.push(theta_i.cos() * step * (powers[0] + powers[1]));
    }
    let u: Vec<f64> = (0..AZIMUTHS).map(|n| intensities.all(n)).collect();
    let contrast =
        squares.iter().enumerate().map(|(n, square)| contrast(intensities.square(n), square / count));
    let contrast = contrast.collect();
    let own = (fields.ways > 1).then(|| intensity_of_both_ways(fields, pair));
    let own = own.as_ref().unwrap_or(&intensities);
    let v = (0..AZIMUTHS).map(|n| coherent(own, &amplitudes, n)).collect();
    let reflected = fractions.iter().sum::<f64>() / count;
    let mut of_places = Means::new(fields, 1);
    fractions.iter().enumerate().for_each(|(field, f)| of_places.add(fields.place(field), 0, *f));
    let spread: f64 = fractions
        .iter()
        .enumerate()
        .map(|(field, f)| (f - of_places.of(fields.place(field), 0)).powi(2))
        .sum();
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
        reflected_std: (spread / (count - fields.places as f64).max(1.0)).sqrt(),
        contrast,
    }
}

/// Mean over individuals of |𝓔|² of the mean of each one's field and its mirror image's. These two are no different
/// individuals; near the mirror direction at normal incidence they are the same field.
fn intensity_of_both_ways(fields: &Fields, pair: usize) -> Means {
    let mut means = Means::new(fields, AZIMUTHS);
    means.counts.iter_mut().for_each(|count| *count *= 0.5);
    means.fields_of_individual = 2.0;
    for individual in 0..fields.values.len() / 2 {
        let [own, image] = [0, 1].map(|way| components(fields, 2 * individual + way, pair));
        let place = fields.place(2 * individual);
        for (n, at) in tabulated(fields).enumerate() {
            let mean = [own.0[at] + image.0[at], own.1[at] + image.1[at]].map(|value| 0.5 * widen(value));
            means.add(place, n, mean[0].norm_sqr() + mean[1].norm_sqr());
        }
    }
    means
}

/// V at an azimuth: the mean over places of the intensity of the mean field (`amplitudes`, sums over fields of `[place][azimuth]`)
/// without what M individuals leave of the incoherent part in it, (U − V)/M; `own` are the intensities of individuals.
fn coherent(own: &Means, amplitudes: &[[Complex64; 2]], azimuth: usize) -> f64 {
    let individuals: f64 = own.counts.iter().sum();
    let of_place = |(place, &count): (usize, &f64)| {
        let [a, b] = amplitudes[place * own.azimuths + azimuth];
        let fields = own.fields_of_individual * count;
        let coherent = (a.norm_sqr() + b.norm_sqr()) / (fields * fields).max(1.0);
        let unbiased =
            if count > 1.0 { (count * coherent - own.of(place, azimuth)) / (count - 1.0) } else { coherent };
        count * unbiased
    };
    own.counts.iter().enumerate().map(of_place).sum::<f64>() / individuals
}

/// Standard deviation over mean, from the squared mean of an intensity and the mean of its square.
fn contrast(squared_mean: f64, mean_square: f64) -> f32 {
    let variance = mean_square - squared_mean;
    let is_lit = squared_mean > f64::MIN_POSITIVE;
    if variance > 0.0 && is_lit { (variance / squared_mean).sqrt() as f32 } else { 0.0 }
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
    let mut sum = covariance.sum();
    for instance in 0..fields.values.len() {
        let parts = components(fields, instance, pair);
        let field = if component == 0 { parts.0 } else { parts.1 };
        let weighted =
            grid.points.iter().zip(envelope).map(|(point, weight)| point.interpolate(field) * weight);
        sum.add(weighted);
    }
    sum.mean()
}

/// The points x_j = (2j + 1 − N)/N of S.44 on the cone, with interpolation from the fine azimuths.
pub(super) struct NoiseGrid {
    pub(super) points: Vec<NoisePoint>,
}

pub(super) struct NoisePoint {
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
fn patterns(fields: &Fields, phi: usize) -> (f64, f64) {
    let intensities = |instance: usize, at: usize| {
        [0, 1].map(|polarization| {
            let (e1, e2) = components(fields, instance, 2 * phi + polarization);
            f64::from(e1[at].norm_sqr() + e2[at].norm_sqr())
        })
    };
    let mut means = [0, 1, 2].map(|_| Means::new(fields, AZIMUTHS));
    for instance in 0..fields.values.len() {
        let place = fields.place(instance);
        for (n, at) in tabulated(fields).enumerate() {
            let [first, second] = intensities(instance, at);
            for (mean, value) in means.iter_mut().zip([first, second, first + second]) {
                mean.add(place, n, value);
            }
        }
    }
    let all = |p: usize| -> Vec<f64> { (0..AZIMUTHS).map(|n| means[p].all(n)).collect() };
    let scales = [0, 1, 2].map(|p| (0..AZIMUTHS).map(|n| means[p].square(n).sqrt()).collect::<Vec<f64>>());
    let u = [all(0), all(1), all(2)];
    let floor = [0, 1].map(|p| 1e-12 * u[p].iter().fold(0.0, |a: f64, &b| a.max(b)));
    let (mut cross, mut squares, mut unpolarized, mut total) = (0.0, [0.0; 2], 0.0, 0.0);
    for instance in 0..fields.values.len() {
        let place = fields.place(instance);
        for (n, at) in tabulated(fields).enumerate() {
            if u[0][n] <= floor[0] || u[1][n] <= floor[1] {
                continue;
            }
            let [first, second] = intensities(instance, at);
            let departure = |p: usize, value: f64| (value - means[p].of(place, n)) / scales[p][n];
            let deviation = [departure(0, first), departure(1, second)];
            let mean = u[2][n];
            cross += mean * deviation[0] * deviation[1];
            squares[0] += mean * deviation[0] * deviation[0];
            squares[1] += mean * deviation[1] * deviation[1];
            unpolarized += mean * departure(2, first + second).powi(2);
            total += mean;
        }
    }
    let spread = (squares[0] * squares[1]).sqrt();
    let correlation = if spread > 0.0 { cross / spread } else { 1.0 };
    (correlation, if total > 0.0 { (unpolarized / total).sqrt() } else { 0.0 })
}
