//! `barbule species`: what is built in, and files of one's own, with colours, sources and parameters.

use std::fmt::Write as _;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use barbule::io::{is_species, read_species_file, read_text};
use barbule::material::Library;
use barbule::plot::{Anchor, Drawing, Ink, Stroke};
use barbule::progress::{Progress, Unobserved};
use barbule::solve::crystal::{Multipole, sweep};
use barbule::solve::swatch::normal_reflectance;
use barbule::spectrum::look::{Look, hex};
use barbule::spectrum::peaks::Origin;
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::structure::{
    DEFAULT_VARIANT, SpeciesFile, Structure, species_name, species_names, species_toml,
};
use barbule::{Error, Result, fields};
use serde_json::{Map, Value, json};

use crate::bird_args::{BirdArgs, Sight, Viewer};
use crate::common::{Common, print, print_json};
use crate::figure::FigureArgs;
use crate::peak_args::PeakArgs;
use crate::progress::Terminal;
use crate::provenance::Provenance;
use crate::{sets, structure_arg};

/// Points of the top whose colours are averaged, random individuals, and the most given ones.
const POINTS: usize = 120;
const INSTANCES: usize = 2;
const MOST_GIVEN: usize = 20;

/// Wavelengths where none are given, nm.
const USUAL_NM: &str = "380:780:10";
const USUAL_NM_OF_BIRDS: &str = "300:780:10";

/// Swatches in a line of the figure.
const SWATCHES_ABREAST: usize = 8;

/// Arguments of `barbule species`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule species starling:green --toml > my-starling.toml\n  \
    barbule species my-starling.toml\n  barbule species starling --bird starling -o seen.svg")]
pub(crate) struct Args {
    /// A species or one variant, as in starling or starling:pink, by any of its names; a file of your own; or any other
    /// structure [default: all built-in species]
    #[arg(value_name = "NAME[:VARIANT]|FILE")]
    name: Option<String>,
    /// Print a species file to start your own from: of NAME:VARIANT a flat one, every key explained; of NAME with its
    /// variants. With --json as JSON
    #[arg(long, conflicts_with = "output")]
    toml: bool,
    /// Wavelengths in nm of which colours are made [default: 380:780:10, with --bird 300:780:10]
    #[arg(long, alias = "wavelength", value_name = "SET", value_parser = sets::wavelength_set)]
    wavelengths: Option<Wavelengths>,
    #[command(flatten)]
    birds: BirdArgs,
    #[command(flatten)]
    peak: PeakArgs,
    #[command(flatten)]
    figure: FigureArgs,
    #[command(flatten)]
    common: Common,
}

/// What is asked about.
enum Subject {
    /// A species with its variants, or the one that was named.
    Species { file: Box<SpeciesFile>, library: Library, wanted: Option<String>, path: Option<PathBuf> },
    /// A stack, lattice, section or folder.
    Other(Structure),
}

/// What is listed.
struct Entry {
    name: String,
    latin: String,
    coloration: String,
    source: String,
    generator: Option<String>,
    default: String,
    variants: Vec<Variant>,
}

