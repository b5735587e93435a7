//! Arches are lit from edge to edge: what campaigns make of their places, against whole sections under plane waves.

use barbule::bsdf::Arch;
use barbule::campaign::{Campaign, CampaignParameters, PLACES, Resources, places, statistics};
use barbule::progress::Unobserved;
use barbule::scattering::directions::{azimuths, omega};
use barbule::scattering::far_field::{Illumination, IncidentLight, Polarization, Window};
use barbule::scattering::statistics::{AZIMUTHS, Axes, Statistics};
use barbule::scene::description::SceneDescription;
use barbule::solve::surface::{Accuracy, Barbule, CAMPAIGN_ELEMENT_UM, far_field};
use barbule::spectrum::Wavelengths;
use barbule::structure::Structure;

const NM: [f64; 3] = [450.0, 550.0, 650.0];
const PHI_DEG: [f64; 2] = [45.0, 0.0];
const SEED: u64 = 1;

fn simulated(structure: &Structure, instances: usize, places: usize) -> Statistics {
    let cosines = PHI_DEG.map(|phi| phi.to_radians().cos()).to_vec();
    let axes = Axes::new(&Wavelengths::new(NM).unwrap(), vec![1.0], cosines).unwrap();
    let parameters = CampaignParameters { axes, instances, seed: SEED, tilt: 0.0, mirror: false, places };
    let campaign = Campaign::new(structure, parameters, &Resources::default(), &Unobserved).unwrap();
    statistics(&campaign, &Unobserved).unwrap()
}

/// Mean over the individuals of `simulated` of what their whole sections reflect of a plane wave, unpolarized, over the power that falls
/// on them. The same individuals, since others would differ by more than the bounds.
fn whole(structure: &Structure, instances: usize, wavelength_nm: f64, phi_i: f64) -> Vec<f64> {
    let mut mean = vec![0.0; AZIMUTHS];
    let accuracy = Accuracy { element_um: CAMPAIGN_ELEMENT_UM, ..Accuracy::default() };
    for instance in 0..instances {
        let section = structure.instance(SEED, instance).unwrap();
        let lit = Barbule::new(&section, CAMPAIGN_ELEMENT_UM, Window::PlaneWave).unwrap();
        let power = lit.incident_power_um(0.0, phi_i);
        let light = Illumination { wavelength_nm, theta_i: 0.0, phi_i, window: Window::PlaneWave };
        let field = far_field(&section, &light, AZIMUTHS, &accuracy).unwrap();
        assert_eq!(field.light, IncidentLight::PlaneWave);
        let both = Polarization::BOTH.map(|polarization| field.differential_width_um(polarization));
        for (k, (first, second)) in both[0].iter().zip(&both[1]).enumerate() {
            mean[k] += 0.5 * (first + second) / power / instances as f64;
        }
    }
    mean
}

fn unpolarized(of: &Statistics, wave: usize, phi: usize) -> Vec<f64> {
    let at = of.axes.index(wave, 0, phi) * 2 * AZIMUTHS;
    (0..AZIMUTHS).map(|k| 0.5 * f64::from(of.u[at + k] + of.u[at + AZIMUTHS + k])).collect()
}

/// The distance from the mirror direction within which half the light is, degrees.
fn half_light_deg(u: &[f64], phi_deg: f64) -> f64 {
    let mut by_distance: Vec<[f64; 2]> =
        azimuths(AZIMUTHS).zip(u).map(|(phi, u)| [(phi.to_degrees() + phi_deg).abs(), *u]).collect();
    by_distance.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let total: f64 = u.iter().sum();
    let mut sum = 0.0;
    by_distance
        .into_iter()
        .find(|[_, u]| {
            sum += u;
            sum >= 0.5 * total
        })
        .unwrap()[0]
}

/// What the middle of an arch would send of a whole's light if each place sent what its share says, lit by a window of a quarter of the
/// width as campaigns' are.
fn of_the_middle(whole: &[f64], arch: Arch, phi_i: f64) -> Vec<f64> {
    const STEPS: i32 = 200;
    let wi = omega(0.0, phi_i);
    let places = (0..STEPS).map(|k| 2.0 * (f64::from(k) + 0.5) / f64::from(STEPS) - 1.0);
    let lit: Vec<[f64; 2]> = places.map(|x| [x, (-8.0 * x * x).exp()]).collect();
    let total: f64 = lit.iter().map(|[_, power]| power).sum();
    azimuths(AZIMUTHS)
        .zip(whole)
        .map(|(phi_o, u)| {
            let share: f64 = lit.iter().map(|[x, power]| power * arch.share(*x, omega(0.0, phi_o), wi)).sum();
            u * share / total
        })
        .collect()
}

