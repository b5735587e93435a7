//! `barbule lobes`: pictures of a material's BRDF, its parameters, its noise and its fits, and their numbers.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::brdf::FeatherMaterial;
use barbule::characterize::CampaignDescription;
use barbule::error::shortened;
use barbule::figures::{
    self, FieldPatterns, FitCurves, Hemispheres, InstancePatterns, NoiseCurves, ParameterMaps, tiled,
};
use barbule::io::store::Store;
use barbule::plot::Drawing;
use barbule::progress::Progress;
use barbule::scattering::statistics::Statistics;
use barbule::{Error, Result};
use serde::Serialize;
use serde_json::{Value, json};

use crate::arguments::spoken;
use crate::common::{Common, print_json};
use crate::figure::FigureArgs;
use crate::materials;
use crate::progress::Terminal;
use crate::provenance::Provenance;

/// Most instances in one picture.
const MOST_INSTANCES: usize = 20;

/// Pixels across a hemisphere in figures, and in JSON, which would be forty megabytes otherwise.
const PIXELS: usize = 240;
const JSON_PIXELS: usize = 60;

/// Arguments of `barbule lobes`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  barbule lobes starling -o lobes.png --instances 3\n  barbule lobes starling --parameters --json"
)]
pub(crate) struct Args {
    /// A material file, or SPECIES[:VARIANT]
    material: String,
    #[command(flatten)]
    figure: FigureArgs,
    /// Draw maps of m_eff, φ_eff − φ_i and F_eff over cosθ_i and cosφ_i
    #[arg(long, group = "what")]
    parameters: bool,
    /// Draw simulated and fitted U and V at 0° and 70°
    #[arg(long, group = "what")]
    fits: bool,
    /// Draw a single barbule's field over x_o for three φ_i and three wavelengths
    #[arg(long, group = "what")]
    fields: bool,
    /// Draw the noise: autocovariances, spectrum and some functions
    #[arg(long, group = "what")]
    noise: bool,
    /// Instances below the smooth lobes, and as many simulated beside synthesized ones [default: 3, synthesized only]
    #[arg(long, value_name = "N", conflicts_with = "what")]
    instances: Option<usize>,
    #[command(flatten)]
    common: Common,
}

