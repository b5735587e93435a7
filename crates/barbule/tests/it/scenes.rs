//! Scenes as lists of objects, opened and rendered by the library as the command does it.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use barbule::brdf::fixtures::example;
use barbule::io::image::{write_exr, write_png};
use barbule::io::{Folder, Memory};
use barbule::open::{Opening, scene};
use barbule::resolve::{Below, foretell_files, read_files};
use barbule::scene::Object;
use barbule::scene::description::{Holds, Named, ReadyScene};
use barbule::scene::feather::{Feather, Level, VaneDisc};
use barbule::{Picture, PictureOptions, SceneDescription, Unobserved, Worn, resolve};

const SMALL: [u32; 2] = [48, 30];

fn options(samples: u32) -> PictureOptions {
    PictureOptions { size: SMALL, samples, ..PictureOptions::default() }
}

fn in_examples(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../examples/scenes")
        .join(name)
        .to_string_lossy()
        .into_owned()
}

/// How many pixels an object changes.
fn seen(picture: &Picture, ready: &ReadyScene, name: &str, samples: u32) -> usize {
    let without = ready.changed(|scene| scene.objects.retain(|object| object.label() != name)).unwrap();
    let other = Picture::of(&without, &options(samples), &Unobserved).unwrap();
    let pixels = (0..SMALL[1]).flat_map(|y| (0..SMALL[0]).map(move |x| (x, y)));
    pixels.filter(|&(x, y)| picture.film().xyz(x, y) != other.film().xyz(x, y)).count()
}

/// Two feathers of two species and a coat stand in one picture, each in its own colour; the same again from its own text.
#[test]
fn two_birds_and_a_coat_are_one_scene() {
    let ready = scene(&in_examples("two-birds.toml"), &Opening::default(), &Unobserved).unwrap();
    let materials = ready.material_names();
    assert_eq!(materials, ["starling", "mallard", "magpie"]);
    let again = SceneDescription::parse(&ready.to_toml().unwrap()).unwrap();
    assert_eq!(again.objects.len(), 3);
    assert_eq!(SceneDescription::parse(&again.to_toml().unwrap()).unwrap(), again);
    let picture = Picture::of(&ready, &options(2), &Unobserved).unwrap();
    let names = ready.object_names();
    for part in ["skin", "mallard left vane", "magpie shaft"] {
        assert!(names.iter().any(|name| name == part), "{names:?}");
    }
    for bird in ["coat", "mallard", "magpie"] {
        let count = seen(&picture, &ready, bird, 2);
        assert!(count > 60, "{bird}: {count}");
    }
}

/// One vane of three materials: the zones are there, in colours of their own, and the rest of the feather keeps its bits.
#[test]
fn a_vane_has_three_zones() {
    let ready = scene(&in_examples("three-zones.toml"), &Opening::default(), &Unobserved).unwrap();
    assert_eq!(ready.material_names(), ["starling", "rock-dove:purple", "bronzewing"]);
    let names = ready.object_names();
    assert!(names.iter().any(|name| name.starts_with("zone 2")), "{names:?}");
    let (objects, counts) = ready.objects(1).unwrap();
    assert_eq!(objects.len(), names.len());
    let plain = ready.changed(|scene| scene.lone_feather_mut().unwrap().zones.clear()).unwrap();
    let (own, own_counts) = plain.objects(1).unwrap();
    let ribbons = |objects: &[Object]| objects.iter().map(|o| o.geometry.ribbon_count()).sum::<usize>();
    assert_eq!((ribbons(&objects), counts), (ribbons(&own), own_counts));
    let [zoned, plain] = [&ready, &plain].map(|scene| Picture::of(scene, &options(4), &Unobserved).unwrap());
    let differs = |x: u32, y: u32| zoned.film().xyz(x, y) != plain.film().xyz(x, y);
    let (top, bottom) =
        ((0..SMALL[0]).filter(|x| differs(*x, 3)).count(), (0..SMALL[0]).filter(|x| differs(*x, 28)).count());
    assert!(top > 20 && bottom < top, "{top} {bottom}");
}

