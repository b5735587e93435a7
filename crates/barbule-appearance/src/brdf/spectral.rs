//! How instances differ from wavelength to wavelength, and as the light turns.
//!
//! Fields of one barbule at two wavelengths, or from two lights, carry the phases k(z_i + z_o) z of a rough top: the further these
//! are apart, the less the fields have in common. What the campaign kept of all instances near the mirror direction says how fast,
//! and that some of the pattern is the same at all wavelengths: where few facets face one direction, they are bright at any.
//! Both follow from the correlation of intensities of all instances,
//!
//! ```text
//! cov(I_a, I_b)/(Ī_a Ī_b) = E[τ_a τ_b] (1 + 2 √(s_a s_b (1−s_a)(1−s_b)) Γ + (1−s_a)(1−s_b) Γ²) − 1,
//! ```
//!
//! with the steady parts s of both, as [`super::correlation`] has it for polarizations; Γ is 1 in the share p of achromatic
//! instances, and C₀(x/l_a − x/l_b) exp(−(h Δk(z_i + z_o))²/2) in the others.

use super::fitted::{fitted_on_azimuths, place};
use super::length;
use super::material::{FeatherMaterial, chromatic_length};
use super::noise::Spectral;
use super::slope;
use crate::scattering::directions;
use crate::scattering::lobe::Fitter;
use crate::scattering::statistics::{AZIMUTHS, GLINTS, NOISE_POINTS, Statistics, glints};
use crate::spectrum::wave_number_per_um;

/// Wavelengths, θ_i and φ_i of which pairs are formed, at most.
const MOST: [usize; 3] = [8, 4, 6];

/// Light nearer to grazing is left out: most of it is steady.
const LEAST_COSINE: f64 = 0.3;

/// Directions with less of the lobe's peak are left out.
const LEAST_MEAN: f64 = 0.1;

/// Shares p that are tried, and heights h, µm.
const SHARES: [f64; 2] = [0.0, 0.6];
const HEIGHTS_UM: [f64; 2] = [0.005, 1.5];

/// Intensities of which a material's instances have less relative variance than this are steady there: they correlate with
/// nothing.
const LEAST_VARIANCE: f64 = 1e-6;

/// Steps along each, and how often they are made finer about the best.
const STEPS: usize = 13;
const ROUNDS: usize = 4;

/// Which wavelengths and lights a pair is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Two wavelengths in the mirror direction.
    Mirror,
    /// Two wavelengths beside it.
    Beside,
    /// Two lights in their mirror directions.
    Turned,
}

const KINDS: [Kind; 3] = [Kind::Mirror, Kind::Beside, Kind::Turned];

/// How well instances correlate between wavelengths and lights: mean of |synthesized − simulated| over pairs.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct SpectralErrors {
    /// Between wavelengths in the mirror direction.
    pub mirror: f64,
    /// Between wavelengths 4° and 12° beside it.
    pub beside: f64,
    /// Between lights in their mirror directions.
    pub turned: f64,
}

/// One end of a pair.
#[derive(Debug, Clone, Copy)]
struct End {
    /// Length of chromatic instances as it was measured, and of achromatic ones.
    length: f64,
    achromatic: f64,
    /// k(z_i + z_o), rad/µm.
    phase_per_um: f64,
    /// s/f̂ and g h.
    steady: f64,
    sloped: f64,
}

/// Two intensities.
#[derive(Debug, Clone, Copy)]
struct Pair {
    kind: Kind,
    ends: [End; 2],
    /// x_i + x_o.
    x: f64,
    /// The correlation that was found.
    found: f64,
}

/// h and the share of achromatic instances, and what remains between these and the campaign. The material has everything else.
pub(super) fn solved(
    statistics: &Statistics,
    material: &FeatherMaterial,
    fitters: &[Fitter],
) -> (Spectral, SpectralErrors) {
    let reference = length::reference(statistics);
    let pairs = pairs(statistics, material, fitters);
    let covariance = |lag: f64| length::interpolate(&reference, lag.abs() * 0.5 * NOISE_POINTS as f64);
    let errors = |spectral: Spectral| -> [f64; 3] {
        KINDS.map(|kind| {
            let of = pairs.iter().filter(|pair| pair.kind == kind);
            let apart = of.map(|pair| (pair.expected(spectral, &covariance) - pair.found).abs());
            mean(&apart.collect::<Vec<_>>())
        })
    };
    // Sums of squares settle on what most pairs say.
    let misfit = |spectral: Spectral| -> f64 {
        let of = |kind: Kind| {
            let of = pairs.iter().filter(|pair| pair.kind == kind);
            let apart = of.map(|pair| (pair.expected(spectral, &covariance) - pair.found).powi(2));
            mean(&apart.collect::<Vec<_>>())
        };
        KINDS.into_iter().map(of).sum()
    };
    let spectral = if pairs.is_empty() { Spectral::default() } else { best(misfit) };
    let [mirror, beside, turned] = errors(spectral);
    (spectral, SpectralErrors { mirror, beside, turned })
}

