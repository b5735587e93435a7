//! From the statistics of a campaign to a material.

use rayon::prelude::*;

pub use super::fitted::{Fitted, fitted, fitted_scale};
pub use super::patterns::Pattern;
pub use super::report::{Clipped, FitReport, Flagged, GrazingDirection, LARGEST_RESIDUAL};
pub use super::spectral::SpectralErrors;

use super::fitted::{fitted_on_azimuths, place, scale_of, shares_of};
use super::fitted_node::FittedNode;
use super::length::{self, Length};
use super::material::{
    FeatherMaterial, LobeSet, ParameterSet, STEEPEST_FRACTION, SteadySet, achromatic_lengths, check_sigma,
};
use super::noise::{Spectral, spectrum};
use super::slope::{self, Contrasts, Slope};
use super::steady::{self, Observed, Steady};
use super::{correlation, report, spectral};
use crate::progress::Progress;
use crate::scattering::directions;
use crate::scattering::lobe::{FitKind, Fitter, PairFit};
use crate::scattering::statistics::{AZIMUTHS, GLINTS, LAGS, Sides, Statistics};
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
    /// Whether the material is to have a halo, which no statistics hold: who makes it sees to that.
    pub halo: bool,
    /// Whether both incident polarizations keep sets of their own.
    pub polarized: bool,
    /// Seed of the material's noise.
    pub seed: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            kind: FitKind::Marginal,
            lobe: LobeForm::Pair,
            sigma: 0.04,
            halo: false,
            polarized: false,
            seed: 1,
        }
    }
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
    let lengths: Vec<Vec<Length>> = chosen.iter().map(|of| length::lengths(statistics, of)).collect();
    let contrasts = Contrasts::new(statistics.instances_of_a_place());
    let task = Task { statistics, options, fitters: &fitters, contrasts };
    let mut lights = chosen
        .iter()
        .zip(&lengths)
        .map(|(polarizations, lengths)| task.light(polarizations, lengths, progress))
        .collect::<Result<Vec<_>>>()?;
    // Slopes first beside speckle alone; then, as steady parts even out some of what they do, beside those.
    let mut slopes = Vec::new();
    for _ in 0..2 {
        slopes = task.slopes(&lights);
        lights.iter_mut().for_each(|light| task.steady(light, &slopes));
    }
    let sets: Vec<ParameterSet> = lights.iter().map(|light| parameter_set(light, options.lobe)).collect();
    let nodes: Vec<FittedNode> = lights.into_iter().flat_map(|light| light.nodes).collect();
    let mut material = FeatherMaterial {
        achromatic_length: achromatic_lengths(axes, &sets),
        axes: axes.clone(),
        kind: options.kind,
        sigma: options.sigma,
        halo: None,
        sets,
        correlation: Vec::new(),
        steepness: slopes.iter().map(|slope| slope.steepness as f32).collect(),
        strength: slopes.iter().map(|slope| slope.strength as f32).collect(),
        spectral: Spectral::default(),
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
    let spectral_errors = tell_wavelengths_apart(statistics, &mut material, &fitters);
    let report = report::report(statistics, &material, &nodes, &lengths.concat(), spectral_errors);
    Ok((material, report))
}

/// Gives a material its spectral noise; what of the correlations that were found it does not show.
fn tell_wavelengths_apart(
    statistics: &Statistics,
    material: &mut FeatherMaterial,
    fitters: &[Fitter],
) -> SpectralErrors {
    if statistics.instances < steady::FEWEST || statistics.glints.is_empty() {
        return SpectralErrors::default();
    }
    let (found, errors) = spectral::solved(statistics, material, fitters);
    material.spectral = found;
    errors
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
    let (glints, expected) = (statistics.glints.len(), nodes * GLINTS.len() * statistics.instances);
    if glints != 0 && glints != expected {
        return Err(Error::input(format!("glints has {glints} values, but the axes ask for {expected}")));
    }
    let finite = |values: &[f32]| values.iter().all(|v| v.is_finite());
    let Statistics { u, v, autocovariance, contrast, glints, .. } = statistics;
    if ![u, v, autocovariance, contrast, glints].into_iter().all(|v| finite(v)) {
        return Err(Error::not_settled(
            "the statistics hold values that are not finite, so nothing can be fitted",
        ));
    }
    Ok(())
}

/// κ and g follow from this many wavelengths at most.
const SLOPE_WAVES: usize = 9;

/// What all nodes of a fit share.
struct Task<'a> {
    statistics: &'a Statistics,
    options: &'a FitOptions,
    /// By θ_i.
    fitters: &'a [Fitter],
    contrasts: Contrasts,
}

/// The fits of one kind of light.
struct Light<'a> {
    polarizations: Chosen,
    lengths: &'a [Length],
    nodes: Vec<FittedNode>,
}

