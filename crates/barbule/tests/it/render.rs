//! The renderer against what must hold for any renderer: furnaces, known radiances, agreement of its techniques, and
//! the same bits however it is run.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use barbule::brdf::{FeatherBrdf, Options, example};
use barbule::math::rng::Stream;
use barbule::progress::{Progress, Unobserved};
use barbule::render::checkpoint;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Technique};
use barbule::render::run::{Ended, Goal, run};
use barbule::scene::camera::{Camera, Projection};
use barbule::scene::emission::Emission;
use barbule::scene::geometry::{CurveNode, Geometry, Mesh, Ribbon, RibbonNode};
use barbule::scene::keratin::{Keratin, Reflectance};
use barbule::scene::light::{Light, LightSample, Rectangle, Sphere, Sun, disc_radiance};
use barbule::scene::preset;
use barbule::scene::sky::Sky;
use barbule::scene::surface::{Barbule, Surface};
use barbule::scene::{Lamp, Scene};
use glam::{DVec2, DVec3, Vec3};

fn sky(radiance: f64) -> Lamp {
    let sky = Sky::grey(8, 4, Emission::daylight(), |_| radiance).unwrap();
    Lamp { light: Light::Sky(sky), weight: 1.0 }
}

fn square(half: f32) -> Geometry {
    let corner = |x: f32, y: f32| Vec3::new(x * half, y * half, 0.0);
    let positions = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let tangents = vec![Vec3::Y; 4];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let mesh = Mesh { positions, tangents, triangles, id: 1, ..Mesh::default() };
    Geometry { meshes: vec![mesh], ..Geometry::default() }
}

/// Looks down at the origin from an elevation over the x–y plane, rad.
fn camera(elevation: f64, width_mm: f64) -> Camera {
    let towards = DVec3::new(elevation.cos() * 0.6, elevation.cos() * 0.8, elevation.sin());
    Camera {
        eye: towards * 20.0,
        target: DVec3::ZERO,
        up: DVec3::Z,
        width_mm,
        projection: Projection::Orthographic,
    }
}

fn scene(geometry: Geometry, surface: Surface, lights: Vec<Lamp>, camera: Camera) -> Scene {
    let scene = Scene { geometry, surfaces: vec![surface], lights, camera, max_depth: 64 };
    scene.check().unwrap();
    scene
}

fn goal(samples: u32) -> Goal {
    Goal { samples, noise: None, time: None }
}

fn film(integrator: &Integrator<'_>, size: [u32; 2], samples: u32) -> Film {
    let mut film = Film::new(size).unwrap();
    run(integrator, &mut film, 1, goal(samples), &Unobserved, &mut |_| Ok(())).unwrap();
    film
}

/// Mean Y of a picture and its standard error.
fn luminance(film: &Film) -> (f64, f64) {
    let [width, height] = film.size();
    let pixels = f64::from(width * height);
    let (mut sum, mut variance) = (0.0, 0.0);
    for y in 0..height {
        for x in 0..width {
            sum += film.xyz(x, y)[1];
            variance += film.variance(x, y);
        }
    }
    (sum / pixels, variance.sqrt() / pixels)
}

fn white() -> Surface {
    Surface::Lambertian(Reflectance::new(|_| 1.0).unwrap())
}

/// Four deviations and what one wavelength set a pixel leaves of the colour's quadrature.
fn assert_luminance(film: &Film, expected: f64, what: &str) {
    let (mean, error) = luminance(film);
    assert!((mean - expected).abs() < 4.0 * error + 2e-3, "{what}: {mean} ± {error}, expected {expected}");
}

