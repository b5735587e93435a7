//! The renderer against what must hold for any renderer: furnaces, known radiances, agreement of its techniques.

use std::sync::Arc;

use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::bsdf::{Absorption, BarbuleSurface, Cells, Keratin, Lambertian, Reflectance, Surface};
use barbule::math::rng::Stream;
use barbule::progress::Unobserved;
use barbule::render::faults::Faults;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Technique, Transport};
use barbule::render::light::{LightSample, Lighting};
use barbule::render::planes::{Bands, Planes};
use barbule::render::run::run;
use barbule::scene::camera::{Camera, Projection};
use barbule::scene::emission::Emission;
use barbule::scene::geometry::{Geometry, Ribbon, RibbonNode};
use barbule::scene::light::{Lamp, Light, Rectangle, Sphere, Sun, disc_radiance};
use barbule::scene::sky::{Environment, Sky};
use barbule::scene::{Object, Scene};
use barbule::spectrum::dense::Lambdas;
use barbule::spectrum::sensor::Band;
use glam::{DVec2, DVec3, Vec3};

use crate::small_scenes::{
    Ready, agreeing, assert_luminance, bright_pixel, camera, fibres, film, film_of, goal, hair, lamp,
    luminance, scene, sky, square, under_sky, white,
};

/// What a film tells of its noise is how far pictures of other samples scatter about their mean, with some to spare; independent samples would scatter
/// farther by half.
#[test]
fn noise_is_how_far_pictures_of_other_samples_scatter() {
    let brown = hair(0.3, Absorption::pigments(0.3, 0.1).unwrap());
    let ready = Ready::new(scene(fibres(), brown, under_sky(sky(1.0)), camera(1.0, 3.0)));
    let integrator = ready.integrator(4, Technique::Both);
    let films: Vec<Film> = (1..=8)
        .map(|seed| {
            let mut film = Film::new([32, 32]).unwrap();
            run(&integrator, &mut film, seed, goal(64), &Unobserved, &mut |_| Ok(())).unwrap();
            film
        })
        .collect();
    let (mut scatter, mut independent) = (0.0, 0.0);
    for (x, y) in (0..32).flat_map(|y| (0..32).map(move |x| (x, y))) {
        let seen: Vec<f64> = films.iter().map(|film| film.xyz(x, y)[1]).collect();
        let mean = seen.iter().sum::<f64>() / 8.0;
        let variance = seen.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / 7.0;
        // The root of a variance of seven degrees of freedom is too small by 27/28 in the mean.
        scatter += variance.sqrt() * 29.0 / 28.0 / (mean + 0.05) / 1024.0;
        independent += films[0].variance(x, y).sqrt() / (mean + 0.05) / 1024.0;
    }
    let told = films.iter().filter_map(Film::noise).sum::<f64>() / 8.0;
    println!("scatter {scatter:.4}, told {told:.4}, as of independent samples {independent:.4}");
    assert!(told > 0.95 * scatter && told < 1.3 * scatter, "{told} {scatter}");
    assert!(independent > 1.2 * scatter, "{independent} {scatter}");
}

#[test]
fn white_shapes_vanish_in_a_white_furnace() {
    let mut ribbons = Geometry::default();
    for i in 0..12 {
        let x = (i as f32 - 5.5) * 0.3;
        let ribbon: Vec<RibbonNode> = (0..6)
            .map(|k| RibbonNode {
                point: Vec3::new(x, k as f32 - 2.5, 0.3 * (0.8 * k as f32).cos()),
                across: Vec3::new(0.12, 0.0, 0.01 * (k as f32 - 2.5)),
                arc: k as f32,
            })
            .collect();
        ribbons.add_ribbon(&ribbon, Ribbon { id: i, cell: 0.3, ..Ribbon::default() });
    }
    for (name, geometry) in [("square", square(2.0)), ("fibres", fibres()), ("ribbons", ribbons)] {
        let scene = scene(geometry, white(), under_sky(sky(1.0)), camera(1.0, 3.0));
        let film = film_of(scene, [16, 16], 64);
        assert!((0..256).any(|i| film.pixel(i % 16, i / 16).hits > 0));
        assert_luminance(&film, 1.0, name);
    }
}

/// What a sheet does not reflect goes through it, and what comes from behind goes through too.
#[test]
fn a_translucent_sheet_vanishes_in_a_white_furnace() {
    for share in [0.0, 0.3, 1.0] {
        let part = |share: f64| Reflectance::new(|_| share).unwrap();
        let sheet = Lambertian::translucent(part(1.0 - share), part(share)).unwrap();
        let lights = under_sky(sky(1.0));
        let scene = scene(square(2.0), Surface::Lambertian(sheet), lights, camera(1.0, 3.0));
        assert_luminance(&film_of(scene, [16, 16], 64), 1.0, "sheet");
    }
}

