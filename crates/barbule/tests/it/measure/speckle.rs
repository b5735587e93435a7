//! What single barbules do, in figures: shared by the tests that hold them and the program that prints them.

use barbule::brdf::fit::{FitOptions, FitReport, LobeForm, fit};
use barbule::brdf::{FeatherMaterial, Synthesis};
use barbule::campaign::single::autocovariance;
use barbule::campaign::{Campaign, CampaignParameters, Keep, Resources, places};
use barbule::material::Library;
use barbule::progress::Unobserved;
use barbule::scattering::directions::azimuths;
use barbule::scattering::far_field::Polarization;
use barbule::scattering::lobe::{FitKind, Lobe};
use barbule::scattering::statistics::{AZIMUTHS, Axes, NOISE_POINTS, Statistics, glints};
use barbule::spectrum::Wavelengths;
use barbule::structure::{SpeciesModel, Structure};
use num_complex::Complex64;
use std::sync::OnceLock;

const INSTANCES: usize = 50;

/// Directions weaker than this part of the lobe's peak are left out: there nothing is seen.
const WEAKEST: f64 = 0.05;

/// Share of (λ, ω_i, φ_o, part) at which normality is rejected at 1 %: that of A² (n → ∞ form) with mean and variance
/// from the sample, D'Agostino & Stephens 1986, table 4.7.
const CRITICAL: f64 = 1.035;

/// Simulated barbules of a species.
pub(crate) struct Species {
    pub(crate) name: &'static str,
    /// Whether its tops are arches.
    #[allow(dead_code)] // the tests'
    pub(crate) is_arched: bool,
    structure: Structure,
    /// Lit in the middle, as is published.
    middle: Ensemble,
    /// Of arches: lit at all places in turn, as materials are made.
    places: Option<Ensemble>,
    /// Fitted to them, once for all that asks.
    material: OnceLock<(FeatherMaterial, FitReport)>,
}

/// Simulated barbules lit in one way.
struct Ensemble {
    campaign: Campaign,
    statistics: Statistics,
    /// `[unit][φ_i, polarization, e₁ e₂, instance, AZIMUTHS]`.
    fields: Vec<Vec<num_complex::Complex<f32>>>,
}

/// 50 instances with tilts, three wavelengths and θ_i, four φ_i.
pub(crate) fn simulate(name: &'static str) -> Species {
    let model = SpeciesModel::builtin(name, None, Library::builtin()).unwrap();
    let is_arched = model.is_curved();
    let structure = Structure::Species(Box::new(model));
    let all = places(&structure, INSTANCES);
    let usual =
        |places: usize| ensemble(&structure, &[0.1, 0.5, 1.0], &[0.1, 0.35, 0.7, 1.0], INSTANCES, 1, places);
    let (middle, places) = (usual(1), (all > 1).then(|| usual(all)));
    Species { name, is_arched, structure, middle, places, material: OnceLock::new() }
}

fn ensemble(
    structure: &Structure,
    cos_theta: &[f64],
    cos_phi: &[f64],
    instances: usize,
    seed: u64,
    places: usize,
) -> Ensemble {
    let wavelengths = Wavelengths::new([400.0, 550.0, 694.0]).unwrap();
    let axes = Axes::new(&wavelengths, cos_theta.to_vec(), cos_phi.to_vec()).unwrap();
    let parameters = CampaignParameters {
        axes: axes.clone(),
        instances,
        seed,
        tilt: 2f64.to_radians(),
        mirror: false,
        places,
    };
    let campaign = Campaign::new(structure, parameters, &Resources::default(), &Unobserved).unwrap();
    let mut statistics = Statistics::empty(axes, instances).with_places(places);
    let mut fields = Vec::new();
    for wave in 0..3 {
        let tables = campaign.tables(wave, &Unobserved).unwrap();
        for theta in 0..cos_theta.len() {
            let mut unit = campaign.unit(&tables, theta, Keep::Fields, &Unobserved).unwrap();
            fields.push(std::mem::take(&mut unit.fields));
            statistics.append(unit);
        }
    }
    Ensemble { campaign, statistics, fields }
}

impl Species {
    /// Lit as materials are made.
    fn lit(&self) -> &Ensemble {
        self.places.as_ref().unwrap_or(&self.middle)
    }

