//! PLY (Turk 1994): triangle meshes in text or binary, of either byte order.

use glam::{Vec2, Vec3};

use super::{MOST_VERTICES, Parts};
use crate::error::shortened;
use crate::{Error, Result};

/// Most lines of a header, most properties of an element, most corners of a face.
const MOST_LINES: usize = 1000;
const MOST_PROPERTIES: usize = 64;
const MOST_CORNERS: usize = 256;

/// How values are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A kind of number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Integer { bytes: usize, is_signed: bool },
    Float { bytes: usize },
}

impl Kind {
    fn named(name: &str) -> Result<Self> {
        let integer = |bytes, is_signed| Ok(Self::Integer { bytes, is_signed });
        match name {
            "char" | "int8" => integer(1, true),
            "uchar" | "uint8" => integer(1, false),
            "short" | "int16" => integer(2, true),
            "ushort" | "uint16" => integer(2, false),
            "int" | "int32" => integer(4, true),
            "uint" | "uint32" => integer(4, false),
            "float" | "float32" => Ok(Self::Float { bytes: 4 }),
            "double" | "float64" => Ok(Self::Float { bytes: 8 }),
            other => Err(Error::input(format!("has a property of the unknown kind '{}'", shortened(other)))),
        }
    }

    fn bytes(self) -> usize {
        match self {
            Self::Integer { bytes, .. } | Self::Float { bytes } => bytes,
        }
    }
}

/// A property of an element: one number, or a list with its length in front.
struct Property {
    name: String,
    length: Option<Kind>,
    kind: Kind,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

/// Reads a mesh.
pub(super) fn read(bytes: &[u8]) -> Result<Parts> {
    let (encoding, elements, body) = header(bytes)?;
    let mut values = Values { body, encoding };
    let mut parts = Parts::default();
    for element in &elements {
        // A row takes a byte at least, so a count over the file's length is a lie.
        if element.count > body.len().max(1) || element.count > MOST_VERTICES {
            return Err(Error::input(format!(
                "says that it has {} of '{}', more than the file can hold or {MOST_VERTICES}",
                element.count,
                shortened(&element.name)
            )));
        }
        match element.name.as_str() {
            "vertex" => vertices(element, &mut values, &mut parts)?,
            "face" => faces(element, &mut values, &mut parts)?,
            _ => {
                for _ in 0..element.count {
                    for property in &element.properties {
                        values.row(property, &mut Vec::new())?;
                    }
                }
            }
        }
    }
    Ok(parts)
}

/// How many vertices and triangles a header announces of a file of so many bytes. A binary file whose faces have nothing but their
/// corners tells exactly; else each face counts as one triangle.
pub(super) fn foretell(head: &[u8], length: u64) -> Option<[f64; 2]> {
    let (encoding, elements, body) = header(head).ok()?;
    let most = length.min(MOST_VERTICES as u64) as usize;
    let count =
        |name: &str| elements.iter().find(|one| one.name == name).map_or(0, |one| one.count.min(most));
    let [vertices, faces] = ["vertex", "face"].map(|name| count(name) as f64);
    let rows = |element: &Element| {
        let sizes = element
            .properties
            .iter()
            .map(|property| property.length.is_none().then(|| property.kind.bytes()));
        sizes.sum::<Option<usize>>().map(|row| (row * element.count.min(most)) as f64)
    };
    let corners = || {
        let [vertex, face] = &elements[..] else { return None };
        let [Property { length: Some(counted), kind, .. }] = &face.properties[..] else { return None };
        let rest = length as f64 - (head.len() - body.len()) as f64 - rows(vertex)?;
        (encoding != Encoding::Text).then(|| (rest - faces * counted.bytes() as f64) / kind.bytes() as f64)
    };
    let triangles = corners().map_or(faces, |corners| (corners - 2.0 * faces).max(0.0));
    Some([vertices, triangles.min(MOST_VERTICES as f64)])
}

/// The header's lines, and what follows them.
fn header(bytes: &[u8]) -> Result<(Encoding, Vec<Element>, &[u8])> {
    let refuse = |what: &str| Error::input(format!("is no PLY: {what}"));
    let (mut encoding, mut elements, mut rest) = (None, Vec::<Element>::new(), bytes);
    for number in 0..MOST_LINES {
        let end = rest.iter().position(|b| *b == b'\n').ok_or_else(|| refuse("its header does not end"))?;
        let line = std::str::from_utf8(&rest[..end]).map_err(|_| refuse("its header is not text"))?;
        rest = &rest[end + 1..];
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["ply"] if number == 0 => {}
            _ if number == 0 => return Err(refuse("its first line is not 'ply'")),
            ["format", kind, _] => {
                encoding = Some(match kind {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    other => return Err(refuse(&format!("the format '{}' is unknown", shortened(other)))),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| refuse("an element's count is no number"))?;
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", "list", length, kind, name] => {
                let (length, kind) = (Some(Kind::named(length)?), Kind::named(kind)?);
                add(&mut elements, Property { name: name.to_owned(), length, kind })?;
            }
            ["property", kind, name] => {
                let kind = Kind::named(kind)?;
                add(&mut elements, Property { name: name.to_owned(), length: None, kind })?;
            }
            ["end_header"] => {
                let encoding = encoding.ok_or_else(|| refuse("it names no format"))?;
                return Ok((encoding, elements, rest));
            }
            ["comment" | "obj_info", ..] | [] => {}
            _ => return Err(refuse(&format!("line {} of its header cannot be read", number + 1))),
        }
    }
    Err(refuse("its header does not end"))
}

fn add(elements: &mut [Element], property: Property) -> Result<()> {
    match elements.last_mut() {
        Some(element) if element.properties.len() < MOST_PROPERTIES => {
            element.properties.push(property);
            Ok(())
        }
        _ => Err(Error::input("is no PLY: a property belongs to no element, or is one of too many")),
    }
}

fn vertices(element: &Element, values: &mut Values<'_>, parts: &mut Parts) -> Result<()> {
    let place = |names: &[&str]| {
        element.properties.iter().position(|p| names.contains(&p.name.as_str()) && p.length.is_none())
    };
    let all = |names: [&[&str]; 3]| -> Option<[usize; 3]> {
        Some([place(names[0])?, place(names[1])?, place(names[2])?])
    };
    let position =
        all([&["x"], &["y"], &["z"]]).ok_or_else(|| Error::input("has no vertices with x, y and z"))?;
    let normal = all([&["nx"], &["ny"], &["nz"]]);
    let uv = place(&["u", "s", "texture_u"]).zip(place(&["v", "t", "texture_v"]));
    let mut row = Vec::new();
    for _ in 0..element.count {
        let mut columns = [0.0_f32; MOST_PROPERTIES];
        for (column, property) in columns.iter_mut().zip(&element.properties) {
            values.row(property, &mut row)?;
            *column = row.first().map_or(0.0, |value| *value as f32);
        }
        let vector = |at: [usize; 3]| Vec3::from_array(at.map(|k| columns[k]));
        parts.positions.push(vector(position));
        parts.normals.extend(normal.map(vector));
        parts.uvs.extend(uv.map(|(u, v)| Vec2::new(columns[u], columns[v])));
    }
    Ok(())
}

fn faces(element: &Element, values: &mut Values<'_>, parts: &mut Parts) -> Result<()> {
    let is_corners = |p: &Property| matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
    if !element.properties.iter().any(|p| is_corners(p) && p.length.is_some()) {
        return Err(Error::input("has faces without a list vertex_indices"));
    }
    let mut row = Vec::new();
    for face in 0..element.count {
        for property in &element.properties {
            values.row(property, &mut row)?;
            if is_corners(property) {
                let corners = row.iter().map(|value| if *value >= 0.0 { Some(*value as u32) } else { None });
                let corners: Option<Vec<u32>> = corners.collect();
                let corners =
                    corners.ok_or_else(|| Error::input(format!("face {face} has a negative corner")))?;
                parts.add_polygon(&corners)?;
            }
        }
    }
    Ok(())
}

/// What follows the header.
struct Values<'a> {
    body: &'a [u8],
    encoding: Encoding,
}

