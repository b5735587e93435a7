//! CIE XYZ of what the renderer gathers: of spectra at the wavelengths of a path, and of whole ones.

use std::sync::LazyLock;

use super::wavelengths::Hero;
use crate::scene::emission::Emission;
use crate::spectrum::colour::{Illuminant, matching, xyz_from_rgb};
use crate::spectrum::dense::{SHORTEST_NM, VALUES, WAVES};

/// The colour-matching functions at the renderer's wavelengths, each scaled so that daylight (D65, 1 at 560 nm) cut to
/// 380 … 720 nm has exactly the X, Y and Z of sRGB's white; a zero fills each row to the width of a register.
static MATCHING: LazyLock<[[f64; 4]; VALUES]> = LazyLock::new(|| {
    let nm = |i: usize| SHORTEST_NM + i as f64;
    let mut table: [[f64; 4]; VALUES] = std::array::from_fn(|i| {
        let [x, y, z] = matching(nm(i));
        [x, y, z, 0.0]
    });
    let mut sums = [0.0; 3];
    for (i, row) in table.iter().enumerate() {
        let weight = if i == 0 || i + 1 == VALUES { 0.5 } else { 1.0 };
        let daylight = weight * Illuminant::D65.power(nm(i)) / Illuminant::D65.power(560.0);
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += daylight * value;
        }
    }
    let white = xyz_from_rgb([1.0; 3]);
    for row in &mut table {
        for k in 0..3 {
            row[k] *= white[k] / sums[k];
        }
    }
    table
});

/// Of a spectrum at the wavelengths of a path, over their densities.
#[inline(always)]
pub(super) fn xyz(over_pdf: &[f64; WAVES], hero: &Hero) -> [f64; 3] {
    let matching = &*MATCHING;
    let places = hero.wavelengths.places();
    let mut xyz = [0.0; 4];
    for (k, value) in over_pdf.iter().enumerate() {
        let index = (places.below[k] as usize).min(VALUES - 2);
        let (low, high) = (&matching[index], &matching[index + 1]);
        let share = value / WAVES as f64;
        for i in 0..4 {
            xyz[i] += share * (low[i] + (high[i] - low[i]) * places.rest[k]);
        }
    }
    [xyz[0], xyz[1], xyz[2]]
}

/// Of a light: what paths find in the mean. Both it and the colour-matching functions are linear between whole nanometres.
pub(super) fn xyz_of(light: &Emission) -> [f64; 3] {
    let values = light.spectrum().values();
    std::array::from_fn(|i| {
        let cell = |k: usize| {
            let (low, high) = (MATCHING[k][i], MATCHING[k + 1][i]);
            (values[k] * (2.0 * low + high) + values[k + 1] * (low + 2.0 * high)) / 6.0
        };
        (0..VALUES - 1).map(cell).sum()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::colour::rgb_from_xyz;

    #[test]
    fn daylight_of_radiance_1_is_white() {
        let daylight = Emission::daylight();
        let mut sum = [0.0; 3];
        let count = 4096;
        for i in 0..count {
            let hero = Hero::new((f64::from(i) + 0.5) / f64::from(count));
            let emitted = daylight.at_each(hero.wavelengths);
            let over_pdf = std::array::from_fn(|k| emitted[k] / hero.pdf[k]);
            for (sum, value) in sum.iter_mut().zip(xyz(&over_pdf, &hero)) {
                *sum += value / f64::from(count);
            }
        }
        // Quadrature of the sharp lines of D65's table: 1e-4.
        assert!(rgb_from_xyz(sum).iter().all(|v| (v - 1.0).abs() < 1e-4), "{sum:?}");
        // Both are integrals of the same two broken lines, one of them from 32768 wavelengths.
        for (whole, sum) in xyz_of(&daylight).into_iter().zip(sum) {
            assert!((whole / sum - 1.0).abs() < 1e-6, "{whole} {sum}");
        }
    }
}
