//! What a material's BRDF radiates per outgoing azimuth: the far field's intensity, integrated over θ_o.

use glam::DVec3;
use rayon::prelude::*;

use super::evaluate::FeatherBrdf;
use super::exact::ExactBrdf;
use super::longitudinal::END;
use super::noise::{Draw, knots};
use crate::math::quadrature::gauss_legendre;
use crate::progress::Progress;
use crate::{Error, Result};

/// A piece is cut in half until that changes it by less than this part of the whole: of an azimuth that is asked for, and of one of the
/// many of a reflected fraction, whose own steps leave more.
const TOLERANCE: f64 = 1e-9;
const ROUGH: f64 = 1e-5;

/// Steps of v in the reflected fraction of an instance, and how far beyond the mirror direction they go: what leaves farther off
/// falls with 1/cosh² v, to under 5e-4 of it.
const STEP: f64 = 0.01;
const BEYOND: f64 = 4.5;

/// Halvings of a piece at most.
const MOST_HALVINGS: u32 = 20;

/// What is radiated per azimuth at one wavelength, rad⁻¹.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Marginal {
    /// Of f: of an instance, or of the smooth mean, which is the fitted U' itself.
    pub f: Vec<f64>,
    /// Of the steady part s.
    pub steady: Vec<f64>,
}

/// ∫ f (z·ω_o) cosθ_o dθ_o / cosθ_i at each azimuth `phi_o` (rad), of an instance or of the smooth mean, one for each
/// wavelength; times cosθ_i and integrated over φ_o it is the reflected fraction.
///
/// Without an instance the integral is known; with one its relative accuracy is 1e-6. f is not symmetrized.
///
/// # Errors
/// A stop by `progress`.
pub fn marginals(
    brdf: &FeatherBrdf,
    wavelengths_nm: &[f64],
    wi: DVec3,
    phi_o: &[f64],
    instance: Option<u64>,
    progress: &dyn Progress,
) -> Result<Vec<Marginal>> {
    marginals_by(&Rule::fine(), brdf, wavelengths_nm, wi, phi_o, instance, progress)
}

/// The same, summed by a rule.
fn marginals_by(
    rule: &Rule,
    brdf: &FeatherBrdf,
    wavelengths_nm: &[f64],
    wi: DVec3,
    phi_o: &[f64],
    instance: Option<u64>,
    progress: &dyn Progress,
) -> Result<Vec<Marginal>> {
    progress.begin("marginals", wavelengths_nm.len() as u64);
    let draw = instance.map(|instance| brdf.noise().draw(instance));
    let cos_i = wi.x.hypot(wi.z);
    wavelengths_nm
        .iter()
        .map(|&nm| {
            let exact = brdf.exact(nm, wi);
            let row = phi_o.par_iter().map(|&phi| {
                if progress.is_cancelled() {
                    return Err(Error::interrupted());
                }
                let smooth = exact.across([phi.sin(), phi.cos()], 1.0, None);
                let f = match &draw {
                    None => smooth.f / cos_i,
                    Some(draw) => Meridian { exact: &exact, phi, draw, rule }.integral(),
                };
                Ok((f, smooth.steady / cos_i))
            });
            let (f, steady) = row.collect::<Result<Vec<_>>>()?.into_iter().unzip();
            progress.advance(1);
            Ok(Marginal { f, steady })
        })
        .collect()
}

/// The reflected fraction ∫ f (z·ω_o) dω_o at each wavelength, of an instance or of the smooth mean, whatever azimuths anybody asks for.
///
/// Of the mean it is known. Of an instance its marginal is summed over even steps of v = arsinh(tanφ_o), in which lobes near the horizon
/// are as wide as elsewhere: good to about 1e-3, which is what the speckle leaves between the steps. An instance may give back more than
/// falls in where light grazes: its speckle multiplies lobes that the horizon cuts, and only the mean over instances is the mean's. f is
/// not symmetrized.
///
/// # Errors
/// A stop by `progress`.
pub fn reflected_fractions(
    brdf: &FeatherBrdf,
    wavelengths_nm: &[f64],
    wi: DVec3,
    instance: Option<u64>,
    progress: &dyn Progress,
) -> Result<Vec<f64>> {
    if instance.is_none() {
        return Ok(wavelengths_nm.iter().map(|&nm| brdf.exact(nm, wi).reflected()).collect());
    }
    let reach = libm::asinh(wi.x / wi.z).abs() + BEYOND;
    let steps = (reach / STEP).ceil();
    let nodes: Vec<f64> = (0..=2 * steps as usize).map(|k| STEP * (k as f64 - steps)).collect();
    let phi_o: Vec<f64> = nodes.iter().map(|&v| libm::atan(libm::sinh(v))).collect();
    // dφ_o = dv / cosh v.
    let scale = STEP * wi.x.hypot(wi.z);
    let sum = |row: Marginal| row.f.iter().zip(&nodes).map(|(f, &v)| f / libm::cosh(v)).sum::<f64>() * scale;
    let rows = marginals_by(&Rule::rough(), brdf, wavelengths_nm, wi, &phi_o, instance, progress)?;
    Ok(rows.into_iter().map(sum).collect())
}

