//! Objects of scene files: glass in a furnace, paint, holes, instances.

use std::sync::Arc;

use barbule::SceneDescription;
use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::emission::Emission;
use barbule::scene::sky::{Environment, Sky};

/// What a scene file without a feather shows under a sky of radiance 1 on all sides, seen straight from above.
fn furnace(text: &str, most_scatterings: u32, samples: u32) -> Film {
    let head = "preset = 'starling'\nshows_feather = false\n[light]\nstrength = 0.0\n[camera]\nelevation = 90.0\nroll = 0.0\nlens = 0.0\nwidth_mm = 4.0\n";
    let scene = SceneDescription::parse(&format!("{head}{text}")).unwrap();
    let brdf = Arc::new(FeatherBrdf::new(&example(3), Options::default()).unwrap());
    let (objects, counts) = scene.objects(brdf, 1).unwrap();
    assert_eq!((objects.len(), counts.barbules), (scene.objects.len(), 0));
    assert_eq!(scene.object_names().len(), objects.len());
    let stage = Stage::new(objects).unwrap();
    let sky = Sky::grey(64, 32, Emission::daylight(), |_| 1.0).unwrap();
    let lighting = Lighting::new(Vec::new(), Some(&Environment { sky, weight: 1.0 })).unwrap();
    let camera = scene.camera();
    let transport = Transport { most_scatterings, ..Transport::default() };
    let integrator = Integrator::new(&stage, &lighting, &camera, transport);
    let mut film = Film::new([24, 16]).unwrap();
    run(&integrator, &mut film, 1, Goal::samples(samples), &Unobserved, &mut |_| Ok(())).unwrap();
    film
}

fn luminances(film: &Film) -> Vec<f64> {
    (0..24 * 16).map(|i| film.xyz(i % 24, i / 24)[1]).collect()
}

/// Glass takes nothing away, inside, outside and along its edges, however often light is thrown back within it.
#[test]
fn glass_vanishes_in_a_white_furnace() {
    for shape in ["sphere_mm = 1.2", "rectangle_mm = [3, 3]\nrotate_deg = [30, 0, 0]"] {
        let text = format!(
            "[surfaces.glass]\ntype = 'dielectric'\nindex = 1.5\n[[objects]]\n{shape}\nsurface = 'glass'\n"
        );
        let film = furnace(&text, 300, 64);
        let hits = (0..24 * 16).filter(|i| film.pixel(i % 24, i / 24).hits > 0).count();
        assert!(hits > 60);
        // A rectangle has no other side to come out of: what goes through stays over n².
        let values = luminances(&film);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        if shape.starts_with("sphere") {
            assert!((mean - 1.0).abs() < 3e-3, "{mean}");
            assert!(values.iter().all(|value| (value - 1.0).abs() < 0.25), "{values:?}");
        } else {
            assert!(mean < 0.9);
        }
    }
}

/// Frosted glass takes only what a second facet of its surface would send on: little where it is nearly smooth.
#[test]
fn frosted_glass_nearly_vanishes_in_a_white_furnace() {
    let mean = |roughness: f64| {
        let text = format!(
            "[surfaces.glass]\ntype = 'dielectric'\nindex = 1.5\nroughness = {roughness}\n[[objects]]\nsphere_mm = 1.2\nsurface = 'glass'\n"
        );
        let film = furnace(&text, 300, 64);
        let on_glass = (0..24 * 16)
            .filter(|i| film.pixel(i % 24, i / 24).hits == 64)
            .map(|i| luminances(&film)[i as usize]);
        let values: Vec<f64> = on_glass.collect();
        assert!(values.len() > 60);
        values.iter().sum::<f64>() / values.len() as f64
    };
    let (little, much) = (mean(0.05), mean(0.5));
    assert!((0.96..1.005).contains(&little) && much < little - 0.02 && much > 0.4, "{little} {much}");
}

/// Colour and instances: three squares of one colour, each as bright as its luminance, side by side.
#[test]
fn paint_has_its_colour_and_instances_stand_in_their_places() {
    let text = "[surfaces.red]\ntype = 'diffuse'\ncolour = '#ff0000'\n[[objects]]\nrectangle_mm = [1, 1]\nsurface = 'red'\n\
                instances = [{translate_mm = [-1.4, 0, 0]}, {}, {translate_mm = [1.4, 0, 0], scale = 0.5}]";
    let film = furnace(text, 2, 64);
    let seen = |x: u32| film.pixel(x, 8).hits > 0;
    assert!(seen(3) && !seen(7) && seen(12) && !seen(16) && seen(20) && !seen(23));
    assert_ne!(film.pixel(3, 8).id, film.pixel(12, 8).id);
    let mut mean = [0.0; 3];
    for (x, y) in (10..14).flat_map(|x| (7..9).map(move |y| (x, y))) {
        let rgb = barbule::spectrum::colour::rgb_from_xyz(film.xyz(x, y));
        mean.iter_mut().zip(rgb).for_each(|(sum, value)| *sum += value / 8.0);
    }
    assert!((mean[0] - 1.0).abs() < 0.05 && mean[1].abs() < 0.03 && mean[2].abs() < 0.03, "{mean:?}");
}
