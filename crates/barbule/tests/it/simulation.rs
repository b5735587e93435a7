//! The fast simulation over random species, variants, directions and wavelengths: energy, and its reference.
//!
//! `cargo test --release -p barbule --test it simulation -- --nocapture --test-threads 1` prints the tables of
//! `docs/theory/simulation.md`.

use std::f64::consts::PI;

use barbule::campaign::spectrum::{Collect, SpectrumRequest, spectra};
use barbule::campaign::{Campaign, Keep, Parameters};
use barbule::material::Library;
use barbule::math::rng::Stream;
use barbule::math::simd::Width;
use barbule::progress::Unobserved;
use barbule::scattering::far_field::{Illumination, Window};
use barbule::scattering::statistics::{AZIMUTHS, Axes};
use barbule::solve::direct;
use barbule::solve::surface::{FINE_ELEMENT_UM, far_field};
use barbule::spectrum::Wavelengths;
use barbule::structure::{
    Medium, Parts, Polyline, Section, SpeciesFile, SpeciesModel, Structure, Substance, layered_species,
};
use num_complex::Complex64;

/// Roughness of the tops: τ, amplitude and width in µm, of which species.
const ROWS: [(f64, f64, f64, &str); 5] = [
    (1.0, 0.08, 20.0, "rock dove"),
    (1.5, 0.3, 25.0, "starling"),
    (1.5, 0.2, 40.0, "bronzewing"),
    (1.5, 0.25, 40.0, "hummingbird"),
    (1.2, 0.3, 40.0, "mallard, magpie"),
];

/// R(τ; −height, height) on a flat perfect mirror (r_s = −1, r_p = +1 to 2e-6).
fn mirror(width_um: f64, tau: f64, height: f64, seed: u64) -> Section {
    let mut stream = Stream::new(seed, &[1]);
    let waves: Vec<(f64, f64, f64)> = (1..80)
        .map(|n| {
            let f = f64::from(n) / (1.5 * width_um);
            ((-(PI * f * tau).powi(2)).exp(), 2.0 * PI * f, stream.uniform(0.0, 2.0 * PI))
        })
        .collect();
    let count = (width_um / 0.03).round() as usize;
    let x_um: Vec<f64> = (0..=count).map(|i| width_um * (i as f64 / count as f64 - 0.5)).collect();
    let raw: Vec<f64> =
        x_um.iter().map(|x| waves.iter().map(|(a, k, p)| a * (k * x + p).cos()).sum()).collect();
    let low = raw.iter().copied().fold(f64::MAX, f64::min);
    let high = raw.iter().copied().fold(f64::MIN, f64::max);
    let z_um = raw.iter().map(|v| height * (2.0 * (v - low) / (high - low) - 1.0)).collect();
    let parts = Parts {
        name: "mirror".into(),
        width_um: Some(width_um),
        boundaries: vec![Polyline { x_um, z_um }],
        media: vec![Medium::named("air"), Medium::Pure(Substance::Index(Complex64::new(0.0, 1e6)))],
        ..Parts::default()
    };
    Section::new(parts, Library::builtin()).unwrap()
}

/// Φ_r/Φ_i of one section, `[direction][wavelength]`, for one incident polarization.
fn reflected(
    section: &Section,
    wavelengths_nm: &[f64],
    directions: &[(f64, f64)],
    polarization: usize,
) -> Vec<Vec<f64>> {
    let structure = Structure::Sections { name: "one".into(), sections: vec![section.clone()] };
    let request = SpectrumRequest {
        wavelengths: Wavelengths::new(wavelengths_nm).unwrap(),
        directions: directions.to_vec(),
        instances: 1,
        seed: 1,
        collect: Collect::Hemisphere,
        polarization: if polarization == 0 { [1.0, 0.0] } else { [0.0, 1.0] },
    };
    spectra(&structure, &request, Width::best(), &Unobserved).unwrap().mean
}

