//! `barbule bench render`: the renderer in figures.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use barbule::brdf::{FeatherBrdf, Options};
use barbule::io::{curves_text, make_folder, read_curves, write_together};
use barbule::scene::spline::Basis;
use barbule::{Error, Result};
use barbule_bench::render::{Effort, RenderFigures, SCATTERINGS, measure};
use barbule_bench::scenes::{BenchScene, CurveFeather};
use clap::ValueEnum;
use serde_json::json;

use crate::common::{Common, print, print_json};
use crate::materials;
use crate::progress::Terminal;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Name {
    /// The feather from near
    Close,
    /// The whole feather
    Full,
    /// A square of hair's scattering
    Hair,
    /// A square of brushed copper
    Conductor,
    /// A square of a starling's tables
    Table,
}

impl From<Name> for BenchScene {
    fn from(name: Name) -> Self {
        match name {
            Name::Close => Self::Close,
            Name::Full => Self::Full,
            Name::Hair => Self::HairQuad,
            Name::Conductor => Self::ConductorQuad,
            Name::Table => Self::TableQuad,
        }
    }
}

#[derive(Debug, clap::Args)]
pub(super) struct RenderArgs {
    /// Scenes [default: all]
    scenes: Vec<Name>,
    /// A third of a million paths of each
    #[arg(long)]
    quick: bool,
    /// Width and height of the pictures, pixels
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=4096))]
    side: Option<u32>,
    /// Samples per pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    samples: Option<u32>,
    /// Renders of each, of which the middle one counts
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=99))]
    runs: Option<u32>,
    /// Folder with the feather's curve files, feather_barbs.txt and feather_barbules.txt (B-splines, cm)
    /// [default: a feather of Barbule's own]
    #[arg(long, value_name = "DIR")]
    curves: Option<PathBuf>,
    /// Write the feather's curve files into this folder, for other renderers, and measure nothing
    #[arg(long, value_name = "DIR")]
    write_curves: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

const BARBS: &str = "feather_barbs.txt";
const BARBULES: &str = "feather_barbules.txt";

impl RenderArgs {
    pub(super) fn run(&self, out: &mut dyn Write) -> Result<()> {
        let feather = match &self.curves {
            Some(folder) => read(folder)?,
            None => CurveFeather::new(),
        };
        if let Some(folder) = &self.write_curves {
            return self.write(folder, &feather);
        }
        let usual = if self.quick { Effort::QUICK } else { Effort::USUAL };
        let effort = Effort {
            side: self.side.unwrap_or(usual.side),
            samples: self.samples.unwrap_or(usual.samples),
            runs: self.runs.unwrap_or(usual.runs),
        };
        let scenes: Vec<BenchScene> = match &self.scenes[..] {
            [] => BenchScene::ALL.to_vec(),
            given => given.iter().map(|&name| name.into()).collect(),
        };
        let tables = || {
            let (material, _) = materials::find("starling", &self.common)?;
            Ok(Arc::new(FeatherBrdf::new(&material, Options::default())?))
        };
        let mut found = Vec::new();
        for bench in scenes {
            let scene = bench.scene(&feather, tables)?;
            let progress = Terminal::new(&self.common);
            let figures = measure(scene, effort, self.common.seed, &progress)?;
            found.push((bench.name(), figures));
        }
        if self.common.json {
            return print_json(out, &document(effort, &found));
        }
        print(out, &table(effort, &found))
    }

    fn write(&self, folder: &Path, feather: &CurveFeather) -> Result<()> {
        make_folder(folder)?;
        let (barbs, barbules) = (folder.join(BARBS), folder.join(BARBULES));
        let texts = [curves_text(&feather.barbs), curves_text(&feather.barbules)];
        write_together(&[(&barbs, texts[0].as_bytes()), (&barbules, texts[1].as_bytes())])?;
        self.common.wrote(&barbs, &format!("{} curves", feather.barbs.len()));
        self.common.wrote(&barbules, &format!("{} curves", feather.barbules.len()));
        Ok(())
    }
}

fn read(folder: &Path) -> Result<CurveFeather> {
    if !folder.is_dir() {
        return Err(Error::input(format!("--curves {}: no such folder", folder.display())));
    }
    Ok(CurveFeather {
        barbs: read_curves(&folder.join(BARBS), Basis::BSpline)?,
        barbules: read_curves(&folder.join(BARBULES), Basis::BSpline)?,
    })
}

fn document(effort: Effort, found: &[(&str, RenderFigures)]) -> serde_json::Value {
    let scenes: Vec<_> = found
        .iter()
        .map(|(name, figures)| {
            json!({
                "scene": name,
                "paths_per_cpu_second": figures.paths_per_cpu_second,
                "paths_per_second": figures.paths_per_second,
                "rays_per_path": figures.rays_per_path,
                "shadow_rays_per_path": figures.shadow_rays_per_path,
                "primitives": figures.primitives,
                "hierarchy_bytes": figures.hierarchy_bytes,
                "build_seconds": figures.build_seconds,
                "peak_bytes": figures.peak_bytes,
                "mean_rgb": figures.mean,
                "noise_rgb": figures.noise.map(|noise| noise.rgb),
                "noise_luminance": figures.noise.map(|noise| noise.luminance),
            })
        })
        .collect();
    json!({
        "side": effort.side,
        "samples": effort.samples,
        "runs": effort.runs,
        "most_scatterings": SCATTERINGS,
        "scenes": scenes,
    })
}

fn table(effort: Effort, found: &[(&str, RenderFigures)]) -> String {
    let Effort { side, samples, runs } = effort;
    let mut text = format!(
        "{side} x {side} pixels, {samples} samples, {SCATTERINGS} scatterings, middle of {runs}\n\
         {:<16} {:>14} {:>9} {:>9} {:>11} {:>13} {:>9}",
        "scene", "M paths/CPU s", "rays", "shadows", "primitives", "hierarchy MB", "peak MB"
    );
    for (name, figures) in found {
        let peak =
            figures.peak_bytes.map_or_else(|| "-".into(), |bytes| format!("{:.0}", 1e-6 * bytes as f64));
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "\n{name:<16} {:>14.3} {:>9.2} {:>9.2} {:>11} {:>13.1} {peak:>9}",
            1e-6 * figures.paths_per_cpu_second,
            figures.rays_per_path,
            figures.shadow_rays_per_path,
            figures.primitives,
            1e-6 * figures.hierarchy_bytes as f64,
        );
    }
    text
}
