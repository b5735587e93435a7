//! What `barbule spectrum` gives: files, a document, and lines for people.

use std::fmt::Write as _;
use std::io::Write;

use barbule::Result;
use barbule::error::{counted, shortened};
use barbule::figures::{self, Simulated};
use barbule::io::measured::{AtAngle, Measured};
use barbule::plot::{Band, MeasuredBand};
use barbule::solve::core_fringes::CoreFringes;
use barbule::solve::surface::LARGEST_MIRROR_ERROR;
use barbule::spectrum::comparison::Comparison;
use barbule::spectrum::look::Look;
use barbule::spectrum::peaks::Origin;
use serde_json::{Value, json};

use super::instrument::{Row, front};
use super::{Args, Asked, Found, Layout, intervals, tables};
use crate::bird_args::Sight;
use crate::common::print;
use crate::peak_args;
use crate::provenance::{Provenance, csv_cell};

impl Args {
    /// Writes the files that are asked for.
    pub(super) fn write(&self, all: &[Found], asked: Asked) -> Result<()> {
        let provenance = Provenance::new(&self.common);
        let rows = asked.rows;
        let shown = |what: &str| {
            let whose = match all {
                [one] => one.name.clone(),
                many => format!("{} structures", many.len()),
            };
            let count = if self.laid(rows, None).is_empty() { "angle" } else { "reading" };
            format!("{what} of {whose} at {}", counted(rows.len(), count))
        };
        let beside = if asked.measured.is_some() { ", and what was measured" } else { "" };
        if let Some(path) = &self.figure.output {
            provenance.write_figure(path, &self.figure(all, asked)?)?;
            self.common.wrote(path, &format!("{}{beside}", shown("reflectance")));
        }
        if let Some(path) = &self.csv {
            let tables = tables::Tables {
                all,
                rows,
                names: &rows.iter().map(|row| self.row_name(row)).collect::<Vec<_>>(),
                nm: self.wavelengths.nm(),
                measured: asked.measured,
            };
            let text = match self.csv_layout {
                Layout::Wide => tables.wide(),
                Layout::Tidy => tables.tidy(),
                Layout::Spectrometer => tables.spectrometer(),
            };
            provenance.write_csv(path, &text)?;
            self.common.wrote(path, &format!("{}{beside}", shown("reflectance")));
        }
        if let Some(path) = &self.instrument.law {
            let all: Vec<_> = all.iter().map(|found| (found.typed.clone(), &found.looks[..])).collect();
            provenance.write_figure(path, &self.law_figure(&all, rows)?)?;
            self.common.wrote(path, "the followed peak against the angle, with its law");
        }
        if let Some(path) = &self.summary {
            provenance.write_csv(path, &self.summary_text(all, asked))?;
            let beside = if asked.measured.is_some() { " and of the comparison" } else { "" };
            self.common.wrote(path, &format!("{}{beside}", shown("numbers of the colour")));
        }
        Ok(())
    }

    fn figure(&self, all: &[Found], asked: Asked) -> Result<barbule::plot::Drawing> {
        let most = all.iter().map(|found| found.instances).max().unwrap_or(0);
        let angles: Vec<String> = asked.rows.iter().map(|row| self.row_name(row)).collect();
        let title = match (all, &angles[..]) {
            ([one], _) => format!("{}, {}", one.name, counted(one.instances, "instance")),
            (_, [angle]) => format!("{angle}, {}", counted(most, "instance")),
            _ => counted(most, "instance"),
        };
        let names: Vec<Vec<String>> = all
            .iter()
            .map(|found| match (all.len(), angles.len()) {
                (1, _) => angles.clone(),
                (_, 1) => vec![shortened(&found.typed)],
                _ => angles.iter().map(|angle| format!("{}, {angle}", shortened(&found.typed))).collect(),
            })
            .collect();
        let simulated: Vec<Simulated> = all
            .iter()
            .zip(&names)
            .map(|(found, names)| Simulated {
                names,
                spectra: &found.spectra,
                instances: found.instances,
                looks: &found.looks,
                has_guess: found.has_guess,
            })
            .collect();
        let measured = bands(asked);
        let (title, page) = (self.figure.title(figures::heading(&title)), self.figure.page()?);
        figures::spectra(&title, &self.wavelengths, &simulated, &measured, &page)
    }

