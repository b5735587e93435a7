//! Several measurements: individuals and angles, in one file, in several, or in a folder of them.

use std::path::{Path, PathBuf};

use super::names::angle_in;
use super::resample::{Own, brought_to};
use super::{MOST_NUMBERS, Measured, Sample, Scale, mean, read_measured};
use crate::error::shortened;
use crate::io::whole::failure;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::{Error, Result};

/// What was measured at one angle.
#[derive(Debug, Clone, PartialEq)]
pub struct AtAngle {
    /// The angle, degrees; none where nothing says any, and so none of the others has one.
    pub angle_deg: Option<f64>,
    /// All samples at that angle, whichever files they stand in.
    pub measured: Measured,
}

/// What several places hold, by angle.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurements {
    /// In the order of their angles; at least one.
    pub angles: Vec<AtAngle>,
    /// How each file was read, one sentence each.
    pub reading: Vec<String>,
}

/// Angles that differ by less, degrees, are one.
const SAME_DEG: f64 = 0.05;
/// Files of a folder, at most.
const MOST_FILES: usize = 1_000;
/// How files of measurements end, in folders.
const ENDINGS: [&str; 12] =
    ["csv", "tsv", "txt", "dat", "jdx", "dx", "asc", "ttt", "trt", "procspec", "jaz", "transmission"];

impl Measurements {
    /// The measurement at an angle: the one that says so, or the only one where none says any.
    #[must_use]
    pub fn at(&self, angle_deg: f64) -> Option<&Measured> {
        let same = |at: &&AtAngle| at.angle_deg.is_none_or(|angle| (angle - angle_deg).abs() < SAME_DEG);
        self.angles.iter().find(same).map(|at| &at.measured)
    }

    /// The angles that are said, degrees, rising; none where none is.
    #[must_use]
    pub fn angles_deg(&self) -> Option<Vec<f64>> {
        self.angles.iter().map(|at| at.angle_deg).collect()
    }
}

/// A file with the angle that is typed behind it.
struct Place {
    path: PathBuf,
    angle_deg: Option<f64>,
}

/// Reads measurements of one or several places: `FILE`, `FILE@ANGLE` (degrees) or `FOLDER`, whose files are read in the order of their
/// names. Without `@ANGLE` the names of the samples say their angles, as `30deg`, `30°` or `theta_30` (of long tables a column `angle`),
/// or that of the file does. Samples of the same angle are individuals, brought to the wavelengths of the first file. `column` and
/// `scale` are those of [`read_measured`].
///
/// # Errors
/// As [`read_measured`]; a folder without measurements; angles over 90°, or said for some samples alone; nothing in common.
pub fn read_measurements(
    places: &[String],
    column: Option<&str>,
    scale: Option<Scale>,
) -> Result<Measurements> {
    let mut files = Vec::new();
    for place in places {
        files.extend(expanded(place)?);
    }
    let several = files.len() > 1;
    let mut reading = Vec::new();
    let mut groups: Vec<(Option<f64>, Vec<Sample>)> = Vec::new();
    let mut numbers = 0;
    for file in &files {
        let measured = read_measured(&file.path, column, scale)?;
        let samples = measured.samples.len();
        numbers += samples * measured.mean.wavelengths().len();
        if numbers > MOST_NUMBERS {
            return Err(Error::input(format!(
                "the measurements up to {} hold over {MOST_NUMBERS} numbers in all; give fewer files",
                file.path.display()
            )));
        }
        let angles = angles(file, &measured).map_err(|error| error.at(file.path.display()))?;
        let stem = file.path.file_stem().unwrap_or_default().to_string_lossy();
        for (sample, angle) in measured.samples.into_iter().zip(angles) {
            let name = match (several, samples) {
                (false, _) => sample.name,
                (true, 1) => shortened(&stem),
                (true, _) => shortened(&format!("{stem}: {}", sample.name)),
            };
            let sample = Sample { name, ..sample };
            let same = |group: &&mut (Option<f64>, Vec<Sample>)| match (group.0, angle) {
                (Some(a), Some(b)) => (a - b).abs() < SAME_DEG,
                (a, b) => a == b,
            };
            match groups.iter_mut().find(same) {
                Some(group) => group.1.push(sample),
                None => groups.push((angle, vec![sample])),
            }
        }
        reading.push(measured.reading);
    }
    if let (Some(without), Some(with)) =
        (groups.iter().find(|group| group.0.is_none()), groups.iter().find_map(|group| group.0))
    {
        return Err(Error::input(format!(
            "'{}' says no angle, but another measurement says {with}°; write FILE@ANGLE for it",
            without.1[0].name
        )));
    }
    groups.sort_by(|a, b| a.0.unwrap_or(0.0).total_cmp(&b.0.unwrap_or(0.0)));
    let together = reading.join("; ");
    let angles = groups
        .into_iter()
        .map(|(angle_deg, samples)| Ok(AtAngle { angle_deg, measured: pooled(samples, together.clone())? }))
        .collect::<Result<Vec<_>>>()?;
    Ok(Measurements { angles, reading })
}

