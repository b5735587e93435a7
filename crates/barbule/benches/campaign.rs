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
use barbule::solve::surface::{CAMPAIGN_ELEMENT_UM, Surface, Window, stage_seconds};
use barbule::structure::{SpeciesModel, Structure};

const INSTANCES: usize = 8;

fn main() {
    let species = std::env::args().skip(1).find(|a| !a.starts_with('-')).unwrap_or_else(|| "starling".into());
    let structure = Structure::Species(Box::new(
        SpeciesModel::builtin(&species, None, Library::builtin()).expect("a known species"),
    ));
    let cosines: Vec<f64> = (1..=20).map(|i| f64::from(i) * 0.05).collect();
    let axes = Axes {
        // Spread over the band, so that the mean over units is the campaign's.
        wavelengths_nm: vec![412.0, 484.0, 556.0, 628.0, 682.0],
        cos_theta: vec![0.15, 0.4, 0.65, 0.9],
        cos_phi: cosines.clone(),
    };
    let tilt = 2f64.to_radians();
    let parameters = Parameters { axes, instances: INSTANCES, seed: 1, tilt };
    let begun = Instant::now();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    one.install(|| {
        let campaign = Campaign::new(&structure, parameters, Width::best(), &Unobserved).expect("instances");
        let preparing = begun.elapsed().as_secs_f64() / INSTANCES as f64;
        let begun = Instant::now();
        let mut units = 0;
        for wavelength in 0..5 {
            for theta in 0..4 {
                campaign.unit(wavelength, theta, false).expect("a unit");
                units += 1;
            }
        }
        let seconds = begun.elapsed().as_secs_f64();
        let illuminations = (units * cosines.len() * INSTANCES * 2) as f64;
        println!("{species}, SIMD {}", Width::best().name());
        println!("preparing one instance: {:.1} ms", preparing * 1e3);
        println!("illuminations per second and core: {:.0}", illuminations / seconds);
        let whole = 2e6 * seconds / illuminations + 50.0 * preparing;
        println!("a full material on two cores, extrapolated: {:.0} s", whole / 2.0);

        let section = structure.instance(1, 0).expect("an instance");
        let surface = Surface::new(&section, CAMPAIGN_ELEMENT_UM, Window::Gaussian).expect("a surface");
        let phis: Vec<f64> = cosines.iter().map(|c| c.acos()).collect();
        let stages = stage_seconds(&surface, 550.0, 0.8, &phis, 10).expect("stages");
        let total: f64 = stages.iter().map(|(_, s)| s).sum();
        for (name, stage) in &stages {
            println!("  {name:<28} {:5.1} %", 100.0 * stage / total);
        }
        let begun = Instant::now();
        direct::far_field(&section, Window::Gaussian, CAMPAIGN_ELEMENT_UM, 550.0, 0.8, 0.4, 400)
            .expect("a field");
        let plain = begun.elapsed().as_secs_f64() / 2.0;
        println!(
            "plain evaluation: {:.0} times slower per illumination",
            plain * 2.0 * phis.len() as f64 / total
        );
    });
}
