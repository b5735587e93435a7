//! Every material under every light: furnaces, the techniques against each other, and energy over both sides.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::bsdf::{
    Absorption, BarbuleSurface, Cells, Clad, Conductor, FacetRoughness, Frame, Hit, Keratin, Lambertian,
    Layout, Reflectance, RoughDielectric, Surface, ThinFilm,
};
use barbule::material::Library;
use barbule::math::rng::Stream;
use barbule::scene::emission::Emission;
use barbule::scene::geometry::Geometry;
use barbule::scene::light::{Lamp, Light, Rectangle, Sphere, Sun, disc_radiance};
use barbule::scene::sky::{Environment, Sky};
use barbule::spectrum::dense::{Lambdas, WAVES};
use barbule::stack::Stack;
use glam::DVec3;

use crate::small_scenes::{
    Lights, SLACK, agreeing, assert_luminance, bright_pixel, camera, fibres, film_of, hair, lamp, scene, sky,
    square, under_sky,
};

fn grey(value: f64) -> Reflectance {
    Reflectance::new(|_| value).unwrap()
}

fn film(stack: &str, body: f64) -> Surface {
    let roughness = FacetRoughness { across: 0.4, along: 0.2 };
    let stack = Stack::parse(stack, &Library::builtin()).unwrap();
    Surface::ThinFilm(ThinFilm::new(&stack, roughness, Some(grey(body))).unwrap())
}

/// What takes nothing of the light, with its shape. Of rough boundaries' single scattering a white body takes what they lose.
fn white() -> Vec<(&'static str, Surface, Geometry)> {
    let sheet = Lambertian::translucent(grey(0.6), grey(0.4)).unwrap();
    vec![
        ("white", Surface::Lambertian(Lambertian::new(grey(1.0))), square(2.0)),
        ("sheet", Surface::Lambertian(sheet), square(2.0)),
        ("keratin", Surface::Keratin(Keratin::new(0.3, 1.56, grey(1.0)).unwrap()), square(2.0)),
        ("film", film("air/keratin:400/1.7:100/1.4", 1.0), square(2.0)),
        // The reflectance of this index is 1 but for 2e-6; a smooth metal loses next to nothing between its facets.
        (
            "metal",
            Surface::Conductor(Conductor::new(FacetRoughness::even(0.05), |_| [1e-3, 40.0]).unwrap()),
            square(2.0),
        ),
        ("hair", hair(0.4, Absorption::new(|_| 0.0).unwrap()), fibres()),
    ]
}

/// Radiance 1 from everywhere, by each kind of light that can.
fn furnaces() -> Vec<(&'static str, Lights)> {
    let whole = Sun { direction: DVec3::X, cos_radius: -1.0, emission: Emission::daylight() };
    // A box of six rectangles that face inwards.
    let walls = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]).map(|out| {
        let edge = out.any_orthonormal_vector();
        let other = -out.cross(edge);
        let emission = Emission::daylight();
        let corner = 50.0 * (out - edge - other);
        let wall = Rectangle { corner, edge_u: 100.0 * edge, edge_v: 100.0 * other, emission };
        Lamp { light: Light::Rectangle(wall), weight: 1.0 }
    });
    let image = Sky::image(8, 4, vec![[1.0; 3]; 32], 1.0, 0.0).unwrap();
    vec![
        ("sky", under_sky(sky(1.0))),
        ("image", under_sky(Environment { sky: image, weight: 1.0 })),
        ("sun", lamp(Light::Sun(whole))),
        ("rectangles", (walls.collect(), None)),
    ]
}

/// Whatever takes no light is as bright as what surrounds it.
#[test]
fn every_white_material_vanishes_in_a_furnace_of_every_light() {
    for (light, lights) in furnaces() {
        for (name, surface, geometry) in white() {
            let scene = scene(geometry, surface, lights.clone(), camera(1.0, 2.0));
            let film = film_of(scene, [16, 16], 128);
            let hits: u32 = (0..256).map(|i| film.pixel(i % 16, i / 16).hits).sum();
            assert!(hits > 128 * 128, "{name}: {hits}");
            assert_luminance(&film, 1.0, &format!("{name} under {light}"));
        }
    }
}

