//! Refractive indices of media against wavelength.
//!
//! A [`Material`] gives n + jk at a vacuum wavelength in nm; a [`Library`] knows materials by name. Time runs as
//! exp(−jωt), so absorption is k > 0 and gain (k < 0) is refused. Nothing is ever extrapolated from a table.

mod expression;
mod law;
mod library;
mod metal;
mod mixture;
mod table;

pub use expression::parse;
pub use law::{Cauchy, ExponentialAbsorption};
pub use library::Library;
pub use mixture::{Mixture, Rule};
pub use table::Table;

use std::sync::Arc;

use crate::identity::{Hasher, Identify};
use crate::{Complex64, Error, Result};

/// The largest |n| or k of any medium: beyond it the formulas lose their digits.
const LARGEST_INDEX: f64 = 1e9;
/// From here on keratin's absorption is known to be negligible, nm; below it has some that nobody has tabulated, and
/// [`Material::keratin`] has none.
pub const KERATIN_CLEAR_FROM_NM: f64 = 350.0;
/// The smallest |n + jk| of any medium.
const SMALLEST_INDEX: f64 = 1e-3;

/// The refractive index of one medium as a function of the vacuum wavelength.
#[derive(Debug, Clone, PartialEq)]
pub enum Material {
    /// The same n + jk at every wavelength.
    Constant(Complex64),
    /// Cauchy's formula.
    Cauchy(Cauchy),
    /// Cauchy's formula with an exponential absorption: n = a + b/λ² + j·c·exp(−λ/l).
    AbsorbingCauchy(Cauchy, ExponentialAbsorption),
    /// A table, interpolated linearly.
    Table(Arc<Table>),
    /// Two media mixed below the scale of the wavelength.
    Mixture(Arc<Mixture>),
}

impl Material {
    /// Air, n = 1.
    #[must_use]
    pub const fn air() -> Self {
        Self::Constant(Complex64::new(1.0, 0.0))
    }

    /// Feather keratin, 1.532 + 5890/λ² (Leertouwer, Wilts & Stavenga 2011).
    #[must_use]
    pub const fn keratin() -> Self {
        Self::Cauchy(Cauchy::KERATIN)
    }

    /// Melanin, 1.648 + 23700/λ² + 0.56j·exp(−λ/270) (Stavenga et al. 2015).
    #[must_use]
    pub const fn melanin() -> Self {
        Self::AbsorbingCauchy(Cauchy::MELANIN, ExponentialAbsorption::MELANIN)
    }

    /// Copper, as [`Table::copper`] has it.
    #[must_use]
    pub fn copper() -> Self {
        Self::Table(Table::copper().into())
    }

    /// Gold, as [`Table::gold`] has it.
    #[must_use]
    pub fn gold() -> Self {
        Self::Table(Table::gold().into())
    }

    /// Silver, as [`Table::silver`] has it.
    #[must_use]
    pub fn silver() -> Self {
        Self::Table(Table::silver().into())
    }

    /// Aluminium, as [`Table::aluminium`] has it.
    #[must_use]
    pub fn aluminium() -> Self {
        Self::Table(Table::aluminium().into())
    }

    /// The same index at every wavelength.
    ///
    /// # Errors
    /// n < 0, gain (k < 0), not finite, |n + jk| below 0.001, or a part above 1e9.
    pub fn constant(index: Complex64) -> Result<Self> {
        check(index).map(Self::Constant)
    }

    /// A mixture in which `fraction` (0 to 1) of the volume is `b`.
    ///
    /// # Errors
    /// The fraction is outside 0 to 1, or mixtures are nested more than 16 deep.
    pub fn mixture(a: Self, b: Self, fraction: f64, rule: Rule) -> Result<Self> {
        Mixture::new(a, b, fraction, rule).map(|m| Self::Mixture(Arc::new(m)))
    }

    /// The same medium with n higher by `by` at every wavelength; of a mixture both media.
    ///
    /// # Errors
    /// An index that no medium has.
    pub fn with_higher_index(&self, by: f64) -> Result<Self> {
        let higher = |law: &Cauchy| Cauchy { a: law.a + by, ..*law };
        Ok(match self {
            Self::Constant(index) => return Self::constant(index + by),
            Self::Cauchy(law) => Self::Cauchy(higher(law)),
            Self::AbsorbingCauchy(law, absorption) => Self::AbsorbingCauchy(higher(law), *absorption),
            Self::Table(table) => {
                let rows: Vec<(f64, Complex64)> =
                    table.wavelength_nm.iter().copied().zip(table.index.iter().map(|n| n + by)).collect();
                Self::Table(Table::new(table.name(), &rows)?.into())
            }
            Self::Mixture(mixture) => Self::Mixture(Arc::new(mixture.with_higher_index(by)?)),
        })
    }

