//! A material beside the barbules that it was simulated from: fits, fields, noise, instances.

use crate::Result;
use crate::brdf::fit::{fitted_scale, fitted_values};
use crate::brdf::{FeatherMaterial, LobeSet, Noise, Synthesis};
use crate::campaign::single::{Patterns, intensities};
use crate::campaign::{Keep, statistics};
use crate::characterize::Barbules;
use crate::plot::{Anchor, Axis, Curve, Drawing, Figure, Ink, Item, Picture, Stroke};
use crate::scattering::directions::azimuths;
use crate::scattering::far_field::Polarization;
use crate::scattering::lobe::Lobe;
use crate::scattering::statistics::{AZIMUTHS, Axes, LAGS, NOISE_POINTS, Statistics};
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::{Observer, Weights, display, luminance};

use super::three;

/// What U and V are, and the squared modulus of a field over √Φ_i.
const PER_RADIAN: &str = "c₀|E|²/Φ_i (1/rad)";

/// Most wavelengths that the colours of instances are made of.
const COLOUR_SAMPLES: usize = 25;

/// Height of a strip of the specular cone, and its least distance to the next.
const STRIP: [f64; 2] = [20.0, 4.0];

fn nearest(values: &[f64], wanted: f64) -> usize {
    let apart = |k: &usize| (values[*k] - wanted).abs();
    (0..values.len()).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(0)
}

/// A faint line for what another panel shows.
fn ghost() -> Option<Stroke> {
    Some(Stroke::solid(Ink::of([150, 150, 150]), 2.4))
}

/// φ_i of the fits by their places on the axes: those nearest to 70° and 0°.
fn fitted_phis(axes: &Axes) -> Vec<usize> {
    let mut phis = vec![nearest(axes.cos_phi(), 70.0_f64.to_radians().cos()), nearest(axes.cos_phi(), 1.0)];
    phis.dedup();
    phis
}

/// The statistics that [`fits`] draws, of a material whose store is gone: simulated again.
///
/// # Errors
/// As [`Barbules::campaign`].
pub fn statistics_of_fits(material: &FeatherMaterial, barbules: &Barbules<'_>) -> Result<Statistics> {
    let from = &material.axes;
    let nm: Vec<f64> = three(from).into_iter().map(|k| from.wavelengths_nm()[k]).collect();
    let cos_theta = vec![from.cos_theta()[from.cos_theta().len() - 1]];
    let cos_phi = fitted_phis(from).iter().map(|k| from.cos_phi()[*k]).collect();
    let axes = Axes::new(&Wavelengths::new(nm)?, cos_theta, cos_phi)?;
    statistics(&barbules.campaign(axes, None, true)?, barbules.progress())
}

/// Simulated and fitted U and V over φ_o, at θ_i nearest to 0 and φ_i nearest to 0° and 70°, at three wavelengths.
#[must_use]
pub fn fits(material: &FeatherMaterial, statistics: &Statistics) -> Vec<Drawing> {
    let axes = &material.axes;
    let theta = axes.cos_theta().len() - 1;
    let phis = fitted_phis(axes);
    let found = &statistics.axes;
    let mut charts = Vec::new();
    for &wave in &three(axes) {
        for &phi in phis.iter().rev() {
            let node = axes.index(wave, theta, phi);
            let place = found.index(
                nearest(found.wavelengths_nm(), axes.wavelengths_nm()[wave]),
                nearest(found.cos_theta(), axes.cos_theta()[theta]),
                nearest(found.cos_phi(), axes.cos_phi()[phi]),
            );
            let title = format!(
                "{:.0} nm, θ_i = {:.0}°, φ_i = {:.0}°",
                axes.wavelengths_nm()[wave],
                axes.theta_i(theta).to_degrees(),
                axes.phi_i(phi).to_degrees()
            );
            let mut figure =
                Figure::new(title, Axis::with_range("φ_o (°)", -90.0, 90.0), Axis::new(PER_RADIAN));
            figure.size = [420.0, 230.0];
            for (label, fitted, array, part) in
                [("U", "U′ (fitted)", &statistics.u, 0), ("V", "s (steady part)", &statistics.v, 1)]
            {
                let curve = |name: &str, values: Vec<f64>| {
                    let points = azimuths(AZIMUTHS).map(f64::to_degrees).zip(values);
                    Curve::line(name, points.map(|(x, y)| [x, y]).collect())
                };
                let measured = mean_over_polarizations(array, place);
                figure.curves.push(curve(&format!("{label} (simulated)"), measured));
                figure.curves.push(curve(fitted, fitted_mean(material, node, part)));
            }
            charts.push(figure.draw());
        }
    }
    charts
}

