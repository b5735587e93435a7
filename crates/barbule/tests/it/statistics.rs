//! Fields of simulated barbules against the theory of speckle, and synthesized instances against the simulated ones.
//!
//! `cargo test --release -p barbule --test it statistics -- --nocapture --include-ignored --test-threads 1`
//! prints the tables of `docs/theory/statistics.md`.

use std::path::Path;
use std::sync::OnceLock;

use barbule::brdf::fit::{FitOptions, FitReport, fit};
use barbule::brdf::{FeatherMaterial, Noise, Synthesis, lobe_integral};
use barbule::campaign::single::autocovariance;
use barbule::campaign::{Campaign, Keep, Parameters};
use barbule::material::Library;
use barbule::math::simd::Width;
use barbule::plot::{Axis, Curve, Drawing, Figure, Format, Ink, Stroke};
use barbule::progress::Unobserved;
use barbule::scattering::far_field::Polarization;
use barbule::scattering::lobe::Lobe;
use barbule::scattering::statistics::{AZIMUTHS, Axes, NOISE_POINTS, Statistics};
use barbule::spectrum::Wavelengths;
use barbule::structure::{SpeciesModel, Structure};
use num_complex::Complex64;

const INSTANCES: usize = 50;

/// Directions weaker than this part of the lobe's peak are left out: there nothing is seen.
const WEAKEST: f64 = 0.05;

/// Share of (λ, ω_i, φ_o, part) at which normality is rejected at 1 %: that of A² (n → ∞ form) with mean and variance
/// from the sample, D'Agostino & Stephens 1986, table 4.7.
const CRITICAL: f64 = 1.035;

/// The species of the usual run, simulated once for all tests.
const QUICK: [&str; 3] = ["rock-dove", "starling", "bronzewing"];

fn quick() -> &'static [Species] {
    static SPECIES: OnceLock<Vec<Species>> = OnceLock::new();
    SPECIES.get_or_init(|| QUICK.into_iter().map(simulate).collect())
}

/// Its many layers take as long as all others together.
fn hummingbird() -> &'static Species {
    static SPECIES: OnceLock<Species> = OnceLock::new();
    SPECIES.get_or_init(|| simulate("hummingbird"))
}

struct Species {
    name: &'static str,
    campaign: Campaign,
    statistics: Statistics,
    /// `[unit][φ_i, polarization, e₁ e₂, instance, AZIMUTHS]`.
    fields: Vec<Vec<num_complex::Complex<f32>>>,
}

fn simulate(name: &'static str) -> Species {
    let model = SpeciesModel::builtin(name, None, Library::builtin()).unwrap();
    let wavelengths = Wavelengths::new([400.0, 550.0, 694.0]).unwrap();
    let axes = Axes::new(&wavelengths, vec![0.1, 0.5, 1.0], vec![0.1, 0.35, 0.7, 1.0]).unwrap();
    let parameters =
        Parameters { axes: axes.clone(), instances: INSTANCES, seed: 1, tilt: 2f64.to_radians() };
    let structure = Structure::Species(Box::new(model));
    let campaign = Campaign::new(&structure, parameters, Width::best(), &Unobserved).unwrap();
    let mut statistics = Statistics::empty(axes, INSTANCES);
    let mut fields = Vec::new();
    for wave in 0..3 {
        let tables = campaign.tables(wave, &Unobserved).unwrap();
        for theta in 0..3 {
            let mut unit = campaign.unit(&tables, theta, Keep::Fields);
            fields.push(std::mem::take(&mut unit.fields));
            statistics.append(unit);
        }
    }
    Species { name, campaign, statistics, fields }
}

