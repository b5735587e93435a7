//! The response of one stack at many wavelengths and angles.

use rayon::prelude::*;

use super::{FilmResponse, Polarization, response_at};
use crate::progress::{Progress, Unobserved};
use crate::spectrum::Wavelengths;
use crate::stack::Stack;
use crate::{Complex64, Error, Result};

/// What becomes of plane waves of unit power at each angle and wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// The wavelengths.
    pub at: Wavelengths,
    /// The angles in rad.
    pub angle: Vec<f64>,
    /// s, then p.
    pub polarization: [FilmTables; 2],
}

/// Numbers of one polarization. Shape: `[angle, wavelength]`, row-major.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FilmTables {
    /// Reflected over incident amplitude (s: of E, p: of H̃).
    pub r: Vec<Complex64>,
    /// Transmitted over incident amplitude.
    pub t: Vec<Complex64>,
    /// The reflected part of the power.
    pub reflected: Vec<f64>,
    /// The part that enters the exit medium.
    pub transmitted: Vec<f64>,
    /// The part absorbed in the layers.
    pub absorbed: Vec<f64>,
    /// The part absorbed in each layer. Shape: `[layer, angle, wavelength]`, row-major.
    pub absorbed_per_layer: Vec<f64>,
}

/// Bytes that a sweep takes, for a check before it starts.
#[must_use]
pub fn bytes(layers: usize, wavelengths: usize, angles: usize) -> u64 {
    // Twice: the points as they are computed, and the tables; two polarizations of 7 numbers and one per layer.
    let numbers = (layers as u64 + 7).saturating_mul(4);
    numbers.saturating_mul(8).saturating_mul(wavelengths as u64).saturating_mul(angles as u64)
}

/// The response at every wavelength and angle (rad), in parallel over wavelengths; a stack whose thicknesses spread has its mean
/// ones.
///
/// # Errors
/// As [`super::response`], or the user cancelled.
pub fn sweep(stack: &Stack, at: &Wavelengths, angle: &[f64], progress: &dyn Progress) -> Result<Sweep> {
    progress.begin("film", at.len() as u64);
    compute(stack, at, angle, progress)
}

/// As [`sweep`], as a part of the work that `progress` watches.
pub(super) fn compute(
    stack: &Stack,
    at: &Wavelengths,
    angle: &[f64],
    progress: &dyn Progress,
) -> Result<Sweep> {
    let columns: Vec<Vec<[FilmResponse; 2]>> =
        at.par_iter().map(|&nm| column(stack, nm, angle, progress)).collect::<Result<_>>()?;
    let tables = |which: usize| {
        let points = || (0..angle.len()).flat_map(|a| columns.iter().map(move |column| &column[a][which]));
        let layers = stack.layers();
        FilmTables {
            r: points().map(|p| p.r).collect(),
            t: points().map(|p| p.t).collect(),
            reflected: points().map(|p| p.reflected).collect(),
            transmitted: points().map(|p| p.transmitted).collect(),
            absorbed: points().map(|p| p.absorbed).collect(),
            absorbed_per_layer: (0..layers)
                .flat_map(|l| points().map(move |p| p.absorbed_per_layer[l]))
                .collect(),
        }
    };
    let polarization = [tables(0), tables(1)];
    Ok(Sweep { at: at.clone(), angle: angle.to_vec(), polarization })
}

/// All angles at one wavelength.
fn column(stack: &Stack, nm: f64, angle: &[f64], progress: &dyn Progress) -> Result<Vec<[FilmResponse; 2]>> {
    let indices = stack.indices(nm)?;
    let mut points = Vec::with_capacity(angle.len());
    for &angle in angle {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        let at = |polarization| response_at(&indices, stack.thickness_nm(), nm, angle, polarization);
        points.push([at(Polarization::S)?, at(Polarization::P)?]);
    }
    progress.advance(1);
    Ok(points)
}

/// Fewer wavelengths are some that are asked for, and no curve.
const FEWEST_OF_A_CURVE: usize = 10;
/// Steps whose middles are looked at, at most.
const MOST_MIDDLES: usize = 400;
/// What the middles of steps may be off the straight line between their ends, as a part of how the curve varies: a sine of four samples
/// a period is off by 0.29 of it.
const MOST_BENT: f64 = 0.29;
/// Less is not seen in any plot.
const LEAST_BENT: f64 = 1e-3;