/// What takes some.
fn coloured() -> Vec<(&'static str, Surface, Geometry)> {
    let brdf = Arc::new(FeatherBrdf::new(&example(12), Options::default()).unwrap());
    let under = Keratin::new(0.3, 1.56, Reflectance::melanin(2.0).unwrap()).unwrap();
    let plate = |instances| BarbuleSurface {
        brdf: brdf.clone(),
        instances,
        below: None,
        under: under.clone(),
        cells: Cells::default(),
        opacity: 1.0,
    };
    let barbule = |instances| Surface::Barbule(plate(instances));
    // Some tens of barbules of swelling cells on a square of two millimetres.
    let layout = Layout { uv_mm: [1.0; 2], width_mm: 0.05, length_mm: 0.4, cell_mm: 0.03, swelling: 0.1 };
    let clad = Surface::Clad(Box::new(Clad::new(plate(false), layout).unwrap()));
    let sheet = Lambertian::translucent(grey(0.2), grey(0.7)).unwrap();
    vec![
        ("sheet", Surface::Lambertian(sheet), square(2.0)),
        ("keratin", Surface::Keratin(under.clone()), square(2.0)),
        ("barbule", barbule(false), square(2.0)),
        ("instance", barbule(true), square(2.0)),
        ("clad", clad, square(2.0)),
        (
            "copper",
            Surface::Conductor(Conductor::copper(FacetRoughness { across: 0.4, along: 0.2 }).unwrap()),
            square(2.0),
        ),
        ("film", film("air/keratin:400/melanin:60/keratin", 0.5), square(2.0)),
        (
            "frosted",
            Surface::RoughDielectric(
                RoughDielectric::new(FacetRoughness { across: 0.4, along: 0.3 }, 1.5).unwrap(),
            ),
            square(2.0),
        ),
        ("hair", hair(0.4, Absorption::pigments(0.6, 0.1).unwrap()), fibres()),
    ]
}

/// Lights of every kind that all techniques find, wide enough for directions of the BSDF to meet them, about the mirror
/// direction of the camera.
fn lamps() -> Vec<(&'static str, Lights)> {
    let eye = camera(0.9, 2.0).eye.normalize();
    let mirror = DVec3::new(-eye.x, -eye.y, eye.z);
    let emission = Emission::daylight;
    let sun =
        Sun { direction: mirror, cos_radius: 0.95, emission: emission().scaled(disc_radiance(0.3, 1.0)) };
    let sphere = Sphere { centre: 10.0 * mirror, radius: 3.0, emission: emission().scaled(3.0) };
    let (u, v) = mirror.any_orthonormal_pair();
    let rectangle = Rectangle {
        corner: 10.0 * mirror - 3.0 * (u + v),
        edge_u: 6.0 * v,
        edge_v: 6.0 * u,
        emission: emission().scaled(3.0),
    };
    vec![
        ("sky", under_sky(sky(0.7))),
        ("image", under_sky(Environment { sky: bright_pixel(24, 12), weight: 1.0 })),
        ("sun", lamp(Light::Sun(sun))),
        ("sphere", lamp(Light::Sphere(sphere))),
        ("rectangle", lamp(Light::Rectangle(rectangle))),
    ]
}

/// What the techniques of several pictures differ by, in deviations of their noise.
#[derive(Clone, Default)]
struct Differences {
    sums: [f64; 2],
    slack: [f64; 2],
    count: f64,
}

impl Differences {
    fn add(&mut self, [both, single @ ..]: [(f64, f64); 3]) {
        for (k, (mean, error)) in single.into_iter().enumerate() {
            let deviation = error.hypot(both.1);
            self.sums[k] += (mean - both.0) / deviation;
            self.slack[k] += SLACK * both.0 / deviation;
        }
        self.count += 1.0;
    }

    /// Four deviations of the sum.
    fn assert_none(&self, what: &str) {
        for (sum, slack) in self.sums.iter().zip(self.slack) {
            let allowed = 4.0 * self.count.sqrt() + slack;
            assert!(
                sum.abs() < allowed,
                "{what}: techniques differ by {sum:.1} in all, {allowed:.1} allowed"
            );
        }
    }
}

