//! Heightfields as they are named on a command line: a sample or a file.

use std::path::Path;

use barbule::error::{did_you_mean, shortened};
use barbule::fields::typed_in_nm;
use barbule::io::{Clean, HeightUnit, HeightsOptions, foretell_heights, read_heights};
use barbule::structure::{Heightfield, SAMPLES};
use barbule::{Error, Result};

use crate::common::{Common, LEAST_MEMORY};

/// Which heights, and what their file does not say.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct HeightsArgs {
    /// Measured heights (.npy, .tif, .png, .gwy, rows of numbers, Gwyddion's text), or a sample: elaphe, xenopeltis,
    /// blazed, sinusoid
    #[arg(value_name = "HEIGHTS|SAMPLE")]
    heights: String,
    /// Distance of neighbouring heights of a file, µm
    #[arg(long, value_name = "UM", value_parser = micrometres)]
    pitch: Option<f64>,
    /// Unit of a file's numbers [default: um]
    #[arg(long, value_enum, value_name = "UNIT")]
    unit: Option<Unit>,
    /// Height between black and white of a picture, µm
    #[arg(long, value_name = "UM", value_parser = micrometres)]
    range: Option<f64>,
    /// Whether a file's heights are levelled, clipped and blended at their edges [default: auto]
    #[arg(long, value_enum, value_name = "WHEN")]
    clean: Option<Cleaned>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Unit {
    Um,
    Nm,
    M,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Cleaned {
    /// Unless opposite edges fit each other
    Auto,
    Always,
    Never,
}

/// Heights that are farther apart than this, µm, are more likely so many nm apart.
const MOST_USUAL_PITCH_UM: f64 = 10.0;

fn micrometres(text: &str) -> std::result::Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|value| (1e-6..=1e4).contains(value));
    number.ok_or_else(|| "give a number of µm over 0 and up to 10000, as in 0.0488".into())
}

impl HeightsArgs {
    /// The heights and what they are called; says where they were cleaned unasked.
    pub(crate) fn read(&self, common: &Common) -> Result<(Heightfield, String)> {
        if let Some(bytes) = foretell_heights(Path::new(&self.heights), &self.options()) {
            let what = format!("reading {}", shortened(&self.heights));
            common.check_memory(&what, LEAST_MEMORY as u64 + bytes, "a smaller file")?;
        }
        let (field, name, is_cleaned) = self.open(common.seed)?;
        if let Some(pitch_um) = self.pitch {
            // Farther apart nothing that diffracts is resolved.
            let meant = typed_in_nm(pitch_um, &(1e-6..=MOST_USUAL_PITCH_UM));
            if !meant.is_empty() {
                common.say(&format!("--pitch {pitch_um}: heights {pitch_um} µm apart{meant}"));
            }
        }
        if is_cleaned && self.clean.is_none_or(|clean| clean == Cleaned::Auto) {
            common.say("opposite edges of these heights do not fit: they were levelled, clipped and blended at the edges; --clean never leaves them as they are");
        }
        Ok((field, name))
    }

    /// The same, and whether they were cleaned; says nothing.
    pub(crate) fn open(&self, seed: u64) -> Result<(Heightfield, String, bool)> {
        let path = Path::new(&self.heights);
        if let Some(sample) = Heightfield::sample(&self.heights, seed) {
            let given = [
                ("--pitch", self.pitch.is_some()),
                ("--unit", self.unit.is_some()),
                ("--range", self.range.is_some()),
                ("--clean", self.clean.is_some()),
            ];
            if let Some((flag, _)) = given.into_iter().find(|(_, given)| *given) {
                return Err(Error::input(format!(
                    "{flag} is of files, but {} is a sample; leave it out",
                    self.heights
                )));
            }
            return Ok((sample?, self.heights.clone(), false));
        }
        if !path.exists() && path.extension().is_none() {
            let near = did_you_mean(&self.heights, SAMPLES);
            return Err(Error::input(format!(
                "{}: no such file or sample{near}; samples are {}",
                shortened(&self.heights),
                SAMPLES.join(", ")
            )));
        }
        let name =
            path.file_stem().map_or_else(|| "heights".into(), |name| name.to_string_lossy().into_owned());
        let (field, is_cleaned) = read_heights(path, &self.options())?;
        Ok((field, name, is_cleaned))
    }
    /// How a file is read.
    fn options(&self) -> HeightsOptions {
        HeightsOptions {
            pitch_um: self.pitch,
            unit: self.unit.map(|unit| match unit {
                Unit::Um => HeightUnit::Micrometre,
                Unit::Nm => HeightUnit::Nanometre,
                Unit::M => HeightUnit::Metre,
            }),
            range_um: self.range,
            clean: match self.clean {
                None | Some(Cleaned::Auto) => Clean::Auto,
                Some(Cleaned::Always) => Clean::Always,
                Some(Cleaned::Never) => Clean::Never,
            },
        }
    }
}
