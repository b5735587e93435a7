//! One-dimensional arrays named as the dimensions, so that `xarray` finds values by their wavelength or angle.

use std::f64::consts::PI;

use crate::io::zarr::{Array, DataType};
use crate::scattering::statistics::{AZIMUTHS, Axes, GLINTS, LAGS, NOISE_POINTS};

/// A dimension's values; they follow from the attributes, and what is read back is only held against them.
pub(super) struct Coordinate {
    pub(super) array: Array,
    values: Values,
}

enum Values {
    Numbers(Vec<f64>),
    Counts(Vec<u64>),
}

impl Coordinate {
    fn new(name: &'static str, values: Values, units: &'static str, meaning: &'static str) -> Self {
        let (data_type, length) = match &values {
            Values::Numbers(numbers) => (DataType::Float64, numbers.len()),
            Values::Counts(counts) => (DataType::UInt64, counts.len()),
        };
        let array = Array {
            name,
            data_type,
            shape: vec![length],
            chunk_shape: vec![length],
            dimension_names: vec![name],
            units,
            meaning,
        };
        Self { array, values }
    }

    /// The path of its only chunk.
    pub(super) fn key(&self) -> String {
        self.array.chunk_path(&[])
    }

    /// Its only chunk.
    pub(super) fn chunk(&self) -> Vec<u8> {
        let encoded = match &self.values {
            Values::Numbers(numbers) => self.array.encode(numbers),
            Values::Counts(counts) => self.array.encode(counts),
        };
        // Type and length are the values' own.
        encoded.unwrap_or_default()
    }
}

/// Those of a store; none of fields where none are kept.
pub(super) fn coordinates(axes: &Axes, instances: usize, kept_nm: &[f64]) -> Vec<Coordinate> {
    let degrees = |count: usize, angle: &dyn Fn(usize) -> f64| {
        Values::Numbers((0..count).map(|i| angle(i).to_degrees()).collect())
    };
    let count = |from: usize, to: usize| Values::Counts((from as u64..=to as u64).collect());
    let azimuth = |n: usize| (n as f64 + 0.5) * PI / AZIMUTHS as f64 - PI / 2.0;
    let lags = (0..LAGS).map(|k| 2.0 * k as f64 / NOISE_POINTS as f64).collect();
    let nm = |values: &[f64]| Values::Numbers(values.to_vec());
    let mut all = vec![
        Coordinate::new("wavelength", nm(axes.wavelengths_nm()), "nm", "vacuum wavelength"),
        Coordinate::new(
            "theta_i",
            degrees(axes.cos_theta().len(), &|i| axes.theta_i(i)),
            "degree",
            "incident inclination along the barbule, 0 in the plane across it",
        ),
        Coordinate::new(
            "phi_i",
            degrees(axes.phis(), &|i| axes.phi_i(i)),
            "degree",
            "incident azimuth about the barbule's axis, 0 at its normal",
        ),
        Coordinate::new("polarization", count(1, 2), "", "incident polarization: E along e1, E along e2"),
        Coordinate::new("azimuth", degrees(AZIMUTHS, &azimuth), "degree", "outgoing azimuth phi_o"),
        Coordinate::new("lag", Values::Numbers(lags), "", "lag in x_o"),
        Coordinate::new(
            "glint",
            degrees(GLINTS.len(), &|i| f64::from(GLINTS[i]) * PI / AZIMUTHS as f64),
            "degree",
            "azimuth from the one nearest to the mirror direction",
        ),
        Coordinate::new("instance", count(0, instances - 1), "", "random individual"),
    ];
    if !kept_nm.is_empty() {
        all.push(Coordinate::new("kept_wavelength", nm(kept_nm), "nm", "vacuum wavelength of kept fields"));
        all.push(Coordinate::new("component", count(1, 2), "", "component of the field: along e1, along e2"));
    }
    all
}