/// A sun behind a sheet lights its other side by the transmitted share.
#[test]
fn light_from_behind_comes_through_a_translucent_sheet() {
    let sun = |direction: DVec3| {
        let emission = Emission::daylight().scaled(disc_radiance(0.1, 1.0));
        lamp(Light::Sun(Sun { direction, cos_radius: f64::cos(0.1), emission }))
    };
    let part = |share: f64| Reflectance::new(|_| share).unwrap();
    let sheet = Surface::Lambertian(Lambertian::translucent(part(0.2), part(0.7)).unwrap());
    for (direction, expected) in [(DVec3::Z, 0.2), (-DVec3::Z, 0.7)] {
        let scene = scene(square(2.0), sheet.clone(), sun(direction), camera(1.2, 1.0));
        assert_luminance(&film_of(scene.clone(), [8, 8], 128), expected, "sheet");
        agreeing(scene, 128, "sheet");
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
        let plain = Surface::Lambertian(Lambertian::new(albedo));
        let plain = scene(square(2.0), plain, under_sky(sky(1.0)), camera);
        let (expected, _) = luminance(&film_of(plain, [16, 16], 256));
        for instances in [false, true] {
            let surface = Surface::Barbule(BarbuleSurface {
                brdf: Arc::clone(&brdf),
                instances,
                below: None,
                under: under.clone(),
                cells: Cells::default(),
                opacity: 1.0,
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
            let film = film_of(scene(geometry, surface, under_sky(sky(1.0)), camera), [24, 24], 256);
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
    let sphere = Sphere { centre: DVec3::ZERO, radius: 5.0, emission: Emission::daylight() };
    let rectangle = Rectangle {
        corner: DVec3::new(-9.0, -9.0, 0.0),
        edge_u: DVec3::new(18.0, 0.0, 0.0),
        edge_v: DVec3::new(0.0, 18.0, 0.0),
        emission: Emission::daylight(),
    };
    for light in [Light::Sphere(sphere), Light::Rectangle(rectangle)] {
        let scene = scene(Geometry::default(), white(), lamp(light), camera(1.2, 1.0));
        assert_luminance(&film_of(scene, [8, 8], 64), 1.0, "lamp");
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
    let scene = scene(square(2.0), white(), lamp(Light::Sun(sun)), camera(1.2, 1.0));
    assert_luminance(&film_of(scene, [8, 8], 128), 0.7, "sun");
}

#[test]
fn techniques_agree_with_each_other() {
    let brdf = Arc::new(FeatherBrdf::new(&example(12), Options::default()).unwrap());
    let under = Keratin::new(0.3, 1.56, Reflectance::melanin(2.0).unwrap()).unwrap();
    let feather = Surface::Barbule(BarbuleSurface {
        brdf,
        instances: false,
        below: None,
        under: under.clone(),
        cells: Cells::default(),
        opacity: 1.0,
    });
    let camera = camera(0.9, 1.0);
    let mirror = DVec3::new(-camera.eye.x, -camera.eye.y, camera.eye.z).normalize();
    let sun = Sun { direction: mirror, cos_radius: 0.97, emission: Emission::daylight().scaled(3.0) };
    let lights = (vec![Lamp { light: Light::Sun(sun), weight: 0.7 }], Some(sky(0.4)));
    for (name, surface) in [("feather", feather), ("keratin", Surface::Keratin(under)), ("white", white())] {
        let scene = scene(square(2.0), surface, lights.clone(), camera);
        let means = agreeing(scene, 128, name);
        assert!(means[0].1 <= means[1].1.max(means[2].1), "{name}: {means:?}");
    }
}

/// More lights than a point samples: four of them are drawn, by weights that have nothing to do with what they bring.
#[test]
fn techniques_agree_under_many_lights() {
    let lamps: Vec<Lamp> = (0..6)
        .map(|k| {
            let azimuth = f64::from(k);
            let direction = DVec3::new(0.6 * azimuth.cos(), 0.6 * azimuth.sin(), 0.8);
            let emission = Emission::daylight().scaled(1.0 + 0.5 * azimuth);
            Lamp {
                light: Light::Sun(Sun { direction, cos_radius: 0.97, emission }),
                weight: 3.0 - 0.4 * azimuth,
            }
        })
        .collect();
    let under = Keratin::new(0.3, 1.56, Reflectance::melanin(2.0).unwrap()).unwrap();
    for (name, surface) in [("keratin", Surface::Keratin(under)), ("white", white())] {
        agreeing(scene(square(2.0), surface, (lamps.clone(), Some(sky(0.4))), camera(0.9, 1.0)), 128, name);
    }
}

/// A white image is daylight, so it must do what the plain sky does.
#[test]
fn a_white_image_lights_as_the_plain_sky_does() {
    let image = Sky::image(8, 4, vec![[0.7; 3]; 32], 1.0, 0.0).unwrap();
    let films = [Environment { sky: image, weight: 1.0 }, sky(0.7)].map(|sky| {
        let scene = scene(square(2.0), white(), under_sky(sky), camera(0.9, 1.0));
        film_of(scene, [8, 8], 64)
    });
    let [image, plain] = films.map(|film| luminance(&film).0);
    assert!((image / plain - 1.0).abs() < 1e-6, "{image} {plain}");
}

/// Behind the scene colour is known without following paths. A film that keeps spectra follows them everywhere: with the same rays
/// it finds the same shapes, the same alpha and, but for the wavelengths' noise, the same colours: of a sky, a sun and lamps.
#[test]
fn what_is_behind_the_scene_is_what_paths_find_there() {
    let emission = Emission::new(|nm| 2.0 - 0.002 * nm).unwrap();
    let towards = DVec3::new(0.0, 0.0, 1.0);
    let view = Projection::Perspective { lens_radius: 0.3 };
    let camera =
        Camera { eye: DVec3::Z * 10.0, target: DVec3::ZERO, up: DVec3::Y, width_mm: 9.0, projection: view };
    let sun = Sun {
        direction: DVec3::new(0.25, 0.25, -0.9).normalize(),
        cos_radius: 0.995,
        emission: emission.clone(),
    };
    let plate = Rectangle {
        corner: DVec3::new(-4.5, -4.0, -1.0),
        edge_u: DVec3::X * 2.0,
        edge_v: DVec3::Y * 2.0,
        emission: emission.scaled(2.0),
    };
    let ball = Sphere { centre: towards * -3.0 + DVec3::X * 4.0, radius: 0.6, emission };
    let lights = [Light::Sun(sun), Light::Rectangle(plate), Light::Sphere(ball)];
    let lamps: Vec<Lamp> = lights.into_iter().map(|light| Lamp { light, weight: 1.0 }).collect();
    let sky = Environment { sky: bright_pixel(24, 12), weight: 1.0 };
    let ready = Ready::new(scene(fibres(), white(), (lamps, Some(sky)), camera));
    for shows_sky in [true, false] {
        let transport = Transport { most_scatterings: 2, shows_sky, ..Transport::default() };
        let integrator = Integrator::new(&ready.stage, &ready.lighting, &ready.camera, transport);
        let size = [70, 50];
        let [known, followed] = [&[][..], &[550.0]].map(|nm| {
            let planes = Planes { spectral: Bands::new(nm, Band::HUMAN).unwrap(), ..Planes::default() };
            let mut film = Film::with(size, planes).unwrap();
            run(&integrator, &mut film, 1, goal(64), &Unobserved, &mut |_| Ok(())).unwrap();
            film
        });
        let (mut behind, mut apart) = (0, [0.0; 3]);
        for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
            assert_eq!(known.alpha(x, y), followed.alpha(x, y), "{x} {y}");
            assert_eq!(
                (known.pixel(x, y).hits, known.pixel(x, y).id),
                (followed.pixel(x, y).hits, followed.pixel(x, y).id)
            );
            if known.pixel(x, y).hits > 0 {
                continue;
            }
            behind += 1;
            let (known, followed) = (known.xyz(x, y), followed.xyz(x, y));
            for (sum, (a, b)) in apart.iter_mut().zip(known.iter().zip(followed)) {
                *sum += (a - b) / b.max(0.05);
            }
            // Of 64 samples with eight wavelengths each.
            let near = known.iter().zip(followed).all(|(a, b)| (a - b).abs() < 0.015 * b + 0.01);
            assert!(near, "{x} {y}: {known:?} {followed:?}");
        }
        assert!(behind > 1000, "{behind}");
        assert!(apart.iter().all(|sum| (sum / f64::from(behind)).abs() < 2e-4), "{apart:?} of {behind}");
    }
}

/// Counts of samples in bins against the integral of the stated density.
#[test]
fn lights_are_sampled_with_their_density() {
    let emission = Emission::daylight();
    let point = DVec3::new(0.3, -0.2, 0.1);
    let environment = |sky| under_sky(Environment { sky, weight: 1.0 });
    let lights = [
        lamp(Light::Sun(Sun {
            direction: DVec3::new(0.0, 0.6, 0.8),
            cos_radius: 0.8,
            emission: emission.clone(),
        })),
        lamp(Light::Sphere(Sphere {
            centre: DVec3::new(1.0, 1.0, 2.0),
            radius: 0.9,
            emission: emission.clone(),
        })),
        lamp(Light::Rectangle(Rectangle {
            corner: DVec3::new(-1.0, -1.0, 2.0),
            edge_u: DVec3::new(0.0, 2.0, 0.3),
            edge_v: DVec3::new(1.5, 0.0, 0.0),
            emission: emission.clone(),
        })),
        environment(Sky::grey(16, 8, emission, |d| (1.3 + d.x).powi(2)).unwrap()),
        environment(bright_pixel(24, 12)),
    ];
    const SIDE: usize = 12;
    for (which, (lamps, environment)) in lights.into_iter().enumerate() {
        let light = Lighting::new(lamps, environment.as_ref()).unwrap();
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
            let LightSample { direction, pdf, .. } =
                light.sample(0, point, u, Lambdas::splat(550.0)).unwrap();
            let stated = light.pdf(0, point, direction);
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
                    f64::from(count) * area * light.pdf(0, point, DVec3::new(s * a.cos(), s * a.sin(), z));
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

#[test]
fn light_that_passes_straight_through_is_counted_once() {
    let brdf = Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap());
    let under = Keratin::new(0.3, 1.56, Reflectance::melanin(20.0).unwrap()).unwrap();
    // Five sheets that each pass 90 % over a white floor that only a sun lights: seen and lit through all of them.
    let mut sheets = Geometry::default();
    for sheet in 1..=5 {
        let mut upper = square(40.0).meshes.remove(0);
        for p in &mut upper.positions {
            p.z = sheet as f32;
        }
        sheets.meshes.push(upper);
    }
    let radius = 0.02;
    let emission = Emission::daylight().scaled(disc_radiance(radius, 1.0));
    let sun = Sun { direction: DVec3::Z, cos_radius: radius.cos(), emission };
    let with = |opacity: f64, floor: Surface| {
        let surface = BarbuleSurface {
            brdf: brdf.clone(),
            instances: false,
            below: None,
            under: under.clone(),
            cells: Cells::default(),
            opacity,
        };
        let objects = vec![
            Object { geometry: square(2.0), surface: floor },
            Object { geometry: sheets.clone(), surface: Surface::Barbule(surface) },
        ];
        let (lamps, environment) = lamp(Light::Sun(sun.clone()));
        let ready = Ready::new(Scene { objects, lamps, environment, camera: camera(1.2, 0.5) });
        luminance(&film(&ready.integrator(1, Technique::Both), [16, 16], 1024))
    };
    assert!((with(0.0, white()).0 - 1.0).abs() < 5e-3);
    // What the sheets themselves scatter to the camera is seen over a black floor.
    let black = Surface::Lambertian(Lambertian::new(Reflectance::new(|_| 0.0).unwrap()));
    let (seen, error) = with(0.1, white());
    let (sheets_alone, black_error) = with(0.1, black);
    let (floor, expected) = (seen - sheets_alone, 0.9_f64.powi(10));
    let allowed = 4.0 * error.hypot(black_error) + 5e-3;
    assert!(allowed < 0.1 * expected, "{allowed}");
    assert!((floor - expected).abs() < allowed, "{floor} ± {allowed}, expected {expected}");
}

/// A light that cannot be: what it makes is counted with its place, and nothing of it gets into the picture.
#[test]
fn samples_that_no_light_can_make_are_counted_and_left_out() {
    let lit = |factor: f64| {
        let emission = Emission::daylight().scaled(factor);
        let whole = Sun { direction: DVec3::X, cos_radius: -1.0, emission };
        let surface = Surface::Lambertian(Lambertian::new(Reflectance::new(|_| 0.5).unwrap()));
        film_of(scene(square(4.0), surface, lamp(Light::Sun(whole)), camera(1.0, 1.0)), [24, 24], 4)
    };
    assert_eq!(lit(1.0).faults(), Faults::default());
    for factor in [-1.0, f64::NAN] {
        let film = lit(factor);
        let faults = film.faults();
        let first = faults.first.unwrap();
        assert!(faults.count > 50 && first.sample == 0, "{factor}: {faults:?}");
        let on_it = film.pixel(12, 12);
        assert!(on_it.luminance.is_finite() && on_it.luminance >= 0.0, "{factor}: {on_it:?}");
        let size = film.size();
        let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        assert!(all.clone().all(|(x, y)| film.xyz(x, y).iter().all(|value| value.is_finite())), "{factor}");
        assert_eq!(first.object, Some(0));
    }
}