/// A sky, a mesh, a texture and a grating's sample: whatever a scene names, from a folder or from memory, to the same bits.
#[test]
fn the_library_renders_whatever_a_scene_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let plane = |value: f32| vec![value; 8 * 4];
    write_exr(
        &path("sky.exr"),
        [8, 4],
        vec![("R", plane(0.4)), ("G", plane(0.5)), ("B", plane(0.9))],
        vec![],
        &[],
        &[],
    )
    .unwrap();
    write_png(&path("paint.png"), [2, 1], &[255, 40, 20, 20, 60, 255], false, &[]).unwrap();
    std::fs::write(
        path("tent.obj"),
        "v -1 -1 0\nv 1 -1 0\nv 1 1 1\nv -1 1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n",
    )
    .unwrap();
    let text = "preset = 'starling'\nshows_feather = false\nlights = []\nsky_image = { file = 'sky.exr' }\n\
                [camera]\nwidth_mm = 6\nlens = 0\ntarget_mm = [0, 0, 0]\n\
                [surfaces.paint]\ntype = 'diffuse'\nalbedo = 'paint.png'\n[surfaces.rainbow]\ntype = 'grating'\nsample = 'blazed'\n\
                [[objects]]\nmesh = 'tent.obj'\nsurface = 'paint'\n\
                [[objects]]\nrectangle_mm = [1, 1]\nsurface = 'rainbow'\ntranslate_mm = [2, 0, 0]\n";
    std::fs::write(path("scene.toml"), text).unwrap();
    let ready = scene(&path("scene.toml").to_string_lossy(), &Opening::default(), &Unobserved).unwrap();
    let picture = Picture::of(&ready, &options(8), &Unobserved).unwrap();
    let counts = ["paint", "rainbow"].map(|name| seen(&picture, &ready, name, 8));
    assert!(counts[0] > 100 && counts[1] > 10, "{counts:?}");
    let files = ["sky.exr", "paint.png", "tent.obj"];
    let read = |name: &&str| ((*name).to_owned(), std::fs::read(path(name)).unwrap());
    let memory = Memory(files.iter().map(read).collect::<BTreeMap<_, _>>());
    let mut dye = |_: &str| Worn::new(&example(3), String::new());
    let same = resolve(SceneDescription::parse(text).unwrap(), &memory, &mut dye, 1, &Unobserved).unwrap();
    assert_eq!(Picture::of(&same, &options(8), &Unobserved).unwrap().film(), picture.film());
    // What is missing is refused by its key, whatever it is.
    for lost in files {
        let mut fewer = memory.clone();
        fewer.0.remove(lost);
        let refused =
            resolve(SceneDescription::parse(text).unwrap(), &fewer, &mut dye, 1, &Unobserved).unwrap_err();
        assert!(
            refused.to_string().contains(lost) && refused.to_string().contains("no such file"),
            "{refused}"
        );
    }
}

/// A mesh wears the barbules of a material that its surface names, and one name is asked for once.
#[test]
fn a_mesh_of_a_scene_wears_a_material() {
    let text = "preset = 'starling'\n[surfaces.green]\ntype = 'barbule'\nmaterial = 'starling'\nuv_mm = [4, 3]\nwidth_um = 30\ncell_um = 40\n\
                [[objects]]\nname = 'sheet'\nrectangle_mm = [4, 3]\nsurface = 'green'\ntranslate_mm = [0, 0, 3]\n";
    let mut asked = Vec::new();
    let mut dye = |name: &str| {
        asked.push(name.to_owned());
        Worn::new(&example(3), String::new())
    };
    let description = SceneDescription::parse(text).unwrap();
    let ready = resolve(description.clone(), &Folder::default(), &mut dye, 1, &Unobserved).unwrap();
    assert_eq!(asked, ["starling"]);
    let picture = Picture::of(&ready, &options(4), &Unobserved).unwrap();
    let count = seen(&picture, &ready, "sheet", 4);
    assert!(count > 300, "{count}");
    let mut named = description;
    assert_eq!(named.named_mut().iter().filter(|(_, one)| matches!(one, Named::Material(_))).count(), 3);
}

