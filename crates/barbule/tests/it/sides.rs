//! Structures that are not their own mirror images, ensembles that are made so, and lower sides.

use barbule::brdf::fit::{FitOptions, fit};
use barbule::brdf::{FeatherBrdf, Options, marginals};
use barbule::campaign::spectrum::{Collect, SpectrumRequest, spectra};
use barbule::campaign::{Campaign, CampaignParameters, Resources, sides, statistics};
use barbule::characterize::{CampaignDescription, CampaignOptions};
use barbule::io::parse_section;
use barbule::io::store::Store;
use barbule::material::Library;
use barbule::math::simd::Width;
use barbule::progress::Unobserved;
use barbule::scattering::directions::{azimuths, omega};
use barbule::scattering::far_field::Polarization;
use barbule::scattering::statistics::{AZIMUTHS, Axes, Sides, Statistics};
use barbule::solve::surface::{Accuracy, far_field};
use barbule::spectrum::Wavelengths;
use barbule::structure::{Lattice, Section, Side, Structure};
use serde_json::{Value, json};

use crate::measure::fields::beam;

/// The top slopes by this, so that its normal leans towards −x, degrees.
const SLOPE_DEG: f64 = 6.0;

/// A wedge of melanin 20 µm wide on a flat bottom, so thick that nothing comes back from below; `slope` is dz/dx of the top.
fn wedge(slope: f64, bump: f64) -> Section {
    let text = json!({
        "barbule": 1, "units": "um", "width": 20, "name": "wedge",
        "boundaries": [
            {"x": [-10, 3, 10], "z": [-10.0 * slope, 3.0 * slope + bump, 10.0 * slope]},
            {"x": [-10, 0, 10], "z": [-8, -8, -8]},
        ],
        "media": ["air", "melanin", "air"],
    })
    .to_string();
    parse_section(&text, "wedge.json".as_ref(), &Library::builtin()).unwrap()
}

/// The wedge with x → −x.
fn mirrored_wedge(slope: f64, bump: f64) -> Section {
    let text = json!({
        "barbule": 1, "units": "um", "width": 20, "name": "wedge",
        "boundaries": [
            {"x": [-10, -3, 10], "z": [10.0 * slope, 3.0 * slope + bump, -10.0 * slope]},
            {"x": [-10, 0, 10], "z": [-8, -8, -8]},
        ],
        "media": ["air", "melanin", "air"],
    })
    .to_string();
    parse_section(&text, "wedge.json".as_ref(), &Library::builtin()).unwrap()
}

fn slope() -> f64 {
    SLOPE_DEG.to_radians().tan()
}

fn given(sections: Vec<Section>) -> Structure {
    Structure::Sections { name: "wedge".into(), sections }
}

/// At 500 nm, cosθ_i = 0.8 and 1, φ_i = ±40° and 0°, without tilt.
fn simulated(structure: &Structure, mirror: bool) -> Statistics {
    let cosines = vec![40f64.to_radians().cos(), 1.0];
    let sides = if mirror { Sides::Alike } else { sides(&structure.symmetry()) };
    let axes = Axes::new(&Wavelengths::new([500.0]).unwrap(), vec![0.8, 1.0], cosines).unwrap();
    let axes = axes.with_sides(sides);
    let instances = structure.count().unwrap_or(1);
    let parameters = CampaignParameters { axes, instances, seed: 1, tilt: 0.0, mirror, places: 1 };
    let campaign = Campaign::new(structure, parameters, &Resources::default(), &Unobserved).unwrap();
    statistics(&campaign, &Unobserved).unwrap()
}

/// U, V or the contrast at θ_i number `theta`, φ_i number `phi` and polarization `p`.
fn row<'a>(of: &'a Statistics, values: &'a [f32], theta: usize, phi: usize, p: usize) -> &'a [f32] {
    let at = (of.axes.index(0, theta, phi) * 2 + p) * AZIMUTHS;
    &values[at..at + AZIMUTHS]
}

fn reversed(values: &[f32]) -> Vec<f32> {
    values.iter().rev().copied().collect()
}

/// ‖a − b‖/‖b‖.
fn difference(a: &[f32], b: &[f32]) -> f64 {
    let sum = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let apart = sum(&mut a.iter().zip(b).map(|(a, b)| f64::from(a - b)));
    (apart / sum(&mut b.iter().map(|b| f64::from(*b)))).sqrt()
}

/// Numbers of φ_i = 40°, 0° and −40° where both signs are simulated.
const RIGHT: usize = 0;
const NORMAL: usize = 1;
const LEFT: usize = 2;

