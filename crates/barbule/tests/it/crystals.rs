//! Barbules over photonic crystals: the fast simulation against its plain reference, closed forms and laws.
//!
//! `cargo test --release -p barbule --test it crystals -- --nocapture --test-threads 1` prints the figures of
//! `docs/theory/simulation.md`.

use barbule::campaign::{Campaign, Keep, Parameters};
use barbule::material::Library;
use barbule::math::rng::Stream;
use barbule::math::simd::Width;
use barbule::progress::Unobserved;
use barbule::scattering::far_field::{FarField, Illumination, Polarization, Window};
use barbule::scattering::statistics::{AZIMUTHS, Axes};
use barbule::solve::crystal::{Cell, CrystalSolver, Incidence, Multipole, Response};
use barbule::solve::direct;
use barbule::solve::surface::{FINE_ELEMENT_UM, far_field};
use barbule::spectrum::Wavelengths;
use barbule::structure::{
    CrystalLayer, Parts, Polyline, Section, SpeciesFile, SpeciesModel, Structure, crystal_species,
};
use num_complex::Complex64;

/// ‖a − b‖/‖b‖.
fn relative_l2(a: &[Complex64], b: &[Complex64]) -> f64 {
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum();
    (difference / b.iter().map(Complex64::norm_sqr).sum::<f64>()).sqrt()
}

/// A random variant of each species and one of its random instances.
fn barbules(seed: u64) -> Vec<(String, Section, Stream)> {
    crystal_species()
        .map(|species| {
            let mut stream = Stream::new(seed, &[species.len() as u64]);
            let file = SpeciesFile::builtin(species).unwrap();
            let variants: Vec<&str> = file.variants().collect();
            let variant = variants[(stream.unit() * variants.len() as f64) as usize];
            let model = file.model(Some(variant), Library::builtin()).unwrap();
            (model.title(), model.section(seed, 0).unwrap(), stream)
        })
        .collect()
}

/// A section with its top cut to the middle `width_um`, so that the plain evaluation stays affordable.
fn narrow(section: &Section, width_um: f64) -> Section {
    let top = section.top();
    let half = 0.5 * width_um;
    let mut x_um = vec![-half];
    x_um.extend(top.x_um.iter().copied().filter(|x| x.abs() < half));
    x_um.push(half);
    let z_um = x_um.iter().map(|&x| top.height(x)).collect();
    under(Polyline { x_um, z_um }, section.crystal.clone().unwrap())
}

fn under(top: Polyline, crystal: CrystalLayer) -> Section {
    let width = top.x_um[top.x_um.len() - 1] - top.x_um[0];
    let media = [&crystal.lattice.incidence, &crystal.lattice.host]
        .map(|medium| barbule::structure::Medium::Pure(medium.clone()))
        .to_vec();
    let library = crystal.lattice.library.clone();
    let parts = Parts {
        name: "test".into(),
        width_um: Some(width),
        boundaries: vec![top],
        media,
        crystal: Some(crystal),
        ..Parts::default()
    };
    Section::new(parts, library).unwrap()
}

fn fast(section: &Section, element_um: f64, nm: f64, theta: f64, phi: f64, azimuths: usize) -> FarField {
    far_field(section, element_um, &beam(nm, theta, phi), azimuths, Width::best()).unwrap()
}

fn beam(wavelength_nm: f64, theta_i: f64, phi_i: f64) -> Illumination {
    Illumination { wavelength_nm, theta_i, phi_i, window: Window::Gaussian }
}

fn layer(species: &str, offset_um: f64) -> CrystalLayer {
    let model = SpeciesModel::builtin(species, None, Library::builtin()).unwrap();
    CrystalLayer { lattice: model.lattice().unwrap(), offset_um, regularity: None }
}

/// The mallard's rods 2.5 times as far apart: at [`SPARSE`] two orders leave a flat top.
fn sparse(offset_um: f64) -> CrystalLayer {
    let mut crystal = layer("mallard", offset_um);
    crystal.lattice.period_um *= 2.5;
    crystal
}

/// A wavelength (nm), θ_i and φ_i (rad).
const SPARSE: (f64, f64, f64) = (450.0, 0.3, 0.3);

fn flat(width_um: f64, crystal: CrystalLayer) -> Section {
    let half = 0.5 * width_um;
    under(Polyline { x_um: vec![-half, 0.0, half], z_um: vec![0.0; 3] }, crystal)
}

/// The flat crystal itself.
fn ideal(crystal: &CrystalLayer, nm: f64, theta: f64, phi: f64) -> Response {
    let cell = Cell::new(&crystal.lattice, nm).unwrap();
    Multipole::default().respond(&cell, &Incidence { wavelength_nm: nm, theta_i: theta, phi_i: phi }).unwrap()
}

