//! The analytic lobe that stands for a mean scattering distribution, and its least-squares fit.
//!
//! With ω_eff = ω(θ_i, φ_eff) and ω_o = ω(−θ_i, φ_o) on the specular cone, the sum ω_eff + ω_o has no y component, so
//! the half vector is h = (sin((φ_o + φ_eff)/2), 0, cos((φ_o + φ_eff)/2)) whatever θ_i is: the lobe peaks near
//! φ_o = −φ_eff. What the BRDF of the barbule radiates per dφ_o is then, up to a scale and for a narrow longitudinal
//! spread,
//!
//! ```text
//! D₁(h_x) G₁(ω_o) cos((φ_o − φ_eff)/2),    D₁ = m²/(π (m² + (1−m²) h_x²)²),    G₁ = 2/(1 + √(1 + m² (1−ω_z²)/ω_z²))
//! ```
//!
//! where the cosine is dθ_o/dh_y · ω_eff·h. Source: Yu et al., *Appearance Modeling of Iridescent Feathers with Diverse
//! Nanostructures*, section 5.2 and its supplement, section 3.

use std::f64::consts::PI;

mod pair;
mod products;
mod search;
mod steady;

pub use pair::{Pair, PairFit};
pub use steady::{Power, SteadyFit};

use products::{Azimuths, Single};
use search::{Least, Limits, Normal, least, of_one};

/// The smallest roughness of a lobe.
pub const SMALLEST_M: f64 = 0.001;

/// cos φ_eff never falls below this, so that ω_eff stays above the horizon.
const SMALLEST_COS_PHI: f64 = 0.02;

/// A fit with a larger relative residual is tried again from another start.
const SECOND_START: f64 = 0.2;

/// Between these values of cosθ_i cosφ_i the fitted φ_eff passes over into φ_i.
const BLEND: (f64, f64) = (0.05, 0.1);

/// When searches end.
const LIMITS: Limits = Limits { error: 1e-9, step: 1e-7, evaluations: 45 };

/// Shape of a lobe at one wavelength and incident direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobe {
    /// Roughness m_eff in \[0.001, 1\].
    pub m: f64,
    /// Effective incident azimuth φ_eff, rad; the lobe peaks near φ_o = −φ_eff.
    pub phi: f64,
}

/// What the shape is on the specular cone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FitKind {
    /// What the lobe radiates per dφ_o, integrated over θ_o.
    #[default]
    Marginal,
    /// The lobe's value on the cone itself (times cosine of the outgoing direction), the published reading.
    Cone,
}

/// A fitted lobe: U' = `scale` · shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// The lobe.
    pub lobe: Lobe,
    /// Factor on the shape, ≥ 0.
    pub scale: f64,
    /// ‖U' − U‖ / ‖U‖ over the azimuths; 0 for zero input.
    pub residual: f64,
    /// Whether the least squares settled.
    pub converged: bool,
}

impl Lobe {
    /// D₁(h_x) G₁(ω_o) times, for [`FitKind::Marginal`], cos((φ_o − φ_eff)/2), on the specular cone of `theta_i`; rad.
    #[must_use]
    pub fn shape(&self, kind: FitKind, theta_i: f64, phi_o: f64) -> f64 {
        let (sin_o, cos_o) = libm::sincos(0.5 * phi_o);
        let cos_z = libm::cos(theta_i) * libm::cos(phi_o);
        let slope = (1.0 - cos_z * cos_z) / (cos_z * cos_z);
        Parameters::new(*self).shape(kind, sin_o, cos_o, slope)
    }

    /// What part of a mean is steady over what it is in the lobe's middle: π m² D₁ of φ_o, 1 everywhere for m = 1.
    #[must_use]
    pub fn steady_share(&self, phi_o: f64) -> f64 {
        let hx = libm::sin(0.5 * (phi_o + self.phi));
        let m2 = self.m * self.m;
        let part = m2 / (m2 + (1.0 - m2) * hx * hx);
        part * part
    }

    /// The lobe of the mirror image.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { phi: -self.phi, ..self }
    }
}

/// m² and the sine and cosine of φ_eff/2.
#[derive(Debug, Clone, Copy)]
struct Parameters {
    m2: f64,
    sin: f64,
    cos: f64,
}

impl Parameters {
    fn new(lobe: Lobe) -> Self {
        let (sin, cos) = libm::sincos(0.5 * lobe.phi);
        Self { m2: lobe.m * lobe.m, sin, cos }
    }

