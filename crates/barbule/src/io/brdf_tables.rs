//! Tables of BRDFs as *safetensors* containers with a JSON description.
//!
//! `docs/formats/brdf-tables.md` describes the layout.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::whole::read_at_most;
use super::write_whole;
use crate::brdf::{
    BrdfTables, MOST_HALOS, Numbers, Reciprocity, Spectral, TABLES_VERSION, TableArray, TablesHeader,
    checksum_of,
};
use crate::error::shortened;
use crate::scattering::far_field::Polarization;
use crate::scattering::lobe::FitKind;
use crate::scattering::statistics::Sides;
use crate::{Error, Result};

/// The one entry of the container's metadata.
const ENTRY: &str = "barbule-tables";

/// The largest file that is read.
const LARGEST: u64 = 2 << 30;

/// The description inside the container.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Description {
    version: u32,
    program: String,
    /// `marginal` or `cone`.
    kind: String,
    /// `alike` or `both`.
    sides: String,
    /// 1 or 2, or none for unpolarized light.
    polarization: Option<u8>,
    /// False or true, and of later ones a word of [`Reciprocity`] that is neither.
    reciprocal: Value,
    sigma: f64,
    /// h of the height phase, µm, and the share of achromatic instances.
    height_um: f64,
    achromatic: f64,
    /// σ of the halo's Gaussians.
    halo: Vec<f64>,
    seed: u64,
    sets: usize,
    thetas: usize,
    phis: usize,
    waves: usize,
    /// BLAKE3 of this description without the checksum, then of each array's name and bytes in the order of names.
    checksum: String,
}

/// Writes the tables of a BRDF.
///
/// # Errors
/// A path that cannot be written.
pub fn write_tables(path: &Path, tables: &BrdfTables) -> Result<()> {
    write_whole(path, &encode_tables(tables)?)
}

/// Reads the tables of a BRDF.
///
/// # Errors
/// The file is missing or too large, or no valid tables; the message begins with the file's name.
pub fn read_tables(path: &Path) -> Result<BrdfTables> {
    decode_tables(&read_at_most(path, LARGEST)?).map_err(|error| error.at(path.display()))
}

/// The bytes of a file of tables. Equal tables give equal bytes.
///
/// # Errors
/// More bytes than the machine has.
pub fn encode_tables(tables: &BrdfTables) -> Result<Vec<u8>> {
    let arrays: BTreeMap<String, (Dtype, Vec<usize>, Vec<u8>)> = tables
        .arrays()
        .into_iter()
        .map(|TableArray { name, shape, numbers }| {
            let (dtype, bytes) = bytes_of(&numbers);
            (name, (dtype, shape, bytes))
        })
        .collect();
    let mut description = description_of(&tables.header());
    let bytes = arrays.iter().map(|(name, (.., bytes))| (name.as_str(), bytes.as_slice()));
    description.checksum = checksum_of(&description, bytes)?;
    let refuse =
        |e: safetensors::SafeTensorError| Error::machine(format!("the tables cannot be stored: {e}"));
    let views = arrays
        .iter()
        .map(|(name, (dtype, shape, bytes))| Ok((name, TensorView::new(*dtype, shape.clone(), bytes)?)))
        .collect::<std::result::Result<Vec<_>, _>>()
        .map_err(refuse)?;
    let entries = HashMap::from([(ENTRY.to_owned(), json(&description)?)]);
    safetensors::serialize(views, Some(entries)).map_err(refuse)
}

/// Tables from the bytes of their file. Never allocates more than a few times the bytes given.
///
/// # Errors
/// Anything but complete, undamaged tables of a known version, in one sentence.
pub fn decode_tables(bytes: &[u8]) -> Result<BrdfTables> {
    let damaged = |what: &str| Error::input(format!("is no file of BRDF tables: {}", shortened(what)));
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|e| damaged(&e.to_string()))?;
    let json_text = metadata
        .metadata()
        .as_ref()
        .and_then(|entries| entries.get(ENTRY))
        .ok_or_else(|| damaged("its metadata has no entry of them (another kind of safetensors?)"))?;
    let value: serde_json::Value = serde_json::from_str(json_text).map_err(|e| damaged(&e.to_string()))?;
    let version = value.get("version").and_then(serde_json::Value::as_u64);
    if version != Some(u64::from(TABLES_VERSION)) {
        return Err(Error::input(format!(
            "has another version than {TABLES_VERSION}, which this program reads; make the tables again from the material"
        )));
    }
    let description: Description = serde_json::from_value(value).map_err(|e| damaged(&e.to_string()))?;
    let container = SafeTensors::deserialize(bytes).map_err(|e| damaged(&e.to_string()))?;
    let mut views = container.tensors();
    views.sort_by(|a, b| a.0.cmp(&b.0));
    let bare = Description { checksum: String::new(), ..description.clone() };
    let found = checksum_of(&bare, views.iter().map(|(name, view)| (name.as_str(), view.data())))?;
    if found != description.checksum {
        return Err(Error::input(
            "the checksum does not match the contents: the file was damaged or edited; make it again",
        ));
    }
    let arrays = views
        .into_iter()
        .map(|(name, view)| match numbers_of(&view) {
            Some(numbers) => Ok(TableArray { name, shape: view.shape().to_vec(), numbers }),
            None => Err(damaged(&format!("array {name} has type {:?}", view.dtype()))),
        })
        .collect::<Result<Vec<_>>>()?;
    BrdfTables::from_arrays(&header_of(&description)?, &arrays)
}