    /// What is fitted to it as materials are.
    fn material(&self) -> &(FeatherMaterial, FitReport) {
        self.material.get_or_init(|| self.lit().fitted(LobeForm::Pair, false))
    }

    /// The stronger component's values over instances where the lobe is seen, lit in the middle, `(node, [φ_o][instance])`.
    #[allow(dead_code)] // the program's
    pub(crate) fn samples(&self) -> impl Iterator<Item = (usize, Vec<Vec<Complex64>>)> + '_ {
        self.middle.samples()
    }

    /// Whether light comes from within about 45° of the normal.
    #[allow(dead_code)] // the program's
    pub(crate) fn is_steep(&self, node: usize) -> bool {
        self.middle.is_steep(node)
    }
}

impl Ensemble {
    fn samples(&self) -> impl Iterator<Item = (usize, Vec<Vec<Complex64>>)> + '_ {
        let phis = self.statistics.axes.cos_phi().len();
        let instances = self.statistics.instances;
        (0..self.statistics.axes.len() * 2).map(move |at| {
            let (node, polarization) = (at / 2, at % 2);
            let fields = &self.fields[node / phis];
            let component = |along: usize, instance: usize| {
                let part = ((node % phis) * 2 + polarization) * 2 + along;
                &fields[(part * instances + instance) * AZIMUTHS..][..AZIMUTHS]
            };
            let energy = |along: usize| -> f64 {
                (0..instances).flat_map(|m| component(along, m)).map(|v| f64::from(v.norm_sqr())).sum()
            };
            let along = usize::from(energy(1) > energy(0));
            let u = &self.statistics.u[at * AZIMUTHS..][..AZIMUTHS];
            let peak = u.iter().fold(0.0_f32, |a, b| a.max(*b));
            let seen = (0..AZIMUTHS).filter(|k| f64::from(u[*k]) > WEAKEST * f64::from(peak));
            let of = |k: usize| {
                (0..instances)
                    .map(|m| {
                        let value = component(along, m)[k];
                        Complex64::new(f64::from(value.re), f64::from(value.im))
                    })
                    .collect()
            };
            (node, seen.map(of).collect())
        })
    }

    /// Unpolarized intensities about the mean of each instance's place, with the mean of all, `[instance][azimuth]`.
    fn intensities(&self, wave: usize, theta: usize, phi: usize) -> Vec<Vec<f64>> {
        let Statistics { axes, instances, .. } = &self.statistics;
        let instances = *instances;
        let fields = &self.fields[wave * axes.cos_theta().len() + theta];
        let of = |instance: usize, azimuth: usize| -> f64 {
            let parts = 4 * phi..4 * (phi + 1);
            let squares = parts
                .map(|part| f64::from(fields[(part * instances + instance) * AZIMUTHS + azimuth].norm_sqr()));
            0.5 * squares.sum::<f64>()
        };
        let all = (0..instances).map(|instance| (0..AZIMUTHS).map(|at| of(instance, at)).collect()).collect();
        about_places(all, self.statistics.places)
    }

    fn is_steep(&self, node: usize) -> bool {
        let axes = &self.statistics.axes;
        let phis = axes.cos_phi().len();
        axes.cos_phi()[node % phis] * axes.cos_theta()[node / phis % axes.cos_theta().len()] > 0.65
    }

    fn fitted(&self, lobe: LobeForm, polarized: bool) -> (FeatherMaterial, FitReport) {
        fit(&self.statistics, &FitOptions { lobe, polarized, ..FitOptions::default() }, &Unobserved).unwrap()
    }
}

/// Intensities whose departures are those from the mean of their place, and whose mean is that of all, to the scale at which both
/// have the same contrast.
fn about_places(mut all: Vec<Vec<f64>>, places: usize) -> Vec<Vec<f64>> {
    for at in 0..all[0].len() {
        let mean_at = |from: usize, step: usize| mean(all.iter().skip(from).step_by(step).map(|one| one[at]));
        let (whole, of_places): (f64, Vec<f64>) =
            (mean_at(0, 1), (0..places).map(|p| mean_at(p, places)).collect());
        let square: f64 = mean(of_places.iter().map(|mean| mean * mean));
        let scale = if places > 1 { whole / square.sqrt().max(f64::MIN_POSITIVE) } else { 1.0 };
        for (n, one) in all.iter_mut().enumerate() {
            one[at] = whole + scale * (one[at] - of_places[n % places]);
        }
    }
    all
}