fn mean_over_polarizations(array: &[f32], node: usize) -> Vec<f64> {
    let part = |p: usize| &array[(node * 2 + p) * AZIMUTHS..][..AZIMUTHS];
    part(0).iter().zip(part(1)).map(|(a, b)| 0.5 * f64::from(a + b)).collect()
}

/// U' (`part` 0) or s (1) of the material, mean over its sets.
fn fitted_mean(material: &FeatherMaterial, node: usize, part: usize) -> Vec<f64> {
    let axes = &material.axes;
    let theta = axes.theta_i(node / axes.cos_phi().len() % axes.cos_theta().len());
    let mut sum = vec![0.0; AZIMUTHS];
    for set in &material.sets {
        let lobe: &LobeSet = if part == 0 { &set.mean } else { &set.stationary };
        let shape = Lobe { m: f64::from(lobe.m[node]), phi: f64::from(lobe.phi[node]) };
        let values = fitted_values(material.kind, shape, theta, f64::from(lobe.reflected[node]));
        for (sum, value) in sum.iter_mut().zip(values) {
            *sum += value / material.sets.len() as f64;
        }
    }
    sum
}

/// R of one barbule against x_o for three φ_i (left) and three wavelengths (right), grey the first pattern shifted or
/// stretched; below R as it is and weighted.
///
/// # Errors
/// As [`Barbules::campaign`].
pub fn fields(material: &FeatherMaterial, barbules: &Barbules<'_>) -> Result<Vec<Drawing>> {
    let waves = three(&material.axes);
    let nm: Vec<f64> = waves.iter().map(|k| material.axes.wavelengths_nm()[*k]).collect();
    let angles = [40.0_f64, 20.0, 0.0];
    let cos_phi = angles.iter().map(|a| a.to_radians().cos()).collect();
    let axes = Axes::new(&Wavelengths::new(nm.clone())?, vec![1.0], cos_phi)?;
    let campaign = barbules.campaign(axes, Some(1), false)?;
    let at_normal = (0..nm.len())
        .map(|w| {
            let tables = campaign.tables(w, barbules.progress())?;
            campaign.patterns(&tables, 0, 2, Polarization::First, barbules.progress())
        })
        .collect::<Result<Vec<_>>>()?;
    let shortest = campaign.tables(0, barbules.progress())?;
    let oblique = [1, 0]
        .map(|phi| campaign.patterns(&shortest, 0, phi, Polarization::First, barbules.progress()))
        .into_iter()
        .collect::<Result<Vec<_>>>()?;
    let first = &at_normal[0];
    let mut left = vec![panel(format!("{:.0} nm, φ_i = 0°", nm[0]), "R (1/√rad)", first, None).draw()];
    for (pattern, angle) in oblique.into_iter().zip([20.0_f64, 40.0]) {
        let moved = Curve {
            stroke: ghost(),
            ..curve("φ_i = 0°, shifted", first, |x| x - angle.to_radians().sin())
        };
        let title = format!("{:.0} nm, φ_i = {angle:.0}°: the pattern shifts by −Δx_i", nm[0]);
        left.push(panel(title, "R (1/√rad)", &pattern, Some(moved)).draw());
    }
    let mut right = Vec::new();
    for (pattern, wave) in at_normal.iter().zip(&nm) {
        let ratio = wave / nm[0];
        let stretched = (ratio != 1.0)
            .then(|| Curve { stroke: ghost(), ..curve("shortest λ, stretched", first, |x| x * ratio) });
        let title = if stretched.is_some() {
            format!("{wave:.0} nm, φ_i = 0°: the pattern stretches with λ")
        } else {
            format!("{wave:.0} nm, φ_i = 0°")
        };
        right.push(panel(title, "R (1/√rad)", pattern, stretched).draw());
    }
    let plain = panel(format!("the field R, {:.0} nm, φ_i = 0°", nm[0]), "R (1/√rad)", first, None).draw();
    // One barbule's own intensity is no lobe: the weight is the material's.
    let mut weighted = first.clone();
    weighted.fitted = fitted_at(material, &first.phi_o);
    weighted.fields = vec![weighted.weighted(0)];
    let below =
        panel("weighted for its autocovariance, r = √U′ R".into(), "r (1/rad)", &weighted, None).draw();
    // A material of fewer wavelengths leaves places empty.
    let right = right.into_iter().chain(std::iter::repeat_with(|| Drawing::new(0.0, 0.0)));
    let mut page: Vec<Drawing> = left.into_iter().zip(right).flat_map(|(a, b)| [a, b]).collect();
    page.extend([plain, below]);
    Ok(page)
}

