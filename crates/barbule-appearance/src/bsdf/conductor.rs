//! Rough metal: GGX microfacets, of two roughnesses, that reflect by Fresnel's formulas of a complex index.
//!
//! Light is reflected once: what a second facet would reflect again is lost, a few percent at a roughness of 0.5. Both
//! sides are the same.

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::DVec3;

use super::hit::Hit;
use super::lobes::Lobes;
use super::microfacet::{FacetRoughness, Ggx};
use super::{Bsdf, Model};
use crate::material::Table;
use crate::math::simd::{dispatch_large, level};
use crate::spectrum::dense::{DenseSpectrum, Lambdas, WAVES};
use crate::{Error, Result};

/// A rough metal. Its frame's y is the long axis of what was hit.
#[derive(Debug, Clone)]
pub struct Conductor {
    ggx: Ggx,
    n: DenseSpectrum,
    k: DenseSpectrum,
}

impl Conductor {
    /// - `roughness`: each 0.02 … 1
    /// - `index`: n and k as a function of the wavelength in nm
    ///
    /// # Errors
    /// A roughness out of range, or an index that is not finite, or has n not over 0 or k below 0.
    pub fn new(roughness: FacetRoughness, index: impl Fn(f64) -> [f64; 2]) -> Result<Self> {
        if !roughness.is_allowed() {
            let FacetRoughness { along, across } = roughness;
            return Err(Error::input(format!(
                "metal of roughness {across} across and {along} along: give 0.02 to 1 for both"
            )));
        }
        let n = DenseSpectrum::new(|w| index(w)[0]);
        let k = DenseSpectrum::new(|w| index(w)[1]);
        let sound = |spectrum: &DenseSpectrum, least: f64| {
            spectrum.values().iter().all(|v| v.is_finite() && *v >= least)
        };
        if !(sound(&n, 1e-3) && sound(&k, 0.0)) {
            return Err(Error::input(
                "a metal's index needs n of at least 0.001 and k not below 0, both finite",
            ));
        }
        Ok(Self { ggx: Ggx::new(roughness), n, k })
    }

    /// Copper of this roughness.
    ///
    /// # Errors
    /// A roughness out of range.
    pub fn copper(roughness: FacetRoughness) -> Result<Self> {
        Self::of_table(roughness, &Table::copper())
    }

    /// A metal of this roughness whose index a table has; beyond its ends n and k go on in straight lines. Between rows the value of the one
    /// below is stepped from, which differs from the table's own value by rounding: pictures are of these bits.
    ///
    /// # Errors
    /// A roughness out of range, a table of fewer than two rows, or one that goes on to an index that is none.
    pub fn of_table(roughness: FacetRoughness, table: &Table) -> Result<Self> {
        if table.wavelengths_nm().len() < 2 {
            return Err(Error::input(format!("{}: a metal needs two rows at least", table.name())));
        }
        let (nm, index) = (table.wavelengths_nm(), table.indices());
        Self::new(roughness, |w| {
            let above = nm.partition_point(|nm| *nm < w).clamp(1, nm.len() - 1);
            let (low, high) = (index[above - 1], index[above]);
            let t = (w - nm[above - 1]) / (nm[above] - nm[above - 1]);
            [low.re + (high.re - low.re) * t, low.im + (high.im - low.im) * t]
        })
    }

    /// At a hit, seen from `wo`.
    #[inline(always)]
    pub(super) fn bind(&self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'_> {
        let side = hit.side(wo);
        let lambda_o = self.ggx.lambda(side.wo);
        let (n, k) = (self.n.at_each(wavelengths), self.k.at_each(wavelengths));
        Bsdf::new(Model::Conductor(Bound { ggx: self.ggx, n, k, lambda_o }), side)
    }
}

/// Metal at the wavelengths of a path.
pub(super) struct Bound {
    ggx: Ggx,
    n: [f64; WAVES],
    k: [f64; WAVES],
    /// Smith's Λ of the viewer's direction.
    lambda_o: f64,
}