impl Species {
    /// The stronger component's values over instances where the lobe is seen, `(node, [φ_o][instance])`.
    fn samples(&self) -> impl Iterator<Item = (usize, Vec<Vec<Complex64>>)> + '_ {
        let phis = self.statistics.axes.cos_phi.len();
        (0..self.statistics.axes.len() * 2).map(move |at| {
            let (node, polarization) = (at / 2, at % 2);
            let fields = &self.fields[node / phis];
            let component = |along: usize, instance: usize| {
                let part = ((node % phis) * 2 + polarization) * 2 + along;
                &fields[(part * INSTANCES + instance) * AZIMUTHS..][..AZIMUTHS]
            };
            let energy = |along: usize| -> f64 {
                (0..INSTANCES).flat_map(|m| component(along, m)).map(|v| f64::from(v.norm_sqr())).sum()
            };
            let along = usize::from(energy(1) > energy(0));
            let u = &self.statistics.u[at * AZIMUTHS..][..AZIMUTHS];
            let peak = u.iter().fold(0.0_f32, |a, b| a.max(*b));
            let seen = (0..AZIMUTHS).filter(|k| f64::from(u[*k]) > WEAKEST * f64::from(peak));
            let of = |k: usize| {
                (0..INSTANCES)
                    .map(|m| {
                        let value = component(along, m)[k];
                        Complex64::new(f64::from(value.re), f64::from(value.im))
                    })
                    .collect()
            };
            (node, seen.map(of).collect())
        })
    }

    /// Whether light comes from within about 45° of the normal.
    fn is_steep(&self, node: usize) -> bool {
        let axes = &self.statistics.axes;
        let phis = axes.cos_phi.len();
        axes.cos_phi[node % phis] * axes.cos_theta[node / phis % axes.cos_theta.len()] > 0.65
    }

    fn fitted(&self, polarized: bool) -> (FeatherMaterial, FitReport) {
        fit(&self.statistics, &FitOptions { polarized, ..FitOptions::default() }, &Unobserved).unwrap()
    }
}

