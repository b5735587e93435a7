//! A campaign in portions of a few seconds, for workers on several machines that fill one store.
//!
//! A portion is a run of neighbouring [units](Unit), so that whoever computes it makes the tables of few wavelengths. The
//! instances are prepared once, with the first portion that asks for them. What is in the store is not computed again, and
//! the bits of a unit are the same whichever portion it is in.

use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, Mutex, TryLockError};
use std::time::Duration;

use super::{Catalog, HaloPlan, Plan, check, finished, halo_units};
use crate::brdf::FeatherMaterial;
use crate::brdf::fit::FitOptions;
use crate::campaign::{Allowance, Campaign, Demand, Keep, Outcome, Resources, Results, run};
use crate::io::Units;
use crate::io::store::Store;
use crate::math::simd::Width;
use crate::progress::{Progress, Shard};
use crate::scattering::statistics::Unit;
use crate::solve::cost::PROGRAM;
use crate::{Error, Result};

/// Seconds that a portion may be asked to take: under these the overhead of a cluster shows, over these too much is lost
/// with a worker.
const SECONDS: std::ops::RangeInclusive<f64> = 0.01..=86_400.0;

/// How often whoever waits for instances that another thread prepares looks for them.
const LOOK: Duration = Duration::from_millis(20);

/// A plan, its store, and its units in portions.
pub struct Portions {
    plan: Plan,
    store: Store,
    catalog: Catalog,
    width: Width,
    keep: Keep,
    /// What a whole worker may take.
    allowed: Allowance,
    units: Vec<Unit>,
    portions: Vec<Range<usize>>,
    /// Foretold seconds of a unit on one thread.
    unit_seconds: f64,
    prepared: Mutex<Option<Arc<Campaign>>>,
    halo: HaloPlan,
    /// Where the units of the halo are kept.
    halo_units: Units,
}

impl Portions {
    /// Creates the store of a plan, or opens it to go on, and divides the units that it has; each portion takes about `seconds` on
    /// one thread or more, as far as that can be foretold, but for campaigns that are shorter. Nothing is simulated yet.
    ///
    /// Fields of all instances are kept at wavelengths `kept_nm`. The store is computed with the instructions `width`, and
    /// `allowed` is what preparing it may take in memory.
    ///
    /// # Errors
    /// `seconds` is not within 0.01 and 86,400; as [`Plan::store`] and [`Plan::unit_cost`].
    pub fn new(
        plan: Plan,
        path: &Path,
        kept_nm: &[f64],
        width: Width,
        seconds: f64,
        catalog: Catalog,
        allowed: Allowance,
    ) -> Result<Self> {
        if !SECONDS.contains(&seconds) {
            let (low, high) = (SECONDS.start(), SECONDS.end());
            return Err(Error::input(format!(
                "units of {seconds} s cannot be made; give from {low} to {high} s"
            )));
        }
        let keep = if kept_nm.is_empty() { Keep::Statistics } else { Keep::Fields };
        let unit_seconds = plan.unit_cost(keep, 1)?.seconds.unwrap_or_default();
        let store = plan.store(path, kept_nm, &Resources { width, units_at_once: 1 })?;
        let units: Vec<Unit> = store.axes().units().collect();
        let thetas = store.axes().cos_theta().len();
        let portions = divided(units.len() / thetas, thetas, unit_seconds, seconds);
        let (prepared, halo, halo_units) = (Mutex::default(), HaloPlan::new(&plan, width), halo_units(path));
        Ok(Self {
            plan,
            store,
            catalog,
            width,
            keep,
            allowed,
            units,
            portions,
            unit_seconds,
            prepared,
            halo,
            halo_units,
        })
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.portions.len()
    }