/// The material of lower sides is asked for where a picture may show it, once, and looks as if it had been named.
#[test]
fn lower_sides_are_worn_where_they_show_and_left_alone_elsewhere() {
    let ready = |text: &str| {
        let mut asked = Vec::new();
        let mut dye = |name: &str| {
            asked.push(name.to_owned());
            let below = if name == "duck" { Below::Named("duck (below)".into()) } else { Below::Same };
            let size = if name == "duck" { 3 } else { 5 };
            Ok(Worn { below, ..Worn::new(&example(size), format!("hash of {name}"))? })
        };
        let scene = SceneDescription::parse(text).unwrap();
        assert_eq!(SceneDescription::parse(&scene.to_toml().unwrap()).unwrap(), scene, "{text}");
        let scene = resolve(scene, &Folder::default(), &mut dye, 1, &Unobserved).unwrap();
        (scene, asked)
    };
    let feather = "preset = 'starling-feather'\nmaterial = 'duck'\n[camera]\nelevation_deg = -60\n";
    let with = |under: &str| ready(&format!("under = '{under}'\n{feather}"));
    let (own, asked) = ready(feather);
    assert_eq!(asked, ["duck", "duck (below)"]);
    let (named, asked) = with("duck (below)");
    assert_eq!(asked, ["duck", "duck (below)"]);
    let (keratin, asked) = with("keratin");
    assert_eq!(asked, ["duck"]);
    let film = |scene: &ReadyScene| Picture::of(scene, &options(4), &Unobserved).unwrap().film().clone();
    let hash = |scene: &ReadyScene| barbule::identity::hash("scene", &**scene);
    assert_eq!((film(&own), hash(&own)), (film(&named), hash(&named)));
    assert!(film(&own) != film(&keratin) && hash(&own) != hash(&keratin));
    // What is alike on both sides is held once, and is not asked for again.
    assert_eq!(ready(&feather.replace("'duck'", "'starling'")).1, ["starling"]);
    // Zones, coats and meshes have lower sides of their own.
    let zone = format!("{feather}[[zones]]\nalong = [0.5, 1]\nmaterial = 'crow'\nunder = 'tit'\n");
    assert_eq!(ready(&zone).1, ["duck", "duck (below)", "crow", "tit"]);
    let objects = |what: &str| {
        ready(&format!(
            "preset = 'starling'\nshows_feather = false\n[surfaces.plates]\ntype = 'barbule'\nmaterial = 'duck'\n[[objects]]\n{what}\n"
        ))
    };
    let coat = "sphere_mm = 9\nsurface = 'plates'\n[[objects]]\nfeather = 'contour'\nmaterial = 'crow'\nunder = 'tit'";
    assert_eq!(objects(coat).1, ["crow", "tit", "duck", "duck (below)"]);
    let refused = |text: &str| SceneDescription::parse(text).unwrap_err().to_string();
    let alone = format!("{feather}[[zones]]\nalong = [0.5, 1]\nunder = 'tit'\n");
    assert!(
        refused(&alone).contains("zones[0].under is given, but no barbules of a material"),
        "{}",
        refused(&alone)
    );
    assert!(refused(&format!("under = 3\n{feather}")).contains("under is the number 3"));
}