#[test]
fn both_signs_of_a_wedge_are_those_of_single_far_fields_and_leave_where_its_slope_sends_them() {
    let sections = vec![wedge(slope(), 0.0), wedge(slope(), 0.05)];
    let found = simulated(&given(sections.clone()), false);
    let axes = &found.axes;
    assert_eq!((axes.sides(), axes.phis(), found.instances), (Sides::Both, 3, 2));
    let step = 180.0 / AZIMUTHS as f64;
    for theta in 0..2 {
        for (phi, deg) in [(RIGHT, 40.0), (NORMAL, 0.0), (LEFT, -40.0)] {
            assert!((axes.phi_i(phi).to_degrees() - deg).abs() < 1e-9);
            let light = beam(500.0, axes.theta_i(theta), axes.phi_i(phi));
            let single: Vec<_> = sections
                .iter()
                .map(|section| far_field(section, &light, AZIMUTHS, &Accuracy::default()).unwrap())
                .collect();
            for (p, polarization) in Polarization::BOTH.into_iter().enumerate() {
                let each: Vec<Vec<f64>> = single.iter().map(|f| f.intensity(polarization).unwrap()).collect();
                let mean: Vec<f32> =
                    each[0].iter().zip(&each[1]).map(|(a, b)| (0.5 * (a + b)) as f32).collect();
                let u = row(&found, &found.u, theta, phi, p);
                assert!(difference(u, &mean) < 1e-3, "{theta} {deg} {p}: {}", difference(u, &mean));
                let power = 0.5 * (single[0].radiated[p] + single[1].radiated[p]);
                let reflected = found.reflected[axes.index(0, theta, phi) * 2 + p];
                assert!((reflected / power - 1.0).abs() < 1e-3, "{reflected} {power}");
            }
            // The normal of a top that rises by α towards x leans by α towards −x.
            let flat = single[0].intensity(Polarization::First).unwrap();
            let peak = (0..AZIMUTHS).max_by(|a, b| flat[*a].total_cmp(&flat[*b])).unwrap();
            let at = (peak as f64 + 0.5) * step - 90.0;
            let expected = -deg - 2.0 * SLOPE_DEG;
            assert!((at - expected).abs() < 1.0, "{theta} {deg}: {at} {expected}");
        }
    }
}

/// A material of wedges of many slopes: from either side its lobe leaves where the slopes send it, with what it reflects.
#[test]
fn a_fitted_wedge_has_a_lobe_of_its_own_for_either_side() {
    let sections = (0..8).map(|k| wedge((4.0 + 0.5 * f64::from(k)).to_radians().tan(), 0.0)).collect();
    let found = simulated(&given(sections), false);
    let (material, _) = fit(&found, &FitOptions::default(), &Unobserved).unwrap();
    let brdf = FeatherBrdf::new(&material, Options::default()).unwrap();
    let phi_out: Vec<f64> = azimuths(AZIMUTHS).collect();
    for (phi, deg) in [(RIGHT, 40.0_f64), (LEFT, -40.0)] {
        let wi = omega(found.axes.theta_i(1), deg.to_radians());
        let fitted = marginals(&brdf, &[500.0], wi, &phi_out, None, &Unobserved).unwrap().remove(0).f;
        let of = |p: usize| row(&found, &found.u, 1, phi, p).iter().map(|u| f64::from(*u));
        let mean: Vec<f64> = of(0).zip(of(1)).map(|(a, b)| 0.5 * (a + b)).collect();
        let moments = |values: &[f64]| {
            let total: f64 = values.iter().sum();
            [total, phi_out.iter().zip(values).map(|(phi, v)| phi * v).sum::<f64>() / total]
        };
        let ([total, centre], [expected, there]) = (moments(&fitted), moments(&mean));
        // Mean slope 5.75°: light goes from φ_i to −φ_i − 11.5°.
        assert!((there.to_degrees() + deg + 11.5).abs() < 1.5, "{deg}: {}", there.to_degrees());
        assert!((centre - there).abs().to_degrees() < 1.0, "{deg}: {centre} {there}");
        assert!((total / expected - 1.0).abs() < 1e-4, "{deg}: {total} {expected}");
    }
}

