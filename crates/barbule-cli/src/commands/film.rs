//! `barbule film`: what flat layers reflect, transmit and absorb.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::io::read_stack;
use barbule::material::Library;
use barbule::plot::{Axis, Curve, Drawing, Figure, HeatMap};
use barbule::solve::film::{self, FilmTables, Sweep};
use barbule::spectrum::Wavelengths;
use barbule::spectrum::colour::{Observer, chromaticity, display, held};
use barbule::structure::stack::Stack;
use barbule::{Complex64, Error, Result};
use serde_json::{Value, json};

use crate::common::{Common, print, print_json};
use crate::progress::Terminal;
use crate::provenance::{Provenance, check_outputs};
use crate::sets;

/// What a sweep may take in memory unless `--memory` says otherwise.
const USUAL_MEMORY: u64 = 4 << 30;

/// Arguments of `barbule film`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  barbule film 'air/6*(melanin:99/keratin:100)/keratin' --angles 0,30,60 -o film.svg"
)]
pub(crate) struct Args {
    /// A stack, as in 'air/keratin:595/air', or a TOML file
    stack: String,
    /// Wavelengths in nm: 520, or 400,442,484, or 400:694:6
    #[arg(long, value_name = "SET", default_value = "400:694:6", value_parser = sets::wavelength_set)]
    wavelengths: Wavelengths,
    /// Angles from the normal in the first medium in degrees
    #[arg(long, value_name = "SET", default_value = "0", allow_hyphen_values = true,
        value_parser = |text: &str| sets::angles("--angles", text))]
    angles: sets::Angles,
    /// Draw a figure: .svg or .png
    #[arg(short, long, value_name = "FIG")]
    output: Option<PathBuf>,
    /// Write a table: angle_deg,wavelength_nm,R_s,R_p,T_s,T_p,A_s,A_p
    #[arg(long, value_name = "F")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let (at, angle_deg) = (&self.wavelengths, &self.angles.0[..]);
        check_outputs(self.output.as_deref(), self.csv.as_deref())?;
        let stack = read(&self.stack, &self.common.library()?)?;
        let allowed = self.common.memory.unwrap_or(USUAL_MEMORY);
        let needed = film::bytes(stack.layers(), at.len(), angle_deg.len());
        if needed > allowed {
            return Err(Error::input(format!(
                "{} wavelengths at {} angles through {} layers need {} MB of memory, but {} MB are allowed; give fewer, or raise --memory",
                at.len(),
                angle_deg.len(),
                stack.layers(),
                needed / 1_000_000,
                allowed / 1_000_000
            )));
        }
        self.common.explain(&format!(
            "{} layers, {} wavelengths, {} angles",
            stack.layers(),
            at.len(),
            angle_deg.len()
        ));
        let angle: Vec<f64> = angle_deg.iter().map(|a| a.to_radians()).collect();
        let found = film::sweep(&stack, at, &angle, &Terminal::new(&self.common))?;
        let provenance = Provenance::new(&self.common);
        if let Some(path) = &self.output {
            provenance.write_figure(path, &figure(&self.stack, &found, angle_deg))?;
        }
        if let Some(path) = &self.csv {
            provenance.write_csv(path, &csv(&found, angle_deg))?;
        }
        if self.common.json {
            return print_json(out, &document(&found, angle_deg, stack.layers()));
        }
        if self.output.is_none() && self.csv.is_none() {
            return print(out, &table(&found, angle_deg));
        }
        Ok(())
    }
}

/// A stack from the stack language or, where the text ends in `.toml`, from that file.
fn read(text: &str, library: &Library) -> Result<Stack> {
    let path = Path::new(text);
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        return read_stack(path, library);
    }
    Stack::parse(text, library).map_err(|error| {
        if path.exists() {
            return Error::input(format!(
                "{text}: is not a stack; files with stacks are TOML and end in .toml"
            ));
        }
        error
    })
}