/// Mean and standard deviation of a sample.
pub(crate) fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt())
}

/// Anderson and Darling's A² against the normal distribution of the sample's own mean and variance.
fn anderson_darling(values: &[f64]) -> f64 {
    let (mean, deviation) = moments(values);
    let mut sorted: Vec<f64> = values.iter().map(|v| (v - mean) / deviation).collect();
    sorted.sort_by(f64::total_cmp);
    let below = |z: f64| (0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)).clamp(1e-300, 1.0);
    let n = sorted.len() as f64;
    let sum: f64 = (0..sorted.len())
        .map(|i| {
            let odd = 2.0 * i as f64 + 1.0;
            odd * (below(sorted[i]).ln() + below(-sorted[sorted.len() - 1 - i]).ln())
        })
        .sum();
    (-n - sum / n) * (1.0 + 0.75 / n + 2.25 / (n * n))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Share of rejections of real and imaginary parts, for steep and for other incidence.
fn rejected(species: &Ensemble) -> [f64; 2] {
    let mut counts = [[0.0; 2]; 2];
    for (node, samples) in species.samples() {
        let group = &mut counts[usize::from(!species.is_steep(node))];
        // Every fourth azimuth: neighbours are the same speckle.
        for values in samples.iter().step_by(4) {
            for part in [|v: &Complex64| v.re, |v: &Complex64| v.im] {
                let a = anderson_darling(&values.iter().map(part).collect::<Vec<_>>());
                group[0] += 1.0;
                group[1] += f64::from(u8::from(a > CRITICAL));
            }
        }
    }
    counts.map(|[all, bad]| bad / all)
}

/// σ_R/σ_I of each (λ, ω_i) and polarization, variances summed over the lobe.
fn ratios(species: &Ensemble, steep: bool) -> Vec<f64> {
    let mut ratios = Vec::new();
    for (_, samples) in species.samples().filter(|(node, _)| species.is_steep(*node) == steep) {
        let mut sums = [0.0; 2];
        for values in &samples {
            for (sum, part) in sums.iter_mut().zip([|v: &Complex64| v.re, |v: &Complex64| v.im]) {
                *sum += moments(&values.iter().map(part).collect::<Vec<_>>()).1.powi(2);
            }
        }
        ratios.push((sums[0] / sums[1]).sqrt());
    }
    ratios
}

/// ∫V/∫U at a node, both polarizations.
fn steady(statistics: &Statistics, node: usize) -> f64 {
    let sum = |array: &[f32]| -> f64 {
        array[node * 2 * AZIMUTHS..(node + 1) * 2 * AZIMUTHS].iter().map(|v| f64::from(*v)).sum()
    };
    sum(&statistics.v) / sum(&statistics.u)
}

/// The Δx at which an autocovariance falls to 1/e.
fn decay(lags: &[f64]) -> f64 {
    let level = (-1f64).exp() * lags[0];
    let at = lags.iter().position(|v| *v < level).unwrap();
    let (above, below) = (lags[at - 1], lags[at]);
    ((at - 1) as f64 + (above - level) / (above - below)) * 2.0 / NOISE_POINTS as f64
}

/// Synthesized instances whose lengths are told: two hundred tell them to three percent only.
const SYNTHESIZED: u64 = 2000;

