//! Far fields of segments, kept as they come, and what all instances of one direction and wavelength give together.

use serde::{Deserialize, Serialize};

use super::{Found, Plan, USUAL_SIGMA};
use crate::clock;
use crate::identity::Hasher;
use crate::io::Units;
use crate::math::simd::Width;
use crate::progress::{OnlyStops, Progress, Shard};
use crate::solve::segment::{self, Hemisphere, SegmentAccuracy, SegmentLight};
use crate::structure::Segment;
use crate::{Error, Result};

/// What one wavelength and direction give.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Cell {
    pub(super) found: Found,
    /// Pictures of the mean and of one instance.
    pub(super) flat: [Vec<f64>; 2],
    pub(super) segments: [Vec<f64>; 2],
    /// Wall time of both simulations.
    pub(super) seconds: [f64; 2],
}

/// The far field of one segment.
pub(super) struct Scattered {
    /// Its directions; of a kept one without the amplitudes, of which nothing but the intensity is asked.
    pub(super) far: Hemisphere,
    pub(super) intensity: Vec<f64>,
    /// Wall time.
    pub(super) seconds: f64,
}

/// The same as it is kept.
#[derive(Serialize, Deserialize)]
struct KeptSegment {
    step: [f64; 2],
    reach: usize,
    omega_y: Vec<f64>,
    incident_um2: f64,
    intensity: Vec<f64>,
    seconds: f64,
}

impl From<&Scattered> for KeptSegment {
    fn from(Scattered { far, intensity, seconds }: &Scattered) -> Self {
        let Hemisphere { step, reach, omega_y, amplitudes: _, incident_um2 } = far;
        Self {
            step: *step,
            reach: *reach,
            omega_y: omega_y.clone(),
            incident_um2: *incident_um2,
            intensity: intensity.clone(),
            seconds: *seconds,
        }
    }
}

impl KeptSegment {
    /// `None` where the numbers of directions and intensities do not fit.
    fn scattered(self) -> Option<Scattered> {
        let Self { step, reach, omega_y, incident_um2, intensity, seconds } = self;
        let far = Hemisphere { step, reach, omega_y, amplitudes: Default::default(), incident_um2 };
        (intensity.len() == far.columns() * far.omega_y.len()).then_some(Scattered {
            far,
            intensity,
            seconds,
        })
    }
}

impl Plan {
    /// How many of the far fields of segments are there from before.
    #[must_use]
    pub fn done(&self, units: &Units) -> usize {
        let mut done = 0;
        for &direction in &self.directions {
            for &nm in self.wavelengths.nm() {
                if self.kept_cell(units, direction, nm, self.sigma()).is_some() {
                    done += self.instances;
                    continue;
                }
                let is_there =
                    |index: &usize| self.kept(units, &self.light(nm, direction, *index), *index).is_some();
                done += (0..self.instances).filter(is_there).count();
            }
        }
        done
    }

    /// Computes and keeps the far fields of a part of the segments, of about equal time: [`Self::run`] then finds them, whoever computed
    /// them. Those that are there from before take no time.
    ///
    /// # Errors
    /// As the solver; a unit cannot be written; or the user cancelled, what is kept till then stays.
    pub fn run_part(&self, shard: Shard, units: &Units, progress: &dyn Progress) -> Result<()> {
        let own = self.part_of(shard);
        progress.begin("segments", own.len() as u64);
        let mut segments: Vec<Option<Segment>> = vec![None; self.instances];
        for cell in own.chunk_by(|a, b| a[..2] == b[..2]) {
            let (direction, nm) = (self.directions[cell[0][0]], self.wavelengths.nm()[cell[0][1]]);
            let is_there = self.kept_cell(units, direction, nm, self.sigma()).is_some();
            for &[_, _, index] in cell {
                if progress.is_cancelled() {
                    return Err(Error::interrupted());
                }
                let light = self.light(nm, direction, index);
                if !is_there && self.kept(units, &light, index).is_none() {
                    let segment = match segments[index].take() {
                        Some(segment) => segment,
                        None => self.structure.segment(self.seed, index, self.length_um, self.roughness)?,
                    };
                    self.scattered(&segment, &light, index, Some(units), progress)?;
                    segments[index] = Some(segment);
                }
                progress.advance(1);
            }
        }
        Ok(())
    }

