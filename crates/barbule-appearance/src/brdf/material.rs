//! The tables of a feather material, as a file holds them.

use super::halo::Halo;
use super::noise::{Noise, Spectral};
use super::slope::{STEEPNESS, Slope};
use crate::scattering::lobe::{FitKind, SMALLEST_M};
use crate::scattering::statistics::{Axes, NOISE_POINTS};
use crate::spectrum::Wavelengths;
use crate::{Error, Result};

/// Power terms P₁ … P_{N/2−1} of the noise process; P₀ and P_{N/2} are zero and the rest mirrors these.
pub const NOISE_TERMS: usize = NOISE_POINTS / 2 - 1;

/// One lobe for every (λ, θ_i, φ_i): arrays of shape `[λ, θ_i, φ_i]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LobeSet {
    /// Roughness, in \[0.001, 1\].
    pub m: Vec<f32>,
    /// Effective azimuth, rad, in (−π/2, π/2).
    pub phi: Vec<f32>,
    /// Reflected fraction ρ = cosθ_i ∫ U dφ_o of this lobe, in \[0, 1\].
    pub reflected: Vec<f32>,
}

/// What part of the mean does not fluctuate: [`Lobe::steady_share`](crate::scattering::lobe::Lobe::steady_share) of a lobe, times
/// what it is at the lobe's middle. Arrays of shape `[λ, θ_i, φ_i]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SteadySet {
    /// Roughness of the lobe, in \[0.001, 1\]: 1 where the part is the same at all azimuths.
    pub m: Vec<f32>,
    /// Its effective azimuth, rad, in (−π/2, π/2).
    pub phi: Vec<f32>,
    /// The part of the mean in its middle, in \[0, 1\].
    pub share: Vec<f32>,
}

/// The parameters of one kind of light: unpolarized, or one incident polarization.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParameterSet {
    /// The mean intensity is the sum of these lobes: two, or a single one. The second may reflect nothing.
    pub mean: Vec<LobeSet>,
    /// What of it does not fluctuate from instance to instance.
    pub steady: SteadySet,
    /// Length l of S.26 relative to the shortest wavelength at normal incidence. Shape `[λ, θ_i, φ_i]`.
    pub length: Vec<f32>,
    /// Part of incident polarization 1 in the mean, in the mirror direction; empty in a set of one polarization.
    pub fraction_1: Vec<f32>,
    /// How fast it changes with the slope t of the facet that mirrors, which decides the angle of incidence: it is
    /// F + slope · t, within 0 and 1, with t within ±1. Length of `fraction_1`.
    pub fraction_1_slope: Vec<f32>,
}

/// A feather material: everything that a renderer needs, and where it came from.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatherMaterial {
    /// Wavelengths and directions of the tables.
    pub axes: Axes,
    /// How the lobes were fitted.
    pub kind: FitKind,
    /// Longitudinal spread σ that applies unless the user gives another: with a halo, of the narrow part.
    pub sigma: f64,
    /// What leaves beside the narrow part, where segments in three dimensions were simulated.
    pub halo: Option<Halo>,
    /// One set (unpolarized light), or two (incident polarizations 1 and 2).
    pub sets: Vec<ParameterSet>,
    /// Correlation γ, in \[0, 1\], of the noise that both incident polarizations carry. Shape `[λ, θ_i, φ_i]`.
    pub correlation: Vec<f32>,
    /// κ of each direction: how fast a barbule's own slope tells, over the length l. Shape `[θ_i, φ_i]`.
    pub steepness: Vec<f32>,
    /// g of each direction: how much it tells at most, 0 to 1. Shape of `steepness`.
    pub strength: Vec<f32>,
    /// Length l that all wavelengths share in the instances whose pattern is the same at all of them:
    /// [`achromatic_lengths`] of the sets. Shape of `steepness`.
    pub achromatic_length: Vec<f32>,
    /// How instances differ from wavelength to wavelength.
    pub spectral: Spectral,
    /// P₁ … P_{N/2−1} of the noise process (S.34), Σ = ½. Length [`NOISE_TERMS`].
    pub noise_power: Vec<f64>,
    /// Seed of the noise that is drawn from `noise_power` when the material is prepared.
    pub seed: u64,
    /// Species, variant, parameters of generator and simulation, residuals: whatever the maker recorded.
    pub info: serde_json::Value,
}