/// 1/e lengths at polarization 1, simulated and synthesized: of the weighted fields (S.30) and of the intensities
/// about their mean over instances.
fn lengths(species: &Ensemble, material: &FeatherMaterial, wave: usize, phi: usize) -> [[f64; 2]; 2] {
    let axes = &species.statistics.axes;
    let theta = axes.cos_theta().len() - 1;
    let patterns = species.campaign.patterns(
        &species.campaign.tables(wave, &Unobserved).unwrap(),
        theta,
        phi,
        Polarization::First,
        &Unobserved,
    );
    let patterns = patterns.unwrap();
    let synthesis = Synthesis::on(material, axes.index(wave, theta, phi), &patterns.phi_o);
    let noise = material.noise();
    let synthesized: Vec<Vec<Complex64>> = (0..SYNTHESIZED)
        .map(|n| synthesis.fields(&noise, n).map(|[[re, im], _]| Complex64::new(re, im)).collect())
        .collect();
    let of = |rows: &mut dyn Iterator<Item = Vec<Complex64>>| {
        let mut sum = vec![0.0; NOISE_POINTS / 2];
        for values in rows {
            sum.iter_mut().zip(autocovariance(&values)).for_each(|(sum, value)| *sum += value);
        }
        decay(&sum)
    };
    let decays = |fields: &[Vec<Complex64>], places: usize| {
        let weighted = |field: &Vec<Complex64>| -> Vec<Complex64> {
            field.iter().zip(&patterns.fitted).map(|(v, u)| v * u.sqrt()).collect()
        };
        let intensities: Vec<Vec<f64>> =
            fields.iter().map(|field| field.iter().map(Complex64::norm_sqr).collect()).collect();
        let whole: Vec<f64> =
            (0..patterns.x.len()).map(|k| mean(intensities.iter().map(|one| one[k]))).collect();
        let departure = |one: Vec<f64>| {
            one.iter().zip(&whole).map(|(value, mean)| Complex64::new(value - mean, 0.0)).collect()
        };
        let about = about_places(intensities, places);
        [of(&mut fields.iter().map(weighted)), of(&mut about.into_iter().map(departure))]
    };
    let (a, b) = (decays(&patterns.fields, species.statistics.places), decays(&synthesized, 1));
    [[a[0], b[0]], [a[1], b[1]]]
}

/// How the intensities of instances correlate, simulated and synthesized, and how far the two are apart in the mean over pairs.
#[derive(Debug)]
pub(crate) struct Correlations {
    /// Of two wavelengths in the mirror direction.
    pub(crate) mirror: [f64; 3],
    /// Of two wavelengths over the lobe, where both have a tenth of its peak.
    pub(crate) lobe: [f64; 3],
    /// Of two lights, each in its mirror direction.
    pub(crate) turned: [f64; 3],
}

/// Measures [`Correlations`] of a material without what tells wavelengths apart, as it is published, and of one with it.
pub(crate) fn correlations(species: &Species) -> [Correlations; 2] {
    let lit = species.lit();
    let published = Statistics { glints: Vec::new(), ..lit.statistics.clone() };
    let (published, _) = fit(&published, &FitOptions::default(), &Unobserved).unwrap();
    [&published, &species.material().0].map(|material| correlations_of(lit, material))
}

/// Instances that are drawn.
const DRAWN: u64 = 400;

fn correlations_of(species: &Ensemble, material: &FeatherMaterial) -> Correlations {
    let axes = &species.statistics.axes;
    let noise = material.noise();
    // θ_i and φ_i that are not grazing.
    let (thetas, phis) = ([1, 2], [1, 2, 3]);
    let both = |wave: usize, theta: usize, phi: usize| -> [Vec<Vec<f64>>; 2] {
        let synthesis = Synthesis::new(material, axes.index(wave, theta, phi));
        let drawn = (0..DRAWN).map(|name| synthesis.intensity(&noise, name)).collect();
        [species.intensities(wave, theta, phi), drawn]
    };
    let [mut mirror, mut lobe, mut turned] = [const { Vec::new() }; 3];
    for theta in thetas {
        let nodes: Vec<Vec<[Vec<Vec<f64>>; 2]>> =
            (0..3).map(|wave| phis.map(|phi| both(wave, theta, phi)).into()).collect();
        let middle = phis.map(|phi| glints(axes.phi_i(phi))[0].unwrap());
        for (first, second) in [(0, 1), (1, 2), (0, 2)] {
            for k in 0..phis.len() {
                let (a, b) = (&nodes[first][k], &nodes[second][k]);
                let at = |azimuth: usize| [0, 1].map(|side| correlation(&a[side], &b[side], [azimuth; 2]));
                mirror.push(at(middle[k]));
                let seen = lit(&a[0]).zip(lit(&b[0])).enumerate().filter(|(_, (a, b))| *a && *b);
                let all: Vec<[f64; 2]> = seen.map(|(azimuth, _)| at(azimuth)).collect();
                lobe.push([0, 1].map(|side| mean(all.iter().map(|pair| pair[side]))));
            }
        }
        for waves in &nodes {
            for (first, second) in [(0, 1), (1, 2), (0, 2)] {
                let places = [middle[first], middle[second]];
                let (a, b) = (&waves[first], &waves[second]);
                turned.push([0, 1].map(|side| correlation(&a[side], &b[side], places)));
            }
        }
    }
    let of = |pairs: &[[f64; 2]]| {
        let [simulated, synthesized] = [0, 1].map(|side| mean(pairs.iter().map(|pair| pair[side])));
        [simulated, synthesized, mean(pairs.iter().map(|[a, b]| (a - b).abs()))]
    };
    Correlations { mirror: of(&mirror), lobe: of(&lobe), turned: of(&turned) }
}

