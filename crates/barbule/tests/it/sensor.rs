//! Sensors other than the human eye: their pictures against the eye's of the same paths, and against radiances known by hand.

use std::sync::Arc;

use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::bsdf::{Lambertian, Reflectance, Surface};
use barbule::progress::Unobserved;
use barbule::render::checkpoint;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::picture::{Development, planes};
use barbule::render::planes::{Bands, Planes};
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::Scene;
use barbule::scene::emission::Emission;
use barbule::scene::light::{Lamp, Light, Sun};
use barbule::scene::sky::{Environment, Sky};
use barbule::spectrum::dense::DenseSpectrum;
use barbule::spectrum::sensor::{Band, Curve, Sensor};
use glam::DVec3;

use crate::measure::picture::close_up;
use crate::small_scenes::{camera, scene, square};

fn curve(name: &str, value: impl Fn(f64) -> f64) -> Curve {
    Curve { name: name.to_owned(), response: DenseSpectrum::new(value) }
}

/// X, Y in two parts that meet at 560 nm, and Z.
fn four_channels() -> Sensor {
    let human = Sensor::human();
    let [x, y, z] = [0, 1, 2].map(|k| &human.channels()[k].response);
    let channels = vec![
        curve("X", |nm| x.at(nm)),
        curve("Y1", |nm| if nm < 560.0 { y.at(nm) } else { 0.0 }),
        curve("Y2", |nm| if nm < 560.0 { 0.0 } else { y.at(nm) }),
        curve("Z", |nm| z.at(nm)),
    ];
    let sensor = Sensor::new("four", Band::HUMAN, channels).unwrap();
    let unit = |rows: [[f64; 4]; 3]| rows.map(|row| row.to_vec());
    sensor.with_xyz(&unit([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])).unwrap()
}

/// One flat channel in the ultraviolet.
fn ultraviolet() -> Sensor {
    Sensor::new("uv", Band::new(300, 400).unwrap(), vec![curve("UV", |_| 1.0)]).unwrap()
}

fn film(scene: Scene, size: [u32; 2], samples: u32, planes: &[Planes]) -> Vec<Film> {
    let Scene { objects, lamps, environment, camera } = scene;
    let stage = Stage::new(objects).unwrap();
    let lighting = Lighting::new(lamps, environment.as_ref()).unwrap();
    let integrator = Integrator::new(&stage, &lighting, &camera, Transport::default());
    let films = planes.iter().map(|planes| {
        let mut film = Film::with(size, planes.clone()).unwrap();
        run(&integrator, &mut film, 1, Goal::samples(samples), &Unobserved, &mut |_| Ok(())).unwrap();
        film
    });
    films.collect()
}

fn of(sensor: Sensor) -> Planes {
    let spectral = Bands::new(&[450.0, 550.0, 650.0], sensor.band()).unwrap();
    Planes { sensor, compositing: true, spectral }
}

/// The same paths: sums of channels are the eye's to rounding. Paths of its own wavelengths: within the noise.
#[test]
fn a_sensor_whose_channels_sum_to_the_eyes_sees_the_eyes_picture() {
    let brdf = Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap());
    let scene = close_up().wearing(brdf).unwrap().scene(7).unwrap().0;
    let four = four_channels();
    let shared = four.clone().drawn_as(&Sensor::human()).unwrap();
    let size = [32, 24];
    let films = film(scene, size, 4, &[of(Sensor::human()), of(shared), of(four)]);
    let [human, shared, own] = &films[..] else { panic!("three films") };
    let mut differences = Vec::new();
    for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
        let (seen, parts) = (human.channels(x, y), shared.channels(x, y));
        let sums = [parts[0], parts[1] + parts[2], parts[3]];
        for (sum, value) in sums.into_iter().zip(&seen) {
            assert!((sum - value).abs() <= 1e-12 * value.abs(), "{x} {y}: {parts:?} {seen:?}");
        }
        assert_eq!(seen, human.xyz(x, y));
        for (sum, value) in shared.xyz(x, y).into_iter().zip(&seen) {
            assert!((sum - value).abs() <= 1e-12 * value.abs());
        }
        assert_eq!(
            (shared.alpha(x, y), shared.spectrum(x, y), shared.compositing(x, y)),
            (human.alpha(x, y), human.spectrum(x, y), human.compositing(x, y))
        );
        differences.push(own.xyz(x, y)[1] - seen[1]);
    }
    let count = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let spread = (differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / count).sqrt();
    // A sample counts in four pixels: 2.25 of them are as one.
    assert!(spread > 0.0 && mean.abs() < 4.0 * spread * (2.25 / count).sqrt(), "{mean} {spread}");
}

/// Light of radiance 1 up to 360 nm that is gone at 370: ∫ from 300 to 400 nm is 65.
fn dark_light() -> Emission {
    Emission::new(|nm| ((370.0 - nm) / 10.0).clamp(0.0, 1.0)).unwrap()
}

/// A surface that is white up to 380 nm and black above.
fn white_below_sight() -> Surface {
    Surface::Lambertian(Lambertian::new(Reflectance::new(|nm| f64::from(nm < 380.5)).unwrap()))
}

