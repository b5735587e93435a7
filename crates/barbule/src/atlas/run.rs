//! Computing the units that a store lacks.

use rayon::prelude::*;

use super::Atlas;
use super::cell::Cell;
use crate::characterize::Catalog;
use crate::clock;
use crate::io::sweep::{SweepStore, SweepUnit, SweepValues};
use crate::progress::{OnlyStops, Progress};
use crate::{Error, Result};

/// What a run did.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outcome {
    /// Units computed now.
    pub computed: usize,
    /// Units that were there and whole.
    pub found: usize,
    /// Units that were there but damaged, and were computed again.
    pub repaired: usize,
    /// Numbers of the units computed now and the seconds that each took, in the order of units.
    pub seconds: Vec<(usize, f64)>,
}

/// Computes those of some units that the store lacks; cells of a unit side by side.
///
/// # Errors
/// A cell cannot be computed, the store cannot be written, or the user cancelled; what was written stays and is found next time.
pub fn run(atlas: &Atlas, store: &SweepStore, units: &[usize], progress: &dyn Progress) -> Result<Outcome> {
    store.prepare_writing()?;
    let outcome = compute(atlas, store, units, progress);
    store.end_writing();
    outcome
}

fn compute(atlas: &Atlas, store: &SweepStore, units: &[usize], progress: &dyn Progress) -> Result<Outcome> {
    let cells_of = |unit: usize| store.layout().cells_of(unit).into_iter().flatten().collect::<Vec<_>>();
    let all: usize = units.iter().map(|unit| cells_of(*unit).len()).sum();
    progress.begin("simulating the atlas", all as u64);
    let held: Vec<(bool, bool)> =
        units.par_iter().map(|unit| (store.is_done(*unit), store.is_whole(*unit))).collect();
    let mut outcome = Outcome::default();
    let catalog = Catalog::default();
    for (&unit, (was_there, is_whole)) in units.iter().zip(held) {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        let cells = cells_of(unit);
        // Another process may have been here since.
        if is_whole || (!was_there && store.is_whole(unit)) {
            outcome.found += 1;
            progress.advance(cells.len() as u64);
            continue;
        }
        let began = clock::system();
        let found = self::unit(atlas, &cells, &catalog, progress)?;
        let seconds = (clock::system() - began).as_secs_f64();
        store.write(unit, &found, seconds)?;
        outcome.computed += 1;
        outcome.repaired += usize::from(was_there);
        outcome.seconds.push((unit, seconds));
    }
    Ok(outcome)
}

/// The values of a unit's cells.
fn unit(atlas: &Atlas, cells: &[usize], catalog: &Catalog, progress: &dyn Progress) -> Result<SweepUnit> {
    let quiet = OnlyStops(progress);
    let one = |&cell: &usize| {
        let found = atlas.cell(cell, catalog, &quiet)?;
        progress.advance(1);
        Ok((cell, found))
    };
    let found: Vec<(usize, Cell)> = cells.par_iter().with_max_len(1).map(one).collect::<Result<_>>()?;
    let mut values: Vec<SweepValues> =
        atlas
            .layout()
            .arrays
            .iter()
            .map(|array| {
                if array.is_bytes { SweepValues::Bytes(Vec::new()) } else { SweepValues::Floats(Vec::new()) }
            })
            .collect();
    let mut materials = Vec::new();
    for (cell, Cell { values: own, material }) in found {
        for (all, own) in values.iter_mut().zip(own) {
            match (all, own) {
                (SweepValues::Floats(all), SweepValues::Floats(own)) => all.extend(own),
                (SweepValues::Bytes(all), SweepValues::Bytes(own)) => all.extend(own),
                _ => {
                    return Err(Error::machine(format!(
                        "cell {cell} has values of another kind than the store"
                    )));
                }
            }
        }
        materials.extend(material.map(|bytes| (cell, bytes)));
    }
    Ok(SweepUnit { values, materials })
}
