//! Figures of the fast simulation of layers: shared by the tests that hold them and the program that prints them.

use std::f64::consts::PI;

use barbule::campaign::spectrum::{Collect, SpectrumRequest, spectra};
use barbule::material::Library;
use barbule::math::rng::Stream;
use barbule::progress::Unobserved;
use barbule::solve::direct;
use barbule::solve::surface::{Accuracy, FINE_ELEMENT_UM, far_field};
use barbule::spectrum::Wavelengths;
use barbule::structure::{
    Medium, Parts, Polyline, Section, SpeciesFile, SpeciesModel, Structure, Substance, layered_species,
};
use num_complex::Complex64;

use super::fields::{beam, campaign_errors, larger, relative_l2};

/// Roughness of the tops: τ, amplitude and width in µm, of which species.
pub(crate) const ROUGHNESSES: [(f64, f64, f64, &str); 5] = [
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
    spectra(&structure, &request, &Unobserved).unwrap().mean
}

/// Φ_r/Φ_i of 50 rough mirrors of one of [`ROUGHNESSES`].
pub(crate) struct MirrorEnergy {
    /// At φ_i = 0°, 15°, 30°, 45° and 50°, 60°, 70°, 80°, each of every instance.
    pub(crate) values: Vec<Vec<f64>>,
}

impl MirrorEnergy {
    /// Angles of φ_i up to 45°.
    const STEEP: usize = 4;

    /// All values of φ_i up to 45°.
    pub(crate) fn steep(&self) -> Vec<f64> {
        self.values[..Self::STEEP].concat()
    }

    /// The largest distance of a mean over instances from 1, φ_i up to 45°.
    pub(crate) fn worst_mean(&self) -> f64 {
        self.values[..Self::STEEP].iter().map(|v| (mean(v) - 1.0).abs()).fold(0.0, f64::max)
    }

    /// Mean and largest value at each φ_i above 45°.
    #[allow(dead_code)] // the program's
    pub(crate) fn oblique(&self) -> Vec<[f64; 2]> {
        self.values[Self::STEEP..].iter().map(|v| [mean(v), v.iter().copied().fold(0.0, f64::max)]).collect()
    }
}

/// The mean of values.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Measures [`MirrorEnergy`].
pub(crate) fn mirror_energy((tau, height, width, _): (f64, f64, f64, &str)) -> MirrorEnergy {
    let angles = [0.0, 15.0, 30.0, 45.0, 50.0, 60.0, 70.0, 80.0].map(|d: f64| (0.0, d.to_radians()));
    let mut values = vec![Vec::new(); angles.len()];
    for seed in 0..50 {
        let section = mirror(width, tau, height, seed);
        let nm = 400.0 + 6.0 * seed as f64;
        let polarization = (seed % 2) as usize;
        for (all, value) in values.iter_mut().zip(reflected(&section, &[nm], &angles, polarization)) {
            all.push(value[0]);
        }
    }
    MirrorEnergy { values }
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

/// The largest Φ_r/Φ_i of random barbules and where, for cosθ cosφ ≥ 0.1 and below.
pub(crate) fn largest_reflected() -> [(f64, String); 2] {
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
    [worst, below]
}

/// The largest differences (field, power) of double precision from the plain evaluation.
pub(crate) fn plain_errors() -> [f64; 2] {
    let mut worst = [0.0; 2];
    for (_, section, mut stream) in sections(2) {
        let nm = stream.uniform(400.0, 694.0);
        let (theta, phi) = (stream.uniform(-1.3, 1.3), stream.uniform(-1.3, 1.3));
        // A coarse sum of both: they must agree whatever the elements.
        let element = 0.05;
        let light = beam(nm, theta, phi);
        let fast = far_field(&section, &light, 100, &Accuracy { element_um: element, ..Accuracy::default() })
            .unwrap();
        let plain = direct::far_field(&section, &light, 100, element).unwrap();
        for p in 0..2 {
            let error = relative_l2(&fast.amplitudes[p].concat(), &plain.amplitudes[p].concat());
            worst = larger(worst, [error, (fast.radiated[p] / plain.radiated[p] - 1.0).abs()]);
        }
    }
    worst
}

/// Names of random barbules with the errors of campaigns (field, power) against converged fields.
pub(crate) fn converged_errors() -> Vec<(String, [f64; 2])> {
    sections(3)
        .map(|(name, section, mut stream)| {
            let nm = stream.uniform(400.0, 694.0);
            let cosines = [stream.uniform(0.1, 1.0), stream.uniform(0.1, 1.0)];
            // Voids have sharp ends: fields over inclusions settle last.
            let element = FINE_ELEMENT_UM * if section.inclusions.is_empty() { 0.5 } else { 0.25 };
            (name, campaign_errors(&section, nm, cosines, element))
        })
        .collect()
}