/// The files that are meant.
fn expanded(place: &str) -> Result<Vec<Place>> {
    let (path, angle_deg) = split(place)?;
    if !path.is_dir() {
        return Ok(vec![Place { path, angle_deg }]);
    }
    let entries = std::fs::read_dir(&path).map_err(|error| failure(&path, "cannot be read", &error))?;
    let mut paths: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| is_measurement(path))
        .take(MOST_FILES + 1)
        .collect();
    if paths.is_empty() || paths.len() > MOST_FILES {
        return Err(Error::input(format!(
            "{}: the folder has {} files of measurements ({}); give one with up to {MOST_FILES}",
            path.display(),
            if paths.is_empty() { "no".to_owned() } else { format!("over {MOST_FILES}") },
            ENDINGS.map(|ending| format!(".{ending}")).join(", "),
        )));
    }
    paths.sort();
    Ok(paths.into_iter().map(|path| Place { path, angle_deg }).collect())
}

/// Whether a file of a folder is meant: by its ending, and not hidden or a page to read.
fn is_measurement(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    path.is_file()
        && !name.starts_with('.')
        && !name.starts_with("readme")
        && ENDINGS.contains(&ending.as_str())
}

/// A path and the angle behind its last `@`; a file whose name holds one is meant as it is.
fn split(place: &str) -> Result<(PathBuf, Option<f64>)> {
    let whole = PathBuf::from(place);
    let Some((path, angle)) = place.rsplit_once('@').filter(|_| !whole.exists()) else {
        return Ok((whole, None));
    };
    match angle.trim().trim_end_matches('°').parse::<f64>() {
        Ok(angle) if angle.abs() < 90.0 => Ok((path.into(), Some(angle))),
        _ => Err(Error::input(format!(
            "'{}' is no angle behind @; write FILE@ANGLE with degrees between -90 and 90, as in {}@30",
            shortened(angle),
            shortened(path)
        ))),
    }
}

/// The angle of each sample.
fn angles(file: &Place, measured: &Measured) -> Result<Vec<Option<f64>>> {
    let said: Vec<Option<f64>> = measured.samples.iter().map(|sample| angle_in(&sample.name)).collect();
    let known = said.iter().flatten().count();
    let stem = file.path.file_stem().unwrap_or_default().to_string_lossy();
    let found = match (known, file.angle_deg) {
        (0, Some(angle)) => vec![Some(angle); said.len()],
        (0, None) => vec![angle_in(&stem); said.len()],
        (_, Some(angle)) => {
            return Err(Error::input(format!(
                "its samples say their angles themselves, as '{}'; leave @{angle} out",
                measured.samples.iter().find(|s| angle_in(&s.name).is_some()).map_or("", |s| &s.name)
            )));
        }
        (known, None) if known == said.len() => said,
        (_, None) => {
            let without = said.iter().position(Option::is_none).unwrap_or(0);
            return Err(Error::input(format!(
                "the sample '{}' says no angle, but others do; name it with one, or take single ones with `column`",
                measured.samples[without].name
            ))
            .naming(&["column"]));
        }
    };
    if let Some(bad) = found.iter().flatten().find(|angle| angle.abs() >= 90.0) {
        return Err(Error::input(format!("{bad}° is no angle of incidence; they lie between -90 and 90")));
    }
    Ok(found)
}