    /// The units of a portion.
    ///
    /// # Errors
    /// There is no such portion.
    pub fn units(&self, portion: usize) -> Result<&[Unit]> {
        let range = self.portions.get(portion).cloned();
        range.and_then(|range| self.units.get(range)).ok_or_else(|| {
            Error::input(format!("there is no portion {portion} of {} (they count from 0)", self.count()))
        })
    }

    /// Seconds that a portion takes on one thread, foretold within a half, beside what preparing the instances takes once.
    ///
    /// # Errors
    /// There is no such portion.
    pub fn seconds(&self, portion: usize) -> Result<f64> {
        Ok(self.unit_seconds * self.units(portion)?.len() as f64)
    }

    /// Memory that a worker takes which computes one portion at a time on the threads of the present pool, bytes, foretold from the first
    /// instances; seconds of work.
    ///
    /// # Errors
    /// As [`Demand::predict`].
    pub fn bytes(&self, progress: &dyn Progress) -> Result<u64> {
        let Plan { structure, parameters, .. } = &self.plan;
        let demand =
            Demand::predict(structure, parameters, self.keep, Results::Stored, Allowance::UNKNOWN, progress)?;
        Ok(demand.bytes(1))
    }

    /// The store.
    #[must_use]
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// Whether all units of a portion are in the store and their checksums hold; reads them.
    ///
    /// # Errors
    /// There is no such portion.
    pub fn is_whole(&self, portion: usize) -> Result<bool> {
        Ok(self.units(portion)?.iter().all(|unit| self.store.is_whole(unit.wavelength, unit.theta)))
    }

    /// The files of each unit of a portion, relative to the store, in the order of writing.
    ///
    /// # Errors
    /// There is no such portion.
    pub fn files(&self, portion: usize) -> Result<Vec<Vec<String>>> {
        Ok(self.units(portion)?.iter().map(|unit| self.store.unit_files(*unit)).collect())
    }

    /// Units of the halo of the campaign's material.
    #[must_use]
    pub fn halo_count(&self) -> usize {
        self.halo.units()
    }

    /// Whether a unit of the halo is beside the store.
    ///
    /// # Errors
    /// There is no such unit.
    pub fn halo_is_done(&self, unit: usize) -> Result<bool> {
        self.check_halo(unit)?;
        Ok(self.halo.is_done(unit, &self.halo_units))
    }

    /// Memory that a worker takes for a unit of the halo on the threads of the present pool, bytes.
    ///
    /// # Errors
    /// As [`HaloPlan::unit_cost`].
    pub fn halo_bytes(&self) -> Result<u64> {
        self.halo.unit_cost(rayon::current_num_threads()).map(|cost| PROGRAM + cost.bytes)
    }

    /// Simulates a unit of the halo and keeps it beside the store, unless it is there. One that was computed with other instructions than the
    /// store's is not there.
    ///
    /// # Errors
    /// There is no such unit; as [`HaloPlan::run_unit`].
    pub fn run_halo(&self, unit: usize, progress: &dyn Progress) -> Result<()> {
        self.check_halo(unit)?;
        self.halo.run_unit(unit, &self.halo_units, progress)
    }

    fn check_halo(&self, unit: usize) -> Result<()> {
        let count = self.halo.units();
        let refusal =
            || Error::input(format!("there is no unit {unit} of {count} of the halo (they count from 0)"));
        (unit < count).then_some(()).ok_or_else(refusal)
    }

    /// Refuses, before any work, what no material can be fitted with.
    ///
    /// # Errors
    /// As [`check`].
    pub fn check(&self, options: &FitOptions) -> Result<()> {
        check(&self.plan, options)
    }

    /// Fits the material of the finished store, as [`characterize`](super::characterize()) does; what is not there of its halo is simulated.
    ///
    /// # Errors
    /// Units are missing or damaged; as [`check`].
    pub fn material(&self, options: &FitOptions, progress: &dyn Progress) -> Result<FeatherMaterial> {
        self.check(options)?;
        let statistics = self.store.statistics()?;
        finished(&self.plan, &statistics, options, self.width, Some(&self.halo_units), progress)
            .map(|(material, _)| material)
    }