    /// How many far fields of a part are there from before, and how many it has.
    #[must_use]
    pub fn done_of_part(&self, shard: Shard, units: &Units) -> [usize; 2] {
        let own = self.part_of(shard);
        let mut done = 0;
        for cell in own.chunk_by(|a, b| a[..2] == b[..2]) {
            let (direction, nm) = (self.directions[cell[0][0]], self.wavelengths.nm()[cell[0][1]]);
            done += if self.kept_cell(units, direction, nm, self.sigma()).is_some() {
                cell.len()
            } else {
                let is_there =
                    |at: &&[usize; 3]| self.kept(units, &self.light(nm, direction, at[2]), at[2]).is_some();
                cell.iter().filter(is_there).count()
            };
        }
        [done, own.len()]
    }

    /// Directions, wavelengths and instances, by their places, of a part.
    fn part_of(&self, shard: Shard) -> Vec<[usize; 3]> {
        let mut all = Vec::with_capacity(self.count());
        let mut costs = Vec::with_capacity(self.count());
        for direction in 0..self.directions.len() {
            for (w, nm) in self.wavelengths.nm().iter().enumerate() {
                all.extend((0..self.instances).map(|index| [direction, w, index]));
                // As many cells are in a segment as squares of wavelengths.
                costs.resize(all.len(), nm.powi(-2));
            }
        }
        shard.by_cost(&costs).into_iter().map(|place| all[place]).collect()
    }

    /// σ of the BRDF that pictures are compared with.
    pub(super) fn sigma(&self) -> f64 {
        self.material.as_deref().map_or(USUAL_SIGMA, |material| material.sigma)
    }

    /// The far field of one segment, kept or new.
    pub(super) fn scattered(
        &self,
        segment: &Segment,
        light: &SegmentLight,
        index: usize,
        units: Option<&Units>,
        progress: &dyn Progress,
    ) -> Result<Scattered> {
        if let Some(kept) = units.and_then(|units| self.kept(units, light, index)) {
            return Ok(kept);
        }
        let begun = clock::system();
        let far = segment::far_field(segment, light, &SegmentAccuracy::default(), &OnlyStops(progress))?;
        let seconds = (clock::system() - begun).as_secs_f64();
        let found = Scattered { intensity: far.intensity(), far, seconds };
        if let Some(units) = units {
            units.keep(
                &segment_name(light, index),
                &self.identity(light, index),
                &KeptSegment::from(&found),
            )?;
        }
        Ok(found)
    }

    fn kept(&self, units: &Units, light: &SegmentLight, index: usize) -> Option<Scattered> {
        units.get::<KeptSegment>(&segment_name(light, index), &self.identity(light, index))?.scattered()
    }

    /// What all instances gave at one wavelength under light from one direction, where it was kept.
    pub(super) fn kept_cell(
        &self,
        units: &Units,
        direction: [f64; 2],
        wavelength_nm: f64,
        sigma: f64,
    ) -> Option<Cell> {
        let light = self.light(wavelength_nm, direction, 0);
        units.get(&cell_name(&light), &self.cell_identity(&light, sigma))
    }

    /// Keeps that in place of the single far fields.
    pub(super) fn keep_cell(
        &self,
        units: &Units,
        direction: [f64; 2],
        wavelength_nm: f64,
        sigma: f64,
        cell: &Cell,
    ) -> Result<()> {
        let light = self.light(wavelength_nm, direction, 0);
        units.keep(&cell_name(&light), &self.cell_identity(&light, sigma), cell)?;
        for index in 0..self.instances {
            let light = self.light(wavelength_nm, direction, index);
            units.forget(&segment_name(&light, index), &self.identity(&light, index));
        }
        Ok(())
    }

