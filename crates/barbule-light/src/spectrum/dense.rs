//! Spectra at every nanometre that any sensor may see, and the wavelengths of a light path: what renderers sample.

use std::sync::Arc;

/// Shortest wavelength of a [`DenseSpectrum`], nm.
pub const SHORTEST_NM: f64 = 300.0;
/// Longest wavelength of a [`DenseSpectrum`], nm.
pub const LONGEST_NM: f64 = 830.0;
/// Values of a [`DenseSpectrum`]: one per nm, both ends included.
pub const VALUES: usize = 531;

/// Wavelengths of a light path. Eight cost a feather half as much again as four, and leave half the colour noise.
pub const WAVES: usize = 8;

/// Wavelengths of one light path, nm. The first, the hero, decides directions; the others go with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lambdas {
    nm: [f64; WAVES],
    places: Places,
}

/// Where wavelengths lie in tables of one value per nm: the values before them, and how far they are on the way to the
/// next. Found once for all spectra that a path asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Places {
    /// Indices of the values before; at most [`VALUES`] − 2.
    pub below: [u32; WAVES],
    /// 0 … 1 from there to the next value.
    pub rest: [f64; WAVES],
}

impl Lambdas {
    /// Wavelengths, nm, the hero first.
    #[inline(always)]
    #[must_use]
    pub fn new(nm: [f64; WAVES]) -> Self {
        let (mut below, mut rest) = ([0; WAVES], [0.0; WAVES]);
        for k in 0..WAVES {
            let at = (nm[k] - SHORTEST_NM).clamp(0.0, (VALUES - 1) as f64);
            below[k] = (at as u32).min(VALUES as u32 - 2);
            rest[k] = at - f64::from(below[k]);
        }
        Self { nm, places: Places { below, rest } }
    }

    /// The same wavelength for all, nm.
    #[inline]
    #[must_use]
    pub fn splat(nm: f64) -> Self {
        Self::new([nm; WAVES])
    }

    /// Where they lie in tables of one value per nm.
    #[inline(always)]
    #[must_use]
    pub fn places(&self) -> &Places {
        &self.places
    }

    /// In nm, the hero first.
    #[inline]
    #[must_use]
    pub fn nm(self) -> [f64; WAVES] {
        self.nm
    }

    /// In nm and single precision, as tables of barbules are looked up.
    #[inline]
    #[must_use]
    pub fn single_nm(self) -> [f32; WAVES] {
        self.nm.map(|w| w as f32)
    }

    /// A function of the wavelength in nm at all of them.
    #[inline]
    #[must_use]
    pub fn map(self, value: impl FnMut(f64) -> f64) -> [f64; WAVES] {
        self.nm.map(value)
    }
}

/// A quantity at 300, 301 … 830 nm, linear between and held outside. A copy costs nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct DenseSpectrum {
    values: Arc<[f64; VALUES]>,
}

impl DenseSpectrum {
    /// From a function of the wavelength in nm.
    #[must_use]
    pub fn new(value: impl Fn(f64) -> f64) -> Self {
        Self { values: Arc::new(std::array::from_fn(|i| value(SHORTEST_NM + i as f64))) }
    }

    /// The values, one per nm. Length [`VALUES`].
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values[..]
    }

    /// The value at a wavelength, nm.
    #[inline]
    #[must_use]
    pub fn at(&self, wavelength_nm: f64) -> f64 {
        let at = (wavelength_nm - SHORTEST_NM).clamp(0.0, (VALUES - 1) as f64);
        let index = (at as usize).min(VALUES - 2);
        let rest = at - index as f64;
        self.values[index] + (self.values[index + 1] - self.values[index]) * rest
    }

    /// The values at the wavelengths of a path.
    #[inline(always)]
    #[must_use]
    pub fn at_each(&self, wavelengths: Lambdas) -> [f64; WAVES] {
        let Places { below, rest } = wavelengths.places;
        let (mut low, mut high) = ([0.0; WAVES], [0.0; WAVES]);
        for k in 0..WAVES {
            // The least of both is below itself; it lets the compiler see that.
            let index = (below[k] as usize).min(VALUES - 2);
            (low[k], high[k]) = (self.values[index], self.values[index + 1]);
        }
        for k in 0..WAVES {
            low[k] += (high[k] - low[k]) * rest[k];
        }
        low
    }

    /// The same spectrum times a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { values: Arc::new(self.values.map(|v| v * factor)) }
    }

    /// The product with another at each nm.
    #[must_use]
    pub fn times(&self, other: &Self) -> Self {
        Self { values: Arc::new(std::array::from_fn(|i| self.values[i] * other.values[i])) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_linear_inside_and_held_outside() {
        let spectrum = DenseSpectrum::new(|w| w);
        assert_eq!(spectrum.at(500.25), 500.25);
        assert_eq!([200.0, 900.0, 300.5, 829.5].map(|nm| spectrum.at(nm)), [300.0, 830.0, 300.5, 829.5]);
        assert_eq!(spectrum.at_each(Lambdas::splat(500.25)), [500.25; WAVES]);
        for nm in [200.0, 300.0, 300.5, 555.125, 829.5, 830.0, 900.0] {
            assert_eq!(spectrum.at_each(Lambdas::splat(nm)), [spectrum.at(nm); WAVES]);
        }
        assert_eq!(spectrum.times(&spectrum).at(400.0), 160_000.0);
        assert_eq!((spectrum.values().len(), spectrum.scaled(2.0).at(LONGEST_NM)), (VALUES, 1660.0));
    }
}