/// A variant: its look along the normal of a flat barbule, and its parameters with what they are.
struct Variant {
    name: String,
    look: Look,
    /// What each bird that was asked for sees.
    sights: Vec<Sight>,
    parameters: Map<String, Value>,
    explained: Vec<(String, String)>,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let at = self.wavelengths()?;
        let peak_range = self.peak.within(&at)?;
        self.figure.check_rigid(&self.common)?;
        if self.toml {
            for (flag, is_given) in [
                ("--wavelengths", self.wavelengths.is_some()),
                ("--bird", !self.birds.birds.is_empty()),
                ("--peak-range", peak_range.is_some()),
            ] {
                if is_given {
                    self.common
                        .idle(flag, "--toml prints the species file, without colours; leave --toml out");
                }
            }
            let text = self.file_text()?;
            return match self.common.json {
                true => print_json(out, &fields::parse_toml(&text)?),
                false => print(out, text.trim_end()),
            };
        }
        let subjects: Vec<_> = match &self.name {
            Some(name) => vec![self.find(name)?],
            None => species_names().map(|name| self.find(name)).collect::<Result<_>>()?,
        };
        let views = self.birds.views(at.range_nm())?;
        let progress = Terminal::new(&self.common);
        progress.begin("colours", subjects.iter().map(Subject::colours).sum());
        let entries = subjects
            .iter()
            .map(|subject| self.entry(subject, &views, &progress))
            .collect::<Result<Vec<_>>>()?;
        drop(progress);
        if let Some(path) = self.figure.path() {
            let drawing = figure(&entries).under(&self.figure.title(""));
            Provenance::new(&self.common).write_figure(path, &self.figure.page()?.place(drawing))?;
            let count: usize = entries.iter().map(|entry| entry.variants.len()).sum();
            let of = if let [entry] = &entries[..] { &entry.name } else { "all species" };
            self.common.wrote(path, &format!("colours of {of} at normal incidence, {count} swatches"));
        }
        if self.common.json { print_json(out, &document(&entries)) } else { list(out, &entries) }
    }

    /// The wavelengths of colours: those given, or the usual ones, which reach to where birds see.
    fn wavelengths(&self) -> Result<Wavelengths> {
        let usual = if self.birds.birds.is_empty() { USUAL_NM } else { USUAL_NM_OF_BIRDS };
        self.wavelengths.clone().map_or_else(|| sets::wavelength_set(usual), Ok)
    }

    /// Built-in names come before files.
    fn find(&self, text: &str) -> Result<Subject> {
        let opening = self.common.opening()?;
        let library = opening.media.library();
        let (name, variant) =
            text.split_once(':').map_or((text, None), |(name, variant)| (name, Some(variant)));
        let species = |file: SpeciesFile, library, variant: Option<&str>, path| {
            file.model(variant, Library::clone(&library))?;
            let wanted = variant.map(str::to_owned);
            Ok(Subject::Species { file: Box::new(file), library, wanted, path })
        };
        if let Ok(name) = species_name(name) {
            return species(SpeciesFile::builtin(name)?, library.clone(), variant, None);
        }
        let is_toml = |text: &str| text.to_lowercase().ends_with(".toml");
        let (path, variant) = match text.rsplit_once(':').filter(|(path, _)| is_toml(path)) {
            Some((path, variant)) => (path, Some(variant)),
            None => (text, None),
        };
        if is_toml(path) && is_species(Path::new(path))? {
            let (file, library) = read_species_file(Path::new(path), library)?;
            return species(file, library, variant, Some(path.into())).map_err(|error| error.at(path));
        }
        structure_arg::parse(text, &self.common).map(Subject::Other)
    }

    /// The text of a file to start from.
    fn file_text(&self) -> Result<String> {
        match self.find(self.name.as_deref().unwrap_or("starling"))? {
            Subject::Species { file, wanted: Some(variant), .. } => file.flat_toml(Some(&variant)),
            Subject::Species { path: Some(path), .. } => read_text(&path),
            Subject::Species { file, .. } => species_toml(&file.name).map(str::to_owned),
            Subject::Other(structure) => Err(Error::input(format!(
                "{} is no species, so it has no species file; leave --toml out",
                structure.name()
            ))),
        }
    }

    fn entry(&self, subject: &Subject, views: &[Viewer], progress: &dyn Progress) -> Result<Entry> {
        let (file, library, wanted) = match subject {
            Subject::Species { file, library, wanted, .. } => (file, library, wanted.as_deref()),
            Subject::Other(structure) => return self.other(structure, views, progress),
        };
        let mut variants = Vec::new();
        for name in file.variants().filter(|v| wanted.is_none_or(|w| w == *v)) {
            let model = file.model(Some(name), library.clone())?;
            let (look, sights) = self.look(&Structure::Species(Box::new(model)), views, progress)?;
            let parameters = file
                .given(Some(name))?
                .into_iter()
                .map(|(key, value)| (key.name.to_owned(), value))
                .collect();
            variants.push(Variant {
                name: name.to_owned(),
                look,
                sights,
                parameters,
                explained: file.explained(Some(name))?,
            });
        }
        Ok(Entry {
            name: file.name.clone(),
            latin: file.latin.clone(),
            coloration: file.coloration.clone(),
            source: file.source.clone(),
            generator: Some(file.generator.clone()),
            default: file.default.clone(),
            variants,
        })
    }

    /// What is no species has one look.
    fn other(&self, structure: &Structure, views: &[Viewer], progress: &dyn Progress) -> Result<Entry> {
        let source = match structure {
            Structure::Sections { sections, .. } => sections.first().map(|section| section.source.clone()),
            Structure::Species(_) | Structure::Stack(_) | Structure::Below(_) => None,
        };
        let (look, sights) = self.look(structure, views, progress)?;
        let name = DEFAULT_VARIANT.to_owned();
        let count = structure.count().unwrap_or(1);
        Ok(Entry {
            name: structure.name(),
            latin: String::new(),
            coloration: match structure.lattice() {
                Some(_) => "a photonic crystal".into(),
                None if count > 1 => format!("layers, {count} sections"),
                None => "layers".into(),
            },
            source: source.unwrap_or_default(),
            generator: None,
            default: name.clone(),
            variants: vec![Variant { name, look, sights, parameters: Map::new(), explained: Vec::new() }],
        })
    }

    /// How a structure looks along the normal of a flat barbule.
    fn look(
        &self,
        structure: &Structure,
        views: &[Viewer],
        progress: &dyn Progress,
    ) -> Result<(Look, Vec<Sight>)> {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        let at = &self.wavelengths()?;
        if let Some(lattice) = structure.lattice() {
            let found = sweep(&Multipole::default(), &lattice, at.nm(), 0.0, &[0.0], &Unobserved)?;
            let values = found.into_iter().map(|[a, b]| 0.5 * (a + b)).collect();
            progress.advance(1);
            return self.look_of(values, views);
        }
        let instances = match structure {
            Structure::Species(_) | Structure::Below(_) => INSTANCES,
            // Endless flat stacks: each is one point of a colour.
            Structure::Stack(_) => MOST_GIVEN,
            Structure::Sections { sections, .. } => sections.len().min(MOST_GIVEN),
        };
        let mut mean = vec![0.0; at.len()];
        for instance in 0..instances {
            let section = structure.instance(self.common.seed, instance)?;
            if section.boundaries.is_empty() {
                return Err(Error::input(format!(
                    "{} has no top boundary, so it has no colour along its normal; `barbule far-field` gives what it scatters",
                    structure.name()
                )));
            }
            for (sum, value) in mean.iter_mut().zip(normal_reflectance(&section, POINTS, at)?.values()) {
                *sum += value / instances as f64;
            }
        }
        progress.advance(1);
        self.look_of(mean, views)
    }

    fn look_of(&self, values: Vec<f64>, views: &[Viewer]) -> Result<(Look, Vec<Sight>)> {
        let at = self.wavelengths()?;
        let peak_range = self.peak.within(&at)?;
        let reflectance = [Spectrum::new(at, values)?];
        let sights = views.iter().map(|view| Sight::of(view, &reflectance)).collect::<Result<_>>()?;
        Ok((Look::with_peak_in(&reflectance[0], Origin::Computed, peak_range), sights))
    }
}

