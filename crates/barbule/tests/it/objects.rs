//! Objects of scene files: glass in a furnace, paint, holes, relief, maps, instances.

use std::path::Path;
use std::sync::Arc;

use barbule::SceneDescription;
use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::io::Folder;
use barbule::io::image::write_png;
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::resolve::read_files;
use barbule::scene::emission::Emission;
use barbule::scene::eye_maps;
use barbule::scene::sky::{Environment, Sky};
use barbule::spectrum::dense::Lambdas;
use glam::DVec3;

/// A scene file without a feather, seen straight from above; the files it names lie in the folder.
fn scene_in(folder: &Path, text: &str) -> SceneDescription {
    let head = "preset = 'starling'\nshows_feather = false\nlights = []\n[light]\nstrength = 0.0\n[camera]\nelevation = 90.0\nroll = 0.0\nlens = 0.0\nwidth_mm = 4.0\ntarget_mm = [0, 0, 0]\n";
    let mut scene = SceneDescription::parse(&format!("{head}{text}")).unwrap();
    read_files(&mut scene, &Folder(folder.to_path_buf()), 1, &Unobserved).unwrap();
    scene
}

fn stage(scene: &SceneDescription) -> Stage {
    let brdf = Arc::new(FeatherBrdf::new(&example(3), Options::default()).unwrap());
    let (objects, counts) = scene.clone().wearing(brdf).unwrap().objects(1).unwrap();
    assert_eq!((objects.len(), counts.barbules), (scene.objects.len(), 0));
    assert_eq!(scene.object_names().len(), objects.len());
    Stage::new(objects).unwrap()
}

/// What a scene shows under a sky of radiance 1 on all sides.
fn furnace_of(scene: &SceneDescription, most_scatterings: u32, samples: u32) -> Film {
    let stage = stage(scene);
    let sky = Sky::grey(64, 32, Emission::daylight(), |_| 1.0).unwrap();
    let lighting = Lighting::new(Vec::new(), Some(&Environment { sky, weight: 1.0 })).unwrap();
    let camera = scene.camera();
    let transport = Transport { most_scatterings, ..Transport::default() };
    let integrator = Integrator::new(&stage, &lighting, &camera, transport);
    let mut film = Film::new([24, 16]).unwrap();
    run(&integrator, &mut film, 1, Goal::samples(samples), &Unobserved, &mut |_| Ok(())).unwrap();
    film
}

fn furnace(text: &str, most_scatterings: u32, samples: u32) -> Film {
    furnace_of(&scene_in(Path::new(""), text), most_scatterings, samples)
}

/// A PNG one pixel high of these greys.
fn greys(path: &Path, values: &[u8]) {
    let bytes: Vec<u8> = values.iter().flat_map(|v| [*v; 3]).collect();
    write_png(path, [values.len() as u32, 1], &bytes, false, &[]).unwrap();
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

/// An eye from its front: an iris 1.9 mm behind a cornea of radius 4.1 mm, whose pupil has a radius of 1 mm.
fn eye(iris: &str, pupil: &str) -> SceneDescription {
    let side = 2.0 / eye_maps::PUPIL;
    let text = format!(
        "projection = 'orthographic'\n[surfaces.cornea]\ntype = 'dielectric'\nindex = 1.336\n[surfaces.iris]\ntype = 'diffuse'\n\
         colour = '#ffffff'\n{iris}\n[surfaces.pupil]\ntype = 'diffuse'\ncolour = '{pupil}'\n\
         [[objects]]\nsurface = 'cornea'\nsphere_mm = 4.1\n\
         [[objects]]\nsurface = 'iris'\nrectangle_mm = [{side}, {side}]\ntranslate_mm = [0, 0, 2.2]\n\
         [[objects]]\nsurface = 'pupil'\nrectangle_mm = [3, 3]\ntranslate_mm = [0, 0, 2.1]\n"
    );
    scene_in(Path::new(""), &text)
}

/// Pupils look larger through corneas: as large as Snell's law has it for rays that come in side by side, in the plane of one of them,
/// which is near Gauss' magnification 1/(1 − d (1 − 1/n)/r).
#[test]
fn corneas_magnify_pupils() {
    let film = furnace_of(&eye("alpha = 'eye:pupil'", "#000000"), 60, 64);
    let (radius, depth, index) = (4.1_f64, 1.9, 1.336_f64);
    // Where a ray beside the axis meets the iris's plane.
    let meets = |beside: f64| {
        let (normal, sag) = ((beside / radius).asin(), radius - (radius * radius - beside * beside).sqrt());
        beside - (depth - sag) * (normal - (beside / radius / index).asin()).tan()
    };
    let (mut low, mut high) = (1.0, 1.5);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if meets(middle) < 1.0 { low = middle } else { high = middle }
    }
    let paraxial = 1.0 / (1.0 - depth * (1.0 - 1.0 / index) / radius);
    assert!((low / paraxial - 1.0).abs() < 0.02, "{low} {paraxial}");
    // Area of what is dark, with the cornea's own reflection in its middle.
    let values = luminances(&film);
    let (dark, pale) = (film.xyz(12, 8)[1], film.xyz(1, 8)[1]);
    let share = values.iter().filter(|value| **value < 0.5 * (dark + pale)).count();
    let partly: f64 = values.iter().map(|value| ((pale - value) / (pale - dark)).clamp(0.0, 1.0)).sum();
    let seen = (partly * (4.0 / 24.0) * (4.0 / 24.0) / std::f64::consts::PI).sqrt();
    assert!((seen / low - 1.0).abs() < 0.02 && share > 100, "{seen} {low}");
}

