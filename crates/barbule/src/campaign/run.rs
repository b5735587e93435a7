//! Running a campaign's units into a store, or straight into statistics.

use rayon::prelude::*;

use super::Campaign;
use crate::io::store::Store;
use crate::observer::Observer;
use crate::scattering::statistics::Statistics;
use crate::{Error, Result};

/// What a run of a store did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// Units computed now.
    pub computed: usize,
    /// Units that were there and whole.
    pub found: usize,
    /// Units that were there but damaged, and were computed again.
    pub repaired: usize,
}

/// Computes the units of shard `shard` of `shards` that the store lacks.
///
/// # Errors
/// A unit cannot be computed or written, or the observer cancelled; what was written stays and is found next time.
pub fn run(
    campaign: &Campaign,
    store: &Store,
    shard: usize,
    shards: usize,
    observer: &dyn Observer,
) -> Result<Outcome> {
    let units = store.shard(shard, shards);
    observer.begin("simulating", units.len() as u64);
    let whole: Vec<bool> = units.par_iter().map(|&(w, t)| store.is_whole(w, t)).collect();
    let missing: Vec<_> =
        units.iter().zip(whole).filter(|(_, whole)| !whole).map(|(unit, _)| *unit).collect();
    let found = units.len() - missing.len();
    let repaired = missing.iter().filter(|&&(w, t)| store.is_done(w, t)).count();
    observer.advance(found as u64);
    // Units of one wavelength share its tables, of which there is room for one wavelength at a time.
    for group in missing.chunk_by(|a, b| a.0 == b.0) {
        let wavelength = campaign.wavelength(group[0].0)?;
        group.par_iter().with_max_len(1).try_for_each(|&(index, theta)| {
            if observer.is_cancelled() {
                return Err(Error::interrupted());
            }
            store.write(index, theta, &campaign.unit(&wavelength, theta, store.keeps(index)))?;
            observer.advance(1);
            Ok(())
        })?;
    }
    Ok(Outcome { computed: missing.len(), found, repaired })
}

/// Computes all units in memory.
///
/// # Errors
/// A medium's table does not reach a wavelength, or the observer cancelled.
pub fn statistics(campaign: &Campaign, observer: &dyn Observer) -> Result<Statistics> {
    let axes = &campaign.parameters().axes;
    let thetas = axes.cos_theta.len();
    observer.begin("simulating", (axes.wavelengths_nm.len() * thetas) as u64);
    let mut statistics = Statistics::empty(axes.clone(), campaign.parameters().instances);
    for index in 0..axes.wavelengths_nm.len() {
        let wavelength = campaign.wavelength(index)?;
        let units = (0..thetas)
            .into_par_iter()
            .with_max_len(1)
            .map(|theta| {
                if observer.is_cancelled() {
                    return Err(Error::interrupted());
                }
                let unit = campaign.unit(&wavelength, theta, false);
                observer.advance(1);
                Ok(unit)
            })
            .collect::<Result<Vec<_>>>()?;
        units.into_iter().for_each(|unit| statistics.append(unit));
    }
    Ok(statistics)
}