/// A wrong density or weight is that of a material or of a light, so it tells in all pictures of either: summed over them it is found where it
/// is a third (of a light) or half (of a material) of what a single picture would tell.
#[test]
fn techniques_agree_on_every_material_under_every_light() {
    let names: Vec<&str> = coloured().iter().map(|(name, ..)| *name).collect();
    let mut of_materials = vec![Differences::default(); names.len()];
    for (light, lights) in lamps() {
        let mut of_light = Differences::default();
        for ((name, surface, geometry), of_material) in coloured().into_iter().zip(&mut of_materials) {
            let what = format!("{name} under {light}");
            let means = agreeing(scene(geometry, surface, lights.clone(), camera(0.9, 2.0)), 128, &what);
            assert!(means[0].0 > 1e-3, "{what}: {means:?}");
            of_light.add(means);
            of_material.add(means);
        }
        of_light.assert_none(light);
    }
    for (name, of_material) in names.into_iter().zip(of_materials) {
        of_material.assert_none(name);
    }
}

const PATH: [f64; WAVES] = [550.0, 610.0, 470.0, 510.0, 400.0, 430.0, 650.0, 690.0];

/// Reflected and transmitted shares at the hero's wavelength: a sum over both hemispheres that knows nothing of how directions are drawn, and
/// the mean of drawn ones. White materials give all that they get; others less.
#[test]
fn energy_over_both_sides_is_that_of_samples_and_never_more_than_all() {
    let normal = DVec3::new(0.2, -0.3, 0.9).normalize();
    let frame = Frame::new(normal, DVec3::new(0.5, 1.0, 0.1));
    let hit = Hit { normal, vane_normal: normal, frame, instance: 7, ..Hit::default() };
    let materials = white().into_iter().map(|m| (true, m)).chain(coloured().into_iter().map(|m| (false, m)));
    for (is_white, (name, surface, _)) in materials {
        for viewer in [[0.0, 0.1, 1.0], [0.7, -0.2, 0.6], [0.3, 0.2, -0.8]] {
            let wo = frame.to_world(DVec3::from_array(viewer).normalize());
            let hit = Hit { uv: [0.5, offset(frame.to_local(wo))], ..hit };
            let bsdf = surface.bind(&hit, wo, Lambdas::new(PATH));
            let summed = summed(&frame, |wi| {
                let evaluation = bsdf.eval(wi);
                evaluation.f[0] * evaluation.cosine
            });
            let mut stream = Stream::new(21, &[]);
            let count = 50_000;
            let (mut drawn, mut squares) = (0.0, 0.0);
            for _ in 0..count {
                let Some(sample) = bsdf.sample([stream.unit(), stream.unit(), stream.unit()]) else {
                    continue;
                };
                let e = sample.evaluation;
                let value = e.f[0] * e.cosine / e.pdf[0];
                drawn += value / f64::from(count);
                squares += value * value / f64::from(count);
            }
            let error = ((squares - drawn * drawn).max(0.0) / f64::from(count)).sqrt();
            let what = format!("{name} from {viewer:?}: {summed} and {drawn} ± {error}");
            assert!((summed - drawn).abs() < 4.5 * error + 5e-4 * summed + 1e-6, "{what}");
            // An instance fluctuates about the mean, and may give more from some directions.
            if name != "instance" {
                // Light that enters a denser medium is squeezed into fewer directions.
                let most = if name == "frosted" { 1.5 * 1.5 } else { 1.0 };
                assert!(summed < 1.005 * most, "{what}");
            }
            if is_white {
                assert!(summed > 0.99, "{what}");
            }
        }
    }
}

/// Where a fibre's frame sees the viewer, −1 … 1 across.
fn offset(wo: DVec3) -> f64 {
    wo.x / wo.x.hypot(wo.z)
}

/// Over all directions, in y and the azimuth about it: a barbule's lobe is narrow in y alone.
fn summed(frame: &Frame, value: impl Fn(DVec3) -> f64) -> f64 {
    const ROWS: usize = 250;
    const COLUMNS: usize = 500;
    let mut sum = 0.0;
    for row in 0..ROWS {
        let y = 2.0 * (row as f64 + 0.5) / ROWS as f64 - 1.0;
        let across = (1.0 - y * y).sqrt();
        for column in 0..COLUMNS {
            let azimuth = TAU * (column as f64 + 0.5) / COLUMNS as f64;
            sum += value(frame.to_world(DVec3::new(across * azimuth.cos(), y, across * azimuth.sin())));
        }
    }
    sum * 4.0 * PI / (ROWS * COLUMNS) as f64
}
