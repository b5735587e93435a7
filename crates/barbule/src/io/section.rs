//! Cross sections as JSON: reading with the place of every mistake, writing so that the same bits come back.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::lattice::{crystal_from, crystal_json};
use super::media::{materials, medium, medium_json};
use super::{note_input, read_text, write_whole};
use crate::error::shortened;
use crate::fields::{Fields, in_json, list, parse_json};
use crate::material::Library;
use crate::structure::{Inclusion, Loop, MOST_POINTS, MaterialSource, Medium, Parts, Polyline, Section};
use crate::{Error, Result};

/// A folder of sections has no more files than this.
const MOST_SECTIONS: usize = 10_000;

/// What a section's file consists of.
pub(super) const KEYS: [&str; 11] = [
    "barbule",
    "units",
    "width",
    "name",
    "boundaries",
    "media",
    "inclusions",
    "source",
    "materials",
    "lattice",
    // What `geometry --three-d` adds: of the segment that the section was carried to.
    "segment",
];

/// Reads a section.
///
/// # Errors
/// The file cannot be read, or anything that `docs/formats/section.md` lists; the message names the file, the field and
/// the index.
pub fn read_section(path: &Path, library: &Library) -> Result<Section> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let text = read_text(path)?;
    let mut section = parse_section(&text, folder, library).map_err(|error| error.in_file(path))?;
    if section.name.is_empty() {
        section.name = stem(path);
    }
    Ok(section)
}

/// Reads every `.json` of a folder, in the order of their names: instances of one structure.
///
/// # Errors
/// No such file, over 10,000 of them, widths that differ by over 1 %, lattices that differ, or as [`read_section`].
pub fn read_sections(folder: &Path, library: &Library) -> Result<Vec<Section>> {
    let refuse = |what: String| Error::input(what).in_file(folder);
    let mut files = Vec::new();
    note_input(folder)?;
    for entry in std::fs::read_dir(folder).map_err(|e| refuse(format!("cannot be read ({e})")))? {
        let path = entry.map_err(|e| refuse(format!("cannot be read ({e})")))?.path();
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) && path.is_file() {
            files.push(path);
        }
        if files.len() > MOST_SECTIONS {
            return Err(refuse(format!("has over {MOST_SECTIONS} sections; split it")));
        }
    }
    if files.is_empty() {
        return Err(refuse("has no .json file; put the sections of a structure's instances there".into()));
    }
    files.sort();
    let sections = files.iter().map(|path| read_section(path, library)).collect::<Result<Vec<_>>>()?;
    let width = sections[0].width_um;
    if let Some(other) = sections.iter().position(|s| (s.width_um - width).abs() > 0.01 * width) {
        return Err(refuse(format!(
            "{} is {} µm wide but {} is {width} µm; instances of one structure must have one width",
            stem(&files[other]),
            sections[other].width_um,
            stem(&files[0])
        )));
    }
    let lattice = |section: &Section| section.crystal.as_ref().map(|crystal| crystal.lattice.hash());
    let first = lattice(&sections[0]);
    if let Some(other) = sections.iter().position(|s| lattice(s) != first) {
        return Err(refuse(format!(
            "{} has another lattice than {}; instances of one structure must have the same one",
            stem(&files[other]),
            stem(&files[0])
        )));
    }
    Ok(sections)
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// As [`read_section`], from text; `folder` is where the files of materials lie.
///
/// # Errors
/// As [`read_section`], without the file's name.
pub fn parse_section(text: &str, folder: &Path, library: &Library) -> Result<Section> {
    // Two numbers for each of at most a million points, and as many for mixtures: more need not be read.
    if text.bytes().filter(|&b| b == b',').count() > 5 * MOST_POINTS {
        return Err(Error::input(
            "has over 5000000 values, but a section may have 1000000 points; sample it more coarsely",
        ));
    }
    let value = parse_json(text).map_err(|error| {
        let is_number = text.contains("NaN") || text.contains("Infinity");
        error.followed_by(if is_number {
            " (JSON has no NaN or infinity; leave such points out)"
        } else {
            ""
        })
    })?;
    section(&value, folder, library).map_err(|error| in_json(error, text))
}

