//! The renderer against Mitsuba 3: the same scenes, described twice, give the same mean colours.
//!
//! The reference values are data (`data/mitsuba.json`); `scripts/mitsuba-bench --agreement` makes them again.

use barbule::bsdf::{
    Absorption, Conductor, FacetRoughness, FibreIndex, Hair, HairParameters, Lambertian, Reflectance, Surface,
};
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::Object;
use barbule::scene::camera::{Camera, Projection};
use barbule::scene::emission::Emission;
use barbule::scene::geometry::{CurveNode, Geometry, Mesh};
use barbule::scene::light::{Lamp, Light, Rectangle};
use barbule::scene::sky::{Environment, Sky};
use barbule::spectrum::colour::rgb_from_xyz;
use glam::{DVec3, Vec3};

/// Of each channel of each quarter of a picture, noise included.
const AGREEMENT: f64 = 0.01;

const SIDE: u32 = 64;
const SAMPLES: u32 = 256;

/// Wavelength in nm and value, linear between: walls' reflectances, and what one radius of a fibre absorbs.
const RED: &[(f64, f64)] = &[(360.0, 0.05), (560.0, 0.1), (620.0, 0.6), (830.0, 0.65)];
const GREEN: &[(f64, f64)] = &[(360.0, 0.1), (480.0, 0.15), (530.0, 0.5), (590.0, 0.15), (830.0, 0.1)];
const WHITE: &[(f64, f64)] = &[(360.0, 0.7), (830.0, 0.7)];
const PIGMENT: &[(f64, f64)] = &[(360.0, 1.2), (550.0, 0.35), (830.0, 0.1)];

fn between(table: &[(f64, f64)], nm: f64) -> f64 {
    let pair = table.windows(2).find(|pair| nm <= pair[1].0).unwrap();
    let ((from, a), (to, b)) = (pair[0], pair[1]);
    a + (b - a) * (nm - from) / (to - from)
}

/// A square about `middle`, `half` wide to each side, that looks at `to`; its first tangent is `along`.
fn square(middle: Vec3, to: Vec3, half: f32, along: Vec3) -> Geometry {
    let normal = (to - middle).normalize();
    let (x, y) = (along * half, normal.cross(along) * half);
    let mesh = Mesh {
        positions: vec![middle - x - y, middle + x - y, middle + x + y, middle - x + y],
        tangents: vec![along; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        id: 1,
        ..Mesh::default()
    };
    Geometry { meshes: vec![mesh], ..Geometry::default() }
}

/// A lamp of 3 × 3 around `at` that shines towards `to`.
fn lamp(at: DVec3, to: DVec3, up: DVec3) -> Lamp {
    let ahead = (to - at).normalize();
    let left = up.cross(ahead).normalize();
    let up = ahead.cross(left);
    let rectangle = Rectangle {
        corner: at - 1.5 * (left + up),
        edge_u: 3.0 * left,
        edge_v: 3.0 * up,
        emission: Emission::daylight().scaled(10.0),
    };
    Lamp { light: Light::Rectangle(rectangle), weight: 1.0 }
}

/// Means over the quarters of the picture, in the order of the reference.
fn quarters(objects: Vec<Object>, lamp: Lamp, eye: DVec3) -> [[f64; 3]; 4] {
    let sky = Sky::grey(8, 4, Emission::daylight(), |_| 0.3).unwrap();
    let lighting = Lighting::new(vec![lamp], Some(&Environment { sky, weight: 1.0 })).unwrap();
    let camera = Camera {
        eye,
        target: DVec3::ZERO,
        up: DVec3::Y,
        width_mm: 2.0 * eye.length() * 16_f64.to_radians().tan(),
        projection: Projection::Perspective { lens_radius: 0.0 },
    };
    let stage = Stage::new(objects).unwrap();
    let transport = Transport { most_scatterings: 7, ..Transport::default() };
    let integrator = Integrator::new(&stage, &lighting, &camera, transport);
    let mut film = Film::new([SIDE; 2]).unwrap();
    let goal = Goal::samples(SAMPLES);
    run(&integrator, &mut film, 1, goal, &Unobserved, &mut |_| Ok(())).unwrap();
    let half = SIDE / 2;
    [[0, 0], [half, 0], [0, half], [half, half]].map(|[left, top]| {
        let mut sum = [0.0; 3];
        for (x, y) in (top..top + half).flat_map(|y| (left..left + half).map(move |x| (x, y))) {
            for (sum, value) in sum.iter_mut().zip(film.xyz(x, y)) {
                *sum += value;
            }
        }
        rgb_from_xyz(sum.map(|value| value / f64::from(half * half)))
    })
}

fn compare(name: &str, found: [[f64; 3]; 4]) {
    let data: serde_json::Value = serde_json::from_str(include_str!("data/mitsuba.json")).unwrap();
    let expected: [[f64; 3]; 4] = serde_json::from_value(data[name].clone()).unwrap();
    for (quarter, (found, expected)) in found.iter().zip(expected).enumerate() {
        println!("{name} {quarter}: {found:.4?}, Mitsuba {expected:.4?}");
    }
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found / expected - 1.0).abs() < AGREEMENT, "{name}: {found} {expected}");
    }
}

