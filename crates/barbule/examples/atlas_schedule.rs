//! How well many workers are used on an atlas, by the measured spread of its units' times: a table for `docs/guide/atlas.md`.
//!
//! ```text
//! atlas_schedule PLAN.toml [MEASURED]
//! ```
//!
//! Computes MEASURED units of the plan, spread over all; where a unit takes longer than ten seconds, it is tried with a few of its wavelengths
//! and individuals. Times of the plan's own units and of 10,000 are drawn from theirs and simulated on workers, each of which has as many
//! threads as this process.

#![allow(clippy::print_stdout)] // a program that prints

use std::path::Path;

use barbule::atlas::{Atlas, Faults, Plan, Schedule, foretell, foretell_by, run};
use barbule::math::rng::Stream;
use barbule::math::simd::Width;
use barbule::open::Opening;
use barbule::progress::Shard;
use barbule::{Error, Result, Unobserved};

/// Workers of the table.
const WORKERS: [usize; 3] = [10, 100, 1000];

/// Seconds of a unit that is too long to be computed for a table.
const LONG_S: f64 = 10.0;

/// Units of a larger atlas, and seconds of a unit that is as short as it should be.
const MANY: usize = 10_000;
const SHORT_S: f64 = 2.0;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let file = words.first().ok_or_else(|| Error::input("give PLAN.toml"))?;
    let measured = match words.get(1) {
        None => 40,
        Some(word) => word.parse().map_err(|_| Error::input(format!("{word} is no number of units")))?,
    };
    let (plan, folder) = Plan::open(Path::new(file))?;
    let atlas = Atlas::new(&plan, &folder, &Opening::default(), Width::best(), &Unobserved)?;
    let forecast = foretell(&atlas, &Unobserved)?;
    let units = atlas.layout().units();
    let (seconds, how) = if forecast.seconds / units as f64 > LONG_S {
        (tried(&atlas, measured)?, "tried with few wavelengths and individuals")
    } else {
        (computed(&atlas, measured)?, "computed")
    };
    let mean = seconds.iter().sum::<f64>() / seconds.len() as f64;
    let spread = (seconds.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / seconds.len() as f64).sqrt();
    let (least, most) = seconds.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), s| (l.min(*s), m.max(*s)));
    println!(
        "{} of {units} units of {} {how}, {} threads: {mean:.3} s ± {spread:.3} s, {least:.3} to {most:.3} s\n",
        seconds.len(),
        atlas.name(),
        forecast.cores
    );
    println!(
        "| units | of | workers | nothing goes wrong | slow workers and failures, next unit | the same, fixed parts |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    for (units, unit_s) in [(units, mean), (MANY, mean), (MANY, SHORT_S)] {
        rows(&seconds, units, unit_s / mean, &format!("{unit_s:.2} s"));
    }
    Ok(())
}

/// Seconds of so many units, spread over all.
fn computed(atlas: &Atlas, measured: usize) -> Result<Vec<f64>> {
    let made = tempfile::tempdir().map_err(|error| Error::machine(error.to_string()))?;
    let store = atlas.create(&made.path().join("units.zarr"))?;
    let all = atlas.layout().units();
    let parts = (all / measured.clamp(1, all)).max(1);
    let outcome = run(atlas, &store, &atlas.units(Shard::new(0, parts)?), &Unobserved)?;
    Ok(outcome.seconds.iter().map(|unit| unit.1).collect())
}

/// Seconds of so many units as cells foretell them.
fn tried(atlas: &Atlas, measured: usize) -> Result<Vec<f64>> {
    let unit_cells = atlas.cells() as f64 / atlas.layout().units() as f64;
    let cells = foretell_by(atlas, measured, &Unobserved)?.cell_seconds;
    Ok(cells.iter().map(|seconds| seconds * unit_cells).collect())
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
