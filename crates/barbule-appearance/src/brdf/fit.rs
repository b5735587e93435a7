//! From the statistics of a campaign to a material.

use rayon::prelude::*;

pub use super::fitted::{Fitted, fitted, fitted_scale, fitted_values};
pub use super::patterns::Pattern;
pub use super::report::{Clipped, FitReport, Flagged, GrazingDirection, LARGEST_RESIDUAL};

use super::fitted::{fitted_on_azimuths, place};
use super::material::{FeatherMaterial, LobeSet, ParameterSet, check_sigma};
use super::noise::spectrum;
use super::steady::{self, Observed, Steady};
use super::{correlation, length, report};
use crate::progress::Progress;
use crate::scattering::lobe::{FitKind, Fitter, Lobe, PairFit};
use crate::scattering::statistics::{AZIMUTHS, LAGS, Sides, Statistics};
use crate::{Error, Result};

/// What stands for the mean intensity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LobeForm {
    /// Two lobes.
    #[default]
    Pair,
    /// A single lobe, as published.
    Ggx,
}

impl LobeForm {
    /// What a material was fitted with.
    #[must_use]
    pub fn of(material: &FeatherMaterial) -> Self {
        if material.sets.first().is_some_and(|set| set.mean.len() == 1) { Self::Ggx } else { Self::Pair }
    }
}

/// How a material is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitOptions {
    /// What the lobe's shape is fitted to.
    pub kind: FitKind,
    /// What stands for the mean intensity.
    pub lobe: LobeForm,
    /// Longitudinal spread σ that the material proposes.
    pub sigma: f64,
    /// Whether both incident polarizations keep sets of their own.
    pub polarized: bool,
    /// Seed of the material's noise.
    pub seed: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { kind: FitKind::Marginal, lobe: LobeForm::Pair, sigma: 0.04, polarized: false, seed: 1 }
    }
}