impl Subject {
    /// How many looks it has.
    fn colours(&self) -> u64 {
        match self {
            Self::Species { file, wanted: None, .. } => file.variants().count() as u64,
            _ => 1,
        }
    }
}

impl Entry {
    /// Names, Latin name and what colours it.
    fn title(&self) -> String {
        let latin = if self.latin.is_empty() { String::new() } else { format!(" ({})", self.latin) };
        let coloration =
            if self.coloration.is_empty() { String::new() } else { format!(": {}", self.coloration) };
        format!("{}{latin}{coloration}", self.name)
    }
}

impl Variant {
    /// Brightened, so that hues can be compared; none where the wavelengths do not make a colour.
    fn srgb_normalized(&self) -> Option<[u8; 3]> {
        self.look.colour.map(|colour| colour.srgb_normalized())
    }
}

/// Columns of a terminal.
const COLUMNS: usize = 80;
/// Parameters up to so long stand beside what they are, longer ones above it.
const LONGEST_BESIDE: usize = 28;

fn list(out: &mut dyn Write, entries: &[Entry]) -> Result<()> {
    let blocks = std::io::stdout().is_terminal();
    for entry in entries {
        print(out, &wrapped("", &entry.title(), 2))?;
        if !entry.source.is_empty() {
            print(out, &wrapped("  source:", &entry.source, 4))?;
        }
        for variant in &entry.variants {
            print(out, &line(variant, variant.name == entry.default, blocks))?;
            for sight in &variant.sights {
                print(out, &wrapped("     ", &sight.words(0), 8))?;
            }
        }
        let [variant] = &entry.variants[..] else { continue };
        print(out, &wrapped(" ", &variant.look.words(), 4))?;
        if let Some(generator) = &entry.generator {
            print(out, &format!("  parameters of the generator {generator}:"))?;
        }
        let lengths = variant.explained.iter().map(|(line, _)| line.chars().count());
        let width = lengths.filter(|length| *length <= LONGEST_BESIDE).max().unwrap_or(0);
        for (line, about) in &variant.explained {
            if line.chars().count() <= width {
                print(out, &wrapped(&format!("    {line:width$} "), about, width + 6))?;
            } else {
                print(out, &wrapped("   ", line, 6))?;
                print(out, &wrapped(&" ".repeat(width + 5), about, width + 6))?;
            }
        }
    }
    Ok(())
}

