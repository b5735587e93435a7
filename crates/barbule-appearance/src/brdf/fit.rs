//! From the statistics of a campaign to a material.

use rayon::prelude::*;

pub use super::fitted::{fitted_scale, fitted_values};
pub use super::patterns::Pattern;

use super::fitted::direction;
use super::integral::Fine;
use super::length;
use super::material::{FeatherMaterial, LobeSet, ParameterSet, check_sigma};
use super::noise::spectrum;
use crate::progress::Progress;
use crate::scattering::lobe::{Fit, FitKind, Fitter, Lobe};
use crate::scattering::statistics::{AZIMUTHS, LAGS, Statistics};
use crate::{Error, Result};

/// A mean lobe with a larger relative residual is flagged.
pub const LARGEST_RESIDUAL: f64 = 0.5;

/// A stationary part with less than this share of the energy takes the mean lobe's shape: its own would be noise.
const SMALLEST_STATIONARY: f64 = 2e-3;

/// How a material is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitOptions {
    /// What the lobe's shape is fitted to.
    pub kind: FitKind,
    /// Longitudinal spread σ that the material proposes.
    pub sigma: f64,
    /// Whether both incident polarizations keep sets of their own.
    pub polarized: bool,
    /// Seed of the material's noise.
    pub seed: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { kind: FitKind::Marginal, sigma: 0.04, polarized: false, seed: 1 }
    }
}

/// How well a fit went, over all (λ, ω_i) of all sets.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FitReport {
    /// Median of ‖U' − U‖/‖U‖ over the azimuths.
    pub residual_median: f64,
    /// 95th percentile of the same.
    pub residual_95: f64,
    /// Fits that did not settle or whose residual exceeds [`LARGEST_RESIDUAL`].
    pub flagged: Vec<Flagged>,
    /// Number of mean lobes fitted.
    pub fits: usize,
    /// Largest part of V's total that the clip to \[0, U\] took away, relative to U's.
    pub largest_clip: f64,
    /// l at the longest wavelength and normal incidence, by least squares and by ratio of 1/e lengths.
    pub longest_length: [f64; 2],
    /// Median of |l_least squares / l_ratio − 1| over all (λ, ω_i).
    pub length_disagreement: f64,
    /// Correlation of both polarizations' intensity patterns, and contrast of the unpolarized intensity.
    pub patterns: Vec<Pattern>,
    /// Nodes that reflected over all light: the material has 1 there.
    pub clipped: Vec<Clipped>,
    /// Directions so near grazing incidence that the simulation does not hold; left to the caller, who knows the barbule.
    pub grazing: Vec<GrazingDirection>,
}

/// A node that reflected over all light.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Clipped {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// θ_i, degrees.
    pub theta_deg: f64,
    /// φ_i, degrees.
    pub phi_deg: f64,
    /// What it reflected.
    pub reflected: f64,
}

/// A direction at which a flat perfect mirror as wide as the barbule would not reflect all light.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct GrazingDirection {
    /// θ_i, degrees.
    pub theta_deg: f64,
    /// φ_i, degrees.
    pub phi_deg: f64,
    /// At how many of the wavelengths.
    pub wavelengths: usize,
    /// What the mirror would reflect where it is furthest off.
    pub mirror_fraction: f64,
}

/// One fit that should not be trusted.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Flagged {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// θ_i, degrees.
    pub theta_deg: f64,
    /// φ_i, degrees.
    pub phi_deg: f64,
    /// Relative residual.
    pub residual: f64,
    /// Whether the least squares settled.
    pub converged: bool,
}

impl FitReport {
    /// Nodes (λ, ω_i) at the directions near grazing incidence.
    #[must_use]
    pub fn grazing_nodes(&self) -> usize {
        self.grazing.iter().map(|direction| direction.wavelengths).sum()
    }