/// Mean and standard deviation of a sample.
fn moments(values: &[f64]) -> (f64, f64) {
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
fn rejected(species: &Species) -> [f64; 2] {
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
fn ratios(species: &Species, steep: bool) -> Vec<f64> {
    let mut ratios = Vec::new();
    for (node, samples) in species.samples().filter(|(node, _)| species.is_steep(*node) == steep) {
        let _ = node;
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

/// 1/e lengths at polarization 1, simulated and synthesized: of the weighted fields (S.30) and of the intensities
/// about their mean over instances.
fn lengths(species: &Species, material: &FeatherMaterial, wave: usize, phi: usize) -> [[f64; 2]; 2] {
    let axes = &species.statistics.axes;
    let theta = axes.cos_theta.len() - 1;
    let tables = species.campaign.tables(wave, &Unobserved).unwrap();
    let patterns = species.campaign.patterns(&tables, theta, phi, Polarization::First);
    let first = ((patterns.x[0] + 1.0) * 0.5 * NOISE_POINTS as f64) as usize;
    let synthesis = Synthesis::on(material, axes.index(wave, theta, phi), &patterns.phi_o);
    let noise = Noise::new(&material.noise_power, material.seed);
    let synthesized: Vec<Vec<Complex64>> = (0..200)
        .map(|n| synthesis.fields(&noise, n).map(|[[re, im], _]| Complex64::new(re, im)).collect())
        .collect();
    let decays = |fields: &[Vec<Complex64>]| {
        let mean: Vec<f64> = (0..patterns.x.len())
            .map(|k| fields.iter().map(|f| f[k].norm_sqr()).sum::<f64>() / fields.len() as f64)
            .collect();
        let of = |weigh: &dyn Fn(usize, Complex64) -> Complex64| {
            let mut sum = vec![0.0; NOISE_POINTS / 2];
            for field in fields {
                let values: Vec<Complex64> = field.iter().enumerate().map(|(k, v)| weigh(k, *v)).collect();
                for (sum, value) in sum.iter_mut().zip(autocovariance(&values, first)) {
                    *sum += value;
                }
            }
            decay(&sum)
        };
        [of(&|k, v| v * patterns.fitted[k].sqrt()), of(&|k, v| Complex64::new(v.norm_sqr() - mean[k], 0.0))]
    };
    let (a, b) = (decays(&patterns.fields), decays(&synthesized));
    [[a[0], b[0]], [a[1], b[1]]]
}

/// Normality, equal parts, and a mean field that grows towards grazing incidence.
fn speckle(species: &Species) {
    let [steep, oblique] = rejected(species);
    let spread = |values: Vec<f64>| {
        let low = values.iter().copied().fold(f64::MAX, f64::min);
        let high = values.iter().copied().fold(0.0, f64::max);
        [median(values), low, high]
    };
    let (near, far) = (spread(ratios(species, true)), spread(ratios(species, false)));
    let axes = &species.statistics.axes;
    let v: Vec<f64> = (0..4)
        .rev()
        .map(|phi| (0..3).map(|w| steady(&species.statistics, axes.index(w, 2, phi)) / 3.0).sum())
        .collect();
    let parts = |[median, low, high]: [f64; 3]| format!("{median:.3} ({low:.2}–{high:.2})");
    println!(
        "| {} | {:.1} % | {:.1} % | {} | {} | {:.3}, {:.3}, {:.3}, {:.3} |",
        species.name,
        100.0 * steep,
        100.0 * oblique,
        parts(near),
        parts(far),
        v[0],
        v[1],
        v[2],
        v[3]
    );
    // 1 % for normal fields; the rest is the barbules' own spread of slopes and, oblique, a phase they share.
    assert!(steep < 0.1 && oblique < 0.12);
    assert!(near[1] > 0.9 && near[2] < 1.1 && (far[0] - 1.0).abs() < 0.06);
    assert!(v[0].abs() < 0.01 && v[1] < 0.05 && v[2] > v[1] && v[3] > v[2]);
}

/// φ_eff, F, and both polarizations (medians over all λ and ω_i).
fn parameters(species: &Species) {
    let name = species.name;
    let (material, _) = species.fitted(false);
    let (polarized, _) = species.fitted(true);
    let axes = &material.axes;
    let phis = axes.cos_phi.len();
    let lobe = |node: usize| {
        let set = &material.sets[0].mean;
        Lobe { m: f64::from(set.m[node]), phi: f64::from(set.phi[node]) }
    };
    let cosines = |node: usize| (axes.cos_theta[node / phis % 3], axes.cos_phi[node % phis]);
    let off: Vec<f64> =
        (0..axes.len()).map(|node| (lobe(node).phi - cosines(node).1.acos()).abs().to_degrees()).collect();
    let apart = [median(off.clone()), off.iter().copied().fold(0.0, f64::max)];
    let f = |node: usize| {
        let theta = cosines(node).0.acos();
        let integral = lobe_integral(lobe(node), theta, material.sigma).unwrap();
        f64::from(material.sets[0].mean.reflected[node]) / integral
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
    let m = middle(&|n| f64::from(one.mean.m[n] / two.mean.m[n]));
    let phi = middle(&|n| f64::from((one.mean.phi[n] - two.mean.phi[n]).abs()).to_degrees());
    let l = middle(&|n| f64::from(one.length[n] / two.length[n]));
    println!("| {name} | {:.2}° | {:.1}° | {grazing:.2} | {m:.3} | {phi:.2}° | {l:.3} |", apart[0], apart[1]);
    // An arch reflects each wavelength from a place of its own.
    let arch = name == "rock-dove";
    assert!(apart[0] < if arch { 2.0 } else { 1.0 } && apart[1] < if arch { 20.0 } else { 7.0 });
    assert!(grazing > 3.0);
    assert!((m - 1.0).abs() < 0.04 && phi < 0.1 && (l - 1.0).abs() < 0.01);
}

/// Contrast, correlation, energy and lengths.
fn synthesized(species: &Species) {
    let name = species.name;
    let (material, report) = species.fitted(false);
    let count = report.patterns.len() as f64;
    let mean = |side: usize| report.patterns.iter().map(|p| p.contrast[side]).sum::<f64>() / count;
    let apart = report.patterns.iter().map(|p| (p.contrast[0] - p.contrast[1]).abs()).fold(0.0, f64::max);
    let balance: f64 = report.patterns.iter().map(|p| p.balance).sum();
    let correlation =
        |side: usize| report.patterns.iter().map(|p| p.balance * p.correlation[side]).sum::<f64>() / balance;
    let noise = Noise::new(&material.noise_power, material.seed);
    let node = material.axes.index(1, 2, 3);
    let synthesis = Synthesis::new(&material, node);
    let step = std::f64::consts::PI / AZIMUTHS as f64;
    let drawn: f64 = (0..2000).map(|n| step * synthesis.intensity(&noise, n).iter().sum::<f64>()).sum();
    let reflected = &species.statistics.reflected[2 * node..2 * node + 2];
    let energy = drawn / 2000.0 / (0.5 * (reflected[0] + reflected[1]));
    println!(
        "| {name} | {:.3} / {:.3} | {apart:.2} | {:.3} / {:.3} | {energy:.3} |",
        mean(0),
        mean(1),
        correlation(0),
        correlation(1),
    );
    let found = [(0, 3), (2, 3), (0, 2)].map(|(wave, phi)| lengths(species, &material, wave, phi));
    let cells: Vec<String> = found.iter().flatten().map(|[a, b]| format!("{a:.4} / {b:.4}")).collect();
    println!("| {name}, 1/e lengths | {} |", cells.join(" | "));
    let arch = name == "rock-dove";
    assert!((mean(0) - mean(1)).abs() < 0.03 && apart < 0.12);
    // Near Brewster's angle the weaker polarization has a pattern of its own, which shared noise does not know.
    assert!(correlation(1) - correlation(0) < if arch { 0.15 } else { 0.06 });
    assert!((energy - 1.0).abs() < 0.01);
    // The seed finds 1.70 (S.31); pure scaling with the wavelength would give 1.735.
    assert!((1.6..1.8).contains(&report.longest_length[0]));
    for [fields, intensities] in found {
        let apart = |[a, b]: [f64; 2]| (b / a - 1.0).abs();
        // An arch's steady part changes its phase over the lobe, which only fields show.
        assert!(arch || apart(fields) < 0.03, "{fields:?}");
        assert!(apart(intensities) < if arch { 0.18 } else { 0.09 }, "{intensities:?}");
    }
}

#[test]
fn fields_are_the_speckle_that_instances_are_made_of() {
    println!(
        "\n| species | rejected, steep | oblique | σ_R/σ_I, steep | oblique | V/U at φ_i = 0°, 46°, 70°, 84° |"
    );
    quick().iter().for_each(speckle);
}

#[test]
fn parameters_behave_as_published() {
    println!(
        "\n| species | median of \\|φ_eff − φ_i\\| | largest | F at grazing over the next | m₁/m₂ | \\|φ₁ − φ₂\\| | l₁/l₂ |"
    );
    quick().iter().for_each(parameters);
}

#[test]
fn synthesized_instances_vary_as_the_simulated_ones() {
    println!("\n| species | contrast | largest difference | correlation of polarizations | ρ |");
    println!(
        "| 1/e lengths of | fields, 400 nm | intensities | fields, 694 nm | intensities | fields, 400 nm, 46° | intensities |"
    );
    quick().iter().for_each(synthesized);
}

#[test]
#[ignore = "takes as long as the others together"]
fn hummingbirds_keep_the_same_laws() {
    println!();
    speckle(hummingbird());
    parameters(hummingbird());
    synthesized(hummingbird());
}

/// Writes `docs/figures/qq.png`.
#[test]
#[ignore = "draws a figure of the documentation"]
fn the_quantile_plot() {
    let mut page = Drawing::new(0.0, 0.0);
    for (number, species) in quick().iter().chain([hummingbird()]).enumerate() {
        let mut figure = Figure::new(
            species.name,
            Axis::with_range("normal quantile", -4.0, 4.0),
            Axis::with_range("R and I over their deviation", -4.0, 4.0),
        );
        figure.size = [260.0, 260.0];
        let line = Some(Stroke::solid(Ink::of([150, 150, 150]), 2.4));
        figure.curves.push(Curve { stroke: line, ..Curve::line("normal", vec![[-4.0, -4.0], [4.0, 4.0]]) });
        for (label, steep) in [("steep", true), ("oblique", false)] {
            let mut values = Vec::new();
            for (_, samples) in species.samples().filter(|(node, _)| species.is_steep(*node) == steep) {
                for sample in samples.iter().step_by(4) {
                    for part in [|v: &Complex64| v.re, |v: &Complex64| v.im] {
                        let parts: Vec<f64> = sample.iter().map(part).collect();
                        let (mean, deviation) = moments(&parts);
                        values.extend(parts.iter().map(|v| (v - mean) / deviation));
                    }
                }
            }
            values.sort_by(f64::total_cmp);
            let normal = statrs::distribution::Normal::standard();
            let points = (0..400).map(|k| {
                let share = (f64::from(k) + 0.5) / 400.0;
                let quantile = statrs::distribution::ContinuousCDF::inverse_cdf(&normal, share);
                [quantile, values[(share * values.len() as f64) as usize]]
            });
            figure.curves.push(Curve::line(label, points.collect()));
        }
        let chart = figure.draw();
        let (width, height) = (chart.width, chart.height);
        let (column, row) = ((number % 2) as f64, (number / 2) as f64);
        page.place(chart, [column * width, row * height]);
        (page.width, page.height) = (2.0 * width, 2.0 * height);
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/figures/qq.png");
    barbule::io::write_whole(&path, &page.encode(Format::Png, &[]).unwrap()).unwrap();
}