#[test]
fn rough_mirrors_conserve_energy() {
    let steep = [0.0, 15.0, 30.0, 45.0];
    let oblique = [50.0, 60.0, 70.0, 80.0];
    println!("\n| roughness | φ_i ≤ 45°: mean of 50 | extremes | 50° | 60° | 70° | 80° (mean, largest) |");
    for (tau, height, width, name) in ROWS {
        let mut values = vec![Vec::new(); 8];
        for seed in 0..50 {
            let section = mirror(width, tau, height, seed);
            let angles: Vec<(f64, f64)> =
                steep.iter().chain(&oblique).map(|d: &f64| (0.0, d.to_radians())).collect();
            let nm = 400.0 + 6.0 * seed as f64;
            let polarization = (seed % 2) as usize;
            for (all, value) in values.iter_mut().zip(reflected(&section, &[nm], &angles, polarization)) {
                all.push(value[0]);
            }
        }
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let low = |v: &[f64]| v.iter().copied().fold(f64::MAX, f64::min);
        let high = |v: &[f64]| v.iter().copied().fold(0.0, f64::max);
        let small: Vec<f64> = values[..4].concat();
        let cells: Vec<String> =
            values[4..].iter().map(|v| format!("{:.3}, {:.3}", mean(v), high(v))).collect();
        let worst = values[..4].iter().map(|v| (mean(v) - 1.0).abs()).fold(0.0, f64::max);
        println!(
            "| {name}: τ {tau}, ±{height}, W {width} | {:.4} (worst angle {worst:.4}) | {:.4}–{:.4} | {} |",
            mean(&small),
            low(&small),
            high(&small),
            cells.join(" | ")
        );
        assert!(worst < 5e-3, "{name}: {worst}");
        // The steepest slopes of all, of the lattice species' tops, shade each other at 45° already.
        assert!(small.iter().all(|v| (v - 1.0).abs() < if tau < 1.5 && height > 0.2 { 0.025 } else { 0.02 }));
    }
}

/// A random section of a random variant of each species, `count` of each.
fn sections(count: u64) -> impl Iterator<Item = (String, Section, Stream)> {
    layered_species().flat_map(move |species| {
        (0..count).map(move |number| {
            let mut stream = Stream::new(number, &[77, species.len() as u64]);
            let file = SpeciesFile::builtin(species).unwrap();
            let variants: Vec<&str> = file.variants().collect();
            let variant = variants[(stream.unit() * variants.len() as f64) as usize];
            let model = SpeciesModel::builtin(species, Some(variant), Library::builtin()).unwrap();
            let section = model.section(5, (stream.unit() * 1000.0) as usize).unwrap();
            (format!("{species}:{variant}"), section, stream)
        })
    })
}

#[test]
fn no_barbule_reflects_more_than_it_receives() {
    let (mut worst, mut below) = ((0f64, String::new()), (0f64, String::new()));
    for (name, section, mut stream) in sections(6) {
        let mut wavelengths = [0; 3].map(|_| stream.uniform(400.0, 694.0));
        wavelengths.sort_by(f64::total_cmp);
        // Every third direction near the limit, where mirrors of their own slopes would exceed it.
        let mut directions = Vec::new();
        while directions.len() < 12 {
            let (theta, phi) = (stream.uniform(-1.5, 1.5), stream.uniform(-1.5, 1.5));
            let steepness = theta.cos() * phi.cos();
            if directions.len() % 3 != 0 || steepness < 0.2 {
                directions.push((theta, phi));
            }
        }
        directions.sort_by(|a, b| a.0.total_cmp(&b.0));
        for polarization in 0..2 {
            for (row, (theta, phi)) in
                reflected(&section, &wavelengths, &directions, polarization).iter().zip(&directions)
            {
                let highest = row.iter().copied().fold(0.0, f64::max);
                let place = if theta.cos() * phi.cos() >= 0.1 { &mut worst } else { &mut below };
                if highest > place.0 {
                    let (t, p) = (theta.to_degrees(), phi.to_degrees());
                    *place = (
                        highest,
                        format!("{name}, θ_i {t:.0}°, φ_i {p:.0}°, polarization {}", polarization + 1),
                    );
                }
            }
        }
    }
    println!("\nlargest Φ_r/Φ_i with cosθ cosφ ≥ 0.1: {worst:?}, below: {below:?}");
    assert!(worst.0 <= 1.01, "{worst:?}");
}

