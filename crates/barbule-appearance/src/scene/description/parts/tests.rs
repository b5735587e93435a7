//! Zones at every level of detail: pictures of a patch of a starling's vane.

use super::*;
use crate::brdf::fixtures::example;
use crate::brdf::{FeatherBrdf, Options};
use crate::bsdf::Texture;
use crate::progress::Unobserved;
use crate::render::film::Film;
use crate::render::integrator::{Integrator, Transport};
use crate::render::light::Lighting;
use crate::render::run::{Goal, run};
use crate::render::stage::Stage;
use crate::scene::description::{ReadyScene, Ring, SceneDescription};
use crate::spectrum::colour::xyz_from_rgb;
use crate::spectrum::difference::{delta_e_2000, lab};

/// Six millimetres of the vane from above, a little from its base, 18 mm up the shaft, under a sky without lamps.
const PATCH: &str = "preset = 'starling'
lights = []
sky = 1.0
[light]
strength = 0.0
[window]
along_mm = 18.0
radius_mm = 4.4
[camera]
projection = 'orthographic'
lens = 0.0
roll_deg = 0.0
azimuth_deg = 180.0
elevation_deg = 80.0
width_mm = 6.0
target_mm = [0.0, 0.0, 0.0]
";
/// Plain barbules and rami, so that colours are their pigment's; all of the vane has it.
const PLAIN: &str = "[surfaces.barbule]
longitudinal_roughness = 0.3
azimuthal_roughness = 0.4
eumelanin = 0.1
[surfaces.hair]
longitudinal_roughness = 0.3
azimuthal_roughness = 0.4
eumelanin = 0.1
[feather.pattern]
pale_tip_from_mm = 0.0
";
const LEVELS: [&str; 4] = ["barbules", "barbs", "vane", "envelopes"];
const SIDE: u32 = 64;
/// Where the patch lies along the vane, mm from its base.
const MIDDLE_MM: f64 = 18.0 - 0.12 * 30.0;
/// Length of the vane, mm.
const VANE_MM: f64 = 0.88 * 30.0;

fn scene(level: &str, extra: &str) -> SceneDescription {
    SceneDescription::parse(&format!("{PATCH}[detail]\nlevel = '{level}'\n{extra}")).unwrap()
}

/// Everything below 1 mm under the patch's middle; a disc on the right vane.
fn zones(edge_mm: f64) -> Vec<Zone> {
    let all = Zone {
        along: [0.0, 1.0],
        across: [-1.0, 1.0],
        ring: None,
        edge_mm,
        ramus: None,
        distal: None,
        proximal: None,
    };
    let disc = Ring {
        centre_mm: [1.7, MIDDLE_MM + 1.0],
        radii_mm: [0.0, 1.2],
        stretch: 1.3,
        widening_per_mm: 0.0,
        notch_mm: [0.0, 1.0],
    };
    vec![Zone { along: [0.0, (MIDDLE_MM - 1.0) / VANE_MM], ..all.clone() }, Zone { ring: Some(disc), ..all }]
}

/// X, Y and Z of every pixel, rows from the top.
fn picture(scene: &SceneDescription, zones: Vec<Zone>) -> Vec<[f64; 3]> {
    let brdf = Arc::new(FeatherBrdf::new(&example(3), Options::default()).unwrap());
    let mut scene = scene.clone();
    scene.lone_feather_mut().unwrap().zones = zones;
    rendered(&scene.wearing(brdf).unwrap())
}

fn rendered(scene: &ReadyScene) -> Vec<[f64; 3]> {
    let film = film_of(scene, Transport::default());
    (0..SIDE * SIDE).map(|pixel| film.xyz(pixel % SIDE, pixel / SIDE)).collect()
}

fn film_of(scene: &ReadyScene, transport: Transport) -> Film {
    let (objects, _) = scene.objects(1).unwrap();
    let stage = Stage::new(objects).unwrap();
    let environment = scene.environment().unwrap();
    let lighting = Lighting::new(scene.lamps().unwrap(), environment.as_ref()).unwrap();
    let camera = scene.camera();
    let integrator = Integrator::new(
        &stage,
        &lighting,
        &camera,
        Transport { most_scatterings: scene.scatterings, ..transport },
    );
    let mut film = Film::new([SIDE; 2]).unwrap();
    run(&integrator, &mut film, 1, Goal::samples(16), &Unobserved, &mut |_| Ok(())).unwrap();
    film
}

