//! Small scenes of one surface, what they are lit by, and their films: shared by the tests of the renderer.

use barbule::bsdf::{Absorption, FibreIndex, Hair, HairParameters, Lambertian, Reflectance, Surface};
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Technique, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::camera::{Camera, Projection};
use barbule::scene::emission::Emission;
use barbule::scene::geometry::{CurveNode, Geometry, Mesh};
use barbule::scene::light::{Lamp, Light};
use barbule::scene::sky::{Environment, Sky};
use barbule::scene::{Object, Scene};
use glam::{DVec3, Vec3};

/// The lights of a scene.
pub(crate) type Lights = (Vec<Lamp>, Option<Environment>);

pub(crate) fn sky(radiance: f64) -> Environment {
    let sky = Sky::grey(8, 4, Emission::daylight(), |_| radiance).unwrap();
    Environment { sky, weight: 1.0 }
}

pub(crate) fn under_sky(sky: Environment) -> Lights {
    (Vec::new(), Some(sky))
}

pub(crate) fn lamp(light: Light) -> Lights {
    (vec![Lamp { light, weight: 1.0 }], None)
}

pub(crate) fn square(half: f32) -> Geometry {
    let corner = |x: f32, y: f32| Vec3::new(x * half, y * half, 0.0);
    let positions = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let tangents = vec![Vec3::Y; 4];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let mesh = Mesh { positions, tangents, triangles, id: 1, ..Mesh::default() };
    Geometry { meshes: vec![mesh], ..Geometry::default() }
}

/// Looks down at the origin from an elevation over the x–y plane, rad.
pub(crate) fn camera(elevation: f64, width_mm: f64) -> Camera {
    let towards = DVec3::new(elevation.cos() * 0.6, elevation.cos() * 0.8, elevation.sin());
    Camera {
        eye: towards * 20.0,
        target: DVec3::ZERO,
        up: DVec3::Z,
        width_mm,
        projection: Projection::Orthographic,
    }
}

pub(crate) fn scene(
    geometry: Geometry,
    surface: Surface,
    (lamps, environment): Lights,
    camera: Camera,
) -> Scene {
    Scene { objects: vec![Object { geometry, surface }], lamps, environment, camera }
}

/// A scene ready for rays.
pub(crate) struct Ready {
    pub(crate) stage: Stage,
    pub(crate) lighting: Lighting,
    pub(crate) camera: Camera,
}

impl Ready {
    pub(crate) fn new(scene: Scene) -> Self {
        Self {
            stage: Stage::new(scene.objects).unwrap(),
            lighting: Lighting::new(scene.lamps, scene.environment.as_ref()).unwrap(),
            camera: scene.camera,
        }
    }

    pub(crate) fn integrator(&self, most_scatterings: u32, technique: Technique) -> Integrator<'_> {
        let transport = Transport { most_scatterings, technique, ..Transport::default() };
        Integrator::new(&self.stage, &self.lighting, &self.camera, transport)
    }
}

/// A scene's film with paths of up to 64 scatterings.
pub(crate) fn film_of(scene: Scene, size: [u32; 2], samples: u32) -> Film {
    film(&Ready::new(scene).integrator(64, Technique::Both), size, samples)
}

pub(crate) fn goal(samples: u32) -> Goal {
    Goal::samples(samples)
}

pub(crate) fn film(integrator: &Integrator<'_>, size: [u32; 2], samples: u32) -> Film {
    let mut film = Film::new(size).unwrap();
    run(integrator, &mut film, 1, goal(samples), &Unobserved, &mut |_| Ok(())).unwrap();
    film
}

/// Mean Y of a picture and its standard error.
pub(crate) fn luminance(film: &Film) -> (f64, f64) {
    let [width, height] = film.size();
    let pixels = f64::from(width * height);
    let (mut sum, mut variance) = (0.0, 0.0);
    for y in 0..height {
        for x in 0..width {
            sum += film.xyz(x, y)[1];
            // Neighbours share samples: what counts for the mean is what each pixel drew.
            variance += film.pixel(x, y).variance(film.count(x, y));
        }
    }
    (sum / pixels, variance.sqrt() / pixels)
}

pub(crate) fn white() -> Surface {
    Surface::Lambertian(Lambertian::new(Reflectance::new(|_| 1.0).unwrap()))
}

/// Four deviations and what one wavelength set a pixel leaves of the colour's quadrature.
pub(crate) fn assert_luminance(film: &Film, expected: f64, what: &str) {
    let (mean, error) = luminance(film);
    assert!((mean - expected).abs() < 4.0 * error + 2e-3, "{what}: {mean} ± {error}, expected {expected}");
}

/// Twelve bent, tapering fibres side by side.
pub(crate) fn fibres() -> Geometry {
    let mut fibres = Geometry::default();
    for i in 0..12 {
        let x = (i as f32 - 5.5) * 0.3;
        let curve: Vec<CurveNode> = (0..6)
            .map(|k| CurveNode {
                point: Vec3::new(x + 0.1 * (k as f32).sin(), k as f32 - 2.5, 0.2 * (k as f32).cos()),
                radius: 0.12 - 0.01 * k as f32,
                ..CurveNode::default()
            })
            .collect();
        fibres.add_curve(&curve, i);
    }
    fibres
}

/// What techniques may differ by beside their noise, of the mean: what one wavelength set a pixel leaves of the colour's quadrature.
pub(crate) const SLACK: f64 = 1e-3;

/// Mean luminance and its error with both techniques, with the BSDF's alone and with the lights' alone, which agree.
pub(crate) fn agreeing(scene: Scene, samples: u32, name: &str) -> [(f64, f64); 3] {
    let ready = Ready::new(scene);
    let means = [Technique::Both, Technique::BsdfOnly, Technique::LightsOnly]
        .map(|technique| luminance(&film(&ready.integrator(64, technique), [16, 16], samples)));
    for (mean, error) in &means[1..] {
        let allowed = 4.0 * error.hypot(means[0].1) + SLACK * means[0].0;
        assert!((mean - means[0].0).abs() < allowed, "{name}: {means:?}");
    }
    means
}

/// An image of uneven colours, half of its light from one of its pixels.
pub(crate) fn bright_pixel(width: usize, height: usize) -> Sky {
    let mut rgb: Vec<[f32; 3]> =
        (0..width * height).map(|i| [0.5 + 0.3 * (i % 3) as f32, 0.5, 0.2 + 0.1 * (i % 5) as f32]).collect();
    rgb[width * height / 4 + width / 3] = [0.3 * (width * height) as f32; 3];
    Sky::image(width, height, rgb, 0.8, 25.0).unwrap()
}

/// Hair with tilted scales.
pub(crate) fn hair(roughness: f64, absorption: Absorption) -> Surface {
    let parameters = HairParameters {
        longitudinal_roughness: roughness,
        azimuthal_roughness: roughness,
        scale_tilt: 0.035,
        index: FibreIndex::Constant(1.55),
        absorption,
        height_over_width: 1.0,
    };
    Surface::Hair(Hair::new(parameters).unwrap())
}
