//! How measurements, and the spectra that stand beside them, are described.

use barbule::io::measured::Scale;
use clap::ValueEnum;

/// Planes of incidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Plane {
    /// Angles are φ_i
    Across,
    /// Angles are θ_i
    Along,
}

/// Units of measured values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MeasuredUnit {
    /// 0 to 100
    Percent,
    /// 0 to 1
    Fraction,
}

impl From<MeasuredUnit> for Scale {
    fn from(unit: MeasuredUnit) -> Self {
        match unit {
            MeasuredUnit::Percent => Self::Percent,
            MeasuredUnit::Fraction => Self::Fraction,
        }
    }
}
