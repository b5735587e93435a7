//! The fast simulation in figures: illuminations per second and core, share of time per stage, ratio to the plain
//! evaluation, all from one run. `cargo bench -p barbule --bench campaign [SPECIES]`

#![allow(clippy::print_stdout)] // its output is its result

use std::time::Instant;

use barbule::campaign::{Campaign, Parameters};
use barbule::material::Library;
use barbule::math::simd::Width;
use barbule::observer::Unobserved;
use barbule::scattering::statistics::Axes;
use barbule::solve::direct;
use barbule::solve::surface::{FINE_ELEMENT_UM, Window, stage_seconds};
use barbule::structure::{SpeciesModel, Structure};

const INSTANCES: usize = 50;

fn main() {
    let species = std::env::args().skip(1).find(|a| !a.starts_with('-')).unwrap_or_else(|| "starling".into());
    let structure = Structure::Species(Box::new(
        SpeciesModel::builtin(&species, None, Library::builtin()).expect("a known species"),
    ));
    let cosines: Vec<f64> = (1..=20).map(|i| f64::from(i) * 0.05).collect();
    let axes = Axes {
        // Spread over the band, so that the mean over units is the campaign's.
        wavelengths_nm: vec![418.0, 490.0, 568.0, 652.0],
        cos_theta: vec![0.2, 0.5, 0.8],
        cos_phi: cosines.clone(),
    };
    let tilt = 2f64.to_radians();
    let parameters = Parameters { axes, instances: INSTANCES, seed: 1, tilt };
    let begun = Instant::now();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    one.install(|| {
        let campaign = Campaign::new(&structure, parameters, Width::best(), &Unobserved).expect("instances");
        let preparing = begun.elapsed().as_secs_f64() / INSTANCES as f64;
        let (mut tables, mut units, mut bytes) = (0.0, 0.0, 0);
        let (wavelengths, thetas) =
            (campaign.parameters().axes.wavelengths_nm.len(), campaign.parameters().axes.cos_theta.len());
        for index in 0..wavelengths {
            let begun = Instant::now();
            let wavelength = campaign.wavelength(index).expect("tables");
            tables += begun.elapsed().as_secs_f64();
            bytes = bytes.max(wavelength.bytes());
            let begun = Instant::now();
            for theta in 0..thetas {
                std::hint::black_box(campaign.unit(&wavelength, theta, false));
            }
            units += begun.elapsed().as_secs_f64();
        }
        // 50 wavelengths and 20 θ_i make a full campaign.
        let (tables, units) =
            (tables * 50.0 / wavelengths as f64, units * 1000.0 / (wavelengths * thetas) as f64);
        println!("{species}, SIMD {}", Width::best().name());
        println!(
            "preparing one instance: {:.1} ms; tables of one wavelength: {:.0} MB",
            preparing * 1e3,
            bytes as f64 * 1e-6
        );
        println!("illuminations per second and core: {:.0}", 2e6 / (units + tables));
        println!(
            "a full material on two cores, extrapolated: {:.0} s ({:.1} s of instances, {:.1} s of tables)",
            (units + tables + 50.0 * preparing) / 2.0,
            25.0 * preparing,
            tables / 2.0
        );

        let section = structure.instance(1, 0).expect("an instance");
        let phis: Vec<f64> = cosines.iter().map(|c| c.acos()).collect();
        let stages = stage_seconds(&section, 550.0, 0.8, &phis, campaign.ray_parts(), 10).expect("stages");
        // Tables serve the 20 θ_i of a wavelength.
        let mut stages = stages;
        stages[0].1 /= 20.0;
        let total: f64 = stages.iter().map(|(_, s)| s).sum();
        println!("rays per element: {}", 2 * campaign.ray_parts());
        for (name, stage) in &stages {
            println!("  {name:<28} {:5.1} %", 100.0 * stage / total);
        }
        let begun = Instant::now();
        direct::far_field(&section, Window::Gaussian, FINE_ELEMENT_UM, 550.0, 0.8, 0.4, 400)
            .expect("a field");
        let plain = begun.elapsed().as_secs_f64() / 2.0;
        println!(
            "plain evaluation: {:.0} times slower per illumination",
            plain * 2.0 * phis.len() as f64 / total
        );
    });
}