    /// Correlation of the polarizations' patterns, and contrast of unpolarized intensity, each simulated and synthesized:
    /// means over [`Self::patterns`], correlations weighted as they enter the variance of unpolarized light.
    #[must_use]
    pub fn mean_patterns(&self) -> [[f64; 2]; 2] {
        let mean = |value: &dyn Fn(&Pattern) -> f64| {
            self.patterns.iter().map(value).sum::<f64>() / self.patterns.len().max(1) as f64
        };
        let balance = mean(&|p| p.balance).max(f64::MIN_POSITIVE);
        let correlation = [0, 1].map(|side| mean(&|p| p.balance * p.correlation[side]) / balance);
        [correlation, [0, 1].map(|side| mean(&|p| p.contrast[side]))]
    }
}

/// The fits of one (λ, ω_i).
struct Node {
    mean: Fit,
    stationary: Lobe,
    /// At most 1.
    reflected: f64,
    /// What was simulated.
    simulated: f64,
    reflected_stationary: f64,
    fraction: [f64; 2],
    clipped: f64,
}

/// Which polarizations a set stands for.
type Chosen = &'static [usize];

/// Fits a material; what it says about itself ([`FeatherMaterial::info`]) is left to the caller.
///
/// # Errors
/// Statistics whose arrays do not match their axes, σ out of range, or a stop by the progress.
pub fn fit(
    statistics: &Statistics,
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<(FeatherMaterial, FitReport)> {
    check(statistics)?;
    check_sigma(options.sigma)?;
    let axes = &statistics.axes;
    let chosen: &[Chosen] = if options.polarized { &[&[0], &[1]] } else { &[&[0, 1]] };
    progress.begin("fitting", (axes.len() * chosen.len()) as u64);
    let noise_power = spectrum(&length::reference(statistics));
    let mut sets = Vec::new();
    let mut nodes = Vec::new();
    let mut ratios = Vec::new();
    for &polarizations in chosen {
        let fitted = fit_nodes(statistics, options, polarizations, progress)?;
        let lengths = length::lengths(statistics, polarizations);
        sets.push(parameter_set(&fitted, &lengths, polarizations.len() == 2));
        ratios.extend(lengths);
        nodes.extend(fitted);
    }
    let material = FeatherMaterial {
        axes: axes.clone(),
        kind: options.kind,
        sigma: options.sigma,
        sets,
        noise_power,
        seed: options.seed,
        info: serde_json::Value::Null,
    };
    let report = report(statistics, &material, &nodes, &ratios);
    Ok((material, report))
}

fn check(statistics: &Statistics) -> Result<()> {
    let nodes = statistics.axes.len();
    if nodes == 0 {
        return Err(Error::input("the statistics hold no wavelength or direction"));
    }
    for (name, found, expected) in [
        ("u", statistics.u.len(), nodes * 2 * AZIMUTHS),
        ("v", statistics.v.len(), nodes * 2 * AZIMUTHS),
        ("autocovariance", statistics.autocovariance.len(), nodes * 2 * LAGS),
        ("reflected", statistics.reflected.len(), nodes * 2),
        ("pattern_correlation", statistics.pattern_correlation.len(), nodes),
        ("unpolarized_contrast", statistics.unpolarized_contrast.len(), nodes),
        ("contrast", statistics.contrast.len(), nodes * 2 * AZIMUTHS),
    ] {
        if found != expected {
            return Err(Error::input(format!("{name} has {found} values, but the axes ask for {expected}")));
        }
    }
    let finite = |values: &[f32]| values.iter().all(|v| v.is_finite());
    if !(finite(&statistics.u) && finite(&statistics.v) && finite(&statistics.autocovariance)) {
        return Err(Error::not_settled(
            "the statistics hold values that are not finite, so nothing can be fitted",
        ));
    }
    Ok(())
}

fn fit_nodes(
    statistics: &Statistics,
    options: &FitOptions,
    polarizations: Chosen,
    progress: &dyn Progress,
) -> Result<Vec<Node>> {
    let axes = &statistics.axes;
    let phis = axes.cos_phi().len();
    let fitters: Vec<Fitter> =
        axes.cos_theta().iter().map(|&c| Fitter::new(options.kind, libm::acos(c), AZIMUTHS)).collect();
    let quadrature = Fine::new();
    let rows: Vec<Vec<Node>> = (0..axes.wavelengths_nm().len() * axes.cos_theta().len())
        .into_par_iter()
        .map(|row| {
            let theta = row % axes.cos_theta().len();
            let nodes = (0..phis)
                .map(|phi| {
                    let node = row * phis + phi;
                    let node_fit = NodeFit {
                        statistics,
                        node,
                        polarizations,
                        quadrature: &quadrature,
                        sigma: options.sigma,
                    };
                    node_fit.fit(&fitters[theta], axes.cos_theta()[theta], axes.cos_phi()[phi])
                })
                .collect();
            progress.advance(phis as u64);
            if progress.is_cancelled() { Err(Error::interrupted()) } else { Ok(nodes) }
        })
        .collect::<Result<_>>()?;
    Ok(rows.into_iter().flatten().collect())
}

/// One (λ, ω_i) of the statistics.
struct NodeFit<'a> {
    statistics: &'a Statistics,
    node: usize,
    polarizations: Chosen,
    quadrature: &'a Fine,
    sigma: f64,
}

