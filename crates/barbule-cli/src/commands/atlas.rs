//! `barbule atlas`: a sweep over sizes of a structure into one store, its maps and its page.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::atlas::{Atlas, Forecast, Plan, foretell, run};
use barbule::error::counted;
use barbule::figures::{AtlasColours, atlas_map, atlas_page, claim_atlas_page, write_atlas_page};
use barbule::io::store::Survey;
use barbule::io::sweep::SweepStore;
use barbule::math::simd::Width;
use barbule::plot::Page;
use barbule::progress::Shard;
use barbule::{Error, Result};
use serde_json::{Value, json};

use crate::common::{Common, duration, print, print_json};
use crate::progress::Terminal;
use crate::provenance::{Provenance, check_outputs};
use crate::shard::{self, Parts};

/// Arguments of `barbule atlas`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  barbule atlas examples/atlas/films.toml -o films.zarr --picture films.svg\n  \
    barbule atlas examples/atlas/hummingbirds.toml --status\n  \
    barbule atlas examples/atlas/films.toml -o films.zarr --shard 0/4\n  \
    barbule atlas examples/atlas/films.toml -o films.zarr --status --shards 4\n  \
    barbule atlas examples/atlas/films.toml -o films.zarr --page films\n\n\
    The same command goes on with a store that was interrupted. --status says what is done and what is left, or before the first unit what it will take."
)]
pub(crate) struct Args {
    /// The plan: what is swept, over which sizes
    #[arg(value_name = "PLAN.toml")]
    plan: PathBuf,
    /// The store to fill, or to resume
    #[arg(short, long, value_name = "S.zarr", required_unless_present = "status")]
    output: Option<PathBuf>,
    /// Only part i of n (i from 0) of the units, for several processes on one store
    #[arg(long, value_name = "i/n", allow_hyphen_values = true, value_parser = shard::parse)]
    shard: Option<Shard>,
    /// Say what is done, what is left and who computes; of a store that is not there yet what it will take
    #[arg(long, conflicts_with_all = ["page", "picture"])]
    status: bool,
    /// With --status: what of each of n parts is done [default: as many as those that run have]
    #[arg(long, value_name = "n", requires = "status", conflicts_with = "shard", allow_hyphen_values = true,
        value_parser = shard::count)]
    shards: Option<usize>,
    /// Make a page of what is there in this folder: maps, spectra, a file of each structure
    #[arg(long, value_name = "FOLDER")]
    page: Option<PathBuf>,
    /// Draw the map of colours: .svg, .pdf or .png
    #[arg(long, value_name = "FIG")]
    picture: Option<PathBuf>,
    /// SIMD instructions to compute with, alike on all machines of one store [default: the widest of this processor]
    #[arg(long, value_name = "NAME", value_parser = Width::named)]
    simd: Option<Width>,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let (plan, folder) = Plan::open(&self.plan)?;
        let opening = self.common.opening()?;
        let progress = Terminal::new(&self.common);
        let width = self.simd.unwrap_or_default();
        let atlas =
            Atlas::new(&plan, &folder, &opening, width, &progress).map_err(|e| e.in_file(&self.plan))?;
        check_outputs(self.picture.as_deref(), None)?;
        if self.status {
            return self.report(&atlas, &progress, out);
        }
        let Some(path) = &self.output else { return Err(Error::input("give the store's name with -o")) };
        if let Some(folder) = &self.page {
            claim_atlas_page(folder, &atlas).map_err(|error| error.at("--page"))?;
        }
        if self.picture.is_some() {
            AtlasColours::check(&atlas)?;
        }
        let store = atlas.create(path)?;
        let mut document = self.compute(&atlas, &store, path, &progress)?;
        drop(progress);
        self.draw(&atlas, &store)?;
        if self.common.json {
            let status = status(&atlas, &store, &store.survey());
            if let (Value::Object(all), Value::Object(status)) = (&mut document, status) {
                all.extend(status);
            }
            return print_json(out, &document);
        }
        Ok(())
    }

    /// Computes what is missing of the units that are asked for; what was done.
    fn compute(&self, atlas: &Atlas, store: &SweepStore, path: &Path, progress: &Terminal) -> Result<Value> {
        let units = atlas.units(self.shard.unwrap_or(Shard::WHOLE));
        if units.iter().all(|unit| store.is_whole(*unit)) {
            store.prepare_writing()?;
            store.end_writing();
            self.common.say("everything is there already: nothing to do");
            return Ok(json!({"computed": 0, "found": units.len(), "repaired": 0, "unit_seconds": []}));
        }
        if !(0..atlas.layout().units()).any(|unit| store.is_done(unit)) {
            let forecast = foretell(atlas, progress)?;
            let remedy = "fewer angles, wavelengths or individuals, or --threads";
            self.common.check_memory("the atlas", forecast.memory_bytes, remedy)?;
            self.common.say(&words(&forecast));
        }
        let _announced = store.announce(self.shard.unwrap_or(Shard::WHOLE));
        let outcome = run(atlas, store, &units, progress).map_err(|error| {
            if !error.is_interrupted() {
                return error;
            }
            let done = units.iter().filter(|unit| store.is_done(**unit)).count();
            Error::interrupted_after(format!(
                "{done} of {} units done; the same command goes on",
                units.len()
            ))
        })?;
        if outcome.repaired > 0 {
            self.common.say(&format!("{} damaged units were computed again", outcome.repaired));
        }
        let what = format!(
            "the atlas {}, {} of {} units ({})",
            atlas.name(),
            outcome.computed + outcome.found,
            atlas.layout().units(),
            counted(atlas.cells(), "structure"),
        );
        self.common.wrote(path, &what);
        Ok(json!({
            "computed": outcome.computed,
            "found": outcome.found,
            "repaired": outcome.repaired,
            "unit_seconds": outcome.seconds,
        }))
    }

    /// Draws the map and makes the page, as asked.
    fn draw(&self, atlas: &Atlas, store: &SweepStore) -> Result<()> {
        let provenance = Provenance::new(&self.common);
        if let Some(path) = &self.picture {
            let colours = AtlasColours::read(atlas, store)?;
            let map = atlas_map(atlas.name(), atlas, &colours, &Page::default())?;
            provenance.write_figure(path, &map)?;
            self.common.wrote(path, &format!("the colours of {}", atlas.name()));
        }
        let Some(folder) = &self.page else { return Ok(()) };
        let files = atlas_page(atlas, store, &provenance.notes())?;
        write_atlas_page(folder, &files)?;
        self.common
            .wrote(folder, &format!("index.html, map.svg and {}", counted(files.len() - 2, "structure")));
        Ok(())
    }

    fn report(&self, atlas: &Atlas, progress: &Terminal, out: &mut dyn Write) -> Result<()> {
        let store = match &self.output {
            Some(path) if path.exists() => Some(atlas.open(path)?),
            _ => None,
        };
        let surveyed = store.map(|store| (store.survey(), store));
        let is_begun =
            |survey: &Survey| survey.status().missing() < survey.status().units || !survey.runs().is_empty();
        let Some((survey, store)) = surveyed.filter(|(survey, _)| is_begun(survey)) else {
            let forecast = foretell(atlas, progress)?;
            return match self.common.json {
                true => print_json(out, &forecast_json(atlas, &forecast)),
                false => print(out, &format!("{}: {}", atlas.name(), words(&forecast))),
            };
        };
        let parts = Parts::of(&survey, self.shard, self.shards);
        let mut document = status(atlas, &store, &survey);
        if self.common.json {
            document["shards"] = parts.json();
            return print_json(out, &document);
        }
        let number = |key: &str| document[key].as_u64().unwrap_or(0);
        let left = match document["seconds_left"].as_f64() {
            Some(seconds) if seconds > 0.0 => {
                format!(", about {} of one process like those before left", duration(seconds))
            }
            _ => String::new(),
        };
        let text = format!(
            "{}: {} of {} units done, {} missing, {} damaged; {:.1} MB{left}",
            atlas.name(),
            number("done"),
            number("units"),
            number("missing"),
            number("damaged"),
            number("bytes") as f64 / 1e6,
        );
        print(out, &text)?;
        parts.lines().iter().try_for_each(|line| print(out, line))
    }
}

