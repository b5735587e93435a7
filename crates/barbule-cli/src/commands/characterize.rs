//! `barbule characterize`: from a structure to its material in one go.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::brdf::fit::FitOptions;
use barbule::campaign::{Keep, Resources, Results};
use barbule::characterize::{
    Catalog, Characterized, Execution, HaloPlan, Plan, characterize, check, thinned,
};
use barbule::io::{check_writable, write_material};
use barbule::{Error, Result};

use crate::campaign::{CampaignArgs, FitArgs, expected, say_repaired, summary, units_at_once};
use crate::common::{Common, path_json, print, print_json};
use crate::progress::Terminal;
use crate::structure_arg::SideArg;
use crate::{materials, structure_arg};

/// Arguments of `barbule characterize`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule characterize starling:pink --thin 4 -o pink.barbule\n  \
    barbule characterize starling --side below --thin 10 -o underside.barbule\n  \
    barbule characterize my-species.toml -o mine.barbule\n  \
    barbule characterize rock-dove --halo -o dove-3d.barbule")]
pub(crate) struct Args {
    #[arg(help = structure_arg::HELP)]
    structure: String,
    /// The material to write [default: in the cache; the path is printed]
    #[arg(short, long, value_name = "M.barbule")]
    output: Option<PathBuf>,
    /// Keep the campaign store in this folder
    #[arg(long, value_name = "DIR")]
    keep_store: Option<PathBuf>,
    /// Simulate segments in three dimensions too: the light along the barbule beside σ, and what is reflected
    #[arg(long)]
    halo: bool,
    #[command(flatten)]
    side: SideArg,
    #[command(flatten)]
    campaign: CampaignArgs,
    #[command(flatten)]
    fit: FitArgs,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let structure = self.side.of(structure_arg::parse(&self.structure, &self.common)?)?;
        let name = structure.name();
        let plan = self.campaign.plan(structure, &self.common)?;
        let options = FitOptions { halo: self.halo, ..self.fit.options()? };
        check(&plan, &options)?;
        let output = match &self.output {
            Some(path) => path.clone(),
            None => Catalog { cache: Some(materials::cache_folder(&self.common)?) }.path(&plan, &options)?,
        };
        check_writable(&output)?;
        let store = self.keep_store.as_deref().map(|folder| store_path(folder, &plan)).transpose()?;
        let width = self.campaign.width();
        let units_at_once = units_at_once(&plan, Keep::Statistics, Results::Gathered, &self.common)?;
        self.common.say(&format!("characterizing {name}: about {}", expected(&plan)));
        if self.halo {
            let count = HaloPlan::new(&plan).count();
            self.common.say(&format!("then {count} far fields of segments, for its halo"));
        }
        let how = Execution { resources: Resources { width, units_at_once }, store: store.as_deref() };
        let progress = Terminal::new(&self.common);
        let catalog = materials::catalog(&self.common);
        let Characterized { material, report, repaired } =
            characterize(&plan, &options, &catalog, &how, &progress)?;
        drop(progress);
        say_repaired(repaired, &self.common);
        write_material(&output, &material)?;
        let quick = if thinned(&material).is_some() { ", thinned: a quick look" } else { "" };
        if let Some(store) = &store {
            self.common.wrote(store, &format!("the campaign of {name}"));
        }
        self.common.wrote(&output, &format!("the material {name}{quick}"));
        self.common.explain(&summary(&report));
        if self.common.json {
            let report = serde_json::to_value(&report).map_err(|e| Error::machine(e.to_string()))?;
            return print_json(out, &serde_json::json!({ "material": path_json(&output), "fit": report }));
        }
        if self.output.is_none() {
            return print(out, &output.to_string_lossy());
        }
        Ok(())
    }
}

/// Where `--keep-store` puts the store: named by the campaign, so that the same one goes on and another has its own.
fn store_path(folder: &Path, plan: &Plan) -> Result<PathBuf> {
    if !folder.is_dir() {
        return Err(Error::input(format!("--keep-store {}: no such folder", folder.display())));
    }
    Ok(folder.join(plan.store_name()))
}
