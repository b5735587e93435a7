//! `barbule trace`: from a micrograph to what is in it.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::error::shortened;
use barbule::io::{check_writable, read_micrograph, write_whole};
use barbule::plot::Format;
use barbule::trace::{Bar, Grey, Kind, Spread};
use barbule::traced::{Micrograph, TracedImage, scaled_by_bar, trace_image};
use barbule::{Error, Result};
use clap::ValueEnum;

use crate::common::{Common, print, print_json};
use crate::provenance::Provenance;

/// Arguments of `barbule trace`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    barbule trace examples/micrographs/rods.png --scale 200nm=100px -o rods.toml --picture rods.png\n  \
    barbule trace examples/micrographs/layers.png --scale 200nm=bar -o layers.toml")]
pub(crate) struct Args {
    /// The micrograph: .png, .tif or .jpg, grey or in colours, 8 or 16 bits
    image: PathBuf,
    /// A length and its pixels, or `bar` for the scale bar that the picture shows: 100nm=85px, 0.5um=bar
    #[arg(long, value_name = "LENGTH=PX", value_parser = scale)]
    scale: Scale,
    /// Grey levels between the classes, 0 to 255 of the flattened picture, the brighter first [default: in the middle between classes]
    #[arg(long, value_name = "A[,B]", value_delimiter = ',', num_args = 1)]
    thresholds: Vec<f64>,
    /// Media of the classes of grey from the brightest to the darkest [default: air,keratin,melanin, or the last two]
    #[arg(long, value_name = "MEDIA", value_delimiter = ',', num_args = 1)]
    classes: Vec<String>,
    /// What to trace it as [default: what it looks like]
    #[arg(long = "as", value_name = "KIND", value_enum)]
    kind: Option<As>,
    /// Keratin above the first row of a lattice, nm, where the picture does not show it
    #[arg(long, value_name = "NM")]
    cortex: Option<f64>,
    /// The part to trace: left, top, width and height in pixels
    #[arg(long, value_name = "X,Y,W,H", value_parser = crop)]
    crop: Option<Crop>,
    /// Write what simulates: a lattice (.toml, .json), layers (.toml a species, .json a section), a section (.json)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw outlines, thresholds and measures over the picture: .svg, .pdf or .png
    #[arg(long, value_name = "FIG")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// What can be traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum As {
    /// Rods on a lattice
    Lattice,
    /// Layers from side to side
    Layers,
    /// Outlines of whatever is there
    Section,
}

/// Length in nm, and its pixels; none for the scale bar in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Scale {
    nm: f64,
    px: Option<f64>,
}

/// Left, top, width, height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Crop([usize; 4]);

fn scale(text: &str) -> Result<Scale> {
    let refused = || {
        Error::input(format!(
            "--scale {}: give a length and its pixels, as in 100nm=85px or 0.5um=120.5px, or 100nm=bar for the picture's scale bar",
            shortened(text)
        ))
    };
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
    let (length, pixels) = text.split_once('=').ok_or_else(refused)?;
    let length = length.trim();
    let units = [("nm", 1.0), ("um", 1e3), ("µm", 1e3), ("μm", 1e3)];
    let nm = units.iter().find_map(|(unit, nm)| Some(number(length.strip_suffix(unit)?)? * nm));
    let nm = nm.ok_or_else(refused)?;
    let px = match pixels.trim() {
        "bar" => None,
        pixels => Some(number(pixels.strip_suffix("px").unwrap_or(pixels)).ok_or_else(refused)?),
    };
    Ok(Scale { nm, px })
}

