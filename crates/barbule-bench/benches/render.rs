//! The renderer in figures: camera paths per CPU second on a preset, on 60,000 round barbules of keratin and on a plane
//! of a tabulated barbule BRDF.
//! `cargo bench --workspace --bench render [PRESET]`

#![allow(clippy::print_stdout)] // its output is its result

use std::sync::Arc;
use std::time::Instant;

use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::bsdf::{BarbuleSurface, Cells, Keratin, Reflectance, Surface};
use barbule::math::rng::Stream;
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::camera::{Camera, Projection};
use barbule::scene::description::SceneDescription;
use barbule::scene::emission::Emission;
use barbule::scene::geometry::{CurveNode, Geometry, Mesh};
use barbule::scene::light::{Lamp, Light, Sun, disc_radiance};
use barbule::scene::sky::{Environment, Sky};
use barbule::scene::{Object, Scene};
use cpu_time::ProcessTime;
use glam::{DVec3, Vec3};

const SIZE: [u32; 2] = [320, 200];

/// Millions of camera paths per CPU second on one thread.
fn measure(name: &str, samples: u32, most_scatterings: u32, scene: Scene) {
    let begun = Instant::now();
    let Scene { objects, lamps, environment, camera } = scene;
    let stage = Stage::new(objects).expect("sound shapes");
    let lighting = Lighting::new(lamps, environment.as_ref()).expect("lights");
    let transport = Transport { most_scatterings, ..Transport::default() };
    let integrator = Integrator::new(&stage, &lighting, &camera, transport);
    let built = begun.elapsed().as_secs_f64();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let mut film = Film::new(SIZE).expect("a film");
    let goal = Goal::samples(samples);
    let before = ProcessTime::now();
    pool.install(|| run(&integrator, &mut film, 1, goal, &Unobserved, &mut |_| Ok(()))).expect("a picture");
    let speed = 1e-6 * film.samples() as f64 / before.elapsed().as_secs_f64();
    println!(
        "{name}: {speed:.3} M paths/CPU s ({} primitives, hierarchy in {built:.2} s)",
        stage.primitives()
    );
}

/// One object under a plain sky and a sun.
fn scene(geometry: Geometry, surface: Surface) -> Scene {
    let daylight = Emission::daylight();
    let sky = Sky::grey(64, 32, daylight.clone(), |d| 0.35 + 0.65 * d.z.abs()).expect("a sky");
    let sun = Sun {
        direction: DVec3::new(0.3, 0.5, 0.8).normalize(),
        cos_radius: 0.1_f64.cos(),
        emission: daylight.scaled(disc_radiance(0.1, 2.0)),
    };
    Scene {
        objects: vec![Object { geometry, surface }],
        lamps: vec![Lamp { light: Light::Sun(sun), weight: 1.0 }],
        environment: Some(Environment { sky, weight: 1.0 }),
        camera: camera(),
    }
}

fn camera() -> Camera {
    let projection = Projection::Perspective { lens_radius: 0.0 };
    let (target, up) = (DVec3::ZERO, DVec3::Y);
    Camera { eye: DVec3::new(2.0, -4.0, 12.0), target, up, width_mm: 4.0, projection }
}

fn keratin() -> Keratin {
    Keratin::new(0.3, 1.56, Reflectance::melanin(1.0).expect("pigment")).expect("keratin")
}

/// 60 barbs with 500 barbules on each side, five segments each.
fn barbules() -> Scene {
    let mut geometry = Geometry::default();
    let mut stream = Stream::new(1, &[]);
    for barb in 0..60_u32 {
        for place in 0..500_u32 {
            for side in [-1.0_f64, 1.0] {
                let (x, y) = (f64::from(barb) * 0.1 - 3.0, f64::from(place) * 0.012 - 3.0);
                let (turn, lift) = (0.6 + 0.05 * stream.normal(), 0.15 * stream.unit());
                let nodes: Vec<CurveNode> = (0..6_u32)
                    .map(|k| {
                        let along = 0.04 * f64::from(k);
                        let point = DVec3::new(
                            x + side * along * turn.cos(),
                            y + along * turn.sin(),
                            lift * along * (1.0 - 4.0 * along),
                        );
                        CurveNode {
                            point: point.as_vec3(),
                            radius: (0.006 - 0.02 * along) as f32,
                            ..CurveNode::default()
                        }
                    })
                    .collect();
                geometry.add_curve(&nodes, u64::from(barb * 1000 + place));
            }
        }
    }
    scene(geometry, Surface::Keratin(keratin()))
}

/// A square that fills the picture.
fn plane(brdf: Arc<FeatherBrdf>) -> Scene {
    let corners = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)];
    let mesh = Mesh {
        positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let surface = Surface::Barbule(BarbuleSurface {
        brdf,
        instances: true,
        below: None,
        under: keratin(),
        cells: Cells::default(),
        opacity: 1.0,
    });
    scene(Geometry { meshes: vec![mesh], ..Geometry::default() }, surface)
}

fn main() {
    let wanted = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    // Without a preset's name the scene of the tests, which stays as it is.
    let description = match &wanted {
        Some(preset) => SceneDescription::named(preset).expect("a preset"),
        None => SceneDescription::parse(include_str!("../../barbule/tests/it/data/close-up.toml"))
            .expect("a scene"),
    };
    let brdf = Arc::new(FeatherBrdf::new(&example(50), Options::default()).expect("a material"));
    let (scene, _) = description.clone().wearing(brdf.clone()).expect("a scene").scene(1).expect("a scene");
    measure(&format!("close-up of {}", wanted.as_deref().unwrap_or("a starling")), 16, 5, scene);
    measure("60,000 round barbules of keratin", 16, 8, barbules());
    measure("plane of a tabulated barbule", 32, 8, plane(brdf));
}
