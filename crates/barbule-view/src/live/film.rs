//! Flat layers, exactly.

use barbule::Result;
use barbule::film::{ensemble, sweep};
use barbule::progress::Progress;
use barbule::spectrum::Wavelengths;
use barbule::stack::Stack;

use super::Curves;

/// Reflectance of flat layers.
#[derive(Debug, Clone)]
pub struct FilmJob {
    /// The layers.
    pub stack: Stack,
    /// At which wavelengths.
    pub at: Wavelengths,
    /// At which angles in the first medium, rad.
    pub angle: Vec<f64>,
    /// How many random individuals, where thicknesses spread.
    pub individuals: usize,
    /// Their seed.
    pub seed: u64,
}

/// What flat layers reflect of unpolarized light; in the mean over individuals where thicknesses spread.
///
/// # Errors
/// A medium has no index at a wavelength, an angle of 90° or more, or a stop by `progress`.
pub fn film(job: &FilmJob, progress: &dyn Progress) -> Result<Curves> {
    let FilmJob { stack, at, angle, individuals, seed } = job;
    if stack.is_random() {
        let found = ensemble(stack, at, angle, (*individuals).max(1), *seed, progress)?;
        // The mean over polarizations of the means, as powers add.
        let reflected = found.mean.unpolarized();
        return Curves::new(at.clone(), angle.clone(), reflected, Some(found.unpolarized_std));
    }
    let found = sweep(stack, at, angle, progress)?;
    Curves::new(at.clone(), angle.clone(), found.unpolarized(), None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::Unobserved;
    use barbule::film::{Polarization, response};
    use barbule::material::Library;
    use barbule::progress::Shared;

    fn job(text: &str) -> FilmJob {
        FilmJob {
            stack: Stack::parse(text, &Library::builtin()).unwrap(),
            at: Wavelengths::usual(),
            angle: vec![0.0, 0.6],
            individuals: 9,
            seed: 3,
        }
    }

    #[test]
    fn films_reflect_what_single_waves_do() {
        let job = job("air/6*(melanin:99/keratin:100)/keratin");
        let curves = film(&job, &Unobserved).unwrap();
        let both = Polarization::BOTH.map(|p| response(&job.stack, job.at[7], 0.6, p).unwrap().reflected);
        assert_eq!(curves.reflected[job.at.len() + 7], (both[0] + both[1]) / 2.0);
        assert_eq!((curves.std, curves.reflected.len()), (None, 100));
    }

    #[test]
    fn spreading_films_are_means_over_their_individuals() {
        let job = job("air/keratin:300±5%/melanin");
        let curves = film(&job, &Unobserved).unwrap();
        let of = |k: usize| {
            let stack = job.stack.individual(3, k);
            Polarization::BOTH
                .map(|p| response(&stack, job.at[7], 0.6, p).unwrap().reflected)
                .iter()
                .sum::<f64>()
                / 2.0
        };
        let mean = (0..9).map(of).sum::<f64>() / 9.0;
        let std = ((0..9).map(|k| (of(k) - mean).powi(2)).sum::<f64>() / 8.0).sqrt();
        let place = job.at.len() + 7;
        assert!((curves.reflected[place] - mean).abs() < 1e-14);
        assert!((curves.std.unwrap()[place] - std).abs() < 1e-14);
    }

    #[test]
    fn what_is_no_film_or_no_longer_wanted_ends_with_its_reason() {
        let steep = FilmJob { angle: vec![1.6], ..job("air/keratin:300/air") };
        assert!(film(&steep, &Unobserved).unwrap_err().is_input());
        let progress = Shared::default();
        progress.cancel();
        assert!(film(&job("air/keratin:300/air"), &progress).unwrap_err().is_interrupted());
    }
}
