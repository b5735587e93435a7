//! Tables of docs/theory/simulation.md: the fast simulation of layers and crystals against energy
//! and its references.
//!
//! `target/release/examples/simulation_tables` (after `cargo build --release --workspace --examples`), 15 CPU seconds.

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program over what tests hold

#[path = "../tests/it/measure"]
mod measure {
    pub(crate) mod crystals;
    pub(crate) mod fields;
    pub(crate) mod simulation;
}

use measure::crystals;
use measure::simulation::{self as layers, ROUGHNESSES, mean, mirror_energy};

fn main() {
    println!("| roughness | φ_i ≤ 45°: mean of 50 | extremes | 50° | 60° | 70° | 80° (mean, largest) |");
    for row in ROUGHNESSES {
        let (tau, height, width, name) = row;
        let found = mirror_energy(row);
        let steep = found.steep();
        let low = steep.iter().copied().fold(f64::MAX, f64::min);
        let high = steep.iter().copied().fold(0.0, f64::max);
        let cells: Vec<String> = found.oblique().iter().map(|[m, h]| format!("{m:.3}, {h:.3}")).collect();
        println!(
            "| {name}: τ {tau}, ±{height}, W {width} | {:.4} (worst angle {:.4}) | {low:.4}–{high:.4} | {} |",
            mean(&steep),
            found.worst_mean(),
            cells.join(" | ")
        );
    }
    let [worst, below] = layers::largest_reflected();
    println!("\nlargest Φ_r/Φ_i over layers with cosθ cosφ ≥ 0.1: {worst:?}, below: {below:?}");
    println!("largest Φ_r/Φ_i over crystals: {:?}", crystals::largest_reflected());
    let kinds = [
        ("layers", layers::plain_errors(), layers::converged_errors()),
        ("crystals", crystals::plain_errors(), crystals::converged_errors()),
    ];
    for (kind, [field, power], converged) in kinds {
        println!("\n{kind}, double precision against plain (field, power): {field:.1e} {power:.1e}");
        println!("{kind}, campaigns against converged fields (field, power):");
        for (name, [field, power]) in converged {
            println!("{name}: {field:.1e} {power:.1e}");
        }
    }
}