    fn summary_text(&self, all: &[Found], asked: Asked) -> String {
        let (header, cells) = front(asked.rows);
        let mut text = format!("structure,{header}angle_deg,instances");
        let first = all.iter().flat_map(|found| found.looks.first()).next();
        let compared = all.iter().flat_map(|found| found.comparisons.iter().flatten()).next();
        if let Some(fields) = first.map(Look::fields) {
            let _ = write!(text, ",{},flagged_wavelengths", fields.csv_header());
        }
        if let Some(fields) = compared.map(Comparison::fields) {
            let _ = write!(text, ",{}", fields.csv_header());
        }
        let columns = compared.map_or(0, |comparison| comparison.fields().csv_header().split(',').count());
        for found in all {
            for (a, Row { angle_deg, .. }) in asked.rows.iter().enumerate() {
                let (name, front) = (csv_cell(&found.typed), &cells[a]);
                let cells = found.looks[a].fields().csv_cells();
                let flagged = found.flagged(a);
                let _ = write!(text, "\n{name},{front}{angle_deg},{},{cells},{flagged}", found.instances);
                match found.comparisons.get(a) {
                    Some(Some(comparison)) => {
                        let _ = write!(text, ",{}", comparison.fields().csv_cells());
                    }
                    Some(None) => text.push_str(&",".repeat(columns)),
                    None => {}
                }
            }
        }
        text.push('\n');
        text
    }

    /// All that was found, for machines.
    pub(super) fn document(&self, all: &[Found], asked: Asked) -> Value {
        let of = |found: &Found| {
            let error = |std: &Vec<f64>| -> Vec<f64> {
                std.iter().map(|s| s / (found.instances as f64).sqrt()).collect()
            };
            let standard_error =
                (found.instances > 1).then(|| found.spectra.std.iter().map(error).collect::<Vec<_>>());
            let mut document = json!({
                "structure": found.typed,
                "angle_deg": asked.rows.iter().map(|row| row.angle_deg).collect::<Vec<_>>(),
                "wavelength_nm": self.wavelengths.nm(),
                "mean": found.spectra.mean,
                "std": found.spectra.std,
                "mirror_fraction": found.spectra.mirror,
                "flagged": found.spectra.flagged(),
                "standard_error": standard_error,
                "instances": found.instances,
                "look": found.looks,
                "core_note": found.core_fringes.map(|fringes| core_note(&fringes, found.instances)),
                "order_notes": peak_args::notes(&self.law_angles_deg(asked.rows), &found.looks),
            });
            self.describe(&mut document, &found.looks, asked.rows);
            if let Some(individuals) = &found.individuals {
                let of = |a: usize| {
                    (0..individuals.count()).map(move |i| individuals.of(i, a)).collect::<Vec<_>>()
                };
                document["individuals"] = json!((0..found.spectra.mean.len()).map(of).collect::<Vec<_>>());
            }
            if !found.sights.is_empty() {
                document["birds"] = found.sights.iter().map(Sight::document).collect();
            }
            if let Some(all) = &found.intervals {
                document["intervals"] = json!(all);
            }
            if asked.measured.is_some() {
                document["comparison"] = json!(found.comparisons);
            }
            document
        };
        let mut document = match all {
            [one] => of(one),
            many => json!({ "structures": many.iter().map(of).collect::<Vec<_>>() }),
        };
        if let Some(measured) = asked.measured {
            let peak_range = self.peak.within(&self.wavelengths).ok().flatten();
            let of = |at: &AtAngle| {
                let measured = &at.measured;
                json!({
                    "reading": measured.reading,
                    "angle_deg": at.angle_deg,
                    "samples": measured.samples.iter().map(|sample| &sample.name).collect::<Vec<_>>(),
                    "wavelength_nm": measured.mean.wavelengths().nm(),
                    "mean": measured.mean.values(),
                    "std": measured.std,
                    "look": Look::with_peak_in(&measured.mean, Origin::Measured, peak_range),
                })
            };
            document["measured"] = match &measured.angles[..] {
                [one] => of(one),
                several => json!({
                    "reading": measured.reading.join("; "),
                    "law": self.measured_law(asked),
                    "angles": several.iter().map(of).collect::<Vec<_>>(),
                }),
            };
        }
        document
    }

