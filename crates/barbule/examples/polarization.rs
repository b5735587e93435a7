//! How wrong it is that light loses its polarization at each bounce: the tables of docs/theory/rendering.md.
//!
//! `target/release/examples/polarization pictures PRESET… [--samples 1024]` renders pictures of 96 × 60 pixels of presets' own view
//! with and without polarization between bounces, from the same random numbers; `target/release/examples/polarization
//! fields SPECIES…` shows what simulated fields do to polarization (after `cargo build --release --workspace --examples`). A
//! minute or two each.

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program over what is built in

#[path = "../tests/it/measure"]
mod measure {
    pub(crate) mod polarized;
}

use std::sync::Arc;

use barbule::brdf::{FeatherBrdf, Options};
use barbule::bsdf::{Keratin, Reflectance};
use barbule::io::decode_material;
use barbule::material::Library;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::stage::Stage;
use barbule::scattering::far_field::{Illumination, Polarization, Window};
use barbule::scene::Scene;
use barbule::scene::description::{BarbuleDress, PigmentedKeratin, RamusDress, SceneDescription};
use barbule::solve::surface::{Accuracy, far_field};
use barbule::spectrum::colour::{Illuminant, matching};
use barbule::spectrum::dense::{Lambdas, WAVES};
use barbule::spectrum::difference::{delta_e_2000, lab};
use barbule::spectrum::sensor::Band;
use barbule::structure::{SpeciesModel, Structure};
use barbule::{Error, Result};
use measure::polarized::{BarbuleModel, MODELS, PolarizedScene, fresnel};
use rayon::prelude::*;

const SIZE: [u32; 2] = [96, 60];
const SAMPLES: u64 = 1024;
/// Of these the renderer's own values are compared too.
const COMPARED: u64 = 16;
const SEED: u64 = 1;

/// A pixel is one of those where scattering between surfaces counts when this much of its light was scattered twice or more.
const MUCH: f64 = 0.25;

fn main() -> Result<()> {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let mut samples = SAMPLES;
    if let Some(at) = words.iter().position(|word| word == "--samples") {
        let count = words.get(at + 1).and_then(|count| count.parse().ok()).filter(|count| count % 2 == 0);
        samples = count.ok_or_else(|| Error::input("--samples needs an even number"))?;
        words.drain(at..at + 2);
    }
    match words.split_first() {
        Some((what, presets)) if what == "pictures" => {
            let heads = [
                "scene",
                "scattered twice or more",
                "by barbules twice or more",
                "barbules",
                "mean Y",
                "relative RMSE of XYZ",
                "pixels of much such light",
                "their mean Y",
                "ΔE00 of all pixels: mean, 95 %, 99 %",
            ];
            print_heads(&heads);
            presets.iter().try_for_each(|preset| pictures(preset, samples))
        }
        Some((what, species)) if what == "fields" => {
            let heads = [
                "species",
                "θ_i, φ_i",
                "along and across the barbule",
                "at any angle",
                "of a keratin boundary",
                "changes polarization",
                "in step",
            ];
            print_heads(&heads);
            species.iter().try_for_each(|name| fields(name))
        }
        _ => Err(Error::input("give `pictures PRESET…` or `fields SPECIES…`")),
    }
}

fn print_heads(heads: &[&str]) {
    println!("| {} |\n|{}", heads.join(" | "), " --- |".repeat(heads.len()));
}

/// X, Y and Z over those of daylight of radiance 1.
fn xyz(radiance: &[f64; WAVES], wavelengths: Lambdas, white: [f64; 3]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (value, nm) in radiance.iter().zip(wavelengths.nm()) {
        let weights = matching(nm);
        for c in 0..3 {
            sum[c] += value * weights[c] / (WAVES as f64 * white[c]);
        }
    }
    sum
}

fn daylight() -> [f64; 3] {
    let mut sum = [0.0; 3];
    for nm in Band::HUMAN.each_nm().map(|nm| nm + 0.5).filter(|nm| Band::HUMAN.contains(*nm)) {
        let power = Illuminant::D65.power(nm) / Illuminant::D65.power(560.0);
        for (sum, weight) in sum.iter_mut().zip(matching(nm)) {
            *sum += power * weight;
        }
    }
    sum
}

/// Means over a pixel's samples.
#[derive(Debug, Clone, Copy, Default)]
struct Pixel {
    /// XYZ without polarization, and with it for each of [`MODELS`]; of the first and of the second half of the samples.
    depolarized: [[f64; 3]; 2],
    polarized: [[[f64; 3]; 2]; MODELS.len()],
    /// Y of what was scattered twice or more, and by barbules' upper sides so.
    twice: f64,
    twice_by_barbules: f64,
    /// Y of the first samples, the renderer's and ours.
    compared: [f64; 2],
}

impl Pixel {
    fn plain(&self) -> [f64; 3] {
        mean(self.depolarized)
    }

    fn kept(&self, model: usize) -> [f64; 3] {
        mean(self.polarized[model])
    }
}

fn mean([a, b]: [[f64; 3]; 2]) -> [f64; 3] {
    [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]))
}

