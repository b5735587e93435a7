//! What an atlas sweeps, as its file says it.

use std::path::{Path, PathBuf};

use barbule_base::{record, words};

use super::steps::Steps;
use crate::error::{did_you_mean, shortened};
use crate::fields::{Key, NumbersByName, Record as _, Several, Text, at_line, parse_toml, up_to, within};
use crate::io::read_text;
use crate::open::is_built_in;
use crate::{Error, Result};

/// What structures are, for people.
const STRUCTURE: Text = Text("SPECIES[:VARIANT], a stack, or the .toml file of either");

/// Letters of a name, at most.
const MOST_NAME: usize = 120;

/// What stands before a file of a light in quanta.
const QUANTA: &str = "quanta:";

words! {
    /// The plane in which angles of incidence lie.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Plane {
        /// Across the barbule: the angle is φ_i.
        "across": Across,
        /// Along the barbule: the angle is θ_i.
        "along": Along,
    }
}

words! {
    /// What is done about sizes that make no structure.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Impossible {
        /// The plan is refused.
        "refused": Refused,
        /// Their cells stay empty.
        "empty": Empty,
    }
}

record! {
    /// A key with its values.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Vary {
        /// A size of the species, as `barbule keys species:GENERATOR` lists them, or `layer1` and so on of a stack, in nm.
        key: String = "key", Text("a size of the species, or layer1 and so on of a stack");
        /// Its values: a list, "low:high:step", or low, high and count; "low:high" where samples draw.
        values: Steps = "values", ();
    }
}

record! {
    /// A patch of plumage: a structure of its own, or the common one with some sizes fixed.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Patch {
        /// What it is called.
        name: String = "name", Text("a name");
        /// Its structure; unless given that of the plan.
        structure: Option<String> = "structure", STRUCTURE;
        /// Sizes that it has in all cells.
        set: NumbersByName = "set", (), or NumbersByName::default();
    }
}

record! {
    /// A material for each cell, as `barbule characterize` makes it.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Materials {
        /// Wavelengths; unless given 300 to 700 nm in steps of 8.
        wavelengths_nm: Option<Steps> = "wavelengths_nm", ();
        /// Directions: cosθ_i in so many equal steps up to 1, cosφ_i likewise.
        directions: [usize; 2] = "directions", within(2, 200), or [20, 20];
        /// Random individuals; unless given 50, with thin 12.
        individuals: Option<usize> = "individuals", within(1, 10_000);
        /// Largest tilt of an individual about its axis.
        tilt_deg: f64 = "tilt_deg", within(0, 30), or 2.0;
        /// Takes every n-th wavelength and direction only, for a quick look.
        thin: Option<usize> = "thin", within(1, 20);
        /// Whether both incident polarizations are kept apart.
        polarized: bool = "polarized", (), or false;
    }
}

record! {
    /// The plan of an atlas.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Plan {
        /// Version of the format.
        version: usize = "barbule", within(1, 1);
        /// What the atlas is called.
        name: String = "name", Text("a name");
        /// What is swept, but for patches that name their own.
        structure: Option<String> = "structure", STRUCTURE;
        /// Patches of plumage, each of which has every cell.
        patches: Vec<Patch> = "patches", up_to(1000), or Vec::new();
        /// The keys that are swept, the slowest axis first.
        vary: Vec<Vary> = "vary", Several { least: 1, most: 8, of: () };
        /// How many cells are drawn over the ranges of all keys, by a Latin hypercube; without it the full grid.
        samples: Option<usize> = "samples", within(2, 100_000);
        /// Vacuum wavelengths of the spectra.
        wavelengths_nm: Steps = "wavelengths_nm", (), or Steps::Stepped([400.0, 694.0, 6.0]);
        /// Angles of incidence.
        angles_deg: Steps = "angles_deg", (), or Steps::List(vec![0.0]);
        /// The plane in which they lie: across the barbule, or along it.
        plane: Plane = "plane", (), or Plane::Across;
        /// Random individuals of each cell.
        individuals: usize = "individuals", within(1, 10_000), or 50;
        /// Birds that look at each cell, by name or file.
        birds: Vec<String> = "birds", Several { least: 0, most: 16, of: Text("a bird as `barbule birds` lists it, or a file") }, or Vec::new();
        /// The light in which birds see them.
        illuminant: String = "illuminant", Text("a light's name or file"), or "D65".to_owned();
        /// A material for each cell.
        material: Option<Materials> = "material", ();
        /// What is done about cells whose sizes make no structure.
        impossible: Impossible = "impossible", (), or Impossible::Refused;
        /// Cells that are one unit of work and one file of each array; unless given 1 with materials, else 8 or as many more as keep
        /// the files under 9000.
        unit_cells: Option<usize> = "unit_cells", within(1, 10_000);
    }
}

