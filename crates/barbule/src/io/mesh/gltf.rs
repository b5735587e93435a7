//! glTF 2.0: the triangles of a scene's nodes, from text or binary; materials, skins, morphs and animations are passed over.

mod document;

use std::collections::HashSet;
use std::path::{Component, Path};

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use glam::{DMat3, DMat4, DQuat, DVec3, Vec2, Vec3};

use super::{Found, LARGEST_MESH, MOST_VERTICES, Parts};
use crate::error::shortened;
use crate::{Error, Result};
use document::{Accessor, Document, Node, Primitive, entry};

/// glTF's unit is the metre.
const MM_PER_M: f64 = 1000.0;

/// Kinds of a binary file's chunks.
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BINARY: u32 = u32::from_le_bytes(*b"BIN\0");

/// Most primitives in all their places.
const MOST_PLACED: usize = 1_000_000;

/// Files leave padding out and bits over.
const READ_BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_allow_trailing_bits(true)
        .with_decode_padding_mode(DecodePaddingMode::RequireNone),
);

/// How corners make triangles.
const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// Reads a file's bytes; buffers in files of their own lie in its folder or below.
pub(super) fn read(bytes: &[u8], other: &dyn Fn(&str, u64) -> Result<Vec<u8>>) -> Result<Found> {
    let (text, binary) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
    let document = Document::parse(text)?;
    let mut beside = Vec::new();
    let mut embedded = Vec::new();
    let mut left = LARGEST_MESH;
    // Which of the two lists a buffer is in, or that it is the binary chunk.
    let mut places = Vec::with_capacity(document.buffers.len());
    for (index, buffer) in document.buffers.iter().enumerate() {
        places.push(match &buffer.uri {
            None if index == 0 && binary.is_some() => Place::Binary,
            None => return Err(Error::input(format!("has no data of buffer {index}"))),
            Some(uri) => match uri.strip_prefix("data:") {
                Some(data) => {
                    embedded.push(decoded(data).map_err(|error| error.at(format!("buffer {index}")))?);
                    Place::Embedded(embedded.len() - 1)
                }
                None => {
                    let bytes = other(&local(uri)?, left)?;
                    left -= bytes.len() as u64;
                    beside.push(bytes);
                    Place::Beside(beside.len() - 1)
                }
            },
        });
    }
    let buffers: Vec<&[u8]> = places
        .iter()
        .map(|place| match *place {
            Place::Binary => binary.unwrap_or_default(),
            Place::Embedded(k) => &embedded[k][..],
            Place::Beside(k) => &beside[k][..],
        })
        .collect();
    for (index, (buffer, bytes)) in document.buffers.iter().zip(&buffers).enumerate() {
        if bytes.len() < buffer.byte_length {
            return Err(Error::input(format!(
                "says that buffer {index} has {} bytes, but there are {}",
                buffer.byte_length,
                bytes.len()
            )));
        }
    }
    let parts = Reader { document: &document, buffers }.scene()?;
    Ok(Found { parts, beside })
}

enum Place {
    Binary,
    Embedded(usize),
    Beside(usize),
}

/// The text and the binary chunk of a binary file.
pub(in crate::io) fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>)> {
    let damaged = || Error::input("is no binary glTF 2.0: its header or a chunk is damaged");
    let word = |at: usize| -> Result<u32> {
        let bytes = bytes.get(at..at + 4).ok_or_else(damaged)?;
        bytes.try_into().map(u32::from_le_bytes).map_err(|_| damaged())
    };
    if word(4)? != 2 {
        return Err(damaged());
    }
    let whole = word(8)? as usize;
    let bytes = bytes.get(..whole).ok_or_else(damaged)?;
    let chunk = |at: usize| -> Result<(u32, &[u8])> {
        let length = word(at)? as usize;
        Ok((word(at + 4)?, bytes.get(at + 8..).and_then(|rest| rest.get(..length)).ok_or_else(damaged)?))
    };
    let (JSON, text) = chunk(12)? else { return Err(damaged()) };
    let next = 20 + text.len();
    if next >= bytes.len() {
        return Ok((text, None));
    }
    let (kind, binary) = chunk(next)?;
    Ok((text, (kind == BINARY).then_some(binary)))
}

/// A path below the file's folder, with `%20` and such made letters.
pub(in crate::io) fn local(uri: &str) -> Result<String> {
    let refuse = || {
        Error::input(format!(
            "has a buffer in '{}'; buffers are read from the file itself, or from files in its folder",
            shortened(uri)
        ))
    };
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, after @ ..] = rest {
        rest = after;
        if *first == b'%' {
            let (digits, after) = rest.split_at_checked(2).ok_or_else(refuse)?;
            let digits = std::str::from_utf8(digits).map_err(|_| refuse())?;
            bytes.push(u8::from_str_radix(digits, 16).map_err(|_| refuse())?);
            rest = after;
        } else {
            bytes.push(*first);
        }
    }
    let name = String::from_utf8(bytes).map_err(|_| refuse())?;
    let is_below = Path::new(&name).components().all(|part| matches!(part, Component::Normal(_)));
    if name.is_empty() || !is_below || name.contains(':') {
        return Err(refuse());
    }
    Ok(name)
}

