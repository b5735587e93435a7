use super::*;
use crate::identity::hash;
use crate::scene::description::{RamusDress, SkyDescription};

#[test]
fn a_scene_is_a_preset_with_changes() {
    let text = "preset = \"starling\"\nmaterial = \"starling:pink\"\n[light]\nazimuth = 77.0\n";
    let scene = SceneDescription::parse(text).unwrap();
    let starling = SceneDescription::named("starling").unwrap();
    assert_eq!(scene.material(), Some("starling:pink"));
    assert_eq!(scene.light.bearing.azimuth_deg, 77.0);
    assert_eq!((&scene.camera, scene.feather()), (&starling.camera, starling.feather()));
    let identity = |scene: &SceneDescription| hash("scene", scene);
    // Names decide as long as nobody has read what they stand for.
    assert_ne!(identity(&SceneDescription::named("starling:pink").unwrap()), identity(&starling));
    assert_ne!(identity(&scene), identity(&starling));
    let other = SceneDescription::parse(&text.replace("azimuth ", "azimuth_deg ")).unwrap();
    assert_eq!(identity(&other), identity(&scene));
}

/// A bird's coat changes key by key, but for its body.
#[test]
fn a_coat_is_a_presets_with_changes() {
    let coat = |text: &str| {
        let scene = SceneDescription::parse(&format!("preset = 'starling-bird'\n{text}")).unwrap();
        match &scene.objects[0].shape {
            ObjectShape::Coat(of) => of.coat.clone(),
            other => panic!("{other:?}"),
        }
    };
    let own = coat("");
    assert_eq!(coat("[coat]\nvariants = 2"), CoatDescription { variants: 2, ..own.clone() });
    let ball = coat("[coat]\nellipsoid_mm = [20, 30, 20]\ncount = 9");
    let body = CoatDescription {
        ellipsoid_mm: Some([20.0, 30.0, 20.0]),
        form: None,
        count: Some(9),
        density_per_cm2: None,
        ..own
    };
    assert_eq!(ball, body);
}

#[test]
fn whatever_a_preset_sets_a_scene_can_set() {
    for name in preset::names() {
        let text = preset::toml(name).unwrap();
        assert_eq!(SceneDescription::parse(text).unwrap(), SceneDescription::named(name).unwrap());
        if text.contains("preset =") {
            continue;
        }
        let other = if name == "magpie" { "mallard" } else { "magpie" };
        let changed = SceneDescription::parse(&format!("preset = \"{other}\"\n{text}")).unwrap();
        // Keys that a preset leaves out are those of the proximal barbules.
        assert_eq!(
            changed.feather().unwrap().distal,
            SceneDescription::named(name).unwrap().feather().unwrap().distal
        );
    }
    let text = "preset = \"magpie\"\n[feather.proximal]\ntilt_deg = 5.0\n[surfaces.ramus]\nmelanin = 0.5\n\
                [window]\nradius_mm = 1.0\n";
    let (scene, magpie) =
        (SceneDescription::parse(text).unwrap(), SceneDescription::named("magpie").unwrap());
    let [scene, magpie] = [&scene, &magpie].map(|scene| scene.lone_feather().unwrap());
    assert_eq!(scene.feather.proximal.tilt, 5.0_f64.to_radians());
    assert_eq!(scene.feather.proximal.base_lift, magpie.feather.proximal.base_lift);
    assert_eq!(scene.feather.distal, magpie.feather.distal);
    let RamusDress::Keratin(ramus) = &scene.dress.ramus else { panic!("{:?}", scene.dress) };
    assert_eq!((ramus.melanin, ramus.index), (0.5, 1.56));
    assert_eq!((scene.window.radius_mm, scene.window.along_mm), (Some(1.0), 150.0));
}

