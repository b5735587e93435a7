//! Gratings as `.grating` files: *safetensors* containers with a JSON description.
//!
//! `docs/formats/grating.md` describes the layout.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use serde::{Deserialize, Serialize};

use super::whole::read_at_most;
use super::write_whole;
use crate::brdf::checksum_of;
use crate::scattering::grating::{
    Basis, Coherence, Normalization, Obliquity, Orders, Place, Powers, Setup, TableGrid, Tables,
};
use crate::{Error, Result};

/// Version of the layout.
const SCHEMA: u32 = 1;
/// The one entry of the container's metadata.
const ENTRY: &str = "barbule-grating";
/// The largest file that is read: tables of 1001² places, thirty of them, beside the powers of a patch.
pub const LARGEST_GRATING: u64 = 2 << 30;

/// What a `.grating` file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct GratingFile {
    /// What the heights were called.
    pub name: String,
    /// Colour tables under D65.
    pub tables: Tables,
    /// Powers of the orders at any wavelength, in the mean over places.
    pub powers: Powers,
    /// Where it comes from, as names and texts.
    pub provenance: serde_json::Value,
}

/// The description inside the container.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Description {
    schema: u32,
    name: String,
    /// `taylor` or `chebyshev`.
    basis: String,
    size: usize,
    exponent: f64,
    obliquity: String,
    /// s_s in µm, or none for a disc.
    coherence_um: Option<f64>,
    /// Angular radius of a disc.
    disc_rad: Option<f64>,
    /// Where the window stands, µm, or none for the mean over all places.
    place_um: Option<[f64; 2]>,
    /// `energy` or `relative`.
    normalization: String,
    index: f64,
    /// Highest orders of the powers, and the patch's periods.
    orders: [usize; 2],
    period_um: [f64; 2],
    kappa_most_per_um: f64,
    provenance: serde_json::Value,
    /// BLAKE3 of this description without the checksum, then of each tensor's name and bytes in the order of names.
    checksum: String,
}

/// Writes a grating.
///
/// # Errors
/// A path that cannot be written.
pub fn write_grating(path: &Path, grating: &GratingFile) -> Result<()> {
    write_whole(path, &encode(grating)?)
}

/// Reads a grating.
///
/// # Errors
/// The file is missing or too large, or no valid grating; the message begins with the file's name.
pub fn read_grating(path: &Path) -> Result<GratingFile> {
    decode_grating(&read_at_most(path, LARGEST_GRATING)?).map_err(|error| error.in_file(path))
}

fn encode(grating: &GratingFile) -> Result<Vec<u8>> {
    let (tables, powers) = (&grating.tables, &grating.powers);
    let setup = tables.setup();
    let obliquity = Obliquity::ALL.iter().find(|(_, form)| *form == setup.obliquity);
    let mut description = Description {
        schema: SCHEMA,
        name: grating.name.clone(),
        basis: match tables.basis() {
            Basis::Taylor { .. } => "taylor",
            Basis::Chebyshev { .. } => "chebyshev",
        }
        .into(),
        size: tables.grid().size,
        exponent: tables.grid().exponent,
        obliquity: obliquity.map_or("", |(name, _)| name).into(),
        coherence_um: match setup.coherence {
            Coherence::Fixed(deviation) => Some(deviation),
            Coherence::Disc(_) => None,
        },
        disc_rad: match setup.coherence {
            Coherence::Fixed(_) => None,
            Coherence::Disc(radius) => Some(radius),
        },
        place_um: match setup.place {
            Place::At(place) => Some(place),
            Place::Anywhere => None,
        },
        normalization: match setup.normalization {
            Normalization::Energy => "energy",
            Normalization::Relative => "relative",
        }
        .into(),
        index: setup.index,
        orders: powers.orders().most,
        period_um: powers.orders().period_um,
        kappa_most_per_um: powers.kappa_most(),
        provenance: grating.provenance.clone(),
        checksum: String::new(),
    };
    let bytes = |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
    let [columns, rows] = powers.orders().counts();
    let size = tables.grid().size;
    let tensors = BTreeMap::from([
        ("powers", (vec![rows, columns, powers.terms()], bytes(powers.series()))),
        ("tables", (vec![size, size, tables.basis().count(), 3], bytes(tables.values()))),
    ]);
    description.checksum =
        checksum_of(&description, tensors.iter().map(|(name, (_, bytes))| (*name, bytes.as_slice())))?;
    let json =
        serde_json::to_string(&description).map_err(|e| Error::machine(format!("no JSON form: {e}")))?;
    let refuse =
        |e: safetensors::SafeTensorError| Error::machine(format!("the grating cannot be stored: {e}"));
    let views = tensors
        .iter()
        .map(|(name, (shape, bytes))| Ok((*name, TensorView::new(Dtype::F32, shape.clone(), bytes)?)))
        .collect::<std::result::Result<Vec<_>, _>>()
        .map_err(refuse)?;
    safetensors::serialize(views, Some(HashMap::from([(ENTRY.to_owned(), json)]))).map_err(refuse)
}