impl NodeFit<'_> {
    /// The mean over the chosen polarizations, and at normal azimuth over both sides, which are mirror images.
    fn values(&self, array: &[f32], cos_phi: f64) -> Vec<f64> {
        let mut mean = vec![0.0; AZIMUTHS];
        for &p in self.polarizations {
            let from = &array[(self.node * 2 + p) * AZIMUTHS..][..AZIMUTHS];
            for (sum, value) in mean.iter_mut().zip(from) {
                *sum += f64::from(*value) / self.polarizations.len() as f64;
            }
        }
        if cos_phi > 1.0 - 1e-12 {
            let mirrored: Vec<f64> = mean.iter().rev().copied().collect();
            for (value, other) in mean.iter_mut().zip(mirrored) {
                *value = 0.5 * (*value + other);
            }
        }
        mean
    }

    fn fit(&self, fitter: &Fitter, cos_theta: f64, cos_phi: f64) -> Node {
        let phi_i = libm::acos(cos_phi);
        let step = std::f64::consts::PI / AZIMUTHS as f64;
        let u = self.values(&self.statistics.u, cos_phi);
        let v = self.values(&self.statistics.v, cos_phi);
        let lobe_of = |values: &[f64]| {
            // By symmetry the azimuth is 0 there, even where two modes would pull it to one of them.
            if cos_phi > 1.0 - 1e-12 { fitter.fit_m(0.0, values) } else { fitter.fit(phi_i, values) }
        };
        let mean = lobe_of(&u);
        let total = |values: &[f64]| cos_theta * step * values.iter().sum::<f64>();
        let simulated = total(&u);
        let reflected = simulated.clamp(0.0, 1.0);
        let unclipped = total(&v);
        let own = lobe_of(&v);
        let weak = unclipped < SMALLEST_STATIONARY * reflected || own.scale == 0.0;
        let stationary = if weak { mean.lobe } else { own.lobe };
        // F_sta ≤ F_eff, with F = ρ/I.
        let integral = |lobe: Lobe| self.quadrature.integral(lobe, libm::acos(cos_theta), self.sigma);
        let highest = reflected * (integral(stationary) / integral(mean.lobe)).min(1.0);
        let reflected_stationary = unclipped.clamp(0.0, highest);
        let clipped = (unclipped - reflected_stationary).abs() / reflected.max(f64::MIN_POSITIVE);
        let mut fraction = [self.fraction(&self.statistics.u), self.fraction(&self.statistics.v)];
        let (mut stationary, mut reflected_stationary) = (stationary, reflected_stationary);
        let steady = steady_share(self.statistics.unpolarized_contrast[self.node], self.statistics.instances);
        if steady * reflected > reflected_stationary {
            (stationary, reflected_stationary) = (mean.lobe, steady * reflected);
            fraction[1] = fraction[0];
        }
        Node { mean, stationary, reflected, simulated, reflected_stationary, fraction, clipped }
    }

    /// Polarization 1's part of the energy.
    fn fraction(&self, array: &[f32]) -> f64 {
        let [first, second] = [0, 1].map(|p| {
            let from = &array[(self.node * 2 + p) * AZIMUTHS..][..AZIMUTHS];
            from.iter().map(|&v| f64::from(v)).sum::<f64>().max(0.0)
        });
        if first + second > 0.0 { first / (first + second) } else { 0.5 }
    }
}