    /// The shape at one azimuth.
    #[inline(always)]
    fn shape(&self, kind: FitKind, sin: f64, cos: f64, slope: f64) -> f64 {
        let hx = sin * self.cos + cos * self.sin;
        let q = self.m2 + (1.0 - self.m2) * hx * hx;
        let root = (1.0 + self.m2 * slope).sqrt();
        let value = 2.0 / PI * self.m2 / (q * q * (1.0 + root));
        match kind {
            FitKind::Marginal => value * (cos * self.cos + sin * self.sin),
            FitKind::Cone => value,
        }
    }
}

/// Sum of products in four lanes, which the compiler vectorizes.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (fours_a, rest_a) = a.as_chunks::<4>();
    let (fours_b, rest_b) = b.as_chunks::<4>();
    for (x, y) in fours_a.iter().zip(fours_b) {
        for lane in 0..4 {
            lanes[lane] += x[lane] * y[lane];
        }
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(x, y)| x * y).sum();
    (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]) + rest
}

/// Fits lobes at one θ_i: keeps what all fits at that angle share.
#[derive(Debug, Clone)]
pub struct Fitter {
    kind: FitKind,
    cos_theta: f64,
    azimuths: Azimuths,
    step: f64,
}

impl Fitter {
    /// For values on [`azimuths`](crate::scattering::directions::azimuths)`(count)` at this θ_i, rad.
    #[must_use]
    pub fn new(kind: FitKind, theta_i: f64, count: usize) -> Self {
        let cos_theta = libm::cos(theta_i);
        let azimuths = Azimuths::new(cos_theta, count);
        Self { kind, cos_theta, azimuths, step: PI / count.max(1) as f64 }
    }

    /// How far azimuths of lobes are free with light from φ_i, rad: 0 to 1. Towards grazing incidence they pass over into
    /// φ_i, since the horizon cuts off the light that would tell them.
    #[must_use]
    pub fn freedom(&self, phi_i: f64) -> f64 {
        let grazing = self.cos_theta * libm::cos(phi_i);
        // Cosines of angles of cosines: what is meant to be the upper bound may lie a few 1e-17 below it.
        ((grazing + 1e-12 - BLEND.0) / (BLEND.1 - BLEND.0)).clamp(0.0, 1.0)
    }

    /// The lobe's shape on the azimuths.
    #[must_use]
    pub fn values(&self, lobe: Lobe) -> Vec<f64> {
        let mut shape = vec![0.0; self.azimuths.count];
        self.evaluate(&Parameters::new(lobe), &mut shape);
        shape
    }

    /// [`Lobe::steady_share`] on the azimuths.
    #[must_use]
    pub fn steady_shares(&self, lobe: Lobe) -> Vec<f64> {
        let mut shape = vec![1.0; self.azimuths.count];
        steady::narrow(&Parameters::new(lobe), &self.azimuths, &mut shape);
        shape
    }

    /// The best lobe for `values` (U or V, the latter may be slightly negative) with light from φ_i, rad.
    ///
    /// Several starts (φ_i, centroid and highest peaks, each with three widths) guard against distributions with
    /// several modes. Below cosθ_i cosφ_i = 0.1 φ_eff passes linearly over into φ_i, reached at 0.05, and m is fitted
    /// again. Input without anything positive or with a value that is not finite gives scale 0.
    #[must_use]
    pub fn fit(&self, phi_i: f64, values: &[f64]) -> Fit {
        let norm = values.iter().map(|v| v * v).sum::<f64>().sqrt();
        let usable = values.len() == self.azimuths.count && norm.is_finite();
        if !usable || norm == 0.0 {
            let residual = if usable { 0.0 } else { f64::NAN };
            let lobe = Lobe { m: 1.0, phi: bounded_phi(phi_i) };
            return Fit { lobe, scale: 0.0, residual, converged: usable };
        }
        let weight = self.freedom(phi_i);
        let starts = self.starts(phi_i, values);
        let free = if weight > 0.0 { self.best(&starts, values, norm, true) } else { None };
        if let (Some(fit), true) = (free, weight >= 1.0) {
            return fit;
        }
        // Towards grazing the azimuth is no longer free: only m is fitted.
        let towards = free.map_or(phi_i, |fit| phi_i + weight * (fit.lobe.phi - phi_i));
        let phi = bounded_phi(if weight >= 1.0 { phi_i } else { towards });
        self.fit_m(phi, values)
    }

