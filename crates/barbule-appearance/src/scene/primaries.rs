//! Spectra of lights that are given as colours.

use super::emission::Emission;
use crate::Result;
use crate::spectrum::dense::DenseSpectrum;
use crate::spectrum::primaries::shares;

/// Spectra of sRGB's red, green and blue: daylight (D65) times their [`shares`]. A colour's spectrum is their sum weighted with its linear R, G and B: it is
/// never negative, as bright as wanted, white is daylight itself, and the colour comes back within 3e-7.
///
/// # Errors
/// None; the tables are in range.
pub fn primaries() -> Result<[Emission; 3]> {
    let daylight = Emission::daylight();
    let [red, green, blue] = shares();
    let light = |share: &DenseSpectrum| Emission::new(|nm| daylight.at(nm) * share.at(nm));
    Ok([light(&red)?, light(&green)?, light(&blue)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::colour::{matching, rgb_from_xyz, xyz_from_rgb};
    use crate::spectrum::sensor::Band;

    /// Linear sRGB of a light whose white is daylight, from the renderer's wavelengths.
    fn colour(light: &Emission) -> [f64; 3] {
        let daylight = Emission::daylight();
        let white = xyz_from_rgb([1.0; 3]);
        let (mut sums, mut whites) = ([0.0; 3], [0.0; 3]);
        for nm in Band::HUMAN.each_nm() {
            let weight = if nm == 380.0 || nm == 720.0 { 0.5 } else { 1.0 };
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
        for nm in (300..=830).map(f64::from) {
            let sum: f64 = primaries.iter().map(|p| p.at(nm)).sum();
            assert!((sum / daylight.at(nm) - 1.0).abs() < 1e-6, "{nm}: {sum}");
        }
    }
}