/// Means over the middle of a picture and their standard error.
fn middle(film: &Film) -> (f64, f64) {
    let pixels = || (4..12).flat_map(|y| (4..12).map(move |x| (x, y)));
    let sum: f64 = pixels().map(|(x, y)| film.channels(x, y)[0]).sum();
    let variance: f64 = pixels().map(|(x, y)| film.pixel(x, y).variance(film.count(x, y))).sum();
    let white = film.planes().sensor.white()[0];
    (sum / 64.0, white * variance.sqrt() / 64.0)
}

#[test]
fn ultraviolet_light_has_the_radiance_that_is_known_by_hand() {
    let under = |lamps: Vec<Lamp>, environment: Option<Environment>| {
        scene(square(4.0), white_below_sight(), (lamps, environment), camera(1.0, 4.0))
    };
    // A sun of radius 6° straight above: E = L π sin²α, and white returns E/π. It is bright, so that each of its shadow rays is worth it.
    let radius = 6_f64.to_radians();
    let sun = Sun { direction: DVec3::Z, cos_radius: radius.cos(), emission: dark_light().scaled(100.0) };
    let lit = under(vec![Lamp { light: Light::Sun(sun), weight: 1.0 }], None);
    let plain = |sensor: Sensor| Planes { sensor, ..Planes::default() };
    let films = film(lit, [16, 16], 64, &[plain(ultraviolet()), plain(Sensor::human())]);
    let (mean, error) = middle(&films[0]);
    let expected = 6500.0 * radius.sin().powi(2);
    assert!(error < 5e-3 * expected, "{error}");
    assert!((mean - expected).abs() < 4.0 * error, "{mean} {expected}");
    assert_eq!(middle(&films[1]).0, 0.0);
    // In a sky of that light the square vanishes, and what is behind has no noise.
    let sky = Sky::grey(8, 4, dark_light(), |_| 1.0).unwrap();
    let mut furnace = under(Vec::new(), Some(Environment { sky, weight: 1.0 }));
    furnace.camera = camera(1.0, 24.0);
    let seen = film(furnace, [48, 48], 16, &[plain(ultraviolet())]).remove(0);
    assert!((seen.channels(1, 1)[0] / 65.0 - 1.0).abs() < 1e-12, "{:?}", seen.channels(1, 1));
    let centre: f64 =
        (20..28).flat_map(|y| (20..28).map(move |x| (x, y))).map(|(x, y)| seen.channels(x, y)[0]).sum();
    assert!((centre / 64.0 / 65.0 - 1.0).abs() < 0.02, "{centre}");
}

#[test]
fn pictures_of_channels_have_a_plane_for_each() {
    let named = |sensor: Sensor| {
        let film = Film::with([4, 3], Planes { sensor, compositing: true, ..Planes::default() }).unwrap();
        let found = planes(&film, &Development::exposed(1.0), &[]).floats;
        found
            .into_iter()
            .map(|plane| plane.name)
            .filter(|name| !name.starts_with("Crypto"))
            .collect::<Vec<_>>()
    };
    let common = ["normal.X", "normal.Y", "normal.Z", "depth.Z"];
    let expected = |first: &[&'static str], last: &[&'static str]| [first, &common, last].concat();
    assert_eq!(named(ultraviolet()), expected(&["A", "CH.UV"], &["variance.mean", "samples.N", "albedo.UV"]));
    assert_eq!(
        named(four_channels()),
        expected(
            &["R", "G", "B", "A", "CH.X", "CH.Y1", "CH.Y2", "CH.Z"],
            &["variance.mean", "samples.N", "albedo.X", "albedo.Y1", "albedo.Y2", "albedo.Z"]
        )
    );
    assert_eq!(
        named(Sensor::human()),
        expected(
            &["R", "G", "B", "A", "XYZ.X", "XYZ.Y", "XYZ.Z"],
            &["variance.Y", "samples.N", "albedo.R", "albedo.G", "albedo.B"]
        )
    );
}

#[test]
fn checkpoints_are_of_one_sensor() {
    let planes = |sensor: Sensor| Planes { sensor, ..Planes::default() };
    let name = |planes: &Planes| checkpoint::name(&close_up(), 1, "", planes);
    let (human, other) = (planes(Sensor::human()), planes(four_channels()));
    let shared = planes(four_channels().drawn_as(&Sensor::human()).unwrap());
    assert_eq!(name(&human), name(&Planes::default()));
    assert!(name(&human) != name(&other) && name(&other) != name(&shared));
    let film = |planes: &Planes| Film::with([8, 8], planes.clone()).unwrap();
    let bytes = checkpoint::write(&film(&other), &name(&other));
    let refused = checkpoint::read(&bytes, &name(&human), film(&human)).unwrap_err().to_string();
    assert!(refused.contains("sensor or seed differ"), "{refused}");
    assert_eq!(checkpoint::read(&bytes, &name(&other), film(&other)).unwrap(), film(&other));
}