fn keratin(of: &PigmentedKeratin) -> Result<(Keratin, f64)> {
    Ok((Keratin::new(of.roughness, of.index, Reflectance::new(|_| 0.0)?)?, of.index))
}

fn pictures(preset: &str, samples: u64) -> Result<()> {
    let description = SceneDescription::named(preset)?;
    let wanted = description.material().unwrap_or_default().replace(':', "-");
    let (_, bytes) = barbule_birds::materials()
        .find(|(name, _)| name.starts_with(&wanted))
        .ok_or_else(|| Error::input(format!("no shipped material is called {wanted}")))?;
    let material = decode_material(bytes)?;
    let of = |polarization| FeatherBrdf::new(&material, Options { polarization, ..Options::default() });
    let (Scene { objects, lamps, environment, camera }, _) =
        description.clone().wearing(Arc::new(of(None)?))?.scene(SEED)?;
    let (stage, lighting) = (Stage::new(objects)?, Lighting::new(lamps, environment.as_ref())?);
    let no_keratin = || Error::input(format!("{preset}: is not a feather of keratin"));
    let dress = &description.lone_feather().ok_or_else(no_keratin)?.dress;
    let (RamusDress::Keratin(ramus), BarbuleDress::Barbule(barbules)) = (&dress.ramus, &dress.distal) else {
        return Err(no_keratin());
    };
    let scene = PolarizedScene {
        stage: &stage,
        lighting: &lighting,
        camera: &camera,
        barbules: Some([of(Some(Polarization::First))?, of(Some(Polarization::Second))?]),
        boundaries: vec![keratin(&dress.shaft)?, keratin(ramus)?, keratin(&barbules.underside)?],
        scatterings: description.scatterings,
    };
    let transport = Transport { most_scatterings: description.scatterings, ..Transport::default() };
    let integrator = Integrator::new(&stage, &lighting, &camera, transport);
    let white = daylight();
    let pixels: Vec<Pixel> = (0..SIZE[0] * SIZE[1])
        .into_par_iter()
        .map(|index| pixel(&scene, &integrator, [index % SIZE[0], index / SIZE[0]], samples, white))
        .collect();
    report(preset, &pixels, description.exposure.factor().unwrap_or(1.0));
    Ok(())
}

fn pixel(
    scene: &PolarizedScene<'_>,
    integrator: &Integrator<'_>,
    at: [u32; 2],
    samples: u64,
    white: [f64; 3],
) -> Pixel {
    let mut sums = Pixel::default();
    for sample in 0..samples {
        let seen = scene.sample(at, SIZE, sample, SEED);
        let colour = |radiance: &[f64; WAVES]| xyz(radiance, seen.hero.wavelengths, white);
        let half = usize::from(2 * sample >= samples);
        let add = |sum: &mut [f64; 3], radiance: &[f64; WAVES]| {
            for (sum, value) in sum.iter_mut().zip(colour(radiance)) {
                *sum += 2.0 * value / samples as f64;
            }
        };
        add(&mut sums.depolarized[half], &seen.depolarized);
        for (sum, radiance) in sums.polarized.iter_mut().zip(&seen.polarized) {
            add(&mut sum[half], radiance);
        }
        sums.twice += colour(&seen.twice)[1] / samples as f64;
        sums.twice_by_barbules += colour(&seen.twice_by_barbules)[1] / samples as f64;
        if sample < COMPARED {
            let own = integrator.sample(at, SIZE, sample, SEED);
            sums.compared[0] += xyz(&own.radiance, own.hero.wavelengths, white)[1];
            sums.compared[1] += colour(&seen.depolarized)[1];
        }
    }
    sums
}

fn report(preset: &str, pixels: &[Pixel], exposure: f64) {
    let sum = |of: &dyn Fn(&Pixel) -> f64| pixels.iter().map(of).sum::<f64>();
    let whole = sum(&|p| p.plain()[1]);
    let much: Vec<&Pixel> = pixels.iter().filter(|p| p.twice > MUCH * p.plain()[1]).collect();
    for (k, model) in MODELS.iter().enumerate() {
        let model = match model {
            BarbuleModel::Tables { step } => format!("tables, in step {step}"),
            BarbuleModel::Boundary => "keratin boundary".into(),
            BarbuleModel::Polarizer => "polarizer".into(),
        };
        let change = sum(&|p| p.kept(k)[1]) / whole - 1.0;
        // The product of both halves' differences has no noise in its mean.
        let squares = sum(&|p| {
            let apart = |half: usize, c: usize| p.polarized[k][half][c] - p.depolarized[half][c];
            (0..3).map(|c| apart(0, c) * apart(1, c)).sum()
        });
        let power = sum(&|p| (0..3).map(|c| p.depolarized[0][c] * p.depolarized[1][c]).sum());
        let there = |of: &dyn Fn(&Pixel) -> f64| much.iter().map(|p| of(p)).sum::<f64>();
        let locally = match there(&|p| p.plain()[1]) {
            0.0 => "–".into(),
            plain => format!("{:+.2} %", 100.0 * (there(&|p| p.kept(k)[1]) / plain - 1.0)),
        };
        let seen = |xyz: [f64; 3]| lab(xyz.map(|v| (exposure * v).max(0.0)), [1.0; 3]);
        let mut differences: Vec<f64> =
            pixels.iter().map(|p| delta_e_2000(seen(p.plain()), seen(p.kept(k)))).collect();
        differences.sort_by(f64::total_cmp);
        let quantile = |q: f64| differences[(q * (differences.len() - 1) as f64) as usize];
        println!(
            "| {preset} | {:.2} % | {:.2} % | {model} | {:+.3} % | {:.3} % | {:.1} % | {locally} | {:.3}, {:.3}, {:.3} |",
            100.0 * sum(&|p| p.twice) / whole,
            100.0 * sum(&|p| p.twice_by_barbules) / whole,
            100.0 * change,
            100.0 * (squares.max(0.0) / power).sqrt(),
            100.0 * much.len() as f64 / pixels.len() as f64,
            differences.iter().sum::<f64>() / differences.len() as f64,
            quantile(0.95),
            quantile(0.99),
        );
    }
    let compared = |k: usize| sum(&|p| p.compared[k]);
    println!("{preset}: mean Y of {COMPARED} samples over the renderer's: {:.5}", compared(1) / compared(0));
}