/// The bytes of a data URI after `data:` (RFC 2397), in base64 (RFC 4648).
fn decoded(data: &str) -> Result<Vec<u8>> {
    let refuse = || Error::input("its embedded data are no base64");
    let (_, text) = data.split_once(";base64,").ok_or_else(refuse)?;
    READ_BASE64.decode(text.trim_end_matches('=')).map_err(|_| refuse())
}

/// A document with what its buffers hold.
struct Reader<'a> {
    document: &'a Document,
    buffers: Vec<&'a [u8]>,
}

impl Reader<'_> {
    /// All triangles of the scene that the file shows.
    fn scene(&self) -> Result<Parts> {
        let Document { nodes, meshes, .. } = self.document;
        let mut parts = Parts::default();
        let mut is_placed = vec![false; nodes.len()];
        let mut placed = 0;
        let root = DMat4::from_scale(DVec3::splat(MM_PER_M));
        let mut open: Vec<(u32, DMat4)> = self.roots()?.into_iter().rev().map(|node| (node, root)).collect();
        while let Some((index, above)) = open.pop() {
            let node = entry(nodes, index as usize, "node")?;
            if std::mem::replace(&mut is_placed[index as usize], true) {
                return Err(Error::input(format!("has node {index} in two places of its tree")));
            }
            let here = above * transform(node);
            if let Some(mesh) = node.mesh {
                let primitives = &entry(meshes, mesh, "mesh")?.primitives;
                placed += primitives.len();
                if placed > MOST_PLACED {
                    return Err(Error::input(format!("has over {MOST_PLACED} primitives in its nodes")));
                }
                for primitive in primitives {
                    self.add(primitive, here, &mut parts)?;
                }
            }
            open.extend(node.children.iter().rev().map(|child| (*child, here)));
        }
        // A mesh has them everywhere or nowhere.
        if parts.normals.len() != parts.positions.len() {
            parts.normals.clear();
        }
        if parts.uvs.len() != parts.positions.len() {
            parts.uvs.clear();
        }
        Ok(parts)
    }

    /// The nodes that stand by themselves: those of the scene that is shown, or of a file without any all that are no one's children.
    fn roots(&self) -> Result<Vec<u32>> {
        let Document { scene, scenes, nodes, .. } = self.document;
        if scene.is_some() || !scenes.is_empty() {
            return Ok(entry(scenes, scene.unwrap_or(0), "scene")?.nodes.clone());
        }
        let children: HashSet<u32> = nodes.iter().flat_map(|node| &node.children).copied().collect();
        Ok((0..nodes.len() as u32).filter(|node| !children.contains(node)).collect())
    }

    /// Adds the triangles of a primitive; points and lines are left out.
    fn add(&self, primitive: &Primitive, place: DMat4, parts: &mut Parts) -> Result<()> {
        let mode = primitive.mode.unwrap_or(TRIANGLES);
        let Some(positions) = primitive.attributes.position else { return Ok(()) };
        if !(TRIANGLES..=FAN).contains(&mode) {
            return Ok(());
        }
        let positions = self.values::<3>(positions)?;
        let first = parts.positions.len();
        if first + positions.len() > MOST_VERTICES {
            return Err(Error::input(format!("has over {MOST_VERTICES} vertices")));
        }
        let count = positions.len() as u32;
        let point = |p: [f32; 3]| place.transform_point3(Vec3::from(p).as_dvec3()).as_vec3();
        parts.positions.extend(positions.into_iter().map(point));
        if let Some(normals) = primitive.attributes.normal {
            let turn = DMat3::from_mat4(place);
            // Cofactors are the transposed inverse times the determinant, and there even where that is none.
            let (x, y, z) = (turn.x_axis, turn.y_axis, turn.z_axis);
            let cofactors =
                DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * turn.determinant().signum();
            let normal = |n: [f32; 3]| (cofactors * Vec3::from(n).as_dvec3()).normalize_or_zero().as_vec3();
            parts.normals.extend(self.values::<3>(normals)?.into_iter().take(count as usize).map(normal));
        }
        if let Some(uvs) = primitive.attributes.texcoord_0 {
            // There v grows downwards.
            let uv = |[u, v]: [f32; 2]| Vec2::new(u, 1.0 - v);
            parts.uvs.extend(self.values::<2>(uvs)?.into_iter().take(count as usize).map(uv));
        }
        let corners: Vec<u32> = match primitive.indices {
            None => (0..count).collect(),
            Some(indices) => self.values_as(indices, |[corner]: [f64; 1]| corner as u32)?,
        };
        if let Some(corner) = corners.iter().find(|corner| **corner >= count) {
            return Err(Error::input(format!("has a triangle with corner {corner} of {count}")));
        }
        let is_mirrored = place.determinant() < 0.0;
        let triangles = match mode {
            TRIANGLES => corners.len() / 3,
            _ => corners.len().saturating_sub(2),
        };
        for k in 0..triangles {
            let [a, b, c] = match mode {
                TRIANGLES => [corners[3 * k], corners[3 * k + 1], corners[3 * k + 2]],
                STRIP => [corners[k], corners[k + 1 + k % 2], corners[k + 2 - k % 2]],
                _ => [corners[0], corners[k + 1], corners[k + 2]],
            }
            .map(|corner| first as u32 + corner);
            parts.add_polygon(&if is_mirrored { [a, c, b] } else { [a, b, c] })?;
        }
        Ok(())
    }

    fn values<const N: usize>(&self, accessor: usize) -> Result<Vec<[f32; N]>> {
        self.values_as(accessor, |values: [f64; N]| values.map(|value| value as f32))
    }

    /// The rows of an accessor of `N` numbers each.
    fn values_as<const N: usize, T>(&self, accessor: usize, of: impl Fn([f64; N]) -> T) -> Result<Vec<T>> {
        let refuse = |what: &str| Error::input(format!("accessor {accessor} {what}"));
        let found = entry(&self.document.accessors, accessor, "accessor")?;
        let Accessor { buffer_view, byte_offset, count, normalized, .. } = *found;
        if found.kind != ["SCALAR", "VEC2", "VEC3"][N - 1] {
            return Err(refuse(&format!("has values of the kind '{}'", shortened(&found.kind))));
        }
        if found.sparse.is_some() {
            return Err(refuse("is sparse, which is not read; save the file without sparse accessors"));
        }
        let view = buffer_view.ok_or_else(|| refuse("has no buffer view"))?;
        let view = entry(&self.document.buffer_views, view, "buffer view")?;
        let buffer = entry(&self.buffers, view.buffer, "buffer")?;
        let number =
            Number::of(found.component_type).ok_or_else(|| refuse("has numbers of no known kind"))?;
        let stride = view.byte_stride.unwrap_or(N * number.bytes());
        let bytes = buffer
            .get(view.byte_offset..)
            .and_then(|rest| rest.get(..view.byte_length))
            .and_then(|rest| rest.get(byte_offset..))
            .ok_or_else(|| refuse("lies outside its buffer"))?;
        let row = N * number.bytes();
        let needed = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(row));
        if stride < row || count > 3 * MOST_VERTICES || needed.is_none_or(|needed| needed > bytes.len()) {
            return Err(refuse(&format!("of {count} values is larger than its buffer")));
        }
        let value = |at: usize| number.value(&bytes[at..at + number.bytes()], normalized);
        let rows = (0..count).map(|k| {
            let mut row = [0.0; N];
            for (column, entry) in row.iter_mut().enumerate() {
                *entry = value(k * stride + column * number.bytes());
            }
            of(row)
        });
        Ok(rows.collect())
    }
}