/// How a meridian is summed.
struct Rule {
    /// Nodes and weights on \[0, 1\].
    nodes: Vec<(f64, f64)>,
    /// What halving may change in the end, as a part of the whole.
    tolerance: f64,
}

impl Rule {
    fn fine() -> Self {
        Self { nodes: gauss_legendre(8), tolerance: TOLERANCE }
    }

    /// With fewer nodes, since the noise's points cut a meridian into small pieces anyway.
    fn rough() -> Self {
        Self { nodes: gauss_legendre(3), tolerance: ROUGH }
    }

    fn over(&self, f: &impl Fn(f64) -> f64, [a, b]: [f64; 2]) -> f64 {
        (b - a) * self.nodes.iter().map(|&(u, w)| w * f(a + (b - a) * u)).sum::<f64>()
    }

    /// The same with halving; `whole` is the rule's value of this piece.
    fn refined(&self, f: &impl Fn(f64) -> f64, piece: [f64; 2], whole: f64, allowed: f64, depth: u32) -> f64 {
        let [a, b] = piece;
        let halves = [[a, 0.5 * (a + b)], [0.5 * (a + b), b]];
        let values = halves.map(|half| self.over(f, half));
        let sum = values[0] + values[1];
        if (sum - whole).abs() <= allowed || depth == MOST_HALVINGS {
            return sum;
        }
        self.refined(f, halves[0], values[0], allowed, depth + 1)
            + self.refined(f, halves[1], values[1], allowed, depth + 1)
    }
}

/// The outgoing directions of one azimuth.
struct Meridian<'a> {
    exact: &'a ExactBrdf<'a>,
    phi: f64,
    draw: &'a Draw,
    rule: &'a Rule,
}

impl Meridian<'_> {
    fn integral(&self) -> f64 {
        let wi = self.exact.incident;
        let cos_i = wi.x.hypot(wi.z);
        let (sine, cosine) = self.phi.sin_cos();
        let f = |theta: f64| {
            let (y_o, cos_o) = theta.sin_cos();
            let along = self.exact.along([y_o, cos_o]);
            self.exact.across([sine, cosine], cos_o, Some(self.draw)).f * along * cos_o / cos_i
        };
        let edges = self.edges();
        let pieces: Vec<[f64; 2]> = edges.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        let coarse: Vec<f64> = pieces.iter().map(|piece| self.rule.over(&f, *piece)).collect();
        let allowed = self.rule.tolerance * coarse.iter().sum::<f64>();
        pieces.iter().zip(coarse).map(|(piece, whole)| self.rule.refined(&f, *piece, whole, allowed, 0)).sum()
    }

    /// θ_o between which f is smooth and not too narrow a peak, rad, rising: each Gaussian along the barbule in steps
    /// of its width, and where the noise passes from point to point.
    fn edges(&self) -> Vec<f64> {
        let right = std::f64::consts::FRAC_PI_2;
        let centre = -self.exact.incident.y.asin();
        let steps = |sigma: &f64| {
            let reach = 2.0 * libm::asin((END.sqrt() * sigma).min(1.0));
            (-4..=4).map(move |k| (centre + 0.25 * f64::from(k) * reach).clamp(-right, right))
        };
        let mut edges: Vec<f64> =
            self.exact.brdf.tables.longitudinal.sigmas().iter().flat_map(steps).collect();
        edges.sort_by(f64::total_cmp);
        let (first, last) = (edges[0], edges[edges.len() - 1]);
        // The turning point of x_o.
        let mut inner = vec![0.0];
        let sine = self.phi.sin();
        let x_i = self.exact.incident.x;
        let x_o = [first, last, 0.0_f64.clamp(first, last)].map(|theta| theta.cos() * sine);
        for inverse_length in self.exact.inverse_lengths(sine, self.phi.cos()) {
            let reach = x_o.map(|x| (x_i + x) * inverse_length);
            let low = reach.into_iter().fold(f64::INFINITY, f64::min);
            let high = reach.into_iter().fold(f64::NEG_INFINITY, f64::max);
            inner.extend(knots(low, high).flat_map(|x| both_signs((x / inverse_length - x_i) / sine)));
        }
        edges.extend(inner.into_iter().filter(|theta| (first..last).contains(theta)));
        edges.sort_by(f64::total_cmp);
        edges.dedup();
        edges
    }
}