impl Values<'_> {
    /// The values of a property in the next row.
    fn row(&mut self, property: &Property, to: &mut Vec<f64>) -> Result<()> {
        to.clear();
        let count = match property.length {
            None => 1,
            Some(kind) => {
                let count = self.next(kind)?;
                if !(0.0..=MOST_CORNERS as f64).contains(&count) {
                    return Err(Error::input(format!(
                        "has a list of {count} values; at most {MOST_CORNERS} are read"
                    )));
                }
                count as usize
            }
        };
        for _ in 0..count {
            to.push(self.next(property.kind)?);
        }
        Ok(())
    }

    fn next(&mut self, kind: Kind) -> Result<f64> {
        let ends = || Error::input("ends before all of its values are there");
        if self.encoding == Encoding::Text {
            let start = self.body.iter().position(|b| !b.is_ascii_whitespace()).ok_or_else(ends)?;
            let rest = &self.body[start..];
            let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
            let (word, rest) = rest.split_at(length);
            self.body = rest;
            let word = String::from_utf8_lossy(word);
            return word
                .parse()
                .map_err(|_| Error::input(format!("has '{}' where a number is needed", shortened(&word))));
        }
        let (front, rest) = self.body.split_at_checked(kind.bytes()).ok_or_else(ends)?;
        self.body = rest;
        let mut bytes = [0; 8];
        bytes[..front.len()].copy_from_slice(front);
        if self.encoding == Encoding::BigEndian {
            bytes[..front.len()].reverse();
        }
        Ok(match kind {
            Kind::Integer { bytes: length, is_signed } => {
                let unused = 64 - 8 * length as u32;
                let word = u64::from_le_bytes(bytes);
                if is_signed { ((word << unused) as i64 >> unused) as f64 } else { word as f64 }
            }
            Kind::Float { bytes: 4 } => {
                f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
            }
            Kind::Float { .. } => f64::from_le_bytes(bytes),
        })
    }
}
