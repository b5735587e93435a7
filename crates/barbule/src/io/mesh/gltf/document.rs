//! The JSON of a glTF file, as far as shapes go. Lists are of bounded lengths, so that a file makes no more than it weighs.

use std::marker::PhantomData;

use serde::de::{Deserializer, Error as _, SeqAccess, Visitor};
use serde::{Deserialize, de};

use crate::error::shortened;
use crate::{Error, Result};

/// The longest text: 64 MiB, with what is embedded in it. Larger buffers belong into a binary file.
const LONGEST_TEXT: usize = 64 << 20;

/// Most entries of a list: nodes, meshes, buffers.
const MOST_ENTRIES: usize = 100_000;

/// Extensions that change no shape, by how their names begin, and one that lets positions be of smaller numbers.
const HARMLESS: [&str; 4] = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_mesh_quantization"];

/// A whole file.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    asset: Asset,
    pub(super) scene: Option<usize>,
    #[serde(default, deserialize_with = "bounded")]
    pub(super) scenes: Vec<Scene>,
    #[serde(default, deserialize_with = "bounded")]
    pub(super) nodes: Vec<Node>,
    #[serde(default, deserialize_with = "bounded")]
    pub(super) meshes: Vec<MeshOf>,
    #[serde(default, deserialize_with = "bounded")]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default, deserialize_with = "bounded")]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(default, deserialize_with = "bounded")]
    pub(super) buffers: Vec<Buffer>,
    #[serde(default, deserialize_with = "bounded")]
    extensions_required: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Asset {
    version: String,
}

/// Nodes that stand by themselves.
#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default, deserialize_with = "bounded")]
    pub(super) nodes: Vec<u32>,
}

/// A mesh in its place, and nodes that move with it.
#[derive(Debug, Deserialize)]
pub(super) struct Node {
    pub(super) mesh: Option<usize>,
    #[serde(default, deserialize_with = "bounded")]
    pub(super) children: Vec<u32>,
    /// Column by column; in place of the other three.
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    /// A quaternion x, y, z, w.
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
pub(super) struct MeshOf {
    #[serde(deserialize_with = "bounded")]
    pub(super) primitives: Vec<Primitive>,
}

/// Triangles of one material. Numbers are those of accessors.
#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: Attributes,
    pub(super) indices: Option<usize>,
    pub(super) mode: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) struct Attributes {
    pub(super) position: Option<usize>,
    pub(super) normal: Option<usize>,
    pub(super) texcoord_0: Option<usize>,
}

/// Numbers in a part of a buffer.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
    pub(super) count: usize,
    #[serde(rename = "type")]
    pub(super) kind: String,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) sparse: Option<de::IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    pub(super) byte_stride: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) byte_length: usize,
}

impl Document {
    /// Reads the text.
    pub(super) fn parse(text: &[u8]) -> Result<Self> {
        if text.len() > LONGEST_TEXT {
            return Err(Error::input(format!(
                "has over {} MiB of JSON; give a binary .glb",
                LONGEST_TEXT >> 20
            )));
        }
        let document: Self = serde_json::from_slice(text).map_err(|error| {
            let what: String = error.to_string().chars().take(200).collect();
            Error::input(format!("is no glTF: {what}"))
        })?;
        if !document.asset.version.starts_with("2.") {
            let version = shortened(&document.asset.version);
            return Err(Error::input(format!("is glTF of version {version}; 2.0 is read")));
        }
        let changes_shapes = |name: &&String| !HARMLESS.iter().any(|start| name.starts_with(start));
        match document.extensions_required.iter().find(changes_shapes) {
            Some(name) => Err(Error::input(format!(
                "needs the extension '{}', which is not read; save it without compression",
                shortened(name)
            ))),
            None => Ok(document),
        }
    }
}

/// The entry that a number in the file names.
pub(super) fn entry<'a, T>(list: &'a [T], index: usize, what: &str) -> Result<&'a T> {
    list.get(index).ok_or_else(|| Error::input(format!("names {what} {index}, but has {}", list.len())))
}

/// A list of at most [`MOST_ENTRIES`].
fn bounded<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> std::result::Result<Vec<T>, D::Error> {
    struct Bounded<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for Bounded<T> {
        type Value = Vec<T>;

        fn expecting(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            write!(to, "a list of at most {MOST_ENTRIES} entries")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> std::result::Result<Vec<T>, A::Error> {
            let mut values = Vec::new();
            while let Some(value) = list.next_element()? {
                if values.len() == MOST_ENTRIES {
                    return Err(A::Error::custom(format!("a list has over {MOST_ENTRIES} entries")));
                }
                values.push(value);
            }
            Ok(values)
        }
    }
    from.deserialize_seq(Bounded(PhantomData))
}