fn section(value: &Value, folder: &Path, library: &Library) -> Result<Section> {
    let fields = Fields::new(value, "", &KEYS)?;
    let version = fields.need_number("barbule", "the format's version, \"barbule\": 1")?;
    if version != 1.0 {
        return Err(Error::input(format!("barbule is {version}, but this version reads format 1 only")));
    }
    match fields.text("units")? {
        Some("um") => {}
        None => return Err(Error::input("units is missing; give \"units\": \"um\", lengths are in µm")),
        Some(other) => {
            return Err(Error::input(format!(
                "units is '{}', but must be 'um'; convert lengths to µm",
                shortened(other)
            )));
        }
    }
    let mut library = library.clone();
    let materials = materials(fields.get("materials"), folder, &mut library)?;
    let mut parts = Parts {
        name: fields.text("name")?.unwrap_or_default().to_owned(),
        source: fields.text("source")?.unwrap_or_default().to_owned(),
        width_um: fields.number("width")?,
        ..Parts::default()
    };
    if let Some(value) = fields.get("boundaries") {
        for (index, boundary) in list(value, "boundaries")?.iter().enumerate() {
            let fields = Fields::new(boundary, &format!("boundaries[{index}]"), &["x", "z"])?;
            parts.boundaries.push(Polyline { x_um: fields.numbers("x")?, z_um: fields.numbers("z")? });
        }
    }
    if let Some(value) = fields.get("lattice") {
        parts.crystal = Some(crystal_from(value, library.clone())?);
    }
    match fields.get("media") {
        Some(value) => {
            for (index, entry) in list(value, "media")?.iter().enumerate() {
                parts.media.push(medium(entry, &format!("media[{index}]"))?);
            }
        }
        None if parts.boundaries.is_empty() => parts.media.push(Medium::named("air")),
        None if parts.crystal.is_some() && parts.boundaries.len() == 1 => {
            parts.media = parts
                .crystal
                .iter()
                .flat_map(|crystal| [&crystal.lattice.incidence, &crystal.lattice.host])
                .map(|medium| Medium::Pure(medium.clone()))
                .collect();
        }
        None => {
            return Err(Error::input(format!(
                "media is missing; list {} media, from above the top to below the last boundary",
                parts.boundaries.len() + 1
            )));
        }
    }
    if let Some(value) = fields.get("inclusions") {
        for (index, entry) in list(value, "inclusions")?.iter().enumerate() {
            parts.inclusions.push(inclusion(entry, &format!("inclusions[{index}]"))?);
        }
    }
    let mut section = Section::new(parts, library)?;
    section.materials = materials;
    Ok(section)
}

fn inclusion(value: &Value, place: &str) -> Result<Inclusion> {
    let fields = Fields::new(value, place, &["x", "z", "circle", "medium", "holes"])?;
    let mut holes = Vec::new();
    if let Some(value) = fields.get("holes") {
        let path = fields.path("holes");
        for (index, hole) in list(value, &path)?.iter().enumerate() {
            holes.push(closed(&Fields::new(hole, &format!("{path}[{index}]"), &["x", "z", "circle"])?)?);
        }
    }
    let medium =
        medium(fields.need("medium", "the medium inside, as in \"melanin\"")?, &fields.path("medium"))?;
    Ok(Inclusion { outline: closed(&fields)?, medium, holes })
}

fn closed(fields: &Fields<'_>) -> Result<Loop> {
    let Some(circle) = fields.get("circle") else {
        return Ok(Loop::polygon(fields.numbers("x")?, fields.numbers("z")?));
    };
    if fields.get("x").is_some() || fields.get("z").is_some() {
        return Err(Error::input(format!(
            "{} stands beside x or z; give one of the two",
            fields.path("circle")
        )));
    }
    let circle = Fields::new(circle, &fields.path("circle"), &["x", "z", "radius"])?;
    Ok(Loop::Circle {
        x_um: circle.need_number("x", "the centre in µm")?,
        z_um: circle.need_number("z", "the centre in µm")?,
        radius_um: circle.need_number("radius", "the radius in µm")?,
    })
}

/// The section's JSON, which [`parse_section`] reads back to the same bits. Files of materials have absolute paths.
#[must_use]
pub fn section_json(section: &Section) -> Value {
    let mut out = Map::new();
    out.insert("barbule".into(), 1.into());
    out.insert("units".into(), "um".into());
    out.insert("width".into(), section.width_um.into());
    out.insert("name".into(), section.name.as_str().into());
    out.insert(
        "boundaries".into(),
        section.boundaries.iter().map(|b| json!({"x": b.x_um, "z": b.z_um})).collect(),
    );
    out.insert("media".into(), section.media.iter().map(medium_json).collect());
    if !section.inclusions.is_empty() {
        out.insert("inclusions".into(), section.inclusions.iter().map(inclusion_json).collect());
    }
    if let Some(crystal) = &section.crystal {
        out.insert("lattice".into(), crystal_json(crystal));
    }
    if !section.materials.is_empty() {
        let source = |source: &MaterialSource| match source {
            MaterialSource::File(path) => json!(path.to_string_lossy()),
            MaterialSource::Index(n) => json!([n.re, n.im]),
        };
        let table: Map<String, Value> =
            section.materials.iter().map(|(n, s)| (n.clone(), source(s))).collect();
        out.insert("materials".into(), table.into());
    }
    out.insert("source".into(), section.source.as_str().into());
    out.into()
}

fn loop_json(shape: &Loop) -> Map<String, Value> {
    let value = match shape {
        Loop::Polygon(corners) => json!({"x": corners.x_um, "z": corners.z_um}),
        Loop::Circle { x_um, z_um, radius_um } => {
            json!({"circle": {"x": x_um, "z": z_um, "radius": radius_um}})
        }
    };
    if let Value::Object(table) = value { table } else { Map::new() }
}

fn inclusion_json(inclusion: &Inclusion) -> Value {
    let mut out = loop_json(&inclusion.outline);
    out.insert("medium".into(), medium_json(&inclusion.medium));
    if !inclusion.holes.is_empty() {
        out.insert(
            "holes".into(),
            inclusion.holes.iter().map(|hole| Value::Object(loop_json(hole))).collect(),
        );
    }
    out.into()
}

/// Writes a section's JSON.
///
/// # Errors
/// The file cannot be written.
pub fn write_section(path: &Path, section: &Section) -> Result<()> {
    let mut text = section_json(section).to_string();
    text.push('\n');
    write_whole(path, text.as_bytes())
}

#[cfg(test)]
mod tests;
