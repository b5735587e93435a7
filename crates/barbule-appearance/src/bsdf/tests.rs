//! What must hold for every model: samples follow their density, energy, and Helmholtz's reciprocity where it is claimed.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;

use super::*;
use crate::brdf::fixtures::example;
use crate::brdf::{FeatherBrdf, Options};
use crate::material::Library;
use crate::math::rng::Stream;
use crate::spectrum::dense::WAVES;
use crate::stack::Stack;

fn grey(value: f64) -> Reflectance {
    Reflectance::new(|_| value).unwrap()
}

pub(super) fn keratin(melanin: f64) -> Keratin {
    Keratin::new(0.3, 1.56, Reflectance::melanin(melanin).unwrap()).unwrap()
}

fn hair() -> Hair {
    let absorption = Absorption::pigments(0.6, 0.1).unwrap();
    Hair::new(HairParameters {
        longitudinal_roughness: 0.25,
        azimuthal_roughness: 0.3,
        scale_tilt: 0.035,
        index: FibreIndex::Constant(1.55),
        absorption,
        height_over_width: 1.0,
    })
    .unwrap()
}

pub(super) fn barbule() -> BarbuleSurface {
    let brdf = Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap());
    BarbuleSurface {
        brdf,
        instances: true,
        below: None,
        under: keratin(20.0),
        cells: Cells::default(),
        opacity: 1.0,
    }
}

/// A barbule whose lower side has a BRDF, too.
fn two_sided() -> BarbuleSurface {
    let one = barbule();
    BarbuleSurface { below: Some(one.brdf.clone()), ..one }
}

fn film() -> ThinFilm {
    let stack = Stack::parse("air/keratin:400/melanin:60/keratin", &Library::builtin()).unwrap();
    ThinFilm::new(&stack, FacetRoughness { across: 0.3, along: 0.15 }, Some(grey(0.8))).unwrap()
}

/// Barbules of a twentieth of a millimetre, of which the hit lies in one.
fn clad() -> Clad {
    let layout = Layout { uv_mm: [1.0; 2], width_mm: 0.05, length_mm: 0.0, cell_mm: 0.02, swelling: 0.0 };
    Clad::new(barbule(), layout).unwrap()
}

fn surfaces() -> Vec<(&'static str, Surface)> {
    vec![
        ("white", Surface::Lambertian(Lambertian::new(grey(1.0)))),
        ("sheet", Surface::Lambertian(Lambertian::translucent(grey(0.2), grey(0.7)).unwrap())),
        ("keratin", Surface::Keratin(keratin(2.0))),
        ("barbule", Surface::Barbule(barbule())),
        ("two-sided", Surface::Barbule(two_sided())),
        ("clad", Surface::Clad(Box::new(clad()))),
        ("hair", Surface::Hair(hair())),
        (
            "copper",
            Surface::Conductor(Conductor::copper(FacetRoughness { across: 0.3, along: 0.1 }).unwrap()),
        ),
        ("film", Surface::ThinFilm(film())),
        ("grating", Surface::Grating(super::grating::tests::grating())),
        ("rough grating", Surface::Grating(super::grating::tests::rough())),
        ("measured", Surface::Measured(super::measured::tests::rgl())),
        ("measured isotropic", Surface::Measured(super::measured::tests::merl())),
        (
            "frosted",
            Surface::RoughDielectric(
                RoughDielectric::new(FacetRoughness { across: 0.3, along: 0.2 }, 1.5).unwrap(),
            ),
        ),
    ]
}

/// A hit whose frame is not the scene's.
pub(super) fn hit() -> Hit {
    let normal = DVec3::new(0.2, -0.3, 0.9).normalize();
    let frame = Frame::new(normal, DVec3::new(0.5, 1.0, 0.1));
    let uv_gradients = [frame.y, frame.x];
    Hit { normal, vane_normal: normal, frame, uv_gradients, instance: 7, ..Hit::default() }
}

pub(super) const PATH: [f64; WAVES] = [550.0, 610.0, 470.0, 510.0, 400.0, 430.0, 650.0, 690.0];

