//! `barbule cache`: what is kept of earlier runs, where a material is, and materials as files.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use barbule::brdf::fit::LobeForm;
use barbule::characterize::{Cached, CachedMaterial, Contents, Origin};
use barbule::error::shortened;
use barbule::io::{check_writable, delete_file, write_whole};
use barbule::open::Located;
use barbule::scattering::lobe::FitKind;
use barbule::{Error, Result};
use serde_json::{Value, json};

use crate::campaign::expected;
use crate::common::{Common, path_json, print, print_json};
use crate::materials;
use crate::provenance::quoted;

/// Arguments of `barbule cache`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule cache\n  barbule cache --path starling:pink\n  \
    barbule cache --copy starling -o starling.barbule")]
pub(crate) struct Args {
    /// Delete what this program keeps there; files that it did not name are left
    #[arg(long, group = "what")]
    clear: bool,
    /// Print where the material of a name is: SPECIES[:VARIANT], or any other structure
    #[arg(long, value_name = "NAME", group = "what")]
    path: Option<String>,
    /// Write the material of a name, shipped or cached, as a file
    #[arg(long, value_name = "NAME", group = "what", requires = "output")]
    copy: Option<String>,
    /// The file of --copy
    #[arg(short, long, value_name = "M.barbule", requires = "copy")]
    output: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        match (&self.path, &self.copy, &self.output) {
            (Some(name), ..) => self.locate(name, out),
            (_, Some(name), Some(output)) => self.copy(name, output, out),
            _ => self.list(out),
        }
    }

    /// Prints where a material is.
    fn locate(&self, name: &str, out: &mut dyn Write) -> Result<()> {
        let found = match materials::locate(name, &self.common)? {
            Located::There(found) => found,
            Located::Missing(plan) => return Err(not_there(name, &expected(&plan))),
        };
        let Origin::File(path) = &found.origin else {
            return Err(Error::input(format!(
                "{name} ships inside the program, so it is no file; write it as one with `barbule cache --copy {} -o FILE.barbule`",
                quoted(name)
            )));
        };
        if self.common.json {
            return print_json(out, &json!({ "path": path_json(path), "hash": found.hash }));
        }
        print(out, &path.to_string_lossy())
    }

    /// Writes a material as a file.
    fn copy(&self, name: &str, output: &Path, out: &mut dyn Write) -> Result<()> {
        check_writable(output)?;
        let found = match materials::locate(name, &self.common)? {
            Located::There(found) => found,
            Located::Missing(plan) => return Err(not_there(name, &expected(&plan))),
        };
        write_whole(output, &found.bytes()?)?;
        let title = found.material.info["name"].as_str().unwrap_or(name);
        self.common.wrote(output, &format!("the material {title}"));
        if self.common.json {
            return print_json(out, &json!({ "path": path_json(output), "hash": found.hash }));
        }
        Ok(())
    }

    /// Lists what there is, and deletes it with `--clear`.
    fn list(&self, out: &mut dyn Write) -> Result<()> {
        let folder = materials::known_folder(&self.common)?;
        let files = Cached::all(&folder)?;
        let doomed = |cached: &Cached| self.clear && cached.is_ours;
        files.iter().filter(|cached| doomed(cached)).try_for_each(|cached| delete_file(&cached.file.path))?;
        if self.common.json {
            let list: Vec<Value> = files
                .iter()
                .map(|cached| {
                    let mut entry = document(cached);
                    entry["deleted"] = doomed(cached).into();
                    entry
                })
                .collect();
            return print_json(
                out,
                &json!({ "folder": path_json(&folder), "files": list, "cleared": self.clear }),
            );
        }
        let ours = files.iter().filter(|cached| cached.is_ours).count();
        let mut text = format!("{}: {ours} cached", folder.display());
        if files.len() > ours {
            text += &format!(", {} of your own", files.len() - ours);
        }
        for cached in &files {
            text += &format!("\n{}", line(cached));
            if self.clear {
                text += if doomed(cached) { "  deleted" } else { "  left" };
            }
        }
        print(out, &text)
    }
}

fn not_there(name: &str, time: &str) -> Error {
    Error::input(format!(
        "the material {} is not there yet; make it with `barbule characterize {}` (about {time})",
        shortened(name),
        quoted(&shortened(name))
    ))
}

