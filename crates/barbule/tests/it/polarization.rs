//! Polarization between bounces: the algebra and the paths behind the experiment of docs/theory/rendering.md.

use barbule::bsdf::{Keratin, Reflectance, Surface};
use barbule::math::rng::Stream;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::stage::Stage;
use barbule::scene::Object;
use barbule::scene::camera::{Camera, Projection};
use barbule::scene::emission::Emission;
use barbule::scene::geometry::{Geometry, Mesh};
use barbule::scene::light::{Lamp, Light, Sun, disc_radiance};
use barbule::spectrum::dense::WAVES;
use glam::DVec3;

use crate::measure::polarized::{
    Mueller, PolarizedScene, barbule as barbule_matrix, fresnel, scattered, turned,
};

const INDEX: f64 = 1.56;

/// A mirror at Brewster's angle is a polarizer: light that it reflects passes a second one turned by ψ about the ray between
/// them as by Malus' law, of unpolarized light R_s²/2 · cos²ψ.
#[test]
fn two_mirrors_at_brewsters_angle_obey_malus() {
    let mirror = fresnel(f64::cos(f64::atan(INDEX)), INDEX);
    assert!(mirror[2][2].abs() < 1e-15);
    let towards = DVec3::new(0.48, -0.6, 0.64);
    let first = towards.any_orthonormal_vector();
    for turn in 0..=12 {
        let psi = f64::from(turn) * std::f64::consts::PI / 12.0;
        let second = first * psi.cos() + towards.cross(first) * psi.sin();
        let row = turned(scattered([1.0, 0.0, 0.0], &mirror), towards, first, second);
        // Over the product of the unpolarized reflectances, each R_s/2.
        let [kept, ..] = scattered(row, &mirror);
        assert!((kept - 2.0 * psi.cos().powi(2)).abs() < 1e-14, "{psi}: {kept}");
    }
}

/// From axis to axis and back is the same row, and a row's lengths stay.
#[test]
fn turns_are_undone() {
    let mut stream = Stream::new(5, &[]);
    let towards = DVec3::new(0.0, 0.6, 0.8);
    let (e, f) = (DVec3::X, towards.cross(DVec3::X));
    for _ in 0..20 {
        let row = [1.0, stream.unit() - 0.5, stream.unit() - 0.5];
        let angle = 6.0 * stream.unit();
        let other = e * angle.cos() + f * angle.sin();
        let there = turned(row, towards, e, other);
        let back = turned(there, towards, other, e);
        assert!(row.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-14));
        assert!((there[1].hypot(there[2]) - row[1].hypot(row[2])).abs() < 1e-14);
    }
}

/// Chains of mirrors at any angles: rows from the camera against the electric fields themselves, vectors of the scene,
/// of both polarizations of the light from its source on. U and its sign matter from the third mirror on.
#[test]
fn chains_of_mirrors_pass_what_their_fields_pass() {
    let mut stream = Stream::new(8, &[]);
    let mut most_turned = 0_f64;
    for _ in 0..200 {
        // Where the light goes, from its source to the camera.
        let ways: [DVec3; 5] = std::array::from_fn(|_| {
            DVec3::new(stream.normal(), stream.normal(), stream.normal()).normalize()
        });
        let mirrors: Vec<(DVec3, f64)> = ways
            .windows(2)
            .map(|way| (way[0].cross(way[1]).normalize(), (0.5 * (1.0 - way[0].dot(way[1]))).sqrt()))
            .collect();
        // Backwards by rows, each over the unpolarized reflectance.
        let (mut row, mut axis) = ([1.0, 0.0, 0.0], ways[4].any_orthonormal_vector());
        for (k, (s, cosine)) in mirrors.iter().enumerate().rev() {
            row = scattered(turned(row, ways[k + 1], axis, *s), &fresnel(*cosine, INDEX));
            axis = *s;
        }
        // Forwards by fields.
        let first = ways[0].any_orthonormal_vector();
        let mut passed = 0.0;
        for mut field in [first, ways[0].cross(first)] {
            for (k, (s, cosine)) in mirrors.iter().enumerate() {
                let inside = (1.0 - (1.0 - cosine * cosine) / (INDEX * INDEX)).sqrt();
                let along = (cosine - INDEX * inside) / (cosine + INDEX * inside);
                let across = (INDEX * cosine - inside) / (INDEX * cosine + inside);
                let unpolarized = (0.5 * (along * along + across * across)).sqrt();
                let (before, after) = (ways[k].cross(*s), ways[k + 1].cross(*s));
                field = (*s * (along * field.dot(*s)) + after * (across * field.dot(before))) / unpolarized;
            }
            passed += 0.5 * field.length_squared();
        }
        assert!((row[0] - passed).abs() < 1e-12, "{} {passed}", row[0]);
        most_turned = most_turned.max((row[0] - 1.0).abs());
    }
    assert!(most_turned > 1.0);
}

