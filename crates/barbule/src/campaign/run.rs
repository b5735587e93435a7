//! Running a campaign's units into a store, or straight into statistics.

use std::sync::atomic::{AtomicUsize, Ordering};

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
    let units: Vec<(usize, usize)> = store.units().skip(shard).step_by(shards.max(1)).collect();
    observer.begin("simulating", units.len() as u64);
    let (found, repaired) = (AtomicUsize::new(0), AtomicUsize::new(0));
    units.par_iter().with_max_len(1).try_for_each(|&(wavelength, theta)| {
        if observer.is_cancelled() {
            return Err(Error::interrupted());
        }
        if store.is_done(wavelength, theta) {
            if store.is_whole(wavelength, theta) {
                found.fetch_add(1, Ordering::Relaxed);
                observer.advance(1);
                return Ok(());
            }
            repaired.fetch_add(1, Ordering::Relaxed);
        }
        let unit = campaign.unit(wavelength, theta, store.keeps(wavelength))?;
        store.write(wavelength, theta, &unit)?;
        observer.advance(1);
        Ok(())
    })?;
    let (found, repaired) = (found.into_inner(), repaired.into_inner());
    Ok(Outcome { computed: units.len() - found, found, repaired })
}

/// Computes all units in memory.
///
/// # Errors
/// As [`run`].
pub fn statistics(campaign: &Campaign, observer: &dyn Observer) -> Result<Statistics> {
    let axes = &campaign.parameters().axes;
    let thetas = axes.cos_theta.len();
    let count = axes.wavelengths_nm.len() * thetas;
    observer.begin("simulating", count as u64);
    let units = (0..count)
        .into_par_iter()
        .with_max_len(1)
        .map(|unit| {
            if observer.is_cancelled() {
                return Err(Error::interrupted());
            }
            let result = campaign.unit(unit / thetas, unit % thetas, false)?;
            observer.advance(1);
            Ok(result)
        })
        .collect::<Result<Vec<_>>>()?;
    let mut statistics = Statistics::empty(axes.clone(), campaign.parameters().instances);
    units.into_iter().for_each(|unit| statistics.append(unit));
    Ok(statistics)
}