/// Zones that wear what the feather does are not seen, also where its tip is pale: on vanes and envelopes not a bit changes. Elsewhere objects
/// come apart into smaller ones, and with the smallest of them changes how near a ray may meet the next barbule: means differ by 1.1 % at
/// most, and by 0.02 % between fibres.
#[test]
fn zones_in_the_feathers_own_dress_are_not_seen() {
    let tip = "[feather.pattern]\npale_tip_from_mm = 19.5\nedge_mm = 0.2";
    let mut seen = Vec::new();
    for (level, extra) in LEVELS.into_iter().flat_map(|level| [(level, tip), (level, PLAIN)]) {
        let scene = scene(level, extra);
        let plain = picture(&scene, Vec::new());
        let zoned = picture(&scene, zones(0.3));
        let apart = plain.iter().zip(&zoned).filter(|(a, b)| a != b).count();
        let sum = |picture: &[[f64; 3]]| picture.iter().map(|xyz| xyz[1]).sum::<f64>();
        seen.push((level, apart, sum(&zoned) / sum(&plain) - 1.0));
    }
    let is_unseen = |(level, apart, mean): &(&str, usize, f64)| {
        mean.abs() < 0.02 && (*apart == 0 || ["barbules", "barbs"].contains(level))
    };
    assert!(seen.iter().all(is_unseen), "{seen:?}");
}

/// All of it made of plain fibres with so much pigment.
fn made_of([eumelanin, pheomelanin]: [f64; 2], zone: Zone) -> Zone {
    let fibre = FibreDescription {
        longitudinal_roughness: 0.3,
        azimuthal_roughness: 0.4,
        scale_tilt_deg: 0.0,
        index: Some(1.55),
        eumelanin,
        pheomelanin,
        colour: None,
        vane_colour: None,
        height_over_width: 1.0,
    };
    let side = Some(BarbuleDress::Hair(fibre));
    Zone { ramus: Some(RamusDress::Hair(fibre)), distal: side.clone(), proximal: side, ..zone }
}

/// Mean X, Y and Z of blocks of 8 × 8 pixels of one column.
fn blocks(picture: &[[f64; 3]], column: u32, [top, below]: [u32; 2]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (y, x) in (8 * top..8 * below).flat_map(|y| (8 * column..8 * column + 8).map(move |x| (y, x))) {
        let xyz = picture[(y * SIDE + x) as usize];
        (0..3).for_each(|k| sum[k] += xyz[k]);
    }
    sum.map(|sum| sum / f64::from(64 * (below - top)))
}

/// Down the right vane: its own barbules, the disc, and the lower zone. Each level draws its own barbules, which shows in so few pixels: X, Y
/// and Z differ by 15 % at most. On envelopes light is not scattered from barbule to barbule and gaps show the sky below: there the
/// disc's luminance over the feather's own is held within 40 %, and the lower zone is darker still.
#[test]
fn zones_lie_in_the_same_places_at_every_level() {
    let dressed: Vec<Zone> =
        [[8.0, 0.0], [0.0, 0.7]].into_iter().zip(zones(0.1)).map(|(of, zone)| made_of(of, zone)).collect();
    let seen = LEVELS.map(|level| {
        let scene = scene(level, PLAIN);
        let picture = picture(&scene, dressed.clone());
        [[0, 1], [1, 4], [6, 8]].map(|rows| blocks(&picture, 5, rows))
    });
    let [own, disc, lower] = seen[0];
    // Three colours: pheomelanin takes the blue, eumelanin everything.
    assert!(disc[2] / disc[0] < 0.97 * own[2] / own[0] && lower[1] < 0.25 * own[1], "{seen:.4?}");
    let expected = [own, disc, lower];
    for (level, found) in LEVELS.iter().zip(&seen) {
        let places = found.iter().zip(&expected);
        if *level == "envelopes" {
            let over_own = |[own, zone, _]: &[[f64; 3]; 3]| zone[1] / own[1];
            let apart = over_own(found) / over_own(&expected) - 1.0;
            assert!(apart.abs() < 0.4 && found[2][1] < 0.4 * found[0][1], "{apart:.3} {found:?}");
        } else {
            for (a, b) in places {
                let apart = [0, 1, 2].map(|k| a[k] / b[k] - 1.0);
                assert!(apart.iter().all(|d| d.abs() < 0.15), "{level}: {apart:.3?}");
            }
        }
    }
}

