//! `barbule species`: what is built in, with colours.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use barbule::Result;
use barbule::observer::Unobserved;
use barbule::plot::{Anchor, Drawing, Format, Ink, Stroke};
use barbule::solve::crystal::{Multipole, sweep};
use barbule::solve::swatch::normal_reflectance;
use barbule::spectrum::colour::{Observer, display};
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::structure::{SpeciesFile, SpeciesModel, crystal_species, species_names, species_toml};
use serde_json::json;

use crate::common::{Common, print, print_json};
use crate::provenance::Provenance;

/// Points of the top whose colours are averaged, and random individuals.
const POINTS: usize = 120;
const INSTANCES: usize = 2;

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
    /// Name, sRGB (brightened), luminous reflectance.
    variants: Vec<(String, [u8; 3], f64)>,
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
        if self.common.json {
            print_json(out, &document(&entries, name.is_none()))
        } else {
            list(out, &entries, name.is_none())
        }
    }

    fn entry(&self, name: &str, wanted: Option<&str>) -> Result<Entry> {
        let file = SpeciesFile::builtin(name)?;
        let mut variants = Vec::new();
        if let Some(wanted) = wanted {
            file.model(Some(wanted), self.common.library()?)?;
        }
        for variant in file.variants().filter(|v| wanted.is_none_or(|w| w == *v)) {
            let model = file.model(Some(variant), self.common.library()?)?;
            let (rgb, luminance) = self.colour(&model)?;
            // As bright as a screen can show it, so that hues can be compared.
            let most = rgb.into_iter().fold(1e-6, f64::max);
            variants.push((variant.to_owned(), display(rgb.map(|c| 0.9 * c / most)), luminance));
        }
        Ok(Entry {
            name: name.to_owned(),
            latin: file.latin.clone(),
            coloration: file.coloration.clone(),
            default: file.default.clone(),
            variants,
        })
    }

    /// Linear sRGB and luminous reflectance at normal incidence.
    fn colour(&self, model: &SpeciesModel) -> Result<([f64; 3], f64)> {
        let at = Wavelengths::new((0..=40).map(|i| 380.0 + 10.0 * f64::from(i)).collect::<Vec<_>>())?;
        let observer = Observer::default();
        if let Some(lattice) = model.lattice() {
            let found = sweep(&Multipole::default(), &lattice, at.nm(), 0.0, &[0.0], &Unobserved)?;
            let spectrum = Spectrum::new(at, found.into_iter().map(|[a, b]| 0.5 * (a + b)).collect())?;
            return Ok((observer.linear_rgb(&spectrum), observer.xyz(&spectrum)[1]));
        }
        let (mut rgb, mut luminance) = ([0.0; 3], 0.0);
        for instance in 0..INSTANCES {
            let section = model.section(self.common.seed, instance)?;
            let spectrum = normal_reflectance(&section, POINTS, &at)?;
            let part = observer.linear_rgb(&spectrum);
            luminance += observer.xyz(&spectrum)[1] / INSTANCES as f64;
            for (sum, c) in rgb.iter_mut().zip(part) {
                *sum += c / INSTANCES as f64;
            }
        }
        Ok((rgb, luminance))
    }
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn list(out: &mut dyn Write, entries: &[Entry], all: bool) -> Result<()> {
    let blocks = std::io::stdout().is_terminal();
    for entry in entries {
        print(out, &format!("{} ({}): {}", entry.name, entry.latin, entry.coloration))?;
        for (variant, rgb, luminance) in &entry.variants {
            let [r, g, b] = rgb;
            let block =
                if blocks { format!("\u{1b}[48;2;{r};{g};{b}m    \u{1b}[0m ") } else { String::new() };
            let mark = if *variant == entry.default { " (default)" } else { "" };
            let percent = 100.0 * luminance;
            print(out, &format!("  {block}{}  {variant:<10} reflects {percent:4.1} %{mark}", hex(*rgb)))?;
        }
    }
    if all {
        let names: Vec<&str> = crystal_species().collect();
        print(out, &format!("Not simulated yet as barbules: {} (barbule crystal)", names.join(", ")))?;
    }
    Ok(())
}

fn document(entries: &[Entry], all: bool) -> serde_json::Value {
    let species: Vec<_> = entries
        .iter()
        .map(|entry| {
            let variants: Vec<_> = entry
                .variants
                .iter()
                .map(|(name, rgb, y)| json!({"name": name, "srgb": hex(*rgb), "luminous_reflectance": y}))
                .collect();
            json!({
                "name": entry.name, "latin": entry.latin, "coloration": entry.coloration,
                "default": entry.default, "variants": variants,
            })
        })
        .collect();
    let mut out = json!({ "species": species });
    if all {
        out["not_simulated_yet"] = crystal_species().collect();
    }
    out
}

fn figure(entries: &[Entry]) -> Drawing {
    let mut drawing = Drawing::new(1000.0, 20.0 + 130.0 * entries.len() as f64);
    for (row, entry) in entries.iter().enumerate() {
        let y = 20.0 + 130.0 * row as f64;
        let title = format!("{} ({}): {}", entry.name, entry.latin, entry.coloration);
        drawing.text([20.0, y + 16.0], 16.0, Anchor::Start, title);
        for (i, (variant, rgb, _)) in entry.variants.iter().enumerate() {
            let x = 20.0 + 120.0 * i as f64;
            let edge = Stroke::solid(Ink::of([120, 120, 120]), 0.8);
            drawing.rectangle([x, y + 28.0, 108.0, 50.0], Some(Ink::of(*rgb)), Some(edge));
            drawing.text([x + 54.0, y + 95.0], 13.0, Anchor::Middle, format!("{variant} {}", hex(*rgb)));
        }
    }
    drawing
}
