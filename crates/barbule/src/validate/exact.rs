//! What full waves say of a wavelength, kept as it comes: a solution may take an hour.

use serde::{Deserialize, Serialize};

use super::{Plan, unpolarized};
use crate::identity::Hasher;
use crate::io::Units;
use crate::math::simd::Width;
use crate::progress::{OnlyStops, Progress, Shard};
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
    /// How many of the wavelengths are there from before.
    #[must_use]
    pub fn done(&self, units: &Units) -> usize {
        self.wavelengths.len() - self.missing(Some(units)).count()
    }

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

    /// Of all that decides the bits of full waves at a wavelength: the closed section, the light and the program. What they are
    /// compared with does not.
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

/// Solves and keeps full waves of one part of the wavelengths of several individuals, of about equal time: [`run_all`](super::run_all)
/// then finds them, whoever solved them. Those that are there from before take no time.
///
/// # Errors
/// As the solver; a unit cannot be written; or the user cancelled, what is kept till then stays.
pub fn solve_part(plans: &[Plan], shard: Shard, units: &Units, progress: &dyn Progress) -> Result<()> {
    let own = part_of(plans, shard)?;
    progress.begin("full waves", own.len() as u64);
    for alike in own.chunk_by(|a, b| a.0 == b.0) {
        let plan = &plans[alike[0].0];
        let exact = plan.full.prepare(&plan.closed.regions)?;
        for &(_, wavelength) in alike {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            plan.solved(&*exact, plan.wavelengths.nm()[wavelength], Some(units), progress)?;
            progress.advance(1);
        }
    }
    Ok(())
}

/// How many wavelengths of a part are there from before, and how many it has.
///
/// # Errors
/// A section does not suit the solver.
pub fn done_of_part(plans: &[Plan], shard: Shard, units: &Units) -> Result<[usize; 2]> {
    let own = part_of(plans, shard)?;
    let is_there =
        |(plan, w): &&(usize, usize)| plans[*plan].kept(units, plans[*plan].wavelengths.nm()[*w]).is_some();
    Ok([own.iter().filter(is_there).count(), own.len()])
}

/// The plans and wavelengths, by their places, of a part.
fn part_of(plans: &[Plan], shard: Shard) -> Result<Vec<(usize, usize)>> {
    let mut all = Vec::new();
    let mut costs = Vec::new();
    for (place, plan) in plans.iter().enumerate() {
        all.extend((0..plan.wavelengths.len()).map(|wavelength| (place, wavelength)));
        // On one thread: parts are the same wherever they are computed.
        costs.extend(plan.costs(1)?.into_iter().map(|cost| cost.seconds.unwrap_or_default()));
    }
    Ok(shard.by_cost(&costs).into_iter().map(|place| all[place]).collect())
}

fn unit_name(wavelength_nm: f64) -> String {
    format!("full-wave-{wavelength_nm}nm")
}
