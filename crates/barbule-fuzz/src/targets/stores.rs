//! Stores of campaigns and of atlases: what a damaged or foreign file in them does.

use std::fs;
use std::path::{Path, PathBuf};

use barbule::Wavelengths;
use barbule::io::Numbers;
use barbule::io::store::Store;
use barbule::io::sweep::{SweepArray, SweepAxis, SweepLayout, SweepStore, SweepUnit, SweepValues};
use barbule::scattering::statistics::{Axes, UnitStatistics};
use num_complex::Complex;
use serde_json::{Value, json};

use super::{Target, Weight};
use crate::laws::{Held, holds, judged};
use crate::{Seen, Verdict, scratch, seal};

const ZARR_WORDS: &[&str] = &[
    "\"attributes\":",
    "\"barbule_store\":5",
    "\"wavelengths_nm\":[",
    "\"cos_theta_i\":[",
    "\"cos_phi_i\":[",
    "\"instances\":",
    "\"kept_nm\":[",
    "\"campaign\":{",
    "\"campaign_hash\":",
    "\"places\":",
    "\"simd\":\"scalar\"",
    "\"node_type\":\"group\"",
    "\"node_type\":\"array\"",
    "\"shape\":[",
    "\"chunk_shape\":[",
    "\"codecs\":[",
    "\"atlas\"",
    "null",
    "true",
    "-1",
    "1e300",
    "0",
    "4294967296",
    "{",
    "}",
    "[",
    "]",
];

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "store-group",
        about: "zarr.json of a campaign's store",
        tokens: ZARR_WORDS,
        seeds: || vec![read(&campaign().join(GROUP))],
        check: |bytes| group(&resealed(bytes, "campaign_hash").unwrap_or_else(|| bytes.to_vec())),
        weight: Weight::Store,
    },
    Target {
        name: "store-array",
        about: "zarr.json of an array in a campaign's store",
        tokens: ZARR_WORDS,
        seeds: || vec![read(&campaign().join("u").join(GROUP))],
        check: |bytes| {
            let folder = campaign();
            swapped(&folder.join("u").join(GROUP), bytes, || {
                judged(Store::open(&folder), |store| survey(&store))
            })
        },
        weight: Weight::Store,
    },
    Target {
        name: "store-chunk",
        about: "chunks of a campaign's store",
        tokens: &[],
        // Which of the files it is, then its bytes.
        seeds: || {
            (0..CHUNKS.len())
                .map(|which| [&[which as u8][..], &read(&campaign().join(CHUNKS[which]))].concat())
                .collect()
        },
        check: chunk,
        weight: Weight::Store,
    },
    Target {
        name: "atlas-group",
        about: "zarr.json of an atlas' store",
        tokens: ZARR_WORDS,
        seeds: || vec![read(&atlas().join(GROUP))],
        check: |bytes| {
            let folder = atlas();
            let check = |bytes: &[u8]| {
                swapped(&folder.join(GROUP), bytes, || {
                    let _ = SweepStore::width_of(&folder);
                    judged(Store::open(&folder), |_| Err("an atlas was opened as a campaign".into()))?;
                    judged(SweepStore::open(&folder, layout()), |store| cells(&store))
                })
            };
            check(bytes)?;
            check(&resealed(bytes, "sweep_hash").unwrap_or_default())
        },
        weight: Weight::Store,
    },
    Target {
        name: "atlas-chunk",
        about: "files of an atlas' store",
        tokens: &[],
        seeds: || {
            (0..SHARDS.len())
                .map(|which| [&[which as u8][..], &read(&atlas().join(SHARDS[which]))].concat())
                .collect()
        },
        check: shard,
        weight: Weight::Store,
    },
];

const GROUP: &str = "zarr.json";

/// Files of the campaign's first unit, in the order of their digests; the digest itself is the last.
const CHUNKS: [&str; 10] = [
    "u/c.0.0.0.0.0",
    "v/c.0.0.0.0.0",
    "autocovariance/c.0.0.0.0.0",
    "reflected/c.0.0.0.0",
    "reflected_std/c.0.0.0.0",
    "pattern_correlation/c.0.0.0",
    "unpolarized_contrast/c.0.0.0",
    "contrast/c.0.0.0.0.0",
    "glints/c.0.0.0.0.0",
    "digest/c.0.0.0",
];

/// Files of the atlas' first unit, likewise.
const SHARDS: [&str; 3] = ["mean/c.0.0.0", "colour/c.0.0.0", "digest/c.0.0"];

fn must<T, E: std::fmt::Display>(found: Result<T, E>) -> T {
    found.unwrap_or_else(|error| panic!("a store to be damaged cannot be made: {error}"))
}

