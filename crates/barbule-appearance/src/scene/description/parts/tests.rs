//! Zones at every level of detail: pictures of a patch of a starling's vane.

use super::*;
use crate::brdf::Options;
use crate::brdf::fixtures::example;
use crate::bsdf::{Absorption, FibreIndex, HairParameters, Region, Ring, ZonePlan};
use crate::progress::Unobserved;
use crate::render::film::Film;
use crate::render::integrator::{Integrator, Transport};
use crate::render::light::Lighting;
use crate::render::run::{Goal, run};
use crate::render::stage::Stage;

/// Six millimetres of the vane from above, 18 mm up the shaft, under a sky without lamps.
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
elevation_deg = 90.0
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
fn regions(edge_mm: f64) -> Vec<Region> {
    let all = Region { along: [0.0, 1.0], across: [-1.0, 1.0], ring: None, edge_mm };
    let disc = Ring { centre_mm: [1.7, MIDDLE_MM + 1.0], radii_mm: [0.0, 1.2], stretch: 1.3 };
    vec![Region { along: [0.0, (MIDDLE_MM - 1.0) / VANE_MM], ..all }, Region { ring: Some(disc), ..all }]
}

fn zones(scene: &SceneDescription, edge_mm: f64) -> Zones {
    scene.feather.zones(ZonePlan::Regions(regions(edge_mm))).unwrap()
}

/// X, Y and Z of every pixel, rows from the top.
fn picture(scene: &SceneDescription, zones: Option<(Zones, Vec<ZoneDress>)>) -> Vec<[f64; 3]> {
    let brdf = Arc::new(FeatherBrdf::new(&example(3), Options::default()).unwrap());
    let (objects, _) = scene.zoned_parts(Some(brdf), zones, 1).unwrap();
    let stage = Stage::new(objects).unwrap();
    let environment = scene.environment(None).unwrap();
    let lighting = Lighting::new(scene.lamps().unwrap(), environment.as_ref()).unwrap();
    let camera = scene.camera();
    let integrator = Integrator::new(&stage, &lighting, &camera, Transport::default());
    let mut film = Film::new([SIDE; 2]).unwrap();
    run(&integrator, &mut film, 1, Goal::samples(16), &Unobserved, &mut |_| Ok(())).unwrap();
    (0..SIDE * SIDE).map(|pixel| film.xyz(pixel % SIDE, pixel / SIDE)).collect()
}

/// Zones that wear what the feather does leave the same picture, also where its tip is pale.
#[test]
fn zones_in_the_feathers_own_dress_are_not_seen() {
    let tip = "[feather.pattern]\npale_tip_from_mm = 19.5\nedge_mm = 0.2";
    for (level, extra) in LEVELS.into_iter().flat_map(|level| [(level, tip), (level, PLAIN)]) {
        let scene = scene(level, extra);
        let plain = picture(&scene, None);
        let zoned = picture(&scene, Some((zones(&scene, 0.3), vec![ZoneDress::default(); 2])));
        let apart = plain.iter().zip(&zoned).filter(|(a, b)| a != b).count();
        assert_eq!(apart, 0, "{level} {extra}");
    }
}

fn fibre(eumelanin: f64, pheomelanin: f64) -> Substance {
    let parameters = HairParameters {
        longitudinal_roughness: 0.3,
        azimuthal_roughness: 0.4,
        scale_tilt: 0.0,
        index: FibreIndex::Constant(1.55),
        absorption: Absorption::pigments(eumelanin, pheomelanin).unwrap(),
        height_over_width: 1.0,
    };
    Substance::Fibre(Hair::new(parameters).unwrap())
}

fn all_of(substance: Substance) -> ZoneDress {
    ZoneDress { ramus: Some(substance.clone()), barbules: [Some(substance.clone()), Some(substance)] }
}

/// Means of squares of pixels: the colours of the vane, of zones and of what has their borders in it.
fn squares(picture: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let blocks = SIDE / BLOCK;
    let mean = |block: u32| {
        let mut sum = [0.0; 3];
        for pixel in 0..BLOCK * BLOCK {
            let x = block % blocks * BLOCK + pixel % BLOCK;
            let y = block / blocks * BLOCK + pixel / BLOCK;
            let xyz = picture[(y * SIDE + x) as usize];
            (0..3).for_each(|k| sum[k] += xyz[k] / f64::from(BLOCK * BLOCK));
        }
        sum
    };
    (0..blocks * blocks).map(mean).collect()
}
const BLOCK: u32 = 8;

#[test]
fn zones_lie_in_the_same_places_at_every_level() {
    let dresses = vec![all_of(fibre(8.0, 0.0)), all_of(fibre(0.0, 3.0))];
    let seen = LEVELS.map(|level| {
        let scene = scene(level, PLAIN);
        squares(&picture(&scene, Some((zones(&scene, 0.1), dresses.clone()))))
    });
    let expected = &seen[0];
    for (level, found) in LEVELS.iter().zip(&seen) {
        let apart: Vec<String> =
            found.iter().zip(expected).map(|(a, b)| format!("{:.2}", a[1] / b[1])).collect();
        for row in apart.chunks((SIDE / BLOCK) as usize) {
            eprintln!("{level} {row:?}");
        }
        for row in found.chunks((SIDE / BLOCK) as usize) {
            eprintln!("{:.3?}", row.iter().map(|xyz| xyz[1]).collect::<Vec<_>>());
        }
    }
}