/// U' of the shortest wavelength at normal incidence, at other azimuths than those of the tables.
fn fitted_at(material: &FeatherMaterial, phi_o: &[f64]) -> Vec<f64> {
    let node = material.axes.index(0, material.axes.cos_theta().len() - 1, material.axes.cos_phi().len() - 1);
    let set = &material.sets[0].mean;
    let lobe = Lobe { m: f64::from(set.m[node]), phi: f64::from(set.phi[node]) };
    let scale = fitted_scale(material.kind, lobe, 0.0, f64::from(set.reflected[node]));
    phi_o.iter().map(|phi| scale * lobe.shape(material.kind, 0.0, *phi)).collect()
}

fn curve(name: &str, pattern: &Patterns, place: impl Fn(f64) -> f64) -> Curve {
    let points = pattern.x.iter().zip(&pattern.fields[0]).map(|(x, field)| [place(*x), field.re]);
    Curve::line(name, points.collect())
}

fn panel(title: String, label: &str, pattern: &Patterns, below: Option<Curve>) -> Figure {
    let mut figure = Figure::new(title, Axis::with_range("x_o", -1.0, 1.0), Axis::new(label));
    figure.size = [520.0, 150.0];
    figure.curves.extend(below);
    let own = Curve { stroke: Some(crate::plot::style(0)), ..curve("simulated", pattern, |x| x) };
    figure.curves.push(own);
    figure
}

/// Autocovariances of single barbules and their mean, the stretched C₀, the spectrum and some functions of the noise;
/// only what the material itself holds without its barbules.
///
/// # Errors
/// As [`Barbules::campaign`].
pub fn noise(material: &FeatherMaterial, barbules: Option<&Barbules<'_>>) -> Result<Vec<Drawing>> {
    let noise = Noise::new(&material.noise_power, material.seed);
    let mut charts = match barbules {
        Some(barbules) => covariances(material, &noise, barbules)?,
        None => {
            let mut figure = covariance_figure("autocovariance C₀");
            figure.curves.push(lags("C₀", noise.autocovariance(), 1.0));
            vec![figure.draw()]
        }
    };
    let terms = material.noise_power.iter().enumerate();
    let last = material.noise_power.iter().rposition(|p| *p > 1e-3 * 0.5 / LAGS as f64).unwrap_or(LAGS) + 2;
    let end = (last as f64 * 1.2).min(LAGS as f64);
    let mut power = Figure::new(
        "power spectrum of the noise",
        Axis::with_range("term l (periods in x = −1 … 1)", 0.0, end),
        Axis::new("P"),
    );
    power.curves.push(Curve::line("P", terms.map(|(l, p)| [(l + 1) as f64, *p]).collect()));
    power.size = [420.0, 260.0];
    let mut functions =
        Figure::new("q_r of three instances", Axis::with_range("x", -1.0, 1.0), Axis::new("q"));
    functions.size = [420.0, 260.0];
    for instance in 1..=3 {
        let draw = noise.draw(instance);
        let points = (0..=800).map(|k| {
            let x = f64::from(k) / 400.0 - 1.0;
            [x, f64::from(noise.at(&draw, x as f32)[0])]
        });
        functions.curves.push(Curve::line(format!("instance {instance}"), points.collect()));
    }
    charts.extend([power.draw(), functions.draw()]);
    Ok(charts)
}

fn covariance_figure(title: &str) -> Figure {
    let mut figure = Figure::new(title, Axis::with_range("Δx", 0.0, 0.25), Axis::new("autocovariance"));
    figure.size = [420.0, 260.0];
    figure
}

/// An autocovariance over Δx, stretched by `scale`, with value 1 at 0.
fn lags(name: &str, values: &[f64], scale: f64) -> Curve {
    let spacing = 2.0 * scale / NOISE_POINTS as f64;
    let first = values.first().copied().filter(|v| *v > 0.0).unwrap_or(1.0);
    Curve::line(name, values.iter().enumerate().map(|(k, c)| [k as f64 * spacing, c / first]).collect())
}