/// The least of a function of (h, p): a grid, then finer ones about its best.
fn best(misfit: impl Fn(Spectral) -> f64) -> Spectral {
    let [mut from, mut to] = [[HEIGHTS_UM[0].ln(), SHARES[0]], [HEIGHTS_UM[1].ln(), SHARES[1]]];
    let mut best = (f64::INFINITY, [0.0; 2]);
    for _ in 0..ROUNDS {
        let step = [0, 1].map(|axis| (to[axis] - from[axis]) / (STEPS - 1) as f64);
        for i in 0..STEPS {
            for j in 0..STEPS {
                let at = [from[0] + i as f64 * step[0], from[1] + j as f64 * step[1]];
                let value = misfit(Spectral { height_um: libm::exp(at[0]), achromatic: at[1] });
                if value < best.0 {
                    best = (value, at);
                }
            }
        }
        let limits = [[HEIGHTS_UM[0].ln(), HEIGHTS_UM[1].ln()], SHARES];
        from = [0, 1].map(|axis| (best.1[axis] - 1.5 * step[axis]).max(limits[axis][0]));
        to = [0, 1].map(|axis| (best.1[axis] + 1.5 * step[axis]).min(limits[axis][1]));
    }
    Spectral { height_um: libm::exp(best.1[0]), achromatic: best.1[1] }
}

impl Pair {
    /// The correlation that instances of a material show.
    fn expected(&self, spectral: Spectral, covariance: &impl Fn(f64) -> f64) -> f64 {
        let [a, b] = self.ends;
        let place = |end: &End| self.x / chromatic_length(end.length, end.achromatic, spectral.achromatic);
        let apart = spectral.height_um * (a.phase_per_um - b.phase_per_um);
        let gamma = covariance(place(&a) - place(&b)) * libm::exp(-0.5 * apart * apart);
        let cross = |gamma: f64| {
            let rest = (1.0 - a.steady) * (1.0 - b.steady);
            let both = 1.0 + *slope::VARIANCE * a.sloped * b.sloped;
            both * (1.0 + 2.0 * (a.steady * b.steady * rest).sqrt() * gamma + rest * gamma * gamma) - 1.0
        };
        let covariance = spectral.achromatic * cross(1.0) + (1.0 - spectral.achromatic) * cross(gamma);
        covariance / (a.variance() * b.variance()).sqrt()
    }
}

impl End {
    /// The relative variance of instances' intensities.
    fn variance(&self) -> f64 {
        (1.0 + *slope::VARIANCE * self.sloped * self.sloped) * (2.0 - self.steady * self.steady) - 1.0
    }
}

/// Up to so many numbers of a list, evenly spread, both ends among them.
fn spread(all: &[usize], most: usize) -> Vec<usize> {
    let last = all.len().saturating_sub(1);
    let count = all.len().min(most);
    let mut chosen: Vec<usize> =
        (0..count).map(|k| all[(k * last).checked_div(count.max(2) - 1).unwrap_or(0)]).collect();
    chosen.dedup();
    chosen
}

/// One intensity of all instances, less its mean and over its deviation.
struct Glint {
    end: End,
    x: f64,
    deviations: Vec<f64>,
}

fn pairs(statistics: &Statistics, material: &FeatherMaterial, fitters: &[Fitter]) -> Vec<Pair> {
    let axes = &material.axes;
    let steep = |cosines: &[f64], k: usize| cosines[k] >= LEAST_COSINE;
    let all = |count: usize| (0..count).collect::<Vec<_>>();
    let steep_thetas: Vec<usize> =
        all(axes.cos_theta().len()).into_iter().filter(|k| steep(axes.cos_theta(), *k)).collect();
    let steep_phis: Vec<usize> =
        all(axes.phis()).into_iter().filter(|phi| steep(axes.cos_phi(), axes.cosine_of(*phi))).collect();
    let waves = spread(&all(axes.wavelengths_nm().len()), MOST[0]);
    let (thetas, phis) = (spread(&steep_thetas, MOST[1]), spread(&steep_phis, MOST[2]));
    let mut pairs = Vec::new();
    for &theta in &thetas {
        let nodes: Vec<Vec<Vec<Option<Glint>>>> = waves
            .iter()
            .map(|&wave| {
                let node = |phi: &usize| {
                    let node = axes.index(wave, theta, *phi);
                    node_glints(statistics, material, node, &fitters[theta])
                };
                phis.iter().map(node).collect()
            })
            .collect();
        for first in 0..waves.len() {
            for phi in 0..phis.len() {
                for second in first + 1..waves.len() {
                    let both = nodes[first][phi].iter().zip(&nodes[second][phi]);
                    for (glint, (one, other)) in both.enumerate() {
                        let kind = if glint == 0 { Kind::Mirror } else { Kind::Beside };
                        pairs.extend(pair(kind, one, other));
                    }
                }
                for turned in phi + 1..phis.len() {
                    pairs.extend(pair(Kind::Turned, &nodes[first][phi][0], &nodes[first][turned][0]));
                }
            }
        }
    }
    pairs
}

