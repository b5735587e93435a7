//! The wavelengths of a path: drawn for a sensor, the hero first.
//!
//! They are stratified: one in each eighth of the distribution, the first one (the hero, which decides directions) in any of them (Wilkie
//! et al. 2014). Between the ends of 256 bins of equal probability the density is constant, so that a table of them gives
//! wavelengths and densities that belong to each other.

use super::dense::{Lambdas, WAVES};
use super::sensor::Band;

/// Slope (1/nm) and middle (nm) of the human eye's density.
const SLOPE: f64 = 0.0072;
const MIDDLE: f64 = 538.0;

/// Bins of an eighth of the distribution.
const BINS: usize = 32;
/// Bins in all.
const ALL: usize = BINS * WAVES;

/// Part of the density that is the same everywhere in the band: what a sensor hardly sees is still looked at.
const EVEN: f64 = 0.25;

/// With which density wavelengths are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct HeroDensity {
    /// Where bins begin and how wide they are, nm. Rows are places within an eighth; columns are the eighths, and again, so
    /// that any eight neighbours are the eighths in turn.
    begin: [[f64; 2 * WAVES]; BINS],
    width: [[f64; 2 * WAVES]; BINS],
}

impl HeroDensity {
    /// The human eye's, ∝ sech²(0.0072 (λ − 538)) from 380 to 720 nm, close to its sensitivity (Radziszewski et al. 2009).
    pub(super) fn of_eye() -> Self {
        let [first, last] = [Band::HUMAN.low_nm(), Band::HUMAN.high_nm()];
        // tanh(SLOPE (λ − MIDDLE)) is uniform.
        let [low, high] = [first, last].map(|nm| libm::tanh(SLOPE * (nm - MIDDLE)));
        Self::between(|bin| match bin {
            0 => first,
            ALL => last,
            bin => MIDDLE + libm::atanh(low + (high - low) * bin as f64 / ALL as f64) / SLOPE,
        })
    }

    /// A quarter even over the band, the rest in proportion to `weights`: one for each nm of the band, not negative, in sum
    /// over 0, linear between.
    pub(super) fn of_weights(band: Band, weights: &[f64]) -> Self {
        let cells = || weights.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let even = EVEN / band.width_nm();
        let share = (1.0 - EVEN) / cells().sum::<f64>();
        let density: Vec<f64> = weights.iter().map(|weight| even + share * weight).collect();
        let mut sums = vec![0.0];
        for cell in cells() {
            sums.push(sums[sums.len() - 1] + even + share * cell);
        }
        let total = sums[sums.len() - 1];
        let edges: Vec<f64> = (0..=ALL)
            .map(|bin| {
                let wanted = total * bin as f64 / ALL as f64;
                let cell = sums.partition_point(|sum| *sum <= wanted).clamp(1, sums.len() - 1) - 1;
                let (left, right) = (density[cell], density[cell + 1]);
                // The root of left x + (right − left) x²/2 = over.
                let over = wanted - sums[cell];
                let x = 2.0 * over / (left + (left * left + 2.0 * (right - left) * over).max(0.0).sqrt());
                band.low_nm() + cell as f64 + x.min(1.0)
            })
            .collect();
        Self::between(|bin| edges[bin])
    }

    /// From the 257 ends of its bins, nm.
    fn between(edge: impl Fn(usize) -> f64) -> Self {
        let of = |value: &dyn Fn(usize) -> f64| -> [[f64; 2 * WAVES]; BINS] {
            std::array::from_fn(|row| std::array::from_fn(|column| value(column % WAVES * BINS + row)))
        };
        Self { begin: of(&edge), width: of(&|bin| edge(bin + 1) - edge(bin)) }
    }

    /// Where its bins begin and how wide they are, nm.
    pub(super) fn tables(&self) -> [&[f64]; 2] {
        [self.begin.as_flattened(), self.width.as_flattened()]
    }

    /// Wavelengths from one uniform number, 0 … 1.
    #[inline(always)]
    #[must_use]
    pub fn draw(&self, u: f64) -> Hero {
        let place = u * ALL as f64;
        let bin = (place as usize).min(ALL - 1);
        let rest = place - bin as f64;
        let (row, column) = (bin % BINS, bin / BINS);
        let (mut nm, mut pdf) = ([0.0; WAVES], [0.0; WAVES]);
        let begin = &self.begin[row][column..column + WAVES];
        let width = &self.width[row][column..column + WAVES];
        for k in 0..WAVES {
            nm[k] = begin[k] + width[k] * rest;
            pdf[k] = (1.0 / ALL as f64) / width[k];
        }
        Hero { wavelengths: Lambdas::new(nm), pdf }
    }
}

