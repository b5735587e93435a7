//! Where the results of a campaign's units go: a store's folder, memory, or what another program has.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{CampaignParameters, Keep};
use crate::io::store::Store;
use crate::scattering::statistics::{Statistics, Unit, UnitStatistics};
use crate::{Error, Result};

/// Takes the results of units from any thread, and knows what is there already.
pub trait Sink: Sync {
    /// Makes ready for units of a campaign.
    ///
    /// # Errors
    /// It is another campaign's, or takes nothing.
    fn begin(&self, _campaign: &CampaignParameters) -> Result<()> {
        Ok(())
    }

    /// What is there of a unit, which may be the work of another process.
    ///
    /// # Errors
    /// It cannot be asked; not where what is there is damaged.
    fn held(&self, unit: Unit) -> Result<Held>;

    /// What is to be kept of a unit.
    fn keep(&self, _unit: Unit) -> Keep {
        Keep::Statistics
    }

    /// Takes what a unit gave, in place of what may be there of it.
    ///
    /// # Errors
    /// The results are of other axes or none that a reflection has, or they cannot be kept.
    fn put(&self, unit: Unit, results: UnitStatistics) -> Result<()>;

    /// Ends what [`Self::begin`] began, also after an error.
    fn end(&self) {}
}

/// What is there of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Held {
    /// Nothing.
    Nothing,
    /// Something that is not whole, to be computed again.
    Damaged,
    /// All of it.
    Whole,
}

impl Sink for Store {
    fn begin(&self, campaign: &CampaignParameters) -> Result<()> {
        self.check_belongs(&campaign.axes, campaign.realizations())?;
        self.prepare_writing()
    }

    fn held(&self, Unit { wavelength, theta }: Unit) -> Result<Held> {
        Ok(if self.is_whole(wavelength, theta) {
            Held::Whole
        } else if self.is_done(wavelength, theta) {
            Held::Damaged
        } else {
            Held::Nothing
        })
    }

    fn keep(&self, unit: Unit) -> Keep {
        if self.keeps(unit.wavelength) { Keep::Fields } else { Keep::Statistics }
    }

    fn put(&self, Unit { wavelength, theta }: Unit, results: UnitStatistics) -> Result<()> {
        self.write(wavelength, theta, &results)
    }

    fn end(&self) {
        self.end_writing();
    }
}

/// Results in memory, in whatever order they come.
#[derive(Debug)]
pub struct Memory {
    campaign: CampaignParameters,
    units: Mutex<BTreeMap<Unit, UnitStatistics>>,
}

impl Memory {
    /// For units of a campaign.
    #[must_use]
    pub fn new(campaign: &CampaignParameters) -> Self {
        Self { campaign: campaign.clone(), units: Mutex::default() }
    }

    fn units(&self) -> MutexGuard<'_, BTreeMap<Unit, UnitStatistics>> {
        self.units.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The statistics of all units.
    ///
    /// # Errors
    /// Some are not there; the message says how many.
    pub fn statistics(self) -> Result<Statistics> {
        let mut units = self.units.into_inner().unwrap_or_else(PoisonError::into_inner);
        let axes = self.campaign.axes.clone();
        let missing = axes.units().filter(|unit| !units.contains_key(unit)).count();
        if missing > 0 {
            return Err(Error::input(format!("{missing} units of the campaign are missing; run them")));
        }
        let mut statistics =
            Statistics::empty(axes, self.campaign.realizations()).with_places(self.campaign.places);
        // Each is dropped as it is appended.
        while let Some((_, unit)) = units.pop_first() {
            statistics.append(unit);
        }
        Ok(statistics)
    }
}

impl Sink for Memory {
    fn held(&self, unit: Unit) -> Result<Held> {
        Ok(if self.units().contains_key(&unit) { Held::Whole } else { Held::Nothing })
    }

