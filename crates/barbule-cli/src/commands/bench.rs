//! `barbule bench`: speed in figures, as ratios from one run.

use std::io::Write;

use barbule::Result;
use barbule::campaign::figures::{Figures, measure};
use barbule::math::simd::Width;
use serde_json::json;

use crate::common::{Common, print, print_json};
use crate::progress::Terminal;
use crate::structure_arg;

/// Arguments of `barbule bench`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  barbule bench campaign starling")]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// Simulation: illuminations per second, shares of stages, a full campaign extrapolated, the plain evaluation
    Campaign(CampaignArgs),
}

#[derive(Debug, clap::Args)]
struct CampaignArgs {
    #[arg(help = structure_arg::HELP, default_value = "starling")]
    structure: String,
    /// SIMD instructions to compute with [default: the widest of this processor]
    #[arg(long, value_name = "NAME")]
    simd: Option<String>,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        match &self.what {
            What::Campaign(args) => args.run(out),
        }
    }
}

impl CampaignArgs {
    fn run(&self, out: &mut dyn Write) -> Result<()> {
        let structure = structure_arg::parse(&self.structure, &self.common)?;
        let name = structure.name();
        let width = self.simd.as_deref().map_or_else(|| Ok(Width::best()), Width::named)?;
        let observer = Terminal::new(&self.common);
        let figures = measure(&structure, self.common.seed, width, &observer)?;
        drop(observer);
        let total: f64 = figures.stages.iter().map(|(_, seconds)| seconds).sum();
        let share = |seconds: f64| seconds / total;
        if self.common.json {
            let stages: serde_json::Map<_, _> =
                figures.stages.iter().map(|(stage, s)| ((*stage).to_owned(), json!(share(*s)))).collect();
            return print_json(
                out,
                &json!({
                    "structure": name,
                    "simd": width.name(),
                    "rays_per_element": figures.rays,
                    "instance_cpu_seconds": figures.instance_seconds,
                    "table_cpu_seconds": figures.table_seconds,
                    "table_bytes": figures.table_bytes,
                    "unit_cpu_seconds": figures.unit_seconds,
                    "illuminations": figures.illuminations,
                    "illuminations_per_cpu_second": figures.illuminations_per_second(),
                    "campaign_cpu_seconds": figures.full_seconds,
                    "stages": stages,
                    "plain_ratio": figures.plain_ratio,
                }),
            );
        }
        print(out, &table(&name, width, &figures))?;
        for (stage, seconds) in &figures.stages {
            print(out, &format!("  {stage:<34} {:5.1} %", 100.0 * share(*seconds)))?;
        }
        print(out, &format!("plain evaluation: {:.0} times slower per illumination", figures.plain_ratio))
    }
}

fn table(name: &str, width: Width, figures: &Figures) -> String {
    let tables = 50.0 * figures.table_seconds;
    let rays = figures.rays.map_or(String::new(), |rays| format!(", {rays} rays per element"));
    let what = if figures.rays.is_some() { "reflectance tables" } else { "orders of the crystal" };
    format!(
        "{name}, {} instructions{rays}\n\
         illuminations per CPU second     {:>8.0}\n\
         a full campaign ({} million)      {:>8.0} CPU s\n\
         \u{20} of these {what:<20}  {:>8.0} CPU s\n\
         preparing one instance           {:>8.1} CPU ms\n\
         tables of one wavelength         {:>8.0} MB\n\
         the fields of one unit:",
        width.name(),
        figures.illuminations_per_second(),
        figures.illuminations / 1_000_000,
        figures.full_seconds,
        tables,
        1e3 * figures.instance_seconds,
        1e-6 * figures.table_bytes as f64,
    )
}