impl Task<'_> {
    /// Fits the mean of all nodes; there is no steady part yet.
    fn light<'a>(
        &self,
        polarizations: Chosen,
        lengths: &'a [Length],
        progress: &dyn Progress,
    ) -> Result<Light<'a>> {
        let axes = &self.statistics.axes;
        let phis = axes.phis();
        let rows: Vec<Vec<FittedNode>> = (0..axes.wavelengths_nm().len() * axes.cos_theta().len())
            .into_par_iter()
            .map(|row| {
                let nodes = row * phis..(row + 1) * phis;
                let nodes = nodes.map(|node| self.node(node, polarizations).fit()).collect();
                progress.advance(phis as u64);
                if progress.is_cancelled() { Err(Error::interrupted()) } else { Ok(nodes) }
            })
            .collect::<Result<_>>()?;
        Ok(Light { polarizations, lengths, nodes: rows.into_iter().flatten().collect() })
    }

    /// Fits the steady part of all nodes beside slopes.
    fn steady(&self, light: &mut Light, slopes: &[Slope]) {
        let Light { polarizations, lengths, nodes } = light;
        nodes.par_iter_mut().zip(*lengths).enumerate().for_each(|(at, (node, length))| {
            let slope = slopes[at % slopes.len()];
            let part = |sum| slope.part(sum, 1.0 / length.fitted);
            node.steady = self.node(at, polarizations).steady(node, &part);
        });
    }

    fn node(&self, node: usize, polarizations: Chosen) -> NodeFit<'_> {
        let axes = &self.statistics.axes;
        let [_, theta, phi] = place(axes, node);
        NodeFit {
            statistics: self.statistics,
            contrasts: &self.contrasts,
            node,
            polarizations,
            lobe: self.options.lobe,
            fitter: &self.fitters[theta],
            cos_theta: axes.cos_theta()[theta],
            phi_i: axes.phi_i(phi),
            is_even: axes.sides() == Sides::Alike && axes.cos_phi()[axes.cosine_of(phi)] > 1.0 - 1e-12,
        }
    }

    /// κ and g of each direction. Shape `[θ_i, φ_i]`.
    fn slopes(&self, lights: &[Light]) -> Vec<Slope> {
        let axes = &self.statistics.axes;
        let (waves, directions) = (axes.wavelengths_nm().len(), axes.cos_theta().len() * axes.phis());
        if self.statistics.instances_of_a_place() < steady::FEWEST {
            return vec![Slope::default(); directions];
        }
        (0..directions)
            .into_par_iter()
            .map(|direction| {
                let observed: Vec<slope::Observed> = (direction..axes.len())
                    .step_by(directions * waves.div_ceil(SLOPE_WAVES))
                    .flat_map(|node| {
                        lights.iter().flat_map(move |Light { polarizations, lengths, nodes }| {
                            self.node(node, polarizations).observed(&nodes[node], &lengths[node])
                        })
                    })
                    .collect();
                slope::solved(&self.contrasts, &observed)
            })
            .collect()
    }
}