#[test]
fn white_shapes_vanish_in_a_white_furnace() {
    let mut fibres = Geometry::default();
    let mut ribbons = Geometry::default();
    for i in 0..12 {
        let x = (i as f32 - 5.5) * 0.3;
        let curve: Vec<CurveNode> = (0..6)
            .map(|k| CurveNode {
                point: Vec3::new(x + 0.1 * (k as f32).sin(), k as f32 - 2.5, 0.2 * (k as f32).cos()),
                radius: 0.12 - 0.01 * k as f32,
            })
            .collect();
        fibres.add_curve(&curve, 0, i);
        let ribbon: Vec<RibbonNode> = (0..6)
            .map(|k| RibbonNode {
                point: Vec3::new(x, k as f32 - 2.5, 0.3 * (0.8 * k as f32).cos()),
                across: Vec3::new(0.12, 0.0, 0.01 * (k as f32 - 2.5)),
                arc: k as f32,
            })
            .collect();
        ribbons.add_ribbon(&ribbon, Ribbon { id: i, cell: 0.3, ..Ribbon::default() });
    }
    for (name, geometry) in [("square", square(2.0)), ("fibres", fibres), ("ribbons", ribbons)] {
        let scene = scene(geometry, white(), vec![sky(1.0)], camera(1.0, 3.0));
        let film = film(&Integrator::new(&scene), [16, 16], 64);
        assert!((0..256).any(|i| film.pixel(i % 16, i / 16).hits > 0));
        assert_luminance(&film, 1.0, name);
    }
}

#[test]
fn feathers_in_the_furnace_have_their_own_albedo() {
    let brdf = Arc::new(FeatherBrdf::new(&example(12), Options::default()).unwrap());
    let under = Keratin::new(0.3, 1.56, Reflectance::melanin(20.0).unwrap()).unwrap();
    for elevation in [1.45, 0.9, 0.5] {
        let camera = camera(elevation, 1.0);
        let wi = camera.eye.normalize();
        // One bounce of a flat plate: Y = ∫ albedo · daylight · ȳ, which the renderer computes for a Lambertian
        // surface of that reflectance.
        let albedo = Reflectance::new(|w| brdf.albedo(w as f32, wi).min(1.0)).unwrap();
        let plain = scene(square(2.0), Surface::Lambertian(albedo), vec![sky(1.0)], camera);
        let (expected, _) = luminance(&film(&Integrator::new(&plain), [16, 16], 256));
        for instances in [false, true] {
            let surface = Surface::Barbule(Barbule {
                brdf: Arc::clone(&brdf),
                instances,
                under: under.clone(),
                passes: 0.0,
            });
            let mut geometry = Geometry::default();
            // Many small plates, so that instances average: each column is one barbule of short cells.
            for i in 0..40 {
                let node = |y: f32| RibbonNode {
                    point: Vec3::new((i as f32 - 19.5) * 0.05, y, 0.0),
                    across: Vec3::new(0.025, 0.0, 0.0),
                    arc: y + 2.0,
                };
                geometry
                    .add_ribbon(&[node(-2.0), node(2.0)], Ribbon { id: i, cell: 0.01, ..Ribbon::default() });
            }
            let feather = scene(geometry, surface, vec![sky(1.0)], camera);
            let film = film(&Integrator::new(&feather), [24, 24], 256);
            let (mean, error) = luminance(&film);
            // The albedo of an instance fluctuates; over some thousand cells 1 % is left.
            let tolerance = if instances { 0.015 } else { 0.004 } * expected;
            let apart = (mean - expected).abs();
            assert!(apart < 4.0 * error + tolerance, "{elevation} {instances}: {mean} ± {error}, {expected}");
        }
    }
}

#[test]
fn a_lamp_of_radiance_1_is_white() {
    let lamp = |light| vec![Lamp { light, weight: 1.0 }];
    let sphere = Sphere { centre: DVec3::ZERO, radius: 5.0, emission: Emission::daylight() };
    let rectangle = Rectangle {
        corner: DVec3::new(-9.0, -9.0, 0.0),
        edge_u: DVec3::new(18.0, 0.0, 0.0),
        edge_v: DVec3::new(0.0, 18.0, 0.0),
        emission: Emission::daylight(),
    };
    for light in [Light::Sphere(sphere), Light::Rectangle(rectangle)] {
        let scene = scene(Geometry::default(), white(), lamp(light), camera(1.2, 1.0));
        assert_luminance(&film(&Integrator::new(&scene), [8, 8], 64), 1.0, "lamp");
    }
}