/// A file in one line: what it is, when it was written, its size, the head of its hash, its name.
fn line(cached: &Cached) -> String {
    let (name, what) = match &cached.contents {
        Contents::Material(material) => (material.name.as_str(), sampling(material)),
        Contents::Orders(orders) => (
            "",
            format!("orders of a crystal: {}, {} angles", wavelengths(&orders.wavelengths_nm), orders.angles),
        ),
        Contents::Unknown(_) => ("", "damaged, or no material".to_owned()),
    };
    let file = cached.file.path.file_name().unwrap_or_default().to_string_lossy();
    let date = cached.file.modified.map_or_else(String::new, |time| utc(time)[..10].to_owned());
    let size = cached.file.bytes.div_ceil(1000);
    let hash = cached.hash.get(..8).unwrap_or_default();
    let own = if cached.is_ours { "" } else { " (your own)" };
    format!("  {name:<20} {what}  {date}  {size} kB  {hash}  {file}{own}")
}

/// How finely a material is sampled, and whatever differs from the usual options.
fn sampling(material: &CachedMaterial) -> String {
    let [thetas, phis] = material.directions;
    let mut what = match material.thinned {
        Some(every) => format!("thinned by {every}"),
        None if material.is_full() => "full".to_owned(),
        None => "other sampling".to_owned(),
    };
    what += &format!(": {}, {thetas} x {phis} directions", wavelengths(&material.wavelengths_nm));
    if let Some(instances) = material.instances {
        what += &format!(", {instances} instances");
    }
    if material.is_polarized {
        what += ", polarized";
    }
    if material.kind == FitKind::Cone {
        what += ", fitted on the cone";
    }
    if material.lobe == LobeForm::Ggx {
        what += ", single lobes";
    }
    if material.has_halo {
        what += ", with a halo";
    }
    what += &format!(", sigma {}, seed {}, version {}", material.sigma, material.seed, material.version);
    what
}

fn wavelengths(nm: &[f64]) -> String {
    match nm {
        [only] => format!("{only} nm"),
        [first, .., last] => format!("{} wavelengths {first} to {last} nm", nm.len()),
        [] => "no wavelengths".to_owned(),
    }
}

/// A file as JSON.
fn document(cached: &Cached) -> Value {
    let mut entry = json!({
        "file": cached.file.path.to_string_lossy(),
        "bytes": cached.file.bytes,
        "modified": cached.file.modified.map(utc),
        "hash": cached.hash,
        "own": !cached.is_ours,
    });
    let more = match &cached.contents {
        Contents::Material(material) => json!({
            "kind": "material",
            "name": material.name,
            "version": material.version,
            "full": material.is_full(),
            "thinned": material.thinned,
            "wavelengths_nm": material.wavelengths_nm,
            "directions": material.directions,
            "instances": material.instances,
            "seed": material.seed,
            "polarized": material.is_polarized,
            "sigma": material.sigma,
            "halo": material.has_halo,
            "fit": if material.kind == FitKind::Cone { "cone" } else { "marginal" },
            "lobe": if material.lobe == LobeForm::Ggx { "ggx" } else { "pair" },
        }),
        Contents::Orders(orders) => json!({
            "kind": "orders",
            "wavelengths_nm": orders.wavelengths_nm,
            "angles": orders.angles,
        }),
        Contents::Unknown(why) => json!({ "kind": "unknown", "why": why }),
    };
    if let (Value::Object(entry), Value::Object(more)) = (&mut entry, more) {
        entry.extend(more);
    }
    entry
}

/// A time as `2025-11-22T04:33:00Z`, by the rule of the Gregorian calendar.
fn utc(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    // Years that begin in March, so that the day of a leap year is their last: 146,097 days are 400 of them.
    let days = seconds / 86_400 + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let (hours, minutes) = (seconds / 3600 % 24, seconds / 60 % 60);
    format!("{:04}-{month:02}-{day:02}T{hours:02}:{minutes:02}:{:02}Z", era * 400 + year + next, seconds % 60)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, date) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (951_868_799, "2000-02-29T23:59:59Z"),
            (951_868_800, "2000-03-01T00:00:00Z"),
            (1_735_689_599, "2024-12-31T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(utc(UNIX_EPOCH + Duration::from_secs(seconds)), date);
        }
    }
}
