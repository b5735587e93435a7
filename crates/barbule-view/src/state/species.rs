//! A species with sizes of one's own: every number of its generator is a slider.

use std::collections::BTreeMap;

use barbule::error::{did_you_mean, shortened};
use barbule::fields::{Key, Kind, Map, Value, path_of};
use barbule::material::Library;
use barbule::structure::{GeneratorParameters, SpeciesFile, SpeciesModel};
use barbule::{Error, Result};

use super::slider::{Slider, spoken};

/// A variant of a species, and what was moved in it.
#[derive(Debug, Clone)]
pub struct SpeciesSizes {
    /// Its file; none where only its numbers are known, as those that a material records.
    file: Option<Box<SpeciesFile>>,
    /// The generator's keys.
    keys: Vec<Key>,
    /// As it was opened, and its parameters as files have them.
    original: SpeciesModel,
    parameters: Map<String, Value>,
    /// What was moved, by the paths of the numbers.
    moved: BTreeMap<String, f64>,
    /// As it is.
    model: SpeciesModel,
}

impl SpeciesSizes {
    /// A variant of a file, or its default one, of these media.
    ///
    /// # Errors
    /// There is no such variant, or it names a medium that is not among the media.
    pub fn of_file(file: SpeciesFile, variant: Option<&str>, media: Library) -> Result<Self> {
        let model = file.model(variant, media)?;
        Ok(Self { file: Some(Box::new(file)), ..Self::of_model(model)? })
    }

    /// A model of which no file is known but, where it is built in, that of its species.
    ///
    /// # Errors
    /// Its parameters cannot be written, which none do.
    pub fn of_model(model: SpeciesModel) -> Result<Self> {
        let unwritable =
            |error: serde_json::Error| Error::machine(format!("parameters cannot be written: {error}"));
        let mut parameters = match serde_json::to_value(&model.parameters).map_err(unwritable)? {
            Value::Object(table) => table,
            _ => Map::new(),
        };
        let generator = parameters.remove("generator");
        let generator = generator.as_ref().and_then(Value::as_str).unwrap_or_default();
        let keys = GeneratorParameters::keys(generator)?;
        let file = SpeciesFile::builtin(&model.name).ok().map(Box::new);
        Ok(Self { file, keys, original: model.clone(), parameters, moved: BTreeMap::new(), model })
    }

    /// The species as it is.
    #[must_use]
    pub fn model(&self) -> &SpeciesModel {
        &self.model
    }

    /// The species as it was opened.
    #[must_use]
    pub fn original(&self) -> &SpeciesModel {
        &self.original
    }

    /// What was moved: values by the keys of their sliders.
    #[must_use]
    pub fn moved(&self) -> &BTreeMap<String, f64> {
        &self.moved
    }

    /// Every number of the species, in the order of its generator's keys.
    #[must_use]
    pub fn sliders(&self) -> Vec<Slider> {
        let mut sliders = Vec::new();
        let mut table = self.parameters.clone();
        walk(&self.keys, &mut table, "", &mut |path, key, kind, value| {
            let Kind::Number { low, high, whole } = *kind else { return };
            let default = value.as_f64().unwrap_or_default();
            sliders.push(Slider {
                key: path.to_owned(),
                name: name_of(path),
                about: key.about.to_owned(),
                unit: key.unit(),
                range: [low, high],
                whole,
                default,
                value: self.moved.get(path).copied().unwrap_or(default),
            });
        });
        sliders
    }

