//! Materials by name.

use std::collections::BTreeMap;

use super::expression::is_name;
use super::{Material, Table};
use crate::error::did_you_mean;
use crate::error::shortened;
use crate::{Error, Result};

/// The media that structures may name.
#[derive(Debug, Clone, PartialEq)]
pub struct Library {
    materials: BTreeMap<String, Material>,
}

impl Default for Library {
    fn default() -> Self {
        Self::builtin()
    }
}

impl Library {
    /// Air, keratin and melanin; aluminium, copper, gold and silver.
    #[must_use]
    pub fn builtin() -> Self {
        let materials = [
            ("air", Material::air()),
            ("aluminium", Material::aluminium()),
            ("copper", Material::copper()),
            ("gold", Material::gold()),
            ("keratin", Material::keratin()),
            ("melanin", Material::melanin()),
            ("silver", Material::silver()),
        ];
        Self { materials: materials.into_iter().map(|(name, m)| (name.to_owned(), m)).collect() }
    }

    /// The material of a name.
    ///
    /// # Errors
    /// No material has that name; the nearest one is offered.
    pub fn get(&self, name: &str) -> Result<&Material> {
        self.materials.get(name).ok_or_else(|| {
            let name = shortened(name);
            let near = did_you_mean(&name, self.names());
            let known = if near.is_empty() {
                format!("; known are {}", shortened(&self.names().collect::<Vec<_>>().join(", ")))
            } else {
                near
            };
            Error::input(format!("there is no medium '{name}'{known}"))
        })
    }

    /// Adds a material under a name, in place of one that had it.
    ///
    /// # Errors
    /// The name is not a letter followed by up to 63 letters, digits, `-`, `_` or `.`, or is the word `mix`.
    pub fn insert(&mut self, name: &str, material: Material) -> Result<()> {
        if !is_name(name) {
            return Err(Error::input(format!(
                "'{}' cannot name a medium; use a letter followed by up to 63 letters, digits, - and _, and not 'mix'",
                shortened(name)
            )));
        }
        self.materials.insert(name.to_owned(), material);
        Ok(())
    }

    /// Adds a user's table under a name.
    ///
    /// # Errors
    /// As [`Library::insert`].
    pub fn insert_table(&mut self, name: &str, table: Table) -> Result<()> {
        self.insert(name, Material::Table(table.into()))
    }

    /// The known names in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.materials.keys().map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_names_come_with_the_nearest_known() {
        let library = Library::builtin();
        assert_eq!(library.get("melanin").unwrap(), &Material::melanin());
        let message = library.get("melanine").unwrap_err().to_string();
        assert_eq!(message, "there is no medium 'melanine', did you mean 'melanin'?");
        assert!(
            library
                .get("zirconium-oxide")
                .unwrap_err()
                .to_string()
                .contains("known are air, aluminium, copper, gold, keratin")
        );
        assert!(library.get(&"x".repeat(10_000)).unwrap_err().to_string().len() < 600);
    }

    #[test]
    fn names_that_the_stack_language_cannot_hold_are_refused() {
        let mut library = Library::builtin();
        for bad in ["", "1a", "a/b", "a:b", "mix", "a b", "1.5", "j(", &"a".repeat(65)] {
            assert!(
                library.insert(bad, Material::air()).unwrap_err().to_string().contains("cannot name"),
                "{bad}"
            );
        }
        library.insert("chitin-2", Material::keratin()).unwrap();
        assert_eq!(library.get("chitin-2").unwrap(), &Material::keratin());
    }
}
