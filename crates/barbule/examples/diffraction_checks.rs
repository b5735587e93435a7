//! Prints the numbers of docs/theory/diffraction.md: errors of tables, Taylor's orders, periods that gratings tell, energies.
//!
//! `cargo run --release --example diffraction_checks`
#![allow(clippy::print_stdout)]

use std::time::Instant;

use barbule::diffraction::{Reference, direction, recovered_periods, table_errors};
use barbule::io::peak_memory;
use barbule::scattering::grating::{Coherence, Normalization, Obliquity, Place, Setup, TableGrid};
use barbule::solve::diffraction::{Builder, Series, usual_wavelengths};
use barbule::spectrum::Wavelengths;
use barbule::spectrum::colour::Observer;
use barbule::structure::{Heightfield, SAMPLES};
use barbule::{Result, Unobserved};

fn main() -> Result<()> {
    let at = usual_wavelengths()?;
    let observer = Observer::default();
    let setup = Setup::default();
    println!("tables at their usual settings, light from 0° and from 45°");
    println!(
        "sample,range_um,side,tables,seconds,peak_of_program_gb,largest_of_peak,mean,mean_delta_e,largest_delta_e"
    );
    for name in SAMPLES {
        let field = sample(name)?;
        let reference = Reference::new(&field, &setup, &observer, &at, &Unobserved)?;
        for side in [501, 1001] {
            let grid = TableGrid { size: side, ..TableGrid::USUAL };
            let start = Instant::now();
            let tables = Builder::new(&field, &setup, grid, Series::Chebyshev, &observer, &at, &Unobserved)?
                .tables(&Unobserved)?;
            let seconds = start.elapsed().as_secs_f64();
            for polar in [0.0, 45.0] {
                let e = table_errors(&reference, &tables, direction(polar, 20.0), 61);
                println!(
                    "{name},{:.3},{side},{},{seconds:.1},{:.2},{:.1e},{:.1e},{:.2},{:.1}",
                    2.0 * field.reach_um(),
                    tables.basis().count(),
                    peak_memory().unwrap_or(0) as f64 * 1e-9,
                    e.largest_of_peak,
                    e.mean,
                    e.mean_delta_e,
                    e.largest_delta_e
                );
            }
        }
    }
    println!("\nseries alone, at places of the grid: largest |ΔY| of the reference there");
    println!("sample,series,tables,largest_relative_error");
    for name in SAMPLES {
        let field = sample(name)?;
        let reference = Reference::new(&field, &setup, &observer, &at, &Unobserved)?;
        let series = [6, 10, 15, 20, 25, 30].map(Series::Taylor).into_iter().chain([Series::Chebyshev]);
        for series in series {
            let grid = TableGrid { size: 41, exponent: 3.0 };
            let builder = Builder::new(&field, &setup, grid, series, &observer, &at, &Unobserved)?;
            println!(
                "{name},{series:?},{},{:.1e}",
                builder.basis().count(),
                at_places(&reference, &builder, grid)
            );
        }
    }
    println!("\nperiods by the first order, light from 75°, 380 … 780 nm");
    println!("sample,expected_um,mean_nm,variance_nm2");
    let relative = Setup { normalization: Normalization::Relative, ..setup };
    for (name, expected, turned) in [
        ("blazed", 2.5, false),
        ("sinusoid", 2.5, false),
        ("elaphe", 1.14, false),
        ("xenopeltis", 1.444, true),
    ] {
        let field = if turned { sample(name)?.turned() } else { sample(name)? };
        let periods = recovered_periods(&field, &relative, expected, &at, &Unobserved)?;
        let count = periods.len() as f64;
        let mean = periods.iter().sum::<f64>() / count;
        let variance = periods.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / count;
        println!("{name},{expected},{:.3},{:.3}", 1e3 * mean, 1e6 * variance);
    }
    println!("\nenergy of a flat patch over that of a mirror, by ∫ f cosθ dω");
    println!("obliquity,0°,30°,60°,80°");
    let flat = Heightfield::new([8, 8], [65.0; 2], vec![0.0; 64])?;
    for (name, obliquity) in Obliquity::ALL {
        let setup = Setup { obliquity, place: Place::Anywhere, coherence: Coherence::USUAL, ..setup };
        let one = Wavelengths::new([550.0])?;
        let reference = Reference::new(&flat, &setup, &observer, &one, &Unobserved)?;
        let shares = [0.0, 30.0, 60.0, 80.0].map(|polar| energy(&reference, polar, setup.index));
        println!("{name},{}", shares.map(|share| format!("{share:.5}")).join(","));
    }
    Ok(())
}

fn sample(name: &str) -> Result<Heightfield> {
    Heightfield::sample(name, 1).unwrap_or_else(|| Err(barbule::Error::input("no such sample")))
}

/// Largest |ΔY|/Y at places of the grid where Y is over 1e-3 of the largest, for several w.
fn at_places(reference: &Reference, builder: &Builder, grid: TableGrid) -> f64 {
    let mut pairs = Vec::new();
    for w_i in [direction(3.0, 0.0), direction(40.0, 130.0), direction(70.0, 250.0)] {
        for (i, j) in (0..grid.size).flat_map(|i| (0..grid.size).map(move |j| (i, j))) {
            let (x, y) = (-grid.coordinate(i) - w_i.x, -grid.coordinate(j) - w_i.y);
            if let Some(w_o) = barbule::diffraction::over(glam::DVec2::new(x, y)).filter(|w_o| w_o.z > 0.1) {
                pairs.push((reference.xyz(w_i, w_o)[1], builder.xyz(w_i, w_o)[1]));
            }
        }
    }
    let peak = pairs.iter().map(|pair| pair.0).fold(0.0, f64::max);
    let seen = pairs.iter().filter(|pair| pair.0 > 1e-3 * peak);
    seen.map(|pair| (pair.1 - pair.0).abs() / pair.0).fold(0.0, f64::max)
}

fn energy(reference: &Reference, polar: f64, index: f64) -> f64 {
    let w_i = direction(polar, 0.0);
    let (half, steps) = (0.03, 200);
    let step = 2.0 * half / f64::from(steps);
    let mut sum = 0.0;
    for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
        let at = |i: i32| (f64::from(i) + 0.5) * step - half;
        if let Some(w_o) = barbule::diffraction::over(glam::DVec2::new(at(i) - w_i.x, at(j))) {
            sum += reference.spectrum(w_i, w_o)[0] * step * step;
        }
    }
    sum / barbule::fresnel::fresnel(w_i.z, index)
}
