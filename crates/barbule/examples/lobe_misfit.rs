//! How far materials of 50 barbules are from the mean of many, and how much of it is the lobes' form.
//!
//! `target/release/examples/lobe_misfit SPECIES… [--instances 1000]` (after `cargo build --release --workspace --examples`),
//! a table in Markdown: relative L2 distances over φ_o, median / 95th percentile over five wavelengths and the directions
//! with cosθ_i cosφ_i ≥ 0.1.

#![allow(clippy::print_stdout)] // a program that prints

use barbule::brdf::fit::{FitOptions, LobeForm, fit, fitted};
use barbule::campaign::{Campaign, CampaignParameters, Resources, places, statistics};
use barbule::material::Library;
use barbule::progress::Unobserved;
use barbule::scattering::directions::azimuths;
use barbule::scattering::lobe::{FitKind, Fitter};
use barbule::scattering::statistics::{AZIMUTHS, Axes, Statistics};
use barbule::spectrum::Wavelengths;
use barbule::structure::{SpeciesModel, Structure};
use barbule::{Error, Result};

/// Instances of a default campaign.
const FEW: usize = 50;

/// Directions nearer to grazing are left out.
const GRAZING: f64 = 0.1;

fn main() -> Result<()> {
    let mut species = Vec::new();
    let mut many = 1000;
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        if word == "--instances" {
            let count = words.next().and_then(|count| count.parse().ok());
            many = count.ok_or_else(|| Error::input("--instances needs a number"))?;
        } else {
            species.push(word);
        }
    }
    println!(
        "| species | speckle of {FEW} | one lobe's form | two lobes' form | material of {FEW}, one lobe | two lobes |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    for name in species {
        let cells = distances(&name, many)?
            .map(|[median, high]| format!("{:.1} % / {:.1} %", 100.0 * median, 100.0 * high));
        println!("| {name} | {} |", cells.join(" | "));
    }
    Ok(())
}

fn simulate(species: &str, instances: usize, seed: u64) -> Result<Statistics> {
    let structure = Structure::Species(Box::new(SpeciesModel::builtin(species, None, Library::builtin())?));
    let wavelengths = Wavelengths::new([400.0, 478.0, 550.0, 622.0, 694.0])?;
    let cos_phi = (1..=10).map(|k| f64::from(k) / 10.0).collect();
    let axes = Axes::new(&wavelengths, vec![0.25, 0.5, 0.75, 1.0], cos_phi)?;
    let (tilt, places) = (2f64.to_radians(), places(&structure, instances));
    let parameters = CampaignParameters { axes, instances, seed, tilt, mirror: false, places };
    statistics(&Campaign::new(&structure, parameters, &Resources::default(), &Unobserved)?, &Unobserved)
}

/// Median and 95th percentile of the speckle of few instances, of the form of one and of two lobes, and of the materials of
/// few instances.
fn distances(species: &str, many: usize) -> Result<[[f64; 2]; 5]> {
    // Other barbules: the few are no part of the many.
    let (few, many) = (simulate(species, FEW, 1)?, simulate(species, many, 2)?);
    let material = |lobe| fit(&few, &FitOptions { lobe, ..FitOptions::default() }, &Unobserved);
    let materials = [material(LobeForm::Ggx)?.0, material(LobeForm::Pair)?.0];
    let axes = &many.axes;
    let phi_o: Vec<f64> = azimuths(AZIMUTHS).collect();
    let mut found: [Vec<f64>; 5] = Default::default();
    for theta in 0..axes.cos_theta().len() {
        let fitter = Fitter::new(FitKind::Marginal, axes.theta_i(theta), AZIMUTHS);
        for phi in 0..axes.phis() {
            let cosine = axes.cos_phi()[axes.cosine_of(phi)];
            if axes.cos_theta()[theta] * cosine < GRAZING - 1e-12 {
                continue;
            }
            let is_even = cosine > 1.0 - 1e-12;
            for wave in 0..axes.wavelengths_nm().len() {
                let node = axes.index(wave, theta, phi);
                let true_mean = mean(&many, node, is_even);
                let forms = if is_even {
                    [fitter.fit_m(0.0, &true_mean).residual, fitter.fit_even_pair(&true_mean).residual]
                } else {
                    let phi_i = axes.phi_i(phi);
                    [fitter.fit(phi_i, &true_mean).residual, fitter.fit_pair(phi_i, &true_mean).residual]
                };
                let of_material = materials.each_ref().map(|material| {
                    let [first, second] = fitted(material, node, &phi_o);
                    let mean = first.mean.iter().zip(&second.mean).map(|(a, b)| 0.5 * (a + b));
                    apart(&mean.collect::<Vec<_>>(), &true_mean)
                });
                let speckle = apart(&mean(&few, node, is_even), &true_mean);
                let all = [speckle, forms[0], forms[1], of_material[0], of_material[1]];
                for (values, value) in found.iter_mut().zip(all) {
                    values.push(value);
                }
            }
        }
    }
    Ok(found.map(|mut values| {
        values.sort_by(f64::total_cmp);
        [0.5, 0.95].map(|q| values[((values.len() - 1) as f64 * q).round() as usize])
    }))
}

/// U, mean over the polarizations and, where light is its own mirror image, over both sides.
fn mean(statistics: &Statistics, node: usize, is_even: bool) -> Vec<f64> {
    let row = |p: usize| &statistics.u[(node * 2 + p) * AZIMUTHS..][..AZIMUTHS];
    let mean: Vec<f64> = row(0).iter().zip(row(1)).map(|(a, b)| 0.5 * f64::from(a + b)).collect();
    if is_even { mean.iter().zip(mean.iter().rev()).map(|(a, b)| 0.5 * (a + b)).collect() } else { mean }
}

/// ‖a − b‖/‖b‖.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (difference / b.iter().map(|b| b * b).sum::<f64>()).sqrt()
}
