//! `barbule fit`: a material from a campaign store.

use std::io::Write;
use std::path::PathBuf;

use barbule::Result;
use barbule::brdf::check_axes;
use barbule::campaign::statistics_bytes;
use barbule::characterize::{CampaignDescription, material_of};
use barbule::io::store::Store;
use barbule::io::{check_writable, write_material};

use super::simulate::damaged;
use crate::campaign::{FitArgs, summary};
use crate::common::{Common, print_json};
use crate::progress::Terminal;

/// Arguments of `barbule fit`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  barbule fit starling.zarr -o starling.barbule --sigma 0.06")]
pub(crate) struct Args {
    /// A store that `barbule simulate` has finished
    store: PathBuf,
    /// The material to write
    #[arg(short, long, value_name = "M.barbule")]
    output: PathBuf,
    #[command(flatten)]
    fit: FitArgs,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        check_writable(&self.output)?;
        let options = self.fit.options()?;
        let store = Store::open(&self.store)?;
        let coordinates = store.damaged_coordinates();
        if !coordinates.is_empty() {
            // The fit has the axes from the attributes.
            self.common.say(&format!("{}; simulate writes them again", damaged(&coordinates)));
        }
        check_axes(store.axes()).map_err(|e| e.at(self.store.display()))?;
        let bytes = statistics_bytes(store.axes(), store.instances());
        self.common.check_memory("this store's statistics", bytes, "a store of fewer directions")?;
        let statistics = store.statistics()?;
        let campaign =
            CampaignDescription::read(store.description()).map_err(|e| e.at(self.store.display()))?;
        let progress = Terminal::new(&self.common);
        let (material, report) = material_of(&statistics, store.name(), &campaign, &options, &progress)?;
        drop(progress);
        write_material(&self.output, &material)?;
        self.common.wrote(&self.output, &format!("the material {}", store.name()));
        if self.common.json {
            return print_json(out, &report);
        }
        self.common.say(&summary(&report));
        Ok(())
    }
}