fn crop(text: &str) -> Result<Crop> {
    let sides: Option<Vec<usize>> = text.split(',').map(|side| side.trim().parse().ok()).collect();
    sides.and_then(|sides| sides.try_into().ok()).map(Crop).ok_or_else(|| {
        Error::input(format!(
            "--crop {}: give left, top, width and height in pixels, as in 0,0,800,600",
            shortened(text)
        ))
    })
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.check_outputs()?;
        let whole = read_micrograph(&self.image)?;
        let whole = match self.crop {
            Some(Crop(part)) => whole.part(part).map_err(|error| error.in_file(&self.image))?,
            None => whole,
        };
        let (bar, picture, nm_per_px) = self.scaled(&whole)?;
        let opening = self.common.opening()?;
        let given = Micrograph {
            nm_per_px,
            media: (!self.classes.is_empty()).then(|| self.classes.clone()),
            thresholds: (!self.thresholds.is_empty()).then(|| self.thresholds.clone()),
            kind: self.kind.map(|kind| match kind {
                As::Lattice => Kind::Lattice,
                As::Layers => Kind::Layers,
                As::Section => Kind::Section,
            }),
            cortex_nm: self.cortex,
            name: self
                .image
                .file_stem()
                .map_or_else(|| "traced".into(), |stem| stem.to_string_lossy().into()),
        };
        let shown = picture.as_ref().unwrap_or(&whole);
        let found = trace_image(shown, &given, opening.media.library())
            .map_err(|error| error.in_file(&self.image))?;
        let media: Vec<&str> = found.media.iter().map(String::as_str).collect();
        self.common.say_unused(&self.image.to_string_lossy(), &opening.media.unused(&media));
        if self.cortex.is_some() && found.traced.kind != Kind::Lattice {
            self.common
                .idle("--cortex", "it lies above a lattice, and none is traced; --as lattice traces one");
        } else if self.cortex.is_some() && self.output.is_none() {
            self.common.idle("--cortex", "it is of the file, and none is written");
        }
        self.write(&found, bar.map(|bar| (&whole, bar)))?;
        found.notes.iter().for_each(|note| self.common.say(note));
        if self.common.json {
            return print_json(out, &found.json());
        }
        lines(&found).iter().try_for_each(|line| print(out, line))
    }

    /// The scale bar if the scale comes from it, the picture without it, and the length of a pixel, nm.
    fn scaled(&self, whole: &Grey) -> Result<(Option<Bar>, Option<Grey>, f64)> {
        let Scale { nm, px } = self.scale;
        if let Some(px) = px {
            return Ok((None, None, nm / px));
        }
        let (bar, picture, nm_per_px) =
            scaled_by_bar(whole, nm).map_err(|error| error.in_file(&self.image))?;
        let [left, top, right, bottom] = bar.bounds;
        self.common.say(&format!(
            "scale bar found: {:.1} px, columns {left} to {right}, rows {top} to {bottom}; 1 px = {nm_per_px:.4} nm; rows {} to {} are traced",
            bar.length, bar.free[0], bar.free[1]
        ));
        Ok((Some(bar), Some(picture), nm_per_px))
    }

    /// Refuses, before any work, outputs that could not be written.
    fn check_outputs(&self) -> Result<()> {
        if let Some(path) = &self.output {
            if !is_json(path) && !has_ending(path, "toml") {
                return Err(Error::input(format!(
                    "{}: trace writes .toml (a lattice, or layers as a species) or .json (also sections); end the name with one of these",
                    path.display()
                )));
            }
            check_writable(path)?;
        }
        if let Some(path) = &self.picture {
            Format::of(path)?;
            check_writable(path)?;
        }
        Ok(())
    }

    fn write(&self, found: &TracedImage, bar: Option<(&Grey, Bar)>) -> Result<()> {
        let image = self.image.file_name().unwrap_or_default().to_string_lossy();
        if let Some(path) = &self.output {
            let source = format!("traced from {image}, 1 px = {:.4} nm", found.nm_per_px);
            let text = found.file(is_json(path), &source).map_err(|error| error.in_file(&self.image))?;
            write_whole(path, text.as_bytes())?;
            self.common.wrote(path, &summary(found));
        }
        if let Some(path) = &self.picture {
            let title = format!("{image}: {}", summary(found));
            let drawing = found.figure(&title, &barbule::plot::Page::default(), bar);
            Provenance::new(&self.common).write_figure(path, &drawing)?;
            self.common.wrote(path, "outlines, thresholds and measures over the picture");
        }
        Ok(())
    }
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending))
}

fn is_json(path: &Path) -> bool {
    has_ending(path, "json")
}

/// What was found, in a few words.
fn summary(found: &TracedImage) -> String {
    match found.traced.kind {
        Kind::Lattice => format!("a lattice of {} rods", found.traced.rods.len()),
        Kind::Layers => format!("{} layers", found.traced.layers.len()),
        Kind::Section => format!("a section with {} regions inside", found.traced.inclusions.len()),
    }
}

/// The measures, a line each.
fn lines(found: &TracedImage) -> Vec<String> {
    let nm = |name: &str, spread: Spread| {
        let Spread { mean, std } = spread.times(found.nm_per_px);
        format!("{name:<12}{mean:8.1} ± {std:.1} nm")
    };
    match (found.traced.kind, &found.traced.lattice) {
        (Kind::Lattice, Some(lattice)) => {
            let mut lines = vec![nm("period", lattice.period), nm("row pitch", lattice.row_pitch)];
            lines.push(format!(
                "{:<12}{:8.3} ± {:.3} of the period",
                "row shift", lattice.row_shift.mean, lattice.row_shift.std
            ));
            lines.push(nm("diameter", lattice.diameter));
            lines.push(nm("hollow", lattice.hollow));
            lines.extend(found.traced.cortex.map(|cortex| nm("cortex", cortex)));
            lines.push(format!("{:<12}{:6}, {} rods", "rows", lattice.rows, found.traced.rods.len()));
            lines
        }
        (Kind::Layers, _) => {
            found.traced.layers.iter().map(|l| nm(&found.media[l.class], l.thickness)).collect()
        }
        _ => {
            let mut lines =
                vec!["from the top down, and regions inside with the diameter of their area:".to_owned()];
            lines.extend(found.traced.bands.classes.iter().map(|class| found.media[*class].clone()));
            lines.extend(found.traced.inclusions.iter().map(|(class, outline)| {
                let diameter = Spread { mean: outline.diameter(), std: 0.0 };
                format!("{:<12}{:8.1} nm", found.media[*class], diameter.times(found.nm_per_px).mean)
            }));
            lines
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_lengths_over_pixels_or_over_the_bar() {
        for (text, nm, px) in [
            ("100nm=85px", 100.0, Some(85.0)),
            ("0.5um = 120.5", 500.0, Some(120.5)),
            ("2µm=bar", 2000.0, None),
        ] {
            assert_eq!(scale(text).unwrap(), Scale { nm, px });
        }
        for bad in [
            "",
            "100",
            "100=85px",
            "100nm",
            "0nm=5px",
            "100nm=0px",
            "100nm=px",
            "nm=3px",
            "1km=3px",
            "infnm=3px",
        ] {
            let error = scale(bad).unwrap_err();
            assert!(error.is_input() && error.to_string().contains("100nm=85px"), "{bad}");
        }
        assert_eq!(crop("1, 2,30,40").unwrap(), Crop([1, 2, 30, 40]));
        assert!(crop("1,2,3").is_err() && crop("-1,2,3,4").is_err());
    }
}