/// A barbule's matrix has the two parts that it is made of, and makes no light: of fully polarized light neither
/// negative nor more polarized light comes.
#[test]
fn matrices_of_barbules_are_physical() {
    let mut stream = Stream::new(6, &[]);
    for _ in 0..500 {
        let (leaving, arriving) = (stream.unit(), stream.unit());
        for step in [1.0, 0.3, 0.0, -1.0] {
            let matrix: Mueller = barbule_matrix(leaving, arriving, step);
            let parts = [matrix[0][0], matrix[1][0], matrix[0][1]];
            let expected = [1.0, 2.0 * leaving - 1.0, 2.0 * arriving - 1.0];
            assert!(parts.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{matrix:?}");
            for k in 0..16 {
                let angle = f64::from(k) * std::f64::consts::TAU / 16.0;
                let light = [1.0, angle.cos(), angle.sin()];
                let [i, q, u] = matrix.map(|row| row.iter().zip(light).map(|(m, s)| m * s).sum::<f64>());
                assert!(i >= -1e-14 && q.hypot(u) <= i + 1e-12, "{leaving} {arriving} {step} {angle}");
            }
        }
    }
}

/// A square plate about a point.
fn plate(middle: DVec3, normal: DVec3, id: u64) -> Geometry {
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    let corner = |a: f64, b: f64| (middle + x * a + y * b).as_vec3();
    let positions = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mesh = Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], id, ..Mesh::default() };
    Geometry { meshes: vec![mesh], ..Geometry::default() }
}

/// Two nearly smooth plates at Brewster's angle, the second turned by ψ about the ray between them, and a lamp where a
/// mirror would show it: means of what the renderer sees, of paths that lose their polarization, and of paths that keep it.
fn between_plates(psi: f64) -> [f64; 3] {
    let brewster = f64::atan(INDEX);
    let seen = -DVec3::Z;
    let normal = DVec3::new(brewster.sin(), 0.0, brewster.cos());
    let between = seen - 2.0 * seen.dot(normal) * normal;
    // Across the ray, in the first plate's plane of incidence, and turned out of it.
    let across = seen.cross(between).normalize();
    let side = across.cross(between) * psi.cos() + across * psi.sin();
    let second = side * brewster.sin() - between * brewster.cos();
    let lamp = between - 2.0 * between.dot(second) * second;
    let keratin = || Keratin::new(0.02, INDEX, Reflectance::new(|_| 0.0).unwrap()).unwrap();
    let object = |geometry| Object { geometry, surface: Surface::Keratin(keratin()) };
    let objects = vec![object(plate(DVec3::ZERO, normal, 1)), object(plate(between * 5.0, second, 2))];
    let stage = Stage::new(objects).unwrap();
    let emission = Emission::daylight().scaled(disc_radiance(0.1, 1.0));
    let sun = Sun { direction: lamp, cos_radius: f64::cos(0.1), emission };
    let lighting = Lighting::new(vec![Lamp { light: Light::Sun(sun), weight: 1.0 }], None).unwrap();
    let camera = Camera {
        eye: DVec3::Z * 3.0,
        target: DVec3::ZERO,
        up: DVec3::Y,
        width_mm: 0.1,
        projection: Projection::Orthographic,
    };
    let scene = PolarizedScene {
        stage: &stage,
        lighting: &lighting,
        camera: &camera,
        barbules: None,
        boundaries: vec![(keratin(), INDEX), (keratin(), INDEX)],
        scatterings: 5,
    };
    let integrator = Integrator::new(&stage, &lighting, &camera, Transport::default());
    let mut sums = [0.0; 3];
    for sample in 0..4000 {
        let own = scene.sample([0, 0], [1, 1], sample, 1);
        let renderers = integrator.sample([0, 0], [1, 1], sample, 1).radiance;
        let mean = |values: [f64; WAVES]| values.iter().sum::<f64>() / WAVES as f64;
        for (sum, values) in sums.iter_mut().zip([renderers, own.depolarized, own.polarized[0]]) {
            *sum += mean(values);
        }
    }
    sums
}

/// The known answer through the whole path: twice the light that is seen if polarization is lost, and none. Roughness and the lamp's
/// width spread the angles by a few degrees: 1 %.
#[test]
fn paths_between_two_plates_find_twice_the_light_and_none() {
    for (turn_deg, expected) in [(0.0_f64, 2.0), (45.0, 1.0), (90.0, 0.0), (135.0, 1.0)] {
        let [renderer, depolarized, polarized] = between_plates(turn_deg.to_radians());
        assert!(depolarized > 0.0);
        assert!((renderer / depolarized - 1.0).abs() < 0.01, "{turn_deg}: {renderer} {depolarized}");
        let kept = polarized / depolarized;
        assert!((kept - expected).abs() < 0.02, "{turn_deg}: {kept}, expected {expected}");
    }
}