impl Plan {
    /// Reads a plan from the text of its file.
    ///
    /// # Errors
    /// Not TOML, a key that is unknown, missing or out of range; the message names the line and the key.
    pub fn parse(text: &str) -> Result<Self> {
        let table = parse_toml(text)?;
        let plan = Self::read(&table, "").and_then(Self::checked);
        plan.map_err(|error| at_line(error, text))
    }

    /// Reads the file of a plan, and says in which folder other files that it names lie.
    ///
    /// # Errors
    /// As [`Self::parse`]; the file cannot be read.
    pub fn open(path: &Path) -> Result<(Self, PathBuf)> {
        let plan = read_text(path).and_then(|text| Self::parse(&text).map_err(|e| e.in_file(path)))?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        Ok((plan, folder.unwrap_or(Path::new(".")).to_owned()))
    }

    /// Refuses what each key may be but not all together.
    fn checked(self) -> Result<Self> {
        let refuse = |key: String, what: &str| Err(Error::input(format!("{key} {what}")).about(key));
        let patches = self.patches.iter().enumerate();
        let names = patches.map(|(i, patch)| (format!("patches[{i}].name"), &patch.name));
        for (key, name) in [("name".to_owned(), &self.name)].into_iter().chain(names) {
            if name.trim().is_empty()
                || name.chars().count() > MOST_NAME
                || name.chars().any(char::is_control)
            {
                return refuse(key, &format!("must be 1 to {MOST_NAME} letters, without control characters"));
            }
        }
        for (i, vary) in self.vary.iter().enumerate() {
            if self.vary[..i].iter().any(|before| before.key == vary.key) {
                return refuse(format!("vary[{i}].key"), "is swept twice; give it once");
            }
        }
        for (i, patch) in self.patches.iter().enumerate() {
            if self.patches[..i].iter().any(|before| before.name == patch.name) {
                return refuse(format!("patches[{i}].name"), "is that of another patch; give each its own");
            }
            if patch.structure.is_none() && self.structure.is_none() {
                return refuse(
                    format!("patches[{i}].structure"),
                    "is missing; give it here, or `structure` for all patches",
                );
            }
            if let Some(key) =
                self.vary.iter().map(|vary| &vary.key).find(|key| patch.set.0.contains_key(*key))
            {
                let what = format!("fixes {} too, which is swept; leave one out", shortened(key));
                return refuse(format!("patches[{i}].set"), &what);
            }
        }
        if self.structure.is_none() && self.patches.is_empty() {
            return refuse(
                "structure".into(),
                "is missing; give a species, a stack, or the .toml file of either",
            );
        }
        if self.material.is_some() && self.unit_cells.is_some_and(|cells| cells > 1) {
            return refuse(
                "unit_cells".into(),
                "is over 1, but with materials each cell is a unit; leave it out",
            );
        }
        Ok(self)
    }

    /// The patches, or the only one without a name.
    #[must_use]
    pub fn all_patches(&self) -> Vec<Patch> {
        if self.patches.is_empty() {
            return vec![Patch { name: String::new(), structure: None, set: NumbersByName::default() }];
        }
        self.patches.clone()
    }

    /// The keys of a plan's file.
    #[must_use]
    pub fn file_keys() -> Vec<Key> {
        Self::keys()
    }
}

