//! Comparisons as units of work that are kept as they come, so that several processes share them; and what comes of them in the end.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::io::{Units, claim_output, files_in, make_folder, write_together};
use crate::plot::{Drawing, Format};
use crate::progress::{Progress, Shard};
use crate::solve::cost::Cost;
use crate::{Error, Result};

/// The folder, in that of the figures, in which what is done is kept.
pub const UNITS: &str = "units";

/// Tables and numbers that stand beside the figures.
const TABLES: [&str; 3] = ["numbers.json", "numbers.csv", "patterns.csv"];

/// What two simulations are compared by, in units that any process may compute, in any order: their bits are the same, and
/// [`Self::finish`] finds them.
pub trait Comparing: Send + Sync {
    /// What its units are called.
    fn what(&self) -> &'static str;

    /// How many units there are.
    fn units(&self) -> usize;

    /// Those of some units, which count from 0, that are not kept; reads them.
    fn missing(&self, some: &[usize], kept: &Units) -> Vec<usize>;

    /// What each unit takes on so many threads, foretold.
    ///
    /// # Errors
    /// As the solvers, as far as that is known without their work; or the user cancelled.
    fn costs(&self, threads: usize, progress: &dyn Progress) -> Result<Vec<Cost>>;

    /// Computes a unit and keeps it, unless it is there.
    ///
    /// # Errors
    /// As the solvers; it cannot be written; or the user cancelled.
    fn keep(&self, unit: usize, kept: &Units, progress: &dyn Progress) -> Result<()>;

    /// Compares what is kept, and computes and keeps what is not.
    ///
    /// # Errors
    /// As [`Self::keep`].
    fn finish(&self, kept: Option<&Units>, progress: &dyn Progress) -> Result<Compared>;

    /// What all of them take on so many threads, one after the other.
    ///
    /// # Errors
    /// As [`Self::costs`].
    fn total_cost(&self, threads: usize, progress: &dyn Progress) -> Result<Cost> {
        Ok(self.costs(threads, progress)?.into_iter().fold(Cost::default(), Cost::then))
    }

    /// How many units are kept.
    fn done(&self, kept: &Units) -> usize {
        let all: Vec<usize> = (0..self.units()).collect();
        self.units() - self.missing(&all, kept).len()
    }

    /// Computes a unit and keeps it, unless it is there; one step of progress.
    ///
    /// # Errors
    /// There is no such unit; as [`Self::keep`].
    fn run_unit(&self, unit: usize, kept: &Units, progress: &dyn Progress) -> Result<()> {
        if unit >= self.units() {
            let count = self.units();
            return Err(Error::input(format!("there is no unit {unit} of {count} (they count from 0)")));
        }
        progress.begin(self.what(), 1);
        self.keep(unit, kept, progress)?;
        progress.advance(1);
        Ok(())
    }

    /// The units of a part, of about equal time: parts are the same wherever they are computed.
    ///
    /// # Errors
    /// As [`Self::costs`].
    fn part(&self, shard: Shard, progress: &dyn Progress) -> Result<Vec<usize>> {
        let seconds = self.costs(1, progress)?.into_iter().map(|cost| cost.seconds.unwrap_or_default());
        Ok(shard.by_cost(&seconds.collect::<Vec<_>>()))
    }

    /// Computes and keeps what is missing of some units, as those of a [`Self::part`]: [`Self::finish`] then finds it, whoever
    /// computed it.
    ///
    /// # Errors
    /// As [`Self::keep`]; what is kept till then stays.
    fn run_units(&self, units: &[usize], kept: &Units, progress: &dyn Progress) -> Result<()> {
        let left = self.missing(units, kept);
        progress.begin(self.what(), left.len() as u64);
        for unit in left {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            self.keep(unit, kept, progress)?;
            progress.advance(1);
        }
        Ok(())
    }
}

/// A finished comparison, as it is shown.
#[derive(Debug, Clone)]
pub struct Compared {
    /// What was compared.
    pub name: String,
    /// All numbers but the patterns, for JSON.
    pub numbers: Value,
    /// Figures with their files' names.
    pub figures: Vec<(String, Drawing)>,
    /// CSV with the files' names.
    pub tables: Vec<(&'static str, String)>,
    /// A table for people.
    pub table: String,
}

impl Compared {
    /// Writes figures, numbers and tables into a folder, which is made where it is not there: all of them, or none. `notes` say in each
    /// figure what made it, and `made` does in the numbers.
    ///
    /// # Errors
    /// The folder or a file cannot be written.
    pub fn write(&mut self, folder: &Path, made: Value, notes: &[(&str, &str)]) -> Result<()> {
        if let Value::Object(map) = &mut self.numbers {
            map.insert("made".into(), made);
        }
        let mut files: Vec<(PathBuf, Vec<u8>)> = Vec::new();
        for (file, drawing) in &self.figures {
            files.push((folder.join(file), drawing.encode(Format::Svg, notes)?));
        }
        files.extend(self.tables.iter().map(|(file, text)| (folder.join(file), text.clone().into_bytes())));
        files.push((folder.join("numbers.json"), format!("{:#}\n", self.numbers).into_bytes()));
        make_folder(folder)?;
        let together: Vec<(&Path, &[u8])> = files.iter().map(|(path, bytes)| (&**path, &**bytes)).collect();
        write_together(&together)
    }
}

/// The units of a comparison whose figures go into a folder. What these may take the place of is known before anything is read.
///
/// # Errors
/// There is something else than a folder, or a file that is an input would be overwritten.
pub fn units_in(folder: &Path) -> Result<Units> {
    if folder.exists() && !folder.is_dir() {
        return Err(Error::input(format!("{}: is no folder; give another name", folder.display())));
    }
    for path in files_in(folder, "svg").into_iter().chain(TABLES.map(|name| folder.join(name))) {
        claim_output(&path, &path.display().to_string())?;
    }
    Ok(Units::new(&folder.join(UNITS)))
}

#[cfg(test)]
pub(super) mod tests {
    use std::collections::BTreeMap;
    use std::ffi::OsString;