/// The contract's JSON; `absorbed_per_layer` is `{"s": [layer][angle][wavelength], "p": …}`.
fn document(found: &Sweep, angle_deg: &[f64], layers: usize) -> Value {
    let columns = found.at.len();
    let rows = |values: &[f64]| values.chunks_exact(columns).map(|row| json!(row)).collect::<Vec<_>>();
    let complex = |values: &[Complex64]| {
        let row = |row: &[Complex64]| row.iter().map(|z| json!([z.re, z.im])).collect::<Vec<_>>();
        values.chunks_exact(columns).map(row).collect::<Vec<_>>()
    };
    let per_layer = |t: &FilmTables| {
        let size = t.absorbed_per_layer.len() / layers.max(1);
        t.absorbed_per_layer.chunks_exact(size.max(1)).map(rows).collect::<Vec<_>>()
    };
    let [s, p] = &found.polarization;
    json!({
        "wavelength_nm": found.at.nm(),
        "angle_deg": angle_deg,
        "r_s": complex(&s.r), "r_p": complex(&p.r),
        "R_s": rows(&s.reflected), "R_p": rows(&p.reflected),
        "T_s": rows(&s.transmitted), "T_p": rows(&p.transmitted),
        "A_s": rows(&s.absorbed), "A_p": rows(&p.absorbed),
        "absorbed_per_layer": { "s": per_layer(s), "p": per_layer(p) },
    })
}

/// Angle, wavelength and the six parts of the power, in order of angle then wavelength.
fn points<'a>(found: &'a Sweep, angle_deg: &'a [f64]) -> impl Iterator<Item = (f64, f64, [f64; 6])> + 'a {
    let [s, p] = &found.polarization;
    let parts = [&s.reflected, &p.reflected, &s.transmitted, &p.transmitted, &s.absorbed, &p.absorbed];
    let columns = found.at.len();
    (0..angle_deg.len() * columns)
        .map(move |i| (angle_deg[i / columns], found.at[i % columns], parts.map(|part| part[i])))
}

fn csv(found: &Sweep, angle_deg: &[f64]) -> String {
    let mut text = String::from("angle_deg,wavelength_nm,R_s,R_p,T_s,T_p,A_s,A_p\n");
    for (angle, nm, parts) in points(found, angle_deg) {
        // Writing to a String cannot fail, here and below.
        let _ = writeln!(text, "{angle},{nm},{}", parts.map(|v| v.to_string()).join(","));
    }
    text
}

fn table(found: &Sweep, angle_deg: &[f64]) -> String {
    let mut text = format!("{:>9} {:>8}", "angle (°)", "λ (nm)");
    for name in ["R_s", "R_p", "T_s", "T_p", "A_s", "A_p"] {
        let _ = write!(text, " {name:>8}");
    }
    for (angle, nm, parts) in points(found, angle_deg) {
        let _ = write!(text, "\n{angle:>9} {nm:>8}");
        for part in parts {
            // Rounding noise below zero is no number to show.
            let _ = write!(text, " {:>8.5}", if part.abs() < 5e-6 { 0.0 } else { part });
        }
    }
    // Fewer samples make no colour.
    if found.at.len() >= 10 {
        let weights = Observer::default().weights(&found.at);
        for (row, angle) in found.unpolarized().chunks_exact(found.at.len()).zip(angle_deg) {
            let [r, g, b] = display(weights.linear_rgb(row));
            let xyz = weights.xyz(row);
            let [x, y] = chromaticity(xyz);
            let _ = write!(
                text,
                "\ncolour at {angle}°, unpolarized under D65: #{r:02x}{g:02x}{b:02x} in sRGB (clipped), x {x:.4}, y {y:.4}, Y {:.4}",
                xyz[1]
            );
        }
        if let Some(note) = held(&found.at) {
            let _ = write!(text, "\n{note}");
        }
    }
    text
}

