//! Tables of a crystal's orders in the cache: *safetensors* containers with a checksum.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use safetensors::{Dtype, SafeTensors, tensor::TensorView};

use super::{LARGEST_INPUT, hash_bytes, read_bytes, read_own, write_whole};
use crate::scattering::orders::{JONES, OrderSeries, OrderTable, Piece};
use crate::{Error, Result};

/// The entry of the container's metadata that holds the key and the checksum.
const ENTRY: &str = "barbule-orders";

/// Numbers per series (step, mirrored, pieces) and per piece (its four bounds, first order, orders, terms).
const PER_SERIES: usize = 3;
const PER_PIECE: usize = 7;

/// Writes a table under a key that names everything it was computed from.
///
/// # Errors
/// The file cannot be written.
pub fn write_orders(path: &Path, key: &str, table: &OrderTable) -> Result<()> {
    let (mut all_series, mut pieces, mut coefficients) = (Vec::new(), Vec::new(), Vec::new());
    for series in &table.series {
        all_series.extend([series.step, f64::from(u8::from(series.mirrored)), series.pieces.len() as f64]);
        for piece in &series.pieces {
            let terms = piece.coefficients.len() / (piece.orders * JONES);
            pieces.extend(piece.between.iter().chain(&piece.part));
            pieces.extend([f64::from(piece.first), piece.orders as f64, terms as f64]);
            coefficients.extend_from_slice(&piece.coefficients);
        }
    }
    let arrays: BTreeMap<&str, &[f64]> = BTreeMap::from([
        ("wavelengths_nm", &table.wavelengths_nm[..]),
        ("cos_theta", &table.cos_theta),
        ("series", &all_series),
        ("pieces", &pieces),
        ("coefficients", &coefficients),
    ]);
    let arrays: BTreeMap<&str, Vec<u8>> = arrays
        .into_iter()
        .map(|(name, values)| (name, values.iter().flat_map(|v| v.to_le_bytes()).collect()))
        .collect();
    let entry = format!("{key} {}", checksum(key, arrays.values().map(Vec::as_slice)));
    let refuse = |e: safetensors::SafeTensorError| Error::machine(format!("orders cannot be stored: {e}"));
    let views = arrays
        .iter()
        .map(|(name, bytes)| Ok((*name, TensorView::new(Dtype::F64, vec![bytes.len() / 8], bytes)?)))
        .collect::<Result<Vec<_>, _>>()
        .map_err(refuse)?;
    let bytes =
        safetensors::serialize(views, Some(HashMap::from([(ENTRY.to_owned(), entry)]))).map_err(refuse)?;
    write_whole(path, &bytes)
}

/// Reads the table of a key, from a cache.
///
/// # Errors
/// The file is missing, of another key, or damaged.
pub fn read_orders(path: &Path, key: &str) -> Result<OrderTable> {
    let found = decode(&read_own(path, LARGEST_INPUT)?).filter(|(found, _)| found == key);
    found
        .map(|(_, table)| table)
        .ok_or_else(|| Error::input("is no table of these orders, or was damaged; delete it").in_file(path))
}

/// Reads any table, with its key.
///
/// # Errors
/// The file is missing, no table, or damaged.
pub fn read_keyed_orders(path: &Path) -> Result<(String, OrderTable)> {
    decode(&read_bytes(path)?).ok_or_else(|| {
        Error::input(format!(
            "{}: is no table of a crystal's orders, or was damaged; delete it",
            path.display()
        ))
    })
}

/// The key of a table, and the table.
fn decode(bytes: &[u8]) -> Option<(String, OrderTable)> {
    let (_, metadata) = SafeTensors::read_metadata(bytes).ok()?;
    let (key, sum) = metadata.metadata().as_ref()?.get(ENTRY)?.rsplit_once(' ')?;
    let container = SafeTensors::deserialize(bytes).ok()?;
    let names: std::collections::BTreeSet<&str> = container.names().into_iter().collect();
    let views = names.iter().map(|name| container.tensor(name).ok()).collect::<Option<Vec<_>>>()?;
    if checksum(key, views.iter().map(|view| view.data())) != sum {
        return None;
    }
    let array = |name: &str| {
        let view = container.tensor(name).ok().filter(|view| view.dtype() == Dtype::F64)?;
        Some(view.data().as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect::<Vec<f64>>())
    };
    let (wavelengths_nm, cos_theta) = (array("wavelengths_nm")?, array("cos_theta")?);
    let (all_series, pieces, coefficients) = (array("series")?, array("pieces")?, array("coefficients")?);
    let (mut pieces, mut coefficients) = (pieces.as_chunks::<PER_PIECE>().0.iter(), &coefficients[..]);
    let mut series = Vec::new();
    for &[step, mirrored, count] in all_series.as_chunks::<PER_SERIES>().0 {
        let mut own = Vec::new();
        for &[s0, s1, from, to, first, orders, terms] in pieces.by_ref().take(count as usize) {
            let orders = orders as usize;
            let length = (terms as usize).checked_mul(orders)?.checked_mul(JONES)?;
            let (head, rest) = coefficients.split_at_checked(length).filter(|(head, _)| !head.is_empty())?;
            coefficients = rest;
            let (between, part, first) = ([s0, s1], [from, to], first as i32);
            own.push(Piece { between, part, first, orders, coefficients: head.to_vec() });
        }
        if own.is_empty() {
            return None;
        }
        series.push(OrderSeries { step, mirrored: mirrored != 0.0, pieces: own });
    }
    let whole = series.len() == wavelengths_nm.len().checked_mul(cos_theta.len())?;
    whole.then(|| (key.to_owned(), OrderTable { wavelengths_nm, cos_theta, series }))
}

fn checksum<'a>(key: &str, arrays: impl Iterator<Item = &'a [u8]>) -> String {
    let mut all = key.as_bytes().to_vec();
    arrays.for_each(|bytes| all.extend_from_slice(bytes));
    hash_bytes(&all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> OrderTable {
        let piece = |part: [f64; 2], orders: usize| Piece {
            between: [-0.3, 0.9],
            part,
            first: -1,
            orders,
            coefficients: (0..2 * orders * JONES).map(|i| 0.1 * i as f64).collect(),
        };
        let series = |step: f64| OrderSeries {
            step,
            mirrored: step > 1.0,
            pieces: vec![piece([0.0, 0.4], 1), piece([0.4, 1.0], 2)],
        };
        OrderTable {
            wavelengths_nm: vec![400.0, 500.0],
            cos_theta: vec![1.0],
            series: vec![series(0.9), series(1.7)],
        }
    }

    #[test]
    fn a_table_comes_back_to_the_same_bits_under_its_key_only() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.orders");
        write_orders(&path, "key", &table()).unwrap();
        assert_eq!(read_orders(&path, "key").unwrap(), table());
        assert!(read_orders(&path, "other").unwrap_err().is_input());
    }

    #[test]
    fn a_damaged_table_is_refused_wherever_a_byte_changed_or_the_file_ends() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.orders");
        write_orders(&path, "key", &table()).unwrap();
        let bytes = read_bytes(&path).unwrap();
        for at in (0..bytes.len()).step_by(7) {
            let mut changed = bytes.clone();
            changed[at] ^= 0x10;
            assert!(decode(&changed).is_none_or(|(key, found)| key == "key" && found == table()), "{at}");
            assert!(decode(&bytes[..at]).is_none(), "{at}");
        }
    }
}