/// Rings of a peacock's eye lie on barbs left and right where their radii say, by straight barbs and rings written out again.
#[test]
fn rings_of_an_eye_hold_their_materials_on_barbs_of_both_sides() {
    let scene = SceneDescription::named("peacock").unwrap();
    let of = scene.lone_feather().unwrap();
    let worn = |zone: usize| match zone {
        0 => of.dress.material().unwrap().to_owned(),
        zone => {
            let worn = [&of.zones[zone - 1].distal, &of.zones[zone - 1].proximal];
            let named = |dress: &Option<BarbuleDress>| match dress {
                Some(BarbuleDress::Barbule(of)) => Some(of.material.name.clone()),
                _ => None,
            };
            worn.into_iter().find_map(named).unwrap()
        }
    };
    let zones = of.feather.zones(of.zone_plan().unwrap().unwrap()).unwrap();
    let (shape, eye, shaft) = (of.feather.barbs, of.feather.eye, of.feather.shaft);
    let smooth = |x: f64| x.clamp(0.0, 1.0).powi(2) * (3.0 - 2.0 * x.clamp(0.0, 1.0));
    let middle = shaft.length_mm * (1.0 - shaft.calamus) - eye.middle_mm;
    // From the heart outwards: outer radius, depth of the notch, and what is there.
    let rings = [
        (6.0, 4.5, "peafowl:scaled-violet"),
        (7.2, 4.5, "peafowl:scaled-blue"),
        (11.0, 2.0, "peafowl:scaled-turquoise"),
        (18.0, 0.0, "peafowl:scaled-bronze"),
        (20.0, 0.0, "peafowl"),
        (24.0, 0.0, "peafowl:scaled-green"),
        (f64::INFINITY, 0.0, "peafowl"),
    ];
    // Draws stray by less than this.
    let clear = 0.2 * 6.0_f64.sqrt() * std::f64::consts::SQRT_2 * 1.1;
    let mut held = [[0; 7]; 2];
    for before in [50.0, 38.0, 26.0, 14.0, 6.0] {
        let station = shaft.length_mm - before;
        let fan = smooth(1.0 - before / eye.length_mm);
        let angle = shape.leading_base_angle + (shape.leading_tip_angle - shape.leading_base_angle) * fan;
        let straight = angle - 0.375 * shape.curl.min(0.6 * angle);
        let radius = (shaft.radius_mm * (before / shaft.length_mm / (1.0 - shaft.calamus)).powf(shaft.taper))
            .max(shaft.tip_radius_mm);
        for step in 0..700 {
            let arc = 0.1 * f64::from(step);
            let x = 0.75 * radius + arc * straight.sin();
            let y = eye.middle_mm - before + arc * straight.cos();
            let rho = |notch: f64| {
                let wide = x / (1.0 + 0.005 * y);
                let plain = (wide * wide + y * y / 1.21).sqrt();
                if y < 0.0 && notch > 0.0 {
                    let width = if notch > 4.0 { 2.8 } else { 3.0 };
                    plain + notch * (-y / notch).min(1.0) * (-x * x / (width * width)).exp()
                } else {
                    plain
                }
            };
            // Too near to a border to tell; in the notch distances grow faster than the radius.
            if rings.iter().any(|(outer, notch, _)| (rho(*notch) - outer).abs() < 2.0 * clear) {
                continue;
            }
            let ring = rings.iter().position(|(outer, notch, _)| rho(*notch) < *outer).unwrap();
            for (k, side) in [-1.0, 1.0].into_iter().enumerate() {
                for name in 0..3 {
                    let zone = zones.at(side, station, arc, hash(name, &[step as u64]));
                    assert_eq!(worn(zone), rings[ring].2, "{before} {arc} {x} {y}");
                    held[k][ring] += 1;
                }
            }
        }
    }
    println!("{held:?} about {middle}");
    assert!(held[0] == held[1] && [0, 2, 3, 5, 6].into_iter().all(|ring| held[0][ring] > 20), "{held:?}");
}

