//! What barbules add to a barb's highlight: radiance of a flat vane about its normal, as hair fibres and with substructures. Table and
//! figure of docs/theory/substructure.md.
//!
//! `target/release/examples/side_bands [-o FIGURE.svg]` (after `cargo build --release --workspace --examples`).

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program over what is built in

use std::path::Path;

use barbule::io::write_whole;
use barbule::plot::{Axis, Curve, Figure, Format};
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::description::SceneDescription;

/// An osprey's vane made flat and even, barbules at 40° to barbs at 45° to the shaft, under a lamp that stands over it; seen from 45°.
const SCENE: &str = "preset = 'osprey'
sky = 0.0
[light]
elevation_deg = 90.0
radius_deg = 2.0
strength = 1.0
[camera]
projection = 'orthographic'
lens = 0.0
width_mm = 1.4
elevation_deg = 45.0
target_mm = [5.0, 5.0, 0.0]
[window]
whole = false
radius_mm = 9.0
along_mm = 32.0
[feather.shaft]
bend_quadratic_deg = 0.0
arch_quadratic_deg = 0.0
[feather.barbs]
base_angle_deg = 45.0
tip_angle_deg = 45.0
curl_deg = 0.0
camber = 0.0
dihedral_deg = 0.0
[feather.distal]
base_angle_deg = 40.0
end_angle_deg = 40.0
base_lift_deg = 0.0
end_lift_deg = 0.0
[feather.proximal]
base_angle_deg = 40.0
end_angle_deg = 40.0
base_lift_deg = 0.0
end_lift_deg = 0.0
[feather.pattern]
bar_spacing_mm = 0.0
[feather.disorder]
barb_angle_deg = 0.0
";
const BARB_AZIMUTH_DEG: f64 = 45.0;
const BARBULE_ANGLE_DEG: f64 = 40.0;
const SIDE: u32 = 16;
const SAMPLES: u32 = 512;
const STEP_DEG: usize = 5;

/// Name, and what the scene says of it.
const MODELS: [(&str, &str); 3] = [
    ("hair fibres", "view_model = 'fibre'"),
    ("barbules looked up", "view_model = 'substructure'"),
    ("barbules grown", "level = 'barbules'"),
];

/// Azimuth from the barb, degrees, and luminance over that of a white, diffuse vane.
fn radiances(model: &str) -> barbule::Result<Vec<[f64; 2]>> {
    let scene = |azimuth: f64| {
        let turned = SCENE.replace("[camera]", &format!("[camera]\nazimuth_deg = {azimuth}"));
        SceneDescription::parse(&format!("{turned}[detail]\n{model}\n"))
    };
    let description = scene(0.0)?.wearing(None)?;
    let (objects, _) = description.objects(1)?;
    let stage = Stage::new(objects)?;
    let lighting = Lighting::new(description.lamps()?, None)?;
    let mut found = Vec::new();
    for azimuth in (0..=360).step_by(STEP_DEG) {
        let camera = scene(BARB_AZIMUTH_DEG + azimuth as f64)?.camera();
        let transport = Transport { most_scatterings: description.scatterings, ..Transport::default() };
        let integrator = Integrator::new(&stage, &lighting, &camera, transport);
        let mut film = Film::new([SIDE; 2])?;
        run(&integrator, &mut film, 1, Goal::samples(SAMPLES), &Unobserved, &mut |_| Ok(()))?;
        let sum: f64 = (0..SIDE * SIDE).map(|k| film.xyz(k % SIDE, k / SIDE)[1]).sum();
        found.push([azimuth as f64, sum / f64::from(SIDE * SIDE)]);
    }
    Ok(found)
}

fn main() -> barbule::Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let all = MODELS.map(|(name, model)| (name, radiances(model).unwrap()));
    println!("azimuth from the barb, degrees; luminance");
    for k in 0..all[0].1.len() {
        let [a, b, c] = [0, 1, 2].map(|m: usize| all[m].1[k][1]);
        println!("{:4} {a:.5} {b:.5} {c:.5}", all[0].1[k][0]);
    }
    // Light along the normal leaves in the planes across each fibre.
    for side in [
        90.0 - BARBULE_ANGLE_DEG,
        90.0 + BARBULE_ANGLE_DEG,
        270.0 - BARBULE_ANGLE_DEG,
        270.0 + BARBULE_ANGLE_DEG,
    ] {
        let k = (side / STEP_DEG as f64).round() as usize;
        let [a, b, c] = [0, 1, 2].map(|m: usize| all[m].1[k][1]);
        println!("at {side}: looked up {:.1}, grown {:.1} times the fibres' {a:.5}", b / a, c / a);
    }
    if let Some(at) = arguments.iter().position(|a| a == "-o") {
        let path = Path::new(&arguments[at + 1]);
        let mut figure = Figure::new(
            "Radiance about the normal of a flat vane, lit from above, seen at 45°",
            Axis::with_range("azimuth from the barbs' direction, degrees", 0.0, 360.0),
            Axis::logarithmic("luminance over that of white"),
        );
        figure.curves = all.iter().map(|(name, points)| Curve::line(*name, points.clone())).collect();
        write_whole(path, &figure.draw().encode(Format::of(path)?, &[])?)?;
    }
    Ok(())
}
