//! The tables of `barbule spectrum --csv`: one line for each wavelength, or one for each wavelength of each curve.

use std::fmt::Write as _;

use barbule::io::measured::{Measured, Measurements};
use barbule::spectrum::Spectrum;

use super::Found;
use super::instrument::{Row, front};
use crate::provenance::csv_cell;

/// What a table is of.
pub(super) struct Tables<'a> {
    pub(super) all: &'a [Found],
    pub(super) rows: &'a [Row],
    /// What each row is called.
    pub(super) names: &'a [String],
    pub(super) nm: &'a [f64],
    pub(super) measured: Option<&'a Measurements>,
}

impl Tables<'_> {
    /// A line for each angle and wavelength, with a column for each curve; of several structures with their names in
    /// front. Measured curves are taken at the simulated wavelengths, and empty beyond their own.
    pub(super) fn wide(&self) -> String {
        let most = self.all.iter().filter_map(|found| found.individuals.as_ref()).map(|i| i.count()).max();
        // As many as at the angle that has the most.
        let counts = self.measured.iter().flat_map(|m| &m.angles).map(|at| at.measured.samples.len());
        let samples = most.and(counts.max()).unwrap_or(0);
        let mut text = String::from(if self.all.len() > 1 { "structure," } else { "" });
        let (header, front) = front(self.rows);
        push(&mut text, format_args!("{header}angle_deg,wavelength_nm,mean,std"));
        if let Some(most) = most {
            text.push_str(",standard_error");
            (1..=most).for_each(|i| push(&mut text, format_args!(",individual_{i}")));
        }
        if self.measured.is_some() {
            text.push_str(",measured_mean,measured_std");
            (1..=samples).for_each(|i| push(&mut text, format_args!(",measured_{i}")));
        }
        text.push('\n');
        for found in self.all {
            let name = if self.all.len() > 1 { csv_cell(&found.typed) + "," } else { String::new() };
            for (a, Row { angle_deg, .. }) in self.rows.iter().enumerate() {
                let front = &front[a];
                let measured = self.measured.and_then(|measured| measured.at(*angle_deg));
                let measured_std = measured.and_then(std_of);
                for (w, nm) in self.nm.iter().enumerate() {
                    let (mean, std) = (found.spectra.mean[a][w], found.spectra.std[a][w]);
                    push(&mut text, format_args!("{name}{front}{angle_deg},{nm},{mean},{std}"));
                    if let (Some(most), Some(individuals)) = (most, &found.individuals) {
                        push(&mut text, format_args!(",{}", cell(standard_error(std, found.instances))));
                        let of = |i| (i < individuals.count()).then(|| individuals.of(i, a)[w]);
                        (0..most).for_each(|i| push(&mut text, format_args!(",{}", cell(of(i)))));
                    }
                    if self.measured.is_some() {
                        let mean = measured.and_then(|measured| measured.mean.value(*nm));
                        let std = measured_std.as_ref().and_then(|std| std.value(*nm));
                        let sample = |i: usize| measured.and_then(|m| m.samples.get(i)?.spectrum.value(*nm));
                        for value in [mean, std].into_iter().chain((0..samples).map(sample)) {
                            push(&mut text, format_args!(",{}", cell(value)));
                        }
                    }
                    text.push('\n');
                }
            }
        }
        text
    }

    /// A line for each wavelength of each curve: means with their spread, individuals by their numbers from 1, and what was
    /// measured, by its samples' names and at its own wavelengths.
    pub(super) fn tidy(&self) -> String {
        let (header, front) = front(self.rows);
        let mut text = format!(
            "structure,{header}angle_deg,source,curve,sample,wavelength_nm,reflectance,std,standard_error\n"
        );
        let nothing = ",".repeat(header.matches(',').count());
        for found in self.all {
            let name = csv_cell(&found.typed);
            for (a, Row { angle_deg, .. }) in self.rows.iter().enumerate() {
                let angle = format!("{}{angle_deg}", front[a]);
                for (w, nm) in self.nm.iter().enumerate() {
                    let (mean, std) = (found.spectra.mean[a][w], found.spectra.std[a][w]);
                    let error = cell(standard_error(std, found.instances));
                    push(
                        &mut text,
                        format_args!("{name},{angle},simulated,mean,,{nm},{mean},{std},{error}\n"),
                    );
                }
                let Some(individuals) = &found.individuals else { continue };
                for i in 0..individuals.count() {
                    for (nm, value) in self.nm.iter().zip(individuals.of(i, a)) {
                        let i = i + 1;
                        push(
                            &mut text,
                            format_args!("{name},{angle},simulated,individual,{i},{nm},{value},,\n"),
                        );
                    }
                }
            }
        }
        for at in self.measured.iter().flat_map(|measured| &measured.angles) {
            let (measured, angle) = (&at.measured, format!("{nothing}{}", cell(at.angle_deg)));
            for (w, (nm, mean)) in points(&measured.mean).enumerate() {
                let std = measured.std.as_ref().map(|std| std[w]);
                let error = cell(std.and_then(|std| standard_error(std, measured.samples.len())));
                push(&mut text, format_args!(",{angle},measured,mean,,{nm},{mean},{},{error}\n", cell(std)));
            }
            for (number, sample) in measured.samples.iter().enumerate() {
                let name =
                    if sample.name.is_empty() { (number + 1).to_string() } else { csv_cell(&sample.name) };
                for (nm, value) in points(&sample.spectrum) {
                    push(&mut text, format_args!(",{angle},measured,individual,{name},{nm},{value},,\n"));
                }
            }
        }
        text
    }
}

impl Tables<'_> {
    /// A line for each wavelength with a column in percent for each curve, as spectrometers' programs deliver them: of individuals
    /// where they are asked for, else of their mean. Names say percent, so that `--measured` reads it as what it is.
    pub(super) fn spectrometer(&self) -> String {
        let mut text = String::from("wavelength_nm");
        let mut columns: Vec<&[f64]> = Vec::new();
        for found in self.all {
            for (a, name) in self.names.iter().enumerate() {
                let mut column = |number: &str, values| {
                    let name = csv_cell(&format!("{} {name}{number} (%)", found.typed));
                    push(&mut text, format_args!(",{name}"));
                    columns.push(values);
                };
                match &found.individuals {
                    None => column("", &found.spectra.mean[a]),
                    Some(individuals) => (0..individuals.count())
                        .for_each(|i| column(&format!(", individual {}", i + 1), individuals.of(i, a))),
                }
            }
        }
        for (w, nm) in self.nm.iter().enumerate() {
            push(&mut text, format_args!("\n{nm}"));
            columns.iter().for_each(|values| push(&mut text, format_args!(",{}", 100.0 * values[w])));
        }
        text.push('\n');
        text
    }
}

/// Writing to a string cannot fail.
fn push(text: &mut String, more: std::fmt::Arguments<'_>) {
    let _ = text.write_fmt(more);
}

/// A number, or an empty cell.
fn cell(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

/// The standard error of a mean; none of a single individual.
fn standard_error(std: f64, count: usize) -> Option<f64> {
    (count > 1).then(|| std / (count as f64).sqrt())
}

fn points(spectrum: &Spectrum) -> impl Iterator<Item = (f64, f64)> {
    spectrum.wavelengths().iter().copied().zip(spectrum.values().iter().copied())
}

/// The standard deviation of what was measured, as a curve.
fn std_of(measured: &Measured) -> Option<Spectrum> {
    let std = measured.std.clone()?;
    Spectrum::new(measured.mean.wavelengths().clone(), std).ok()
}
