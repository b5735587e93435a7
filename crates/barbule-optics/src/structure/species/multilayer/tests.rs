//! Sections of multilayers against films, against the bronzewing, and whatever the parameters.

use serde_json::{Value, json};

use super::super::{GeneratorParameters, SpeciesModel};
use super::{LowerSide, Multilayer};
use crate::Result;
use crate::film::{self, Polarization as FilmPolarization};
use crate::material::{Library, Table};
use crate::math::rng::Stream;
use crate::scattering::far_field::{Illumination, Polarization, Window};
use crate::solve::surface::{Accuracy, far_field};
use crate::solve::swatch::normal_reflectance;
use crate::spectrum::Wavelengths;
use crate::stack::Stack;
use crate::structure::{Medium, Section, Structure};

/// Six pairs of melanin and keratin under a cortex, with changes.
fn with(changes: &Value) -> Result<SpeciesModel> {
    let mut parameters = json!({
        "generator": "multilayer",
        "width_um": 20.0,
        "cortex_um": 0.01,
        "layers": [{ "medium": "melanin", "thickness_um": 0.09 }, { "medium": "keratin", "thickness_um": 0.1 }],
        "repeats": 6,
        "lower": "none",
    });
    let table = parameters.as_object_mut().unwrap();
    table.extend(changes.as_object().unwrap().clone());
    SpeciesModel::from_parameters("mine", "default", &parameters, Library::builtin())
}

fn section(changes: &Value, index: usize) -> Section {
    with(changes).unwrap().section(1, index).unwrap()
}

fn refusal(changes: &Value) -> String {
    let error = with(changes).expect_err("refused");
    assert!(error.is_input() && error.to_string().len() < 600, "{error}");
    error.to_string()
}

fn multilayer(changes: &Value) -> Multilayer {
    match with(changes).unwrap().parameters {
        GeneratorParameters::Multilayer(parameters) => parameters,
        other => panic!("{other:?}"),
    }
}

