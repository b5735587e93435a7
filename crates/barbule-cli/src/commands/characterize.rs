//! `barbule characterize`: from a structure to its material in one go.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::brdf::fit::FitOptions;
use barbule::campaign::{Keep, Outcome, Resources, Results};
use barbule::characterize::{
    Catalog, Characterized, Execution, HaloPlan, Plan, characterize, characterize_part, check, thinned,
};
use barbule::io::{check_writable, write_material};
use barbule::progress::Shard;
use barbule::{Error, Result};

use crate::campaign::{CampaignArgs, FitArgs, expected, say_repaired, summary, units_at_once};
use crate::common::{Common, path_json, print, print_json};
use crate::progress::Terminal;
use crate::structure_arg::SideArg;
use crate::{materials, shard, structure_arg};

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
    /// With --keep-store: only simulate part i of n (i from 0), for several processes; the command without it then makes the material
    #[arg(long, value_name = "i/n", requires = "keep_store", allow_hyphen_values = true, value_parser = shard::parse)]
    shard: Option<Shard>,
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
        let structure = self.side.open(&self.structure, &self.common)?;
        let name = structure.name();
        let plan = self.campaign.plan(structure, &self.common)?;
        let options = FitOptions { halo: self.halo, ..self.fit.options()? };
        check(&plan, &options)?;
        if let Some(shard) = self.shard {
            return self.part(out, &plan, &options, shard);
        }
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
            let count = HaloPlan::new(&plan, width).count();
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

impl Args {
    /// Simulates a part, and makes no material.
    fn part(&self, out: &mut dyn Write, plan: &Plan, options: &FitOptions, shard: Shard) -> Result<()> {
        if self.output.is_some() {
            self.common
                .idle("-o", "a part is simulated and no material made; the command without --shard makes it");
        }
        let Some(folder) = &self.keep_store else {
            return Err(Error::input("--shard: parts meet in a store; give its folder by --keep-store"));
        };
        let store = store_path(folder, plan)?;
        let units_at_once = units_at_once(plan, Keep::Statistics, Results::Stored, &self.common)?;
        let resources = Resources { width: self.campaign.width(), units_at_once };
        let how = Execution { resources, store: Some(&store) };
        let progress = Terminal::new(&self.common);
        let catalog = materials::catalog(&self.common);
        let outcome = characterize_part(plan, options, shard, &catalog, &how, &progress)?;
        drop(progress);
        say_repaired(outcome.repaired, &self.common);
        let Outcome { computed, found, .. } = outcome;
        let name = plan.structure.name();
        self.common.wrote(
            &store,
            &format!("part {shard} of the campaign of {name}, {computed} units computed, {found} found"),
        );
        if self.common.json {
            let document =
                serde_json::json!({ "store": path_json(&store), "computed": computed, "found": found });
            return print_json(out, &document);
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