/// Single barbules' autocovariances with their mean at the shortest wavelength, and the mean at the longest one with
/// C₀ stretched to it; normal incidence.
fn covariances(material: &FeatherMaterial, noise: &Noise, barbules: &Barbules<'_>) -> Result<Vec<Drawing>> {
    let from = &material.axes;
    let all = from.wavelengths_nm();
    let last = all.len() - 1;
    let waves = [all[0], all[last]];
    let normal = (from.cos_theta()[from.cos_theta().len() - 1], from.cos_phi()[from.cos_phi().len() - 1]);
    let mut means = Vec::new();
    let mut single = covariance_figure(&format!("single barbules and their mean, {:.0} nm", waves[0]));
    // A single wavelength is the shortest and the longest.
    let simulated = Wavelengths::new(&waves[..if last == 0 { 1 } else { 2 }])?;
    let axes = Axes::new(&simulated, vec![normal.0], vec![normal.1])?;
    let campaign = barbules.campaign(axes, None, true)?;
    for number in 0..2 {
        let mut mean = vec![0.0; LAGS];
        let tables = campaign.tables(number.min(last), barbules.progress())?;
        for polarization in Polarization::BOTH {
            let patterns = campaign.patterns(&tables, 0, 0, polarization, barbules.progress())?;
            for instance in 0..patterns.fields.len() {
                let own = patterns.autocovariance(instance);
                if number == 0 && polarization == Polarization::First && instance < 3 {
                    single.curves.push(lags(&format!("barbule {}", instance + 1), &own, 1.0));
                }
                for (sum, value) in mean.iter_mut().zip(own) {
                    *sum += value;
                }
            }
        }
        means.push(mean);
    }
    let heavy = Some(Stroke::solid(Ink::BLACK, 2.6));
    single.curves.push(Curve { stroke: heavy, ..lags("mean of all", &means[0], 1.0) });
    let length = f64::from(
        material.sets[0].length[from.index(
            from.wavelengths_nm().len() - 1,
            from.cos_theta().len() - 1,
            from.cos_phi().len() - 1,
        )],
    );
    let mut scaled = covariance_figure(&format!("C at {:.0} nm and C₀ scaled by l = {length:.3}", waves[1]));
    scaled.curves.push(lags("C₀ of the noise", noise.autocovariance(), 1.0));
    scaled.curves.push(lags(&format!("C₀(Δx/{length:.3})"), noise.autocovariance(), length));
    let simulated =
        Curve { stroke: ghost(), ..lags(&format!("simulated, {:.0} nm", waves[1]), &means[1], 1.0) };
    scaled.curves.insert(0, simulated);
    Ok(vec![single.draw(), scaled.draw()])
}

/// `count` simulated beside `count` synthesized instances on their specular cones, for two incident directions: colours
/// over φ_o, and the intensity at the middle wavelength.
///
/// # Errors
/// As [`Barbules::campaign`].
pub fn instances(material: &FeatherMaterial, count: usize, barbules: &Barbules<'_>) -> Result<Drawing> {
    let from = &material.axes;
    let theta = from.cos_theta().len() - 1;
    let mut phis = vec![nearest(from.cos_phi(), 45.0_f64.to_radians().cos()), nearest(from.cos_phi(), 1.0)];
    phis.dedup();
    let every = from.wavelengths_nm().len().div_ceil(COLOUR_SAMPLES);
    let waves: Vec<usize> = (0..from.wavelengths_nm().len()).step_by(every).collect();
    let nm: Vec<f64> = waves.iter().map(|k| from.wavelengths_nm()[*k]).collect();
    let wavelengths = Wavelengths::new(nm.clone())?;
    let weights = Observer::default().weights(&wavelengths);
    let cos_phi = phis.iter().map(|k| from.cos_phi()[*k]).collect();
    let axes = Axes::new(&wavelengths, vec![from.cos_theta()[theta]], cos_phi)?;
    let campaign = barbules.campaign(axes, Some(count), true)?;
    let count = campaign.parameters().instances;
    let kept = (0..waves.len())
        .map(|w| {
            let tables = campaign.tables(w, barbules.progress())?;
            Ok(campaign.unit(&tables, 0, Keep::Fields, barbules.progress())?.fields)
        })
        .collect::<Result<Vec<_>>>()?;
    let noise = Noise::new(&material.noise_power, material.seed);
    let mut columns = Vec::new();
    for place in (0..phis.len()).rev() {
        let node = |wave: usize| from.index(wave, theta, phis[place]);
        let synthesis: Vec<Synthesis> = waves.iter().map(|w| Synthesis::new(material, node(*w))).collect();
        // [side][wavelength][instance][azimuth]
        let simulated = kept.iter().map(|fields| intensities(fields, place, count)).collect();
        let synthesized =
            synthesis.iter().map(|s| (1..=count).map(|n| s.intensity(&noise, n as u64)).collect()).collect();
        let mean = synthesis.iter().map(|s| {
            let [a, b] = s.mean();
            a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect()
        });
        let direction = format!(
            "θ_i = {:.0}°, φ_i = {:.0}°",
            from.theta_i(theta).to_degrees(),
            from.phi_i(phis[place]).to_degrees()
        );
        let column = Column { weights: &weights, nm: &nm, mean: mean.collect(), direction };
        columns.push(column.draw([simulated, synthesized]));
    }
    let mut page = Drawing::new(
        columns.iter().map(|c| c.width).sum(),
        columns.iter().map(|c| c.height).fold(0.0, f64::max),
    );
    let mut x = 0.0;
    for column in columns {
        let width = column.width;
        page.place(column, [x, 0.0]);
        x += width;
    }
    Ok(page)
}