/// What a text of a plan names, as it is opened from anywhere: files lie where the plan's folder says.
pub(super) fn placed(text: &str, folder: &Path) -> String {
    if is_built_in(text) {
        return text.to_owned();
    }
    if let Some(file) = text.strip_prefix(QUANTA) {
        return format!("{QUANTA}{}", placed(file, folder));
    }
    let (file, variant) = match text.rsplit_once(':') {
        Some((file, variant)) if file.to_lowercase().ends_with(".toml") => (file, Some(variant)),
        _ => (text, None),
    };
    let path = folder.join(file);
    if !path.exists() {
        return text.to_owned();
    }
    let path = path.to_string_lossy();
    variant.map_or_else(|| path.to_string(), |variant| format!("{path}:{variant}"))
}

/// The refusal of a key that a structure does not have.
pub(super) fn no_key(title: &str, key: &str, known: &[String]) -> Error {
    let near = did_you_mean(key, known.iter().map(String::as_str));
    Error::input(format!(
        "{title} has no size '{}'{near} (known are {})",
        shortened(key),
        shortened(&known.join(", "))
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "barbule = 1\nname = 'films'\nstructure = 'starling'\n[[vary]]\nkey = 'cortex_um'\nvalues = '0.2:0.5:0.1'\n";

    #[test]
    fn a_plan_says_what_is_usual_where_its_file_does_not() {
        let plan = Plan::parse(GOOD).unwrap();
        assert_eq!((plan.individuals, plan.plane, plan.illuminant.as_str()), (50, Plane::Across, "D65"));
        assert_eq!(plan.wavelengths_nm.values("").unwrap().len(), 50);
        assert_eq!((plan.all_patches().len(), plan.material.is_none()), (1, true));
        let written = toml::to_string(&plan.table()).unwrap();
        assert_eq!(Plan::parse(&written).unwrap(), plan);
    }

    #[test]
    fn plans_that_cannot_be_are_refused_at_their_lines() {
        let patch = |more: &str| format!("{GOOD}[[patches]]\nname = 'a'\n{more}");
        for (text, part) in [
            (GOOD.replace("barbule = 1", "barbule = 2"), "line 1: barbule is 2, outside 1 to 1"),
            (GOOD.replace("'films'", "''"), "line 2: name must be 1 to 120 letters"),
            (GOOD.replace("'films'", "\"a\\u001b[31m\""), "line 2: name must be 1 to 120 letters"),
            (GOOD.replace("name =", "nmae ="), "line 2: unknown key 'nmae', did you mean 'name'?"),
            (GOOD.replace("structure = 'starling'\n", ""), "structure is missing; give a species"),
            (GOOD.replace("'0.2:0.5:0.1'", "0.2:0.5"), "is not TOML"),
            (GOOD.replace("key = 'cortex_um'\n", ""), "vary[0].key is missing"),
            (
                format!("{GOOD}[[vary]]\nkey = 'cortex_um'\nvalues = [1]\n"),
                "line 8: vary[1].key is swept twice",
            ),
            (format!("{GOOD}[material]\nthin = 0\n"), "material.thin is 0, outside 1 to 20"),
            (
                GOOD.replace("[[vary]]", "unit_cells = 4\nmaterial = {}\n[[vary]]"),
                "with materials each cell is a unit",
            ),
            (patch("[patches.set]\ncortex_um = 0.3\n"), "patches[0].set fixes cortex_um too"),
            (patch("[[patches]]\nname = 'a'\n"), "patches[1].name is that of another patch"),
            (GOOD.replace("[[vary]]", "samples = 1\n[[vary]]"), "samples is 1, outside 2 to 100000"),
            (GOOD.replace("[[vary]]", "plane = 'acros'\n[[vary]]"), "did you mean 'across'?"),
        ] {
            let message = Plan::parse(&text).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
        let no_vary = "barbule = 1\nname = 'x'\nstructure = 'starling'\n";
        assert!(Plan::parse(no_vary).unwrap_err().to_string().contains("vary is missing"));
    }
}
