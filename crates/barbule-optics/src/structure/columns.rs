//! The layers under many rays, in slots that all rays share.

use num_complex::Complex64;

use crate::Result;
use crate::material::Material;

/// The materials that mixtures point at by number.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Palette {
    /// Materials.
    pub materials: Vec<Material>,
}

impl Palette {
    /// The refractive index of each material at a vacuum wavelength.
    ///
    /// # Errors
    /// A table of a material does not reach the wavelength.
    pub fn indices(&self, wavelength_nm: f64) -> Result<Vec<Complex64>> {
        self.materials.iter().map(|m| m.index(wavelength_nm)).collect()
    }
}

/// The permittivity of what is finer than light, from shares of the volume and the indices of materials. A field along the axis,
/// in which nothing changes, sees the mean ⟨ε⟩; a field across the axis crosses as many walls as it runs along and sees
/// √(⟨ε⟩ ⟨1/ε⟩⁻¹). This is the geometric mean of both.
fn effective(shares: &[f32], indices: &[Complex64]) -> Complex64 {
    let (mut mean, mut inverse) = (Complex64::ZERO, Complex64::ZERO);
    for (share, n) in shares.iter().zip(indices) {
        let (share, permittivity) = (f64::from(*share), n * n);
        mean += permittivity * share;
        inverse += permittivity.conj() * (share / permittivity.norm_sqr());
    }
    let across = inverse.inv();
    if mean.re > 0.0 && across.re > 0.0 {
        return root(mean * root(mean * across));
    }
    // Of metals: each root is of a number that does not gain, so that none changes the sign of the absorption.
    mean.sqrt() * (mean.sqrt() * across.sqrt()).sqrt()
}

/// The root of a number that does not gain.
fn root(of: Complex64) -> Complex64 {
    if of.re <= 0.0 {
        return of.sqrt();
    }
    // Ten times faster than by polar coordinates, and nothing cancels.
    let re = (0.5 * (of.norm_sqr().sqrt() + of.re)).sqrt();
    Complex64::new(re, 0.5 * of.im / re)
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
    /// What is finer than light: the share of the volume that each of the palette's materials has. Shape: `[ray][material]`.
    Effective(Vec<f32>),
}

impl SlotMixture {
    /// What fills it under a ray; `None`: an effective medium.
    #[must_use]
    pub fn at(&self, ray: usize) -> Option<PaletteMixture> {
        match self {
            Self::Uniform(mixture) => Some(*mixture),
            Self::Varying(row) => Some(row[ray]),
            Self::Effective(_) => None,
        }
    }

    /// Its index under a ray, given the palette's.
    #[must_use]
    pub fn index(&self, ray: usize, indices: &[Complex64]) -> Complex64 {
        match self {
            Self::Uniform(mixture) => mixture.index(indices),
            Self::Varying(row) => row[ray].index(indices),
            Self::Effective(shares) => root(effective(shares_of(shares, ray, indices.len()), indices)),
        }
    }

    /// ε − 1 under a ray, given the palette's indices.
    #[must_use]
    pub fn contrast(&self, ray: usize, indices: &[Complex64]) -> Complex64 {
        match self {
            Self::Uniform(mixture) => mixture.contrast(indices),
            Self::Varying(row) => row[ray].contrast(indices),
            Self::Effective(shares) => effective(shares_of(shares, ray, indices.len()), indices) - 1.0,
        }
    }

    /// What fills it under some of the rays, of a palette of so many `materials`.
    #[must_use]
    pub fn under(&self, rays: impl Iterator<Item = usize>, materials: usize) -> Self {
        let some = match self {
            Self::Uniform(_) => return self.clone(),
            Self::Varying(row) => Self::Varying(rays.map(|ray| row[ray]).collect()),
            Self::Effective(shares) => {
                Self::Effective(rays.flat_map(|ray| shares_of(shares, ray, materials)).copied().collect())
            }
        };
        some.simplified(materials)
    }

    /// Bytes that it takes beside itself.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Self::Uniform(_) => 0,
            Self::Varying(row) => size_of_val(&row[..]),
            Self::Effective(shares) => size_of_val(&shares[..]),
        }
    }

    /// Mixtures that are all the same are one, and so is one material under all rays, of a palette of so many `materials`.
    pub(super) fn simplified(self, materials: usize) -> Self {
        let one = match &self {
            Self::Uniform(_) => None,
            Self::Varying(row) => row.first().filter(|first| row.iter().all(|m| m == *first)).copied(),
            Self::Effective(shares) => {
                let first = shares.iter().take(materials).position(|share| *share == 1.0);
                let all = |at: &usize| shares.chunks_exact(materials).all(|shares| shares[*at] == 1.0);
                let pure = |at: usize| PaletteMixture { a: at as u16, b: at as u16, fraction: 0.0 };
                first.filter(all).map(pure)
            }
        };
        one.map_or(self, Self::Uniform)
    }
}

/// The shares under a ray.
fn shares_of(shares: &[f32], ray: usize, materials: usize) -> &[f32] {
    &shares[ray * materials..(ray + 1) * materials]
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