/// Curves against wavelength, or against angle at one wavelength, or a map when there are many angles.
fn figure(stack: &str, found: &Sweep, angle_deg: &[f64]) -> Drawing {
    let columns = found.at.len();
    let title: String = stack.chars().take(70).collect();
    let [s, p] = &found.polarization;
    let parts: [(&str, &[f64]); 6] = [
        ("R, s", &s.reflected),
        ("R, p", &p.reflected),
        ("T, s", &s.transmitted),
        ("T, p", &p.transmitted),
        ("A, s", &s.absorbed),
        ("A, p", &p.absorbed),
    ];
    let wavelength = || Axis::new("wavelength in vacuum (nm)");
    let spectrum = |values: &[f64], a: usize| {
        found.at.iter().zip(&values[a * columns..]).map(|(&x, &y)| [x, y]).collect::<Vec<_>>()
    };
    if columns == 1 && angle_deg.len() > 1 {
        let mut chart =
            Figure::new(title, Axis::new("angle from the normal (°)"), Axis::new("part of the power"));
        for (name, values) in parts {
            let mut points: Vec<_> = angle_deg.iter().zip(values).map(|(&x, &y)| [x, y]).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            chart.curves.push(Curve::line(name, points));
        }
        chart.legend = format!("{} nm", found.at[0]);
        return chart.draw();
    }
    if angle_deg.len() > 16 {
        return map(title, found, angle_deg).draw();
    }
    let mut chart = Figure::new(title, wavelength(), Axis::new("part of the power"));
    match angle_deg.len() {
        1 => {
            let normal = angle_deg[0] == 0.0;
            let chosen = parts.iter().step_by(if normal { 2 } else { 1 });
            for (name, values) in chosen {
                let name = if normal { &name[..1] } else { name };
                chart.curves.push(Curve::line(name, spectrum(values, 0)));
            }
            chart.legend = format!("{}°", angle_deg[0]);
        }
        2..=4 => {
            chart.y.label = "reflectance".into();
            for (a, angle) in angle_deg.iter().enumerate() {
                chart.curves.push(Curve::line(format!("{angle}°, s"), spectrum(&s.reflected, a)));
                chart.curves.push(Curve::line(format!("{angle}°, p"), spectrum(&p.reflected, a)));
            }
        }
        _ => {
            chart.y.label = "reflectance, unpolarized".into();
            let mean = found.unpolarized();
            for (a, angle) in angle_deg.iter().enumerate() {
                chart.curves.push(Curve::line(format!("{angle}°"), spectrum(&mean, a)));
            }
        }
    }
    chart.draw()
}

/// Unpolarized reflectance against wavelength and angle; each cell shows the nearest computed point.
fn map(title: String, found: &Sweep, angle_deg: &[f64]) -> HeatMap {
    const CELLS: [usize; 2] = [420, 330];
    let columns = found.at.len();
    let mean = found.unpolarized();
    let mut order: Vec<usize> = (0..angle_deg.len()).collect();
    order.sort_by(|a, b| angle_deg[*a].total_cmp(&angle_deg[*b]));
    let angles: Vec<f64> = order.iter().map(|a| angle_deg[*a]).collect();
    let (low, high) = (angles[0], angles[angles.len() - 1]);
    let (first, last) = found.at.range_nm();
    let nearest = |sorted: &[f64], value: f64| {
        let after = sorted.partition_point(|v| *v < value).min(sorted.len() - 1);
        if after > 0 && value - sorted[after - 1] < sorted[after] - value { after - 1 } else { after }
    };
    let middle =
        |i: usize, cells: usize, from: f64, to: f64| from + (to - from) * (i as f64 + 0.5) / cells as f64;
    let across: Vec<usize> =
        (0..CELLS[0]).map(|i| nearest(&found.at, middle(i, CELLS[0], first, last))).collect();
    let mut values = Vec::with_capacity(CELLS[0] * CELLS[1]);
    for j in 0..CELLS[1] {
        let row = order[nearest(&angles, middle(j, CELLS[1], low, high))] * columns;
        values.extend(across.iter().map(|column| mean[row + column]));
    }
    let x = Axis::with_range("wavelength in vacuum (nm)", first, last);
    let y = Axis::with_range("angle from the normal (°)", low, high);
    let mut map = HeatMap::new(title, x, y, CELLS[0], values);
    map.label = "reflectance, unpolarized".into();
    map
}
