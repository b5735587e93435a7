//! The table of docs/numbers.md: what every shipped material keeps of its promises.
//!
//! `target/release/examples/material_numbers [PAGE.md]` (after `cargo build --release --workspace --examples`), one CPU
//! minute; with a page, the table between its markers is replaced.

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program over what tests hold

#[path = "../tests/it/measure/material.rs"]
mod material;

use barbule::brdf::{FeatherBrdf, Options};
use barbule::io::write_whole;
use barbule::math::rng::Stream;
use barbule::scattering::directions::omega;

use material::{albedos, chi_square, expected, instance_albedos, reciprocity_deviation, shipped, whiten};

/// Around the table.
const MARKERS: [&str; 2] = ["<!-- material_numbers begins -->\n", "<!-- material_numbers ends -->"];

fn main() -> barbule::Result<()> {
    let mut table = String::from(
        "| material | reciprocity deviation | albedo of instances | χ² of 20,000 samples: p at 3 directions | ∫pdf | largest albedo | white furnace | lobes | flagged | at all light | near grazing | l at the longest λ | residual: median, 95 % |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    // Each material has draws of its own: what chance does to one says nothing of another.
    for (at, (stem, _)) in (0_u64..).zip(barbule_birds::materials()) {
        let mut material = shipped(stem);
        let info = material.info.clone();
        let number = |key: &str| info[key].as_f64().unwrap_or(f64::NAN);
        let brdf = FeatherBrdf::new(&material, Options::default())?;
        let [average, spread] = instance_albedos(&brdf, 400 * at);
        let chi: Vec<_> = [(0.0_f64, 10.0_f64), (30.0, -20.0), (60.0, 70.0)]
            .into_iter()
            .map(|(theta, phi)| {
                chi_square(&brdf, omega(theta.to_radians(), phi.to_radians()), Stream::new(7, &[at]))
            })
            .collect();
        let p = chi.iter().map(|chi| format!("{:.2}", chi.p)).collect::<Vec<_>>().join(", ");
        let right = std::f64::consts::FRAC_PI_2;
        let (pilot, ends): (Vec<f64>, _) =
            ((0..101).map(|k| 0.02 * (f64::from(k) - 50.0)).collect(), [-right, right]);
        let total = expected(&brdf, omega(0.2, 0.3), [&pilot, &pilot], [&ends, &ends])[0];
        let [_, largest] = albedos(&brdf, 2000);
        whiten(&mut material);
        let [_, white] = albedos(&FeatherBrdf::new(&material, Options::default())?, 2000);
        table += &format!(
            "| {stem} | {:.3} | {average:.3} ± {spread:.3} | {p} | {total:.5} | {largest:.6} | {white:.6} | {} | {} | {} | {} | {:.3} | {:.3}, {:.3} |\n",
            reciprocity_deviation(&brdf),
            number("lobes"),
            number("flagged"),
            number("clipped"),
            number("grazing"),
            info["longest_length"][0].as_f64().unwrap_or(f64::NAN),
            number("residual_median"),
            number("residual_95"),
        );
    }
    print!("{table}");
    if let Some(page) = std::env::args().nth(1) {
        let text = std::fs::read_to_string(&page).unwrap();
        let begin = text.find(MARKERS[0]).unwrap() + MARKERS[0].len();
        let end = text.find(MARKERS[1]).unwrap();
        write_whole(
            page.as_ref(),
            format!("{}\n{table}\n{}", text[..begin].trim_end_matches('\n'), &text[end..]).as_bytes(),
        )?;
    }
    Ok(())
}