/// Wavelengths, the hero first, with their densities, 1/nm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hero {
    /// The wavelengths.
    pub wavelengths: Lambdas,
    /// Densities, 1/nm.
    pub pdf: [f64; WAVES],
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each eighth once, and densities near those of the distribution.
    #[test]
    fn each_eighth_of_the_eyes_distribution_has_a_wavelength() {
        let low = libm::tanh(SLOPE * (380.0 - MIDDLE));
        let range = libm::tanh(SLOPE * (720.0 - MIDDLE)) - low;
        let density = HeroDensity::of_eye();
        for u in [0.0, 0.1, 0.49, 0.8, 1.0 - f64::EPSILON] {
            let hero = density.draw(u);
            for (k, (nm, pdf)) in hero.wavelengths.nm().iter().zip(hero.pdf).enumerate() {
                let t = libm::tanh(SLOPE * (nm - MIDDLE));
                let expected = (u + k as f64 / WAVES as f64) % 1.0;
                assert!(((t - low) / range - expected).abs() < 2e-4, "{u} {k}: {nm}");
                // Constant in its bin, while the distribution falls by up to 5 %.
                assert!((pdf * range / (SLOPE * (1.0 - t * t)) - 1.0).abs() < 0.03, "{u} {k}: {pdf}");
            }
        }
    }

    /// A bump on a band, with flat parts and a corner.
    fn bump(band: Band) -> Vec<f64> {
        band.each_nm().map(|nm| (1.0 - (nm - 350.0).abs() / 20.0).max(0.0)).collect()
    }

    #[test]
    fn means_over_the_wavelengths_are_integrals() {
        let narrow = Band::new(300, 301).unwrap();
        let ultraviolet = Band::new(300, 400).unwrap();
        for (density, band) in [
            (HeroDensity::of_eye(), Band::HUMAN),
            (HeroDensity::of_weights(ultraviolet, &bump(ultraviolet)), ultraviolet),
            (HeroDensity::of_weights(narrow, &[0.0, 1.0]), narrow),
        ] {
            // Four in each bin.
            let count = 1024;
            let (mut length, mut moment) = (0.0, 0.0);
            for i in 0..count {
                let hero = density.draw((f64::from(i) + 0.5) / f64::from(count));
                for (w, p) in hero.wavelengths.nm().iter().zip(hero.pdf) {
                    assert!(band.contains(*w));
                    length += 1.0 / WAVES as f64 / p / f64::from(count);
                    moment += w / WAVES as f64 / p / f64::from(count);
                }
            }
            assert!((length / band.width_nm() - 1.0).abs() < 1e-10, "{band:?}: {length}");
            let middle = 0.5 * (band.low_nm() + band.high_nm());
            assert!((moment / band.width_nm() / middle - 1.0).abs() < 1e-11, "{band:?}: {moment}");
        }
    }

    /// The density that is stated integrates to 1 and is that of what is drawn: a quarter even, the rest as the weights.
    #[test]
    fn wavelengths_are_drawn_in_proportion_to_the_weights() {
        let band = Band::new(300, 400).unwrap();
        let weights = bump(band);
        let density = HeroDensity::of_weights(band, &weights);
        let (pieces, count) = (20, 20_000);
        let mut stream = crate::math::rng::Stream::new(3, &[]);
        let mut found = vec![0.0; pieces];
        for _ in 0..count {
            let nm = density.draw(stream.unit()).wavelengths.nm()[0];
            found[((nm - 300.0) / 5.0) as usize] += 1.0;
        }
        let stated = |piece: usize| {
            let cells = weights.windows(2).skip(5 * piece).take(5).map(|pair| 0.5 * (pair[0] + pair[1]));
            0.25 * 5.0 / 100.0 + 0.75 * cells.sum::<f64>() / 20.0
        };
        assert!(((0..pieces).map(stated).sum::<f64>() - 1.0).abs() < 1e-12);
        let expected = |piece: usize| f64::from(count) * stated(piece);
        let chi2: f64 =
            found.iter().enumerate().map(|(k, n)| (n - expected(k)) * (n - expected(k)) / expected(k)).sum();
        // 19 degrees of freedom: a thousandth lies above 43.8.
        assert!(chi2 < 43.8, "{chi2}");
    }
}
