//! Running a campaign's units into whatever takes their results.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::sink::{Held, Memory, Sink};
use super::{Campaign, WavelengthTables};
use crate::progress::Progress;
use crate::scattering::statistics::{Statistics, Unit};
use crate::{Error, Result};

/// What a run did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// Units computed now.
    pub computed: usize,
    /// Units that were there and whole.
    pub found: usize,
    /// Units that were there but damaged, and were computed again.
    pub repaired: usize,
}

/// Computes those of some units (all, or a [shard](crate::scattering::statistics::Axes::shard)) that the sink lacks; those of
/// one wavelength share its tables and so should be neighbours.
///
/// # Errors
/// The sink is another campaign's, a unit cannot be computed or taken, or the user cancelled; what the sink took stays and is
/// found next time.
pub fn run(campaign: &Campaign, units: &[Unit], sink: &dyn Sink, progress: &dyn Progress) -> Result<Outcome> {
    sink.begin(campaign.parameters())?;
    let outcome = compute(campaign, units, sink, progress);
    sink.end();
    outcome
}

fn compute(campaign: &Campaign, units: &[Unit], sink: &dyn Sink, progress: &dyn Progress) -> Result<Outcome> {
    progress.begin("simulating", units.len() as u64);
    let held = units.par_iter().map(|unit| sink.held(*unit)).collect::<Result<Vec<_>>>()?;
    let missing: Vec<(Unit, Held)> =
        units.iter().copied().zip(held).filter(|(_, held)| *held != Held::Whole).collect();
    let found = units.len() - missing.len();
    let repaired = missing.iter().filter(|(_, held)| *held == Held::Damaged).count();
    progress.advance(found as u64);
    let elsewhere = AtomicUsize::new(0);
    let one = |tables: &WavelengthTables, unit: Unit, before: Held| {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        // Another process may have been here since.
        if before == Held::Nothing && sink.held(unit)? == Held::Whole {
            elsewhere.fetch_add(1, Ordering::Relaxed);
        } else {
            sink.put(unit, campaign.unit(tables, unit.theta, sink.keep(unit), progress)?)?;
        }
        progress.advance(1);
        Ok(())
    };
    // Units of one wavelength share its tables, of which there is room for one wavelength at a time.
    missing.chunk_by(|(a, _), (b, _)| a.wavelength == b.wavelength).try_for_each(|group| {
        let tables = campaign.tables(group[0].0.wavelength, progress)?;
        group.chunks(campaign.units_at_once()).try_for_each(|units| {
            units.par_iter().with_max_len(1).try_for_each(|&(unit, before)| one(&tables, unit, before))
        })
    })?;
    let elsewhere = elsewhere.into_inner();
    Ok(Outcome { computed: missing.len() - elsewhere, found: found + elsewhere, repaired })
}

/// Computes all units in memory.
///
/// # Errors
/// A medium's table does not reach a wavelength, or the user cancelled.
pub fn statistics(campaign: &Campaign, progress: &dyn Progress) -> Result<Statistics> {
    let memory = Memory::new(campaign.parameters());
    run(campaign, &campaign.parameters().axes.shard(0, 1), &memory, progress)?;
    memory.statistics()
}
