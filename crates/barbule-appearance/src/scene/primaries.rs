//! Spectra of lights that are given as colours.

use super::emission::Emission;
use crate::Result;
use crate::spectrum::dense::SHORTEST_NM;

/// Step of the tables below, nm.
const STEP_NM: f64 = 10.0;

/// Red's share of daylight at 380, 390 … 720 nm; `scripts/sky-primaries.py` makes both.
#[rustfmt::skip]
const RED: [f64; 35] = [
    0.026_624, 0.026_616, 0.026_56, 0.026_311, 0.025_437, 0.023_079, 0.019_507, 0.018_819, 0.030_494, 0.012_404,
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.018_621, 0.208_603, 0.477_151, 0.736_784, 0.922_056, 1.0,
    1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0,
];

/// Green's; blue has the rest.
#[rustfmt::skip]
const GREEN: [f64; 35] = [
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.112_149, 0.297_488, 0.508_599, 0.714_756, 0.885_036,
    0.988_609, 1.0, 1.0, 1.0, 1.0, 0.935_072, 0.739_707, 0.488_246, 0.250_325, 0.077_944, 0.0, 0.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
];

/// Spectra of sRGB's red, green and blue: daylight (D65) times shares between 0 and 1 that sum to 1, the smoothest whose
/// colours, seen at the renderer's wavelengths, are the primaries (after Mallett & Yuksel, *Spectral Primary Decomposition
/// for Rendering with sRGB Reflectance*, EGSR 2019). A colour's spectrum is their sum weighted with its linear R, G and B: it is
/// never negative, as bright as wanted, white is daylight itself, and the colour comes back within 3e-7.
///
/// # Errors
/// None; the tables are in range.
pub fn primaries() -> Result<[Emission; 3]> {
    let daylight = Emission::daylight();
    let red = |nm: f64| between(&RED, nm);
    let green = |nm: f64| between(&GREEN, nm);
    Ok([
        Emission::new(|nm| daylight.at(nm) * red(nm))?,
        Emission::new(|nm| daylight.at(nm) * green(nm))?,
        Emission::new(|nm| daylight.at(nm) * (1.0 - red(nm) - green(nm)).max(0.0))?,
    ])
}

/// Linear between the tables' values.
fn between(table: &[f64; 35], nm: f64) -> f64 {
    let at = ((nm - SHORTEST_NM) / STEP_NM).clamp(0.0, 34.0);
    let index = (at as usize).min(33);
    table[index] + (table[index + 1] - table[index]) * (at - index as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::colour::{matching, rgb_from_xyz, xyz_from_rgb};
    use crate::spectrum::dense::{LONGEST_NM, VALUES};

    /// Linear sRGB of a light whose white is daylight, from the renderer's wavelengths.
    fn colour(light: &Emission) -> [f64; 3] {
        let daylight = Emission::daylight();
        let white = xyz_from_rgb([1.0; 3]);
        let (mut sums, mut whites) = ([0.0; 3], [0.0; 3]);
        for i in 0..VALUES {
            let nm = SHORTEST_NM + i as f64;
            let weight = if nm == SHORTEST_NM || nm == LONGEST_NM { 0.5 } else { 1.0 };
            for (k, value) in matching(nm).into_iter().enumerate() {
                sums[k] += weight * value * light.at(nm);
                whites[k] += weight * value * daylight.at(nm);
            }
        }
        rgb_from_xyz(std::array::from_fn(|k| sums[k] / whites[k] * white[k]))
    }

    #[test]
    fn colours_come_back_and_white_is_daylight() {
        let primaries = primaries().unwrap();
        let daylight = Emission::daylight();
        for (k, primary) in primaries.iter().enumerate() {
            for (j, value) in colour(primary).into_iter().enumerate() {
                let expected = if j == k { 1.0 } else { 0.0 };
                assert!((value - expected).abs() < 3e-7, "{k} {j}: {value}");
            }
        }
        for i in 0..VALUES {
            let nm = SHORTEST_NM + i as f64;
            let sum: f64 = primaries.iter().map(|p| p.at(nm)).sum();
            assert!((sum / daylight.at(nm) - 1.0).abs() < 1e-6, "{nm}: {sum}");
        }
    }
}
