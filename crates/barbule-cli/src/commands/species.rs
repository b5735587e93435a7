//! `barbule species`: what is built in, with colours.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use barbule::Result;
use barbule::plot::{Anchor, Drawing, Format, Ink, Stroke};
use barbule::progress::Unobserved;
use barbule::solve::crystal::{Multipole, sweep};
use barbule::solve::swatch::normal_reflectance;
use barbule::spectrum::colour::{Observer, chromaticity, display};
use barbule::spectrum::hue::{Dominant, dominant, hue_deg};
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::structure::{SpeciesFile, SpeciesModel, species_names, species_toml};
use serde_json::json;

use crate::common::{Common, print, print_json};
use crate::provenance::Provenance;

/// Points of the top whose colours are averaged, and random individuals.
const POINTS: usize = 120;
const INSTANCES: usize = 2;

/// Swatches in a line of the figure.
const SWATCHES_ABREAST: usize = 8;

/// Arguments of `barbule species`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  barbule species starling --toml > my-starling.toml")]
pub(crate) struct Args {
    /// One species, or one variant, as in starling or starling:pink [default: all]
    #[arg(value_name = "NAME[:VARIANT]")]
    name: Option<String>,
    /// Print the species' file, to start your own from
    #[arg(long, conflicts_with = "output")]
    toml: bool,
    /// Draw the swatches: .svg or .png
    #[arg(short, long, value_name = "FIG")]
    output: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// A species that is listed.
struct Entry {
    name: String,
    latin: String,
    coloration: String,
    default: String,
    variants: Vec<(String, Look)>,
}

/// How a variant looks along the normal of a flat barbule.
struct Look {
    /// Brightened: as bright as a screen can show it, so that hues can be compared.
    srgb: [u8; 3],
    /// Luminous reflectance.
    luminance: f64,
    /// The highest local maximum of the reflectance in nm, and its height.
    peak: Option<[f64; 2]>,
    dominant: Option<Dominant>,
    hue_deg: f64,
}

impl Look {
    /// Of a mean reflectance.
    fn of(spectrum: &Spectrum) -> Self {
        let observer = Observer::default();
        let (rgb, xyz) = (observer.linear_rgb(spectrum), observer.xyz(spectrum));
        let most = rgb.into_iter().fold(1e-6, f64::max);
        Self {
            srgb: display(rgb.map(|c| 0.9 * c / most)),
            luminance: xyz[1],
            peak: peak(spectrum),
            dominant: dominant(chromaticity(xyz)),
            hue_deg: hue_deg(rgb),
        }
    }
}

/// The highest local maximum, by a parabola through three samples at equal distances.
fn peak(spectrum: &Spectrum) -> Option<[f64; 2]> {
    let (nm, values) = (spectrum.wavelengths().nm(), spectrum.values());
    let (at, three) = values
        .windows(3)
        .enumerate()
        .filter(|(_, w)| w[1] > w[0] && w[1] >= w[2])
        .max_by(|(_, a), (_, b)| a[1].total_cmp(&b[1]))?;
    let shift = 0.5 * (three[0] - three[2]) / (three[0] - 2.0 * three[1] + three[2]);
    Some([nm[at + 1] + shift * (nm[at + 2] - nm[at + 1]), three[1] - 0.25 * (three[0] - three[2]) * shift])
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        if let Some(path) = &self.output {
            Format::of(path)?;
            barbule::io::check_writable(path)?;
        }
        let (name, variant) = match self.name.as_deref().map(|n| n.split_once(':').unwrap_or((n, ""))) {
            Some((name, "")) => (Some(name), None),
            Some((name, variant)) => (Some(name), Some(variant)),
            None => (None, None),
        };
        if self.toml {
            let text = species_toml(name.unwrap_or("starling"))?;
            SpeciesFile::parse(text)?.model(variant, self.common.library()?)?;
            return print(out, text.trim_end());
        }
        let names = name.map_or_else(|| species_names().collect(), |name| vec![name]);
        let entries = names.into_iter().map(|name| self.entry(name, variant)).collect::<Result<Vec<_>>>()?;
        if let Some(path) = &self.output {
            Provenance::new(&self.common).write_figure(path, &figure(&entries))?;
        }
        if self.common.json { print_json(out, &document(&entries)) } else { list(out, &entries) }
    }