/// No material has more wavelengths than this: each takes 0.2 to 0.8 MB of tables however few directions it has.
const MOST_WAVELENGTHS: usize = 512;

/// No material has more table nodes than this.
const MOST_NODES: usize = 4_000_000;

impl FeatherMaterial {
    /// Checks shapes, ranges and finiteness; the message names the array and the index.
    ///
    /// # Errors
    /// Anything that a renderer could not use.
    pub fn check(&self) -> Result<()> {
        check_axes(&self.axes)?;
        let nodes = self.axes.len();
        check_sigma(self.sigma)?;
        self.halo.as_ref().map_or(Ok(()), Halo::check)?;
        if !(1..=2).contains(&self.sets.len()) {
            return Err(Error::input(format!("{} parameter sets, but 1 or 2 are possible", self.sets.len())));
        }
        check_range("correlation", &self.correlation, nodes, 0.0, 1.0)?;
        let directions = nodes / self.axes.wavelengths_nm().len();
        check_range("steepness", &self.steepness, directions, STEEPNESS.0, STEEPNESS.1)?;
        check_range("strength", &self.strength, directions, 0.0, 1.0)?;
        check_range("achromatic_length", &self.achromatic_length, directions, LENGTHS.0, LENGTHS.1)?;
        self.spectral.check()?;
        for (number, set) in self.sets.iter().enumerate() {
            let place = if self.sets.len() == 1 { String::new() } else { format!("p{}.", number + 1) };
            set.check(&place, nodes, self.sets.len() == 1)?;
        }
        check_range("noise_power", &self.noise_power, NOISE_TERMS, 0.0, 0.5 + 1e-6)?;
        let sum: f64 = self.noise_power.iter().sum();
        if (sum - 0.5).abs() > 1e-4 {
            return Err(Error::input(format!(
                "noise_power sums to {sum:.6}, but a process of unit variance has 0.5; fit the material again"
            )));
        }
        Ok(())
    }

    /// The same material with only those wavelengths of its tables that decide what it does at the given ones, nm: their
    /// neighbours on both sides. Prepared in a fraction of the time.
    ///
    /// # Errors
    /// The arrays do not fit the axes ([`FeatherMaterial::check`]).
    pub fn around(&self, wavelengths_nm: &[f64]) -> Result<Self> {
        self.check()?;
        let nodes = self.axes.wavelengths_nm();
        let last = nodes.len() - 1;
        let mut kept: Vec<usize> = wavelengths_nm
            .iter()
            .flat_map(|nm| {
                let above = nodes.partition_point(|node| node <= nm).clamp(1, last.max(1));
                [above - 1, above.min(last)]
            })
            .collect();
        kept.sort_unstable();
        kept.dedup();
        let size = self.axes.len() / nodes.len();
        let part = |values: &Vec<f32>| -> Vec<f32> {
            let layers = kept.iter().filter_map(|wave| values.get(wave * size..(wave + 1) * size));
            layers.flatten().copied().collect()
        };
        let lobe = |lobe: &LobeSet| LobeSet {
            m: part(&lobe.m),
            phi: part(&lobe.phi),
            reflected: part(&lobe.reflected),
        };
        let set = |set: &ParameterSet| ParameterSet {
            mean: set.mean.iter().map(lobe).collect(),
            steady: SteadySet {
                m: part(&set.steady.m),
                phi: part(&set.steady.phi),
                share: part(&set.steady.share),
            },
            length: part(&set.length),
            fraction_1: part(&set.fraction_1),
            fraction_1_slope: part(&set.fraction_1_slope),
        };
        let wavelengths = Wavelengths::new(kept.iter().map(|wave| nodes[*wave]).collect::<Vec<_>>())?;
        let axes = Axes::new(&wavelengths, self.axes.cos_theta().to_vec(), self.axes.cos_phi().to_vec())?;
        Ok(Self {
            axes: axes.with_sides(self.axes.sides()),
            sets: self.sets.iter().map(set).collect(),
            correlation: part(&self.correlation),
            steepness: self.steepness.clone(),
            strength: self.strength.clone(),
            achromatic_length: self.achromatic_length.clone(),
            noise_power: self.noise_power.clone(),
            info: self.info.clone(),
            halo: self.halo.clone(),
            ..*self
        })
    }
}