    fn put(&self, unit: Unit, results: UnitStatistics) -> Result<()> {
        let axes = &self.campaign.axes;
        let is_there = unit.wavelength < axes.wavelengths_nm().len() && unit.theta < axes.cos_theta().len();
        if !is_there || !results.is_of(axes, self.campaign.realizations()) {
            return Err(Error::input("these results are of other axes than the campaign's"));
        }
        self.units().insert(unit, results);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use serde::de::DeserializeOwned;
    use serde_json::{from_str, to_string};

    use super::*;
    use crate::campaign::{Campaign, Resources, run, statistics};
    use crate::progress::Unobserved;
    use crate::scattering::statistics::Axes;
    use crate::spectrum::Wavelengths;
    use crate::structure::Structure;

    fn campaign() -> Campaign {
        let wavelengths = Wavelengths::new([450.0, 600.0]).unwrap();
        let axes = Axes::new(&wavelengths, vec![0.5, 1.0], vec![0.7, 1.0]).unwrap();
        let parameters =
            CampaignParameters { axes, instances: 2, seed: 1, tilt: 0.02, mirror: false, places: 1 };
        let structure = Structure::flat("air/keratin:300/air").unwrap();
        Campaign::new(&structure, parameters, &Resources::default(), &Unobserved).unwrap()
    }

    /// What comes back from its text.
    fn sent<T: serde::Serialize + DeserializeOwned>(value: &T) -> T {
        from_str(&to_string(value).unwrap()).unwrap()
    }

    /// A worker elsewhere, whose results travel as text.
    struct Courier<'a>(&'a Memory);

    impl Sink for Courier<'_> {
        fn held(&self, unit: Unit) -> Result<Held> {
            self.0.held(unit)
        }
        fn keep(&self, _: Unit) -> Keep {
            Keep::Fields
        }
        fn put(&self, unit: Unit, results: UnitStatistics) -> Result<()> {
            assert!(!results.fields.is_empty() && sent(&results) == results);
            self.0.put(unit, sent(&results))
        }
    }

    #[test]
    fn units_sent_to_workers_give_what_one_run_gives() {
        let campaign = campaign();
        let parameters = campaign.parameters();
        assert_eq!(sent(parameters), *parameters);
        let all = statistics(&campaign, &Unobserved).unwrap();
        let memory = Memory::new(parameters);
        let axes = &parameters.axes;
        // The last shard first.
        for shard in (0..3).rev() {
            for unit in axes.shard(shard, 3) {
                let outcome = run(&campaign, &[sent(&unit)], &Courier(&memory), &Unobserved).unwrap();
                assert_eq!((outcome.computed, outcome.found), (1, 0));
            }
        }
        let again = run(&campaign, &axes.shard(0, 1), &memory, &Unobserved).unwrap();
        assert_eq!((again.computed, again.found), (0, 4));
        assert_eq!(memory.statistics().unwrap(), all);
        assert_eq!(sent(&all), all);
    }

    #[test]
    fn what_is_of_other_axes_is_refused() {
        let campaign = campaign();
        let memory = Memory::new(campaign.parameters());
        run(&campaign, &campaign.parameters().axes.shard(1, 4), &memory, &Unobserved).unwrap();
        let unit = Unit { wavelength: 0, theta: 1 };
        assert_eq!((memory.held(unit).unwrap(), memory.units().len()), (Held::Whole, 1));
        let results = memory.units()[&unit].clone();
        assert!(memory.put(Unit { wavelength: 2, theta: 0 }, results.clone()).is_err());
        let mut shorter = results;
        shorter.reflected.pop();
        assert!(memory.put(unit, shorter).is_err());
        let error = memory.statistics().unwrap_err();
        assert!(error.to_string().starts_with("3 units of the campaign are missing"), "{error}");
        let mut all = statistics(&campaign, &Unobserved).unwrap();
        all.v.pop();
        assert!(from_str::<Statistics>(&to_string(&all).unwrap()).is_err());
        let falling = r#"{"wavelengths_nm": [500], "cos_theta_i": [1.0, 0.5], "cos_phi_i": [1.0]}"#;
        assert!(from_str::<Axes>(falling).unwrap_err().to_string().contains("cosines must rise"));
    }
}