    /// Computes what the store lacks of a portion, as every run of the campaign does. Several threads may compute different
    /// portions; the first that finds the instances unprepared prepares them, and the others wait.
    ///
    /// # Errors
    /// There is no such portion; the memory that is allowed does not suffice; as [`Plan::campaign`] and [`run`].
    pub fn run(&self, portion: usize, progress: &dyn Progress) -> Result<Outcome> {
        let units = self.units(portion)?;
        if self.is_whole(portion)? {
            return Ok(Outcome { computed: 0, found: units.len(), repaired: 0 });
        }
        let campaign = self.prepared(progress)?;
        run(&campaign, units, &self.store, progress)
    }

    /// Prepares the instances on the threads of the present pool, which may have more than a portion is given later; nothing where they are
    /// prepared.
    ///
    /// # Errors
    /// The memory that is allowed does not suffice; as [`Plan::campaign`].
    pub fn prepare(&self, progress: &dyn Progress) -> Result<()> {
        self.prepared(progress).map(|_| ())
    }

    /// Ends the announcement that this process computes; until then, or until this is dropped, others see it in the store from the first
    /// portion on, as of one that may compute any unit.
    pub fn leave(&self) {
        self.store.leave();
    }

    /// The instances, which are prepared if they are not yet.
    fn prepared(&self, progress: &dyn Progress) -> Result<Arc<Campaign>> {
        loop {
            let mut prepared = match self.prepared.try_lock() {
                Ok(prepared) => prepared,
                // Whoever panicked left none.
                Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
                Err(TryLockError::WouldBlock) => {
                    if progress.is_cancelled() {
                        return Err(Error::interrupted());
                    }
                    std::thread::sleep(LOOK);
                    continue;
                }
            };
            if let Some(campaign) = &*prepared {
                return Ok(campaign.clone());
            }
            let Plan { structure, parameters, .. } = &self.plan;
            Demand::units_allowed(structure, parameters, self.keep, Results::Stored, self.allowed)?;
            let resources = Resources { width: self.width, units_at_once: 1 };
            self.store.enter(Shard::WHOLE);
            let campaign = self.plan.campaign(&resources, &self.catalog, progress);
            let campaign = Arc::new(campaign.inspect_err(|_| self.store.leave())?);
            *prepared = Some(campaign.clone());
            return Ok(campaign);
        }
    }
}

impl Drop for Portions {
    fn drop(&mut self) {
        self.leave();
    }
}

