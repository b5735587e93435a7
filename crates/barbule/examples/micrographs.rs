//! Draws the micrographs of `examples/micrographs` and prints how far what is traced is off: the tables of `docs/guide/trace.md`.
//!
//! `cargo run --release -p barbule --example micrographs -- FOLDER`

#![allow(clippy::print_stdout)] // a program

use std::path::Path;

use barbule::io::write_whole;
use barbule::trace::{Grey, Micrograph, Options, Rods, Shape, Spread, trace};

/// Percent by which a measure is off.
fn off(found: f64, truth: f64) -> f64 {
    100.0 * (found / truth - 1.0)
}

/// A grey PNG with 8 bits.
fn write(path: &Path, picture: &Grey) -> barbule::Result<()> {
    let [width, height] = picture.size();
    let bytes: Vec<u8> = picture.values().iter().map(|v| (255.0 * v).round() as u8).collect();
    let refuse = |error: png::EncodingError| barbule::Error::machine(format!("no PNG ({error})"));
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width as u32, height as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().map_err(refuse)?;
    writer.write_image_data(&bytes).map_err(refuse)?;
    writer.finish().map_err(refuse)?;
    write_whole(path, &out)
}

/// A level bar with ends at whole pixels.
fn with_bar(picture: &Grey, [left, top, right, bottom]: [usize; 4]) -> barbule::Result<Grey> {
    let [width, height] = picture.size();
    let mut values = picture.values().to_vec();
    for y in 0..height {
        for x in 0..width {
            if (left..right).contains(&x) && (top..bottom).contains(&y) {
                values[y * width + x] = 0.0;
            }
        }
    }
    Grey::new(width, height, values)
}

/// Hollow rods of 110 nm, air 55 nm, 170 nm apart in rows of 147 nm under 130 nm of keratin: 2 nm per px.
fn rods() -> barbule::Result<Grey> {
    let rods = Rods {
        middle: [240.0, 217.0],
        period: 85.0,
        pitch: 73.5,
        shift: 0.5,
        diameter: 55.0,
        hollow: 27.5,
        rows: 4,
        columns: 5,
        turn_deg: 2.0,
        spread: 0.005,
        seed: 3,
    };
    let surface = Shape::Below { height: 14.25, slope: 2.0_f64.to_radians().tan(), bow: 0.0 };
    let mut shapes = vec![(surface, 1)];
    shapes.extend(rods.shapes().0);
    let scope = Micrograph { size: [480, 380], seed: 3, ..Micrograph::default() };
    scope.of(0, &shapes)
}

/// Keratin and melanin in layers of 200, 120, 150, 90 nm on keratin: 2 nm per px, with a bar of 200 nm.
fn layers() -> barbule::Result<Grey> {
    let mut height = 50.0;
    let mut shapes = Vec::new();
    for (thickness, medium) in [(100.0, 1), (60.0, 2), (75.0, 1), (45.0, 2), (0.0, 1)] {
        let slope = -3.0_f64.to_radians().tan();
        shapes.push((Shape::Below { height, slope, bow: 0.0 }, medium));
        height += thickness / 3.0_f64.to_radians().cos();
    }
    let scope = Micrograph { size: [420, 450], seed: 4, ..Micrograph::default() };
    with_bar(&scope.of(0, &shapes)?, [300, 425, 400, 433])
}

/// How far lattices of rods are off, over seeds.
fn table(blur: f64, noise: f64, is_hollow: bool) -> barbule::Result<()> {
    let mut errors = [Vec::new(), Vec::new(), Vec::new(), Vec::new()];
    for seed in 0..10_u64 {
        let rods = Rods {
            middle: [320.0, 250.0],
            period: 84.0,
            pitch: if seed % 2 == 0 { 72.0 } else { 84.0 },
            shift: if seed % 2 == 0 { 0.5 } else { 0.0 },
            diameter: 56.0,
            hollow: if is_hollow { 28.0 } else { 0.0 },
            rows: 5,
            columns: 6,
            turn_deg: seed as f64,
            spread: 0.02,
            seed,
        };
        let (shapes, diameters) = rods.shapes();
        let scope = Micrograph {
            size: [640, 500],
            shading: 0.4 * (seed % 3) as f64 / 2.0,
            stain: 0.2,
            blur,
            noise,
            seed,
            ..Micrograph::default()
        };
        let found = trace(&scope.of(1, &shapes)?, &Options::default())?;
        let Some(lattice) = found.lattice else { continue };
        let mean = Spread::of(&diameters).mean;
        errors[0].push(off(lattice.period.mean, rods.period));
        errors[1].push(off(lattice.row_pitch.mean, rods.pitch));
        errors[2].push(off(lattice.diameter.mean, mean));
        if is_hollow {
            errors[3].push(off(lattice.hollow.mean, mean * rods.hollow / rods.diameter));
        }
    }
    let worst = |errors: &[f64]| errors.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let cells: Vec<String> =
        errors.iter().filter(|e| !e.is_empty()).map(|e| format!("{:.2} %", worst(e))).collect();
    println!("| {blur} px | {:.0} % | {} |", 100.0 * noise, cells.join(" | "));
    Ok(())
}

fn main() -> barbule::Result<()> {
    if let Some(folder) = std::env::args_os().nth(1) {
        let folder = Path::new(&folder);
        write(&folder.join("rods.png"), &rods()?)?;
        write(&folder.join("layers.png"), &layers()?)?;
    }
    for is_hollow in [false, true] {
        println!("hollow: {is_hollow}");
        for (blur, noise) in [(0.0, 0.0), (1.0, 0.03), (2.0, 0.03), (3.0, 0.03), (1.0, 0.08), (3.0, 0.08)] {
            table(blur, noise, is_hollow)?;
        }
    }
    Ok(())
}