fn read(path: &Path) -> Vec<u8> {
    must(fs::read(path).map_err(|error| format!("{}: {error}", path.display())))
}

/// A store of one unit, made once in each thread.
fn campaign() -> PathBuf {
    let folder = scratch::folder().join("campaign.zarr");
    if !folder.exists() {
        let at = must(Wavelengths::new([450.0]));
        let axes = must(Axes::new(&at, vec![1.0], vec![0.25]));
        let store = must(Store::create(&folder, &axes, 2, "nobody", &json!({"seed": 1}), &[], "scalar"));
        must(store.write(0, 0, &unit()));
    }
    folder
}

fn unit() -> UnitStatistics {
    let singles = |n: usize| (0..n).map(|k| k as f32).collect();
    let doubles = |n: usize| (0..n).map(|k| 9.0 + k as f64).collect();
    UnitStatistics {
        u: singles(2 * 400),
        v: singles(2 * 400),
        autocovariance: singles(2 * 512),
        reflected: doubles(2),
        reflected_std: doubles(2),
        pattern_correlation: doubles(1),
        unpolarized_contrast: doubles(1),
        contrast: singles(2 * 400),
        glints: singles(5 * 2),
        fields: Vec::<Complex<f32>>::new(),
    }
}

fn layout() -> SweepLayout {
    let axis = |name: &str, values: Vec<f64>| SweepAxis {
        name: name.into(),
        units: "um".into(),
        meaning: "test".into(),
        values: Numbers::Floats(values),
        labels: Vec::new(),
    };
    let array = |name: &str, is_bytes| SweepArray {
        name: name.into(),
        units: String::new(),
        meaning: "test".into(),
        along: vec!["wavelength".into()],
        is_bytes,
    };
    SweepLayout {
        name: "test".into(),
        width: "scalar".into(),
        cells: vec![axis("a_um", vec![1.0, 2.0, 3.0]), axis("b_um", vec![1.0, 2.0])],
        block: vec![2, 2],
        further: vec![axis("wavelength", vec![400.0, 500.0])],
        coordinates: Vec::new(),
        arrays: vec![array("mean", false), array("colour", true)],
        with_materials: false,
        description: json!({"seed": 1}),
    }
}

/// The store of an atlas with two units, made once in each thread.
fn atlas() -> PathBuf {
    let folder = scratch::folder().join("atlas.zarr");
    if !folder.exists() {
        let store = must(SweepStore::create(&folder, layout()));
        for number in 0..layout().units() {
            let count = layout().cells_of(number).into_iter().flatten().count() * 2;
            let values = vec![SweepValues::Floats(vec![0.5; count]), SweepValues::Bytes(vec![7; count])];
            must(store.write(number, &SweepUnit { values, materials: Vec::new() }, 0.1));
        }
    }
    folder
}

/// What comes out with other bytes in one file of a store, which then are its own again.
fn swapped(path: &Path, bytes: &[u8], check: impl FnOnce() -> Verdict) -> Verdict {
    let own = read(path);
    must(fs::write(path, bytes));
    let seen = check();
    must(fs::write(path, own));
    seen
}

/// A group's text whose checksum `key` is that of its other attributes.
fn resealed(bytes: &[u8], key: &str) -> Option<Vec<u8>> {
    let mut group: Value = serde_json::from_slice(bytes).ok()?;
    let mut covered = group.get("attributes")?.clone();
    covered.as_object_mut()?.remove(key);
    covered.sort_all_objects();
    group["attributes"][key] = json!(blake3::hash(covered.to_string().as_bytes()).to_hex().to_string());
    Some(group.to_string().into_bytes())
}

fn group(bytes: &[u8]) -> Verdict {
    let folder = campaign();
    swapped(&folder.join(GROUP), bytes, || judged(Store::open(&folder), |store| survey(&store)))
}

/// What a store says of itself.
fn survey(store: &Store) -> Held {
    let status = store.status();
    holds(status.done + status.damaged <= status.units, || format!("{status:?}"))?;
    for (wavelength, theta) in store.units().take(8) {
        if let Some(unit) = store.read(wavelength, theta) {
            possible(&unit)?;
        }
    }
    match store.statistics() {
        Ok(_) => Ok(()),
        Err(error) => crate::laws::refusal(&error),
    }
}

/// What comes out of a store could be a reflection.
fn possible(unit: &UnitStatistics) -> Held {
    let sound = unit.u.iter().all(|value| value.is_finite() && *value >= 0.0)
        && unit.reflected.iter().chain(&unit.reflected_std).all(|value| value.is_finite() && *value >= 0.0);
    holds(sound, || "values came out that no reflection has".into())
}

