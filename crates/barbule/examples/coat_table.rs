//! What a scene's coat measures, as docs/guide/coats.md shows it.
//!
//! `target/release/examples/coat_table SCENE.toml [SEED]` (after `cargo build --release --workspace --examples`)

#![allow(clippy::print_stdout)]

use std::path::Path;
use std::time::Instant;

use barbule::io::Folder;
use barbule::progress::Unobserved;
use barbule::resolve::read_files;
use barbule::scene::description::SceneDescription;
use barbule::{Error, Result};

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (file, seed) = match &words[..] {
        [file] => (file, 1),
        [file, seed] => (file, seed.parse().map_err(|_| Error::input("SEED is no whole number"))?),
        _ => return Err(Error::input("give a scene file and, if need be, a seed")),
    };
    let text = std::fs::read_to_string(file).map_err(|error| Error::input(format!("{file}: {error}")))?;
    let mut scene = SceneDescription::parse(&text)?;
    let folder = Folder(Path::new(file).parent().unwrap_or(Path::new("")).to_path_buf());
    read_files(&mut scene, &folder, seed, &Unobserved)?;
    let start = Instant::now();
    let laid = scene
        .laid_coats(seed)?
        .into_iter()
        .next()
        .ok_or_else(|| Error::input(format!("{file} has no [coat]")))?;
    let seconds = start.elapsed().as_secs_f64();
    let lifts: Vec<f64> = (laid.stands.iter().zip(&laid.before))
        .map(|(now, before)| (now.erection - before.erection).to_degrees())
        .collect();
    let [before, after] = laid.buried();
    println!("feathers                      {}", laid.stands.len());
    println!("area, cm²                     {:.1}", 0.01 * laid.area_mm2);
    println!("layers: vanes over area       {:.2}", laid.layers());
    println!("L √density                    {:.2}", laid.overlap());
    println!("triangles of the body         {}", laid.body.triangles.len());
    println!("laid in, s                    {seconds:.2}");
    println!(
        "lifted, mean and most, °      {:.2} {:.2}",
        mean(&lifts),
        lifts.iter().fold(0.0, |a: f64, b| a.max(*b))
    );
    println!("points under, before, %       {:.2}", 100.0 * before);
    println!("points under, after, %        {:.2}", 100.0 * after);
    Ok(())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
