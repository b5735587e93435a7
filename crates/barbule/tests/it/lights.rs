//! Lamps against closed forms: what they give to a white plane, seen from above.

use barbule::bsdf::{Lambertian, Reflectance, Surface};
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::Object;
use barbule::scene::camera::{Camera, Projection};
use barbule::scene::emission::Emission;
use barbule::scene::geometry::{Geometry, Mesh};
use barbule::scene::light::{Lamp, Light, Point, Rectangle, Sphere, Spot};
use glam::{DVec3, Vec3};

/// A square of half side `side` at height `z`.
fn square(side: f32, z: f32) -> Object {
    let corner = |x: f32, y: f32| Vec3::new(x * side, y * side, z);
    let mesh = Mesh {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let geometry = Geometry { meshes: vec![mesh], ..Geometry::default() };
    let surface = Surface::Lambertian(Lambertian::new(Reflectance::new(|_| 1.0).unwrap()));
    Object { geometry, surface }
}

/// π times the luminance of a white plane at z = 0 about a place, from right above: its irradiance in daylight; with its error.
fn irradiance(objects: Vec<Object>, lights: &[Light], x: f64, samples: u32) -> (f64, f64) {
    let stage = Stage::new(objects).unwrap();
    let lamps = lights.iter().map(|light| Lamp { light: light.clone(), weight: 1.0 }).collect();
    let lighting = Lighting::new(lamps, None).unwrap();
    let camera = Camera {
        eye: DVec3::new(x, 0.0, 1.0),
        target: DVec3::new(x, 0.0, 0.0),
        up: DVec3::Y,
        width_mm: 0.01,
        projection: Projection::Orthographic,
    };
    // Light that comes by way of other things is left out.
    let transport = Transport { most_scatterings: 1, ..Transport::default() };
    let integrator = Integrator::new(&stage, &lighting, &camera, transport);
    let size = [8, 8];
    let mut film = Film::new(size).unwrap();
    run(&integrator, &mut film, 1, Goal::samples(samples), &Unobserved, &mut |_| Ok(())).unwrap();
    let places = || (0..64).map(|i| (i % 8, i / 8));
    let mean = places().map(|(x, y)| film.xyz(x, y)[1]).sum::<f64>() / 64.0;
    let variance: f64 = places().map(|(x, y)| film.pixel(x, y).variance(film.count(x, y))).sum();
    (std::f64::consts::PI * mean, std::f64::consts::PI * variance.sqrt() / 64.0)
}

/// Four deviations, and 2e-3 of the colour's quadrature.
fn assert_irradiance((found, error): (f64, f64), expected: f64, what: &str) {
    assert!(
        (found - expected).abs() < 4.0 * error + 2e-3 * expected.max(1e-3),
        "{what}: {found} ± {error}, expected {expected}"
    );
}

fn daylight(factor: f64) -> Emission {
    Emission::daylight().scaled(factor)
}

/// A point at height h gives I cosθ/d² = (I/h²) cos³θ at the angle θ from below it.
#[test]
fn points_follow_the_inverse_square_and_the_cosine() {
    let height = 3.0;
    let point = Light::Point(Point { position: DVec3::new(0.0, 0.0, height), emission: daylight(20.0) });
    for x in [0.0, 1.0, 4.0] {
        let cosine = height / f64::hypot(height, x);
        let expected = 20.0 / (height * height) * cosine.powi(3);
        let found = irradiance(vec![square(9.0, 0.0)], std::slice::from_ref(&point), x, 64);
        assert_irradiance(found, expected, &format!("point at {x}"));
    }
    // What stands between casts a shadow.
    let (found, _) = irradiance(vec![square(9.0, 0.0), square(0.5, 2.0)], &[point], 0.0, 16);
    assert!(found < 1e-9);
}

/// Inside its cone a spot is a point, beyond it is dark, and at half of the fading edge (of the cosine) it has half.
#[test]
fn spots_shine_into_their_cone() {
    let (cos_outer, cos_inner) = (0.8, 0.9);
    let spot = Spot {
        position: DVec3::new(0.0, 0.0, 3.0),
        axis: DVec3::NEG_Z,
        cos_outer,
        cos_inner,
        emission: daylight(20.0),
    };
    for (cosine, share) in [(1.0, 1.0), (0.91, 1.0), (0.85, 0.5), (0.79, 0.0)] {
        let x = 3.0 * f64::sqrt(1.0 / (cosine * cosine) - 1.0);
        let expected = share * 20.0 / 9.0 * f64::powi(cosine, 3);
        let found = irradiance(vec![square(9.0, 0.0)], &[Light::Spot(spot.clone())], x, 64);
        // Across the 0.01 mm that are seen the edge fades by 0.2 %.
        assert!((found.0 - expected).abs() < 4.0 * found.1 + 5e-3 * expected + 1e-6, "{cosine}: {found:?}");
    }
}

/// A sphere gives π L sin²α cosθ wherever it stands wholly above the horizon.
#[test]
fn spheres_give_the_square_of_their_sine() {
    let sphere = Sphere { centre: DVec3::new(0.0, 0.0, 3.0), radius: 1.5, emission: daylight(2.0) };
    for x in [0.0, 2.0, 5.0] {
        let distance = f64::hypot(3.0, x);
        let sine = 1.5 / distance;
        let expected = std::f64::consts::PI * 2.0 * sine * sine * 3.0 / distance;
        let light = Light::Sphere(sphere.clone());
        assert_irradiance(irradiance(vec![square(9.0, 0.0)], &[light], x, 256), expected, "sphere");
    }
}

/// Of many lamps some are drawn at each point; their sum is that of all of them.
#[test]
fn many_lamps_of_all_kinds_add_up() {
    // None stands in the light of another.
    let at = |x: f64, z: f64| DVec3::new(x, 0.5 * x, z);
    let aside = DVec3::new(0.0, -3.0, 4.0);
    let rectangle = Rectangle {
        corner: DVec3::new(-1.0, -1.0, 4.0),
        edge_u: DVec3::new(0.0, 2.0, 0.0),
        edge_v: DVec3::new(2.0, 0.0, 0.0),
        emission: daylight(1.0),
    };
    let spot = Spot {
        position: aside,
        axis: -aside.normalize(),
        cos_outer: 0.8,
        cos_inner: 0.9,
        emission: daylight(9.0),
    };
    let lights = [
        Light::Point(Point { position: at(1.0, 3.0), emission: daylight(5.0) }),
        Light::Point(Point { position: DVec3::new(-3.0, 3.0, 4.0), emission: daylight(8.0) }),
        Light::Sphere(Sphere { centre: at(2.0, 2.5), radius: 0.4, emission: daylight(3.0) }),
        Light::Sphere(Sphere { centre: at(-2.0, 3.0), radius: 0.5, emission: daylight(3.0) }),
        Light::Rectangle(rectangle.clone()),
        Light::Spot(spot),
    ];
    let plane = || vec![square(9.0, 0.0)];
    let alone: Vec<(f64, f64)> =
        lights.iter().map(|light| irradiance(plane(), std::slice::from_ref(light), 0.0, 256)).collect();
    assert_irradiance(alone[4], rectangle.irradiance_at_origin(), "rectangle");
    let (sum, error) = irradiance(plane(), &lights, 0.0, 1024);
    let expected: f64 = alone.iter().map(|(mean, _)| mean).sum();
    let known = alone.iter().map(|(_, error)| error * error).sum::<f64>().sqrt();
    assert!(
        (sum - expected).abs() < 4.0 * error.hypot(known) + 2e-3 * expected,
        "{sum} ± {error}, {expected}"
    );
}