impl Sweep {
    /// What is doubtful about the wavelengths, in one sentence: they stand so far apart that fringes of thick layers lie between them.
    /// Found by what the stack reflects halfway between them at the steepest of the angles.
    #[must_use]
    pub fn doubt(&self, stack: &Stack) -> Option<String> {
        let nm = self.at.nm();
        let steepest =
            (0..self.angle.len()).min_by(|&a, &b| self.angle[a].abs().total_cmp(&self.angle[b].abs()));
        let (Some(row), FEWEST_OF_A_CURVE..) = (steepest, nm.len()) else { return None };
        let reflected = &self.unpolarized()[row * nm.len()..][..nm.len()];
        let every = nm.len().div_ceil(MOST_MIDDLES);
        // Where a medium ends between two wavelengths there is nothing to hold them against.
        let off = |step: usize| -> Option<f64> {
            let nm = 0.5 * (nm[step] + nm[step + 1]);
            let middle = column(stack, nm, &self.angle[row..=row], &Unobserved).ok()?;
            let found: f64 = middle.iter().flatten().map(|one| 0.5 * one.reflected).sum();
            Some(found - 0.5 * (reflected[step] + reflected[step + 1]))
        };
        let off: Vec<f64> = (0..nm.len() - 1).step_by(every).filter_map(off).collect();
        if off.is_empty() {
            return None;
        }
        let square = |values: &[f64], mean: f64| {
            values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64
        };
        let mean = reflected.iter().sum::<f64>() / reflected.len() as f64;
        let (bent, varied) = (square(&off, 0.0).sqrt(), square(reflected, mean).sqrt());
        if bent < LEAST_BENT.max(MOST_BENT * varied) {
            return None;
        }
        let widest = nm.array_windows().map(|[a, b]| b - a).fold(0.0, f64::max);
        Some(format!(
            "what the stack reflects rises and falls between wavelengths {} nm apart: fringes are missed, and peaks and colours that are read from these are not the stack's; take finer steps",
            // Differences of decimal fractions need not be one.
            (widest * 1e6).round() / 1e6
        ))
    }

    /// The reflectance of unpolarized light, shape `[angle, wavelength]`.
    #[must_use]
    pub fn unpolarized(&self) -> Vec<f64> {
        let [s, p] = &self.polarization;
        s.reflected.iter().zip(&p.reflected).map(|(s, p)| (s + p) / 2.0).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::response;
    use crate::material::Library;

    #[test]
    fn a_sweep_holds_the_single_responses_in_order() {
        let stack = Stack::parse("air/melanin:99/keratin:100/air", &Library::builtin()).unwrap();
        let at = Wavelengths::new([400.0, 500.0, 600.0]).unwrap();
        let angle = [0.0, 0.5];
        let found = sweep(&stack, &at, &angle, &Unobserved).unwrap();
        let one = response(&stack, 600.0, 0.5, Polarization::P).unwrap();
        let tables = &found.polarization[1];
        assert_eq!((tables.r[5], tables.transmitted[5]), (one.r, one.transmitted));
        // layer 1 of 2, angle 1 of 2, wavelength 2 of 3
        assert_eq!(tables.absorbed_per_layer[(2 + 1) * 3 + 2], one.absorbed_per_layer[1]);
        assert_eq!(found.unpolarized().len(), 6);
    }

    /// Fringes of 10 µm of keratin are 5 nm wide at 400 nm and 15 nm at 700; those of an ideal mirror are as wide as its band.
    #[test]
    fn steps_over_fringes_are_doubted() {
        let doubt = |text: &str, step: f64, angle: &[f64]| {
            let stack = Stack::parse(text, &Library::builtin()).unwrap();
            let nm: Vec<f64> = (0..=(300.0 / step) as u32).map(|k| 400.0 + step * f64::from(k)).collect();
            let at = Wavelengths::new(nm).unwrap();
            sweep(&stack, &at, angle, &Unobserved).unwrap().doubt(&stack)
        };
        let said = doubt("air/keratin:10000/air", 6.0, &[1.0, 0.0]).unwrap();
        assert!(said.contains("between wavelengths 6 nm apart"), "{said}");
        assert_eq!(doubt("air/keratin:10000/air", 1.0, &[0.0]), None);
        for usual in [
            "air/keratin:1500/air",
            "air/6*(melanin:99/keratin:100)/keratin",
            "air/keratin:10000/keratin",
            "air/air",
        ] {
            assert_eq!(doubt(usual, 6.0, &[0.0]), None, "{usual}");
        }
        assert_eq!(doubt("air/keratin:10000/air", 50.0, &[0.0]), None, "seven wavelengths are no curve");
    }
}
