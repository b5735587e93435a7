//! A film's numbers for people, tables and programs.

use std::fmt::Write as _;

use barbule::Complex64;
use barbule::film::{FilmTables, Sweep};
use barbule::spectrum::colour::held;
use serde_json::{Value, json};

use super::{Found, Looks};
use crate::peak_args::notes;

/// The contract's JSON; `absorbed_per_layer` is `{"s": [layer][angle][wavelength], "p": …}`.
pub(super) fn document(found: &Found, looks: &[Looks], layers: usize) -> Value {
    let Found { mean, angle_deg, spread } = found;
    let columns = mean.at.len();
    let rows = |values: &[f64]| values.chunks_exact(columns).map(|row| json!(row)).collect::<Vec<_>>();
    let complex = |values: &[Complex64]| {
        let row = |row: &[Complex64]| row.iter().map(|z| json!([z.re, z.im])).collect::<Vec<_>>();
        values.chunks_exact(columns).map(row).collect::<Vec<_>>()
    };
    let per_layer = |t: &FilmTables| {
        let size = t.absorbed_per_layer.len() / layers.max(1);
        t.absorbed_per_layer.chunks_exact(size.max(1)).map(rows).collect::<Vec<_>>()
    };
    let look = |look: &Looks| json!({"angle_deg": look.angle_deg, "unpolarized": look.unpolarized, "s": look.s, "p": look.p});
    let [s, p] = &mean.polarization;
    let mut document = json!({
        "wavelength_nm": mean.at.nm(),
        "angle_deg": angle_deg,
        "r_s": complex(&s.r), "r_p": complex(&p.r),
        "R_s": rows(&s.reflected), "R_p": rows(&p.reflected),
        "T_s": rows(&s.transmitted), "T_p": rows(&p.transmitted),
        "A_s": rows(&s.absorbed), "A_p": rows(&p.absorbed),
        "R": rows(&mean.unpolarized()),
        "absorbed_per_layer": { "s": per_layer(s), "p": per_layer(p) },
        "looks": looks.iter().map(look).collect::<Vec<_>>(),
    });
    if let Some(spread) = spread {
        let [s, p] = &spread.std;
        document["instances"] = spread.individuals.into();
        document["std"] = json!({
            "R_s": rows(&s.reflected), "R_p": rows(&p.reflected),
            "T_s": rows(&s.transmitted), "T_p": rows(&p.transmitted),
            "A_s": rows(&s.absorbed), "A_p": rows(&p.absorbed),
            "R": rows(&spread.unpolarized),
        });
    }
    document
}

/// The names of the parts of the power.
const PARTS: [&str; 6] = ["R_s", "R_p", "T_s", "T_p", "A_s", "A_p"];

/// The parts of the power at a place of the tables, in the order of [`PARTS`].
fn parts(mean: &Sweep, i: usize) -> [f64; 6] {
    let [s, p] = &mean.polarization;
    [&s.reflected, &p.reflected, &s.transmitted, &p.transmitted, &s.absorbed, &p.absorbed].map(|part| part[i])
}

/// Angle, wavelength and place in the tables, in order of angle then wavelength.
fn points(found: &Found) -> impl Iterator<Item = (f64, f64, usize)> {
    let at = &found.mean.at;
    (0..found.angle_deg.len() * at.len()).map(|i| (found.angle_deg[i / at.len()], at[i % at.len()], i))
}

pub(super) fn csv(found: &Found) -> String {
    let mut text = format!("angle_deg,wavelength_nm,{},R,T,A", PARTS.join(","));
    if found.spread.is_some() {
        text += &PARTS.map(|part| format!(",{part}_std")).concat();
        text += ",R_std";
    }
    for (angle, nm, i) in points(found) {
        let parts = parts(&found.mean, i);
        let means = [0, 2, 4].map(|k| 0.5 * (parts[k] + parts[k + 1]));
        let mut cells = [&parts[..], &means[..]].concat();
        if let Some(spread) = &found.spread {
            let [s, p] = &spread.std;
            cells.extend([&s.reflected, &p.reflected, &s.transmitted, &p.transmitted].map(|std| std[i]));
            cells.extend([s.absorbed[i], p.absorbed[i], spread.unpolarized[i]]);
        }
        // Writing to a String cannot fail, here and below.
        let _ = write!(text, "\n{angle},{nm}");
        cells.iter().for_each(|cell| _ = write!(text, ",{cell}"));
    }
    text + "\n"
}

pub(super) fn table(found: &Found) -> String {
    let mut text = format!("{:>9} {:>8}", "angle (°)", "λ (nm)");
    for name in PARTS.into_iter().chain(["R"]).chain(found.spread.as_ref().map(|_| "R std")) {
        let _ = write!(text, " {name:>8}");
    }
    for (angle, nm, i) in points(found) {
        let _ = write!(text, "\n{angle:>9} {nm:>8}");
        let parts = parts(&found.mean, i);
        let spread = found.spread.as_ref().map(|spread| spread.unpolarized[i]);
        for part in parts.into_iter().chain([0.5 * (parts[0] + parts[1])]).chain(spread) {
            // Rounding noise below zero is no number to show.
            let _ = write!(text, " {:>8.5}", if part.abs() < 5e-6 { 0.0 } else { part });
        }
    }
    text
}

/// A line for each angle's colour in unpolarized light, then what people should know of them.
pub(super) fn words(found: &Found, looks: &[Looks]) -> Vec<String> {
    let one = |look: &Looks| format!("{}°, unpolarized: {}", look.angle_deg, look.unpolarized.words());
    let mut lines: Vec<String> = looks.iter().map(one).collect();
    if let Some(spread) = &found.spread {
        lines.push(format!("means over {} random individuals", spread.individuals));
    }
    let unpolarized: Vec<_> = looks.iter().map(|look| look.unpolarized.clone()).collect();
    lines.extend(notes(&found.angle_deg, &unpolarized));
    lines.extend(held(&found.mean.at).filter(|_| !looks.is_empty()));
    lines
}
