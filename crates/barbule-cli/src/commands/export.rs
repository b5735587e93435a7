//! `barbule export`: materials in files of other programs, with what these make of them.

use std::io::Write;
use std::path::PathBuf;

use barbule::brdf::{FeatherBrdf, Options};
use barbule::export::{BsdfTable, Deviation, Flavour};
use barbule::io::{check_writable, encode_bsdf, write_whole};
use barbule::{Error, Result};
use clap::ValueEnum;
use serde_json::{Value, json};

use crate::common::{Common, LEAST_MEMORY, path_json, print_json};
use crate::materials;
use crate::progress::Terminal;
use crate::provenance::Provenance;

/// Size of a `.bsdf` where nothing is said, MB.
const USUAL_MB: f64 = 40.0;

/// Memory of a `.bsdf` that is searched for over its bytes: the best so far, the next, and both as they are read.
const BSDF_MEMORY: f64 = 8.0;

/// A greater relative error is said aloud.
const MUCH: f64 = 0.05;

/// Arguments of `barbule export`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  barbule export starling --to bsdf -o starling.bsdf --size 20\n  barbule export rock-dove --to bsdf-rgb -o dove.bsdf --json"
)]
pub(crate) struct Args {
    /// A material file, or SPECIES[:VARIANT]
    #[arg(help = materials::HELP)]
    material: String,
    /// What for
    #[arg(long, value_name = "FORMAT")]
    to: Format,
    /// The file to write
    #[arg(short, long, value_name = "F")]
    output: PathBuf,
    /// Most MB of a .bsdf [default: 40]: the more, the nearer it is
    #[arg(long, value_name = "MB")]
    size: Option<f64>,
    #[command(flatten)]
    common: Common,
}

/// What other programs read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// RGL tables over wavelengths, for Mitsuba's and pbrt's `measured`
    Bsdf,
    /// The same of red, green and blue
    BsdfRgb,
}

/// What was written.
struct Written {
    what: String,
    bytes: usize,
    deviation: Deviation,
    /// More for JSON.
    details: Value,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        check_writable(&self.output)?;
        let most_bytes = self.most_bytes()?;
        let (material, hash) = materials::find(&self.material, &self.common)?;
        let brdf = FeatherBrdf::new(&material, Options::default())?;
        let provenance =
            Provenance::new(&self.common).with("material", &self.material).with("material_hash", &hash);
        let written = match self.to {
            Format::Bsdf => self.bsdf(&brdf, Flavour::Spectral, most_bytes, &provenance),
            Format::BsdfRgb => self.bsdf(&brdf, Flavour::Rgb, most_bytes, &provenance),
        }?;
        self.tell(out, &hash, &written)
    }

    fn most_bytes(&self) -> Result<usize> {
        match self.size.unwrap_or(USUAL_MB) {
            mb if mb.is_finite() && (1.0..=2000.0).contains(&mb) => Ok((mb * 1e6) as usize),
            mb => Err(Error::input(format!("--size {mb}: give 1 to 2000 MB"))),
        }
    }

    fn bsdf(
        &self,
        brdf: &FeatherBrdf,
        flavour: Flavour,
        most_bytes: usize,
        provenance: &Provenance,
    ) -> Result<Written> {
        let memory = BSDF_MEMORY * most_bytes as f64 + LEAST_MEMORY;
        self.common.check_memory("searching for a table", memory as u64, "a smaller --size")?;
        let progress = Terminal::new(&self.common);
        let table = BsdfTable::of(brdf, flavour, most_bytes, &progress)?;
        drop(progress);
        let mut about = provenance.json();
        about["frame"] =
            "x along the barbule, z out of its upper side; indexed by the viewer's direction".into();
        let bytes = encode_bsdf(&table.arrays, &about.to_string());
        write_whole(&self.output, &bytes)?;
        let r = &table.resolution;
        let values = table.arrays.values.len() / table.arrays.luminance.len();
        Ok(Written {
            what: format!("{} × {} directions, {values} × {}² values each", r.thetas, r.phis, r.values),
            bytes: bytes.len(),
            deviation: table.deviation,
            details: json!({
                "theta_i": r.thetas, "phi_i": r.phis, "channels": values, "values": r.values, "normals": r.normals,
                "sigma": table.crowding.sigma, "tail": table.crowding.tail, "m2": table.crowding.m2,
                "even": table.crowding.even,
            }),
        })
    }

    fn tell(&self, out: &mut dyn Write, hash: &str, written: &Written) -> Result<()> {
        let Deviation { relative_l1, bias, delta_e } = written.deviation;
        let mb = written.bytes as f64 * 1e-6;
        self.common.wrote(
            &self.output,
            &format!(
                "{mb:.1} MB, {}; off by {:.1} % (relative L1), {:+.1} % of all light, ΔE00 {delta_e:.2}",
                written.what,
                100.0 * relative_l1,
                100.0 * bias
            ),
        );
        if relative_l1 > MUCH {
            self.common.say(&format!(
                "over {:.0} %: a greater --size is nearer; the plugin of barbule.mitsuba is exact",
                100.0 * MUCH
            ));
        }
        if !self.common.json {
            return Ok(());
        }
        print_json(
            out,
            &json!({
                "material": self.material, "material_hash": hash, "file": path_json(&self.output),
                "bytes": written.bytes, "relative_l1": relative_l1, "bias": bias, "delta_e": delta_e,
                "table": written.details,
            }),
        )
    }
}
