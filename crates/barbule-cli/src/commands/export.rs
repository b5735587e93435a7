//! `barbule export`: materials, scenes and films in files of other programs, with how near these come.

use std::io::Write;
use std::path::PathBuf;

use barbule::brdf::{FeatherBrdf, Options};
use barbule::export::{Deviation, Format, Needs, Request, Source, Written, export};
use barbule::io::{Folder, check_writable};
use barbule::open;
use barbule::resolve::Worn;
use barbule::{Error, Result, resolve};

use crate::common::{Common, LEAST_MEMORY, print_json};
use crate::progress::Terminal;
use crate::provenance::Provenance;
use crate::{materials, scene_arg};

/// Size of a `.bsdf` where nothing is said, MB.
const USUAL_MB: f64 = 40.0;

/// Memory of a `.bsdf` that is searched for over its bytes: the best so far, the next, and both as they are read.
const BSDF_MEMORY: f64 = 8.0;

/// Samples per pixel that scenes ask for.
const SAMPLES: u32 = 64;

/// A greater relative error is said aloud.
const MUCH: f64 = 0.05;

/// Arguments of `barbule export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  barbule export starling --to bsdf -o starling.bsdf --size 20
  barbule export rock-dove --to osl -o dove.osl
  barbule export starling --to mitsuba -o starling.xml
  barbule export air/keratin:595/air --to gltf -o film.gltf --json")]
pub(crate) struct Args {
    /// A material or SPECIES[:VARIANT] (bsdf, bsdf-rgb, osl, csv, exr), a preset or scene (mitsuba, pbrt, usd), or a stack of one film (gltf, openpbr)
    #[arg(value_name = "MATERIAL|SCENE|STACK")]
    what: String,
    /// What for: mitsuba, bsdf, bsdf-rgb, pbrt, osl, usd, gltf, openpbr, csv or exr
    #[arg(long, value_name = "FORMAT", value_parser = |text: &str| Format::named("--to", text))]
    to: Format,
    /// The file to write; shapes and tables that belong to it lie beside it
    #[arg(short, long, value_name = "F")]
    output: PathBuf,
    /// Most MB of a .bsdf [default: 40]: the more, the nearer it is
    #[arg(long, value_name = "MB")]
    size: Option<f64>,
    /// Leave out a part of a scene, as mattes call it: shaft, down (repeatable)
    #[arg(long, value_name = "PART")]
    without: Vec<String>,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        check_writable(&self.output)?;
        let most_bytes = self.most_bytes()?;
        if !self.without.is_empty() && !matches!(self.to, Format::Mitsuba | Format::Pbrt) {
            self.common.idle("--without", "only scenes of mitsuba and pbrt have parts to leave out");
        }
        let provenance = Provenance::new(&self.common).with("exported", &self.what);
        let request = |notes: &[(&str, &str)], source: Source<'_>| {
            let progress = Terminal::new(&self.common);
            let Self { to: format, output: path, without, .. } = self;
            export(
                source,
                &Request {
                    format: *format,
                    path,
                    most_bytes,
                    picture: None,
                    samples: SAMPLES,
                    without,
                    seed: self.common.seed,
                    notes,
                },
                &progress,
            )
        };
        let (hash, written) = match self.to.needs() {
            Needs::Material => {
                let (material, hash) = materials::find(&self.what, &self.common)?;
                let brdf = FeatherBrdf::new(&material, Options::default())?;
                let notes = provenance.with("material_hash", &hash);
                let written = request(&notes.notes(), Source::Material(&brdf))?;
                (Some(hash), written)
            }
            Needs::Scene => {
                let description = scene_arg::parse(&self.what, &self.common)?;
                let mut dye = |name: &str| -> Result<Worn> {
                    let (material, hash) = materials::find(name, &self.common)?;
                    open::worn(&material, hash)
                };
                let progress = Terminal::new(&self.common);
                let folder = Folder(open::folder_of(&self.what));
                let scene = resolve(description, &folder, &mut dye, self.common.seed, &progress)?;
                drop(progress);
                (None, request(&provenance.notes(), Source::Scene(&scene))?)
            }
            Needs::Stack => {
                let media = self.common.opening()?.media;
                let stack = open::film_stack(&self.what, media.library())?;
                (None, request(&provenance.notes(), Source::Stack(&stack, &self.what))?)
            }
        };
        self.tell(out, hash.as_deref(), &written)
    }

    fn most_bytes(&self) -> Result<usize> {
        if self.size.is_some() && !self.to.has_size() {
            self.common.idle("--size", "no table of this format is searched for");
        }
        let bytes = match self.size.unwrap_or(USUAL_MB) {
            mb if mb.is_finite() && (1.0..=2000.0).contains(&mb) => (mb * 1e6) as usize,
            mb => return Err(Error::input(format!("--size {mb}: give 1 to 2000 MB"))),
        };
        if self.to.has_size() {
            let memory = BSDF_MEMORY * bytes as f64 + LEAST_MEMORY;
            self.common.check_memory("searching for a table", memory as u64, "a smaller --size")?;
        }
        Ok(bytes)
    }

    fn tell(&self, out: &mut dyn Write, hash: Option<&str>, written: &Written) -> Result<()> {
        let mut words = format!("{:.1} MB, {}", written.bytes as f64 * 1e-6, written.what);
        if let Some(Deviation { relative_l1, bias, delta_e }) = written.deviation {
            words.push_str(&format!(
                "; off by {:.1} % (relative L1), {:+.1} % of all light, ΔE00 {delta_e:.2}",
                100.0 * relative_l1,
                100.0 * bias
            ));
        }
        self.common.wrote(&self.output, &words);
        written.remarks.iter().for_each(|remark| self.common.say(remark));
        let is_much = written.deviation.is_some_and(|deviation| deviation.relative_l1 > MUCH);
        if self.to.has_size() && is_much {
            let percent = 100.0 * MUCH;
            self.common.say(&format!(
                "over {percent:.0} %: a greater --size is nearer; the plugin of barbule.mitsuba is exact"
            ));
        }
        if !self.common.json {
            return Ok(());
        }
        let mut document = written.json();
        document["exported"] = self.what.clone().into();
        document["format"] = self.to.word().into();
        document["material_hash"] = hash.into();
        print_json(out, &document)
    }
}