/// How far a store is.
fn status(atlas: &Atlas, store: &SweepStore, survey: &Survey) -> Value {
    let (status, seconds) = (survey.status(), store.seconds());
    let left = status.units - status.done;
    let mean = seconds.iter().sum::<f64>() / seconds.len().max(1) as f64;
    let seconds_left = (left == 0 || !seconds.is_empty()).then_some(mean * left as f64);
    json!({
        "name": atlas.name(),
        "structures": atlas.cells(),
        "units": status.units,
        "done": status.done,
        "missing": status.missing(),
        "damaged": status.damaged,
        "seconds_left": seconds_left,
        "bytes": store.bytes(),
        "simd": store.layout().width,
        "running": shard::running(survey),
    })
}

fn forecast_json(atlas: &Atlas, forecast: &Forecast) -> Value {
    json!({
        "name": atlas.name(),
        "structures": forecast.cells,
        "units": forecast.units,
        "done": 0,
        "missing": forecast.units,
        "damaged": 0,
        "seconds_left": forecast.seconds,
        "cores": forecast.cores,
        "core_hours": forecast.core_hours(),
        "cell_seconds": forecast.cell_seconds,
        "files": forecast.files,
        "bytes": forecast.bytes,
        "memory_bytes": forecast.memory_bytes,
    })
}

/// What an atlas will take, in words.
fn words(forecast: &Forecast) -> String {
    let Forecast { cells, units, files, bytes, memory_bytes, cores, seconds, .. } = forecast;
    format!(
        "{} in {}: about {} on {} ({:.2} core-hours), {files} files of {:.1} MB together, up to {} MB of memory",
        counted(*cells, "structure"),
        counted(*units, "unit"),
        duration(*seconds),
        counted(*cores, "core"),
        forecast.core_hours(),
        *bytes as f64 / 1e6,
        memory_bytes.div_ceil(1_000_000),
    )
}