/// One incident direction of the instances.
struct Column<'a> {
    weights: &'a Weights,
    nm: &'a [f64],
    /// `[wavelength][azimuth]`.
    mean: Vec<Vec<f64>>,
    direction: String,
}

impl Column<'_> {
    /// Of `[simulated, synthesized]`, each `[wavelength][instance][azimuth]`.
    fn draw(&self, sides: [Vec<Vec<Vec<f64>>>; 2]) -> Drawing {
        let (left, width) = (64.0, 360.0);
        let colour = |of: &dyn Fn(usize) -> f64| {
            let samples: Vec<f64> = (0..self.nm.len()).map(of).collect();
            self.weights.linear_rgb(&samples)
        };
        let brightest = (0..AZIMUTHS).map(|k| luminance(colour(&|w| self.mean[w][k]))).fold(1e-30, f64::max);
        // Single barbules are a few times as bright as their mean.
        let exposure = 0.4 / brightest;
        let middle = self.nm.len() / 2;
        let highest =
            sides.iter().flat_map(|s| s[middle].iter().flatten()).fold(1e-30, |a: f64, b| a.max(*b));
        let mut page = Drawing::new(left + width + 120.0, 0.0);
        page.text([left + width / 2.0, 22.0], 14.0, Anchor::Middle, self.direction.clone());
        let mut y = 40.0;
        for (side, name) in sides.iter().zip(["simulated", "synthesized"]) {
            let count = side[0].len();
            page.text([left, y + 4.0], 12.0, Anchor::Start, format!("{name} barbules: colour over φ_o"));
            y += 12.0;
            let strip = |instance: usize| {
                let rgba = (0..AZIMUTHS).map(|k| {
                    let rgb = colour(&|w| side[w][instance][k]);
                    let [r, g, b] = display(rgb.map(|v| v * exposure));
                    [r, g, b, 255]
                });
                Picture { width: AZIMUTHS, height: 1, rgba: rgba.collect() }
            };
            for picture in (0..count).map(strip) {
                page.items.push(Item::Picture { area: [left, y, width, STRIP[0]], picture });
                y += STRIP[0] + STRIP[1];
            }
            let mut figure = Figure::new(
                format!("{name}, {:.0} nm", self.nm[middle]),
                Axis::with_range("φ_o (°)", -90.0, 90.0),
                Axis::with_range(PER_RADIAN, 0.0, 1.05 * highest),
            );
            figure.size = [width, 150.0];
            for (instance, values) in side[middle].iter().enumerate() {
                let points = azimuths(AZIMUTHS).map(f64::to_degrees).zip(values).map(|(x, y)| [x, *y]);
                figure.curves.push(Curve::line(format!("number {}", instance + 1), points.collect()));
            }
            let chart = figure.draw();
            let height = chart.height;
            page.place(chart, [0.0, y + 4.0]);
            y += height + 24.0;
        }
        page.height = y;
        page
    }
}