#[test]
fn both_signs_of_a_crystal_without_a_mirror_are_those_of_single_far_fields() {
    let duck = Structure::builtin("mallard").unwrap().lattice().unwrap();
    let lattice = Lattice { period_um: 0.45, rows: 2, row_shift: 0.25, ..duck };
    let section = Section::flat_crystal("quarter", lattice).unwrap();
    let found = simulated(&given(vec![section.clone()]), false);
    assert_eq!(found.axes.sides(), Sides::Both);
    let mut reflected = Vec::new();
    for phi in [RIGHT, LEFT] {
        let light = beam(500.0, found.axes.theta_i(0), found.axes.phi_i(phi));
        let single = far_field(&section, &light, AZIMUTHS, &Accuracy::default()).unwrap();
        for (p, polarization) in Polarization::BOTH.into_iter().enumerate() {
            let exact: Vec<f32> =
                single.intensity(polarization).unwrap().iter().map(|value| *value as f32).collect();
            let apart = difference(row(&found, &found.u, 0, phi, p), &exact);
            assert!(apart < 1e-3, "{phi} {p}: {apart}");
            reflected.push(row(&found, &found.u, 0, phi, p).to_vec());
        }
    }
    // It does reflect otherwise from either side: by 0.0083.
    let apart = difference(&reflected[0], &reversed(&reflected[2]));
    assert!(apart > 5e-3, "{apart}");
}

#[test]
fn a_mirrored_wedge_has_mirrored_statistics() {
    let here = simulated(&given(vec![wedge(slope(), 0.0), wedge(slope(), 0.05)]), false);
    let there = given(vec![mirrored_wedge(slope(), 0.0), mirrored_wedge(slope(), 0.05)]);
    let there = simulated(&there, false);
    for theta in 0..2 {
        for (phi, other) in [(RIGHT, LEFT), (NORMAL, NORMAL), (LEFT, RIGHT)] {
            let nodes = [here.axes.index(0, theta, phi), there.axes.index(0, theta, other)];
            for p in 0..2 {
                for (name, mine, theirs, most) in [
                    ("u", &here.u, &there.u, 1e-5),
                    ("v", &here.v, &there.v, 1e-4),
                    ("contrast", &here.contrast, &there.contrast, 1e-2),
                ] {
                    let image = reversed(row(&there, theirs, theta, other, p));
                    let apart = difference(row(&here, mine, theta, phi, p), &image);
                    assert!(apart < most, "{name} {theta} {phi} {p}: {apart}");
                }
                let [a, b] = [here.reflected[nodes[0] * 2 + p], there.reflected[nodes[1] * 2 + p]];
                assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
            }
        }
    }
}

#[test]
fn wedges_that_lie_either_way_round_are_symmetric_and_the_mean_of_both() {
    let sections = || vec![wedge(slope(), 0.0), wedge(slope(), 0.05), wedge(slope(), 0.1)];
    let both = simulated(&given(sections()), false);
    let found = simulated(&given(sections()), true);
    assert_eq!((found.axes.sides(), found.axes.phis(), found.instances), (Sides::Alike, 2, 6));
    for theta in 0..2 {
        for p in 0..2 {
            let u = row(&found, &found.u, theta, NORMAL, p);
            assert!(difference(u, &reversed(u)) < 1e-6);
            for (phi, other) in [(RIGHT, LEFT), (NORMAL, NORMAL)] {
                let own = row(&both, &both.u, theta, phi, p);
                let image = reversed(row(&both, &both.u, theta, other, p));
                let mean: Vec<f32> = own.iter().zip(&image).map(|(a, b)| 0.5 * (a + b)).collect();
                let apart = difference(row(&found, &found.u, theta, phi, p), &mean);
                assert!(apart < 1e-6, "{theta} {phi} {p}: {apart}");
                // Var I = ⟨I²⟩ − ⟨I⟩² with means over the instances and their images.
                let spread = |theirs: &Statistics, phi: usize| -> Vec<f64> {
                    let of = |values| row(theirs, values, theta, phi, p).iter().map(|v| f64::from(*v));
                    of(&theirs.u).zip(of(&theirs.contrast)).map(|(u, c)| u * u * (1.0 + c * c)).collect()
                };
                let (own, image) = (spread(&both, phi), spread(&both, other));
                let squares = own.iter().zip(image.iter().rev()).map(|(a, b)| 0.5 * (a + b));
                let largest = mean.iter().copied().fold(0.0, f32::max);
                let contrast = row(&found, &found.contrast, theta, phi, p);
                for ((square, mean), contrast) in squares.zip(&mean).zip(contrast) {
                    let mean = f64::from(*mean);
                    if mean > 0.05 * f64::from(largest) {
                        let expected = (square / (mean * mean) - 1.0).max(0.0).sqrt();
                        assert!((f64::from(*contrast) - expected).abs() < 5e-3, "{contrast} {expected}");
                    }
                }
                let node = |of: &Statistics, phi: usize| of.reflected[of.axes.index(0, theta, phi) * 2 + p];
                let expected = 0.5 * (node(&both, phi) + node(&both, other));
                assert!((node(&found, phi) / expected - 1.0).abs() < 1e-9);
            }
        }
    }
    let mirror = CampaignOptions { mirror: true, ..CampaignOptions::default() };
    let plan = mirror.plan(given(sections())).unwrap();
    assert!(plan.parameters.mirror && plan.description.mirror && plan.description.sides == Sides::Alike);
    // What is its own mirror image does without.
    let species = mirror.plan(Structure::builtin("starling").unwrap()).unwrap();
    assert!(!species.parameters.mirror && !species.description.mirror);
}