/// Samples of several files at the wavelengths of the first that all of them reach.
fn pooled(samples: Vec<Sample>, reading: String) -> Result<Measured> {
    let at = samples[0].spectrum.wavelengths().clone();
    let samples = if samples.iter().all(|sample| *sample.spectrum.wavelengths() == at) {
        samples
    } else {
        let own = |sample: &Sample| Own {
            name: sample.name.clone(),
            positions: sample.spectrum.wavelengths().nm().to_vec(),
            values: sample.spectrum.values().to_vec(),
        };
        let all = brought_to(at.nm(), samples.iter().map(own))?;
        let known: Vec<usize> =
            (0..at.len()).filter(|&i| all.iter().all(|(_, values)| values[i].is_finite())).collect();
        if known.len() < 2 {
            return Err(Error::input(format!(
                "the measurements '{}' and others have fewer than two wavelengths in common",
                samples[0].name
            )));
        }
        let nm = Wavelengths::new(known.iter().map(|&i| at[i]).collect::<Vec<_>>())?;
        let kept = |values: Vec<f64>| known.iter().map(|&i| values[i]).collect();
        all.into_iter()
            .map(|(name, values)| Ok(Sample { name, spectrum: Spectrum::new(nm.clone(), kept(values))? }))
            .collect::<Result<Vec<_>>>()?
    };
    let at = samples[0].spectrum.wavelengths().clone();
    let (mean, std) = mean(&samples, &at)?;
    Ok(Measured { samples, mean, std, reading })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// A folder with these files.
    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            fs::write(folder.path().join(name), text).unwrap();
        }
        folder
    }

    fn read(folder: &tempfile::TempDir, places: &[&str]) -> Result<Measurements> {
        let places: Vec<String> =
            places.iter().map(|place| folder.path().join(place).display().to_string()).collect();
        read_measurements(&places, None, None)
    }

    const ONE: &str = "wl,R\n400,0.1\n500,0.3\n";

    #[test]
    fn individuals_of_several_files_are_pooled_at_the_wavelengths_of_the_first() {
        let files = [("a.csv", ONE), ("b.csv", "wl,R\n350,0.1\n450,0.2\n550,0.3\n"), ("README.txt", "words")];
        let folder = folder(&files);
        let two = read(&folder, &["a.csv", "b.csv"]).unwrap();
        assert_eq!((two.angles.len(), two.angles_deg()), (1, None));
        let measured = two.at(30.0).unwrap();
        let names: Vec<_> = measured.samples.iter().map(|sample| sample.name.as_str()).collect();
        assert_eq!((names, measured.mean.wavelengths().nm()), (vec!["a", "b"], &[400.0, 500.0][..]));
        assert!((measured.mean.values()[0] - 0.125).abs() < 1e-12 && measured.std.is_some());
        // A folder is its files in the order of their names; pages to read are none.
        assert_eq!(read(&folder, &[""]).unwrap().angles, two.angles);
        fs::write(folder.path().join("c.csv"), "wl,R\n700,0.1\n800,0.2\n").unwrap();
        let refusal = read(&folder, &[""]).unwrap_err();
        assert!(refusal.is_input() && refusal.to_string().contains("in common"), "{refusal}");
    }

    #[test]
    fn angles_are_those_behind_at_signs_in_names_and_in_columns() {
        let folder = folder(&[
            ("a.csv", ONE),
            ("bird_30deg.csv", ONE),
            ("wide.csv", "wl,0deg,30deg,60°\n400,0.1,0.2,0.3\n500,0.2,0.3,0.4\n"),
            ("long.csv", "angle_deg,wl,R\n0,400,0.1\n0,500,0.2\n12.5,400,0.3\n12.5,500,0.4\n"),
            (
                "birds.csv",
                "bird,angle,wl,R\nx,0,400,0.1\nx,0,500,0.2\ny,0,400,0.3\ny,0,500,0.4\n\
                           x,30,400,0.1\nx,30,500,0.2\n",
            ),
            ("odd@2.csv", ONE),
        ]);
        let of = |places: &[&str]| read(&folder, places).unwrap().angles_deg();
        assert_eq!(of(&["a.csv@30", "a.csv@-10"]), Some(vec![-10.0, 30.0]));
        assert_eq!(of(&["bird_30deg.csv", "a.csv@0"]), Some(vec![0.0, 30.0]));
        assert_eq!(of(&["odd@2.csv"]), None);
        let wide = read(&folder, &["wide.csv"]).unwrap();
        assert_eq!(wide.angles_deg(), Some(vec![0.0, 30.0, 60.0]));
        assert_eq!(wide.at(30.0).unwrap().mean.values(), [0.2, 0.3]);
        assert_eq!(wide.at(45.0), None);
        let long = read(&folder, &["long.csv"]).unwrap();
        assert_eq!(long.angles_deg(), Some(vec![0.0, 12.5]));
        assert_eq!(long.at(12.5).unwrap().mean.values(), [0.3, 0.4]);
        let birds = read(&folder, &["birds.csv"]).unwrap();
        let counts: Vec<_> =
            birds.angles.iter().map(|at| (at.angle_deg, at.measured.samples.len())).collect();
        assert_eq!(counts, [(Some(0.0), 2), (Some(30.0), 1)]);
    }

    #[test]
    fn what_says_its_angle_in_part_or_twice_is_refused() {
        let folder = folder(&[
            ("a.csv", ONE),
            ("b_100deg.csv", ONE),
            ("some.csv", "wl,30deg,other\n400,0.1,0.2\n500,0.2,0.3\n"),
            ("wide.csv", "wl,0deg,30deg\n400,0.1,0.2\n500,0.2,0.3\n"),
        ]);
        for (places, says) in [
            (&["a.csv", "wide.csv"][..], "'a' says no angle, but another measurement says 0°"),
            (&["wide.csv@10"], "say their angles themselves"),
            (&["some.csv"], "the sample 'other' says no angle"),
            (&["a.csv@95"], "'95' is no angle"),
            (&["a.csv@x"], "'x' is no angle"),
            (&["b_100deg.csv"], "100° is no angle of incidence"),
        ] {
            let error = read(&folder, places).unwrap_err();
            let text = error.to_string();
            assert!(error.is_input() && text.contains(says) && text.len() < 600, "{text}");
        }
        let empty = tempfile::tempdir().unwrap();
        let refusal = read_measurements(&[empty.path().display().to_string()], None, None).unwrap_err();
        assert!(refusal.to_string().contains("has no files of measurements"), "{refusal}");
    }
}
