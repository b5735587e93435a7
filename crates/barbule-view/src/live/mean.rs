//! Means over individuals: a first colour from few individuals and wavelengths, then more of both until all are there.

use barbule::Result;
use barbule::campaign::spectrum::{Collect, SpectrumRequest, spectra};
use barbule::progress::Progress;
use barbule::spectrum::Wavelengths;
use barbule::structure::Structure;

use super::Curves;

/// What is computed before everything is: of so many individuals at every so many-th wavelength. Each is a small part of the next, so that
/// all of them together take little of the whole.
const EARLY: [(usize, usize); 3] = [(2, 5), (4, 2), (12, 1)];

/// The mean reflectance of a structure.
#[derive(Debug, Clone)]
pub struct MeanJob {
    /// The structure.
    pub structure: Structure,
    /// At which wavelengths.
    pub at: Wavelengths,
    /// At which angles of incidence across the barbule, rad.
    pub angle: Vec<f64>,
    /// Over how many individuals; given ones may be fewer.
    pub individuals: usize,
    /// Their seed.
    pub seed: u64,
    /// What of the reflected light is collected.
    pub collect: Collect,
}

/// A mean as far as it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct MeanFound {
    /// Mean and standard deviation, at the wavelengths so far.
    pub curves: Curves,
    /// Over so many individuals.
    pub individuals: usize,
    /// Whether it is all that was asked for.
    pub is_whole: bool,
}

impl MeanJob {
    /// How many individuals there are of those that were asked for.
    #[must_use]
    pub fn count(&self) -> usize {
        let asked = self.individuals.max(1);
        self.structure.count().map_or(asked, |given| given.min(asked))
    }

    fn request(&self, (individuals, at): (usize, &Wavelengths)) -> SpectrumRequest {
        SpectrumRequest {
            wavelengths: at.clone(),
            directions: self.angle.iter().map(|phi| (0.0, *phi)).collect(),
            instances: individuals,
            seed: self.seed,
            collect: self.collect,
            polarization: [0.5; 2],
        }
    }
}

/// What is computed one after the other: of how many individuals, and at which wavelengths; the last is all that is asked for.
///
/// # Errors
/// None of wavelengths that rise.
pub fn stages(job: &MeanJob) -> Result<Vec<(usize, Wavelengths)>> {
    let count = job.count();
    let mut stages = Vec::new();
    for (individuals, stride) in EARLY {
        // Worth its while only where it is less than half of everything.
        let at = thinned(&job.at, stride)?;
        if 2 * individuals * at.len() < count * job.at.len() {
            stages.push((individuals.min(count), at));
        }
    }
    stages.push((count, job.at.clone()));
    Ok(stages)
}

/// Every so many-th wavelength, both ends always.
fn thinned(at: &Wavelengths, stride: usize) -> Result<Wavelengths> {
    let last = at.len() - 1;
    let kept: Vec<f64> = (0..last).step_by(stride).chain([last]).map(|k| at[k]).collect();
    Wavelengths::new(kept)
}

/// Computes means, and tells each as soon as it is there.
///
/// # Errors
/// An individual cannot be made, a table does not reach a wavelength, or a stop by `progress`.
pub fn mean(job: &MeanJob, progress: &dyn Progress, found: &mut dyn FnMut(MeanFound)) -> Result<()> {
    let stages = stages(job)?;
    let last = stages.len() - 1;
    for (stage, (individuals, at)) in stages.into_iter().enumerate() {
        let made = spectra(&job.structure, &job.request((individuals, &at)), progress)?;
        let std = (individuals > 1).then(|| made.std.concat());
        let curves = Curves::new(at, job.angle.clone(), made.mean.concat(), std)?;
        found(MeanFound { curves, individuals, is_whole: stage == last });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::Unobserved;
    use barbule::progress::Shared;

    fn job(structure: Structure, individuals: usize) -> MeanJob {
        let at = Wavelengths::new((0..11).map(|k| 450.0 + 20.0 * f64::from(k)).collect::<Vec<_>>()).unwrap();
        MeanJob { structure, at, angle: vec![0.0, 0.5], individuals, seed: 1, collect: Collect::Hemisphere }
    }

    #[test]
    fn means_begin_with_few_and_end_with_the_librarys_own() {
        let job = job(Structure::builtin("starling").unwrap(), 9);
        let mut found = Vec::new();
        mean(&job, &Unobserved, &mut |one| found.push(one)).unwrap();
        assert!(found.len() > 1 && found[..found.len() - 1].iter().all(|one| !one.is_whole));
        assert!(found.windows(2).all(|pair| pair[0].individuals <= pair[1].individuals));
        let first = &found[0];
        assert_eq!((first.individuals, first.curves.at.nm()), (2, &[450.0, 550.0, 650.0][..]));
        let whole = &found[found.len() - 1];
        let own = spectra(&job.structure, &job.request((9, &job.at)), &Unobserved).unwrap();
        assert_eq!(
            (&whole.curves.reflected, whole.curves.std.as_ref()),
            (&own.mean.concat(), Some(&own.std.concat()))
        );
        assert!(whole.is_whole && whole.individuals == 9);
        // Each earlier one is that of its own individuals.
        let early = spectra(&job.structure, &job.request((2, &first.curves.at)), &Unobserved).unwrap();
        assert_eq!(first.curves.reflected, early.mean.concat());
    }

    #[test]
    fn given_individuals_are_no_more_than_there_are() {
        let flat = job(Structure::flat("air/keratin:300/air").unwrap(), 50);
        assert_eq!(flat.count(), 1);
        let stages = stages(&flat).unwrap();
        assert_eq!(stages.last().unwrap().0, 1);
        let mut found = Vec::new();
        mean(&flat, &Unobserved, &mut |one| found.push(one)).unwrap();
        assert!(found.last().unwrap().is_whole && found.last().unwrap().curves.std.is_none());
    }

    #[test]
    fn whoever_watches_stops_it() {
        let progress = Shared::default();
        progress.cancel();
        let job = job(Structure::builtin("starling").unwrap(), 9);
        assert!(mean(&job, &progress, &mut |_| panic!("nothing is found")).unwrap_err().is_interrupted());
    }
}
