//! The four wavelengths of a path.
//!
//! Drawn between 380 and 720 nm with density ∝ sech²(0.0072 (λ − 538)), close to the eye's sensitivity (Radziszewski et
//! al. 2009), stratified: one in each quarter of the distribution, the first one (the hero, which decides directions)
//! in any of them (Wilkie et al. 2014).

use crate::spectrum::dense::Lambda4;

const SLOPE: f64 = 0.0072;
const MIDDLE: f64 = 538.0;

/// Four wavelengths, the hero first, with their densities, 1/nm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hero {
    /// The wavelengths.
    pub wavelengths: Lambda4,
    /// Densities, 1/nm.
    pub pdf: [f64; 4],
}

impl Hero {
    /// From one uniform number.
    #[must_use]
    pub fn new(u: f64) -> Self {
        // tanh(SLOPE (λ − MIDDLE)) is uniform, and sech² is one less its square.
        let steep = [0.0, 0.25, 0.5, 0.75].map(|shift| {
            let v = u + shift;
            LOW + (HIGH - LOW) * if v < 1.0 { v } else { v - 1.0 }
        });
        Self {
            wavelengths: Lambda4::new(steep.map(|t| MIDDLE + 0.5 / SLOPE * ((1.0 + t) / (1.0 - t)).ln())),
            pdf: steep.map(|t| SLOPE * (1.0 - t * t) / (HIGH - LOW)),
        }
    }
}

/// tanh(SLOPE (λ − MIDDLE)) at the shortest and the longest wavelength.
const LOW: f64 = -0.8136043613811508;
const HIGH: f64 = 0.8643765890672668;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::dense::{LONGEST_NM, SHORTEST_NM};

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
                length += 0.25 / p / f64::from(count);
                moment += 0.25 * w / p / f64::from(count);
            }
        }
        assert!((length - 340.0).abs() < 0.01);
        assert!((moment / 340.0 - 550.0).abs() < 0.01);
    }
}
