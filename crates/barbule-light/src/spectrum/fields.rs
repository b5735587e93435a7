//! Numbers with names, as tables and documents give them.

use serde::ser::{Serialize, SerializeMap, Serializer};

/// One value for machines.
#[derive(Debug, Clone, PartialEq)]
pub enum Field {
    /// A number; none where there is no such thing.
    Number(Option<f64>),
    /// How many.
    Count(usize),
    /// Yes or no.
    Flag(Option<bool>),
    /// A word without commas, such as a colour `#rrggbb`.
    Word(Option<String>),
    /// A sentence, which tables leave out.
    Note(Option<String>),
    /// Several things of the same kind, which tables leave out.
    List(Vec<Fields>),
}

impl Field {
    /// A number, or none where it is not finite.
    #[must_use]
    pub fn number(value: impl Into<Option<f64>>) -> Self {
        Self::Number(value.into().filter(|v| v.is_finite()))
    }

    fn cell(&self) -> String {
        match self {
            Self::Number(value) => value.map_or_else(String::new, |v| v.to_string()),
            Self::Count(value) => value.to_string(),
            Self::Flag(value) => value.map_or_else(String::new, |v| v.to_string()),
            Self::Word(value) | Self::Note(value) => value.clone().unwrap_or_default(),
            Self::List(_) => String::new(),
        }
    }
}

/// Values by their names, in the order of a table's columns. As a document it is a map with null where there is no
/// such value.
#[derive(Debug, Clone, PartialEq)]
pub struct Fields(pub Vec<(&'static str, Field)>);

impl Fields {
    /// The names of a table's columns, separated by commas.
    #[must_use]
    pub fn csv_header(&self) -> String {
        self.columns().map(|(name, _)| *name).collect::<Vec<_>>().join(",")
    }

    /// The cells of one row in the same order, separated by commas; empty where there is no such value.
    #[must_use]
    pub fn csv_cells(&self) -> String {
        self.columns().map(|(_, field)| field.cell()).collect::<Vec<_>>().join(",")
    }

    fn columns(&self) -> impl Iterator<Item = &(&'static str, Field)> {
        self.0.iter().filter(|(_, field)| !matches!(field, Field::Note(_) | Field::List(_)))
    }
}

impl Serialize for Field {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(value) => value.serialize(serializer),
            Self::Count(value) => value.serialize(serializer),
            Self::Flag(value) => value.serialize(serializer),
            Self::Word(value) | Self::Note(value) => value.serialize(serializer),
            Self::List(values) => values.serialize(serializer),
        }
    }
}

impl Serialize for Fields {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, field) in &self.0 {
            map.serialize_entry(name, field)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_empty_in_tables_and_sentences_stay_out() {
        let fields = Fields(vec![
            ("a", Field::number(0.5)),
            ("b", Field::number(f64::NAN)),
            ("c", Field::Flag(Some(true))),
            ("d", Field::Note(Some("one, two".into()))),
            ("e", Field::Word(Some("#ffffff".into()))),
        ]);
        assert_eq!(
            (fields.csv_header().as_str(), fields.csv_cells().as_str()),
            ("a,b,c,e", "0.5,,true,#ffffff")
        );
    }
}
