//! Photonic crystals in TOML or JSON.

use std::path::Path;

use serde_json::{Value, json};

use super::media::{materials, substance, substance_json};
use super::read_text;
use super::section::KEYS as SECTION_KEYS;
use crate::fields::{Fields, at_line, in_json, list, number, parse_json, parse_toml, typed_in_nm};
use crate::material::Library;
use crate::structure::{Circle, CrystalLayer, Lattice, MOST_RODS, Regularity, Rod, Substance};
use crate::{Error, Result};

const KEYS: &[&str] =
    &["period", "host", "incidence", "cortex", "depth_to_center", "rows", "row_pitch", "row_shift", "rod"];

/// What a file of a lattice alone consists of.
const BESIDE: &[&str] = &["lattice", "materials"];

/// Host above the first row that can be meant, µm.
const CORTEX_UM: std::ops::RangeInclusive<f64> = 0.0..=50.0;

/// Keys that only a lattice inside a section has.
const UNDER_A_TOP: &[&str] = &["offset", "regularity"];

/// Reads a lattice: a table `lattice` in TOML or JSON, `materials` beside it.
///
/// # Errors
/// The file cannot be read, or anything that `docs/formats/lattice.md` lists; the message names the file and the key.
pub fn read_lattice(path: &Path, library: &Library) -> Result<Lattice> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let is_json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    parse(&read_text(path)?, is_json, folder, library).map_err(|error| error.in_file(path))
}

fn parse(text: &str, is_json: bool, folder: &Path, library: &Library) -> Result<Lattice> {
    if is_json {
        return alone(&parse_json(text)?, folder, library).map_err(|error| in_json(error, text));
    }
    alone(&parse_toml(text)?, folder, library).map_err(|error| at_line(error, text))
}

fn alone(value: &Value, folder: &Path, library: &Library) -> Result<Lattice> {
    // A section's lattice is as good, where it lies under the top apart.
    let alone = value.get("boundaries").is_none();
    let fields = Fields::new(value, "", if alone { BESIDE } else { &SECTION_KEYS })?;
    let mut library = library.clone();
    materials(fields.get("materials"), folder, &mut library)?;
    let lattice = fields.need("lattice", "a table [lattice]")?;
    if let Some(key) = UNDER_A_TOP.iter().find(|key| alone && lattice.get(key).is_some()) {
        return Err(Error::input(format!(
            "lattice.{key} is for a lattice inside a section; leave it out of a lattice alone"
        )));
    }
    lattice_from(lattice, library)
}

/// The crystal of a section from its table `lattice`: a lattice with `offset` and `regularity`.
///
/// # Errors
/// As [`lattice_from`].
pub(super) fn crystal_from(value: &Value, library: Library) -> Result<CrystalLayer> {
    let lattice = lattice_from(value, library)?;
    let fields = Fields::new(value, "lattice", &keys())?;
    let regularity = match fields.get("regularity") {
        None => None,
        Some(value) => {
            let fields = Fields::new(value, "lattice.regularity", &["x", "value"])?;
            Some(Regularity { x_um: fields.numbers("x")?, value: fields.numbers("value")? })
        }
    };
    Ok(CrystalLayer { lattice, offset_um: fields.number("offset")?.unwrap_or(0.0), regularity })
}

/// What [`crystal_from`] reads back to the same bits.
pub(super) fn crystal_json(crystal: &CrystalLayer) -> Value {
    let lattice = &crystal.lattice;
    let circle = |c: &Circle| json!({"diameter": c.diameter_um, "medium": substance_json(&c.medium)});
    let rod = |rod: &Rod| {
        let mut out = json!({
            "x": rod.x_um,
            "z": rod.z_um,
            "circles": rod.circles.iter().map(circle).collect::<Vec<_>>(),
        });
        if let Some(rows) = rod.rows {
            out["rows_of_this"] = rows.into();
        }
        out
    };
    let mut out = json!({
        "period": lattice.period_um,
        "host": substance_json(&lattice.host),
        "incidence": substance_json(&lattice.incidence),
        "depth_to_center": lattice.depth_to_center_um,
        "rows": lattice.rows,
        "row_pitch": lattice.row_pitch_um,
        "row_shift": lattice.row_shift,
        "rod": lattice.rods.iter().map(rod).collect::<Vec<_>>(),
        "offset": crystal.offset_um,
    });
    if let Some(Regularity { x_um, value }) = &crystal.regularity {
        out["regularity"] = json!({"x": x_um, "value": value});
    }
    out
}

/// The text of a file of a lattice alone, which [`read_lattice`] reads as the same lattice where the media have their names.
///
/// # Errors
/// What TOML cannot write.
pub fn lattice_toml(lattice: &Lattice) -> Result<String> {
    let mut table =
        crystal_json(&CrystalLayer { lattice: lattice.clone(), offset_um: 0.0, regularity: None });
    if let Value::Object(table) = &mut table {
        UNDER_A_TOP.iter().for_each(|key| drop(table.remove(*key)));
    }
    toml::to_string(&json!({ "lattice": table }))
        .map_err(|error| Error::input(format!("the lattice cannot be written as TOML: {error}")))
}