/// What was asked for.
struct Answer {
    /// Its key in the JSON document, and what it is in words.
    key: &'static str,
    words: &'static str,
    /// The numbers, where JSON is asked for.
    json: Option<Value>,
    /// The figure, where one is asked for.
    drawing: Option<Drawing>,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        self.figure.check_rigid(&self.common)?;
        if self.figure.path().is_none() && !self.common.json {
            return Err(Error::input("give -o FIG for the figure, or --json for the numbers that it shows"));
        }
        let instances = self.instances.unwrap_or(3);
        if instances > MOST_INSTANCES {
            return Err(Error::input(format!(
                "--instances {instances}: give at most {MOST_INSTANCES}, one row of the picture each"
            )));
        }
        let (material, hash) = materials::find(&self.material, &self.common)?;
        let title = self.figure.title(figures::title(&material));
        let Answer { key, words, json, drawing } = self.answer(&material, &title)?;
        if let (Some(path), Some(drawing)) = (self.figure.path(), drawing) {
            Provenance::new(&self.common)
                .with("material", &self.material)
                .with("material_hash", &hash)
                .write_figure(path, &self.figure.page()?.place(drawing))?;
            self.common.wrote(path, &format!("{words} of {title}"));
        }
        match json {
            Some(numbers) => print_json(
                out,
                &json!({"material": self.material, "material_hash": hash, "title": title, key: numbers}),
            ),
            None => Ok(()),
        }
    }

    fn answer(&self, material: &FeatherMaterial, title: &str) -> Result<Answer> {
        let progress = Terminal::new(&self.common);
        let barbules = || materials::barbules(material, &self.common);
        if self.parameters {
            let maps = ParameterMaps::new(material)?;
            let draw = || tiled(maps.draw(), 4, title);
            return self.of("parameters", "maps of the parameters", &maps, draw);
        }
        if self.noise {
            let barbules = barbules()
                .inspect_err(|error| self.common.say(&format!("no single barbules: {}", spoken(error))))
                .ok();
            let curves = NoiseCurves::new(material, barbules.as_ref(), &progress)?;
            return self.of("noise", "the noise", &curves, || tiled(curves.draw(), 2, title));
        }
        if self.fields {
            let patterns = FieldPatterns::new(material, &barbules()?, &progress)?;
            let draw = || tiled(patterns.draw(), 2, title);
            return self.of("fields", "fields of a single barbule", &patterns, draw);
        }
        if self.fits {
            let statistics = match self.store_beside() {
                Some(store) => stored(material, &store)?,
                None => figures::statistics_of_fits(material, &barbules()?, &progress)?,
            };
            let fits = FitCurves::of(material, &statistics)?;
            let draw = || tiled(fits.iter().map(FitCurves::draw).collect(), 2, title);
            return self.of("fits", "simulated and fitted U and V", &fits, draw);
        }
        self.hemispheres(material, title, &progress)
    }

    /// The lobes, and the patterns of instances where their number was given.
    fn hemispheres(
        &self,
        material: &FeatherMaterial,
        title: &str,
        progress: &dyn Progress,
    ) -> Result<Answer> {
        let patterns = |count: usize| match materials::barbules(material, &self.common) {
            Ok(barbules) => InstancePatterns::new(material, count, &barbules, progress).map(Some),
            Err(error) => {
                self.common.say(&format!("synthesized instances only: {}", spoken(&error)));
                Ok(None)
            }
        };
        let patterns = self.instances.filter(|count| *count > 0).map(patterns).transpose()?.flatten();
        let lobes = |pixels| Hemispheres::new(material, self.instances.unwrap_or(3), pixels);
        let drawing = || -> Result<Drawing> {
            let above = lobes(PIXELS)?.draw(title);
            patterns.as_ref().map_or(Ok(above.clone()), |patterns| Ok(below(above.clone(), patterns.draw()?)))
        };
        let numbers = || Ok(json!({"hemispheres": lobes(JSON_PIXELS)?, "patterns": patterns}));
        Ok(Answer {
            key: "lobes",
            words: "the lobes",
            json: self.common.json.then(numbers).transpose()?,
            drawing: self.figure.path().is_some().then(drawing).transpose()?,
        })
    }

    fn of(
        &self,
        key: &'static str,
        words: &'static str,
        numbers: &impl Serialize,
        draw: impl FnOnce() -> Drawing,
    ) -> Result<Answer> {
        let value =
            || serde_json::to_value(numbers).map_err(|e| Error::machine(format!("no JSON form: {e}")));
        Ok(Answer {
            key,
            words,
            json: self.common.json.then(value).transpose()?,
            drawing: self.figure.path().is_some().then(draw),
        })
    }

    /// The store of a material's file under the same name; materials that are found by a structure's name have none.
    fn store_beside(&self) -> Option<PathBuf> {
        let path = Path::new(&self.material);
        Some(path.with_extension("zarr")).filter(|store| path.is_file() && store.is_dir())
    }
}

/// The statistics of the store that a material was fitted to.
fn stored(material: &FeatherMaterial, beside: &Path) -> Result<Statistics> {
    let store = Store::open(beside)?;
    let (ours, theirs) = (&material.info["campaign"], store.description());
    let [here, there] = [ours, theirs].map(CampaignDescription::read);
    let there = there.map_err(|e| e.at(beside.display()))?;
    if !here.is_ok_and(|here| here == there) {
        let name = material.info["name"].as_str().map_or_else(|| "an unnamed structure".into(), shortened);
        return Err(Error::input(format!(
            "{}: is not the campaign that the material was fitted to (of {} there, of {name} here, or with other \
             options); fit the material from this store, or move it away",
            beside.display(),
            shortened(store.name()),
        )));
    }
    store.statistics()
}

/// One drawing below another.
fn below(above: Drawing, below: Drawing) -> Drawing {
    let mut page = Drawing::new(above.width.max(below.width), above.height + below.height);
    let height = above.height;
    page.place(above, [0.0, 0.0]);
    page.place(below, [0.0, height]);
    page
}