/// Rami of hair are a further table; without it a scene is the one that it was before there was hair.
#[test]
fn rami_may_be_fibres_of_hair() {
    let text = "preset = \"rock-dove\"\n[surfaces.hair]\nlongitudinal_roughness = 0.25\nazimuthal_roughness = 0.3\n\
                eumelanin = 0.6\npheomelanin = 0.1\nindex = 1.55\nheight_over_width = 2.5\n";
    let scene = SceneDescription::parse(text).unwrap();
    let RamusDress::Hair(hair) = scene.lone_feather().unwrap().dress.ramus.clone() else { panic!() };
    assert_eq!((hair.longitudinal_roughness, hair.azimuthal_roughness), (0.25, 0.3));
    assert_eq!(
        (hair.eumelanin, hair.pheomelanin, hair.index, hair.scale_tilt_deg),
        (0.6, 0.1, Some(1.55), 0.0)
    );
    assert_eq!(hair.height_over_width, 2.5);
    let bare = SceneDescription::named("rock-dove").unwrap();
    assert!(matches!(bare.lone_feather().unwrap().dress.ramus, RamusDress::Keratin(_)));
    assert_ne!(hash("scene", &scene), hash("scene", &bare));
    let message = |text: &str| {
        let text = format!("preset = \"rock-dove\"\n[surfaces.hair]\n{text}");
        SceneDescription::parse(&text).unwrap_err().to_string()
    };
    assert!(message("eumelanine = 1").contains("did you mean 'eumelanin'"));
    assert!(message("index = 1.0").contains("surfaces.hair.index"));
    assert!(message("azimuthal_roughness = 0").contains("surfaces.hair.azimuthal_roughness"));
    assert!(message("height_over_width = 20").contains("surfaces.hair.height_over_width is 20"));
}

#[test]
fn a_whole_feather_takes_the_place_of_a_radius() {
    let window = |text: &str| {
        SceneDescription::parse(&format!("preset = 'starling'\n[window]\n{text}"))
            .map(|scene| scene.lone_feather().unwrap().window)
    };
    assert_eq!(window("whole = true").unwrap().radius_mm, None);
    assert_eq!(
        window("whole = false").unwrap(),
        SceneDescription::named("starling").unwrap().lone_feather().unwrap().window
    );
    assert_eq!(window("whole = false\nradius_mm = 2").unwrap().radius_mm, Some(2.0));
    let both = window("whole = true\nradius_mm = 2").unwrap_err().to_string();
    assert_eq!(both, "window.whole and window.radius_mm are both given; leave one out");
}

#[test]
fn bad_scenes_are_refused_in_a_sentence() {
    let message = |text: &str| SceneDescription::parse(text).unwrap_err().to_string();
    let starling = |text: &str| message(&format!("preset = \"starling\"\n{text}"));
    assert!(message("preset = \"starlign\"").contains("did you mean 'starling'"));
    assert!(starling("exposre = 1.0").contains("line 2: unknown key 'exposre', did you mean 'exposure'"));
    assert!(message("preset = 3").contains("preset is the number 3"));
    assert!(starling("exposure = -1.0").contains("exposure is -1, outside 0.000001 to 1000000"));
    assert!(starling("[light]\nelevation = 100.0").contains("light.elevation_deg is 100, outside -90 to 90"));
    assert!(starling("[light]\nelevation = 10.0\nelevation_deg = 20.0").contains("are both given"));
    assert!(message("material = \"x\"").contains("preset"));
    assert!(starling("sky = 1.0\n[sky_image]\nfile = \"a.exr\"").contains("both"));
    assert!(starling("[sky_image]\nfiel = \"a.exr\"").contains("did you mean 'file'"));
    assert!(starling("[feather.distal]\nlenght_um = 3").contains("did you mean 'length_um'"));
    let range = "feather.distal.length_um is 0, outside 5 to 10000";
    assert!(starling("[feather.distal]\nlength_um = 0").contains(range));
    assert!(starling("[feather]\ndistal = 3").contains("feather.distal is the number 3"));
    assert!(starling("[surfaces.shaft]\nroughness = nan").contains("surfaces.shaft.roughness"));
    assert!(starling("[window]\nradius_mm = 0.0").contains("window.radius_mm is 0, outside 0.01 to 500"));
    assert!(starling("scatterings = 0").contains("scatterings is 0, outside 1 to 1000"));
    assert!(starling("[light]\nazimuth = 1e17").contains("light.azimuth_deg is 1"));
    let turned = "[sky_image]\nfile = \"a.exr\"\nturn = -1e17";
    assert!(starling(turned).contains("outside -3600 to 3600"));
    assert!(
        starling("sky = 0\nlights = []\n[light]\nstrength = 0").contains("sky and light.strength are both 0")
    );
    let dark = "lights = []\n[sky_image]\nfile = \"a.exr\"\nstrength = 0\n[light]\nstrength = 0";
    assert!(starling(dark).contains("sky_image.strength and light.strength are both 0"));
    assert!(message("[[[").len() < 400);
}

