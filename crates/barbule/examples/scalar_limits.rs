//! Where the scalar sum over heights holds: its orders beside those of Maxwell's equations, for ridges of the built-in samples' shapes. Table
//! and figure of docs/theory/diffraction.md.
//!
//! `target/release/examples/scalar_limits [-o FIGURE.svg]` (after `cargo build --release --workspace --examples`).

#![allow(clippy::print_stdout)] // a program that prints

use std::path::Path;

use barbule::io::write_whole;
use barbule::plot::{Axis, Curve, Figure, Format};
use barbule::solve::crystal::Rcwa;
use barbule::solve::diffraction::{OrderPower, RidgeOrders, ridge_orders};
use barbule::structure::{Fingers, Heightfield};
use barbule::{Error, Result};
use rayon::prelude::*;

/// Keratin.
const INDEX: f64 = 1.56;
/// Of the figure.
const WAVELENGTH_NM: f64 = 550.0;
const INCIDENCES_DEG: [f64; 3] = [0.0, 30.0, 60.0];
/// Heights along a period.
const CELLS: usize = 120;

/// A shape, by the period, µm.
type Shape = fn(f64) -> Result<Heightfield>;

fn blazed(period_um: f64) -> Result<Heightfield> {
    Heightfield::blazed(period_um, 0.24623, 1, CELLS)
}

fn sinusoid(period_um: f64) -> Result<Heightfield> {
    Heightfield::sinusoid(period_um, 0.123, 1, CELLS)
}

fn elaphe_fingers(period_um: f64) -> Result<Heightfield> {
    Fingers { pitch_um: period_um, ..Fingers::ELAPHE }.across(CELLS)
}

fn fingers(period_um: f64) -> Result<Heightfield> {
    Fingers { pitch_um: period_um, ..Fingers::XENOPELTIS }.across(CELLS)
}

fn rows(period_um: f64) -> Result<Heightfield> {
    Fingers { row_um: period_um, ..Fingers::XENOPELTIS }.along(CELLS)
}

/// The samples with their periods, µm.
const SAMPLES: [(&str, Shape, f64); 5] = [
    ("blazed", blazed, 2.5),
    ("sinusoid", sinusoid, 2.5),
    ("elaphe fingers", elaphe_fingers, 1.14),
    ("xenopeltis rows", rows, 1.45),
    ("xenopeltis fingers", fingers, 0.54),
];

/// Shapes whose periods the figure changes.
const SHAPES: [(&str, Shape); 3] = [
    ("blazed, 0.25 µm deep", blazed),
    ("sinusoid, 0.25 µm deep", sinusoid),
    ("fingers, 0.07 µm high", fingers),
];

fn orders(period: &Heightfield, wavelength_nm: f64, incidence_deg: f64) -> Result<RidgeOrders> {
    let waves = period.size_um()[0] / (1e-3 * wavelength_nm);
    let solver = Rcwa { orders: 16 + (3.0 * waves) as usize, slices: 24, estimate: true };
    ridge_orders(period, INDEX, wavelength_nm, incidence_deg.to_radians(), &solver)
}

fn table() -> Result<()> {
    println!(
        "sample,period_um,wavelength_nm,incidence_deg,scalar,exact,misplaced,misplaced_along,misplaced_across,\
         brightest,its_scalar_along,its_scalar_across,its_exact_along,its_exact_across,uncertainty"
    );
    for (name, shape, period_um) in SAMPLES {
        let field = shape(period_um)?;
        let waves: Vec<[f64; 2]> =
            [450.0, 550.0, 650.0].into_iter().flat_map(|nm| INCIDENCES_DEG.map(|deg| [nm, deg])).collect();
        let found: Vec<RidgeOrders> =
            waves.par_iter().map(|[nm, deg]| orders(&field, *nm, *deg)).collect::<Result<_>>()?;
        for ([nm, deg], found) in waves.iter().zip(found) {
            let [scalar, exact] = found.whole(OrderPower::unpolarized);
            let sideways = found.orders.iter().filter(|order| order.m != 0);
            let brightest = sideways.max_by(|a, b| a.unpolarized()[1].total_cmp(&b.unpolarized()[1]));
            let of_it = brightest.map_or_else(
                || ",,,,".to_owned(),
                |OrderPower { m, scalar: [a, b], exact: [c, d], .. }| {
                    format!("{m},{a:.5},{b:.5},{c:.5},{d:.5}")
                },
            );
            println!(
                "{name},{period_um},{nm},{deg},{scalar:.5},{exact:.5},{:.3},{:.3},{:.3},{of_it},{:.0e}",
                found.misplaced(OrderPower::unpolarized),
                found.misplaced(|order| order.polarized(0)),
                found.misplaced(|order| order.polarized(1)),
                found.uncertainty
            );
        }
    }
    Ok(())
}

/// Misplaced light against the period over the wavelength.
fn figure() -> Result<Figure> {
    let mut figure = Figure::new(
        "Light that the scalar sum puts into wrong orders",
        Axis::logarithmic("period over the wavelength"),
        Axis::logarithmic("part of all reflected light, unpolarized"),
    );
    for (name, shape) in SHAPES {
        for deg in [0.0, 60.0] {
            let points = (0..=24)
                .into_par_iter()
                .map(|i| {
                    let ratio = 0.6 * 20.0_f64.powf(f64::from(i) / 24.0);
                    Ok([
                        ratio,
                        orders(&shape(ratio * 1e-3 * WAVELENGTH_NM)?, WAVELENGTH_NM, deg)?
                            .misplaced(OrderPower::unpolarized),
                    ])
                })
                .collect::<Result<_>>()?;
            figure.curves.push(Curve::line(format!("{name}, {deg}°"), points));
        }
    }
    let note = format!("Ridges of n = {INDEX} at {WAVELENGTH_NM} nm against Fourier modes");
    figure.footnote = Some(note);
    Ok(figure)
}

fn main() -> Result<()> {
    table()?;
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|argument| argument == "-o") {
        let path = arguments.get(at + 1).ok_or_else(|| Error::input("give a file after -o"))?;
        let path = Path::new(path);
        write_whole(path, &figure()?.draw().encode(Format::of(path)?, &[])?)?;
    }
    Ok(())
}
