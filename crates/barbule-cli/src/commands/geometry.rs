//! `barbule geometry`: a cross section as a picture or as JSON.

use std::io::Write;
use std::path::Path;

use barbule::figures;
use barbule::io::{check_writable, section_json, write_section, write_whole};
use barbule::plot::Format;
use barbule::structure::{CutLayer, GeneratorParameters, Hummingbird, Plane, Section, Segment, Structure};
use barbule::{Error, Result};
use serde_json::{Value, json};

use crate::common::{Common, print_json};
use crate::figure::FigureArgs;
use crate::provenance::Provenance;
use crate::segment_args::{self, SegmentArgs};
use crate::structure_arg;

/// Arguments of `barbule geometry`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule geometry starling:pink --instance 3 -o starling.svg\n  \
    barbule geometry starling --three-d -o segment.svg")]
#[command(mut_arg("output", |output| output.value_name("F").help(OUTPUT)))]
pub(crate) struct Args {
    #[arg(help = structure_arg::HELP)]
    structure: String,
    /// Which random individual, or which file of a folder; the first is 0
    #[arg(long, value_name = "K", default_value_t = 0)]
    instance: usize,
    /// A segment in three dimensions: the section carried along, with roughness on each boundary
    #[arg(long)]
    three_d: bool,
    #[command(flatten)]
    segment: SegmentArgs,
    #[command(flatten)]
    figure: FigureArgs,
    #[command(flatten)]
    common: Common,
}

const OUTPUT: &str = "Where to: a picture (.svg, .pdf, .png) or the section itself (.json)";

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        if !self.three_d {
            self.segment.check_unused()?;
        }
        if self.figure.output.is_none() && !self.common.json {
            return Err(Error::input(
                "geometry: say where to write with -o F.svg, F.pdf, F.png or F.json, or give --json",
            ));
        }
        self.check_output()?;
        let structure = structure_arg::parse(&self.structure, &self.common)?;
        if self.three_d {
            return self.segment(&structure, out);
        }
        let section = structure.instance(self.common.seed, self.instance)?;
        if let Some(path) = &self.figure.output {
            if is_json(path) {
                write_section(path, &section)?;
            } else {
                let provenance = Provenance::new(&self.common).with("structure_hash", structure.hash());
                let sketch = regular(&structure, self.common.seed)?;
                let sketch = sketch.as_ref().map(|(parameters, section)| (parameters, section));
                let title = self.figure.title(figures::heading(&section.name));
                let drawing = figures::section(&section, &title, sketch, &self.figure.page()?);
                provenance.write_figure(path, &drawing)?;
            }
            self.common.wrote(path, &format!("the section {}", section.name));
        }
        if self.common.json { print_json(out, &section_json(&section)) } else { Ok(()) }
    }

    /// Draws both cuts of a segment, or writes its section with what makes it a segment.
    fn segment(&self, structure: &Structure, out: &mut dyn Write) -> Result<()> {
        let roughness = self.segment.roughness(false)?;
        let length_um = self.segment.length_um(structure);
        let segment = structure.segment(self.common.seed, self.instance, length_um, roughness)?;
        let document = || -> Result<Value> {
            let mut document = section_json(&segment.section);
            if let Value::Object(keys) = &mut document {
                keys.insert("segment".into(), segment_json(&segment)?);
            }
            Ok(document)
        };
        if let Some(path) = &self.figure.output {
            if is_json(path) {
                write_whole(path, format!("{}\n", document()?).as_bytes())?;
            } else {
                let provenance = Provenance::new(&self.common).with("structure_hash", structure.hash());
                let usual =
                    format!("{}, a segment of {length_um} µm", figures::heading(&segment.section.name));
                let drawing = figures::segment(&segment, &self.figure.title(usual), &self.figure.page()?)?;
                provenance.write_figure(path, &drawing)?;
            }
            self.common.wrote(path, &format!("a segment of {}", segment.section.name));
        }
        if self.common.json { print_json(out, &document()?) } else { Ok(()) }
    }

    /// Refuses, before any work, an output that could not be written.
    fn check_output(&self) -> Result<()> {
        let Some(path) = &self.figure.output else { return Ok(()) };
        if !is_json(path) {
            Format::of(path).map_err(|_| {
                Error::input(format!(
                    "{}: geometry writes .svg, .pdf, .png or .json; end the name with one of these",
                    path.display()
                ))
            })?;
            return self.figure.check(&self.common);
        }
        let FigureArgs { title, figure_size, font_size, figure_dpi, .. } = &self.figure;
        let given = [
            ("--title", title.is_some()),
            ("--figure-size", figure_size.is_some()),
            ("--font-size", font_size.is_some()),
            ("--figure-dpi", figure_dpi.is_some()),
        ];
        for (flag, _) in given.into_iter().filter(|(_, given)| *given) {
            self.common.idle(flag, "the section is written as JSON, not drawn");
        }
        check_writable(path)
    }
}

fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

/// Places along y at which a segment's layers are written.
const WRITTEN: usize = 400;

/// What makes a section a segment: its length and roughness, and its top and layers at x = 0 along y.
fn segment_json(segment: &Segment) -> Result<Value> {
    let cut = segment.cut(Plane::Along, segment.length_um, WRITTEN)?;
    let places = (0..WRITTEN).map(|i| (i as f64 + 0.5 - 0.5 * WRITTEN as f64) * cut.step_um);
    let layer = |layer: &CutLayer| {
        let (first, second, fraction) = &layer.media;
        json!({
            "media": [first.label(), second.label()],
            "fraction": fraction,
            "height_um": layer.height_um,
        })
    };
    let layers = |layers: &Vec<CutLayer>| layers.iter().map(layer).collect::<Vec<_>>();
    let mut document = segment_args::json_of(segment);
    document["along"] = json!({
        "y_um": places.collect::<Vec<_>>(),
        "top_um": cut.top_um,
        "layers": cut.layers.iter().map(layers).collect::<Vec<_>>(),
    });
    Ok(document)
}

/// The parameters of a hummingbird, and its section without randomness.
fn regular(structure: &Structure, seed: u64) -> Result<Option<(Hummingbird, Section)>> {
    let Structure::Species(model) = structure else { return Ok(None) };
    let GeneratorParameters::Hummingbird(parameters) = &model.parameters else { return Ok(None) };
    let mut regular = (**model).clone();
    regular.parameters = GeneratorParameters::Hummingbird(parameters.without_randomness());
    Ok(Some((parameters.clone(), regular.section(seed, 0)?)))
}
