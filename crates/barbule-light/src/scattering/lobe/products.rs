//! What least squares need of lobes: products of shapes, their derivatives and targets, summed over the azimuths in one pass.
//!
//! Eight azimuths at a time, without fused operations, so that the sums are the same bits on every processor.

use std::f64::consts::PI;

use barbule_base::math::simd::{dispatch_large, level};
use fearless_simd::{Simd, f64x8, prelude::*};

use super::{FitKind, Lobe, Parameters};
use crate::scattering::directions;

/// Azimuths of one vector.
const LANES: usize = 8;

/// What does not change between trials: per outgoing azimuth sin and cos of φ_o/2 and (1 − ω_z²)/ω_z². Arrays apart, so that
/// the loops over azimuths are vectorized, and whole vectors long.
#[derive(Debug, Clone)]
pub(super) struct Azimuths {
    pub(super) count: usize,
    pub(super) sin: Vec<f64>,
    pub(super) cos: Vec<f64>,
    pub(super) slope: Vec<f64>,
}

/// Of azimuths that fill up the last vector: no lobe reaches them, and nothing overflows there.
const BEYOND: f64 = 1e300;

impl Azimuths {
    /// [`directions::azimuths`]`(count)` on a cone.
    pub(super) fn new(cos_theta: f64, count: usize) -> Self {
        let (mut sin, mut cos): (Vec<f64>, Vec<f64>) =
            directions::azimuths(count).map(|phi_o| libm::sincos(0.5 * phi_o)).unzip();
        let slope = |phi_o: f64| {
            let cos_z = cos_theta * libm::cos(phi_o);
            (1.0 - cos_z * cos_z) / (cos_z * cos_z)
        };
        let mut slope: Vec<f64> = directions::azimuths(count).map(slope).collect();
        let padded = count.next_multiple_of(LANES);
        sin.resize(padded, 0.0);
        cos.resize(padded, 0.0);
        slope.resize(padded, BEYOND);
        Self { count, sin, cos, slope }
    }

    /// Values, or weights, with zeros up to whole vectors.
    pub(super) fn padded(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut padded: Vec<f64> = values.collect();
        padded.resize(self.sin.len(), 0.0);
        padded
    }

    /// Sums of products of the columns with each other and with targets, [padded](Self::padded) ones.
    pub(super) fn products<const C: usize, const V: usize>(
        &self,
        kind: FitKind,
        columns: &impl Columns<C>,
        targets: [&[f64]; V],
    ) -> Products<C, V> {
        dispatch_large!(level(), simd => sums(simd, self, kind, columns, targets))
    }
}

/// Functions of the azimuth.
pub(super) trait Columns<const C: usize> {
    /// Their values at the azimuths of vector number `at`.
    fn at<S: Simd>(&self, simd: S, azimuths: &Azimuths, kind: FitKind, at: usize) -> [f64x8<S>; C];
}

/// Products of columns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Products<const C: usize, const V: usize> {
    /// With each other; both halves.
    pub(super) gram: [[f64; C]; C],
    /// With the targets.
    pub(super) targets: [[f64; C]; V],
}

#[inline(always)]
fn sums<S: Simd, const C: usize, const V: usize>(
    simd: S,
    azimuths: &Azimuths,
    kind: FitKind,
    columns: &impl Columns<C>,
    targets: [&[f64]; V],
) -> Products<C, V> {
    let zero = f64x8::splat(simd, 0.0);
    let (mut gram, mut with_targets) = ([[zero; C]; C], [[zero; C]; V]);
    for at in 0..azimuths.sin.len() / LANES {
        let values = columns.at(simd, azimuths, kind, at);
        for (i, row) in gram.iter_mut().enumerate() {
            for j in i..C {
                row[j] += values[i] * values[j];
            }
        }
        for (row, target) in with_targets.iter_mut().zip(targets) {
            let target = vector(simd, target, at);
            for (sum, value) in row.iter_mut().zip(values) {
                *sum += value * target;
            }
        }
    }
    let mut products = Products { gram: [[0.0; C]; C], targets: [[0.0; C]; V] };
    for (i, row) in gram.into_iter().enumerate() {
        for (j, value) in row.into_iter().enumerate().skip(i) {
            products.gram[i][j] = sum(value);
            products.gram[j][i] = products.gram[i][j];
        }
    }
    for (to, row) in products.targets.iter_mut().zip(with_targets) {
        for (to, value) in to.iter_mut().zip(row) {
            *to = sum(value);
        }
    }
    products
}

#[inline(always)]
fn vector<S: Simd>(simd: S, values: &[f64], at: usize) -> f64x8<S> {
    f64x8::from_slice(simd, &values[LANES * at..LANES * at + LANES])
}

/// In an order that no processor changes.
#[inline(always)]
fn sum<S: Simd>(values: f64x8<S>) -> f64 {
    let [a, b, c, d, e, f, g, h]: [f64; LANES] = values.into();
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// A shape and its derivatives by ln m and by φ_eff.
pub(super) struct Single(pub(super) Lobe);

/// The sum of a shape and its mirror image, and its derivatives by what both share.
pub(super) struct Even(pub(super) Lobe);

/// Two shapes, each with its derivatives.
pub(super) struct Two(pub(super) [Lobe; 2]);

/// A steady share, its derivatives likewise; weighted, and squared where asked.
pub(super) struct Steady<'a> {
    pub(super) lobe: Lobe,
    pub(super) squared: bool,
    pub(super) weights: &'a [f64],
}

