//! The wavelengths of a path.
//!
//! Drawn between 380 and 720 nm with density ∝ sech²(0.0072 (λ − 538)), close to the eye's sensitivity (Radziszewski et
//! al. 2009), stratified: one in each eighth of the distribution, the first one (the hero, which decides directions)
//! in any of them (Wilkie et al. 2014). Between the ends of 256 bins of equal probability the density is constant, so that a table
//! of them gives wavelengths and densities that belong to each other.

use std::sync::LazyLock;

use crate::spectrum::dense::{LONGEST_NM, Lambdas, SHORTEST_NM, WAVES};

const SLOPE: f64 = 0.0072;
const MIDDLE: f64 = 538.0;

/// Bins of an eighth of the distribution.
const BINS: usize = 32;

/// Where bins begin and how wide they are, nm. Rows are places within an eighth; columns are the eighths, and again, so that
/// any eight neighbours are the eighths in turn.
struct Bins {
    begin: [[f64; 2 * WAVES]; BINS],
    width: [[f64; 2 * WAVES]; BINS],
}

static INVERSE: LazyLock<Bins> = LazyLock::new(|| {
    // tanh(SLOPE (λ − MIDDLE)) is uniform.
    let [low, high] = [SHORTEST_NM, LONGEST_NM].map(|nm| libm::tanh(SLOPE * (nm - MIDDLE)));
    let nm = |bin: usize| match bin {
        0 => SHORTEST_NM,
        bin if bin == BINS * WAVES => LONGEST_NM,
        bin => MIDDLE + libm::atanh(low + (high - low) * bin as f64 / (BINS * WAVES) as f64) / SLOPE,
    };
    let of = |value: &dyn Fn(usize) -> f64| -> [[f64; 2 * WAVES]; BINS] {
        std::array::from_fn(|row| std::array::from_fn(|column| value(column % WAVES * BINS + row)))
    };
    Bins { begin: of(&nm), width: of(&|bin| nm(bin + 1) - nm(bin)) }
});

/// Wavelengths, the hero first, with their densities, 1/nm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hero {
    /// The wavelengths.
    pub wavelengths: Lambdas,
    /// Densities, 1/nm.
    pub pdf: [f64; WAVES],
}

impl Hero {
    /// From one uniform number, 0 … 1.
    #[inline(always)]
    #[must_use]
    pub fn new(u: f64) -> Self {
        let bins = &*INVERSE;
        let place = u * (BINS * WAVES) as f64;
        let bin = (place as usize).min(BINS * WAVES - 1);
        let rest = place - bin as f64;
        let (row, column) = (bin % BINS, bin / BINS);
        let (mut nm, mut pdf) = ([0.0; WAVES], [0.0; WAVES]);
        let begin = &bins.begin[row][column..column + WAVES];
        let width = &bins.width[row][column..column + WAVES];
        for k in 0..WAVES {
            nm[k] = begin[k] + width[k] * rest;
            pdf[k] = (1.0 / (BINS * WAVES) as f64) / width[k];
        }
        Self { wavelengths: Lambdas::new(nm), pdf }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each eighth once, and densities near those of the distribution.
    #[test]
    fn each_eighth_of_the_distribution_has_a_wavelength() {
        let low = libm::tanh(SLOPE * (SHORTEST_NM - MIDDLE));
        let range = libm::tanh(SLOPE * (LONGEST_NM - MIDDLE)) - low;
        for u in [0.0, 0.1, 0.49, 0.8, 1.0 - f64::EPSILON] {
            let hero = Hero::new(u);
            for (k, (nm, pdf)) in hero.wavelengths.nm().iter().zip(hero.pdf).enumerate() {
                let t = libm::tanh(SLOPE * (nm - MIDDLE));
                let expected = (u + k as f64 / WAVES as f64) % 1.0;
                assert!(((t - low) / range - expected).abs() < 2e-4, "{u} {k}: {nm}");
                // Constant in its bin, while the distribution falls by up to 5 %.
                assert!((pdf * range / (SLOPE * (1.0 - t * t)) - 1.0).abs() < 0.03, "{u} {k}: {pdf}");
            }
        }
    }

    #[test]
    fn means_over_the_wavelengths_are_integrals() {
        // Four in each bin.
        let count = 1024;
        let (mut length, mut moment) = (0.0, 0.0);
        for i in 0..count {
            let hero = Hero::new((f64::from(i) + 0.5) / f64::from(count));
            for (w, p) in hero.wavelengths.nm().iter().zip(hero.pdf) {
                assert!((SHORTEST_NM..=LONGEST_NM).contains(w));
                length += 1.0 / WAVES as f64 / p / f64::from(count);
                moment += w / WAVES as f64 / p / f64::from(count);
            }
        }
        assert!((length - 340.0).abs() < 1e-9);
        assert!((moment / 340.0 - 550.0).abs() < 1e-9);
    }
}