/// The part s/f̂ of a lobe's intensity that does not fluctuate, from the contrast of M instances.
///
/// Fields A e^{jψ} + n with a phase ψ of each instance's own have V = 0 although their intensity varies by
/// U² − A⁴ only: A² = U √(1 − contrast²). Speckle alone gives 1 − contrast² = 0 ± 1/√M or so, so values up to
/// 0.75/√M count as none, those from three times that on in full.
fn steady_share(contrast: f64, instances: usize) -> f64 {
    if instances < 8 {
        return 0.0;
    }
    let count = instances as f64;
    // The mean of M draws stands for the true one: of fully developed speckle (M − 1)/(M + 1) is found.
    let part = 1.0 - contrast * contrast * (count + 1.0) / (count - 1.0);
    let noise = 0.75 / count.sqrt();
    let t = ((part - noise) / (2.0 * noise)).clamp(0.0, 1.0);
    (part.clamp(0.0, 1.0) * t * t * (3.0 - 2.0 * t)).sqrt()
}

fn parameter_set(nodes: &[Node], lengths: &[length::Length], fractions: bool) -> ParameterSet {
    let gather = |value: fn(&Node) -> f64| nodes.iter().map(|n| value(n) as f32).collect::<Vec<f32>>();
    ParameterSet {
        mean: LobeSet {
            m: gather(|n| n.mean.lobe.m),
            phi: gather(|n| n.mean.lobe.phi),
            reflected: gather(|n| n.reflected),
        },
        stationary: LobeSet {
            m: gather(|n| n.stationary.m),
            phi: gather(|n| n.stationary.phi),
            reflected: gather(|n| n.reflected_stationary),
        },
        length: lengths.iter().map(|l| l.fitted as f32).collect(),
        fraction_1: if fractions { gather(|n| n.fraction[0]) } else { Vec::new() },
        stationary_fraction_1: if fractions { gather(|n| n.fraction[1]) } else { Vec::new() },
    }
}