    /// The best lobe of a given φ_eff, rad: only m and the scale are free.
    #[must_use]
    pub fn fit_m(&self, phi: f64, values: &[f64]) -> Fit {
        let norm = values.iter().map(|v| v * v).sum::<f64>().sqrt();
        let phi = bounded_phi(phi);
        if norm == 0.0 || !norm.is_finite() || values.len() != self.azimuths.count {
            return Fit { lobe: Lobe { m: 1.0, phi }, scale: 0.0, residual: norm, converged: norm == 0.0 };
        }
        let starts = [0.004, 0.03, 0.1, 0.4].map(|m| Lobe { m, phi });
        let fixed = Fit { lobe: starts[2], scale: 0.0, residual: 1.0, converged: false };
        self.best(&starts, values, norm, false).unwrap_or(fixed)
    }

    /// Refines the best of the starts, and where it fits badly the best one elsewhere too.
    fn best(&self, starts: &[Lobe], values: &[f64], norm: f64, free_phi: bool) -> Option<Fit> {
        let problem = Problem::new(self, values, norm * norm, free_phi);
        let mut ranked: Vec<(f64, Lobe)> =
            starts.iter().map(|&lobe| (problem.at(unbounded(lobe, free_phi)).0.error, lobe)).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let refine = |start: Lobe| {
            let found = least(unbounded(start, free_phi), LIMITS, |place| problem.at(place));
            let Least { parameters: [t, u], error, with: [scale], converged } = found;
            Fit { lobe: bounded(t, u), scale, residual: error.sqrt(), converged }
        };
        let first_start = ranked.first()?.1;
        let first = refine(first_start);
        if first.converged && first.residual < SECOND_START {
            return Some(first);
        }
        let elsewhere =
            |l: &Lobe| !free_phi || (l.phi - first_start.phi).abs() > 0.3 * first_start.m.max(l.m);
        let second = ranked[1..].iter().map(|r| r.1).find(elsewhere).map(refine);
        Some(second.filter(|fit| fit.residual < first.residual).unwrap_or(first))
    }

    /// Fills `shape`.
    fn evaluate(&self, parameters: &Parameters, shape: &mut [f64]) {
        let Azimuths { sin, cos, slope, .. } = &self.azimuths;
        // One loop per kind, so that the choice is not made per azimuth.
        match self.kind {
            FitKind::Marginal => {
                for (((out, s), c), slope) in shape.iter_mut().zip(sin).zip(cos).zip(slope) {
                    *out = parameters.shape(FitKind::Marginal, *s, *c, *slope);
                }
            }
            FitKind::Cone => {
                for (((out, s), c), slope) in shape.iter_mut().zip(sin).zip(cos).zip(slope) {
                    *out = parameters.shape(FitKind::Cone, *s, *c, *slope);
                }
            }
        }
    }

    /// φ_i, the centroid and the two highest separate peaks, each with the widths that the area under it suggests.
    fn starts(&self, phi_i: f64, values: &[f64]) -> Vec<Lobe> {
        let count = values.len();
        let smooth: Vec<f64> = (0..count)
            .map(|k| {
                let window = &values[k.saturating_sub(3)..(k + 4).min(count)];
                window.iter().sum::<f64>() / window.len() as f64
            })
            .collect();
        let azimuth = |k: usize| (k as f64 + 0.5) * self.step - 0.5 * PI;
        let top = |far_from: Option<usize>| {
            let near = count / 30;
            (0..count)
                .filter(|&k| far_from.is_none_or(|other| k.abs_diff(other) > near))
                .filter(|&k| {
                    (k == 0 || smooth[k] >= smooth[k - 1]) && (k + 1 == count || smooth[k] > smooth[k + 1])
                })
                .max_by(|&a, &b| smooth[a].total_cmp(&smooth[b]))
        };
        let peak = top(None);
        let area: f64 = values.iter().filter(|v| **v > 0.0).sum::<f64>() * self.step;
        let moment: f64 =
            values.iter().enumerate().filter(|(_, v)| **v > 0.0).map(|(k, v)| azimuth(k) * v).sum::<f64>();
        let highest = peak.map_or(0.0, |k| smooth[k]).max(f64::MIN_POSITIVE);
        // The area under D₁ against φ_o is π m times its peak.
        let width = (area / highest / PI).clamp(0.004, 0.6);
        let centroid = if area > 0.0 { -moment * self.step / area } else { phi_i };
        let mut phis = vec![phi_i, centroid];
        phis.extend(peak.map(|k| -azimuth(k)));
        phis.extend(peak.and_then(|k| top(Some(k))).map(|k| -azimuth(k)));
        phis.iter()
            .flat_map(|&phi| {
                [0.4, 1.0, 2.2].map(|f| Lobe { m: (f * width).clamp(0.003, 0.95), phi: bounded_phi(phi) })
            })
            .collect()
    }
}