/// Plates on a feather of fibres, as iridescent patches are, where parts stand there one by one, in the feather or in what its sheets
/// show; envelopes refuse them.
#[test]
fn zones_of_plates_lie_on_feathers_of_fibres() {
    let scene = |level: &str| {
        let text = format!(
            "preset = 'osprey'\nzones = [{{along = [0.5, 1.0], material = 'starling'}}]\n[detail]\nlevel = '{level}'"
        );
        SceneDescription::parse(&text)
    };
    let brdf = Arc::new(FeatherBrdf::new(&example(3), Options::default()).unwrap());
    let parts = |level: &str| {
        let ready = scene(level).unwrap().wearing(brdf.clone()).unwrap();
        (ready.objects(1).unwrap().0, ready.object_names())
    };
    let is_plates = |object: &Object| {
        let Geometry { ribbons, curves, repeated, .. } = &object.geometry;
        let ribbons = ribbons.len() + repeated.iter().map(|part| part.ribbons.len()).sum::<usize>();
        let curves = curves.len() + repeated.iter().map(|part| part.curves.len()).sum::<usize>();
        match object.surface {
            Surface::Barbule(_) => (ribbons > 0 && curves == 0).then_some(true),
            Surface::Hair(_) => (ribbons == 0 && curves > 0).then_some(false),
            _ => None,
        }
    };
    let (objects, names) = parts("barbs");
    let named = |name: &str| &objects[names.iter().position(|own| own == name).unwrap()];
    assert_eq!(is_plates(named("distal barbules")), Some(false));
    assert_eq!(is_plates(named("zone 1 distal barbules")), Some(true));
    let (objects, _) = parts("vane");
    let window = objects[1].geometry.window.as_ref().unwrap();
    for (layer, expected) in window.layers[..2].iter().zip([false, true]) {
        assert_eq!(is_plates(&layer.objects[2]), Some(expected));
    }
    let refused = scene("envelopes").unwrap_err().to_string();
    assert!(refused.contains("zones[0].distal is of type 'barbule', but the feather's own is 'hair', which envelopes cannot mix"), "{refused}");
}

/// Where scans are held against what they become: types of feathers, places along the vane and beside the shaft, mm.
const SCANNED: [(&str, f64, f64); 5] = [
    ("contour", 24.0, 2.2),
    ("covert", 38.0, 3.0),
    ("primary", 110.0, 4.0),
    ("secondary", 70.0, 4.0),
    ("tail", 75.0, 4.0),
];

/// A scan of two colours on each type of feather that birds wear: in even light on white what the vane covers is as it was scanned, within
/// ΔE00 of 2.5 (1.5 is found; black fibres would be 17 and 50 apart). The dark one is as dark as the gloss of body feathers lets it be.
#[test]
fn vanes_on_white_look_like_their_scan() {
    let scanned = [[0.112_f32, 0.074, 0.048], [0.578, 0.392, 0.188]];
    let places =
        SCANNED.into_iter().flat_map(|place| [-1.0, 1.0].into_iter().zip(scanned).map(move |k| (place, k)));
    for ((feather, along_mm, beside_mm), (side, colour)) in places {
        let text = format!(
            "preset = 'osprey'\nalbedo = 'scan.png'\nlights = []\nsky = 1.0\nsky_horizon = 1.0\nsky_below = 1.0\nscatterings = 60\n\
             [light]\nstrength = 0.0\n[window]\nalong_mm = {along_mm}\nwhole = true\n[detail]\nlevel = 'vane'\n\
             [feather]\ntype = '{feather}'\n\
             [camera]\nprojection = 'orthographic'\nlens = 0.0\nazimuth_deg = 180.0\nelevation_deg = 90.0\nwidth_mm = 1.2\n\
             target_mm = [{}, 0.0, 0.0]\n[surfaces.hair]\neumelanin = 0\npheomelanin = 0\n[surfaces.barbule]\neumelanin = 0\npheomelanin = 0",
            beside_mm * side
        );
        let mut scene = SceneDescription::parse(&text).unwrap();
        let picture = Texture::new([2, 1], scanned.to_vec()).unwrap();
        scene.lone_feather_mut().unwrap().albedo.as_mut().unwrap().fill(picture, "hash".into());
        let scene = scene.wearing(None).unwrap();
        let film = film_of(&scene, Transport { shows_sky: false, ..Transport::default() });
        let (mut sum, mut covered) = ([0.0; 3], 0.0);
        for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            sum.iter_mut().zip(film.xyz(x, y)).for_each(|(sum, value)| *sum += value);
            covered += film.alpha(x, y);
        }
        let white = xyz_from_rgb([1.0; 3]);
        let labs = [sum.map(|value| value / covered), xyz_from_rgb(colour.map(f64::from))]
            .map(|xyz| lab(xyz, white));
        let apart = delta_e_2000(labs[0], labs[1]);
        assert!(apart < 2.5, "{feather} {side}: {apart:.2} {labs:.2?}");
    }
}