/// Directions of the viewer above and below.
pub(super) fn viewers() -> [DVec3; 3] {
    let frame = hit().frame;
    [[0.0, 0.1, 1.0], [0.7, -0.2, 0.6], [0.3, 0.2, -0.8]]
        .map(|v| frame.to_world(DVec3::from_array(v).normalize()))
}

/// A direction of the scene from y in the hit's frame and the azimuth about it, from x to z. A barbule's lobe is narrow
/// in y alone, so even steps resolve it.
fn towards(y: f64, azimuth: f64) -> DVec3 {
    let across = (1.0 - y * y).max(0.0).sqrt();
    hit().frame.to_world(DVec3::new(across * azimuth.cos(), y, across * azimuth.sin()))
}

/// Counts of samples in bins over both hemispheres against the integral of the stated density (χ²): within five deviations.
pub(super) fn assert_samples_follow_density(name: &str, bsdf: &Bsdf<'_>, mut check: impl FnMut(&BsdfSample)) {
    const SIDE: usize = 12;
    const FINE: usize = 40;
    let frame = hit().frame;
    let count = 40_000;
    let mut seen = vec![0.0; SIDE * SIDE];
    let mut stream = Stream::new(11, &[]);
    for _ in 0..count {
        let u = [stream.unit(), stream.unit(), stream.unit()];
        let Some(sample) = bsdf.sample(u) else { continue };
        let local = frame.to_local(sample.wi);
        let row = (0.5 * (local.y + 1.0) * SIDE as f64).min(SIDE as f64 - 1.0) as usize;
        let column = ((local.z.atan2(local.x) / TAU + 0.5) * SIDE as f64) as usize;
        seen[row * SIDE + column.min(SIDE - 1)] += 1.0;
        assert!(bsdf.lobes().has(sample.lobes), "{name}");
        assert_eq!(bsdf.pdf(sample.wi), sample.evaluation.pdf);
        check(&sample);
    }
    let mut expected = vec![0.0; SIDE * SIDE];
    let step = 4.0 * PI / (SIDE * FINE * SIDE * FINE) as f64;
    for i in 0..SIDE * FINE {
        for j in 0..SIDE * FINE {
            let y = 2.0 * (i as f64 + 0.5) / (SIDE * FINE) as f64 - 1.0;
            let azimuth = TAU * ((j as f64 + 0.5) / (SIDE * FINE) as f64 - 0.5);
            expected[(i / FINE) * SIDE + j / FINE] +=
                f64::from(count) * step * bsdf.pdf(towards(y, azimuth))[0];
        }
    }
    let (mut chi2, mut degrees) = (0.0, 0.0);
    for (seen, expected) in seen.iter().zip(&expected) {
        if *expected > 8.0 {
            // The sum resolves a narrow lobe's edge in a bin to 1 %.
            chi2 += (seen - expected).powi(2) / (expected + (0.01 * expected).powi(2));
            degrees += 1.0;
        }
    }
    assert!(chi2 < degrees + 5.0 * f64::sqrt(2.0 * degrees), "{name}: χ² {chi2} of {degrees}");
}

#[test]
fn samples_follow_their_density_on_both_sides() {
    let hit = hit();
    for (name, surface) in surfaces() {
        for wo in viewers() {
            let bsdf = surface.bind(&hit, wo, Lambdas::new(PATH));
            assert_samples_follow_density(name, &bsdf, |sample| {
                let is_above = |d: DVec3| hit.frame.to_local(d).z > 0.0;
                let same_side = is_above(sample.wi) == is_above(wo);
                let side = if same_side { Lobes::REFLECTION } else { Lobes::TRANSMISSION };
                assert!(sample.lobes.has(side), "{name}");
            });
        }
    }
}

/// Albedo by sampling: what is reflected and transmitted. Monte Carlo of 20,000: 1 %.
#[test]
fn no_surface_gives_more_than_it_gets() {
    for (name, surface) in surfaces() {
        for wo in viewers() {
            let bsdf = surface.bind(&hit(), wo, Lambdas::new(PATH));
            let mut stream = Stream::new(12, &[]);
            let count = 20_000;
            let mut sum = 0.0;
            for _ in 0..count {
                let u = [stream.unit(), stream.unit(), stream.unit()];
                if let Some(BsdfSample { evaluation: e, .. }) = bsdf.sample(u) {
                    sum += e.f[0] * e.cosine / e.pdf[0];
                }
            }
            let albedo = sum / f64::from(count);
            let expected = match name {
                "white" => 1.0..=1.0,
                "sheet" => 0.9..=0.9,
                // A barbule's instance fluctuates about the mean.
                "barbule" | "two-sided" | "clad" => 0.0..=2.0,
                // Radiance within glass is higher by the square of its index.
                "frosted" => 0.0..=2.25,
                _ => 0.0..=1.0,
            };
            assert!(albedo > expected.start() - 0.01 && albedo < expected.end() + 0.01, "{name}: {albedo}");
        }
    }
}

