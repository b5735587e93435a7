//! A picture of 2005 takes cos² δ for what a film of 140 nm reflects: that beside the film itself, as docs/theory/peacock.md has it, and
//! the pictures that stand on its disk.
//!
//! `target/release/examples/peacock_film [FOLDER]` (after `cargo build --release --workspace --examples`): with a folder the pictures
//! `colour.png`, `bump.png` and `alpha.png` are written there.

#![allow(clippy::print_stdout)] // a program that prints

#[path = "../tests/it/measure/peacock_film.rs"]
mod measure;

use std::path::Path;

use barbule::Result;
use barbule::io::image::write_png;
use barbule::scene::eye_maps;
use barbule::spectrum::colour::encode;

fn main() -> Result<()> {
    println!(
        "| angle | cos² δ: highest at, nm | its colour | film: highest R | its colour | correlation | ratio of means |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for angle_deg in [0.0, 30.0, 45.0, 60.0] {
        let measure::Row { peak_nm, colour, highest, film_colour, correlation, ratio } =
            measure::row(angle_deg)?;
        println!(
            "| {angle_deg}° | {peak_nm} | {colour:?} | {highest:.3} | {film_colour:?} | {correlation:.2} | {ratio:.1} |"
        );
    }
    let measure::Halved { correlation, absolute, relative } = measure::halved()?;
    println!(
        "\ncos²(δ/2) · 4 R₁ at 0°: correlation {correlation:.4}, off by {absolute:.4} at most, by {:.1} % of R at most",
        100.0 * relative
    );
    if let Some(folder) = std::env::args().nth(1) {
        eye_maps::NAMES.into_iter().try_for_each(|name| write(Path::new(&folder), name))?;
    }
    Ok(())
}

/// Writes one of the disk's pictures: colours as a screen shows them, numbers as they are.
fn write(folder: &Path, name: &str) -> Result<()> {
    let (picture, _) = eye_maps::made(name)?;
    let is_colour = name.ends_with("colour");
    let side = eye_maps::SIDE;
    let middle = |pixel: usize| (pixel as f64 + 0.5) / side as f64;
    let pixels: Vec<u8> = (0..side * side)
        .flat_map(|i| picture.at([middle(i % side), 1.0 - middle(i / side)]))
        .map(|v| (255.0 * if is_colour { encode(v) } else { v }).round() as u8)
        .collect();
    let file = folder.join(name.trim_start_matches("eye:").to_owned() + ".png");
    write_png(&file, [side as u32; 2], &pixels, false, &[("made by", "barbule, peacock_film")])
}
