//! `barbule man`: the manual's pages, made from the same definition as `--help`.

use std::borrow::Cow;
use std::io::Write;
use std::path::PathBuf;

use barbule::error::{did_you_mean, shortened};
use barbule::io::{check_writable, make_folder, write_whole};
use barbule::{Error, Result};
use clap_mangen::Man;
use serde_json::json;

use crate::common::{Common, path_json, print, print_json};

/// The manual's section for programs.
const SECTION: &str = "1";

/// Arguments of `barbule man`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule man --list\n  barbule man render > barbule-render.1\n  \
    barbule man -o man1\n\n\
    On Linux, `barbule man -o ~/.local/share/man/man1` sets pages up: then `man barbule-render` shows one.")]
pub(crate) struct Args {
    /// The command whose page is wanted, as in render [default: the program's own page; with -o all pages]
    #[arg(value_name = "COMMAND")]
    commands: Vec<String>,
    /// List the names of all pages
    #[arg(long, conflicts_with_all = ["commands", "folder"])]
    list: bool,
    /// Write pages into this folder, as in barbule-render.1
    #[arg(short = 'o', long = "output", value_name = "FOLDER")]
    folder: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// A page of the manual.
struct Page {
    /// As `man` knows it: `barbule-bench-render`.
    name: String,
    roff: String,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        let pages = pages()?;
        if self.list {
            let names: Vec<&str> = pages.iter().map(|page| page.name.as_str()).collect();
            return if self.common.json { print_json(out, &names) } else { print(out, &names.join("\n")) };
        }
        let Some(folder) = &self.folder else {
            let page = self.named(&pages)?;
            return match self.common.json {
                true => print_json(out, &json!({"name": page.name, "roff": page.roff})),
                false => print(out, page.roff.trim_end()),
            };
        };
        let wanted =
            if self.commands.is_empty() { pages.iter().collect() } else { vec![self.named(&pages)?] };
        make_folder(folder)?;
        let files: Vec<_> = wanted
            .iter()
            .map(|page| (folder.join(format!("{}.{SECTION}", page.name)), page.roff.as_bytes()))
            .collect();
        files.iter().try_for_each(|(path, _)| check_writable(path))?;
        for (path, roff) in &files {
            write_whole(path, roff)?;
        }
        let count = match files.len() {
            1 => "1 page".to_owned(),
            count => format!("{count} pages"),
        };
        self.common.wrote(folder, &format!("{count} of the manual"));
        if self.common.json {
            let files: Vec<_> = files.iter().map(|(path, _)| path_json(path)).collect();
            return print_json(out, &json!({ "files": files }));
        }
        Ok(())
    }

    /// The page of the command that was asked for.
    fn named<'a>(&self, pages: &'a [Page]) -> Result<&'a Page> {
        let given = self.commands.join("-");
        let wanted = if given.is_empty() { "barbule".to_owned() } else { format!("barbule-{given}") };
        pages.iter().find(|page| page.name == wanted).ok_or_else(|| {
            let known = pages.iter().filter_map(|page| page.name.strip_prefix("barbule-"));
            Error::input(format!(
                "'{}': no such command{}; barbule man --list names all pages",
                shortened(&self.commands.join(" ")),
                did_you_mean(&given, known)
            ))
        })
    }
}

/// All pages, the program's own first, in the order of its help.
fn pages() -> Result<Vec<Page>> {
    // Otherwise every command would have a page about its help.
    let mut program = crate::command().disable_help_subcommand(true);
    program.build();
    let mut pages = Vec::new();
    let mut open = vec![&program];
    while let Some(command) = open.pop() {
        let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_owned();
        let mut roff = Vec::new();
        let rendered = Man::new(command.clone()).section(SECTION).render(&mut roff);
        rendered.map_err(|e| Error::machine(format!("{name}: no page can be made: {e}")))?;
        let roff = String::from_utf8(roff).map_err(|e| Error::machine(format!("{name}: {e}")))?;
        let lines: Vec<_> = roff.lines().map(|line| mended(&name, line)).collect();
        // An empty line between two ends of lines is one too many for readers of manuals.
        let roff = (lines.join("\n") + "\n").replace("\n.br\n\n.br\n", "\n.sp\n");
        pages.push(Page { name, roff });
        open.extend(command.get_subcommands().collect::<Vec<_>>().into_iter().rev());
    }
    Ok(pages)
}

/// A line of a page as it should be: of a version instead of a day, which without its quotes would be the version; what
/// stands behind the flags in our help is examples.
fn mended<'a>(name: &str, line: &'a str) -> Cow<'a, str> {
    if line.starts_with(".TH ") {
        format!(".TH {name} {SECTION} \"\" \"barbule {}\" \"Barbule\"", env!("CARGO_PKG_VERSION")).into()
    } else if line == ".SH EXTRA" {
        ".SH EXAMPLES".into()
    } else {
        line.into()
    }
}