    /// Puts numbers in the place of those that were moved before; all others are as they were at first.
    ///
    /// # Errors
    /// There is no such number (the nearest is offered), one is outside its range, or all together make no barbule; then nothing
    /// has changed.
    pub fn put(&mut self, moved: &BTreeMap<String, f64>) -> Result<()> {
        let mut table = self.parameters.clone();
        let mut known = Vec::new();
        let mut kept = BTreeMap::new();
        walk(&self.keys, &mut table, "", &mut |path, _, kind, value| {
            known.push(path.to_owned());
            if let Some(&number) = moved.get(path) {
                if value.as_f64() != Some(number) {
                    kept.insert(path.to_owned(), number);
                }
                *value = written(number, kind);
            }
        });
        if let Some(key) = moved.keys().find(|key| !known.contains(key)) {
            return Err(unknown(&self.original.title(), key, &known));
        }
        let changes: Vec<(&str, Value)> = (table.iter())
            .filter(|(name, value)| self.parameters.get(*name) != Some(value))
            .map(|(name, value)| (name.as_str(), value.clone()))
            .collect();
        let model =
            self.original.with_parameters(&changes).map_err(|error| error.at(self.original.title()))?;
        (self.model, self.moved) = (model, kept);
        Ok(())
    }

    /// The text of a species' file that makes the same barbules as these.
    ///
    /// # Errors
    /// No file of the species is known, or the format cannot write it.
    pub fn file_text(&self) -> Result<String> {
        let Some(file) = &self.file else {
            return Err(Error::input(format!(
                "{} is known by its numbers alone, so it has no species file to start from; open the species by its name or file",
                self.original.title()
            )));
        };
        let mut table = self.parameters.clone();
        walk(&self.keys, &mut table, "", &mut |path, _, kind, value| {
            if let Some(&number) = self.moved.get(path) {
                *value = written(number, kind);
            }
        });
        file.flat_toml_of(Some(&self.original.variant), &table)
    }
}

/// A number as files have it: whole ones without a point.
fn written(number: f64, kind: &Kind) -> Value {
    match kind {
        Kind::Number { whole: true, .. } if number.fract() == 0.0 && number >= 0.0 => (number as u64).into(),
        _ => number.into(),
    }
}

/// What a path is called: the words of its last key, with the number of what it is in, as in `layer 2 thickness`.
fn name_of(path: &str) -> String {
    let parts = path.split('.').map(|part| match part.split_once('[') {
        None => spoken(part),
        Some((list, index)) => {
            let number = index.trim_end_matches(']').parse::<usize>().unwrap_or_default() + 1;
            format!("{} {number}", spoken(list).trim_end_matches('s'))
        }
    });
    parts.collect::<Vec<_>>().join(" ")
}

pub(super) fn unknown(what: &str, key: &str, known: &[String]) -> Error {
    let near = did_you_mean(key, known.iter().map(String::as_str));
    let help = if near.is_empty() { format!("; known are {}", shortened(&known.join(", "))) } else { near };
    Error::input(format!("{what} has no size '{}'{help}", shortened(key)))
}

/// What is done at each number of a table: its path, its key, which values it may have, and the value.
type Visit<'a> = &'a mut dyn FnMut(&str, &Key, &Kind, &mut Value);

/// Visits the numbers of a table, also those in its lists and tables, in the order of the keys.
fn walk(keys: &[Key], table: &mut Map<String, Value>, place: &str, visit: Visit<'_>) {
    for key in keys {
        if let Some(value) = table.get_mut(key.name) {
            walk_value(key, &key.kind, value, &path_of(place, key.name), visit);
        }
    }
}