/// Where the mean over instances is at least a tenth of its peak.
fn lit(instances: &[Vec<f64>]) -> impl Iterator<Item = bool> {
    let total = |azimuth: usize| instances.iter().map(|one| one[azimuth]).sum::<f64>();
    let totals: Vec<f64> = (0..AZIMUTHS).map(total).collect();
    let peak = totals.iter().copied().fold(0.0, f64::max);
    totals.into_iter().map(move |total| total > 0.1 * peak)
}

/// Of two patterns' intensities over instances, each at its azimuth.
fn correlation(a: &[Vec<f64>], b: &[Vec<f64>], [at_a, at_b]: [usize; 2]) -> f64 {
    let column = |all: &[Vec<f64>], at: usize| all.iter().map(|one| one[at]).collect::<Vec<_>>();
    let (a, b) = (column(a, at_a), column(b, at_b));
    let ((mean_a, deviation_a), (mean_b, deviation_b)) = (moments(&a), moments(&b));
    let products = a.iter().zip(&b).map(|(a, b)| (a - mean_a) * (b - mean_b));
    products.sum::<f64>() / ((a.len() - 1) as f64 * deviation_a * deviation_b).max(f64::MIN_POSITIVE)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / f64::max(count, 1.0)
}

/// How much single barbules vary, simulated and synthesized: the contrast of unpolarized light within 1.6° of places in the lobe.
#[derive(Debug, Default)]
pub(crate) struct Contrasts {
    /// Means over all places.
    pub(crate) mean: [f64; 2],
    /// Mean of the distances.
    pub(crate) apart: f64,
    /// The same of the few barbules that the material was fitted to, from the many: what chance makes of contrasts.
    pub(crate) sampled: f64,
    pub(crate) farthest_sampled: f64,
    /// The largest distance, with both contrasts there.
    pub(crate) farthest: [f64; 3],
    /// Wavelength in nm, cosθ_i, φ_i and distance from the mirror direction in degrees of that.
    pub(crate) at: [f64; 4],
}

/// Distances from the mirror direction at which contrasts are compared, degrees.
const OFFSETS_DEG: [f64; 9] = [-30.0, -20.0, -10.0, -5.0, 0.0, 5.0, 10.0, 20.0, 30.0];

/// Half the width over which a contrast is taken, degrees.
const WITHIN_DEG: f64 = 1.6;

/// Measures [`Contrasts`] of a material of the usual number of barbules against so many others.
pub(crate) fn contrasts(species: &Species, others: usize) -> Contrasts {
    let lit = species.lit();
    let (material, _) = species.material();
    let (cosines, noise) = ([[0.5, 1.0].as_slice(), &[0.35, 0.7, 1.0]], material.noise());
    let many = ensemble(&species.structure, cosines[0], cosines[1], others, 2, lit.statistics.places);
    let (axes, azimuths): (_, Vec<f64>) = (&many.statistics.axes, azimuths(AZIMUTHS).collect());
    let (mut found, mut count) = (Contrasts::default(), 0.0);
    for (wave, theta, phi) in (0..18).map(|k| (k / 6, k / 3 % 2, k % 3)) {
        let simulated = many.intensities(wave, theta, phi);
        let few = lit.intensities(wave, theta + 1, phi + 1);
        let phi_deg = axes.phi_i(phi).to_degrees();
        for offset in OFFSETS_DEG.into_iter().filter(|offset| (offset - phi_deg).abs() < 75.0) {
            let near = |phi_o: &f64| (phi_o.to_degrees() + phi_deg - offset).abs() < WITHIN_DEG;
            let places: Vec<usize> = (0..AZIMUTHS).filter(|k| near(&azimuths[*k])).collect();
            // Drawn where they are compared, and nowhere else.
            let there: Vec<f64> = places.iter().map(|k| azimuths[*k]).collect();
            let synthesis = Synthesis::on(material, material.axes.index(wave, theta + 1, phi + 1), &there);
            let drawn: Vec<Vec<f64>> =
                (0..10 * DRAWN).map(|name| synthesis.intensity(&noise, name)).collect();
            let all: Vec<usize> = (0..there.len()).collect();
            let pair = [contrast(&simulated, &places), contrast(&drawn, &all)];
            let apart = (pair[0] - pair[1]).abs();
            let own = contrast(&few, &places);
            found.sampled += (own - pair[0]).abs();
            found.farthest_sampled = found.farthest_sampled.max((own - pair[0]).abs());
            (found.mean, found.apart) =
                ([found.mean[0] + pair[0], found.mean[1] + pair[1]], found.apart + apart);
            count += 1.0;
            if apart > found.farthest[0] {
                found.farthest = [apart, pair[0], pair[1]];
                found.at = [axes.wavelengths_nm()[wave], axes.cos_theta()[theta], phi_deg, offset];
            }
        }
    }
    found.mean = found.mean.map(|sum| sum / count);
    found.apart /= count;
    found.sampled /= count;
    found
}

