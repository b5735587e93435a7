//! Media as section and lattice files name them: the table `materials`, substances and mixtures.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use super::tables::{MediumSource, add_media};
use crate::error::shortened;
use crate::fields::{Fields, list, number};
use crate::material::Library;
use crate::structure::{MaterialSource, Medium, Substance};
use crate::{Complex64, Error, Result};

/// Reads `materials` into the library; also where each came from, with absolute paths.
pub(super) fn materials(
    value: Option<&Value>,
    folder: &Path,
    library: &mut Library,
) -> Result<BTreeMap<String, MaterialSource>> {
    let Some(value) = value else { return Ok(BTreeMap::new()) };
    let Value::Object(table) = value else {
        return Err(Error::input("materials must be a table of names, each with a file or [n, k]"));
    };
    let mut media = BTreeMap::new();
    let mut sources = BTreeMap::new();
    for (name, value) in table {
        let place = format!("materials.{}", shortened(name));
        let source = match value {
            Value::String(file) => {
                let path = folder.join(file);
                sources
                    .insert(name.clone(), MaterialSource::File(std::path::absolute(&path).unwrap_or(path)));
                MediumSource::File(file.clone())
            }
            Value::Array(_) => {
                let index = index(value, &place)?;
                sources.insert(name.clone(), MaterialSource::Index(index));
                MediumSource::Index([index.re, index.im])
            }
            _ => return Err(Error::input(format!("{place} must be the name of a file, or an index [n, k]"))),
        };
        media.insert(name.clone(), source);
    }
    add_media(&media, folder, library)?;
    Ok(sources)
}

fn index(value: &Value, place: &str) -> Result<Complex64> {
    match list(value, place)? {
        [n, k] => Ok(Complex64::new(number(n, &format!("{place}[0]"))?, number(k, &format!("{place}[1]"))?)),
        other => Err(Error::input(format!("{place} has {} numbers, but an index is [n, k]", other.len()))),
    }
}

/// What is between two boundaries, or in an inclusion.
pub(super) fn medium(value: &Value, place: &str) -> Result<Medium> {
    if let Value::Object(table) = value
        && !table.contains_key("index")
    {
        let fields = Fields::new(value, place, &["mix", "x", "fraction", "index"])?;
        let path = fields.path("mix");
        let [first, second] = fields.list("mix", "two media, as in \"mix\": [\"keratin\", \"melanin\"]")?
        else {
            return Err(Error::input(format!("{path} must list two media")));
        };
        return Ok(Medium::Mixture {
            first: substance(first, &format!("{path}[0]"))?,
            second: substance(second, &format!("{path}[1]"))?,
            x_um: fields.numbers("x")?,
            fraction: fields.numbers("fraction")?,
        });
    }
    substance(value, place).map(Medium::Pure)
}

/// One medium, not a mixture.
pub(super) fn substance(value: &Value, place: &str) -> Result<Substance> {
    match value {
        Value::String(name) => Ok(Substance::Named(name.clone())),
        Value::Object(_) => {
            let fields = Fields::new(value, place, &["index"])?;
            Ok(Substance::Index(index(fields.need("index", "[n, k]")?, &fields.path("index"))?))
        }
        _ => Err(Error::input(format!(
            "{place} must be a medium: a name, {{\"index\": [n, k]}}, or {{\"mix\": [a, b], \"x\": …, \"fraction\": …}}"
        ))),
    }
}

/// As [`substance`] reads it.
pub(super) fn substance_json(substance: &Substance) -> Value {
    match substance {
        Substance::Named(name) => json!(name),
        Substance::Index(n) => json!({"index": [n.re, n.im]}),
    }
}

/// As [`medium`] reads it.
pub(super) fn medium_json(medium: &Medium) -> Value {
    match medium {
        Medium::Pure(substance) => substance_json(substance),
        Medium::Mixture { first, second, x_um, fraction } => {
            json!({"mix": [substance_json(first), substance_json(second)], "x": x_um, "fraction": fraction})
        }
    }
}