fn json(description: &Description) -> Result<String> {
    serde_json::to_string(description).map_err(|e| Error::machine(format!("no JSON form: {e}")))
}

fn bytes_of(numbers: &Numbers<'_>) -> (Dtype, Vec<u8>) {
    match numbers {
        Numbers::F64(values) => (Dtype::F64, values.iter().flat_map(|v| v.to_le_bytes()).collect()),
        Numbers::F32(values) => (Dtype::F32, values.iter().flat_map(|v| v.to_le_bytes()).collect()),
        Numbers::I16(values) => (Dtype::I16, values.iter().flat_map(|v| v.to_le_bytes()).collect()),
    }
}

fn numbers_of(view: &TensorView<'_>) -> Option<Numbers<'static>> {
    let data = view.data();
    Some(match view.dtype() {
        Dtype::F64 => {
            Numbers::F64(Cow::Owned(data.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect()))
        }
        Dtype::F32 => {
            Numbers::F32(Cow::Owned(data.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()))
        }
        Dtype::I16 => {
            Numbers::I16(Cow::Owned(data.as_chunks().0.iter().map(|b| i16::from_le_bytes(*b)).collect()))
        }
        _ => return None,
    })
}

fn description_of(header: &TablesHeader) -> Description {
    let TablesHeader { version, reciprocity, sigma, halo, spectral, seed, sets, thetas, phis, waves, .. } =
        *header;
    Description {
        version,
        program: format!("barbule {}", env!("CARGO_PKG_VERSION")),
        kind: match header.kind {
            FitKind::Marginal => "marginal",
            FitKind::Cone => "cone",
        }
        .into(),
        sides: match header.sides {
            Sides::Alike => "alike",
            Sides::Both => "both",
        }
        .into(),
        polarization: header.polarization.map(|polarization| match polarization {
            Polarization::First => 1,
            Polarization::Second => 2,
        }),
        reciprocal: match reciprocity {
            Reciprocity::AsFitted => false.into(),
            Reciprocity::Mean => true.into(),
            Reciprocity::Steeper => reciprocity.word().into(),
        },
        sigma,
        halo: halo.into_iter().filter(|sigma| *sigma != 0.0).collect(),
        height_um: spectral.height_um,
        achromatic: spectral.achromatic,
        seed,
        sets,
        thetas,
        phis,
        waves,
        checksum: String::new(),
    }
}

fn header_of(description: &Description) -> Result<TablesHeader> {
    let refuse = |what: &str| Err(Error::input(format!("its {what}")));
    let Description { version, sigma, height_um, achromatic, seed, sets, thetas, phis, waves, .. } =
        *description;
    if description.halo.len() > MOST_HALOS {
        return refuse(&format!("halo has {} σ, over the limit of {MOST_HALOS}", description.halo.len()));
    }
    Ok(TablesHeader {
        version,
        kind: match description.kind.as_str() {
            "marginal" => FitKind::Marginal,
            "cone" => FitKind::Cone,
            _ => return refuse("kind must be 'marginal' or 'cone'"),
        },
        sides: match description.sides.as_str() {
            "alike" => Sides::Alike,
            "both" => Sides::Both,
            _ => return refuse("sides must be 'alike' or 'both'"),
        },
        polarization: match description.polarization {
            None => None,
            Some(1) => Some(Polarization::First),
            Some(2) => Some(Polarization::Second),
            Some(_) => return refuse("polarization must be 1, 2 or null"),
        },
        reciprocity: match &description.reciprocal {
            Value::Bool(false) => Reciprocity::AsFitted,
            Value::Bool(true) => Reciprocity::Mean,
            Value::String(word) if word == Reciprocity::Steeper.word() => Reciprocity::Steeper,
            _ => return refuse("reciprocal must be false, true or 'steeper'"),
        },
        sigma,
        halo: std::array::from_fn(|k| description.halo.get(k).copied().unwrap_or_default()),
        spectral: Spectral { height_um, achromatic },
        seed,
        sets,
        thetas,
        phis,
        waves,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::fixtures::{example, halo};
    use crate::brdf::{FeatherBrdf, FeatherMaterial, Options};
    use glam::DVec3;

    fn tables(options: Options) -> BrdfTables {
        let halo = options.sigma.is_none().then(halo);
        BrdfTables::new(&FeatherMaterial { halo, ..example(2) }, options).unwrap()
    }

    #[test]
    fn what_is_written_is_read_again_and_says_the_same() {
        let second = Some(Polarization::Second);
        for options in [
            Options::default(),
            Options { sigma: Some(0.1), reciprocity: Reciprocity::Mean, ..Options::default() },
            Options { reciprocity: Reciprocity::Steeper, ..Options::default() },
            Options { polarization: second, ..Options::default() },
        ] {
            let tables = tables(options);
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("file");
            write_tables(&path, &tables).unwrap();
            let again = read_tables(&path).unwrap();
            assert_eq!(again, tables);
            assert_eq!(encode_tables(&again).unwrap(), std::fs::read(&path).unwrap());
            let (wi, wo) = (DVec3::new(0.3, 0.2, 0.9).normalize(), DVec3::new(-0.25, -0.2, 0.9).normalize());
            let [one, two] = [tables, again]
                .map(|tables| FeatherBrdf::from_tables(tables).eval([433.0; 4], wi, wo, Some(5)));
            assert_eq!(one.map(f32::to_bits), two.map(f32::to_bits));
        }
    }

    /// The same container with another description, under a checksum that is right.
    fn described(bytes: &[u8], edit: impl Fn(&mut Description)) -> Vec<u8> {
        let container = SafeTensors::deserialize(bytes).unwrap();
        let (_, metadata) = SafeTensors::read_metadata(bytes).unwrap();
        let mut views = container.tensors();
        views.sort_by(|a, b| a.0.cmp(&b.0));
        let mut description: Description =
            serde_json::from_str(&metadata.metadata().as_ref().unwrap()[ENTRY]).unwrap();
        description.checksum = String::new();
        edit(&mut description);
        let arrays = views.iter().map(|(name, view)| (name.as_str(), view.data()));
        description.checksum = checksum_of(&description, arrays).unwrap();
        let entries = HashMap::from([(ENTRY.to_owned(), json(&description).unwrap())]);
        safetensors::serialize(views, Some(entries)).unwrap()
    }

    #[test]
    fn damaged_files_are_refused_in_one_sentence() {
        let bytes = encode_tables(&tables(Options::default())).unwrap();
        for length in [0, 7, 40, bytes.len() - 1] {
            assert!(decode_tables(&bytes[..length]).unwrap_err().is_input(), "{length}");
        }
        for place in (0..3000).step_by(7).chain((3000..bytes.len()).step_by(9973)) {
            let mut bad = bytes.clone();
            bad[place] ^= 0x15;
            let error = decode_tables(&bad).unwrap_err();
            assert!(error.is_input() && !error.to_string().contains('\n'), "{place}: {error}");
        }
        let mut huge = bytes.clone();
        huge[..8].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(decode_tables(&huge).unwrap_err().is_input());
        let material = crate::io::encode_material(&example(2)).unwrap();
        assert!(decode_tables(&material).unwrap_err().to_string().contains("another kind of safetensors?"));
        type Edit = (&'static str, fn(&mut Description));
        let edits: [Edit; 11] = [
            ("has another version than 3", |d| d.version = 1),
            ("achromatic is -1", |d| d.achromatic = -1.0),
            ("halo has 4 σ, over the limit of 3", |d| d.halo = vec![0.1; 4]),
            ("the halo of the tables has σ", |d| d.halo = vec![2.0]),
            ("inverse_q has 12291 numbers", |d| d.halo = vec![0.1]),
            ("kind must be 'marginal' or 'cone'", |d| d.kind = "half".into()),
            ("sides must be 'alike' or 'both'", |d| d.sides = String::new()),
            ("polarization must be 1, 2 or null", |d| d.polarization = Some(3)),
            ("sigma is 3", |d| d.sigma = 3.0),
            ("2 sets of 18446744073709551615 ×", |d| (d.sets, d.thetas) = (2, usize::MAX)),
            ("array p1.nodes is missing", |d| d.sets = 2),
        ];
        for (expected, edit) in edits {
            let error = decode_tables(&described(&bytes, edit)).unwrap_err();
            assert!(error.is_input() && error.to_string().contains(expected), "{expected}: {error}");
        }
        assert!(decode_tables(&described(&bytes, |_| ())).is_ok());
    }
}