#[test]
fn a_disc_at_infinity_lights_a_white_plane_by_its_irradiance() {
    let radius = 0.1;
    let sun = Sun {
        direction: DVec3::Z,
        cos_radius: f64::cos(radius),
        emission: Emission::daylight().scaled(disc_radiance(radius, 0.7)),
    };
    let lights = vec![Lamp { light: Light::Sun(sun), weight: 1.0 }];
    let scene = scene(square(2.0), white(), lights, camera(1.2, 1.0));
    assert_luminance(&film(&Integrator::new(&scene), [8, 8], 128), 0.7, "sun");
}

/// Mean luminance and its error with both techniques, with the BSDF's alone and with the lights' alone, which agree.
fn agreeing(scene: &Scene, name: &str) -> Vec<(f64, f64)> {
    let means: Vec<(f64, f64)> = [Technique::Both, Technique::BsdfOnly, Technique::LightsOnly]
        .into_iter()
        .map(|technique| luminance(&film(&Integrator::with_technique(scene, technique), [16, 16], 512)))
        .collect();
    for (mean, error) in &means[1..] {
        let allowed = 4.0 * error.hypot(means[0].1) + 1e-3 * means[0].0;
        assert!((mean - means[0].0).abs() < allowed, "{name}: {means:?}");
    }
    means
}

#[test]
fn techniques_agree_with_each_other() {
    let brdf = Arc::new(FeatherBrdf::new(&example(12), Options::default()).unwrap());
    let under = Keratin::new(0.3, 1.56, Reflectance::melanin(2.0).unwrap()).unwrap();
    let feather = Surface::Barbule(Barbule { brdf, instances: false, under: under.clone(), passes: 0.0 });
    let camera = camera(0.9, 1.0);
    let mirror = DVec3::new(-camera.eye.x, -camera.eye.y, camera.eye.z).normalize();
    let sun = Sun { direction: mirror, cos_radius: 0.97, emission: Emission::daylight().scaled(3.0) };
    let lights = vec![Lamp { light: Light::Sun(sun), weight: 0.7 }, sky(0.4)];
    for (name, surface) in [("feather", feather), ("keratin", Surface::Keratin(under)), ("white", white())] {
        let scene = scene(square(2.0), surface, lights.clone(), camera);
        let means = agreeing(&scene, name);
        assert!(means[0].1 <= means[1].1.max(means[2].1), "{name}: {means:?}");
    }
}

/// An image of uneven colours, half of its light from one of its pixels.
fn bright_pixel(width: usize, height: usize) -> Sky {
    let mut rgb: Vec<[f32; 3]> =
        (0..width * height).map(|i| [0.5 + 0.3 * (i % 3) as f32, 0.5, 0.2 + 0.1 * (i % 5) as f32]).collect();
    rgb[width * height / 4 + width / 3] = [0.3 * (width * height) as f32; 3];
    Sky::image(width, height, rgb, 0.8, 25.0).unwrap()
}

#[test]
fn techniques_agree_under_an_image_with_a_bright_pixel() {
    let under = Keratin::new(0.3, 1.56, Reflectance::melanin(2.0).unwrap()).unwrap();
    let lights = vec![Lamp { light: Light::Sky(bright_pixel(24, 12)), weight: 1.0 }];
    for surface in [white(), Surface::Keratin(under)] {
        let scene = scene(square(2.0), surface, lights.clone(), camera(0.9, 1.0));
        agreeing(&scene, "image");
    }
}

/// A white image is daylight, so it must do what the plain sky does.
#[test]
fn a_white_image_lights_as_the_plain_sky_does() {
    let image = Sky::image(8, 4, vec![[0.7; 3]; 32], 1.0, 0.0).unwrap();
    let lamps = [Lamp { light: Light::Sky(image), weight: 1.0 }, sky(0.7)];
    let films = lamps.map(|lamp| {
        let scene = scene(square(2.0), white(), vec![lamp], camera(0.9, 1.0));
        film(&Integrator::new(&scene), [8, 8], 64)
    });
    let [image, plain] = films.map(|film| luminance(&film).0);
    assert!((image / plain - 1.0).abs() < 1e-6, "{image} {plain}");
}

