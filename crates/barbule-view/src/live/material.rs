//! The material of a structure: the one that is there, or else a coarse one soon and the whole one when asked for.

use std::sync::Arc;

use barbule::Result;
use barbule::brdf::fit::FitOptions;
use barbule::characterize::{
    CampaignOptions, Catalog, Execution, Found, Origin, Plan, as_filed, characterize,
};
use barbule::open::{Located, Opening, made, material_of};
use barbule::progress::Progress;
use barbule::structure::Structure;

/// Every so many-th wavelength and direction of a coarse material.
const THIN: usize = 5;

/// The material of a structure.
#[derive(Debug, Clone)]
pub struct MaterialJob {
    /// The structure.
    pub structure: Structure,
    /// Media, cache and seed.
    pub opening: Opening,
    /// Whether the whole material is made, which takes minutes; else a coarse one.
    pub whole: bool,
}

/// A material.
#[derive(Debug, Clone)]
pub struct MaterialFound {
    /// The material, and where it is.
    pub found: Arc<Found>,
    /// Of a coarse one, of which every so many-th wavelength and direction was simulated.
    pub thinned: Option<usize>,
}

impl MaterialJob {
    fn plan(&self, thin: Option<usize>) -> Result<Plan> {
        let options = CampaignOptions { seed: self.opening.seed, thin, ..CampaignOptions::default() };
        options.plan(self.structure.clone())
    }
}

/// Seconds that the coarse and the whole material take on so many cores that do nothing else, roughly; nothing where it is there.
///
/// # Errors
/// A shipped file is damaged.
pub fn expected_seconds(job: &MaterialJob, cores: usize) -> Result<Option<[f64; 2]>> {
    match material_of(job.structure.clone(), &job.opening)? {
        Located::There(_) => Ok(None),
        Located::Missing(plan) => Ok(Some([job.plan(Some(THIN))?.seconds(cores), plan.seconds(cores)])),
    }
}

/// Finds or makes the material, and tells what is there as soon as it is: what ships or is in the cache at once, else a coarse one
/// and, where it is asked for, the whole one, which is kept in the cache. Where nothing may be computed, what is missing stays so.
///
/// # Errors
/// As [`characterize`], or a stop by `progress`.
pub fn material(
    job: &MaterialJob,
    progress: &dyn Progress,
    found: &mut dyn FnMut(MaterialFound),
) -> Result<()> {
    let plan = match material_of(job.structure.clone(), &job.opening)? {
        Located::There(there) => {
            found(MaterialFound { found: Arc::new(*there), thinned: None });
            return Ok(());
        }
        // Whoever may compute nothing only asked whether it is there.
        Located::Missing(_) if !job.opening.may_compute => return Ok(()),
        Located::Missing(plan) => plan,
    };
    found(MaterialFound { found: Arc::new(coarse(job, progress)?), thinned: Some(THIN) });
    if job.whole {
        let whole = made(&plan, &job.opening, progress)?;
        found(MaterialFound { found: Arc::new(whole), thinned: None });
    }
    Ok(())
}

fn coarse(job: &MaterialJob, progress: &dyn Progress) -> Result<Found> {
    let plan = job.plan(Some(THIN))?;
    let how = Execution { resources: job.opening.resources, ..Execution::default() };
    // Its crystal's orders are not those of the whole one, so they are not kept.
    let made = characterize(&plan, &FitOptions::default(), &Catalog::default(), &how, progress)?;
    let (material, hash) = as_filed(&made.material)?;
    Ok(Found { material, hash, origin: Origin::Memory })
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::Unobserved;
    use barbule::characterize::thinned;
    use barbule::progress::Shared;

    fn job(structure: &str) -> MaterialJob {
        let structure = match structure.contains('/') {
            true => Structure::flat(structure).unwrap(),
            false => Structure::builtin(structure).unwrap(),
        };
        MaterialJob { structure, opening: Opening::default(), whole: false }
    }

    #[test]
    fn what_ships_is_there_at_once() {
        let job = job("starling:green");
        let mut all = Vec::new();
        material(&job, &Unobserved, &mut |one| all.push(one)).unwrap();
        assert_eq!((all.len(), all[0].thinned), (1, None));
        let shipped = Catalog::default().shipped(&job.structure).unwrap().unwrap();
        assert_eq!(all[0].found.hash, shipped.hash);
        assert_eq!(expected_seconds(&job, 2).unwrap(), None);
    }

    #[test]
    fn what_is_not_there_is_made_coarsely_as_the_library_makes_it() {
        let job = job("air/keratin:320/melanin");
        let [coarse, whole] = expected_seconds(&job, 2).unwrap().unwrap();
        assert!(coarse < whole);
        let mut all = Vec::new();
        material(&job, &Unobserved, &mut |one| all.push(one)).unwrap();
        assert_eq!((all.len(), all[0].thinned), (1, Some(THIN)));
        assert_eq!(thinned(&all[0].found.material), Some(THIN));
        let plan =
            CampaignOptions { thin: Some(THIN), ..CampaignOptions::default() }.plan(job.structure).unwrap();
        let own = characterize(
            &plan,
            &FitOptions::default(),
            &Catalog::default(),
            &Execution::default(),
            &Unobserved,
        );
        assert_eq!(as_filed(&own.unwrap().material).unwrap().1, all[0].found.hash);
    }

    #[test]
    fn whoever_watches_stops_it() {
        let progress = Shared::default();
        progress.cancel();
        let refused =
            material(&job("air/keratin:320/melanin"), &progress, &mut |_| panic!("nothing is found"));
        assert!(refused.unwrap_err().is_interrupted());
    }
}
