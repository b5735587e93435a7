//! The layers under many rays, in slots that all rays share.

use num_complex::Complex64;

use crate::material::Material;

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
}

impl SlotMixture {
    /// What fills it under a ray.
    #[must_use]
    pub fn at(&self, ray: usize) -> PaletteMixture {
        match self {
            Self::Uniform(mixture) => *mixture,
            Self::Varying(row) => row[ray],
        }
    }

    /// Varying mixtures that are all the same are one.
    pub(super) fn simplified(self) -> Self {
        match &self {
            Self::Varying(row) => match row.first() {
                Some(first) if row.iter().all(|m| m == first) => Self::Uniform(*first),
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
    /// The materials that mixtures point at.
    pub palette: Vec<Material>,
}
