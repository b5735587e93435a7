//! The wavelengths of a path.
//!
//! Drawn between 380 and 720 nm with density ∝ sech²(0.0072 (λ − 538)), close to the eye's sensitivity (Radziszewski et
//! al. 2009), stratified: one in each eighth of the distribution, the first one (the hero, which decides directions)
//! in any of them (Wilkie et al. 2014).

use fearless_simd::{Simd, dispatch, f64x8, prelude::*};

use crate::math::elementary::ln_each;
use crate::math::simd::level;
use crate::spectrum::dense::{Lambdas, WAVES};

const SLOPE: f64 = 0.0072;
const MIDDLE: f64 = 538.0;

/// Wavelengths, the hero first, with their densities, 1/nm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hero {
    /// The wavelengths.
    pub wavelengths: Lambdas,
    /// Densities, 1/nm.
    pub pdf: [f64; WAVES],
}

impl Hero {
    /// From one uniform number.
    #[inline(never)] // one copy for all callers
    #[must_use]
    pub fn new(u: f64) -> Self {
        dispatch!(level(), simd => drawn(simd, u))
    }
}

/// Compiled for each instruction set.
#[inline(always)]
fn drawn<S: Simd>(simd: S, u: f64) -> Hero {
    let all = |v: f64| f64x8::splat(simd, v);
    let one = all(1.0);
    let v = all(u) + f64x8::from_slice(simd, &STRATA);
    let v = v.simd_lt(one).select(v, v - one);
    // tanh(SLOPE (λ − MIDDLE)) is uniform, and sech² is one less its square.
    let t = all(LOW) + all(HIGH - LOW) * v;
    let nm = all(MIDDLE) + all(0.5 / SLOPE) * ln_each(simd, (one + t) / (one - t));
    let pdf = all(SLOPE / (HIGH - LOW)) * (one - t * t);
    Hero { wavelengths: Lambdas::new(nm.to_array()), pdf: pdf.to_array() }
}

/// Where each eighth of the distribution begins.
const STRATA: [f64; WAVES] = [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875];

/// tanh(SLOPE (λ − MIDDLE)) at the shortest and the longest wavelength.
const LOW: f64 = -0.8136043613811508;
const HIGH: f64 = 0.8643765890672668;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::dense::{LONGEST_NM, SHORTEST_NM, WAVES};

    #[test]
    fn the_ends_are_those_of_the_visible_range() {
        for (edge, nm) in [(LOW, SHORTEST_NM), (HIGH, LONGEST_NM)] {
            assert!((edge - (SLOPE * (nm - MIDDLE)).tanh()).abs() < 1e-15);
        }
    }

    #[test]
    fn means_over_the_wavelengths_are_integrals() {
        let count = 1000;
        let (mut length, mut moment) = (0.0, 0.0);
        for i in 0..count {
            let hero = Hero::new((f64::from(i) + 0.5) / f64::from(count));
            for (w, p) in hero.wavelengths.nm().iter().zip(hero.pdf) {
                assert!((SHORTEST_NM..=LONGEST_NM).contains(w));
                length += 1.0 / WAVES as f64 / p / f64::from(count);
                moment += w / WAVES as f64 / p / f64::from(count);
            }
        }
        assert!((length - 340.0).abs() < 0.01);
        assert!((moment / 340.0 - 550.0).abs() < 0.01);
    }
}