/// Fits a lobe to `values` on [`azimuths`](crate::scattering::directions::azimuths)`(values.len())`; see [`Fitter::fit`]. Angles in rad.
#[must_use]
pub fn fit(kind: FitKind, theta_i: f64, phi_i: f64, values: &[f64]) -> Fit {
    Fitter::new(kind, theta_i, values.len()).fit(phi_i, values)
}

fn largest_phi() -> f64 {
    libm::acos(SMALLEST_COS_PHI)
}

fn bounded_phi(phi: f64) -> f64 {
    phi.clamp(-largest_phi(), largest_phi())
}

/// A lobe as two unbounded parameters (t, u): ln m between its bounds by a sine of t, φ_eff = φ_max sin u.
fn unbounded(lobe: Lobe, free_phi: bool) -> [f64; 2] {
    let t =
        libm::asin((2.0 * libm::log(lobe.m) / libm::log(SMALLEST_M)).mul_add(-1.0, 1.0).clamp(-0.999, 0.999));
    let u = libm::asin((lobe.phi / largest_phi()).clamp(-1.0, 1.0));
    // A start on the bound would have no slope; a fixed azimuth keeps its exact value.
    [t, if free_phi { u.clamp(-1.53, 1.53) } else { u }]
}

/// The lobe of two unbounded parameters.
fn bounded(t: f64, u: f64) -> Lobe {
    let ln_m = 0.5 * libm::log(SMALLEST_M) * (1.0 - libm::sin(t));
    Lobe { m: libm::exp(ln_m).clamp(SMALLEST_M, 1.0), phi: bounded_phi(largest_phi() * libm::sin(u)) }
}

/// d ln m/dt and dφ_eff/du; the latter 0 for a fixed azimuth.
fn chain(t: f64, u: f64, free_phi: bool) -> [f64; 2] {
    [-0.5 * libm::log(SMALLEST_M) * libm::cos(t), if free_phi { largest_phi() * libm::cos(u) } else { 0.0 }]
}

/// Least squares over the two unbounded parameters of a lobe, its scale eliminated.
struct Problem<'a> {
    fitter: &'a Fitter,
    values: Vec<f64>,
    total: f64,
    free_phi: bool,
}

impl<'a> Problem<'a> {
    /// `total` is the sum of the values' squares.
    fn new(fitter: &'a Fitter, values: &[f64], total: f64, free_phi: bool) -> Self {
        Self { fitter, values: fitter.azimuths.padded(values.iter().copied()), total, free_phi }
    }

