//! `barbule cache`: the materials computed on first use, and tables of crystals.

use std::io::Write;

use barbule::Result;
use serde_json::json;

use crate::common::{Common, path_json, print, print_json};
use crate::materials;

/// Arguments of `barbule cache`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  barbule cache --clear")]
pub(crate) struct Args {
    /// Delete what is cached
    #[arg(long)]
    clear: bool,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        let folder = materials::cache_folder(&self.common)?;
        let files = barbule::io::list_cached(&folder)?;
        if self.clear {
            barbule::io::delete_cached(&files)?;
        }
        if self.common.json {
            let list: Vec<_> = files
                .iter()
                .map(|(path, bytes)| json!({ "file": path_json(path), "bytes": bytes }))
                .collect();
            return print_json(
                out,
                &json!({ "folder": path_json(&folder), "files": list, "cleared": self.clear }),
            );
        }
        let mut text = format!("{}: {} cached", folder.display(), files.len());
        for (path, bytes) in &files {
            text += &format!("\n{:>8} kB  {}", bytes.div_ceil(1000), path.display());
        }
        if self.clear {
            text += "\ncleared";
        }
        print(out, &text)
    }
}