/// Root mean square of the contrasts at some azimuths.
fn contrast(instances: &[Vec<f64>], azimuths: &[usize]) -> f64 {
    let squared = azimuths.iter().map(|&at| {
        let (mean, deviation) = moments(&instances.iter().map(|one| one[at]).collect::<Vec<_>>());
        (deviation / mean).powi(2)
    });
    mean(squared).sqrt()
}

/// Normality, equal parts, and a mean field that grows towards grazing incidence.
pub(crate) struct Speckle {
    /// Share of rejections of normality at 1 %, for steep and for other incidence.
    pub(crate) rejected: [f64; 2],
    /// σ_R/σ_I, for steep and for other incidence: median, lowest, highest.
    pub(crate) ratio: [[f64; 3]; 2],
    /// V/U at θ_i = 0 and φ_i = 0°, 46°, 70°, 84°, mean of the wavelengths.
    pub(crate) steady: [f64; 4],
}

/// Measures [`Speckle`].
pub(crate) fn speckle(species: &Species) -> Speckle {
    let species = &species.middle;
    let spread = |values: Vec<f64>| {
        let low = values.iter().copied().fold(f64::MAX, f64::min);
        let high = values.iter().copied().fold(0.0, f64::max);
        [median(values), low, high]
    };
    let axes = &species.statistics.axes;
    Speckle {
        rejected: rejected(species),
        ratio: [true, false].map(|steep| spread(ratios(species, steep))),
        steady: [3, 2, 1, 0]
            .map(|phi| (0..3).map(|w| steady(&species.statistics, axes.index(w, 2, phi)) / 3.0).sum()),
    }
}

/// How the parameters of single lobes lie to the directions and to each other; medians are over all λ and ω_i.
pub(crate) struct Fitted {
    /// |φ_eff − φ_i|, degrees: median and largest.
    pub(crate) apart_deg: [f64; 2],
    /// The least of F at grazing incidence over the largest elsewhere.
    pub(crate) grazing: f64,
    /// Medians of m₁/m₂, |φ₁ − φ₂| (degrees) and l₁/l₂ of the two polarizations.
    pub(crate) polarizations: [f64; 3],
}

/// Measures [`Fitted`].
pub(crate) fn fitted(species: &Species) -> Fitted {
    let species = &species.middle;
    let (material, _) = species.fitted(LobeForm::Ggx, false);
    let (polarized, _) = species.fitted(LobeForm::Ggx, true);
    let axes = &material.axes;
    let phis = axes.cos_phi().len();
    let lobe = |node: usize| {
        let set = &material.sets[0].mean[0];
        Lobe { m: f64::from(set.m[node]), phi: f64::from(set.phi[node]) }
    };
    let cosines = |node: usize| (axes.cos_theta()[node / phis % 3], axes.cos_phi()[node % phis]);
    let off: Vec<f64> =
        (0..axes.len()).map(|node| (lobe(node).phi - cosines(node).1.acos()).abs().to_degrees()).collect();
    let f = |node: usize| {
        let theta = cosines(node).0.acos();
        f64::from(material.sets[0].mean[0].reflected[node]) / integral(lobe(node), theta, material.sigma)
    };
    let per_wave = axes.len() / 3;
    let grazing = (0..3)
        .map(|w| {
            let rest = (1..per_wave).map(|n| f(w * per_wave + n)).fold(0.0, f64::max);
            f(w * per_wave) / rest
        })
        .fold(f64::MAX, f64::min);
    let [one, two] = [0, 1].map(|p| &polarized.sets[p]);
    let middle = |pick: &dyn Fn(usize) -> f64| median((0..axes.len()).map(pick).collect());
    Fitted {
        apart_deg: [median(off.clone()), off.iter().copied().fold(0.0, f64::max)],
        grazing,
        polarizations: [
            middle(&|n| f64::from(one.mean[0].m[n] / two.mean[0].m[n])),
            middle(&|n| f64::from((one.mean[0].phi[n] - two.mean[0].phi[n]).abs()).to_degrees()),
            middle(&|n| f64::from(one.length[n] / two.length[n])),
        ],
    }
}

