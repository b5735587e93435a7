//! Making cross sections and casting rays through them, CPU time of the quickest of seven.
//! `cargo bench --workspace --bench geometry`

#![allow(clippy::print_stdout)] // its output is its result

use std::time::Duration;

use barbule::material::Library;
use barbule::structure::{Ray, SpeciesModel, cast, layered_species};
use cpu_time::ProcessTime;

/// Rays straight down on the top.
const RAYS: usize = 3000;

fn quickest(act: impl Fn()) -> Duration {
    let once = |_| {
        let begun = ProcessTime::now();
        act();
        begun.elapsed()
    };
    (0..7).map(once).min().unwrap_or_default()
}

fn main() {
    for name in layered_species() {
        let model = SpeciesModel::builtin(name, None, Library::builtin()).expect("a species that ships");
        let section = model.section(1, 0).expect("a section");
        let made = quickest(|| drop(model.section(1, 0)));
        let points: usize = section.boundaries.iter().map(|b| b.x_um.len()).sum::<usize>()
            + section.inclusions.iter().map(|i| i.outline.points()).sum::<usize>();
        let rays: Vec<Ray> = (0..RAYS)
            .map(|k| {
                let x_um = section.width_um * ((k as f64 + 0.5) / RAYS as f64 - 0.5);
                Ray { x_um, z_um: section.top().height(x_um), normal: [0.0, 1.0] }
            })
            .collect();
        let columns = cast(&section, &rays).expect("rays that meet layers");
        let casting = quickest(|| drop(cast(&section, &rays)));
        println!("{name}: made in {made:?}, {points} points, cast in {casting:?}, {} slots", columns.slots);
    }
}