/// Of the scenes that are no box.
const LAMP_AT: DVec3 = DVec3::new(6.0, 8.0, 12.0);

#[test]
fn a_diffuse_box_has_the_colours_of_mitsuba() {
    let middle = Vec3::new(0.0, 0.0, -5.0);
    let wall = |at: [f32; 3], along: Vec3, table: &[(f64, f64)]| Object {
        geometry: square(Vec3::from_array(at), middle, 5.0, along),
        surface: Surface::Lambertian(Lambertian::new(Reflectance::new(|nm| between(table, nm)).unwrap())),
    };
    let walls = vec![
        wall([-5.0, 0.0, -5.0], Vec3::Y, RED),
        wall([5.0, 0.0, -5.0], Vec3::Y, GREEN),
        wall([0.0, -5.0, -5.0], Vec3::X, WHITE),
        wall([0.0, 5.0, -5.0], Vec3::X, WHITE),
        wall([0.0, 0.0, -10.0], Vec3::X, WHITE),
    ];
    let lamp = lamp(DVec3::new(0.0, 4.9, -5.0), middle.as_dvec3(), DVec3::Z);
    compare("box", quarters(walls, lamp, DVec3::new(0.0, 0.0, 20.0)));
}

/// Anisotropic, seen aslant; Mitsuba masks facets on the way in and on the way out independently.
#[test]
fn brushed_copper_has_the_colours_of_mitsuba() {
    let geometry = square(Vec3::ZERO, Vec3::Z, 4.0, Vec3::X);
    let surface = Surface::Conductor(Conductor::copper(FacetRoughness { across: 0.3, along: 0.1 }).unwrap());
    let lamp = lamp(LAMP_AT, DVec3::ZERO, DVec3::Y);
    compare("copper", quarters(vec![Object { geometry, surface }], lamp, DVec3::new(0.0, -12.0, 16.0)));
}

#[test]
fn fibres_of_hair_have_the_colours_of_mitsuba() {
    let mut geometry = Geometry::default();
    for k in -4_i16..=4 {
        let node = |y: f32| CurveNode {
            point: Vec3::new(f32::from(k), y, 0.0),
            radius: 0.4,
            ..CurveNode::default()
        };
        geometry.add_curve(&[node(-8.0), node(8.0)], u64::from(k.unsigned_abs()));
    }
    let parameters = HairParameters {
        longitudinal_roughness: 0.25,
        azimuthal_roughness: 0.3,
        scale_tilt: 2_f64.to_radians(),
        index: FibreIndex::Constant(1.55),
        absorption: Absorption::new(|nm| between(PIGMENT, nm)).unwrap(),
        height_over_width: 1.0,
    };
    let surface = Surface::Hair(Hair::new(parameters).unwrap());
    let lamp = lamp(LAMP_AT, DVec3::ZERO, DVec3::Y);
    compare("fibres", quarters(vec![Object { geometry, surface }], lamp, DVec3::new(0.0, 0.0, 20.0)));
}
