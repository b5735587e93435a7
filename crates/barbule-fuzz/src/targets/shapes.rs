//! Meshes, curves and heights.

use std::collections::BTreeMap;

use barbule::io::{
    Clean, HeightUnit, HeightsOptions, Memory, curves_text, decode_mesh, foretell_heights, foretell_mesh,
    parse_curves, read_heights,
};
use barbule::scene::spline::Basis;
use serde_json::json;

use super::{Target, Weight, bytes_of, finite};
use crate::laws::{holds, judged};
use crate::{Verdict, scratch, seal};

const PLY_WORDS: &[&str] = &[
    "ply\n",
    "format ascii 1.0\n",
    "format binary_little_endian 1.0\n",
    "format binary_big_endian 1.0\n",
    "element vertex ",
    "element face ",
    "element edge ",
    "property float x\n",
    "property list uchar int vertex_indices\n",
    "property list uint8 uint32 vertex_index\n",
    "property double nx\n",
    "comment ",
    "end_header\n",
    "5000000",
    "5000001",
    "4294967295",
];
const GLTF_WORDS: &[&str] = &[
    "\"uri\":\"data:application/octet-stream;base64,",
    "\"uri\":\"part.bin\"",
    "\"byteLength\":",
    "\"byteOffset\":",
    "\"byteStride\":",
    "\"componentType\":5126",
    "\"componentType\":5121",
    "\"type\":\"VEC3\"",
    "\"normalized\":true",
    "\"sparse\":{",
    "\"mode\":5",
    "\"mode\":6",
    "\"children\":[0]",
    "\"matrix\":[",
    "\"scale\":[0,0,0]",
    "\"nodes\":[0,0]",
    "null",
    "-1",
    "1e300",
];
const HEADER: &str = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }   \n";

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "ply",
        about: "meshes in PLY, text and binary",
        tokens: PLY_WORDS,
        seeds: || vec![ply_text(), ply_binary(false), ply_binary(true)],
        check: |bytes| mesh("mesh.ply", bytes),
        weight: Weight::Text,
    },
    Target {
        name: "obj",
        about: "meshes in OBJ",
        tokens: &[
            "v ",
            "vt ",
            "vn ",
            "f ",
            "1/1/1",
            "-1//-1",
            "\\\n",
            "o a\n",
            "g a\n",
            "usemtl a\n",
            "mtllib a\n",
            "s off\n",
            "#",
            "nan",
            "1e39",
        ],
        seeds: || {
            bytes_of([
                "# a roof\nmtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\ng roof\nf 1/1 2/2 3/3 4/4\nf -5/-5 2/2 5/5\n",
                "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n",
            ])
        },
        check: |bytes| mesh("mesh.obj", bytes),
        weight: Weight::Text,
    },
    Target {
        name: "gltf",
        about: "meshes in glTF",
        tokens: GLTF_WORDS,
        seeds: || vec![gltf(Some("data:application/octet-stream;base64,")), gltf(Some("part.bin"))],
        check: |bytes| mesh("mesh.gltf", bytes),
        weight: Weight::Text,
    },
    Target {
        name: "glb",
        about: "meshes in binary glTF",
        tokens: GLTF_WORDS,
        seeds: || vec![glb()],
        check: |bytes| mesh("mesh.glb", &mended(bytes)),
        weight: Weight::Text,
    },
    Target {
        name: "curves",
        about: "curves as lines of control points",
        tokens: &["0 0 0 1\n", "\n\n", "nan", "1e9", "-1", "1e-300", "#"],
        seeds: || {
            bytes_of([
                "0 0 0 0.1\n0 0 1 0.1\n0 0 2 0.08\n0 1 3 0.05\n\n1 0 0 0.1\n1 0 1 0.1\n1 1 2 0.1\n2 1 3 0.05\n",
            ])
        },
        check: curves,
        weight: Weight::Text,
    },
    Target {
        name: "heights-npy",
        about: "heights in NumPy's NPY",
        tokens: &[
            "\x02\0",
            "\x03\0",
            "'descr': '<f8'",
            "'descr': '>i2'",
            "'descr': '|u1'",
            "'descr': '<f2'",
            "'descr': '|b1'",
            "'fortran_order': True",
            "'shape': (3, 2)",
            "(2, 3,)",
            "()",
            "(99999999999, 9)",
            "L",
        ],
        seeds: || {
            let doubles: Vec<u8> = (0..6).flat_map(|i| f64::from(i).to_le_bytes()).collect();
            let shorts: Vec<u8> = (0..6).flat_map(|i: i16| i.to_be_bytes()).collect();
            let big = HEADER.replace("<f8", ">i2").replace("False", "True");
            vec![
                npy(1, HEADER, &doubles),
                npy(2, HEADER, &doubles),
                npy(3, &big, &shorts),
                npy(1, &HEADER.replace("<f8", "|u1"), &[1; 6]),
            ]
        },
        check: heights,
        weight: Weight::Numbers,
    },
    Target {
        name: "heights-tiff",
        about: "heights in TIFF",
        tokens: &["II*\0", "MM\0*"],
        seeds: Vec::new,
        check: heights,
        weight: Weight::Picture,
    },
    Target {
        name: "heights-png",
        about: "heights in PNG",
        tokens: &["IHDR", "IDAT", "IEND", "tRNS", "PLTE"],
        seeds: Vec::new,
        check: |bytes| heights(&seal::png(bytes)),
        weight: Weight::Picture,
    },
    Target {
        name: "heights-gwyddion",
        about: "heights in Gwyddion's own files",
        tokens: &[
            "GwyContainer\0",
            "GwyDataField\0",
            "/0/data\0o",
            "xres\0i",
            "yres\0i",
            "xreal\0d",
            "yreal\0d",
            "data\0D",
            "si_unit_z\0oGwySIUnit\0",
            "unitstr\0sm\0",
            "si_unit_xy\0o",
        ],
        seeds: || vec![gwyddion()],
        check: heights,
        weight: Weight::Text,
    },
    Target {
        name: "heights-text",
        about: "heights as text, Gwyddion's export among them",
        tokens: &[
            "# Width: 3 \u{b5}m\n",
            "# Height: 2 nm\n",
            "# Value units: m\n",
            "# Channel: z\n",
            "\t",
            ";",
            ",",
            "nan",
            "1,5",
            "\r",
            "1e-9",
        ],
        seeds: || {
            bytes_of([
                "0 1 2\n3 4 5\n",
                "0;1;2\n3;4,0;5",
                "# Channel: Topography\n# Width: 3.00 \u{b5}m\n# Height: 2.00 \u{b5}m\n# Value units: m\n0 1e-6 2e-6\n3e-6 4e-6 5e-6\n",
            ])
        },
        check: heights,
        weight: Weight::Text,
    },
];

