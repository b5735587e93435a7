//! `barbule keys`: the keys of scenes, species and plans of atlases, as their readers define them.

use std::io::Write;

use barbule::Result;
use barbule::keys::{json_of, keys_of, kinds, page, rows, schema_of};

use crate::common::{Common, print, print_json};

/// Arguments of `barbule keys`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule keys scene camera\n  barbule keys species:starling\n  \
    barbule keys scene --schema > scene.schema.json")]
pub(crate) struct Args {
    /// scene, atlas, or species:GENERATOR [default: lists them]
    #[arg(value_name = "KIND")]
    kind: Option<String>,
    /// One of its tables, as in camera or feather.distal
    #[arg(value_name = "TABLE", requires = "kind", value_hint = clap::ValueHint::Other)]
    table: Option<String>,
    /// Print a JSON schema of the whole file, for editors
    #[arg(long, requires = "kind", conflicts_with_all = ["table", "markdown"])]
    schema: bool,
    /// Print all keys of all kinds as a page of Markdown
    #[arg(long, conflicts_with = "kind")]
    markdown: bool,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        if self.markdown {
            if self.common.json {
                self.common.idle("--json", "a page of Markdown is asked for; leave --markdown out");
            }
            return print(out, page().trim_end());
        }
        let Some(kind) = &self.kind else {
            return match self.common.json {
                true => print_json(out, &kinds()),
                false => print(out, &kinds().join("\n")),
            };
        };
        if self.schema {
            return print(out, &format!("{:#}", schema_of(kind)?));
        }
        let keys = keys_of(kind, self.table.as_deref())?;
        if self.common.json {
            return print_json(out, &json_of(&keys));
        }
        let rows = rows(&keys);
        let width = |column: usize, most: usize| {
            rows.iter().map(|row| row[column].chars().count()).max().unwrap_or_default().min(most)
        };
        let [name, allowed, usual] = [width(0, 32), width(1, 40), width(2, 12)];
        let line = |[key, values, otherwise, about]: &[String; 4]| {
            format!("{key:name$}  {values:allowed$}  {otherwise:usual$}  {about}").trim_end().to_owned()
        };
        print(out, &rows.iter().map(line).collect::<Vec<_>>().join("\n"))
    }
}
