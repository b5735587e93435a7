//! Sensors: what each channel answers to light, as tables in CSV or TOML.

use std::path::Path;

use serde_json::Value;

use super::read_text;
use crate::error::{counted, shortened};
use crate::fields::{Fields, at_line, list, number, parse_toml};
use crate::spectrum::dense::{DenseSpectrum, LONGEST_NM, SHORTEST_NM};
use crate::spectrum::sensor::{Band, Curve, Sensor};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::{Error, Result};

/// Reads a sensor: `.toml` with `wavelength_nm`, `[[channels]]` and perhaps `name` and `to_xyz`; anything else as CSV whose first
/// column is `wavelength_nm` and every further one a channel. Curves are linear between the wavelengths; the band is of the whole
/// nanometres within them. Without a name it is the file's.
///
/// # Errors
/// The file cannot be read, or anything that `docs/formats/sensor.md` lists; the message names the file and the place.
pub fn read_sensor(path: &Path) -> Result<Sensor> {
    let text = read_text(path)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let is_toml = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let sensor = if is_toml { of_toml(&text, &stem) } else { of_csv(&text, &stem) };
    sensor.map_err(|error| error.at(path.display()))
}

fn of_toml(text: &str, stem: &str) -> Result<Sensor> {
    of_table(&parse_toml(text)?, stem).map_err(|error| at_line(error, text))
}

fn of_table(value: &Value, stem: &str) -> Result<Sensor> {
    let fields = Fields::new(value, "", &["name", "wavelength_nm", "channels", "to_xyz"])?;
    let nm = fields.numbers("wavelength_nm")?;
    let mut channels = Vec::new();
    for (index, channel) in fields.list("channels", "tables [[channels]]")?.iter().enumerate() {
        let place = format!("channels[{index}]");
        let channel = Fields::new(channel, &place, &["name", "values"])?;
        let name = channel.text("name")?.unwrap_or_default();
        let values = channel.numbers("values")?;
        if values.len() != nm.len() {
            return Err(Error::input(format!(
                "{} has {}, but wavelength_nm has {}; give one for each",
                channel.path("values"),
                counted(values.len(), "number"),
                nm.len()
            )));
        }
        channels.push((name.to_owned(), values));
    }
    let sensor = made(fields.text("name")?.unwrap_or(stem), nm, channels)?;
    let Some(rows) = fields.get("to_xyz") else { return Ok(sensor) };
    let [x, y, z] = list(rows, "to_xyz")? else {
        return Err(Error::input("to_xyz must be three rows, of X, Y and Z"));
    };
    let row = |row: &Value, place: &str| -> Result<Vec<f64>> {
        let numbers = list(row, place)?.iter().enumerate();
        numbers.map(|(column, value)| number(value, &format!("{place}[{column}]"))).collect()
    };
    sensor.with_xyz(&[row(x, "to_xyz[0]")?, row(y, "to_xyz[1]")?, row(z, "to_xyz[2]")?])
}

fn of_csv(text: &str, stem: &str) -> Result<Sensor> {
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let cells = |line: &'_ str| -> Vec<String> {
        line.split(',').map(|cell| cell.trim().trim_matches('"').to_owned()).collect()
    };
    let names = lines.next().map(|(_, line)| cells(line)).unwrap_or_default();
    if names.first().is_none_or(|first| first != "wavelength_nm") {
        return Err(Error::input(
            "has no line of names; begin with wavelength_nm and the channels, as in wavelength_nm,UV,S,M,L",
        ));
    }
    let mut columns = vec![Vec::new(); names.len()];
    for (line, text) in lines {
        let row = cells(text);
        if row.len() != names.len() {
            return Err(Error::input(format!(
                "line {line}: has {}, but there are {} names",
                counted(row.len(), "column"),
                names.len()
            )));
        }
        for ((column, cell), name) in columns.iter_mut().zip(&row).zip(&names) {
            let value = cell.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
                let (name, cell) = (shortened(name), shortened(cell));
                Error::input(format!("line {line}: {name} is '{cell}', not a finite number"))
            })?;
            column.push(value);
        }
    }
    let mut columns = columns.into_iter();
    let nm = columns.next().unwrap_or_default();
    made(stem, nm, names.into_iter().skip(1).zip(columns).collect())
}