    /// Of all that decides the bits of a segment's far field: what it is made from, the light and the program.
    fn identity(&self, light: &SegmentLight, index: usize) -> String {
        let SegmentLight { wavelength_nm, theta_i, phi_i, window_um, turn } = *light;
        let mut hasher = self.hasher("segment");
        hasher
            .count("instance", index as u64)
            .number("wavelength_nm", wavelength_nm)
            .numbers("direction", &[theta_i, phi_i])
            .numbers("window_um", &window_um)
            .number("turn", turn);
        hasher.hex()
    }

    fn cell_identity(&self, light: &SegmentLight, sigma: f64) -> String {
        let SegmentLight { wavelength_nm, theta_i, phi_i, window_um, turn: _ } = *light;
        let mut hasher = self.hasher("segments");
        hasher
            .count("instances", self.instances as u64)
            .number("tilt", self.tilt)
            .number("sigma", sigma)
            .number("wavelength_nm", wavelength_nm)
            .numbers("direction", &[theta_i, phi_i])
            .numbers("window_um", &window_um);
        hasher.hex()
    }

    fn hasher(&self, kind: &str) -> Hasher {
        let mut hasher = Hasher::new(kind);
        hasher
            .text("program", env!("CARGO_PKG_VERSION"))
            .text("simd", Width::best().name())
            .text("structure", &self.structure.hash())
            .count("seed", self.seed)
            .number("length_um", self.length_um)
            .number("roughness_um", self.roughness.amplitude_um)
            .numbers("correlation_um", &self.roughness.correlation_um);
        hasher
    }
}

fn cell_name(light: &SegmentLight) -> String {
    let [theta, phi] = [light.theta_i, light.phi_i].map(|angle| angle.to_degrees().round());
    format!("segments-{theta}-{phi}-{}nm", light.wavelength_nm)
}

fn segment_name(light: &SegmentLight, index: usize) -> String {
    format!("{}-{index}", cell_name(light))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;
    use crate::progress::Unobserved;
    use crate::spectrum::Wavelengths;
    use crate::structure::{Roughness, Structure};

    /// Asks to stop after so many steps.
    struct StopsAfter(u64, AtomicU64);

    impl Progress for StopsAfter {
        fn begin(&self, _label: &str, _total: u64) {}
        fn advance(&self, steps: u64) {
            self.1.fetch_add(steps, Ordering::Relaxed);
        }
        fn is_cancelled(&self) -> bool {
            self.1.load(Ordering::Relaxed) >= self.0
        }
    }

    #[test]
    fn a_stopped_comparison_goes_on_to_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let units = Units::new(folder.path());
        let plan = Plan {
            structure: Structure::flat("air/keratin:300±5%/melanin:300/air").unwrap(),
            seed: 1,
            instances: 3,
            wavelengths: Wavelengths::new(vec![600.0, 650.0]).unwrap(),
            directions: vec![[0.0, 0.3]],
            length_um: 6.0,
            roughness: Roughness::default(),
            tilt: 0.03,
            material: None,
        };
        let stopped = plan.run(Some(&units), &StopsAfter(5, AtomicU64::new(0)));
        assert!(stopped.unwrap_err().is_interrupted());
        // One wavelength whole, and two of three segments of the other.
        assert_eq!(plan.done(&units), 5);
        let other = Plan { seed: 2, ..plan.clone() };
        assert_eq!(other.done(&units), 0);
        let (resumed, fresh) =
            (plan.run(Some(&units), &Unobserved).unwrap(), plan.run(None, &Unobserved).unwrap());
        assert_eq!(resumed.found, fresh.found);
        assert!(resumed.pictures[0].flat == fresh.pictures[0].flat);
        assert!(resumed.pictures[0].segments == fresh.pictures[0].segments);
        assert_eq!((plan.done(&units), std::fs::read_dir(folder.path()).unwrap().count()), (6, 2));
    }
}