impl Columns<3> for Single {
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, azimuths: &Azimuths, kind: FitKind, at: usize) -> [f64x8<S>; 3] {
        lobe(simd, azimuths, kind, &Parameters::new(self.0), at)
    }
}

impl Columns<3> for Even {
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, azimuths: &Azimuths, kind: FitKind, at: usize) -> [f64x8<S>; 3] {
        let [a, a_by_m, a_by_phi] = lobe(simd, azimuths, kind, &Parameters::new(self.0), at);
        let image = Parameters::new(self.0.mirrored());
        let [b, b_by_m, b_by_phi] = lobe(simd, azimuths, kind, &image, at);
        // The image moves against the azimuth.
        [a + b, a_by_m + b_by_m, a_by_phi - b_by_phi]
    }
}

impl Columns<6> for Two {
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, azimuths: &Azimuths, kind: FitKind, at: usize) -> [f64x8<S>; 6] {
        let [first, second] = self.0;
        let [a, a_by_m, a_by_phi] = lobe(simd, azimuths, kind, &Parameters::new(first), at);
        let [b, b_by_m, b_by_phi] = lobe(simd, azimuths, kind, &Parameters::new(second), at);
        [a, a_by_m, a_by_phi, b, b_by_m, b_by_phi]
    }
}

impl Columns<3> for Steady<'_> {
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, azimuths: &Azimuths, _: FitKind, at: usize) -> [f64x8<S>; 3] {
        let [value, by_m, by_phi] = share(simd, azimuths, &Parameters::new(self.lobe), at);
        let weight = vector(simd, self.weights, at);
        if self.squared {
            let twice = weight * value * f64x8::splat(simd, 2.0);
            [weight * value * value, twice * by_m, twice * by_phi]
        } else {
            [weight * value, weight * by_m, weight * by_phi]
        }
    }
}

/// A lobe's shape with the derivatives by ln m and by φ_eff.
#[inline(always)]
fn lobe<S: Simd>(
    simd: S,
    azimuths: &Azimuths,
    kind: FitKind,
    parameters: &Parameters,
    at: usize,
) -> [f64x8<S>; 3] {
    let splat = |value: f64| f64x8::splat(simd, value);
    let Azimuths { sin, cos, slope, .. } = azimuths;
    let [sin, cos, slope] = [sin, cos, slope].map(|values| vector(simd, values, at));
    let (one, half, four) = (splat(1.0), splat(0.5), splat(4.0));
    let (m2, rest) = (splat(parameters.m2), splat(1.0 - parameters.m2));
    let (sin_eff, cos_eff) = (splat(parameters.sin), splat(parameters.cos));
    let hx = sin * cos_eff + cos * sin_eff;
    let hx_by_phi = half * (cos * cos_eff - sin * sin_eff);
    let q = m2 + rest * (hx * hx);
    let root = (one + m2 * slope).sqrt();
    let root_1 = one + root;
    // Three reciprocals from one division.
    let inverse = one / (q * root * root_1);
    let [inverse_q, inverse_root, inverse_root_1] =
        [inverse * root * root_1, inverse * q * root_1, inverse * q * root];
    let falling = four * m2 * (one - hx * hx) * inverse_q;
    let turning = four * rest * hx * inverse_q * hx_by_phi;
    let value = splat(2.0 / PI * parameters.m2) * inverse_q * inverse_q * inverse_root_1;
    let by_ln_m = one + inverse_root - falling;
    let by_phi = -turning;
    match kind {
        FitKind::Marginal => {
            let cosine = cos * cos_eff + sin * sin_eff;
            let cosine_by_phi = half * (sin * cos_eff - cos * sin_eff);
            let shape = value * cosine;
            [shape, shape * by_ln_m, value * (cosine * by_phi + cosine_by_phi)]
        }
        FitKind::Cone => [value, value * by_ln_m, value * by_phi],
    }
}

/// [`Lobe::steady_share`] with the derivatives by ln m and by φ_eff.
#[inline(always)]
fn share<S: Simd>(simd: S, azimuths: &Azimuths, parameters: &Parameters, at: usize) -> [f64x8<S>; 3] {
    let splat = |value: f64| f64x8::splat(simd, value);
    let [sin, cos] = [&azimuths.sin, &azimuths.cos].map(|values| vector(simd, values, at));
    let (one, half, four) = (splat(1.0), splat(0.5), splat(4.0));
    let (m2, rest) = (splat(parameters.m2), splat(1.0 - parameters.m2));
    let (sin_eff, cos_eff) = (splat(parameters.sin), splat(parameters.cos));
    let hx = sin * cos_eff + cos * sin_eff;
    let hx_by_phi = half * (cos * cos_eff - sin * sin_eff);
    let inverse_q = one / (m2 + rest * (hx * hx));
    let part = m2 * inverse_q;
    let value = part * part;
    let by_ln_m = four - four * m2 * (one - hx * hx) * inverse_q;
    let by_phi = splat(-4.0) * rest * hx * inverse_q * hx_by_phi;
    [value, value * by_ln_m, value * by_phi]
}