    /// The equations at parameters, and the scale.
    fn at(&self, [t, u]: [f64; 2]) -> (Normal<2>, [f64; 1]) {
        let Fitter { azimuths, kind, .. } = self.fitter;
        let products = azimuths.products(*kind, &Single(bounded(t, u)), [&self.values[..]]);
        of_one(&products, chain(t, u, self.free_phi), self.total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::directions;
    use crate::scattering::lobe::search::tests::gradients_match;

    fn values(kind: FitKind, theta: f64, lobe: Lobe, count: usize) -> Vec<f64> {
        directions::azimuths(count).map(|phi| 0.7 * lobe.shape(kind, theta, phi)).collect()
    }

    #[test]
    fn a_lobe_is_found_again_from_its_own_values() {
        for kind in [FitKind::Marginal, FitKind::Cone] {
            for (m, phi) in [(0.02, 0.3), (0.1, -0.6), (0.5, 0.1), (0.9, 0.0), (0.005, 1.0)] {
                let lobe = Lobe { m, phi };
                let fit = fit(kind, 0.5, 0.2, &values(kind, 0.5, lobe, 400));
                assert!(fit.converged, "{lobe:?} {fit:?}");
                assert!((fit.lobe.m / m - 1.0).abs() < 1e-4, "{lobe:?} {fit:?}");
                assert!((fit.lobe.phi - phi).abs() < 1e-4, "{lobe:?} {fit:?}");
                assert!((fit.scale - 0.7).abs() < 1e-3 && fit.residual < 1e-4, "{lobe:?} {fit:?}");
            }
        }
    }

    #[test]
    fn the_larger_of_two_modes_wins_and_noise_does_no_harm() {
        let one = values(FitKind::Marginal, 0.0, Lobe { m: 0.05, phi: 0.7 }, 400);
        let two = values(FitKind::Marginal, 0.0, Lobe { m: 0.05, phi: -0.4 }, 400);
        let mut stream = barbule_base::math::rng::Stream::new(3, &[]);
        let sum: Vec<f64> = one.iter().zip(&two).map(|(a, b)| a + 0.4 * b + 0.02 * stream.normal()).collect();
        let fit = fit(FitKind::Marginal, 0.0, 0.1, &sum);
        assert!((fit.lobe.phi - 0.7).abs() < 0.05, "{fit:?}");
        assert!(fit.residual < 0.5);
    }

    #[test]
    fn input_without_light_does_not_fail() {
        for values in
            [vec![0.0; 400], vec![-1.0; 400], vec![f64::NAN; 400], vec![], vec![1.0], vec![1e-300; 7]]
        {
            let fit = fit(FitKind::Marginal, 0.3, 0.4, &values);
            assert!((SMALLEST_M..=1.0).contains(&fit.lobe.m), "{fit:?}");
            assert!(fit.lobe.phi.is_finite() && fit.scale >= 0.0, "{fit:?}");
        }
    }

    #[test]
    fn towards_grazing_the_azimuth_becomes_the_incident_one() {
        let theta = 0.3_f64;
        for (cosine, weight) in [(0.04, 0.0), (0.05, 0.0), (0.075, 0.5), (0.1, 1.0)] {
            let phi_i = (cosine / theta.cos()).acos();
            let lobe = Lobe { m: 0.1, phi: 0.9 };
            let fit = fit(FitKind::Marginal, theta, phi_i, &values(FitKind::Marginal, theta, lobe, 400));
            let expected = phi_i + weight * (lobe.phi - phi_i);
            assert!((fit.lobe.phi - expected).abs() < 1e-4, "{cosine} {fit:?} {expected}");
        }
    }

    #[test]
    fn gradients_match_differences() {
        let fitter = Fitter::new(FitKind::Marginal, 0.4, 50);
        let values = values(FitKind::Marginal, 0.4, Lobe { m: 0.2, phi: 0.3 }, 50);
        let problem = Problem::new(&fitter, &values, dot(&values, &values), true);
        let start = Lobe { m: 0.15, phi: 0.2 };
        gradients_match(unbounded(start, true), 1e-7, |place| problem.at(place));
    }

    /// The kernel's products against plain sums of shapes and of their differences, where azimuths do not fill the last vector.
    #[test]
    fn products_are_those_of_shapes_and_differences() {
        let step = 1e-5;
        for kind in [FitKind::Marginal, FitKind::Cone] {
            let lobe = Lobe { m: 0.3, phi: 0.4 };
            let fitter = Fitter::new(kind, 0.6, 43);
            let target: Vec<f64> = (0..43).map(|k| libm::sin(0.3 * f64::from(k))).collect();
            let padded = fitter.azimuths.padded(target.iter().copied());
            let found = fitter.azimuths.products(kind, &Single(lobe), [&padded[..]]);
            let values =
                |m: f64, phi: f64| fitter.values(Lobe { m: lobe.m * libm::exp(m), phi: lobe.phi + phi });
            let difference = |m: f64, phi: f64| -> Vec<f64> {
                values(m, phi).iter().zip(values(-m, -phi)).map(|(a, b)| (a - b) / (2.0 * step)).collect()
            };
            let columns = [values(0.0, 0.0), difference(step, 0.0), difference(0.0, step)];
            for (i, column) in columns.iter().enumerate() {
                let plain = dot(column, &target);
                assert!((found.targets[0][i] - plain).abs() < 1e-7 * (1.0 + plain.abs()), "{kind:?} {i}");
                for (j, other) in columns.iter().enumerate() {
                    let plain = dot(column, other);
                    assert!(
                        (found.gram[i][j] - plain).abs() < 1e-7 * (1.0 + plain.abs()),
                        "{kind:?} {i} {j}"
                    );
                }
            }
        }
    }
}
