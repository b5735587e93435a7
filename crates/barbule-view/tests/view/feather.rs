//! The feather's shader against the plain evaluation of the same tables, and against the golden values.

use barbule_appearance::brdf::fixtures::{example, halo};
use barbule_appearance::brdf::{BrdfTables, FeatherMaterial, Options, PlainBrdf, Reciprocity};
use barbule_base::math::rng::Stream;
use barbule_light::scattering::far_field::Polarization;
use barbule_light::scattering::lobe::FitKind;
use barbule_light::scattering::statistics::Sides;
use barbule_view::gpu::{Question, Shader};
use glam::DVec3;
use serde::Deserialize;

use crate::questions::{Asking, Loaded};

/// Errors over the largest value of one wavelength and incident direction: what a back end is held to. Of shipped materials 2e-5 are
/// reached, and 2e-4 where s comes so near f̂ that √(f̂ − s) keeps half of single precision's digits.
const AGREES: f64 = 1e-3;
/// Of the smooth mean, and of what is reflected: single precision's own, 1e-5.
const MEAN_AGREES: f64 = 5e-5;

/// Asks for values.
struct Asked<'a> {
    plain: &'a PlainBrdf,
    /// Incident directions with a wavelength, and outgoing ones of each.
    light: Vec<(f32, DVec3, Vec<DVec3>)>,
    instances: Vec<Option<u64>>,
}

/// A direction rounded to single precision, as shaders have it.
fn rounded(w: DVec3) -> DVec3 {
    w.as_vec3().as_dvec3()
}

/// A direction by θ and φ, rad.
fn direction(theta: f64, phi: f64) -> DVec3 {
    rounded(DVec3::new(theta.cos() * phi.sin(), theta.sin(), theta.cos() * phi.cos()))
}

impl Asked<'_> {
    /// Largest errors of f, s and (of the mean) f alone, over the peak of the mean for the light.
    fn errors(&self, asking: &Asking, loaded: &Loaded) -> [f64; 3] {
        let mut questions = Vec::new();
        for (wavelength_nm, wi, all) in &self.light {
            for wo in all {
                for instance in &self.instances {
                    let (wavelength_nm, wi, wo, instance) = (*wavelength_nm, *wi, *wo, *instance);
                    questions.push(Question::Values { wavelength_nm, wi, wo, instance });
                }
            }
        }
        let mut answers = asking.ask(loaded, &questions).into_iter();
        let mut worst = [0.0_f64; 3];
        for (nm, wi, all) in &self.light {
            let nm = f64::from(*nm);
            let mut peak = 0.0_f64;
            let mut apart = [0.0_f64; 3];
            for wo in all {
                for instance in &self.instances {
                    let expected = self.plain.values(nm, *wi, *wo, *instance);
                    let [f, steady, _] = answers.next().unwrap();
                    let error = (expected.f - f).abs();
                    apart[0] = apart[0].max(error);
                    apart[1] = apart[1].max((expected.steady - steady).abs());
                    if instance.is_none() {
                        peak = peak.max(expected.f);
                        apart[2] = apart[2].max(error);
                    }
                }
            }
            for (worst, apart) in worst.iter_mut().zip(apart) {
                *worst = worst.max(apart / peak);
            }
        }
        worst
    }
}

/// Light from everywhere, eyes about the mirror direction and everywhere.
fn light(own_nm: &[f64], count: usize) -> Vec<(f32, DVec3, Vec<DVec3>)> {
    let mut stream = Stream::new(11, &[]);
    (0..count)
        .map(|k| {
            let z = stream.uniform(0.01, 1.0);
            let (sin, cos) = stream.uniform(0.0, 6.3).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let wi = rounded(DVec3::new(r * cos, r * sin, z));
            let (theta, phi) = (wi.y.asin(), wi.x.atan2(wi.z));
            // Half of the wavelengths are the tables' own.
            let own = own_nm[(stream.unit() * own_nm.len() as f64) as usize];
            let nm = if k % 2 == 0 { own } else { stream.uniform(370.0, 720.0) };
            let mut all = vec![direction(-theta, -phi)];
            for _ in 0..5 {
                let away = |stream: &mut Stream, most: f64| stream.uniform(-most, most);
                let (up, across) = (away(&mut stream, 0.15), away(&mut stream, 0.6));
                let within = |angle: f64| angle.clamp(-1.55, 1.55);
                all.push(direction(within(up - theta), within(across - phi)));
            }
            (nm as f32, wi, all)
        })
        .collect()
}

fn shipped(name: &str) -> FeatherMaterial {
    barbule::io::decode_material(barbule_birds::material(name).unwrap()).unwrap()
}