impl FeatherMaterial {
    /// How slopes tell at a node of the tables.
    pub(super) fn slope(&self, node: usize) -> Slope {
        let of = |values: &[f32]| f64::from(values[node % values.len()]);
        Slope {
            steepness: of(&self.steepness),
            strength: of(&self.strength),
            achromatic_inverse_length: 1.0 / of(&self.achromatic_length),
        }
    }

    /// 1/l with which the chromatic instances of a set look up noise at a node.
    pub(super) fn inverse_length(&self, set: &ParameterSet, node: usize) -> f64 {
        let common = self.achromatic_length[node % self.achromatic_length.len()];
        1.0 / chromatic_length(f64::from(set.length[node]), f64::from(common), self.spectral.achromatic)
    }

    /// The noise that tells its instances apart.
    #[must_use]
    pub fn noise(&self) -> Noise {
        Noise::new(&self.noise_power, self.spectral, self.seed)
    }
}

/// Geometric means of the lengths l of all wavelengths and sets, by direction. Shape `[θ_i, φ_i]`; the arrays of the sets are as
/// long as the axes ask.
#[must_use]
pub fn achromatic_lengths(axes: &Axes, sets: &[ParameterSet]) -> Vec<f32> {
    let directions = axes.len() / axes.wavelengths_nm().len();
    let mean = |direction: usize| {
        let of = |set: &ParameterSet| -> Vec<f64> {
            set.length.iter().skip(direction).step_by(directions).map(|l| libm::log(f64::from(*l))).collect()
        };
        let logarithms: Vec<f64> = sets.iter().flat_map(of).collect();
        let mean = logarithms.iter().sum::<f64>() / logarithms.len().max(1) as f64;
        (libm::exp(mean) as f32).clamp(LENGTHS.0, LENGTHS.1)
    };
    (0..directions).map(mean).collect()
}

/// The length with which chromatic instances must stretch so that they and a share of achromatic ones have the measured one together:
/// both kinds' covariances, taken as Gaussian, sum to 1/e there.
pub(super) fn chromatic_length(measured: f64, achromatic: f64, share: f64) -> f64 {
    if share == 0.0 {
        return measured;
    }
    let common = share * libm::exp(-(measured / achromatic).powi(2));
    let rest = ((libm::exp(-1.0) - common) / (1.0 - share).max(1e-3)).clamp(0.05, 0.8);
    let length = measured / (-libm::log(rest)).sqrt();
    length.clamp(f64::from(LENGTHS.0), f64::from(LENGTHS.1))
}

/// The codes of a file round two fractions that sum to 1 to this at most.
const MOST_REFLECTED: f64 = 1.0 + 1e-4;

/// |slope| of polarization 1's part, at most.
pub const STEEPEST_FRACTION: f64 = 4.0;

/// Polarization 1's part of the mean where a facet of the slope `t` mirrors; beyond 45° it is as there.
#[inline(always)]
pub(super) fn part_of_first([fraction, slope]: [f64; 2], t: f64) -> f64 {
    (fraction + slope * t.clamp(-1.0, 1.0)).clamp(0.0, 1.0)
}

impl ParameterSet {
    /// The reflected fraction of a node: that of all its mean lobes.
    #[must_use]
    pub fn reflected(&self, node: usize) -> f64 {
        self.mean.iter().map(|lobe| f64::from(lobe.reflected[node])).sum()
    }

    fn check(&self, place: &str, nodes: usize, fractions: bool) -> Result<()> {
        let check = |name: &str, values: &[f32], low: f32, high: f32| {
            check_range(&format!("{place}{name}"), values, nodes, low, high)
        };
        let right = std::f32::consts::FRAC_PI_2;
        if !(1..=2).contains(&self.mean.len()) {
            return Err(Error::input(format!("{} mean lobes, but 1 or 2 are possible", self.mean.len())));
        }
        for (lobe, suffix) in self.mean.iter().zip(["", "_2"]) {
            check(&format!("m{suffix}"), &lobe.m, 0.999 * SMALLEST_M as f32, 1.0)?;
            check(&format!("phi{suffix}"), &lobe.phi, -right, right)?;
            check(&format!("rho{suffix}"), &lobe.reflected, 0.0, 1.0)?;
        }
        let SteadySet { m, phi, share } = &self.steady;
        check("m_sta", m, 0.999 * SMALLEST_M as f32, 1.0)?;
        check("phi_sta", phi, -right, right)?;
        check("share_sta", share, 0.0, 1.0)?;
        if let Some(at) = (0..nodes).find(|&node| self.reflected(node) > MOST_REFLECTED) {
            return Err(Error::input(format!(
                "{place}rho[{at}] and {place}rho_2[{at}] sum to {}, more than all light; the file is damaged, fit the material again",
                self.reflected(at)
            )));
        }
        check("length", &self.length, LENGTHS.0, LENGTHS.1)?;
        let nodes = if fractions { nodes } else { 0 };
        check_range(&format!("{place}fraction_1"), &self.fraction_1, nodes, 0.0, 1.0)?;
        let steepest = STEEPEST_FRACTION as f32;
        check_range(&format!("{place}fraction_1_slope"), &self.fraction_1_slope, nodes, -steepest, steepest)
    }
}