fn walk_value(key: &Key, kind: &Kind, value: &mut Value, path: &str, visit: Visit<'_>) {
    match (kind, value) {
        (Kind::Number { .. }, value @ Value::Number(_)) => visit(path, key, kind, value),
        (Kind::List { of, .. }, Value::Array(values)) => {
            for (index, value) in values.iter_mut().enumerate() {
                walk_value(key, of, value, &format!("{path}[{index}]"), visit);
            }
        }
        (Kind::Table(keys), Value::Object(table)) => walk(keys, table, path, visit),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::structure::species_names;

    fn opened(name: &str) -> SpeciesSizes {
        SpeciesSizes::of_file(SpeciesFile::builtin(name).unwrap(), None, Library::builtin()).unwrap()
    }

    fn one(key: &str, value: f64) -> BTreeMap<String, f64> {
        BTreeMap::from([(key.to_owned(), value)])
    }

    /// Every species has sliders for all its numbers, each within its range; where none is moved the barbule is the same.
    #[test]
    fn every_built_in_species_has_its_numbers_as_sliders() {
        for name in species_names() {
            let mut sizes = opened(name);
            let sliders = sizes.sliders();
            assert!(sliders.len() > 5, "{name}: {}", sliders.len());
            for slider in &sliders {
                let [low, high] = slider.range;
                assert!((low..=high).contains(&slider.value) && !slider.is_moved(), "{name}: {}", slider.key);
                assert!(!slider.about.is_empty(), "{name}: {}", slider.key);
            }
            let all = sliders.iter().map(|s| (s.key.clone(), s.value)).collect();
            sizes.put(&all).unwrap();
            assert_eq!(sizes.model().parameters, sizes.original().parameters, "{name}");
            assert!(sizes.moved().is_empty());
        }
    }

    #[test]
    fn a_moved_number_makes_another_barbule_and_its_file_the_same() {
        let mut sizes = opened("starling");
        let cortex = sizes.sliders().into_iter().find(|s| s.key == "cortex_um").unwrap();
        assert_eq!((cortex.unit, cortex.name.as_str(), cortex.range), ("µm", "cortex", [0.001, 10.0]));
        sizes.put(&one("cortex_um", 0.25)).unwrap();
        let before = sizes.original().section(1, 3).unwrap();
        let after = sizes.model().section(1, 3).unwrap();
        assert_ne!(before.boundaries, after.boundaries);
        assert_eq!(sizes.sliders().iter().filter(|s| s.is_moved()).count(), 1);
        let text = sizes.file_text().unwrap();
        let own = SpeciesFile::parse(&text).unwrap().model(None, Library::builtin()).unwrap();
        assert_eq!(own.parameters, sizes.model().parameters);
        sizes.put(&BTreeMap::new()).unwrap();
        assert_eq!(sizes.model().section(1, 3).unwrap(), before);
    }

    #[test]
    fn numbers_in_lists_have_paths_and_names() {
        let text = "barbule = 1\nname = \"own\"\ngenerator = \"multilayer\"\n[parameters]\nwidth_um = 20\n\
                    layers = [{ medium = \"melanin\", thickness_um = 0.1 }, { medium = \"keratin\", thickness_um = 0.12 }]\nrepeats = 3\n";
        let file = SpeciesFile::parse(text).unwrap();
        let mut sizes = SpeciesSizes::of_file(file, None, Library::builtin()).unwrap();
        let layer = sizes.sliders().into_iter().find(|s| s.key == "layers[1].thickness_um").unwrap();
        assert_eq!((layer.name.as_str(), layer.value, layer.unit), ("layer 2 thickness", 0.12, "µm"));
        sizes.put(&BTreeMap::from([(layer.key, 0.15), ("repeats".to_owned(), 4.0)])).unwrap();
        let GeneratorParameters::Multilayer(made) = &sizes.model().parameters else { panic!() };
        assert_eq!((made.layers[1].thickness_um, made.sizes.repeats), (0.15, 4));
    }

    #[test]
    fn what_makes_no_barbule_is_refused_and_changes_nothing() {
        let mut sizes = opened("starling");
        sizes.put(&one("cortex_um", 0.3)).unwrap();
        let before = sizes.model().clone();
        for (moved, words) in [
            (one("cortex", 0.3), "starling:green has no size 'cortex', did you mean 'cortex_um'?"),
            (one("cortex_um", 300.0), "cortex_um is 300, outside 0.001 to 10; did you mean 0.3 (300 nm)?"),
            (one("core_fraction_low", 1.0), "swap them"),
            (one("cortex_um", f64::NAN), "cortex_um"),
        ] {
            let refused = sizes.put(&moved).unwrap_err();
            assert!(refused.is_input() && refused.to_string().contains(words), "{refused}");
            assert_eq!((sizes.model(), sizes.moved()), (&before, &one("cortex_um", 0.3)));
        }
        let mut crystal = opened("magpie");
        let refused = crystal.put(&one("rows", 2.5)).unwrap_err().to_string();
        assert!(refused.contains("rows is 2.5, but must be a whole number"), "{refused}");
    }
}