impl Bound {
    #[inline(always)]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::REFLECTION.and(Lobes::GLOSSY)
    }

    #[inline(always)]
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> ([f64; WAVES], [f64; WAVES]) {
        let h = (wi + wo).normalize();
        let visible = self.ggx.distribution(h) / (4.0 * wo.z);
        let lambda_i = self.ggx.lambda(wi);
        let share = visible / (wi.z * (1.0 + self.lambda_o + lambda_i));
        let mut f = reflectances(wi.dot(h), &self.n, &self.k);
        for value in &mut f {
            *value *= share;
        }
        (f, [visible / (1.0 + self.lambda_o); WAVES])
    }

    #[inline(always)]
    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Lobes)> {
        let h = self.ggx.visible_normal(wo, u[0], u[1]);
        let wi = 2.0 * wo.dot(h) * h - wo;
        (wi.z > 0.0).then_some((wi, self.lobes()))
    }
}

/// Unpolarized Fresnel reflectances of indices n + ik from air (Born & Wolf, *Principles of Optics*, 7th ed., §14.2):
/// with 2a² = |w| + Re w and 2b² = |w| − Re w of w = (n + ik)² − sin²θ.
#[inline(never)] // one copy for all callers, which are inlined into one function
fn reflectances(cosine: f64, n: &[f64; WAVES], k: &[f64; WAVES]) -> [f64; WAVES] {
    dispatch_large!(level(), simd => reflectances_in(simd, cosine.clamp(0.0, 1.0), n, k))
}

/// Compiled for each instruction set.
#[inline(always)]
fn reflectances_in<S: Simd>(simd: S, c: f64, n: &[f64; WAVES], k: &[f64; WAVES]) -> [f64; WAVES] {
    let all = |v: f64| f64x8::splat(simd, v);
    let (n, k) = (f64x8::from_slice(simd, n), f64x8::from_slice(simd, k));
    let c2 = c * c;
    let s2 = 1.0 - c2;
    let real = n * n - k * k - all(s2);
    let imaginary = n * k * all(2.0);
    let modulus = (real * real + imaginary * imaginary).sqrt();
    let a = ((modulus + real) * all(0.5)).max(all(0.0)).sqrt();
    let cross = a * all(2.0 * c);
    let square = modulus + all(c2);
    let s = (square - cross) / (square + cross);
    let (square, cross) = (modulus * all(c2) + all(s2 * s2), cross * all(s2));
    let p = (square - cross) / (square + cross);
    (all(0.5) * s * (all(1.0) + p)).to_array()
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;

    /// Against the amplitudes in complex numbers.
    #[test]
    fn reflectances_are_those_of_complex_amplitudes() {
        for (n, k) in [(0.22, 3.747), (1.36, 1.975), (1.5, 0.0), (0.05, 6.0)] {
            for step in 0..=50 {
                let c = f64::from(step) / 50.0;
                let index = Complex64::new(n, k);
                let t = (1.0 - (1.0 - c * c) / (index * index)).sqrt();
                let s = (c - index * t) / (c + index * t);
                let p = (index * c - t) / (index * c + t);
                let expected = 0.5 * (s.norm_sqr() + p.norm_sqr());
                let found = reflectances(c, &[n; WAVES], &[k; WAVES])[3];
                assert!((found - expected).abs() < 1e-12, "{n} {k} {c}: {found} {expected}");
            }
        }
    }

    /// Normal incidence, ((n − 1)² + k²)/((n + 1)² + k²), at nodes of the table and between them.
    #[test]
    fn copper_is_red() {
        let copper = Conductor::copper(FacetRoughness::even(0.1)).unwrap();
        let at = |w: f64| {
            let (n, k) = (copper.n.at(w), copper.k.at(w));
            ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k)
        };
        assert!(
            (at(450.0) - 0.55).abs() < 0.02 && (at(659.0) - 0.94).abs() < 0.02,
            "{} {}",
            at(450.0),
            at(659.0)
        );
        assert!((copper.n.at(533.0) - (1.18 - 0.16 * 12.1 / 27.7)).abs() < 1e-6);
    }

    #[test]
    fn impossible_metals_are_refused() {
        assert!(
            Conductor::copper(FacetRoughness { across: 0.0, along: 0.1 })
                .unwrap_err()
                .to_string()
                .contains("0.02 to 1")
        );
        assert!(Conductor::new(FacetRoughness::even(0.1), |_| [f64::NAN, 1.0]).is_err());
        assert!(Conductor::new(FacetRoughness::even(0.1), |_| [1.0, -1.0]).is_err());
    }
}
