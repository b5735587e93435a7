//! Eyes of users' own: what a bird's cones are made of, or their curves.

use std::path::Path;

use super::{read_sensor, read_text};
use crate::Result;
use crate::fields::parse_toml;
use crate::vision::Eye;

/// Reads an eye: `.toml` with `[[cones]]` as `docs/formats/bird.md` describes it, or a sensor's curves (`docs/formats/sensor.md`) taken as
/// answers to quanta.
///
/// # Errors
/// The file cannot be read or is neither; the message names it and the place.
pub fn read_eye(path: &Path) -> Result<Eye> {
    let is_toml = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    if is_toml {
        let text = read_text(path)?;
        let has_channels = parse_toml(&text).is_ok_and(|table| table.get("channels").is_some());
        if !has_channels {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            return Eye::parse(&text, &stem).map_err(|error| error.at(path.display()));
        }
    }
    Eye::of_sensor(&read_sensor(path)?).map_err(|error| error.at(path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eyes_are_read_from_templates_and_from_curves() {
        let folder = tempfile::tempdir().unwrap();
        let read = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            read_eye(&path)
        };
        let pigments = read("a.toml", "[[cones]]\nname = 'L'\npigment_nm = 563\n").unwrap();
        // The template's own peak is within a nanometre of its pigment's.
        let peak_nm = pigments.cones[0].peak_nm;
        assert!(pigments.name == "a" && (peak_nm - 563.0).abs() <= 1.0, "{peak_nm}");
        let curves = read("b.csv", "wavelength_nm,UV,double\n300,0,0\n360,2,0\n400,0,1\n500,0,0\n").unwrap();
        assert_eq!((curves.cones[0].peak_nm, curves.double.unwrap().peak_nm), (360.0, 400.0));
        let channels = "wavelength_nm = [400, 500, 600]\n[[channels]]\nname = 'M'\nvalues = [0, 3, 0]\n";
        assert_eq!(read("c.toml", channels).unwrap().cones[0].peak_nm, 500.0);
        for (name, text, part) in [
            ("d.toml", "cones = 3", "d.toml: line 1: cones is the number 3"),
            ("d.csv", "wavelength_nm,double\n300,1\n400,1\n", "0 classes"),
            ("e.csv", "hello", "has no line of names"),
        ] {
            let message = read(name, text).unwrap_err().to_string();
            assert!(message.contains(part) && message.contains(name), "{message}");
        }
    }
}
