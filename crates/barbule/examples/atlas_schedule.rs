//! How well many workers are used on an atlas, by the measured spread of its units' times: a table for `docs/guide/atlas.md`.
//!
//! ```text
//! atlas_schedule PLAN.toml [MEASURED] [UNIT_SECONDS]
//! ```
//!
//! Computes MEASURED units of the plan, spread over all; draws the times of the plan's own units and of 10,000 from theirs, and simulates
//! these on workers. UNIT_SECONDS is how long a unit takes on average where that is not what was measured, as of a plan that was thinned.

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

/// Units of a larger atlas, and seconds of a unit that is as short as it should be.
const MANY: usize = 10_000;
const SHORT_S: f64 = 2.0;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let file = words.first().ok_or_else(|| Error::input("give PLAN.toml"))?;
    let number = |index: usize| match words.get(index) {
        None => Ok(None),
        Some(word) => match word.parse::<f64>() {
            Ok(number) if number > 0.0 => Ok(Some(number)),
            _ => Err(Error::input(format!("{word} is no number above 0"))),
        },
    };
    let (measured, given_s) = (number(1)?.unwrap_or(40.0) as usize, number(2)?);
    let (plan, folder) = Plan::open(Path::new(file))?;
    let atlas = Atlas::new(&plan, &folder, &Opening::default(), Width::best(), &Unobserved)?;
    let seconds = measure(&atlas, measured)?;
    let mean = seconds.iter().sum::<f64>() / seconds.len() as f64;
    let spread = (seconds.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / seconds.len() as f64).sqrt();
    let (least, most) = seconds.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), s| (l.min(*s), m.max(*s)));
    println!(
        "{} of {} units of {} measured: {mean:.3} s ± {spread:.3} s, {least:.3} to {most:.3} s\n",
        seconds.len(),
        atlas.layout().units(),
        atlas.name()
    );
    println!(
        "| units | of | workers | nothing goes wrong | slow workers and failures, next unit | the same, fixed parts |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    let own_s = given_s.unwrap_or(mean);
    for (units, unit_s) in [(atlas.layout().units(), own_s), (MANY, own_s), (MANY, SHORT_S)] {
        rows(&seconds, units, unit_s / mean, &format!("{unit_s:.2} s"));
    }
    Ok(())
}

/// Seconds of so many units, spread over all.
fn measure(atlas: &Atlas, measured: usize) -> Result<Vec<f64>> {
    let made = tempfile::tempdir().map_err(|error| Error::machine(error.to_string()))?;
    let store = atlas.create(&made.path().join("units.zarr"))?;
    let all = atlas.layout().units();
    let parts = (all / measured.clamp(1, all)).max(1);
    // The first unit pays for what is made once; it is computed twice.
    let first = atlas.create(&made.path().join("first.zarr"))?;
    run(atlas, &first, &[0], &Unobserved)?;
    let outcome = run(atlas, &store, &atlas.units(Shard::new(0, parts)?), &Unobserved)?;
    Ok(outcome.seconds.iter().map(|unit| unit.1).collect())
}

/// The rows of so many units, which take `scale` times what was measured.
fn rows(seconds: &[f64], units: usize, scale: f64, words: &str) {
    let mut stream = Stream::new(1, &[0]);
    let mut draw = || seconds[((stream.unit() * seconds.len() as f64) as usize).min(seconds.len() - 1)];
    let all: Vec<f64> = (0..units).map(|_| draw() * scale).collect();
    let only_work =
        Faults { start_s: Faults::USUAL.start_s, overhead_s: Faults::USUAL.overhead_s, ..Faults::NONE };
    for workers in WORKERS {
        let quiet = Schedule::taken(&all, workers, &only_work, 1);
        let next = Schedule::taken(&all, workers, &Faults::USUAL, 1);
        let fixed = Schedule::shared_out(&all, workers, &Faults::USUAL, 1);
        println!(
            "| {units} | {words} | {workers} | {:.3} | {:.3} ({} again) | {:.3} |",
            quiet.efficiency, next.efficiency, next.repeated, fixed.efficiency
        );
    }
}