/// Thickness along z of layer `k` of a section, at every point.
fn thickness(section: &Section, k: usize) -> Vec<f64> {
    let (above, below) = (&section.boundaries[k].z_um, &section.boundaries[k + 1].z_um);
    above.iter().zip(below).map(|(a, b)| a - b).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn a_flat_multilayer_without_spread_reflects_as_its_film() {
    for (lower, end) in [
        ("none", "keratin"),
        ("plain", "keratin:1000/keratin:10/air"),
        ("mirrored", "keratin:1000/6*(keratin:100/melanin:90)/keratin:10/air"),
    ] {
        let stack = format!("air/keratin:10/6*(melanin:90/keratin:100)/{end}");
        let stack = Stack::parse(&stack, &Library::builtin()).unwrap();
        let at = Wavelengths::new([400.0, 520.0, 633.0]).unwrap();
        let found = normal_reflectance(&section(&json!({ "lower": lower }), 3), 7, &at).unwrap();
        for (&nm, value) in at.nm().iter().zip(found.values()) {
            let exact = film::response(&stack, nm, 0.0, FilmPolarization::S).unwrap().reflected;
            assert!((value - exact).abs() < 1e-11, "{lower} {nm}: {value} {exact}");
        }
    }
}

/// Chains of touching circles are as thick as circles are on the mean, π/4 of their diameter, and notches fill little.
#[test]
fn layers_like_a_bronzewings_have_its_peak() {
    let at = Wavelengths::new((0..101).map(|i| 400.0 + 3.0 * f64::from(i)).collect::<Vec<_>>()).unwrap();
    let peak = |model: &SpeciesModel| {
        let mut sum = vec![0.0; at.len()];
        for index in 0..6 {
            let found = normal_reflectance(&model.section(1, index).unwrap(), 60, &at).unwrap();
            sum.iter_mut().zip(found.values()).for_each(|(sum, value)| *sum += value);
        }
        let highest = sum.iter().copied().fold(0.0, f64::max);
        at.nm()[sum.iter().position(|v| *v == highest).unwrap()]
    };
    let bronzewing = SpeciesModel::builtin("bronzewing", None, Library::builtin()).unwrap();
    let (diameter, spacing) = (0.082, 0.077);
    let thick = diameter * std::f64::consts::FRAC_PI_4;
    let like = with(&json!({
        "width_um": 40.0,
        "cortex_um": 0.012 + 0.5 * (diameter - thick),
        "layers": [
            { "medium": "melanin", "thickness_um": thick },
            { "medium": "keratin", "thickness_um": diameter + spacing - thick },
        ],
        "core": "mix(keratin,melanin,0.15)",
        "core_um": 2.0,
        "lower": "mirrored",
        "waviness": 0.1,
        "roughness_amplitude_um": 0.2,
    }));
    let (found, expected) = (peak(&like.unwrap()), peak(&bronzewing));
    assert!((found - expected).abs() <= 12.0, "{found} nm, the bronzewing's is {expected} nm");
}

/// The brightest azimuth in degrees of light that falls at `phi_deg`.
fn brightest_deg(section: &Section, phi_deg: f64, among: impl Fn(f64) -> bool) -> f64 {
    let illumination = Illumination {
        wavelength_nm: 550.0,
        theta_i: 0.0,
        phi_i: phi_deg.to_radians(),
        window: Window::Gaussian,
    };
    let far = far_field(section, &illumination, 720, &Accuracy::default()).unwrap();
    let intensity = far.intensity(Polarization::First).unwrap();
    let phi = far.azimuths.phi_o();
    let candidates = (0..phi.len()).filter(|&n| among(phi[n].to_degrees()));
    let best = candidates.max_by(|&a, &b| intensity[a].total_cmp(&intensity[b])).unwrap();
    phi[best].to_degrees()
}

/// A facet whose normal leans by ν sends light from φ to 2ν − φ; a lobe of 9 µm at 0.55 µm is about 3° wide.
#[test]
fn the_arms_of_a_fold_reflect_by_the_law_of_reflection() {
    for (fold, fall) in [(15.0, 0.0), (15.0, 10.0), (-15.0, 5.0)] {
        let folded = section(&json!({ "fold_deg": fold, "fold_radius_um": 0.5 }), 0);
        for side in [-1.0, 1.0] {
            let lean = side * 15.0;
            let expected = 2.0 * lean - fall;
            let found = brightest_deg(&folded, fall, |phi| (phi + fall) * side > 0.0);
            assert!((found - expected).abs() < 1.5, "{fold}° from {fall}°: {found}°, by the law {expected}°");
        }
    }
}

#[test]
fn layers_follow_arch_and_fold_at_their_thickness() {
    let arch = section(&json!({ "sagitta_um": 3.0 }), 0);
    let top = arch.top();
    // Chords of 0.03 µm lie up to 6e-6 µm below a circle of 18 µm.
    assert!((top.height(0.0) - top.height(-10.0) - 3.0).abs() < 1e-5);
    // The circle through the middle and the ends.
    let radius = 0.5 * (100.0 / 3.0 + 3.0);
    let last = arch.boundaries.last().unwrap();
    assert!((radius - 6.0 * 0.19 - 0.01 - (radius - top.height(0.0)) - last.height(0.0)).abs() < 2e-4);
    let ridge = section(&json!({ "fold_deg": 30.0, "fold_radius_um": 0.0 }), 0);
    let slant = f64::to_radians(30.0).cos();
    assert!(thickness(&ridge, 1).iter().all(|t| (t - 0.09 / slant).abs() < 1e-11));
    let level = section(&json!({ "fold_deg": -20.0, "fold_radius_um": 2.0, "fold_flat_um": 8.0 }), 0);
    let height = |x: f64| level.top().height(x) - level.top().height(0.0);
    assert!(height(3.9).abs() < 1e-12);
    let slope = (height(9.0) - height(8.0)).atan().to_degrees();
    assert!((slope - 20.0).abs() < 1e-9, "{slope}");
    assert!(with(&json!({ "sagitta_um": 3.0 })).unwrap().is_curved());
    assert!(!with(&json!({})).unwrap().is_curved());
}

#[test]
fn spreads_are_those_between_individuals_between_layers_and_along_the_barbule() {
    let changes = json!({ "spread": 0.05, "spread_within": 0.03 });
    let count = 400;
    // Layers 1, 3, 5 … are of melanin.
    let drawn: Vec<[f64; 2]> = (0..count)
        .map(|index| {
            let section = section(&changes, index);
            [1, 7].map(|k| mean(&thickness(&section, k)) / 0.09 - 1.0)
        })
        .collect();
    let moment = |of: &dyn Fn(&[f64; 2]) -> f64| drawn.iter().map(of).sum::<f64>() / count as f64;
    assert!(moment(&|d| d[0]).abs() < 0.01);
    // σ² = 0.05² + 0.03², of which 0.05² is common to repetitions; clipping takes 1.3 % of each σ.
    let (square, common) = (moment(&|d| d[0] * d[0]), moment(&|d| d[0] * d[1]));
    assert!((square.sqrt() / 0.0576 - 1.0).abs() < 0.12, "{square}");
    assert!((common.sqrt() / 0.0494 - 1.0).abs() < 0.12, "{common}");
    let wavy = section(&json!({ "waviness": 0.2, "waviness_correlation_um": 1.0 }), 0);
    let along = thickness(&wavy, 1);
    let range = |values: &[f64]| {
        values.iter().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), v| (low.min(*v), high.max(*v)))
    };
    let (low, high) = range(&along);
    // The cortex above is wavy too, which takes a little from the normal's direction.
    assert!((low / 0.072 - 1.0).abs() < 0.01 && (high / 0.108 - 1.0).abs() < 0.01, "{low} {high}");
    let own = json!({ "spread": 0.05, "layers": [
        { "medium": "melanin", "thickness_um": 0.09, "spread": 0.0 },
        { "medium": "keratin", "thickness_um": 0.1 },
    ]});
    assert!((0..5).all(|k| (thickness(&section(&own, k), 1)[0] - 0.09).abs() < 1e-12));
    assert_ne!(thickness(&section(&own, 0), 2)[0], thickness(&section(&own, 1), 2)[0]);
}