/// A node's place in the one above.
fn transform(node: &Node) -> DMat4 {
    node.matrix.map_or_else(
        || {
            let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
            let length = (x * x + y * y + z * z + w * w).sqrt();
            let turn = if length > 0.0 {
                DQuat::from_xyzw(x / length, y / length, z / length, w / length)
            } else {
                DQuat::IDENTITY
            };
            let scale = DVec3::from(node.scale.unwrap_or([1.0; 3]));
            DMat4::from_scale_rotation_translation(scale, turn, node.translation.unwrap_or_default().into())
        },
        |matrix| DMat4::from_cols_array(&matrix),
    )
}

/// A kind of number in a buffer, little-endian.
#[derive(Debug, Clone, Copy)]
enum Number {
    Signed(usize),
    Unsigned(usize),
    Float,
}

impl Number {
    /// By its code in the file.
    fn of(code: u32) -> Option<Self> {
        match code {
            5120 => Some(Self::Signed(1)),
            5121 => Some(Self::Unsigned(1)),
            5122 => Some(Self::Signed(2)),
            5123 => Some(Self::Unsigned(2)),
            5125 => Some(Self::Unsigned(4)),
            5126 => Some(Self::Float),
            _ => None,
        }
    }

    fn bytes(self) -> usize {
        match self {
            Self::Signed(bytes) | Self::Unsigned(bytes) => bytes,
            Self::Float => 4,
        }
    }

    /// The number in so many bytes; normalized integers are −1 … 1 or 0 … 1.
    fn value(self, bytes: &[u8], normalized: bool) -> f64 {
        let mut word = [0; 4];
        word[..bytes.len()].copy_from_slice(bytes);
        let unused = 32 - 8 * bytes.len() as u32;
        match self {
            Self::Float => f64::from(f32::from_le_bytes(word)),
            Self::Unsigned(_) => {
                let value = f64::from(u32::from_le_bytes(word));
                if normalized { value / f64::from(u32::MAX >> unused) } else { value }
            }
            Self::Signed(_) => {
                let value = f64::from((u32::from_le_bytes(word) << unused) as i32 >> unused);
                if normalized { (value / f64::from(i32::MAX >> unused)).max(-1.0) } else { value }
            }
        }
    }
}

#[cfg(test)]
mod tests;