fn keys() -> Vec<&'static str> {
    KEYS.iter().chain(UNDER_A_TOP).copied().collect()
}

/// A lattice from its table, whose media are found in `library`.
///
/// # Errors
/// An unknown or missing key, a value of the wrong kind, or as [`Lattice::check`].
pub(super) fn lattice_from(value: &Value, library: Library) -> Result<Lattice> {
    let fields = Fields::new(value, "lattice", &keys())?;
    let medium = |key: &str, usual: &str| match fields.get(key) {
        None => Ok(Substance::named(usual)),
        Some(value) => substance(value, &fields.path(key)),
    };
    let rods = fields
        .list("rod", "at least one [[lattice.rod]]")?
        .iter()
        .enumerate()
        .map(|(index, value)| rod(value, &format!("lattice.rod[{index}]")))
        .collect::<Result<Vec<_>>>()?;
    let rows = if fields.get("rows").is_some() { fields.count_within("rows", 1, MOST_RODS)? } else { 1 };
    let depth_to_center_um = match (fields.number("cortex")?, fields.number("depth_to_center")?) {
        (Some(cortex_um), None) if CORTEX_UM.contains(&cortex_um) => {
            Lattice::depth_under_cortex(cortex_um, &rods)
        }
        (Some(cortex_um), None) => {
            return Err(Error::input(format!(
                "lattice.cortex is {cortex_um}, outside {} to {} µm{}",
                CORTEX_UM.start(),
                CORTEX_UM.end(),
                typed_in_nm(cortex_um, &CORTEX_UM)
            )));
        }
        (None, Some(depth_um)) => depth_um,
        (None, None) => {
            return Err(Error::input("lattice: give cortex (above the first row) or depth_to_center"));
        }
        (Some(_), Some(_)) => return Err(Error::input("lattice: give cortex or depth_to_center, not both")),
    };
    let row_pitch_um = match fields.number("row_pitch")? {
        Some(pitch_um) => pitch_um,
        // One row has no next one.
        None if rows == 1 => 0.0,
        None => fields.need_number("row_pitch", "the distance of rows in µm")?,
    };
    let lattice = Lattice {
        period_um: fields.need_number("period", "the period in µm")?,
        host: medium("host", "keratin")?,
        incidence: medium("incidence", "air")?,
        depth_to_center_um,
        rows,
        row_pitch_um,
        row_shift: fields.number("row_shift")?.unwrap_or(0.0),
        rods,
        library,
    };
    lattice.check()?;
    Ok(lattice)
}

