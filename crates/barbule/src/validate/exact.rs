//! What full waves say of a wavelength, kept as it comes: a solution may take an hour.

use serde::{Deserialize, Serialize};

use super::{Compared, Comparing, FullWaves, Plan, unpolarized};
use crate::identity::Hasher;
use crate::io::Units;
use crate::math::simd::Width;
use crate::progress::{OnlyStops, Progress};
use crate::solve::cost::Cost;
use crate::solve::far_fields::{Effort, Prepared, Scattered, SectionSolver as _};
use crate::{Error, Result};

/// One incidence by full waves; powers are parts of the incident power.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Solved {
    /// Unpolarized radiant intensity over the upper half, 1/rad.
    pub(super) pattern: Vec<f64>,
    /// What leaves into the upper half.
    pub(super) reflected: f64,
    /// What absorbing regions take.
    pub(super) absorbed: f64,
    /// What leaves in all directions but for the light itself.
    pub(super) scattered: f64,
    /// What it took.
    pub(super) effort: Effort,
}

impl Solved {
    /// What is compared of a far field on four times `azimuths` of the circle.
    pub(super) fn new(full: &Scattered, azimuths: usize) -> Result<Self> {
        let Scattered { far, reflected: Some(reflected), exact: Some(exact), effort: Some(effort) } = full
        else {
            return Err(Error::machine(
                "the solver to compare with does not solve Maxwell's equations for a beam",
            ));
        };
        let circle = unpolarized(far);
        let power_um = far.light.scale().powi(-2);
        let mean = |both: [f64; 2]| 0.5 * (both[0] + both[1]);
        Ok(Self {
            pattern: (0..azimuths).map(|n| circle[azimuths + 2 * n + 1]).collect(),
            reflected: mean(*reflected),
            absorbed: mean(exact.absorbed_um) / power_um,
            scattered: mean(far.radiated),
            effort: *effort,
        })
    }
}

impl Plan {
    /// The wavelengths, by their places, that are not there from before.
    pub(super) fn missing(&self, units: Option<&Units>) -> impl Iterator<Item = usize> {
        let is_kept = move |nm: f64| units.is_some_and(|units| self.kept(units, nm).is_some());
        (0..self.wavelengths.len()).filter(move |w| !is_kept(self.wavelengths.nm()[*w]))
    }

    /// Full waves of all incidences of a wavelength, and whether they were not there from before.
    pub(super) fn solved(
        &self,
        exact: &dyn Prepared,
        wavelength_nm: f64,
        units: Option<&Units>,
        progress: &dyn Progress,
    ) -> Result<(Vec<Solved>, bool)> {
        if let Some(kept) = units.and_then(|units| self.kept(units, wavelength_nm)) {
            return Ok((kept, false));
        }
        let found = exact.scatter(&self.light_of(wavelength_nm), self.circle(), &OnlyStops(progress))?;
        let found = found.iter().map(|full| Solved::new(full, self.azimuths)).collect::<Result<Vec<_>>>()?;
        if let Some(units) = units {
            units.keep(&unit_name(wavelength_nm), &self.identity(wavelength_nm), &found)?;
        }
        Ok((found, true))
    }

    fn kept(&self, units: &Units, wavelength_nm: f64) -> Option<Vec<Solved>> {
        let found: Vec<Solved> = units.get(&unit_name(wavelength_nm), &self.identity(wavelength_nm))?;
        let is_whole = |one: &Solved| one.pattern.len() == self.azimuths;
        (found.len() == self.phi_i.len() && found.iter().all(is_whole)).then_some(found)
    }

    /// Of all that decides the bits of full waves at a wavelength: the closed section, the light, the program, and the processor, by its
    /// widest instructions, since dense algebra chooses among these itself. What they are compared with does not.
    fn identity(&self, wavelength_nm: f64) -> String {
        let mut hasher = Hasher::new("full waves");
        hasher
            .text("program", env!("CARGO_PKG_VERSION"))
            .text("simd", Width::best().name())
            .part("section", &self.closed.regions)
            .number("wavelength_nm", wavelength_nm)
            .number("theta_i", 0.0)
            .numbers("phi_i", &self.phi_i)
            .text("window", "beam")
            .count("azimuths", self.azimuths as u64)
            .number("elements", self.full.elements_per_wavelength);
        hasher.hex()
    }
}

impl FullWaves {
    /// The individual and the place of the wavelength of a unit.
    fn place(&self, unit: usize) -> (&Plan, usize) {
        let wavelengths = self.plans[0].wavelengths.len();
        (&self.plans[unit / wavelengths], unit % wavelengths)
    }
}

impl Comparing for FullWaves {
    fn what(&self) -> &'static str {
        if self.plans.len() > 1 { "individuals' wavelengths" } else { "wavelengths" }
    }

    fn units(&self) -> usize {
        self.plans.len() * self.plans[0].wavelengths.len()
    }

    fn missing(&self, some: &[usize], kept: &Units) -> Vec<usize> {
        let is_missing = |unit: &usize| {
            let (plan, wavelength) = self.place(*unit);
            plan.kept(kept, plan.wavelengths.nm()[wavelength]).is_none()
        };
        some.iter().copied().filter(is_missing).collect()
    }

    fn costs(&self, threads: usize, progress: &dyn Progress) -> Result<Vec<Cost>> {
        let each = self.plans.iter().map(|plan| plan.costs(threads, progress));
        Ok(each.collect::<Result<Vec<_>>>()?.concat())
    }

    fn keep(&self, unit: usize, kept: &Units, progress: &dyn Progress) -> Result<()> {
        let (plan, wavelength) = self.place(unit);
        let exact = plan.full.prepare(&plan.closed.regions)?;
        plan.solved(&*exact, plan.wavelengths.nm()[wavelength], Some(kept), progress).map(|_| ())
    }

    fn finish(&self, kept: Option<&Units>, progress: &dyn Progress) -> Result<Compared> {
        let found = self.run(kept, progress)?;
        Ok(Compared {
            name: self.plans[0].name.clone(),
            numbers: found.numbers(),
            figures: found.figures(),
            tables: vec![("numbers.csv", found.csv()), ("patterns.csv", found.patterns_csv())],
            table: found.table(),
        })
    }
}

fn unit_name(wavelength_nm: f64) -> String {
    format!("full-wave-{wavelength_nm}nm")
}