fn assert_agrees(asking: &Asking, what: &str, material: &FeatherMaterial, options: Options, count: usize) {
    let tables = BrdfTables::new(material, options).unwrap();
    let loaded = asking.feather(&tables, 16);
    let plain = PlainBrdf::new(&tables);
    let mut stream = Stream::new(3, &[]);
    // The mean, and names of few and of many bits.
    let names = (0..count as u64).map(|k| Some(if k % 2 == 0 { k } else { stream.bits() }));
    let instances = std::iter::once(None).chain(names).collect();
    let asked = Asked { plain: &plain, light: light(material.axes.wavelengths_nm(), 24), instances };
    let [f, steady, mean] = asked.errors(asking, &loaded);
    println!("{} {what}: instances {f:.1e}, steady {steady:.1e}, mean {mean:.1e}", asking.gpu);
    assert!(f < AGREES && steady < AGREES && mean < MEAN_AGREES, "{what}: {f} {steady} {mean}");
}

/// Two hundred barbules of each.
#[test]
fn the_shader_agrees_with_the_plain_evaluation_of_shipped_materials() {
    for asking in Asking::all(Shader::Feather) {
        for name in ["starling-green", "hummingbird-anna"] {
            assert_agrees(&asking, name, &shipped(name), Options::default(), 200);
        }
    }
}

#[test]
fn the_shader_agrees_in_every_mode() {
    let with = |options: Options| (example(5), options);
    let reciprocal = |reciprocity| with(Options { reciprocity, ..Options::default() });
    let polarized = |polarization| with(Options { polarization: Some(polarization), ..Options::default() });
    let wide = FeatherMaterial { halo: Some(halo()), ..example(5) };
    let cone = FeatherMaterial { kind: FitKind::Cone, ..example(5) };
    let modes = [
        ("as fitted", with(Options::default())),
        ("of one wavelength", (example(1), Options::default())),
        ("mean of both orders", reciprocal(Reciprocity::Mean)),
        ("of the steeper direction", reciprocal(Reciprocity::Steeper)),
        ("first polarization", polarized(Polarization::First)),
        ("second polarization", polarized(Polarization::Second)),
        ("with a halo", (wide, Options::default())),
        ("a cone", (cone, Options::default())),
        ("two sets, both sides", (of_both(), Options::default())),
        (
            "two sets, both sides, steeper",
            (of_both(), Options { reciprocity: Reciprocity::Steeper, ..Options::default() }),
        ),
    ];
    for asking in Asking::all(Shader::Feather) {
        for (what, (material, options)) in &modes {
            assert_agrees(&asking, what, material, *options, 20);
        }
    }
}

/// Nodes of each polarization, for either sign of φ_i; lobes of the left side are narrower and the second polarization's weaker.
fn of_both() -> FeatherMaterial {
    let mut material = example(3);
    let axes = material.axes.clone();
    material.axes = axes.clone().with_sides(Sides::Both);
    let both = material.axes.clone();
    // Each node of both sides from its mirror image.
    let spread = |values: &[f32], left: f32| -> Vec<f32> {
        (0..both.len())
            .map(|node| {
                let (phi, rest) = (node % both.phis(), node / both.phis());
                let value = values[rest * axes.phis() + both.cosine_of(phi)];
                if both.phi_i(phi) < 0.0 { left * value } else { value }
            })
            .collect()
    };
    let set = &mut material.sets[0];
    for lobe in &mut set.mean {
        lobe.m = spread(&lobe.m, 0.8);
        lobe.phi = spread(&lobe.phi, -1.0);
        lobe.reflected = spread(&lobe.reflected, 0.7);
    }
    set.steady.m = spread(&set.steady.m, 1.0);
    set.steady.phi = spread(&set.steady.phi, -1.0);
    set.steady.share = spread(&set.steady.share, 0.5);
    set.length = spread(&set.length, 1.1);
    // Of sets of one polarization there are no parts of either.
    (set.fraction_1, set.fraction_1_slope) = (Vec::new(), Vec::new());
    material.correlation = spread(&material.correlation, 0.9);
    let cells = axes.cos_theta().len() * both.phis();
    material.steepness = vec![6.0; cells];
    material.strength = (0..cells).map(|cell| (cell % 10) as f32 / 10.0).collect();
    material.achromatic_length = vec![1.3; cells];
    let mut second = material.sets[0].clone();
    for lobe in &mut second.mean {
        lobe.reflected.iter_mut().for_each(|rho| *rho *= 0.6);
    }
    material.sets.push(second);
    material
}