#[test]
fn a_rough_boundary_moves_itself_and_not_those_below() {
    let rough = section(&json!({ "layer_roughness_um": 0.03 }), 0);
    for (k, boundary) in rough.boundaries.iter().enumerate().skip(1) {
        let depth = 0.01 + (k / 2) as f64 * 0.19 + if k % 2 == 0 { -0.1 } else { 0.0 };
        let worst = boundary.z_um.iter().map(|z| (z + depth).abs()).fold(0.0, f64::max);
        // Layers are measured along the normal, which leans by up to 0.03/0.5; the cortex may not vanish.
        assert!(worst < 0.04, "{k}: {worst}");
    }
}

#[test]
fn the_same_seed_and_number_give_the_same_bits() {
    let changes = json!({ "spread": 0.05, "spread_within": 0.05, "waviness": 0.1, "roughness_amplitude_um": 0.2, "lower": "mirrored" });
    let model = with(&changes).unwrap();
    let boundaries = |seed, index| model.section(seed, index).unwrap().boundaries;
    assert_eq!(boundaries(1, 4), boundaries(1, 4));
    assert_ne!(boundaries(1, 4), boundaries(1, 5));
    assert_ne!(boundaries(1, 4), boundaries(2, 4));
}

/// Random parameters from all over their ranges: no section is refused.
#[test]
fn layers_never_cross_whatever_the_parameters() {
    let mut stream = Stream::new(11, &[]);
    let mut made = 0;
    for trial in 0..150 {
        let mut draw = |low: f64, high: f64| stream.uniform(low, high);
        let width = draw(2.0, 60.0);
        let layers: Vec<Value> = (0..1 + trial % 4)
            .map(|i| json!({ "medium": (["melanin", "keratin", "air"][i % 3]), "thickness_um": 10f64.powf(draw(-2.5, 0.0)) }))
            .collect();
        let changes = json!({
            "width_um": width,
            "layers": layers,
            "repeats": 1 + trial % 9,
            "cortex_um": if trial % 2 == 0 { 0.0 } else { draw(0.005, 1.0) },
            "core_um": draw(0.01, 4.0),
            "lower": (["none", "plain", "mirrored"][trial % 3]),
            "core_spread": draw(0.0, 0.5),
            "spread": draw(0.0, 0.5),
            "spread_within": draw(0.0, 0.5),
            "waviness": draw(0.0, 0.5),
            "waviness_correlation_um": draw(0.05, 5.0),
            "roughness_amplitude_um": draw(0.0, 2.0),
            "roughness_correlation_um": draw(0.1, 5.0),
            "layer_roughness_um": draw(0.0, 0.0015),
            "layer_roughness_correlation_um": draw(0.05, 5.0),
            "sagitta_um": draw(-0.35, 0.35) * width,
            "fold_deg": draw(-60.0, 60.0),
            "fold_radius_um": draw(0.0, 0.4) * width,
            "fold_flat_um": draw(0.0, 0.3) * width,
            "point_spacing_um": draw(0.02, 0.2),
        });
        let model = with(&changes).unwrap();
        model.section(1, trial).unwrap_or_else(|error| panic!("{error}\n{changes}"));
        made += 1;
    }
    assert_eq!(made, 150);
}