/// What fields of 20 instances do to polarization about the mirror direction of several directions.
fn fields(species: &str) -> Result<()> {
    let structure = Structure::Species(Box::new(SpeciesModel::builtin(species, None, Library::builtin())?));
    for (theta_deg, phi_deg) in
        [(0.0_f64, 0.0_f64), (0.0, 45.0), (0.0, 70.0), (30.0, 0.0), (30.0, 45.0), (60.0, 0.0), (60.0, 45.0)]
    {
        let (theta_i, phi_i) = (theta_deg.to_radians(), phi_deg.to_radians());
        let found = [450.0, 520.0, 600.0]
            .par_iter()
            .map(|&wavelength_nm| {
                let light = Illumination { wavelength_nm, theta_i, phi_i, window: Window::Gaussian };
                polarization(&structure, &light)
            })
            .collect::<Result<Vec<_>>>()?;
        let mean = |of: &dyn Fn(&Polarized) -> f64| found.iter().map(of).sum::<f64>() / found.len() as f64;
        // About the horizontal facet that mirrors the light.
        let boundary = fresnel(theta_i.cos() * phi_i.cos(), 1.56)[1][0];
        println!(
            "| {species} | {theta_deg}°, {phi_deg}° | {:.2} | {:.2} | {boundary:.2} | {:.1} % | {:+.2} |",
            mean(&|p| p.axial),
            mean(&|p| p.degree),
            100.0 * mean(&|p| p.changed),
            mean(&|p| p.in_step),
        );
    }
    Ok(())
}

/// What fields do to polarization; all azimuths count by their light.
struct Polarized {
    /// Degree of polarization of reflected light that came unpolarized, of its parts along and across the barbule alone.
    axial: f64,
    /// The degree of linear polarization, at whatever angle.
    degree: f64,
    /// Part of the light that changes between e₁ and e₂.
    changed: f64,
    /// Mean of Re(S₁₁ S₂₂*) over that of |S₁₁ S₂₂|, about the axes of [`PolarizedScene`].
    in_step: f64,
}

fn polarization(structure: &Structure, light: &Illumination) -> Result<Polarized> {
    const INSTANCES: usize = 20;
    const AZIMUTHS: usize = 360;
    // I, Q and U of light that came unpolarized, by azimuth.
    let mut stokes = vec![[0.0; 3]; AZIMUTHS];
    let [mut changed, mut in_step, mut most] = [0.0; 3];
    for index in 0..INSTANCES {
        let section = structure.instance(SEED, index)?;
        let far = far_field(&section, light, AZIMUTHS, &Accuracy::default())?;
        for (at, stokes) in stokes.iter_mut().enumerate() {
            let [[s11, s21], [s12, s22]] = far.amplitudes.each_ref().map(|e| [e[0][at], e[1][at]]);
            for [e1, e2] in [[s11, s21], [s12, s22]] {
                stokes[0] += e1.norm_sqr() + e2.norm_sqr();
                stokes[1] += e1.norm_sqr() - e2.norm_sqr();
                stokes[2] += 2.0 * (e1 * e2.conj()).re;
            }
            changed += s21.norm_sqr() + s12.norm_sqr();
            // e₂ is on the same side of what leaves the surface, so on the other one of light that comes.
            in_step -= (s11 * s22.conj()).re;
            most += (s11 * s22).norm();
        }
    }
    let sum = |of: &dyn Fn(&[f64; 3]) -> f64| stokes.iter().map(of).sum::<f64>();
    let whole = sum(&|s| s[0]);
    Ok(Polarized {
        axial: sum(&|s| s[1].abs()) / whole,
        degree: sum(&|s| s[1].hypot(s[2])) / whole,
        changed: changed / whole,
        in_step: in_step / most,
    })
}