    /// The colours, and how they compare, one line each.
    pub(super) fn print(&self, out: &mut dyn Write, all: &[Found], asked: Asked) -> Result<()> {
        let file = asked.measured.map(|_| self.measured_name());
        for found in all {
            for (a, row) in asked.rows.iter().enumerate() {
                let name = if all.len() > 1 { shortened(&found.typed) } else { found.name.clone() };
                let flagged = match found.flagged(a) {
                    0 => String::new(),
                    count => format!(
                        ", flagged: off by over {:.0} % at {count} of {}",
                        100.0 * LARGEST_MIRROR_ERROR,
                        counted(self.wavelengths.len(), "wavelength")
                    ),
                };
                let words = found.looks[a].words();
                print(out, &format!("{name}, {}: {words}{flagged}", self.row_name(row)))?;
                for sight in &found.sights {
                    print(out, &format!("  {}", sight.words(a)))?;
                }
                if let Some(found) = found.intervals.as_ref().and_then(|all| all.get(a)) {
                    print(out, &format!("  {}", intervals::words(found)))?;
                }
                if let (Some(Some(comparison)), Some(file)) = (found.comparisons.get(a), &file) {
                    print(out, &format!("  against {file}: {}", comparison.words()))?;
                }
            }
            if let Ok(law) = self.law(&found.looks, asked.rows) {
                print(out, &format!("{}: {}", shortened(&found.typed), law.words()))?;
            }
            let core = found.core_fringes.map(|fringes| core_note(&fringes, found.instances));
            for note in
                peak_args::notes(&self.law_angles_deg(asked.rows), &found.looks).into_iter().chain(core)
            {
                let name =
                    if all.len() > 1 { format!("{}: ", shortened(&found.typed)) } else { String::new() };
                self.common.say(&format!("{name}{note}"));
            }
        }
        if let Some(law) = self.measured_law(asked) {
            print(out, &format!("measured: {}", law.words()))?;
        }
        if let Some(note) = all.first().and_then(|found| found.looks[0].colour_note.as_ref()) {
            self.common.say(note);
        }
        Ok(())
    }
}

/// What was measured at these angles, each beside its curve, as figures show it.
fn bands(asked: Asked) -> Vec<MeasuredBand> {
    let of = |(beside, measured): (usize, &Measured)| MeasuredBand {
        band: Band {
            name: match &measured.samples[..] {
                [_] => "measured".into(),
                many => format!("measured, mean of {}", many.len()),
            },
            mean: measured.mean.clone(),
            std: measured.std.clone(),
            peak: None,
        },
        samples: match &measured.samples[..] {
            [_] => Vec::new(),
            many => many.iter().map(|sample| sample.spectrum.clone()).collect(),
        },
        beside: Some(beside),
    };
    match asked.measured.map(|measured| &measured.angles[..]) {
        Some([AtAngle { angle_deg: None, measured }]) => vec![of((0, measured))],
        _ => (0..asked.rows.len()).filter_map(|a| Some((a, asked.measured_at(a)?))).map(of).collect(),
    }
}

/// What to tell of fringes that look like peaks of the structure.
fn core_note(fringes: &CoreFringes, instances: usize) -> String {
    format!(
        "the core, a film between both sides, makes fringes of ±{:.1} % of the light ({:.0} % of the mean) about {:.0} nm at normal incidence, {:.0} nm from one to the next; the mean of {instances} individuals keeps {:.0} % of them, since their cores are alike: core_spread = 0.1 in the species file, or lower = \"none\", takes them out",
        100.0 * fringes.amplitude,
        100.0 * fringes.part,
        fringes.near_nm,
        fringes.period_nm,
        100.0 * fringes.kept
    )
}
