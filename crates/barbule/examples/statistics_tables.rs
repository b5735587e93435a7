//! Tables and figure of docs/theory/statistics.md: what single barbules of each species do.
//!
//! `target/release/examples/statistics_tables [FIGURE.png]` (after `cargo build --release --workspace --examples`), two CPU
//! minutes; with a name it draws the quantiles of the fields against normal ones (docs/figures/qq.png).

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program over what tests hold

#[path = "../tests/it/measure/speckle.rs"]
mod speckle;

use std::path::Path;

use barbule::plot::{Axis, Curve, Drawing, Figure, Format, Ink, Stroke};
use barbule::structure::species_names;
use num_complex::Complex64;

use speckle::{Species, contrasts, correlations, fitted, moments, simulate, speckle, synthesized};

/// Barbules that contrasts are held against.
const OTHERS: usize = 400;

fn main() -> barbule::Result<()> {
    let species: Vec<Species> = species_names().map(simulate).collect();
    println!(
        "| species | rejected at 1 %, steep | oblique | σ_R/σ_I, steep | oblique | V/U at φ_i = 0°, 46°, 70°, 84° |"
    );
    for one in &species {
        let found = speckle(one);
        let [steep, oblique] = found.rejected.map(|share| 100.0 * share);
        let [near, far] = found.ratio.map(|[median, low, high]| format!("{median:.3} ({low:.2}–{high:.2})"));
        let v = found.steady.map(|v| format!("{v:.3}")).join(", ");
        println!("| {} | {steep:.1} % | {oblique:.1} % | {near} | {far} | {v} |", one.name);
    }
    println!(
        "\n| species | median of \\|φ_eff − φ_i\\| | largest | F at grazing over the next | m₁/m₂ | \\|φ₁ − φ₂\\| | l₁/l₂ |"
    );
    for one in &species {
        let found = fitted(one);
        let ([median, largest], [m, phi, l]) = (found.apart_deg, found.polarizations);
        println!(
            "| {} | {median:.2}° | {largest:.1}° | {:.2} | {m:.3} | {phi:.2}° | {l:.3} |",
            one.name, found.grazing
        );
    }
    println!(
        "\n| species | contrast | largest difference | about the mirror direction | shoulders | wings | correlation of polarizations | ρ | longest length |"
    );
    let mut lengths = Vec::new();
    for one in &species {
        let found = synthesized(one);
        let pair = |[a, b]: [f64; 2]| format!("{a:.3} / {b:.3}");
        let (contrast, correlation) = (pair(found.contrast), pair(found.correlation));
        println!(
            "| {} | {contrast} | {:.2} | {} | {correlation} | {:.3} | {:.3} |",
            one.name,
            found.contrast_apart,
            found.regions.map(pair).join(" | "),
            found.energy,
            found.longest_length
        );
        let cells: Vec<String> =
            found.lengths.iter().flatten().map(|[a, b]| format!("{a:.4} / {b:.4}")).collect();
        lengths.push(format!("| {} | {} |", one.name, cells.join(" | ")));
    }
    println!(
        "\n| 1/e lengths of | fields, 400 nm | intensities | fields, 694 nm | intensities | fields, 400 nm, 46° | intensities |\n{}",
        lengths.join("\n")
    );
    println!(
        "\n| species | two wavelengths, mirror direction: simulated / published / now | apart | over the lobe | apart | two lights | apart |"
    );
    for one in &species {
        let [published, now] = correlations(one);
        let cells: Vec<String> =
            [(published.mirror, now.mirror), (published.lobe, now.lobe), (published.turned, now.turned)]
                .iter()
                .map(|([simulated, before, apart_before], [_, after, apart])| {
                    format!("{simulated:.2} / {before:.2} / {after:.2} | {apart_before:.2} → {apart:.2}")
                })
                .collect();
        println!("| {} | {} |", one.name, cells.join(" | "));
    }
    println!(
        "\n| species | contrast, {OTHERS} barbules / material of 50 | apart, mean | most | where: nm, cosθ_i, φ_i, from the mirror direction | those 50 themselves, mean | most |\n| --- | --- | --- | --- | --- | --- | --- |"
    );
    for one in &species {
        let found = contrasts(one, OTHERS);
        let ([a, b], [most, x, y], [nm, cosine, phi, offset]) = (found.mean, found.farthest, found.at);
        println!(
            "| {} | {a:.3} / {b:.3} | {:.3} | {most:.2} ({x:.2} / {y:.2}) | {nm}, {cosine}, {phi:.0}°, {offset:+}° | {:.3} | {:.2} |",
            one.name, found.apart, found.sampled, found.farthest_sampled
        );
    }
    std::env::args().nth(1).map_or(Ok(()), |path| quantiles(&species, Path::new(&path)))
}

/// Quantiles of the fields' parts against normal ones.
fn quantiles(species: &[Species], path: &Path) -> barbule::Result<()> {
    let mut page = Drawing::new(0.0, 0.0);
    for (number, species) in species.iter().enumerate() {
        let mut figure = Figure::new(
            species.name,
            Axis::with_range("normal quantile", -4.0, 4.0),
            Axis::with_range("R and I over their deviation", -4.0, 4.0),
        );
        figure.size = [260.0, 260.0];
        let line = Some(Stroke::solid(Ink::of([150, 150, 150]), 2.4));
        figure.curves.push(Curve { stroke: line, ..Curve::line("normal", vec![[-4.0, -4.0], [4.0, 4.0]]) });
        for (label, steep) in [("steep", true), ("oblique", false)] {
            let mut values = Vec::new();
            for (_, samples) in species.samples().filter(|(node, _)| species.is_steep(*node) == steep) {
                for sample in samples.iter().step_by(4) {
                    for part in [|v: &Complex64| v.re, |v: &Complex64| v.im] {
                        let parts: Vec<f64> = sample.iter().map(part).collect();
                        let (mean, deviation) = moments(&parts);
                        values.extend(parts.iter().map(|v| (v - mean) / deviation));
                    }
                }
            }
            values.sort_by(f64::total_cmp);
            let normal = statrs::distribution::Normal::standard();
            let points = (0..400).map(|k| {
                let share = (f64::from(k) + 0.5) / 400.0;
                let quantile = statrs::distribution::ContinuousCDF::inverse_cdf(&normal, share);
                [quantile, values[(share * values.len() as f64) as usize]]
            });
            figure.curves.push(Curve::line(label, points.collect()));
        }
        let chart = figure.draw();
        let (width, height) = (chart.width, chart.height);
        let (column, row) = ((number % 2) as f64, (number / 2) as f64);
        page.place(chart, [column * width, row * height]);
        (page.width, page.height) = (2.0 * width, 2.0 * height);
    }
    barbule::io::write_whole(path, &page.encode(Format::Png, &[])?)
}
