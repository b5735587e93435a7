//! What a material says at the nodes of its tables: the one place that turns parameters into intensities per azimuth.

use super::material::{FeatherMaterial, LobeSet, ParameterSet, SteadySet, part_of_first};
use crate::scattering::directions;
use crate::scattering::lobe::{FitKind, Fitter, Lobe};
use crate::scattering::statistics::{AZIMUTHS, Axes};

/// Wavelength in nm and θ_i, φ_i in degrees of a node.
pub(super) fn direction(axes: &Axes, node: usize) -> (f64, f64, f64) {
    let [wave, theta, phi] = place(axes, node);
    (axes.wavelengths_nm()[wave], axes.theta_i(theta).to_degrees(), axes.phi_i(phi).to_degrees())
}

/// Which λ, θ_i and φ_i a node is.
pub(super) fn place(axes: &Axes, node: usize) -> [usize; 3] {
    let (phis, thetas) = (axes.phis(), axes.cos_theta().len());
    [node / phis / thetas, node / phis % thetas, node % phis]
}

/// What a material's node sends to azimuths on the specular cone in one incident polarization, 1/rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// Mean intensity U'.
    pub mean: Vec<f64>,
    /// The part of it that does not fluctuate, at most the mean.
    pub steady: Vec<f64>,
    /// How much of it goes with the barbule's own slope: g h in τ = 1 + g h (E − 1).
    pub sloped: Vec<f64>,
}

/// Mean and steady intensity of node number `node` of the tables at the azimuths φ_o, rad, by incident polarization.
#[must_use]
pub fn fitted(material: &FeatherMaterial, node: usize, phi_o: &[f64]) -> [Fitted; 2] {
    let [_, theta, _] = place(&material.axes, node);
    let theta_i = material.axes.theta_i(theta);
    let fitter = Fitter::new(material.kind, theta_i, AZIMUTHS);
    let kind = material.kind;
    assemble(
        material,
        node,
        &fitter,
        phi_o,
        &|lobe: Lobe| phi_o.iter().map(|phi| lobe.shape(kind, theta_i, *phi)).collect(),
        &|lobe: Lobe| phi_o.iter().map(|phi| lobe.steady_share(*phi)).collect(),
    )
}

/// The same on the azimuths of U, with the fitter of the node's θ_i.
pub(super) fn fitted_on_azimuths(material: &FeatherMaterial, node: usize, fitter: &Fitter) -> [Fitted; 2] {
    let phi_o: Vec<f64> = directions::azimuths(AZIMUTHS).collect();
    assemble(material, node, fitter, &phi_o, &|lobe| fitter.values(lobe), &|lobe| fitter.steady_shares(lobe))
}

fn assemble(
    material: &FeatherMaterial,
    node: usize,
    fitter: &Fitter,
    phi_o: &[f64],
    shape: &dyn Fn(Lobe) -> Vec<f64>,
    steady_share: &dyn Fn(Lobe) -> Vec<f64>,
) -> [Fitted; 2] {
    let [_, theta, phi_at] = place(&material.axes, node);
    let (cos_theta, phi_i) = (material.axes.cos_theta()[theta], material.axes.phi_i(phi_at));
    let of_set = |number: usize| {
        let set = &material.sets[number];
        let mut mean = Vec::new();
        for lobe in &set.mean {
            let (at, reflected) = lobe_at(lobe, node);
            let scale = scale_of(&fitter.values(at), cos_theta, reflected);
            let values = shape(at);
            mean.resize(values.len(), 0.0);
            for (sum, value) in mean.iter_mut().zip(values) {
                *sum += scale * value;
            }
        }
        let SteadySet { m, phi, share } = &set.steady;
        let at = Lobe { m: f64::from(m[node]), phi: f64::from(phi[node]) };
        let share = f64::from(share[node]);
        let steady =
            steady_share(at).into_iter().zip(&mean).map(|(part, mean)| share * part * mean).collect();
        let (slope, inverse_length) = (material.slope(node), material.inverse_length(set, node));
        let sum = |trig: fn(f64) -> f64, phi_o: f64| cos_theta * (trig(phi_i) + trig(phi_o));
        let h = |&phi_o: &f64| slope.part([sum(libm::sin, phi_o), sum(libm::cos, phi_o)], inverse_length);
        Fitted { mean, steady, sloped: phi_o.iter().map(h).collect() }
    };
    let sets: Vec<Fitted> = (0..material.sets.len()).map(of_set).collect();
    [0, 1].map(|polarization| {
        let number = polarization.min(material.sets.len() - 1);
        let set = &material.sets[number];
        let Fitted { mean, steady, sloped } = &sets[number];
        let shares = polarization_shares(set, node, polarization, phi_i, phi_o);
        let scaled =
            |values: &[f64]| values.iter().zip(&shares).map(|(value, share)| value * share).collect();
        Fitted { mean: scaled(mean), steady: scaled(steady), sloped: sloped.clone() }
    })
}

/// What a set's values are multiplied by to be those of one polarization (0: the first), at the azimuths φ_o.
fn polarization_shares(
    set: &ParameterSet,
    node: usize,
    polarization: usize,
    phi_i: f64,
    phi_o: &[f64],
) -> Vec<f64> {
    match (set.fraction_1.get(node), set.fraction_1_slope.get(node)) {
        (Some(&fraction), Some(&slope)) => {
            let parts = [fraction, slope].map(f64::from);
            shares_of(parts, polarization, phi_i, phi_o.iter().copied()).collect()
        }
        _ => vec![1.0; phi_o.len()],
    }
}

/// 2 f or 2 − 2 f with polarization 1's part f, at azimuths.
pub(super) fn shares_of(
    parts: [f64; 2],
    polarization: usize,
    phi_i: f64,
    phi_o: impl Iterator<Item = f64>,
) -> impl Iterator<Item = f64> {
    phi_o.map(move |phi_o| {
        let first = part_of_first(parts, libm::tan(0.5 * (phi_i + phi_o)));
        2.0 * if polarization == 0 { first } else { 1.0 - first }
    })
}

fn lobe_at(set: &LobeSet, node: usize) -> (Lobe, f64) {
    let lobe = Lobe { m: f64::from(set.m[node]), phi: f64::from(set.phi[node]) };
    (lobe, f64::from(set.reflected[node]))
}

/// The factor on a lobe's shape with which it reflects `reflected`.
#[must_use]
pub fn fitted_scale(kind: FitKind, lobe: Lobe, theta_i: f64, reflected: f64) -> f64 {
    let shape = Fitter::new(kind, theta_i, AZIMUTHS).values(lobe);
    scale_of(&shape, libm::cos(theta_i), reflected)
}

/// The factor on a shape on the azimuths with which it reflects `reflected`.
pub(super) fn scale_of(shape: &[f64], cos_theta: f64, reflected: f64) -> f64 {
    let step = std::f64::consts::PI / shape.len().max(1) as f64;
    reflected / (cos_theta * step * shape.iter().sum::<f64>()).max(f64::MIN_POSITIVE)
}
