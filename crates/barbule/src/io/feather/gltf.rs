//! glTF 2.0 in one file: a mesh a part, the buffer embedded.

use base64::prelude::{BASE64_STANDARD, Engine as _};
use glam::Vec3;
use serde_json::{Value, json};

use super::parts::Part;
use crate::{Error, Result};

const FLOATS: u32 = 5126;
const INDICES: u32 = 5125;

/// The file's bytes. glTF's unit is the metre: a node scales what is in mm.
pub(super) fn encoded(parts: &[Part], notes: &[(&str, &str)]) -> Result<Vec<u8>> {
    let mut buffer = Vec::new();
    let (mut views, mut accessors, mut meshes, mut nodes) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut put = |bytes: Vec<u8>, accessor: Value| {
        views.push(json!({"buffer": 0, "byteOffset": buffer.len(), "byteLength": bytes.len()}));
        buffer.extend(bytes);
        let mut accessor = accessor;
        accessor["bufferView"] = (views.len() - 1).into();
        accessors.push(accessor);
        accessors.len() - 1
    };
    for part in parts {
        let floats =
            |values: &[Vec3]| values.iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes).collect();
        let indices = part.triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes()).collect();
        let low = part.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = part.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let count = part.positions.len();
        let positions = put(
            floats(&part.positions),
            json!({"componentType": FLOATS, "count": count, "type": "VEC3", "min": low.to_array(), "max": high.to_array()}),
        );
        let normals =
            put(floats(&part.normals), json!({"componentType": FLOATS, "count": count, "type": "VEC3"}));
        let corners = put(
            indices,
            json!({"componentType": INDICES, "count": 3 * part.triangles.len(), "type": "SCALAR"}),
        );
        meshes.push(json!({
            "name": part.name,
            "primitives": [{"attributes": {"POSITION": positions, "NORMAL": normals}, "indices": corners}],
        }));
        nodes.push(json!({"name": part.name, "mesh": meshes.len() - 1, "scale": [0.001, 0.001, 0.001]}));
    }
    let extras: serde_json::Map<String, Value> =
        notes.iter().map(|(name, text)| ((*name).to_owned(), (*text).into())).collect();
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&buffer));
    let roots: Vec<usize> = (0..nodes.len()).collect();
    let document = json!({
        "asset": {"version": "2.0", "generator": "barbule", "extras": extras},
        "scene": 0,
        "scenes": [{"nodes": roots}],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": buffer.len(), "uri": uri}],
    });
    serde_json::to_vec(&document).map_err(|error| Error::machine(format!("no glTF: {error}")))
}