/// ∫ f̂/F (z·ω_o) dω_o of the published lobe for a narrow spread σ: σ√π G₁(ω_eff)/(2 cosφ_eff) times the area under its shape.
fn integral(lobe: Lobe, theta: f64, sigma: f64) -> f64 {
    let z = theta.cos() * lobe.phi.cos();
    let shadowing = 2.0 / (1.0 + (1.0 + lobe.m * lobe.m * (1.0 - z * z) / (z * z)).sqrt());
    let shape = azimuths(AZIMUTHS).map(|phi_o| lobe.shape(FitKind::Marginal, theta, phi_o));
    let area = shape.sum::<f64>() * std::f64::consts::PI / AZIMUTHS as f64;
    sigma * std::f64::consts::PI.sqrt() * shadowing * area / (2.0 * lobe.phi.cos())
}

/// Simulated instances beside synthesized ones, in this order in each pair.
#[derive(Debug)]
pub(crate) struct Synthesized {
    /// Means of the contrast.
    pub(crate) contrast: [f64; 2],
    /// Largest difference of the contrasts.
    pub(crate) contrast_apart: f64,
    /// Means of the contrast of one polarization about the mirror direction, on the shoulders and in the wings.
    pub(crate) regions: [[f64; 2]; 3],
    /// Means, weighted by ρ, of the correlation of the polarizations' patterns.
    pub(crate) correlation: [f64; 2],
    /// Energy of 2000 synthesized instances over the simulated mean's.
    pub(crate) energy: f64,
    /// 1/e lengths of fields and of intensities, at 400 nm, at 694 nm, and at 400 nm and φ_i = 46°.
    pub(crate) lengths: [[[f64; 2]; 2]; 3],
    /// Longest correlation length over the one at the shortest wavelength.
    pub(crate) longest_length: f64,
}

/// Instances whose reflected fraction is measured: ±0.3 %.
const DRAWS: u64 = 8000;

/// Measures [`Synthesized`].
pub(crate) fn synthesized(species: &Species) -> Synthesized {
    let (material, report) = species.material();
    let species = species.lit();
    let count = report.patterns.len() as f64;
    let balance: f64 = report.patterns.iter().map(|p| p.balance).sum();
    let noise = material.noise();
    let node = material.axes.index(1, 2, 3);
    let synthesis = Synthesis::new(material, node);
    let step = std::f64::consts::PI / AZIMUTHS as f64;
    let drawn: f64 = (0..DRAWS).map(|n| step * synthesis.intensity(&noise, n).iter().sum::<f64>()).sum();
    let reflected = &species.statistics.reflected[2 * node..2 * node + 2];
    let patterns = || report.patterns.iter();
    Synthesized {
        contrast: [0, 1].map(|side| patterns().map(|p| p.contrast[side]).sum::<f64>() / count),
        contrast_apart: patterns().map(|p| (p.contrast[0] - p.contrast[1]).abs()).fold(0.0, f64::max),
        regions: report.mean_regions().map(|pair| pair.unwrap_or([f64::NAN; 2])),
        correlation: [0, 1]
            .map(|side| patterns().map(|p| p.balance * p.correlation[side]).sum::<f64>() / balance),
        energy: drawn / DRAWS as f64 / (0.5 * (reflected[0] + reflected[1])),
        lengths: [(0, 3), (2, 3), (0, 2)].map(|(wave, phi)| lengths(species, material, wave, phi)),
        longest_length: report.longest_length[0],
    }
}