fn pair(kind: Kind, first: &Option<Glint>, second: &Option<Glint>) -> Option<Pair> {
    let (first, second) = (first.as_ref()?, second.as_ref()?);
    if first.end.variance().min(second.end.variance()) < LEAST_VARIANCE {
        return None;
    }
    let found = first.deviations.iter().zip(&second.deviations).map(|(a, b)| a * b).sum::<f64>();
    Some(Pair { kind, ends: [first.end, second.end], x: first.x, found })
}

/// The intensities of a node that are kept, where there is light.
fn node_glints(
    statistics: &Statistics,
    material: &FeatherMaterial,
    node: usize,
    fitter: &Fitter,
) -> Vec<Option<Glint>> {
    let axes = &material.axes;
    let [wave, theta, phi] = place(axes, node);
    let (cosine, phi_i) = (axes.cos_theta()[theta], axes.phi_i(phi));
    let wave_number = wave_number_per_um(axes.wavelengths_nm()[wave]);
    let sides = fitted_on_azimuths(material, node, fitter);
    let sum = |of: &dyn Fn(usize) -> f64| 0.5 * (of(0) + of(1));
    let mean_at = |at: usize| sum(&|p| sides[p].mean[at]);
    let peak = (0..AZIMUTHS).map(mean_at).fold(0.0, f64::max);
    let phi_o: Vec<f64> = directions::azimuths(AZIMUTHS).collect();
    let rows = statistics.glints[node * GLINTS.len() * statistics.instances..]
        .chunks_exact(statistics.instances.max(1));
    glints(phi_i)
        .into_iter()
        .zip(rows)
        .map(|(at, intensities)| {
            let at = at.filter(|at| mean_at(*at) > LEAST_MEAN * peak)?;
            let end = End {
                length: f64::from(material.sets[0].length[node]),
                achromatic: f64::from(material.achromatic_length[node % material.achromatic_length.len()]),
                phase_per_um: wave_number * cosine * (libm::cos(phi_i) + libm::cos(phi_o[at])),
                steady: (sum(&|p| sides[p].steady[at]) / mean_at(at)).clamp(0.0, 1.0),
                sloped: sum(&|p| sides[p].sloped[at]),
            };
            let x = cosine * (libm::sin(phi_i) + libm::sin(phi_o[at]));
            Some(Glint { end, x, deviations: standardized(intensities)? })
        })
        .collect()
}

/// Less the mean, and with squares that sum to 1; none where all are alike.
fn standardized(values: &[f32]) -> Option<Vec<f64>> {
    let mean = values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len().max(1) as f64;
    let apart: Vec<f64> = values.iter().map(|v| f64::from(*v) - mean).collect();
    let norm = apart.iter().map(|v| v * v).sum::<f64>().sqrt();
    (norm > 1e-6 * mean && norm > 0.0).then(|| apart.into_iter().map(|v| v / norm).collect())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where all is steady nothing varies that could correlate; it once counted with a correlation of 10¹³⁷.
    #[test]
    fn what_is_steady_forms_no_pair() {
        let glint = |steady: f64| {
            let end = End { length: 1.0, achromatic: 1.0, phase_per_um: 20.0, steady, sloped: 0.0 };
            Some(Glint { end, x: 0.1, deviations: vec![0.6, 0.8] })
        };
        let [some, all] = [glint(0.9), glint(1.0)];
        assert!(pair(Kind::Mirror, &some, &all).is_none() && pair(Kind::Mirror, &all, &all).is_none());
        let pair = pair(Kind::Mirror, &some, &some).unwrap();
        let whole = pair.expected(Spectral { height_um: 0.1, achromatic: 0.2 }, &|_| 1.0);
        assert!((whole - 1.0).abs() < 1e-12 && (pair.found - 1.0).abs() < 1e-12, "{whole}");
    }
}