    fn entry(&self, name: &str, wanted: Option<&str>) -> Result<Entry> {
        let file = SpeciesFile::builtin(name)?;
        let mut variants = Vec::new();
        if let Some(wanted) = wanted {
            file.model(Some(wanted), self.common.library()?)?;
        }
        for variant in file.variants().filter(|v| wanted.is_none_or(|w| w == *v)) {
            let model = file.model(Some(variant), self.common.library()?)?;
            variants.push((variant.to_owned(), Look::of(&self.reflectance(&model)?)));
        }
        Ok(Entry {
            name: name.to_owned(),
            latin: file.latin.clone(),
            coloration: file.coloration.clone(),
            default: file.default.clone(),
            variants,
        })
    }

    /// Mean reflectance at normal incidence.
    fn reflectance(&self, model: &SpeciesModel) -> Result<Spectrum> {
        let at = Wavelengths::new((0..=40).map(|i| 380.0 + 10.0 * f64::from(i)).collect::<Vec<_>>())?;
        if let Some(lattice) = model.lattice() {
            let found = sweep(&Multipole::default(), &lattice, at.nm(), 0.0, &[0.0], &Unobserved)?;
            return Spectrum::new(at, found.into_iter().map(|[a, b]| 0.5 * (a + b)).collect());
        }
        let mut mean = vec![0.0; at.len()];
        for instance in 0..INSTANCES {
            let section = model.section(self.common.seed, instance)?;
            for (sum, value) in mean.iter_mut().zip(normal_reflectance(&section, POINTS, &at)?.values()) {
                *sum += value / INSTANCES as f64;
            }
        }
        Spectrum::new(at, mean)
    }
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn list(out: &mut dyn Write, entries: &[Entry]) -> Result<()> {
    let blocks = std::io::stdout().is_terminal();
    for entry in entries {
        print(out, &format!("{} ({}): {}", entry.name, entry.latin, entry.coloration))?;
        for (variant, look) in &entry.variants {
            let [r, g, b] = look.srgb;
            let block =
                if blocks { format!("\u{1b}[48;2;{r};{g};{b}m    \u{1b}[0m ") } else { String::new() };
            let mark = if *variant == entry.default { " (default)" } else { "" };
            let percent = 100.0 * look.luminance;
            let peak = look.peak.map_or(String::new(), |[nm, _]| format!(", peak {nm:.0} nm"));
            print(
                out,
                &format!("  {block}{}  {variant:<16} reflects {percent:4.1} %{peak}{mark}", hex(look.srgb)),
            )?;
        }
    }
    Ok(())
}

fn document(entries: &[Entry]) -> serde_json::Value {
    let species: Vec<_> = entries
        .iter()
        .map(|entry| {
            let variants: Vec<_> = entry
                .variants
                .iter()
                .map(|(name, look)| {
                    json!({
                        "name": name,
                        "srgb": hex(look.srgb),
                        "luminous_reflectance": look.luminance,
                        "peak_nm": look.peak.map(|[nm, _]| nm),
                        "peak_reflectance": look.peak.map(|[_, height]| height),
                        "dominant_nm": look.dominant.map(|d| d.nm),
                        "dominant_is_complementary": look.dominant.is_some_and(|d| d.is_complementary),
                        "purity": look.dominant.map(|d| d.purity),
                        "hue_deg": look.hue_deg,
                    })
                })
                .collect();
            json!({
                "name": entry.name, "latin": entry.latin, "coloration": entry.coloration,
                "default": entry.default, "variants": variants,
            })
        })
        .collect();
    json!({ "species": species })
}

fn figure(entries: &[Entry]) -> Drawing {
    let lines = |entry: &Entry| entry.variants.len().div_ceil(SWATCHES_ABREAST).max(1);
    let height: usize = entries.iter().map(|entry| 20 + 30 + 80 * lines(entry)).sum();
    let mut drawing = Drawing::new(1000.0, 20.0 + height as f64);
    let mut y = 20.0;
    for entry in entries {
        let title = format!("{} ({}): {}", entry.name, entry.latin, entry.coloration);
        drawing.text([20.0, y + 16.0], 16.0, Anchor::Start, title);
        for (i, (variant, look)) in entry.variants.iter().enumerate() {
            let x = 20.0 + 120.0 * (i % SWATCHES_ABREAST) as f64;
            let top = y + 28.0 + 80.0 * (i / SWATCHES_ABREAST) as f64;
            let edge = Stroke::solid(Ink::of([120, 120, 120]), 0.8);
            drawing.rectangle([x, top, 108.0, 50.0], Some(Ink::of(look.srgb)), Some(edge));
            // A long name leaves no room for the number.
            let words =
                if variant.len() > 9 { variant.clone() } else { format!("{variant} {}", hex(look.srgb)) };
            drawing.text([x + 54.0, top + 67.0], 13.0, Anchor::Middle, words);
        }
        y += 50.0 + 80.0 * lines(entry) as f64;
    }
    drawing
}
