//! How well a material was fitted.

use super::fitted::{direction, place};
use super::fitted_node::FittedNode;
use super::length;
use super::material::FeatherMaterial;
use super::patterns::{Pattern, compare};
use super::spectral::SpectralErrors;
use crate::scattering::lobe::PairFit;
use crate::scattering::statistics::{Axes, Statistics};

/// A mean with a larger relative residual is flagged.
pub const LARGEST_RESIDUAL: f64 = 0.5;

/// Nodes with a smaller cosθ_i cosφ_i are near grazing incidence: lobes' azimuths are not free there.
const GRAZING: f64 = 0.1;

/// How well a fit went, over all (λ, ω_i) of all sets.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FitReport {
    /// Median of ‖U' − U‖/‖U‖ over the azimuths.
    pub residual_median: f64,
    /// 95th percentile of the same.
    pub residual_95: f64,
    /// Median and 95th percentile of the same where cosθ_i cosφ_i ≥ 0.1.
    pub residual_off_grazing: [f64; 2],
    /// Fits that did not settle or whose residual exceeds [`LARGEST_RESIDUAL`].
    pub flagged: Vec<Flagged>,
    /// Number of mean intensities fitted.
    pub fits: usize,
    /// Median of the part of what is reflected that does not fluctuate.
    pub steady_median: f64,
    /// Median of the part of the mean field's intensity V in what is reflected.
    pub coherent_median: f64,
    /// l at the longest wavelength and normal incidence, by least squares and by ratio of 1/e lengths.
    pub longest_length: [f64; 2],
    /// Median of |l_least squares / l_ratio − 1| over all (λ, ω_i).
    pub length_disagreement: f64,
    /// What instances do beside the simulated barbules, at up to nine (λ, ω_i).
    pub patterns: Vec<Pattern>,
    /// Correlations of instances between wavelengths and between lights: how far they are from the simulated ones.
    pub spectral: SpectralErrors,
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

    /// Contrast of one polarization's intensity at the mirror direction, the shoulders and the wings of lobes
    /// ([`Pattern::regions`]), each simulated and synthesized: means over [`Self::patterns`] and both polarizations, `None`
    /// where there is none.
    #[must_use]
    pub fn mean_regions(&self) -> [Option<[f64; 2]>; 3] {
        [0, 1, 2].map(|region| {
            let of = |p: &Pattern| p.regions.iter().filter_map(|side| side[region]).collect::<Vec<_>>();
            let found: Vec<[f64; 2]> = self.patterns.iter().flat_map(of).collect();
            let mean = |side: usize| found.iter().map(|pair| pair[side]).sum::<f64>() / found.len() as f64;
            (!found.is_empty()).then(|| [mean(0), mean(1)])
        })
    }
}

pub(super) fn report(
    statistics: &Statistics,
    material: &FeatherMaterial,
    nodes: &[FittedNode],
    lengths: &[length::Length],
    spectral: SpectralErrors,
) -> FitReport {
    let axes = &statistics.axes;
    let residuals = || nodes.iter().map(|n| n.mean.residual);
    let off = residuals().enumerate().filter(|(at, _)| cosine(axes, at % axes.len()) >= GRAZING);
    let off: Vec<f64> = off.map(|(_, residual)| residual).collect();
    let bad =
        |n: &FittedNode| !n.mean.converged || n.mean.residual > LARGEST_RESIDUAL || n.mean.residual.is_nan();
    let flagged = nodes.iter().enumerate().filter(|(_, n)| bad(n)).map(|(at, n)| {
        let (wavelength_nm, theta_deg, phi_deg) = direction(axes, at % axes.len());
        let PairFit { residual, converged, .. } = n.mean;
        Flagged { wavelength_nm, theta_deg, phi_deg, residual, converged }
    });
    let clipped = nodes.iter().enumerate().filter(|(_, n)| n.simulated > 1.0).map(|(at, n)| {
        let (wavelength_nm, theta_deg, phi_deg) = direction(axes, at % axes.len());
        Clipped { wavelength_nm, theta_deg, phi_deg, reflected: n.simulated }
    });
    // Of the longest wavelength, the direction nearest to normal incidence.
    let normal = [axes.wavelengths_nm().len(), axes.cos_theta().len(), axes.cos_phi().len()].map(|n| n - 1);
    let last = &lengths[axes.index(normal[0], normal[1], normal[2])];
    let share = |n: &FittedNode| n.steady.energy;
    FitReport {
        residual_median: quantile(residuals().collect(), 0.5),
        residual_95: quantile(residuals().collect(), 0.95),
        residual_off_grazing: [0.5, 0.95].map(|q| quantile(off.clone(), q)),
        flagged: flagged.collect(),
        fits: nodes.len(),
        steady_median: quantile(nodes.iter().map(share).collect(), 0.5),
        coherent_median: quantile(nodes.iter().map(|n| n.coherent).collect(), 0.5),
        longest_length: [last.fitted, last.ratio],
        length_disagreement: quantile(
            lengths.iter().map(|l| (l.fitted / l.ratio - 1.0).abs()).collect(),
            0.5,
        ),
        patterns: compare(statistics, material),
        spectral,
        clipped: clipped.collect(),
        grazing: Vec::new(),
    }
}

/// cosθ_i cosφ_i of a node.
fn cosine(axes: &Axes, node: usize) -> f64 {
    let [_, theta, phi] = place(axes, node);
    axes.cos_theta()[theta] * axes.cos_phi()[axes.cosine_of(phi)] + 1e-12
}

/// A quantile of the values; 0 without any.
fn quantile(mut values: Vec<f64>, q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get((values.len().saturating_sub(1) as f64 * q).round() as usize).copied().unwrap_or(0.0)
}