fn beam(wavelength_nm: f64, theta_i: f64, phi_i: f64) -> Illumination {
    Illumination { wavelength_nm, theta_i, phi_i, window: Window::Gaussian }
}

/// ‖a − b‖/‖b‖.
fn relative_l2(a: &[Complex64], b: &[Complex64]) -> f64 {
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum();
    (difference / b.iter().map(Complex64::norm_sqr).sum::<f64>()).sqrt()
}

#[test]
fn double_precision_equals_the_plain_evaluation_for_random_barbules() {
    let mut worst = (0f64, 0f64);
    for (name, section, mut stream) in sections(2) {
        let nm = stream.uniform(400.0, 694.0);
        let (theta, phi) = (stream.uniform(-1.3, 1.3), stream.uniform(-1.3, 1.3));
        // A coarse sum of both: they must agree whatever the elements.
        let element = 0.05;
        let light = beam(nm, theta, phi);
        let fast = far_field(&section, element, &light, 100, Width::best()).unwrap();
        let plain = direct::far_field(&section, element, &light, 100).unwrap();
        for p in 0..2 {
            let error = relative_l2(&fast.amplitudes[p].concat(), &plain.amplitudes[p].concat());
            let power = (fast.radiated[p] / plain.radiated[p] - 1.0).abs();
            worst = (worst.0.max(error), worst.1.max(power));
            assert!(error < 1e-9 && power < 1e-9, "{name} {nm} {theta} {phi}: {error:e} {power:e}");
        }
    }
    println!("\ndouble precision against plain: {worst:?}");
}

/// Error of a campaign's field (relative L2): 3.8e-4 is reached, of which what rays average is the largest part;
/// reflectance tables (3e-5) and nodes (8e-5) are smaller ones.
const CAMPAIGN_FIELD: f64 = 4e-4;

/// Relative error of its reflected power: 2.3e-4 is reached.
const CAMPAIGN_POWER: f64 = 2.5e-4;

#[test]
fn campaigns_equal_converged_fields_for_random_barbules() {
    let mut worst = [0f64; 2];
    for (name, section, mut stream) in sections(3) {
        let nm = stream.uniform(400.0, 694.0);
        let cosines = [stream.uniform(0.1, 1.0), stream.uniform(0.1, 1.0)];
        let wavelengths = Wavelengths::new([nm]).unwrap();
        let axes = Axes::new(&wavelengths, vec![cosines[0]], vec![cosines[1], 1.0]).unwrap();
        let structure = Structure::Sections { name: name.clone(), sections: vec![section.clone()] };
        let parameters = Parameters { axes: axes.clone(), instances: 1, seed: 1, tilt: 0.0 };
        let campaign = Campaign::new(&structure, parameters, Width::best(), &Unobserved).unwrap();
        let unit = campaign.unit(&campaign.tables(0, &Unobserved).unwrap(), 0, Keep::Fields);
        // Voids have sharp ends: their fields settle last.
        let element = FINE_ELEMENT_UM * if name.starts_with("hummingbird") { 0.25 } else { 0.5 };
        for number in 0..axes.cos_phi.len() {
            let (theta, phi) = (axes.theta_i(0), axes.phi_i(number));
            let exact = far_field(&section, element, &beam(nm, theta, phi), AZIMUTHS, Width::best()).unwrap();
            for p in 0..2 {
                let at = (number * 2 + p) * 2 * AZIMUTHS;
                let single: Vec<Complex64> = unit.fields[at..at + 2 * AZIMUTHS]
                    .iter()
                    .map(|v| Complex64::new(f64::from(v.re), f64::from(v.im)))
                    .collect();
                let error = relative_l2(&single, &exact.amplitudes[p].concat());
                let power = (unit.reflected[number * 2 + p] / exact.radiated[p] - 1.0).abs();
                println!(
                    "{name} {nm:.0} nm, {} rays per element: {error:.1e} {power:.1e}",
                    2 * campaign.ray_parts().unwrap_or(0)
                );
                worst = [worst[0].max(error), worst[1].max(power)];
            }
        }
    }
    println!("\ncampaigns against converged fields (field, power): {worst:.6?}");
    assert!(worst[0] < CAMPAIGN_FIELD && worst[1] < CAMPAIGN_POWER, "{worst:?}");
}