/// Error of fields and powers whose orders come from series, of which up to 3e-5 of each element is left out: 9.5e-5 and
/// 7.3e-5 are reached.
const SERIES: f64 = 1.1e-4;

#[test]
fn far_fields_equal_the_plain_evaluation() {
    let mut worst = [0f64; 2];
    for seed in 1..=3 {
        for (name, mut section, mut stream) in barbules(seed) {
            let nm = if seed == 1 { stream.uniform(300.0, 360.0) } else { stream.uniform(400.0, 694.0) };
            if seed == 3 {
                // Several orders everywhere.
                section.crystal = Some(sparse(0.1));
            }
            let section = narrow(&section, 12.0);
            let (theta, phi) = (stream.uniform(-1.2, 1.2), stream.uniform(-1.2, 1.2));
            // A coarse sum of both: they must agree whatever the elements.
            let element = 0.05;
            let found = fast(&section, element, nm, theta, phi, 200);
            let plain = direct::far_field(&section, element, &beam(nm, theta, phi), 200).unwrap();
            for p in 0..2 {
                let error = relative_l2(&found.amplitudes[p].concat(), &plain.amplitudes[p].concat());
                let power = (found.radiated[p] / plain.radiated[p] - 1.0).abs();
                println!("{name} {nm:.0} nm {theta:.2} {phi:.2}: {error:.1e} {power:.1e}");
                worst = [worst[0].max(error), worst[1].max(power)];
            }
        }
    }
    println!("fast against plain (field, power): {worst:?}");
    assert!(worst.into_iter().all(|worst| worst < SERIES), "{worst:?}");
}

/// Error of a campaign's field (relative L2): 2.1e-4 is reached, by elements of 0.04 µm and nodes.
const CAMPAIGN_FIELD: f64 = 2.3e-4;

/// Relative error of its reflected power: 1.9e-4 is reached.
const CAMPAIGN_POWER: f64 = 2e-4;

#[test]
fn campaigns_equal_converged_fields() {
    let mut worst = [0f64; 2];
    for (name, section, mut stream) in barbules(3) {
        for nm in [stream.uniform(300.0, 400.0), stream.uniform(400.0, 694.0)] {
            let cosines = [stream.uniform(0.1, 1.0), stream.uniform(0.1, 1.0)];
            let wavelengths = Wavelengths::new([nm]).unwrap();
            let axes = Axes::new(&wavelengths, vec![cosines[0]], vec![cosines[1], 1.0]).unwrap();
            let structure = Structure::Sections { name: name.clone(), sections: vec![section.clone()] };
            let parameters = Parameters { axes: axes.clone(), instances: 1, seed: 1, tilt: 0.0 };
            let campaign = Campaign::new(&structure, parameters, Width::best(), &Unobserved).unwrap();
            let unit = campaign.unit(&campaign.tables(0, &Unobserved).unwrap(), 0, Keep::Fields);
            for number in 0..axes.cos_phi.len() {
                let (theta, phi) = (axes.theta_i(0), axes.phi_i(number));
                let exact = fast(&section, 0.5 * FINE_ELEMENT_UM, nm, theta, phi, AZIMUTHS);
                for p in 0..2 {
                    let at = (number * 2 + p) * 2 * AZIMUTHS;
                    let single: Vec<Complex64> = unit.fields[at..at + 2 * AZIMUTHS]
                        .iter()
                        .map(|v| Complex64::new(f64::from(v.re), f64::from(v.im)))
                        .collect();
                    let error = relative_l2(&single, &exact.amplitudes[p].concat());
                    let power = (unit.reflected[number * 2 + p] / exact.radiated[p] - 1.0).abs();
                    println!("{name} {nm:.0} nm: {error:.1e} {power:.1e}");
                    worst = [worst[0].max(error), worst[1].max(power)];
                }
            }
        }
    }
    println!("campaigns against converged fields (field, power): {worst:?}");
    assert!(worst[0] < CAMPAIGN_FIELD && worst[1] < CAMPAIGN_POWER, "{worst:?}");
}