    use super::*;
    use crate::progress::{NO_CLOCK, Unobserved};
    use crate::structure::Structure;
    use crate::validate::FullWaveOptions;

    /// The files of a folder.
    pub(crate) fn files(folder: &Path) -> BTreeMap<OsString, Vec<u8>> {
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
        entries.map(|entry| (entry.file_name(), std::fs::read(entry.path()).unwrap())).collect()
    }

    /// Two individuals of a film at two wavelengths.
    fn options() -> FullWaveOptions {
        FullWaveOptions {
            wavelengths_nm: Some(vec![600.0, 650.0]),
            phi_deg: Some(vec![0.0]),
            elements_per_wavelength: 4.0,
            individuals: 2,
            ..FullWaveOptions::default()
        }
    }

    fn film() -> Structure {
        Structure::flat("air/keratin:400±10%/air").unwrap()
    }

    #[test]
    fn full_waves_of_parts_units_and_one_run_are_the_same_files() {
        let folder = tempfile::tempdir().unwrap();
        let plan = options().plan(film(), u64::MAX, NO_CLOCK).unwrap();
        let kept = |name: &str| units_in(&folder.path().join(name)).unwrap();
        let there = |name: &str| files(&folder.path().join(name).join(UNITS));
        for number in [1, 0] {
            let own = plan.part(Shard::new(number, 2).unwrap(), &Unobserved).unwrap();
            plan.run_units(&own, &kept("parts"), &Unobserved).unwrap();
        }
        for unit in [3, 0, 2, 1] {
            plan.run_unit(unit, &kept("units"), &Unobserved).unwrap();
        }
        let mut whole = plan.finish(Some(&kept("whole")), &Unobserved).unwrap();
        assert_eq!((plan.units(), there("whole").len(), plan.done(&kept("parts"))), (4, 4, 4));
        assert!(there("parts") == there("whole") && there("units") == there("whole"));
        let costs = plan.costs(1, &Unobserved).unwrap();
        assert!(costs.len() == 4 && costs.iter().all(|cost| cost.seconds > Some(0.0) && cost.bytes > 0));
        whole.write(&folder.path().join("whole"), Value::Null, &[("version", "0")]).unwrap();
        let text = std::fs::read_to_string(folder.path().join("whole/numbers.json")).unwrap();
        let read: Value = serde_json::from_str(&text).unwrap();
        assert!(read == whole.numbers && read["made"].is_null() && read["count"] == 2);
        std::fs::write(folder.path().join("file"), "").unwrap();
        assert!(units_in(&folder.path().join("file")).unwrap_err().to_string().contains("is no folder"));
    }

    #[test]
    fn options_out_of_range_are_refused_by_name() {
        for (bad, part) in [
            (FullWaveOptions { elements_per_wavelength: 3.0, ..options() }, "3 nodes per wavelength"),
            (FullWaveOptions { individuals: 0, ..options() }, "give from 1 to 1000"),
            (FullWaveOptions { width_um: Some(0.5), ..options() }, "`width_um` is 0.5"),
            (FullWaveOptions { width_um: Some(6.0), ..options() }, "change species"),
            (FullWaveOptions { layers: Some(101), ..options() }, "`layers` is 101"),
            (FullWaveOptions { phi_deg: Some(vec![f64::NAN]), ..options() }, "`phi_deg`: give"),
            (FullWaveOptions { smooth_um: Some(3.0), ..options() }, "an average over 3 µm"),
            (FullWaveOptions { wavelengths_nm: Some(vec![]), ..options() }, "wavelength"),
        ] {
            let message = bad.plan(film(), u64::MAX, NO_CLOCK).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
        let text = serde_json::to_string(&options()).unwrap();
        assert_eq!(serde_json::from_str::<FullWaveOptions>(&text).unwrap(), options());
        assert!(serde_json::from_str::<FullWaveOptions>(r#"{"instances": 3}"#).is_err());
    }
}
