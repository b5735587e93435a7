//! The layers' shader against exact films on facets, and against the renderer's surface of them.

use std::f64::consts::{PI, TAU};

use barbule_appearance::bsdf::{FacetRoughness, Hit, Surface, ThinFilm};
use barbule_base::math::rng::Stream;
use barbule_base::progress::Unobserved;
use barbule_light::film::{Polarization, response, sweep};
use barbule_light::material::Library;
use barbule_light::spectrum::Wavelengths;
use barbule_light::spectrum::dense::Lambdas;
use barbule_light::stack::Stack;
use barbule_view::gpu::{PackedLayers, Question, Reflected, Shader};
use glam::DVec3;

use crate::questions::Asking;

/// Errors over the largest value of one wavelength and incident direction.
const AGREES: f64 = 1e-3;
/// Of the renderer's tables, which are good to 5e-4 over the cosine.
const RENDERER_AGREES: f64 = 5e-3;
const STEPS: usize = Reflected::STEPS;

fn reflected(stack: &Stack) -> Reflected {
    let at = Wavelengths::usual();
    // At grazing a stack may have an absorbing last medium: the angle stays below 90°.
    let found = sweep(stack, &at, &Reflected::angles(STEPS), &Unobserved).unwrap().unpolarized();
    // From [angle, wavelength] to [wavelength, angle].
    let value = |wave: usize, angle: usize| found[angle * at.len() + wave] as f32;
    let values = (0..at.len()).flat_map(|wave| (0..=STEPS).map(move |angle| (wave, angle)));
    let values = values.map(|(wave, angle)| value(wave, angle)).collect();
    Reflected { nm: at.nm().to_vec(), steps: STEPS, values }
}

fn direction(stream: &mut Stream) -> DVec3 {
    let z = stream.uniform(0.1, 1.0);
    let (sin, cos) = stream.uniform(0.0, TAU).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z).as_vec3().as_dvec3()
}

/// R D/(4 cosθ_i cosθ_o (1 + Λ_i + Λ_o)) with the transfer matrix's own R.
fn exact(stack: &Stack, alpha: f64, nm: f64, [wi, wo]: [DVec3; 2]) -> f64 {
    let h = (wi + wo).normalize();
    let angle = wi.dot(h).min(1.0).acos();
    let reflected = Polarization::BOTH.map(|p| response(stack, nm, angle, p).unwrap().reflected);
    let hidden = |w: DVec3| 0.5 * ((1.0 + alpha * alpha * (1.0 / (w.z * w.z) - 1.0)).sqrt() - 1.0);
    let slopes = (h.x * h.x + h.y * h.y) / (alpha * alpha) + h.z * h.z;
    let facets = 1.0 / (PI * alpha * alpha * slopes * slopes);
    0.5 * (reflected[0] + reflected[1]) * facets / (4.0 * wi.z * wo.z * (1.0 + hidden(wi) + hidden(wo)))
}

#[test]
fn the_shader_agrees_with_the_renderers_film() {
    for (text, roughness) in [("air/keratin:300/melanin", 0.1), ("air/4*(melanin:60/air:110)/keratin", 0.3)] {
        let stack = Stack::parse(text, &Library::builtin()).unwrap();
        let reflected = reflected(&stack);
        let packed = PackedLayers::new(&reflected, roughness).unwrap();
        let surface =
            Surface::ThinFilm(ThinFilm::new(&stack, FacetRoughness::even(roughness), None).unwrap());
        for asking in Asking::all(Shader::Layers) {
            let loaded = asking.layers(&packed, 25);
            let mut stream = Stream::new(5, &[]);
            let (mut worst, mut worst_colour, mut of_renderer) = (0.0_f64, 0.0_f64, 0.0_f64);
            for _ in 0..40 {
                let wi = direction(&mut stream);
                let wave = (stream.unit() * reflected.nm.len() as f64) as usize;
                let mut all = vec![DVec3::new(-wi.x, -wi.y, wi.z)];
                all.extend((0..30).map(|_| direction(&mut stream)));
                let of = |wo: &DVec3, nm: f64| exact(&stack, roughness, nm, [wi, *wo]);
                let renderer = |wo: &DVec3, nm: f64| {
                    surface.bind(&Hit::default(), *wo, Lambdas::splat(nm)).eval(wi).f[0]
                };
                let ask =
                    |wo: &DVec3| Question::Values { wavelength_nm: wave as f32, wi, wo: *wo, instance: None };
                let answers = asking.ask(&loaded, &all.iter().map(ask).collect::<Vec<_>>());
                let expected: Vec<f64> = all.iter().map(|wo| of(wo, reflected.nm[wave])).collect();
                let peak = expected.iter().fold(0.0_f64, |peak, v| peak.max(*v));
                for ((wo, expected), [found, ..]) in all.iter().zip(&expected).zip(answers) {
                    worst = worst.max((expected - found).abs() / peak);
                    let other = renderer(wo, reflected.nm[wave]);
                    of_renderer = of_renderer.max((other - found).abs() / peak);
                }
                let ask = |wo: &DVec3| Question::Colour { wi, wo: *wo, instance: None };
                let answers = asking.ask(&loaded, &all.iter().map(ask).collect::<Vec<_>>());
                for (wo, found) in all.iter().zip(answers) {
                    let values: Vec<f64> = loaded.waves.nm().iter().map(|nm| of(wo, *nm)).collect();
                    let expected = loaded.waves.linear_rgb(&values);
                    for (found, expected) in found.into_iter().zip(expected) {
                        worst_colour = worst_colour.max((found - expected).abs() / peak);
                    }
                }
            }
            println!(
                "{} {text}: {worst:.1e}, colours {worst_colour:.1e}, renderer {of_renderer:.1e}",
                asking.gpu
            );
            assert!(of_renderer < RENDERER_AGREES, "{text}: {of_renderer}");
            assert!(worst < AGREES && worst_colour < AGREES, "{text}: {worst} {worst_colour}");
        }
    }
}