#[test]
fn what_is_recorded_makes_the_same_species_again() {
    for changes in [
        json!({}),
        json!({ "lower": "mirrored", "core": "mix(keratin,melanin,0.2)", "fold_deg": -20.5, "layered_width_um": 6.0 }),
        json!({ "lower": "plain", "core_spread": 0.1 }),
        json!({ "layers": [{ "medium": "1.7+0.1j", "thickness_um": 0.2, "waviness": 0.1 }], "spread": 0.07 }),
    ] {
        let model = with(&changes).unwrap();
        let structure = Structure::Species(Box::new(model.clone()));
        let recorded: Value = serde_json::from_str(&structure.description().to_string()).unwrap();
        let again =
            SpeciesModel::from_parameters("mine", "default", &recorded["parameters"], Library::builtin());
        let again = Structure::Species(Box::new(again.unwrap()));
        assert_eq!(again.description(), recorded);
        assert_eq!(again.hash(), structure.hash());
        assert_eq!(again.instance(1, 2).unwrap(), structure.instance(1, 2).unwrap());
    }
}

#[test]
fn every_parameter_and_every_medium_is_part_of_the_identity() {
    let hash = |model: SpeciesModel| Structure::Species(Box::new(model)).hash();
    let mut hashes = vec![hash(with(&json!({})).unwrap())];
    for changes in [
        json!({ "width_um": 21.0 }),
        json!({ "outside": "1.0" , "core": "melanin" }),
        json!({ "cortex_um": 0.02 }),
        json!({ "cortex_medium": "melanin" }),
        json!({ "repeats": 7 }),
        json!({ "core_um": 2.0 }),
        json!({ "lower": "plain" }),
        json!({ "lower": "mirrored" }),
        json!({ "core_spread": 0.0 }),
        json!({ "core_spread": 0.1 }),
        json!({ "spread": 0.1 }),
        json!({ "spread_within": 0.1 }),
        json!({ "waviness": 0.1 }),
        json!({ "waviness_correlation_um": 1.0 }),
        json!({ "layer_roughness_um": 0.01 }),
        json!({ "layer_roughness_correlation_um": 1.0 }),
        json!({ "roughness_amplitude_um": 0.1 }),
        json!({ "roughness_correlation_um": 1.0 }),
        json!({ "sagitta_um": 1.0 }),
        json!({ "fold_deg": 10.0 }),
        json!({ "fold_radius_um": 2.0 }),
        json!({ "fold_flat_um": 2.0 }),
        json!({ "layered_width_um": 5.0 }),
        json!({ "point_spacing_um": 0.02 }),
        json!({ "layers": [{ "medium": "melanin", "thickness_um": 0.09 }] }),
    ] {
        let other = hash(with(&changes).unwrap());
        assert!(!hashes.contains(&other), "{changes}");
        hashes.push(other);
    }
    let with_index = |n: f64| {
        let mut library = Library::builtin();
        let rows = [(300.0, n.into()), (830.0, n.into())];
        library.insert_table("chitin", Table::new("c", &rows).unwrap()).unwrap();
        let mut parameters = serde_json::to_value(&with(&json!({})).unwrap().parameters).unwrap();
        parameters["core"] = "chitin".into();
        let model = SpeciesModel::from_parameters("mine", "default", &parameters, library).unwrap();
        Structure::Species(Box::new(model))
    };
    let [one, other] = [1.5, 1.6].map(with_index);
    assert_ne!(one.hash(), other.hash());
    assert!(one.description()["materials"]["chitin"].is_string());
    assert_ne!(one.description(), other.description());
}

#[test]
fn beyond_the_layered_width_layers_are_their_mean() {
    let part = section(&json!({ "layered_width_um": 6.0 }), 0);
    let below = |x: f64| {
        let at = part.top().height(x);
        let index = |depth: f64| match part.medium_at(x, at - depth) {
            Medium::Mixture { .. } => part.medium_at(x, at - depth).fraction(x),
            Medium::Pure(_) => -1.0,
        };
        [0.005, 0.05, 0.15].map(index)
    };
    // "melanin" comes first: fractions are those of keratin.
    assert_eq!(below(0.0), [-1.0, 0.0, 1.0]);
    let [cortex, melanin, keratin] = below(5.0);
    assert_eq!((cortex, melanin), (-1.0, keratin));
    assert!((melanin - 0.1 / 0.19).abs() < 1e-12);
}

#[test]
fn the_core_keeps_a_tenth_of_its_thickness() {
    let changes = json!({ "core_um": 0.2, "roughness_amplitude_um": 0.5, "lower": "mirrored", "repeats": 2 });
    for index in 0..10 {
        let section = section(&changes, index);
        // Cortex and two pairs, then the core.
        let least = thickness(&section, 5).into_iter().fold(f64::INFINITY, f64::min);
        assert!((0.02 - 1e-12..0.2).contains(&least), "{least}");
    }
    assert_eq!(multilayer(&changes).lower, LowerSide::Mirrored);
}