/// The fits of one (λ, ω_i).
pub(super) struct Node {
    pub(super) mean: PairFit,
    /// Part of the first lobe in what is reflected.
    first: f64,
    /// At most 1.
    pub(super) reflected: f64,
    /// What was simulated.
    pub(super) simulated: f64,
    pub(super) steady: Steady,
    /// Part of the mean field's intensity V in what was simulated.
    pub(super) coherent: f64,
    /// Polarization 1's part.
    fraction_1: f64,
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
    let fitters: Vec<Fitter> = (0..axes.cos_theta().len())
        .map(|theta| Fitter::new(options.kind, axes.theta_i(theta), AZIMUTHS))
        .collect();
    let mut sets = Vec::new();
    let mut nodes = Vec::new();
    let mut ratios = Vec::new();
    for &polarizations in chosen {
        let fitted = fit_nodes(statistics, options, polarizations, &fitters, progress)?;
        let lengths = length::lengths(statistics, polarizations);
        sets.push(parameter_set(&fitted, &lengths, options.lobe, polarizations.len() == 2));
        ratios.extend(lengths);
        nodes.extend(fitted);
    }
    let mut material = FeatherMaterial {
        axes: axes.clone(),
        kind: options.kind,
        sigma: options.sigma,
        sets,
        correlation: Vec::new(),
        noise_power: spectrum(&length::reference(statistics)),
        seed: options.seed,
        info: serde_json::Value::Null,
    };
    material.correlation = (0..axes.len())
        .into_par_iter()
        .map(|node| {
            let sides = fitted_on_azimuths(&material, node, &fitters[place(axes, node)[1]]);
            correlation::solved(&sides, statistics.pattern_correlation[node]) as f32
        })
        .collect();
    let report = report::report(statistics, &material, &nodes, &ratios);
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
    if ![&statistics.u, &statistics.v, &statistics.autocovariance, &statistics.contrast]
        .into_iter()
        .all(|v| finite(v))
    {
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
    fitters: &[Fitter],
    progress: &dyn Progress,
) -> Result<Vec<Node>> {
    let axes = &statistics.axes;
    let phis = axes.phis();
    let rows: Vec<Vec<Node>> = (0..axes.wavelengths_nm().len() * axes.cos_theta().len())
        .into_par_iter()
        .map(|row| {
            let theta = row % axes.cos_theta().len();
            let nodes = (0..phis)
                .map(|phi| {
                    let node_fit = NodeFit {
                        statistics,
                        node: row * phis + phi,
                        polarizations,
                        lobe: options.lobe,
                        fitter: &fitters[theta],
                        cos_theta: axes.cos_theta()[theta],
                        phi_i: axes.phi_i(phi),
                        is_even: axes.sides() == Sides::Alike
                            && axes.cos_phi()[axes.cosine_of(phi)] > 1.0 - 1e-12,
                    };
                    node_fit.fit()
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
    lobe: LobeForm,
    fitter: &'a Fitter,
    cos_theta: f64,
    /// Incident azimuth, rad.
    phi_i: f64,
    /// Whether light comes across the normal plane of a barbule whose both sides are alike: everything is its own mirror
    /// image there.
    is_even: bool,
}

impl NodeFit<'_> {
    /// One polarization's values.
    fn row(&self, array: &[f32], polarization: usize) -> Vec<f64> {
        let from = &array[(self.node * 2 + polarization) * AZIMUTHS..][..AZIMUTHS];
        from.iter().map(|v| f64::from(*v)).collect()
    }

    /// The mean over the chosen polarizations, and over both sides where they are mirror images.
    fn values(&self, array: &[f32]) -> Vec<f64> {
        let mut mean = vec![0.0; AZIMUTHS];
        for &p in self.polarizations {
            for (sum, value) in mean.iter_mut().zip(self.row(array, p)) {
                *sum += value / self.polarizations.len() as f64;
            }
        }
        if self.is_even {
            steady::fold(&mut mean);
        }
        mean
    }

    fn fit(&self) -> Node {
        let step = std::f64::consts::PI / AZIMUTHS as f64;
        let u = self.values(&self.statistics.u);
        let mean = self.mean(&u);
        let total = |values: &[f64]| self.cos_theta * step * values.iter().sum::<f64>();
        let simulated = total(&u);
        let reflected = simulated.clamp(0.0, 1.0);
        let coherent = total(&self.values(&self.statistics.v)) / simulated.max(f64::MIN_POSITIVE);
        let parts = [0, 1].map(|k| mean.pair.scales[k] * total(&self.fitter.values(mean.pair.lobes[k])));
        let whole = parts[0] + parts[1];
        let first = if whole > 0.0 { parts[0] / whole } else { 1.0 };
        let fraction_1 = self.fraction(&self.statistics.u);
        // Lobes that together reflect what is kept of the simulated total.
        let scale = reflected / whole.max(f64::MIN_POSITIVE);
        let mut shape = vec![0.0; AZIMUTHS];
        for k in 0..2 {
            for (sum, value) in shape.iter_mut().zip(self.fitter.values(mean.pair.lobes[k])) {
                *sum += scale * mean.pair.scales[k] * value;
            }
        }
        let kept = reflected / simulated.max(f64::MIN_POSITIVE);
        let steady = self.steady(&shape, mean.pair.lobes, fraction_1, kept);
        let steady = Steady { reflected: steady.reflected.clamp(0.0, reflected), ..steady };
        Node { mean, first, reflected, simulated, steady, coherent, fraction_1 }
    }

    fn mean(&self, u: &[f64]) -> PairFit {
        match (self.lobe, self.is_even) {
            (LobeForm::Pair, false) => self.fitter.fit_pair(self.phi_i, u),
            (LobeForm::Pair, true) => self.fitter.fit_even_pair(u),
            (LobeForm::Ggx, false) => self.fitter.fit(self.phi_i, u).into(),
            // By symmetry the azimuth is 0 there, even where two modes would pull it to one of them.
            (LobeForm::Ggx, true) => self.fitter.fit_m(0.0, u).into(),
        }
    }

    /// The steady part; `shape` is the fitted mean, `kept` the part of what was simulated that is not over all light.
    fn steady(&self, shape: &[f64], lobes: [Lobe; 2], fraction_1: f64, kept: f64) -> Steady {
        let alone = self.polarizations.len() == 1;
        let observed = self.polarizations.iter().map(|&p| {
            let share = match (alone, p) {
                (true, _) => 1.0,
                (false, 0) => 2.0 * fraction_1,
                (false, _) => 2.0 - 2.0 * fraction_1,
            };
            let scaled = |array: &[f32]| self.row(array, p).into_iter().map(|v| kept * v).collect();
            Observed {
                u: scaled(&self.statistics.u),
                v: scaled(&self.statistics.v),
                contrast2: self.row(&self.statistics.contrast, p).into_iter().map(|c| c * c).collect(),
                mean: shape.iter().map(|value| share * value).collect(),
            }
        });
        let node = steady::Node {
            fitter: self.fitter,
            cos_theta: self.cos_theta,
            phi_i: self.phi_i,
            is_even: self.is_even,
            instances: self.statistics.instances,
            // Without any, all azimuths count as one.
            correlation: length::correlation_length(self.statistics, self.node, self.polarizations)
                .unwrap_or(2.0),
            lobes: &lobes,
            observed: observed.collect(),
        };
        node.fit()
    }

    /// Polarization 1's part of the energy.
    fn fraction(&self, array: &[f32]) -> f64 {
        let [first, second] = [0, 1].map(|p| self.row(array, p).iter().sum::<f64>().max(0.0));
        if first + second > 0.0 { first / (first + second) } else { 0.5 }
    }
}

fn parameter_set(
    nodes: &[Node],
    lengths: &[length::Length],
    form: LobeForm,
    fractions: bool,
) -> ParameterSet {
    let gather = |value: &dyn Fn(&Node) -> f64| nodes.iter().map(|n| value(n) as f32).collect::<Vec<f32>>();
    let mean = |k: usize| LobeSet {
        m: gather(&|n| n.mean.pair.lobes[k].m),
        phi: gather(&|n| n.mean.pair.lobes[k].phi),
        reflected: gather(&|n| n.reflected * if k == 0 { n.first } else { 1.0 - n.first }),
    };
    let lobes = if form == LobeForm::Pair { 2 } else { 1 };
    ParameterSet {
        mean: (0..lobes).map(mean).collect(),
        steady: LobeSet {
            m: gather(&|n| n.steady.lobe.m),
            phi: gather(&|n| n.steady.lobe.phi),
            reflected: gather(&|n| n.steady.reflected),
        },
        length: lengths.iter().map(|l| l.fitted as f32).collect(),
        fraction_1: if fractions { gather(&|n| n.fraction_1) } else { Vec::new() },
        steady_fraction_1: if fractions { gather(&|n| n.steady.fraction_1) } else { Vec::new() },
    }
}

#[cfg(test)]
mod tests;