#[test]
fn sections_in_files_are_seen_to_be_their_own_mirror_images() {
    assert!(given(vec![wedge(0.0, 0.0)]).symmetry().is_mirrored());
    assert!(!given(vec![wedge(slope(), 0.0)]).symmetry().is_mirrored());
    assert!(!given(vec![wedge(0.0, 0.0), wedge(0.0, 0.01)]).symmetry().is_mirrored());
    for (slope, sides) in [(0.0, Sides::Alike), (slope(), Sides::Both)] {
        let plan = CampaignOptions::default().plan(given(vec![wedge(slope, 0.0)])).unwrap();
        assert_eq!((plan.parameters.axes.sides(), plan.description.sides), (sides, sides));
    }
}

#[test]
fn descriptions_and_stores_of_symmetric_structures_are_what_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let store = |name: &str, structure: Structure, mirror: bool| {
        let options = CampaignOptions {
            wavelengths_nm: vec![450.0, 550.0],
            directions: [2, 2],
            instances: Some(2),
            mirror,
            ..CampaignOptions::default()
        };
        let plan = options.plan(structure).unwrap();
        let path = folder.path().join(name);
        let resources = Resources { width: Width::named("scalar").unwrap(), ..Resources::default() };
        plan.store(&path, &[], &resources).unwrap();
        let text = std::fs::read_to_string(path.join("zarr.json")).unwrap();
        let attributes = serde_json::from_str::<Value>(&text).unwrap()["attributes"].clone();
        let read = CampaignDescription::read(&attributes["campaign"]).unwrap();
        assert!(read == plan.description && read.is_recorded(&attributes["campaign"]));
        assert_eq!(Store::open(&path).unwrap().axes(), &plan.parameters.axes);
        (attributes, path)
    };
    // As programs wrote it before both signs of φ_i were simulated, but for the layout.
    let (starling, _) = store("starling.zarr", Structure::builtin("starling").unwrap(), true);
    assert_eq!(starling["campaign_hash"], "b5f31a368ff4b933b44cb561fbb8c829ecb48efc334c66d816c0eb1dc4635fe1");
    let keys = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    let [usual, usual_campaign] = [&starling, &starling["campaign"]].map(keys);
    assert_eq!(usual.len(), 10);
    assert_eq!(usual_campaign.len(), 10);
    let (below, _) = store("below.zarr", Structure::builtin("starling").unwrap().underside().unwrap(), false);
    assert_eq!(
        (&below["name"], &below["campaign"]["structure"]["side"]),
        (&json!("starling:green (below)"), &json!("below"))
    );
    let (both, path) = store("both.zarr", given(vec![wedge(slope(), 0.0)]), false);
    assert_eq!((&both["sides"], &both["campaign"]["sides"]), (&json!("both"), &json!("both")));
    let (mirror, _) = store("mirror.zarr", given(vec![wedge(slope(), 0.0)]), true);
    assert_eq!((&mirror["sides"], &mirror["campaign"]["mirror"]), (&Value::Null, &json!(true)));
    assert_eq!((&mirror["instances"], &mirror["campaign"]["instances"]), (&json!(4), &json!(2)));
    // φ_i = 60°, 0°, −60°.
    let bytes = std::fs::read(path.join("phi_i/c.0")).unwrap();
    let degrees: Vec<f64> = bytes[..24].as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
    assert!(degrees.iter().zip([60.0, 0.0, -60.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{degrees:?}");
}

/// Mean reflected fractions and standard errors at 450, 550 and 650 nm, φ_i = 0° and −30°.
fn reflected(structure: &Structure, instances: usize) -> Vec<[f64; 2]> {
    let request = SpectrumRequest {
        wavelengths: Wavelengths::new([450.0, 550.0, 650.0]).unwrap(),
        directions: vec![(0.0, 0.0), (0.0, -30f64.to_radians())],
        instances,
        seed: 1,
        collect: Collect::Hemisphere,
        polarization: [0.5, 0.5],
    };
    let found = spectra(structure, &request, &Unobserved).unwrap();
    let error = |std: &f64| std / (instances as f64).sqrt();
    found.mean.iter().flatten().zip(found.std.iter().flatten()).map(|(m, s)| [*m, error(s)]).collect()
}

#[test]
fn a_section_turned_twice_is_itself() {
    for name in ["starling", "rock-dove", "bronzewing", "hummingbird"] {
        let section = Structure::builtin(name).unwrap().instance(2, 1).unwrap();
        let turned = section.underside().unwrap();
        let again = turned.underside().unwrap();
        assert_eq!(again.media, section.media);
        for (a, b) in again.boundaries.iter().zip(&section.boundaries) {
            assert_eq!(a.x_um, b.x_um);
            assert!(a.z_um.iter().zip(&b.z_um).all(|(a, b)| (a - b).abs() < 1e-12), "{name}");
        }
        assert_eq!(again.inclusions.len(), section.inclusions.len());
        // A point and where it comes to lie.
        let [first, last] = [section.boundaries.first(), section.boundaries.last()].map(|b| b.unwrap());
        let mean = |z_um: &[f64]| z_um.iter().sum::<f64>() / z_um.len() as f64;
        let sum = mean(&first.z_um) + mean(&last.z_um);
        for (x, z) in [(0.7, -0.2), (-3.1, -1.0), (5.5, -0.5), (1.0, -2.5), (2.0, 0.7)] {
            let there = turned.medium_at(-x, sum - z);
            assert_eq!(
                there.substances().next(),
                section.medium_at(x, z).substances().next(),
                "{name} {x} {z}"
            );
        }
    }
    let below = Structure::builtin("starling").unwrap().underside().unwrap();
    assert_eq!((below.name().as_str(), below.side()), ("starling:green (below)", Side::Below));
    assert_eq!(below.underside().unwrap(), Structure::builtin("starling").unwrap());
}

#[test]
fn a_starling_is_alike_on_both_sides_and_a_stack_is_reversed() {
    let starling = Structure::builtin("starling").unwrap();
    let above = reflected(&starling, 30);
    let below = reflected(&starling.underside().unwrap(), 30);
    for ([a, error_a], [b, error_b]) in above.into_iter().zip(below) {
        assert!((a - b).abs() < 4.0 * error_a.hypot(error_b), "{a} {error_a} {b} {error_b}");
        assert!(a != b);
    }
    let flat = |text: &str| Structure::flat(text).unwrap();
    let turned = reflected(&flat("air/keratin:300/melanin:100/air").underside().unwrap(), 1);
    let reversed = reflected(&flat("air/melanin:100/keratin:300/air"), 1);
    for ([a, _], [b, _]) in turned.into_iter().zip(reversed) {
        assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
    }
    let random = flat("air/keratin:300±5%/melanin:100±5%/air");
    assert_eq!(random.clone().underside().unwrap().count(), None);
    assert_ne!(random.hash(), random.underside().unwrap().hash());
}

#[test]
fn crystals_hang_under_the_lower_outline_too_and_without_one_there_is_no_lower_side() {
    for name in ["mallard", "magpie", "peafowl"] {
        let species = Structure::builtin(name).unwrap();
        let below = species.clone().underside().unwrap();
        assert_eq!(below.lattice(), species.lattice(), "{name}");
        let [upper, lower] = [&species, &below].map(|structure| structure.instance(1, 0).unwrap());
        assert_ne!(upper.top().z_um, lower.top().z_um);
        let mean = lower.top().z_um.iter().sum::<f64>() / lower.top().z_um.len() as f64;
        assert!(mean.abs() < 1e-9, "{mean}");
        let ends = |section: &Section| {
            let z = &section.top().z_um;
            0.5 * (z[0] + z[z.len() - 1]) - z[z.len() / 2]
        };
        if name == "peafowl" {
            // An arch is a trough from below.
            assert!(ends(&upper) < -1.0 && ends(&lower) > 1.0, "{} {}", ends(&upper), ends(&lower));
        }
    }
    let lattice = Structure::builtin("mallard").unwrap().lattice().unwrap();
    let alone = given(vec![Section::flat_crystal("rods", lattice).unwrap()]);
    let message = alone.underside().unwrap_err().to_string();
    assert_eq!(
        message,
        "rods: its lower side cannot be lit, since under its photonic crystal the keratin goes on without end"
    );
    let message = Structure::flat("air/keratin:300/melanin").unwrap().underside().unwrap_err().to_string();
    assert!(
        message.contains("melanin goes on under it; let the last medium be the built-in air"),
        "{message}"
    );
}