/// Barbules that curves wear face outwards all round: what lies inside is not asked for.
#[test]
fn curves_have_no_lower_sides() {
    let text = "preset = 'starling'\nshows_feather = false\n[surfaces.plates]\ntype = 'barbule'\nmaterial = 'duck'\nunder = 'tit'\n\
                [[objects]]\ncurves = 'a.txt'\nsurface = 'plates'\n";
    let memory =
        Memory([("a.txt".to_owned(), b"0 0 0 0.1\n0 1 0 0.1\n0 2 0 0.1\n0 3 0 0.1\n".to_vec())].into());
    let asked = |text: &str| {
        let mut asked = Vec::new();
        let mut dye = |name: &str| {
            asked.push(name.to_owned());
            Worn::new(&example(3), String::new())
        };
        let ready =
            resolve(SceneDescription::parse(text).unwrap(), &memory, &mut dye, 1, &Unobserved).unwrap();
        ready.objects(1).unwrap();
        asked
    };
    assert_eq!(asked(text), ["duck"]);
    let both = format!("{text}[[objects]]\nrectangle_mm = [1, 1]\nsurface = 'plates'\n");
    assert_eq!(asked(&both), ["duck", "tit"]);
}

/// A file that is named several times is held once; what no object has is not read, and need not be there.
#[test]
fn files_are_held_once_and_only_where_an_object_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("paint.png");
    write_png(&path, [2, 1], &[255, 40, 20, 20, 60, 255], false, &[]).unwrap();
    let tent = b"v -1 -1 0\nv 1 -1 0\nv 1 1 1\nf 1 2 3\n".to_vec();
    let files = [("paint.png", std::fs::read(&path).unwrap()), ("tent.obj", tent)];
    let memory = Memory(files.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)).collect());
    let text = "preset = 'starling'\nshows_feather = false\n\
                [surfaces.a]\ntype = 'diffuse'\nalbedo = 'paint.png'\n[surfaces.b]\ntype = 'diffuse'\nalbedo = 'paint.png'\n\
                [surfaces.unseen]\ntype = 'diffuse'\nalbedo = 'none.png'\n\
                [surfaces.by_place]\ntype = 'map'\nfile = 'paint.png'\nsurfaces = ['b']\n\
                [[objects]]\nmesh = 'tent.obj'\nsurface = 'a'\n[[objects]]\nmesh = 'tent.obj'\nsurface = 'by_place'\n";
    let mut scene = SceneDescription::parse(text).unwrap();
    let (foreseen, reading) = foretell_files(&scene, &memory, 1);
    assert_eq!(foreseen.get("paint.png"), Some(&Holds::Pixels(2.0)));
    assert!(reading > 0 && scene.bytes(&foreseen) > 0);
    assert_eq!(scene.named_mut().len(), 6);
    read_files(&mut scene, &memory, 1, &Unobserved).unwrap();
    let (mut colours, mut meshes) = (Vec::new(), Vec::new());
    for (_, named) in scene.needed_mut() {
        assert!(named.is_read(), "{named:?}");
        match named {
            Named::Colours(slot) => colours.push(slot.value().unwrap().clone()),
            Named::Mesh(slot) => meshes.push(slot.value().unwrap().clone()),
            _ => {}
        }
    }
    assert!(colours.len() == 2 && Arc::ptr_eq(&colours[0], &colours[1]));
    assert!(meshes.len() == 2 && Arc::ptr_eq(&meshes[0], &meshes[1]));
}

/// What is counted of a feather before it grows is at least what grows, within the noise of its disorder, and not far more.
#[test]
fn a_census_counts_what_grows() {
    for (name, along_mm, radius_mm) in [
        ("contour", 25.0, Some(4.0)),
        ("contour", 20.0, None),
        ("down", 5.0, Some(1.5)),
        ("semiplume", 20.0, Some(3.0)),
        ("primary", 90.0, Some(3.0)),
    ] {
        let feather = Feather::of_type(name).unwrap();
        let window = VaneDisc { along_mm, radius_mm };
        let grown = feather.grow(window, Level::Barbules, None, 3, 1).unwrap().counts();
        let census = feather.census(window);
        for (what, count, foretold) in
            [("barbs", grown.barbs, census.barbs), ("barbules", grown.barbules, census.barbules)]
        {
            let foretold = foretold[0] + foretold[1];
            let ratio = foretold / count as f64;
            let place = format!("{name}, {radius_mm:?}: {count} {what}, {foretold} foretold");
            assert!(ratio > 0.9 && (ratio < 4.0 || foretold < 200.0), "{place}");
        }
    }
}