/// The first of eight bytes of BLAKE3 that tie a file to its place: of parts with their lengths before them.
fn tie<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> u64 {
    let mut hasher = blake3::Hasher::new();
    for part in parts {
        hasher.update(&(part.len() as u64).to_le_bytes()).update(part);
    }
    hasher.finalize().as_bytes().first_chunk().copied().map_or(0, u64::from_le_bytes)
}

/// The checksum among the attributes of a store's group.
fn hash_of(folder: &Path, key: &str) -> String {
    let group: Value = must(serde_json::from_slice(&read(&folder.join(GROUP))));
    group["attributes"][key].as_str().unwrap_or_default().to_owned()
}

fn chunk(bytes: &[u8]) -> Verdict {
    let Some((which, body)) = bytes.split_first() else { return Ok(Seen::Refused) };
    let which = usize::from(*which) % CHUNKS.len();
    let folder = campaign();
    let path = folder.join(CHUNKS[which]);
    let own = must(Store::open(&folder));
    let check = || {
        let status = own.status();
        match own.read(0, 0) {
            Some(unit) => possible(&unit).map(|()| Seen::Accepted),
            None => holds(status.done == 0, || "a unit that cannot be read is said to be done".into())
                .map(|()| Seen::Refused),
        }
    };
    // As it is; with its own checksum; and with the digest that ties it to its place.
    let first = swapped(&path, body, check)?;
    let Some(sealed) = seal::trailing_crc32c(body) else { return Ok(first) };
    let second = swapped(&path, &sealed, check)?;
    if which + 1 == CHUNKS.len() {
        return Ok(second);
    }
    let digest = folder.join(CHUNKS[CHUNKS.len() - 1]);
    let mut digests = read(&digest);
    let tied = tie([hash_of(&folder, "campaign_hash").as_bytes(), CHUNKS[which].as_bytes(), &sealed]);
    digests[which * 8..which * 8 + 8].copy_from_slice(&tied.to_le_bytes());
    let digests = seal::trailing_crc32c(&digests).unwrap_or(digests);
    swapped(&digest, &digests, || swapped(&path, &sealed, check))
}

/// Cells that are there are of numbers.
fn cells(store: &SweepStore) -> Held {
    let status = store.status();
    holds(status.done + status.damaged <= status.units, || format!("{status:?}"))?;
    for name in ["mean", "colour"] {
        match store.numbers(name) {
            Ok(values) => holds(values.iter().flatten().flatten().all(|value| !value.is_infinite()), || {
                "an infinite value came out".into()
            })?,
            Err(error) => crate::laws::refusal(&error)?,
        }
    }
    Ok(())
}

/// Cells of a file of the atlas, and bytes of the values of each.
const CELLS: [(usize, usize); SHARDS.len()] = [(4, 2 * 8), (4, 2), (1, SHARDS.len() * 8)];

/// A file with the checksums of its cells, and of where they lie, made right.
fn resealed_shard(body: &[u8], (count, length): (usize, usize)) -> Vec<u8> {
    let mut body = body.to_vec();
    let mut seal = |from: usize, length: usize| {
        if let Some(part) = body.get_mut(from..from + length + 4) {
            let (values, sum) = part.split_at_mut(length);
            sum.copy_from_slice(&crc32c::crc32c(values).to_le_bytes());
        }
    };
    (0..count).for_each(|cell| seal(cell * (length + 4), length));
    seal(count * (length + 4), count * 16);
    body
}

fn shard(bytes: &[u8]) -> Verdict {
    let Some((which, body)) = bytes.split_first() else { return Ok(Seen::Refused) };
    let which = usize::from(*which) % SHARDS.len();
    let folder = atlas();
    let path = folder.join(SHARDS[which]);
    let store = must(SweepStore::open(&folder, layout()));
    let check = || {
        cells(&store)?;
        Ok(if store.read(0).is_some() { Seen::Accepted } else { Seen::Refused })
    };
    let first = swapped(&path, body, check)?;
    let sealed = resealed_shard(body, CELLS[which]);
    let second = swapped(&path, &sealed, check)?;
    if which + 1 == SHARDS.len() {
        return Ok(if first == Seen::Accepted { first } else { second });
    }
    let last = SHARDS.len() - 1;
    let digest = folder.join(SHARDS[last]);
    let mut digests = read(&digest);
    let tied = tie([hash_of(&folder, "sweep_hash").as_bytes(), SHARDS[which].as_bytes(), &sealed]);
    digests[which * 8..which * 8 + 8].copy_from_slice(&tied.to_le_bytes());
    swapped(&digest, &resealed_shard(&digests, CELLS[last]), || swapped(&path, &sealed, check))
}