fn report(
    statistics: &Statistics,
    material: &FeatherMaterial,
    nodes: &[Node],
    lengths: &[length::Length],
) -> FitReport {
    let axes = &statistics.axes;
    let mut residuals: Vec<f64> = nodes.iter().map(|n| n.mean.residual).collect();
    residuals.sort_by(f64::total_cmp);
    let quantile = |values: &[f64], q: f64| values[((values.len() - 1) as f64 * q).round() as usize];
    let bad = |n: &Node| !n.mean.converged || n.mean.residual > LARGEST_RESIDUAL || n.mean.residual.is_nan();
    let flagged = nodes
        .iter()
        .enumerate()
        .filter(|(_, n)| bad(n))
        .map(|(at, n)| {
            let (wavelength_nm, theta_deg, phi_deg) = direction(axes, at % axes.len());
            Flagged {
                wavelength_nm,
                theta_deg,
                phi_deg,
                residual: n.mean.residual,
                converged: n.mean.converged,
            }
        })
        .collect();
    let clipped = nodes
        .iter()
        .enumerate()
        .filter(|(_, n)| n.simulated > 1.0)
        .map(|(at, n)| {
            let (wavelength_nm, theta_deg, phi_deg) = direction(axes, at % axes.len());
            Clipped { wavelength_nm, theta_deg, phi_deg, reflected: n.simulated }
        })
        .collect();
    let mut apart: Vec<f64> = lengths.iter().map(|l| (l.fitted / l.ratio - 1.0).abs()).collect();
    apart.sort_by(f64::total_cmp);
    let last = &lengths[axes.len() - 1];
    FitReport {
        residual_median: quantile(&residuals, 0.5),
        residual_95: quantile(&residuals, 0.95),
        flagged,
        fits: nodes.len(),
        largest_clip: nodes.iter().map(|n| n.clipped).fold(0.0, f64::max),
        longest_length: [last.fitted, last.ratio],
        length_disagreement: quantile(&apart, 0.5),
        patterns: super::patterns::compare(statistics, material),
        clipped,
        grazing: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::fixtures::example;
    use crate::progress::Unobserved;
    use crate::scattering::statistics::Axes;
    use crate::spectrum::Wavelengths;

    /// Statistics that a material's own lobes would give, with the biased fluctuation of `noise` on V.
    fn statistics_of(material: &FeatherMaterial) -> Statistics {
        let wavelengths = Wavelengths::new(material.axes.wavelengths_nm()).unwrap();
        let axes = Axes::new(&wavelengths, vec![0.3, 0.7, 1.0], vec![0.05, 0.25, 0.6, 1.0]).unwrap();
        let mut out = Statistics {
            instances: 50,
            u: vec![],
            v: vec![],
            autocovariance: vec![],
            reflected: vec![],
            reflected_std: vec![],
            pattern_correlation: vec![1.0; axes.len()],
            contrast: vec![1.0; axes.len()],
            axes,
        };
        let set = &material.sets[0];
        let from = |axis: &[f64], c: f64| axis.iter().position(|v| (v - c).abs() < 1e-9).unwrap();
        for (wave, &nm) in out.axes.wavelengths_nm().iter().enumerate() {
            for &ct in out.axes.cos_theta() {
                for &cp in out.axes.cos_phi() {
                    let at = material.axes.index(
                        wave,
                        from(material.axes.cos_theta(), ct),
                        from(material.axes.cos_phi(), cp),
                    );
                    let values = |lobe: &LobeSet| {
                        let shape = Lobe { m: f64::from(lobe.m[at]), phi: f64::from(lobe.phi[at]) };
                        fitted_values(FitKind::Marginal, shape, ct.acos(), f64::from(lobe.reflected[at]))
                    };
                    for share in [1.2_f32, 0.8] {
                        out.u.extend(values(&set.mean).iter().map(|v| share * *v as f32));
                        out.v.extend(values(&set.stationary).iter().map(|v| share * *v as f32));
                        out.reflected.push(f64::from(set.mean.reflected[at]) * f64::from(share));
                        out.reflected_std.push(0.0);
                        let scale = 8.0 * nm / 400.0 * (0.8 + 0.2 * cp);
                        out.autocovariance
                            .extend((0..LAGS).map(|k| libm::exp(-(k as f64 / scale).powi(2)) as f32 * share));
                    }
                }
            }
        }
        out
    }

    #[test]
    fn a_material_is_found_again_from_its_statistics() {
        let material = example(3);
        let statistics = statistics_of(&material);
        let (fitted, report) = fit(&statistics, &FitOptions::default(), &Unobserved).unwrap();
        fitted.check().unwrap();
        // Where the azimuth passes over to φ_i the shape is no longer free.
        assert!(report.residual_median < 1e-6 && report.residual_95 < 0.03, "{report:?}");
        assert!(report.flagged.is_empty() && report.largest_clip < 1e-6, "{report:?}");
        assert!((report.longest_length[0] - 1.735).abs() < 0.01, "{report:?}");
        let set = &fitted.sets[0];
        let axes = &fitted.axes;
        for wave in 0..3 {
            for (t, ct) in axes.cos_theta().iter().enumerate() {
                for (p, cp) in axes.cos_phi().iter().enumerate() {
                    let from = |axis: &[f64], c: f64| axis.iter().position(|v| (v - c).abs() < 1e-9).unwrap();
                    let other = material.axes.index(
                        wave,
                        from(material.axes.cos_theta(), *ct),
                        from(material.axes.cos_phi(), *cp),
                    );
                    let at = axes.index(wave, t, p);
                    let close = |a: f32, b: f32| (a / b - 1.0).abs() < 2e-3 || (a - b).abs() < 2e-4;
                    let grazing = ct * cp < 0.1;
                    let expected = &material.sets[0];
                    assert!(grazing || close(set.mean.m[at], expected.mean.m[other]));
                    assert!(grazing || (set.mean.phi[at] - expected.mean.phi[other]).abs() < 1e-3);
                    assert!(close(set.mean.reflected[at], expected.mean.reflected[other]));
                    assert!(close(set.stationary.reflected[at], expected.stationary.reflected[other]));
                    assert!(close(set.length[at], expected.length[other]));
                    assert!(close(set.fraction_1[at], 0.6));
                }
            }
        }
        for pattern in &report.patterns {
            // Contrast of a field of which a share s/f̂ is common: √(1 − (s/f̂)²), here averaged over azimuths.
            assert!((0.3..1.05).contains(&pattern.contrast[1]), "{pattern:?}");
            assert!(pattern.correlation[1] > 0.98, "{pattern:?}");
        }
        let polarized = FitOptions { polarized: true, ..FitOptions::default() };
        let (both, _) = fit(&statistics, &polarized, &Unobserved).unwrap();
        both.check().unwrap();
        assert!((both.sets[0].mean.reflected[7] / both.sets[1].mean.reflected[7] - 1.5).abs() < 1e-4);
    }

    #[test]
    fn noise_in_the_mean_field_is_not_clipped_before_its_total() {
        let material = example(1);
        let mut statistics = statistics_of(&material);
        let mut stream = crate::math::rng::Stream::new(1, &[]);
        for (v, u) in statistics.v.iter_mut().zip(&statistics.u) {
            *v = 0.02 * u * stream.normal() as f32;
        }
        let (fitted, report) = fit(&statistics, &FitOptions::default(), &Unobserved).unwrap();
        fitted.check().unwrap();
        // Zero mean with either sign: what remains after clipping the total is 0.02 √(2/π)/2 of U over √(azimuths).
        let share: f32 = fitted.sets[0]
            .stationary
            .reflected
            .iter()
            .zip(&fitted.sets[0].mean.reflected)
            .map(|(s, u)| s / u)
            .sum();
        assert!(share / 12.0 < 3e-3, "{share} {report:?}");
    }

    #[test]
    fn broken_statistics_are_refused_and_empty_ones_survive() {
        let mut statistics = statistics_of(&example(1));
        for values in [&mut statistics.u, &mut statistics.v, &mut statistics.autocovariance] {
            values.fill(0.0);
        }
        let (dark, _) = fit(&statistics, &FitOptions::default(), &Unobserved).unwrap();
        dark.check().unwrap();
        statistics.u.pop();
        let error = fit(&statistics, &FitOptions::default(), &Unobserved).unwrap_err();
        assert!(error.to_string().contains("u has"), "{error}");
        let wide = FitOptions { sigma: 1.0, ..FitOptions::default() };
        assert!(fit(&statistics_of(&example(1)), &wide, &Unobserved).unwrap_err().is_input());
    }

    #[test]
    fn intensities_that_hardly_vary_leave_instances_that_hardly_vary() {
        for contrast in [0.4, 0.6, 0.75] {
            let mut statistics = statistics_of(&example(2));
            statistics.contrast.fill(contrast);
            let (_, report) = fit(&statistics, &FitOptions::default(), &Unobserved).unwrap();
            for pattern in &report.patterns {
                // The ramp above the campaign's own noise weakens a steady part of less than half.
                let [wanted, found] = pattern.contrast;
                assert!((found - wanted).abs() < 0.06, "{wanted} {found}");
            }
        }
    }

    #[test]
    fn speckle_has_no_steady_part_even_in_few_instances() {
        for instances in [1, 7, 12, 50] {
            let count = instances as f64;
            let found = ((count - 1.0) / (count + 1.0)).sqrt();
            assert!(steady_share(found, instances) < 1e-12);
        }
        assert!((steady_share(0.5, 1000) - 0.75_f64.sqrt()).abs() < 1e-3);
        assert!(steady_share(0.0, 50) > 0.999 && steady_share(2.0, 50) == 0.0);
    }
}