/// Counts of samples in bins against the integral of the stated density.
#[test]
fn lights_are_sampled_with_their_density() {
    let emission = Emission::daylight();
    let point = DVec3::new(0.3, -0.2, 0.1);
    let lights = [
        Light::Sun(Sun { direction: DVec3::new(0.0, 0.6, 0.8), cos_radius: 0.8, emission: emission.clone() }),
        Light::Sphere(Sphere { centre: DVec3::new(1.0, 1.0, 2.0), radius: 0.9, emission: emission.clone() }),
        Light::Rectangle(Rectangle {
            corner: DVec3::new(-1.0, -1.0, 2.0),
            edge_u: DVec3::new(0.0, 2.0, 0.3),
            edge_v: DVec3::new(1.5, 0.0, 0.0),
            emission: emission.clone(),
        }),
        Light::Sky(Sky::grey(16, 8, emission, |d| (1.3 + d.x).powi(2)).unwrap()),
        Light::Sky(bright_pixel(24, 12)),
    ];
    const SIDE: usize = 12;
    for (which, light) in lights.iter().enumerate() {
        let bin = |d: DVec3| {
            let u = (0.5 * (d.z + 1.0) * SIDE as f64).min(SIDE as f64 - 1.0) as usize;
            let v = (d.y.atan2(d.x) / std::f64::consts::TAU + 0.5) * SIDE as f64;
            u * SIDE + (v as usize).min(SIDE - 1)
        };
        let count = 60_000;
        let mut seen = vec![0.0; SIDE * SIDE];
        let mut stream = Stream::new(4, &[which as u64]);
        for _ in 0..count {
            let u = DVec2::new(stream.unit(), stream.unit());
            let LightSample { direction, pdf, .. } = light.sample(point, u, [550.0; 4]).unwrap();
            let stated = light.pdf(point, direction);
            assert!((stated / pdf - 1.0).abs() < 1e-6, "light {which}: {stated} {pdf}");
            seen[bin(direction)] += 1.0;
        }
        // Expected counts by a stratified sum over each bin.
        const FINE: usize = 60;
        let mut expected = vec![0.0; SIDE * SIDE];
        for i in 0..SIDE * FINE {
            for j in 0..SIDE * FINE {
                let z = 2.0 * (i as f64 + 0.5) / (SIDE * FINE) as f64 - 1.0;
                let a = std::f64::consts::TAU * ((j as f64 + 0.5) / (SIDE * FINE) as f64 - 0.5);
                let s = (1.0 - z * z).sqrt();
                let area = 4.0 * std::f64::consts::PI / (SIDE * FINE * SIDE * FINE) as f64;
                expected[(i / FINE) * SIDE + j / FINE] +=
                    f64::from(count) * area * light.pdf(point, DVec3::new(s * a.cos(), s * a.sin(), z));
            }
        }
        let total: f64 = expected.iter().sum::<f64>() / f64::from(count);
        assert!((total - 1.0).abs() < 5e-3, "light {which}: density integrates to {total}");
        let (mut chi2, mut degrees) = (0.0, 0.0);
        for (s, e) in seen.iter().zip(&expected) {
            if *e > 8.0 {
                // The edge of a light is not resolved by the sum: 1 % of a bin.
                chi2 += (s - e).powi(2) / (e + (0.01 * e).powi(2));
                degrees += 1.0;
            }
        }
        // Five deviations of the chi-square distribution.
        assert!(chi2 < degrees + 5.0 * f64::sqrt(2.0 * degrees), "light {which}: {chi2} of {degrees}");
    }
}

fn starling() -> Scene {
    let brdf = Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap());
    let mut preset = preset::named("starling").unwrap();
    preset.window.radius_mm = 0.7;
    preset.width_mm = 1.0;
    preset.scene(brdf, 7).unwrap().0
}

#[test]
fn the_picture_is_the_same_bits_for_any_number_of_threads() {
    let picture = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let scene = starling();
            film(&Integrator::new(&scene), [70, 40], 8)
        })
    };
    let one = picture(1);
    assert!(luminance(&one).0 > 0.0);
    assert_eq!(one, picture(2));
    assert_eq!(one, picture(5));
}