/// One (λ, ω_i) of the statistics.
struct NodeFit<'a> {
    statistics: &'a Statistics,
    contrasts: &'a Contrasts,
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

    /// The mean.
    fn fit(&self) -> FittedNode {
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
        let fraction_1 = self.first_part();
        let steady = Steady::none(mean.pair.lobes[0]);
        FittedNode { mean, first, reflected, simulated, steady, coherent, fraction_1 }
    }

    /// The fitted mean intensity, which reflects what is kept of the simulated total.
    fn shape(&self, node: &FittedNode) -> Vec<f64> {
        let mut shape = vec![0.0; AZIMUTHS];
        for (lobe, part) in node.mean.pair.lobes.into_iter().zip([node.first, 1.0 - node.first]) {
            let values = self.fitter.values(lobe);
            let scale = scale_of(&values, self.cos_theta, part * node.reflected);
            shape.iter_mut().zip(values).for_each(|(sum, value)| *sum += scale * value);
        }
        shape
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

    /// ω_i + ω_o of all azimuths, x and z.
    fn sums(&self) -> impl Iterator<Item = [f64; 2]> {
        let of = |trig: fn(f64) -> f64, phi_o: f64| self.cos_theta * (trig(self.phi_i) + trig(phi_o));
        directions::azimuths(AZIMUTHS).map(move |phi_o| [of(libm::sin, phi_o), of(libm::cos, phi_o)])
    }

    /// The steady part of a node beside slopes whose g h is `part` of ω_i + ω_o.
    fn steady(&self, node: &FittedNode, part: &dyn Fn([f64; 2]) -> f64) -> Steady {
        let shape = self.shape(node);
        let observed = self.polarizations.iter().map(|&p| Observed {
            u: self.row(&self.statistics.u, p),
            v: self.row(&self.statistics.v, p),
            contrast2: self.squares(p),
            mean: shape
                .iter()
                .zip(self.shares(node.fraction_1, p))
                .map(|(value, share)| share * value)
                .collect(),
        });
        // Without any, all azimuths count as one.
        let correlation =
            length::correlation_length(self.statistics, self.node, self.polarizations).unwrap_or(2.0);
        let kept = steady::of_kept_energy(&shape, self.cos_theta, correlation);
        let expected = |sum| {
            let [speckle, alone] = self.contrasts.at(part(sum));
            [kept * speckle, alone]
        };
        let problem = steady::Node {
            fitter: self.fitter,
            cos_theta: self.cos_theta,
            phi_i: self.phi_i,
            is_even: self.is_even,
            instances: self.statistics.instances_of_a_place(),
            correlation,
            lobes: &node.mean.pair.lobes,
            expected: self.sums().map(expected).collect(),
            observed: observed.collect(),
        };
        problem.fit()
    }

    /// C² of one polarization.
    fn squares(&self, polarization: usize) -> Vec<f64> {
        self.row(&self.statistics.contrast, polarization).into_iter().map(|c| c * c).collect()
    }

    /// What κ and g are found from.
    fn observed(&self, node: &FittedNode, length: &Length) -> Vec<slope::Observed> {
        let steady = self.fitter.steady_shares(node.steady.lobe);
        let of = |&p: &usize| {
            let square = |steady: &f64| (node.steady.share * steady).powi(2);
            let found = self.squares(p).into_iter().zip(&steady).map(|(c2, steady)| [c2, square(steady)]);
            let azimuths = directions::azimuths(AZIMUTHS).zip(found);
            slope::Observed::new([self.cos_theta, self.phi_i], 1.0 / length.fitted, azimuths)
        };
        self.polarizations.iter().map(of).collect()
    }

    /// What the set's values are multiplied by to be those of a polarization, on azimuths.
    fn shares(&self, fraction_1: [f64; 2], polarization: usize) -> Vec<f64> {
        if self.polarizations.len() == 1 {
            return vec![1.0; AZIMUTHS];
        }
        shares_of(fraction_1, polarization, self.phi_i, directions::azimuths(AZIMUTHS)).collect()
    }

    /// Polarization 1's part of the light over the slope of the facet that mirrors: the straight line of least squares, weighted by
    /// the light, which keeps the part of all of it; a constant where no line stays between 0 and 1 in the mirror direction.
    fn first_part(&self) -> [f64; 2] {
        let [first, second] = [0, 1].map(|p| self.row(&self.statistics.u, p));
        let (mut weights, mut values) = ([0.0; 3], [0.0; 2]);
        for ((phi_o, first), second) in directions::azimuths(AZIMUTHS).zip(first).zip(second) {
            let t = libm::tan(0.5 * (self.phi_i + phi_o)).clamp(-1.0, 1.0);
            let (first, both) = (first.max(0.0), first.max(0.0) + second.max(0.0));
            weights.iter_mut().zip([1.0, t, t * t]).for_each(|(sum, power)| *sum += both * power);
            values.iter_mut().zip([1.0, t]).for_each(|(sum, power)| *sum += first * power);
        }
        let [whole, by_t, by_t2] = weights;
        if whole <= 0.0 {
            return [0.5, 0.0];
        }
        let constant = [values[0] / whole, 0.0];
        let spread = whole * by_t2 - by_t * by_t;
        if self.is_even || spread <= 1e-9 * whole * whole {
            return constant;
        }
        let slope = (whole * values[1] - by_t * values[0]) / spread;
        let slope = slope.clamp(-STEEPEST_FRACTION, STEEPEST_FRACTION);
        let fraction = (values[0] - slope * by_t) / whole;
        if (0.0..=1.0).contains(&fraction) { [fraction, slope] } else { constant }
    }
}

fn parameter_set(light: &Light, form: LobeForm) -> ParameterSet {
    let Light { polarizations, lengths, nodes } = light;
    let fractions = polarizations.len() == 2;
    let gather =
        |value: &dyn Fn(&FittedNode) -> f64| nodes.iter().map(|n| value(n) as f32).collect::<Vec<f32>>();
    let mean = |k: usize| LobeSet {
        m: gather(&|n| n.mean.pair.lobes[k].m),
        phi: gather(&|n| n.mean.pair.lobes[k].phi),
        reflected: gather(&|n| n.reflected * if k == 0 { n.first } else { 1.0 - n.first }),
    };
    let lobes = if form == LobeForm::Pair { 2 } else { 1 };
    ParameterSet {
        mean: (0..lobes).map(mean).collect(),
        steady: SteadySet {
            m: gather(&|n| n.steady.lobe.m),
            phi: gather(&|n| n.steady.lobe.phi),
            share: gather(&|n| n.steady.share),
        },
        length: lengths.iter().map(|l| l.fitted as f32).collect(),
        fraction_1: if fractions { gather(&|n| n.fraction_1[0]) } else { Vec::new() },
        fraction_1_slope: if fractions { gather(&|n| n.fraction_1[1]) } else { Vec::new() },
    }
}

#[cfg(test)]
mod tests;
