//! The layers under many rays, in slots that all rays share.

use std::collections::BTreeMap;

use num_complex::Complex64;

use crate::material::Material;
use crate::{Error, Result};

/// Parts into which the volume of an effective medium is divided.
pub(super) const SHARES: u8 = 128;

/// The media that mixtures point at by number: materials, then what is finer than light of them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Palette {
    /// Materials.
    pub materials: Vec<Material>,
    /// Effective media, numbered after the materials: the share of each material in [`SHARES`]ths of the volume.
    effective: Vec<Vec<u8>>,
    known: BTreeMap<Vec<u8>, u16>,
}

impl Palette {
    /// Of materials alone.
    pub(super) fn of(materials: Vec<Material>) -> Self {
        Self { materials, ..Self::default() }
    }

    /// The number of a medium with these shares of the materials: of a material where it is all.
    ///
    /// # Errors
    /// There are over 65,535 media.
    pub(super) fn entry(&mut self, shares: &[u8]) -> Result<u16> {
        if let Some(at) = shares.iter().position(|share| *share == SHARES) {
            return Ok(at as u16);
        }
        if let Some(at) = self.known.get(shares) {
            return Ok(*at);
        }
        let at = u16::try_from(self.materials.len() + self.effective.len()).map_err(|_| {
            Error::input("averages along the top have over 65535 different media; turn them off".to_owned())
        })?;
        self.effective.push(shares.to_vec());
        self.known.insert(shares.to_vec(), at);
        Ok(at)
    }

    /// The refractive index of each medium at a vacuum wavelength.
    ///
    /// # Errors
    /// A table of a material does not reach the wavelength.
    pub fn indices(&self, wavelength_nm: f64) -> Result<Vec<Complex64>> {
        let mut indices =
            self.materials.iter().map(|m| m.index(wavelength_nm)).collect::<Result<Vec<_>>>()?;
        let permittivities: Vec<Complex64> = indices.iter().map(|n| n * n).collect();
        indices.extend(self.effective.iter().map(|shares| effective_index(shares, &permittivities)));
        Ok(indices)
    }
}

/// The index of what is finer than light. A field along the axis, in which nothing changes, sees the mean ⟨ε⟩; a field across the
/// axis crosses as many walls as it runs along and sees √(⟨ε⟩ ⟨1/ε⟩⁻¹). The index is that of the geometric mean of both.
///
/// Each root is of a number that does not gain, so that none changes the sign of the absorption.
fn effective_index(shares: &[u8], permittivities: &[Complex64]) -> Complex64 {
    let parts =
        || shares.iter().zip(permittivities).map(|(share, e)| (f64::from(*share) / f64::from(SHARES), e));
    let mean: Complex64 = parts().map(|(part, e)| e * part).sum();
    let inverse: Complex64 = parts().map(|(part, e)| e.inv() * part).sum();
    let across = mean.sqrt() * inverse.inv().sqrt();
    (mean.sqrt() * across.sqrt()).sqrt()
}

/// A medium made of up to two of a palette: index (1−f)·n_a + f·n_b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaletteMixture {
    /// Palette entry where the fraction is 0.
    pub a: u16,
    /// Palette entry where the fraction is 1; equal to `a` in a pure medium.
    pub b: u16,
    /// The fraction of b, 0 to 1; 0 in a pure medium.
    pub fraction: f64,
}

impl PaletteMixture {
    /// Its index, given the palette's.
    pub fn index(&self, indices: &[Complex64]) -> Complex64 {
        let (a, b) = (indices[usize::from(self.a)], indices[usize::from(self.b)]);
        a * (1.0 - self.fraction) + b * self.fraction
    }

    /// ε − 1, given the palette's indices.
    pub fn contrast(&self, indices: &[Complex64]) -> Complex64 {
        let (a, b) = (indices[usize::from(self.a)], indices[usize::from(self.b)]);
        let n = a + (b - a) * self.fraction;
        (n - 1.0) * (n + 1.0)
    }
}

/// What fills a slot: one mixture under all rays, or one under each.
#[derive(Debug, Clone, PartialEq)]
pub enum SlotMixture {
    /// The same everywhere.
    Uniform(PaletteMixture),
    /// Shape: `[ray]`.
    Varying(Vec<PaletteMixture>),
    /// The entry of the palette under each ray, pure.
    Entries(Vec<u16>),
}

impl SlotMixture {
    /// What fills it under a ray.
    #[must_use]
    pub fn at(&self, ray: usize) -> PaletteMixture {
        match self {
            Self::Uniform(mixture) => *mixture,
            Self::Varying(row) => row[ray],
            Self::Entries(row) => PaletteMixture { a: row[ray], b: row[ray], fraction: 0.0 },
        }
    }

    /// Varying mixtures that are all the same are one.
    pub(super) fn simplified(self) -> Self {
        match &self {
            Self::Varying(row) => match row.first() {
                Some(first) if row.iter().all(|m| m == first) => Self::Uniform(*first),
                _ => self,
            },
            Self::Entries(row) => match row.first() {
                Some(first) if row.iter().all(|m| m == first) => {
                    Self::Uniform(PaletteMixture { a: *first, b: *first, fraction: 0.0 })
                }
                _ => self,
            },
            Self::Uniform(_) => self,
        }
    }
}

/// The layers below each ray, in slots that all rays share.
///
/// Slots are filled so that each holds one kind of medium (or one kind of mixture) over all rays; the last is the
/// substrate. A ray that lacks a slot's layer has thickness 0 there.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    /// Number of rays.
    pub rays: usize,
    /// Number of slots: layers from the top down, then the substrate.
    pub slots: usize,
    /// Shape: `[slot][ray]`; 0 for the substrate and where a ray has no such layer.
    pub thickness_um: Vec<f64>,
    /// Shape: `[slot]`.
    pub mixture: Vec<SlotMixture>,
    /// The media that mixtures point at.
    pub palette: Palette,
}
