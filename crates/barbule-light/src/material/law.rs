//! Formulas of indices, with the numbers of the media of feathers.

/// Cauchy's formula n = a + b/λ².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cauchy {
    /// The index at infinite wavelength.
    pub a: f64,
    /// Dispersion in nm².
    pub b_nm2: f64,
}

impl Cauchy {
    /// Feather keratin, 1.532 + 5890/λ² (Leertouwer, Wilts & Stavenga 2011).
    pub const KERATIN: Self = Self { a: 1.532, b_nm2: 5890.0 };

    /// The real part of melanin's, 1.648 + 23700/λ² (Stavenga et al. 2015).
    pub const MELANIN: Self = Self { a: 1.648, b_nm2: 23700.0 };

    /// n at a vacuum wavelength in nm.
    #[inline(always)]
    #[must_use]
    pub fn n(self, wavelength_nm: f64) -> f64 {
        self.a + self.b_nm2 / (wavelength_nm * wavelength_nm)
    }
}

/// Absorption that falls with the wavelength, k = c·exp(−λ/l).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExponentialAbsorption {
    /// k at wavelength zero.
    pub c: f64,
    /// Decay length l in nm.
    pub decay_nm: f64,
}

impl ExponentialAbsorption {
    /// Melanin's, 0.56·exp(−λ/270) (Stavenga et al. 2015).
    pub const MELANIN: Self = Self { c: 0.56, decay_nm: 270.0 };

    /// k over c at a vacuum wavelength in nm.
    #[inline]
    #[must_use]
    pub fn decay(self, wavelength_nm: f64) -> f64 {
        libm::exp(-wavelength_nm / self.decay_nm)
    }
}