fn made(name: &str, nm: Vec<f64>, channels: Vec<(String, Vec<f64>)>) -> Result<Sensor> {
    let at = Wavelengths::new(nm)?;
    let (first, last) = at.range_nm();
    if first < SHORTEST_NM || last > LONGEST_NM {
        return Err(Error::input(format!(
            "has {first} to {last} nm; give wavelengths within {SHORTEST_NM} to {LONGEST_NM}"
        )));
    }
    // Both lie within the range that was just checked.
    let band = Band::new(first.ceil() as u32, last.floor() as u32)?;
    let curve = |(name, values): (String, Vec<f64>)| -> Result<Curve> {
        let table = Spectrum::new(at.clone(), values)?;
        Ok(Curve { name, response: DenseSpectrum::new(|nm| table.held(nm)) })
    };
    Sensor::new(name, band, channels.into_iter().map(curve).collect::<Result<_>>()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(name: &str, text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        read_sensor(&path).unwrap_err().to_string()
    }

    #[test]
    fn tables_of_both_kinds_are_the_same_sensor() {
        let csv =
            of_csv("# cones\n\nwavelength_nm, UV, \"S\"\n300.5, 0, 1\n310, 1, 1\n400.5,1,0\n", "a").unwrap();
        let toml = of_toml(
            "name = 'a'\nwavelength_nm = [300.5, 310, 400.5]\n[[channels]]\nname = 'UV'\nvalues = [0, 1, 1]\n\
             [[channels]]\nname = 'S'\nvalues = [1, 1, 0]\n",
            "b",
        )
        .unwrap();
        assert_eq!(csv, toml);
        assert_eq!((csv.name(), csv.band(), csv.has_colours()), ("a", Band::new(301, 400).unwrap(), false));
        assert!((csv.channels()[0].response.at(305.0) - 4.5 / 9.5).abs() < 1e-12);
        let coloured = of_toml(
            "wavelength_nm = [400, 700]\nto_xyz = [[0.95], [1], [1.09]]\n[[channels]]\nname = 'v'\nvalues = [1, 1]\n",
            "grey",
        )
        .unwrap();
        assert_eq!((coloured.name(), coloured.has_colours()), ("grey", true));
    }

    #[test]
    fn what_is_no_sensor_is_refused_by_line_and_key() {
        for (name, text, part) in [
            ("a.csv", "", "has no line of names"),
            ("a.csv", "300,1\n", "has no line of names"),
            ("a.csv", "wavelength_nm,a\n300,1,2\n", "line 2: has 3 columns, but there are 2 names"),
            ("a.csv", "wavelength_nm,a\n300,x\n", "line 2: a is 'x', not a finite number"),
            ("a.csv", "wavelength_nm,a\n", "is empty"),
            ("a.csv", "wavelength_nm\n300\n400\n", "0 channels: give 1 to 8"),
            (
                "a.csv",
                "wavelength_nm,a\n299,1\n400,1\n",
                "has 299 to 400 nm; give wavelengths within 300 to 830",
            ),
            ("a.csv", "wavelength_nm,a\n400,1\n400.5,1\n", "a band of 400 to 400 nm"),
            ("a.csv", "wavelength_nm,a\n400,1\n500,-1\n", "channel 'a': its value at 451 nm is -0.02"),
            ("a.csv", "wavelength_nm,a\n400,1e308\n500,1e308\n", "its integral over the wavelengths is inf"),
            ("a.toml", "wavelength_nm = 3", "line 1: wavelength_nm is"),
            ("a.toml", "wavelength_nm = [300, 400]", "channels is missing"),
            (
                "a.toml",
                "wavelength_nm = [300, 400]\n[[channels]]\nname = 'a'\nvalues = [1]\n",
                "line 4: channels[0].values has 1 number, but wavelength_nm has 2",
            ),
            ("a.toml", "wavelength_nm = [300, 400]\nto_xyz = [1]\nchannels = []", "0 channels"),
            (
                "a.toml",
                "wavelength_nm = [300, 400]\nto_xyz = [[1], [1]]\n[[channels]]\nname = 'a'\nvalues = [1, 1]\n",
                "line 2: to_xyz must be three rows",
            ),
            (
                "a.toml",
                "wavelength_nm = [300, 400]\nto_xyz = [[1], [1], [1, 2]]\n[[channels]]\nname = 'a'\nvalues = [1, 1]\n",
                "line 2: to_xyz has a row of 2 numbers; give three rows of 1 finite ones",
            ),
            ("a.toml", "wavelenth_nm = [300]", "did you mean 'wavelength_nm'?"),
        ] {
            let message = refused(name, text);
            assert!(message.contains(part) && message.contains(name), "{text:?}: {message}");
        }
    }
}
