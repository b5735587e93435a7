//! How well many workers are used on an atlas, by the measured spread of its units' times: a table for `docs/guide/atlas.md`.
//!
//! ```text
//! atlas_schedule PLAN.toml [UNITS] [MEASURED]
//! ```
//!
//! Computes MEASURED units of the plan, draws UNITS times from theirs, and simulates these on workers.

#![allow(clippy::print_stdout)] // a program that prints

use std::path::Path;

use barbule::atlas::{Atlas, Faults, Plan, Schedule, run};
use barbule::math::rng::Stream;
use barbule::math::simd::Width;
use barbule::open::Opening;
use barbule::progress::Shard;
use barbule::{Error, Result, Unobserved};

/// Workers of the table.
const WORKERS: [usize; 3] = [10, 100, 1000];

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let count = |index: usize, usual: usize| match words.get(index) {
        None => Ok(usual),
        Some(word) => word.parse().map_err(|_| Error::input(format!("{word} is no number of units"))),
    };
    let file = words.first().ok_or_else(|| Error::input("give PLAN.toml"))?;
    let (units, measured) = (count(1, 10_000)?, count(2, 40)?);
    let (plan, folder) = Plan::open(Path::new(file))?;
    let atlas = Atlas::new(&plan, &folder, &Opening::default(), Width::best(), &Unobserved)?;
    let made = tempfile::tempdir().map_err(|error| Error::machine(error.to_string()))?;
    let store = atlas.create(&made.path().join("units.zarr"))?;
    let parts = atlas.layout().units().div_ceil(measured.max(1));
    // The first unit pays for what is made once.
    let seconds: Vec<f64> = run(&atlas, &store, &atlas.units(Shard::new(0, parts)?), &Unobserved)?
        .seconds
        .iter()
        .skip(1)
        .map(|unit| unit.1)
        .collect();
    if seconds.is_empty() {
        return Err(Error::input("one unit has no spread; give a larger plan or a smaller unit_cells"));
    }
    let mean = seconds.iter().sum::<f64>() / seconds.len() as f64;
    let spread = (seconds.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / seconds.len() as f64).sqrt();
    let (least, most) = seconds.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), s| (l.min(*s), m.max(*s)));
    println!(
        "{} units of {}: {mean:.3} s ± {spread:.3} s, {least:.3} to {most:.3} s\n",
        seconds.len(),
        atlas.name()
    );
    println!(
        "| units of | workers | nothing goes wrong | slow workers and failures, next unit | the same, fixed parts |"
    );
    println!("| --- | --- | --- | --- | --- |");
    for length_s in [mean, 2.0, 20.0] {
        let mut stream = Stream::new(1, &[0]);
        let mut draw = || seconds[((stream.unit() * seconds.len() as f64) as usize).min(seconds.len() - 1)];
        let all: Vec<f64> = (0..units).map(|_| draw() * length_s / mean).collect();
        for workers in WORKERS {
            let only_work = Faults {
                start_s: Faults::USUAL.start_s,
                overhead_s: Faults::USUAL.overhead_s,
                ..Faults::NONE
            };
            let quiet = Schedule::taken(&all, workers, &only_work, 1);
            let next = Schedule::taken(&all, workers, &Faults::USUAL, 1);
            let fixed = Schedule::shared_out(&all, workers, &Faults::USUAL, 1);
            println!(
                "| {length_s:.2} s | {workers} | {:.3} | {:.3} ({} again) | {:.3} |",
                quiet.efficiency, next.efficiency, next.repeated, fixed.efficiency
            );
        }
    }
    Ok(())
}