/// The words of a text behind a start, in lines of a terminal's width; all but the first are indented. A word that is longer
/// has a line of its own.
fn wrapped(start: &str, text: &str, indent: usize) -> String {
    let (mut done, mut line) = (String::new(), start.to_owned());
    let mut is_begun = false;
    for word in text.split_whitespace() {
        let gap = usize::from(!line.is_empty());
        if is_begun && line.chars().count() + gap + word.chars().count() > COLUMNS {
            done += &line;
            done.push('\n');
            line = " ".repeat(indent.saturating_sub(1));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += word;
        is_begun = true;
    }
    done + &line
}

/// A variant in one line: brightened colour, name, how bright it is and where it peaks.
fn line(variant: &Variant, is_default: bool, blocks: bool) -> String {
    let mut text = String::from("  ");
    match variant.srgb_normalized() {
        // Writing to a string cannot fail, here and below.
        Some(rgb) => {
            let [r, g, b] = rgb;
            if blocks {
                let _ = write!(text, "\u{1b}[48;2;{r};{g};{b}m    \u{1b}[0m ");
            }
            let _ = write!(text, "{}", hex(rgb));
        }
        None => text += "no colour",
    }
    if variant.name != DEFAULT_VARIANT {
        let _ = write!(text, "  {:<15}", variant.name);
    }
    if let Some(colour) = variant.look.colour {
        let _ = write!(text, "  reflects {:4.1} %", 100.0 * colour.xyz[1]);
    }
    if let Some(peak) = variant.look.peak {
        let _ = write!(text, ", peak {:.0} nm", peak.nm);
    }
    if is_default && variant.name != DEFAULT_VARIANT {
        text += " (default)";
    }
    text
}

fn document(entries: &[Entry]) -> Value {
    let variant = |variant: &Variant| {
        let mut table = Map::from_iter([("name".to_owned(), json!(variant.name))]);
        if let Value::Object(look) = json!(variant.look.fields()) {
            table.extend(look);
        }
        if !variant.sights.is_empty() {
            table.insert("birds".into(), variant.sights.iter().map(Sight::document).collect());
        }
        table.insert("parameters".into(), variant.parameters.clone().into());
        Value::Object(table)
    };
    let species = |entry: &Entry| {
        json!({
            "name": entry.name, "latin": entry.latin, "coloration": entry.coloration, "source": entry.source,
            "generator": entry.generator, "default": entry.default,
            "variants": entry.variants.iter().map(variant).collect::<Vec<_>>(),
        })
    };
    json!({ "species": entries.iter().map(species).collect::<Vec<_>>() })
}

/// Swatches with their names: large as bright as a screen can show them, below at their own luminance.
fn figure(entries: &[Entry]) -> Drawing {
    let lines = |entry: &Entry| entry.variants.len().div_ceil(SWATCHES_ABREAST).max(1);
    let birds: Vec<&Sight> =
        entries.iter().find_map(|e| e.variants.first()).map_or(&[][..], |v| &v.sights).iter().collect();
    let line_height = 80.0 + BARS_HEIGHT * birds.len() as f64;
    let height: f64 = entries.iter().map(|entry| 50.0 + line_height * lines(entry) as f64).sum();
    let mut drawing = Drawing::new(1000.0, 20.0 + height + 18.0 * birds.len() as f64);
    let mut y = 20.0;
    for entry in entries {
        drawing.text([20.0, y + 16.0], 16.0, Anchor::Start, entry.title());
        for (i, variant) in entry.variants.iter().enumerate() {
            let x = 20.0 + 120.0 * (i % SWATCHES_ABREAST) as f64;
            let top = y + 28.0 + line_height * (i / SWATCHES_ABREAST) as f64;
            let edge = Stroke::solid(Ink::of([120, 120, 120]), 0.8);
            let colour = variant.look.colour;
            let fill = |rgb: Option<[u8; 3]>| rgb.map(Ink::of);
            drawing.rectangle([x, top, 108.0, 38.0], fill(variant.srgb_normalized()), None);
            drawing.rectangle([x, top + 38.0, 108.0, 12.0], fill(colour.map(|c| c.srgb())), None);
            drawing.rectangle([x, top, 108.0, 50.0], None, Some(edge));
            // A long name leaves no room for the number.
            let words = match variant.srgb_normalized() {
                Some(rgb) if variant.name.len() <= 9 => format!("{} {}", variant.name, hex(rgb)),
                _ => variant.name.clone(),
            };
            drawing.text([x + 54.0, top + 67.0], 13.0, Anchor::Middle, words);
            for (row, sight) in variant.sights.iter().enumerate() {
                bars(&mut drawing, [x, top + 74.0 + BARS_HEIGHT * row as f64], sight.catches(0));
            }
        }
        y += 50.0 + line_height * lines(entry) as f64;
    }
    let count = birds.len();
    for (row, sight) in birds.into_iter().enumerate() {
        let number = if count > 1 { format!(" in row {}", row + 1) } else { String::new() };
        let words = format!("bars{number}: {}", sight.legend());
        drawing.text([20.0, y + 18.0 * row as f64], 13.0, Anchor::Start, words);
    }
    drawing
}

/// Height that the bars of a bird take, px.
const BARS_HEIGHT: f64 = 34.0;

/// What each cone catches, as bars from short to long wavelengths over that of the cone that catches most.
fn bars(drawing: &mut Drawing, [x, top]: [f64; 2], catches: &[f64]) {
    let most = catches.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let (width, full) = (108.0 / catches.len() as f64, BARS_HEIGHT - 8.0);
    for (k, q) in catches.iter().enumerate() {
        let height = full * (q / most).max(0.0);
        let area = [x + width * k as f64 + 2.0, top + full - height, width - 4.0, height];
        drawing.rectangle(area, Some(Ink::of([120, 120, 120])), None);
    }
    drawing.line([x, top + full], [x + 108.0, top + full], Stroke::solid(Ink::BLACK, 0.8));
}
