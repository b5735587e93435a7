//! `barbule characterize`: from a structure to its material in one go.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::campaign::{Keep, Results, run, statistics};
use barbule::io::store::Store;
use barbule::io::{check_writable, write_material};
use barbule::{Error, Result};

use crate::campaign::{CampaignArgs, FitArgs, say_repaired, summary};
use crate::common::{Common, print, print_json};
use crate::progress::Terminal;
use crate::{materials, structure_arg};

/// Arguments of `barbule characterize`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule characterize starling:pink --thin 4 -o pink.barbule\n  \
    barbule characterize my-species.toml -o mine.barbule")]
pub(crate) struct Args {
    #[arg(help = structure_arg::HELP)]
    structure: String,
    /// The material to write [default: in the cache; the path is printed]
    #[arg(short, long, value_name = "M.barbule")]
    output: Option<PathBuf>,
    /// Keep the campaign store in this folder
    #[arg(long, value_name = "DIR")]
    keep_store: Option<PathBuf>,
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
        let structure = structure_arg::parse(&self.structure, &self.common)?;
        let name = structure.name();
        let planned = self.campaign.plan(structure, &self.common)?;
        let output = match &self.output {
            Some(path) => path.clone(),
            None => materials::cache_path(&self.common, &name)?,
        };
        check_writable(&output)?;
        self.fit.check()?;
        let store = self.keep_store.as_deref().map(|folder| store_path(folder, &name)).transpose()?;
        let width = self.campaign.width()?;
        let at_once = planned.units_at_once(width, Keep::Statistics, Results::Gathered, &self.common)?;
        self.common.say(&format!("characterizing {name}: about {}", materials::expected(&planned)));
        let progress = Terminal::new(&self.common);
        let campaign = planned.campaign(width, at_once, &self.common, &progress)?;
        let statistics = match &store {
            None => statistics(&campaign, &progress)?,
            Some(path) => {
                let parameters = &planned.parameters;
                let store = Store::create(
                    path,
                    &parameters.axes,
                    parameters.instances,
                    &name,
                    &planned.description,
                    &[],
                    width.name(),
                )?;
                let outcome = run(&campaign, &store, 0, 1, &progress)?;
                say_repaired(outcome.repaired, &self.common);
                store.statistics()?
            }
        };
        let (material, report) = self.fit.fit(&statistics, &name, &planned.description, &progress)?;
        drop(progress);
        write_material(&output, &material)?;
        self.common.explain(&summary(&report));
        if self.common.json {
            let report = serde_json::to_value(&report).map_err(|e| Error::machine(e.to_string()))?;
            return print_json(out, &serde_json::json!({ "material": output, "fit": report }));
        }
        if self.output.is_none() {
            return print(out, &output.display().to_string());
        }
        Ok(())
    }
}

/// Where `--keep-store` puts the store.
fn store_path(folder: &Path, name: &str) -> Result<PathBuf> {
    if !folder.is_dir() {
        return Err(Error::input(format!("--keep-store {}: no such folder", folder.display())));
    }
    Ok(folder.join(format!("{}.zarr", materials::file_stem(name))))
}
