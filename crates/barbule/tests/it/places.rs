//! Feathers that stand in several places.

use std::sync::Arc;

use barbule::SceneDescription;
use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::bsdf::{Lambertian, Reflectance, Surface};
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::camera::Camera;
use barbule::scene::emission::Emission;
use barbule::scene::geometry::{Geometry, Mesh, Place};
use barbule::scene::light::{Lamp, Light, Sun, disc_radiance};
use barbule::scene::{Object, camera};
use glam::{DMat3, DVec3, Vec3};

/// Three millimetres of a starling's vane beside its shaft.
const PATCH: &str = "preset = 'starling'\n[window]\nradius_mm = 3.0\n[detail]\nlevel = ";
const SIDE: u32 = 32;
/// Feathers over which the draws of the few barbs that are seen are averaged.
const SEEDS: u64 = 6;

/// Where the second of the two stands.
fn second() -> Place {
    let axis = DVec3::new(0.4, -0.3, 0.8).normalize();
    Place { scale: 1.0, turn: DMat3::from_axis_angle(axis, 2.1), shift: DVec3::new(3.0, -5.0, 2.0), id: 12 }
}

/// Far from everything and too small to be seen: by the size of all stages, which it sets, shadows begin as far from surfaces in each.
fn speck() -> Object {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| 0.01 * corner - 200.0 * Vec3::Z).to_vec();
    let mesh = Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() };
    let geometry = Geometry { meshes: vec![mesh], ..Geometry::default() };
    Object { geometry, surface: Surface::Lambertian(Lambertian::new(Reflectance::new(|_| 0.0).unwrap())) }
}

/// Mean X, Y and Z of the patch that stands at a place, seen and lit from the same sides of it.
fn mean(mut objects: Vec<Object>, place: &Place) -> [f64; 3] {
    objects.push(speck());
    let stage = Stage::new(objects).unwrap();
    let towards = DVec3::new(0.3, -0.4, 0.8).normalize();
    let eye = DVec3::new(1.1, 0.8, 0.0) + 30.0 * towards;
    let view = Camera {
        eye: place.point(eye),
        target: place.point(DVec3::new(1.1, 0.8, 0.0)),
        up: place.direction(DVec3::Y),
        width_mm: 2.0,
        projection: camera::Projection::Orthographic,
    };
    let emission = Emission::daylight().scaled(disc_radiance(0.5, 1.0));
    let direction = place.direction(DVec3::new(-0.2, 0.4, 0.9).normalize());
    let sun = Light::Sun(Sun { direction, cos_radius: f64::cos(0.5), emission });
    let lighting = Lighting::new(vec![Lamp { light: sun, weight: 1.0 }], None).unwrap();
    let integrator = Integrator::new(&stage, &lighting, &view, Transport::default());
    let mut film = Film::new([SIDE; 2]).unwrap();
    run(&integrator, &mut film, 1, Goal::samples(32), &Unobserved, &mut |_| Ok(())).unwrap();
    let mut sum = [0.0; 3];
    for pixel in 0..SIDE * SIDE {
        let xyz = film.xyz(pixel % SIDE, pixel / SIDE);
        (0..3).for_each(|k| sum[k] += xyz[k] / f64::from(SIDE * SIDE));
    }
    sum
}

/// The second of two feathers looks as one that stands where it was made, from the side from which that is seen. Its barbules' draws are its
/// own.
#[test]
fn a_feather_looks_the_same_wherever_it_stands() {
    let brdf = Arc::new(FeatherBrdf::new(&example(3), Options::default()).unwrap());
    for level in ["barbules", "barbs", "vane", "envelopes"] {
        let scene =
            SceneDescription::parse(&format!("{PATCH}'{level}'")).unwrap().wearing(brdf.clone()).unwrap();
        let (mut expected, mut found) = ([0.0; 3], [0.0; 3]);
        for seed in 1..=SEEDS {
            let (objects, _) = scene.objects(seed).unwrap();
            let places = vec![Place { shift: DVec3::X * 8.0, id: 11, ..Place::HERE }, second()];
            let placed = objects.iter().map(|object| {
                let geometry = Geometry { places: places.clone(), ..object.geometry.clone() };
                Object { geometry, ..object.clone() }
            });
            let (there, here) = (mean(placed.collect(), &second()), mean(objects, &Place::HERE));
            (0..3).for_each(|k| (found[k], expected[k]) = (found[k] + there[k], expected[k] + here[k]));
        }
        let apart = [0, 1, 2].map(|k| found[k] / expected[k] - 1.0);
        println!("{level}: {apart:.4?} of {expected:.4?}");
        assert!(expected[1] > 0.01 && apart.iter().all(|d| d.abs() < 0.01), "{level}: {apart:.4?}");
    }
}