/// A grating from the bytes of its file. Never allocates more than a few times the bytes given.
/// A grating's bytes.
///
/// # Errors
/// They are no valid grating.
pub fn decode_grating(bytes: &[u8]) -> Result<GratingFile> {
    let damaged = |what: &str| {
        let what: String = what.chars().map(|c| if c.is_control() { ' ' } else { c }).take(160).collect();
        Error::input(format!("is not a grating: {what}"))
    };
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|e| damaged(&e.to_string()))?;
    let json = metadata
        .metadata()
        .as_ref()
        .and_then(|entries| entries.get(ENTRY))
        .ok_or_else(|| damaged("its metadata has no entry of one (another kind of safetensors?)"))?;
    let schema = serde_json::from_str::<serde_json::Value>(json).map_err(|e| damaged(&e.to_string()))?;
    if schema.get("schema").and_then(serde_json::Value::as_u64) != Some(u64::from(SCHEMA)) {
        return Err(Error::input(format!(
            "has another schema than {SCHEMA}, which this program reads; make it again with `barbule diffract`"
        )));
    }
    let description: Description = serde_json::from_value(schema).map_err(|e| damaged(&e.to_string()))?;
    let container = SafeTensors::deserialize(bytes).map_err(|e| damaged(&e.to_string()))?;
    let tensor = |name: &'static str| {
        let view = container.tensor(name).map_err(|e| damaged(&e.to_string()))?;
        if view.dtype() != Dtype::F32 {
            return Err(damaged(&format!("array {name} has type {:?}, but must be F32", view.dtype())));
        }
        Ok((name, view))
    };
    let [tables, powers] = [tensor("tables")?, tensor("powers")?];
    let bare = Description { checksum: String::new(), ..description.clone() };
    let found = checksum_of(&bare, [(powers.0, powers.1.data()), (tables.0, tables.1.data())].into_iter())?;
    if found != description.checksum {
        return Err(Error::input(
            "the checksum does not match the contents: the file was damaged or edited; make it again",
        ));
    }
    let shape = |(name, view): &(&str, TensorView<'_>), axes: usize| match view.shape() {
        shape if shape.len() == axes => Ok(shape.to_vec()),
        shape => Err(damaged(&format!("array {name} has {} axes, not {axes}", shape.len()))),
    };
    let (table_shape, power_shape) = (shape(&tables, 4)?, shape(&powers, 3)?);
    let floats = |view: &TensorView<'_>| -> Vec<f32> {
        view.data().as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
    };
    let grid = TableGrid { size: description.size, exponent: description.exponent };
    let basis = basis_of(&description.basis, table_shape[2])?;
    let orders = Orders { most: description.orders, period_um: description.period_um };
    let tables = Tables::new(grid, basis, setup_of(&description)?, floats(&tables.1))?;
    let powers = Powers::new(orders, description.kappa_most_per_um, power_shape[2], floats(&powers.1))?;
    Ok(GratingFile { name: description.name, tables, powers, provenance: description.provenance })
}

fn basis_of(name: &str, count: usize) -> Result<Basis> {
    match name {
        "taylor" if count % 2 == 1 => Ok(Basis::Taylor { orders: count / 2 }),
        "chebyshev" => Ok(Basis::Chebyshev { terms: count }),
        _ => Err(Error::input(format!(
            "its basis must be 'chebyshev', or 'taylor' with an odd number of tables; it has {count}"
        ))),
    }
}

fn setup_of(description: &Description) -> Result<Setup> {
    let form = Obliquity::ALL.iter().find(|(name, _)| *name == description.obliquity);
    let (_, obliquity) = form.ok_or_else(|| Error::input("its obliquity is none that is known"))?;
    let coherence = match (description.coherence_um, description.disc_rad) {
        (Some(deviation), None) => Coherence::Fixed(deviation),
        (None, Some(radius)) => Coherence::Disc(radius),
        _ => return Err(Error::input("it must have either coherence_um or disc_rad")),
    };
    let normalization = match description.normalization.as_str() {
        "energy" => Normalization::Energy,
        "relative" => Normalization::Relative,
        _ => return Err(Error::input("its normalization must be 'energy' or 'relative'")),
    };
    let place = description.place_um.map_or(Place::Anywhere, Place::At);
    Ok(Setup { obliquity: *obliquity, coherence, place, normalization, index: description.index })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example(setup: Setup, basis: Basis) -> GratingFile {
        let grid = TableGrid { size: 3, exponent: 3.0 };
        let values = (0..9 * basis.count() * 3).map(|i| i as f32 * 0.25).collect();
        let orders = Orders { most: [1, 0], period_um: [10.0, 5.0] };
        GratingFile {
            name: "a patch".into(),
            tables: Tables::new(grid, basis, setup, values).unwrap(),
            powers: Powers::new(orders, 33.0, 2, vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6]).unwrap(),
            provenance: serde_json::json!({"seed": 1}),
        }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let usual = Setup::default();
        let relative = Setup {
            normalization: Normalization::Relative,
            coherence: Coherence::SUN,
            place: Place::Anywhere,
            obliquity: Obliquity::Reciprocal,
            ..usual
        };
        for (setup, basis) in
            [(usual, Basis::Chebyshev { terms: 2 }), (relative, Basis::Taylor { orders: 1 })]
        {
            let grating = example(setup, basis);
            let bytes = encode(&grating).unwrap();
            assert_eq!(decode_grating(&bytes).unwrap(), grating);
            assert_eq!(bytes, encode(&grating).unwrap());
        }
    }

    #[test]
    fn damaged_files_are_refused_in_one_sentence() {
        let bytes = encode(&example(Setup::default(), Basis::Chebyshev { terms: 2 })).unwrap();
        for length in [0, 7, 40, bytes.len() - 1] {
            assert!(decode_grating(&bytes[..length]).unwrap_err().is_input(), "{length}");
        }
        for place in (0..bytes.len()).step_by(7) {
            let mut bad = bytes.clone();
            bad[place] ^= 0x15;
            let error = decode_grating(&bad).unwrap_err();
            assert!(error.is_input() && !error.to_string().contains('\n'), "{place}: {error}");
        }
        // A header that promises more than there is.
        let mut huge = bytes.clone();
        huge[..8].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(decode_grating(&huge).unwrap_err().is_input());
    }
}