/// Stops after some steps of progress.
struct Impatient(AtomicU64);

impl Progress for Impatient {
    fn begin(&self, _label: &str, _total: u64) {}
    fn advance(&self, steps: u64) {
        self.0.fetch_sub(steps.min(self.0.load(Ordering::SeqCst)), Ordering::SeqCst);
    }
    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::SeqCst) == 0
    }
}

#[test]
fn an_interrupted_picture_goes_on_to_the_same_bits() {
    let scene = starling();
    let integrator = Integrator::new(&scene);
    let goal = Goal { samples: 36, noise: Some(0.08), time: None };
    let mut whole = Film::new([70, 40]).unwrap();
    run(&integrator, &mut whole, 3, goal, &Unobserved, &mut |_| Ok(())).unwrap();
    let name = checkpoint::name(&preset::named("starling").unwrap(), "", 1, "", "");
    let mut part = Film::new([70, 40]).unwrap();
    for patience in [30, 50, 20] {
        let ended =
            run(&integrator, &mut part, 3, goal, &Impatient(AtomicU64::new(patience)), &mut |_| Ok(()));
        assert_eq!(ended.unwrap(), Ended::Stopped);
        part = checkpoint::read(&checkpoint::write(&part, &name), &name, [70, 40]).unwrap();
    }
    assert_ne!(part, whole);
    assert_eq!(run(&integrator, &mut part, 3, goal, &Unobserved, &mut |_| Ok(())).unwrap(), Ended::Done);
    assert_eq!(part, whole);
}

#[test]
fn a_noise_target_leaves_easy_tiles_early() {
    // Left half white under a uniform sky, right half glinting barbules.
    let scene = starling();
    let integrator = Integrator::new(&scene);
    let mut film = Film::new([96, 64]).unwrap();
    let goal = Goal { samples: 64, noise: Some(0.25), time: None };
    run(&integrator, &mut film, 1, goal, &Unobserved, &mut |_| Ok(())).unwrap();
    let counts: Vec<u32> = (0..3).map(|i| film.count(32 * i, 0)).collect();
    assert!(counts.iter().all(|c| (16..=64).contains(c)), "{counts:?}");
    assert!(film.samples() < 96 * 64 * 64);
}

#[test]
fn light_that_passes_straight_through_is_counted_once() {
    let brdf = Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap());
    let under = Keratin::new(0.3, 1.56, Reflectance::melanin(20.0).unwrap()).unwrap();
    // Five sheets that each pass 90 % over a white floor that only a sun lights: seen and lit through all of them.
    let mut geometry = square(2.0);
    geometry.meshes[0].surface = 1;
    for sheet in 1..=5 {
        let mut upper = square(40.0).meshes.remove(0);
        for p in &mut upper.positions {
            p.z = sheet as f32;
        }
        geometry.meshes.push(upper);
    }
    let radius = 0.02;
    let emission = Emission::daylight().scaled(disc_radiance(radius, 1.0));
    let sun = Sun { direction: DVec3::Z, cos_radius: radius.cos(), emission };
    let sheets = Surface::Barbule(Barbule { brdf, instances: false, under, passes: 0.9 });
    let with = |passes: f64| {
        let mut sheet = sheets.clone();
        if let Surface::Barbule(barbule) = &mut sheet {
            barbule.passes = passes;
        }
        let scene = Scene {
            geometry: geometry.clone(),
            surfaces: vec![sheet, white()],
            lights: vec![Lamp { light: Light::Sun(sun.clone()), weight: 1.0 }],
            camera: camera(1.2, 0.5),
            max_depth: 1,
        };
        luminance(&film(&Integrator::new(&scene), [16, 16], 256))
    };
    assert!((with(1.0).0 - 1.0).abs() < 5e-3);
    let (mean, error) = with(0.9);
    // The sheets themselves scatter little towards this camera; the floor alone gives 0.9^10.
    assert!(mean > 0.9f64.powi(10) - 4.0 * error, "{mean} ± {error}");
}