/// The angles of a cosine.
fn both_signs(cosine: f64) -> impl Iterator<Item = f64> {
    (0.0..=1.0).contains(&cosine).then(|| libm::acos(cosine)).into_iter().flat_map(|angle| [-angle, angle])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Options;
    use crate::brdf::fixtures::example;
    use crate::progress::Unobserved;
    use crate::scattering::directions::{azimuths, omega};

    fn marginal(brdf: &FeatherBrdf, wi: DVec3, phi: &[f64], instance: Option<u64>) -> Vec<f64> {
        marginals(brdf, &[500.0], wi, phi, instance, &Unobserved).unwrap().remove(0).f
    }

    /// The integral by its definition, on evenly spaced θ_o.
    fn plain(brdf: &FeatherBrdf, wi: DVec3, phi: f64, instance: Option<u64>) -> f64 {
        let exact = brdf.exact(500.0, wi);
        let count = 100_000;
        let step = std::f64::consts::PI / f64::from(count);
        let f = |k: i32| {
            let theta = (f64::from(k) + 0.5) * step - std::f64::consts::FRAC_PI_2;
            let wo = omega(theta, phi);
            exact.values(wo, instance).f * wo.z * theta.cos()
        };
        (0..count).map(f).sum::<f64>() * step / wi.x.hypot(wi.z)
    }

    #[test]
    fn marginals_are_the_plain_integral() {
        let brdf = FeatherBrdf::new(&example(2), Options::default()).unwrap();
        for (theta, phi_i) in [(0.0, 30.0), (35.0, -20.0), (-75.0, 60.0), (10.0, 85.0)] {
            let wi = omega(f64::to_radians(theta), f64::to_radians(phi_i));
            for phi in [-phi_i - 3.0, 0.3, 80.0] {
                let phi = f64::to_radians(phi);
                // The table of 1/Q is right to 1e-6; the corners of the noise leave the plain sum an error of slope · step².
                for (instance, allowed) in [(None, 1e-6), (Some(5), 2e-5)] {
                    let fast = marginal(&brdf, wi, &[phi], instance)[0];
                    let slow = plain(&brdf, wi, phi, instance);
                    assert!(
                        (fast / slow - 1.0).abs() < allowed,
                        "{theta} {phi_i} {phi} {instance:?}: {fast} {slow}"
                    );
                }
            }
        }
    }

    /// Peaks of D₁ far narrower than the longitudinal spread.
    #[test]
    fn narrow_lobes_are_not_missed() {
        let mut material = example(2);
        material.sets[0].mean[0].m.fill(0.002);
        let brdf = FeatherBrdf::new(&material, Options::default()).unwrap();
        let wi = omega(0.7, 0.5);
        for phi in [-0.53, -0.5, -0.47] {
            let (fast, slow) = (marginal(&brdf, wi, &[phi], None)[0], plain(&brdf, wi, phi, None));
            assert!((fast / slow - 1.0).abs() < 1e-6, "{phi}: {fast} {slow}");
        }
    }

    #[test]
    fn marginals_integrate_to_the_reflected_fraction() {
        let brdf = FeatherBrdf::new(&example(2), Options::default()).unwrap();
        let phi: Vec<f64> = azimuths(400).collect();
        for (theta, phi_i) in [(0.0_f64, 0.0_f64), (40.0, 30.0), (-70.0, -50.0)] {
            let wi = omega(theta.to_radians(), phi_i.to_radians());
            let sum: f64 = marginal(&brdf, wi, &phi, None).iter().sum();
            let reflected = sum * std::f64::consts::PI / 400.0 * theta.to_radians().cos();
            let expected = brdf.albedo(500.0, wi);
            assert!((reflected / expected - 1.0).abs() < 1e-4, "{theta} {phi_i}: {reflected} {expected}");
        }
    }

    /// The sum over many azimuths, which finds its way to it; and near the horizon the mean over instances, which no grid of azimuths
    /// would show.
    #[test]
    fn the_reflected_fraction_is_what_azimuths_sum_to_and_in_the_mean_the_means() {
        let brdf = FeatherBrdf::new(&example(2), Options::default()).unwrap();
        let of = |wi: DVec3, instance: Option<u64>| {
            reflected_fractions(&brdf, &[500.0], wi, instance, &Unobserved).unwrap()[0]
        };
        let count = 800;
        let phi: Vec<f64> = azimuths(count).collect();
        for (theta, phi_i) in [(0.0_f64, 0.0_f64), (40.0, 30.0), (10.0, -75.0)] {
            let wi = omega(theta.to_radians(), phi_i.to_radians());
            for instance in [None, Some(3)] {
                let sum: f64 = marginal(&brdf, wi, &phi, instance).iter().sum();
                let summed = sum * std::f64::consts::PI / count as f64 * theta.to_radians().cos();
                let found = of(wi, instance);
                assert!(
                    (found / summed - 1.0).abs() < 3e-3,
                    "{theta} {phi_i} {instance:?}: {found} {summed}"
                );
            }
        }
        let grazing = omega(0.0, f64::to_radians(89.99));
        let mean = of(grazing, None);
        let drawn = (0..8).map(|k| of(grazing, Some(k))).sum::<f64>() / 8.0;
        // Single ones scatter by about as much as they are: two standard errors of eight.
        assert!((drawn / mean - 1.0).abs() < 0.7, "{drawn} {mean}");
    }
}