/// Unless it is given, all barbules are equally thick; given, the core deviates by itself and the barbule is as thick as its parts.
#[test]
fn a_core_takes_up_what_layers_differ_by_or_has_a_spread_of_its_own() {
    let changes = |more: &Value| {
        let mut all = json!({ "core_um": 2.0, "lower": "mirrored", "spread": 0.05, "repeats": 2 });
        all.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        all
    };
    let (plain, own) = (changes(&json!({})), changes(&json!({ "core_spread": 0.1 })));
    // Under the cortex and two pairs.
    let core = |changes: &Value, index| mean(&thickness(&section(changes, index), 5));
    let whole = |changes: &Value, index| {
        let section = section(changes, index);
        section.top().z_um[0] - section.boundaries.last().unwrap().z_um[0]
    };
    assert!((0..5).all(|k| (whole(&plain, k) - whole(&plain, 0)).abs() < 1e-12));
    let layers = |changes: &Value, index| whole(changes, index) - core(changes, index);
    let count = 300;
    let cores: Vec<f64> = (0..count).map(|index| core(&own, index) / 2.0 - 1.0).collect();
    let square = cores.iter().map(|d| d * d).sum::<f64>() / f64::from(count as u32);
    assert!(mean(&cores).abs() < 0.02 && (square.sqrt() / 0.0987 - 1.0).abs() < 0.12, "{square}");
    for index in 0..5 {
        assert!((layers(&own, index) - layers(&plain, index)).abs() < 1e-12, "layers are those without");
    }
    let none = changes(&json!({ "core_spread": 0.0 }));
    assert!((0..5).all(|k| (core(&none, k) - 2.0).abs() < 1e-12));
    let changed = with(&plain).unwrap().with_parameters(&[("core_spread", 0.1.into())]).unwrap();
    assert_eq!(changed.parameters, with(&own).unwrap().parameters);
}

#[test]
fn what_cannot_be_is_refused_with_its_key() {
    for (changes, part) in [
        (json!({ "layers": [] }), "parameters.layers has 0 layers, but 1 to"),
        (json!({ "layers": 3 }), "parameters.layers is the number 3, but must be a list"),
        (json!({ "layers": [3] }), "parameters.layers[0] is the number 3"),
        (json!({ "layers": [{ "thickness_um": 0.1 }] }), "parameters.layers[0].medium is missing"),
        (json!({ "layers": [{ "medium": "keratin" }] }), "parameters.layers[0].thickness_um is missing"),
        (
            json!({ "layers": [{ "medium": "keratin", "thickness_um": 100 }] }),
            "parameters.layers[0].thickness_um is 100, outside 0.001 to 10; did you mean 0.1 (100 nm)?",
        ),
        (
            json!({ "layers": [{ "medium": "keratin", "thickness_nm": 100 }] }),
            "unknown key 'thickness_nm', did you mean 'thickness_um'?",
        ),
        (
            json!({ "layers": [{ "medium": "keratine", "thickness_um": 0.1 }] }),
            "parameters.layers[0].medium: ",
        ),
        (json!({ "core": "keratine" }), "did you mean 'keratin'"),
        (json!({ "outside": 3 }), "parameters.outside is the number 3, but must be a text"),
        (json!({ "lower": "mirored" }), "parameters.lower is 'mirored', did you mean 'mirrored'?"),
        (json!({ "repeats": 0 }), "parameters.repeats is 0, outside 1 to 2000"),
        (json!({ "repeats": 1500 }), "makes 3000 layers, over the limit of 2000"),
        (json!({ "repeats": 900 }), "parameters.layers are 171.010 µm thick in all"),
        (
            json!({ "repeats": 100, "point_spacing_um": 0.005 , "width_um": 200.0 }),
            "parameters.point_spacing_um is 0.005",
        ),
        (
            json!({ "sagitta_um": 9.0 }),
            "parameters.sagitta_um is 9, but an arch is at most 0.35 of its width",
        ),
        (json!({ "fold_deg": 40.0, "fold_radius_um": 20.0 }), "parameters.fold_radius_um is 20"),
        (json!({ "layer_roughness_um": 0.05 }), "make it under half of that, 0.045"),
        (
            json!({ "layered_width_um": 5.0, "layers": [{ "medium": "keratin", "thickness_um": 0.1 }] }),
            "needs layers of two different media",
        ),
        (json!({ "core_spread": 0.6 }), "parameters.core_spread is 0.6, outside 0 to 0.5"),
        (json!({ "spread": 5.0 }), "parameters.spread is 5, outside 0 to 0.5"),
    ] {
        let message = refusal(&changes);
        assert!(message.contains(part), "{changes}\n{message}\nexpected: {part}");
    }
}