/// What is reflected of all light, for an even sky.
#[test]
fn the_shader_reflects_what_the_tables_reflect() {
    let material = shipped("starling-green");
    let tables = BrdfTables::new(&material, Options::default()).unwrap();
    let brdf = barbule_appearance::brdf::FeatherBrdf::from_tables(tables.clone());
    for asking in Asking::all(Shader::Feather) {
        let loaded = asking.feather(&tables, 16);
        let light = light(material.axes.wavelengths_nm(), 40);
        let ask = |(wavelength_nm, wi, _): &(f32, DVec3, Vec<DVec3>)| Question::Values {
            wavelength_nm: *wavelength_nm,
            wi: *wi,
            wo: DVec3::Z,
            instance: None,
        };
        let questions: Vec<_> = light.iter().map(ask).collect();
        for ((nm, wi, _), answer) in light.iter().zip(asking.ask(&loaded, &questions)) {
            let expected = brdf.exact(f64::from(*nm), *wi).reflected();
            let [.., found] = answer;
            assert!((found - expected).abs() < MEAN_AGREES, "{wi} at {nm} nm: {found}, {expected}");
        }
    }
}

/// The sum over wavelengths, as the processor makes it from the plain evaluation.
#[test]
fn colours_are_those_of_the_wavelengths() {
    let material = shipped("hummingbird-anna");
    let tables = BrdfTables::new(&material, Options::default()).unwrap();
    let plain = PlainBrdf::new(&tables);
    for asking in Asking::all(Shader::Feather) {
        for waves in [12, 50] {
            let loaded = asking.feather(&tables, waves);
            let light = light(material.axes.wavelengths_nm(), 8);
            let mut questions = Vec::new();
            let mut expected = Vec::new();
            for (_, wi, all) in &light {
                for (wo, instance) in all.iter().flat_map(|wo| [(wo, None), (wo, Some(7))]) {
                    questions.push(Question::Colour { wi: *wi, wo: *wo, instance });
                    let of = |nm: &f64| plain.values(*nm, *wi, *wo, instance).f;
                    expected
                        .push(loaded.waves.linear_rgb(&loaded.waves.nm().iter().map(of).collect::<Vec<_>>()));
                }
            }
            let peak = expected.iter().flatten().fold(0.0_f64, |peak, v| peak.max(*v));
            for (answer, expected) in asking.ask(&loaded, &questions).into_iter().zip(&expected) {
                for (found, expected) in answer.into_iter().zip(expected) {
                    assert!((found - expected).abs() < AGREES * peak, "{found} {expected} of {peak}");
                }
            }
        }
    }
}

/// The golden file, as far as it is read here.
#[derive(Deserialize)]
struct Golden {
    wavelengths_nm: Vec<f32>,
    instance: u64,
    materials: Vec<GoldenMaterial>,
}

#[derive(Deserialize)]
struct GoldenMaterial {
    name: String,
    light: Vec<GoldenLight>,
}

#[derive(Deserialize)]
struct GoldenLight {
    wi: [f64; 3],
    wo: Vec<[f64; 3]>,
    mean: Vec<Vec<f64>>,
    drawn: Vec<Vec<f64>>,
}

#[test]
fn the_shader_agrees_with_the_golden_values() {
    let golden: Golden =
        serde_json::from_str(include_str!("../../../barbule/tests/it/data/brdf.json")).unwrap();
    for asking in Asking::all(Shader::Feather) {
        for material in &golden.materials {
            let tables = BrdfTables::new(&shipped(&material.name), Options::default()).unwrap();
            let loaded = asking.feather(&tables, 16);
            let mut worst = [0.0_f64; 2];
            for light in &material.light {
                for (wave, nm) in golden.wavelengths_nm.iter().enumerate() {
                    let ask = |(wo, instance): (&[f64; 3], Option<u64>)| Question::Values {
                        wavelength_nm: *nm,
                        wi: DVec3::from_array(light.wi),
                        wo: DVec3::from_array(*wo),
                        instance,
                    };
                    let both = [None, Some(golden.instance)];
                    let questions: Vec<_> =
                        both.iter().flat_map(|name| light.wo.iter().map(|wo| ask((wo, *name)))).collect();
                    let answers = asking.ask(&loaded, &questions);
                    let peak = light.mean[wave].iter().fold(0.0_f64, |peak, v| peak.max(*v));
                    let expected = [&light.mean[wave], &light.drawn[wave]];
                    for (kind, expected) in expected.into_iter().enumerate() {
                        let found = &answers[kind * light.wo.len()..];
                        for (expected, found) in expected.iter().zip(found) {
                            worst[kind] = worst[kind].max((expected - found[0]).abs() / peak);
                        }
                    }
                }
            }
            println!("{} {}: mean {:.1e}, instance {:.1e}", asking.gpu, material.name, worst[0], worst[1]);
            assert!(worst[0] < MEAN_AGREES && worst[1] < AGREES, "{}: {worst:?}", material.name);
        }
    }
}