/// Divides the units of so many wavelengths, each with `thetas` of them, into portions that take `seconds` or more: whole wavelengths,
/// as their tables are shared, or equal parts of one.
fn divided(wavelengths: usize, thetas: usize, unit_seconds: f64, seconds: f64) -> Vec<Range<usize>> {
    // An unknown duration counts as a short one.
    let unit_seconds = if unit_seconds > 0.0 { unit_seconds } else { f64::MIN_POSITIVE };
    let wavelength_seconds = unit_seconds * thetas as f64;
    let bound = |k: usize, of: usize, count: usize| of * k / count;
    if wavelength_seconds < 2.0 * seconds {
        let together = (seconds / wavelength_seconds).ceil().clamp(1.0, wavelengths.max(1) as f64) as usize;
        let count = (wavelengths / together).max(1);
        let from = |k: usize| bound(k, wavelengths, count) * thetas;
        return (0..count).map(|k| from(k)..from(k + 1)).collect();
    }
    let parts = (thetas / (seconds / unit_seconds).ceil() as usize).max(1);
    (0..wavelengths)
        .flat_map(|wavelength| {
            let from = move |k: usize| wavelength * thetas + bound(k, thetas, parts);
            (0..parts).map(move |k| from(k)..from(k + 1))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::characterize::{CampaignOptions, Execution, characterize};
    use crate::progress::Unobserved;
    use crate::structure::Structure;

    #[test]
    fn portions_hold_every_unit_once_and_last_as_long_as_asked() {
        for (wavelengths, thetas) in [(1, 1), (1, 20), (13, 5), (51, 20), (7, 3)] {
            for unit_seconds in [0.0, 1e-4, 0.03, 0.11, 0.9, 1.0, 2.5, 40.0] {
                for seconds in [0.5, 4.0] {
                    let portions = divided(wavelengths, thetas, unit_seconds, seconds);
                    let all: Vec<usize> = portions.iter().cloned().flatten().collect();
                    assert_eq!(all, (0..wavelengths * thetas).collect::<Vec<_>>());
                    let shortest = portions.iter().map(Range::len).min().unwrap() as f64 * unit_seconds;
                    let is_long = shortest >= 0.999 * seconds || portions.len() == 1;
                    assert!(is_long, "{wavelengths} {thetas} {unit_seconds} {seconds}: {shortest}");
                    // Nor much longer, where units and wavelengths allow.
                    let longest = portions.iter().map(Range::len).max().unwrap() as f64 * unit_seconds;
                    let coarse = (unit_seconds * thetas as f64).max(seconds);
                    assert!(longest <= 4.0 * coarse || portions.len() == 1, "{longest} {coarse}");
                }
            }
        }
    }

    /// Every file of a store.
    fn files(folder: &Path) -> BTreeMap<std::path::PathBuf, Vec<u8>> {
        let mut all = BTreeMap::new();
        let mut folders = vec![folder.to_owned()];
        while let Some(at) = folders.pop() {
            for entry in std::fs::read_dir(at).unwrap().map(|entry| entry.unwrap().path()) {
                if entry.is_dir() {
                    folders.push(entry);
                } else {
                    let key = entry.strip_prefix(folder).unwrap().to_owned();
                    all.insert(key, std::fs::read(entry).unwrap());
                }
            }
        }
        all
    }

    fn plan() -> Plan {
        let options = CampaignOptions { thin: Some(10), instances: Some(6), ..CampaignOptions::default() };
        options.plan(Structure::flat("air/keratin:300±5%/air").unwrap()).unwrap()
    }

    fn portions(path: &Path, seconds: f64) -> Result<Portions> {
        let (width, allowed) = (Width::best(), Allowance::UNKNOWN);
        Portions::new(plan(), path, &[380.0], width, seconds, Catalog::default(), allowed)
    }

    #[test]
    fn portions_in_any_order_and_by_several_workers_give_what_one_run_gives() {
        let folder = tempfile::tempdir().unwrap();
        let [one, several] = ["one.zarr", "several.zarr"].map(|name| folder.path().join(name));
        let whole = portions(&one, 86_400.0).unwrap();
        assert_eq!(whole.count(), 1);
        whole.run(0, &Unobserved).unwrap();
        // As short as they can be: units.
        let workers = [(); 2].map(|()| portions(&several, 0.01).unwrap());
        let count = workers[0].count();
        assert!(count > 1);
        let mut written = Vec::new();
        std::thread::scope(|scope| {
            for (number, worker) in workers.iter().enumerate() {
                scope.spawn(move || {
                    for portion in (0..count).rev().filter(|portion| portion % 2 == number) {
                        worker.run(portion, &Unobserved).unwrap();
                    }
                });
            }
        });
        for portion in 0..count {
            assert!(workers[0].is_whole(portion).unwrap());
            let again = workers[1].run(portion, &Unobserved).unwrap();
            assert_eq!((again.computed, again.found), (0, workers[0].units(portion).unwrap().len()));
            written.extend(workers[0].files(portion).unwrap().concat());
        }
        whole.leave();
        workers.iter().for_each(Portions::leave);
        let there = files(&several);
        assert_eq!(files(&one), there);
        written.extend(workers[0].store().own_files());
        let mut named: Vec<String> =
            there.keys().map(|key| key.to_string_lossy().replace('\\', "/")).collect();
        named.sort();
        assert_eq!(written.last().map(String::as_str), Some("zarr.json"));
        written.sort();
        assert_eq!(written, named);
    }

    #[test]
    fn workers_are_seen_in_the_store_while_they_compute() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.zarr");
        let workers = [(); 2].map(|()| portions(&path, 0.01).unwrap());
        let runs = || Store::open(&path).unwrap().survey().runs().to_vec();
        assert_eq!(runs(), []);
        for worker in &workers {
            worker.prepare(&Unobserved).unwrap();
            worker.run(0, &Unobserved).unwrap();
        }
        let seen = runs();
        assert_eq!(seen.len(), 2);
        for run in seen {
            assert!(run.is_alive && run.process == std::process::id() && run.shard == Shard::WHOLE);
        }
        workers[0].leave();
        assert_eq!(runs().len(), 1);
        // What is prepared stays so, and is not announced again.
        workers[0].run(1, &Unobserved).unwrap();
        assert_eq!(runs().len(), 1);
        drop(workers);
        assert_eq!(runs(), []);
        assert!(!path.join(".aside").exists());
    }

    #[test]
    fn halos_of_workers_are_those_of_one_run() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.zarr");
        let options = CampaignOptions {
            wavelengths_nm: vec![600.0],
            directions: [2, 2],
            instances: Some(2),
            ..CampaignOptions::default()
        };
        let plan = options.plan(Structure::flat("air/keratin:300±5%/melanin:300/air").unwrap()).unwrap();
        let fit = FitOptions { halo: true, ..FitOptions::default() };
        let (width, catalog) = (Width::best(), Catalog::default());
        let here = Portions::new(plan.clone(), &path, &[], width, 1.0, catalog.clone(), Allowance::UNKNOWN);
        let here = here.unwrap();
        (0..here.count()).for_each(|portion| _ = here.run(portion, &Unobserved).unwrap());
        for unit in (0..here.halo_count()).rev() {
            assert!(!here.halo_is_done(unit).unwrap());
            here.run_halo(unit, &Unobserved).unwrap();
            assert!(here.halo_is_done(unit).unwrap());
        }
        assert!(here.run_halo(here.halo_count(), &Unobserved).unwrap_err().is_input());
        assert!(here.halo_bytes().unwrap() > PROGRAM);
        let alone = characterize(&plan, &fit, &catalog, &Execution::default(), &Unobserved).unwrap();
        assert_eq!(here.material(&fit, &Unobserved).unwrap(), alone.material);
        assert!(here.check(&FitOptions { sigma: 7.0, ..fit }).is_err());
    }

    #[test]
    fn what_cannot_be_a_portion_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.zarr");
        for bad in [0.0, -1.0, f64::NAN, 1e9] {
            let message = portions(&path, bad).err().unwrap().to_string();
            assert!(message.contains("give from 0.01 to 86400 s"), "{message}");
        }
        let few = portions(&path, 10.0).unwrap();
        let message = few.run(few.count(), &Unobserved).unwrap_err().to_string();
        assert!(message.contains("there is no portion"), "{message}");
    }

    #[test]
    fn a_worker_without_the_memory_says_so_before_it_begins() {
        let folder = tempfile::tempdir().unwrap();
        let allowed = Allowance { bytes: 1_000_000, asked: true };
        let path = folder.path().join("s.zarr");
        let (width, catalog) = (Width::best(), Catalog::default());
        let poor = Portions::new(plan(), &path, &[], width, 10.0, catalog, allowed).unwrap();
        let message = poor.run(0, &Unobserved).unwrap_err().to_string();
        assert!(message.contains("but 1 MB are allowed"), "{message}");
        assert!(poor.bytes(&Unobserved).unwrap() > 1_000_000);
    }
}