#[test]
fn surfaces_without_instances_or_offsets_are_reciprocal() {
    let hit = hit();
    let reciprocal = ["white", "sheet", "keratin", "copper", "film", "grating", "rough grating"];
    for (name, surface) in surfaces().iter().filter(|(name, _)| reciprocal.contains(name)) {
        for a in viewers() {
            for b in viewers() {
                let f = |wo, wi| surface.bind(&hit, wo, Lambdas::new(PATH)).eval(wi).f;
                let (ab, ba) = (f(a, b), f(b, a));
                assert!(ab.iter().zip(ba).all(|(x, y)| (x - y).abs() <= 1e-12 * x.abs()), "{name}");
            }
        }
    }
}

#[test]
fn opaque_surfaces_scatter_nothing_to_the_other_side() {
    let [above, _, below] = viewers();
    for (name, surface) in surfaces() {
        for (wo, wi) in [(above, below), (below, above)] {
            let evaluation = surface.bind(&hit(), wo, Lambdas::new(PATH)).eval(wi);
            assert_eq!(evaluation.f != [0.0; WAVES], ["sheet", "hair", "frosted"].contains(&name), "{name}");
            assert!(evaluation.cosine >= 0.0);
        }
        assert!(surface.is_opaque() && surface.opacity(&hit(), -above, above) == 1.0);
    }
}

/// Lit and seen from below, a barbule whose lower side has the BRDF of the upper one is that barbule turned by 180° about its axis, lit
/// and seen from above; the trough of an arch leans as an arch whose ends are exchanged.
#[test]
fn a_lower_side_is_the_upper_side_of_the_turned_barbule() {
    let arch = |low, high| Some(Arch { low, high, blur: 0.2 });
    let cells = |arch| Cells { size: 0.05, wall_mm: 0.002, arch, ..Cells::default() };
    for (own, turned) in [(None, None), (arch(-0.9, 0.7), arch(0.7, -0.9))] {
        let own = Surface::Barbule(BarbuleSurface { cells: cells(own), ..two_sided() });
        let turned = Surface::Barbule(BarbuleSurface { cells: cells(turned), below: None, ..two_sided() });
        for place in [0.01, 0.4] {
            let ribbon = OnRibbon { half_width: 0.01, cell_length: 0.03, place, ..OnRibbon::default() };
            let upright = Hit { uv: [0.1, 0.3], ribbon, ..hit() };
            let over =
                Hit { normal: -upright.normal, frame: upright.frame.flipped(), uv: [0.1, -0.3], ..upright };
            let viewers = [[0.0, 0.1, -1.0], [0.7, -0.2, -0.6], [-0.5, 0.2, -0.4]];
            let world = |v: [f64; 3]| upright.frame.to_world(DVec3::from_array(v).normalize());
            for wo in viewers.map(world) {
                let below = own.bind(&upright, wo, Lambdas::new(PATH));
                let above = turned.bind(&over, wo, Lambdas::new(PATH));
                let mut seen = 0.0_f64;
                for u in [[0.1, 0.7, 0.2], [0.5, 0.5, 0.5], [0.9, 0.2, 0.4]] {
                    let (Some(a), Some(b)) = (below.sample(u), above.sample(u)) else { panic!("{wo}") };
                    assert_eq!((a.wi, a.evaluation.pdf), (b.wi, b.evaluation.pdf));
                    for (a, b) in a.evaluation.f.into_iter().zip(b.evaluation.f) {
                        assert!((a - b).abs() <= 1e-12 * a.abs(), "{a} {b}");
                        seen = seen.max(a);
                    }
                }
                assert!(seen > 0.0);
            }
        }
    }
}