/// White eyes neither give nor take light: iris, pupil and cornea vanish.
#[test]
fn white_eyes_vanish_in_a_white_furnace() {
    let values = luminances(&furnace_of(&eye("", "#ffffff"), 300, 64));
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    assert!((mean - 1.0).abs() < 5e-3, "{mean}");
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

/// Heights are those of the scene, however large the object is: an even slope leans the normal by its angle, on a turned and
/// enlarged rectangle and around a sphere.
#[test]
fn bumps_lean_normals_by_their_slope() {
    let folder = tempfile::tempdir().unwrap();
    // Rises by 64 steps of 4/255 of the height over its width.
    greys(&folder.path().join("ramp.png"), &std::array::from_fn::<u8, 64, _>(|i| 4 * i as u8));
    let rise = 64.0 * 4.0 / 255.0;
    let scene = |object: &str| {
        let text = format!(
            "[surfaces.wall]\ntype = 'diffuse'\nbump = 'ramp.png'\nbump_um = 3000\n[[objects]]\n{object}\nsurface = 'wall'\n"
        );
        stage(&scene_in(folder.path(), &text))
    };
    let normal = |stage: &Stage, from: DVec3, along: DVec3| {
        let hit = stage.hit(from, along, 0.0, 100.0).unwrap();
        stage.surface(&hit).bind(&hit, -along, Lambdas::splat(550.0)).shading_normal()
    };
    let turned = scene("rectangle_mm = [2, 2]\nscale = 3\nrotate_deg = [0, 0, 90]");
    let found = normal(&turned, DVec3::new(0.3, 0.4, 5.0), DVec3::NEG_Z);
    assert!((found - DVec3::new(0.0, -rise * 3.0 / 6.0, 1.0).normalize()).length() < 1e-6, "{found}");
    // At +x the texture of a sphere goes towards −y.
    let round = scene("sphere_mm = 2");
    let found = normal(&round, DVec3::new(9.0, 0.01, 0.02), DVec3::NEG_X);
    let slope = rise * 3.0 / (4.0 * std::f64::consts::PI);
    assert!((found - DVec3::new(1.0, slope, 0.0).normalize()).length() < 0.02, "{found}");
}

/// One object of two surfaces, the border between them sharp; a pixel that no surface has is refused with the file's name.
#[test]
fn maps_choose_surfaces_by_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[surfaces.white]\ntype = 'diffuse'\n[surfaces.grey]\ntype = 'diffuse'\ncolour = '#808080'\n\
                [surfaces.both]\ntype = 'map'\nfile = 'ids.png'\nsurfaces = ['grey', 'white']\n\
                [[objects]]\nrectangle_mm = [4.8, 4]\nsurface = 'both'\n";
    greys(&folder.path().join("ids.png"), &[0, 1, 1, 1]);
    let film = furnace_of(&scene_in(folder.path(), text), 2, 64);
    let mean = |columns: std::ops::Range<u32>| {
        let count = f64::from(4 * columns.len() as u32);
        columns.flat_map(|x| (6..10).map(move |y| (x, y))).map(|(x, y)| film.xyz(x, y)[1]).sum::<f64>()
            / count
    };
    // '#808080' is 0.2159 of white's light.
    for (found, expected) in [(mean(1..3), 0.2159), (mean(6..11), 1.0), (mean(13..23), 1.0)] {
        assert!((found - expected).abs() < 0.03, "{found} {expected}");
    }
    greys(&folder.path().join("ids.png"), &[0, 2]);
    let brdf = Arc::new(FeatherBrdf::new(&example(3), Options::default()).unwrap());
    let refused = scene_in(folder.path(), text).wearing(brdf).unwrap().objects(1).unwrap_err().to_string();
    assert!(refused.contains("ids.png: has a pixel of value 2"), "{refused}");
}