fn mesh(name: &str, bytes: &[u8]) -> Verdict {
    let files = BTreeMap::from([(name.to_owned(), bytes.to_vec()), ("part.bin".to_owned(), buffer())]);
    judged(decode_mesh(name, &Memory(files)), |(mesh, _)| {
        let vertices = mesh.positions.len();
        holds(mesh.triangles.iter().flatten().all(|corner| (*corner as usize) < vertices), || {
            "a corner that is not there".into()
        })?;
        holds([0, vertices].contains(&mesh.normals.len()), || {
            format!("{} normals of {vertices}", mesh.normals.len())
        })?;
        holds([0, vertices].contains(&mesh.uvs.len()), || format!("{} uvs of {vertices}", mesh.uvs.len()))?;
        holds(mesh.positions.iter().all(|position| position.is_finite()), || {
            "a position that is no number".into()
        })?;
        holds(mesh.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-3), || {
            "a normal that is not of length 1".into()
        })?;
        let length = bytes.len() as u64;
        foretell_mesh(name, bytes, length).map_or(Ok(()), |[foretold, _]| {
            holds(vertices as f64 <= foretold, || format!("{vertices} vertices, foretold {foretold}"))
        })
    })
}

fn curves(bytes: &[u8]) -> Verdict {
    let text = String::from_utf8_lossy(bytes);
    let check = |basis| {
        judged(parse_curves("curves.txt", &text, basis), |curves| {
            holds(
                curves
                    .iter()
                    .flatten()
                    .all(|[x, y, z, r]| [x, y, z, r].into_iter().all(|v| v.is_finite()) && *r > 0.0),
                || "a point that is none".into(),
            )?;
            // Six digits are written: thin ones may become nothing, which is refused.
            let written = curves_text(&curves);
            match parse_curves("written.txt", &written, basis) {
                Ok(back) => holds(curves_text(&back) == written, || "curves come back changed".into()),
                Err(error) => holds(error.to_string().contains("radius"), || {
                    format!("what was written is refused: {error}")
                }),
            }
        })
    };
    check(Basis::Linear)?;
    check(Basis::BSpline)
}

fn heights(bytes: &[u8]) -> Verdict {
    let path = scratch::file("heights", bytes);
    let given = |unit, range_um| HeightsOptions { pitch_um: Some(0.5), unit, range_um, clean: Clean::Never };
    let check = |options: HeightsOptions| {
        judged(read_heights(&path, &options), |(field, _)| {
            finite("height", field.height_um())?;
            let [columns, rows] = field.cells();
            holds(columns * rows == field.height_um().len(), || {
                "sides that are not those of the heights".into()
            })?;
            let foretold =
                foretell_heights(&path, &options).ok_or("heights that were read were not foretold")?;
            holds(foretold >= 8 * field.height_um().len() as u64, || {
                format!("foretold {foretold} bytes of {columns} x {rows} heights")
            })
        })
    };
    // What a file says of itself must not be said again; what it does not say must.
    let first = check(HeightsOptions { clean: Clean::Never, ..HeightsOptions::default() })?;
    let second = check(given(Some(HeightUnit::Nanometre), None))?;
    let third = check(given(None, Some(1.0)))?;
    let accepted = [first, second, third].into_iter().find(|seen| *seen == crate::Seen::Accepted);
    Ok(accepted.unwrap_or(first))
}

fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
    let length = match version {
        1 => (header.len() as u16).to_le_bytes().to_vec(),
        _ => (header.len() as u32).to_le_bytes().to_vec(),
    };
    [b"\x93NUMPY", &[version, 0][..], &length, header.as_bytes(), data].concat()
}

fn ply_text() -> Vec<u8> {
    b"ply\nformat ascii 1.0\ncomment a roof\nelement vertex 5\nproperty float x\nproperty float y\nproperty double z\nproperty float u\nproperty float v\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n0.5 0.5 1 0.5 0.5\n4 0 1 2 3\n3 0 1 4\n".to_vec()
}

fn ply_binary(is_big: bool) -> Vec<u8> {
    let order = if is_big { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n").into_bytes();
    for [x, y] in [[0.0_f32, 0.0], [1.0, 0.0], [0.0, 1.0]] {
        for value in [x, y, 0.0, 0.0, 0.0, 1.0] {
            bytes.extend(if is_big { value.to_be_bytes() } else { value.to_le_bytes() });
        }
    }
    bytes.push(3);
    for corner in 0..3_i32 {
        bytes.extend(if is_big { corner.to_be_bytes() } else { corner.to_le_bytes() });
    }
    bytes
}

/// A square of 1 m, its corners' texture coordinates, and six indices of two bytes.
fn buffer() -> Vec<u8> {
    let corners = [[0.0_f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let places = corners.iter().flat_map(|[x, y]| [*x, *y, 0.0]).flat_map(f32::to_le_bytes);
    let uvs = corners.iter().flatten().flat_map(|value| value.to_le_bytes());
    let indices = [0_u16, 1, 2, 0, 2, 3].into_iter().flat_map(u16::to_le_bytes);
    places.chain(uvs).chain(indices).collect()
}

/// The bytes of [`buffer`] in base64.
const BASE64: &str = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAgD8AAIA/AAAAAAAAgD8AAAEAAgAAAAIAAwA=";

fn gltf(uri: Option<&str>) -> Vec<u8> {
    let mut document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [0, 0, 1], "children": [1]}, {"mesh": 0, "rotation": [0, 0, 0, 1], "scale": [2, 1, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 0, "byteOffset": 48, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 80}, {"buffer": 0, "byteOffset": 80, "byteLength": 12}],
        "buffers": [{"byteLength": 92}],
    });
    if let Some(uri) = uri {
        let data = if uri.starts_with("data:") { BASE64 } else { "" };
        document["buffers"][0]["uri"] = json!(format!("{uri}{data}"));
    }
    document.to_string().into_bytes()
}

const JSON_CHUNK: u32 = 0x4e4f_534a;
const BINARY_CHUNK: u32 = 0x004e_4942;

fn glb() -> Vec<u8> {
    let mut text = gltf(None);
    text.resize(text.len().next_multiple_of(4), b' ');
    let data = buffer();
    let mut bytes = b"glTF".to_vec();
    for word in [2, (12 + 8 + text.len() + 8 + data.len()) as u32, text.len() as u32, JSON_CHUNK] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(&text);
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(BINARY_CHUNK.to_le_bytes());
    bytes.extend(&data);
    bytes
}

/// A binary glTF whose length is that of the file: mutations seldom keep it.
fn mended(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let length = bytes.len() as u32;
    // One in eight keeps what it says.
    if let Some(place) = bytes.get_mut(8..12).filter(|_| !length.is_multiple_of(8)) {
        place.copy_from_slice(&length.to_le_bytes());
    }
    bytes
}

/// A file of Gwyddion's with one channel of 3 by 2 heights.
fn gwyddion() -> Vec<u8> {
    let entry = |name: &str, kind: u8, value: &[u8]| [name.as_bytes(), &[0, kind], value].concat();
    let object = |kind: &str, entries: &[Vec<u8>]| {
        let body = entries.concat();
        [kind.as_bytes(), &[0], &(body.len() as u32).to_le_bytes(), &body].concat()
    };
    let unit = |text: &str| object("GwySIUnit", &[entry("unitstr", b's', &[text.as_bytes(), &[0]].concat())]);
    let values: Vec<u8> = (0..6).flat_map(|i| (1e-6 * f64::from(i)).to_le_bytes()).collect();
    let field = object(
        "GwyDataField",
        &[
            entry("xres", b'i', &3_i32.to_le_bytes()),
            entry("yres", b'i', &2_i32.to_le_bytes()),
            entry("xreal", b'd', &3e-6_f64.to_le_bytes()),
            entry("yreal", b'd', &2e-6_f64.to_le_bytes()),
            entry("si_unit_xy", b'o', &unit("m")),
            entry("si_unit_z", b'o', &unit("m")),
            entry("data", b'D', &[&6_u32.to_le_bytes()[..], &values].concat()),
        ],
    );
    let title = [b"Height".as_slice(), &[0]].concat();
    let all = object("GwyContainer", &[entry("/0/data", b'o', &field), entry("/0/data/title", b's', &title)]);
    [b"GWYP".as_slice(), &all].concat()
}
