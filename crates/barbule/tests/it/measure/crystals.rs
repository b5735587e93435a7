//! Figures of barbules over photonic crystals: shared by the tests that hold them and the program that prints them.

use barbule::material::Library;
use barbule::math::rng::Stream;
use barbule::scattering::far_field::FarField;
use barbule::solve::direct;
use barbule::solve::surface::{Accuracy, FINE_ELEMENT_UM, far_field};
use barbule::structure::{
    CrystalLayer, Parts, Polyline, Section, SpeciesFile, SpeciesModel, crystal_species,
};

use super::fields::{beam, campaign_errors, larger, relative_l2};

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

/// A crystal under a top.
pub(crate) fn under(top: Polyline, crystal: CrystalLayer) -> Section {
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

/// Far fields in double precision.
pub(crate) fn fast(
    section: &Section,
    element_um: f64,
    nm: f64,
    theta: f64,
    phi: f64,
    azimuths: usize,
) -> FarField {
    let accuracy = Accuracy { element_um, ..Accuracy::default() };
    far_field(section, &beam(nm, theta, phi), azimuths, &accuracy).unwrap()
}

/// A species' crystal.
pub(crate) fn layer(species: &str, offset_um: f64) -> CrystalLayer {
    let model = SpeciesModel::builtin(species, None, Library::builtin()).unwrap();
    CrystalLayer { lattice: model.lattice().unwrap(), offset_um, regularity: None }
}

/// The mallard's rods 2.5 times as far apart: at 450 nm and 0.3 rad two orders leave a flat top.
pub(crate) fn sparse(offset_um: f64) -> CrystalLayer {
    let mut crystal = layer("mallard", offset_um);
    crystal.lattice.period_um *= 2.5;
    crystal
}

/// The largest differences (field, power) from the plain evaluation.
pub(crate) fn plain_errors() -> [f64; 2] {
    let mut worst = [0f64; 2];
    for seed in 1..=3 {
        for (_, mut section, mut stream) in barbules(seed) {
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
            let plain = direct::far_field(&section, &beam(nm, theta, phi), 200, element).unwrap();
            for p in 0..2 {
                let error = relative_l2(&found.amplitudes[p].concat(), &plain.amplitudes[p].concat());
                let power = (found.radiated[p] / plain.radiated[p] - 1.0).abs();
                worst = larger(worst, [error, power]);
            }
        }
    }
    worst
}

/// Names and wavelengths of random barbules with the errors of campaigns (field, power) against converged fields.
pub(crate) fn converged_errors() -> Vec<(String, [f64; 2])> {
    let mut found = Vec::new();
    for (name, section, mut stream) in barbules(3) {
        for nm in [stream.uniform(300.0, 400.0), stream.uniform(400.0, 694.0)] {
            let cosines = [stream.uniform(0.1, 1.0), stream.uniform(0.1, 1.0)];
            let errors = campaign_errors(&section, nm, cosines, 0.5 * FINE_ELEMENT_UM);
            found.push((format!("{name}, {nm:.0} nm"), errors));
        }
    }
    found
}

/// The largest Φ_r/Φ_i of random barbules, and where.
pub(crate) fn largest_reflected() -> (f64, String) {
    let mut worst = (0.0, String::new());
    for (name, section, mut stream) in barbules(5) {
        for _ in 0..6 {
            let nm = stream.uniform(300.0, 700.0);
            let (theta, phi) = (stream.uniform(-1.2, 1.2), stream.uniform(-1.2, 1.2));
            for reflected in fast(&section, 0.02, nm, theta, phi, 400).radiated {
                if reflected > worst.0 {
                    worst = (reflected, format!("{name} {nm} {theta} {phi}"));
                }
            }
        }
    }
    worst
}
