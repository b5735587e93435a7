//! `barbule bench`: speed in figures, as ratios from one run.

mod render;

use std::fmt::Write as _;
use std::io::Write;

use barbule::Result;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::math::simd::Width;
use barbule::structure::crystal_species;
use barbule_bench::campaign::{CampaignFigures, measure};
use barbule_bench::{brdf, crystal};
use serde_json::json;

use crate::common::{Common, print, print_json};
use crate::progress::Terminal;
use crate::{materials, structure_arg};

/// Arguments of `barbule bench`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  barbule bench campaign starling\n  barbule bench crystal mallard\n  barbule bench render close\n  barbule bench brdf mallard"
)]
pub(crate) struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// Simulation: illuminations per second, shares of stages, a full campaign extrapolated, the plain evaluation
    Campaign(CampaignArgs),
    /// Photonic crystals: seconds of each solver, ratios and differences to the multipoles, a full table extrapolated
    Crystal(CrystalArgs),
    /// Renderer: paths per CPU second, rays, memory, on the scenes that other renderers are measured on
    Render(render::RenderArgs),
    /// Values of a material: ns of an instance, of the mean, of many together and of a drawn direction, and the plain evaluation
    Brdf(BrdfArgs),
}

#[derive(Debug, clap::Args)]
struct BrdfArgs {
    /// A material, or a structure whose material is at hand or is made
    #[arg(value_name = "MATERIAL", default_value = "starling")]
    material: String,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, clap::Args)]
struct CampaignArgs {
    #[arg(help = structure_arg::HELP, default_value = "starling")]
    structure: String,
    /// SIMD instructions to compute with [default: the widest of this processor]
    #[arg(long, value_name = "NAME", value_parser = Width::named)]
    simd: Option<Width>,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, clap::Args)]
struct CrystalArgs {
    /// mallard, magpie or peafowl[:VARIANT], a species .toml of a crystal, or a lattice [default: these three]
    structure: Vec<String>,
    /// One point only
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        match &self.what {
            What::Campaign(args) => args.run(out),
            What::Crystal(args) => args.run(out),
            What::Render(args) => args.run(out),
            What::Brdf(args) => args.run(out),
        }
    }
}

impl CampaignArgs {
    fn run(&self, out: &mut dyn Write) -> Result<()> {
        let structure = structure_arg::parse(&self.structure, &self.common)?;
        let name = structure.name();
        let width = self.simd.unwrap_or_default();
        let progress = Terminal::new(&self.common);
        let figures = measure(&structure, self.common.seed, width, &progress)?;
        drop(progress);
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

impl BrdfArgs {
    fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let (material, _) = materials::find(&self.material, &self.common)?;
        let progress = Terminal::new(&self.common);
        let figures = brdf::measure(&FeatherBrdf::new(&material, Options::default())?, &progress)?;
        drop(progress);
        let rows = [
            ("instance_ns", "four wavelengths of an instance", figures.instance_ns),
            ("smooth_ns", "four wavelengths of the mean", figures.smooth_ns),
            ("together_ns", "an instance's among 256 pairs together", figures.together_ns),
            ("sample_ns", "a direction drawn with its density", figures.sample_ns),
        ];
        if self.common.json {
            let mut document = json!({
                "material": self.material,
                "plain_ratio": figures.plain_ratio,
                "largest_difference": figures.difference,
            });
            rows.iter().for_each(|(key, _, ns)| document[*key] = json!(ns));
            return print_json(out, &document);
        }
        for (_, what, ns) in rows {
            print(out, &format!("{what:<40} {ns:7.1} ns"))?;
        }
        print(
            out,
            &format!(
                "plain evaluation: {:.0} times slower, the same within {:.0e} of the largest value",
                figures.plain_ratio, figures.difference
            ),
        )
    }
}

impl CrystalArgs {
    fn run(&self, out: &mut dyn Write) -> Result<()> {
        let names = match &self.structure[..] {
            [] => crystal_species().map(str::to_owned).collect(),
            given => given.to_vec(),
        };
        let lattices = names
            .iter()
            .map(|name| structure_arg::lattice(name, &self.common))
            .collect::<Result<Vec<_>>>()?;
        let effort = if self.quick { crystal::Effort::Least } else { crystal::Effort::Usual };
        let mut found = Vec::new();
        for (name, lattice) in names.iter().zip(&lattices) {
            let progress = Terminal::new(&self.common);
            let figures = crystal::measure(lattice, effort, &progress)?;
            drop(progress);
            if self.common.json {
                found.push(crystal_document(name, &figures));
            } else {
                print(out, &crystal_table(name, &figures))?;
            }
        }
        if self.common.json { print_json(out, &json!({ "crystals": found })) } else { Ok(()) }
    }
}

fn crystal_document(name: &str, figures: &crystal::CrystalFigures) -> serde_json::Value {
    let solvers: Vec<_> = figures
        .solvers
        .iter()
        .map(|solver| {
            json!({
                "solver": solver.name,
                "points": solver.points,
                "cpu_seconds": solver.seconds,
                "cpu_seconds_per_polarization": 0.5 * solver.seconds,
                "ratio": solver.ratio,
                "largest_difference": solver.difference,
                "largest_imbalance": solver.imbalance,
            })
        })
        .collect();
    json!({
        "structure": name,
        "solvers": solvers,
        "table_point_cpu_seconds": figures.table_point_seconds,
        "table_points": crystal::TABLE,
        "table_cpu_seconds": figures.table_seconds(),
    })
}

fn crystal_table(name: &str, figures: &crystal::CrystalFigures) -> String {
    let mut text = format!(
        "{name}\n  {:<39} {:>6} {:>11} {:>8} {:>11} {:>11}",
        "one λ and direction, both polarizations", "points", "CPU ms", "ratio", "error of R", "balance"
    );
    for solver in &figures.solvers {
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "\n  {:<39} {:>6} {:>11.3} {:>8.1} {:>11.1e} {:>11.1e}",
            solver.name,
            solver.points,
            1e3 * solver.seconds,
            solver.ratio,
            solver.difference,
            solver.imbalance
        );
    }
    let [wavelengths, thetas, azimuths] = crystal::TABLE;
    text + &format!(
        "\n  table by multipoles, {wavelengths} λ × {thetas} θ × {azimuths} φ: {:.3} CPU ms a point, {:.0} CPU s",
        1e3 * figures.table_point_seconds,
        figures.table_seconds()
    )
}

fn table(name: &str, width: Width, figures: &CampaignFigures) -> String {
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
