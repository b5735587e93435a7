//! Films whose thicknesses spread: the mean and the spread over random individuals.

use super::sweep::{FilmTables, Sweep, compute};
use crate::progress::Progress;
use crate::spectrum::Wavelengths;
use crate::stack::Stack;
use crate::{Complex64, Result};

/// What becomes of plane waves at random individuals of a stack.
#[derive(Debug, Clone, PartialEq)]
pub struct Ensemble {
    /// Means over the individuals; those of amplitudes are of complex numbers, so |r|² is at most the reflected part.
    pub mean: Sweep,
    /// Standard deviations of s, then of p.
    pub std: [Deviations; 2],
    /// Standard deviation of the reflectance of unpolarized light. Shape: `[angle, wavelength]`, row-major.
    pub unpolarized_std: Vec<f64>,
    /// How many individuals.
    pub individuals: usize,
}

/// Standard deviations between individuals; 0 for one. Shape: `[angle, wavelength]`, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviations {
    /// Of the reflected part of the power.
    pub reflected: Vec<f64>,
    /// Of the transmitted part.
    pub transmitted: Vec<f64>,
    /// Of the part absorbed in the layers.
    pub absorbed: Vec<f64>,
}

/// The response of individuals 0 … `individuals` − 1 of a stack at every wavelength and angle (rad).
///
/// # Errors
/// As [`super::sweep`].
pub fn ensemble(
    stack: &Stack,
    at: &Wavelengths,
    angle: &[f64],
    individuals: usize,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Ensemble> {
    progress.begin("film", (at.len() * individuals) as u64);
    let mut mean = compute(&stack.individual(seed, 0), at, angle, progress)?;
    let mut unpolarized = Moments::of(&mean.unpolarized());
    let mut moments: [[Moments; 3]; 2] = [0, 1].map(|p| powers(&mean.polarization[p]).map(Moments::of));
    for index in 1..individuals {
        let found = compute(&stack.individual(seed, index), at, angle, progress)?;
        let weight = 1.0 / (index + 1) as f64;
        unpolarized.add(&found.unpolarized(), weight);
        for (p, (mean, found)) in mean.polarization.iter_mut().zip(&found.polarization).enumerate() {
            for (moments, values) in moments[p].iter_mut().zip(powers(found)) {
                moments.add(values, weight);
            }
            let approach = |mean: &mut [Complex64], found: &[Complex64]| {
                mean.iter_mut().zip(found).for_each(|(mean, value)| *mean += (value - *mean) * weight);
            };
            approach(&mut mean.r, &found.r);
            approach(&mut mean.t, &found.t);
            let layers = mean.absorbed_per_layer.iter_mut().zip(&found.absorbed_per_layer);
            layers.for_each(|(mean, value)| *mean += (value - *mean) * weight);
        }
    }
    for (tables, [reflected, transmitted, absorbed]) in mean.polarization.iter_mut().zip(&moments) {
        tables.reflected.clone_from(&reflected.mean);
        tables.transmitted.clone_from(&transmitted.mean);
        tables.absorbed.clone_from(&absorbed.mean);
    }
    let std = moments.map(|moments| {
        let [reflected, transmitted, absorbed] = moments.map(|of| of.deviation(individuals));
        Deviations { reflected, transmitted, absorbed }
    });
    Ok(Ensemble { mean, std, unpolarized_std: unpolarized.deviation(individuals), individuals })
}

fn powers(tables: &FilmTables) -> [&[f64]; 3] {
    [&tables.reflected, &tables.transmitted, &tables.absorbed]
}

/// Running means and sums of squared deviations (Welford 1962).
#[derive(Debug, Clone)]
struct Moments {
    mean: Vec<f64>,
    squares: Vec<f64>,
}

impl Moments {
    fn of(values: &[f64]) -> Self {
        Self { mean: values.to_vec(), squares: vec![0.0; values.len()] }
    }

    /// Adds the next values, which have this weight in the new mean.
    fn add(&mut self, values: &[f64], weight: f64) {
        for ((mean, square), value) in self.mean.iter_mut().zip(&mut self.squares).zip(values) {
            let apart = value - *mean;
            *mean += apart * weight;
            *square += apart * (value - *mean);
        }
    }

    /// The standard deviation of a sample of so many.
    fn deviation(&self, count: usize) -> Vec<f64> {
        let count = count.saturating_sub(1).max(1) as f64;
        self.squares.iter().map(|square| (square / count).sqrt()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Polarization, response, sweep};
    use crate::material::Library;
    use crate::progress::Unobserved;

    fn stack(text: &str) -> Stack {
        Stack::parse(text, &Library::builtin()).unwrap()
    }

    #[test]
    fn means_and_deviations_are_those_of_the_individuals() {
        let stack = stack("air/keratin:200±10%/melanin:90±5%/air");
        let at = Wavelengths::new([450.0, 600.0]).unwrap();
        let found = ensemble(&stack, &at, &[0.0, 0.7], 9, 5, &Unobserved).unwrap();
        // Angle 1 of 2, wavelength 0 of 2.
        let one = |k| response(&stack.individual(5, k), 450.0, 0.7, Polarization::P).unwrap();
        let all: Vec<_> = (0..9).map(one).collect();
        let mean = all.iter().map(|r| r.absorbed).sum::<f64>() / 9.0;
        let square = all.iter().map(|r| (r.absorbed - mean).powi(2)).sum::<f64>() / 8.0;
        let p = &found.mean.polarization[1];
        assert!((p.absorbed[2] - mean).abs() < 1e-15);
        assert!((found.std[1].absorbed[2] - square.sqrt()).abs() < 1e-15);
        let r = all.iter().map(|r| r.r).sum::<Complex64>() / 9.0;
        assert!((p.r[2] - r).norm() < 1e-15 && p.r[2].norm_sqr() <= p.reflected[2]);
        let layer = all.iter().map(|r| r.absorbed_per_layer[1]).sum::<f64>() / 9.0;
        assert!((p.absorbed_per_layer[4 + 2] - layer).abs() < 1e-15);
        assert!((p.reflected[2] + p.transmitted[2] + p.absorbed[2] - 1.0).abs() < 1e-14);
    }

    /// To second order in a small spread σ: ⟨R⟩ = R + σ²R″/2, and the deviation is σ|R′|.
    #[test]
    fn a_small_spread_acts_as_the_derivatives_say() {
        let (thick, sigma) = (200.0, 2.0);
        let at = Wavelengths::new([480.0]).unwrap();
        let reflected = |nm: f64| {
            let found = sweep(&stack(&format!("air/keratin:{nm}/melanin")), &at, &[0.0], &Unobserved);
            found.unwrap().polarization[0].reflected[0]
        };
        let found = ensemble(
            &stack(&format!("air/keratin:{thick}±{sigma}/melanin")),
            &at,
            &[0.0],
            4000,
            1,
            &Unobserved,
        );
        let found = found.unwrap();
        let [below, middle, above] = [-1.0, 0.0, 1.0].map(|by| reflected(thick + by));
        let (slope, bend) = (0.5 * (above - below), above - 2.0 * middle + below);
        let std = found.std[0].reflected[0];
        // The sample's deviation is known to 1.1 %, and clipping takes off 1.3 %.
        assert!((std / (sigma * slope.abs()) - 1.0).abs() < 0.05, "{std} {slope}");
        // The mean's standard error is 1.6 % of the deviation.
        let expected = middle + 0.5 * sigma * sigma * bend;
        assert!((found.mean.polarization[0].reflected[0] - expected).abs() < 0.06 * std);
        assert!((found.unpolarized_std[0] - std).abs() < 1e-12);
    }

    #[test]
    fn one_individual_has_no_deviation() {
        let at = Wavelengths::new([480.0]).unwrap();
        let found = ensemble(&stack("air/keratin:200±5%/air"), &at, &[0.3], 1, 1, &Unobserved).unwrap();
        let one = sweep(&stack("air/keratin:200±5%/air").individual(1, 0), &at, &[0.3], &Unobserved);
        assert_eq!(found.mean, one.unwrap());
        assert_eq!(found.std[0].reflected, [0.0]);
    }
}
