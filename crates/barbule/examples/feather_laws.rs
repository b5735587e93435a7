//! The laws of Osorio & Ham (2002) on rendered feathers, as `docs/theory/measured.md` tells them:
//! `target/release/examples/feather_laws FOLDER` (after `cargo build --release --workspace --examples`), some minutes.

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program over what tests hold

use std::path::Path;

use barbule::io::write_whole;
use barbule::plot::{Axis, Curve, Figure, Format};
use barbule::spectrum::angle_law::AngleLaw;
use barbule::{Error, Result};
use laws::{Patch, Pose, beam_and_white, height, modulation, peak_nm};

#[path = "../tests/it/measure/laws.rs"]
mod laws;

/// Presets, and where their peak is looked for, nm.
const FEATHERS: [(&str, [f64; 2]); 4] = [
    ("starling", [450.0, 620.0]),
    ("rock-dove", [450.0, 620.0]),
    ("mallard", [440.0, 640.0]),
    ("hummingbird", [500.0, 690.0]),
];
const BETWEEN_DEG: [f64; 4] = [10.0, 30.0, 50.0, 70.0];
const ROLLS_DEG: [f64; 3] = [0.0, 45.0, 90.0];
/// Samples of a pixel: to find the beam, and to measure it.
const SAMPLES: [u32; 2] = [3, 48];

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).ok_or_else(|| Error::input("name the folder of the figures"))?;
    let folder = Path::new(&folder);
    let mut chart = Figure::new(
        "Rendered feathers, turned in fixed light",
        Axis::new("angle between light and viewer (°)"),
        Axis::new("wavelength of the peak (nm)"),
    );
    for (preset, range_nm) in FEATHERS {
        let points = peak_of(preset, range_nm)?;
        chart.curves.push(Curve::points(preset, points));
    }
    draw(&chart, &folder.join("law-of-angles.svg"))?;
    draw(&two_lobes(), &folder.join("gloss-and-beam.svg"))
}

fn draw(figure: &Figure, path: &Path) -> Result<()> {
    write_whole(path, &figure.draw().encode(Format::of(path)?, &[])?)
}

/// Peaks against the angle in all poses that show the beam; prints the law, how far poses of one angle differ, and what is left of the
/// modulation under a sky.
fn peak_of(preset: &str, range_nm: [f64; 2]) -> Result<Vec<[f64; 2]>> {
    let patch = Patch::of(preset, 1.0);
    let (mut points, mut apart, mut worst, mut deepest) = (vec![], 0.0, 0.0_f64, 0.0_f64);
    for between_deg in BETWEEN_DEG {
        let poses = patch.beam(between_deg, &ROLLS_DEG, SAMPLES[0]);
        let spectra: Vec<_> = poses.iter().map(|&pose| patch.lit(pose, None, SAMPLES[1])).collect();
        deepest = spectra.iter().map(modulation).fold(deepest, f64::max);
        let found: Vec<_> = spectra.iter().map(|spectrum| peak_nm(spectrum, range_nm)).collect();
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        apart += found.iter().map(|nm| (nm - mean).powi(2)).sum::<f64>();
        worst = found.iter().map(|nm| (nm - mean).abs()).fold(worst, f64::max);
        let turns: Vec<_> = poses.iter().map(|pose| format!("{}/{}", pose.roll_deg, pose.turn_deg)).collect();
        println!("{preset}: E = {between_deg}°: {mean:.1} nm in {} poses ({})", found.len(), turns.join(" "));
        points.extend(found.iter().map(|nm| [between_deg, *nm]));
    }
    let lit: Vec<_> = points.iter().map(|[between, nm]| (0.5 * between.to_radians(), *nm)).collect();
    let law = AngleLaw::fit(&lit)?;
    let spread = (apart / points.len() as f64).sqrt();
    let sky =
        modulation(&patch.under_sky(Pose { between_deg: 0.0, turn_deg: 0.0, roll_deg: 0.0 }, SAMPLES[1]));
    let index = law.index.map_or(f64::NAN, |index| index.value);
    println!(
        "{preset}: {:.1} nm − {:.3} nm/° E, rms {:.1} nm; n = {index:.2}; poses of one angle differ by {spread:.1} nm (rms), {worst:.1} at most; \
         modulation {deepest:.2}, under a sky {sky:.2}",
        law.line.a_nm.value, law.line.b_nm_per_deg.value, law.line.rmse_nm
    );
    Ok(points)
}

/// The coloured beam of a hummingbird's barbules and the white gloss of its barbs, as the feather is turned.
fn two_lobes() -> Figure {
    let mut chart = Figure::new(
        "A hummingbird's feather, turned",
        Axis::new("turn of the vane beyond the mirror position (°)"),
        Axis::new("radiance over the largest"),
    );
    let patch = Patch::of("hummingbird", 0.35);
    for between_deg in [10.0, 50.0] {
        let turns = (-12..=14).map(|k| 5.0 * f64::from(k));
        let poses: Vec<_> = turns.map(|turn_deg| Pose { between_deg, turn_deg, roll_deg: 0.0 }).collect();
        let whole: Vec<_> = poses.iter().map(|&pose| patch.lit(pose, None, 16)).collect();
        let beam = whole.iter().max_by(|a, b| height(a).total_cmp(&height(b))).unwrap();
        let barbs: Vec<_> = poses.iter().map(|&pose| patch.lit(pose, Some("barbs"), 16)).collect();
        let coloured: Vec<_> = whole.iter().map(|s| beam_and_white(s, beam)[0]).collect();
        let white: Vec<_> = barbs.iter().map(|s| beam_and_white(s, beam)[1].max(0.0)).collect();
        for (name, values) in [("coloured beam", coloured), ("white gloss of the barbs", white)] {
            let most = values.iter().copied().fold(0.0, f64::max);
            let beyond = poses.iter().map(|pose| pose.turn_deg - 0.5 * between_deg);
            let points: Vec<_> = beyond.zip(&values).map(|(turn, value)| [turn, value / most]).collect();
            let top = points.iter().max_by(|a, b| a[1].total_cmp(&b[1])).unwrap();
            println!("hummingbird, E = {between_deg}°: {name} at {}° from the mirror position", top[0]);
            chart.curves.push(Curve::line(format!("{name}, E = {between_deg}°"), points));
        }
    }
    chart
}