#[test]
fn a_scene_comes_back_from_its_text() {
    for name in preset::names() {
        let scene = SceneDescription::named(name).unwrap();
        let text = scene.to_toml().unwrap();
        assert_eq!(SceneDescription::parse(&text).unwrap(), scene, "{text}");
        // Round numbers stay round.
        assert!(!text.contains("0000000"), "{text}");
    }
    let text = "preset = 'magpie'\nexposure = 'auto'\nsize = [40, 20]\nturn = 12.5\n[background]\nfile = 'wall.png'\n\
                [sky_image]\nfile = 'sky.exr'\n[surfaces.hair]\neumelanin = 0.3\nheight_over_width = 2.5\n\
                [camera]\nprojection = 'orthographic'\ntarget_mm = [0.5, 0, 0]\nposition_mm = [0, 1, 9]\n\
                [[lights]]\ntype = 'sun'\nazimuth_deg = 10\nelevation_deg = 30\nstrength = 1\nspectrum = 'lamp.csv'\n\
                [[lights]]\ntype = 'point'\nposition_mm = [1, 2, 3]\nstrength = 1\ncolour = '#ffa040'\n\
                [[lights]]\ntype = 'spot'\nposition_mm = [1, 2, 3]\ncone_deg = 20\nstrength = 1\n\
                [[lights]]\ntype = 'sphere'\nazimuth_deg = 1\nelevation_deg = 2\ndistance_mm = 30\nradius_mm = 2\nstrength = 1\n\
                [[lights]]\ntype = 'rectangle'\nposition_mm = [1, 2, 3]\nsize_mm = [1, 2]\nstrength = 1\n";
    let text = format!(
        "shows_feather = false\n{text}[surfaces.glass]\ntype = 'dielectric'\nindex = 1.3\n\
         [surfaces.red]\ntype = 'diffuse'\ncolour = '#ff8000'\nalbedo = 'a.png'\nalpha = 'b.exr'\nnormal = 'c.png'\n\
         [surfaces.horn]\ntype = 'keratin'\nroughness = 0.2\nindex = 1.5\nmelanin = 3\n[surfaces.fur]\ntype = 'hair'\n\
         [[objects]]\nname = 'ball'\nsphere_mm = 2.5\nsurface = 'glass'\nrotate_deg = [1, 2, 3]\n\
         [[objects]]\nmesh = 'a.ply'\nsurface = 'red'\ninstances = [{{scale = 2}}, {{translate_mm = [1, 2, 3]}}]\n\
         [[objects]]\nrectangle_mm = [1, 2]\nsurface = 'horn'\n\
         [surfaces.pan]\ntype = 'conductor'\nroughness = 0.1\nmetal = 'copper'\n\
         [surfaces.steel]\ntype = 'conductor'\nroughness = [0.1, 0.3]\nindex = 2.5\nabsorption = 3.4\n\
         [[objects]]\ncurves = 'a.txt'\nsurface = 'pan'\n\
         [[objects]]\ncurves = 'b.txt'\nbasis = 'linear'\nsurface = 'steel'\n"
    );
    let scene = SceneDescription::parse(&text).unwrap();
    assert_eq!(SceneDescription::parse(&scene.to_toml().unwrap()).unwrap(), scene);
    let mut focused = SceneDescription::named("starling").unwrap();
    focused.camera.focus_distance_mm = Some(14.0);
    focused.camera.focal_length_mm = Some(85.0);
    focused.camera.f_number = Some(11.0);
    focused.lone_feather_mut().unwrap().window.radius_mm = None;
    focused.sky = SkyDescription::Gradient { zenith: 0.5, horizon: 1.0, below: 1.0 };
    assert_eq!(SceneDescription::parse(&focused.to_toml().unwrap()).unwrap(), focused);
}