fn rod(value: &Value, place: &str) -> Result<Rod> {
    let fields = Fields::new(value, place, &["x", "z", "rows_of_this", "circles"])?;
    let circles = list(fields.need("circles", "a list of { diameter, medium }")?, &fields.path("circles"))?
        .iter()
        .enumerate()
        .map(|(index, value)| {
            let fields = Fields::new(value, &format!("{place}.circles[{index}]"), &["diameter", "medium"])?;
            let medium = fields.need("medium", "a medium, as in \"melanin\"")?;
            Ok(Circle {
                diameter_um: number(fields.need("diameter", "a diameter in µm")?, &fields.path("diameter"))?,
                medium: substance(medium, &fields.path("medium"))?,
            })
        })
        .collect::<Result<Vec<_>>>()?;
    let rows = match fields.get("rows_of_this") {
        None => None,
        Some(_) => Some(fields.count_within("rows_of_this", 1, MOST_RODS)?),
    };
    Ok(Rod {
        x_um: fields.number("x")?.unwrap_or(0.0),
        z_um: fields.number("z")?.unwrap_or(0.0),
        rows,
        circles,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const MALLARD: &str = r#"
        [lattice]
        period = 0.19
        host = "keratin"
        incidence = "air"
        cortex = 0.28
        rows = 6
        row_pitch = 0.17
        row_shift = 0.5
        [[lattice.rod]]
        x = 0.0
        circles = [ { diameter = 0.13, medium = "melanin" } ]
    "#;

    fn read(text: &str) -> Result<Lattice> {
        parse(text, false, Path::new("."), &Library::builtin())
    }

    fn refusal(from: &str, to: &str) -> String {
        assert!(MALLARD.contains(from), "{from}");
        let error = read(&MALLARD.replace(from, to)).unwrap_err();
        assert!(error.is_input() && error.to_string().len() < 600, "{error}");
        error.to_string()
    }

    #[test]
    fn what_is_written_of_a_lattice_is_read_as_the_same() {
        for name in ["mallard", "magpie", "peafowl"] {
            let lattice =
                crate::structure::SpeciesModel::builtin(name, None, Library::builtin()).unwrap().lattice();
            let lattice = lattice.unwrap();
            let text = lattice_toml(&lattice).unwrap();
            let read = parse(&text, false, Path::new("."), &Library::builtin()).unwrap();
            assert_eq!(read.hash(), lattice.hash(), "{text}");
        }
    }

    #[test]
    fn toml_and_json_give_the_same_lattice() {
        let lattice = read(MALLARD).unwrap();
        assert!((lattice.depth_to_center_um - 0.345).abs() < 1e-15);
        assert_eq!((lattice.rows, lattice.placed().count()), (6, 6));
        let table: toml::Table = toml::from_str(MALLARD).unwrap();
        let json = serde_json::to_string(&table).unwrap();
        assert_eq!(parse(&json, true, Path::new("."), &Library::builtin()).unwrap(), lattice);
        let centre = MALLARD.replace("cortex = 0.28", "depth_to_center = 0.345");
        assert!((read(&centre).unwrap().depth_to_center_um - 0.345).abs() < 1e-15);
    }

    #[test]
    fn a_stack_may_be_listed_as_one_row() {
        let text = MALLARD
            .replace("rows = 6", "rows = 1")
            .replace("row_pitch = 0.17", "")
            .replace("cortex = 0.28", "depth_to_center = 0.345");
        let second =
            "\n[[lattice.rod]]\nx = 0.095\nz = 0.17\ncircles = [ { diameter = 0.13, medium = \"melanin\" } ]";
        let lattice = read(&(text + second)).unwrap();
        let two = Lattice { rows: 2, ..read(MALLARD).unwrap() };
        let places = |l: &Lattice| l.placed().map(|p| (p.x_um, p.depth_um)).collect::<Vec<_>>();
        for (a, b) in places(&lattice).into_iter().zip(places(&two)) {
            assert!((a.0 - b.0).abs() < 1e-15 && (a.1 - b.1).abs() < 1e-15, "{a:?} {b:?}");
        }
        assert_eq!(lattice.placed().count(), 2);
    }

    #[test]
    fn lengths_in_nm_and_lost_digits_are_refused_on_their_lines() {
        for (from, to, expected) in [
            (
                "period = 0.19",
                "period = 205",
                "line 3: lattice.period is 205, outside 0.0001 to 100 µm; did you mean 0.205",
            ),
            (
                "cortex = 0.28",
                "cortex = 280",
                "line 6: lattice.cortex is 280, outside 0 to 50 µm; did you mean 0.28 (280 nm)?",
            ),
            ("row_pitch = 0.17", "row_pitch = 170", "did you mean 0.17 (170 nm)?"),
            ("diameter = 0.13", "diameter = 130", "did you mean 0.13 (130 nm)?"),
            ("x = 0.0", "x = 1e16", "line 11: lattice.rod[0].x is 1e16, outside -100 to 100 µm"),
            ("x = 0.0", "x = 1.8e308", "line 11 is not TOML: floating-point number overflowed"),
            (
                "row_shift = 0.5",
                "row_shift = 1e300",
                "line 9: lattice.row_shift is 1e300, outside -1 to 1 of the period",
            ),
            (
                "\"melanin\"",
                "{ index = [1.5, 1e9] }",
                "lattice.rod[0].circles[0].medium has the index 1.5+1000000000i",
            ),
        ] {
            let message = refusal(from, to);
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn what_is_no_lattice_is_refused_by_key() {
        assert!(refusal("period = 0.19", "").contains("lattice.period is missing"));
        assert!(refusal("period = 0.19", "period = \"x\"").contains("lattice.period is the text 'x'"));
        assert!(refusal("period = 0.19", "period = 0").contains("lattice.period is 0"));
        assert!(refusal("period = 0.19", "perod = 0.19").contains("did you mean 'period'"));
        assert!(refusal("diameter = 0.13", "diameter = -0.13").contains("diameter is -0.13"));
        assert!(refusal("diameter = 0.13", "diameter = 0.3").contains("wider than the period"));
        assert!(refusal("rows = 6", "rows = 0").contains("lattice.rows is 0"));
        assert!(refusal("rows = 6", "rows = 2.5").contains("whole number"));
        assert!(refusal("cortex = 0.28", "cortex = -1").contains("lattice.cortex is -1, outside 0 to 50 µm"));
        assert!(refusal("cortex = 0.28", "").contains("give cortex"));
        assert!(refusal("cortex = 0.28", "cortex = 0.28\ndepth_to_center = 1").contains("not both"));
        assert!(refusal("row_pitch = 0.17", "").contains("lattice.row_pitch is missing"));
        assert!(refusal("row_pitch = 0.17", "row_pitch = 0.05").contains("overlap"));
        assert!(refusal("\"melanin\"", "\"melamin\"").contains("did you mean 'melanin'"));
        assert!(refusal("[lattice]", "[latice]").contains("unknown key 'latice', did you mean 'lattice'?"));
        let foreign = refusal("[lattice]", "[materails]\nkeratin = [1.9, 0.0]\n[lattice]");
        assert!(foreign.contains("line 2: unknown key 'materails', did you mean 'materials'?"), "{foreign}");
        assert!(refusal("[lattice]", "[lattice").contains("is not TOML"));
    }
}
