//! What was computed, in each form of output: all of them follow from the same labelled arrays.

use std::fmt::Write as _;
use std::path::Path;

use barbule::Result;
use barbule::io::{
    Coordinate, LabelledArrays, Numbers, Quantity, check_new_zarr, check_writable, write_together,
    write_whole, write_zarr,
};
use barbule::plot::Drawing;
use serde_json::{Map, Value, json};

use crate::provenance::{Provenance, is_beside, sidecar};

/// Axes that stand for themselves where they have a single value.
pub(super) const INSTANCE: &str = "instance";
pub(super) const INCIDENT: &str = "wi";

/// Rows of the table for people: all of them, or so many and how many more there are.
const MOST_PRINTED: usize = 200;
const FIRST_PRINTED: usize = 40;

/// What `-o` asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Figure,
    Table,
    Npy,
    Zarr,
}

impl Form {
    pub(super) fn of(path: &Path) -> Self {
        let end = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match end.as_str() {
            "csv" => Self::Table,
            "npy" => Self::Npy,
            "zarr" => Self::Zarr,
            _ => Self::Figure,
        }
    }

    /// Refuses early what could not be written.
    pub(super) fn check(self, path: &Path) -> Result<()> {
        match self {
            Self::Figure => Ok(()),
            Self::Zarr => check_new_zarr(path),
            Self::Table | Self::Npy => {
                check_writable(path)?;
                if is_beside(path) { check_writable(&sidecar(path)) } else { Ok(()) }
            }
        }
    }
}

/// What was computed.
pub(super) struct Answer {
    /// Over the axes instance (where instances were asked for), wi, wavelength and outgoing direction.
    pub(super) arrays: LabelledArrays,
    /// Of marginals, `[instance][wi][wavelength]`.
    pub(super) reflected: Option<Vec<f64>>,
    /// N of a grid of outgoing directions.
    pub(super) grid: Option<usize>,
    pub(super) drawing: Option<Drawing>,
}

/// What a fraction may be over 1 by the error of its integral alone.
const OVER: f64 = 1e-3;

impl Answer {
    /// Which reflected fractions are over all light.
    pub(super) fn flagged(&self) -> Vec<bool> {
        self.reflected.iter().flatten().map(|reflected| *reflected > 1.0 + OVER).collect()
    }

    /// Axes of JSON and tables: those of the arrays without single instances and single incident directions.
    fn axes(&self) -> impl Iterator<Item = &(&'static str, usize)> {
        self.arrays.axes.iter().filter(|(name, length)| *length > 1 || ![INSTANCE, INCIDENT].contains(name))
    }

    fn coordinates(&self, axis: &str) -> impl Iterator<Item = &Coordinate> {
        self.arrays.coordinates.iter().filter(move |coordinate| coordinate.axis == axis)
    }

    /// The document but for what names it: coordinates, then values nested by `axes`.
    pub(super) fn json(&self) -> Map<String, Value> {
        let mut to = Map::new();
        to.insert("axes".into(), self.axes().map(|(name, _)| *name).collect());
        for coordinate in &self.arrays.coordinates {
            let is_single = [INSTANCE, INCIDENT].contains(&coordinate.axis) && coordinate.values.len() == 1;
            let value = match &coordinate.values {
                Numbers::Floats(values) if is_single => json!(values[0]),
                Numbers::Counts(values) if is_single => json!(values[0]),
                Numbers::Floats(values) => json!(values),
                Numbers::Counts(values) => json!(values),
            };
            if coordinate.name == "x_out" {
                to.insert("grid".into(), self.grid.into());
            }
            to.insert(coordinate.name.into(), value);
        }
        let shape: Vec<usize> = self.axes().map(|(_, length)| *length).collect();
        for Quantity { name, values, .. } in &self.arrays.quantities {
            to.insert((*name).into(), nested(values, &shape));
        }
        if let Some(reflected) = &self.reflected {
            let shape = &shape[..shape.len() - 1];
            to.insert("reflected_fraction".into(), nested(reflected, shape));
            to.insert("flagged".into(), nested(&self.flagged(), shape));
        }
        to
    }