#[test]
fn a_flat_barbule_reflects_what_its_crystal_does_into_each_order() {
    let mut seen = [0; 2];
    let waves = [(320.0, 0.3, 0.6), (500.0, 0.5, -0.4), (620.0, 0.0, 0.0)];
    let crystals = crystal_species().map(|species| (species, layer(species, 0.03), &waves[..]));
    for (species, crystal, waves) in crystals.chain([("sparse", sparse(0.03), &[SPARSE][..])]) {
        let section = flat(40.0, crystal);
        for &(nm, theta, phi) in waves {
            let exact = ideal(section.crystal.as_ref().unwrap(), nm, theta, phi);
            let found = fast(&section, FINE_ELEMENT_UM, nm, theta, phi, 3000);
            let total = exact.reflectance(phi);
            for (p, total) in Polarization::BOTH.into_iter().zip(total) {
                let all = found.radiated[p.index()];
                assert!((all - total).abs() < 2e-3, "{species} {nm}: {all} {total}");
                let intensity = found.intensity(p).unwrap();
                for order in &exact.orders {
                    // The lobe of an order that is not near the horizon, ±6°.
                    if order.phi_o.cos() < 0.4 {
                        continue;
                    }
                    let step = std::f64::consts::PI / 3000.0;
                    let lobe: f64 = found
                        .azimuths
                        .phi_o()
                        .iter()
                        .zip(&intensity)
                        .filter(|(phi_o, _)| (*phi_o - order.phi_o).abs() < 0.1)
                        .map(|(_, i)| i * step * theta.cos())
                        .sum();
                    let expected = order.reflectance(phi)[p.index()];
                    seen[usize::from(order.m != 0)] += 1;
                    assert!(
                        (lobe - expected).abs() < 2e-3,
                        "{species} {nm} order {}: {lobe} {expected}",
                        order.m
                    );
                }
            }
        }
    }
    assert!(seen[0] >= 16 && seen[1] >= 2, "zeroth and other orders that were looked at: {seen:?}");
}

#[test]
fn moving_the_lattice_turns_the_phase_of_each_order() {
    let ((nm, theta, phi), moved) = (SPARSE, 0.137);
    let fields = |offset: f64| fast(&flat(40.0, sparse(offset)), FINE_ELEMENT_UM, nm, theta, phi, 3000);
    let (here, there) = (fields(0.0), fields(moved));
    let crystal = sparse(0.0);
    let orders = ideal(&crystal, nm, theta, phi).orders;
    assert_eq!(orders.len(), 2);
    for order in orders {
        let peak = here.azimuths.phi_o().iter().position(|phi_o| *phi_o > order.phi_o).unwrap();
        let turn = -std::f64::consts::TAU * f64::from(order.m) * moved / crystal.lattice.period_um;
        let (a, b) = (here.amplitudes[0][0][peak], there.amplitudes[0][0][peak]);
        assert!((b / a - Complex64::from_polar(1.0, turn)).norm() < 1e-3, "{}: {}", order.m, b / a);
    }
}

#[test]
fn a_turned_barbule_is_the_same_barbule_seen_from_elsewhere() {
    let (nm, theta, phi) = SPARSE;
    // A turn by a whole number of azimuths, from x towards z; the window runs in x.
    let (azimuths, shift) = (360, 23);
    let turn = std::f64::consts::PI * shift as f64 / azimuths as f64;
    let (sin, cos) = turn.sin_cos();
    let ends = |along: f64| vec![-10.0 * along, 0.0, 10.0 * along];
    let turned = under(Polyline { x_um: ends(cos), z_um: ends(sin) }, sparse(0.05));
    let here = fast(&flat(20.0, sparse(0.05)), FINE_ELEMENT_UM, nm, theta, phi, azimuths);
    let there = fast(&turned, FINE_ELEMENT_UM, nm, theta, phi - turn, azimuths);
    let largest = here.amplitudes[0][0].iter().map(|v| v.norm()).fold(0.0, f64::max);
    for p in 0..2 {
        for c in 0..2 {
            for n in shift..azimuths {
                let (a, b) = (here.amplitudes[p][c][n], there.amplitudes[p][c][n - shift]);
                assert!((a - b).norm() < 1e-6 * largest, "{p} {c} {n}: {a} {b}");
            }
        }
    }
}

#[test]
fn no_barbule_reflects_more_than_it_gets() {
    let mut worst = 0f64;
    for (name, section, mut stream) in barbules(5) {
        for _ in 0..6 {
            let nm = stream.uniform(300.0, 700.0);
            let (theta, phi) = (stream.uniform(-1.2, 1.2), stream.uniform(-1.2, 1.2));
            let found = fast(&section, 0.02, nm, theta, phi, 400);
            for reflected in found.radiated {
                assert!(reflected <= 1.0, "{name} {nm} {theta} {phi}: {reflected}");
                worst = worst.max(reflected);
            }
        }
    }
    println!("largest Φ_r/Φ_i: {worst:.3}");
}

#[test]
fn half_the_regularity_gives_a_quarter_of_the_light() {
    let mut crystal = layer("magpie", 0.02);
    let whole = fast(&flat(20.0, crystal.clone()), 0.02, 420.0, 0.1, 0.3, 100);
    crystal.regularity = Some(barbule::structure::Regularity { x_um: vec![-1.0, 1.0], value: vec![0.5; 2] });
    let half = fast(&flat(20.0, crystal), 0.02, 420.0, 0.1, 0.3, 100);
    assert_eq!(whole.light, half.light);
    for p in 0..2 {
        assert!((half.radiated[p] / whole.radiated[p] - 0.25).abs() < 1e-12);
    }
}