/// One given arch serves all places and tilts.
#[test]
fn a_single_arch_is_lit_at_all_places() {
    let arch = Structure::builtin("rock-dove").unwrap().instance(1, 0).unwrap();
    let given = Structure::Sections { name: "arch".into(), sections: vec![arch] };
    assert_eq!([places(&given, 9), places(&given, 10)], [1, PLACES]);
    let (all, middle) = (simulated(&given, 10, PLACES), simulated(&given, 10, 1));
    let [lit, of_middle] = [&all, &middle].map(|of| half_light_deg(&unpolarized(of, 1, 1), 0.0));
    assert!(lit > 1.4 * of_middle, "{lit} {of_middle}");
    // Without tilts the instances of one place are one field: nothing varies, and all of it is the mean field.
    let at = all.axes.index(1, 0, 1) * 2 * AZIMUTHS;
    let range = at..at + AZIMUTHS;
    assert!(all.contrast[range.clone()].iter().all(|c| *c < 1e-2));
    let [u, v] = [&all.u, &all.v].map(|values| values[range.clone()].iter().sum::<f32>());
    assert!((v / u - 1.0).abs() < 1e-4, "{u} {v}");
}

/// Pictures share light out over the arch that was simulated.
#[test]
fn presets_have_the_simulated_arches() {
    for preset in ["rock-dove", "rock-dove-neck", "dove-bird", "peafowl"] {
        let scene = SceneDescription::named(preset).unwrap();
        let species = if preset == "peafowl" { preset } else { "rock-dove" };
        let normals = Structure::builtin(species).unwrap().edge_normals(SEED).unwrap().unwrap();
        let distal = &scene.feather().unwrap().distal;
        for (known, normal) in [distal.arch_low, distal.arch_high].into_iter().zip(normals) {
            assert!((known - normal).to_degrees().abs() < 0.2, "{preset}: {known} {normal}");
        }
    }
    assert_eq!(Structure::builtin("starling").unwrap().edge_normals(SEED).unwrap(), None);
}

#[test]
fn places_of_an_arch_together_are_the_whole_of_it() {
    // Individuals of the peafowl are alike, and each takes a crystal's solution.
    for (species, instances, middle_off, bound) in [("rock-dove", 40, 0.4, 0.04), ("peafowl", 10, 0.25, 0.03)]
    {
        let structure = Structure::builtin(species).unwrap();
        assert_eq!(places(&structure, instances), PLACES);
        let (all, middle) = (simulated(&structure, instances, PLACES), simulated(&structure, instances, 1));
        let normals = structure.edge_normals(SEED).unwrap().unwrap();
        let arch = Arch::between(normals, structure.width_um()).unwrap();
        println!("{species}: normals lean by {:.1?} degrees", normals.map(f64::to_degrees));
        let mut apart = [0.0f64; 2];
        for (wave, nm) in NM.into_iter().enumerate() {
            for (phi, cosine) in all.axes.cos_phi().iter().enumerate() {
                let phi_deg = cosine.acos().to_degrees();
                let mean = whole(&structure, instances, nm, phi_deg.to_radians());
                let [lit, of_middle] =
                    [&all, &middle].map(|of| half_light_deg(&unpolarized(of, wave, phi), phi_deg));
                let truth = half_light_deg(&mean, phi_deg);
                let shared = half_light_deg(&of_the_middle(&mean, arch, phi_deg.to_radians()), phi_deg);
                let reflected = unpolarized(&all, wave, phi).iter().sum::<f64>() / mean.iter().sum::<f64>();
                println!(
                    "{species} {nm} nm, {phi_deg:.0}°: whole ±{truth:.2}°, places ±{lit:.2}°, middle ±{of_middle:.2}°, by shares ±{shared:.2}°; reflected {reflected:.3}"
                );
                // A circle's share and a window's blur: near enough to tell a place from the whole.
                assert!(
                    (0.75..1.6).contains(&(shared / of_middle)),
                    "{species} {nm} {phi_deg}: {shared} {of_middle}"
                );
                apart = [apart[0].max((lit / truth - 1.0).abs()), apart[1].max(1.0 - of_middle / truth)];
                assert!((reflected - 1.0).abs() < bound, "{species} {nm} {phi_deg}: {reflected}");
            }
        }
        assert!(apart[0] < 0.08 && apart[1] > middle_off, "{species}: {apart:?}");
    }
}
