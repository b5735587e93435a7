//! Running a campaign's units into a store, or straight into statistics.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::{Campaign, Keep, WavelengthTables};
use crate::io::store::Store;
use crate::progress::Progress;
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
/// The store has other axes than the campaign, a unit cannot be computed or written, or the user cancelled; what was
/// written stays and is found next time.
pub fn run(
    campaign: &Campaign,
    store: &Store,
    shard: usize,
    shards: usize,
    progress: &dyn Progress,
) -> Result<Outcome> {
    store.check_belongs(&campaign.parameters().axes, campaign.parameters().realizations())?;
    store.prepare_writing()?;
    let units = store.shard(shard, shards);
    progress.begin("simulating", units.len() as u64);
    let whole: Vec<bool> = units.par_iter().map(|&(w, t)| store.is_whole(w, t)).collect();
    let missing: Vec<_> = units
        .iter()
        .zip(whole)
        .filter(|(_, whole)| !whole)
        .map(|(&(w, t), _)| (w, t, store.is_done(w, t)))
        .collect();
    let found = units.len() - missing.len();
    let repaired = missing.iter().filter(|(_, _, damaged)| *damaged).count();
    progress.advance(found as u64);
    let elsewhere = AtomicUsize::new(0);
    let compute = |tables: &WavelengthTables, index: usize, theta: usize, damaged: bool| {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        // Another process may have been here since.
        if !damaged && store.is_whole(index, theta) {
            elsewhere.fetch_add(1, Ordering::Relaxed);
        } else {
            let keep = if store.keeps(index) { Keep::Fields } else { Keep::Statistics };
            store.write(index, theta, &campaign.unit(tables, theta, keep, progress)?)?;
        }
        progress.advance(1);
        Ok(())
    };
    // Units of one wavelength share its tables, of which there is room for one wavelength at a time.
    let work = missing.chunk_by(|a, b| a.0 == b.0).try_for_each(|group| {
        let tables = campaign.tables(group[0].0, progress)?;
        group.chunks(campaign.units_at_once()).try_for_each(|units| {
            units
                .par_iter()
                .with_max_len(1)
                .try_for_each(|&(index, theta, damaged)| compute(&tables, index, theta, damaged))
        })
    });
    store.end_writing();
    work?;
    let elsewhere = elsewhere.into_inner();
    Ok(Outcome { computed: missing.len() - elsewhere, found: found + elsewhere, repaired })
}

/// Computes all units in memory.
///
/// # Errors
/// A medium's table does not reach a wavelength, or the user cancelled.
pub fn statistics(campaign: &Campaign, progress: &dyn Progress) -> Result<Statistics> {
    let axes = &campaign.parameters().axes;
    let thetas = axes.cos_theta().len();
    progress.begin("simulating", (axes.wavelengths_nm().len() * thetas) as u64);
    let mut statistics = Statistics::empty(axes.clone(), campaign.parameters().realizations());
    for index in 0..axes.wavelengths_nm().len() {
        let tables = campaign.tables(index, progress)?;
        let all: Vec<usize> = (0..thetas).collect();
        for some in all.chunks(campaign.units_at_once()) {
            let units = some
                .par_iter()
                .with_max_len(1)
                .map(|&theta| {
                    if progress.is_cancelled() {
                        return Err(Error::interrupted());
                    }
                    let unit = campaign.unit(&tables, theta, Keep::Statistics, progress)?;
                    progress.advance(1);
                    Ok(unit)
                })
                .collect::<Result<Vec<_>>>()?;
            units.into_iter().for_each(|unit| statistics.append(unit));
        }
    }
    Ok(statistics)
}