    /// Names of the columns of the table: coordinates, then values, with their units.
    pub(super) fn columns(&self) -> Vec<(&'static str, &'static str)> {
        let coordinates = self.axes().flat_map(|(axis, _)| self.coordinates(axis)).map(|c| (c.name, ""));
        coordinates.chain(self.arrays.quantities.iter().map(|q| (q.name, q.units))).collect()
    }

    /// How many rows the table has.
    pub(super) fn rows(&self) -> usize {
        self.arrays.shape().iter().product()
    }

    /// A row of the table, each cell by one of these.
    fn row<T>(&self, index: usize, number: impl Fn(f64) -> T, count: impl Fn(u64) -> T) -> Vec<T> {
        let (mut rest, mut places) = (index, Vec::new());
        for (_, length) in self.arrays.axes.iter().rev() {
            places.push(rest % length);
            rest /= length;
        }
        places.reverse();
        let mut cells = Vec::new();
        for (axis, _) in self.axes() {
            let place = self.arrays.axes.iter().position(|(name, _)| name == axis).map_or(0, |at| places[at]);
            for coordinate in self.coordinates(axis) {
                cells.push(match &coordinate.values {
                    Numbers::Floats(values) => number(values[place]),
                    Numbers::Counts(values) => count(values[place]),
                });
            }
        }
        cells.extend(self.arrays.quantities.iter().map(|quantity| number(quantity.values[index])));
        cells
    }

    pub(super) fn csv(&self) -> String {
        let mut text = self.columns().iter().map(|(name, _)| *name).collect::<Vec<_>>().join(",");
        for index in 0..self.rows() {
            text.push('\n');
            text += &self.row(index, written, |count| count.to_string()).join(",");
        }
        text + "\n"
    }

    /// The table for people: columns as wide as their names, and of many rows the first.
    pub(super) fn aligned(&self) -> String {
        let columns = self.columns();
        let mut text = String::new();
        for (name, units) in &columns {
            let head = if units.is_empty() { (*name).to_owned() } else { format!("{name} ({units})") };
            let _ = write!(text, "{head:>14}");
        }
        let rows = self.rows();
        let shown = if rows > MOST_PRINTED { FIRST_PRINTED } else { rows };
        for index in 0..shown {
            text.push('\n');
            let cells =
                self.row(index, |value| (Some(value), String::new()), |count| (None, count.to_string()));
            for ((value, count), (_, units)) in cells.iter().zip(&columns) {
                // Writing to a string cannot fail.
                let _ = match value {
                    None => write!(text, "{count:>14}"),
                    Some(value) if units.is_empty() => write!(text, "{value:14.4}"),
                    Some(value) => write!(text, "{value:14.6e}"),
                };
            }
        }
        if shown < rows {
            let _ = write!(
                text,
                "\n… and {} rows more: all with -o F.csv, F.npy or F.zarr, or --json",
                rows - shown
            );
        }
        text
    }

    /// Writes arrays or a table with what made them.
    pub(super) fn write(&self, form: Form, path: &Path, provenance: &Provenance) -> Result<()> {
        match form {
            Form::Figure => match &self.drawing {
                Some(drawing) => provenance.write_figure(path, drawing),
                None => Ok(()),
            },
            Form::Table => provenance.write_csv(path, &self.csv()),
            Form::Zarr => {
                let attributes = match provenance.json() {
                    Value::Object(notes) => notes,
                    _ => Map::new(),
                };
                write_zarr(path, &self.arrays, &attributes)
            }
            Form::Npy => {
                let quantity = &self.arrays.quantities[0];
                let bytes = self.arrays.npy(quantity);
                if !is_beside(path) {
                    return write_whole(path, &bytes);
                }
                let mut notes = self.arrays.labels(quantity);
                notes["made"] = provenance.json();
                write_together(&[(path, &bytes), (&sidecar(path), format!("{notes}\n").as_bytes())])
            }
        }
    }
}

/// A number in as few digits as tell it apart.
fn written(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-4 { format!("{value:e}") } else { value.to_string() }
}

/// Values in the order of axes as lists in lists.
fn nested<T: serde::Serialize>(values: &[T], shape: &[usize]) -> Value {
    match shape {
        [] | [_] => json!(values),
        [length, rest @ ..] => {
            let each = (values.len() / length).max(1);
            values.chunks(each).map(|part| nested(part, rest)).collect()
        }
    }
}