/// Lengths l that a material may have.
pub(super) const LENGTHS: (f32, f32) = (1.0 / 64.0, 64.0);

/// Refuses axes that no material can have.
///
/// # Errors
/// An axis is empty, out of range or does not rise; more than 512 wavelengths or 4,000,000 nodes.
pub fn check_axes(axes: &Axes) -> Result<()> {
    check_each_axis(axes.wavelengths_nm(), axes.cos_theta(), axes.cos_phi())?;
    let nodes = axes.len();
    if nodes > MOST_NODES {
        return Err(Error::input(format!(
            "the tables have {nodes} nodes, over the limit of {MOST_NODES}; simulate fewer wavelengths or directions"
        )));
    }
    let waves = axes.wavelengths_nm().len();
    if waves > MOST_WAVELENGTHS {
        return Err(Error::input(format!(
            "wavelengths_nm has {waves} values, over the limit of {MOST_WAVELENGTHS}; simulate fewer wavelengths"
        )));
    }
    Ok(())
}

/// The axes of a material's tables, by the names that files give them.
///
/// # Errors
/// As [`check_axes`].
pub fn table_axes(wavelengths_nm: Vec<f64>, cos_theta: Vec<f64>, cos_phi: Vec<f64>) -> Result<Axes> {
    check_each_axis(&wavelengths_nm, &cos_theta, &cos_phi)?;
    let axes = Axes::new(&Wavelengths::new(wavelengths_nm)?, cos_theta, cos_phi)?;
    check_axes(&axes)?;
    Ok(axes)
}

fn check_each_axis(wavelengths_nm: &[f64], cos_theta: &[f64], cos_phi: &[f64]) -> Result<()> {
    check_axis("wavelengths_nm", wavelengths_nm, 100.0, 20_000.0)?;
    check_axis("cos_theta", cos_theta, 1e-6, 1.0)?;
    check_axis("cos_phi", cos_phi, 1e-6, 1.0)
}

/// Refuses a longitudinal spread that is too wide for the lobe's integral to hold, or too narrow to be seen.
///
/// # Errors
/// σ is outside 0.002 to 0.25.
pub fn check_sigma(sigma: f64) -> Result<()> {
    if (0.002..=0.25).contains(&sigma) {
        return Ok(());
    }
    Err(Error::input(format!("sigma is {sigma}, but must lie between 0.002 and 0.25 (0.04 is the default)")))
}

pub(super) fn check_axis(name: &str, values: &[f64], low: f64, high: f64) -> Result<()> {
    if values.is_empty() {
        return Err(Error::input(format!("{name} is empty, but needs at least one value")));
    }
    check_range(name, values, values.len(), low, high)?;
    match values.windows(2).position(|pair| pair[0] >= pair[1]) {
        Some(at) => Err(Error::input(format!(
            "{name}[{}] = {} does not exceed the value before it; sort the axis",
            at + 1,
            values[at + 1]
        ))),
        None => Ok(()),
    }
}

pub(super) fn check_range<T: Copy + PartialOrd + std::fmt::Display>(
    name: &str,
    values: &[T],
    count: usize,
    low: T,
    high: T,
) -> Result<()> {
    if values.len() != count {
        return Err(Error::input(format!(
            "{name} has {} values, but the axes ask for {count}",
            values.len()
        )));
    }
    match values.iter().position(|v| !(low <= *v && *v <= high)) {
        Some(at) => Err(Error::input(format!(
            "{name}[{at}] = {} is not in {low} to {high}; the file is damaged, fit the material again",
            values[at]
        ))),
        None => Ok(()),
    }
}