    /// The refractive index n + jk at a vacuum wavelength in nm.
    ///
    /// # Errors
    /// The wavelength is not positive, is outside a table, or the medium has gain there.
    pub fn index(&self, wavelength_nm: f64) -> Result<Complex64> {
        if !(wavelength_nm > 0.0 && wavelength_nm.is_finite()) {
            return Err(Error::input(format!("the wavelength {wavelength_nm} nm is not greater than zero")));
        }
        let index = match self {
            Self::Constant(index) => *index,
            Self::Cauchy(law) => law.n(wavelength_nm).into(),
            Self::AbsorbingCauchy(law, absorption) => {
                Complex64::new(law.n(wavelength_nm), absorption.c * absorption.decay(wavelength_nm))
            }
            Self::Table(table) => table.index(wavelength_nm)?,
            Self::Mixture(mixture) => mixture.index(wavelength_nm)?,
        };
        check(index)
    }

    /// Whether the index is the same at every wavelength.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        match self {
            Self::Constant(_) => true,
            Self::Mixture(mixture) => mixture.is_constant(),
            _ => false,
        }
    }
}

impl Identify for Material {
    fn feed(&self, to: &mut Hasher) {
        match self {
            Self::Constant(Complex64 { re, im }) => to.numbers("constant", &[*re, *im]),
            Self::Cauchy(Cauchy { a, b_nm2 }) => to.numbers("cauchy", &[*a, *b_nm2]),
            Self::AbsorbingCauchy(Cauchy { a, b_nm2 }, ExponentialAbsorption { c, decay_nm }) => {
                to.numbers("absorbing cauchy", &[*a, *b_nm2, *c, *decay_nm])
            }
            Self::Table(table) => to.part("table", &**table),
            Self::Mixture(mixture) => to.part("mixture", &**mixture),
        };
    }
}

/// An index that the solvers can use.
fn check(index: Complex64) -> Result<Complex64> {
    if index.im < 0.0 {
        return Err(Error::input(format!(
            "the index {} has gain, k = {}; absorbing media have k > 0 here",
            show(index),
            index.im
        )));
    }
    let usable = index.re >= 0.0 && index.re <= LARGEST_INDEX && index.im <= LARGEST_INDEX;
    if !(usable && index.norm() >= SMALLEST_INDEX) {
        return Err(Error::input(format!(
            "the index {} is not usable; n and k must be from 0 to {LARGEST_INDEX} and not both near 0",
            show(index)
        )));
    }
    Ok(index)
}

/// An index as people write it, `1.56+0.02j`.
fn show(index: Complex64) -> String {
    format!("{}{:+}j", index.re, index.im)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_media_follow_their_formulas() {
        let at = |m: Material| m.index(500.0).unwrap();
        assert_eq!(at(Material::air()), Complex64::new(1.0, 0.0));
        assert!((at(Material::keratin()).re - (1.532 + 5890.0 / 250_000.0)).abs() < 1e-15);
        let melanin = at(Material::melanin());
        assert!((melanin.re - (1.648 + 0.0948)).abs() < 1e-15);
        assert!((melanin.im - 0.56 * (-500.0_f64 / 270.0).exp()).abs() < 1e-15);
    }

    #[test]
    fn gain_and_unusable_indices_are_refused() {
        let refused = |re, im| Material::constant(Complex64::new(re, im)).unwrap_err().to_string();
        assert!(refused(1.5, -0.1).contains("gain"));
        for (re, im) in [(-1.0, 0.0), (0.0, 0.0), (f64::NAN, 0.0), (1.0, f64::INFINITY), (2e9, 0.0)] {
            assert!(refused(re, im).contains("not usable"), "{re} {im}");
        }
        assert!(Material::constant(Complex64::new(0.05, 3.0)).is_ok(), "a metal is a medium");
    }

    #[test]
    fn wavelengths_that_are_not_positive_are_refused() {
        for bad in [0.0, -500.0, f64::NAN, f64::INFINITY] {
            assert!(Material::air().index(bad).unwrap_err().is_input(), "{bad}");
        }
    }
}
